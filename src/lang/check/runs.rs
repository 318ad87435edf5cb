//! How many runs a scenario has and which seed: `repeat`, `runs` and `seed`.

use super::block::{Layer, last};
use super::defaults::Defaults;
use super::literal;
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use scenario::{AggregateBounds, Claim, Criterion, People, RunBudget};

/// More runs of one thing are taken for a mistake.
const MOST_RUNS: u32 = 1_000_000;

/// What a scenario says of its runs.
pub struct Runs {
    pub repeat: u32,
    pub budget: Option<RunBudget>,
    pub seed: Option<u64>,
}

/// What the layers say together. `criteria` are those that the runs are to decide.
pub fn runs(
    layers: &[Layer<ast::ScenarioBlock>],
    criteria: &[(Span, Criterion)],
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Runs> {
    let (repeat, budget) = match last(layers, ast::ScenarioBlock::run_count).map(|said| said.node) {
        None => (Some(Defaults::REPEAT), Some(None)),
        Some(ast::RunCount::Runs(node)) => {
            refuse_means(criteria, report);
            refuse_all_people(criteria, report);
            (Some(Defaults::REPEAT), budget(node, places, report).map(Some))
        }
        Some(ast::RunCount::Repeat(node)) => {
            (literal::count(node.count(), 1, MOST_RUNS, "the number of repetitions", report), Some(None))
        }
    };
    let seed = match last(layers, ast::ScenarioBlock::seed) {
        Some(said) => literal::whole(said.node.number(), report).map(Some),
        None => Some(None),
    };
    Some(Runs { repeat: repeat?, budget: budget?, seed: seed? })
}

/// `repeat` and `runs` say the same thing.
pub fn reject_both(block: ast::ScenarioBlock, report: &mut Vec<Diagnostic>) {
    if let (Some(repeat), Some(runs)) = (block.repeat(), block.runs()) {
        let message = "`repeat` and `runs` both say how many runs there are";
        report.push(
            Diagnostic::new(Code::RepeatedStatement, runs.span(), message)
                .label("says it again")
                .context(repeat.span(), "said here")
                .hint("leave out one of them"),
        );
    }
}

/// `runs 50 .. 2000`
fn budget(node: ast::Runs, places: &TextPlaces, report: &mut Vec<Diagnostic>) -> Option<RunBudget> {
    let mut ends = node.ends();
    let mut end = |what: &str, least: u32| literal::count(ends.next()?, least, MOST_RUNS, what, report);
    let least = end("the smallest number of runs", 1)?;
    let most = end("the largest number of runs", least)?;
    Some(RunBudget { least, most, origin: places.origin(node.span()) })
}

/// Runs are added, not people.
fn refuse_all_people(criteria: &[(Span, Criterion)], report: &mut Vec<Diagnostic>) {
    let of_all =
        |criterion: &Criterion| criterion.reach.people == Some(People::All) && !criterion.reach.drawn_people;
    for (span, _) in criteria.iter().filter(|(_, criterion)| of_all(criterion)) {
        report.push(
            Diagnostic::new(
                Code::BadPeople,
                *span,
                "runs that are added are of the same people, and say no more of all people",
            )
            .label("speaks of all people")
            .hint(
                "let every run be of somebody else, `individuals drawn from standard`; or say `repeat` and take as many `individuals` \
                 as it needs",
            ),
        );
    }
}

/// Of means of metrics without limits no bound is known that stays true however often one looks.
fn refuse_means(criteria: &[(Span, Criterion)], report: &mut Vec<Diagnostic>) {
    for (span, criterion) in criteria {
        let Claim::Aggregate { aggregate, confidence: Some(_), .. } = &criterion.claim else { continue };
        if aggregate.bounds() != AggregateBounds::Mean {
            continue;
        }
        let metric = aggregate.metric();
        if metric.known().is_some_and(|known| known.limits(&metric.settings, 1.0).is_some()) {
            continue;
        }
        report.push(
            Diagnostic::new(
                Code::NotSequential,
                *span,
                "the confidence in a mean of a metric without limits needs a number of runs that is fixed beforehand",
            )
            .label("cannot be decided while runs are added")
            .hint("say `repeat` instead of `runs`, or bound a `median(…)`, `quantile(…)` or share"),
        );
    }
}
