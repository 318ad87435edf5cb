//! Searches, tunes, evaluates and statements.

use super::super::entry::{BlockEntry, BlockKind, StatementEntry, YamlShape, statement};
use super::{
    Aggregate, Condition, Confidence, Doc, Expect, Expression, Individuals, Integer, List, Metric, Name,
    Population, Quantity, Rate, Reference, Relation, Repeat, SettingName, Text, Undefined, When,
};
use super::{DOC, EXPECT, INDIVIDUAL, INDIVIDUALS, REPEAT};
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
        keep: (Keep),
        expects: [Expect],
    }
    /// `in SCENARIO`
    SearchIn = search_in { name: Name }
    Together = together {}
    /// `keep pet < 1.5 s and plausibility >= 5 %`
    Keep = keep { each: [Constraint] }
    /// What a search keeps, or what a tune is subject to
    Constraint = constraint { condition: Condition, undefined: (Undefined) }
    /// `tune NAME { … }`
    Tune = tune { name: Name, block: TuneBlock }
    TuneBlock = tune_block {
        doc: (Doc),
        on: (OnCases),
        over: [Over],
        objectives: [Measure],
        constraints: [Constraints],
        budget: (Budget),
        tries: [Try],
        fresh_seeds: (FreshSeeds),
        stop_early: (StopEarly),
        otherwise: (Otherwise),
        compare: (Compare),
    }
    /// `try { braking_distance: 8 m }`
    Try = try_values { set: ParameterSet }
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
    /// `calibrate NAME { … }`
    Calibrate = calibrate { name: Name, block: CalibrateBlock }
    CalibrateBlock = calibrate_block {
        doc: (Doc),
        candidates: (Candidates),
        scenarios: (CalibrateIn),
        matched: [Matched],
        spreads: [MatchedSpread],
        parameters: [MatchedParameter],
        method: (CalibrateMethod),
        folds: (Folds),
        repeat: (Repeat),
        compare: (ComparePeople),
    }
    /// `candidates 2000 by latin_hypercube` or `candidates all of "people.csv"`
    Candidates = candidates {
        is_latin_hypercube: {kw_latin_hypercube},
        are_all: {kw_all},
        count: (Integer),
        population: (Population),
    }
    /// `in SCENARIO, SCENARIO`
    CalibrateIn = calibrate_in { names: [Name] }
    /// `match rate(gap_accepted) to "people.csv"`
    Matched = matched {
        rate: Rate,
        path: Text,
        counted_where: (CountedWhere),
        undefined: (Undefined),
        not_counted: (NotCounted),
    }
    /// `where no gap_accepted(cars_4, walker)`
    CountedWhere = counted_where { condition: Condition }
    /// `undefined not counted`
    NotCounted = not_counted {}
    /// `match spread between individuals of rate(gap_accepted) within 80 % of error`
    MatchedSpread = matched_spread { rate: Rate, within: (Expression) }
    /// `match mean of walker.model.ped_free_speed to 1.34 m/s within 0.03 m/s`, or its deviation
    MatchedParameter = matched_mean | matched_deviation { is_mean: {kw_mean}, target: Target, bounds: [Expression] }
    /// `method maximum_entropy within 50 % of error`
    CalibrateMethod = calibrate_method { within: (Expression) }
    /// `folds 5`
    Folds = folds { count: Integer }
    /// `compare with standard, "people.json"`
    ComparePeople = compare_people { populations: [Population] }
    /// `estimate NAME { … }`
    Estimate = estimate { name: Name, block: EstimateBlock }
    EstimateBlock = estimate_block {
        doc: (Doc),
        of: (EstimateOf),
        compared_with: (ComparedWith),
        event: (Event),
        score: (Score),
        budget: (EstimateBudget),
        exposure: (Exposure),
        claims: [EstimateClaim],
    }
    /// `of SCENARIO`
    EstimateOf = estimate_of { name: Name }
    /// `compare with SCENARIO`
    ComparedWith = compared_with { name: Name }
    /// `event collision`
    Event = event { condition: Condition, undefined: (Undefined) }
    /// `score pet`
    Score = score { metric: Metric }
    /// `budget 50000 runs, by importance`
    EstimateBudget = estimate_budget { runs: Integer, method: (SamplingMethod) }
    SamplingMethod = sampling_method { is_splitting: {kw_splitting}, is_crude: {kw_crude} }
    /// `exposure 3 .. 12 encounters per 1000 km source "A count"`
    Exposure = exposure { numbers: [Expression], confidence: (Confidence), source: (Text) }
    /// `claim guaranteed <= 1e-3 with 95 % confidence`, `claim ratio <= 1.2`, or `claim <= 0.01 per 1000 km` of two numbers
    EstimateClaim = estimate_claim {
        is_guaranteed: {kw_guaranteed},
        is_difference: {kw_difference},
        is_ratio: {kw_ratio},
        relation: Relation,
        numbers: [Expression],
        confidence: (Confidence),
    }
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
    Block = Search | Tune | Evaluate | Calibrate | Estimate | Statement;
    /// What a claim is made of, between operators.
    ClaimedOperand = Measured | Chosen | ClaimedGroup | Quantity | Reference;
    /// What names scenarios or blocks.
    Referring = SearchIn | CalibrateIn | EstimateOf | ComparedWith | OnCases | AsMany | Evaluated | Outcomes | Chosen;
}

