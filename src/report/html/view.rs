//! What the page's template shows: every number already in words.

use std::time::SystemTime;

use chrono::{DateTime, Utc};
use serde::Serialize;

use super::command::ReplayCommand;
use super::embed::{LeadRun, embed};
use super::failures::{FailureLine, failure_lines, is_open};
use super::figure::HtmlFigure;
use super::plots::RunPlots;
use super::statement::Statements;
use super::still::Still;
use super::told::RunTold;
use super::{block, gate, rating};
use crate::controllers;
use crate::digest::written_unit;
use crate::failure::render_failure;
use crate::figures::{figures, short_name};
use crate::table::Column;
use crate::wording::{
    bound, interval, judged_words, margin, missing, nearest_run, observed, several_claims, stopping,
    trial_warnings, verdict_mark, verdict_word,
};
use results::{
    BlockReport, BlockResult, BlockState, Chosen, Finding, FindingMeasure, GateReport, GateState, Program,
    RatingReport, RatingState, Recording, Requests, Skip, SuiteReport, TestedController, TrialReport,
    TrialState, Verdict,
};
use scenario::MetricReference;

/// A table with more trials than this scrolls.
const LONG_TABLE: usize = 30;
/// More trials of a scenario are not shown.
const MOST_TRIALS: usize = 500;
/// More failures of a scenario are not written out.
const MOST_FAILURES: usize = 60;

#[derive(Debug, Serialize)]
pub struct Page {
    version: String,
    platform: String,
    started: String,
    title: String,
    counts: Counts,
    /// Whether somebody interrupted it.
    interrupted: bool,
    /// What is counted: `trials and blocks`.
    counted: &'static str,
    suites: Vec<Suite>,
    /// JSON for the script.
    runs: String,
    run_count: usize,
    runs_left_out: usize,
    /// What is drawn of each of them over time.
    plots: Vec<RunPlots>,
    /// The run that is seen first.
    first: Option<ShownFirst>,
    /// Whether that is a failure, which then stands before everything else.
    leads: bool,
    /// Recorded runs that do not pass, none of which is counted elsewhere.
    recorded_open: usize,
    /// Failures of every suite.
    failures: Vec<FailureLine>,
    failures_left_out: usize,
}

/// A run as it is seen before the script draws it.
#[derive(Debug, Serialize)]
struct ShownFirst {
    key: String,
    command: String,
    told: RunTold,
    view_box: String,
    /// SVG elements.
    still: String,
    /// Who is drawn where a controller was told that they are, in words.
    perceived: Vec<String>,
    is_certain: bool,
}

impl From<LeadRun> for ShownFirst {
    fn from(first: LeadRun) -> Self {
        let LeadRun { told, still, key, command, is_certain, .. } = first;
        let Still { view_box, content, perceived } = still;
        Self { key, command, told, view_box, still: content, perceived, is_certain }
    }
}

/// Trials, blocks, ratings and gates by what became of them, and the runs of trials.
#[derive(Debug, Default, Clone, Copy, Serialize)]
struct Counts {
    /// Trials, blocks, ratings and gates.
    all: usize,
    trials: usize,
    blocks: usize,
    gates: usize,
    ratings: usize,
    passed: usize,
    failed: usize,
    inconclusive: usize,
    errors: usize,
    not_finished: usize,
    /// Trials to which no criterion applied.
    not_judged: usize,
    /// Searches that expect nothing of what they found.
    found: usize,
    skipped: usize,
    runs: usize,
    /// Of searches and tunes.
    evaluations: usize,
}

#[derive(Debug, Serialize)]
struct Suite {
    name: String,
    file: String,
    /// As a string, for JavaScript's numbers would round it.
    seed: String,
    seconds: String,
    counts: Counts,
    /// Which programs were tested, and how fast they answered.
    controllers: Vec<String>,
    /// Which populations people are of, and what is to be known of claims.
    notes: Vec<String>,
    warnings: Vec<String>,
    statements: Option<Statements>,
    scenarios: Vec<Scenario>,
    figures: Vec<HtmlFigure>,
    /// What to type to see a run of the charts again, with `{run}` for its key.
    replay: String,
    blocks: Vec<block::BlockSection>,
    gates: Vec<gate::GateSection>,
    ratings: Vec<rating::RatingSection>,
    metrics: Vec<Heading>,
}

