"""Results as rows, and the runner as a command, here played by a small program."""

import json
import os
import stat
import sys
import tempfile
import unittest
from unittest import mock

from scenario_runner_av import Results, RunFailed, results, run


def report(verdict="passed", **metrics):
    one = {"key": "s/t/a=1/rep=1", "seed": "18446744073709551615", "ending": {"reason": "completed", "time": 2.5}, "metrics": {"pet": None, **metrics}, "fingerprint": "00ff"}
    other = {**one, "key": "s/t/a=1/rep=2", "metrics": {"min_ttc": "inf"}}
    trial = {"key": "s/t/a=1", "scenario": "t", "verdict": verdict, "variation": {"a": 1.0, "who": "child"}, "runs": [one, other]}
    exit_code = {"passed": 0, "inconclusive": 102}.get(verdict, 100)
    return {"layout": 2, "overall": {"verdict": verdict, "exit_code": exit_code}, "suites": [{"suite": "s", "trials": [trial]}]}


class Rows(unittest.TestCase):
    def test_runs_are_flat_rows_with_the_same_columns(self):
        first, second = Results(report(collision=0.0)).runs
        self.assertEqual(list(first), list(second))
        self.assertEqual((first["variation_a"], first["variation_who"], first["seed"]), (1.0, "child", 2**64 - 1))
        self.assertEqual((first["collision"], first["pet"], first["min_ttc"]), (0.0, None, None))
        self.assertEqual((second["collision"], second["min_ttc"]), (None, float("inf")))

    def test_what_did_not_pass_is_not_passed(self):
        self.assertTrue(Results(report()).passed)
        for other in ("failed", "error", "inconclusive"):
            self.assertFalse(Results(report(other)).passed)
        self.assertFalse(Results(report(), exit_code=102).passed)
        self.assertFalse(Results({"layout": 2, "suites": []}).passed)

    def test_the_runner_decides_what_passed(self):
        # A gate got worse, a claim of an estimate failed, nothing was judged: all trials passed.
        for code in (100, 102, 103, 104, 105):
            self.assertFalse(Results({**report(), "overall": {"verdict": "regressed", "exit_code": code}}).passed)
        # Trials that were not selected are skipped, and the part that was has passed.
        part = report()
        part["suites"][0]["trials"].append({**part["suites"][0]["trials"][0], "verdict": "skipped", "runs": []})
        self.assertTrue(Results(part).passed)

    def test_a_trial_that_judged_nothing_has_not_passed(self):
        nothing = report()
        nothing["suites"][0]["trials"][0]["judged"] = False
        row = Results(nothing).trials[0]
        self.assertEqual((row["verdict"], row["judged"]), ("not_judged", False))
        untested = report()
        untested["suites"][0]["trials"][0]["findings"] = [{"untested": {"reason": "no_value"}}]
        self.assertTrue(Results(untested).trials[0]["untested"])

    def test_another_layout_is_refused(self):
        with self.assertRaisesRegex(ValueError, "layout 3"):
            Results({**report(), "layout": 3})

    def test_results_of_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "r.json")
            with open(path, "w") as file:
                json.dump(report(), file)
            self.assertEqual(results(path).trials, [{"suite": "s", "scenario": "t", "trial": "s/t/a=1", "verdict": "passed", "judged": True, "untested": False, "runs": 2, "variation_a": 1.0, "variation_who": "child"}])


class Commands(unittest.TestCase):
    def run_with(self, body, *words, **more):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "runner")
            with open(path, "w") as file:
                file.write(f"#!{sys.executable}\nimport json, sys\npath = [one for one in sys.argv if one.startswith('--json=')][0][7:]\n{body}\n")
            os.chmod(path, stat.S_IRWXU)
            with mock.patch.dict(os.environ, SCENARIO_RUNNER=path):
                return run(*words, **more)

    def test_failing_trials_are_results(self):
        body = f"print(sys.argv[1:]); json.dump({report('failed')!r}, open(path, 'w')); sys.exit(100)".replace("None", "None")
        found = self.run_with(body, "zebra.suite", "tta=6s", allow_run="my_av", options=["-j1"])
        self.assertEqual((found.exit_code, found.passed, len(found.runs)), (100, False, 2))
        for word in ("'zebra.suite', 'tta=6s'", "'-j1'", "'--allow-run=my_av'"):
            self.assertIn(word, found.said)

    def test_where_nothing_came_of_it_that_is_raised(self):
        with self.assertRaisesRegex(RunFailed, "exit code 3\nE1105") as raised:
            self.run_with("sys.stderr.write('E1105'); sys.exit(3)", "zebra.suite")
        self.assertEqual(raised.exception.exit_code, 3)


if __name__ == "__main__":
    unittest.main()
