//! What could stand at a place that is being written.
//!
//! The place is found by tokens alone, because a text is seldom whole while it is being written; what a statement could
//! go on with is asked of the grammar, and names come from the rest of the file.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;

use super::assist::path_to;
use super::declared;
use super::suite::included;
use super::syntax::ast::{self, View};
use super::syntax::words::{self, BlockEntry, BlockKind, StatementEntry};
use super::syntax::{self, Next, Node, Token, TokenKind, goes_on_with};
use super::texts::{FileId, Texts, with_declared};
use super::units;
use files::{self, Overlay};
use scenario::registry::{Registry, Table};
use scenario::{
    AGGREGATES, AggregateWord, Answer, DISTRIBUTIONS, Declaration, ParameterKind, Registered, STEERS, Scope,
    SignalEntry, input_signals, output_signals,
};

/// A word that could stand somewhere.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Completion {
    /// What is put at the place.
    pub word: String,
    /// One line.
    pub detail: String,
}

/// The words that could stand at byte `offset` of the file at `path`, with the names that it defines or uses.
pub fn complete(
    path: &Path,
    text: &str,
    offset: usize,
    registry: &Registry,
    texts: &dyn files::Files,
) -> Vec<Completion> {
    let before = &text[..offset.min(text.len())];
    let tokens: Vec<Token> =
        syntax::tokens(before).into_iter().filter(|token| token.kind != TokenKind::Space).collect();
    if tokens.last().is_some_and(|token| matches!(token.kind, TokenKind::Comment | TokenKind::OpenString)) {
        return Vec::new();
    }
    let word = |token: &Token| &before[token.start..token.end];
    // The first words of every statement whose braces are open here, and the current statement.
    let mut open: Vec<Vec<&str>> = Vec::new();
    let mut statement: Vec<&str> = Vec::new();
    let mut start = 0;
    for token in &tokens {
        match (token.kind, word(token)) {
            (TokenKind::Newline | TokenKind::Comment, _) | (_, ";") => statement.clear(),
            (_, "{") => open.push(std::mem::take(&mut statement)),
            (_, "}") => {
                open.pop();
                statement.clear();
            }
            (_, text) => {
                if statement.is_empty() {
                    start = token.start;
                }
                statement.push(text);
            }
        }
    }
    // The word being written is what is to be completed.
    let writing = tokens.last().filter(|token| token.kind == TokenKind::Word && token.end == before.len());
    if writing.is_some() {
        statement.pop();
    }
    let registry = &with_declared(path, &without_line(text, before.len()), registry, texts);
    let owner = open.last().map_or(&[] as &[&str], Vec::as_slice);
    let first_two = |index| owner.get(index).copied().unwrap_or_default();
    if let Some(declaration) = declared::named(first_two(0), first_two(1), registry).filter(|_| {
        // A controller that a file declares is a block of statements there.
        owner.len() < 3 && (open.len() > 1 || first_two(0) != "controller")
    }) {
        return setting(&declaration, &statement);
    }
    if let ([.., tune, _], ["try"]) = (open.as_slice(), owner) {
        let tune = tune.get(1).copied().unwrap_or_default();
        return tried(path, &without_line(text, before.len()), registry, texts, (tune, &statement));
    }
    let block = block_of(&open);
    match statement.as_slice() {
        [] => first_words(block, registry),
        [.., number] if number.starts_with(|c: char| c.is_ascii_digit()) => units(),
        [word @ ("controller" | "test" | "dynamics" | "model" | "crossing")] => {
            let choices = declared::choices(word, registry);
            choices.iter().map(|(name, kind)| proposal(name, &kind.summary)).collect()
        }
        ["input"] => signals(""),
        ["input", group, "."] => signals(&format!("{group}.")),
        ["output"] => Answer::ALL.into_iter().flat_map(output_signals).chain([&STEERS]).map(signal).collect(),
        ["input" | "output", .., "in"] | ["parameter", .., "as", _, "in"] => units(),
        [.., "no"] if !is(block, &[BlockKind::Road, BlockKind::Gate]) => all(registry.metrics()),
        ["road"] => visible(path, &without_line(text, before.len()), registry, texts, |kind| {
            matches!(kind, ast::Defining::RoadDefinition(_))
        }),
        ["over" | "on"] if is(block, &[BlockKind::Road, BlockKind::Vehicle]) => {
            visible(path, &without_line(text, before.len()), registry, texts, |kind| {
                matches!(kind, ast::Defining::RoadDefinition(_))
            })
        }
        [.., ":"] if is(block, &[BlockKind::File]) => {
            visible(path, &without_line(text, before.len()), registry, texts, |kind| {
                matches!(kind, ast::Defining::Scenario(_))
            })
        }
        [.., "in" | "on" | "of" | "with" | "as"] if refers(block, &statement) => {
            visible(path, &without_line(text, before.len()), registry, texts, |kind| match kind {
                ast::Defining::Scenario(scenario) => !scenario.is_template(),
                ast::Defining::Search(_) | ast::Defining::Tune(_) | ast::Defining::Evaluate(_) => true,
                _ => false,
            })
        }
        _ => {
            let end = writing.map_or(before.len(), |token| token.start);
            let text = without_line(text, before.len());
            let place = Place { path, text, line: line_start(before), registry, texts };
            place.go_on(block, &statement, &before[start.min(end)..end])
        }
    }
}

