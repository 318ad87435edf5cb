//! `rating NAME { … }`

use super::block::{Layer, missing, reject_repeats};
use super::literal;
use super::metric::{Cast, kind_name, metric_reference};
use super::places::TextPlaces;
use super::rated_cells::{self, RatedScenarios};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::{self, ast, phrase};
use crate::value::{self, NameScope};
use scenario::{
    Dimension, MetricKind, Notation, PointsCriterion, Rating, Relation, Scoring, TagPoints, Weight,
    WeightedValues, Weights,
};

/// What no maximum is above.
const MOST_POINTS: f64 = 1e6;

/// The rating at `node`; its metric may name the road users of `cast`, its cells are those of `rated`.
pub fn rating(
    node: ast::Rating,
    rated: &RatedScenarios,
    cast: &Cast,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Rating> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let what = format!("rating `{}`", name.text());
    let layer = [Layer { block, scope }];
    let measure = match block.measure() {
        Some(node) => measure(node, cast, scope, report),
        None => {
            missing::<ast::RatedMetric>(&layer, name.span(), &what, report);
            None
        }
    };
    let nodes: Vec<ast::Weights> = block.weights().collect();
    if nodes.is_empty() {
        missing::<ast::Weights>(&layer, name.span(), &what, report);
    }
    if block.points().next().is_none() {
        missing::<ast::Points>(&layer, name.span(), &what, report);
    }
    let points: Vec<_> = block.points().map(|node| points(node, scope, report)).collect();
    let points: Option<Vec<_>> = points.into_iter().collect();
    let points: Vec<(Span, TagPoints)> = points?.into_iter().flatten().collect();
    let tables: Vec<_> = nodes
        .iter()
        .map(|node| table(*node, measure.as_ref().map(|(_, dimension)| *dimension), scope, report))
        .collect();
    rated_cells::tags(&points, rated, report)?;
    let when = rated_cells::conditions(name.span(), &nodes, &points, rated, scope, places, report);
    let mut notation: Option<Notation> = None;
    let mut weights = Vec::new();
    for (node, (table, when)) in nodes.iter().zip(tables.into_iter().zip(when?)) {
        let (lines, written) = table?;
        notation = notation.or(written);
        // Otherwise it is about no cell, which only values from outside are forgiven.
        let Some(when) = when else { continue };
        let said = node.when().map_or(String::new(), |when| format!("{} ", phrase(*when)));
        let each: Vec<_> = node.block().lines().map(|line| phrase(*line)).collect();
        let text = format!("{said}{{ {} }}", each.join(", "));
        weights.push(Weights { when, lines, text, origin: places.origin(node.span()) });
    }
    let rating = Rating {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        measure: measure?.0,
        notation,
        weights,
        points: points.into_iter().map(|(_, points)| points).collect(),
        not_assessed: block.not_assessed().map(|one| one.what().value()).collect(),
        criteria: Vec::new(),
        origin: places.origin(name.span()),
    };
    let criteria: Vec<_> = block
        .expects()
        .flat_map(|expect| expect.block().criteria())
        .map(|node| criterion(node, &rating, scope, places, report))
        .collect();
    Some(Rating { criteria: criteria.into_iter().collect::<Option<_>>()?, ..rating })
}

