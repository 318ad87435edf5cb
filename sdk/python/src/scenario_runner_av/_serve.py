"""The conversation with the runner, in both encodings."""

import json
import struct
import sys

from . import _streams
from ._controller import check
from ._declare import declaration
from ._hosts import Refused, host_of, json_answer, message_of
from ._parameter import parameters_of
from ._seen import CROSSING_COLUMNS, CURVATURE_COLUMNS, NAN, PEDESTRIAN_COLUMNS, RUN_COLUMNS, VEHICLE_COLUMNS, rows_of

PROTOCOL = 1
ENCODINGS = ("f64", "json")
_COLUMNS = (
    ("runs", RUN_COLUMNS),
    ("pedestrians", PEDESTRIAN_COLUMNS),
    ("vehicles", VEHICLE_COLUMNS),
    ("curvature_ahead", CURVATURE_COLUMNS),
    ("crossings", CROSSING_COLUMNS),
)
_WORD = struct.Struct("<I")
_COUNTS = struct.Struct("<6I")
_ANSWER = struct.Struct("<4I")


def serve(controller, *, encoding="f64", runs_at_once=None):
    """Answers the runner until it says goodbye; with `--declare` on the command line, prints what a scenario file says of the class.

    `--encoding=json` and `--runs-at-once=1` on the command line go before what is given here.
    """
    check(controller)
    for argument in sys.argv[1:]:
        option, _, value = argument.partition("=")
        if argument == "--declare":
            print(declaration(controller))
            return
        if option == "--encoding":
            encoding = value
        elif option == "--runs-at-once":
            runs_at_once = int(value)
    requests, answers = _streams.take()
    converse(controller, requests, answers, encoding, runs_at_once)


def converse(controller, requests, answers, encoding="f64", runs_at_once=None, *, make=None, is_parent=False):
    """Answers the requests of one binary stream on another. `make` makes what decides, `is_parent` says that the runner cannot start it anew."""
    if encoding not in ENCODINGS:
        raise ValueError(f"there is no encoding {encoding!r}; there are {', '.join(ENCODINGS)}")
    line = requests.readline()
    if not line:
        return
    greeting = json.loads(line)["hello"]
    runs_at_once = runs_at_once or controller.runs_at_once
    steers = "lateral_offset" in greeting.get("columns", {}).get("lanes", [])
    host = host_of(controller, runs_at_once, make or controller, is_parent, steers)
    hello = {
        "protocol": PROTOCOL,
        "name": controller.own_name(),
        "version": controller.version,
        "encoding": encoding,
        "tables": ["lanes", "kinds", "crossings"],
        "runs_at_once": runs_at_once,
        "gives": [controller.gives],
        "modes": list(controller.modes),
        "parameters": [one.said() for one in parameters_of(controller)],
    }
    hello = {name: value for name, value in hello.items() if value is not None}
    answers.write(json.dumps({"hello": hello}, separators=(",", ":")).encode() + b"\n")
    answers.flush()
    if greeting.get("protocol") != PROTOCOL:
        return
    wire = Frames(host, greeting["columns"]) if encoding == "f64" else Lines(host, controller)
    while True:
        answer = wire.next(requests)
        if answer is None:
            return
        if answer:
            answers.write(answer)
            answers.flush()


class Wire:
    """What both encodings have in common: requests as JSON."""

    def __init__(self, host):
        self.host = host

    def text(self, request):
        """Answers to all but steps; None at the end."""
        if "open" in request:
            ready, failed = [], []
            for run in request["open"]:
                try:
                    self.host.open(run)
                    ready.append(run["slot"])
                except BaseException as error:
                    failed.append({"slot": run["slot"], "message": message_of(error)})
            answer = {"ready": ready}
            if failed:
                answer["failed"] = failed
            return self.said(answer)
        for run in request.get("close", ()):
            try:
                self.host.close(run["slot"], run.get("reason", ""))
            except BaseException as error:
                # Nobody waits for an answer.
                message_of(error)
        return None if "bye" in request else b""

    def refused(self, error):
        """An error of some runs."""
        return self.said({"error": [{"slot": slot, "message": message} for slot, message in error.slots]})


class Lines(Wire):
    """Lines of JSON."""

    def __init__(self, host, controller):
        super().__init__(host)
        self.controller = controller

    def said(self, answer):
        """A text as it is sent."""
        return json.dumps(answer, separators=(",", ":")).encode() + b"\n"

    def next(self, requests):
        """Reads a request and gives the answer; None at the end."""
        line = requests.readline()
        if not line:
            return None
        request = json.loads(line)
        if "step" not in request:
            return self.text(request)
        try:
            rows = self.host.step(*rows_of(request["step"]))
        except Refused as error:
            return self.refused(error)
        gives, modes = self.controller.gives, self.controller.modes
        return self.said({"answer": [json_answer(gives, modes, row) for row in rows]})


class Frames(Wire):
    """Frames of doubles."""

    def __init__(self, host, columns):
        super().__init__(host)
        self.is_vector = hasattr(host, "numpy")
        # What is asked for goes on behind; a runner may be older than that.
        columns = {
            **columns,
            "runs": columns["runs"] + columns.get("lanes", []),
            "pedestrians": columns["pedestrians"] + columns.get("kinds", []),
        }
        self.tables = [Table(columns.get(name, known), known) for name, known in _COLUMNS]

    def said(self, answer):
        """A text as it is sent."""
        text = json.dumps(answer, separators=(",", ":")).encode()
        return _WORD.pack(len(text) + 4) + _WORD.pack(0) + text

    def next(self, requests):
        """Reads a request and gives the answer; None at the end."""
        head = requests.read(4)
        if len(head) < 4:
            return None
        frame = requests.read(_WORD.unpack(head)[0])
        if frame[:4] == b"\0\0\0\0":
            return self.text(json.loads(frame[4:]))
        _, *counts = _COUNTS.unpack_from(frame)
        offset, tables = 28, []
        for table, rows in zip(self.tables, counts):
            part = memoryview(frame)[offset : offset + rows * table.bytes]
            tables.append(table.array(self.host.numpy, part) if self.is_vector else table.rows(part))
            offset += rows * table.bytes
        try:
            rows = self.host.step(*tables)
        except Refused as error:
            return self.refused(error)
        width = len(rows[0])
        if self.is_vector:
            doubles = rows.astype("<f8").tobytes()
        else:
            doubles = struct.pack(f"<{len(rows) * width}d", *(value for row in rows for value in row))
        return _ANSWER.pack(12 + len(doubles), 2, len(rows), width) + doubles


class Table:
    """Rows of doubles, whatever columns the runner has besides those that are known here."""

    def __init__(self, columns, known):
        self.bytes = 8 * len(columns)
        self.row = struct.Struct(f"<{len(columns)}d")
        places = [columns.index(name) if name in columns else None for name in known]
        self.places = None if places == list(range(len(columns))) else places

    def rows(self, part):
        """As tuples of the columns that are known."""
        rows = self.row.iter_unpack(part)
        if self.places is None:
            return list(rows)
        return [tuple(NAN if place is None else row[place] for place in self.places) for row in rows]

    def array(self, numpy, part):
        """As an array of them."""
        rows = numpy.frombuffer(part, dtype="<f8").reshape(-1, self.bytes // 8)
        if self.places is None:
            return rows
        missing = numpy.full(len(rows), NAN)
        return numpy.stack([missing if place is None else rows[:, place] for place in self.places], axis=1)