/// Whether a statement of a block names scenarios and other blocks.
fn refers(block: Option<&BlockEntry>, statement: &[&str]) -> bool {
    is(
        block,
        &[
            BlockKind::Search,
            BlockKind::Tune,
            BlockKind::Evaluate,
            BlockKind::Calibrate,
            BlockKind::Estimate,
            BlockKind::Statement,
        ],
    ) && !statement
        .iter()
        .any(|word| matches!(*word, "over" | "rises" | "falls" | "compare" | "repeat" | "event" | "score"))
}

fn is(block: Option<&BlockEntry>, kinds: &[BlockKind]) -> bool {
    block.is_some_and(|block| kinds.contains(&block.kind))
}

fn line_start(before: &str) -> usize {
    before.rfind('\n').map_or(0, |at| at + 1)
}

/// Where something is written: a text that can be read, without the line at byte `line`.
struct Place<'a> {
    path: &'a Path,
    text: String,
    line: usize,
    registry: &'a Registry,
    texts: &'a dyn files::Files,
}

impl Place<'_> {
    /// What a statement could go on with after `written`, as far as the grammar says it.
    fn go_on(&self, block: Option<&BlockEntry>, statement: &[&str], written: &str) -> Vec<Completion> {
        let texts = Overlay::new(self.texts, self.path, &self.text);
        let mut files = Texts::new(self.registry, &texts).while_edited();
        let Some(file) = files.open(self.path, None, &mut Vec::new()) else { return Vec::new() };
        let first = statement.first().copied().unwrap_or_default();
        // What is about all that the suite runs.
        let is_about_all = matches!(first, "test" | "weights" | "points");
        let included = if is_about_all { included(&mut files, file, self.path) } else { Vec::new() };
        let statements = block.map_or(&[] as &[_], |block| block.statements).iter();
        let known = statements.filter(|known| known.word() == first || known.words.is_empty());
        let mut found: Vec<Completion> = Vec::new();
        for next in goes_on_with(known, written) {
            match next {
                Next::Metric => found.extend(all(self.registry.metrics())),
                Next::Aggregate => found.extend(aggregates()),
                Next::Value => {
                    found.extend(self.names(&files, file, Named::Value));
                    found.extend(constants(&files, file));
                }
                Next::Target => found.extend(self.names(&files, file, Named::Target)),
                Next::Name => match named(statement, self.registry) {
                    Some(kinds) => {
                        found.extend(self.names(&files, file, kinds));
                        included.iter().for_each(|one| found.extend(self.everywhere(&files, *one, kinds)));
                    }
                    None => found.extend(all(self.registry.metrics())),
                },
                Next::SettingName => {
                    if let [.., user, ".", part, "."] = statement {
                        found.extend(self.parameters(&files, file, user, part));
                    }
                }
                Next::Tag if first == "points" => {
                    std::iter::once(&file)
                        .chain(&included)
                        .for_each(|one| found.extend(self.tags(&files, *one)));
                }
                Next::Tag => {}
                Next::Distribution => {
                    found.extend(DISTRIBUTIONS.iter().map(|known| proposal(known.word, "A distribution.")));
                }
                Next::Keyword(word) => found.push(proposal(&word, "")),
                Next::Sign => {}
            }
        }
        let mut seen = HashSet::new();
        found.retain(|one| seen.insert(one.word.clone()));
        found
    }

    /// The scenario that is being written with those it builds on; elsewhere, every scenario of the file and those it uses.
    fn scenarios<'f>(&self, files: &'f Texts, file: FileId) -> Vec<ast::Scenario<'f>> {
        let names = files.names(file);
        let around = path_to(files.tree(file), self.line.min(self.text.len()));
        let inside = around.into_iter().find_map(ast::Scenario::cast);
        let Some(inside) = inside else {
            let mut all: Vec<_> = names.scenarios.iter().collect();
            all.sort_by_key(|(name, _)| name.as_str());
            return all.into_iter().map(|(_, definition)| files.scenario(*definition)).collect();
        };
        let mut chain = vec![inside];
        while let Some(base) = chain.last().and_then(|node| Some(node.base()?.name())) {
            let Some(definition) = names.scenarios.get(base.text()) else { break };
            let node = files.scenario(*definition);
            if chain.iter().any(|known| known.span() == node.span()) {
                break;
            }
            chain.push(node);
        }
        chain
    }

    /// The names that statements of those kinds give here, each with the statement's first line.
    fn names(&self, files: &Texts, file: FileId, kinds: Named) -> Vec<Completion> {
        let mut roads: Vec<_> = files.names(file).roads.iter().collect();
        roads.retain(|_| kinds == Named::Solid);
        roads.sort_by_key(|(name, _)| name.as_str());
        let roads = roads.into_iter().map(|(_, road)| files.tree(road.file).node(road.node));
        let scenarios = self.scenarios(files, file).into_iter().map(|scenario| *scenario);
        let nodes = scenarios.chain(roads).flat_map(Node::descendants);
        given(nodes.filter(|node| kinds.are(*node)))
    }

    /// The names that statements of those kinds give in every scenario that a file knows.
    fn everywhere(&self, files: &Texts, file: FileId, kinds: Named) -> Vec<Completion> {
        let mut scenarios: Vec<_> = files.names(file).scenarios.iter().collect();
        scenarios.sort_by_key(|(name, _)| name.as_str());
        let scenarios = scenarios.into_iter().map(|(_, definition)| *files.scenario(*definition));
        given(scenarios.flat_map(Node::descendants).filter(|node| kinds.are(*node)))
    }

    /// The tags of every scenario that a file knows, in the order of the alphabet.
    fn tags(&self, files: &Texts, file: FileId) -> Vec<Completion> {
        let scenarios = files.names(file).scenarios.values().map(|definition| files.scenario(*definition));
        let all: BTreeSet<&str> =
            scenarios.flat_map(|one| one.every::<ast::Tag>()).map(|tag| tag.text()).collect();
        all.into_iter().map(|tag| proposal(tag, "A tag.")).collect()
    }

    /// The parameters of a road user's controller, dynamics, perception or model.
    fn parameters(&self, files: &Texts, file: FileId, user: &str, part: &str) -> Vec<Completion> {
        let statements = self
            .scenarios(files, file)
            .into_iter()
            .flat_map(|scenario| scenario.every::<ast::RoadUser>())
            .filter(|found| found.name().text() == user)
            .flat_map(|found| found.descendants())
            .filter(|node| node.text().split_whitespace().next() == Some(part));
        let declared = statements.filter_map(|statement| declared::declared(statement, self.registry)).next();
        let declared = declared.or_else(|| declared::named(part, "", self.registry));
        declared.map_or_else(Vec::new, |declaration| setting(&declaration, &[]))
    }
}

