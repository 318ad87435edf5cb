//! The command lines of all slices of a plan, on the engine that a user names.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use super::error::EngineError;
use super::ray::Ray;
use super::slurm::{SETTLE, Slurm};
use super::task::{EndedTask, Engine, EngineEvent, Task};

/// As on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EngineName {
    /// `ray`.
    Ray,
    /// `slurm`.
    Slurm,
}

impl FromStr for EngineName {
    type Err = EngineError;

    fn from_str(name: &str) -> Result<Self, EngineError> {
        match name {
            "ray" => Ok(Self::Ray),
            "slurm" => Ok(Self::Slurm),
            other => Err(EngineError::Refused(format!(
                "there is no engine `{other}`: known are `ray` and `slurm`"
            ))),
        }
    }
}

/// What slices take, and what only one engine is told.
#[derive(Debug, Clone)]
pub struct EngineOptions {
    /// On a disk that all machines share under this path: what tasks say, and what drivers note.
    pub folder: PathBuf,
    /// Processor cores of a slice.
    pub cpus: u32,
    /// What else a slice takes of a machine that Ray knows, such as `av_stack: 1`.
    pub resources: BTreeMap<String, f64>,
    /// Slurm's own.
    pub slurm_options: Vec<String>,
    /// For so long a shared disk may show late what a task of Slurm has left.
    pub settle: Duration,
    /// The Python that has Ray.
    pub python: OsString,
}

impl EngineOptions {
    /// A core a slice and nothing else, `python3`, and a network file system as it is mounted by default.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            cpus: 1,
            resources: BTreeMap::new(),
            slurm_options: Vec::new(),
            settle: SETTLE,
            python: "python3".into(),
        }
    }
}

/// What slice `number` (from 1) says on its standard streams, a file that is there once it has begun.
pub fn slice_output(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("slice-{number}.out"))
}

/// Has all slices done on that engine; each has a [`slice_output`] in the folder.
///
/// # Errors
/// As [`Engine::run`]. A slice that ended with another exit code than 0, or not at all, is no error here: look at what is given back.
pub fn run_slices(
    engine: EngineName,
    slices: Vec<Vec<String>>,
    options: EngineOptions,
    stop: &dyn Fn() -> bool,
    told: &mut dyn FnMut(EngineEvent),
) -> Result<Vec<EndedTask>, EngineError> {
    let EngineOptions { folder, cpus, resources, slurm_options, settle, python } = options;
    files::make_folder(&folder).map_err(|error| EngineError::file(&folder, error))?;
    let folder = std::path::absolute(&folder).map_err(|error| EngineError::file(&folder, error))?;
    let task = |(at, argv): (usize, Vec<String>)| {
        let id = format!("slice-{}", at + 1);
        Task { out: slice_output(&folder, at + 1), id, argv, cpus, resources: resources.clone() }
    };
    let tasks: Vec<Task> = slices.into_iter().enumerate().map(task).collect();
    match engine {
        EngineName::Ray => Ray { python }.run(&tasks, stop, told),
        EngineName::Slurm => Slurm { folder, options: slurm_options, settle }.run(&tasks, stop, told),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_engine_that_there_is_not_is_refused_with_those_that_there_are() {
        assert_eq!("slurm".parse::<EngineName>().unwrap(), EngineName::Slurm);
        let error = "dask".parse::<EngineName>().unwrap_err();
        assert_eq!(error.to_string(), "there is no engine `dask`: known are `ray` and `slurm`");
    }

    #[test]
    fn every_slice_is_a_task_with_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("engine");
        let options = EngineOptions { python: "/no/such/python".into(), ..EngineOptions::new(&path) };
        let slices = vec![vec!["x".to_string()], Vec::new()];
        let error = run_slices(EngineName::Ray, slices, options, &|| false, &mut |_| ()).unwrap_err();
        assert_eq!(error.to_string(), "the task `slice-2` has no program");
        assert!(path.is_dir());
    }
}
