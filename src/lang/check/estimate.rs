//! `estimate NAME { … }`

use super::block::{Layer, missing, reject_repeats};
use super::comparison::constant_comparison;
use super::criterion;
use super::literal;
use super::metric::metric_reference;
use super::places::Places;
use super::subject::{StatementSubject, Subjects};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax;
use crate::syntax::ast;
use crate::value::{self, NameScope};
use scenario::{
    Dimension, Estimate, EstimateClaim, EstimateMethod, Exposure, FEWEST_ESTIMATE_RUNS, MetricKind,
    MetricReference, PopulationShare, Relation, Worst,
};

/// As many runs as a suite may have.
const MOST_RUNS: u32 = 10_000_000;
/// Where nothing is said.
const CONFIDENCE: f64 = 0.95;

/// The estimate at `node`.
pub fn estimate(
    node: ast::Estimate,
    subjects: &Subjects,
    scope: &NameScope,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Estimate> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = format!("estimate `{}`", name.text());
    let budget = match block.budget() {
        Some(said) => budget(said, report),
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
    let claims: Vec<_> =
        block.claims().map(|claim| self::claim(claim, exposure.as_ref(), scope, places, report)).collect();
    let Some(of) = block.of().map(ast::EstimateOf::name) else {
        missing::<ast::EstimateOf>(&layers, name.span(), &what, report);
        return None;
    };
    let subject = subjects.scenario(of.span(), of.text(), &[], places, report)?;
    let is_drawn = draws(of.span(), &subject, report);
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
    let can = block.claims().zip(&claims).all(|(node, claim)| suffices(node, claim, budget, method, report));
    let (event, event_text) = event?;
    (is_drawn && can).then_some(Estimate {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        scenario: subject.scenario.name.clone(),
        event,
        event_text,
        score,
        budget,
        method,
        exposure,
        claims,
        origin: places.origin(name.span()),
    })
}

fn bad(span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Code::BadEstimate, span, message)
}

