//! The file of a unit: an archive of which nothing is believed, unpacked into a folder that nobody else may see.

use std::io::{Cursor, Read};
use std::path::{Component, Path, PathBuf};

use zip::ZipArchive;
use zip::read::ZipFile;

use super::description::{Description, FmiVersion};
use super::error::FmuError;

/// Of `modelDescription.xml`, bytes.
const LARGEST_DESCRIPTION: u64 = 64 << 20;

/// Of all that is unpacked, bytes.
const LARGEST: u64 = 1 << 30;

/// Files in an archive, at most.
const MOST_FILES: usize = 100_000;

/// A unit as its file has it.
pub struct Archive {
    zip: ZipArchive<Cursor<Vec<u8>>>,
    description: Description,
}

/// Where the parts of a unit are that are used while it runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unpacked {
    /// What is loaded.
    pub library: PathBuf,
    /// The folder of the unit's own data, which is there even if it is empty.
    pub resources: PathBuf,
}

impl Archive {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// If they are no archive, or its description is none.
    pub fn read(bytes: Vec<u8>) -> Result<Self, FmuError> {
        let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(|error| refused(&error.to_string()))?;
        if zip.len() > MOST_FILES {
            return Err(refused(&format!("{} files, more than {MOST_FILES}", zip.len())));
        }
        let file = zip
            .by_name("modelDescription.xml")
            .map_err(|_| refused("there is no modelDescription.xml in it"))?;
        let mut left = LARGEST_DESCRIPTION;
        let text = String::from_utf8(content(file, &mut left)?)
            .map_err(|_| FmuError::Description("is not UTF-8".to_string()))?;
        let description = Description::read(&text).map_err(FmuError::Description)?;
        Ok(Self { zip, description })
    }

    /// What the unit says of itself.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Writes what runs need into a folder, which is there and empty: the files for this machine, the resources, the description.
    ///
    /// # Errors
    /// If there is no library for this machine, a name leads outside, or something cannot be written.
    pub fn unpack(&mut self, folder: &Path) -> Result<Unpacked, FmuError> {
        let binaries = format!("binaries/{}/", platform(self.description.version));
        let library = format!("{binaries}{}{}", self.description.identifier, std::env::consts::DLL_SUFFIX);
        self.check_claimed(&binaries)?;
        let mut left = LARGEST;
        let mut found = Vec::new();
        let mut is_there = false;
        for index in 0..self.zip.len() {
            let file = self.zip.by_index(index).map_err(|error| refused(&error.to_string()))?;
            let name = file.name().replace('\\', "/");
            let platform = name.strip_prefix("binaries/").and_then(|rest| rest.split('/').next());
            if let Some(platform) =
                platform.filter(|one| !one.is_empty() && !found.iter().any(|known| known == one))
            {
                found.push(platform.to_string());
            }
            if !is_wanted(&name, &binaries) {
                continue;
            }
            is_there |= name == library;
            if file.is_symlink() {
                return Err(refused(&format!("`{name}` is a link, which could lead anywhere")));
            }
            let Some(inside) = inside(&name) else {
                return Err(refused(&format!("`{name}` leads outside of it")));
            };
            files::write(&folder.join(inside), content(file, &mut left)?)?;
        }
        if !is_there {
            found.sort();
            return Err(FmuError::NoBinary { wanted: library, found });
        }
        let resources = folder.join("resources");
        files::make_folder(&resources)?;
        Ok(Unpacked { library: folder.join(&library), resources })
    }

    /// Refuses an archive that says of itself that it is too large, before anything is unpacked.
    fn check_claimed(&mut self, binaries: &str) -> Result<(), FmuError> {
        let mut claimed: u64 = 0;
        for index in 0..self.zip.len() {
            let file = self.zip.by_index_raw(index).map_err(|error| refused(&error.to_string()))?;
            if is_wanted(&file.name().replace('\\', "/"), binaries) {
                claimed = claimed.saturating_add(file.size());
            }
        }
        match claimed > LARGEST {
            true => Err(refused(&format!("it unpacks to {claimed} bytes, more than {LARGEST}"))),
            false => Ok(()),
        }
    }
}

/// Whether runs need what has this name.
fn is_wanted(name: &str, binaries: &str) -> bool {
    let is_of_runs =
        name.starts_with(binaries) || name.starts_with("resources/") || name == "modelDescription.xml";
    is_of_runs && !name.ends_with('/')
}

fn refused(message: &str) -> FmuError {
    FmuError::Archive(message.to_string())
}

/// The path of a file below the folder of its archive; `None` if it is not there.
fn inside(name: &str) -> Option<&Path> {
    let path = Path::new(name);
    let is_plain = path.components().all(|part| matches!(part, Component::Normal(_)));
    // A drive or a stream of Windows has a colon.
    (is_plain && !name.contains([':', '\0'])).then_some(path)
}

