//! `--allow-run`: threads that make runs, and ask the programs in which users' own controllers are.

use std::env;
use std::path::Path;
use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::run::parent::ServedByParent;
use super::{Exit, store};
use lang::{Code, Excerpt};
use report::console::stderr;
use runner::run::{Threads, VerifyRuns};
use scenario::{ControllerModel, DeclaredProgram, ProgramKind, Reference, Suite};
use under_test::{Allowed, KnowsMore, Permission, ProcessPool, StartError, StartProblem, WireRecord};

#[derive(Debug, Clone, Default, Args)]
pub struct ProgramArguments {
    /// Let the programs of controllers that files declare run this once: those of these names, or all. `scenario-runner
    /// allow FILE` lets them run until what runs is changed. Whatever they do is then allowed.
    #[arg(long, value_name = "NAME,…", num_args = 0..=1, require_equals = true, value_delimiter = ',', default_missing_value = "")]
    allow_run: Option<Vec<String>>,
}

#[derive(Debug, Clone, Copy, Args)]
pub struct VerifyArguments {
    /// Which runs in which programs decide are made a second time, alone in another process, to see whether they come out the same. They
    /// count nowhere.
    #[arg(long, value_enum, value_name = "WHICH", default_value_t = Verified::Some)]
    verify_runs: Verified,
}

impl VerifyArguments {
    /// What [`Self::word`] said.
    pub fn of_word(word: &str) -> Option<Self> {
        Verified::from_str(word, false).ok().map(|verify_runs| Self { verify_runs })
    }

    /// As on the command line.
    pub fn word(self) -> String {
        self.verify_runs.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string())
    }

    pub fn runs(self) -> VerifyRuns {
        self.verify_runs.into()
    }
}

/// Which runs are made twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Verified {
    /// None.
    None,
    /// The first of each scenario, every 200th, and those that failed before.
    Some,
    /// Every one.
    All,
}

impl From<Verified> for VerifyRuns {
    fn from(verified: Verified) -> Self {
        match verified {
            Verified::None => Self::None,
            Verified::Some => Self::Some,
            Verified::All => Self::All,
        }
    }
}

impl ProgramArguments {
    /// As if everything were allowed this once.
    pub fn everything() -> Self {
        Self { allow_run: Some(Vec::new()) }
    }

    /// What the user allows, here, in the environment, or once and for all.
    pub fn permission(&self) -> Result<Permission, Exit> {
        let allowed = Allowed::place().and_then(Allowed::read).map_err(|error| {
            writeln!(stderr(), "error: {error}");
            Exit::Usage
        })?;
        let permission = Permission::default().of_environment().listed(&allowed);
        Ok(match self.allow_run.as_deref() {
            None => permission,
            Some(names) if names.iter().all(String::is_empty) => permission.all(),
            Some(names) => permission.named(names.iter().map(|name| name.trim().to_string())),
        })
    }

    /// So many threads (one for each core if nothing is said) to make runs of these suites. The programs that decide in them
    /// are started; if one may not or does not, nothing is run, and stderr is told.
    pub fn threads<'s>(
        &self,
        threads: Option<usize>,
        suites: impl IntoIterator<Item = &'s Suite>,
    ) -> Result<Threads, Exit> {
        self.threads_with(threads, suites, None, None).map(|(threads, _)| threads)
    }

    /// As [`Self::threads`], which write down what is said in one run, and in which whoever started this program decides for a controller;
    /// with the processes, which have the record.
    pub fn threads_with<'s>(
        &self,
        threads: Option<usize>,
        suites: impl IntoIterator<Item = &'s Suite>,
        record: Option<WireRecord>,
        served: Option<ServedByParent>,
    ) -> Result<(Threads, Option<Arc<ProcessPool>>), Exit> {
        let made = threads.map_or_else(Threads::all, Threads::new);
        let mut models: Vec<&Reference<ControllerModel>> = Vec::new();
        for model in suites.into_iter().flat_map(of_suite) {
            // Files of several suites may call different programs the same.
            let program =
                |one: &Reference<ControllerModel>| one.known().and_then(|known| known.program.clone());
            if !models.iter().any(|known| program(known) == program(model)) {
                models.push(model);
            }
        }
        if models.is_empty() && served.is_none() {
            return Ok((made, None));
        }
        let permission = self.permission()?;
        let programs: Vec<(&ControllerModel, &Arc<DeclaredProgram>)> = models
            .iter()
            .filter_map(|model| Some((model.known()?, model.known()?.program.as_ref()?)))
            .collect();
        let served_name = served.as_ref().map(|served| served.controller.clone());
        if let Some(name) = &served_name {
            let own =
                programs.iter().filter(|(_, program)| program.name == *name).map(|(_, program)| &***program);
            is_served(name, &own.collect::<Vec<_>>())?;
        }
        let needs_permission = |program: &DeclaredProgram| served_name.as_ref() != Some(&program.name);
        let forbidden = programs
            .iter()
            .filter(|(_, program)| needs_permission(program))
            .filter_map(|(_, program)| permission.check(program).err());
        say_all(&forbidden.collect::<Vec<_>>())?;
        let pool = pool(permission, runner::run::Executor::parallelism(&made))?;
        let pool = record.into_iter().fold(pool, ProcessPool::recording);
        let pool = match served {
            Some(served) => pool.served_by_parent(served.controller.clone(), served.parent()?),
            None => pool,
        };
        let mut wrong = Vec::new();
        for (model, program) in programs {
            match pool.prepare(program) {
                Ok(prepared) => {
                    wrong.extend(prepared.hello.disagreements(program, &model.declaration));
                    prepared.hello.more(&model.declaration).iter().for_each(|more| warn(program, more));
                }
                Err(error) => wrong.push(error),
            }
        }
        say_all(&wrong)?;
        let pool = Arc::new(pool);
        Ok((made.with_processes(pool.clone()), Some(pool)))
    }
}

