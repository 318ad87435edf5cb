//! `--serve-by-parent NAME`: whoever started this program decides for a controller, on its standard streams.

use std::fs::File;
use std::path::Path;
#[cfg(unix)]
use std::{thread, time::Duration};

use crate::cli::Exit;
use report::console::{self, stderr};
use results::SuiteReport;
use runner::run::Stop;
use under_test::Parent;

/// The streams to whoever started this program, and the controller for which that decides.
pub struct ServedByParent {
    pub controller: String,
    answers: File,
    requests: File,
    #[cfg(unix)]
    id: u32,
}

impl ServedByParent {
    /// Takes the standard streams; from then on everything is said on standard error.
    pub fn take(controller: &str) -> Result<Self, Exit> {
        let (answers, requests) = console::give_streams().map_err(|error| {
            writeln!(stderr(), "error: the standard streams cannot be used: {error}");
            Exit::Output
        })?;
        Ok(Self {
            controller: controller.to_string(),
            answers,
            requests,
            #[cfg(unix)]
            id: std::os::unix::process::parent_id(),
        })
    }

    /// Refuses reports that would be written among the requests.
    pub fn check(&self, reports: &[(&str, &Path)]) -> Result<(), Exit> {
        let Some((option, path)) = reports.iter().find(|(_, path)| is_same(&self.requests, path)) else {
            return Ok(());
        };
        let path = path.display();
        writeln!(
            stderr(),
            "error: with `--serve-by-parent`, standard output belongs to the requests: `{option} {path}`"
        );
        writeln!(stderr(), "help: name a file; nothing was run, and nothing was written");
        Err(Exit::Usage)
    }

    /// Who started this program.
    pub fn watch(&self) -> ParentWatch {
        ParentWatch {
            #[cfg(unix)]
            id: self.id,
        }
    }

    /// What asks the parent.
    pub fn parent(self) -> Result<Parent, Exit> {
        Parent::new(self.answers, self.requests).map_err(|error| {
            writeln!(stderr(), "error: the parent cannot be asked: {error}");
            Exit::Output
        })
    }
}

/// Who started this program, to be watched.
pub struct ParentWatch {
    #[cfg(unix)]
    id: u32,
}

impl ParentWatch {
    /// Ends everything once whoever started this program is gone, though its streams may be held open by others: first nothing more begins,
    /// as if it were interrupted.
    #[cfg(unix)]
    pub fn end_with(self, stop: &Stop) {
        const INTERVAL: Duration = Duration::from_millis(200);
        // It may wait for an answer that never comes, and nobody waits for its reports.
        const GRACE: Duration = Duration::from_secs(3);
        let (parent, stop) = (self.id, stop.clone());
        let watch = move || {
            while std::os::unix::process::parent_id() == parent {
                thread::sleep(INTERVAL);
            }
            stop.request();
            thread::sleep(GRACE);
            std::process::exit(i32::from(Exit::Interrupted as u8));
        };
        if let Err(error) = thread::Builder::new().name("parent".into()).spawn(watch) {
            writeln!(stderr(), "warning: the end of the parent will not be noticed: {error}");
        }
    }

    /// Elsewhere the end of its streams is all that is known of it.
    #[cfg(not(unix))]
    pub fn end_with(self, _stop: &Stop) {}
}

/// Whether a path leads to where a stream leads.
#[cfg(unix)]
fn is_same(stream: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |metadata: std::fs::Metadata| (metadata.dev(), metadata.ino());
    matches!((stream.metadata().map(place), path.metadata().map(place)), (Ok(one), Ok(other)) if one == other)
}

#[cfg(not(unix))]
fn is_same(_stream: &File, _path: &Path) -> bool {
    false
}

/// Why what passed says nothing of the parent, if it was not asked.
pub fn was_not_asked(controller: &str, reports: &[SuiteReport]) -> Option<String> {
    let mut tested = reports.iter().flat_map(|report| &report.controllers);
    let was_asked = tested.any(|one| one.name == controller && one.answers.is_some());
    (!was_asked)
        .then(|| format!("the parent was not asked once: `{controller}` drives in nothing that was run"))
}
