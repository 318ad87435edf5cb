//! `scenario-runner compare BASE CANDIDATE`: is the candidate worse, beyond what is tolerated and beyond doubt?

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::interrupt::stop_on_interrupt;
use super::programs::{ProgramArguments, VerifyArguments};
use super::set::SetArguments;
use super::{Exit, measured, parameters};
use files::escape::{shell_path, shell_word};
use report::console::{stderr, stdout};
use report::{gate_markdown, render_gate};
use results::judge::baseline::{Baseline, Incompatible, pair};
use results::judge::gate::{blanket_rule, collision_rule, judge_paired};
use results::{CheckOutcome, GateVerdict, Verdict, record_command, set_options};
use runner::baseline::measured_metrics;
use runner::run::Stop;
use scenario::registry::Registry;
use scenario::{Gate, Suite};

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  scenario-runner compare zebra.json zebra.suite                  what was, and what is now
  scenario-runner compare old.suite new.suite --tolerance 2       two suites, no file needed
  scenario-runner compare zebra.suite --parameters new.scn        other parameters, one suite
  scenario-runner compare zebra.json zebra.suite --format markdown

Exit codes: 0 nothing is worse, 104 something is, 102 too few runs to say, 103 not comparable.")]
pub struct CompareArguments {
    /// What was: a baseline, or a suite to run. With --parameters, the suite to run with them.
    base: String,

    /// What is now: a baseline, or a suite to run.
    #[arg(required_unless_present = "parameters", conflicts_with = "parameters")]
    candidate: Option<String>,

    /// Run the suite with these parameters of its vehicles: definitions (`let braking_distance = 4.75 m`) or JSON, as
    /// `tune NAME FILE --save` writes them. Given twice: the first is what was, the second what is now. Given once: what
    /// was is what the suite declares.
    #[arg(long, value_name = "PATH")]
    parameters: Vec<PathBuf>,

    /// Compare by the rules of this gate of the suite [default: all its gates; without any, by --tolerance].
    #[arg(long, value_name = "NAME", conflicts_with_all = ["tolerance", "confidence"])]
    gate: Option<String>,

    /// How much worse any metric may be, in percent of its mean; of metrics that are true or false, in points.
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    tolerance: Option<f64>,

    /// How sure to be, in percent above 50 [default: 95].
    #[arg(long, value_name = "PERCENT", value_parser = confidence)]
    confidence: Option<f64>,

    /// Replaces the seed of every suite that is run.
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,

    #[command(flatten)]
    set: SetArguments,

    #[command(flatten)]
    programs: ProgramArguments,

    #[command(flatten)]
    verify: VerifyArguments,

    /// Leave out trials that the base lacks, instead of refusing to compare.
    #[arg(long)]
    baseline_lenient: bool,

    /// Count what is not shown either way as inconclusive (exit code 102).
    #[arg(long)]
    strict: bool,

    /// Show the comparisons that held or are the same, too.
    #[arg(long)]
    all: bool,

    #[arg(long, value_enum, default_value_t = Format::Terminal)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Terminal,
    /// For a pull request.
    Markdown,
    Json,
}

const DEFAULT_TOLERANCE: f64 = 0.05;
const DEFAULT_CONFIDENCE: f64 = 0.95;

fn percent(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('%').trim_end();
    match number.parse::<f64>() {
        Ok(percent) if (0.0..100.0).contains(&percent) => Ok(percent / 100.0),
        _ => Err("a number of percent from 0 to below 100, such as `5`".to_string()),
    }
}

/// A confidence in percent, as a share.
fn confidence(text: &str) -> Result<f64, String> {
    percent(text)
        .ok()
        .filter(|share| *share > 0.5)
        .ok_or_else(|| "a number of percent above 50 and below 100, such as `95`".to_string())
}

pub fn compare(arguments: &CompareArguments, registry: &Registry) -> Exit {
    let stop = stop_on_interrupt();
    match judged(arguments, registry, &stop) {
        Err(Exit::Interrupted) => interrupted(),
        Ok(_) if stop.is_requested() => interrupted(),
        Ok(verdicts) => {
            print(arguments, &verdicts);
            exit(&verdicts, arguments.strict)
        }
        Err(exit) => exit,
    }
}

