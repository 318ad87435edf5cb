//! What could make a plot look well where the run is not: another unit, another pair, a failure that no sample shows, a run that ends early.

use std::sync::Arc;

use super::pairs::user_look;
use super::plots::RunPlots;
use crate::chart::First;
use crate::fixture::Session;
use results::{Critical, Recording, Requests, SuiteReport, choose_runs};
use scenario::{Claim, Comparison, Criterion, Relation, Settings, Value, WhenUndefined};
use sim::measure::{PairDetails, PassingTimes, PersonDetails, Reached, StepReadings, VisitTimes};
use sim::{ModelState, StateQuantity};

/// A run with two people, asked for one more thing: what it is called, its bound in SI units, what it came to, when and with whom.
struct Drawn {
    report: SuiteReport,
    requests: Requests,
    recording: Recording,
}

fn two_people() -> Drawn {
    let session = Session::new();
    let report = session.report();
    let (_, mut recording) = session.record(choose_runs(&report)).remove(0);
    // The second walks beside the first, farther from the vehicle.
    let world = Arc::make_mut(&mut recording.case.world);
    let mut other = world.pedestrians[0].clone();
    other.name = "second".into();
    world.pedestrians.push(other);
    let places = recording.users[1]
        .iter()
        .map(|place| place.as_ref().map(|place| results::Place { y: place.y + 30.0, ..*place }));
    let places = places.collect();
    recording.users.push(places);
    let count = recording.times.len();
    recording.meetings = (0..2)
        .map(|pedestrian| PairDetails {
            vehicle: 0,
            pedestrian,
            time_to_collision: vec![Some(8.0); count],
            ..PairDetails::default()
        })
        .collect();
    Drawn { report, requests: session.requests, recording }
}

impl Drawn {
    fn asked(
        mut self,
        metric: &str,
        (text, bound): (&str, f64),
        value: Option<f64>,
        (time, person): (f64, &str),
    ) -> Self {
        let reference = models::known::measured(metric);
        let key = self.recording.case.key.clone();
        let holds = |trial: &&mut results::TrialReport| trial.outcomes.iter().any(|one| one.key == key);
        let trial = self.report.trials.iter_mut().find(holds).unwrap();
        let plain = Arc::make_mut(&mut trial.trial);
        let mut criterion = plain.criteria[0].clone();
        criterion.text = text.into();
        criterion.claim = Claim::Runs {
            comparison: Comparison {
                metric: reference.clone(),
                relation: Relation::GreaterOrEqual,
                bound: bound.into(),
                when_undefined: WhenUndefined::AsDeclared,
            },
            share: None,
            confidence: None,
        };
        // The unit is that of the first criterion.
        plain.criteria = std::iter::once(criterion).chain(plain.criteria.iter().cloned()).collect();
        let known = self.requests.index(&reference);
        self.requests.add(&reference);
        let outcome = trial.outcomes.iter_mut().find(|one| one.key == key).unwrap();
        let critical = Critical {
            time: Some(time),
            vehicle: Some("av".into()),
            pedestrian: Some(person.into()),
            other: None,
        };
        let all = self.requests.iter().count();
        let before: Vec<Option<Critical>> =
            (0..all).map(|index| outcome.critical.get(index).cloned()).collect();
        match known {
            Some(index) => outcome.metrics[index] = value,
            None => outcome.metrics.extend([value]),
        }
        let index = known.unwrap_or(all - 1);
        let at = |(place, known)| if place == index { Some(critical.clone()) } else { known };
        outcome.critical = before.into_iter().enumerate().map(at).collect();
        self
    }

    fn plots(&self) -> serde_json::Value {
        let reports = std::slice::from_ref(&self.report);
        serde_json::to_value(RunPlots::new(reports, &self.requests, &self.recording, None)).unwrap()
    }

    /// The picture with that title.
    fn panel(&self, title: &str) -> Option<String> {
        let plots = self.plots();
        let panels = plots["panels"].as_array().unwrap().iter();
        let svgs = panels.map(|panel| panel["svg"].as_str().unwrap().to_string());
        svgs.into_iter().find(|svg| svg.contains(&format!(">{title}</text>")))
    }
}

