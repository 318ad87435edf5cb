//! The course of a run as CSV: one row per road user and step, SI units.

use std::io::{self, Write};

use files::escape::csv_cell;
use scenario::World;
use sim::{Trace, TraceMark};

/// Writes a row per sample with the columns of the first line; numbers round-trip exactly. `event` says in which row
/// somebody `appears`, `jumps` or `touches NAME`; several are separated by `; `.
pub fn write_trace(world: &World, trace: &Trace, out: impl Write) -> io::Result<()> {
    let names: Vec<String> = world
        .vehicles
        .iter()
        .map(|vehicle| csv_cell(&vehicle.name))
        .chain(world.pedestrians.iter().map(|pedestrian| csv_cell(&pedestrian.name)))
        .collect();
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record([
        "time_s",
        "who",
        "x_m",
        "y_m",
        "vx_m_s",
        "vy_m_s",
        "acceleration_m_s2",
        "mode",
        "event",
    ])?;
    let mut marks = trace.marks.iter().peekable();
    for (index, sample) in trace.samples.iter().enumerate() {
        let mut events = Vec::new();
        while let Some((_, mark)) = marks.next_if(|(of, _)| *of == index) {
            events.push(match mark {
                TraceMark::Appears => "appears".to_string(),
                TraceMark::Jumps => "jumps".to_string(),
                TraceMark::Touches(solid) => format!("touches {}", solid.name(world)),
            });
        }
        writer.write_record([
            sample.time.to_string().as_str(),
            &names[sample.who],
            &sample.position.x.to_string(),
            &sample.position.y.to_string(),
            &sample.velocity.x.to_string(),
            &sample.velocity.y.to_string(),
            &sample.acceleration.to_string(),
            &csv_cell(&sample.mode),
            &csv_cell(&events.join("; ")),
        ])?;
    }
    writer.flush()
}
