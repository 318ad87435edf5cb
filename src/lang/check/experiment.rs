//! `search NAME { … }` and `tune NAME { … }`

use std::sync::Arc;

use std::collections::HashMap;

use super::block::{Layer, Said, missing, reject_repeats};
use super::comparison::{bound_in, constant_comparison};
use super::criterion;
use super::keep;
use super::literal;
use super::metric::{self, Cast};
use super::pedestrian::individuals;
use super::places::TextPlaces;
use super::search_expect::expectations;
use super::subject::{StatementSubject, Subjects, case_set};
use super::target::{Takes, reject_unmeant, target};
use super::tried::tried;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::notations;
use crate::settings::{self, repeated};
use crate::source::Span;
use crate::syntax::ast::{self, View};
use crate::syntax::{self, phrase};
use crate::value::{self, NameScope, ValueKind};
use scenario::{
    Aggregate, Budget, Claim, Comparison, Dimension, Expression, Goal, InitialDesign, MetricKind, Notation,
    Objective, ParameterKind, PedestrianModel, RangeValues, Relation, Search, SearchMethod, SearchRange,
    Tune, Value, Variation,
};

const MOST_EVALUATIONS: u32 = 1_000_000;

/// The search at `node`.
pub fn search(
    node: ast::Search,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Search> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = format!("search `{}`", name.text());
    let Some(wanted) = block.scenario().map(ast::SearchIn::name) else {
        missing::<ast::SearchIn>(&layers, name.span(), &what, report);
        return None;
    };
    let subject = subjects.scenario(wanted.span(), wanted.text(), &[], places, report)?;
    let cast = subject.cast();
    if let Some(drawn) = block.people().filter(|node| node.are_drawn()) {
        report.push(
            Diagnostic::new(
                Code::BadPeople,
                drawn.span(),
                "a search finds something for each of its people, who are chosen beforehand",
            )
            .label("somebody else in every run")
            .hint("take some: `individuals 20 of standard`; the scenario itself may draw its people"),
        );
        return None;
    }
    let people =
        block.people().map(|node| individuals(Said { node, scope }, &able_models(&subject), places, report));
    let objective = match block.objective() {
        Some(node) => objective(node, &cast, scope, report),
        None => {
            missing::<ast::Measure>(&layers, name.span(), &what, report);
            None
        }
    };
    let over = ranges(&layers, block.over(), (name.span(), &what), &subject, scope, places, report);
    let budget = budget(&layers, block.budget(), name, &what, report);
    let runs = match block.repeat() {
        Some(repeat) => {
            literal::count(repeat.count(), 1, 100_000, "the number of runs per evaluation", report)
        }
        None => Some(1),
    };
    let keep = block.keep().map(|node| {
        let people = block.people().is_some();
        keep::keep(node, (&subject, &cast, scope), over.as_deref(), people, report)
    });
    let expect = expectations(block, &cast, scope, places, report);
    let mut search = Search {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        scenario: subject.scenario.name.clone(),
        individuals: match people {
            Some(people) => Some(people?),
            None => None,
        },
        together: block.together().is_some(),
        objective: objective?,
        over: over?,
        budget: budget?,
        runs: runs?,
        keep: match keep {
            Some(keep) => keep?,
            None => Vec::new(),
        },
        expect: expect?,
        origin: places.origin(name.span()),
    };
    let expected = search.expect.iter().filter_map(|criterion| match &criterion.claim {
        Claim::Runs { comparison, .. } => Some((comparison, notations::of_criterion(criterion))),
        Claim::Aggregate { .. } => None,
    });
    search.objective.notation = unit_beside(&search.objective, search.kept_metrics().chain(expected));
    Some(search)
}

