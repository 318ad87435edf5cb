//! A checked scenario whose values are all constants as a file that stands alone.
//!
//! What is read back from it is the same scenario to the last bit: numbers are written in whichever unit gives them
//! back exactly with the fewest digits.

mod words;

use std::collections::BTreeSet;
use std::fmt::Write;

use super::check::{DEFAULT_GOAL, Defaults};
use scenario::{
    CrossingKind, DeclaredAppearance, DeclaredPedestrian, DeclaredShape, DeclaredVehicleStart, Dimension,
    Direction, Individuals, PopulationShare, Road, Scenario, Side, Vehicle, VehicleReference,
};
use words::{constant, is_name, model, number_of, quoted, settings};

pub use words::{quantity, write_comparison};

/// The text of a scenario without variations, in the one style. `expect` are criteria in the language's words, which
/// stand in place of the scenario's own; `remarks` are comments above it.
///
/// # Panics
/// If a value depends on a variation.
pub fn write_scenario(scenario: &Scenario, expect: &[String], remarks: &[String]) -> String {
    assert!(scenario.variations.is_empty(), "variations are put in before a scenario is written");
    let mut out = Lines::default();
    for remark in remarks {
        out.line(format!("# {remark}").trim_end());
    }
    let programs = scenario.vehicles.iter().filter_map(|car| car.controller.first.known()?.program.as_ref());
    let files: BTreeSet<&str> = programs.map(|program| program.file.as_str()).collect();
    files.iter().for_each(|file| out.line(&format!("use {}", quoted(file))));
    out.open(&format!("scenario {}", scenario.name));
    if let Some(doc) = &scenario.doc {
        out.line(&quoted(doc));
    }
    if !scenario.tags.is_empty() {
        out.line(&format!("tags {}", scenario.tags.join(", ")));
    }
    road(&scenario.road, &mut out);
    if scenario.step != Defaults::STEP {
        out.line(&format!("step {}", quantity(scenario.step, Dimension::TIME)));
    }
    if scenario.horizon != Defaults::HORIZON {
        out.line(&format!("horizon {}", quantity(scenario.horizon, Dimension::TIME)));
    }
    if scenario.finish != Defaults::FINISH {
        out.line(&format!("finish {}", quantity(scenario.finish, Dimension::LENGTH)));
    }
    if scenario.end_on_collision {
        out.line("end on collision");
    }
    match &scenario.runs {
        Some(runs) => out.line(&format!("runs {} .. {}", runs.least, runs.most)),
        None if scenario.repeat != Defaults::REPEAT => out.line(&format!("repeat {}", scenario.repeat)),
        None => {}
    }
    if let Some(seed) = scenario.seed {
        out.line(&format!("seed {seed}"));
    }
    scenario.vehicles.iter().for_each(|car| vehicle_block(car, &mut out));
    scenario.pedestrians.iter().for_each(|person| pedestrian_block(person, &mut out));
    if !expect.is_empty() {
        out.open("expect");
        expect.iter().for_each(|criterion| out.line(criterion));
        out.close();
    }
    out.close();
    out.text
}

fn road(road: &Road, out: &mut Lines) {
    out.open("road");
    let directions: Vec<_> = road
        .lanes
        .iter()
        .map(|lane| match lane.direction {
            Direction::Forward => "forward",
            Direction::Backward => "backward",
        })
        .collect();
    if directions != ["forward"] {
        out.line(&format!("lanes {}", directions.join(", ")));
    }
    out.line(&format!("lane_width {}", quantity(road.lane_width, Dimension::LENGTH)));
    out.line(&format!("speed_limit {}", quantity(road.speed_limit, Dimension::SPEED)));
    if !road.kerbs {
        out.line("no kerbs");
    }
    let width = quantity(road.crossing.width, Dimension::LENGTH);
    out.line(&match road.crossing.kind {
        CrossingKind::Zebra => format!("crossing zebra {{ width: {width} }}"),
        CrossingKind::Unmarked => format!("crossing unmarked {{ width: {width} }}"),
        CrossingKind::Signalised { cycle, pedestrian_green_from, pedestrian_green } => format!(
            "crossing signalised {{ width: {width}, cycle: {}, pedestrian_green: {}, pedestrian_green_from: {} }}",
            quantity(cycle, Dimension::TIME),
            quantity(pedestrian_green, Dimension::TIME),
            quantity(pedestrian_green_from, Dimension::TIME),
        ),
    });
    for (index, body) in road.boxes.iter().enumerate() {
        let metres = |value| quantity(value, Dimension::LENGTH);
        let name = if body.name.is_empty() { format!("box_{}", index + 1) } else { body.name.clone() };
        out.line(&format!(
            "box {name} {{ along: {}, across: {}, length: {}, width: {} }}",
            metres(body.x),
            metres(body.y),
            metres(body.length),
            metres(body.width),
        ));
    }
    out.close();
}

