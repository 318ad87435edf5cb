//! People in encounters that are far from those in which they were observed.

use std::collections::BTreeMap;

use super::individuals::{file_name, read};
use super::lazily::probe_scenario;
use results::PeopleUsed;
use scenario::Suite;

/// By what share vehicles may be slower or faster than those that people were observed with before that is told.
const FAR: f64 = 1.25;

/// Where people meet vehicles at speeds far from those that people were observed with, by what the provenance of their populations says: a
/// sentence for each population.
fn unobserved(suite: &Suite) -> BTreeMap<String, String> {
    let mut met: BTreeMap<String, ((f64, f64), Vec<f64>)> = BTreeMap::new();
    for scenario in &suite.scenarios {
        let people = scenario.pedestrians.iter().filter_map(|one| Some((one, one.individuals.as_ref()?)));
        let observed: Vec<(String, (f64, f64))> = people
            .filter_map(|(person, individuals)| {
                let speeds = read(person, individuals).ok()?.observed_speeds()?;
                Some((file_name(&individuals.population), speeds))
            })
            .collect();
        if observed.is_empty() {
            continue;
        }
        let trials = probe_scenario(suite, scenario).unwrap_or_default();
        let worlds = trials.iter().flat_map(|trial| trial.cases.worlds());
        let speeds: Vec<f64> =
            worlds.flat_map(|world| world.vehicles.iter().map(|car| car.speed).collect::<Vec<_>>()).collect();
        for (name, range) in observed {
            let far = |speed: &f64| *speed < range.0 / FAR || *speed > range.1 * FAR;
            let known = met.entry(name).or_insert_with(|| (range, Vec::new()));
            known.1.extend(speeds.iter().copied().filter(far));
        }
    }
    met.retain(|_, (_, speeds)| !speeds.is_empty());
    let sentence = |(name, ((low, high), mut speeds)): (String, ((f64, f64), Vec<f64>))| {
        speeds.sort_by(f64::total_cmp);
        let from_to = |low: f64, high: f64| {
            let (low, high) = (scenario::significant(low * 3.6, 3), scenario::significant(high * 3.6, 3));
            if low == high { format!("{low} km/h") } else { format!("{low} to {high} km/h") }
        };
        let said = format!(
            "people of `{name}` were observed before vehicles at {}, and here they meet vehicles at {}: what people do then is not known",
            from_to(low, high),
            from_to(speeds[0], speeds[speeds.len() - 1]),
        );
        (name, said)
    };
    met.into_iter().map(sentence).collect()
}

/// The populations of a suite, of which these are the digests, with what has to be known of their use in it.
pub fn people_used(suite: &Suite, digests: &BTreeMap<String, String>) -> Vec<PeopleUsed> {
    let mut warnings = if digests.is_empty() { BTreeMap::new() } else { unobserved(suite) };
    let one = |(population, digest): (&String, &String)| PeopleUsed {
        population: population.clone(),
        digest: digest.clone(),
        version: scenario::population::shipped_version(population),
        warning: warnings.remove(population),
    };
    digests.iter().map(one).collect()
}