/// The names that statements give, each with the statement's first line.
fn given<'t>(nodes: impl Iterator<Item = Node<'t>>) -> Vec<Completion> {
    nodes
        .filter_map(|node| {
            let line = node.text().lines().next().unwrap_or_default();
            let name = node.parts::<ast::Name>().next()?;
            Some(proposal(name.text(), line.trim_end_matches('{').trim_end()))
        })
        .collect()
}

/// What names could be of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Named {
    Value,
    Variation,
    Vehicle,
    Stream,
    RoadUser,
    /// Also boxes of the road.
    Solid,
    /// What is searched over.
    Target,
}

impl Named {
    /// Whether the node gives such a name.
    fn are(self, node: Node) -> bool {
        let varied = || ast::Varied::cast(node).is_some();
        let user = || ast::RoadUser::cast(node).is_some();
        match self {
            Self::Value => {
                varied()
                    || ast::Draw::cast(node).is_some()
                    || ast::Binding::cast(node).is_some()
                    || ast::Parameter::cast(node).is_some()
            }
            Self::Variation => varied(),
            Self::Vehicle => ast::Vehicle::cast(node).is_some(),
            Self::Stream => ast::Vehicle::cast(node).is_some_and(ast::Vehicle::is_stream),
            Self::RoadUser => user(),
            Self::Solid => user() || ast::Obstacle::cast(node).is_some(),
            Self::Target => varied() || user(),
        }
    }
}

