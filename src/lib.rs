//! Testing automated-vehicle controllers against pedestrians who behave like people.
//!
//! A [`Project`] is what files say, a [`Session`] runs it, [`Results`] are what came of it, and every function of [`report`] makes
//! something of them to be read.
//!
//! ```
//! use scenario_runner::results::{Overall, Unheard};
//! use scenario_runner::{Memory, Project, Selection, Session, models, report};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = r#"
//! scenario steps_out {
//!   road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
//!   vehicle av { controller carla_behavior; speed 40 km/h; start 60 m before crossing }
//!   pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
//!   expect { no collision }
//! }
//! "#;
//! // Texts come from memory here; `Disk` has files.
//! let files = Memory::default().with("steps_out.scn", text);
//! let project = Project::open("steps_out.scn", &models::standard(), &files)?;
//! let results = Session::new(&project).run(&Selection::all(), &mut Unheard)?;
//! assert_eq!(results.overall(), Overall::Passed);
//!
//! let mut tap = Vec::new();
//! report::write_tap(&results, &mut tap)?;
//! assert!(String::from_utf8(tap)?.contains("ok 1 - steps_out/steps_out"));
//! # Ok(())
//! # }
//! ```
//!
//! A green result says that every run was made that was to be made, and that every criterion that applies is fulfilled. A file that
//! is wrong gives [`Problems`](project::Problems) with the place of each; a run that cannot be made is an *error* of its trial and
//! never passed; what was not run has not passed either, and where nothing was selected there is a [`SessionError`].
//!
//! # Where to go on
//!
//! | to | |
//! |---|---|
//! | test a controller of one's own | [a model of one's own](#a-model-of-ones-own), [`sim::Controller`] |
//! | know what scenarios may name | [`models::standard`], [`registry::Registry`] |
//! | choose what runs | [`Selection`] |
//! | set values that files do not say | [`ProjectOptions`] |
//! | look into results | [`results`]: trials with their outcomes, findings, blocks, gates |
//! | write JUnit, HTML, JSON, CSV, TAP or Markdown | [`report`] |
//! | follow a session while it runs | [`results::Reporter`], [`report::Terminal`] |
//! | make runs elsewhere than on this machine's cores | [`run::Executor`] |
//! | stop a session | [`run::Stop`] |
//! | format files, convert them to YAML and back, serve an editor | [`language`] |
//! | record a baseline, or failures to be run first | [`baseline`], [`corpus`] |
//! | make a failing case simpler | [`mod@shrink`] |
//! | let programs of one's own decide | [`programs`] |
//! | run suites as tests of `cargo test` | [`testing`] |
//! | extend the program with models of one's own | [`cli::main`] |
//!
//! # A model of one's own
//!
//! What files may name is a value, a [`Registry`](registry::Registry). [`models::standard`] has all that ships, and a controller,
//! pedestrian, perception or metric of one's own is added to it: what it declares is all that checker, completion, tunes and
//! reports need to know of it.
//!
//! ```
//! use scenario_runner::models::standard;
//! use scenario_runner::registry::{Registry, RegistryError};
//! use scenario_runner::scenario::{Chance, CommandKind, ControllerModel, Declaration, Dimension};
//! use scenario_runner::sim::{Command, Controller, ControllerError, Observation, Schedule};
//!
//! /// Brakes as soon as anybody is seen.
//! struct Timid {
//!     deceleration: f64,
//! }
//!
//! impl Controller for Timid {
//!     fn schedule(&self) -> Schedule {
//!         Schedule::every(0.05)
//!     }
//!
//!     fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
//!         let wanted = if seen.pedestrians.is_empty() { seen.cruise_speed - seen.ego.speed } else { -self.deceleration };
//!         Ok(Command::Acceleration(wanted.clamp(-self.deceleration, self.deceleration)))
//!     }
//! }
//!
//! fn registry() -> Result<Registry, RegistryError> {
//!     let declaration = Declaration::new("timid", "Brakes as soon as anybody is seen.")
//!         .source("the documentation of scenario-runner")
//!         .number("deceleration", Dimension::ACCELERATION, 3.0, (0.5, 9.0), "How hard it brakes.");
//!     let timid = ControllerModel::new(declaration, CommandKind::Acceleration, |context| {
//!         Ok(Box::new(Timid { deceleration: context.settings.number("deceleration") }))
//!     });
//!     standard().with_controller(timid.chance(Chance::Never))
//! }
//!
//! assert!(registry()?.controllers().get("timid").is_some());
//! # Ok::<(), RegistryError>(())
//! ```
//!
//! `examples/own_controller.rs`, `own_pedestrian.rs` and `own_metric.rs` run and tune such entries. A program that is the command
//! line with them is `fn main() -> ExitCode { scenario_runner::cli::main(&registry) }`.
//!
//! # What can be relied on
//!
//! A run is a pure function of its [`Case`](scenario::Case): whichever [`Executor`](run::Executor) makes it, on however many
//! threads, every bit is the same. All data are in SI units and the world's frame, unless a field says otherwise; units exist in
//! files and reports alone. What a metric is undefined for is `None`, never a number. Errors are enums that may grow; data are plain
//! structs that may be taken apart.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod cli;
pub mod testing;

