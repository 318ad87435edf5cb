//! What findings and comparisons say, in parts for tables and charts, each number with its unit.

use std::collections::HashSet;

use super::chart::Rule;
use super::format::{count, in_notation, quantity, share};
use results::judge::{PerRun, judge};
use results::{
    BlockReport, BlockState, Finding, FindingMeasure, Horizon, LeftRoad, NearestRun, OnCourse, Outcome,
    OutlastedRuns, Reason, RecordedReport, RecordedState, Regarding, Requests, RunsTaken, ScenarioSummary,
    Skip, Standing, SuiteReport, TrialReport, TrialState, TrialVerdict, UnitReport, Untested, UntestedPair,
    Verdict, WaitingStep, WorstRun,
};
use scenario::{Comparison, Keep, MetricKind, Notation, People, Relation, Search, Stake, World, significant};
use sim::StopReason;
use sim::measure::Closeness;

/// Why a run ends.
pub fn ending_words(reason: StopReason) -> &'static str {
    match reason {
        StopReason::Completed => "everybody has passed",
        StopReason::Collision => "the run ends at the collision",
        StopReason::Horizon => "time is up",
    }
}

/// The same of a run in this world: for the last vehicles of streams no run waits.
pub fn ending_of(reason: StopReason, world: &World) -> &'static str {
    match reason {
        StopReason::Completed if !world.streams.is_empty() => "everybody has passed for whom the run waits",
        reason => ending_words(reason),
    }
}

/// What was found: `holds in 18 of 20 runs`, `85 %`, `1.62 s`; `–` if no run has a value.
pub fn observed(finding: &Finding) -> String {
    match (finding.measure, finding.observed) {
        (FindingMeasure::EveryRun, _) => format!("holds in {} of {} runs", finding.holding, finding.runs),
        (_, None) => "–".to_string(),
        (FindingMeasure::Share, Some(value)) => share(value),
        (FindingMeasure::Count, Some(value)) => format!("{value} of {} runs", finding.runs),
        (FindingMeasure::Value, Some(value)) => in_unit(finding, value),
    }
}

/// What it was compared to.
pub fn bound(finding: &Finding) -> String {
    match finding.measure {
        FindingMeasure::EveryRun => "every run".to_string(),
        FindingMeasure::Share => share(finding.bound),
        FindingMeasure::Count => significant(finding.bound, 4),
        FindingMeasure::Value => in_unit(finding, finding.bound),
    }
}

/// The interval of the estimate, such as `[71 %, 94 %]`.
pub fn interval(finding: &Finding) -> Option<String> {
    let (low, high) = finding.interval?;
    let show = |value| match finding.measure {
        FindingMeasure::EveryRun | FindingMeasure::Share => share(value),
        FindingMeasure::Count => significant(value, 4),
        FindingMeasure::Value => in_unit(finding, value),
    };
    let mut text = format!("[{}, {}]", show(low), show(high));
    if finding.approximate {
        text = format!("approximately {text}");
    }
    Some(text + &whom(finding).map_or_else(String::new, |whom| format!(" {whom}")))
}

/// Whom a finding with confidence speaks of, where people walk who are somebody: `of these 5 people`.
pub fn whom(finding: &Finding) -> Option<String> {
    let Regarding { whom, people, drawn } = finding.people?;
    if drawn {
        return Some("of all people, one drawn for each run".to_string());
    }
    Some(match (whom, people) {
        (People::These, 1) => "of this person".to_string(),
        (People::These, _) => format!("of these {people} people"),
        (People::All, _) => format!("of all people, from {people} of them"),
    })
}

/// How far from failing, with its sign: `+0.12 s`, `-5 points`.
pub fn margin(finding: &Finding) -> Option<String> {
    let margin = finding.margin?;
    let size = match finding.measure {
        FindingMeasure::Share => format!("{} points", significant(margin.abs() * 100.0, 3)),
        FindingMeasure::Count => format!("{} runs", significant(margin.abs(), 4)),
        FindingMeasure::EveryRun | FindingMeasure::Value => in_unit(finding, margin.abs()),
    };
    Some(signed(margin, size))
}

