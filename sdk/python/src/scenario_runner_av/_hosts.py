"""Controllers at work: what begins, decides and ends runs, whether one object or arrays decide."""

import itertools
import math
import sys
import traceback

from ._controller import PLAN_POINTS, WIDTH, VectorController
from ._parameter import parameters_of
from ._seen import run_of, scenes_of

NAN = float("nan")


class Refused(Exception):
    """Runs that cannot be decided in: slot and message of each."""

    def __init__(self, slots):
        super().__init__(slots)
        self.slots = slots


def message_of(error):
    """An exception in one line; the traceback goes to the log. An interruption by the user is raised again, and nothing else: an exit is an
    error of its run, and not the end of the script that started the runner."""
    if isinstance(error, KeyboardInterrupt):
        raise error
    traceback.print_exception(type(error), error, error.__traceback__, file=sys.stderr)
    sys.stderr.flush()
    return f"{type(error).__name__}: {error}".splitlines()[0]


def host_of(controller, runs_at_once, make, is_parent=False, steers=True):
    """Whoever puts a class to work, of which `make` makes an object; `steers` says whether the runner takes a curvature."""
    if issubclass(controller, VectorController):
        return VectorHost(controller, runs_at_once, make, is_parent, steers)
    return ObjectHost(controller, runs_at_once, make, steers)


_NOT_TAKEN = "this runner takes no curvature"


class ObjectHost:
    """Has an instance for each run."""

    def __init__(self, controller, runs_at_once, make, steers):
        self.make = make
        self.steers = steers
        self.runs = [None] * runs_at_once
        # What was decided together with a run that was refused: the runner asks for it again, and nobody decides twice.
        self.decided = {}
        self.modes = {mode: float(index) for index, mode in enumerate(controller.modes)}
        self.row = _ROWS[controller.gives]

    def open(self, message):
        """Begins a run."""
        run = run_of(message)
        instance = self.make()
        for name, value in run.parameters.items():
            setattr(instance, name, value)
        instance.start(run)
        self.decided.pop(run.slot, None)
        self.runs[run.slot] = instance

    def step(self, runs, pedestrians, vehicles, changes=(), crossings=()):
        """Rows of answers, with the index of the mode, and the curvature if anybody steers."""
        decided, refused, answers = self.decided, [], []
        for seen in scenes_of(runs, pedestrians, vehicles, changes, crossings):
            known = decided.get(seen.slot)
            if known is not None and known[0] == seen.time:
                answers.append(known[1])
                continue
            try:
                instance = self.runs[seen.slot]
                answer = self.row(instance.step(seen))
                mode = instance.mode
                answer.append(-1.0 if mode is None else self.mode(mode))
                curvature = instance.curvature
                if self.steers:
                    answer.append(NAN if curvature is None else number(curvature))
                elif curvature is not None:
                    raise ValueError(_NOT_TAKEN)
                answers.append(answer)
            except BaseException as error:
                refused.append((seen.slot, message_of(error)))
                answers.append(None)
        if refused:
            slots = zip(runs, answers)
            self.decided = {int(run[0]): (run[1], answer) for run, answer in slots if answer is not None}
            raise Refused(refused)
        if decided:
            self.decided = {}
        if self.steers and all(answer[-1] != answer[-1] for answer in answers):
            # Nobody steers: as it was before anybody could.
            return [answer[:-1] for answer in answers]
        return answers

    def mode(self, word):
        """Its index."""
        try:
            return self.modes[word]
        except KeyError:
            raise ValueError(f"the mode {word!r} is none of `modes`: {list(self.modes)}") from None

    def close(self, slot, reason):
        """Ends a run."""
        instance, self.runs[slot] = self.runs[slot], None
        self.decided.pop(slot, None)
        if instance is not None:
            instance.finish(reason)


