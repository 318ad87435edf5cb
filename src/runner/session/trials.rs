//! What is kept of a suite's trials while they run: each of them, or what a summary needs.

use std::collections::{BTreeMap, HashMap};
use std::mem;

use crate::plan::Plan;
use results::{MOST_SHOWN, PassedTrial, ScenarioSummary, Skip, Standing, SuiteSummary, TrialReport, Verdict};
use scenario::Assignment;

/// The trials of one suite.
pub struct KeptTrials<'a> {
    plan: &'a Plan,
    /// By their places in the suite.
    held: BTreeMap<usize, TrialReport>,
    /// `None` where every trial is held.
    counted: Option<Vec<Counted>>,
    /// The indices of scenarios among those that are counted, by name.
    names: HashMap<String, usize>,
}

/// A scenario of which not every trial is held.
#[derive(Default)]
struct Counted {
    summary: ScenarioSummary,
    /// Trials that passed, by their places, with the index of their criteria: those that are held as long as there are few…
    few: Vec<(usize, u32)>,
    /// …and those that are not.
    passed: Vec<(usize, u32)>,
}

impl<'a> KeptTrials<'a> {
    /// With `every` trial, or without those that passed of scenarios with many, and without those that are not run.
    pub fn new(plan: &'a Plan, every: bool) -> Self {
        let mut kept = Self { plan, held: BTreeMap::new(), counted: None, names: HashMap::new() };
        if !every {
            let mut counted = Vec::new();
            for scenario in plan.scenarios().iter().filter(|scenario| !scenario.is_empty()) {
                let name = &scenario.scenario().name;
                kept.names.entry(name.clone()).or_insert_with(|| {
                    counted.push(Counted { summary: ScenarioSummary::new(name), ..Counted::default() });
                    counted.len() - 1
                });
            }
            kept.counted = Some(counted);
        }
        kept
    }

    /// Takes in what became of the trial with this place in the suite.
    pub fn take(&mut self, place: usize, trial: TrialReport) {
        let Some(counted) = &mut self.counted else {
            self.held.insert(place, trial);
            return;
        };
        let of = &mut counted[self.names[&trial.trial.scenario]];
        let criteria = of.summary.add(place, &trial);
        let has_passed = trial.verdict() == Some(Verdict::Passed);
        if let Some(criteria) = criteria {
            if has_passed {
                of.few.push((place, criteria as u32));
            }
            self.held.insert(place, trial);
        }
        if of.summary.ran() > MOST_SHOWN {
            for (place, criteria) in of.few.drain(..) {
                self.held.remove(&place);
                of.passed.push((place, criteria));
            }
        }
    }

    /// How a trial stands that others needed in vain.
    pub fn standing(&self, place: usize) -> Standing {
        self.held.get(&place).map_or(Standing::Skipped, TrialReport::standing)
    }

    /// The trials that are held in the order of the suite, and where they are not all, what all come to. `skipped` is the report of
    /// one that was not selected.
    pub fn conclude(
        mut self,
        mut skipped: impl FnMut(usize) -> TrialReport,
    ) -> (Vec<TrialReport>, Option<SuiteSummary>) {
        let Some(mut counted) = self.counted else {
            let trials =
                (0..self.plan.len()).map(|place| self.held.remove(&place).unwrap_or_else(|| skipped(place)));
            return (trials.collect(), None);
        };
        let mut all = vec![0; counted.len()];
        let mut first = 0;
        for scenario in self.plan.scenarios().iter().filter(|scenario| !scenario.is_empty()) {
            let index = self.names[&scenario.scenario().name];
            let (of, places) = (&mut counted[index], first..first + scenario.len());
            all[index] += scenario.len();
            if of.summary.has_not_passed() {
                of.passed.sort_unstable();
                let passed = of.passed.iter().filter(|(place, _)| places.contains(place));
                of.summary.passed.extend(passed.map(|(place, criteria)| {
                    let value = |one: Assignment| (one.label.into_boxed_str(), one.value);
                    let values = scenario.variation(place - first).into_iter().map(value).collect();
                    PassedTrial { place: *place, criteria: *criteria, values }
                }));
            }
            first = places.end;
        }
        for (of, trials) in counted.iter_mut().zip(all) {
            let unselected = trials - of.summary.trials();
            of.summary.count(Standing::Skipped, Some(&Skip::NotSelected), unselected);
        }
        let scenarios = counted.iter_mut().map(|of| mem::take(&mut of.summary)).collect();
        let (held, trials) = self.held.into_iter().unzip();
        (trials, Some(SuiteSummary { held, scenarios }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::Project;
    use crate::run::Threads;
    use crate::session::{Selection, Session};
    use files::Memory;
    use models::standard;
    use numbers::random::Stream;
    use results::{SuiteReport, Unheard};

    const SUITE: &str = "\
suite mixed {
  scenario many {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed 50 km/h }
    pedestrian walker { model scripted; start 1 m from kerb; appears at late }
    vary late in 0 s .. 3.9 s step 0.1 s
    horizon 6 s
    expect { no collision when late >= 2 s; pet >= 1 s when late <= 1 s; min_distance >= 1 m undefined passes }
  }
  scenario few {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; start 40 m before crossing; speed 50 km/h }
    pedestrian walker { model scripted; start 1 m from kerb; appears at late }
    vary late in [0 s, 1 s]
    horizon 3 s
    expect { max_deceleration <= 9 m/s^2 }
  }
}
";

