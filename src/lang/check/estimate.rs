//! `estimate NAME { … }`

use super::block::{Layer, missing, reject_repeats};
use super::comparison::constant_comparison;
use super::estimate_claim::{bad, claim, suffices};
use super::exposure::exposure;
use super::literal;
use super::metric::metric_reference;
use super::places::TextPlaces;
use super::subject::{StatementSubject, Subjects};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax;
use crate::syntax::ast;
use crate::value::NameScope;
use scenario::{
    DeclaredPedestrian, Estimate, EstimateMethod, FEWEST_ESTIMATE_RUNS, MetricKind, MetricReference,
    PopulationShare, Scenario, Worst,
};

/// As many runs as a suite may have.
const MOST_RUNS: u32 = 10_000_000;
/// The estimate at `node`.
pub fn estimate(
    node: ast::Estimate,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Estimate> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = format!("estimate `{}`", name.text());
    let is_compared = block.compared_with().is_some();
    let budget = match block.budget() {
        Some(said) => budget(said, is_compared, report),
        None => {
            missing::<ast::EstimateBudget>(&layers, name.span(), &what, report);
            None
        }
    };
    let method = match block.budget().and_then(ast::EstimateBudget::method) {
        Some(method) if method.is_crude() => EstimateMethod::Crude,
        Some(method) if method.is_splitting() => EstimateMethod::Splitting,
        _ => EstimateMethod::Importance,
    };
    let exposure = match block.exposure() {
        Some(said) => Some(exposure(said, scope, places, report)?),
        None => None,
    };
    let claims: Vec<_> = block
        .claims()
        .map(|node| claim(node, exposure.as_ref(), is_compared, scope, places, report))
        .collect();
    let Some(of) = block.of().map(ast::EstimateOf::name) else {
        missing::<ast::EstimateOf>(&layers, name.span(), &what, report);
        return None;
    };
    let subject = subjects.scenario(of.span(), of.text(), &[], places, report)?;
    let is_drawn = draws(of.span(), &subject, report);
    let compared = match block.compared_with().map(ast::ComparedWith::name) {
        Some(with) => {
            let other = subjects.scenario(with.span(), with.text(), &[], places, report)?;
            Some(draws_the_same(with.span(), subject.scenario, other, report)?)
        }
        None => None,
    };
    let cast = subject.cast();
    let event = match block.event() {
        Some(event) => {
            let text = syntax::condition_text(event.condition(), event.undefined());
            constant_comparison(
                (event.condition(), event.undefined(), "the bound of the event"),
                &cast,
                scope,
                report,
            )
            .map(|event| (event, text))
        }
        None => {
            missing::<ast::Event>(&layers, name.span(), &what, report);
            None
        }
    };
    let score = match block.score() {
        Some(said) => {
            let reference = metric_reference(said.metric(), &cast, scope, report);
            Some(reference.and_then(|(reference, found)| {
                let slopes = matches!(found.kind, MetricKind::Quantity(_)) && found.worst != Worst::Neither;
                score(said.span(), reference, slopes, report)
            })?)
        }
        None if method == EstimateMethod::Crude => None,
        None => {
            missing::<ast::Score>(&layers, name.span(), &what, report);
            return None;
        }
    };
    let (budget, claims) = (budget?, claims.into_iter().collect::<Option<Vec<_>>>()?);
    let (event, event_text) = event?;
    if let Some((other, node)) = compared.as_ref().zip(block.event()) {
        let cast = other.cast();
        constant_comparison(
            (node.condition(), node.undefined(), "the bound of the event"),
            &cast,
            scope,
            report,
        )?;
        block
            .score()
            .map_or(Some(()), |said| metric_reference(said.metric(), &cast, scope, report).map(|_| ()))?;
    }
    let estimate = Estimate {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        scenario: subject.scenario.name.clone(),
        compared_with: compared.map(|other| other.scenario.name.clone()),
        event,
        event_text,
        score,
        budget,
        method,
        exposure,
        claims,
        origin: places.origin(name.span()),
    };
    let mut said = block.claims().zip(&estimate.claims);
    let can = said.all(|(node, claim)| suffices(node, claim, estimate.encounters(), method, report));
    (is_drawn && can).then_some(estimate)
}

fn budget(node: ast::EstimateBudget, is_compared: bool, report: &mut Vec<Diagnostic>) -> Option<u32> {
    let runs = literal::count(node.runs(), 1, MOST_RUNS, "the number of runs", report)?;
    let (fewest, each) = if is_compared {
        (2 * FEWEST_ESTIMATE_RUNS, ", half of them of each scenario")
    } else {
        (FEWEST_ESTIMATE_RUNS, "")
    };
    if runs < fewest {
        report.push(
            Diagnostic::new(
                Code::BudgetTooSmall,
                node.runs().span(),
                format!("{runs} runs are too few for 20 independent replicates{each}"),
            )
            .label("too few")
            .hint(format!("take at least {fewest}, and rather 20000")),
        );
        return None;
    }
    Some(runs)
}

