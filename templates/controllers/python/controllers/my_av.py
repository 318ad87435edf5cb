"""The controller under test."""

from scenario_runner_av import Controller, parameter, serve


class MyAv(Controller):
    """Brakes for whoever is on the way or close to it."""

    version = "1"
    period = 0.1
    modes = ("cruise", "brake")
    gap = parameter(3.0, "m", low=1, high=10, doc="Kept to whoever it stops for.")

    def step(self, seen):
        # x is ahead of the vehicle's centre, y to the left of the middle of its lane.
        needed = 0.0
        for one in seen.pedestrians:
            if one.x > 0 and abs(one.y) < 4:
                room = max(one.x - seen.length / 2 - self.gap, 0.1)
                needed = max(needed, seen.speed**2 / (2 * room))
        self.mode = "brake" if needed > 1 else "cruise"
        return -min(needed, 6.0) if needed > 1 else 0.5 * (seen.cruise_speed - seen.speed)


if __name__ == "__main__":
    serve(MyAv)
