"""pytest runs suites: an item for each trial, and the runner's text where one fails."""

import subprocess
import sys


def pytest(*words):
    done = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *words], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


code, said = pytest("suites/zebra.suite", "-v")
assert code == 0 and "12 passed" in said and "zebra/carla_walker/tta=6s PASSED" in said, said
code, said = pytest("suites/zebra.suite", "-k", "carla_walker and 6s")
assert code == 0 and "1 passed, 11 deselected" in said, said
# Tags are keywords, too.
code, said = pytest("suites/zebra.suite", "-k", "paper and 6s")
assert code == 0 and "1 passed, 11 deselected" in said, said
code, said = pytest("suites/zebra_unsafe.suite")
assert code == 1 and "failed" in said and "replay: scenario-runner replay" in said and "exit code 100" in said, said
assert said.count("exit code 100") == said.count("_ zebra_unsafe/"), said
# A gate over all trials is an item of its own, and a part of the suite does not judge it.
code, said = pytest("suites/zebra_gate.suite", "-v")
assert code == 0 and "9 passed" in said and "zebra_gate/gate=braking PASSED" in said, said
code, said = pytest("suites/zebra_gate.suite", "-k", "late_person and 4s")
assert code == 0 and "1 passed, 8 deselected" in said, said
code, said = pytest("suites/nowhere.suite")
assert code != 0, said
print("pytest: items pass, are selected and fail with the runner's text")
