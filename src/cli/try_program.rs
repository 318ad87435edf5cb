//! `scenario-runner try FILE [NAME]`: whether a program keeps to the protocol, for whoever writes one.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::Args;

use super::programs::{ProgramArguments, pool, say_all, warn};
use super::{Exit, load};
use files::Disk;
use files::escape::terminal_line;
use lang::{self, Style};
use report::console::{stderr, stdout};
use scenario::registry::Registry;
use scenario::{ControllerModel, DeclaredProgram, Parameter, ParameterKind, Reference};
use under_test::{
    Conformance, Conversation, Hello, ProcessPool, TriedTimes, again, conformance, read_conversations,
};

#[derive(Debug, Args)]
#[command(after_help = "\
It is shown ten scenes: with the defaults and at the ends of every parameter, alone and with others in one request, in one
process and in another. Whatever goes wrong or comes out differently is a finding (exit code 100). The
program has to be allowed as for a run. Wall time is shown and never judged.

Examples:
  scenario-runner try controllers/my_av.scn
  scenario-runner meet.scn later=2s --record-wire wire.jsonl    what is asked and said in one run
  scenario-runner try meet.scn --wire wire.jsonl                the same again, without the runner's part")]
pub struct TryArguments {
    /// A file that declares controllers (.scn, .yaml), or uses files that do.
    file: String,

    /// The controller [default: every one that the file declares].
    name: Option<String>,

    /// Ask again what is in this file of `--record-wire`, and show where the first answer differs.
    #[arg(long, value_name = "PATH")]
    wire: Option<PathBuf>,

    #[command(flatten)]
    programs: ProgramArguments,
}

/// A declared controller and its program.
type Declared = (Reference<ControllerModel>, Arc<DeclaredProgram>);

pub fn try_program(arguments: &TryArguments, registry: &Registry) -> Exit {
    tried(arguments, registry).unwrap_or_else(|exit| exit)
}

fn tried(arguments: &TryArguments, registry: &Registry) -> Result<Exit, Exit> {
    let known = declared(&arguments.file, arguments.name.as_deref(), registry)?;
    let permission = arguments.programs.permission()?;
    let forbidden = known.iter().filter_map(|(_, program)| permission.check(program).err());
    say_all(&forbidden.collect::<Vec<_>>())?;
    let pool = pool(permission, 1)?;
    match &arguments.wire {
        Some(path) => ask_again(path, &known, &pool),
        None => {
            let mut exit = Exit::Success;
            for (model, program) in &known {
                if !show(model, program, &pool)? {
                    exit = Exit::Failed;
                }
            }
            Ok(exit)
        }
    }
}

/// The controllers that the file declares, or the one of that name.
fn declared(file: &str, name: Option<&str>, registry: &Registry) -> Result<Vec<Declared>, Exit> {
    let wrong = |message: String| {
        writeln!(stderr(), "error: {message}");
        Exit::Usage
    };
    if !load::names_a_file(file) {
        return Err(wrong(format!("{file} is no scenario file")));
    }
    let found = lang::controllers(Path::new(file), registry, &Disk).map_err(|failure| {
        stderr().styled(&failure.render(Style { colour: stderr().takes_colour() }));
        Exit::Scenario
    })?;
    let program = |model: Reference<ControllerModel>| {
        let program = model.known()?.program.clone()?;
        Some((model, program))
    };
    let all: Vec<Declared> = found.into_iter().filter_map(program).collect();
    let names: Vec<&str> = all.iter().map(|(model, _)| model.name()).collect();
    let complaint = match name {
        None if all.is_empty() => format!("{file} declares no controller"),
        Some(name) if !names.contains(&name) => {
            format!("{file} declares no controller `{name}`, but {}", names.join(", "))
        }
        _ => {
            return Ok(all
                .into_iter()
                .filter(|(model, _)| name.is_none_or(|name| model.name() == name))
                .collect());
        }
    };
    Err(wrong(complaint))
}

/// Shows what came of trying a program; whether nothing is wrong.
fn show(
    model: &ControllerModelReference,
    program: &Arc<DeclaredProgram>,
    pool: &ProcessPool,
) -> Result<bool, Exit> {
    let declaration = &model.known().expect("it is declared").declaration;
    let tried = conformance(pool, program, declaration).map_err(|error| {
        let said = say_all(&[error]);
        said.err().unwrap_or(Exit::Scenario)
    })?;
    let Conformance { hello, findings, scenes, settings, alone, together, at_once } = &tried;
    writeln!(
        stdout(),
        "{} ({}:{}): {}",
        program.name,
        program.file,
        program.origin.line,
        terminal_line(&program.typed())
    );
    writeln!(stdout(), "  hello: {}", terminal_line(&introduction(hello)));
    for row in table(&declaration.parameters, hello) {
        writeln!(stdout(), "  {}", terminal_line(&row));
    }
    say_all(&hello.disagreements(program, declaration))?;
    hello.more(declaration).iter().for_each(|more| warn(program, more));
    let each = if *settings == 1 {
        "one setting".to_string()
    } else {
        format!("{settings} settings of its parameters")
    };
    writeln!(stdout(), "  shown: {scenes} scenes, {each}");
    writeln!(stdout(), "  alone: {}", times(alone));
    writeln!(stdout(), "  {at_once} at once, for each run: {}", times(together));
    if let Some(period) = program.period.filter(|period| alone.worst.as_secs_f64() > *period) {
        writeln!(
            stdout(),
            "  an answer took longer than its period of {period} s: in real time it would not keep up on this machine"
        );
    }
    if findings.is_empty() {
        writeln!(stdout(), "  nothing is wrong");
        return Ok(true);
    }
    const MOST: usize = 20;
    for finding in findings.iter().take(MOST) {
        writeln!(stdout(), "  wrong: {}", terminal_line(finding));
    }
    if findings.len() > MOST {
        writeln!(stdout(), "  and {} more", findings.len() - MOST);
    }
    writeln!(stdout(), "  what it wrote is in .scenario-runner/controllers");
    Ok(false)
}

