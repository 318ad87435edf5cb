//! A time to arrival must not be past when a pedestrian begins to wait for it: it would appear or go at once, at another time than the file
//! says.

use rayon::prelude::*;

use super::error::PlanError;
use scenario::{
    Case, DeclaredAppearance, DeclaredMayGo, DeclaredVehicleStart, Dimension, Notation, Origin, Scenario,
    World, show_apart, significant,
};
use sim::{PastArrival, beginning, past_arrival};

/// Leaves room for rounding in a time to arrival, s.
const ROUNDING: f64 = 1e-6;

/// So many runs of a scenario that draws are looked at, at most.
const MOST_COUNTED: usize = 100_000;

/// Whether every time to arrival that a pedestrian of the world waits for is still to come, as `scenario` was resolved to it.
///
/// # Errors
/// The first that is past.
pub fn check_arrivals(scenario: &Scenario, world: &World) -> Result<(), PlanError> {
    let Some(past) = first_past(scenario, world) else { return Ok(()) };
    let (origin, unit) = written(scenario, world, &past);
    let (message, hint) = past_arrival_words(world, &past, unit);
    Err(PlanError::new(origin, message).with_hint(hint))
}

/// What is wrong with a pedestrian's time to arrival, and what to do about it.
pub fn past_arrival_words(world: &World, past: &PastArrival, unit: Option<Notation>) -> (String, String) {
    let (person, car) = (&world.pedestrians[past.pedestrian], &world.vehicles[past.vehicle].name);
    let (name, kind) = (&person.name, person.kind.word());
    let ((wanted, left), (does, when)) = (in_words(past, unit), does_when(past));
    let message =
        format!("{kind} `{name}` {does} at a time to arrival of {wanted}, and `{car}` {left} {when}");
    (message, way_out(past, car))
}

/// What the pedestrian does at that time to arrival, and when it begins to wait.
fn does_when(past: &PastArrival) -> (&'static str, &'static str) {
    if past.to_go { ("may go", "when it appears") } else { ("is to appear", "at the start") }
}

fn way_out(past: &PastArrival, car: &str) -> String {
    match past.to_go {
        true => "let it appear earlier, or go at a shorter time to arrival".to_string(),
        false => format!("leave `start` of `{car}` out: it then starts as far away as it has to"),
    }
}

/// The time to arrival that is waited for, and where the vehicle is then.
fn in_words(past: &PastArrival, unit: Option<Notation>) -> (String, String) {
    let PastArrival { wanted, left, .. } = *past;
    let number = |time: f64| (time, Dimension::TIME, unit);
    let mut shown = show_apart(&[number(wanted), number(left)]).into_iter();
    let wanted = shown.next().unwrap_or_default();
    let left = match shown.next() {
        Some(time) if left >= 0.0 => format!("is {time} away"),
        _ => "is past the place".to_string(),
    };
    (wanted, left)
}

fn first_past(scenario: &Scenario, world: &World) -> Option<PastArrival> {
    // Most scenarios leave it to the runner where a vehicle starts.
    if !may_be_past(scenario) {
        return None;
    }
    past_arrival(world, &beginning(world), ROUNDING)
}

/// Whether a pedestrian waits to go for a time to arrival, or to appear for that of a vehicle whose start is said.
fn may_be_past(scenario: &Scenario) -> bool {
    let says_start = |name: &String| {
        scenario.vehicle(name).is_some_and(|car| !matches!(car.start, DeclaredVehicleStart::Automatic))
    };
    scenario.pedestrians.iter().any(|person| {
        let waits_to_appear = match &person.appears {
            DeclaredAppearance::TimeToArrival { vehicle, .. } => says_start(vehicle),
            DeclaredAppearance::At(_) | DeclaredAppearance::Meets { .. } => false,
        };
        waits_to_appear || matches!(person.may_go, DeclaredMayGo::TimeToArrival { .. })
    })
}

/// Where the time to arrival is written, and in which unit.
fn written<'s>(scenario: &'s Scenario, world: &World, past: &PastArrival) -> (&'s Origin, Option<Notation>) {
    let name = &world.pedestrians[past.pedestrian].name;
    let said = if past.to_go { "may_go" } else { "appears" };
    match scenario.written.get(&format!("{name}.{said}")) {
        Some(said) => (&said.origin, said.notation),
        None => (&scenario.pedestrians[past.pedestrian].origin, None),
    }
}

/// The same of all runs that are to be made of a scenario that draws, of which `case` gives each: their seeds are known.
///
/// # Errors
/// In how many runs a time to arrival is past, with the first.
pub fn check_drawn_arrivals(
    scenario: &Scenario,
    runs: usize,
    case: impl Fn(usize) -> Case + Sync,
) -> Result<(), PlanError> {
    if !scenario.is_drawn() || !may_be_past(scenario) {
        return Ok(());
    }
    let looked_at = runs.min(MOST_COUNTED);
    let past = |run: usize| {
        let case = case(run);
        // What is not possible for another reason is said when it is to be run.
        let found = first_past(scenario, &case.world).filter(|_| case.impossible.is_none())?;
        Some((case, found))
    };
    let found: Vec<usize> = (0..looked_at).into_par_iter().filter(|run| past(*run).is_some()).collect();
    let Some((case, first)) = found.first().and_then(|run| past(*run)) else { return Ok(()) };
    let (origin, unit) = written(scenario, &case.world, &first);
    let (person, car) = (&case.world.pedestrians[first.pedestrian], &case.world.vehicles[first.vehicle].name);
    let (name, kind, (wanted, left)) = (&person.name, person.kind.word(), in_words(&first, unit));
    let share = significant(100.0 * found.len() as f64 / looked_at as f64, 2);
    let all = if looked_at < runs { format!("first {looked_at}") } else { format!("{looked_at}") };
    let (does, when) = does_when(&first);
    let message = format!(
        "in {} of the {all} runs to be made ({share} %) {kind} `{name}` {does} at a time to arrival that is past {when}: in the first of them \
         at {wanted}, and `{car}` {left}",
        found.len(),
    );
    let mut hint = way_out(&first, car);
    if !first.to_go {
        hint += "; or cut what is drawn where that begins: `truncated_normal(mean, standard deviation, low, high)`";
    }
    Err(PlanError::new(origin, message).with_hint(hint).in_case(&case.key))
}