/// What gives the names that could follow; `None` where a metric could.
fn named(statement: &[&str], registry: &Registry) -> Option<Named> {
    let mut depth = 0;
    let open = statement.iter().rposition(|word| {
        depth += i32::from(*word == "(") - i32::from(*word == ")");
        depth > 0
    });
    let call = open.and_then(|open| statement.get(open.checked_sub(1)?)).copied();
    match (statement.first().copied(), call) {
        (_, Some("time_to_arrival")) | (Some("test"), None) => Some(Named::Vehicle),
        (Some("repeats"), None) => Some(Named::Stream),
        (_, Some("chosen")) | (Some("over"), None) => Some(Named::Target),
        (_, Some(call)) if AggregateWord::find(call).is_some() => None,
        (_, Some(call))
            if registry.metrics().get(call).is_some_and(|known| known.scope == Scope::Contact) =>
        {
            Some(Named::Solid)
        }
        (_, Some(_)) => Some(Named::RoadUser),
        (Some("minimise" | "maximise" | "keep" | "subject" | "measure"), None) => None,
        _ => Some(Named::Variation),
    }
}

/// What a file gives names to, itself or in files that it uses.
fn constants(files: &Texts, file: FileId) -> Vec<Completion> {
    let mut names: Vec<_> = files.scope(file).names.iter().collect();
    names.sort_by_key(|(name, _)| name.as_str());
    names
        .into_iter()
        .map(|(name, binding)| {
            let place = files.sources.origin(binding.span);
            proposal(name, place.source_line.trim())
        })
        .collect()
}

/// A text that is being written as one that can be read: without the line at `offset`, with every brace closed.
fn without_line(text: &str, offset: usize) -> String {
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    let end = text[offset..].find('\n').map_or(text.len(), |at| offset + at);
    let mut whole = format!("{}{}", &text[..start], &text[end..]);
    let tokens = syntax::tokens(&whole);
    let count = |brace: &str| tokens.iter().filter(|token| &whole[token.start..token.end] == brace).count();
    let missing = count("{").saturating_sub(count("}"));
    whole.push_str(&"\n}".repeat(missing));
    whole
}

