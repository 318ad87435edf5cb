"""Controllers of automated vehicles in Python, tested by scenario-runner.

    class MyAv(Controller):
        period = 0.1

        def step(self, seen):
            return 0.5 * (seen.cruise_speed - seen.speed)

    if __name__ == "__main__":
        serve(MyAv)
"""

import os as _os

from . import _streams

# What a library prints when it is imported must not get between the runner and the program.
if _os.environ.get("SCENARIO_RUNNER_CONTROLLER"):
    _streams.take()

from ._controller import Controller, VectorController
from ._parameter import parameter
from ._results import Results, RunFailed, results, run
from ._seen import CYCLIST, ESCOOTER, PEDESTRIAN, Box, CurvatureChange, Lane, Pedestrian, Run, Seen, SeenCrossing, Vehicle
from ._serve import serve

__version__ = "0.1.0"

__all__ = [
    "CYCLIST",
    "ESCOOTER",
    "PEDESTRIAN",
    "Box",
    "Controller",
    "CurvatureChange",
    "Lane",
    "Pedestrian",
    "Results",
    "Run",
    "RunFailed",
    "Seen",
    "SeenCrossing",
    "Vehicle",
    "VectorController",
    "parameter",
    "results",
    "run",
    "serve",
]
