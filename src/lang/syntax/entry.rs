//! What is known of a statement of the language and of a kind of block. Entries stand beside the views of their blocks, in `ast`.

use super::tree::{Node, Rule};

/// A statement of a block.
#[derive(Debug)]
pub struct StatementEntry {
    /// The words that it begins with, whatever follows; none for statements that begin with any name.
    pub words: &'static str,
    pub(super) rule: Rule,
    /// An example, or several between which stands `` ` or ` ``: each is read in the tests.
    pub usage: &'static str,
    /// One line.
    pub doc: &'static str,
    /// The key that stands for it in YAML; none for statements of blocks that have no keys there.
    pub key: &'static str,
    /// How the value of that key becomes statements.
    pub shape: YamlShape,
    /// Whether a block may say it several times.
    pub repeats: bool,
    /// The block that it opens.
    pub opens: Option<BlockKind>,
    /// Whether it gives something a name that other statements may use.
    pub names: bool,
    /// What is said where a block needs it and does not have it: what is lacking, and an example.
    pub(super) missing: Option<(&'static str, &'static str)>,
    /// What stands around the value where it is set from outside.
    pub set: Option<Set>,
}

/// How a statement takes a value from outside.
#[derive(Debug, Clone, Copy)]
pub struct Set {
    /// What is written around the value where the block does not say it; nothing if that would be a guess.
    pub around: Option<(&'static str, &'static str)>,
    /// The other statement that says the same in another way, whose place it takes.
    instead_of: Option<Rule>,
}

/// How the value of a key in YAML becomes statements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YamlShape {
    /// The words after those that it begins with; a list makes one statement an item.
    Words,
    /// As [`Self::Words`], but long ones: a list stands on lines of its own.
    Lines,
    /// `a, b, c`
    Commas,
    /// `"text"`; a list makes one statement an item.
    Text,
    /// `"text", "text"`
    Texts,
    /// A path, or `{ file: PATH, without: [a, b] }`: `"path" without a, b`; a list makes one statement an item.
    Table,
    /// A mapping of names to the blocks that it opens: `name { … }`
    Named,
    /// A name, or a block in place: `road NAME`, `road { … }`
    NameOrBlock,
    /// A list of free statements: `expect { … }`; without words they stand in the block itself.
    Statements,
    /// A name, or a name with settings.
    Model,
    /// A mapping of vehicles to names, or to names with settings: `test name { … } as vehicle`
    Tested,
    /// A mapping of names to names, or to names with settings: `crossing school zebra { … }`
    NamedModels,
    /// A mapping of names to settings: `box van { … }`
    NamedSettings,
    /// `sees { … }`
    Settings,
    /// A mapping: `name in values`
    Values,
    /// A mapping of names to distributions, or to `{ file: PATH }`: `draw name from distribution`
    Drawn,
    /// A mapping, or a list of them, with names that go together.
    Together,
    /// A mapping: `let name = value`
    Bindings,
    /// Stands there if true.
    Flag,
    /// Stands there if false.
    NotFlag,
    /// Words for cases, or `{ file: PATH }`.
    Cases,
    /// A list of `default`, names, `{ file: PATH, as: NAME }` and `{ set: { parameter: value }, as: NAME }`.
    Conditions,
    /// A mapping of parameters to values, or a list of such: `try { parameter: value }`
    ParameterSets,
    /// A mapping of names to lists: `reported name: a, b`
    Rows,
    /// A list of mappings of values to weights, perhaps with `when`: `weights when … { value: weight }`
    Weights,
    /// The scenario or template that a scenario builds on.
    Base,
    /// The parameters of a template.
    Parameters,
    /// How many a block describes: `pedestrian NAME times 5 { … }`
    GroupSize,
    /// A mapping of names to defaults, or to `{ default: 5 m, in: 1 m .. 30 m, as: T, unit: m, doc: … }`:
    /// `parameter name = 5 m in 1 m .. 30 m as "T" in m "…"`
    OwnParameters,
}

/// A kind of block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    File,
    Road,
    Path,
    Controller,
    Scenario,
    Vehicle,
    Stream,
    Pedestrian,
    Expect,
    Together,
    Suite,
    Gate,
    Rating,
    ExpectPoints,
    Search,
    Tune,
    Evaluate,
    Calibrate,
    Estimate,
    Statement,
}

/// A kind of block with its statements.
#[derive(Debug)]
pub struct BlockEntry {
    pub kind: BlockKind,
    pub(super) rule: Rule,
    /// With an article: "a `vehicle`".
    pub name: &'static str,
    /// What stands before its statements without a word of its own.
    pub heads: &'static [StatementEntry],
    pub statements: &'static [StatementEntry],
}