/// The names of some kinds that a file defines or sees in files that it uses, in the order of the alphabet, with the line that
/// defines each.
fn visible(
    path: &Path,
    text: &str,
    registry: &Registry,
    texts: &dyn files::Files,
    wanted: impl Fn(ast::Defining) -> bool,
) -> Vec<Completion> {
    let texts = Overlay::new(texts, path, text);
    let mut files = Texts::new(registry, &texts).while_edited();
    let Some(file) = files.open(path, None, &mut Vec::new()) else { return Vec::new() };
    let names = files.names(file);
    let all = names.roads.iter().chain(&names.scenarios).chain(&names.blocks);
    let mut found: Vec<Completion> = all
        .filter(|(_, defined)| ast::Defining::cast(files.node(**defined)).is_some_and(&wanted))
        .map(|(name, defined)| {
            let node = files.tree(defined.file).node(defined.node);
            let first_line = node.text().lines().next().unwrap_or_default();
            proposal(name, first_line.trim_end_matches('{').trim_end())
        })
        .collect();
    found.sort_by(|one, other| one.word.cmp(&other.word));
    found
}

/// The parameters that a tune is over, or the units of the value of one.
fn tried(
    path: &Path,
    text: &str,
    registry: &Registry,
    texts: &dyn files::Files,
    (tune, statement): (&str, &[&str]),
) -> Vec<Completion> {
    match statement.rsplit(|word| *word == ",").next().unwrap_or_default() {
        [] => {}
        [.., number] if number.starts_with(|c: char| c.is_ascii_digit()) => return units(),
        _ => return Vec::new(),
    }
    let texts = Overlay::new(texts, path, text);
    let mut files = Texts::new(registry, &texts).while_edited();
    let Some(file) = files.open(path, None, &mut Vec::new()) else { return Vec::new() };
    let names = files.names(file);
    let block = names.blocks.get(tune).and_then(|block| ast::Tune::cast(files.node(*block)));
    let ranges = block.into_iter().flat_map(|tune| tune.block().over()).flat_map(ast::Over::ranges);
    let parameter = |range: ast::OverRange| Some(proposal(range.target().parameter()?.text(), range.text()));
    ranges.filter_map(parameter).collect()
}

fn proposal(word: &str, detail: &str) -> Completion {
    Completion { word: word.to_string(), detail: detail.to_string() }
}

fn of(declaration: &Declaration) -> Completion {
    proposal(&declaration.name, &declaration.summary)
}

fn units() -> Vec<Completion> {
    units::UNITS.iter().map(|unit| proposal(unit.symbol, unit.doc)).collect()
}

/// What an `fmu` may be told, behind these first letters of its name.
fn signals(group: &str) -> Vec<Completion> {
    let known =
        input_signals().filter_map(|(name, known)| Some(proposal(name.strip_prefix(group)?, known.doc)));
    known.collect()
}

fn signal(known: &SignalEntry) -> Completion {
    proposal(known.name, known.doc)
}

fn all<T: Registered>(table: &Table<T>) -> Vec<Completion> {
    table.declarations().map(of).collect()
}

fn aggregates() -> Vec<Completion> {
    AGGREGATES.iter().map(|known| proposal(known.word, known.doc)).collect()
}

/// The kind of block that the last of these statements opens, which opened each other.
fn block_of(open: &[Vec<&str>]) -> Option<&'static BlockEntry> {
    let Some((last, outer)) = open.split_last() else { return Some(BlockKind::File.block()) };
    let first = last.first()?;
    let begins = |known: &&StatementEntry| known.word() == *first;
    // Where the statement stands is known only as far as what is around it.
    let here = block_of(outer).into_iter().flat_map(|block| block.statements).filter(begins);
    here.chain(words::all().filter(begins)).find_map(|known| known.opens).map(BlockKind::block)
}

fn first_words(block: Option<&BlockEntry>, registry: &Registry) -> Vec<Completion> {
    if is(block, &[BlockKind::Expect]) {
        return [vec![proposal("no", "What must not happen.")], aggregates(), all(registry.metrics())]
            .concat();
    }
    if is(block, &[BlockKind::ExpectPoints]) {
        return vec![proposal("points", "All points, or those `of` a tag.")];
    }
    let mut words: Vec<Completion> = Vec::new();
    let statements = block.map_or(&[] as &[_], |block| block.statements).iter();
    for known in statements.filter(|known| !known.words.is_empty()) {
        if words.iter().all(|word| word.word != known.word()) {
            words.push(proposal(known.word(), known.doc));
        }
    }
    words
}

