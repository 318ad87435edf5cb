//! Which programs may be started: what the user has allowed, never what a project says of itself.

use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::path::{Path, PathBuf};

use serde_json::json;
use thiserror::Error;

use super::lookup;
use super::start::{StartError, StartProblem};
use files::escape::shell_path;
use scenario::{DeclaredProgram, ProgramKind, sha256};

/// Names programs that may be started, with commas between them, where nobody is asked.
pub const ALLOW_RUN: &str = "SCENARIO_RUNNER_ALLOW_RUN";

/// Which programs may be started.
#[derive(Debug, Clone, Default)]
pub struct Permission {
    all: bool,
    names: BTreeSet<String>,
    hashes: BTreeSet<String>,
}

impl Permission {
    /// The same, and everything.
    pub fn all(self) -> Self {
        Self { all: true, ..self }
    }

    /// The same, and programs of these names.
    pub fn named<N: Into<String>>(mut self, names: impl IntoIterator<Item = N>) -> Self {
        self.names.extend(names.into_iter().map(Into::into));
        self
    }

    /// The same, and what the user has allowed once and for all.
    pub fn listed(mut self, allowed: &Allowed) -> Self {
        self.hashes.extend(allowed.hashes.keys().cloned());
        self
    }

    /// The same, and what the environment names.
    pub fn of_environment(self) -> Self {
        let names = env::var(ALLOW_RUN).unwrap_or_default();
        self.named(names.split(',').map(str::trim).filter(|name| !name.is_empty()))
    }

    /// Whether a program may be started.
    pub fn allows(&self, program: &DeclaredProgram) -> bool {
        // A module can do nothing but decide.
        !program.is_process()
            || self.all
            || self.names.contains(&program.name)
            || self.hashes.contains(&hash(program))
    }

    /// Whether a program may be started.
    ///
    /// # Errors
    /// If not.
    pub fn check(&self, program: &DeclaredProgram) -> Result<(), StartError> {
        if let ProgramKind::Fmu(fmu) = &program.kind {
            lookup::fmu(program, &fmu.file)?;
        }
        if self.allows(program) {
            return Ok(());
        }
        let message = format!(
            "`{}` wants to run `{}` in the folder {}",
            program.name,
            program.typed(),
            lookup::folder(program).display()
        );
        let hint = format!(
            "read it, then `scenario-runner allow {}`; or run with `--allow-run={}`",
            shell_path(&program.file),
            program.name
        );
        Err(StartError::new(StartProblem::NotAllowed, program, message, hint))
    }
}

/// Of a declaration, what runs: another command, folder or environment is another one, another file as well; so is a functional mock-up
/// unit with another content.
pub fn hash(program: &DeclaredProgram) -> String {
    let path = Path::new(&program.file);
    let file =
        path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_path_buf());
    let environment: BTreeMap<_, _> = program.environment.iter().cloned().collect();
    let words = match &program.kind {
        ProgramKind::Command(words) => words.clone(),
        ProgramKind::Wasm(file) => vec!["wasm".into(), file.clone()],
        ProgramKind::Fmu(fmu) => vec!["fmu".into(), fmu.file.clone(), fmu_hash(program, &fmu.file)],
    };
    let what = json!({
        "file": file.to_string_lossy(),
        "name": program.name,
        "command": words,
        "folder": program.folder,
        "environment": environment,
    });
    sha256(what.to_string().as_bytes())
}

/// Of the content of a functional mock-up unit; of one that cannot be read, what is the hash of nothing.
fn fmu_hash(program: &DeclaredProgram, file: &str) -> String {
    lookup::fmu(program, file).map_or_else(|_| String::new(), |bytes| sha256(&bytes))
}

/// What the user has allowed: one line each, `hash name file`.
#[derive(Debug, Clone)]
pub struct Allowed {
    path: PathBuf,
    /// With what stands behind each.
    hashes: BTreeMap<String, String>,
}

