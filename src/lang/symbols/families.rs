//! Scenarios that build on each other, and the names in them: what a base calls a vehicle is the name that all above it use.

use std::collections::{HashMap, HashSet};

use super::classes::{Classes, DefinitionIndex, SymbolKind};
use crate::syntax::NodeIndex;
use crate::syntax::ast::{self, View};
use crate::texts::{FileId, NameDefinition, Texts};

/// A scenario or template, by its place among all.
pub type ScenarioIndex = usize;

/// A block of a file.
type BlockOfFile = (FileId, NodeIndex);

type Named = HashMap<String, Vec<DefinitionIndex>>;

/// What a scenario says itself, or what all that build on it say.
#[derive(Debug, Default)]
struct Said {
    users: Named,
    /// Those of them that are several people.
    groups: Named,
    variations: Named,
    /// The blocks of roads.
    roads: Vec<BlockOfFile>,
    /// Whether columns of a file are variations, too.
    draws_columns: bool,
}

#[derive(Debug, Default)]
struct Member {
    base: Option<ScenarioIndex>,
    own: Said,
    /// Of those that build on it.
    above: Said,
    constants: Named,
    parameters: Named,
}

/// What a road has that scenarios name.
#[derive(Debug, Default)]
struct Road {
    obstacles: Named,
    crossings: Named,
}

/// All scenarios of some files.
#[derive(Debug, Default)]
pub struct ScenarioFamilies {
    by_node: HashMap<BlockOfFile, ScenarioIndex>,
    members: Vec<Member>,
    roads: HashMap<BlockOfFile, Road>,
}

fn add(table: &mut Named, name: ast::Name, kind: SymbolKind, classes: &mut Classes) {
    let definition = classes.define(name.span(), kind);
    table.entry(name.text().to_string()).or_default().push(definition);
}

fn add_all(to: &mut Named, from: &Named) {
    for (name, more) in from {
        to.entry(name.clone()).or_default().extend(more);
    }
}

impl ScenarioFamilies {
    pub fn of(files: &Texts, classes: &mut Classes) -> Self {
        let mut families = Self::default();
        let mut bases = Vec::new();
        for file in files.ids() {
            let root = files.tree(file).root();
            for scenario in root.every::<ast::Scenario>() {
                let base = scenario.base();
                bases
                    .push(base.and_then(|base| files.names(file).scenarios.get(base.name().text())).copied());
                families.by_node.insert((file, scenario.index()), families.members.len());
                families.members.push(member(file, scenario, files, classes));
            }
            for block in root.every::<ast::RoadBlock>() {
                let mut road = Road::default();
                for one in block.obstacles() {
                    add(&mut road.obstacles, one.name(), SymbolKind::Obstacle, classes);
                }
                for one in block.other_crossings() {
                    add(&mut road.crossings, one.name(), SymbolKind::Crossing, classes);
                }
                families.roads.insert((file, block.index()), road);
            }
        }
        for (index, base) in bases.into_iter().enumerate() {
            families.members[index].base = base.and_then(|base| families.index(&base));
        }
        families.relate(classes);
        families
    }

    /// What scenarios say of somebody whom they build on is about the same one.
    fn relate(&mut self, classes: &mut Classes) {
        for index in 0..self.members.len() {
            let own = std::mem::take(&mut self.members[index].own);
            let ancestors: Vec<ScenarioIndex> = self.chain(index).skip(1).collect();
            for (table, of) in [(&own.users, USERS), (&own.variations, VARIATIONS)] {
                for (name, definitions) in table {
                    let before = ancestors.iter().find_map(|base| of(&self.members[*base].own).get(name));
                    let all: Vec<DefinitionIndex> =
                        definitions.iter().chain(before.into_iter().flatten()).copied().collect();
                    classes.unite(&all);
                }
            }
            for base in ancestors {
                let above = &mut self.members[base].above;
                add_all(&mut above.users, &own.users);
                add_all(&mut above.groups, &own.groups);
                add_all(&mut above.variations, &own.variations);
                above.roads.extend(&own.roads);
                above.draws_columns |= own.draws_columns;
            }
            self.members[index].own = own;
        }
    }

    /// A scenario and those that it builds on, itself first.
    fn chain(&self, scenario: ScenarioIndex) -> impl Iterator<Item = ScenarioIndex> {
        let mut chain = vec![scenario];
        while let Some(base) = self.members[chain[chain.len() - 1]].base.filter(|base| !chain.contains(base))
        {
            chain.push(base);
        }
        chain.into_iter()
    }

    pub fn index(&self, definition: &NameDefinition) -> Option<ScenarioIndex> {
        self.at(definition.file, definition.node)
    }

    pub fn at(&self, file: FileId, node: NodeIndex) -> Option<ScenarioIndex> {
        self.by_node.get(&(file, node)).copied()
    }

    pub fn base(&self, scenario: ScenarioIndex) -> Option<ScenarioIndex> {
        self.members[scenario].base
    }

    /// What a scenario means by a name: what it or what it builds on says, else what those say that build on it.
    fn meant(&self, scenario: ScenarioIndex, of: Table, name: &str) -> Vec<DefinitionIndex> {
        let own = self.chain(scenario).find_map(|one| of(&self.members[one].own).get(name));
        own.or_else(|| of(&self.members[scenario].above).get(name)).cloned().unwrap_or_default()
    }