#[test]
fn a_failure_that_no_sample_shows_is_marked_in_the_unit_of_the_bound() {
    // All samples say 8 s; the metric came to 0.4 s between two of them.
    let drawn = two_people().asked("min_ttc", ("min_ttc >= 1500 ms", 1.5), Some(0.4), (6.03, "walker"));
    let svg = drawn.panel("Time to collision").unwrap();
    assert!(svg.contains("min_ttc ≥ 1500 ms") && svg.contains(">min_ttc 400 ms</text>"), "{svg}");
    assert!(svg.contains("(ms)") && svg.contains("min_ttc 400 ms at 6.03 s"), "{svg}");
    // The bound is between the mark and the lines, all three in one unit: lower is farther down.
    let at = |class: &str| -> f64 {
        let element = svg.split(class).nth(1).unwrap();
        let path = element.split("d=\"M").nth(1).unwrap();
        path.split([' ', 'H', 'L', 'm']).nth(1).unwrap().parse().unwrap()
    };
    let (mark, bound, line) = (at("class=\"dot"), at("class=\"rule\""), at("class=\"line"));
    assert!(line < bound && bound < mark, "{line} {bound} {mark}");
}

#[test]
fn the_pair_that_fails_is_drawn_before_one_that_comes_nearer() {
    let mut drawn = two_people();
    // A third is nearer than the second, who is whom the metric is of.
    let world = Arc::make_mut(&mut drawn.recording.case.world);
    let mut third = world.pedestrians[0].clone();
    third.name = "third".into();
    world.pedestrians.push(third);
    let places = drawn.recording.users[1].clone();
    drawn.recording.users.push(places);
    let drawn = drawn.asked("min_ttc", ("min_ttc >= 1.5 s", 1.5), Some(0.4), (6.03, "second"));
    let svg = drawn.panel("Time to collision").unwrap();
    assert!(svg.contains("av and second from 8 s"), "{svg}");
    let plots = drawn.plots();
    let legend = plots["legend"].to_string();
    assert!(legend.contains("av and second") && !legend.contains("av and third"), "{legend}");
    assert!(plots["left_out"].as_str().unwrap().contains("1 more pairs"), "{}", plots["left_out"]);
}

/// A failure at the end of what metrics took their values of is never cut off.
#[test]
fn plots_end_after_whatever_metrics_took_their_values_of() {
    let end = |moment: f64, time: f64| {
        let mut drawn = two_people().asked("min_ttc", ("min_ttc >= 1.5 s", 1.5), Some(0.4), (time, "walker"));
        // What the other criteria are about comes late.
        for trial in &mut drawn.report.trials {
            let criteria = &mut Arc::make_mut(&mut trial.trial).criteria;
            *criteria = criteria.iter().filter(|one| one.text == "min_ttc >= 1.5 s").cloned().collect();
        }
        let last = *drawn.recording.times.last().unwrap();
        let reports = [drawn.report];
        let plots = RunPlots::new(&reports, &drawn.requests, &drawn.recording, Some(moment));
        let plots = serde_json::to_value(&plots).unwrap();
        (plots["to"].as_f64().unwrap(), plots["left_out"].to_string(), last)
    };
    let (to, said, last) = end(1.0, 1.0);
    assert!(
        last > 8.0 && (4.0..last).contains(&to) && said.contains("Nothing is drawn after"),
        "{to} of {last}: {said}"
    );
    let (to, said, last) = end(1.0, last - 0.1);
    assert!(to == last && !said.contains("Nothing is drawn"), "{to} of {last}: {said}");
}

#[test]
fn everybody_who_is_drawn_has_a_look_of_their_own() {
    let drawn = two_people();
    let looks: Vec<_> = (0..3).map(|who| user_look(&drawn.recording, who).unwrap()).collect();
    assert_eq!(looks[0], First::Vehicle.look());
    assert_eq!(looks[1], First::Pedestrian.look());
    assert!(looks[2] != looks[0] && looks[2] != looks[1]);
    assert_eq!(user_look(&drawn.recording, 3), None);
}

