//! What may stand in the settings of a road's statements: crossings, boxes, turns.

use scenario::limits::{self, Limit};
use scenario::{Declaration, Dimension, Parameter, STOP_LINE};

const LANGUAGE: &str = "the scenario language";

fn width() -> Parameter {
    Parameter::number(
        "width",
        Dimension::LENGTH,
        4.0,
        (0.5, 50.0),
        "Extent of the crossing along the road.",
        LANGUAGE,
    )
}

fn at() -> Parameter {
    let doc = "Its middle: on a `path` from its beginning; of another crossing than the first of a straight road, from the middle of that.";
    // Which of the two it is, and so its range, is known where the road is.
    let range = (limits::CROSSING_PLACE.range.0, limits::STATION.range.1);
    Parameter::optional("at", Dimension::LENGTH, range, doc, LANGUAGE)
}

pub fn zebra() -> Declaration {
    Declaration::new("crossing zebra", "A crossing at which pedestrians have priority.")
        .source(LANGUAGE)
        .parameters([width(), at()])
}

pub fn unmarked() -> Declaration {
    Declaration::new("crossing unmarked", "A place to cross at which vehicles have priority.")
        .source(LANGUAGE)
        .parameters([width(), at()])
}

pub fn signalised() -> Declaration {
    Declaration::new("crossing signalised", "A crossing with a two-phase signal.")
        .source(LANGUAGE)
        .parameters([
            width(),
            at(),
            Parameter::number(
                "cycle",
                Dimension::TIME,
                60.0,
                limits::CYCLE.range,
                "Time after which the signal repeats.",
                LANGUAGE,
            ),
            Parameter::number(
                "pedestrian_green",
                Dimension::TIME,
                20.0,
                limits::PEDESTRIAN_GREEN.range,
                "How long pedestrians have green in each cycle.",
                LANGUAGE,
            ),
            Parameter::number(
                "pedestrian_green_from",
                Dimension::TIME,
                0.0,
                limits::PEDESTRIAN_GREEN.range,
                "When in the cycle pedestrians get green.",
                LANGUAGE,
            ),
            Parameter::number(
                "amber",
                Dimension::TIME,
                0.0,
                limits::AMBER.range,
                "How long vehicles have amber before their red.",
                "3 s where 50 km/h are allowed: German RiLSA (remembered)",
            ),
            Parameter::number(
                "clearance",
                Dimension::TIME,
                0.0,
                limits::CLEARANCE.range,
                "How long vehicles keep red when pedestrians' green has ended.",
                LANGUAGE,
            ),
            Parameter::number(
                "stop_line",
                Dimension::LENGTH,
                STOP_LINE,
                limits::LINE.range,
                "How far before the edge of the crossing vehicles stop.",
                "MUTCD 2009, 3B.16: at least 4 feet (remembered)",
            ),
        ])
}

/// What of a signal may depend on variations.
pub const OF_SIGNAL: [&str; 6] =
    ["cycle", "pedestrian_green", "pedestrian_green_from", "amber", "clearance", "stop_line"];

/// Every kind of crossing by its word.
pub fn crossings() -> [(&'static str, Declaration); 3] {
    [("zebra", zebra()), ("unmarked", unmarked()), ("signalised", signalised())]
}

const PLACE: (f64, f64) = (-1000.0, 1000.0);
const EXTENT: (f64, f64) = (0.01, 100.0);

pub fn obstacle() -> Declaration {
    let [along, across, length, width] = rectangle();
    Declaration::new("box", "A parked vehicle or another box that blocks the view and the way.")
        .source(LANGUAGE)
        .parameters([along, across, length, width])
}

/// `bus NAME { … }`
pub fn bus() -> Declaration {
    let [along, across, ..] = rectangle();
    let extent = |name, default, doc| {
        let source = "a common length of city buses, and their largest width by Directive 96/53/EC";
        Parameter::number(name, Dimension::LENGTH, default, EXTENT, doc, source)
    };
    Declaration::new("bus", "A bus that stands, which blocks the view and the way.")
        .source(LANGUAGE)
        .parameters([
            along,
            across,
            extent("length", 12.0, "Its extent along the road."),
            extent("width", 2.55, "Its extent across the road."),
        ])
}

/// `parked_row NAME { … }`
pub fn parked_row() -> Declaration {
    let [_, across, length, width] = rectangle();
    let to = "Where the first of them ends along the road, 0 being the middle of the crossing; the others stand before it.";
    Declaration::new("parked_row", "Parked vehicles one behind the other, which block the view and the way.")
        .source(LANGUAGE)
        .parameters([
            Parameter::optional("to", Dimension::LENGTH, PLACE, to, LANGUAGE),
            Parameter::whole("cars", 2, (1, 100), "How many there are.", LANGUAGE),
            Parameter::number("gap", Dimension::LENGTH, 1.0, (0.0, 100.0), "Between two of them.", LANGUAGE),
            across,
            length,
            width,
        ])
}

fn rectangle() -> [Parameter; 4] {
    [
        Parameter::optional(
            "along",
            Dimension::LENGTH,
            PLACE,
            "Its centre along the road; 0 is the middle of the crossing.",
            LANGUAGE,
        ),
        Parameter::optional(
            "across",
            Dimension::LENGTH,
            PLACE,
            "Its centre across the road; 0 is the centre of lane 0, positive towards the far side.",
            LANGUAGE,
        ),
        Parameter::optional("length", Dimension::LENGTH, EXTENT, "Its extent along the road.", LANGUAGE),
        Parameter::optional("width", Dimension::LENGTH, EXTENT, "Its extent across the road.", LANGUAGE),
    ]
}

/// `over main { … }`
pub fn over() -> Declaration {
    let at = "Where their lanes 0 meet: along the other road from the middle of its first crossing, on a `path` from its beginning.";
    let range = (limits::CROSSING_PLACE.range.0, limits::STATION.range.1);
    let meets =
        "How far behind the beginning of its own `path` that is; a road without one is straight and endless.";
    let angle = "From the direction of the other road to its own there, to the left: at 90 deg it comes from the near side.";
    Declaration::new("over", "Where a road lies over another.").source(LANGUAGE).parameters([
        Parameter::optional("at", Dimension::LENGTH, range, at, LANGUAGE),
        Parameter::optional("meets", Dimension::LENGTH, limits::STATION.range, meets, LANGUAGE),
        Parameter::number(
            "angle",
            Dimension::ANGLE,
            std::f64::consts::FRAC_PI_2,
            limits::JUNCTION_ANGLE.range,
            angle,
            LANGUAGE,
        ),
    ])
}

const PROTOCOL: &str = "Euro NCAP's protocol for vulnerable road users";

/// `turn left { … }`
pub fn turn() -> Declaration {
    let parameter =
        |name, limit: Limit, doc| Parameter::optional(name, limit.dimension, limit.range, doc, PROTOCOL);
    Declaration::new("turn", "A clothoid from a radius of 1500 m, an arc and the clothoid back.")
        .source(PROTOCOL)
        .parameters([
            parameter("radius", limits::BEND_RADIUS, "Of the arc, at which each clothoid ends."),
            parameter("clothoid", limits::BEND_ANGLE, "How far each of its clothoids turns."),
            parameter("arc", limits::BEND_ANGLE, "How far its arc turns."),
        ])
}
