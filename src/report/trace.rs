//! The course of a run as CSV: one row per road user and step, SI units.

use std::io::{self, Write};

use files::escape::csv_cell;
use scenario::{Path, World};
use sim::{Sample, Trace, TraceMark};

/// What there is of each sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TraceColumns {
    /// Time, place, velocity, acceleration, mode and events.
    #[default]
    Plain,
    /// With `s_m`, how far along the road somebody is from the middle of the crossing, `d_m`, how far to the left of the centre line of
    /// lane 0, and `heading_rad`, from the x axis to where they face, counter-clockwise.
    Full,
}

/// As [`write_trace_with`], with the plain columns.
pub fn write_trace(world: &World, trace: &Trace, out: impl Write) -> io::Result<()> {
    write_trace_with(world, trace, TraceColumns::Plain, out)
}

/// Writes a row per sample with the columns of the first line; numbers round-trip exactly. `event` says in which row
/// somebody `appears`, `jumps`, `touches NAME`, `comes into the sight of NAME` or `is lost from the sight of NAME`; several are separated by `; `.
pub fn write_trace_with(
    world: &World,
    trace: &Trace,
    columns: TraceColumns,
    out: impl Write,
) -> io::Result<()> {
    let names: Vec<String> = world
        .vehicles
        .iter()
        .map(|vehicle| csv_cell(&vehicle.name))
        .chain(world.pedestrians.iter().map(|pedestrian| csv_cell(&pedestrian.name)))
        .collect();
    let mut writer = csv::Writer::from_writer(out);
    let plain = ["time_s", "who", "x_m", "y_m", "vx_m_s", "vy_m_s", "acceleration_m_s2", "mode", "event"];
    let more: &[&str] = if columns == TraceColumns::Full { &["s_m", "d_m", "heading_rad"] } else { &[] };
    writer.write_record(plain.iter().chain(more))?;
    let mut marks = trace.marks.iter().peekable();
    for (index, sample) in trace.samples.iter().enumerate() {
        let mut events = Vec::new();
        while let Some((_, mark)) = marks.next_if(|(of, _)| *of == index) {
            events.push(match mark {
                TraceMark::Appears => appears(world, sample.who),
                TraceMark::Jumps => "jumps".to_string(),
                TraceMark::Touches(solid) => format!("touches {}", solid.name(world)),
                TraceMark::Seen(car) => format!("comes into the sight of {}", world.vehicles[*car].name),
                TraceMark::Lost(car) => format!("is lost from the sight of {}", world.vehicles[*car].name),
            });
        }
        let mut row = vec![
            sample.time.to_string(),
            names[sample.who].clone(),
            sample.position.x.to_string(),
            sample.position.y.to_string(),
            sample.velocity.x.to_string(),
            sample.velocity.y.to_string(),
            sample.acceleration.to_string(),
            csv_cell(&sample.mode),
            csv_cell(&events.join("; ")),
        ];
        if columns == TraceColumns::Full {
            let (along, left) = on_the_road(world, sample);
            let heading = libm::atan2(sample.heading.y, sample.heading.x);
            row.extend([along, left, heading].map(|number| number.to_string()));
        }
        writer.write_record(row)?;
    }
    writer.flush()
}

/// Who is no vehicle and not on foot appears as what they are.
fn appears(world: &World, who: usize) -> String {
    let person = who.checked_sub(world.vehicles.len()).and_then(|index| world.pedestrians.get(index));
    match person.filter(|person| !person.kind.is_pedestrian()) {
        Some(person) => format!("appears as {}", person.kind.word()),
        None => "appears".to_string(),
    }
}

