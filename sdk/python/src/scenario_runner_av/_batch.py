"""The scenes of many runs as arrays of numpy."""

import numpy

from ._seen import CROSSING_COLUMNS, CURVATURE_COLUMNS, PEDESTRIAN_COLUMNS, RUN_COLUMNS, VEHICLE_COLUMNS


def _attributes(own, columns, rows, kinds):
    rows = numpy.asarray(rows, dtype=float).reshape(-1, len(columns))
    for index, name in enumerate(columns):
        column = rows[:, index]
        kind = kinds.get(name)
        setattr(own, name, column if kind is None else column.astype(kind))


class Batch:
    """Columns of runs, an element a run: `slot`, `time`, `new`, `speed`, …, as in `Seen`. `signal` is 1, 0 or NaN (there is none).

    `mode` holds -1 and takes indices of `modes`. `steering` holds NaN and takes the curvature of the way that the rear axle is to take, to the
    left, 1/m.
    """

    def __init__(self, runs, pedestrians, vehicles, changes=(), crossings=()):
        _attributes(self, RUN_COLUMNS, runs, {"slot": numpy.intp, "new": bool, "pedestrian_priority": bool})
        self.mode = numpy.full(len(self.slot), -1.0)
        self.steering = numpy.full(len(self.slot), numpy.nan)
        self.pedestrians = Others(PEDESTRIAN_COLUMNS, pedestrians, len(self))
        self.vehicles = Others(VEHICLE_COLUMNS, vehicles, len(self))
        self.curvature_ahead = Others(CURVATURE_COLUMNS, changes, len(self))
        self.crossings = Others(CROSSING_COLUMNS, crossings, len(self))

    def __len__(self):
        return len(self.slot)


class Others:
    """Columns of pedestrians, vehicles, changes of curvature or crossings of all runs, `row` being the place of each one's run in the batch."""

    def __init__(self, columns, rows, runs):
        _attributes(self, columns, rows, {"row": numpy.intp, "id": numpy.int64})
        self._runs = runs

    def __len__(self):
        return len(self.row)

    def any(self, which):
        """For each run, whether one of its own is among them."""
        found = numpy.zeros(self._runs, dtype=bool)
        found[self.row[which]] = True
        return found

    def least(self, values, otherwise=numpy.inf):
        """For each run, the least of its own values; `otherwise` if it has none."""
        found = numpy.full(self._runs, otherwise, dtype=float)
        numpy.minimum.at(found, self.row, values)
        return found
