"""Suites run from Python, and what they came to as rows."""

import json
import os
import shutil
import subprocess
import sysconfig
import tempfile

from . import _parent as parent

LAYOUT = 2
_FILES = (".suite", ".scn", ".yaml", ".yml")
_VERDICTS = ("passed", "inconclusive", "failed")
_INFINITE = {"inf": float("inf"), "-inf": float("-inf")}


class RunFailed(Exception):
    """Nothing came of it: a file with errors, a program that may not run, nothing selected. `exit_code` says which."""

    def __init__(self, exit_code, said):
        super().__init__(f"scenario-runner ended with exit code {exit_code}\n{said}")
        self.exit_code = exit_code
        self.said = said


class Results:
    """What suites came to: `runs` and `trials` are lists of rows (flat dicts), for `pandas.DataFrame(…)` or `polars.DataFrame(…)`.

    `report` is all that the runner wrote, `exit_code` how it ended (0: everything passed; None: read from a file), `said` its texts.
    """

    def __init__(self, report, exit_code=None, said=""):
        if report.get("layout") != LAYOUT:
            raise ValueError(f"results of layout {report.get('layout')}; this package reads {LAYOUT}")
        self.report, self.exit_code, self.said = report, exit_code, said

    @property
    def overall(self):
        """The verdict on all units, gates, ratings and blocks included: `passed`, `failed`, `regressed`, `not_comparable`, `inconclusive` or
        `nothing_judged`; None in results that do not say it."""
        return self.report.get("overall", {}).get("verdict")

    @property
    def passed(self):
        """Whether the runner ends with 0: what was judged passed, and something was."""
        return self.report.get("overall", {}).get("exit_code") == 0 and self.exit_code in (0, None)

    @property
    def trials(self):
        """A row for each trial: suite, scenario, key, verdict, whether it was judged and whether something that passed was never put to the
        test, runs, then its variations. A trial to which no criterion applies has the verdict `not_judged`."""
        rows = []
        for suite, trial in self._trials():
            judged = trial.get("judged", trial["verdict"] in _VERDICTS)
            verdict = "not_judged" if trial.get("judged") is False else trial["verdict"]
            row = {"suite": suite["suite"], "scenario": trial["scenario"], "trial": trial["key"], "verdict": verdict}
            row["judged"], row["untested"] = judged, _is_untested(trial)
            row["runs"] = len(trial["runs"])
            row.update(_variation(trial))
            rows.append(row)
        return rows

    @property
    def runs(self):
        """A row for each run that came to its end: where it belongs, variations, seed, how it ended, its metrics (None: undefined)."""
        rows = []
        for suite, trial in self._trials():
            for run in trial["runs"]:
                row = {"suite": suite["suite"], "scenario": trial["scenario"], "trial": trial["key"], "run": run["key"]}
                row.update(_variation(trial))
                row["seed"] = int(run["seed"])
                row["ending"] = run["ending"]["reason"]
                row["ending_time"] = _number(run["ending"]["time"])
                row.update((name, _number(value)) for name, value in run["metrics"].items())
                row["fingerprint"] = run["fingerprint"]
                rows.append(row)
        # Tables want the same columns in every row.
        columns = dict.fromkeys(name for row in rows for name in row)
        return [{name: row.get(name) for name in columns} for row in rows]

    def _trials(self):
        return ((suite, trial) for suite in self.report["suites"] for trial in suite["trials"])


def _is_untested(trial):
    return bool(trial.get("never_began")) or any("untested" in finding for finding in trial.get("findings", ()))


def _number(value):
    return _INFINITE.get(value, value) if isinstance(value, str) else value


def _variation(trial):
    return {f"variation_{name}": _number(value) for name, value in trial["variation"].items()}


def results(path):
    """The results that `--json` wrote into a file."""
    with open(path, encoding="utf-8") as file:
        return Results(json.load(file))


def runner():
    """Where the runner is: what SCENARIO_RUNNER names, beside this Python, or on PATH."""
    named = os.environ.get("SCENARIO_RUNNER")
    beside = shutil.which("scenario-runner", path=sysconfig.get_path("scripts"))
    found = named or beside or shutil.which("scenario-runner")
    if not found:
        raise FileNotFoundError("there is no scenario-runner beside this Python nor on PATH; SCENARIO_RUNNER may name it")
    return found


def run(*words, allow_run=(), options=(), use=(), **controllers):
    """Runs suites and scenarios, named as on the command line, and gives their `Results`, also of those that fail.

    `allow_run` names the declared controllers whose programs may run this once. `av=MyAv` has that class (or a copy of that object for each
    run) drive every vehicle `av` in the place of what the scenarios say, here in this process; `av="carla_behavior"` has that controller.
    Files in `use` may declare them; a class that none of the files declares is declared as `--declare` prints it. Raises `RunFailed` where
    nothing came of it.
    """
    words = [os.fspath(word) for word in words]
    uses = [os.fspath(one) for one in ([use] if isinstance(use, (str, os.PathLike)) else use)]
    served, more = parent.served(controllers)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "results.json")
        command = [runner(), *words, "--no-progress", f"--json={path}", *more, *options]
        if allow_run:
            command.append(f"--allow-run={','.join([allow_run] if isinstance(allow_run, str) else allow_run)}")
        if served is None:
            command += [f"--use={one}" for one in uses]
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace")
            code, said = done.returncode, done.stdout + done.stderr
        else:
            with served.declared() as own:
                files = [*(word for word in words if word.endswith(_FILES)), *uses]
                uses += [] if any(_declares(file, served.name) for file in files) else [own]
                code, said = served.run([*command, *(f"--use={one}" for one in uses), *served.words()])
        if not os.path.exists(path):
            raise RunFailed(code, said)
        with open(path, encoding="utf-8") as file:
            return Results(json.load(file), code, said)


def _declares(file, name):
    """Whether a file declares a controller of that name, itself or in one that it uses."""
    command = [runner(), "models", name, file]
    return b" is declared in " in subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True).stdout
