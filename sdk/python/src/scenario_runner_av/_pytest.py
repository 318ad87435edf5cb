"""Suites as tests of pytest: `pytest suites/zebra.suite`, an item for each trial, block, gate and rating.

A suite runs once, and each item reads its own verdict from the results. Where `-k` selects a part of it, the items of that part run one by
one; a gate or rating that is selected needs the whole suite.

Declared controllers run as for the command: once they are allowed, or named in SCENARIO_RUNNER_ALLOW_RUN.
"""

import json
import os
import subprocess
import tempfile

import pytest

from ._results import LAYOUT, runner

LIST_LAYOUT = 1
LISTED_VERSION = 1
OVER_ALL = ("gate", "rating")


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".suite":
        return SuiteFile.from_parent(parent, path=file_path)
    return None


class SuiteFile(pytest.File):
    def collect(self):
        units = self._read(LIST_LAYOUT, "layout", self.path, "--list", "--format=json")["units"]
        listed = self._read(LISTED_VERSION, "version", "list", self.path, "--format=json")["listed"]
        listed = [one for one in listed if one["kind"] in OVER_ALL]
        self.whole, self.has_failed, self.count = None, False, len(units) + len(listed)
        for unit in units:
            yield self._item(unit["key"], unit["kind"], unit.get("tags", ()))
        for one in listed:
            yield self._item(one["name"], one["kind"], one.get("tags", ()))

    def _item(self, key, kind, tags):
        # `-k` selects by the tags of its scenario, too.
        item = Unit.from_parent(self, name=key)
        item.kind = kind
        item.extra_keyword_matches.update(tags)
        return item

    def _read(self, version, member, *words):
        done = _runner(*words)
        if done.returncode != 0:
            raise self.CollectError(done.stdout + done.stderr)
        read = json.loads(done.stdout)
        if read.get(member) != version:
            raise self.CollectError(f"the runner lists in {member} {read.get(member)}; this plugin reads {version}")
        return read

    def ran(self, item):
        """The run that an item reads its verdict from: that of the whole suite, or its own where only a part is selected."""
        selected = [one for one in item.session.items if one.parent is self]
        is_last = selected[-1] is item
        if len(selected) < self.count and not any(one.kind in OVER_ALL for one in selected):
            return Ran(self.path, item.name), is_last
        if self.whole is None:
            self.whole = Ran(self.path, None)
        return self.whole, is_last


class Unit(pytest.Item):
    def runtest(self):
        ran, is_last = self.parent.ran(self)
        verdict = ran.verdict(self.name)
        if verdict == "passed" and not (is_last and ran.is_red_alone(self.parent)):
            return
        if verdict in ("not judged", "nothing expected") and ran.exit_code == 0:
            pytest.skip(verdict)
        first = not self.parent.has_failed
        self.parent.has_failed = True
        raise Failed(ran.exit_code, ran.said if first else ran.about(self.name, verdict))

    def repr_failure(self, excinfo):
        if isinstance(excinfo.value, Failed):
            code, said = excinfo.value.args
            return f"{said.rstrip()}\nexit code {code}"
        return super().repr_failure(excinfo)

    def reportinfo(self):
        return self.path, None, self.name


class Ran:
    """A run of a suite, or of one unit of it, with what it wrote."""

    def __init__(self, path, unit):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "results.json")
            words = [path, "--no-progress", f"--json={file}", *([] if unit is None else [unit, "--exact"])]
            done = _runner(*words)
            self.exit_code, self.said, self.is_whole = done.returncode, done.stdout + done.stderr, unit is None
            self.units = {}
            if os.path.exists(file):
                with open(file, encoding="utf-8") as read:
                    self._read(json.load(read))

    def _read(self, report):
        if report.get("layout") != LAYOUT:
            raise ValueError(f"results of layout {report.get('layout')}; this plugin reads {LAYOUT}")
        for suite in report["suites"]:
            for kind in ("recorded", "trials", "blocks", "gates", "ratings"):
                self.units.update((unit["key"], unit) for unit in suite.get(kind, ()))

    def verdict(self, key):
        """`passed`, `failed`, …, or None where nothing is known of the unit."""
        unit = self.units.get(key)
        if unit is None:
            return None
        if unit.get("judged") is False or unit["verdict"] == "not_judged":
            return "not judged"
        return "nothing expected" if unit["verdict"] is None else unit["verdict"]

    def is_red_alone(self, file):
        """Whether the suite as a whole has not passed although each unit of it has."""
        return self.is_whole and self.exit_code != 0 and not file.has_failed

    def about(self, key, verdict):
        lines = [line for line in self.said.splitlines() if key in line]
        return "\n".join([f"{key}: {verdict or 'not run'}", *lines])


class Failed(Exception):
    """Exit code and texts of a run."""


def _runner(*words):
    # Where pytest was started, as for the command.
    return subprocess.run(
        [runner(), *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace"
    )