#[test]
fn without_samples_the_mark_and_the_bound_are_there_all_the_same() {
    let mut drawn = two_people().asked("min_ttc", ("min_ttc >= 1.5 s", 1.5), Some(0.4), (6.03, "walker"));
    drawn.recording.meetings.clear();
    let svg = drawn.panel("Time to collision").unwrap();
    assert!(svg.contains("min_ttc ≥ 1.5 s") && svg.contains("min_ttc 0.4 s at 6.03 s"), "{svg}");
    // Where nothing is known and nothing is asked there is no plot.
    let mut none = two_people();
    none.recording.meetings.clear();
    assert_eq!(none.panel("Time to collision"), None);
}

#[test]
fn another_prediction_has_a_plot_of_its_own_where_it_is_another() {
    let straight = Settings([("prediction".into(), Value::Word("straight".into()))].into());
    let asked = |mut drawn: Drawn| {
        drawn = drawn.asked(
            "min_ttc",
            ("min_ttc prediction: straight >= 1.5 s", 1.5),
            Some(0.4),
            (6.03, "walker"),
        );
        let with = |criterion: &mut Criterion| {
            if let Claim::Runs { comparison, .. } = &mut criterion.claim
                && comparison.metric.name() == "min_ttc"
            {
                comparison.metric.settings = straight.clone();
            }
        };
        drawn.report.trials.iter_mut().for_each(|trial| {
            Arc::make_mut(&mut Arc::make_mut(&mut trial.trial).criteria).iter_mut().for_each(with);
        });
        drawn.requests.iter_mut().filter(|one| one.name() == "min_ttc").for_each(|one| {
            one.settings = straight.clone();
        });
        drawn
    };
    let drawn = asked(two_people());
    assert!(drawn.panel("Time to collision").unwrap().contains("min_ttc 0.4 s at"));
    assert_eq!(drawn.panel("Time to collision, straight on"), None);
    let mut drawn = asked(two_people());
    let count = drawn.recording.times.len();
    drawn.recording.meetings[0].straight_on = vec![Some(3.0); count];
    let svg = drawn.panel("Time to collision, straight on").unwrap();
    assert!(svg.contains("min_ttc 0.4 s at") && svg.contains("av and walker from 3 s to 3 s"), "{svg}");
    let along = drawn.panel("Time to collision").unwrap();
    assert!(!along.contains("min_ttc"), "{along}");
}

fn stays(drawn: &mut Drawn, vehicle: (Reached, Reached), passed: Reached, to: Option<f64>) {
    let pair = &mut drawn.recording.meetings[0];
    pair.visits = vec![VisitTimes { from: 4.0, to, enters: vehicle.0, leaves: vehicle.1 }];
    pair.passings = vec![PassingTimes { pedestrian: 4.6, vehicle: passed }];
}

const AREA: &str = "Who is in the shared area";

#[test]
fn the_time_between_is_the_metrics_own_and_what_was_needed_is_drawn() {
    let mut drawn = two_people().asked("pet", ("pet >= 1.5 s", 1.5), Some(1.25), (5.85, "walker"));
    stays(&mut drawn, (Reached::At(5.5), Reached::At(6.2)), Reached::At(5.85), Some(5.2));
    let svg = drawn.panel(AREA).unwrap();
    assert!(svg.contains("pet 1.25 s (dashed: ≥ 1.5 s): from 4.60 s to 5.85 s"), "{svg}");
    assert!(svg.contains("class=\"gap short\"") && svg.contains("1.50 s would have been needed"), "{svg}");
    assert!(svg.contains("walker in the way of av: 4.00 s to 5.20 s, passing at 4.60 s"), "{svg}");
    // Of a pair that it is not of no metric is told.
    let mut drawn = two_people().asked("pet", ("pet >= 1.5 s", 1.5), Some(1.25), (5.85, "second"));
    stays(&mut drawn, (Reached::At(5.5), Reached::At(6.2)), Reached::At(5.85), Some(5.2));
    assert!(!drawn.panel(AREA).unwrap().contains("pet"));
    // A longer time is not short.
    let mut drawn = two_people().asked("pet", ("pet >= 1.5 s", 1.5), Some(2.0), (6.6, "walker"));
    stays(&mut drawn, (Reached::At(6.2), Reached::At(7.0)), Reached::At(6.6), Some(5.2));
    let svg = drawn.panel(AREA).unwrap();
    assert!(svg.contains("class=\"gap\"") && !svg.contains("short"), "{svg}");
}

