//! Functional mock-up units as programs: read here, and loaded by a process of ours that speaks the protocol.

mod folder;
mod host;
mod plan;
mod signals;
mod wired;
mod wiring;

use std::path::Path;

use ::fmu::Archive;

use self::folder::OwnFolder;
use super::lookup;
use super::start::{StartError, StartProblem};
use scenario::{DeclaredFmu, DeclaredProgram};

pub use host::host;

/// The word that has our program be the process of a unit.
pub const HOST: &str = "fmu-host";

/// A unit that is unpacked for one process, as long as that is there.
pub struct UnpackedFmu {
    /// The words that start the process.
    pub words: Vec<String>,
    _folder: OwnFolder,
}

/// Reads a unit, holds its variables against what the file says of them, and unpacks it for a process of `executable`, which is our
/// program. Nothing of the unit is executed.
///
/// # Errors
/// If it is no unit for this machine, cannot be unpacked, or has not the variables that it is wired by.
pub fn unpack(
    program: &DeclaredProgram,
    declared: &DeclaredFmu,
    executable: Option<&Path>,
) -> Result<UnpackedFmu, StartError> {
    let cannot = |message: String, hint: &str| {
        let message = format!("`{}`: {message}", declared.file);
        StartError::new(StartProblem::CannotStart, program, message, hint)
    };
    let bytes = lookup::fmu(program, &declared.file)?;
    let is_no_unit = |error: ::fmu::FmuError| {
        cannot(error.to_string(), "an FMU is for co-simulation, of FMI 2.0 or 3.0: see docs/under_test.md")
    };
    let mut archive = Archive::read(bytes).map_err(is_no_unit)?;
    let wiring = wiring::wiring(program, declared, archive.description())?;
    let executable = executable.ok_or_else(|| {
        let hint =
            "run the suite by `scenario-runner`, or as a test of a project by `scenario_runner::testing`";
        cannot(
            "FMUs are loaded by another process of the same program, and this one cannot be that".to_string(),
            hint,
        )
    })?;
    let is_unwritable = |error: std::io::Error| {
        cannot(format!("it cannot be unpacked: {error}"), "see that there is space for temporary files")
    };
    // Only its user may look into it, and it is gone with the process.
    let folder = OwnFolder::new(&std::env::temp_dir()).map_err(is_unwritable)?;
    let unpacked = archive.unpack(folder.path()).map_err(is_no_unit)?;
    let plan = plan::plan(program, archive.description(), unpacked, wiring);
    let path = folder.path().join("plan.json");
    let text = serde_json::to_vec(&plan).expect("a plan is numbers and texts");
    files::write(&path, text).map_err(is_unwritable)?;
    let word = |path: &Path| {
        path.to_str().map(str::to_string).ok_or_else(|| {
            cannot(format!("{} is no UTF-8", path.display()), "set TMPDIR to a folder whose name is")
        })
    };
    Ok(UnpackedFmu { words: vec![word(executable)?, HOST.to_string(), word(&path)?], _folder: folder })
}