impl BlockKind {
    /// The file first.
    pub const ALL: [Self; 20] = [
        Self::File,
        Self::Road,
        Self::Path,
        Self::Controller,
        Self::Scenario,
        Self::Vehicle,
        Self::Stream,
        Self::Pedestrian,
        Self::Expect,
        Self::Together,
        Self::Suite,
        Self::Gate,
        Self::Rating,
        Self::ExpectPoints,
        Self::Search,
        Self::Tune,
        Self::Evaluate,
        Self::Calibrate,
        Self::Estimate,
        Self::Statement,
    ];
}

impl BlockEntry {
    /// The kind's name alone, such as `vehicle`.
    pub fn word(&self) -> String {
        format!("{:?}", self.rule).trim_end_matches("_block").to_string()
    }

    /// What has a key in YAML, in the order in which it is written there.
    pub fn keys(&self) -> impl Iterator<Item = &'static StatementEntry> {
        self.heads.iter().chain(self.statements).filter(|statement| !statement.key.is_empty())
    }

    /// The statement that begins as `text` does.
    pub fn beginning(&self, text: &str) -> Option<&'static StatementEntry> {
        let written = |index| text.split(|c: char| !is_letter(c)).filter(|word| !word.is_empty()).nth(index);
        let first = text.split(|c: char| !is_letter(c)).next().unwrap_or_default();
        let known = self.statements.iter().filter(|statement| statement.word() == first && !first.is_empty());
        known.max_by_key(|statement| {
            let words = statement.words.split(' ').enumerate();
            let same = words.clone().take_while(|(index, word)| written(*index) == Some(word)).count();
            (same, std::cmp::Reverse(words.count()))
        })
    }

    /// The statement that begins with any name.
    pub fn free(&self) -> Option<&'static StatementEntry> {
        self.statements.iter().find(|statement| statement.words.is_empty())
    }
}

fn is_letter(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

impl StatementEntry {
    /// The first of its words.
    pub fn word(&self) -> &'static str {
        self.words.split(' ').next().unwrap_or_default()
    }

    /// Whether the node is this statement.
    pub fn is(&self, node: Node) -> bool {
        // Of two that are of one kind their first words tell.
        self.rule == node.rule()
            && (self.words.is_empty() || node.text().split(|c| !is_letter(c)).next() == Some(self.word()))
    }

    /// The node of the block that this is, or that says the same in another way.
    pub fn said_in<'t>(&self, block: Node<'t>) -> Option<Node<'t>> {
        let other = || {
            let rule = self.set?.instead_of?;
            block.children().find(|child| child.rule() == rule)
        };
        block.children().find(|child| self.is(*child)).or_else(other)
    }

    /// Whether a block has to say it.
    pub fn is_needed(&self) -> bool {
        self.missing.is_some()
    }

    /// What is said where a block needs it: what is lacking, and an example.
    pub fn missing(&self) -> (&'static str, &'static str) {
        self.missing.unwrap_or((self.word(), self.usage))
    }

    /// Its examples, one by one.
    pub fn usages(&self) -> impl Iterator<Item = &'static str> {
        self.usage.split("` or `").flat_map(|usage| usage.split("`, `"))
    }
}

/// A statement that stands once in a block and has no key in YAML.
pub(super) const fn statement(
    words: &'static str,
    rule: Rule,
    usage: &'static str,
    doc: &'static str,
) -> StatementEntry {
    StatementEntry {
        words,
        rule,
        usage,
        doc,
        key: "",
        shape: YamlShape::Words,
        repeats: false,
        opens: None,
        names: false,
        missing: None,
        set: None,
    }
}

impl StatementEntry {
    pub(super) const fn key(self, key: &'static str, shape: YamlShape) -> Self {
        Self { key, shape, ..self }
    }

    pub(super) const fn repeats(self) -> Self {
        Self { repeats: true, ..self }
    }

    pub(super) const fn opens(self, block: BlockKind) -> Self {
        Self { opens: Some(block), ..self }
    }

    pub(super) const fn names(self) -> Self {
        Self { names: true, ..self }
    }

    /// What a block that needs it and does not have it lacks, with an example.
    pub(super) const fn needed(self, lacks: &'static str, example: &'static str) -> Self {
        Self { missing: Some((lacks, example)), ..self }
    }

    /// Takes its value from outside, between these words where nothing is said.
    pub(super) const fn set(self, before: &'static str, after: &'static str) -> Self {
        Self { set: Some(Set { around: Some((before, after)), instead_of: None }), ..self }
    }

    /// As [`Self::set`], in place of another statement too.
    pub(super) const fn set_instead_of(self, other: Rule, before: &'static str) -> Self {
        Self { set: Some(Set { around: Some((before, "")), instead_of: Some(other) }), ..self }
    }

    /// Takes its value from outside where it is said.
    pub(super) const fn set_where_said(self) -> Self {
        Self { set: Some(Set { around: None, instead_of: None }), ..self }
    }
}
