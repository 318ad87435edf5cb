//! The reports of a session that go elsewhere than to the terminal.

use std::env;
use std::io::{self, BufWriter, IntoInnerError, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use files::{WholeFile, append_text};
use report::console::stdout;
use report::{
    Repository, RunLines, annotations, step_summary, to_html, write_csv, write_json, write_junit, write_runs,
    write_tap,
};
use results::{Reporter, Results};
use runner::session::Units;

#[derive(Debug, Args)]
pub struct OutputArguments {
    /// Write a JUnit XML report.
    #[arg(long, value_name = "PATH")]
    junit: Option<PathBuf>,

    /// Write all results as JSON.
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,

    /// Write a TAP 14 report.
    #[arg(long, value_name = "PATH")]
    tap: Option<PathBuf>,

    /// Print GitHub annotations and append to the step's summary [runs do so by themselves in GitHub Actions].
    #[arg(long)]
    github: bool,

    /// Write one HTML file with tables, charts and animations of the worst runs.
    #[arg(long, value_name = "PATH")]
    html: Option<PathBuf>,

    /// Write every run as JSON, one a line (JSON Lines), without times: the same bytes whatever the threads.
    #[arg(long, value_name = "PATH")]
    runs: Option<PathBuf>,

    /// Write every run as a row of CSV, for spreadsheets and data frames.
    #[arg(long, value_name = "PATH")]
    csv: Option<PathBuf>,
}

/// Reports of a command that runs one block. What its `--json` writes is its result alone, and it makes no runs of trials.
#[derive(Debug, Clone, Default, Args)]
pub struct BlockOutputArguments {
    /// Write a JUnit XML report.
    #[arg(long, value_name = "PATH")]
    junit: Option<PathBuf>,

    /// Write a TAP 14 report.
    #[arg(long, value_name = "PATH")]
    tap: Option<PathBuf>,

    /// Write one HTML file with tables, charts and animations of the worst runs.
    #[arg(long, value_name = "PATH")]
    html: Option<PathBuf>,

    /// Print GitHub annotations and append to the step's summary.
    #[arg(long)]
    github: bool,
}

impl BlockOutputArguments {
    /// As those of a session.
    pub fn of_session(&self) -> OutputArguments {
        let Self { junit, tap, html, github } = self.clone();
        OutputArguments { junit, json: None, tap, github, html, runs: None, csv: None }
    }
}

impl OutputArguments {
    /// Every report that is to be a file, by its option.
    pub fn files(&self) -> Vec<(&'static str, &Path)> {
        let files = [
            ("--junit", &self.junit),
            ("--json", &self.json),
            ("--tap", &self.tap),
            ("--html", &self.html),
            ("--runs", &self.runs),
            ("--csv", &self.csv),
        ];
        files.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?))).collect()
    }
}

impl OutputArguments {
    /// Whether a report that is to be made names every trial, and so needs all of them to the end.
    pub fn need_every_trial(&self, on_github: bool) -> bool {
        (!self.files().is_empty() || self.github || on_github) && !self.are_runs_alone(on_github)
    }

    /// Whether lines of runs are all that is to be written, so that they are written as units end, and nothing is held for them.
    fn are_runs_alone(&self, on_github: bool) -> bool {
        matches!(self.files()[..], [("--runs", _)]) && !self.github && !on_github
    }

    /// Begins to write the lines of runs, if they are all that is asked for.
    ///
    /// # Errors
    /// What to say of a file that cannot be written.
    pub fn begin_lines(
        &self,
        units: &Units,
        chosen: &[bool],
        on_github: bool,
    ) -> Result<Option<WrittenLines>, String> {
        let Some(path) = self.runs.as_ref().filter(|_| self.are_runs_alone(on_github)) else {
            return Ok(None);
        };
        let file = WholeFile::create(path).map_err(|error| cannot_write(path, &error))?;
        let units = (0..units.len()).filter(|unit| chosen[*unit] && !units.is_block(*unit)).collect();
        Ok(Some(WrittenLines { path: path.clone(), lines: RunLines::new(BufWriter::new(file), units) }))
    }

    /// Whether a report that was asked for draws runs.
    pub fn draw_runs(&self) -> bool {
        self.html.is_some() || self.json.is_some()
    }
}

/// Lines of runs, written while these are made.
pub struct WrittenLines {
    path: PathBuf,
    lines: RunLines<BufWriter<WholeFile>>,
}

impl WrittenLines {
    /// Who has to be told what happens.
    pub fn reporter(&mut self) -> &mut dyn Reporter {
        &mut self.lines
    }

    /// Makes the file whole, or says why that cannot be.
    pub fn end(self) -> Option<String> {
        let whole = self.lines.finish().and_then(|out| out.into_inner().map_err(IntoInnerError::into_error));
        match whole.and_then(WholeFile::commit) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Some(cannot_write(&self.path, &error)),
            _ => None,
        }
    }
}

fn cannot_write(path: &Path, error: &io::Error) -> String {
    format!("cannot write {}: {error}", path.display())
}

/// Writes whatever was asked for but lines that [are written already](OutputArguments::begin_lines), and returns what could not be written. GitHub is told if that was asked for, or
/// `on_github`.
pub fn write(arguments: &OutputArguments, results: &Results, on_github: bool) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut write = |path: &Option<PathBuf>, content: &dyn Fn(&mut dyn Write) -> io::Result<()>| {
        let Some(path) = path else { return };
        match save(path, content) {
            // Nobody reads it any more, which is the reader's choice.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
            Err(error) => complaints.push(cannot_write(path, &error)),
            Ok(()) => {}
        }
    };
    let repository = Repository::here();
    write(&arguments.junit, &|out| write_junit(results, &repository, out));
    write(&arguments.json, &|out| write_json(results, out));
    write(&arguments.tap, &|out| write_tap(results, out));
    write(&arguments.html, &|out| out.write_all(to_html(results).as_bytes()));
    if !arguments.are_runs_alone(on_github) {
        write(&arguments.runs, &|out| write_runs(results, out));
    }
    write(&arguments.csv, &|out| write_csv(results, out));
    if arguments.github || on_github {
        complaints.extend(tell_github(results, &repository));
    }
    complaints
}

/// Annotations go to stdout; the summary goes to the file that GitHub names.
fn tell_github(results: &Results, repository: &Repository) -> Option<String> {
    stdout().verbatim(&annotations(results, repository));
    let path = env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty())?;
    let summary = step_summary(results);
    let error = append_text(Path::new(&path), &summary).err()?;
    Some(format!("cannot write {}: {error}", Path::new(&path).display()))
}

/// Writes a file as a whole, making the folders it is to be in.
fn save(path: &Path, content: &dyn Fn(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    content(&mut file)?;
    file.commit()
}
