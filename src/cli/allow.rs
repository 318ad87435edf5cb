//! `scenario-runner allow FILE`: lets the programs that files declare run, until what runs is changed.

use std::path::Path;

use clap::Args;

use super::Exit;
use super::load;
use super::programs::say_all;
use files::Disk;
use lang::{self, Style};
use report::console::{stderr, stdout};
use scenario::registry::Registry;
use scenario::{DeclaredProgram, ProgramKind, Reference};
use under_test::{Allowed, AllowedError};

#[derive(Debug, Args)]
#[command(after_help = "\
What is allowed is the words of the command, its folder and its environment, as they stand in that
file; when one of them changes, it is asked for again. What stands in the program's own files is not
looked at, but an `fmu` that changes is asked for again. Allowing a program allows everything that it
does.")]
pub struct AllowArguments {
    /// Files that declare controllers (.scn, .yaml), or use files that do.
    #[arg(value_name = "FILE", required_unless_present = "list")]
    files: Vec<String>,

    /// Take back what was allowed of these files.
    #[arg(long, conflicts_with = "list")]
    revoke: bool,

    /// Print what is allowed.
    #[arg(long)]
    list: bool,
}

pub fn allow(arguments: &AllowArguments, registry: &Registry) -> Exit {
    let failed = |error: AllowedError| {
        writeln!(stderr(), "error: {error}");
        Exit::Usage
    };
    let mut allowed = match Allowed::place().and_then(Allowed::read) {
        Ok(allowed) => allowed,
        Err(error) => return failed(error),
    };
    if arguments.list {
        allowed.entries().for_each(|entry| writeln!(stdout(), "{entry}"));
        return Exit::Success;
    }
    for file in &arguments.files {
        if let Err(exit) = allow_file(file, arguments.revoke, &mut allowed, registry) {
            return exit;
        }
    }
    match allowed.write() {
        Ok(()) => Exit::Success,
        Err(error) => failed(error),
    }
}

fn allow_file(file: &str, revoke: bool, allowed: &mut Allowed, registry: &Registry) -> Result<(), Exit> {
    if !load::names_a_file(file) {
        writeln!(stderr(), "error: {file} is no scenario file");
        return Err(Exit::Usage);
    }
    if revoke {
        let taken = allowed.revoke_file(Path::new(file));
        writeln!(stdout(), "took back {taken} of {file}");
        return Ok(());
    }
    let programs = declared(file, registry)?;
    if programs.is_empty() {
        writeln!(stderr(), "error: {file} declares no controller");
        return Err(Exit::Usage);
    }
    for program in programs {
        if may_be_written_by_others(Path::new(&program.file)) {
            writeln!(
                stderr(),
                "error: everybody may write {}: whoever does could run anything",
                program.file
            );
            writeln!(stderr(), "help: `chmod o-w {}`", program.file);
            return Err(Exit::Usage);
        }
        if program.is_process() {
            allowed.add(&program).map_err(|error| say_all(&[error]).err().unwrap_or(Exit::Scenario))?;
        }
        show(&program);
    }
    Ok(())
}

/// The programs that a file declares or brings along.
fn declared(file: &str, registry: &Registry) -> Result<Vec<DeclaredProgram>, Exit> {
    let found = lang::controllers(Path::new(file), registry, &Disk).map_err(|failure| {
        stderr().styled(&failure.render(Style { colour: stderr().takes_colour() }));
        Exit::Scenario
    })?;
    let program = |model: &Reference<_>| -> Option<DeclaredProgram> {
        let model: &scenario::ControllerModel = model.known()?;
        model.program.as_deref().cloned()
    };
    Ok(found.iter().filter_map(program).collect())
}

/// What would run, word by word.
fn show(program: &DeclaredProgram) {
    let place = format!("{} ({}:{})", program.name, program.file, program.origin.line);
    match &program.kind {
        ProgramKind::Wasm(_) => return writeln!(stdout(), "{place} is a module and needs no permission"),
        ProgramKind::Command(words) => {
            writeln!(stdout(), "{place} may run");
            words.iter().for_each(|word| writeln!(stdout(), "  {word:?}"));
        }
        ProgramKind::Fmu(fmu) => {
            writeln!(stdout(), "{place} may run what is in");
            writeln!(stdout(), "  {:?}, as it is now", fmu.file);
        }
    }
    let folder = if program.folder.is_empty() { "the folder of that file" } else { &program.folder };
    writeln!(stdout(), "  in {folder}");
    program.environment.iter().for_each(|(name, value)| writeln!(stdout(), "  with {name}={value:?}"));
}

#[cfg(unix)]
fn may_be_written_by_others(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    path.metadata().is_ok_and(|metadata| metadata.permissions().mode() & 0o002 != 0)
}

#[cfg(not(unix))]
fn may_be_written_by_others(_path: &Path) -> bool {
    false
}