pub use files::{Disk, Files, Memory, ReadError};
pub use models;
pub use report;
pub use results;
pub use results::Results;
pub use runner::project::{Project, ProjectOptions};
pub use runner::session::{Selection, Session, SessionError};
pub use scenario;
pub use scenario::registry;
pub use sim;

/// What [`Project`] speaks of: what is to be said of its files, and what is planned of them.
pub mod project {
    pub use lang::{
        Code, Diagnostic, Failure, Label, Location, Override, Replacement, Severity, Source, SourceId,
        Sources, Span, Style,
    };
    pub use runner::plan::{
        Cases, DrawAxis, Plan, PlanError, PlannedTrial, ScenarioPlan, plan, plan_scenario, standalone,
    };
    pub use runner::project::{
        Notice, NoticeLevel, PlannedSuite, Problems, examine, examine_edited, key_prefixes, plan_notices,
    };
}

/// What [`Session`] speaks of: its units, and whoever watches their runs.
pub mod session {
    pub use runner::session::{
        OnDemand, RunWatch, Unit, UnitKind, Units, Work, gate_key, nondeterministic, second_runs,
        tested_controllers, units, with_needs,
    };
}

/// Where runs are made: an [`Executor`](run::Executor) takes jobs and gives back what came of each. [`Threads`](run::Threads) is the
/// one that ships.
pub mod run {
    pub use runner::run::{
        AbsentRuns, BatchError, DecodingError, Done, EncodedBy, Executor, FirstRuns, FreeFlows, FromResults,
        Job, JobFailure, JobPlace, MeasuredMetrics, Panicked, Ran, Round, RunBatch, RunDigest, RunDigests,
        RunError, RunResults, Sharing, Stop, StoredRun, Threads, VerifyRuns, Wanted, WentDifferently,
        note_places, programs, went_differently,
    };
}

/// Runs on many machines: a manifest of units, files of results, and the executor that answers from them.
pub mod shards {
    pub use runner::shards::{
        BatchProgress, Batches, Build, Executed, Execution, ManifestHeader, ManifestReader, ManifestUnit,
        PlannedProgram, PlannedUnit, Planner, ResultFiles, ShardError, UnitBatch, WrittenManifest, canary,
        chosen, write_manifest,
    };
}

/// Ray and Slurm, which have commands done on other machines.
pub mod engines {
    pub use engines::{
        EndedTask, Engine, EngineError, EngineEvent, EngineName, EngineOptions, RAY_VERSION, Ray, Slurm,
        Task, TaskEnd, run_slices, slice_output,
    };
}

/// The texts of files by themselves: to be checked, formatted, written in the other notation, and what editors ask about them.
pub mod language {
    pub use lang::filter;
    pub use lang::{
        Completion, Examined, Excerpt, Loaded, NamedValue, Outside, Runnable, SymbolKind, TokenColour, Tree,
        UNITS, UnitEntry, complete, controllers, count, definition, examine_edited, format, from_yaml, hover,
        load, named_values, nearest, render, render_all, runnables, suite_doc, to_yaml, with_controllers,
        with_declared, write_comparison, write_scenario,
    };
}

/// What gates compare with: baselines of trials, recorded once and read from then on by [`results::judge::baseline`].
pub mod baseline {
    pub use runner::baseline::{NotKept, against_baseline, measured_metrics, program_titles, record};
}

/// Cases that failed, kept in a file and run first from then on.
pub mod corpus {
    pub use runner::corpus::{
        CorpusError, Stale, case_hash, corpus_path, criteria, is_unchecked, read_corpus, record, revive,
        write_corpus,
    };
}

/// What blocks of a file need of each other, and the cases and parameters that they leave in files.
pub mod experiment {
    pub use runner::experiment::{
        CaseFile, ExperimentError, Need, ParameterFile, apply_settings, needs, searched_case,
    };
}

/// A failing case made as simple as it can be while it fails.
pub mod shrink {
    pub use runner::shrink::{Knob, KnobPlace, Move, ShrinkError, Shrunk, shrink, unmoved};
}

/// One run made in two ways on the same noise, and where the two part.
pub mod diff {
    pub use runner::diff::{NoCounterpart, counterpart, two_runs};
}

/// The story of a run, and what would have come of it had something gone otherwise.
pub mod why {
    pub use runner::why::story;
}

/// Compares populations and models with people that chose a gap in two streams of cars.
pub mod gap_choice {
    pub use runner::gap_choice::{
        FactsError, GapChoiceError, GapStudy, PlannedChooser, PopulationOrModel, read_people_at_gaps,
    };
}

/// Suites that are run again when what they read has changed.
pub mod watch {
    pub use runner::watch::{Agenda, Extent, Quiet, SuiteState};
}

/// Controllers that are programs of users': who may start them, where their processes are, what was said to them, and whether they keep
/// to the protocol.
pub mod programs {
    pub use under_test::{
        Allowed, AllowedError, Conformance, Conversation, Hello, KnowsMore, MoreTables, Parent, Permission,
        ProcessPool, StartError, StartProblem, TriedTimes, WireRecord, WireRecordError, again, conformance,
        read_conversations,
    };
}