/// How far along the road somebody is from the middle of the crossing, and how far to the left of the centre line of lane 0, m. Where the
/// road comes near itself, a vehicle is on the part that it drives.
fn on_the_road(world: &World, sample: &Sample) -> (f64, f64) {
    /// A vehicle is no farther than this from where its way says that it is, m.
    const NEAR: f64 = 5.0;
    let Some(bend) = &world.road.bend else { return (sample.position.x, sample.position.y) };
    let found = bend.line.project(sample.position);
    let lane = world.vehicles.get(sample.who).filter(|car| car.road == 0).map(|car| world.path_of(car));
    if let (Some(course), Some(place)) = (lane.as_ref().and_then(Path::course), sample.travelled) {
        let station = course.station(place);
        if (station - found.station).abs() > NEAR {
            return (station - bend.crossing, course.offset());
        }
    }
    (found.station - bend.crossing, found.left)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use nalgebra::Vector2;
    use scenario::geometry::{Piece, Pose, ReferenceLine};
    use scenario::{Bend, Direction, Lane};
    use sim::Mode;

    /// A car in lane 1 of two of a bend, and somebody on the crossing, 1 m to the left of the line.
    fn recorded() -> (World, Trace) {
        let mut world = sim::fixture::world();
        world.road.lanes.push(Lane { direction: Direction::Backward });
        world.vehicles[0].lane = 1;
        let line = ReferenceLine::new(Pose::origin(), &[Piece::line(20.0), Piece::arc(15.0, 2.0)]).unwrap();
        world.road.bend = Some(Bend { line: Arc::new(line), crossing: 30.0 });
        let path = world.road.path(1);
        let (position, heading) = path.pose(-4.0);
        let crossing = world.road.bend.as_ref().unwrap().line.pose(30.0);
        let sample = |who, position, heading, travelled| Sample {
            time: 0.0,
            who,
            position,
            heading,
            travelled,
            velocity: Vector2::zeros(),
            acceleration: 0.0,
            mode: Mode::NONE,
        };
        let mut trace = Trace::default();
        trace.samples.push(sample(0, position, heading, Some(-4.0)));
        trace.samples.push(sample(1, crossing.point + crossing.normal(), crossing.normal(), None));
        (world, trace)
    }

    fn rows(columns: TraceColumns) -> Vec<Vec<String>> {
        let (world, trace) = recorded();
        let mut out = Vec::new();
        write_trace_with(&world, &trace, columns, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        text.lines().map(|line| line.split(',').map(str::to_string).collect()).collect()
    }

    #[test]
    fn full_columns_say_where_on_the_road_everybody_is() {
        let (plain, full) = (rows(TraceColumns::Plain), rows(TraceColumns::Full));
        assert_eq!(full[0][9..], ["s_m", "d_m", "heading_rad"]);
        for (plain, full) in plain.iter().zip(&full) {
            assert_eq!(plain[..], full[..9], "the others stay as they are");
        }
        let number = |row: usize, column: usize| full[row][column].parse::<f64>().unwrap();
        // Backwards on the inner lane, 4 m to the left of the line: 4 m of 11 m radius are 4·15/11 m of the line.
        assert!((number(1, 9) - 4.0 * 15.0 / 11.0).abs() < 1e-9, "{}", number(1, 9));
        assert!((number(1, 10) - 4.0).abs() < 1e-9);
        let turned = (10.0 + 4.0 * 15.0 / 11.0) / 15.0;
        let heading = number(1, 11) - (turned - std::f64::consts::PI);
        assert!(heading.abs() < 1e-9, "{heading}");
        assert!(number(2, 9).abs() < 1e-9 && (number(2, 10) - 1.0).abs() < 1e-9);
        assert!((number(2, 11) - (10.0 / 15.0 + std::f64::consts::FRAC_PI_2)).abs() < 1e-9);
    }

    #[test]
    fn who_rides_appears_as_what_they_are() {
        let (mut world, mut trace) = recorded();
        trace.marks.push((1, TraceMark::Appears));
        let appears = |world: &World| {
            let mut out = Vec::new();
            write_trace_with(world, &trace, TraceColumns::Plain, &mut out).unwrap();
            String::from_utf8(out).unwrap().lines().nth(2).unwrap().rsplit(',').next().unwrap().to_string()
        };
        assert_eq!(appears(&world), "appears");
        world.pedestrians[0].kind = scenario::RoadUserKind::Cyclist;
        assert_eq!(appears(&world), "appears as cyclist");
    }
}
