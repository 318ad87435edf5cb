//! Values set from outside: `av.speed=40km/h` stands in the text of every file as if it had been written there.
//!
//! The text is changed before anything is checked, so that a value that is set goes through all checks that a written one
//! goes through, and is shown where it stands.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use super::declared::declared;
use super::syntax::ast::{self, View};
use super::syntax::{Given, Node, Tree, given};
use scenario::registry::Registry;

/// A value for everything that has this name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Such as `tta`, `av.speed`, `av.controller.braking_distance` or `repeat`.
    pub name: String,
    /// As it would be written in a file.
    pub value: String,
    /// Whether it stands for all the values of a variation.
    is_list: bool,
}

impl fmt::Display for Override {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}={}", self.name, self.value)
    }
}

impl Override {
    /// Whether it stands for all the values of a variation.
    pub fn is_list(&self) -> bool {
        self.is_list
    }

    /// `repeat` for every scenario.
    pub fn repeat(times: u32) -> Self {
        Self { name: REPEAT.to_string(), value: times.to_string(), is_list: false }
    }
}

const REPEAT: &str = "repeat";

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text
            .split_once('=')
            .ok_or_else(|| format!("`{text}` sets nothing; write it like tta=4s or av.speed=40km/h"))?;
        let (name, value) = (name.trim(), value.trim());
        let in_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        if name.is_empty() || !name.chars().all(in_name) {
            return Err(format!("`{name}` is no name; write it like tta=4s or av.speed=40km/h"));
        }
        // A value must stay the one value that it is, whatever stands around it.
        let Some(given) = given(value) else {
            return Err(format!("`{value}` is no value; write it as in a scenario file, like 4s or 40km/h"));
        };
        let is_list = given == Given::Values;
        Ok(Self { name: name.to_string(), value: value.to_string(), is_list })
    }
}

/// What is set, and what of it was found so far.
#[derive(Debug, Default)]
pub struct Overrides {
    all: Vec<Override>,
    /// One for each: whether anything has the name.
    found: Vec<bool>,
    /// Every name that there is.
    known: BTreeSet<String>,
}

/// Text that takes the place of other text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edit {
    pub range: Range<usize>,
    pub text: String,
}

impl Overrides {
    pub fn new(all: &[Override]) -> Self {
        Self { all: all.to_vec(), found: vec![false; all.len()], known: BTreeSet::new() }
    }

    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    pub fn all(&self) -> &[Override] {
        &self.all
    }

    /// Those that nothing has the name of, and every name that there is.
    pub fn unknown(&self) -> (Vec<&Override>, &BTreeSet<String>) {
        let unknown = self.all.iter().zip(&self.found).filter(|(_, found)| !**found).map(|(one, _)| one);
        (unknown.collect(), &self.known)
    }

    /// What is to be changed in a file, in the order of the text.
    pub fn edits(&mut self, tree: &Tree, registry: &Registry) -> Vec<Edit> {
        let mut edits = Edits { overrides: self, registry, edits: Vec::new() };
        for node in tree.nodes() {
            match ast::Settable::cast(node) {
                Some(ast::Settable::Binding(node)) => edits.named(node.name(), node.value()),
                Some(ast::Settable::Argument(node)) => edits.named(node.name(), node.value()),
                Some(ast::Settable::Parameter(node)) => edits.parameter(node),
                Some(ast::Settable::Varied(node)) if node.is_alone() => edits.variation(node),
                Some(ast::Settable::Draw(node)) => edits.draw(node),
                Some(ast::Settable::VaryTogether(node)) => edits.together(node),
                Some(ast::Settable::Scenario(node)) => edits.block(*node.block(), ""),
                Some(ast::Settable::Vehicle(node)) => {
                    edits.block(*node.block(), &format!("{}.", node.name().text()));
                }
                Some(ast::Settable::Pedestrian(node)) => {
                    edits.block(*node.block(), &format!("{}.", node.name().text()));
                }
                Some(ast::Settable::Varied(_)) | None => {}
            }
        }
        let mut edits = edits.edits;
        edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
        edits
    }
}

