"""A model-predictive planner as a controller of scenario-runner: a quadratic programme, solved by OSQP at every decision.

Over a horizon of steps of 0.2 s it chooses accelerations that keep to the cruise speed, are small and change little, and stay `margin`
metres behind the leader by the rule of `leader.py`, whose speed is taken to stay as it is. Staying behind is soft: where it cannot be kept
to, as little is missing as possible.
"""

import sys

import numpy as np
import osqp
from scenario_runner_av import Controller, parameter, serve
from scipy import sparse

from leader import leader_of

STEP = 0.2
SLOWEST, FASTEST = -8.0, 2.0
# What 1 m too close costs, beside 1 (m/s)² off the cruise speed.
TOO_CLOSE = 1e4
NOBODY = 1e4


class Planner(Controller):
    """A planner by quadratic programming (OSQP) over the next 4 s."""

    name, version, period = "planner", "1", STEP
    margin = parameter(3.0, "m", low=0.5, high=15, doc="Kept between the bumper and whoever is the leader.")
    calm = parameter(1.0, low=0.05, high=20, doc="What 1 (m/s²)² costs, beside 1 (m/s)² off the cruise speed.")
    anticipation = parameter(2.0, "s", low=0, high=4, doc="Somebody who is on the lane that soon counts as a leader.")
    adaptation = parameter("fixed", options=["fixed", "by_time"], doc="When OSQP adapts its step size: every 25 iterations, or by wall time, its default.")

    steps = 20

    def start(self, run):
        count = self.steps
        # Of accelerations: speeds and ways gained at the end of each step.
        self.speeds = STEP * np.tril(np.ones((count, count)))
        self.ways = STEP * np.tril(np.ones((count, count))) @ self.speeds - 0.5 * STEP * self.speeds
        changes = np.eye(count) - np.eye(count, k=-1)
        cost = self.speeds.T @ self.speeds + self.calm * np.eye(count) + self.calm * changes.T @ changes
        every, none = np.eye(count), np.zeros((count, count))
        rows = np.block([[every, none], [self.speeds, none], [self.ways, -every], [none, every]])
        self.low = np.concatenate([np.full(count, SLOWEST), np.zeros(count), np.full(count, -np.inf), np.zeros(count)])
        self.high = np.concatenate([np.full(count, FASTEST), np.full(count, np.inf), np.full(count, NOBODY), np.full(count, np.inf)])
        self.solver = osqp.OSQP()
        self.solver.setup(
            sparse.csc_matrix(np.block([[2 * cost, none], [none, 2 * TOO_CLOSE * every]])),
            np.zeros(2 * count),
            sparse.csc_matrix(rows),
            self.low,
            self.high,
            verbose=False,
            eps_abs=1e-4,
            eps_rel=1e-4,
            max_iter=20_000,
            adaptive_rho_interval=25 if self.adaptation == "fixed" else 0,
        )
        self.last = 0.0

    def step(self, seen):
        count = self.steps
        leader = leader_of(seen, self.anticipation)
        times = STEP * np.arange(1, count + 1)
        off = seen.speed - seen.cruise_speed
        gradient = np.zeros(2 * count)
        gradient[:count] = 2 * off * self.speeds.sum(axis=0)
        gradient[0] -= 2 * self.calm * self.last
        self.low[count : 2 * count] = -seen.speed
        if leader:
            self.high[2 * count : 3 * count] = leader.gap - self.margin + (leader.speed - seen.speed) * times
        else:
            self.high[2 * count : 3 * count] = NOBODY
        self.solver.update(q=gradient, l=self.low, u=self.high)
        found = self.solver.solve()
        if found.info.status != "solved":
            raise RuntimeError(f"OSQP: {found.info.status}")
        self.last = float(found.x[0])
        return self.last


class Next(Planner):
    """The next version of it, which looks 2 s ahead rather than 4 s to save time."""

    name, version = "planner", "2"
    steps = 10


if __name__ == "__main__":
    serve(Next if "--next" in sys.argv else Planner)
