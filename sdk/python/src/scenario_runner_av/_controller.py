"""What authors derive from: a controller of one run, or of many runs in arrays."""

import re

from ._parameter import parameters_of


class _Told:
    """What the runner is told of a class."""

    name = None
    """As reports call it; the name of the class if nothing is said."""
    version = None
    gives = "acceleration"
    """`acceleration` (m/s²), `pedals` (throttle and brake, 0 .. 1), `speed` (m/s) or `speed_plan` (pairs of s and m/s)."""
    period = None
    """Between decisions, s; every step of the simulation if nothing is said. The scenario file decides: this is what `--declare` writes."""
    modes = ()
    """Words for what it is up to, which reports show."""

    @classmethod
    def own_name(cls):
        """Its name, or one made from that of its class: `my_av` of `MyAv`."""
        return cls.name or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower().strip("_")


class Controller(_Told):
    """A controller of one run. There is an instance for each run, made anew when it begins."""

    runs_at_once = 64
    """How many runs the program may be asked for in one request."""
    mode = None
    """What it is up to, one of `modes`; set it in `step`."""
    curvature = None
    """Of the way that the rear axle is to take, to the left, 1/m; set it in `step`. None keeps the lane, or once it was steered goes on beside it."""

    def start(self, run):
        """A run begins: a `Run`. An exception is an error of that run."""

    def step(self, seen):
        """What the vehicle is to do, having `Seen` this: a number, for `pedals` and `speed_plan` a pair or pairs of them."""
        raise NotImplementedError(f"{type(self).__name__} has no `step`")

    def finish(self, reason):
        """The run is over: `completed`, `collision`, `horizon` or `abandoned`."""


class VectorController(_Told):
    """A controller of many runs at once, in arrays of numpy. There is one instance for the whole program.

    What it keeps of a run stands in arrays of `runs_at_once`, by slot; its parameters are such arrays, too. An exception in
    `step` ends the process, whereupon the runner makes each of the runs again alone and blames those that fail then.
    """

    runs_at_once = 256

    def start(self, run):
        """A run begins in `run.slot`: what an earlier one left there is to be forgotten."""

    def step(self, batch):
        """An array with a row for each run of the `Batch`; of `pedals` with two columns, of `speed_plan` with pairs t1, v1, … and NaN."""
        raise NotImplementedError(f"{type(self).__name__} has no `step`")

    def finish(self, slot, reason):
        """The run in that slot is over."""


PLAN_POINTS = 16
WIDTH = {"acceleration": 1, "speed": 1, "pedals": 2, "speed_plan": 2 * PLAN_POINTS}


def check(controller):
    """Refuses what no runner would take.

    Raises TypeError or ValueError.
    """
    if not (isinstance(controller, type) and issubclass(controller, _Told)):
        raise TypeError(f"{controller!r} is no class of a `Controller` or `VectorController`")
    if controller.gives not in WIDTH:
        raise ValueError(f"`gives` is {controller.gives!r}; there are {', '.join(WIDTH)}")
    if not 1 <= controller.runs_at_once <= 1024:
        raise ValueError(f"`runs_at_once` is {controller.runs_at_once}; it may be 1 .. 1024")
    if isinstance(controller.modes, str):
        raise TypeError("`modes` are several words, in a tuple")
    for one in parameters_of(controller):
        if hasattr(Controller, one.name) or hasattr(VectorController, one.name):
            raise ValueError(f"`{one.name}` means something else in a controller; call the parameter otherwise")
