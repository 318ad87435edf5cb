"""What a controller is told: the scene of a decision and the run that begins, in SI units."""

from typing import Any, Dict, List, NamedTuple, Optional

NAN = float("nan")


PEDESTRIAN, CYCLIST, ESCOOTER = 1.0, 2.0, 3.0


class Pedestrian(NamedTuple):
    """Somebody on foot, or who rides. x is ahead of the ego's centre, y to the left of the middle of its lane; velocities are over ground."""

    row: int
    id: int
    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    length: float
    width: float
    kind: float = PEDESTRIAN
    """`PEDESTRIAN`, `CYCLIST` or `ESCOOTER`."""


class Vehicle(NamedTuple):
    """Another vehicle, in the same frame."""

    row: int
    id: int
    x: float
    y: float
    vx: float
    vy: float
    length: float
    width: float


class CurvatureChange(NamedTuple):
    """A place at which the curvature of the ego's lane changes."""

    row: int
    distance: float
    """Ahead of the point of the ego that follows its lane, m."""
    curvature: float
    """There, to the left, 1/m. It changes evenly from one to the next; two at one distance are a jump."""


class SeenCrossing(NamedTuple):
    """A crossing of the road."""

    row: int
    distance: float
    """From the ego's centre to its middle, m; negative behind it."""
    width: float
    pedestrian_priority: bool
    right_edge: float
    """y of where people wait on the right, beyond a kerb or on a refuge."""
    left_edge: float


class Seen(NamedTuple):
    """The scene of one decision. What is not there is NaN."""

    slot: int
    time: float
    """s; negative while the vehicle drives freely before the run begins."""
    new: bool
    """Whether this is the run's first decision."""
    cruise_speed: float
    distance_to_crossing: float
    """From the ego's centre to the middle of the crossing, m; negative behind it."""
    speed: float
    acceleration: float
    length: float
    width: float
    lane_width: float
    speed_limit: float
    crossing_width: float
    pedestrian_priority: bool
    signal: Optional[bool]
    """Whether vehicles have green, neither red nor amber; None where there is no signal."""
    right_kerb: float
    left_kerb: float
    travelled: float
    """Along the lane, 0 at the middle of the crossing, m."""
    curvature: float
    """Of the lane at the ego, to the left, 1/m."""
    gradient: float
    """Rise of the road per metre ahead; NaN where it says none."""
    amber: float
    """1 while vehicles have amber, 0 while they have green or red; NaN where there is no signal."""
    stop_line: float
    """From the near edge of the crossing back to the line at which vehicles stop, m; NaN where there is no signal."""
    lateral_offset: float
    """From the middle of its lane to the ego, to the left, m; 0 where nobody has steered."""
    heading_error: float
    """From the direction of its lane to that of the ego, to the left, rad."""
    pedestrians: List[Pedestrian]
    vehicles: List[Vehicle]
    curvature_ahead: List[CurvatureChange] = []
    """How the lane bends within 150 m, nearest first; empty where its curvature does not change."""
    crossings: List[SeenCrossing] = []
    """Every crossing in the order in which the ego comes to them; empty where the runner is older than this."""


class Lane(NamedTuple):
    """A lane: y of its middle, and 1 if it is driven in the ego's direction, else -1."""

    y: float
    direction: int


class Box(NamedTuple):
    """Something that hides and blocks, such as a parked car."""

    x: float
    y: float
    length: float
    width: float


class Road(NamedTuple):
    """The street. x is along the ego's lane from the middle of the crossing, y to the left of the lane's middle."""

    lane_width: float
    speed_limit: float
    lanes: List[Lane]
    crossing: str
    """`zebra`, `unmarked` or `signalised`."""
    crossing_width: float
    right_kerb: float
    left_kerb: float
    boxes: List[Box]


class Run(NamedTuple):
    """A run that begins."""

    slot: int
    seed: int
    """For whoever draws numbers; it tells nothing of which run it is."""
    step: float
    """Of the simulation, s."""
    cruise_speed: float
    length: float
    """Of the ego."""
    width: float
    road: Road
    parameters: Dict[str, Any]
    message: Dict[str, Any]
    """All that the runner said, as it said it."""