/// Reads a file of the archive, which is at most as large as it says, and takes its size from the bytes that are left.
fn content<R: Read>(file: ZipFile<R>, left: &mut u64) -> Result<Vec<u8>, FmuError> {
    let name = file.name().to_string();
    let mut bytes = Vec::new();
    let most = file.size().min(*left);
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| refused(&format!("`{name}` cannot be read: {error}")))?;
    match left.checked_sub(bytes.len() as u64) {
        Some(rest) if bytes.len() as u64 <= most => *left = rest,
        _ => return Err(refused(&format!("`{name}` unpacks to more than is taken"))),
    }
    Ok(bytes)
}

/// The folder below `binaries` for this machine.
fn platform(version: FmiVersion) -> String {
    let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
    match (version, system, machine) {
        (FmiVersion::Two, "linux", "x86_64") => "linux64".to_string(),
        (FmiVersion::Two, "windows", "x86_64") => "win64".to_string(),
        (FmiVersion::Two, "macos", "x86_64") => "darwin64".to_string(),
        // FMI 2.0 has names for no other machines; exporters use those of 3.0.
        (_, "macos", _) => format!("{machine}-darwin"),
        _ => format!("{machine}-{system}"),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::super::description::tests::TWO;
    use super::*;

    fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in files {
            if let Some(target) = name.strip_suffix("@") {
                zip.add_symlink(target, "/etc/passwd", SimpleFileOptions::default()).unwrap();
                continue;
            }
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(content).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn library() -> String {
        format!("binaries/{}/unit{}", platform(FmiVersion::Two), std::env::consts::DLL_SUFFIX)
    }

    fn unpacked(more: &[(&str, &[u8])]) -> Result<(tempfile::TempDir, Unpacked), FmuError> {
        let library = library();
        let mut files: Vec<(&str, &[u8])> =
            vec![("modelDescription.xml", TWO.as_bytes()), (&library, b"code")];
        files.extend(more);
        let folder = tempfile::tempdir().unwrap();
        let found = Archive::read(zipped(&files))?.unpack(folder.path())?;
        Ok((folder, found))
    }

    #[test]
    fn what_runs_need_is_unpacked_and_nothing_else() {
        let (folder, found) =
            unpacked(&[("resources/a/b.txt", b"b"), ("binaries/other/x.so", b"x"), ("sources/x.c", b"x")])
                .unwrap();
        assert_eq!(std::fs::read(&found.library).unwrap(), b"code");
        assert_eq!(std::fs::read(found.resources.join("a/b.txt")).unwrap(), b"b");
        assert!(!folder.path().join("sources").exists() && !folder.path().join("binaries/other").exists());
    }

    #[test]
    fn nothing_is_written_outside() {
        for name in ["resources/../../x", "resources//etc/../../../x", "resources/C:\\x", "resources/l@"] {
            let error = unpacked(&[(name, b"x")]).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains("outside") || error.contains("link"), "{name}: {error}");
        }
    }

    #[test]
    fn what_is_no_unit_is_said_so() {
        let of = |bytes: Vec<u8>| Archive::read(bytes).map(|_| ()).unwrap_err().to_string();
        assert!(of(b"PK nothing".to_vec()).contains("no archive"));
        assert!(of(zipped(&[("a", b"")])).contains("no modelDescription.xml"));
        assert!(of(zipped(&[("modelDescription.xml", b"<a")])).contains("is no XML"));
        let mut archive = Archive::read(zipped(&[
            ("modelDescription.xml", TWO.as_bytes()),
            ("binaries/sparc-plan9/unit.so", b""),
        ]))
        .unwrap();
        let folder = tempfile::tempdir().unwrap();
        let error = archive.unpack(folder.path()).unwrap_err().to_string();
        assert!(error.contains("no library for this machine") && error.contains("sparc-plan9"), "{error}");
    }

    #[test]
    fn an_archive_that_claims_to_be_too_large_is_not_unpacked() {
        let library = library();
        let mut bytes = zipped(&[("modelDescription.xml", TWO.as_bytes()), (&library, b"code")]);
        // The size that the central directory says of the last file: 24 bytes behind the beginning of its entry.
        let entry = bytes.windows(4).rposition(|four| four == b"PK\x01\x02").unwrap();
        bytes[entry + 24..entry + 28].copy_from_slice(&(LARGEST as u32 + 1).to_le_bytes());
        let folder = tempfile::tempdir().unwrap();
        let error = Archive::read(bytes).unwrap().unpack(folder.path()).unwrap_err().to_string();
        assert!(error.contains("more than 1073741824"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// What unpacks to more than it may, although it is small itself.
    #[test]
    fn what_grows_is_refused() {
        let bytes = zipped(&[("a", &vec![0; 1 << 20])]);
        assert!(bytes.len() < 1 << 14);
        let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let mut left = 1 << 10;
        let error = content(zip.by_index(0).unwrap(), &mut left).unwrap_err().to_string();
        assert!(error.contains("more than is taken"), "{error}");
    }
}
