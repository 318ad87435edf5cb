//! The end of a session: tables and results, failures once more where they have scrolled away, and the summary.

use std::collections::HashSet;
use std::time::Duration;

use super::lines::{Bad, Lines};
use super::status;
use crate::experiment::render_block;
use crate::format::count;
use crate::groups::{Group, groups};
use crate::statement::render_statements;
use crate::table::render_tables;
use crate::wording::{FOUND, several_claims};
use files::escape::{terminal, terminal_line};
use results::{
    BlockReport, BlockResult, CutBy, Requests, Skip, Standing, StandingCount, StatementResult, SuiteIdentity,
    SuiteReport, Verdict, Workload,
};

/// A failure that is farther up than this is shown again.
const SCREEN: usize = 100;
/// Failures shown again; more would scroll each other away.
const MOST_AGAIN: usize = 10;
/// Units that did not pass and are named below the summary.
const MOST_NAMED: usize = 50;

impl Lines {
    /// Says how all of it ended; `bad` did not pass.
    pub fn end(&mut self, bad: &[Bad], reports: &[SuiteReport], requests: &Requests, elapsed: Duration) {
        for report in reports {
            self.suite(report, requests);
        }
        let causes: Vec<_> = reports.iter().map(|report| (report, groups(report))).collect();
        self.failures_again(bad, &causes);
        let tally = Standings::of(reports);
        let style = if tally.failed + tally.errored + tally.timed_out > 0 {
            status::BAD
        } else if tally.inconclusive + tally.interrupted + tally.not_run > 0 {
            status::DOUBTFUL
        } else {
            status::GOOD
        };
        self.gap();
        self.say(&"─".repeat(12));
        let time = status::seconds(elapsed);
        let line = status::line("Summary", style, Some(&time), &tally.in_words(), self.colour);
        self.say(&line);
        self.what_did_not_pass(bad, &causes);
    }

    /// Tables of the trials and what the blocks came to.
    fn suite(&mut self, report: &SuiteReport, requests: &Requests) {
        let summary = report.summary();
        let trials = summary.ran();
        let results: Vec<_> = report.blocks.iter().filter_map(BlockReport::result).collect();
        if trials == 0 && results.is_empty() {
            return;
        }
        self.gap();
        if trials > 0 {
            let tables = render_tables(report, requests, self.colour);
            self.say(&tables);
        }
        for result in &results {
            self.gap();
            self.say(&terminal(&render_block(result)));
        }
        let statements: Vec<_> = results.iter().filter_map(|result| statement(result)).collect();
        if statements.len() > 1 {
            self.gap();
            self.say(&terminal(&render_statements(&statements)));
        }
        self.gap();
        let identity = &report.identity;
        let mut parts = Vec::new();
        if trials > 0 {
            parts.extend([count(trials, "trial"), count(summary.runs(), "run")]);
        }
        let blocks = report.blocks.iter().filter(|block| !block.skipped()).count();
        if blocks > 0 {
            parts.push(count(blocks, "block"));
        }
        if report.evaluations() > 0 {
            parts.push(count(report.evaluations(), "evaluation"));
        }
        let suite = terminal_line(&identity.suite);
        let seed = identity.seed_words();
        self.say(&format!("{suite}: {}, {}\n", parts.join(", "), terminal_line(&seed)));
        if let Some(said) = several_claims(report) {
            self.say(&format!("{:>width$}  {said}\n", "", width = suite.chars().count()));
        }
    }

    /// What did not pass and cannot be seen any more, or was not shown at all. Of failures of one cause it is the worst.
    fn failures_again(&mut self, bad: &[Bad], causes: &[Causes]) {
        let groups = || causes.iter().flat_map(|(_, groups)| groups);
        let stands_for_others = |key: &str| groups().any(|group| group.worst.0 == key);
        let in_any: HashSet<&str> = groups().flat_map(|group| group.trials.iter().copied()).collect();
        let is_shown = |one: &&Bad| !in_any.contains(one.key.as_str()) || stands_for_others(&one.key);
        let is_far = |one: &&Bad| one.shown.is_none_or(|line| self.count - line > SCREEN);
        let far: Vec<_> = bad.iter().filter(is_shown).filter(is_far).take(MOST_AGAIN).collect();
        for one in far {
            self.gap();
            self.say(&format!("{}\n\n{}\n", one.line, one.text.trim_end()));
        }
    }

    /// The names of what did not pass: failures of one cause together and with a command, worst first, then all others.
    fn what_did_not_pass(&mut self, bad: &[Bad], causes: &[Causes]) {
        let mut said = Vec::new();
        let mut grouped: HashSet<&str> = HashSet::new();
        for (report, group) in
            causes.iter().flat_map(|(report, groups)| groups.iter().map(move |one| (report, one)))
        {
            if group.trials.len() > 1 {
                grouped.extend(&group.trials);
                said.push(self.cause(&report.identity, group));
            }
        }
        said.extend(bad.iter().filter(|one| !grouped.contains(one.key.as_str())).map(|one| one.line.clone()));
        said.iter().take(MOST_NAMED).for_each(|one| self.say(one));
        if said.len() > MOST_NAMED {
            self.say(&format!("{:>12} and {} more", "", said.len() - MOST_NAMED));
        }
    }

    fn cause(&self, suite: &SuiteIdentity, group: &Group) -> String {
        let (verb, style) = match group.verdict {
            Verdict::Inconclusive => ("INCONCLUSIVE", status::DOUBTFUL),
            _ => ("FAIL", status::BAD),
        };
        let what = format!("{}/{}: `{}` {}", suite.suite, group.scenario, group.criterion, group.in_words());
        let mut text = status::line(verb, style, None, &what, self.colour);
        if let Some(run) = group.run() {
            let again = suite.replay_command(run);
            text += &format!("\n{:>12} worst of them: {}", "", terminal_line(&again));
        }
        text
    }
}

