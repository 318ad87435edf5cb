//! What `plan`, `exec` and `merge` share: a project with its manifest, if nothing has changed since.

use std::path::Path;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::program_files::program_files;
use super::programs::{VerifyArguments, declared};
use super::set::SetArguments;
use super::{Exit, load};
use files::{Disk, hexadecimal};
use report::console::stderr;
use runner::project::Project;
use runner::run::RunDigests;
use runner::shards::{Build, ManifestReader, PlannedProgram, ShardError};
use scenario::registry::Registry;
use scenario::{DeclaredProgram, Gate, TextDigest, sha256};

/// A program that decides, and the digest of its declaration and its files.
pub type ProgramDigest = (Arc<DeclaredProgram>, String);

/// A project that is what its manifest was made of.
pub struct PlannedProject {
    pub manifest: ManifestReader,
    pub project: Project,
    pub programs: Vec<ProgramDigest>,
    pub digests: RunDigests,
    pub verify: VerifyArguments,
}

impl PlannedProject {
    /// Opens a manifest and the files that it names; what is wrong or has changed is said on stderr.
    pub fn open(path: &Path, colour: bool, registry: &Registry) -> Result<Self, Exit> {
        let build = own_build()?;
        let manifest = ManifestReader::open(path).map_err(|error| said(&error))?;
        manifest.check_build(&build).map_err(|error| {
            let exit = said(&error);
            writeln!(stderr(), "help: a plan is for the program that made it; copy that, or plan again");
            exit
        })?;
        let header = manifest.header();
        let strange = |what: &str| {
            writeln!(stderr(), "error: {}: its {what} cannot be read", path.display());
            Exit::Usage
        };
        let verify = VerifyArguments::of_word(&header.verify_runs).ok_or_else(|| strange("`verify_runs`"))?;
        let set = SetArguments::of_words(&header.set).ok_or_else(|| strange("`set`"))?;
        let files: Vec<&String> = header.files.iter().collect();
        let project = load::load_all(&files, header.seed, &set, colour, registry)?;
        same_texts(&header.texts, &texts(&project))?;
        let programs = programs(&project)?;
        same_programs(&header.programs, &planned_programs(&programs))?;
        let digests = run_digests(&build, &verify, &programs);
        Ok(Self { manifest, project, programs, digests, verify })
    }
}

/// The program that is running.
pub fn own_build() -> Result<Build, Exit> {
    Build::here().map_err(|error| {
        writeln!(stderr(), "error: this program's own file, by which results are told from those of another, cannot be read: {error}");
        Exit::Usage
    })
}

/// Of the runs of this build. Where programs decide, which runs are made twice is part of what results hold.
pub fn run_digests(build: &Build, verify: &VerifyArguments, programs: &[ProgramDigest]) -> RunDigests {
    let made_twice =
        if programs.is_empty() { String::new() } else { format!(", made twice: {}", verify.word()) };
    RunDigests::new(&format!("{}{made_twice}", build.identity()), programs.to_vec())
}

/// Says what is wrong.
pub fn said(error: &ShardError) -> Exit {
    writeln!(stderr(), "error: {error}");
    match error {
        ShardError::Stopped => Exit::Interrupted,
        ShardError::NotWritten { .. } => Exit::Output,
        _ => Exit::Usage,
    }
}

/// What the files of a project are, with the baselines that its gates compare with. Of one that cannot be read its gate tells.
pub fn texts(project: &Project) -> Vec<TextDigest> {
    let suites = || project.suites().iter().map(|one| &one.suite);
    let baseline = |gate: &Gate| {
        let digest = files::digest(Path::new(&gate.baseline)).ok()?;
        Some(TextDigest { file: gate.baseline.clone(), sha256: hexadecimal(&digest) })
    };
    let mut all: Vec<TextDigest> = suites().flat_map(|suite| suite.texts.clone()).collect();
    all.extend(suites().flat_map(|suite| &suite.gates).filter_map(baseline));
    all.sort_by(|one, other| (&one.file, &one.sha256).cmp(&(&other.file, &other.sha256)));
    all.dedup();
    all
}

fn same_texts(planned: &[TextDigest], found: &[TextDigest]) -> Result<(), Exit> {
    let changed = planned.iter().chain(found).find(|one| !planned.contains(one) || !found.contains(one));
    let Some(changed) = changed else { return Ok(()) };
    writeln!(stderr(), "error: {} is not what it was when the plan was made", changed.file);
    writeln!(stderr(), "help: plan again, or bring the files as they were");
    Err(Exit::Usage)
}

/// The programs that decide in a project, each once.
pub fn programs(project: &Project) -> Result<Vec<ProgramDigest>, Exit> {
    let mut all: Vec<ProgramDigest> = Vec::new();
    for program in project.suites().iter().flat_map(|one| declared(&one.suite)) {
        if all.iter().all(|(known, _)| **known != *program) {
            all.push((Arc::new(program.clone()), program_digest(program)?));
        }
    }
    all.sort_by(|(one, _), (other, _)| (&one.name, &one.file).cmp(&(&other.name, &other.file)));
    Ok(all)
}

/// As the manifest has them.
pub fn planned_programs(programs: &[ProgramDigest]) -> Vec<PlannedProgram> {
    let planned = |(program, digest): &ProgramDigest| PlannedProgram {
        name: program.name.clone(),
        file: program.file.clone(),
        digest: digest.clone(),
    };
    programs.iter().map(planned).collect()
}

fn same_programs(planned: &[PlannedProgram], found: &[PlannedProgram]) -> Result<(), Exit> {
    let changed = planned.iter().chain(found).find(|one| !planned.contains(one) || !found.contains(one));
    let Some(changed) = changed else { return Ok(()) };
    writeln!(
        stderr(),
        "error: the program of `{}` ({}), or a file that its declaration names, is not what it was when the plan was made",
        changed.name,
        changed.file
    );
    writeln!(stderr(), "help: plan again, or bring the files as they were");
    Err(Exit::Usage)
}

/// By which all programs of a plan together are allowed: it says what they are, and nothing about where they are.
pub fn permission_digest(programs: &[PlannedProgram]) -> String {
    let lines = programs.iter().map(|one| format!("{} {} {}\n", one.name, one.file, one.digest));
    sha256(lines.collect::<String>().as_bytes())
}

/// Over all of a declaration that decides runs, and all bytes of the files that it names.
fn program_digest(program: &DeclaredProgram) -> Result<String, Exit> {
    let DeclaredProgram {
        name: _,
        kind,
        folder,
        environment,
        gives,
        period,
        delay,
        settles,
        starts_within: _,
        answers_within,
        processes: _,
        is_nondeterministic,
        file: _,
        origin: _,
        parameters: _,
    } = program;
    let decides = (folder, environment, gives, period, delay, settles, answers_within, is_nondeterministic);
    let mut hash = Sha256::new().chain_update(format!("{kind:?} {decides:?}\n"));
    for path in program_files(program, &Disk) {
        let digest = files::digest(&path).map_err(|error| {
            writeln!(stderr(), "error: {} of the program `{}`: {error}", path.display(), program.name);
            Exit::Usage
        })?;
        hash.update(format!("{}\n", path.display()));
        hash.update(digest);
    }
    Ok(hexadecimal(&hash.finalize()))
}