/// The text with the edits made, none of which overlap.
pub fn apply(text: &str, edits: &[Edit]) -> String {
    let mut changed = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        changed.push_str(&text[at..edit.range.start]);
        changed.push_str(&edit.text);
        at = edit.range.end;
    }
    changed.push_str(&text[at..]);
    changed
}

/// Edits while they are gathered.
struct Edits<'o> {
    overrides: &'o mut Overrides,
    registry: &'o Registry,
    edits: Vec<Edit>,
}

impl Edits<'_> {
    /// The value that a name is to have; the name then counts as found.
    fn wanted(&mut self, name: &str) -> Option<Override> {
        self.overrides.known.insert(name.to_string());
        let place = self.overrides.all.iter().position(|one| one.name == name)?;
        self.overrides.found[place] = true;
        Some(self.overrides.all[place].clone())
    }

    fn replace(&mut self, range: Range<usize>, text: impl Into<String>) {
        self.edits.push(Edit { range, text: text.into() });
    }

    /// `let NAME = VALUE`, `NAME: VALUE`
    fn named(&mut self, name: ast::Name, value: ast::Expression) {
        if let Some(wanted) = self.wanted(name.text()) {
            self.replace(range(*value), wanted.value);
        }
    }

    /// A parameter of a template, with or without a default.
    fn parameter(&mut self, node: ast::Parameter) {
        let Some(wanted) = self.wanted(node.name().text()) else { return };
        match node.default() {
            Some(value) => self.replace(range(*value), wanted.value),
            None => self.replace(after(*node.name()), format!(" = {}", wanted.value)),
        }
    }

    fn variation(&mut self, node: ast::Varied) {
        let name = node.name();
        if let Some(wanted) = self.wanted(name.text()) {
            self.replace(name.span().end..node.span().end, format!(" in {}", values(&wanted)));
        }
    }

    /// What is set is no longer drawn.
    fn draw(&mut self, node: ast::Draw) {
        let name = node.name();
        if let Some(wanted) = self.wanted(name.text()) {
            self.replace(range(*node), format!("vary {} in {}", wanted.name, values(&wanted)));
        }
    }

    /// What is set is no longer varied together with the others, which keep their values.
    fn together(&mut self, node: ast::VaryTogether) {
        let lines: Vec<ast::Varied> = node.block().each().collect();
        let mut own = String::new();
        let mut taken = Vec::new();
        for line in &lines {
            if let Some(wanted) = self.wanted(line.name().text()) {
                own.push_str(&format!("vary {} in {}; ", wanted.name, values(&wanted)));
                taken.push(range(**line));
            }
        }
        if taken.is_empty() {
            return;
        }
        if taken.len() == lines.len() {
            self.replace(range(*node), own.trim_end_matches("; "));
            return;
        }
        self.replace(before(*node), own);
        taken.into_iter().for_each(|line| self.replace(line, ""));
    }

    /// What stands in a block, under names that begin with `prefix`.
    fn block(&mut self, block: Node, prefix: &str) {
        let Some(known) = block.block() else { return };
        for statement in known.statements.iter().filter(|statement| statement.set.is_some()) {
            let said = statement.said_in(block);
            let around = statement.set.and_then(|set| set.around);
            if said.is_none() && around.is_none() {
                continue;
            }
            let Some(wanted) = self.wanted(&format!("{prefix}{}", statement.word())) else { continue };
            match (said, around) {
                (Some(said), around) if !statement.is(said) => {
                    let (before, after) = around.unwrap_or_default();
                    self.replace(range(said), format!("{before}{}{after}", wanted.value));
                }
                (Some(said), _) => self.replace_value(said, &wanted.value),
                (None, Some((before, after))) => {
                    let start = block.span().start + 1;
                    self.replace(start..start, format!(" {before}{}{after};", wanted.value));
                }
                (None, None) => {}
            }
        }
        for statement in known.statements {
            let said = block.children().find(|child| statement.is(*child));
            if let Some(said) = said.and_then(ast::Settled::cast) {
                self.settings(said, &format!("{prefix}{}.", statement.word()));
            }
        }
    }

    fn replace_value(&mut self, said: Node, value: &str) {
        if let Some(size) = ast::Size::cast(said) {
            let (first, last) = (size.extents().next(), size.extents().last());
            if let (Some(first), Some(last)) = (first, last) {
                self.replace(first.span().start..last.span().end, value);
            }
        } else if let Some(start) = ast::PedestrianStart::cast(said) {
            // Of two ways to say one place the first is as good as the other.
            if let Some(first) = start.distances().next() {
                self.replace(range(*first.value()), value);
                self.replace(first.span().end..said.span().end, "");
            }
        } else if let Some(named) = ast::Named::cast(said) {
            self.replace(range(*named.name()), value);
        } else {
            let integer = said.parts::<ast::Integer>().next().map(|integer| *integer);
            let hole = integer.or_else(|| said.every::<ast::Expression>().next().map(|value| *value));
            hole.into_iter().for_each(|hole| self.replace(range(hole), value));
        }
    }

    /// Settings of `controller NAME { … }` and the like, under names that begin with `prefix`. What a model has no parameter for
    /// stays out of it.
    fn settings(&mut self, said: ast::Settled, prefix: &str) {
        let declaration = declared(*said, self.registry);
        let settings = said.settings();
        let mut names: BTreeSet<String> = settings
            .iter()
            .flat_map(|settings| settings.each())
            .map(|one| one.name().text().to_string())
            .collect();
        match declaration {
            Some(declaration) => {
                names.extend(declaration.parameters.iter().map(|parameter| parameter.name.to_string()));
                names.extend(declaration.presets.as_ref().map(|family| family.word.to_string()));
            }
            // Which of several it is differs between runs: whether they all have the parameter is checked later.
            None => {
                let own = self.overrides.all.iter().filter_map(|one| one.name.strip_prefix(prefix));
                names.extend(own.map(str::to_string));
            }
        }
        let mut added: Vec<String> = Vec::new();
        for name in names {
            let Some(wanted) = self.wanted(&format!("{prefix}{name}")) else { continue };
            let mut known = settings.iter().flat_map(|settings| settings.each());
            match known.find(|one| one.name().text() == name) {
                Some(setting) => self.replace(range(*setting.value()), wanted.value),
                None => added.push(format!("{name}: {}", wanted.value)),
            }
        }
        if added.is_empty() {
            return;
        }
        let added = added.join(", ");
        match settings {
            Some(settings) => {
                let start = settings.span().start + 1;
                self.replace(start..start, format!(" {added}, "));
            }
            None => self.replace(after(*said), format!(" {{ {added} }}")),
        }
    }
}

