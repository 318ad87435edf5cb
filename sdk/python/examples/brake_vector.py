"""Brakes for whoever is near, in many runs at once."""

import numpy

from scenario_runner_av import VectorController, parameter, serve


class Brake(VectorController):
    """Brakes for whoever is near."""

    version, period, modes = "1", 0.1, ("cruise", "brake")
    braking_distance = parameter(25.0, "m", low=1, high=60, doc="Who is nearer counts.")

    def step(self, batch):
        people = batch.pedestrians
        reach = self.braking_distance[batch.slot][people.row]
        brakes = people.any((0 < people.x) & (people.x < reach) & (abs(people.y) < 4)) & (batch.speed > 0)
        batch.mode = numpy.where(brakes, 1, 0)
        return numpy.where(brakes, -3.0, 0.5 * (batch.cruise_speed - batch.speed))


if __name__ == "__main__":
    serve(Brake)
