//! `claim …` of an estimate: what a probability, a difference or a ratio is at most.

use super::criterion;
use super::exposure::{THOUSAND_KILOMETRES, distance};
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope};
use scenario::{Dimension, EstimateClaim, EstimateClaimOf, EstimateMethod, Exposure, Relation};

/// Where nothing is said.
const CONFIDENCE: f64 = 0.95;

/// What is wrong with an estimate.
pub fn bad(span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Code::BadEstimate, span, message)
}

/// The claim at `node`, of an estimate that is compared with something or not.
pub fn claim(
    node: ast::EstimateClaim,
    exposure: Option<&Exposure>,
    is_compared: bool,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<EstimateClaim> {
    let (of, what) = if node.is_difference() {
        (EstimateClaimOf::Difference, "the difference")
    } else if node.is_ratio() {
        (EstimateClaimOf::Ratio, "the ratio")
    } else {
        (EstimateClaimOf::Probability, "the probability")
    };
    if of != EstimateClaimOf::Probability && !is_compared {
        report.push(
            bad(node.span(), format!("nothing is compared that {what} could be of"))
                .label("of what and what?")
                .hint("name a scenario that draws the same: `compare with SCENARIO`"),
        );
        return None;
    }
    if node.relation().meaning() != Relation::LessOrEqual {
        report.push(
            bad(node.relation().span(), format!("a claim says what {what} is at most"))
                .label("not `<=`")
                .hint("write `claim <= 1e-5`, `claim difference <= 1e-6` or `claim ratio <= 1.2`"),
        );
        return None;
    }
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
        Some(along) if of == EstimateClaimOf::Ratio => {
            report.push(
                bad(along.span(), "a ratio is the same along any distance")
                    .label("without a meaning here")
                    .hint("leave `per …` out"),
            );
            return None;
        }
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
    let (possible, between, hint) = match of {
        EstimateClaimOf::Probability => (
            at_most > 0.0 && at_most < 1.0,
            "not between 0 and 1",
            "write it as a number above 0, such as `1e-5`",
        ),
        EstimateClaimOf::Difference => (
            at_most > -1.0 && at_most < 1.0,
            "not between -1 and 1",
            "write how much more probable it may be, such as `1e-6`, or `0`",
        ),
        EstimateClaimOf::Ratio => (
            at_most > 0.0 && at_most.is_finite(),
            "not above 0",
            "write how many times as probable it may be, such as `1.2`",
        ),
    };
    if !possible {
        let said = format!("no runs show that {what} is at most {at_most}");
        report.push(bad(bound.span(), said).label(between).hint(hint));
        return None;
    }
    let text = node.text().split_whitespace().collect::<Vec<_>>().join(" ");
    let guaranteed = node.is_guaranteed();
    Some(EstimateClaim {
        of,
        guaranteed,
        at_most,
        per_1000_km,
        confidence,
        text,
        origin: places.origin(node.span()),
    })
}

/// Whether so many encounters can show a claim at all.
pub fn suffices(
    node: ast::EstimateClaim,
    claim: &EstimateClaim,
    encounters: u32,
    method: EstimateMethod,
    report: &mut Vec<Diagnostic>,
) -> bool {
    let nominal = method.nominal_runs(encounters as usize) as u64;
    if !claim.guaranteed && method != EstimateMethod::Crude {
        return true;
    }
    // However few they are, the event may be so much rarer than in what it is compared with that it shows.
    if claim.of != EstimateClaimOf::Probability {
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