#[test]
fn a_contact_is_no_time_between_and_a_run_that_was_cut_off_says_so() {
    let mut drawn = two_people().asked("pet", ("pet >= 1.5 s", 1.5), Some(0.0), (5.0, "walker"));
    stays(&mut drawn, (Reached::At(4.9), Reached::NotYet), Reached::NotYet, None);
    drawn.recording.meetings[0].contact = Some(5.0);
    let svg = drawn.panel(AREA).unwrap();
    assert!(svg.contains("pet 0 s, since they touch (dashed: ≥ 1.5 s): from 5.00 s to 5.00 s"), "{svg}");
    assert!(svg.contains("4.90 s to the end of the run"), "{svg}");
    // The vehicle never came: no bar, no time between, and that is said.
    let mut drawn = two_people().asked("pet", ("pet >= 1.5 s", 1.5), None, (5.0, "walker"));
    stays(&mut drawn, (Reached::NotYet, Reached::NotYet), Reached::NotYet, Some(5.2));
    let svg = drawn.panel(AREA).unwrap();
    assert!(svg.contains("not there in this run") && !svg.contains("class=\"gap"), "{svg}");
    assert!(svg.contains("pet – (asked for: ≥ 1.5 s)"), "{svg}");
}

#[test]
fn what_a_person_makes_of_it_is_that_of_the_person() {
    let mut drawn = two_people();
    let count = drawn.recording.times.len();
    let quantity =
        |group: &str, name: &str| StateQuantity { group: group.into(), name: name.into(), range: (0.0, 1.0) };
    let state = |value: f64| Some(ModelState { about: Some(0), values: vec![value, 0.25, 1.0 - value] });
    let person = |states: Vec<Option<ModelState>>| PersonDetails {
        quantities: vec![
            quantity("worth <b>", "go"),
            quantity("worth <b>", "stay"),
            quantity("belief", "yields"),
        ],
        states,
    };
    drawn.recording.states = vec![PersonDetails::default(), person(vec![state(0.75); count])];
    let svg = drawn.panel("second: worth &lt;b&gt;").unwrap();
    assert!(svg.contains("go from 0.75 to 0.75; stay from 0.25 to 0.25"), "{svg}");
    assert!(drawn.panel("second: belief").unwrap().contains("yields from 0.25 to 0.25"));
    assert_eq!(drawn.panel("walker: belief"), None);
    // No line leads from what is about one vehicle to what is about another.
    let one = svg.matches("class=\"line c0\"").count();
    let states = &mut drawn.recording.states[1].states;
    states[count / 2..].iter_mut().flatten().for_each(|state| state.about = None);
    let svg = drawn.panel("second: worth &lt;b&gt;").unwrap();
    assert_eq!(svg.matches("class=\"line c0\"").count(), one + 1, "{svg}");
    let states = &mut drawn.recording.states[1].states;
    states.iter_mut().flatten().for_each(|state| state.about = Some(0));
    let embedded = super::minds::embedded(&drawn.recording, 1).unwrap();
    assert_eq!(embedded["groups"][0], serde_json::json!(["worth <b>", ["go", "stay"], 0.0, 1.0]));
    assert_eq!(embedded["at"][0], serde_json::json!([0, 0.75, 0.25, 0.25]));
    assert_eq!(super::minds::embedded(&drawn.recording, 0), None);
}

/// Readings over time of what a metric came to in the end, which it comes to in the middle of the run.
fn with_readings(mut drawn: Drawn, metric: &str, (first, worst): (f64, f64)) -> Drawn {
    let index = drawn.requests.index(&models::known::measured(metric)).unwrap();
    let count = drawn.recording.times.len();
    let values = (0..count).map(|at| match at {
        0..10 => None,
        at if at == count / 2 => Some(worst),
        _ => Some(first),
    });
    let is_smallest = first > worst;
    drawn.recording.readings.push(StepReadings { metric: index, is_smallest, worst: values.collect() });
    drawn
}