impl<'t> Block<'t> {
    pub fn name(self) -> Name<'t> {
        match self {
            Self::Search(search) => search.name(),
            Self::Tune(tune) => tune.name(),
            Self::Evaluate(evaluate) => evaluate.name(),
            Self::Calibrate(calibrate) => calibrate.name(),
            Self::Estimate(estimate) => estimate.name(),
            Self::Statement(statement) => statement.name(),
        }
    }
}

pub(super) const SEARCH: StatementEntry = statement(
    "search",
    Rule::search,
    "search NAME { … }",
    "Looks for the values at which a metric is worst.",
)
.key("searches", YamlShape::Named)
.opens(BlockKind::Search)
.names();

pub(super) const TUNE: StatementEntry =
    statement("tune", Rule::tune, "tune NAME { … }", "Looks for the best controller parameters.")
        .key("tunes", YamlShape::Named)
        .opens(BlockKind::Tune)
        .names();

pub(super) const EVALUATE: StatementEntry = statement(
    "evaluate",
    Rule::evaluate,
    "evaluate NAME { … }",
    "Compares parameter sets on the same cases.",
)
.key("evaluates", YamlShape::Named)
.opens(BlockKind::Evaluate)
.names();

pub(super) const CALIBRATE: StatementEntry = statement(
    "calibrate",
    Rule::calibrate,
    "calibrate NAME { … }",
    "Weighs candidates until they do what people did: a population.",
)
.key("calibrates", YamlShape::Named)
.opens(BlockKind::Calibrate)
.names();

pub(super) const ESTIMATE: StatementEntry = statement(
    "estimate",
    Rule::estimate,
    "estimate NAME { … }",
    "The probability of a rare event in a scenario that draws: a guaranteed bound and an estimate.",
)
.key("estimates", YamlShape::Named)
.opens(BlockKind::Estimate)
.names();

pub(super) const STATEMENT: StatementEntry = statement(
    "statement",
    Rule::statement,
    "statement NAME { … }",
    "What a source says, held against the results.",
)
.key("statements", YamlShape::Named)
.opens(BlockKind::Statement)
.names();

pub(super) const SOURCE: StatementEntry =
    statement("source", Rule::source, "source \"Wang et al., Table 1\"", "Where reported numbers come from.")
        .key("source", YamlShape::Text);

pub(super) const FRESH_SEEDS: StatementEntry = statement(
    "repeat",
    Rule::fresh_seeds,
    "repeat 20 with fresh seeds",
    "Runs every case this often, none with the seed it was found with.",
)
.key("repeat", YamlShape::Words);