    fn project() -> Project {
        let files = Memory::default().with("mixed.suite", SUITE);
        Project::open("mixed.suite", &standard(), &files).unwrap_or_else(|error| panic!("{error}"))
    }

    fn report(project: &Project, every: bool, selection: &Selection) -> SuiteReport {
        let session = Session::new(project).executor(Threads::new(2)).courses(false).every_trial(every);
        session.run(selection, &mut Unheard).unwrap().suites.remove(0)
    }

    /// Threads end in any order.
    #[test]
    fn what_is_kept_depends_on_no_order() {
        let project = project();
        let whole = report(&project, true, &Selection::all());
        let plan = &project.suites()[0].plan;
        let kept = |order: &[usize]| {
            let mut kept = KeptTrials::new(plan, false);
            order.iter().for_each(|place| kept.take(*place, whole.trials[*place].clone()));
            let (trials, mut summary) = kept.conclude(|place| whole.trials[place].clone());
            let scenarios = summary.iter_mut().flat_map(|summary| &mut summary.scenarios);
            // Their order says nothing, and neither does that of the indices of criteria.
            scenarios.for_each(|one| {
                one.standings.sort_by_key(|one| one.standing);
                one.nearest.sort_by_key(|one| one.first);
                one.criteria.sort_by_key(|one| one.first);
                one.passed.iter_mut().for_each(|passed| passed.criteria = 0);
            });
            (trials, summary)
        };
        let mut order: Vec<usize> = (0..plan.len()).collect();
        let first = kept(&order);
        let mut stream = Stream::seeded(1);
        for _ in 0..20 {
            for index in (1..order.len()).rev() {
                order.swap(index, stream.index(index + 1));
            }
            assert_eq!(kept(&order), first);
        }
    }

    #[test]
    fn what_is_not_held_is_counted() {
        let project = project();
        for selection in [Selection::all(), Selection::containing("late=1"), Selection::containing("few")] {
            let (whole, counted) = (report(&project, true, &selection), report(&project, false, &selection));
            let (all, summary) = (SuiteSummary::of(&whole.trials), counted.summary().into_owned());
            assert_eq!(whole.summary, None);
            let mut standings = [&whole, &counted].map(|one| one.standings().collect::<Vec<_>>());
            standings.iter_mut().for_each(|one| one.sort_unstable());
            assert_eq!(standings[0], standings[1]);
            let numbers = |summary: &SuiteSummary| (summary.ran(), summary.runs(), summary.untested());
            assert_eq!(numbers(&all), numbers(&summary));
            for (place, trial) in counted.placed_trials() {
                let bits = |trial: &TrialReport| -> Vec<u64> {
                    trial.outcomes.iter().map(|outcome| outcome.fingerprint).collect()
                };
                assert_eq!(trial.trial, whole.trials[place].trial);
                assert_eq!(bits(trial), bits(&whole.trials[place]));
                assert_eq!(trial.state, whole.trials[place].state);
            }
            for (place, trial) in whole.trials.iter().enumerate() {
                let is_held = summary.held.contains(&place);
                let not_passed = !trial.skipped() && trial.verdict() != Some(Verdict::Passed);
                assert!(is_held || !not_passed, "{} did not pass", trial.trial.key);
            }
            assert!(counted.incomplete().is_some());
        }
        let all = report(&project, false, &Selection::all());
        let many = &all.summary().scenarios[0];
        assert!(many.passed.len() > 10 && many.has_not_passed(), "the suite has both: {many:?}");
    }

    /// Where anybody looks at another metric, all are measured.
    #[test]
    fn all_metrics_are_measured_where_somebody_may_look_at_them() {
        let count = |text: &str, whole: bool| {
            let files = Memory::default().with("claims.suite", text);
            let project = Project::open("claims.suite", &standard(), &files).unwrap();
            let session = Session::new(&project).executor(Threads::new(1)).courses(false).every_trial(whole);
            session.run(&Selection::all(), &mut Unheard).unwrap().requests.iter().count()
        };
        let text = SUITE.replace("no collision when late >= 2 s; pet >= 1 s when late <= 1 s; ", "");
        assert_eq!(count(&text, false), 2);
        assert!(count(&text, true) > 20);
        // Tables of trials that nothing is claimed of have columns all the same.
        let conditional =
            text.replace("max_deceleration <= 9 m/s^2", "max_deceleration <= 9 m/s^2 when late >= 1 s");
        assert!(count(&conditional, false) > 20);
        let block = text.trim_end().strip_suffix('}').unwrap().to_string()
            + "  statement slow { claim max(max_deceleration) of few <= 9 m/s^2 }\n}\n";
        assert!(count(&block, false) > 20);
    }
}
