"""highway-env's `IDMVehicle` as a controller of scenario-runner: its own acceleration for a leader by the rule of `leader.py`."""

import os

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # nothing is drawn

from highway_env import __version__ as version
from highway_env.road.road import Road, RoadNetwork
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.kinematics import Vehicle
from scenario_runner_av import Controller, parameter, serve

from leader import leader_of

LENGTH = 10_000.0


class HighwayIdm(Controller):
    """highway-env's IDMVehicle: the intelligent driver model with a jam distance of 5 m and a time gap of 1.5 s."""

    name, version, period = "highway_idm", version, 0.1
    anticipation = parameter(2.0, "s", low=0, high=4, doc="Somebody who is on the lane that soon counts as a leader.")

    def start(self, run):
        self.road = Road(network=RoadNetwork.straight_road_network(1, length=LENGTH, speed_limit=run.cruise_speed))
        self.ego = IDMVehicle(self.road, [0.0, 0.0], target_speed=run.cruise_speed, enable_lane_change=False)

    def step(self, seen):
        leader = leader_of(seen, self.anticipation)
        self.ego.speed = seen.speed
        front = None
        if leader:
            # It measures from middle to middle of vehicles of its own length.
            front = Vehicle(self.road, [leader.gap + Vehicle.LENGTH, 0.0], speed=leader.speed)
        wanted = float(self.ego.acceleration(self.ego, front))
        # As its `act` limits it.
        return max(-IDMVehicle.ACC_MAX, min(IDMVehicle.ACC_MAX, wanted))


if __name__ == "__main__":
    serve(HighwayIdm)
