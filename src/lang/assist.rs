//! What an editor asks: what is this, and where is it defined.

use std::path::Path;

use super::declared::declared;
use super::source::{Sources, Span};
use super::syntax::ast::{self, View, Word};
use super::syntax::{Node, Tree};
use super::texts::Texts;
use super::units;
use files::{self, Overlay};
use scenario::registry::Registry;
use scenario::{Answer, Declaration, Parameter, ParameterKind, STEERS, input_signals, output_signals};

/// What the word at byte `offset` means, in Markdown, with the bytes it is about.
pub fn hover(tree: &Tree, offset: usize, registry: &Registry) -> Option<(Span, String)> {
    let path = path_to(tree, offset);
    let node = *path.last()?;
    let parent = path.len().checked_sub(2).map(|index| path[index]);
    let text = match Word::cast(node) {
        Some(Word::Unit(_)) => {
            let unit = units::unit_of(node.text())?;
            format!("`{}`: {}, a unit of {}", unit.symbol, unit.doc, unit.dimension.name())
        }
        Some(Word::Signal(_)) => {
            let (_, known) = input_signals().find(|(name, _)| name == node.text()).or_else(|| {
                let given = Answer::ALL.into_iter().flat_map(output_signals).chain([&STEERS]).copied();
                given.map(|known| (known.name.to_string(), known)).find(|(name, _)| name == node.text())
            })?;
            format!("{} {}", known.doc, known.dimension.si_unit()).trim_end().to_string()
        }
        Some(Word::Name(_)) if parent.and_then(ast::NamesRegistered::cast).is_some() => {
            whole(&declared(parent?, registry)?)
        }
        Some(Word::SettingName(_)) => {
            let owner = path.iter().rev().find_map(|node| declared(*node, registry))?;
            match owner.parameter(node.text()) {
                Some(found) => parameter(found),
                None => {
                    let family = owner.presets.as_ref().filter(|family| family.word == node.text())?;
                    let names: Vec<_> = family
                        .presets
                        .iter()
                        .map(|preset| format!("- `{}`: {}", preset.name, preset.doc))
                        .collect();
                    format!("Named settings; `{}` if not said.\n\n{}", family.default, names.join("\n"))
                }
            }
        }
        Some(Word::Reference(_) | Word::Name(_)) => {
            let place = local_definition(&path, node.text())?;
            let line = tree.text()[..place.start].rfind('\n').map_or(0, |at| at + 1);
            let end = tree.text()[place.end..].find('\n').map_or(tree.text().len(), |at| place.end + at);
            format!("```scn\n{}\n```", tree.text()[line..end].trim())
        }
        None => {
            let (index, block) =
                path.iter().enumerate().rev().find_map(|(index, node)| Some((index, node.block()?)))?;
            let said = *path.get(index + 1)?;
            let known = said.statement_of(block).or_else(|| block.beginning(said.text()))?;
            format!("{}\n\n`{}`", known.doc, known.usage)
        }
    };
    Some((node.span(), text))
}

/// The nodes around a byte, from the file to the innermost.
pub(super) fn path_to(tree: &Tree, offset: usize) -> Vec<Node<'_>> {
    let mut path = vec![tree.root()];
    while let Some(inner) = path.last().and_then(|node| {
        node.children().find(|child| child.span().start <= offset && offset <= child.span().end)
    }) {
        path.push(inner);
    }
    path
}

fn whole(declaration: &Declaration) -> String {
    let mut text =
        format!("**{}** – {}\n\nSource: {}\n", declaration.name, declaration.summary, declaration.source);
    for found in &declaration.parameters {
        text.push_str(&format!("\n- `{}`: {}", found.name, found.doc));
    }
    text
}

fn parameter(found: &Parameter) -> String {
    let range = match &found.kind {
        ParameterKind::Number { dimension, range: (low, high), .. } => {
            format!(", {low} .. {high} {}", dimension.si_unit())
        }
        ParameterKind::Whole { range: (low, high), .. } => format!(", {low} .. {high}"),
        _ => String::new(),
    };
    let default = found.default_value().map(|value| format!("Default (SI): {value}. ")).unwrap_or_default();
    format!("{}\n\nTakes {}{range}. {default}Source: {}", found.doc, found.kind.expectation(), found.source)
}