fn signed(margin: f64, size: String) -> String {
    format!("{}{size}", if margin < 0.0 { "-" } else { "+" })
}

/// A comparison with a constant bound, shown in `unit` if it has one: `pet < 1.5 s`, `no collision`, `passed_first = pedestrian`.
pub fn comparison_text(comparison: &Comparison, unit: Option<Notation>) -> String {
    let (label, bound) = (comparison.metric.label(), comparison.constant_bound());
    let metric = comparison.metric.known();
    let flag = metric.is_some_and(|metric| metric.kind == MetricKind::Flag);
    match comparison.relation {
        Relation::Equal | Relation::NotEqual if flag => {
            let set = (bound != 0.0) == (comparison.relation == Relation::Equal);
            if set { label } else { format!("no {label}") }
        }
        relation => {
            let bound = match (unit, metric) {
                (Some(unit), _) => in_notation(bound, unit),
                (None, Some(metric)) => quantity(metric, Some(bound)),
                (None, None) => significant(bound, 4),
            };
            format!("{label} {} {bound}", relation.symbol())
        }
    }
}

/// What a search keeps: `pet < 1.5 s and plausibility >= 5 %`.
pub fn keep_text(search: &Search) -> String {
    let each = search.keep.iter().map(|keep| match keep {
        Keep::Metric { comparison, written_in } => comparison_text(comparison, *written_in),
        Keep::Plausibility { relation, bound } => {
            format!("plausibility {} {} %", relation.symbol(), significant(100.0 * bound, 4))
        }
    });
    each.collect::<Vec<_>>().join(" and ")
}

/// The bound of a comparison as a line in a chart of its metric: both in `unit` if it has one, else in SI units.
pub fn comparison_rule(comparison: &Comparison, unit: Option<Notation>) -> Rule {
    let sign = match comparison.relation {
        Relation::GreaterOrEqual => "≥",
        Relation::LessOrEqual => "≤",
        Relation::NotEqual => "≠",
        other => other.symbol(),
    };
    let bound = comparison.constant_bound();
    let shown = match (unit, comparison.metric.known()) {
        (Some(unit), _) => in_notation(bound, unit),
        (None, Some(metric)) if matches!(metric.kind, MetricKind::Quantity(_)) => {
            quantity(metric, Some(bound))
        }
        _ => significant(bound, 4),
    };
    Rule { value: unit.map_or(bound, |unit| unit.of_si(bound)), label: format!("{sign} {shown}") }
}