fn budget(node: ast::EstimateBudget, report: &mut Vec<Diagnostic>) -> Option<u32> {
    let runs = literal::count(node.runs(), 1, MOST_RUNS, "the number of runs", report)?;
    if runs < FEWEST_ESTIMATE_RUNS {
        report.push(
            Diagnostic::new(
                Code::BudgetTooSmall,
                node.runs().span(),
                format!("{runs} runs are too few for 20 independent replicates"),
            )
            .label("too few")
            .hint(format!("take at least {FEWEST_ESTIMATE_RUNS}, and rather 20000")),
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

fn claim(
    node: ast::EstimateClaim,
    exposure: Option<&Exposure>,
    scope: &NameScope,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<EstimateClaim> {
    if node.relation().meaning() != Relation::LessOrEqual {
        report.push(
            bad(node.relation().span(), "a claim says what the probability is at most")
                .label("not `<=`")
                .hint("write `claim <= 1e-5`"),
        );
        return None;
    }
    let what = "the probability";
    let mut numbers = node.numbers();
    let (bound, along) = (numbers.next()?, numbers.next());
    let value = value::quantity_of(bound, Dimension::NUMBER, what, scope, report)?;
    let said = value
        .as_constant_number()
        .or_else(|| value::not_constant(value.span, &value.expression, what, report))?;
    let mut confidence = match node.confidence() {
        Some(said) => criterion::share(said.value(), "the confidence", true, scope, report)?,
        None => CONFIDENCE,
    };
    let (at_most, per_1000_km) = match along {
        None => (said, None),
        Some(along) => {
            let events = said * THOUSAND_KILOMETRES / distance(along, scope, report)?;
            let Some(exposure) = exposure else {
                report.push(
                    Diagnostic::new(
                        Code::BadExposure,
                        node.span(),
                        "nothing says how many encounters there are",
                    )
                    .label("events along a distance")
                    .hint("say it, with its source: `exposure 3 .. 12 encounters per 1000 km source \"…\"`"),
                );
                return None;
            };
            // What the exposure may be wrong by is taken from what the claim may.
            confidence += exposure.confidence.map_or(0.0, |sure| 1.0 - sure);
            if confidence >= 1.0 {
                report.push(
                    Diagnostic::new(
                        Code::BadExposure,
                        node.span(),
                        "the exposure is less sure than the claim: no number of runs can show it",
                    )
                    .label("cannot be shown, whatever comes of the runs")
                    .hint("claim it with less confidence, or give an exposure that is surer, which is a wider range"),
                );
                return None;
            }
            if events >= exposure.high {
                report.push(
                    Diagnostic::new(
                        Code::BadExposure,
                        bound.span(),
                        format!(
                            "there are at most {} encounters in 1,000 km: it holds if every one of them is an event",
                            scenario::significant(exposure.high, 6)
                        ),
                    )
                    .label("holds whatever comes of the runs")
                    .hint("claim fewer events than there are encounters"),
                );
                return None;
            }
            (events / exposure.high, Some(events))
        }
    };
    if !(at_most > 0.0 && at_most < 1.0) {
        report.push(
            bad(bound.span(), format!("no runs show a probability of at most {at_most}"))
                .label("not between 0 and 1")
                .hint("write it as a number above 0, such as `1e-5`"),
        );
        return None;
    }
    let text = node.text().split_whitespace().collect::<Vec<_>>().join(" ");
    let guaranteed = node.is_guaranteed();
    Some(EstimateClaim {
        guaranteed,
        at_most,
        per_1000_km,
        confidence,
        text,
        origin: places.origin(node.span()),
    })
}

/// So far are distances that numbers of encounters are told for, m.
const THOUSAND_KILOMETRES: f64 = 1e6;

/// What encounters or events are counted along, m.
fn distance(node: ast::Expression, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<f64> {
    let every = (f64::NEG_INFINITY, f64::INFINITY);
    let along = value::constant_in(node, Dimension::LENGTH, every, "the distance", scope, report)?;
    if along > 0.0 && along.is_finite() {
        return Some(along);
    }
    report.push(
        Diagnostic::new(Code::BadExposure, node.span(), "encounters are counted along a distance above 0")
            .label("no distance")
            .hint("write `per 1000 km`"),
    );
    None
}

/// A number that somebody has to give: none of it has a default.
fn exposure(
    node: ast::Exposure,
    scope: &NameScope,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Exposure> {
    let numbers: Vec<ast::Expression> = node.numbers().collect();
    let (along, counts) = numbers.split_last()?;
    let Some(source) = node.source() else {
        report.push(
            Diagnostic::new(
                Code::BadExposure,
                node.span(),
                "nothing says how the number of encounters is known".to_string(),
            )
            .label("without a source")
            .hint("add `source \"…\"`: what was counted, where, when and by whom; that it is a guess can be said too"),
        );
        return None;
    };
    if counts.is_empty() {
        report.push(
            Diagnostic::new(Code::BadExposure, node.span(), "how many encounters there are is missing")
                .label("no number")
                .hint(
                    "give the number of such encounters where the system is to drive, such as `exposure 3 .. 12 encounters per 1000 km`: \
                     nobody else knows it, and there is no default",
                ),
        );
        return None;
    }
    let every = (f64::NEG_INFINITY, f64::INFINITY);
    let along = distance(*along, scope, report)?;
    let count = |one: &ast::Expression| {
        value::constant_in(*one, Dimension::NUMBER, every, "the number of encounters", scope, report)
    };
    let counts: Vec<f64> = counts.iter().map(count).collect::<Option<_>>()?;
    let (low, high) = (*counts.first()?, *counts.last()?);
    let mut wrong = |span: Span, message: String, label: &str, hint: &str| {
        report.push(Diagnostic::new(Code::BadExposure, span, message).label(label).hint(hint));
        None
    };
    if !(low >= 0.0 && high > 0.0 && high.is_finite()) {
        let message = format!("{low} .. {high} encounters: there must be some, or nothing is said");
        return wrong(
            numbers[0].span(),
            message,
            "not above 0",
            "write at least how many there are at most: `0 .. 3`",
        );
    }
    if low > high {
        let message = format!("at least {low} encounters and at most {high}");
        return wrong(numbers[0].span(), message, "more than the second", "write the smaller one first");
    }
    if source.value().trim().is_empty() {
        return wrong(
            source.span(),
            "nothing says how the number of encounters is known".to_string(),
            "empty",
            "say what was counted, where, when and by whom; a guess is a source too if it says that it is one",
        );
    }
    let confidence = match node.confidence() {
        Some(said) => Some(criterion::share(said.value(), "the confidence", true, scope, report)?),
        None => None,
    };
    let text = node.text().split_whitespace().collect::<Vec<_>>().join(" ");
    let per = THOUSAND_KILOMETRES / along;
    Some(Exposure {
        low: low * per,
        high: high * per,
        confidence,
        source: source.value(),
        text: text.split(" source ").next().unwrap_or_default().to_string(),
        origin: places.origin(node.span()),
    })
}

/// Whether the budget can show a claim at all.
fn suffices(
    node: ast::EstimateClaim,
    claim: &EstimateClaim,
    budget: u32,
    method: EstimateMethod,
    report: &mut Vec<Diagnostic>,
) -> bool {
    let nominal = method.nominal_runs(budget as usize) as u64;
    if !claim.guaranteed && method != EstimateMethod::Crude {
        return true;
    }
    let needed = claim.runs_needed();
    if needed.is_some_and(|needed| nominal >= needed) {
        return true;
    }
    let needed = needed.map_or_else(|| "more".to_string(), grouped);
    let level = scenario::significant(100.0 * claim.confidence, 6);
    let how = match method {
        EstimateMethod::Importance => "; `by importance` makes one in ten of the runs after its pilot such",
        EstimateMethod::Splitting => "; `by splitting` makes one in ten of the runs after its pilot such",
        EstimateMethod::Crude => "",
    };
    report.push(
        Diagnostic::new(
            Code::BudgetTooSmall,
            node.span(),
            format!(
                "this needs at least {needed} runs for {} at {level} %, and the budget has {} that are drawn as they are",
                number(claim.at_most),
                grouped(nominal)
            ),
        )
        .label("cannot be shown, whatever comes of the runs")
        .hint(format!(
            "raise the budget, or let the estimate decide: `claim <= {}`{how}",
            number(claim.at_most)
        )),
    );
    false
}

/// A probability, with a power of ten where it is small.
fn number(probability: f64) -> String {
    if probability < 1e-3 { format!("{probability:e}") } else { scenario::significant(probability, 6) }
}

/// With commas between thousands.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