/// Why the list of what is allowed cannot be used.
#[derive(Debug, Error)]
pub enum AllowedError {
    #[error(
        "there is no folder for what is allowed: neither XDG_CONFIG_HOME (on Windows APPDATA) nor HOME is set"
    )]
    /// There is no configuration of this user.
    NoFolder,
    #[error("cannot read what is allowed, {}: {error}", path.display())]
    /// The list is there and cannot be read.
    Unreadable {
        /// Where it is.
        path: PathBuf,
        /// Why not.
        error: files::ReadError,
    },
    #[error("cannot write what is allowed, {}: {error}", path.display())]
    /// The list cannot be written.
    Unwritable {
        /// Where it is.
        path: PathBuf,
        /// Why not.
        error: std::io::Error,
    },
}

impl Allowed {
    /// Where the list is: in the user's configuration.
    ///
    /// # Errors
    /// If there is no such folder.
    pub fn place() -> Result<PathBuf, AllowedError> {
        let variable = |name: &str| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = if cfg!(windows) { variable("APPDATA") } else { variable("XDG_CONFIG_HOME") };
        // Taken as it is only if it is no part of wherever one stands: a project cannot allow itself.
        let folder = folder.filter(|path| path.is_absolute());
        let folder =
            folder.or_else(|| Some(variable("HOME").filter(|path| path.is_absolute())?.join(".config")));
        Ok(folder.ok_or(AllowedError::NoFolder)?.join("scenario-runner").join("allowed"))
    }

    /// What stands in the list at `path`; nothing if it is not there.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(path: PathBuf) -> Result<Self, AllowedError> {
        let text = match files::read_text(&path) {
            Ok(text) => text,
            Err(error) if error.is_missing() => String::new(),
            Err(error) => return Err(AllowedError::Unreadable { path, error }),
        };
        let lines = text.lines().filter_map(|line| line.split_once(' '));
        let hashes = lines.map(|(hash, what)| (hash.to_string(), what.to_string())).collect();
        Ok(Self { path, hashes })
    }

    /// Adds a program.
    ///
    /// # Errors
    /// If it is a functional mock-up unit that cannot be read.
    pub fn add(&mut self, program: &DeclaredProgram) -> Result<(), StartError> {
        if let ProgramKind::Fmu(fmu) = &program.kind {
            lookup::fmu(program, &fmu.file)?;
        }
        let file = std::path::absolute(&program.file).unwrap_or_else(|_| PathBuf::from(&program.file));
        let what = format!("{} {}", program.name, file.display());
        self.hashes.insert(hash(program), what.replace(['\n', '\r'], " "));
        Ok(())
    }

    /// Takes a program off; whether it stood there.
    pub fn revoke(&mut self, program: &DeclaredProgram) -> bool {
        self.hashes.remove(&hash(program)).is_some()
    }

    /// Takes everything off that a file of this path was allowed; how much that was.
    pub fn revoke_file(&mut self, file: &Path) -> usize {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let ending = format!(" {}", file.display());
        let before = self.hashes.len();
        self.hashes.retain(|_, what| !what.ends_with(&ending));
        before - self.hashes.len()
    }

    /// Whether a program stands in it.
    pub fn contains(&self, program: &DeclaredProgram) -> bool {
        self.hashes.contains_key(&hash(program))
    }

    /// What stands in it: names and files.
    pub fn entries(&self) -> impl Iterator<Item = &str> {
        self.hashes.values().map(String::as_str)
    }

    /// Writes it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self) -> Result<(), AllowedError> {
        let text: String = self.hashes.iter().map(|(hash, what)| format!("{hash} {what}\n")).collect();
        let made = self.path.parent().map_or(Ok(()), files::make_folder);
        made.and_then(|()| files::write(&self.path, text))
            .map_err(|error| AllowedError::Unwritable { path: self.path.clone(), error })
    }
}