/// Names of parameters, or what the one before the colon takes.
fn setting(declaration: &Declaration, statement: &[&str]) -> Vec<Completion> {
    let current = statement.rsplit(|word| *word == ",").next().unwrap_or_default();
    match current {
        [] => {
            let presets =
                declaration.presets.as_ref().map(|family| proposal(&family.word, "Named settings."));
            declaration
                .parameters
                .iter()
                .map(|found| proposal(&found.name, &found.doc))
                .chain(presets)
                .collect()
        }
        [name, ":"] => {
            if let Some(family) = declaration.presets.as_ref().filter(|family| family.word == *name) {
                return family.presets.iter().map(|preset| proposal(&preset.name, &preset.doc)).collect();
            }
            match declaration.parameter(name).map(|found| &found.kind) {
                Some(ParameterKind::Choice { options, .. }) => {
                    options.iter().map(|option| proposal(&option.name, &option.doc)).collect()
                }
                Some(ParameterKind::Flag { .. }) => vec![proposal("true", ""), proposal("false", "")],
                _ => Vec::new(),
            }
        }
        [.., number] if number.starts_with(|c: char| c.is_ascii_digit()) => units(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::Disk;
    use models::standard;

    #[test]
    fn completion_knows_where_it_is() {
        let words = |text: &str| {
            complete(Path::new("nowhere/a.scn"), text, text.len(), &standard(), &Disk)
                .into_iter()
                .map(|found| found.word)
                .collect::<Vec<_>>()
        };
        assert!(words("").contains(&"scenario".to_string()));
        let unit = |text: &str| words(&format!("controller own {{\n  fmu \"a.fmu\"\n  {text}"));
        assert!(unit("").contains(&"output".to_string()));
        assert!(unit("input eg").contains(&"ego.speed".to_string()));
        assert_eq!(unit("input ahead.").len(), 3, "{:?}", unit("input ahead."));
        assert!(unit("output ").contains(&"throttle".to_string()));
        assert!(unit("input ego.speed = \"v\" in ").contains(&"km/h".to_string()));
        let rating = |text: &str| {
            let scenario = "scenario a {\n  tags cpna\n  vary pace in [1 m/s]\n}\n";
            words(&format!("{scenario}suite s {{\n  rating r {{\n    {text}"))
        };
        assert!(rating("").contains(&"weights".to_string()));
        assert!(rating("measure ").contains(&"impact_speed".to_string()));
        assert!(rating("weights when ").contains(&"pace".to_string()), "{:?}", rating("weights when "));
        assert!(rating("points ").contains(&"cpna".to_string()), "{:?}", rating("points "));
        // `expect` of a rating is another than that of a scenario.
        assert_eq!(rating("expect {\n      "), ["points"]);
        assert!(words("scenario a {\n  ve").contains(&"vehicle".to_string()));
        assert!(words("scenario a { vehicle v {\n controller ").contains(&"carla_behavior".to_string()));
        assert!(words("vehicle v { controller carla_behavior { ").contains(&"braking_distance".to_string()));
        assert!(
            words("vehicle v { controller carla_behavior { gap: 1, profile: ")
                .contains(&"cautious".to_string())
        );
        assert!(words("scenario a { expect {\n  no ").contains(&"collision".to_string()));
        assert!(words("vehicle v { speed 30 ").contains(&"km/h".to_string()));
        assert!(words("suite s {\n  test ").contains(&"carla_behavior".to_string()));
        assert!(words("suite s {\n  test carla_behavior { ").contains(&"braking_distance".to_string()));
        let vehicle = "scenario a {\n  vehicle av {\n  }\n}\nsuite s {\n  test carla_behavior as ";
        assert!(words(vehicle).contains(&"av".to_string()), "{:?}", words(vehicle));
        let below = files::Memory::default()
            .with("all/people/a.scn", "use \"../base.scn\"\nscenario a : base {\n  vehicle ego {\n  }\n}\n");
        let below = below
            .with("all/base.scn", "define base {\n  vehicle av {\n  }\n}\n")
            .with("all/people/bad.scn", "scenario {");
        let suite = "suite s {\n  scenarios \"people/*.scn\"\n  test carla_behavior as ";
        let found = complete(Path::new("all/s.suite"), suite, suite.len(), &standard(), &below);
        assert_eq!(found.iter().map(|found| found.word.as_str()).collect::<Vec<_>>(), ["ego", "av"]);
        assert!(words("# scen").is_empty());
        let text = "define base {\n}\nscenario a : base {\n}\nsearch s {\n  in a\n}\ntune t {\n  on ";
        assert_eq!(words(text), ["a", "s", "t"]);
        assert_eq!(words(&format!("{text}s\n}}\nscenario b : ")), ["a", "base"]);
        assert_eq!(
            complete(Path::new("nowhere/a.scn"), &format!("{text}\n}}\n"), text.len(), &standard(), &Disk)
                .len(),
            3
        );
    }

    #[test]
    fn statements_go_on_as_the_grammar_says() {
        let words = |text: &str| {
            let found = complete(Path::new("nowhere/a.scn"), text, text.len(), &standard(), &Disk);
            found.into_iter().map(|found| found.word).collect::<Vec<_>>()
        };
        let text = "let pace = 1 m/s\nscenario walk {\n  vehicle av {\n    controller carla_behavior\n  }\n  \
                    pedestrian walker {\n    model scripted\n  }\n  vary tta in [1 s]\n}\n";
        let after = |more: &str| words(&format!("{text}{more}"));
        assert_eq!(after("search s {\n  over "), ["av", "walker", "tta"]);
        assert_eq!(after("search s {\n  over av."), ["controller", "dynamics", "sees", "model"]);
        assert!(after("search s {\n  over av.controller.").contains(&"braking_distance".to_string()));
        assert!(after("search s {\n  over walker.model.").contains(&"speed".to_string()));
        assert!(after("search s {\n  budget 6 evaluations, by ").contains(&"sobol".to_string()));
        assert!(after("tune t {\n  minimise ").contains(&"mean".to_string()));
        let tune = "tune t {\n  on walk\n  over av.controller.braking_distance in 1 m .. 9 m\n  try { ";
        assert_eq!(after(tune), ["braking_distance"]);
        assert!(after(&format!("{tune}braking_distance: 8 ")).contains(&"m".to_string()));
        assert!(after("search s {\n  expect {\n    no ").contains(&"collision".to_string()));
        assert_eq!(after("statement s {\n  claim mean(pet) of walk rises with "), ["tta"]);
        let inside = |more: &str| words(&format!("{}{more}", text.trim_end().trim_end_matches('}')));
        assert_eq!(inside("  pedestrian other {\n    appears "), ["at", "when"]);
        assert_eq!(inside("  pedestrian other {\n    appears when time_to_arrival("), ["av"]);
        assert_eq!(inside("  pedestrian other {\n    from "), ["near", "far"]);
        assert_eq!(inside("  vehicle other {\n    speed "), ["tta", "pace"]);
        assert_eq!(inside("  expect {\n    pet(av, "), ["av", "walker"]);
        let on_road = |more: &str| {
            let road =
                "road street {\n  parked van { along: 0 m, across: 0 m, length: 1 m, width: 1 m }\n}\n";
            words(&format!("{road}{}{more}", text.trim_end().trim_end_matches('}')))
        };
        assert_eq!(on_road("  expect {\n    collision(av, "), ["av", "walker", "van"]);
        assert_eq!(inside("  expect {\n    pet >= 1 s when "), ["tta"]);
        assert!(inside("  expect {\n    pet >= 1 s ").contains(&"when".to_string()));
        assert!(inside("  expect {\n    quantile(95 %, ").contains(&"pet".to_string()));
        assert!(inside("  expect {\n    no ").contains(&"collision".to_string()));
        assert!(inside("  expect {\n    ").contains(&"mean".to_string()));
        assert!(inside("  vary v in ").contains(&"uniform".to_string()));
        assert!(inside("  expect {\n    pet >> ").is_empty(), "what is wrong already goes on with nothing");
    }
}