class VectorHost:
    """Has one instance, whose state stands in arrays by slot."""

    def __init__(self, controller, runs_at_once, make, is_parent, steers):
        import numpy

        self.steers = steers
        self.known = numpy.arange(-1, len(controller.modes))
        self.numpy = numpy
        self.is_parent = is_parent
        self.width = WIDTH[controller.gives]
        kinds = {"number": float, "whole": numpy.int64, "flag": bool, "word": object, "text": object}
        self.instance = make()
        self.instance.runs_at_once = runs_at_once
        for one in parameters_of(controller):
            setattr(self.instance, one.name, numpy.full(runs_at_once, one.default, dtype=kinds[one.kind]))
        self.names = {one.name for one in parameters_of(controller)}

    def open(self, message):
        """Begins a run."""
        run = run_of(message)
        for name in self.names.intersection(run.parameters):
            getattr(self.instance, name)[run.slot] = run.parameters[name]
        self.instance.start(run)

    def step(self, runs, pedestrians, vehicles, changes=(), crossings=()):
        """An array of answers, with the index of the mode, and the curvature if anybody steers."""
        from ._batch import Batch

        numpy = self.numpy
        batch = Batch(runs, pedestrians, vehicles, changes, crossings)
        rows = numpy.full((len(batch), self.width + 1 + self.steers), NAN)
        try:
            answer = numpy.asarray(self.instance.step(batch))
            if answer.dtype.kind not in "iuf":
                raise TypeError(f"`step` gave an array of {answer.dtype}, where numbers were due")
            answer = answer.astype(float)
            if answer.shape == (len(batch),):
                answer = answer[:, None]
            if answer.ndim != 2 or len(answer) != len(batch):
                raise ValueError(f"`step` gave an array of shape {answer.shape} for {len(batch)} runs")
            if answer.shape[1] != self.width and not (self.width == 2 * PLAN_POINTS and 2 <= answer.shape[1] < self.width):
                raise ValueError(f"`step` gave {answer.shape[1]} columns, where {self.width} were due")
            if not self.steers and not numpy.isnan(batch.steering).all():
                raise ValueError(_NOT_TAKEN)
            if not numpy.isin(batch.mode, self.known).all():
                raise ValueError(f"`mode` holds {batch.mode.tolist()}; it takes indices of `modes`, and -1 for none")
        except BaseException as error:
            if len(batch) > 1 and not self.is_parent:
                # Nobody knows whose fault it is; the runner finds out, by making each run again alone.
                raise
            # Of a parent there is no other: all of them are errors.
            message = message_of(error)
            raise Refused([(int(slot), message) for slot in batch.slot]) from None
        rows[:, : answer.shape[1]] = answer
        rows[:, self.width] = batch.mode
        if self.steers:
            rows[:, -1] = batch.steering
            if numpy.isnan(batch.steering).all():
                rows = rows[:, :-1]
        return rows

    def close(self, slot, reason):
        """Ends a run."""
        self.instance.finish(slot, reason)


def number(value):
    """A number as a float; flags and texts are none, though Python would convert them."""
    if isinstance(value, (bool, str, bytes, bytearray)) or type(value).__name__ in ("bool", "bool_"):
        raise TypeError(f"{value!r} is not a number")
    return float(value)


def _acceleration_or_speed(value):
    return [number(value)]


def _pedals(value):
    throttle, brake = value
    return [number(throttle), number(brake)]


def _plan(value):
    row = []
    for time, speed in value:
        row += (number(time), number(speed))
    if len(row) > 2 * PLAN_POINTS:
        raise ValueError(f"a plan of {len(row) // 2} points; there may be {PLAN_POINTS}")
    return row + [NAN] * (2 * PLAN_POINTS - len(row))


_ROWS = {"acceleration": _acceleration_or_speed, "speed": _acceleration_or_speed, "pedals": _pedals, "speed_plan": _plan}


def json_answer(gives, modes, row):
    """A row of an answer as JSON; what is not finite is null there, for the runner to refuse."""
    value = lambda number: float(number) if math.isfinite(number) else None
    if gives == "pedals":
        answer = {"throttle": value(row[0]), "brake": value(row[1])}
    elif gives == "speed_plan":
        pairs = [(row[index], row[index + 1]) for index in range(0, 2 * PLAN_POINTS, 2)]
        # As in frames, a plan ends where there is neither time nor speed.
        there = itertools.takewhile(lambda pair: pair[0] == pair[0] or pair[1] == pair[1], pairs)
        answer = {gives: [[value(time), value(speed)] for time, speed in there]}
    else:
        answer = {gives: value(row[0])}
    width = WIDTH[gives]
    if row[width] >= 0:
        answer["mode"] = modes[int(row[width])]
    if len(row) > width + 1 and row[-1] == row[-1]:
        answer["curvature"] = value(row[-1])
    return answer