fn vehicle_block(car: &Vehicle, out: &mut Lines) {
    let length = |expression| constant(expression, Dimension::LENGTH);
    out.open(&format!("vehicle {}", car.name));
    out.line(&format!("controller {}", model(&car.controller)));
    if let Some(chosen) = &car.dynamics {
        out.line(&format!("dynamics {}", model(chosen)));
    }
    if let Some((long, wide)) = &car.size {
        out.line(&format!("size {} x {}", length(long), length(wide)));
    }
    out.line(&format!("speed {}", constant(&car.speed, Dimension::SPEED)));
    if car.lane != 0 {
        out.line(&format!("lane {}", car.lane));
    }
    match &car.start {
        DeclaredVehicleStart::Automatic => {}
        DeclaredVehicleStart::Distance(distance) => {
            out.line(&format!("start {} before crossing", length(distance)));
        }
        DeclaredVehicleStart::TimeToArrival(time) => {
            out.line(&format!("start {} before crossing", constant(time, Dimension::TIME)));
        }
    }
    if let Some(sees) = &car.sees {
        out.line(&format!("sees {{ {} }}", settings(sees)));
    }
    out.close();
}

fn pedestrian_block(person: &DeclaredPedestrian, out: &mut Lines) {
    let length = |expression| constant(expression, Dimension::LENGTH);
    out.open(&format!("pedestrian {}", person.name));
    out.line(&format!("model {}", model(&person.model)));
    if let Some(Individuals { selection, population, .. }) = &person.individuals {
        let population = if is_name(population) { population.clone() } else { quoted(population) };
        out.line(&match selection {
            PopulationShare::All => format!("individuals all of {population}"),
            PopulationShare::Count(count) => format!("individuals {count} of {population}"),
            PopulationShare::Number(number) => format!("individual {number} of {population}"),
        });
    }
    match &person.shape {
        None => {}
        Some(DeclaredShape::Disc { radius }) => out.line(&format!("radius {}", length(radius))),
        Some(DeclaredShape::Rectangle { length: long, width }) => {
            out.line(&format!("size {} x {}", length(long), length(width)));
        }
    }
    if person.side == Side::Far {
        out.line("from far side");
    }
    out.line(&format!("start {} from lane centre", length(&person.start_from_lane_centre)));
    if number_of(&person.along) != 0.0 {
        out.line(&format!("along {}", length(&person.along)));
    }
    if number_of(&person.goal_beyond_kerb) != DEFAULT_GOAL {
        out.line(&format!("goal {} beyond kerb", length(&person.goal_beyond_kerb)));
    }
    match &person.appears {
        DeclaredAppearance::At(time) if number_of(time) == 0.0 => {}
        DeclaredAppearance::At(time) => {
            out.line(&format!("appears at {}", constant(time, Dimension::TIME)));
        }
        DeclaredAppearance::TimeToArrival { vehicle, reference, time } => {
            let part = match reference {
                VehicleReference::Centre => "",
                VehicleReference::Front => ".front",
            };
            let time = constant(time, Dimension::TIME);
            out.line(&format!("appears when time_to_arrival({vehicle}{part}) = {time}"));
        }
    }
    out.close();
}

#[derive(Default)]
struct Lines {
    text: String,
    depth: usize,
}

impl Lines {
    fn line(&mut self, line: &str) {
        writeln!(self.text, "{}{line}", "  ".repeat(self.depth)).expect("writing to a string cannot fail");
    }

    fn open(&mut self, head: &str) {
        self.line(&format!("{head} {{"));
        self.depth += 1;
    }

    fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }
}
