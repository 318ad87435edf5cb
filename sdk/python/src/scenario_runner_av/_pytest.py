"""Suites as tests of pytest: `pytest suites/zebra.suite`, an item for each trial and block.

Declared controllers run as for the command: once they are allowed, or named in SCENARIO_RUNNER_ALLOW_RUN.
"""

import subprocess

import pytest

from ._results import runner


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".suite":
        return SuiteFile.from_parent(parent, path=file_path)
    return None


class SuiteFile(pytest.File):
    def collect(self):
        listed = _runner(self.path, "--list")
        if listed.returncode != 0:
            raise self.CollectError(listed.stdout + listed.stderr)
        for key in listed.stdout.splitlines():
            yield Unit.from_parent(self, name=key)


class Unit(pytest.Item):
    def runtest(self):
        ran = _runner(self.path, self.name, "--exact", "--no-progress")
        if ran.returncode != 0:
            raise Failed(ran.returncode, ran.stdout + ran.stderr)

    def repr_failure(self, excinfo):
        if isinstance(excinfo.value, Failed):
            code, said = excinfo.value.args
            return f"{said.rstrip()}\nexit code {code}"
        return super().repr_failure(excinfo)

    def reportinfo(self):
        return self.path, None, self.name


class Failed(Exception):
    """Exit code and texts of a run."""


def _runner(*words):
    # Where pytest was started, as for the command.
    return subprocess.run(
        [runner(), *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace"
    )