    fn roads(&self, scenario: ScenarioIndex) -> impl Iterator<Item = &Road> {
        let own =
            self.chain(scenario).map(|one| &self.members[one].own.roads).find(|roads| !roads.is_empty());
        let blocks = own.into_iter().flatten().chain(&self.members[scenario].above.roads);
        blocks.filter_map(|block| self.roads.get(block))
    }

    /// Road users and boxes that scenarios mean by a name, and how many bytes of it are theirs: of a member of a group or a
    /// stream, `walkers_2`, those of the group.
    pub fn users(&self, scenarios: &[ScenarioIndex], name: &str) -> (Vec<DefinitionIndex>, usize) {
        let mut found: Vec<DefinitionIndex> = Vec::new();
        for scenario in scenarios {
            found.extend(self.meant(*scenario, USERS, name));
            found.extend(self.roads(*scenario).filter_map(|road| road.obstacles.get(name)).flatten());
        }
        if !found.is_empty() {
            return (found, name.len());
        }
        let group = name.rsplit_once('_').filter(|(_, number)| number.parse::<usize>().is_ok());
        let Some((group, _)) = group else { return (Vec::new(), 0) };
        (scenarios.iter().flat_map(|one| self.meant(*one, GROUPS, group)).collect(), group.len())
    }

    pub fn crossings(&self, scenarios: &[ScenarioIndex], name: &str) -> Vec<DefinitionIndex> {
        let roads = scenarios.iter().flat_map(|scenario| self.roads(*scenario));
        roads.filter_map(|road| road.crossings.get(name)).flatten().copied().collect()
    }

    /// What scenarios vary under a name.
    pub fn variations(&self, scenarios: &[ScenarioIndex], name: &str) -> Vec<DefinitionIndex> {
        scenarios.iter().flat_map(|scenario| self.meant(*scenario, VARIATIONS, name)).collect()
    }

    /// What a name in a value of a scenario may stand for besides what its file gives, and whether that is all.
    pub fn values(&self, scenario: ScenarioIndex, name: &str) -> (Vec<DefinitionIndex>, bool) {
        let member = &self.members[scenario];
        if let Some(constant) = member.constants.get(name) {
            return (constant.clone(), true);
        }
        let mut found = self.meant(scenario, VARIATIONS, name);
        if self.chain(scenario).any(|one| self.members[one].own.variations.contains_key(name)) {
            return (found, true);
        }
        let parameter = member.parameters.get(name);
        found.extend(parameter.into_iter().flatten());
        (found, parameter.is_some())
    }

    /// The parameter of a template.
    pub fn parameter(&self, template: ScenarioIndex, name: &str) -> Vec<DefinitionIndex> {
        self.members[template].parameters.get(name).cloned().unwrap_or_default()
    }

    /// Names whose values differ from run to run or from caller to caller, and whether a file gives more of them.
    pub fn open_names(&self, scenario: ScenarioIndex) -> (HashSet<&str>, bool) {
        let own = self.chain(scenario).map(|one| &self.members[one].own);
        let all: Vec<&Said> = own.chain([&self.members[scenario].above]).collect();
        let varied = all.iter().flat_map(|said| said.variations.keys());
        let names = varied.chain(self.members[scenario].parameters.keys()).map(String::as_str);
        (names.collect(), all.iter().any(|said| said.draws_columns))
    }
}

type Table = fn(&Said) -> &Named;
const USERS: Table = |said| &said.users;
const GROUPS: Table = |said| &said.groups;
const VARIATIONS: Table = |said| &said.variations;

fn member(file: FileId, scenario: ast::Scenario, files: &Texts, classes: &mut Classes) -> Member {
    let mut member = Member::default();
    let (block, own) = (scenario.block(), &mut member.own);
    for one in block.vehicles() {
        add(&mut own.users, one.name(), SymbolKind::Vehicle, classes);
        if one.is_stream() {
            add(&mut own.groups, one.name(), SymbolKind::Vehicle, classes);
        }
    }
    for one in block.pedestrians() {
        add(&mut own.users, one.name(), SymbolKind::Pedestrian, classes);
        if one.group().is_some() {
            add(&mut own.groups, one.name(), SymbolKind::Pedestrian, classes);
        }
    }
    for varied in block.every::<ast::Varied>() {
        add(&mut own.variations, varied.name(), SymbolKind::Variation, classes);
    }
    for draw in block.draws() {
        add(&mut own.variations, draw.name(), SymbolKind::Variation, classes);
    }
    own.draws_columns = block.tables().next().is_some();
    own.roads = block.road().into_iter().filter_map(|choice| said_road(file, choice, files)).collect();
    for binding in block.bindings() {
        add(&mut member.constants, binding.name(), SymbolKind::Constant, classes);
    }
    for parameter in scenario.parameters().into_iter().flat_map(ast::Parameters::each) {
        add(&mut member.parameters, parameter.name(), SymbolKind::Parameter, classes);
    }
    member
}

/// The block of the road that a scenario chooses.
fn said_road(file: FileId, choice: ast::RoadChoice, files: &Texts) -> Option<BlockOfFile> {
    if let Some(block) = choice.block() {
        return Some((file, block.index()));
    }
    let found = files.names(file).roads.get(choice.name()?.text())?;
    Some((found.file, ast::RoadDefinition::cast(files.node(*found))?.block().index()))
}