/// Whether a parent can decide for the programs of that name: there is one of them, and it is a process. If not, says so on stderr.
fn is_served(name: &str, own: &[&DeclaredProgram]) -> Result<(), Exit> {
    let message = match own {
        [only] if matches!(only.kind, ProgramKind::Command(_)) => return Ok(()),
        [_] => format!("`{name}` is no `command`, and nobody decides in its place"),
        [] => format!("no vehicle is driven by a declared controller `{name}`"),
        [first, second, ..] => {
            format!("there are two controllers `{name}`, of {} and of {}", first.file, second.file)
        }
    };
    writeln!(stderr(), "error: `--serve-by-parent {name}`: {message}");
    writeln!(stderr(), "help: `--controller VEHICLE={name} --use FILE` has it drive");
    Err(Exit::Usage)
}

/// A pool of this program, with the logs of other programs where it keeps what nobody commits.
pub fn pool(permission: Permission, threads: usize) -> Result<ProcessPool, Exit> {
    let logs = Path::new(store::FOLDER).join("controllers");
    store::prepare(&logs)?;
    let pool = ProcessPool::new(permission, threads);
    let pool = if files::make_folder(&logs).is_ok() { pool.logs(logs) } else { pool };
    Ok(match env::current_exe() {
        Ok(own) if cfg!(unix) => pool.fmu_host(&own).supervised_by(own),
        Ok(own) => pool.fmu_host(own),
        _ => pool,
    })
}

/// The controllers of a suite in whose place a program decides.
fn of_suite(suite: &Suite) -> impl Iterator<Item = &Reference<ControllerModel>> {
    let scenarios = suite.scenarios.iter().chain(&suite.supporting);
    let named = scenarios.flat_map(|scenario| &scenario.vehicles).flat_map(|car| car.controller.all());
    named.filter(|model| model.known().is_some_and(|known| known.program.is_some()))
}

/// The programs that decide in a suite.
pub fn declared(suite: &Suite) -> impl Iterator<Item = &DeclaredProgram> {
    of_suite(suite).filter_map(|model| model.known()?.program.as_deref())
}

/// Says what is wrong, if anything is.
pub fn say_all(errors: &[StartError]) -> Result<(), Exit> {
    for error in errors {
        let code = match error.problem {
            StartProblem::NotAllowed => Code::NotAllowed,
            StartProblem::CannotStart => Code::CannotStart,
            StartProblem::NoHello => Code::NoHello,
            StartProblem::Disagreement => Code::Disagreement,
            StartProblem::NotWired => Code::NotWired,
        };
        let title = format!("{code}: {}", error.message);
        let excerpt = Excerpt {
            title: &title,
            origin: &error.origin,
            label: "",
            notes: &error.notes,
            help: Some(&error.hint),
        };
        stderr().styled(&format!("{}\n\n", excerpt.render(stderr().takes_colour())));
    }
    if errors.is_empty() { Ok(()) } else { Err(Exit::Scenario) }
}

pub fn warn(program: &DeclaredProgram, more: &KnowsMore) {
    let code = Code::KnowsMore;
    let values = if more.values.is_empty() { String::new() } else { format!(" ({})", more.values) };
    writeln!(
        stderr(),
        "warning: {code}: the program of `{}` also has `{}`{values}; declare it in {} to set or vary it",
        program.name,
        more.name,
        program.file
    );
}