type ControllerModelReference = Reference<ControllerModel>;

fn introduction(hello: &Hello) -> String {
    let title = hello.title();
    let title = if title.is_empty() { "no name" } else { &title };
    let modes =
        if hello.modes.is_empty() { String::new() } else { format!(", modes {}", hello.modes.join(", ")) };
    format!("{title}, {}, {} at once{modes}", hello.encoding.word(), hello.runs_at_once)
}

/// Parameters of file and program side by side.
fn table(declared: &[Parameter], hello: &Hello) -> Vec<String> {
    if declared.is_empty() {
        return Vec::new();
    }
    let mut rows = vec![["parameter".to_string(), "file".to_string(), "program".to_string()]];
    rows.extend(declared.iter().map(|one| {
        let said = hello.values_of(&one.name).unwrap_or_else(|| "does not say".to_string());
        [one.name.to_string(), values(one), said]
    }));
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    rows.iter().map(|[name, file, program]| format!("{name:first$}  {file:second$}  {program}")).collect()
}

fn values(parameter: &Parameter) -> String {
    match &parameter.kind {
        ParameterKind::Number { dimension, default, range: (low, high) } => {
            let default = default.map_or_else(String::new, |default| format!("{default} in "));
            format!("{default}{low} .. {high} {}", dimension.si_unit()).trim_end().to_string()
        }
        ParameterKind::Whole { default, range: (low, high) } => format!("{default} in whole {low} .. {high}"),
        ParameterKind::Flag { default } => default.to_string(),
        ParameterKind::Choice { default, options } => {
            let options: Vec<String> = options.iter().map(|one| one.name.to_string()).collect();
            format!("{default} in [{}]", options.join(", "))
        }
        ParameterKind::Text { default, .. } => format!("{:?}", default.to_string()),
        ParameterKind::Pedestrian => "a pedestrian".to_string(),
    }
}

fn times(times: &TriedTimes) -> String {
    let shown = |time: Duration| match time.as_secs_f64() {
        seconds if seconds >= 1.0 => format!("{seconds:.1} s"),
        seconds if seconds >= 1e-3 => format!("{:.1} ms", 1e3 * seconds),
        seconds => format!("{:.1} µs", 1e6 * seconds),
    };
    if times.decisions == 0 {
        return "no answer".to_string();
    }
    let [median, most, worst] = [times.median, times.most, times.worst].map(shown);
    format!(
        "{} decisions, {:.0} a second; an answer takes {median}, 99 % at most {most}, the slowest {worst}",
        times.decisions,
        times.per_second()
    )
}

/// Asks programs what they were asked in a run, and shows where they answer otherwise.
fn ask_again(path: &Path, known: &[Declared], pool: &ProcessPool) -> Result<Exit, Exit> {
    let conversations = read_conversations(path).map_err(|error| {
        writeln!(stderr(), "error: cannot read {}: {error}", path.display());
        Exit::Usage
    })?;
    let mut asked = 0;
    let mut differ = false;
    for (model, program) in known {
        let own: Vec<Conversation> =
            conversations.iter().filter(|one| one.controller == model.name()).cloned().collect();
        asked += own.len();
        let found =
            again(pool, program, &own).map_err(|error| say_all(&[error]).err().unwrap_or(Exit::Scenario))?;
        for one in &own {
            let name = terminal_line(&one.name);
            match found.iter().find(|difference| difference.name == one.name) {
                None => writeln!(stdout(), "{name}: {} decisions, the same again", one.turns.len()),
                Some(difference) => {
                    differ = true;
                    let at = difference
                        .time
                        .map_or_else(String::new, |time| format!(" at {} s", (time * 1e6).round() / 1e6));
                    writeln!(stdout(), "{name}: the first answer that differs{at}");
                    writeln!(stdout(), "  before: {}", terminal_line(&difference.before));
                    writeln!(stdout(), "  now:    {}", terminal_line(&difference.now));
                }
            }
        }
    }
    if asked == 0 {
        let names: Vec<&str> = known.iter().map(|(model, _)| model.name()).collect();
        writeln!(stderr(), "error: {} is of no run of {}", path.display(), names.join(", "));
        return Err(Exit::Usage);
    }
    Ok(if differ { Exit::Failed } else { Exit::Success })
}