/// Whether the scenario is one population of runs that differ by what is drawn.
fn draws(span: Span, subject: &StatementSubject, report: &mut Vec<Diagnostic>) -> bool {
    let scenario = subject.scenario;
    if !scenario.variations.is_empty() {
        let names: Vec<_> =
            scenario.variations.iter().flat_map(|one| one.names()).map(String::as_str).collect();
        report.push(
            bad(span, format!("`{}` varies `{}`: that is several trials", scenario.name, names.join("`, `")))
                .label("not one population of runs")
                .hint("let it `draw` them, or write a scenario with one value"),
        );
        return false;
    }
    let several = scenario.pedestrians.iter().find(|person| {
        let chosen = person.individuals.as_ref().map(|one| &one.selection);
        matches!(chosen, Some(PopulationShare::All | PopulationShare::Count(_)))
    });
    if let Some(person) = several {
        report.push(
            bad(span, format!("`{}` of `{}` is several people in turn", person.name, scenario.name))
                .label("not one population of runs")
                .hint("say `individuals drawn from standard`, or take one: `individual 17 of standard`"),
        );
        return false;
    }
    if !scenario.is_drawn() {
        report.push(
            bad(span, format!("`{}` draws nothing that could be looked into", scenario.name))
                .label("no run differs by what is drawn")
                .hint(
                    "say what differs from run to run, such as `draw tta from normal(9 s, 1.5 s)` or \
                       `individuals drawn from standard`",
                ),
        );
        return false;
    }
    true
}

/// `other`, if a run of it can be in each encounter of `one`: drawn the same, with the same chance.
fn draws_the_same<'a>(
    span: Span,
    one: &Scenario,
    other: StatementSubject<'a>,
    report: &mut Vec<Diagnostic>,
) -> Option<StatementSubject<'a>> {
    let with = other.scenario;
    if with.name == one.name {
        report.push(bad(span, format!("`{}` is compared with itself", one.name)).label("the same").hint(
            format!("name another, such as `scenario before : {} {{ … }}` with another controller", one.name),
        ));
        return None;
    }
    let different = if !draws(span, &other, report) {
        return None;
    } else if !same_draws(one, with) {
        Some("draws other values than")
    } else if who_is_drawn(one) != who_is_drawn(with) {
        Some("draws other people than")
    } else if one.seed != with.seed {
        Some("has another seed than")
    } else {
        None
    };
    match different {
        None => Some(other),
        Some(different) => {
            report.push(
                bad(span, format!("`{}` {different} `{}`", with.name, one.name))
                    .label("its runs are not in the same encounters")
                    .hint(format!(
                        "let it build on the other: `scenario {} : {} {{ … }}`, with what is tested said anew",
                        with.name, one.name
                    )),
            );
            None
        }
    }
}

/// Whether both draw the same values, one after the other, from the same.
fn same_draws(one: &Scenario, other: &Scenario) -> bool {
    let drawn = |scenario: &'_ Scenario| -> Vec<_> {
        scenario.draws.iter().map(|draw| (draw.names.clone(), draw.from.clone())).collect()
    };
    drawn(one) == drawn(other)
}

/// The pedestrians who are somebody else in every run, and from which population.
fn who_is_drawn(scenario: &Scenario) -> Vec<(&str, Option<&str>)> {
    let drawn = |person: &&DeclaredPedestrian| {
        person.individuals.as_ref().is_some_and(|one| one.selection == PopulationShare::Drawn)
    };
    let who = scenario.pedestrians.iter().filter(drawn);
    who.map(|one| (one.name.as_str(), one.individuals.as_ref().map(|one| one.population.as_str()))).collect()
}

/// Metrics that are the same in all runs in which nobody comes near.
const FLAT: [&str; 1] = ["min_distance"];

fn score(
    span: Span,
    reference: MetricReference,
    slopes: bool,
    report: &mut Vec<Diagnostic>,
) -> Option<MetricReference> {
    if !slopes {
        report.push(
            bad(span, format!("`{}` is nothing that gets worse towards an event", reference.name()))
                .label("no score")
                .hint("take a quantity, such as `score pet` or `score min_ttc`"),
        );
        return None;
    }
    if FLAT.contains(&reference.name()) {
        report.push(
            Diagnostic::new(
                Code::FlatScore,
                span,
                format!("`{}` is flat where nobody comes near", reference.name()),
            )
            .label("does not slope towards the event")
            .hint("take a time, such as `score pet` or `score min_ttc`"),
        );
    }
    Some(reference)
}