/// The tune at `node`.
pub fn tune(
    node: ast::Tune,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Tune> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = format!("tune `{}`", name.text());
    let Some(on) = block.on() else {
        missing::<ast::OnCases>(&layers, name.span(), &what, report);
        return None;
    };
    let (case_set, subject) = case_set(on, subjects, places, report)?;
    let cast = subject.cast();
    let objectives: Vec<_> =
        block.objectives().map(|node| (node.span(), objective(node, &cast, scope, report))).collect();
    match objectives.as_slice() {
        [] => missing::<ast::Measure>(&layers, name.span(), &what, report),
        [_, _, more, ..] => report.push(
            Diagnostic::new(Code::BadObjective, more.0, "a tune has at most two objectives")
                .label("one too many")
                .hint("turn one of them into a constraint: `subject to …`"),
        ),
        _ => {}
    }
    let nodes: Vec<ast::Constraint> = block.constraints().flat_map(ast::Constraints::each).collect();
    let constraints: Vec<_> = nodes.iter().map(|node| constraint(*node, &cast, scope, report)).collect();
    let constraints_in: Vec<_> = nodes.iter().map(|node| bound_in(node.condition(), scope)).collect();
    let over = ranges(&layers, block.over(), (name.span(), &what), &subject, scope, places, report);
    let over = over.filter(|_| only_parameters(block, report));
    let budget = budget(&layers, block.budget(), name, &what, report);
    let tries = over.as_deref().map(|over| tried(block, over, &subject, scope, report));
    let fresh = fresh_seeds(block.fresh_seeds(), report);
    let fallback = fewest_violations(block, report);
    let constraints: Vec<Comparison> = constraints.into_iter().collect::<Option<_>>()?;
    let mut objectives: Vec<Objective> =
        objectives.into_iter().map(|(_, objective)| objective).collect::<Option<_>>()?;
    for objective in &mut objectives {
        objective.notation = unit_beside(objective, constraints.iter().zip(constraints_in.iter().copied()));
    }
    Some(Tune {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        on: case_set,
        over: over?,
        objectives,
        constraints,
        constraints_in,
        tries: tries??,
        budget: budget?,
        fresh: fresh?,
        early_stop: block.stop_early().is_some(),
        otherwise_fewest_violations: fallback?,
        compare_with_default: block.compare().is_some(),
        origin: places.origin(name.span()),
    })
}

/// Whether the block says what to take where nothing is feasible.
fn fewest_violations(block: ast::TuneBlock, report: &mut Vec<Diagnostic>) -> Option<bool> {
    let Some(otherwise) = block.otherwise() else { return Some(false) };
    let mut wrong = |message: &str, label: &str, hint: &str| {
        let diagnostic = Diagnostic::new(Code::BadFallback, otherwise.span(), message);
        report.push(diagnostic.label(label).hint(hint));
        None
    };
    if block.constraints().next().is_none() {
        return wrong(
            "nothing can be violated",
            "there is no constraint",
            "add `subject to pet >= 1.5 s`, or remove this line",
        );
    }
    if block.stop_early().is_some() {
        return wrong(
            "violations are not counted where a candidate is given up at the first",
            "needs every run of the set",
            "remove `stop early`",
        );
    }
    Some(true)
}

/// Cases have values of their own for what is varied, so that a tune over it would try the same thing again and again.
fn only_parameters(block: ast::TuneBlock, report: &mut Vec<Diagnostic>) -> bool {
    let targets = block.over().flat_map(ast::Over::ranges).map(ast::OverRange::target);
    let varied: Vec<ast::Target> = targets.filter(|target| target.parameter().is_none()).collect();
    for target in &varied {
        report.push(
            Diagnostic::new(
                Code::BadTarget,
                target.span(),
                format!("`{}` is varied, and a tune chooses parameters", target.text()),
            )
            .label("not a parameter")
            .hint("name one, such as `av.controller.braking_distance`; a search finds values of variations"),
        );
    }
    varied.is_empty()
}

/// The models of the pedestrian that could be an individual, of the first if none could.
fn able_models(subject: &StatementSubject) -> Vec<Arc<PedestrianModel>> {
    let models = subject.scenario.pedestrians.iter().map(|person| {
        person.model.all().iter().filter_map(|model| model.entry().cloned()).collect::<Vec<_>>()
    });
    let able = |models: &Vec<Arc<PedestrianModel>>| models.iter().all(|model| model.takes_individuals);
    models.max_by_key(able).unwrap_or_default()
}

