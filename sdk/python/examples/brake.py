"""Brakes for whoever is near."""

from scenario_runner_av import Controller, parameter, serve


class Brake(Controller):
    """Brakes for whoever is near."""

    version, period, modes = "1", 0.1, ("cruise", "brake")
    braking_distance = parameter(25.0, "m", low=1, high=60, doc="Who is nearer counts.")

    def step(self, seen):
        near = any(0 < one.x < self.braking_distance and abs(one.y) < 4 for one in seen.pedestrians)
        if near and seen.speed > 0:
            self.mode = "brake"
            return -3.0
        self.mode = "cruise"
        return 0.5 * (seen.cruise_speed - seen.speed)


if __name__ == "__main__":
    serve(Brake)
