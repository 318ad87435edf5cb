//! The predicates of filter expressions: what each asks of a trial or block.

use super::matcher::Mark;
use scenario::Assignment;

/// Something that a command may be about: a trial of a scenario, or a block of a suite.
#[derive(Debug, Clone)]
pub struct Subject<'a> {
    /// The suite's name.
    pub suite: &'a str,
    /// `scenario`, or the word that the block begins with.
    pub kind: &'a str,
    /// Of the scenario or block.
    pub name: &'a str,
    /// Of the scenario, or of those that a block works on.
    pub tags: &'a [String],
    /// The pedestrian models in it.
    pub models: Vec<&'a str>,
    /// The controllers in it.
    pub controllers: Vec<&'a str>,
    /// Where it is written, and the file that was loaded.
    pub files: Vec<&'a str>,
    /// The values of the trial's variations; none of a block.
    pub variation: &'a [Assignment],
}

/// What a predicate asks about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    Scenario,
    Suite,
    Tag,
    Model,
    Controller,
    File,
    Variation,
    Block,
    Kind,
    All,
    None,
}

/// A predicate as it is documented.
#[derive(Debug, Clone, Copy)]
pub struct Predicate {
    pub name: &'static str,
    pub asked: Asked,
    /// How text without a mark is compared; `None` for predicates that take none.
    pub default: Option<Mark>,
    pub doc: &'static str,
    pub example: &'static str,
}

const fn predicate(
    name: &'static str,
    asked: Asked,
    default: Option<Mark>,
    example: &'static str,
    doc: &'static str,
) -> Predicate {
    Predicate { name, asked, default, doc, example }
}

/// Every predicate there is.
#[rustfmt::skip]
pub const PREDICATES: &[Predicate] = &[
    predicate("scenario", Asked::Scenario, Some(Mark::Contains), "scenario(walker)",
        "Trials of scenarios of that name. A pattern with `/` is compared with SUITE/SCENARIO."),
    predicate("suite", Asked::Suite, Some(Mark::Glob), "suite(zebra*)",
        "Everything in suites of that name. A scenario file run by itself is a suite named after it."),
    predicate("tag", Asked::Tag, Some(Mark::Glob), "tag(paper)",
        "Scenarios with a tag like that, of their own or from the suite."),
    predicate("model", Asked::Model, Some(Mark::Glob), "model(commotions)",
        "Scenarios in which a pedestrian walks by that model."),
    predicate("controller", Asked::Controller, Some(Mark::Glob), "controller(carla_*)",
        "Scenarios in which a vehicle drives by that controller."),
    predicate("file", Asked::File, Some(Mark::Glob), "file(zebra/*.scn)",
        "What is written in that scenario file or loaded from that suite. `=` and `#` may leave out the folders that the\n\
         path begins with; `*` stays within a folder, `**` does not."),
    predicate("variation", Asked::Variation, Some(Mark::Equal), "variation(tta >= 10 s)",
        "Trials in which a variation has that value. `=`, `!=`, `<`, `<=`, `>` and `>=` compare quantities, so that\n\
         `tta=6s` and `tta=6000ms` are the same; words are equal or not: `style=normal`. `tta~1`, `tta#1?s` and `tta/^1/`\n\
         look at how the value is written; `tta` alone means any value."),
    predicate("block", Asked::Block, Some(Mark::Contains), "block(low_pet)",
        "Blocks of that name, such as searches and tunes; no trials. A pattern with `/` is compared with SUITE/BLOCK."),
    predicate("kind", Asked::Kind, Some(Mark::Glob), "kind(search)",
        "Trials (`scenario`) or one kind of block (`search`, `tune`, …); `list` also knows `rating` and `gate`."),
    predicate("all", Asked::All, None, "all()", "Everything."),
    predicate("none", Asked::None, None, "none()", "Nothing."),
];

impl Predicate {
    pub fn of(name: &str) -> Option<&'static Self> {
        PREDICATES.iter().find(|predicate| predicate.name == name)
    }
}

impl Asked {
    /// The words that a pattern could match in `subject`, for hints.
    pub fn values(self, subject: &Subject) -> Vec<String> {
        let owned = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        let named = || vec![subject.name.to_string(), format!("{}/{}", subject.suite, subject.name)];
        match self {
            Self::Scenario if subject.kind == SCENARIO => named(),
            Self::Block if subject.kind != SCENARIO => named(),
            Self::Suite => owned(&[subject.suite]),
            Self::Tag => subject.tags.to_vec(),
            Self::Model => owned(&subject.models),
            Self::Controller => owned(&subject.controllers),
            Self::File => owned(&subject.files),
            Self::Kind => owned(&[subject.kind]),
            Self::Variation => subject.variation.iter().map(|a| format!("{}={}", a.name, a.label)).collect(),
            Self::Scenario | Self::Block | Self::All | Self::None => Vec::new(),
        }
    }
}

/// The kind of subjects that are trials.
pub const SCENARIO: &str = "scenario";
