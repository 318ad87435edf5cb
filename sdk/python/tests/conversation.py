"""A runner's side of a conversation, for tests."""

import io
import json
import struct

from scenario_runner_av._seen import CROSSING_COLUMNS, CURVATURE_COLUMNS, PEDESTRIAN_COLUMNS, RUN_COLUMNS, VEHICLE_COLUMNS
from scenario_runner_av._serve import converse

COLUMNS = {
    "runs": list(RUN_COLUMNS[:16]),
    "lanes": list(RUN_COLUMNS[16:]),
    "pedestrians": list(PEDESTRIAN_COLUMNS[:-1]),
    "kinds": list(PEDESTRIAN_COLUMNS[-1:]),
    "vehicles": list(VEHICLE_COLUMNS),
    "curvature_ahead": list(CURVATURE_COLUMNS),
    "crossings": list(CROSSING_COLUMNS),
}
NAN = float("nan")
KINDS = {None: 1.0, "cyclist": 2.0, "escooter": 3.0}


def run(slot, **parameters):
    """A run that is opened."""
    road = {
        "lane_width": 4.0,
        "speed_limit": 8.0,
        "lanes": [{"y": 0.0, "direction": 1}],
        "crossing": {"kind": "zebra", "width": 4.0, "x": 0.0},
        "kerbs": {"right": -2.0, "left": 2.0},
        "boxes": [{"x": 1.0, "y": 2.0, "length": 3.0, "width": 4.0}],
    }
    vehicle = {"length": 4.5, "width": 1.8}
    return {"slot": slot, "seed": 7, "step": 0.025, "parameters": parameters, "cruise_speed": 8.0, "vehicle": vehicle, "road": road}


def scene(slot, speed=5.0, people=(), time=1.0, signal=None, bends=()):
    """A decision that is asked for; people are pairs of x and y, bends of a distance and a curvature."""
    road = {
        "lane_width": 4.0,
        "speed_limit": 8.0,
        "crossing_width": 4.0,
        "pedestrian_priority": True,
        "right_kerb": -2.0,
        "left_kerb": 2.0,
    }
    if signal is not None:
        road["signal"] = signal
    if bends:
        road["curvature_ahead"] = [list(one) for one in bends]
    ego = {"distance_to_crossing": 30.0, "speed": speed, "acceleration": 0.0, "length": 4.5, "width": 1.8, "travelled": -30.0}
    if bends:
        ego["curvature"] = 0.25
    still = {"vx": 0.0, "vy": 1.0, "ax": 0.0, "ay": 0.0, "length": 0.5, "width": 0.5}
    pedestrians = [{"id": index, "x": x, "y": y, **still} for index, (x, y) in enumerate(people)]
    return {
        "slot": slot,
        "time": time,
        "new": False,
        "cruise_speed": 8.0,
        "ego": ego,
        "road": road,
        "pedestrians": pedestrians,
        "vehicles": [{"id": 0, "x": 9.0, "y": 3.5, "vx": -8.0, "vy": 0.0, "length": 4.5, "width": 1.8}],
    }


def talk(controller, requests, encoding="json", runs_at_once=None, columns=COLUMNS):
    """The hello of a class and its answers to requests in JSON; steps are sent as the encoding says."""
    said = json.dumps({"hello": {"protocol": 1, "columns": columns}}).encode() + b"\n"
    for request in requests:
        said += json.dumps(request).encode() + b"\n" if encoding == "json" else frame(request, columns)
    answers = io.BytesIO()
    converse(controller, io.BytesIO(said), answers, encoding, runs_at_once)
    answers.seek(0)
    hello = json.loads(answers.readline())["hello"]
    return hello, list(lines(answers) if encoding == "json" else frames(answers))


def frame(request, columns):
    """A request as a frame."""
    if "step" not in request:
        text = json.dumps(request).encode()
        return struct.pack("<2I", len(text) + 4, 0) + text
    scenes, rows = request["step"], b""
    columns = {
        **columns,
        "runs": columns["runs"] + columns.get("lanes", []),
        "pedestrians": columns["pedestrians"] + columns.get("kinds", []),
    }
    counts = [0] * 6
    for index, table in enumerate(("runs", "pedestrians", "vehicles", "curvature_ahead", "crossings")):
        if table not in columns:
            continue
        for row, one in enumerate(scenes):
            run_ = {"curvature": 0.0, "lateral_offset": 0.0, "heading_error": 0.0, **one["ego"], **one["road"], **one}
            only = {"distance": run_["distance_to_crossing"], "width": run_["crossing_width"],
                    "pedestrian_priority": run_["pedestrian_priority"],
                    "right_edge": run_["right_kerb"], "left_edge": run_["left_kerb"]}
            told = {
                "runs": [run_],
                "pedestrians": [{**who, "kind": KINDS[who.get("kind")]} for who in one["pedestrians"]],
                "vehicles": one["vehicles"],
                "curvature_ahead": [{"distance": at, "curvature": bend} for at, bend in one["road"].get("curvature_ahead", ())],
                "crossings": one["road"].get("crossings", [only]),
            }
            for of in told[table]:
                values = [float({"row": row, **of}.get(name, NAN)) for name in columns[table]]
                rows += struct.pack(f"<{len(values)}d", *values)
                counts[index] += 1
    return struct.pack("<8I", 28 + len(rows), 1, *counts) + rows


def lines(answers):
    """Answers in JSON."""
    for line in answers:
        yield json.loads(line, parse_constant=lambda word: (_ for _ in ()).throw(ValueError(word)))


def frames(answers):
    """Answers in frames: texts, or rows of doubles."""
    while True:
        head = answers.read(8)
        if not head:
            return
        length, kind = struct.unpack("<2I", head)
        rest = answers.read(length - 4)
        if kind == 0:
            yield json.loads(rest)
        else:
            rows, width = struct.unpack_from("<2I", rest)
            assert len(rest) == 8 + 8 * rows * width
            yield [list(struct.unpack_from(f"<{width}d", rest, 8 + 8 * width * row)) for row in range(rows)]
