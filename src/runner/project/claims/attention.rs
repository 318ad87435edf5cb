//! Controllers that are blind to what is in their way: looked at before anything runs.

use super::budget::{add_once, at};
use crate::plan;
use lang::{Code, Diagnostic, Sources};
use scenario::{Attention, ControllerModel, LooksAt, Origin, Scenario, SignalConduct, Suite, World};
use sim::{path_conflicts, vehicles_ahead};

/// A warning for every scenario in which a controller does not look at something that is in its way, and one for all scenarios with vehicles
/// of other roads. A vehicle that `ignores vehicles` is not warned of for vehicles. What cannot be planned is left to planning.
pub(super) fn examine_attention(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let (mut found, mut of_other_roads) = (Vec::<Diagnostic>::new(), Vec::new());
    for scenario in suite.scenarios.iter().filter(|scenario| is_concerned(scenario)) {
        let mut unseen = of_scenario(suite, scenario);
        let from_other_roads = unseen.iter().position(|one| one.is_of_other_road);
        of_other_roads.extend(from_other_roads.map(|index| unseen[index].clone()));
        unseen.retain(|one| !one.is_of_other_road);
        let Some((first, others)) = unseen.split_first() else { continue };
        let finding = others.iter().fold(first.finding(sources), |finding, one| finding.note(&*one.words));
        add_once(&mut found, finding);
    }
    if let Some((first, others)) = of_other_roads.split_first() {
        let finding = first.finding(sources);
        found.push(match others.len() {
            0 => finding,
            1 => finding.note("and so in one more scenario"),
            more => finding.note(format!("and so in {more} more scenarios")),
        });
    }
    found
}

/// Something that a controller does not look at.
#[derive(Debug, Clone, PartialEq)]
struct Unseen {
    /// Whose controller, and at what, in a sentence.
    words: String,
    is_of_other_road: bool,
    is_vehicle: bool,
    vehicle: String,
    origin: Origin,
}

impl Unseen {
    fn finding(&self, sources: &Sources) -> Diagnostic {
        let cure = match self.is_vehicle {
            true => format!(", or say `ignores vehicles` in `vehicle {}` if that is meant", self.vehicle),
            false => String::new(),
        };
        at(Code::BlindController, &self.origin, &*self.words, sources)
            .label("blind to what is in its way")
            .hint(format!("take a controller that looks at it{cure}"))
    }
}

/// Whether anything may be there that a controller is blind to: other vehicles, or people and signals where it declares to be.
fn is_concerned(scenario: &Scenario) -> bool {
    let on_foot = |entry: &ControllerModel| match entry.attention {
        Attention::Reacts(_) => {
            let settings = entry.declaration.resolve(&Default::default());
            let looks_at = settings.ok().and_then(|settings| entry.attention.with(&settings));
            looks_at.is_none_or(|looks| !looks.people_crossing || !looks.people_along)
                || matches!(entry.signals, SignalConduct::Never { .. })
        }
        Attention::Scripted | Attention::Own => false,
    };
    let entries = scenario.vehicles.iter().flat_map(|car| {
        let all = [&car.controller.first].into_iter().chain(&car.controller.varied);
        all.filter_map(|reference| reference.entry())
    });
    scenario.streams().next().is_some()
        || scenario.vehicles.len() > 1
        || entries.into_iter().any(|entry| on_foot(entry))
}

/// What controllers do not look at in a scenario's trials, each thing once.
fn of_scenario(suite: &Suite, scenario: &Scenario) -> Vec<Unseen> {
    let mut found: Vec<Unseen> = Vec::new();
    for trial in plan::probe_scenario(suite, scenario).unwrap_or_default() {
        let Some(case) = trial.cases.iter().next() else { continue };
        for one in of_world(scenario, &case.world) {
            if !found.contains(&one) {
                found.push(one);
            }
        }
    }
    found
}

fn of_world(scenario: &Scenario, world: &World) -> Vec<Unseen> {
    let mut found = Vec::new();
    for (index, car) in world.vehicles.iter().enumerate() {
        let Some(entry) = car.controller.model.entry() else { continue };
        let Some(looks) = entry.attention.with(&car.controller.settings) else { continue };
        let Some(declared) = scenario.vehicle(&car.name) else { continue };
        let mut add = |(is_vehicle, is_of_other_road): (bool, bool), what: String| {
            if !(is_vehicle && declared.ignores_vehicles) {
                found.push(Unseen {
                    words: format!("`{}` of `{}` {what}", entry.declaration.name, declared.name),
                    is_of_other_road,
                    is_vehicle,
                    vehicle: declared.name.clone(),
                    origin: declared.controller.origin.clone(),
                });
            }
        };
        for other in unseen_vehicles(world, index, looks) {
            let (other, is_other) = (&world.vehicles[other], world.vehicles[other].road != car.road);
            let place = if is_other { "on a road that crosses its own" } else { "ahead in its lane" };
            match scenario.vehicle(&other.name).filter(|other| other.name != declared.name) {
                Some(other) => add((true, is_other), format!("does not look at `{}`, {place}", other.name)),
                None => {
                    add((true, is_other), format!("does not look at the vehicles of its stream, {place}"))
                }
            }
        }
        if car.road != 0 {
            continue;
        }
        for person in &world.pedestrians {
            let crosses = person.crosses(&world.road);
            let is_seen = if crosses { looks.people_crossing } else { looks.people_along };
            let beside = world.path_of(car).beside(person.start.into());
            if !is_seen && (crosses || beside.abs() <= world.road.lane_width / 2.0) {
                let way = if crosses { "crosses" } else { "moves along" };
                add((false, false), format!("does not look at `{}`, who {way} its lane", person.name));
            }
        }
        if world.road.has_signal() && matches!(entry.signals, SignalConduct::Never { .. }) {
            add((false, false), "does not look at the signal of the crossing".to_string());
        }
    }
    found
}

/// The vehicles in the way of one that its controller does not look at.
fn unseen_vehicles(world: &World, index: usize, looks: LooksAt) -> Vec<usize> {
    let ahead = if looks.vehicles_ahead { Vec::new() } else { vehicles_ahead(world, index) };
    let is_of_other_road = |other: &usize| {
        world.vehicles[*other].road != world.vehicles[index].road
            && !path_conflicts(world, index, *other).is_empty()
    };
    let of_other_roads = (0..world.vehicles.len()).filter(|_| !looks.other_roads).filter(is_of_other_road);
    ahead.into_iter().chain(of_other_roads).collect()
}
