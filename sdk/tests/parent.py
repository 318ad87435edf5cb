"""Controllers in this very process, which starts the runner itself: the same as a program, and what goes wrong is said."""

import contextlib
import io
import os
import shutil
import signal
import subprocess
import sys
import time

from scenario_runner_av import Controller, RunFailed, VectorController, parameter, run

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(os.path.dirname(HERE), "python", "examples")
sys.path.insert(0, EXAMPLES)

from brake import Brake
from brake_vector import Brake as VectorBrake

MEET = """scenario meet {
  road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h; start 50 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears at later }
  vary later in 0 s .. 3 s step 0.5 s
  repeat 3
  expect { max_deceleration <= 9 m/s^2 }
}
"""


def fingerprints(results):
    found = {row["run"]: row["fingerprint"] for row in results.runs}
    assert len(found) == 21, results.said
    return found


def kinds(results):
    return {one["fault"]["kind"] for suite in results.report["suites"] for trial in suite["trials"] for one in trial.get("faults", ())}


def raised(kind, work):
    try:
        work()
    except kind as error:
        return error
    raise AssertionError(f"no {kind.__name__}")


def same_as_a_program():
    with open("brake.scn", "w") as file:
        program = os.path.join(EXAMPLES, "brake.py")
        file.write(f'controller brake {{ command "{sys.executable}", "{program}"; period 100 ms; parameter braking_distance = 25 m in 1 m .. 60 m }}\n')
    for settings, distance in (("", None), (" { braking_distance: 12.5 m }", 12.5)):
        known = fingerprints(run("meet.scn", av=f"brake{settings}", use="brake.scn", allow_run="brake"))
        for kind in (Brake, VectorBrake):
            av = kind
            if distance is not None:
                av = kind()
                av.braking_distance = distance
            for options in ((), ("-j3",)):
                found = run("meet.scn", av=av, options=options)
                assert found.exit_code == 0 and found.passed, found.said
                assert fingerprints(found) == known, (kind, settings)
                tested = found.report["suites"][0]["tested"]
                assert tested == [{"vehicle": "av", "controller": f"brake{settings}", "instead_of": ["constant_speed"]}], tested
        # What a file declares goes before what the class says.
        assert fingerprints(run("meet.scn", av=Brake, use="brake.scn")) == fingerprints(run("meet.scn", av=Brake))
    assert fingerprints(run("meet.scn")) != known


def errors_are_errors():
    class Broken(Controller):
        period = 0.1

        def step(self, seen):
            if seen.time > 0.5:
                raise IndexError("lane 3")
            print("prints stand between no requests")
            return 0.0

    log = io.StringIO()
    with contextlib.redirect_stderr(log), contextlib.redirect_stdout(io.StringIO()) as said:
        found = run("meet.scn", av=Broken)
    assert found.exit_code == 100 and not found.passed and kinds(found) == {"refused"}, found.said
    assert "IndexError: lane 3" in found.said and "in step" in log.getvalue() and "between no requests" in said.getvalue()

    class BrokenVector(VectorController):
        period = 0.1

        def step(self, batch):
            raise IndexError("row 3")

    with contextlib.redirect_stderr(io.StringIO()):
        found = run("meet.scn", av=BrokenVector)
    assert found.exit_code == 100 and kinds(found) == {"refused"} and "IndexError: row 3" in found.said, found.said

    class Slow(Controller):
        period = 0.1

        def step(self, seen):
            time.sleep(2.0)
            return 0.0

    with open("slow.scn", "w") as file:
        file.write('controller slow { command "parent"; period 100 ms; answers within 50 ms }\n')
    Slow.runs_at_once = 1
    found = run("meet.scn", av=Slow, use="slow.scn")
    assert found.exit_code == 100 and kinds(found) == {"timeout"} and len(found.runs) == 0, found.said


def nothing_is_taken_for_something():
    error = raised(RunFailed, lambda: run("meet.scn", ego=Brake))
    assert error.exit_code == 3 and "E1111" in error.said, error.said
    error = raised(RunFailed, lambda: run("meet.scn", "nothing_is_called_so", av=Brake))
    assert error.exit_code == 4, error.said
    assert "one class" in str(raised(ValueError, lambda: run("meet.scn", av=Brake, other=VectorBrake)))
    raised(TypeError, lambda: run("meet.scn", av=3))
    raised(TypeError, lambda: run("meet.scn", av=object))

    class Pet(Controller):
        """Called as a metric is."""

        period = 0.1

        def step(self, seen):
            return 0.0

    assert "av: pet instead of constant_speed" in run("meet.scn", av=Pet).said


def whoever_leaves_ends_the_runner():
    class Leaves(Controller):
        period = 0.1

        def step(self, seen):
            raise KeyboardInterrupt

    begun = time.monotonic()
    raised(KeyboardInterrupt, lambda: run("meet.scn", av=Leaves))
    assert time.monotonic() - begun < 15 and not children(os.getpid())

    script = f"""
import sys, time
sys.path.insert(0, {EXAMPLES!r})
from scenario_runner_av import Controller, run
class Hangs(Controller):
    def step(self, seen):
        print("asked", flush=True)
        time.sleep(600)
run("meet.scn", av=Hangs)
"""
    python = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    assert python.stdout.readline() == b"asked\n"
    left = children(python.pid)
    assert left
    python.send_signal(signal.SIGKILL)
    python.wait()
    until = time.monotonic() + 20
    while any(os.path.exists(f"/proc/{one}") for one in left) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(os.path.exists(f"/proc/{one}") for one in left), left


def children(process):
    found = []
    for one in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError, IndexError), open(f"/proc/{one}/stat") as file:
            if int(file.read().rpartition(")")[2].split()[1]) == process:
                found.append(one)
    return found


if __name__ == "__main__":
    folder = sys.argv[1]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.chdir(folder)
    with open("meet.scn", "w") as file:
        file.write(MEET)
    for test in (same_as_a_program, errors_are_errors, nothing_is_taken_for_something, whoever_leaves_ends_the_runner):
        test()
    print("parent: a class and an object drive as a program does, one and many runs at once; errors are errors")