#[derive(Debug, Serialize)]
struct Heading {
    label: String,
    below: String,
    about: String,
}

#[derive(Debug, Serialize)]
struct Scenario {
    name: String,
    doc: String,
    tags: Vec<String>,
    counts: Counts,
    variations: String,
    /// The criteria of any of its trials.
    criteria: Vec<String>,
    trials: Vec<Trial>,
    /// Whether the table of trials scrolls, those that did not pass first.
    long: bool,
    /// Why trials were skipped, and how many.
    skipped: Vec<String>,
    /// What there would be more of.
    left_out: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Trial {
    key: String,
    name: String,
    /// Of its scenario, where it stands among those of others.
    doc: String,
    runs: usize,
    /// Why there were so many, if they were added until it was decided.
    stopping: Option<String>,
    /// Criteria that passed without being put to the test.
    warnings: Vec<String>,
    state: &'static str,
    mark: &'static str,
    /// One per criterion of the scenario; `None` where it does not apply.
    cells: Vec<Option<Cell>>,
    /// One per metric of the suite.
    metrics: Vec<String>,
    /// Why it did not pass.
    failure: Option<Failure>,
}

#[derive(Debug, Serialize)]
struct Cell {
    verdict: &'static str,
    mark: &'static str,
    observed: String,
    interval: Option<String>,
    /// Bound, margin and what is missing.
    details: String,
    /// The run that is worst, or nearest to failing.
    nearest: Option<String>,
}

#[derive(Debug, Serialize)]
struct Failure {
    text: String,
    commands: Vec<ReplayCommand>,
}

impl Page {
    pub fn new(
        reports: &[SuiteReport],
        requests: &Requests,
        recordings: &[(Chosen, Recording)],
        started: SystemTime,
    ) -> Self {
        let embedded = embed(reports, requests, recordings);
        let leads = embedded.first.as_ref().is_some_and(|first| first.is_failure);
        let drawn: Vec<Recording> = recordings.iter().map(|(_, recording)| recording.clone()).collect();
        let mut counts = Counts::default();
        reports.iter().flat_map(|report| &report.trials).for_each(|trial| counts.add(trial));
        reports.iter().flat_map(|report| &report.blocks).for_each(|block| counts.add_block(block));
        reports.iter().flat_map(|report| &report.gates).for_each(|gate| counts.add_gate(gate));
        reports.iter().flat_map(|report| &report.ratings).for_each(|rating| counts.add_rating(rating));
        let names: Vec<_> = reports.iter().map(|report| report.identity.suite.as_str()).collect();
        let lines = reports.iter().map(|report| failure_lines(report, &embedded.keys));
        let (failures, left_out): (Vec<Vec<FailureLine>>, Vec<usize>) = lines.unzip();
        let recorded = reports.iter().flat_map(|report| &report.recorded);
        let program = Program::of(reports);
        Self {
            version: program.version,
            platform: program.platform,
            started: DateTime::<Utc>::from(started).format("%Y-%m-%d %H:%M:%S UTC").to_string(),
            title: names.join(", "),
            counts,
            interrupted: reports.iter().any(|report| report.interrupted),
            counted: counts.noun(),
            suites: reports.iter().map(|report| suite(report, requests, &drawn, &embedded.keys)).collect(),
            run_count: embedded.count,
            runs_left_out: embedded.left_out,
            runs: embedded.json,
            plots: embedded.plots,
            first: embedded.first.map(ShownFirst::from),
            leads,
            recorded_open: recorded.filter(|one| is_open(one)).count(),
            failures: failures.into_iter().flatten().collect(),
            failures_left_out: left_out.into_iter().sum(),
        }
    }
}

impl Counts {
    fn noun(&self) -> &'static str {
        match (self.blocks > 0, self.ratings > 0, self.gates > 0) {
            (false, false, false) => "trials",
            (true, false, false) => "trials and blocks",
            (false, true, false) => "trials and ratings",
            (false, false, true) => "trials and gates",
            (true, true, false) => "trials, blocks and ratings",
            (true, false, true) => "trials, blocks and gates",
            (false, true, true) => "trials, ratings and gates",
            (true, true, true) => "trials, blocks, ratings and gates",
        }
    }