pub(super) const ON: StatementEntry = statement("on", Rule::on_cases, "on low_pet`, `on all of low_pet`, `on 50 of zebra_walk`, `on as many of zebra_walk as low_pet` or `on \"cases.json\"", "The cases: what a search kept, the best case of everybody, a scenario, some of its cases, or a saved set.").key("on", YamlShape::Cases);

pub(super) const BUDGET: StatementEntry = statement(
    "budget",
    Rule::budget,
    "budget 60 evaluations, 15 random first",
    "How many evaluations, how many of them to begin with, and by which method.",
)
.key("budget", YamlShape::Words);

pub(super) const OVER: StatementEntry = statement(
    "over",
    Rule::over,
    "over tta in 6 s .. 18 s",
    "What is searched: a variation, or a parameter such as `av.controller.braking_distance`.",
)
.key("over", YamlShape::Values);

pub(super) const MAXIMISE: StatementEntry =
    statement("maximise", Rule::objective, "maximise rate(gap_accepted)", "What is to be large.")
        .key("maximise", YamlShape::Words);

pub(super) const MINIMISE: StatementEntry =
    statement("minimise", Rule::objective, "minimise mean(time_lost)", "What is to be small.")
        .key("minimise", YamlShape::Words);

pub static SEARCH_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Search,
    rule: Rule::search_block,
    name: "a `search`",
    heads: &[DOC],
    statements: &[
        statement("in", Rule::search_in, "in zebra_walk", "The scenario that is searched.")
            .key("in", YamlShape::Words)
            .needed("scenario", "in SCENARIO"),
        INDIVIDUALS,
        INDIVIDUAL,
        statement(
            "together",
            Rule::together,
            "together",
            "One search over all individuals instead of one for each.",
        )
        .key("together", YamlShape::Flag),
        MINIMISE.needed("objective", "minimise pet"),
        MAXIMISE,
        OVER.needed("range", "over tta in 6 s .. 18 s").repeats(),
        BUDGET.needed("budget", "budget 60 evaluations, 15 random first"),
        REPEAT,
        statement(
            "keep",
            Rule::keep,
            "keep pet < 1.5 s`, `keep pet < 1.5 s and plausibility >= 5 %",
            "Which of the worst cases belong to the set that the search makes: by what is measured, and by how usual the encounter is.",
        )
        .key("keep", YamlShape::Words),
        EXPECT.repeats(),
    ],
};

pub static TUNE_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Tune,
    rule: Rule::tune_block,
    name: "a `tune`",
    heads: &[DOC],
    statements: &[
        ON.needed("cases", "on SCENARIO"),
        OVER.needed("range", "over tta in 6 s .. 18 s").repeats(),
        MINIMISE.needed("objective", "minimise mean(time_lost)").repeats(),
        MAXIMISE.repeats(),
        statement(
            "subject to",
            Rule::constraints,
            "subject to pet >= 1.5 s, no collision",
            "What must hold in every run.",
        )
        .key("subject_to", YamlShape::Commas)
        .repeats(),
        BUDGET.needed("budget", "budget 60 evaluations, 15 random first"),
        statement(
            "try",
            Rule::try_values,
            "try { braking_distance: 8 m }",
            "A candidate of your own, evaluated after what is declared and before all others; what it leaves out is as declared.",
        )
        .key("try", YamlShape::ParameterSets)
        .repeats(),
        FRESH_SEEDS,
        statement(
            "stop early",
            Rule::stop_early,
            "stop early",
            "Gives a candidate up at its first violation.",
        )
        .key("stop_early", YamlShape::Flag),
        statement(
            "otherwise",
            Rule::otherwise,
            "otherwise fewest violations",
            "Where no candidate keeps every constraint, takes the one that breaks them in the fewest runs.",
        )
        .key("otherwise", YamlShape::Words),
        statement(
            "compare with default",
            Rule::compare,
            "compare with default",
            "Adds a table of before and after.",
        )
        .key("compare_with_default", YamlShape::Flag),
    ],
};

