//! Pedestrians that begin their way where waiting is not an option for their model: looked at before anything runs.

use super::budget::at;
use super::sampled::SampledScenario;
use crate::experiment::search_ends;
use crate::plan::{NearestStart, nearest_starts, to_a_millimetre, too_near_words};
use lang::{Code, Diagnostic, Severity, Sources};
use scenario::{Case, Origin, PedestrianSetup, Scenario, Suite, significant};
use sim::TooNear;

/// What is looked at of a scenario that draws nothing: all of it.
const TRIALS: &str = "trials";

/// An error for every place from which a pedestrian sets out in all of its runs, or in all that a search can try, so near to a lane that its
/// model cannot wait there, and a warning where that is so in some. Pedestrians that `may start inside` are left to reports.
pub(super) fn examine_room(suite: &Suite, sampled: &[SampledScenario], sources: &Sources) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for SampledScenario { scenario, runs } in sampled {
        let all = if scenario.is_drawn() { "runs looked at" } else { TRIALS };
        let declared = Places { all, search: None }.examine(scenario, runs, sources);
        let is_known = declared.iter().any(|found| found.severity == Severity::Error);
        found.extend(declared);
        for search in suite.searches.iter().filter(|search| search.scenario == scenario.name && !is_known) {
            let places = Places { all: "ends of its ranges", search: Some((&search.name, &search.origin)) };
            found.extend(places.examine(scenario, &search_ends(suite, search), sources));
        }
    }
    found
}

/// What a set of runs is of.
struct Places<'a> {
    all: &'static str,
    search: Option<(&'a str, &'a Origin)>,
}

impl Places<'_> {
    fn examine(&self, scenario: &Scenario, runs: &[Case], sources: &Sources) -> Vec<Diagnostic> {
        let starts = nearest_starts(runs.iter().map(|case| &*case.world));
        let is_error = |start: &&NearestStart| !scenario.pedestrians[start.found.pedestrian].may_start_inside;
        starts.iter().filter(is_error).map(|start| self.finding(scenario, start, runs, sources)).collect()
    }

    fn finding(
        &self,
        scenario: &Scenario,
        NearestStart { found, world, times }: &NearestStart,
        runs: &[Case],
        sources: &Sources,
    ) -> Diagnostic {
        let (case, all) = (&runs[*world], runs.len());
        let (setup, declared) =
            (&case.world.pedestrians[found.pedestrian], &scenario.pedestrians[found.pedestrian]);
        let said = scenario.written.get(&format!("{}.start", setup.name)).filter(|_| found.refuge == 0);
        let (code, share) = match *times == all {
            true if self.all == TRIALS => (Code::NoRoomToWait, String::new()),
            true => (Code::NoRoomToWait, format!("in all {all} {} ", self.all)),
            false => {
                let share = significant(100.0 * *times as f64 / all as f64, 2);
                (Code::SometimesNoRoom, format!("in {times} of {all} {} ({share} %) ", self.all))
            }
        };
        let (of_search, origin) = match self.search {
            Some((name, origin)) => (format!("search `{name}`: "), origin),
            None => (String::new(), said.map_or(&declared.origin, |said| &said.origin)),
        };
        let message = format!("{of_search}{share}{}", too_near_words(&case.world, found));
        let half = to_a_millimetre(found.needed - found.margin);
        let margin = to_a_millimetre(found.margin);
        at(code, origin, message, sources)
            .label("has no option to wait")
            .note(format!("in {}", case.key))
            .note(format!("half of both bodies is {half}, and `{}` is {margin}", found.setting))
            .hint(way_out(setup, found))
    }
}

fn way_out(setup: &PedestrianSetup, found: &TooNear) -> String {
    // Rounded to the safe side.
    let missing = (found.missing() * 1e3 - 1e-3).ceil() / 1e3;
    let farther = match found.refuge {
        0 => format!("let it start {} farther away", to_a_millimetre(missing)),
        _ => format!("make the refuge {} wider", to_a_millimetre(2.0 * missing)),
    };
    let nearer = match found.margin - missing {
        left if left > 0.0 => {
            let (setting, model) = (found.setting, &setup.model.model);
            format!(", or declare `{setting}: {}` or less in `{model}`", to_a_millimetre(left))
        }
        _ => String::new(),
    };
    format!("{farther}{nearer}; if it is meant, say `may start inside`")
}