/// A comparison of a tune, whose bound is the same for all runs.
fn constraint(
    node: ast::Constraint,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Comparison> {
    let said = (node.condition(), node.undefined(), "the bound of this comparison");
    constant_comparison(said, cast, scope, report)
}

/// The unit in which one of the comparisons compares the objective's metric, unless the objective counts runs.
fn unit_beside<'c>(
    objective: &Objective,
    mut comparisons: impl Iterator<Item = (&'c Comparison, Option<Notation>)>,
) -> Option<Notation> {
    if matches!(objective.aggregate, Aggregate::Rate(_) | Aggregate::Count(_)) {
        return None;
    }
    let same = |(comparison, unit): (&Comparison, Option<Notation>)| {
        unit.filter(|_| comparison.metric == *objective.aggregate.metric())
    };
    comparisons.find_map(same)
}

fn objective(
    node: ast::Measure,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Objective> {
    let (direction, word) = match node.is_minimised() {
        true => (Goal::Minimise, "minimise"),
        false => (Goal::Maximise, "maximise"),
    };
    let SummedUp { aggregate, text, .. } = summed_up(node, word, cast, scope, report)?;
    Some(Objective { direction, aggregate, text: format!("{word} {text}"), notation: None })
}

/// An aggregate with what it can be compared to.
pub struct SummedUp {
    pub aggregate: Aggregate,
    pub dimension: Dimension,
    pub range: (f64, f64),
    /// In canonical words, such as `mean(pet)`.
    pub text: String,
}

/// The aggregate after `word`; a metric alone means its mean or rate.
pub fn summed_up(
    node: ast::Measure,
    word: &str,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<SummedUp> {
    let Some(metric) = node.metric() else {
        let of = node.aggregate()?;
        let (aggregate, dimension, range) = criterion::aggregate(of, cast, scope, report)?;
        let text = syntax::aggregate_text(of);
        return Some(SummedUp { aggregate, dimension, range, text });
    };
    let (reference, found) = metric::metric_reference(metric, cast, scope, report)?;
    let text = syntax::metric_text(metric);
    match &found.kind {
        MetricKind::Quantity(dimension) => {
            let (aggregate, text) = (Aggregate::Mean(reference), format!("mean({text})"));
            Some(SummedUp {
                aggregate,
                dimension: *dimension,
                range: (f64::NEG_INFINITY, f64::INFINITY),
                text,
            })
        }
        MetricKind::Flag => {
            let comparison = Comparison {
                metric: reference,
                relation: Relation::Equal,
                bound: Expression::number(1.0),
                when_undefined: Default::default(),
            };
            let (aggregate, text) = (Aggregate::Rate(comparison), format!("rate({text})"));
            Some(SummedUp { aggregate, dimension: Dimension::NUMBER, range: (0.0, 1.0), text })
        }
        MetricKind::Category(_) => {
            report.push(
                Diagnostic::new(
                    Code::BadObjective,
                    metric.span(),
                    format!("`{text}` is {}, which cannot be small or large", metric::kind_name(&found)),
                )
                .label("not a quantity")
                .hint(format!("take a rate: `{word} rate({text} = …)`")),
            );
            None
        }
    }
}

fn budget<'t>(
    layers: &[Layer<'t, impl View<'t>>],
    said: Option<ast::Budget<'t>>,
    name: ast::Name,
    what: &str,
    report: &mut Vec<Diagnostic>,
) -> Option<Budget> {
    let Some(node) = said else {
        missing::<ast::Budget>(layers, name.span(), what, report);
        return None;
    };
    reject_repeats(*node, report);
    let evaluations =
        literal::count(node.evaluations(), 1, MOST_EVALUATIONS, "the number of evaluations", report)?;
    let (initial, initial_design) = match node.initial() {
        Some(first) => {
            let count = literal::count(first.count(), 1, MOST_EVALUATIONS, "the first evaluations", report)?;
            if count > evaluations {
                report.push(
                    Diagnostic::new(
                        Code::BadBudget,
                        first.span(),
                        format!("{count} evaluations come first, but there are only {evaluations} in all"),
                    )
                    .label("more than all")
                    .hint("the first ones are part of all evaluations"),
                );
                return None;
            }
            let random = first.is_random();
            (count, if random { InitialDesign::Random } else { InitialDesign::Stratified })
        }
        None => ((evaluations / 4).max(1), InitialDesign::Stratified),
    };
    let method = match node.method() {
        None => SearchMethod::Bayesian,
        Some(method) if method.is_gp_minimize_like() => SearchMethod::GpMinimizeLike,
        Some(method) if method.is_random() => SearchMethod::Random,
        Some(method) if method.is_latin_hypercube() => SearchMethod::LatinHypercube,
        Some(method) if method.is_sobol() => SearchMethod::Sobol,
        Some(method) if method.is_grid() => SearchMethod::Grid,
        Some(_) => SearchMethod::Bayesian,
    };
    let batch = match node.batch() {
        Some(batch) => literal::count(batch.count(), 1, 1000, "the evaluations at once", report)?,
        None => 1,
    };
    Some(Budget { evaluations, initial, initial_design, method, batch })
}

fn ranges<'t>(
    layers: &[Layer<'t, impl View<'t>>],
    over: impl Iterator<Item = ast::Over<'t>>,
    (name, what): (Span, &str),
    subject: &StatementSubject,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<SearchRange>> {
    let nodes: Vec<ast::OverRange> = over.flat_map(ast::Over::ranges).collect();
    if nodes.is_empty() {
        missing::<ast::Over>(layers, name, what, report);
        return None;
    }
    let mut said: HashMap<String, Span> = HashMap::new();
    for target in nodes.iter().map(|node| node.target()) {
        if let Some(first) = said.insert(phrase(*target), target.span()) {
            report.push(repeated(&phrase(*target), target.span(), first));
        }
    }
    reject_parted(&said, subject, report);
    let ranges: Vec<_> = nodes.into_iter().map(|node| range(node, subject, scope, places, report)).collect();
    ranges.into_iter().collect()
}

/// Reports what is searched without a name that it is varied together with, which would have no value.
fn reject_parted(said: &HashMap<String, Span>, subject: &StatementSubject, report: &mut Vec<Diagnostic>) {
    for variation in &subject.scenario.variations {
        let (Variation::Grid { names, .. } | Variation::Sampled { names, .. }) = variation;
        let searched = names.iter().find_map(|name| Some((name, *said.get(name)?)));
        let left = names.iter().find(|name| !said.contains_key(*name));
        if let (Some((name, span)), Some(left)) = (searched, left) {
            report.push(
                Diagnostic::new(
                    Code::BadTarget,
                    span,
                    format!("`{name}` is varied together with `{left}`, which would have no value"),
                )
                .label("one of several that belong together")
                .hint(format!("search over `{left}` too, or vary the two by themselves")),
            );
        }
    }
}

fn range(
    node: ast::OverRange,
    subject: &StatementSubject,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<SearchRange> {
    let target_node = node.target();
    let (target, takes) = target(target_node, subject, report)?;
    let what = format!("`{target}`");
    reject_unmeant(target_node, &target, &takes, subject.scenario, "is searched", report)?;
    let (kind, whole, limits, options) = match &takes {
        Takes::Kind(kind) => {
            let kind = *kind;
            let varied = subject.varied.get(target_node.name().text());
            let values =
                varied.filter(|_| kind == ValueKind::Word).and_then(|binding| binding.varied.as_ref());
            let words = values.map(|values| values.iter().filter_map(|one| one.value.as_word()).collect());
            (kind, false, (f64::NEG_INFINITY, f64::INFINITY), words)
        }
        Takes::Parameter(declaration, name) => match declaration.parameter(name).map(|found| &found.kind) {
            Some(ParameterKind::Number { dimension, range, .. }) => {
                (ValueKind::Number(*dimension), false, *range, None)
            }
            Some(ParameterKind::Whole { range: (low, high), .. }) => {
                (ValueKind::Number(Dimension::NUMBER), true, (*low as f64, *high as f64), None)
            }
            Some(ParameterKind::Choice { options, .. }) => {
                let names = options.iter().map(|option| &*option.name).collect();
                (ValueKind::Word, false, (0.0, 0.0), Some(names))
            }
            Some(ParameterKind::Text { .. } | ParameterKind::Pedestrian) => {
                (ValueKind::Word, false, (0.0, 0.0), None)
            }
            Some(ParameterKind::Flag { .. }) => (ValueKind::Flag, false, (0.0, 0.0), None),
            None => {
                let names: Option<Vec<_>> = declaration
                    .presets
                    .as_ref()
                    .map(|family| family.presets.iter().map(|preset| &*preset.name).collect());
                (ValueKind::Word, false, (0.0, 0.0), names)
            }
        },
    };
    let mut notation = None;
    let (values, unit) = match (kind, node.list()) {
        (ValueKind::Number(dimension), None) => {
            let mut bounds = node.bounds();
            let mut bound = || {
                let (bound, written) =
                    value::written_constant(bounds.next()?, dimension, limits, &what, scope, report)?;
                notation = notation.or(written);
                Some(bound)
            };
            let (low, high) = (bound(), bound());
            let (low, high) = (low?, high?);
            (interval(node, low, high, whole, report)?, dimension.si_unit())
        }
        (ValueKind::Word, Some(list)) => {
            (RangeValues::Words(words(list, &what, options, scope, report)?), String::new())
        }
        (kind, _) => {
            let (message, hint) = match kind {
                ValueKind::Number(_) => ("numbers are searched between two bounds", "write `LOW .. HIGH`"),
                ValueKind::Word => ("words are searched from a list", "write `[one, another]`"),
                ValueKind::Flag => ("`true` and `false` cannot be searched", "run both as a variation"),
            };
            report.push(
                Diagnostic::new(Code::BadRange, node.span(), format!("{what}: {message}"))
                    .label(format!("takes {}", kind.name()))
                    .hint(hint),
            );
            return None;
        }
    };
    Some(SearchRange { target, values, unit, notation, origin: places.origin(node.span()) })
}

fn interval(
    node: ast::OverRange,
    low: f64,
    high: f64,
    whole: bool,
    report: &mut Vec<Diagnostic>,
) -> Option<RangeValues> {
    let logarithmic = node.is_logarithmic();
    let fault = if low >= high {
        Some(("the first bound is not below the second", "write the smaller one first"))
    } else if logarithmic && low <= 0.0 {
        Some(("a logarithmic range begins above zero", "begin with a positive value"))
    } else if whole && (low.fract() != 0.0 || high.fract() != 0.0) {
        Some(("this parameter takes whole numbers", "write whole bounds"))
    } else {
        None
    };
    if let Some((message, hint)) = fault {
        report.push(
            Diagnostic::new(Code::BadRange, node.span(), message).label("cannot be searched").hint(hint),
        );
        return None;
    }
    Some(match (whole, logarithmic) {
        (true, _) => RangeValues::Whole { low: low as i64, high: high as i64 },
        (_, true) => RangeValues::Logarithmic { low, high },
        _ => RangeValues::Real { low, high },
    })
}

fn words(
    list: ast::List,
    what: &str,
    options: Option<Vec<&str>>,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<String>> {
    let mut words = Vec::new();
    for node in list.values() {
        let word = match (&options, node.lone_word()) {
            (Some(options), _) => match settings::choice(node, what, options, scope, report)? {
                Expression::Constant(Value::Word(word)) => word,
                varying => return value::not_constant(node.span(), &varying, what, report),
            },
            (None, Some(word)) => word.to_string(),
            (None, None) => syntax::expression(node).trim_matches('"').to_string(),
        };
        words.push(word);
    }
    if words.len() < 2 {
        report.push(
            Diagnostic::new(Code::BadRange, list.span(), "there is nothing to choose from")
                .label("fewer than two words")
                .hint("list at least two"),
        );
        return None;
    }
    Some(words)
}

/// How often every case runs under fresh seeds; 0 if the block does not say so.
pub fn fresh_seeds(said: Option<ast::FreshSeeds>, report: &mut Vec<Diagnostic>) -> Option<u32> {
    match said {
        Some(said) => literal::count(said.count(), 1, 100_000, "the number of fresh seeds", report),
        None => Some(0),
    }
}