    fn add_rating(&mut self, rating: &RatingReport) {
        self.all += 1;
        self.ratings += 1;
        *match (&rating.state, rating.verdict()) {
            (RatingState::NotJudged(_), _) if rating.is_open() => &mut self.inconclusive,
            (RatingState::NotJudged(_), _) => &mut self.skipped,
            (_, Some(Verdict::Passed)) => &mut self.passed,
            (_, Some(Verdict::Failed)) => &mut self.failed,
            (_, Some(Verdict::Inconclusive)) => &mut self.inconclusive,
            (_, None) => &mut self.not_judged,
        } += 1;
    }

    fn add_gate(&mut self, gate: &GateReport) {
        self.all += 1;
        self.gates += 1;
        *match (&gate.state, gate.verdict()) {
            (GateState::NotJudged(_), _) if gate.is_open() => &mut self.inconclusive,
            (GateState::NotJudged(_), _) => &mut self.skipped,
            (_, Some(Verdict::Passed)) => &mut self.passed,
            (_, Some(Verdict::Failed)) => &mut self.failed,
            (_, Some(Verdict::Inconclusive)) => &mut self.inconclusive,
            (_, None) => &mut self.errors,
        } += 1;
    }

    fn add_block(&mut self, block: &BlockReport) {
        self.all += 1;
        self.blocks += 1;
        *match (&block.state, block.verdict()) {
            (BlockState::Skipped(_), _) => &mut self.skipped,
            (BlockState::Errored(_), _) => &mut self.errors,
            (BlockState::NotFinished(_), _) => &mut self.not_finished,
            (_, Some(Verdict::Failed)) => &mut self.failed,
            (_, Some(Verdict::Inconclusive)) => &mut self.inconclusive,
            (_, Some(Verdict::Passed)) => &mut self.passed,
            (_, None) => &mut self.found,
        } += 1;
        self.evaluations += block.result().map_or(0, BlockResult::evaluations);
    }

    fn add(&mut self, trial: &TrialReport) {
        self.all += 1;
        self.trials += 1;
        self.runs += trial.made();
        *match (&trial.state, trial.verdict()) {
            (TrialState::Skipped(_), _) => &mut self.skipped,
            (TrialState::NotFinished(_), _) => &mut self.not_finished,
            _ if trial.claims_nothing() => &mut self.not_judged,
            (_, Some(Verdict::Passed)) => &mut self.passed,
            (_, Some(Verdict::Failed)) => &mut self.failed,
            (_, Some(Verdict::Inconclusive)) => &mut self.inconclusive,
            (_, None) => &mut self.errors,
        } += 1;
    }
}

