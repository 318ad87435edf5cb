//! What values come to, where a text does not say it itself: `30 km/h` is 8.333 m/s.

use std::path::Path;

use super::source::Span;
use super::symbols::ScenarioFamilies;
use super::syntax::Node;
use super::syntax::ast::{self, View};
use super::texts::{Texts, bind};
use super::units;
use super::value::{self, Binding, NameScope, ValueKind};
use files::{Files, Overlay};
use scenario::registry::Registry;
use scenario::show;

/// What a value comes to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hint {
    /// Behind this byte.
    pub at: usize,
    /// Such as `= 8.333 m/s`.
    pub text: String,
}

/// What the values of a text come to in SI units, where that is not what is written: of other units, of calculations and of names.
/// `text` stands for the file at `path`. What differs from run to run has no hint.
pub fn hints(path: &Path, text: &str, registry: &Registry, texts: &dyn Files) -> Vec<Hint> {
    let texts = Overlay::new(texts, path, text);
    let mut files = Texts::new(registry, &texts).while_edited();
    let Some(file) = files.open(path, None, &mut Vec::new()) else { return Vec::new() };
    let tree = files.tree(file);
    if files.sources.resolve(Span::beginning(tree.source)).source != tree.source {
        // In YAML a value is a part of a text with words around it.
        return Vec::new();
    }
    let families = ScenarioFamilies::of(&files, &mut Default::default());
    let mut found = Vec::new();
    let whole = files.scope(file);
    let mut parts: Vec<Node> = tree.root().children().collect();
    let mut at = 0;
    while let Some(part) = parts.get(at).copied() {
        at += 1;
        if ast::Suite::cast(part).is_some() {
            parts.extend(part.children().flat_map(Node::children));
            continue;
        }
        let Some(scenario) = ast::Scenario::cast(part) else {
            of_node(part, whole, &mut found);
            continue;
        };
        let mut scope = NameScope::inside(whole);
        if let Some(index) = families.at(file, scenario.index()) {
            let (open, has_columns) = families.open_names(index);
            // A column of a file may have the name of anything.
            let all = whole.names.keys().map(String::as_str).filter(|_| has_columns);
            for name in open.into_iter().chain(all) {
                scope.names.insert(name.to_string(), Binding::new(None, part.span()));
            }
        }
        for binding in scenario.block().bindings() {
            bind(binding, &mut scope, &mut Vec::new());
        }
        of_node(part, &scope, &mut found);
    }
    found.sort_by_key(|hint| hint.at);
    found
}

/// Those of the outermost values below a node.
fn of_node(node: Node, scope: &NameScope, found: &mut Vec<Hint>) {
    if let Some(expression) = ast::Expression::cast(node)
        && node.every::<ast::Each>().next().is_none()
    {
        found.extend(of_value(expression, scope));
        return;
    }
    for child in node.children() {
        of_node(child, scope, found);
    }
}

fn of_value(expression: ast::Expression, scope: &NameScope) -> Option<Hint> {
    let refers = expression.every::<ast::Reference>().next().is_some();
    let lone = expression.signed_quantity();
    if !refers && lone.is_some_and(|(_, unit)| is_plain(unit)) {
        return None;
    }
    let typed = value::evaluate(expression, scope, &mut Vec::new())?;
    let ValueKind::Number(dimension) = typed.kind else { return None };
    let shown = show(typed.as_constant_number()?, None, dimension);
    Some(Hint { at: expression.span().end, text: format!("= {shown}") })
}

/// Whether a number in that unit says itself what it is: an SI unit, none, or hundredths.
fn is_plain(unit: &str) -> bool {
    unit.is_empty() || unit == "%" || units::unit_of(unit).is_none_or(|known| known.to_si(1.0) == 1.0)
}
