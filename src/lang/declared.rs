//! What may stand in the settings of a statement: what a registered thing declares, or the language itself.

use super::check::{bus, crossings, obstacle, over, parked_row, turn};
use super::syntax::Node;
use super::syntax::ast::{self, View};
use scenario::Declaration;
use scenario::registry::Registry;

/// What the settings of a statement or metric are of, unless a variation chooses between several.
pub fn declared(of: Node, registry: &Registry) -> Option<Declaration> {
    if let Some(metric) = ast::Metric::cast(of) {
        return registry.metrics().get(metric.name().text()).map(|known| known.declaration.clone());
    }
    ast::HasSettings::cast(of)?;
    let mut words = of.text().split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let (word, name) = (words.next()?, words.next().unwrap_or_default());
    // A crossing may have a name of its own before its kind.
    named(word, name, registry).or_else(|| named(word, words.next()?, registry))
}

/// What the settings are of in a statement that begins with `word` and `name`.
pub fn named(word: &str, name: &str, registry: &Registry) -> Option<Declaration> {
    match word {
        "sees" => Some(registry.perception().declaration.clone()),
        "box" | "parked" => Some(obstacle()),
        "parked_row" => Some(parked_row()),
        "bus" => Some(bus()),
        "turn" => Some(turn()),
        "over" => Some(over()),
        _ => choices(word, registry).into_iter().find(|(known, _)| known == name).map(|(_, found)| found),
    }
}

/// What a statement that begins with `word` may name, in order.
pub fn choices(word: &str, registry: &Registry) -> Vec<(String, Declaration)> {
    let own = |declaration: &Declaration| (declaration.name.to_string(), declaration.clone());
    match word {
        "controller" | "test" => registry.controllers().declarations().map(own).collect(),
        "dynamics" => registry.dynamics().declarations().map(own).collect(),
        "model" => registry.pedestrians().declarations().map(own).collect(),
        "crossing" => crossings().map(|(name, declaration)| (name.to_string(), declaration)).into(),
        _ => Vec::new(),
    }
}