pub static EVALUATE_BLOCK: BlockEntry = BlockEntry { kind: BlockKind::Evaluate, rule: Rule::evaluate_block, name: "an `evaluate`", heads: &[DOC], statements: &[
ON.needed("cases", "on SCENARIO"),
statement("with", Rule::conditions, "with default, braking, \"tuned.json\" as saved, { av.controller.braking_distance: 10 m } as ten", "The conditions: what is declared, what a tune chose, another scenario, a saved set or parameters in place; \
                 the first is what the others are compared with.").key("with", YamlShape::Conditions).needed("conditions", "with default, TUNE"),
FRESH_SEEDS,
statement("measure", Rule::measures, "measure mean(pet), rate(collision)", "The columns of the table.").key("measure", YamlShape::Commas),
SOURCE,
statement("reported", Rule::reported_row, "reported default: 2.5 s, 3 %", "What a source has for a condition, a value for each measure.").key("reported", YamlShape::Rows).repeats(),
]};

pub static CALIBRATE_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Calibrate,
    rule: Rule::calibrate_block,
    name: "a `calibrate`",
    heads: &[DOC],
    statements: &[
        statement(
            "candidates",
            Rule::candidates,
            "candidates 2000 by latin_hypercube`, `candidates all of \"people.csv\"` or `candidates 500 of standard",
            "Who is weighed: parameter sets over the ranges that published individuals span, or those of a population.",
        )
        .key("candidates", YamlShape::Words)
        .needed("candidates", "candidates 2000 by latin_hypercube"),
        statement(
            "in",
            Rule::calibrate_in,
            "in crossing_plain, crossing_zebra",
            "The scenarios whose conditions people were observed in.",
        )
        .key("in", YamlShape::Words)
        .needed("scenarios", "in SCENARIO"),
        statement(
            "match spread",
            Rule::matched_spread,
            "match spread between individuals of rate(gap_accepted)`, `match spread between individuals of rate(gap_accepted) within 80 % of error",
            "That people differ as those did who were observed: the share of pairs of a person's trials in which both hold; within a part of its error of its own, or else the method's.",
        )
        .key("match_spread", YamlShape::Words)
        .repeats(),
        statement(
            "match",
            Rule::matched,
            "match rate(gap_accepted) to \"human_crossing.csv\" undefined fails`, `match rate(gap_accepted) to \"human_crossing.csv\" undefined not counted`, `match rate(gap_accepted(cars_5, walker)) to \"pivot.csv\" where no gap_accepted(cars_4, walker)",
            "What people did, a condition a row; once for each experiment, or for each thing that was counted there. Shares are of all runs, or only of those that count, as those of people are of the trials in which they were still there: `where` something holds, or with `undefined not counted` where the metric exists.",
        )
        .key("match", YamlShape::Words)
        .repeats()
        .needed("observations", "match rate(gap_accepted) to \"people.csv\""),
        statement(
            "match mean",
            Rule::matched_mean,
            "match mean of walker.model.ped_free_speed to 1.34 m/s within 0.03 m/s`, `match mean of walker.model.beta_V to 20 within 2",
            "What is known besides of how a parameter is distributed: its mean among the weighted candidates lies within so much of that.",
        )
        .key("match_mean", YamlShape::Words)
        .repeats(),
        statement(
            "match deviation",
            Rule::matched_deviation,
            "match deviation of walker.model.ped_free_speed to 0.26 m/s within 0.03 m/s",
            "The same of its standard deviation, about the mean that is matched.",
        )
        .key("match_deviation", YamlShape::Words)
        .repeats(),
        statement(
            "method",
            Rule::calibrate_method,
            "method maximum_entropy`, `method maximum_entropy within 50 % of error",
            "The smallest change from equal weights that matches within error, or within a part of it.",
        )
        .key("method", YamlShape::Words),
        statement("folds", Rule::folds, "folds 5", "In how many parts conditions are held back in turn.")
            .key("folds", YamlShape::Words),
        REPEAT,
        statement(
            "compare",
            Rule::compare_people,
            "compare with standard, \"people.json\"",
            "Other populations in the same conditions, shown beside people and the weighed candidates.",
        )
        .key("compare", YamlShape::Words),
    ],
};