fn suite<'r>(
    report: &SuiteReport,
    requests: &'r Requests,
    drawn: &[Recording],
    animated: &[String],
) -> Suite {
    let mut counts = Counts { evaluations: report.evaluations(), ..Counts::default() };
    report.trials.iter().for_each(|trial| counts.add(trial));
    // In one unit for all trials, which may be filtered and sorted together.
    let criteria = || report.trials.iter().flat_map(|trial| trial.trial.criteria.iter());
    let column = |(index, reference): (usize, &'r MetricReference)| {
        let metric = reference.known()?;
        let unit = written_unit(criteria(), reference, metric);
        Some(Column { index, metric, label: reference.label(), unit, members: Vec::new() })
    };
    let columns: Vec<Column> = requests.iter().enumerate().filter_map(column).collect();
    let heading = |column: &Column| {
        let (label, below) = column.heading();
        Heading { label, below, about: column.metric.declaration.summary.to_string() }
    };
    Suite {
        name: report.identity.suite.to_string(),
        file: report.identity.file.to_string(),
        seed: report.identity.seed_words().trim_start_matches("seed ").to_string(),
        seconds: format!("{:.2}", report.wall_time.as_secs_f64()),
        counts,
        controllers: report.controllers.iter().filter_map(controllers::in_words).collect(),
        notes: report
            .people
            .iter()
            .map(|one| format!("People of {}.", one.in_words()))
            .chain(several_claims(report).map(|said| format!("{said}.")))
            .collect(),
        warnings: report
            .controllers
            .iter()
            .filter_map(TestedController::nondeterminism)
            .chain(report.people.iter().filter_map(|one| one.warning.clone()))
            .collect(),
        statements: Statements::new(report),
        scenarios: all_scenarios(report, &columns, animated),
        figures: figures(report, requests, drawn).into_iter().map(HtmlFigure::from).collect(),
        replay: report.identity.replay_command("{run}"),
        blocks: block::BlockSection::all(report),
        gates: gate::GateSection::all(report),
        ratings: rating::RatingSection::all(report),
        metrics: columns.iter().map(heading).collect(),
    }
}

/// Every scenario; several without variations stand in one table, which comes last.
fn all_scenarios(report: &SuiteReport, columns: &[Column], animated: &[String]) -> Vec<Scenario> {
    let is_single = |trials: &[&TrialReport]| trials.len() == 1 && short_name(trials[0]).is_empty();
    let all = report.scenarios();
    let singles: Vec<_> = all.iter().filter(|(_, trials)| is_single(trials)).collect();
    let together = singles.len() > 1;
    let apart = all.iter().filter(|(_, trials)| !together || !is_single(trials));
    let mut shown: Vec<Scenario> =
        apart.map(|(name, trials)| scenario(report, name, trials, columns, animated)).collect();
    if together {
        let trials: Vec<_> = singles.iter().flat_map(|(_, trials)| trials.iter().copied()).collect();
        let mut table = scenario(report, "", &trials, columns, animated);
        table.name = format!("{} scenarios without variations", singles.len());
        table.variations = "scenario".to_string();
        table.doc = String::new();
        table.tags.retain(|tag| trials.iter().all(|trial| trial.trial.tags.contains(tag)));
        for row in &mut table.trials {
            if let Some(trial) = trials.iter().find(|trial| trial.trial.key == row.key) {
                row.name = trial.trial.scenario.clone();
                row.doc = trial.trial.doc.clone().unwrap_or_default();
            }
        }
        shown.push(table);
    }
    shown
}

fn scenario(
    report: &SuiteReport,
    name: &str,
    trials: &[&TrialReport],
    columns: &[Column],
    animated: &[String],
) -> Scenario {
    let mut counts = Counts::default();
    trials.iter().for_each(|trial| counts.add(trial));
    let mut criteria: Vec<String> = Vec::new();
    for criterion in trials.iter().flat_map(|trial| trial.trial.criteria.iter()) {
        if !criteria.contains(&criterion.text) {
            criteria.push(criterion.text.clone());
        }
    }
    let mut ran: Vec<_> = trials.iter().copied().filter(|trial| !trial.skipped()).collect();
    let long = ran.len() > LONG_TABLE;
    if long {
        ran.sort_by_key(|trial| trial.verdict() == Some(Verdict::Passed));
    }
    let mut left_out = Vec::new();
    if ran.len() > MOST_TRIALS {
        let rest = ran.split_off(MOST_TRIALS);
        let bad = rest.iter().filter(|trial| trial.verdict() != Some(Verdict::Passed)).count();
        left_out.push(format!(
            "{} more trials are not shown here, {bad} of which did not pass; --json, --runs and --csv have all",
            rest.len()
        ));
    }
    let mut shown: Vec<Trial> =
        ran.into_iter().map(|one| trial(report, one, &criteria, columns, animated)).collect();
    let failures = shown.iter_mut().filter(|trial| trial.failure.is_some()).skip(MOST_FAILURES);
    let unwritten = failures.map(|trial| trial.failure = None).count();
    if unwritten > 0 {
        left_out
            .push(format!("{unwritten} more trials did not pass and are not written out; --json has all"));
    }
    let first = trials.first().map(|trial| &trial.trial);
    let variation = first.map(|trial| trial.variation.as_slice());
    let names: Vec<_> = variation.unwrap_or_default().iter().map(|one| one.name.as_str()).collect();
    Scenario {
        name: name.to_string(),
        doc: first.and_then(|trial| trial.doc.clone()).unwrap_or_default(),
        tags: first.map(|trial| trial.tags.clone()).unwrap_or_default(),
        counts,
        variations: names.join(", "),
        trials: shown,
        skipped: skipped(trials),
        left_out,
        long,
        criteria,
    }
}

