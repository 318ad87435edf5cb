//! The course of a run as CSV: one row per road user and step, SI units.

use std::io::{self, Write};

use crate::scenario::World;
use crate::sim::Trace;

/// Writes `time,who,x,y,vx,vy,acceleration,mode` rows; numbers round-trip exactly.
pub fn write_trace(world: &World, trace: &Trace, out: impl Write) -> io::Result<()> {
    let names: Vec<&str> = world
        .vehicles
        .iter()
        .map(|vehicle| vehicle.name.as_str())
        .chain(world.pedestrians.iter().map(|pedestrian| pedestrian.name.as_str()))
        .collect();
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(["time_s", "who", "x_m", "y_m", "vx_m_s", "vy_m_s", "acceleration_m_s2", "mode"])?;
    for sample in &trace.samples {
        writer.write_record([
            sample.time.to_string().as_str(),
            names[sample.who],
            &sample.position.x.to_string(),
            &sample.position.y.to_string(),
            &sample.velocity.x.to_string(),
            &sample.velocity.y.to_string(),
            &sample.acceleration.to_string(),
            sample.mode,
        ])?;
    }
    writer.flush()
}