pub static ESTIMATE_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Estimate,
    rule: Rule::estimate_block,
    name: "an `estimate`",
    heads: &[DOC],
    statements: &[
        statement("of", Rule::estimate_of, "of walk", "The scenario, which draws something in every run.")
            .key("of", YamlShape::Words)
            .needed("scenario", "of SCENARIO"),
        statement(
            "compare",
            Rule::compared_with,
            "compare with walk_before",
            "A scenario that draws the same, such as one with another controller, in the same encounters: claims may be about the difference.",
        )
        .key("compare", YamlShape::Words),
        statement(
            "event",
            Rule::event,
            "event collision`, `event pet < 0.5 s",
            "What the probability is of: anything that is true or false of a single run.",
        )
        .key("event", YamlShape::Words)
        .needed("event", "event collision"),
        statement(
            "score",
            Rule::score,
            "score pet",
            "A metric that gets worse the nearer a run is to the event: it shows where to look.",
        )
        .key("score", YamlShape::Words)
        .needed("score", "score pet"),
        statement(
            "budget",
            Rule::estimate_budget,
            "budget 50000 runs, by importance`, `budget 200000 runs, by splitting`, `budget 1000000 runs, by crude",
            "How many runs are made, and how: where the event is likely, weighed, or as they are drawn.",
        )
        .key("budget", YamlShape::Words)
        .needed("budget", "budget 50000 runs, by importance"),
        statement(
            "exposure",
            Rule::exposure,
            "exposure 3 .. 12 encounters per 1000 km source \"How they were counted, where and when\"",
            "How many such encounters there are along how far, and how that is known: results are then told per 1,000 km as well. There is no default.",
        )
        .key("exposure", YamlShape::Words),
        statement(
            "claim",
            Rule::estimate_claim,
            "claim <= 1e-5 with 95 % confidence`, `claim guaranteed <= 1e-3`, `claim <= 0.01 per 1000 km`, `claim ratio <= 1.2`, `claim difference <= 1e-6",
            "What the probability is at most: by the estimate, or by the bound that needs no assumption; with an exposure also how many events there are along a distance. Where it is compared, how much or how many times more probable the event is than there.",
        )
        .key("claims", YamlShape::Lines)
        .repeats(),
    ],
};

pub static STATEMENT_BLOCK: BlockEntry = BlockEntry {
    kind: BlockKind::Statement,
    rule: Rule::statement_block,
    name: "a `statement`",
    heads: &[DOC],
    statements: &[
        SOURCE,
        statement(
            "reported",
            Rule::reported,
            "reported \"about 10 % at 6 s\"",
            "The numbers of the source, in words.",
        )
        .key("reported", YamlShape::Text),
        statement(
            "claim",
            Rule::claim,
            "claim mean(pet) of low_pet < 1.5 s`, `claim rate(gap_accepted) of zebra_walk rises with tta` or \
                 `claim mean(pet) of final.tuned > mean(pet) of final.default",
            "What must hold in the results for the statement to be reproduced.",
        )
        .key("claims", YamlShape::Lines)
        .repeats(),
        statement(
            "differs",
            Rule::differs,
            "differs \"the reason\"",
            "It is known not to be reproduced, for this reason.",
        )
        .key("differs", YamlShape::Text),
        statement(
            "not comparable",
            Rule::not_comparable,
            "not comparable \"the reason\"",
            "It cannot be compared, for this reason.",
        )
        .key("not_comparable", YamlShape::Text),
    ],
};
