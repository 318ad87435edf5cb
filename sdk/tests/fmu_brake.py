"""The controller of `sdk/python/examples/brake.py` as functional mock-up units: of FMI 2.0, and what is other in 3.0."""

TWO = """
from pythonfmu import Boolean, Fmi2Causality as Causality, Fmi2Slave, Fmi2Variability as Variability, Real as Number

CLOCK = None
"""

THREE = """
from pythonfmu3 import Boolean, Fmi3Causality as Causality, Fmi3Slave, Fmi3Variability as Variability, Float64 as Number

CLOCK = dict(causality=Causality.independent, variability=Variability.continuous)
"""

UNIT = '''
OBJECTS = range(1, 9)


class {name}(Fmi{edition}Slave):
    """Brakes for whoever is near."""

    author = "the tests"

    def __init__(self, **settings):
        super().__init__(**settings)
        if CLOCK:
            self.time = 0.0
            self.register_variable(Number("time", **CLOCK))
        self.speed = self.cruise = self.acceleration = 0.0
        self.reach = 25.0
        for name in ("speed", "cruise"):
            self.register_variable(Number(name, causality=Causality.input))
        for number in OBJECTS:
            setattr(self, f"there{{number}}", False)
            self.register_variable(Boolean(f"there{{number}}", causality=Causality.input))
            for axis in ("x", "y"):
                setattr(self, f"{{axis}}{{number}}", 0.0)
                self.register_variable(Number(f"{{axis}}{{number}}", causality=Causality.input))
        self.register_variable(Number("reach", causality=Causality.parameter, variability=Variability.tunable))
        self.register_variable(Number("acceleration", causality=Causality.output))

    def do_step(self, time, step):
        seen = [(getattr(self, f"x{{one}}"), getattr(self, f"y{{one}}")) for one in OBJECTS if getattr(self, f"there{{one}}")]
        near = any(0 < x < self.reach and abs(y) < 4 for x, y in seen)
        {misdeed}
        self.acceleration = {braking} if near and self.speed > 0 else 0.5 * (self.cruise - self.speed)
        return True
'''


def text(edition, name, braking="-3.0", misdeed="pass"):
    """The module of a unit."""
    return (TWO if edition == 2 else THREE) + UNIT.format(name=name, edition=edition, braking=braking, misdeed=misdeed)


def declaration(name, environment, reach="25 m", unit="m/s"):
    """What a scenario file says of it."""
    lines = [f'fmu "{name}.fmu"', f'environment {environment}', "period 100 ms", f'input ego.speed = "speed" in {unit}']
    lines += ['input cruise_speed = "cruise" in m/s', 'output acceleration = "acceleration" in m/s^2']
    for one in range(1, 9):
        lines += [f'input object{one}.present = "there{one}"']
        lines += [f'input object{one}.{axis} = "{axis}{one}" in m' for axis in "xy"]
    lines.append(f'parameter braking_distance = {reach} in 1 m .. 60 m as "reach" in m')
    return "\n  ".join(lines)
