"""Runs the suites of this folder in a copy of it, and says what came of them."""

import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
from scenario_runner_av import results


def main(runner, folder):
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(HERE, os.path.join(folder, "examples", "controllers"))
    shutil.copytree(os.path.join(ROOT, "scenarios"), os.path.join(folder, "scenarios"))
    shutil.copytree(os.path.join(ROOT, "suites"), os.path.join(folder, "suites"))

    def said(*words, codes=(0,)):
        """What the runner says to these words."""
        found = subprocess.run([runner, *words, "--allow-run"], cwd=folder, capture_output=True, text=True)
        assert found.returncode in codes, f"{words}: exit code {found.returncode}\n{found.stdout}{found.stderr}"
        return found.stdout + found.stderr

    def runs(suite, name, *words, only=()):
        """The rows of its runs, or of `only` some. Criteria may fail, which is what the comparison is for; errors may not."""
        text = said(suite, *only, f"--json={name}.json", f"--html={name}.html", *words, codes=(0, 100))
        found = results(os.path.join(folder, f"{name}.json"))
        ended = ("passed", "failed", "skipped") if only else ("passed", "failed")
        wrong = [trial for trial in found.trials if trial["verdict"] not in ended]
        assert not wrong, f"{suite}: {wrong[:3]}\n{text}"
        assert "W1102" not in text, f"{suite}: a controller is not deterministic\n{text}"
        return found.runs, text

    bits = lambda rows: {row["run"]: row["fingerprint"] for row in rows}

    own = "suites/own_controllers.suite"
    rows, text = runs(own, "own", "-j2")
    assert len(rows) == 1440, len(rows)
    print(text[text.rindex("\ncontroller `highway_idm`"):].strip().split("note:")[0].strip())
    again, _ = runs(own, "again", "-j1", only=["tta=4s"])
    known, found = bits(rows), bits(again)
    assert len(found) == 360, len(found)
    differing = [run for run in found if known.get(run) != found[run]]
    assert not differing, f"one thread: {len(differing)} of {len(found)} runs are others, such as {differing[:3]}"
    print(f"own_controllers: the same {len(found)} runs on one thread")
    table(rows)

    varied, _ = runs("examples/controllers/anticipation.suite", "anticipation")
    table(varied, "variation_anticipation")
    assert len(set(bits(varied).values())) > 0.5 * len(varied), "who counts as a leader changes nothing"

    print(said("tune", "margin", own, codes=(0, 100)).split("\ncontroller ")[0])
    gate(folder, said)
    by_time(folder, said)


def table(rows, besides=None):
    """What the controllers came to, a line each."""
    print(f"{'':44}  runs  collisions  least pet  mean of strongest braking  time lost, mean  cut off")
    groups = {}
    for row in rows:
        groups.setdefault((row["scenario"], row.get(besides)), []).append(row)
    for (scenario, value), those in groups.items():
        known = lambda name: [row[name] for row in those if row[name] is not None]
        mean = lambda name: sum(known(name)) / len(known(name))
        name = scenario if value is None else f"{scenario}, anticipation {value:g} s"
        cut = sum(row["ending"] != "completed" for row in those)
        print(
            f"{name:44} {len(those):5} {sum(known('collision')):11.0f} {min(known('pet')):8.2f} s {mean('max_deceleration'):19.2f} m/s^2"
            f" {mean('time_lost'):14.2f} s {cut:8}"
        )


def gate(folder, said):
    """Version 2 of the planner against the baseline of version 1."""
    suite = "examples/controllers/planner_gate.suite"
    said("baseline", "save", suite)
    same = said(suite)
    assert "planner 1" in same, same
    declared = os.path.join(folder, "examples", "controllers", "controllers.scn")
    with open(declared) as file:
        text = file.read()
    with open(declared, "w") as file:
        file.write(text.replace('"planner.py"', '"planner.py", "--next"'))
    found = said(suite, codes=(104,))
    with open(declared, "w") as file:
        file.write(text)
    assert "planner 1 -> planner 2" in found and "regressed" in found, found
    print(found[found.index("gate next_version"):].split("  worse in one trial")[0])


def by_time(folder, said):
    """OSQP as it is by default adapts by wall time: runs that come out otherwise are found, if they do."""
    suite = os.path.join(folder, "examples", "controllers", "planner_gate.suite")
    with open(suite) as file:
        text = file.read()
    with open(suite, "w") as file:
        file.write(text.replace("controller planner;", "controller planner { adaptation: by_time };").split("  gate ")[0] + "}\n")
    found = said(suite, "--verify-runs=all", codes=(0, 100))
    print("OSQP by wall time:", next((line for line in found.splitlines() if "W1102" in line or "not deterministic" in line), "no run differed this time"))


if __name__ == "__main__":
    main(*sys.argv[1:])