fn interrupted() -> Exit {
    writeln!(stderr(), "interrupted: nothing was compared");
    Exit::Interrupted
}

/// One side of the comparison.
struct Side {
    /// What the user calls it.
    file: String,
    /// `None` for a baseline.
    suite: Option<Suite>,
    /// Whether its runs can be replayed from its file.
    as_declared: bool,
}

impl Side {
    fn open(file: &str, arguments: &CompareArguments, registry: &Registry) -> Result<Self, Exit> {
        let suite = || measured::load_suite(file, arguments.seed, &arguments.set, registry);
        let suite = if measured::is_baseline(file) { None } else { Some(suite()?) };
        Ok(Self { file: file.to_string(), suite, as_declared: true })
    }

    /// The suite with the parameters of a file over its own.
    fn with_parameters(
        file: &str,
        path: &Path,
        arguments: &CompareArguments,
        registry: &Registry,
    ) -> Result<Self, Exit> {
        let mut suite = measured::load_suite(file, arguments.seed, &arguments.set, registry)?;
        parameters::put_over(&mut suite, file, path, registry)?;
        Ok(Self { file: format!("{file} with {}", path.display()), suite: Some(suite), as_declared: false })
    }

    fn baseline(
        &self,
        gates: &[Gate],
        title: &str,
        registry: &Registry,
        stop: &Stop,
        arguments: &CompareArguments,
    ) -> Result<Baseline, Exit> {
        let Some(suite) = &self.suite else {
            return measured::read_baseline(Path::new(&self.file), registry);
        };
        let mut requests = measured_metrics(suite, registry);
        gates.iter().for_each(|gate| measured::include_gate(&mut requests, gate));
        measured::run_suite(suite, &requests, title, stop, &arguments.programs, arguments.verify)
    }
}

fn judged(
    arguments: &CompareArguments,
    registry: &Registry,
    stop: &Stop,
) -> Result<Vec<(GateVerdict, Option<String>)>, Exit> {
    let (base, candidate) = sides(arguments, registry)?;
    let gates = gates(arguments, &base, &candidate)?;
    let before = base.baseline(&gates, "base", registry, stop, arguments)?;
    let after = candidate.baseline(&gates, "candidate", registry, stop, arguments)?;
    let refuse = |reasons: Vec<Incompatible>| {
        writeln!(stderr(), "error: {} and {} cannot be compared", base.file, candidate.file);
        for reason in &reasons {
            writeln!(stderr(), "  {}", reason);
        }
        if base.suite.is_none()
            && let Some(suite) = &candidate.suite
            && suite.name == before.suite
        {
            let command = record_command(&candidate.file, &suite.set, Path::new(&base.file));
            writeln!(
                stderr(),
                "help: record it with `{command}`, from the version that it is to be compared with"
            );
        }
        if reasons.iter().all(|reason| matches!(reason, Incompatible::New(_))) {
            writeln!(stderr(), "help: `--baseline-lenient` leaves new trials out");
        }
        Exit::Baseline
    };
    let pairing = pair(&before, &after, arguments.baseline_lenient).map_err(refuse)?;
    let mut verdicts = Vec::new();
    for gate in &gates {
        let sides = [&candidate, &base].into_iter().filter_map(|side| side.suite.as_ref());
        let verdict = judge_paired(gate, &pairing).map_err(refuse)?;
        let replays = candidate.suite.is_some() && candidate.as_declared;
        let file = || shell_path(&candidate.file);
        let again = || format!("{} --seed {}{}", file(), after.seed, set_options(&after.set));
        let verdict = sides.into_iter().fold(verdict, |verdict, suite| verdict.written_as(suite));
        verdicts.push((verdict, replays.then(again)));
    }
    Ok(verdicts)
}

