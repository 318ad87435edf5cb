//! Searches, tunes, evaluates and statements.

use super::{
    Aggregate, Condition, Doc, Expression, Individuals, Integer, List, Metric, Name, Quantity, Reference,
    Relation, Repeat, SettingName, Text, Undefined, When,
};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `search NAME { … }`
    Search = search { name: Name, block: SearchBlock }
    SearchBlock = search_block {
        doc: (Doc),
        scenario: (SearchIn),
        people: (Individuals),
        together: (Together),
        objective: (Measure),
        over: [Over],
        budget: (Budget),
        repeat: (Repeat),
        keep: (Constraint),
    }
    /// `in SCENARIO`
    SearchIn = search_in { name: Name }
    Together = together {}
    /// `keep pet < 1.5 s`, or what a tune is subject to
    Constraint = keep | constraint { condition: Condition, undefined: (Undefined) }
    /// `tune NAME { … }`
    Tune = tune { name: Name, block: TuneBlock }
    TuneBlock = tune_block {
        doc: (Doc),
        on: (OnCases),
        over: [Over],
        objectives: [Measure],
        constraints: [Constraints],
        budget: (Budget),
        fresh_seeds: (FreshSeeds),
        stop_early: (StopEarly),
        otherwise: (Otherwise),
        compare: (Compare),
    }
    /// `subject to …`
    Constraints = constraints { each: [Constraint] }
    StopEarly = stop_early {}
    /// `otherwise fewest violations`
    Otherwise = otherwise {}
    /// `compare with default`
    Compare = compare {}
    /// `on …`
    OnCases = on_cases {
        path: (Text),
        as_many: (AsMany),
        is_of_all: {kw_all},
        count: (Integer),
        name: (Name),
    }
    /// `as many of SCENARIO as SEARCH`
    AsMany = as_many { names: [Name] }
    /// What is made small or large, or a column of a table.
    Measure = objective | measure { is_minimised: {kw_minimise}, aggregate: (Aggregate), metric: (Metric) }
    Over = over { ranges: [OverRange] }
    /// `tta in 6 s .. 18 s`
    OverRange = over_range {
        target: Target,
        list: (List),
        bounds: [Expression],
        is_logarithmic: {kw_logarithmic},
    }
    /// `tta` or `av.controller.gap`
    Target = target {
        name: Name,
        is_of_controller: {kw_controller},
        is_of_dynamics: {kw_dynamics},
        is_of_sees: {kw_sees},
        parameter: (SettingName),
    }
    Budget = budget { evaluations: Integer, initial: (Initial), method: (Method), batch: (Batch) }
    /// `15 random first`
    Initial = initial { count: Integer, is_random: {kw_random} }
    /// `by sobol`
    Method = method {
        is_gp_minimize_like: {kw_gp_minimize_like},
        is_random: {kw_random},
        is_latin_hypercube: {kw_latin_hypercube},
        is_sobol: {kw_sobol},
        is_grid: {kw_grid},
    }
    /// `4 at once`
    Batch = batch { count: Integer }
    /// `evaluate NAME { … }`
    Evaluate = evaluate { name: Name, block: EvaluateBlock }
    EvaluateBlock = evaluate_block {
        doc: (Doc),
        on: (OnCases),
        conditions: [Conditions],
        fresh_seeds: (FreshSeeds),
        measures: [Measures],
        source: (Source),
        rows: [ReportedRow],
    }
    /// `with …`
    Conditions = conditions { each: [Evaluated] }
    Evaluated = evaluated { set: (ParameterSet), path: (Text), name: (Name), alias: (Alias) }
    /// `as NAME`
    Alias = alias { name: Name }
    /// `{ av.controller.gap: 5 m }`
    ParameterSet = parameter_set { given: [Given] }
    Given = given { target: Target, value: Expression }
    /// `repeat 20 with fresh seeds`
    FreshSeeds = fresh_seeds { count: Integer }
    Measures = measures { each: [Measure] }
    Source = source { quoted: Text }
    /// `reported NAME: 2.5 s, 3 %`
    ReportedRow = reported_row { name: Name, values: [Expression] }
    /// `statement NAME { … }`
    Statement = statement { name: Name, block: StatementBlock }
    StatementBlock = statement_block {
        doc: (Doc),
        source: (Source),
        reported: (Reported),
        claims: [Claim],
        differs: (Differs),
        not_comparable: (NotComparable),
    }
    Reported = reported { quoted: Text }
    Differs = differs { reason: Text }
    NotComparable = not_comparable { reason: Text }
    Claim = claim { trend: (Trend), sides: [Claimed], relation: (Relation) }
    /// `… rises with tta`
    Trend = trend { measured: Measured, rises: {kw_rises}, name: Name }
    /// A calculation with what was measured.
    Claimed = claimed {}
    ClaimedGroup = claimed_group { inside: Claimed }
    /// `mean(pet) of SCENARIO when tta = 6 s`
    Measured = measured { aggregate: Aggregate, outcomes: Outcomes, when: (When) }
    /// `NAME` or `EVALUATE.CONDITION`
    Outcomes = outcomes { names: [Name] }
    /// `chosen(av.controller.gap) of TUNE`
    Chosen = chosen { target: Target, tune: Name }
}

choices! {
    /// What a suite computes besides its trials.
    Block = Search | Tune | Evaluate | Statement;
    /// What a claim is made of, between operators.
    ClaimedOperand = Measured | Chosen | ClaimedGroup | Quantity | Reference;
    /// What names scenarios or blocks.
    Referring = SearchIn | OnCases | AsMany | Evaluated | Outcomes | Chosen;
}

impl<'t> Block<'t> {
    pub fn name(self) -> Name<'t> {
        match self {
            Self::Search(search) => search.name(),
            Self::Tune(tune) => tune.name(),
            Self::Evaluate(evaluate) => evaluate.name(),
            Self::Statement(statement) => statement.name(),
        }
    }
}
