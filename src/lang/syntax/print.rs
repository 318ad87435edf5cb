//! Syntax back into words: one spelling for what can be spelled in several ways.

use super::ast::{
    Aggregate, Condition, Criterion, Each, Expression, Group, Metric, Quantity, Relation, Setting, Settings,
    Undefined, View, When,
};
use super::tree::{Node, Rule};

/// An expression with single spaces: `1.5 s`, `-2 * (tta + 1 s)`.
pub fn expression(of: Expression) -> String {
    of.children().map(part).collect()
}

fn part(node: Node) -> String {
    if node.rule() == Rule::operator {
        format!(" {} ", node.text())
    } else if let Some(group) = Group::cast(node) {
        format!("({})", expression(group.inside()))
    } else if let Some(each) = Each::cast(node) {
        format!("each({})", each.values().map(expression).collect::<Vec<_>>().join(", "))
    } else if let Some(quantity) = Quantity::cast(node) {
        match quantity.unit() {
            Some(unit) => format!("{} {}", quantity.number().text(), unit.text()),
            None => quantity.text().to_string(),
        }
    } else {
        node.text().to_string()
    }
}

/// The criterion in its one spelling.
pub fn criterion_text(node: Criterion) -> String {
    let mut text = match node.aggregate_claim() {
        Some(claim) => aggregate_text(claim.aggregate()) + &bound_text(claim.relation(), claim.bound()),
        None => node.condition().map_or(String::new(), condition_only),
    };
    if let Some(share) = node.share() {
        text += &format!(" in {} of runs", expression(share.value()));
    }
    text += undefined_text(node.undefined());
    if let Some(confidence) = node.confidence() {
        text += &format!(" with {} confidence", expression(confidence.value()));
    }
    if let Some(whom) = node.whom() {
        text += if whom.are_all() { " of all people" } else { " of these people" };
    }
    let conditions: Vec<_> = node
        .whens()
        .flat_map(When::conditions)
        .map(|one| one.name().text().to_string() + &bound_text(one.relation(), one.bound()))
        .collect();
    if !conditions.is_empty() {
        text += &format!(" when {}", conditions.join(" and "));
    }
    text
}

/// An aggregate in its one spelling.
pub fn aggregate_text(of: Aggregate) -> String {
    let inside = match of {
        Aggregate::Rate(rate) => condition_text(rate.condition(), rate.undefined()),
        Aggregate::Quantile(of) => format!("{}, {}", expression(of.level()), metric_text(of.metric())),
        Aggregate::Statistic(of) => metric_text(of.metric()),
    };
    format!("{}({inside})", of.word())
}

/// A condition in its one spelling, with what an undefined run is.
pub fn condition_text(node: Condition, undefined: Option<Undefined>) -> String {
    condition_only(node) + undefined_text(undefined)
}

fn condition_only(node: Condition) -> String {
    let no = if node.is_negative() { "no " } else { "" };
    let bound = node.relation().zip(node.bound());
    let bound = bound.map_or(String::new(), |(relation, bound)| bound_text(relation, bound));
    format!("{no}{}{bound}", metric_text(node.metric()))
}

fn undefined_text(said: Option<Undefined>) -> &'static str {
    match said {
        Some(undefined) if undefined.passes() => " undefined passes",
        Some(_) => " undefined fails",
        None => "",
    }
}

fn bound_text(relation: Relation, bound: Expression) -> String {
    format!(" {} {}", relation.meaning().symbol(), expression(bound))
}

/// A metric in its one spelling.
pub fn metric_text(node: Metric) -> String {
    let details = node.details().into_iter().flat_map(|details| details.children()).map(detail);
    with_details(node, details.collect())
}

/// The same with `other` in the place of all pedestrians that it names, who stand after the vehicle if it `names_vehicle`.
pub fn metric_text_of(node: Metric, names_vehicle: bool, other: &str) -> String {
    let vehicle = node.details().and_then(|details| details.names().next()).filter(|_| names_vehicle);
    let settings = node.details().into_iter().flat_map(Settings::each).map(|setting| detail(*setting));
    let names = vehicle.map(|name| name.text().to_string()).into_iter().chain([other.to_string()]);
    with_details(node, names.chain(settings).collect())
}

fn with_details(node: Metric, details: Vec<String>) -> String {
    let name = node.name().text();
    if node.details().is_none() { name.to_string() } else { format!("{name}({})", details.join(", ")) }
}

fn detail(part: Node) -> String {
    match Setting::cast(part) {
        Some(setting) => format!("{}: {}", setting.name().text(), expression(setting.value())),
        None => part.text().to_string(),
    }
}
