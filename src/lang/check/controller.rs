//! `controller NAME { … }` of a file: a program that decides, with its parameters. Nothing is started by reading it.

use std::collections::HashSet;

use super::block::reject_repeats;
use super::fmu;
use super::literal::{count, doc};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{Sources, Span};
use crate::syntax::ast;
use crate::value::{self, NameScope, Typed, ValueKind};
use scenario::registry::{RESERVED, Registry};
use scenario::{
    Answer, ChoiceOption, ControllerModel, Declaration, DeclaredProgram, Delay, Dimension, Expression,
    Parameter, ProgramKind, TextError, Value, limits,
};

/// Where parameters of declared controllers come from.
const SOURCE: &str = "declared in the scenario language";

/// Of a text that a program takes, bytes.
const LONGEST_TEXT: usize = 4096;

const MOST_PROCESSES: u32 = 1024;

/// The controller that a file declares. What is in `registry` already cannot be declared again.
pub fn controller(
    node: ast::ControllerDefinition,
    registry: &Registry,
    scope: &NameScope,
    sources: &Sources,
    report: &mut Vec<Diagnostic>,
) -> Option<ControllerModel> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let before = report.len();
    if RESERVED.contains(&name.text()) || name.text().starts_with('_') {
        report.push(
            Diagnostic::new(
                Code::WrongParameter,
                name.span(),
                format!("`{}` cannot be said in a scenario", name.text()),
            )
            .label("no name of a controller")
            .hint("begin it with a letter"),
        );
    }
    let is_built_in = registry.controllers().get(name.text()).is_some_and(|known| known.program.is_none());
    if is_built_in {
        report.push(
            Diagnostic::new(Code::BuiltInName, name.span(), format!("`{}` is built in", name.text()))
                .label("names a controller that ships")
                .hint("choose another name: reports and baselines tell controllers by it"),
        );
    }
    let file = program_file(name, block, report);
    let environment = environment(block, report);
    let folder = block.folder().map(|said| said.path().path());
    let gives = match block.gives() {
        Some(said) if said.is_pedals() => Answer::Pedals,
        Some(said) if said.is_speed_plan() => Answer::SpeedPlan,
        Some(said) if said.is_speed() => Answer::Speed,
        _ => Answer::Acceleration,
    };
    let mut time = |said: Option<ast::Expression>, limit: limits::Limit, what: &str| {
        said.map(|node| value::constant_in(node, limit.dimension, limit.range, what, scope, report))
    };
    let period = time(block.period().map(ast::Period::value), limits::PERIOD, "the period of a controller");
    let delayed = block.delay().filter(|said| !said.is_measured()).and_then(ast::Delay::value);
    let delay = time(delayed, limits::DELAY, "the delay of a controller");
    let settles =
        time(block.settles().map(ast::Settles::value), limits::SETTLES, "the settling time of a controller");
    let starts_within = time(
        block.starts_within().map(ast::StartsWithin::value),
        limits::WALL_TIME,
        "the time to start within",
    );
    let answers_within = time(
        block.answers_within().map(ast::AnswersWithin::value),
        limits::WALL_TIME,
        "the time to answer within",
    );
    let processes = block
        .processes()
        .map(|said| count(said.number(), 1, MOST_PROCESSES, "the number of processes", report));
    let parameters = parameters(block, scope, report);
    let dynamics = dynamics(block, gives, registry, report);
    let kind = match file {
        Some(ProgramFile::Command(words)) => Some(ProgramKind::Command(words)),
        Some(ProgramFile::Wasm(file)) => Some(ProgramKind::Wasm(file)),
        Some(ProgramFile::Fmu(file)) => {
            fmu::wired(file, block, gives, parameters.as_deref(), sources, report).map(ProgramKind::Fmu)
        }
        None => None,
    };
    if block.fmu().is_none() {
        fmu::reject_wiring(block, report);
    }
    if report.len() > before || block.has_bad() {
        return None;
    }
    let is_measured = block.delay().is_some_and(ast::Delay::is_measured);
    let program = DeclaredProgram {
        name: name.text().to_string(),
        kind: kind?,
        folder: folder.unwrap_or_default(),
        environment: environment?,
        gives,
        period: flat(period)?,
        delay: if is_measured { Delay::Measured } else { Delay::Fixed(flat(delay)?.unwrap_or(0.0)) },
        settles: flat(settles)?.unwrap_or(0.0),
        starts_within: flat(starts_within)?.unwrap_or(30.0),
        answers_within: flat(answers_within)?.unwrap_or(10.0),
        processes: flat(processes)?,
        is_nondeterministic: block.nondeterministic().is_some(),
        file: sources.get(name.span().source).name.clone(),
        origin: sources.origin(name.span()),
        parameters: block
            .parameters()
            .map(|one| (one.name().text().to_string(), sources.origin(one.name().span())))
            .collect(),
    };
    let summary = doc(block.doc()).unwrap_or_default();
    let source = format!("`{}`, declared in {}", program.typed(), program.file);
    let declaration =
        Declaration::new(name.text().to_string(), summary).source(source).parameters(parameters?);
    let model = ControllerModel::of_program(declaration, program);
    Some(match dynamics? {
        Some(named) => model.driving(&named),
        None => model,
    })
}

