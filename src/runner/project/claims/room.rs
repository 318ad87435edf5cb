//! People who begin their way where waiting is not an option for their model: looked at before anything runs.

use super::budget::at;
use crate::experiment::search_ends;
use crate::plan::{self, metres, too_near_words};
use lang::{Code, Diagnostic, Severity, Sources};
use scenario::{Case, DeclaredPedestrian, Origin, PedestrianSetup, Scenario, Suite, significant};
use sim::{TooNear, too_near};

/// So many drawn runs of a scenario are looked at, at most.
const MOST_DRAWN: usize = 400;

/// What is looked at of a scenario that draws nothing: all of it.
const TRIALS: &str = "trials";

/// An error for every place from which a pedestrian sets out in all of its runs, or in all that a search can try, so near to a lane that its
/// model cannot wait there, and a warning where that is so in some. People who `may start inside` are left to reports, and what cannot be
/// planned is left to planning.
pub(super) fn examine_room(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for scenario in suite.scenarios.iter().filter(|scenario| may_need_room(scenario)) {
        let runs = plan::sample_scenario(suite, scenario, MOST_DRAWN).unwrap_or_default();
        let all = if scenario.is_drawn() { "runs looked at" } else { TRIALS };
        let places = Places { all, search: None };
        let declared = places.examine(scenario, &runs, sources);
        let is_known = declared.iter().any(|found| found.severity == Severity::Error);
        found.extend(declared);
        for search in suite.searches.iter().filter(|search| search.scenario == scenario.name && !is_known) {
            let places = Places { all: "ends of its ranges", search: Some((&search.name, &search.origin)) };
            found.extend(places.examine(scenario, &search_ends(suite, search), sources));
        }
    }
    found
}

fn may_need_room(scenario: &Scenario) -> bool {
    let keeps_off = |person: &DeclaredPedestrian| {
        person.model.all().iter().filter_map(|model| model.known()).any(|model| model.keeps_off.is_some())
    };
    scenario.pedestrians.iter().any(|person| !person.may_start_inside && keeps_off(person))
}

/// What a set of runs is of.
struct Places<'a> {
    all: &'static str,
    search: Option<(&'a str, &'a Origin)>,
}

/// A place from which a pedestrian sets out too near to a lane.
struct Place {
    /// In the run in which it is nearest.
    nearest: TooNear,
    case: Case,
    runs: usize,
}

impl Places<'_> {
    fn examine(&self, scenario: &Scenario, runs: &[Case], sources: &Sources) -> Vec<Diagnostic> {
        let mut places: Vec<Place> = Vec::new();
        for case in runs {
            for found in too_near(&case.world) {
                let place = (found.pedestrian, found.refuge);
                let is_it = |known: &&mut Place| (known.nearest.pedestrian, known.nearest.refuge) == place;
                let Some(known) = places.iter_mut().find(is_it) else {
                    places.push(Place { nearest: found, case: case.clone(), runs: 1 });
                    continue;
                };
                known.runs += 1;
                if found.missing() > known.nearest.missing() {
                    (known.nearest, known.case) = (found, case.clone());
                }
            }
        }
        places.retain(|place| !scenario.pedestrians[place.nearest.pedestrian].may_start_inside);
        places.iter().map(|place| self.finding(scenario, place, runs.len(), sources)).collect()
    }

    fn finding(&self, scenario: &Scenario, place: &Place, all: usize, sources: &Sources) -> Diagnostic {
        let Place { nearest, case, runs } = place;
        let setup = &case.world.pedestrians[nearest.pedestrian];
        let declared = &scenario.pedestrians[nearest.pedestrian];
        let said = scenario.written.get(&format!("{}.start", setup.name)).filter(|_| nearest.refuge == 0);
        let declared_at = said.map_or(&declared.origin, |said| &said.origin);
        let (code, share) = match *runs == all {
            true if self.all == TRIALS => (Code::NoRoomToWait, String::new()),
            true => (Code::NoRoomToWait, format!("in all {all} {} ", self.all)),
            false => {
                let share = significant(100.0 * *runs as f64 / all as f64, 2);
                (Code::SometimesNoRoom, format!("in {runs} of {all} {} ({share} %) ", self.all))
            }
        };
        let (of_search, origin) = match self.search {
            Some((name, origin)) => (format!("search `{name}`: "), origin),
            None => (String::new(), declared_at),
        };
        let message = format!("{of_search}{share}{}", too_near_words(&case.world, nearest));
        at(code, origin, message, sources)
            .label("has no option to wait")
            .note(format!("in {}", case.key))
            .note(needs(setup, nearest))
            .hint(way_out(setup, nearest))
    }
}

fn needs(setup: &PedestrianSetup, found: &TooNear) -> String {
    let Some((setting, margin)) = setup.keeps_off() else { return String::new() };
    format!("half of both bodies is {}, and `{setting}` is {}", metres(found.needed - margin), metres(margin))
}

fn way_out(setup: &PedestrianSetup, found: &TooNear) -> String {
    let Some((setting, margin)) = setup.keeps_off() else { return String::new() };
    // Rounded to the safe side.
    let missing = (found.missing() * 1e3 - 1e-3).ceil() / 1e3;
    let farther = match found.refuge {
        0 => format!("let it start {} farther away", metres(missing)),
        _ => format!("make the refuge {} wider", metres(2.0 * missing)),
    };
    let nearer = match margin - missing {
        left if left > 0.0 => {
            format!(", or declare `{setting}: {}` or less in `{}`", metres(left), setup.model.model)
        }
        _ => String::new(),
    };
    format!("{farther}{nearer}; if it is meant, say `may start inside`")
}