/// A suite with what did not hold in it.
type Causes<'r, 's> = (&'r SuiteReport, Vec<Group<'r>>);

fn statement(result: &BlockResult) -> Option<&StatementResult> {
    match result {
        BlockResult::Statement(statement) => Some(statement),
        _ => None,
    }
}

/// What is going to be done, in words.
pub(super) fn starting(outline: &Workload) -> String {
    let mut parts = Vec::new();
    if outline.trials > 0 {
        let runs = match outline.certain_runs {
            certain if certain == outline.runs => count(outline.runs, "run"),
            certain => format!("{certain} to {}", count(outline.runs, "run")),
        };
        parts.push(format!("{} with {runs}", count(outline.trials, "trial")));
    }
    if outline.blocks > 0 {
        parts.push(count(outline.blocks, "block"));
    }
    let recorded = count(outline.recorded, "recorded failure");
    let mut text = if parts.is_empty() { recorded.clone() } else { parts.join(" and ") };
    if outline.suites > 1 {
        text += &format!(" of {}", count(outline.suites, "suite"));
    }
    if outline.recorded > 0 && !parts.is_empty() {
        text += &format!(", after {recorded}");
    }
    if outline.left_out > 0 {
        text += &format!("; {} not selected", outline.left_out);
    }
    text
}

/// Units by how they stand.
#[derive(Debug, Default)]
struct Standings {
    passed: usize,
    /// Trials to which no criterion applied.
    not_judged: usize,
    /// Searches that expect nothing of what they found.
    found: usize,
    failed: usize,
    inconclusive: usize,
    errored: usize,
    /// Cut off by the time limit, and by somebody or a gate.
    timed_out: usize,
    interrupted: usize,
    not_run: usize,
    not_selected: usize,
    /// Units with something that passed without being put to the test.
    untested: usize,
    /// Trials in which a vehicle left its carriageway.
    left_road: usize,
    /// Runs that the horizon ended.
    cut_off: usize,
    recorded: usize,
    trials: usize,
    runs: usize,
    blocks: usize,
    /// Of searches and tunes.
    evaluations: usize,
}

impl Standings {
    fn of(reports: &[SuiteReport]) -> Self {
        let mut tally = Self::default();
        for report in reports {
            for recorded in &report.recorded {
                tally.recorded += usize::from(recorded.rerun().is_some());
                tally.add(recorded.standing(), recorded.skip(), 1);
            }
            let summary = report.summary();
            tally.trials += summary.ran();
            tally.runs += summary.runs();
            tally.untested += report.untested();
            tally.left_road += summary.scenarios.iter().map(|scenario| scenario.left_road).sum::<usize>();
            tally.evaluations += report.evaluations();
            tally.cut_off += summary.scenarios.iter().map(|scenario| scenario.cut_off).sum::<usize>();
            for StandingCount { standing, skip, trials } in summary.standings() {
                tally.add(*standing, skip.as_ref(), *trials);
            }
            for block in &report.blocks {
                tally.blocks += usize::from(!block.skipped());
                tally.add(block.standing(), block.skip(), 1);
            }
        }
        tally
    }

    fn add(&mut self, standing: Standing, skip: Option<&Skip>, units: usize) {
        *match standing {
            Standing::NotJudged => &mut self.not_judged,
            Standing::Found => &mut self.found,
            Standing::Judged(Verdict::Passed) => &mut self.passed,
            Standing::Judged(Verdict::Failed) => &mut self.failed,
            Standing::Judged(Verdict::Inconclusive) => &mut self.inconclusive,
            Standing::Errored => &mut self.errored,
            Standing::NotFinished(CutBy::TimeLimit) => &mut self.timed_out,
            Standing::NotFinished(CutBy::Interrupted | CutBy::GateFailed) => &mut self.interrupted,
            Standing::Skipped if skip == Some(&Skip::NotSelected) => &mut self.not_selected,
            Standing::Skipped => &mut self.not_run,
        } += units;
    }

    fn in_words(&self) -> String {
        let mut what = Vec::new();
        if self.trials > 0 || self.blocks + self.recorded == 0 {
            what.extend([count(self.trials, "trial"), count(self.runs, "run")]);
        }
        if self.blocks > 0 {
            what.push(count(self.blocks, "block"));
        }
        if self.evaluations > 0 {
            what.push(count(self.evaluations, "evaluation"));
        }
        if self.recorded > 0 {
            what.push(count(self.recorded, "recorded failure"));
        }
        let numbers = [
            (self.passed, "passed"),
            (self.failed, "failed"),
            (self.inconclusive, "inconclusive"),
            (self.errored, "could not be run"),
            (self.timed_out + self.interrupted, "not finished"),
            (self.not_judged, "not judged"),
            (self.found, FOUND),
            (self.not_run, "not run"),
        ];
        let numbers = numbers.iter().filter(|(number, _)| *number > 0);
        let said: Vec<_> = numbers.map(|(number, word)| format!("{number} {word}")).collect();
        let said = if said.is_empty() { "0 passed".to_string() } else { said.join(", ") };
        let left_out = match self.not_selected {
            0 => String::new(),
            number => format!("; {number} not selected"),
        };
        let untested = match self.untested {
            0 => String::new(),
            number => format!("; {number} with untested criteria"),
        };
        let left_road = match self.left_road {
            0 => String::new(),
            number => format!("; in {number} a vehicle left the road"),
        };
        let cut_off = match self.cut_off {
            0 => String::new(),
            number => format!("; {} ended at the horizon", count(number, "run")),
        };
        format!("{}: {said}{left_out}{untested}{left_road}{cut_off}", what.join(", "))
    }
}