fn sides(arguments: &CompareArguments, registry: &Registry) -> Result<(Side, Side), Exit> {
    let file = &arguments.base;
    let with = |path: &PathBuf| Side::with_parameters(file, path, arguments, registry);
    if !arguments.parameters.is_empty() && measured::is_baseline(file) {
        writeln!(stderr(), "error: {file} is no suite that could be run with other parameters");
        return Err(Exit::Usage);
    }
    let is_run = |file: &String| !measured::is_baseline(file);
    if !arguments.set.is_empty() && !is_run(file) && !arguments.candidate.as_ref().is_some_and(is_run) {
        writeln!(stderr(), "error: neither side is run, so there is nothing that could be set");
        return Err(Exit::Usage);
    }
    match (&arguments.candidate, &arguments.parameters[..]) {
        (Some(candidate), _) => {
            Ok((Side::open(file, arguments, registry)?, Side::open(candidate, arguments, registry)?))
        }
        (None, [only]) => Ok((Side::open(file, arguments, registry)?, with(only)?)),
        (None, [was, now]) => Ok((with(was)?, with(now)?)),
        (None, _) => {
            writeln!(stderr(), "error: --parameters may be given once or twice");
            Err(Exit::Usage)
        }
    }
}

/// The rules to judge by: a suite's gates, or one for every metric.
fn gates(arguments: &CompareArguments, base: &Side, candidate: &Side) -> Result<Vec<Gate>, Exit> {
    let declared = [candidate, base]
        .into_iter()
        .filter_map(|side| side.suite.as_ref())
        .find(|suite| !suite.gates.is_empty());
    let declared = declared.map_or(&[][..], |suite| &suite.gates);
    if let Some(name) = &arguments.gate {
        let found: Vec<Gate> = declared.iter().filter(|gate| gate.name == *name).cloned().collect();
        if found.is_empty() {
            let known: Vec<_> = declared.iter().map(|gate| format!("`{}`", gate.name)).collect();
            writeln!(stderr(), "error: neither side is a suite with a gate called `{name}`");
            if !known.is_empty() {
                writeln!(stderr(), "help: there is {}", known.join(", "));
            }
            return Err(Exit::Usage);
        }
        return Ok(found);
    }
    if !declared.is_empty() && arguments.tolerance.is_none() && arguments.confidence.is_none() {
        return Ok(declared.to_vec());
    }
    let confidence = arguments.confidence.unwrap_or(DEFAULT_CONFIDENCE);
    let rule = blanket_rule(arguments.tolerance.unwrap_or(DEFAULT_TOLERANCE), confidence);
    Ok(vec![Gate {
        name: rule.text.clone(),
        doc: None,
        baseline: String::new(),
        sequential: false,
        // What is true or false needs a rule of its own.
        rules: vec![rule, collision_rule(confidence)],
        origin: Default::default(),
    }])
}

fn print(arguments: &CompareArguments, verdicts: &[(GateVerdict, Option<String>)]) {
    if arguments.format == Format::Json {
        let all: Vec<_> = verdicts.iter().map(|(verdict, _)| verdict).collect();
        stdout().verbatim(&(serde_json::to_string_pretty(&all).expect("plain data serialises") + "\n"));
        return;
    }
    let colour = stdout().takes_colour();
    for (index, (verdict, file)) in verdicts.iter().enumerate() {
        if index > 0 {
            writeln!(stdout());
        }
        let replay = |key: &str| {
            let again = |file: &String| format!("scenario-runner replay {} {file}", shell_word(key));
            file.as_ref().map(again)
        };
        match arguments.format {
            Format::Markdown => write!(stdout(), "{}", gate_markdown(verdict, &replay)),
            _ => stdout().styled(&render_gate(verdict, &replay, arguments.all, colour)),
        }
    }
}

fn exit(verdicts: &[(GateVerdict, Option<String>)], strict: bool) -> Exit {
    let worst = verdicts.iter().map(|(verdict, _)| verdict.verdict).max().unwrap_or(Verdict::Passed);
    let open = verdicts.iter().any(|(verdict, _)| verdict.count(CheckOutcome::NotShown) > 0);
    match worst {
        Verdict::Failed => Exit::Regressed,
        Verdict::Inconclusive => Exit::Inconclusive,
        Verdict::Passed if strict && open => Exit::Inconclusive,
        Verdict::Passed => Exit::Success,
    }
}