/// What is said and right, or not said.
fn flat<T>(said: Option<Option<T>>) -> Option<Option<T>> {
    match said {
        Some(right) => right.map(Some),
        None => Some(None),
    }
}

fn unstartable(span: Span, message: impl Into<String>, hint: &str) -> Diagnostic {
    Diagnostic::new(Code::NoProgram, span, message).label("cannot be started like this").hint(hint)
}

/// What decides, as far as its own statement says it.
enum ProgramFile {
    Command(Vec<String>),
    Wasm(String),
    Fmu(String),
}

/// What decides: one of the statements that say it.
fn program_file(
    name: ast::Name,
    block: ast::ControllerBlock,
    report: &mut Vec<Diagnostic>,
) -> Option<ProgramFile> {
    let said = [
        ("command", block.command().map(|said| said.span())),
        ("wasm", block.wasm().map(|said| said.span())),
        ("fmu", block.fmu().map(|said| said.span())),
    ];
    let mut said = said.into_iter().filter_map(|(word, span)| Some((word, span?)));
    if let (Some((first, _)), Some((second, span))) = (said.next(), said.next()) {
        let message = format!("`{}` says `{first}` and `{second}`", name.text());
        report.push(
            Diagnostic::new(Code::TwoPrograms, span, message)
                .label("a second program")
                .hint("keep the one that decides"),
        );
        return None;
    }
    match (block.command(), block.wasm(), block.fmu()) {
        (Some(said), ..) => command(said, report).map(ProgramFile::Command),
        (_, Some(said), _) => module(said, block, report).map(ProgramFile::Wasm),
        (.., Some(said)) => file(said.path(), "write `fmu \"aeb.fmu\"`", report).map(ProgramFile::Fmu),
        (None, None, None) => {
            if !block.has_bad() {
                let message = format!("`{}` says no `command`, `wasm` or `fmu`", name.text());
                report.push(
                    Diagnostic::new(Code::NoProgram, name.span(), message)
                        .label("has no program")
                        .hint("say what decides, word by word: `command \"python3\", \"my_av.py\"`"),
                );
            }
            None
        }
    }
}

/// The name of a file.
fn file(said: ast::Text, hint: &str, report: &mut Vec<Diagnostic>) -> Option<String> {
    let file = said.path();
    if file.trim().is_empty() || file.contains('\0') {
        report.push(unstartable(said.span(), "no file is named", hint));
        return None;
    }
    Some(file)
}

/// The file of a module, to which nothing may be said that is about processes.
fn module(said: ast::Wasm, block: ast::ControllerBlock, report: &mut Vec<Diagnostic>) -> Option<String> {
    let before = report.len();
    let of_processes = [
        ("folder", block.folder().map(|said| said.span())),
        ("environment", block.environment().map(|said| said.span())),
        ("starts within", block.starts_within().map(|said| said.span())),
        ("answers within", block.answers_within().map(|said| said.span())),
        ("delay measured", block.delay().filter(|said| said.is_measured()).map(|said| said.span())),
    ];
    for (words, span) in of_processes {
        if let Some(span) = span {
            let hint = "a module has no clock, no files and no environment: what it may do is counted in instructions";
            report.push(unstartable(
                span,
                format!("`{words}` is about processes, and a module is none"),
                hint,
            ));
        }
    }
    let file = file(said.path(), "write `wasm \"brakes.wasm\"`", report);
    file.filter(|_| report.len() == before)
}