def run_of(message):
    """An opened run, of its JSON."""
    road, vehicle = message.get("road", {}), message.get("vehicle", {})
    crossing, kerbs = road.get("crossing", {}), road.get("kerbs", {})
    number = lambda of, name: of.get(name, NAN)
    return Run(
        slot=message["slot"],
        seed=message.get("seed", 0),
        step=number(message, "step"),
        cruise_speed=number(message, "cruise_speed"),
        length=number(vehicle, "length"),
        width=number(vehicle, "width"),
        road=Road(
            lane_width=number(road, "lane_width"),
            speed_limit=number(road, "speed_limit"),
            lanes=[Lane(lane["y"], lane["direction"]) for lane in road.get("lanes", [])],
            crossing=crossing.get("kind", ""),
            crossing_width=number(crossing, "width"),
            right_kerb=number(kerbs, "right"),
            left_kerb=number(kerbs, "left"),
            boxes=[Box(*(box[name] for name in Box._fields)) for box in road.get("boxes", [])],
        ),
        parameters=message.get("parameters", {}),
        message=message,
    )


RUN_COLUMNS = Seen._fields[:-4]
PEDESTRIAN_COLUMNS = Pedestrian._fields
VEHICLE_COLUMNS = Vehicle._fields
CURVATURE_COLUMNS = CurvatureChange._fields
CROSSING_COLUMNS = SeenCrossing._fields

_EGO = ("distance_to_crossing", "speed", "acceleration", "length", "width", "travelled", "curvature",
        "lateral_offset", "heading_error")
# What JSON leaves out where it is nothing.
_LEFT_OUT = {"curvature": 0.0, "lateral_offset": 0.0, "heading_error": 0.0}
_VALUE = {True: 1.0, False: 0.0, None: NAN}
# Who is on foot says nothing of it.
_KINDS = {None: PEDESTRIAN, "cyclist": CYCLIST, "escooter": ESCOOTER}


def rows_of(scenes):
    """Rows of runs, pedestrians, vehicles, changes of curvature and crossings of a request in JSON, as they would come in frames."""
    runs, pedestrians, vehicles, changes, crossings = [], [], [], [], []
    for row, scene in enumerate(scenes):
        ego, road = scene.get("ego", {}), scene.get("road", {})
        values = []
        for name in RUN_COLUMNS:
            of = ego if name in _EGO else scene if name in ("slot", "time", "new", "cruise_speed") else road
            value = of.get(name, _LEFT_OUT.get(name))
            values.append(_VALUE[value] if value is None or isinstance(value, bool) else value)
        runs.append(values)
        for one in scene.get("pedestrians", ()):
            one = {**one, "kind": _KINDS.get(one.get("kind"), NAN)}
            pedestrians.append([row] + [one.get(name, NAN) for name in PEDESTRIAN_COLUMNS[1:]])
        for one in scene.get("vehicles", ()):
            vehicles.append([row] + [one.get(name, NAN) for name in VEHICLE_COLUMNS[1:]])
        for distance, curvature in road.get("curvature_ahead", ()):
            changes.append([row, distance, curvature])
        # One at which people wait beyond the kerbs is what the road's other fields say.
        only = {"distance": ego.get("distance_to_crossing"), "width": road.get("crossing_width"),
                "pedestrian_priority": road.get("pedestrian_priority"),
                "right_edge": road.get("right_kerb"), "left_edge": road.get("left_kerb")}
        for one in road.get("crossings", [only]):
            values = [one.get(name) for name in CROSSING_COLUMNS[1:]]
            crossings.append([row] + [_VALUE[value] if value is None or isinstance(value, bool) else value for value in values])
    return runs, pedestrians, vehicles, changes, crossings


def scenes_of(runs, pedestrians, vehicles, changes=(), crossings=()):
    """The scene of each run, of rows of numbers."""
    people = [[] for _ in runs]
    for values in pedestrians:
        row = int(values[0])
        kind = values[10] if values[10] == values[10] else PEDESTRIAN
        people[row].append(Pedestrian(row, int(values[1]), *values[2:10], kind))
    cars = [[] for _ in runs]
    for values in vehicles:
        row = int(values[0])
        cars[row].append(Vehicle(row, int(values[1]), *values[2:]))
    bends = [[] for _ in runs]
    for values in changes:
        row = int(values[0])
        bends[row].append(CurvatureChange(row, *values[1:]))
    places = [[] for _ in runs]
    for values in crossings:
        row = int(values[0])
        places[row].append(SeenCrossing(row, values[1], values[2], values[3] == 1.0, *values[4:]))
    return [_scene(values, people[row], cars[row], bends[row], places[row]) for row, values in enumerate(runs)]


def _scene(values, pedestrians, vehicles, changes, crossings):
    signal = values[13]
    return Seen(
        int(values[0]),
        values[1],
        values[2] == 1.0,
        *values[3:12],
        values[12] == 1.0,
        None if signal != signal else signal == 1.0,
        *values[14:23],
        pedestrians,
        vehicles,
        changes,
        crossings,
    )
