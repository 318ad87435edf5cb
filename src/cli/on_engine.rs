//! `exec --on ray|slurm`: the slices of a plan, done where an engine has machines.

use std::collections::BTreeMap;
use std::path::{Path, absolute};
use std::str::FromStr;
use std::time::{Duration, Instant};

use clap::Args;

use super::Exit;
use super::interrupt::stop_on_interrupt;
use super::planned::{PlannedProject, permission_digest, said};
use super::programs::{ProgramArguments, say_all};
use engines::{
    EndedTask, EngineError, EngineEvent, EngineName, EngineOptions, TaskEnd, run_slices, slice_output,
};
use files::escape::shell_word;
use report::console::{stderr, stdout};

/// In the folder of results.
const ENGINE_FOLDER: &str = "engine";
/// What a slice takes by default, s on one core.
const SLICE: f64 = 300.0;
/// What goes on is said that often.
const PACE: Duration = Duration::from_secs(5);
/// Python programs that have Ray, other than `python3`.
const PYTHON: &str = "SCENARIO_RUNNER_PYTHON";

#[derive(Debug, Clone, Args)]
pub struct EngineArguments {
    /// Have all shares made by a cluster, as docs/engines.md has it: `ray` or `slurm`.
    #[arg(long, value_name = "ENGINE", conflicts_with = "partition")]
    pub on: Option<EngineName>,

    /// How many shares `--on` makes of the plan [default: one for about five minutes on one core].
    #[arg(long, value_name = "N", requires = "on", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    slices: Option<u32>,

    /// Cores that a share takes [default: 1].
    #[arg(long, value_name = "N", requires = "on", value_parser = clap::value_parser!(u32).range(1..=1024))]
    cpus: Option<u32>,

    /// What else a share takes of a machine that Ray knows, such as `av_stack=1`; may be repeated.
    #[arg(long, value_name = "NAME=AMOUNT", requires = "on")]
    resource: Vec<Resource>,

    /// An option for Slurm's `sbatch`, such as `--slurm-option=--time=00:30:00`; may be repeated.
    #[arg(long, value_name = "OPTION", requires = "on", allow_hyphen_values = true)]
    slurm_option: Vec<String>,
}

/// `av_stack=1`.
#[derive(Debug, Clone)]
struct Resource(String, f64);

impl FromStr for Resource {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "write it as `av_stack=1`, with an amount above 0".to_string();
        let (name, amount) = text.split_once('=').ok_or_else(wrong)?;
        let amount: f64 = amount.parse().map_err(|_| wrong())?;
        let is_sound = !name.is_empty() && amount.is_finite() && amount > 0.0;
        if is_sound { Ok(Self(name.to_string(), amount)) } else { Err(wrong()) }
    }
}

/// The plan whose shares are made, and where their results go.
pub struct Shares<'a> {
    pub manifest: &'a Path,
    pub results: &'a Path,
    pub planned: &'a PlannedProject,
    pub permission: &'a ProgramArguments,
    /// Whether batches are left alone in which commands decide.
    pub reuse: bool,
    /// Whether a share helps no other one.
    pub own_share_only: bool,
}