fn command(said: ast::Command, report: &mut Vec<Diagnostic>) -> Option<Vec<String>> {
    let words: Vec<String> = said.words().map(ast::Text::word).collect();
    let hint = "write each word of the command in quotes of its own: `command \"python3\", \"my_av.py\"`";
    if words.first().is_none_or(|first| first.trim().is_empty()) {
        report.push(unstartable(said.span(), "the first word names no program", hint));
        return None;
    }
    if words.iter().any(|word| word.contains('\0')) {
        report.push(unstartable(said.span(), "a word of a command has no NUL in it", hint));
        return None;
    }
    Some(words)
}

fn environment(block: ast::ControllerBlock, report: &mut Vec<Diagnostic>) -> Option<Vec<(String, String)>> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    let before = report.len();
    for text in block.environment().into_iter().flat_map(ast::Environment::pairs) {
        let said = text.value();
        match said.split_once('=') {
            Some((name, _)) if pairs.iter().any(|(known, _)| known == name) => {
                report.push(unstartable(text.span(), format!("`{name}` is set twice"), "remove one of them"));
            }
            Some((name, value)) if !name.trim().is_empty() && !said.contains('\0') => {
                pairs.push((name.to_string(), value.to_string()));
            }
            _ => report.push(unstartable(
                text.span(),
                format!("`{said}` sets nothing"),
                "write `\"NAME=VALUE\"`",
            )),
        }
    }
    pairs.sort();
    (report.len() == before).then_some(pairs)
}

/// The named dynamics, if any are.
fn dynamics(
    block: ast::ControllerBlock,
    gives: Answer,
    registry: &Registry,
    report: &mut Vec<Diagnostic>,
) -> Option<Option<String>> {
    let Some(said) = block.dynamics() else { return Some(None) };
    let name = said.name();
    let Some(known) = registry.dynamics().get(name.text()) else {
        report.push(
            Diagnostic::new(
                Code::UnknownDynamics,
                name.span(),
                format!("there are no vehicle dynamics `{}`", name.text()),
            )
            .label("unknown dynamics")
            .suggest(name.text(), registry.dynamics().names()),
        );
        return None;
    };
    if known.takes.contains(&gives.command()) {
        return Some(Some(name.text().to_string()));
    }
    let fitting = registry.dynamics().iter().filter(|one| one.takes.contains(&gives.command()));
    let fitting: Vec<_> = fitting.map(|one| format!("`{}`", one.declaration.name)).collect();
    report.push(
        Diagnostic::new(
            Code::DoesNotFit,
            name.span(),
            format!(
                "dynamics `{}` do not take what a controller does that gives {}",
                name.text(),
                gives.word()
            ),
        )
        .label("do not fit the controller")
        .hint(format!("fitting are {}", fitting.join(", "))),
    );
    None
}

fn parameters(
    block: ast::ControllerBlock,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Parameter>> {
    let mut seen = HashSet::new();
    let mut all = Vec::new();
    let before = report.len();
    for node in block.parameters() {
        if !seen.insert(node.name().text()) {
            report.push(wrong(
                node.name().span(),
                format!("there are two parameters `{}`", node.name().text()),
                "remove one of them",
            ));
        } else {
            all.extend(parameter(node, scope, report));
        }
    }
    (report.len() == before).then_some(all)
}

fn wrong(span: Span, message: impl Into<String>, hint: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Code::WrongParameter, span, message).label("declared wrongly").hint(hint)
}