fn measure(
    node: ast::RatedMetric,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(scenario::MetricReference, Dimension)> {
    let (reference, found) = metric_reference(node.metric(), cast, scope, report)?;
    let MetricKind::Quantity(dimension) = found.kind else {
        report.push(
            Diagnostic::new(
                Code::BadRating,
                node.metric().span(),
                format!("`{}` is {}, and weights are of quantities", reference.name(), kind_name(&found)),
            )
            .label("not a quantity")
            .hint("measure a quantity, such as `impact_speed(component: along)`"),
        );
        return None;
    };
    Some((reference, dimension))
}

/// What values are worth, and the unit that they are written in.
fn table(
    node: ast::Weights,
    dimension: Option<Dimension>,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Vec<Weight>, Option<Notation>)> {
    let nodes: Vec<ast::Weight> = node.block().lines().collect();
    if nodes.is_empty() {
        if node.block().children().next().is_none() {
            report.push(
                Diagnostic::new(Code::BadWeights, node.span(), "these weights say what no value is worth")
                    .label("says nothing")
                    .hint("write `weights { 0 km/h: 1, below 10 km/h: 0.25 }`"),
            );
        }
        return None;
    }
    let mut notation = None;
    let mut lines: Vec<(Span, Weight)> = Vec::new();
    let mut whole = true;
    for node in nodes {
        let Some((line, written)) = line(node, dimension?, scope, report) else {
            whole = false;
            continue;
        };
        notation = notation.or(written);
        if let Some((first, _)) = lines.iter().find(|(_, earlier)| earlier.of.covers(line.of)) {
            report.push(
                Diagnostic::new(Code::BadWeights, node.span(), "no value reaches this line")
                    .label("never counts")
                    .context(*first, "has all of its values")
                    .hint("a value falls to the first line that it satisfies: put the narrower one first"),
            );
            whole = false;
        }
        lines.push((node.span(), line));
    }
    whole.then(|| (lines.into_iter().map(|(_, line)| line).collect(), notation))
}

fn line(
    node: ast::Weight,
    dimension: Dimension,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Weight, Option<Notation>)> {
    let mut values = node.values();
    let (of, notation) = if node.is_undefined() {
        (WeightedValues::Undefined, None)
    } else {
        let said = values.next()?;
        let any = (f64::MIN, f64::MAX);
        let (bound, notation) =
            value::written_constant(said, dimension, any, "the value of a weight", scope, report)?;
        let of = match node.bound() {
            Some(word) if word.is_below() => WeightedValues::Below(bound),
            Some(word) if word.is_above() => WeightedValues::Above(bound),
            Some(word) if word.is_at_most() => WeightedValues::AtMost(bound),
            Some(_) => WeightedValues::AtLeast(bound),
            None if bound == 0.0 => WeightedValues::Exactly(0.0),
            None => {
                let said = syntax::expression(said);
                report.push(
                    Diagnostic::new(
                        Code::BadWeights,
                        node.span(),
                        format!("no measured value is exactly {said}"),
                    )
                    .label("hardly ever reached")
                    .hint(format!(
                        "say `below {said}`, `at most {said}`, `above {said}` or `at least {said}`"
                    )),
                );
                return None;
            }
        };
        (of, notation)
    };
    let weight =
        value::constant_in(values.next()?, Dimension::NUMBER, (0.0, 1.0), "a weight", scope, report)?;
    Some((Weight { of, weight }, notation))
}

/// Tags with what they earn, each with its place.
fn points(
    node: ast::Points,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<(Span, TagPoints)>> {
    let by = match node.by_share() {
        Some(share) => Scoring::Share { steps: steps(share, scope, report)? },
        None => Scoring::MeanWeight,
    };
    let each: Vec<_> = node
        .each()
        .map(|one| {
            let (said, what) = (one.points(), "the points of a tag");
            let maximum =
                value::constant_in(said, Dimension::NUMBER, (0.0, MOST_POINTS), what, scope, report)?;
            if maximum == 0.0 {
                report.push(
                    Diagnostic::new(Code::BadRating, said.span(), "nothing can be earned here")
                        .label("no points")
                        .hint("say how many points the best weight in every cell earns"),
                );
                return None;
            }
            let tag = one.tag();
            Some((tag.span(), TagPoints { tag: tag.text().to_string(), maximum, by: by.clone() }))
        })
        .collect();
    each.into_iter().collect()
}

fn steps(node: ast::ByShare, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Vec<f64>> {
    let mut steps: Vec<f64> = Vec::new();
    for said in node.steps() {
        let step = value::constant_in(said, Dimension::NUMBER, (0.0, 1.0), "a step", scope, report)?;
        if steps.last().map_or(step == 0.0, |last| step <= *last) {
            report.push(
                Diagnostic::new(Code::BadRating, said.span(), "steps rise from above 0 % to 100 % at most")
                    .label("does not rise")
                    .hint("write `in steps 50 %, 75 %, 100 %`; below the first, nothing is earned"),
            );
            return None;
        }
        steps.push(step);
    }
    Some(steps)
}

/// `points >= 3`, which some points must satisfy and others not.
fn criterion(
    node: ast::PointsCriterion,
    rating: &Rating,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<PointsCriterion> {
    let tag = node.tag();
    if let Some(tag) = tag
        && rating.points.iter().all(|one| one.tag != tag.text())
    {
        let message = format!("the rating has no points of `{}`", tag.text());
        report.push(
            Diagnostic::new(Code::NoSuchTag, tag.span(), message)
                .label("earns nothing")
                .suggest(tag.text(), rating.points.iter().map(|one| one.tag.as_str())),
        );
        return None;
    }
    let (said, relation) = (node.bound(), node.relation().meaning());
    let any = (f64::MIN, f64::MAX);
    let bound = value::constant_in(said, Dimension::NUMBER, any, "the bound of points", scope, report)?;
    let most = rating.maximum_of(tag.map(|tag| tag.text()));
    let (low, high) = (relation.holds(0.0, bound), relation.holds(most, bound));
    let (can_hold, can_fail) = match relation {
        Relation::Equal => ((0.0..=most).contains(&bound), true),
        Relation::NotEqual => (true, (0.0..=most).contains(&bound)),
        _ => (low || high, !(low && high)),
    };
    let said = match tag {
        Some(tag) => format!("points of {}", tag.text()),
        None => "points".to_string(),
    };
    let text = format!("{said} {} {}", relation.symbol(), syntax::expression(node.bound()));
    if !can_hold || !can_fail {
        let (code, never) = match can_hold {
            true => (Code::BadRating, "fail"),
            false => (Code::NeverHolds, "pass"),
        };
        report.push(
            Diagnostic::new(code, node.span(), format!("`{text}` can never {never}"))
                .label(format!("there are 0 to {most} points"))
                .hint("choose a bound between the two"),
        );
        return None;
    }
    Some(PointsCriterion {
        tag: tag.map(|tag| tag.text().to_string()),
        relation,
        bound,
        text,
        origin: places.origin(node.span()),
    })
}
