//! A unit's library and its instances: initialised, stepped and asked, with what they return in words.

use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use super::binding::{Foreign, InstanceNames, LoadedLibrary, Status};
use super::description::{FmiVersion, Kind};
use super::error::{FmuError, FmuRefusal};

/// What a process has to know to load a unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LibraryPlace {
    /// Of the standard.
    pub version: FmiVersion,
    /// What is loaded.
    pub library: PathBuf,
    /// The folder of the unit's own data.
    pub resources: PathBuf,
    /// By which the library knows its description.
    pub token: String,
}

/// A unit's library in this process, until its last instance is gone.
pub struct Library {
    loaded: Rc<LoadedLibrary>,
    place: LibraryPlace,
}

/// One of a unit: what is stepped.
pub struct Instance {
    foreign: Foreign,
    /// What it has logged, for whoever keeps it.
    log: Vec<String>,
}

impl Library {
    /// Loads it.
    ///
    /// # Errors
    /// If the system does not, or it exports not what it must.
    pub fn load(place: LibraryPlace) -> Result<Self, FmuError> {
        let loaded = LoadedLibrary::load(&place.library, place.version).map_err(FmuError::NotLoaded)?;
        Ok(Self { loaded: Rc::new(loaded), place })
    }

    /// A new instance.
    ///
    /// # Errors
    /// If it makes none.
    pub fn instance(&self, name: &str) -> Result<Instance, FmuRefusal> {
        let text = |text: &str| CString::new(text.replace('\0', "")).expect("NUL was taken out");
        let resources = match self.place.version {
            FmiVersion::Two => uri(&self.place.resources),
            FmiVersion::Three => format!("{}{}", self.place.resources.display(), std::path::MAIN_SEPARATOR),
        };
        let names = InstanceNames {
            instance: text(name),
            token: text(&self.place.token),
            resources: text(&resources),
        };
        match Foreign::new(&self.loaded, &names) {
            Ok(foreign) => Ok(Instance { log: foreign.logged(), foreign }),
            Err(log) => Err(refused("it makes no instance", &log, false)),
        }
    }
}

impl Instance {
    /// Sets variables of a kind, which is no text.
    ///
    /// # Errors
    /// If it does not take them.
    pub fn set(&mut self, kind: Kind, references: &[u32], values: &[f64]) -> Result<(), FmuRefusal> {
        let status = self.foreign.set(kind, references, values);
        self.check("does not take what it is told", status)
    }

    /// Sets a variable that is a text, as far as NUL.
    ///
    /// # Errors
    /// If it does not take it.
    pub fn set_text(&mut self, reference: u32, text: &str) -> Result<(), FmuRefusal> {
        let text = CString::new(text.split('\0').next().unwrap_or_default()).expect("there is no NUL");
        let status = self.foreign.set_text(reference, &text);
        self.check("does not take a text", status)
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// If it does not say it.
    pub fn get(&mut self, kind: Kind, reference: u32) -> Result<f64, FmuRefusal> {
        let (status, value) = self.foreign.get(kind, reference);
        self.check("does not say its outputs", status)?;
        Ok(value)
    }

    /// Begins its initialisation, at time 0; inputs may then be set.
    ///
    /// # Errors
    /// If it does not begin.
    pub fn enter_initialisation(&mut self) -> Result<(), FmuRefusal> {
        let status = self.foreign.enter();
        self.check("cannot be initialised", status)
    }

    /// Ends its initialisation.
    ///
    /// # Errors
    /// If it does not come out of it.
    pub fn exit_initialisation(&mut self) -> Result<(), FmuRefusal> {
        let status = self.foreign.exit();
        self.check("cannot be initialised", status)
    }

    /// Goes on from `time` by `step`, both in s since its initialisation.
    ///
    /// # Errors
    /// If it does not go the whole step, or wants to end.
    pub fn step(&mut self, time: f64, step: f64) -> Result<(), FmuRefusal> {
        let (status, stepped) = self.foreign.step(time, step);
        self.check(&format!("does not step from {time} s by {step} s"), status)?;
        if stepped.terminates {
            return Err(refused("it wants the simulation to end", &self.log, false));
        }
        if stepped.is_early {
            return Err(refused("it came back before its step was over", &self.log, false));
        }
        Ok(())
    }

    /// What it has logged since this was asked last.
    pub fn take_log(&mut self) -> Vec<String> {
        std::mem::take(&mut self.log)
    }

    fn check(&mut self, what: &str, status: Status) -> Result<(), FmuRefusal> {
        let logged = self.foreign.logged();
        self.log.extend(logged.iter().cloned());
        let status = match status {
            0 | 1 => return Ok(()),
            2 => "discard",
            3 => "error",
            4 => "fatal",
            5 => "pending, which nobody asked for",
            _ => "a status that there is not",
        };
        let is_fatal = status == "fatal";
        if is_fatal {
            self.foreign.abandon();
        }
        Err(refused(&format!("it {what}: {status}"), &logged, is_fatal))
    }
}

/// With the last of what it logged meanwhile.
fn refused(what: &str, logged: &[String], is_fatal: bool) -> FmuRefusal {
    const MOST: usize = 3;
    let mut message = what.to_string();
    for (index, line) in logged.iter().skip(logged.len().saturating_sub(MOST)).enumerate() {
        message.push_str(if index == 0 { ": " } else { "; " });
        message.push_str(line.trim());
    }
    FmuRefusal { message, is_fatal }
}

/// Of a folder, as RFC 3986 writes it.
fn uri(folder: &Path) -> String {
    let path = folder.display().to_string().replace(std::path::MAIN_SEPARATOR, "/");
    let mut text = String::from(if path.starts_with('/') { "file://" } else { "file:///" });
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~:".contains(&byte) {
            text.push(char::from(byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resources_are_a_uri() {
        assert_eq!(uri(Path::new("/tmp/a b/ü")), "file:///tmp/a%20b/%C3%BC");
    }

    #[test]
    fn what_it_logged_last_is_the_reason() {
        let lines: Vec<String> = ["a", "b", " c\n", "d"].map(str::to_string).to_vec();
        assert_eq!(refused("it stops", &lines, true).message, "it stops: b; c; d");
        assert_eq!(refused("it stops", &[], false).message, "it stops");
    }

    #[test]
    fn what_is_no_library_is_not_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let library = folder.path().join("unit.so");
        std::fs::write(&library, "no code").unwrap();
        let (resources, token) = (folder.path().to_path_buf(), String::new());
        let place = LibraryPlace { version: FmiVersion::Two, library, resources, token };
        let error = Library::load(place).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("its library is not loaded: "), "{error}");
    }
}
