"""What a parent that decides in this very process costs: decisions a second, start and results included, with one worker.

    PYTHONPATH=sdk/python/src:sdk/python/examples SCENARIO_RUNNER=target/release/scenario-runner python3 benches/parent.py
"""

import os
import tempfile
import time

from brake import Brake
from brake_vector import Brake as VectorBrake
from scenario_runner_av import run

MEET = """scenario meet {
  road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h; start 60 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
  horizon 20 s
  repeat RUNS
}
"""

os.chdir(tempfile.mkdtemp())
for name, kind, runs in [("Python objects", Brake, 2000), ("numpy", VectorBrake, 20000)]:
    with open("meet.scn", "w") as file:
        file.write(MEET.replace("RUNS", str(runs)))
    begun = time.perf_counter()
    results = run("meet.scn", av=kind, options=["-j1", "--verify-runs=none"])
    taken = time.perf_counter() - begun
    answers = sum(one["answers"]["answers"] for suite in results.report["suites"] for one in suite["controllers"])
    print(f"parent, {name:<16} {answers / taken:>12,.0f} decisions/s   ({runs} runs, {taken:.1f} s)")