/// Verdict, what was found, its interval and margin, and the run that is worst or nearest to failing.
pub fn in_words(finding: &Finding) -> String {
    let parts = [
        Some(format!("{}: {}", verdict_word(finding.verdict), observed(finding))),
        missing(finding),
        interval(finding),
        margin(finding).map(|margin| format!("margin {margin}")),
        nearest_run(finding),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// In how many runs there was no value, and why: `undefined in 2 runs, cut off in 3 runs`.
pub fn missing(finding: &Finding) -> Option<String> {
    let parts = [(finding.undefined, "undefined"), (finding.cut_off, "cut off")];
    let parts = parts.iter().filter(|(runs, _)| *runs > 0);
    let parts = parts.map(|(runs, what)| format!("{what} in {}", count(*runs, "run")));
    let said: Vec<_> = parts.chain(tested_runs(finding)).collect();
    (!said.is_empty()).then(|| said.join(", "))
}

/// `met in 24 of 200 runs`, of a number that sums up runs of which only some put anything to the test.
fn tested_runs(finding: &Finding) -> Option<String> {
    let tested = finding.tested.filter(|_| finding.measure != FindingMeasure::EveryRun)?;
    let stake = finding.metric.known().map(|metric| metric.stake);
    let is_met = matches!(stake, Some(Stake::Meeting | Stake::MeetingInTime | Stake::Vehicles));
    Some(format!("{} in {tested} of {} runs", if is_met { "met" } else { "tested" }, finding.runs))
}

/// The run that speaks most against the criterion, or else comes nearest to that:
/// `closest: pet 1.92 s (+0.42 s) at 7.33 s, av and walker, in zebra/walk/rep=3`.
pub fn nearest_run(finding: &Finding) -> Option<String> {
    let worst = finding.worst.first().map(|run| ("worst", run));
    let (what, run) = worst.or(finding.closest.as_ref().map(|run| ("closest", run)))?;
    Some(format!("{what}: {}, in {}", run_in_words(finding, run), run.key))
}

/// How a run stands to a criterion: `pet 0.83 s (-0.67 s) at 7.33 s, av and walker`.
pub fn run_words(criterion: &PerRun, outcome: &Outcome, requests: &Requests) -> String {
    let judged = judge(std::slice::from_ref(&criterion.criterion), std::slice::from_ref(outcome), requests);
    let finding = &judged.findings[0];
    match finding.worst.first().or(finding.closest.as_ref()) {
        Some(run) => run_in_words(finding, run),
        None => {
            let index = requests.index(criterion.criterion.claim.metric());
            let value = index.and_then(|index| outcome.metrics[index]);
            let run = WorstRun { key: String::new(), value, margin: None, cut_off: false, critical: None };
            run_value(finding, &run)
        }
    }
}

/// What a run's metric was, how far from speaking against the criterion, when and for whom:
/// `pet 0.83 s (-0.67 s) at 7.33 s, av and walker`.
pub fn run_in_words(finding: &Finding, run: &WorstRun) -> String {
    let margin = run.margin.map(|margin| format!(" ({})", signed(margin, in_unit(finding, margin.abs()))));
    format!("{}{}{}", run_value(finding, run), margin.unwrap_or_default(), critical(run))
}

/// `pet 0.83 s`
pub fn run_value(finding: &Finding, run: &WorstRun) -> String {
    let so_far = if run.cut_off { " when time was up" } else { "" };
    match finding.metric.known() {
        Some(_) => format!("{} {}{so_far}", finding.metric, metric_value(finding, run.value)),
        None => "?".to_string(),
    }
}

/// A value of the finding's metric as [`quantity`] gives it, but in the unit that the criterion is written in.
pub fn metric_value(finding: &Finding, value: Option<f64>) -> String {
    let Some(metric) = finding.metric.known() else {
        return value.map_or_else(|| "?".to_string(), |value| significant(value, 4));
    };
    let unit = match &metric.kind {
        MetricKind::Quantity(dimension) => lang::unit_in(&finding.criterion, *dimension),
        MetricKind::Flag | MetricKind::Category(_) => None,
    };
    match (unit, value) {
        (Some(unit), Some(value)) => in_notation(value, unit),
        _ => quantity(metric, value),
    }
}

/// Of the criteria that no run of these trials speaks against, the run that comes nearest to it:
/// `closest to \`pet >= 1.5 s\`: pet 1.92 s (+0.42 s) at 7.33 s, av and walker, in zebra/walk/rep=3`.
pub fn closest_calls(scenarios: &[&ScenarioSummary]) -> Vec<String> {
    let mut criteria: Vec<NearestRun> = Vec::new();
    for nearest in scenarios.iter().flat_map(|scenario| &scenario.nearest) {
        match criteria.iter_mut().find(|known| known.criterion == nearest.criterion) {
            None => criteria.push(nearest.clone()),
            Some(known) => known.join(nearest.clone()),
        }
    }
    criteria.sort_by_key(|nearest| nearest.first);
    // Of a criterion that is written of a group, and is one of each member, the member who came nearest.
    let applied = || scenarios.iter().flat_map(|scenario| &scenario.criteria).flat_map(|one| &one.criteria);
    let written = |nearest: &NearestRun| {
        let found = applied().find(|criterion| criterion.text == nearest.criterion)?;
        (!found.origin.file.is_empty()).then(|| found.origin.clone())
    };
    let margin = |nearest: &NearestRun| {
        let run = nearest.finding.as_ref().and_then(|(_, finding)| finding.closest.as_ref());
        run.and_then(|run| run.margin).unwrap_or(f64::INFINITY)
    };
    let mut nearest_of: Vec<NearestRun> = Vec::new();
    for nearest in criteria {
        let origin = written(&nearest);
        match nearest_of.iter_mut().find(|known| origin.is_some() && written(known) == origin) {
            None => nearest_of.push(nearest),
            Some(known) if margin(&nearest) < margin(known) => *known = nearest,
            Some(_) => {}
        }
    }
    let said = nearest_of.iter().filter_map(|NearestRun { criterion, finding, .. }| {
        let (_, finding) = finding.as_ref()?;
        let run = finding.closest.as_ref()?;
        Some(format!("closest to `{criterion}`: {}, in {}", run_in_words(finding, run), run.key))
    });
    said.collect()
}

/// When and for whom a run's metric was what it was: ` at 7.33 s, av and walker`, ` of av`, or nothing.
fn critical(run: &WorstRun) -> String {
    let Some(critical) = &run.critical else { return String::new() };
    let who: Vec<&str> = [&critical.vehicle, &critical.pedestrian, &critical.other]
        .into_iter()
        .flatten()
        .map(|name| &**name)
        .collect();
    match (critical.time, who.join(" and ")) {
        (Some(time), who) if who.is_empty() => format!(" at {time:.2} s"),
        (Some(time), who) => format!(" at {time:.2} s, {who}"),
        (None, who) if who.is_empty() => String::new(),
        (None, who) => format!(" of {who}"),
    }
}

/// What is to be said behind its key in a line of its own.
pub fn remark(report: &UnitReport) -> String {
    match report {
        UnitReport::Recorded(recorded) => recorded_remark(recorded),
        UnitReport::Trial(trial) => match (&trial.state, trial.stopping()) {
            (TrialState::Skipped(skip), _) => format!(": {skip}"),
            (TrialState::NotFinished(cut), _) => format!(": {cut}"),
            (_, Some(stopped)) => format!(" ({})", stopping(stopped)),
            _ => String::new(),
        },
        UnitReport::Block(block) => match &block.state {
            BlockState::Skipped(skip) => format!(": {skip}"),
            BlockState::NotFinished(cut) => format!(": {cut}"),
            BlockState::Finished(_) if report.standing() == Standing::Found => format!(": {FOUND}"),
            BlockState::Finished(_) | BlockState::Errored(_) => String::new(),
        },
    }
}

/// What is to be said of it behind its key; empty if the failure itself says all.
pub fn recorded_remark(recorded: &RecordedReport) -> String {
    let rerun = match &recorded.state {
        RecordedState::Ran(rerun) => rerun,
        RecordedState::Skipped(skip) => return format!(": {skip}"),
        RecordedState::Errored(_) => return String::new(),
    };
    let against: Vec<_> = rerun.against.iter().map(|one| format!("`{}`", one.criterion)).collect();
    let changed = match (rerun.same_case, rerun.may_differ) {
        (true, false) => "",
        (false, false) => " (the case has changed since)",
        (true, true) => " (it may not come out the same again: its controller is not deterministic)",
        (false, true) => " (the case has changed since, and its controller is not deterministic)",
    };
    match rerun.judged.verdict {
        Verdict::Passed if against.is_empty() => format!(": does not fail any more{changed}"),
        Verdict::Passed => format!(": still speaks against {}{changed}", against.join(", ")),
        _ => changed.to_string(),
    }
}

/// Why a trial whose runs are added until it is decided had so many of them.
pub fn stopping(stopping: &RunsTaken) -> String {
    let RunsTaken { runs, most, .. } = stopping;
    match stopping.reason {
        Reason::Decided => format!("decided after {runs} of at most {most} runs"),
        Reason::Budget => format!("not decided by all {runs} runs"),
        Reason::NothingToDecide => format!("ended after {runs} runs, as no criterion has a confidence"),
    }
}

/// Everything about a trial that is to be warned of, in every report: how its runs went, and models in it that are others
/// than were published.
pub fn trial_warnings(trial: &TrialReport) -> Vec<String> {
    let mut said = warnings(&trial.state);
    said.extend(nothing_claimed(trial));
    if !trial.skipped() {
        said.extend(trial.departures.iter().cloned());
    }
    said
}

/// That a trial was run for nothing, though its scenario has criteria; one without any is measured by something else.
pub fn nothing_claimed(trial: &TrialReport) -> Option<String> {
    let asked = trial.claims_nothing() && trial.trial.declared > 0;
    let criteria = match trial.trial.declared {
        1 => "the criterion of its scenario does not apply".to_string(),
        several => format!("none of the {several} criteria of its scenario applies"),
    };
    asked.then(|| format!("not judged: {criteria}, so nothing is claimed of its {}", runs_of(trial)))
}

fn runs_of(trial: &TrialReport) -> String {
    match trial.outcomes.len() {
        1 => "run".to_string(),
        runs => format!("{runs} runs"),
    }
}

/// What is said of a search that expects nothing of what it found.
pub const FOUND: &str = "found, not judged";

/// Word and mark of how something stands.
pub fn standing_words(standing: Standing) -> (&'static str, &'static str) {
    match standing {
        Standing::Judged(verdict) => (verdict_word(verdict), verdict_mark(verdict)),
        Standing::NotFinished(_) => ("not finished", "■"),
        Standing::Errored => ("error", "!"),
        Standing::Skipped => ("skipped", "–"),
        Standing::NotJudged => ("not judged", "–"),
        Standing::Found => (FOUND, "–"),
    }
}

/// Word and mark of a trial that was judged, or to which no criterion applied.
pub fn judged_words(trial: &TrialReport) -> Option<(&'static str, &'static str)> {
    let verdict = trial.verdict()?;
    let said = (verdict_word(verdict), verdict_mark(verdict));
    Some(if trial.claims_nothing() { ("not judged", "–") } else { said })
}

/// The criteria of a trial that passed without being put to the test, or whose confidence rests on equal runs, to be warned of:
/// `\`pet >= 1.5 s\` passed untested: \`walker\` did not come into the way of \`av\` in any of 20 runs`.
pub fn untested(findings: &[Finding]) -> Vec<String> {
    let mut reasons: Vec<&Untested> = Vec::new();
    for reason in findings.iter().filter_map(|finding| finding.untested.as_ref()) {
        if !reasons.iter().any(|known| is_said_together(known, reason)) {
            reasons.push(reason);
        }
    }
    let said = reasons.into_iter().filter_map(|reason| {
        let is_it = |one: &&Finding| one.untested.as_ref().is_some_and(|why| is_said_together(why, reason));
        let all: Vec<_> = findings.iter().filter(is_it).collect();
        let mut criteria: Vec<_> = all.iter().map(|one| format!("`{}`", one.criterion)).collect();
        // What a scenario and a claim about it both state is still one criterion.
        let mut named = HashSet::new();
        criteria.retain(|criterion| named.insert(criterion.clone()));
        let criteria = criteria.join(", ");
        if *reason == Untested::CutOff {
            let most = all.iter().max_by_key(|one| one.unseen)?;
            let same = all.iter().all(|one| one.unseen == most.unseen);
            let up_to = if same { "" } else { "up to " };
            return Some(format!("{criteria} passed, but {up_to}{}", unseen(most)));
        }
        let runs = match all.first()?.runs {
            1 => "the run".to_string(),
            runs => format!("any of {runs} runs"),
        };
        Some(format!("{criteria} passed untested: {} in {runs}{}", untested_words(reason), way_out(reason)))
    });
    said.chain(alike(findings)).collect()
}

/// Whether two reasons are the same but for the criterion that to write instead.
fn is_said_together(one: &Untested, other: &Untested) -> bool {
    match (one, other) {
        (Untested::Pairs { pairs, .. }, Untested::Pairs { pairs: others, .. }) => pairs == others,
        _ => one == other,
    }
}

/// `\`b\` never came into the way of \`av\``: how far the pairs came, several joined.
pub fn untested_words(reason: &Untested) -> String {
    match reason {
        Untested::Pairs { pairs, .. } => pairs.iter().map(pair_words).collect::<Vec<_>>().join("; "),
        Untested::NoMotion { vehicle: Some(vehicle) } => {
            format!("`{vehicle}` did not move while a pedestrian was ahead of it or beside it")
        }
        Untested::NoMotion { vehicle: None } => {
            "no vehicle moved while a pedestrian was ahead of it or beside it".to_string()
        }
        Untested::NoValue => "nothing that it is about was at stake".to_string(),
        Untested::CutOff => "what would have come was not seen".to_string(),
    }
}

fn pair_words(pair: &UntestedPair) -> String {
    let UntestedPair { vehicle, other, closest } = pair;
    let of = vehicle.as_ref().map_or("any vehicle".to_string(), |vehicle| format!("`{vehicle}`"));
    match closest {
        Closeness::Absent => format!("`{other}` did not appear"),
        Closeness::Apart => {
            format!("`{other}` was not there while {of} had yet to pass, or {of} did not move until then")
        }
        Closeness::Together | Closeness::Abreast => format!("`{other}` did not come into the way of {of}"),
        Closeness::InTheWay => format!("`{other}` was in the way of {of}, but not within 5 s of it"),
        Closeness::Met | Closeness::Touched => format!("`{other}` met {of}"),
    }
}

/// How to write the criterion about a pair that was put to the test.
fn way_out(reason: &Untested) -> String {
    match reason {
        Untested::Pairs { instead: Some(instead), .. } => {
            format!(": name the pairs that you mean, as in `{instead}`")
        }
        _ => String::new(),
    }
}

/// `3 of 40 runs ended before what that is about was over`.
pub(super) fn unseen(finding: &Finding) -> String {
    format!("{} of {} runs ended before what that is about was over", finding.unseen, finding.runs)
}

/// The criteria with a confidence that rests on runs of which none is another.
fn alike(findings: &[Finding]) -> Option<String> {
    let mut criteria: Vec<_> =
        findings.iter().filter(|one| one.alike).map(|one| format!("`{}`", one.criterion)).collect();
    criteria.dedup();
    let runs = findings.iter().find(|one| one.alike)?.runs;
    Some(format!(
        "{} rests on {runs} runs that are the same bit for bit: if chance changes nothing in them, they are worth no \
         more than one",
        criteria.join(", ")
    ))
}

/// Steps of scripts that never began, vehicles that left the road, streams that were over before a pedestrian went across, and times between centres where bodies overlap: `step 1 of \`av\`, \`when distance < d1 stop\`, began in no run: what
/// it brings about is untested`.
pub fn not_as_declared(judged: &TrialVerdict) -> Vec<String> {
    let steps = judged.never_began.iter().map(|WaitingStep { of, step }| {
        format!(
            "step {} of `{of}`, `{}`, began in no run: what it brings about is untested",
            step.number, step.text
        )
    });
    let roads = judged.left_road.iter().map(|LeftRoad { vehicle, runs, of }| {
        format!(
            "`{vehicle}` left its carriageway in {runs} of {}, and no criterion is about `kerb_contact`",
            count(*of, "run")
        )
    });
    let outlasted = judged.outlasted.iter().map(|OutlastedRuns { outlasted, runs, of }| {
        format!(
            "the last vehicle of `{}` had passed before `{}` went across in {runs} of {}: which gap it would have taken is not known",
            outlasted.stream,
            outlasted.pedestrian,
            count(*of, "run")
        )
    });
    let overlapping = judged.findings.iter().filter(|finding| finding.overlapping > 0).map(|finding| {
        format!(
            "`{}` passed, but the bodies were in the shared area at the same time in {} of {}: `pet_area` is 0 s there",
            finding.criterion,
            finding.overlapping,
            count(finding.runs, "run")
        )
    });
    steps.chain(roads).chain(outlasted).chain(overlapping).collect()
}

/// What is to be warned of in a trial: criteria that passed untested, runs that the horizon ended too early.
pub fn warnings(state: &TrialState) -> Vec<String> {
    let TrialState::Judged(judged) = state else { return Vec::new() };
    let mut warnings = untested(&judged.findings);
    warnings.extend(not_as_declared(judged));
    if let Some(horizon) = &judged.horizon {
        warnings.extend(horizon_in_words(horizon));
    }
    warnings
}

/// Runs that a line names.
const MOST_NAMED: usize = 3;

/// `2 of 20 runs ended at the horizon; walker had not arrived in zebra/walk/rep=3, zebra/walk/rep=7`, and who was about to
/// touch.
fn horizon_in_words(horizon: &Horizon) -> Vec<String> {
    let Horizon { runs, of, stranded, on_course } = horizon;
    let list = |said: Vec<String>, all: usize| match all.saturating_sub(MOST_NAMED) {
        0 => said.join(", "),
        more => format!("{} and {more} more", said.join(", ")),
    };
    let ended = format!("{runs} of {} ended at the horizon", count(*of, "run"));
    let named = stranded.iter().take(MOST_NAMED);
    let named: Vec<_> = named.map(|run| format!("{} in {}", run.who.join(" and "), run.key)).collect();
    let mut lines = vec![if named.is_empty() {
        ended
    } else {
        let runs = count(stranded.len(), "run");
        format!("{ended}; not hit and not arrived in {runs}: {}", list(named, stranded.len()))
    }];
    if !on_course.is_empty() {
        let said = on_course.iter().take(MOST_NAMED).map(|run| {
            let OnCourse { vehicle, with, time } = &run.course;
            format!("{vehicle} and {with} {} s before they touch in {}", significant(*time, 3), run.key)
        });
        let keys: HashSet<_> = on_course.iter().map(|run| &run.key).collect();
        let runs = count(keys.len(), "run");
        let said = list(said.collect(), on_course.len());
        lines.push(format!("{runs} ended at the horizon on a collision course: {said}"));
    }
    lines
}

/// One word.
pub fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Inconclusive => "inconclusive",
        Verdict::Failed => "failed",
    }
}

