//! Which key stands for which statement, in both directions.

use crate::lang::tree::Rule;

/// How the value of a key becomes statements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// `KEYWORD words`; a list makes one statement an item.
    Words(&'static str),
    /// As [`Self::Words`], but long ones: a list stands on lines of its own.
    Lines(&'static str),
    /// `KEYWORD a, b, c`
    Commas(&'static str),
    /// `KEYWORD "text"`; a list makes one statement an item.
    Text(&'static str),
    /// A mapping of names to blocks: `KEYWORD name { … }`
    Named(&'static str, Rule),
    /// A name, or a block in place: `road NAME`, `road { … }`
    NameOrBlock(&'static str, Rule),
    /// A list of free statements: `expect { … }`; without a word they stand in the block itself.
    Statements(&'static str),
    /// A name, or a name with settings.
    Model(&'static str),
    /// A mapping of names to settings: `box van { … }`
    NamedSettings(&'static str),
    /// `sees { … }`
    Settings(&'static str),
    /// A mapping: `KEYWORD name in values`
    Values(&'static str),
    /// A mapping, or a list of them, with names that go together.
    Together,
    /// A mapping: `let name = value`
    Bindings,
    /// Stands there if true.
    Flag(&'static str),
    /// Stands there if false.
    NotFlag(&'static str),
    /// Words for cases, or `{ file: PATH }`.
    Cases,
    /// A list of `default`, names, `{ file: PATH, as: NAME }` and `{ set: { parameter: value }, as: NAME }`.
    Conditions,
    /// A mapping of names to lists: `reported name: a, b`
    Rows(&'static str),
    /// Part of the head of a scenario.
    Head,
}

/// A key of a block.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    pub name: &'static str,
    pub shape: Shape,
    /// The statement it stands for.
    pub rule: Rule,
}

const fn key(name: &'static str, shape: Shape, rule: Rule) -> Key {
    Key { name, shape, rule }
}

const DOC: Key = key("doc", Shape::Text(""), Rule::doc);
const TAGS: Key = key("tags", Shape::Commas("tags"), Rule::tags);
const EXPECT: Key = key("expect", Shape::Statements("expect"), Rule::expect);
const LET: Key = key("let", Shape::Bindings, Rule::binding);
const SCENARIOS: Key = key("scenarios", Shape::Named("scenario", Rule::scenario_block), Rule::scenario);
const SEARCHES: Key = key("searches", Shape::Named("search", Rule::search_block), Rule::search);
const TUNES: Key = key("tunes", Shape::Named("tune", Rule::tune_block), Rule::tune);
const EVALUATES: Key = key("evaluates", Shape::Named("evaluate", Rule::evaluate_block), Rule::evaluate);
const STATEMENTS: Key = key("statements", Shape::Named("statement", Rule::statement_block), Rule::statement);
const ON: Key = key("on", Shape::Cases, Rule::on_cases);
const SOURCE: Key = key("source", Shape::Text("source"), Rule::source);
const INDIVIDUALS: Key = key("individuals", Shape::Words("individuals"), Rule::individuals);
const INDIVIDUAL: Key = key("individual", Shape::Words("individual"), Rule::individual);
const SIZE: Key = key("size", Shape::Words("size"), Rule::size);
const REPEAT: Key = key("repeat", Shape::Words("repeat"), Rule::repeat);
const MINIMISE: Key = key("minimise", Shape::Words("minimise"), Rule::objective);
const MAXIMISE: Key = key("maximise", Shape::Words("maximise"), Rule::objective);
const OVER: Key = key("over", Shape::Values("over"), Rule::over);
const BUDGET: Key = key("budget", Shape::Words("budget"), Rule::budget);

/// The keys of a block.
pub fn keys(block: Rule) -> &'static [Key] {
    match block {
        Rule::file => {
            const {
                &[
                    key("use", Shape::Text("use"), Rule::use_file),
                    LET,
                    key("roads", Shape::Named("road", Rule::road_block), Rule::road_definition),
                    key("templates", Shape::Named("define", Rule::scenario_block), Rule::define),
                    SCENARIOS,
                    SEARCHES,
                    TUNES,
                    EVALUATES,
                    STATEMENTS,
                    key("suite", Shape::Named("suite", Rule::suite_block), Rule::suite),
                ]
            }
        }
        Rule::road_block => {
            const {
                &[
                    key("lanes", Shape::Commas("lanes"), Rule::lanes),
                    key("lane_width", Shape::Words("lane_width"), Rule::lane_width),
                    key("speed_limit", Shape::Words("speed_limit"), Rule::speed_limit),
                    key("kerbs", Shape::NotFlag("no kerbs"), Rule::no_kerbs),
                    key("crossing", Shape::Model("crossing"), Rule::crossing),
                    key("boxes", Shape::NamedSettings("box"), Rule::obstacle),
                    key("parked", Shape::NamedSettings("parked"), Rule::obstacle),
                ]
            }
        }
        Rule::scenario_block => {
            const {
                &[
                    DOC,
                    key("extends", Shape::Head, Rule::base),
                    key("parameters", Shape::Head, Rule::parameters),
                    TAGS,
                    key("road", Shape::NameOrBlock("road", Rule::road_block), Rule::road_choice),
                    LET,
                    key("vehicles", Shape::Named("vehicle", Rule::vehicle_block), Rule::vehicle),
                    key("pedestrians", Shape::Named("pedestrian", Rule::pedestrian_block), Rule::pedestrian),
                    key("vary", Shape::Values("vary"), Rule::vary),
                    key("vary_together", Shape::Together, Rule::vary_together),
                    REPEAT,
                    key("runs", Shape::Words("runs"), Rule::runs),
                    key("seed", Shape::Words("seed"), Rule::seed),
                    key("step", Shape::Words("step"), Rule::step),
                    key("horizon", Shape::Words("horizon"), Rule::horizon),
                    key("finish", Shape::Words("finish"), Rule::finish),
                    key("end_on_collision", Shape::Flag("end on collision"), Rule::end_on_collision),
                    EXPECT,
                ]
            }
        }
        Rule::vehicle_block => {
            const {
                &[
                    key("controller", Shape::Model("controller"), Rule::controller),
                    key("dynamics", Shape::Model("dynamics"), Rule::dynamics),
                    key("sees", Shape::Settings("sees"), Rule::sees),
                    SIZE,
                    key("speed", Shape::Words("speed"), Rule::speed),
                    key("lane", Shape::Words("lane"), Rule::lane),
                    key("start", Shape::Words("start"), Rule::vehicle_start),
                ]
            }
        }
        Rule::pedestrian_block => {
            const {
                &[
                    key("model", Shape::Model("model"), Rule::model),
                    INDIVIDUALS,
                    INDIVIDUAL,
                    SIZE,
                    key("radius", Shape::Words("radius"), Rule::radius),
                    key("from", Shape::Words("from"), Rule::side),
                    key("start", Shape::Words("start"), Rule::pedestrian_start),
                    key("along", Shape::Words("along"), Rule::along),
                    key("goal", Shape::Words("goal"), Rule::goal),
                    key("appears", Shape::Words("appears"), Rule::appears),
                ]
            }
        }
        Rule::suite_block => {
            const {
                &[
                    DOC,
                    TAGS,
                    key("files", Shape::Text("scenarios"), Rule::suite_files),
                    key("seed", Shape::Words("seed"), Rule::seed),
                    key("time_limit", Shape::Words("time_limit"), Rule::time_limit),
                    EXPECT,
                    SCENARIOS,
                    SEARCHES,
                    TUNES,
                    EVALUATES,
                    STATEMENTS,
                    key("gates", Shape::Named("gate", Rule::gate_block), Rule::gate),
                ]
            }
        }
        Rule::gate_block => {
            const {
                &[
                    DOC,
                    key("baseline", Shape::Text("baseline"), Rule::baseline),
                    key("rules", Shape::Statements(""), Rule::gate_rule),
                ]
            }
        }
        Rule::search_block => {
            const {
                &[
                    DOC,
                    key("in", Shape::Words("in"), Rule::search_in),
                    INDIVIDUALS,
                    INDIVIDUAL,
                    key("together", Shape::Flag("together"), Rule::together),
                    MINIMISE,
                    MAXIMISE,
                    OVER,
                    BUDGET,
                    REPEAT,
                    key("keep", Shape::Words("keep"), Rule::keep),
                ]
            }
        }
        Rule::tune_block => {
            const {
                &[
                    DOC,
                    ON,
                    OVER,
                    MINIMISE,
                    MAXIMISE,
                    key("subject_to", Shape::Commas("subject to"), Rule::constraints),
                    BUDGET,
                    key("repeat", Shape::Words("repeat"), Rule::fresh_seeds),
                    key("stop_early", Shape::Flag("stop early"), Rule::stop_early),
                    key("otherwise", Shape::Words("otherwise"), Rule::otherwise),
                    key("compare_with_default", Shape::Flag("compare with default"), Rule::compare),
                ]
            }
        }
        Rule::evaluate_block => {
            const {
                &[
                    DOC,
                    ON,
                    key("with", Shape::Conditions, Rule::conditions),
                    key("repeat", Shape::Words("repeat"), Rule::fresh_seeds),
                    key("measure", Shape::Commas("measure"), Rule::measures),
                    SOURCE,
                    key("reported", Shape::Rows("reported"), Rule::reported_row),
                ]
            }
        }
        Rule::statement_block => {
            const {
                &[
                    DOC,
                    SOURCE,
                    key("reported", Shape::Text("reported"), Rule::reported),
                    key("claims", Shape::Lines("claim"), Rule::claim),
                    key("differs", Shape::Text("differs"), Rule::differs),
                    key("not_comparable", Shape::Text("not comparable"), Rule::not_comparable),
                ]
            }
        }
        _ => &[],
    }
}
