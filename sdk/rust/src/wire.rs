//! Frames of doubles.

use std::io::{self, ErrorKind, Read};

use serde_json::Value;

use crate::{About, Answer, Command, Gives, Kind, Other, Seen, SeenCrossing, PLAN_POINTS};

const RUNS: [&str; 23] = [
    "slot",
    "time",
    "new",
    "cruise_speed",
    "distance_to_crossing",
    "speed",
    "acceleration",
    "length",
    "width",
    "lane_width",
    "speed_limit",
    "crossing_width",
    "pedestrian_priority",
    "signal",
    "right_kerb",
    "left_kerb",
    "travelled",
    "curvature",
    "gradient",
    "amber",
    "stop_line",
    "lateral_offset",
    "heading_error",
];
const CURVATURE_AHEAD: [&str; 3] = ["row", "distance", "curvature"];
const OTHERS: [&str; 11] = ["row", "id", "x", "y", "vx", "vy", "ax", "ay", "length", "width", "kind"];
const CROSSINGS: [&str; 6] = ["row", "distance", "width", "pedestrian_priority", "right_edge", "left_edge"];

/// The next frame without its length; whether there is one.
pub fn read(from: &mut impl Read, frame: &mut Vec<u8>) -> io::Result<bool> {
    let mut length = [0; 4];
    match from.read_exact(&mut length) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(false),
        other => other?,
    }
    frame.resize(u32::from_le_bytes(length) as usize, 0);
    from.read_exact(frame)?;
    Ok(true)
}

/// A word of a frame.
pub fn word(frame: &[u8], index: usize) -> u32 {
    let bytes = frame.get(4 * index..4 * index + 4).unwrap_or(&[0; 4]);
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// Makes a frame of a text.
pub fn text(value: &Value, into: &mut Vec<u8>) {
    let text = value.to_string();
    into.clear();
    into.extend((text.len() as u32 + 4).to_le_bytes());
    into.extend([0; 4]);
    into.extend(text.bytes());
}

/// Makes a frame of answers. Those that steer are one longer than those that do not.
pub fn rows<'a>(rows: impl Iterator<Item = &'a Vec<f64>> + Clone, into: &mut Vec<u8>) {
    into.clear();
    into.extend([0; 16]);
    let (mut count, columns) = (0_u32, rows.clone().map(Vec::len).max().unwrap_or(0));
    for row in rows {
        count += 1;
        let none = std::iter::repeat(&f64::NAN).take(columns - row.len());
        row.iter().chain(none).for_each(|value| into.extend(value.to_le_bytes()));
    }
    let columns = columns as u32;
    for (index, value) in [into.len() as u32 - 4, 2, count, columns].into_iter().enumerate() {
        into[4 * index..4 * index + 4].copy_from_slice(&value.to_le_bytes());
    }
}

/// The row of an answer: its values, then the index of its mode, and its curvature if it has one.
pub fn row(about: &About, answer: &Answer, steers: bool) -> Result<Vec<f64>, String> {
    let mut row = match (&answer.command, about.gives) {
        (Command::Acceleration(value), Gives::Acceleration) | (Command::Speed(value), Gives::Speed) => {
            vec![*value]
        }
        (Command::Pedals { throttle, brake }, Gives::Pedals) => vec![*throttle, *brake],
        (Command::SpeedPlan(points), Gives::SpeedPlan) if points.len() <= PLAN_POINTS => {
            let mut row: Vec<f64> = points.iter().flat_map(|(time, speed)| [*time, *speed]).collect();
            row.resize(2 * PLAN_POINTS, f64::NAN);
            row
        }
        (Command::SpeedPlan(points), Gives::SpeedPlan) => {
            return Err(format!("a plan of {} points; there may be {PLAN_POINTS}", points.len()))
        }
        (command, gives) => return Err(format!("it answered {command:?}, but says that it gives {gives:?}")),
    };
    if answer.mode.is_some_and(|mode| mode >= about.modes.len()) {
        return Err(format!("mode {:?} of {}", answer.mode, about.modes.len()));
    }
    row.push(answer.mode.map_or(-1.0, |mode| mode as f64));
    match answer.curvature {
        None => {}
        Some(curvature) if steers => row.push(curvature),
        Some(_) => return Err("it answered a curvature, and this runner takes none".to_string()),
    }
    Ok(row)
}

/// Where the columns that are known here stand in the runner's rows, whatever else it has.
pub struct Tables {
    runs: Table,
    pedestrians: Table,
    vehicles: Table,
    /// Of no width where the runner does not know it.
    curvature_ahead: Table,
    /// The same.
    crossings: Table,
    /// Whether the runner takes a curvature.
    pub steers: bool,
}

struct Table {
    width: usize,
    places: Vec<Option<usize>>,
}

impl Table {
    fn of(columns: &Value, known: &[&str]) -> Self {
        let said: Vec<&str> = columns.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let places = known.iter().map(|name| said.iter().position(|one| one == name)).collect();
        Self { width: said.len(), places }
    }

