"""Suites as tests of pytest: `pytest suites/zebra.suite`, an item for each trial and block.

Declared controllers run as for the command: once they are allowed, or named in SCENARIO_RUNNER_ALLOW_RUN.
"""

import json
import subprocess

import pytest

from ._results import runner

LIST_LAYOUT = 1


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".suite":
        return SuiteFile.from_parent(parent, path=file_path)
    return None


class SuiteFile(pytest.File):
    def collect(self):
        listed = _runner(self.path, "--list", "--format=json")
        if listed.returncode != 0:
            raise self.CollectError(listed.stdout + listed.stderr)
        units = json.loads(listed.stdout)
        if units.get("layout") != LIST_LAYOUT:
            raise self.CollectError(f"the runner lists in layout {units.get('layout')}; this plugin reads {LIST_LAYOUT}")
        for unit in units["units"]:
            # `-k` selects by the tags of its scenario, too.
            item = Unit.from_parent(self, name=unit["key"])
            item.extra_keyword_matches.update(unit.get("tags", ()))
            yield item


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