fn parameter(node: ast::OwnParameter, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Parameter> {
    let name = node.name().text().to_string();
    let about = node.doc().map(|doc| doc.value()).unwrap_or_default();
    let values = node.values();
    if let Some(list) = values.and_then(ast::OwnValues::list) {
        return choice(&name, about, node, list, report);
    }
    let default = value::evaluate(node.default(), scope, report)?;
    let what = format!("the default of `{name}`");
    let Expression::Constant(constant) = &default.expression else {
        return value::not_constant(default.span, &default.expression, &what, report);
    };
    match (constant, default.kind, values) {
        (Value::Number(number), ValueKind::Number(dimension), Some(values)) => {
            numeric(&name, about, (*number, dimension, &default), values, scope, report)
        }
        (Value::Number(_), _, None) => {
            report.push(wrong(
                node.default().span(),
                format!("the number `{name}` has no range"),
                format!(
                    "say between which bounds it lies: `parameter {name} = {} in LOW .. HIGH`",
                    node.default().text()
                ),
            ));
            None
        }
        (_, _, Some(values)) => {
            report.push(wrong(
                values.span(),
                format!("a range of `{name}`, which is {}", default.kind.name()),
                "numbers have ranges; words have options: `in [cautious, normal]`",
            ));
            None
        }
        (Value::Flag(flag), _, None) => Some(Parameter::flag(name, *flag, about, SOURCE)),
        (Value::Word(text), _, None) => {
            if text.len() > LONGEST_TEXT {
                report.push(wrong(
                    node.default().span(),
                    format!("the text has {} bytes, more than {LONGEST_TEXT}", text.len()),
                    "put it into a file and name that",
                ));
                return None;
            }
            Some(Parameter::text(name, text.clone(), short_enough, about, SOURCE))
        }
    }
}

fn short_enough(text: &str, _given: &dyn Fn(&str) -> bool) -> Vec<TextError> {
    let message = || format!("the text has {} bytes, more than {LONGEST_TEXT}", text.len());
    let error = || TextError {
        message: message(),
        hint: Some("put it into a file and name that".to_string()),
        part: String::new(),
    };
    if text.len() > LONGEST_TEXT { vec![error()] } else { Vec::new() }
}

fn numeric(
    name: &str,
    about: String,
    (default, dimension, typed): (f64, Dimension, &Typed),
    values: ast::OwnValues,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Parameter> {
    let what = format!("a bound of `{name}`");
    let everything = (f64::NEG_INFINITY, f64::INFINITY);
    let mut bounds = values
        .bounds()
        .map(|node| value::constant_in(node, dimension, everything, &what, scope, report))
        .collect::<Vec<_>>()
        .into_iter();
    let (low, high) = (bounds.next()??, bounds.next()??);
    if low > high {
        report.push(wrong(
            values.span(),
            format!("the range of `{name}` is empty"),
            "write the lower bound first",
        ));
        return None;
    }
    if !(low..=high).contains(&default) {
        let message = value::out_of_range(
            typed,
            &format!("the default of `{name}`"),
            default,
            (low, high),
            dimension,
            None,
        )
        .message;
        report.push(wrong(typed.span, message, "choose a default between the bounds"));
        return None;
    }
    if !values.is_whole() {
        return Some(Parameter::number(name.to_string(), dimension, default, (low, high), about, SOURCE));
    }
    // Beyond 2^53 not every whole number is a number of the language.
    let whole = |number: f64| {
        (number.fract() == 0.0 && number.abs() <= 9_007_199_254_740_992.0).then_some(number as i64)
    };
    match (dimension, whole(default), whole(low), whole(high)) {
        (Dimension::NUMBER, Some(default), Some(low), Some(high)) => {
            Some(Parameter::whole(name.to_string(), default, (low, high), about, SOURCE))
        }
        _ => {
            report.push(wrong(
                values.span(),
                format!("default and bounds of `{name}` are not whole numbers"),
                "leave `whole` out, or write numbers without unit and fraction",
            ));
            None
        }
    }
}

fn choice(
    name: &str,
    about: String,
    node: ast::OwnParameter,
    list: ast::List,
    report: &mut Vec<Diagnostic>,
) -> Option<Parameter> {
    let mut options: Vec<&str> = Vec::new();
    for option in list.values() {
        match option.lone_word().filter(|word| !RESERVED.contains(word) && !options.contains(word)) {
            Some(word) => options.push(word),
            None => {
                report.push(wrong(
                    option.span(),
                    format!("`{}` is no option of `{name}`", option.text()),
                    "options are words, each once; numbers have a range: `in 1 m .. 30 m`",
                ));
                return None;
            }
        }
    }
    let default = node.default();
    let Some(chosen) = default.lone_word().filter(|word| options.contains(word)) else {
        report.push(wrong(
            default.span(),
            format!("the default of `{name}` is none of its options"),
            format!("one of them is `{}`", options.first()?),
        ));
        return None;
    };
    let options: Vec<_> = options.iter().map(|word| ChoiceOption::new(word.to_string(), "")).collect();
    Some(Parameter::choice(name.to_string(), chosen.to_string(), options, about, SOURCE))
}