/// The reasons for which trials were skipped, each with its count.
fn skipped(trials: &[&TrialReport]) -> Vec<String> {
    let mut reasons: Vec<(&Skip, usize)> = Vec::new();
    for trial in trials {
        let TrialState::Skipped(reason) = &trial.state else { continue };
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => reasons.push((reason, 1)),
        }
    }
    reasons.into_iter().map(|(reason, count)| format!("{count} skipped: {reason}")).collect()
}

fn trial(
    report: &SuiteReport,
    trial: &TrialReport,
    criteria: &[String],
    columns: &[Column],
    animated: &[String],
) -> Trial {
    let findings = trial.findings();
    let (state, mark) = match (&trial.state, judged_words(trial)) {
        (_, Some(said)) => said,
        (TrialState::NotFinished(_), None) => ("not finished", "■"),
        (_, None) => ("error", "!"),
    };
    let of = |finding| cell(finding, &trial.trial.key);
    let cell = |text: &String| findings.iter().find(|finding| finding.criterion == *text).map(of);
    let name = short_name(trial);
    Trial {
        key: trial.trial.key.clone(),
        name: if name.is_empty() { "all runs".into() } else { name },
        doc: String::new(),
        runs: trial.made(),
        stopping: trial.stopping().map(stopping),
        warnings: trial_warnings(trial),
        state,
        mark,
        cells: criteria.iter().map(cell).collect(),
        metrics: columns.iter().map(|column| column.cell(trial)).collect(),
        failure: failure(report, trial, findings, animated),
    }
}

/// What was found in the trial of that key.
fn cell(finding: &Finding, key: &str) -> Cell {
    Cell {
        verdict: verdict_word(finding.verdict),
        mark: if finding.untested.is_some() { "⚠" } else { verdict_mark(finding.verdict) },
        observed: observed(finding),
        interval: interval(finding),
        details: details(finding),
        // The trial's own name need not be repeated in its row.
        nearest: nearest_run(finding).map(|run| run.replace(&format!("{key}/"), "")),
    }
}

fn details(finding: &Finding) -> String {
    // Most bounds stand in the heading already.
    let bound = bound(finding);
    let told = finding.measure == FindingMeasure::EveryRun || finding.criterion.contains(&bound);
    let bound = (!told).then(|| format!("bound {bound}"));
    let margin = margin(finding).map(|margin| format!("margin {margin}"));
    let untested = finding.untested.as_ref().map(|_| "untested".to_string());
    [untested, bound, margin, missing(finding)].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn failure(
    report: &SuiteReport,
    trial: &TrialReport,
    findings: &[Finding],
    animated: &[String],
) -> Option<Failure> {
    if trial.verdict() == Some(Verdict::Passed) {
        return None;
    }
    let mut commands: Vec<ReplayCommand> = Vec::new();
    let bad = findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
    for run in bad.filter_map(|finding| finding.worst.first()) {
        if !commands.iter().any(|known| known.key == run.key) {
            commands.push(ReplayCommand::of_run(report, &run.key, animated));
        }
    }
    if let Some(first) = trial.error().and_then(|error| error.faults.first()) {
        commands.push(ReplayCommand::of_run(report, &first.run, animated));
    }
    Some(Failure { text: render_failure(&report.identity, &trial.state, false), commands })
}