impl EngineArguments {
    /// Has all shares made on `engine`.
    pub fn make(&self, engine: EngineName, shares: &Shares) -> Result<Exit, Exit> {
        let slices = self.command_lines(shares)?;
        let engine_folder = shares.results.join(ENGINE_FOLDER);
        let options = EngineOptions {
            cpus: self.cpus.unwrap_or(1),
            resources: self
                .resource
                .iter()
                .map(|Resource(name, amount)| (name.clone(), *amount))
                .collect::<BTreeMap<_, _>>(),
            slurm_options: self.slurm_option.clone(),
            python: std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into()),
            ..EngineOptions::new(&engine_folder)
        };
        let stop = stop_on_interrupt();
        let mut told = Told { all: slices.len(), ended: 0, last: None };
        let ended =
            run_slices(engine, slices, options, &|| stop.is_requested(), &mut |event| told.tell(&event));
        match ended {
            Ok(ended) => Ok(concluded(&ended, shares, &engine_folder)),
            Err(error) => {
                writeln!(stderr(), "error: {error}");
                Err(match error {
                    EngineError::Stopped => Exit::Interrupted,
                    EngineError::Missing(_) | EngineError::Refused(_) => Exit::Usage,
                    EngineError::File { .. } => Exit::Output,
                    _ => Exit::Failed,
                })
            }
        }
    }

    /// A command line a share, which goes to the folder first from which the manifest names files.
    fn command_lines(&self, shares: &Shares) -> Result<Vec<Vec<String>>, Exit> {
        let Shares { manifest, results, planned, permission, reuse, own_share_only } = shares;
        let complain = |error: std::io::Error| {
            writeln!(stderr(), "error: where this program and its files are: {error}");
            Exit::Usage
        };
        let program = std::env::current_exe().map_err(complain)?;
        let folder = std::env::current_dir().map_err(complain)?;
        let (manifest, results) =
            (absolute(manifest).map_err(complain)?, absolute(results).map_err(complain)?);
        let mut text = Vec::new();
        for path in [&folder, &program, &manifest, &results] {
            text.push(path.to_str().map(str::to_string).ok_or_else(|| {
                writeln!(stderr(), "error: {} is no path in UTF-8, which engines need", path.display());
                Exit::Usage
            })?);
        }
        let [folder, program, manifest, results] = text.try_into().expect("there are four");
        let batches = planned.manifest.batches().map_err(|error| said(&error))?.count();
        let wanted = self.slices.map_or((planned.manifest.header().seconds / SLICE).ceil(), f64::from);
        let slices = (wanted as usize).clamp(1, batches.max(1));
        // One whose share is made does not keep others from its cores: they have begun when the last has.
        let last = slice_output(&Path::new(&results).join(ENGINE_FOLDER), slices);
        let mut rest = vec!["--results".to_string(), results];
        match own_share_only {
            true => rest.push("--own-share-only".to_string()),
            false => rest.extend(["--join-once".to_string(), last.to_string_lossy().into_owned()]),
        }
        rest.extend(["--test-threads".to_string(), self.cpus.unwrap_or(1).to_string()]);
        rest.extend(reuse.then(|| "--reuse".to_string()));
        if !planned.programs.is_empty() {
            let permission = permission.permission()?;
            let own = planned.programs.iter().filter_map(|(program, _)| permission.check(program).err());
            say_all(&own.collect::<Vec<_>>())?;
            // What is allowed here is allowed there as what it was here.
            rest.push("--allow-run-digest".to_string());
            rest.push(permission_digest(&planned.manifest.header().programs));
        }
        let line = |slice: usize| {
            let begin = [
                "/bin/sh",
                "-c",
                "cd \"$1\" && shift && exec \"$@\"",
                "sh",
                &folder,
                &program,
                "exec",
                &manifest,
            ];
            let share = ["--partition".to_string(), format!("slice:{slice}/{slices}")];
            begin.into_iter().map(str::to_string).chain(share).chain(rest.iter().cloned()).collect()
        };
        Ok((1..=slices).map(line).collect())
    }
}

/// What is said while shares are made.
struct Told {
    all: usize,
    ended: usize,
    last: Option<Instant>,
}

impl Told {
    fn tell(&mut self, event: &EngineEvent) {
        match event {
            EngineEvent::Ready(_) | EngineEvent::Notice(_) => writeln!(stderr(), "{event}"),
            EngineEvent::Ended(ended) => {
                self.ended += 1;
                if ended.end != TaskEnd::Exited(0) {
                    writeln!(stderr(), "{event}");
                }
            }
            EngineEvent::Standing { waiting, running } => {
                if self.last.is_none_or(|last| last.elapsed() >= PACE) {
                    self.last = Some(Instant::now());
                    let Self { all, ended, .. } = self;
                    writeln!(
                        stderr(),
                        "{ended} of {all} shares are over, {running} are being made, {waiting} wait"
                    );
                }
            }
        }
    }
}

/// What came of all.
fn concluded(ended: &[EndedTask], shares: &Shares, engine_folder: &Path) -> Exit {
    let failed: Vec<&EndedTask> = ended.iter().filter(|one| one.end != TaskEnd::Exited(0)).collect();
    if failed.is_empty() {
        let word = |path: &Path| shell_word(&path.to_string_lossy());
        writeln!(stdout(), "{}: all {} shares are made", shares.results.display(), ended.len());
        writeln!(
            stdout(),
            "  scenario-runner merge {} --results {}",
            word(shares.manifest),
            word(shares.results)
        );
        return Exit::Success;
    }
    for one in &failed {
        let how = match &one.end {
            TaskEnd::Exited(code) => format!("ended with exit code {code}"),
            TaskEnd::Lost(why) => format!("is given up: {why}"),
        };
        let out = engine_folder.join(format!("{}.out", one.id));
        writeln!(stderr(), "error: {} {how}; what it said is in {}", one.id, out.display());
    }
    writeln!(stderr(), "help: the same command makes what is missing; what is there is not made again");
    Exit::Failed
}