/// What a variation takes its values from.
fn values(wanted: &Override) -> String {
    if wanted.is_list { wanted.value.clone() } else { format!("[{}]", wanted.value) }
}

fn range(node: Node) -> Range<usize> {
    node.span().start..node.span().end
}

fn before(node: Node) -> Range<usize> {
    node.span().start..node.span().start
}

fn after(node: Node) -> Range<usize> {
    node.span().end..node.span().end
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Sources;

    fn set(text: &str, overrides: &[&str]) -> (String, Vec<String>) {
        let all: Vec<Override> = overrides.iter().map(|one| one.parse().unwrap()).collect();
        let (tree, found) = Tree::parse(Sources::default().add("test", ""), text.into());
        assert!(found.is_empty(), "{found:?}");
        let mut overrides = Overrides::new(&all);
        let changed = apply(text, &overrides.edits(&tree, &models::standard()));
        let (_, found) = Tree::parse(Sources::default().add("test", ""), changed.as_str().into());
        assert!(found.is_empty(), "{changed}: {found:?}");
        (changed, overrides.unknown().0.iter().map(ToString::to_string).collect())
    }

    fn line(text: &str, overrides: &[&str]) -> String {
        let (changed, unknown) = set(text, overrides);
        assert!(unknown.is_empty(), "{unknown:?} in {changed}");
        changed
    }

    #[test]
    fn whatever_has_a_name_takes_the_value() {
        for (text, wanted, changed) in [
            ("let pace = 1 m/s", "pace=2 m/s", "let pace = 2 m/s"),
            ("define a(delay) { }", "delay=2s", "define a(delay = 2s) { }"),
            ("define a(delay = 1 s) { }", "delay=2s", "define a(delay = 2s) { }"),
            ("scenario b : a(delay: 1 s) { }", "delay=2s", "scenario b : a(delay: 2s) { }"),
            ("scenario a { vary tta in [1 s, 2 s] }", "tta=4s", "scenario a { vary tta in [4s] }"),
            (
                "scenario a { vary tta in uniform(1 s, 2 s) 9 times }",
                "tta=4s",
                "scenario a { vary tta in [4s] }",
            ),
            (
                "scenario a { vary tta in [1 s] }",
                "tta=1s .. 3s step 1s",
                "scenario a { vary tta in 1s .. 3s step 1s }",
            ),
            ("scenario a { repeat 5 }", "repeat=3", "scenario a { repeat 3 }"),
            ("scenario a { runs 5 .. 9 }", "repeat=3", "scenario a { repeat 3 }"),
            ("scenario a { }", "horizon=9s", "scenario a { horizon 9s; }"),
        ] {
            assert_eq!(line(text, &[wanted]), changed);
        }
    }

    #[test]
    fn road_users_take_values_where_they_say_them_and_where_they_do_not() {
        let car = |inside: &str| format!("scenario a {{ vehicle av {{ {inside} }} }}");
        let walker = |inside: &str| format!("scenario a {{ pedestrian walker {{ {inside} }} }}");
        for (text, wanted, changed) in [
            (car("speed 3 m/s"), "av.speed=40km/h", car("speed 40km/h")),
            (car("start 9 m before crossing"), "av.start=2s", car("start 2s before crossing")),
            (car("size 1 m x 2 m"), "av.size=3m x 1m", car("size 3m x 1m")),
            (
                car("controller yielding"),
                "av.controller.deceleration=3",
                car("controller yielding { deceleration: 3 }"),
            ),
            (car("sees { range: 9 m }"), "av.sees.range=3m", car("sees { range: 3m }")),
            (
                car("controller yielding { deceleration: 2 }"),
                "av.controller=idm_aeb",
                car("controller idm_aeb { deceleration: 2 }"),
            ),
            (
                walker("start 2 m from kerb, 4 m from lane centre"),
                "walker.start=1m",
                walker("start 1m from kerb"),
            ),
            (
                walker("appears when time_to_arrival(av) = tta"),
                "walker.appears=3s",
                walker("appears when time_to_arrival(av) = 3s"),
            ),
            (walker("size 1 m x 1 m"), "walker.radius=1m", walker("radius 1m")),
        ] {
            assert_eq!(line(&text, &[wanted]), changed);
        }
        let text = walker("appears at 2 s");
        assert_eq!(line(&text, &["walker.along=1m"]), text.replace("walker {", "walker { along 1m;"));
    }

    #[test]
    fn what_is_set_is_not_varied_together_any_more() {
        let text = "scenario a { vary together { x in [1, 2]; y in [3, 4] } }";
        assert_eq!(line(text, &["x=5"]), "scenario a { vary x in [5]; vary together { ; y in [3, 4] } }");
        assert_eq!(line(text, &["x=5", "y=6"]), "scenario a { vary x in [5]; vary y in [6] }");
    }

    #[test]
    fn what_has_no_such_name_is_known_to_be_unknown() {
        let text = "scenario a { vehicle av { controller yielding } }";
        for unknown in ["x=1", "av.sped=1", "av.controller.nothing=1", "av.dynamics.mass=1", "car.speed=1"] {
            assert_eq!(set(text, &[unknown]), (text.to_string(), vec![unknown.to_string()]));
        }
    }

    #[test]
    fn a_value_is_one_value() {
        for good in ["tta=4s", " tta = 4 s ", "x=a + 1 s", "x=\"b c\"", "x=-1", "x=[1, 2]", "s=1m x 2m"] {
            good.parse::<Override>().unwrap_or_else(|error| panic!("{good}: {error}"));
        }
        for bad in [
            "tta",
            "=4s",
            "tta=",
            "t t=4",
            "x=1 }",
            "x=1\nrepeat 9",
            "x=1; repeat 9",
            "x=1 # no",
            "x=1, y: 2",
            "x={ a: 1 }",
        ] {
            assert!(bad.parse::<Override>().is_err(), "{bad}");
        }
    }
}