fn margins(drawn: &Drawn) -> Vec<serde_json::Value> {
    let plots = drawn.plots();
    let panels = plots["panels"].as_array().unwrap().iter();
    panels.filter(|panel| panel["svg"].as_str().unwrap().contains(">Margins of criteria")).cloned().collect()
}

#[test]
fn a_margin_is_what_was_left_to_the_bound_in_its_unit() {
    for (worst, mark, fails) in [(0.4, "-1100 ms", "✗"), (1.7, "+200 ms", "✓"), (1.5, "0 ms", "✓")] {
        let drawn = two_people().asked("min_ttc", ("min_ttc >= 1500 ms", 1.5), Some(worst), (6.03, "walker"));
        let drawn = with_readings(drawn, "min_ttc", (4.0, worst));
        let [panel] = &margins(&drawn)[..] else { panic!("one picture") };
        let svg = panel["svg"].as_str().unwrap();
        assert!(svg.contains(&format!(">{mark}</text>")), "{svg}");
        assert!(svg.contains(&format!("{mark} at 6.03 s")) && svg.contains("(ms)"), "{svg}");
        // The line ends where the mark is, and begins at what was left before.
        let span = format!(
            "min_ttc &gt;= 1500 ms from {} ms to 2500 ms",
            mark.trim_start_matches('+').trim_end_matches(" ms")
        );
        assert!(svg.contains(&span), "{span}\n{svg}");
        assert!(svg.contains(">the bound</text>"), "{svg}");
        let legend = panel["legend"].to_string();
        assert!(legend.contains(&format!("{fails} min_ttc >= 1500 ms")), "{legend}");
    }
}

/// A wrong line would be worse than none.
#[test]
fn readings_of_something_else_are_not_drawn() {
    let asked = || two_people().asked("min_ttc", ("min_ttc >= 1.5 s", 1.5), Some(0.4), (6.03, "walker"));
    assert_eq!(margins(&with_readings(asked(), "min_ttc", (4.0, 0.4))).len(), 1);
    // They come to another value than was judged, are not those of every time, or there are none.
    assert!(margins(&with_readings(asked(), "min_ttc", (4.0, 0.5))).is_empty());
    let mut cut = with_readings(asked(), "min_ttc", (4.0, 0.4));
    cut.recording.readings[0].worst.pop();
    assert!(margins(&cut).is_empty());
    assert!(margins(&asked()).is_empty());
}

#[test]
fn what_is_known_at_the_end_is_named_and_not_drawn() {
    // The other criteria of the run are about `pet` and others that are no matter of time.
    let drawn = two_people().asked("min_ttc", ("min_ttc >= 1.5 s", 1.5), Some(0.4), (6.03, "walker"));
    let drawn = with_readings(drawn, "min_ttc", (4.0, 0.4));
    let [panel] = &margins(&drawn)[..] else { panic!("one picture") };
    let words = panel["words"].as_str().unwrap();
    assert!(
        words.starts_with("Not drawn, since not known before the end: ") && words.contains("pet >= 1.5 s"),
        "{words}"
    );
    assert!(!panel["svg"].as_str().unwrap().contains("pet &gt;="));
}

#[test]
fn a_metric_that_nothing_else_draws_has_a_picture_with_its_bound() {
    let drawn = two_people().asked("time_headway", ("time_headway >= 1 s", 1.0), Some(0.4), (6.03, "walker"));
    assert!(drawn.panel("time_headway").is_none_or(|svg| !svg.contains("class=\"line")));
    let drawn = with_readings(drawn, "time_headway", (4.0, 0.4));
    let svg = drawn.panel("time_headway").unwrap();
    assert!(svg.contains("time_headway ≥ 1 s") && svg.contains("time_headway 0.4 s at 6.03 s"), "{svg}");
    assert!(svg.contains("time_headway from 0.4 s to 4 s"), "{svg}");
}