    fn row<'f>(&'f self, rows: &'f [u8], index: usize) -> impl Fn(usize) -> f64 + 'f {
        move |column| {
            let Some(place) = self.places[column] else { return f64::NAN };
            let at = 8 * (index * self.width + place);
            let mut bytes = [0; 8];
            bytes.copy_from_slice(&rows[at..at + 8]);
            f64::from_le_bytes(bytes)
        }
    }
}

impl Tables {
    pub fn of(columns: &Value) -> Self {
        // What is asked for goes on behind.
        let both = |tables: [&str; 2]| {
            let all = tables.map(|table| columns[table].as_array().cloned().unwrap_or_default());
            Value::Array(all.concat())
        };
        let steers = columns["lanes"].as_array().into_iter().flatten().any(|name| name == "lateral_offset");
        Self {
            runs: Table::of(&both(["runs", "lanes"]), &RUNS),
            pedestrians: Table::of(&both(["pedestrians", "kinds"]), &OTHERS),
            vehicles: Table::of(&columns["vehicles"], &OTHERS),
            curvature_ahead: Table::of(&columns["curvature_ahead"], &CURVATURE_AHEAD),
            crossings: Table::of(&columns["crossings"], &CROSSINGS),
            steers,
        }
    }

    /// The scenes of a frame of runs.
    pub fn scenes(&self, frame: &[u8]) -> io::Result<Vec<Seen>> {
        let counts = [1, 2, 3, 4, 5].map(|index| word(frame, index) as usize);
        let sizes = [&self.runs, &self.pedestrians, &self.vehicles, &self.curvature_ahead, &self.crossings];
        let sizes: Vec<usize> =
            sizes.iter().zip(counts).map(|(table, count)| 8 * table.width * count).collect();
        if frame.len() != 28 + sizes.iter().sum::<usize>() {
            return Err(io::Error::new(ErrorKind::InvalidData, "a frame is not as long as it says"));
        }
        let (runs, others) = frame[28..].split_at(sizes[0]);
        let (pedestrians, others) = others.split_at(sizes[1]);
        let (vehicles, others) = others.split_at(sizes[2]);
        let (changes, crossings) = others.split_at(sizes[3]);
        let mut scenes: Vec<Seen> = (0..counts[0]).map(|index| scene(self.runs.row(runs, index))).collect();
        for index in 0..counts[1] {
            let (row, one) = other(self.pedestrians.row(pedestrians, index), Kind::Pedestrian);
            scenes[row].pedestrians.push(one);
        }
        for index in 0..counts[2] {
            let (row, one) = other(self.vehicles.row(vehicles, index), Kind::Vehicle);
            scenes[row].vehicles.push(one);
        }
        let told = if changes.is_empty() { 0 } else { counts[3] };
        for index in 0..told {
            let value = self.curvature_ahead.row(changes, index);
            scenes[value(0) as usize].curvature_ahead.push((value(1), value(2)));
        }
        let told = if crossings.is_empty() { 0 } else { counts[4] };
        for index in 0..told {
            let value = self.crossings.row(crossings, index);
            scenes[value(0) as usize].crossings.push(SeenCrossing {
                distance: value(1),
                width: value(2),
                pedestrian_priority: value(3) == 1.0,
                right_edge: value(4),
                left_edge: value(5),
            });
        }
        Ok(scenes)
    }
}

fn scene(value: impl Fn(usize) -> f64) -> Seen {
    Seen {
        slot: value(0) as usize,
        time: value(1),
        is_new: value(2) == 1.0,
        cruise_speed: value(3),
        distance_to_crossing: value(4),
        speed: value(5),
        acceleration: value(6),
        length: value(7),
        width: value(8),
        lane_width: value(9),
        speed_limit: value(10),
        crossing_width: value(11),
        pedestrian_priority: value(12) == 1.0,
        signal: (!value(13).is_nan()).then(|| value(13) == 1.0),
        right_kerb: value(14),
        left_kerb: value(15),
        travelled: value(16),
        curvature: value(17),
        gradient: value(18),
        amber: value(19) == 1.0,
        stop_line: value(20),
        lateral_offset: value(21),
        heading_error: value(22),
        curvature_ahead: Vec::new(),
        crossings: Vec::new(),
        pedestrians: Vec::new(),
        vehicles: Vec::new(),
    }
}

/// Its run's place in the frame, and what it is.
fn other(value: impl Fn(usize) -> f64, otherwise: Kind) -> (usize, Other) {
    let one = Other {
        id: value(1) as u64,
        x: value(2),
        y: value(3),
        vx: value(4),
        vy: value(5),
        ax: value(6),
        ay: value(7),
        length: value(8),
        width: value(9),
        kind: match value(10) {
            2.0 => Kind::Cyclist,
            3.0 => Kind::Escooter,
            _ => otherwise,
        },
    };
    (value(0) as usize, one)
}