/// Where the name at byte `offset` of the file at `path` is defined, possibly in a file that it uses.
pub fn definition(
    path: &Path,
    text: &str,
    offset: usize,
    registry: &Registry,
    texts: &dyn files::Files,
) -> Option<(Span, Sources)> {
    let texts = Overlay::new(texts, path, text);
    let mut files = Texts::new(registry, &texts).while_edited();
    let file = files.open(path, None, &mut Vec::new())?;
    let tree = files.tree(file);
    let around = path_to(tree, offset);
    let node = *around.last()?;
    let parent = around.len().checked_sub(2).map(|index| around[index])?;
    let name = node.text();
    let names = files.names(file);
    let span = match Word::cast(node)? {
        Word::Name(_) if ast::Base::cast(parent).is_some() => names.scenarios.get(name)?.span,
        Word::Name(_) if ast::Referring::cast(parent).is_some() => {
            names.blocks.get(name).or_else(|| names.scenarios.get(name))?.span
        }
        Word::Name(_) if ast::RoadChoice::cast(parent).is_some() => names.roads.get(name)?.span,
        Word::Name(_) | Word::Reference(_) => local_definition(&around, name)
            .or_else(|| files.scope(file).names.get(name).map(|binding| binding.span))
            .or_else(|| names.controllers.get(name).map(|own| own.span))?,
        Word::Unit(_) | Word::SettingName(_) | Word::Signal(_) => return None,
    };
    Some((span, files.sources))
}

/// Where the blocks around a place define a name.
fn local_definition(path: &[Node], name: &str) -> Option<Span> {
    path.iter().rev().find_map(|node| {
        let whole_file = ast::File::cast(*node).is_some();
        if !whole_file && ast::Scenario::cast(*node).is_none() {
            return None;
        }
        node.every::<ast::Local>()
            .filter(|inner| !whole_file || matches!(inner, ast::Local::Binding(_)))
            .filter_map(|inner| inner.parts::<ast::Name>().next())
            .find(|defined| defined.text() == name)
            .map(|defined| defined.span())
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use models::standard;

    const TEXT: &str = "let pace = 1.4 m/s\nscenario a {\n  vehicle av {\n    controller carla_behavior { braking_distance: 5 m }\n    \
                        speed pace\n  }\n  expect { no collision }\n}\n";

    fn at(word: &str) -> usize {
        TEXT.rfind(word).unwrap() + 1
    }

    #[test]
    fn hover_says_what_the_registry_says() {
        let (tree, _) = Tree::parse(Sources::default().add("a.scn", TEXT), Arc::from(TEXT));
        let hovered = |word| hover(&tree, at(word), &standard()).map(|(_, text)| text).unwrap_or_default();
        assert!(hovered("carla_behavior").starts_with("**carla_behavior**"), "{}", hovered("carla_behavior"));
        assert!(hovered("braking_distance").contains("a length in m"), "{}", hovered("braking_distance"));
        assert!(hovered("collision").starts_with("**collision**"));
        assert!(hovered("speed").contains("steady cruise"));
        assert!(hovered("m }").contains("metre"));
        assert_eq!(hovered("pace\n"), "```scn\nlet pace = 1.4 m/s\n```");

        let text = "suite s {\n  test carla_behavior { braking_distance: 5 m } as av\n}\n";
        let (tree, _) = Tree::parse(Sources::default().add("a.suite", text), Arc::from(text));
        for (word, doc) in [("carla_behavior", "**carla_behavior**"), ("braking_distance", "a length in m")] {
            let (_, said) = hover(&tree, text.find(word).unwrap() + 1, &standard()).unwrap();
            assert!(said.contains(doc), "{said}");
        }

        let text = "tune t {\n  otherwise fewest violations\n}\nstatement s {\n  differs \"why\"\n}\n";
        let (tree, _) = Tree::parse(Sources::default().add("a.scn", text), Arc::from(text));
        for (word, doc) in [("otherwise", "fewest runs"), ("differs", "not to be reproduced")] {
            let (_, said) = hover(&tree, text.find(word).unwrap() + 1, &standard()).unwrap();
            assert!(said.contains(doc), "{said}");
        }
        let text = "controller own {\n  fmu \"a.fmu\"\n  input ahead.gap = \"dx\"\n  output acceleration = \"a\"\n}\n";
        let (tree, _) = Tree::parse(Sources::default().add("a.scn", text), Arc::from(text));
        for (word, doc) in
            [("gap", "nobody is. m"), ("acceleration", "accelerate by. m/s^2"), ("fmu", "mock-up unit")]
        {
            let (_, said) = hover(&tree, text.find(word).unwrap() + 1, &standard()).unwrap();
            assert!(said.contains(doc), "{said}");
        }
    }

    #[test]
    fn definitions_are_found() {
        let (span, sources) =
            definition(Path::new("nowhere/a.scn"), TEXT, at("pace"), &standard(), &files::Disk).unwrap();
        assert_eq!(sources.text(span), "pace");
        let own = "controller my_av {\n  command \"a\"\n}\nsuite s {\n  test my_av as av\n}\n";
        let at = own.rfind("my_av").unwrap() + 1;
        let (span, _) = definition(Path::new("nowhere/a.suite"), own, at, &standard(), &files::Disk).unwrap();
        assert_eq!(span.start, own.find("my_av").unwrap());
        assert_eq!(sources.location(span).line, 1);
    }
}