/// One letter that needs no colour.
pub fn verdict_mark(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "✓",
        Verdict::Inconclusive => "?",
        Verdict::Failed => "✗",
    }
}

/// A value in the unit of the finding's metric. Differences and aggregates of flags are shares of runs.
fn in_unit(finding: &Finding, value: f64) -> String {
    match finding.metric.known() {
        Some(metric) if matches!(metric.kind, MetricKind::Quantity(_)) => metric_value(finding, Some(value)),
        _ => significant(value, 4),
    }
}

/// What is to be known of single claims where there are several: none shares its error with the others.
pub fn several_claims(report: &SuiteReport) -> Option<String> {
    let claims = report.claims_with_confidence();
    (claims > 1).then(|| {
        format!(
            "{claims} claims with confidence, each at its own: that all hold is as sure as the least sure of them; of single ones that do not \
             hold, some may pass by luck"
        )
    })
}

/// How far a suite came that somebody interrupted.
pub fn interruption(report: &SuiteReport) -> String {
    let count = |wanted: &dyn Fn(&Standing) -> bool| report.standings().filter(wanted).count();
    let not_finished = count(&|one| matches!(one, Standing::NotFinished(_)));
    let not_run = report.trials.iter().filter_map(TrialReport::skip);
    let not_run = not_run.chain(report.blocks.iter().filter_map(BlockReport::skip));
    let not_run = not_run.chain(report.recorded.iter().filter_map(RecordedReport::skip));
    let not_run = not_run.filter(|skip| matches!(skip, Skip::Stopped(_) | Skip::Needs { .. })).count();
    let is_finished = |one: &Standing| {
        matches!(one, Standing::NotJudged | Standing::Found | Standing::Judged(_) | Standing::Errored)
    };
    let finished = count(&is_finished);
    format!("interrupted: {finished} finished, {not_finished} not finished, {not_run} not run")
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::WhenUndefined;

    #[test]
    fn comparisons_read_as_they_are_written() {
        let text = |name: &str, relation, bound: f64| {
            let metric = models::known::measured(name);
            let when_undefined = WhenUndefined::Fails;
            comparison_text(&Comparison { metric, relation, bound: bound.into(), when_undefined }, None)
        };
        assert_eq!(text("pet", Relation::Less, 1.5), "pet < 1.5 s");
        assert_eq!(text("collision", Relation::Equal, 0.0), "no collision");
        assert_eq!(text("collision", Relation::NotEqual, 0.0), "collision");
        assert_eq!(text("passed_first", Relation::Equal, 1.0), "passed_first = pedestrian");
    }
}
