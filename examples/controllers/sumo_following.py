"""SUMO's car following as a controller of scenario-runner: its own next speed for a leader by the rule of `leader.py`.

One simulation of SUMO stands still for all runs. A run has a vehicle of its own in it, of the type that is asked for, and SUMO is asked how
fast that vehicle would drive a step later.
"""

import itertools
import os

import libsumo
from scenario_runner_av import Controller, parameter, serve

from leader import leader_of

HERE = os.path.dirname(os.path.abspath(__file__))
STEP = 0.1
RUNS = 64
# Apart from each other on the lane, m.
PLACE = 50.0
# Nobody ahead is somebody who drives at cruise speed, so far ahead that nobody would brake for them.
NOBODY = 1000.0

numbers = itertools.count()


def started():
    """Starts SUMO; its version."""
    files = ["--net-file", os.path.join(HERE, "street.net.xml"), "--additional-files", os.path.join(HERE, "types.add.xml")]
    libsumo.start(["sumo", *files, "--step-length", str(STEP), "--seed", "1", "--no-warnings", "--time-to-teleport", "-1"])
    return libsumo.getVersion()[1]


class SumoFollowing(Controller):
    """SUMO's car-following models with their default parameters, of a passenger car."""

    name, period, runs_at_once = "sumo_following", STEP, RUNS
    model = parameter("krauss", options=["krauss", "idm", "eidm"], doc="Which of SUMO's models.")
    anticipation = parameter(2.0, "s", low=0, high=4, doc="Somebody who is on the lane that soon counts as a leader.")

    def start(self, run):
        # A new one for each run: what a model remembers does not outlive it.
        self.vehicle = f"run {next(numbers)}"
        libsumo.vehicle.add(
            self.vehicle, "ahead", typeID=self.model, departPos=str(PLACE * (run.slot + 1)), departSpeed="0", departLane="0"
        )
        libsumo.simulationStep()
        if self.vehicle not in libsumo.vehicle.getIDList():
            raise RuntimeError(f"SUMO found no place for {self.vehicle}")
        libsumo.vehicle.setSpeed(self.vehicle, 0.0)
        libsumo.vehicle.setMaxSpeed(self.vehicle, run.cruise_speed)
        self.hardest = libsumo.vehicle.getEmergencyDecel(self.vehicle)

    def step(self, seen):
        leader = leader_of(seen, self.anticipation)
        gap, speed = leader or (NOBODY, seen.cruise_speed)
        gentlest = libsumo.vehicle.getDecel(self.vehicle)
        follow = libsumo.vehicle.getFollowSpeed(self.vehicle, seen.speed, gap, speed, gentlest)
        # What SUMO does with it afterwards in a step of its own: nobody drives faster than they want or brakes harder than they can.
        wanted = (min(follow, seen.cruise_speed) - seen.speed) / STEP
        return max(wanted, -self.hardest)

    def finish(self, reason):
        libsumo.vehicle.remove(self.vehicle)
        libsumo.simulationStep()


if __name__ == "__main__":
    SumoFollowing.version = started()
    serve(SumoFollowing)
