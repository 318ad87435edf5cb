//! Syntax back into words: one spelling for what can be spelled in several ways.

use super::tree::{Node, Rule};

/// An `expression` node with single spaces: `1.5 s`, `-2 * (tta + 1 s)`.
pub fn expression(node: Node) -> String {
    let mut text = String::new();
    for part in node.children() {
        match part.rule() {
            Rule::operator => {
                text.push(' ');
                text.push_str(part.text());
                text.push(' ');
            }
            Rule::group => {
                text.push('(');
                if let Some(inner) = part.child(Rule::expression) {
                    text.push_str(&expression(inner));
                }
                text.push(')');
            }
            Rule::quantity => text.push_str(&quantity(part)),
            _ => text.push_str(part.text()),
        }
    }
    text
}

/// A `quantity` node as `number unit`.
pub fn quantity(node: Node) -> String {
    match (node.child(Rule::number), node.child(Rule::unit)) {
        (Some(number), Some(unit)) => format!("{} {}", number.text(), unit.text()),
        _ => node.text().to_string(),
    }
}

/// The number and the unit of an expression that is nothing but a quantity.
pub fn signed_quantity(expression: Node) -> Option<(f64, String)> {
    let mut sign = 1.0;
    let mut found = None;
    for part in expression.children() {
        match part.rule() {
            Rule::negation => sign = -sign,
            Rule::quantity if found.is_none() => found = Some(part),
            _ => return None,
        }
    }
    let quantity = found?;
    let number: f64 = quantity.child(Rule::number)?.text().replace('_', "").parse().ok()?;
    let unit = quantity.child(Rule::unit).map_or(String::new(), |unit| unit.text().to_string());
    Some((sign * number, unit))
}
