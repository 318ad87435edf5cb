//! The files of programs that decide, as far as their declarations name them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use files::Files;
use scenario::{DeclaredProgram, ProgramKind};

/// A module, a functional mock-up unit, or the files that a command names.
pub fn program_files(program: &DeclaredProgram, disk: &dyn Files) -> BTreeSet<PathBuf> {
    let beside = Path::new(&program.file).parent().unwrap_or(Path::new(""));
    match &program.kind {
        ProgramKind::Wasm(file) => BTreeSet::from([beside.join(file)]),
        ProgramKind::Fmu(fmu) => BTreeSet::from([beside.join(&fmu.file)]),
        ProgramKind::Command(words) => files_of(words, &beside.join(&program.folder), disk),
    }
}

/// The files that a command names in its folder, such as a script and what it is told to read, and those beside them of the same kind, in
/// their folder and in the folders of that: what it imports. What is found on PATH is the system's.
fn files_of(words: &[String], folder: &Path, disk: &dyn Files) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for word in words {
        for part in [Some(word.as_str()), word.split_once('=').map(|(_, value)| value)].into_iter().flatten()
        {
            let path = folder.join(part);
            if part.is_empty() || !disk.is_file(&path) {
                continue;
            }
            if let (Some(parent), Some(ending)) = (path.parent(), path.extension()) {
                let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
                let ending = glob::Pattern::escape(&ending.to_string_lossy());
                let parent = glob::Pattern::escape(&parent.to_string_lossy());
                for stem in ["*", "*/*"] {
                    let paths = disk.matching(&format!("{parent}/{stem}.{ending}"));
                    found.extend(paths.into_iter().flatten());
                }
            }
            found.insert(path);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use files::RecordingDisk;

    #[test]
    fn what_a_command_is_made_of_is_found() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("parts")).unwrap();
        for file in ["av.py", "helper.py", "parts/more.py", "log.txt", "calm.json", "other.json"] {
            fs::write(folder.path().join(file), file).unwrap();
        }
        let words = ["python3", "av.py", "--with=calm.json", "--fast"].map(str::to_string);
        let recording = RecordingDisk::default();
        let found = files_of(&words, folder.path(), &recording);
        let names: Vec<String> = found
            .iter()
            .map(|path| path.strip_prefix(folder.path()).unwrap().display().to_string().replace('\\', "/"))
            .collect();
        assert_eq!(names, ["av.py", "calm.json", "helper.py", "other.json", "parts/more.py"]);
        assert!(recording.changed().is_empty());
        fs::write(folder.path().join("second.py"), "").unwrap();
        assert!(!recording.changed().is_empty(), "a file that could be imported");
    }
}
