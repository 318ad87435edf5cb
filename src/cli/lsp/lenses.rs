//! Lines above scenarios and suites: run, replay, and what the last run came to; and its failures as findings.

use std::path::Path;

use lsp_types::{Diagnostic, DiagnosticSeverity};
use serde_json::{Value, json};

use super::last_run::{Broken, LastResult, LastResults, TextsNow, results_of};
use super::names::range_in;
use super::workspace::Workspace;
use lang::{Runnable, runnables};

/// What a document is asked about.
pub struct Shown<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub workspace: &'a Workspace,
    pub runs: &'a LastResults,
    pub texts: TextsNow<'a>,
}

impl Shown<'_> {
    fn last(&self, one: &Runnable) -> Option<LastResult> {
        let scenario = Some(one.name.as_str()).filter(|_| !one.is_suite);
        self.runs.of(self.path, scenario, self.workspace, &self.texts)
    }
}

/// A command of the client with the program's arguments and the folder to start it in; the server starts nothing.
const RUN: &str = "scenarioRunner.run";

pub fn code_lenses(shown: &Shown) -> Vec<Value> {
    let Some((root, below)) = shown.workspace.place(shown.path) else { return Vec::new() };
    let file = below.display().to_string();
    if file.starts_with('-') {
        return Vec::new();
    }
    let mut lenses = Vec::new();
    for one in runnables(shown.text) {
        let range = range_in(shown.text, &one.at);
        let scenario = Some(one.name.as_str()).filter(|_| !one.is_suite);
        let results = results_of(&below, scenario).display().to_string();
        let mut run = vec!["run".to_string(), file.clone()];
        if let Some(name) = scenario {
            run.extend(["-E".to_string(), format!("scenario(={name})")]);
        }
        run.extend(["--json".to_string(), results]);
        let command = |title: &str, arguments: &[String]| {
            let started = json!({ "folder": root, "arguments": arguments, "name": one.name });
            json!({ "range": range, "command": { "title": title, "command": RUN, "arguments": [started] } })
        };
        lenses.push(command("Run", &run));
        let Some(last) = shown.last(&one) else { continue };
        // What else the command line said is not said again; and what a file gives as a key is to be no option.
        let is_plain = last.set.is_empty() && last.seed.bytes().all(|digit| digit.is_ascii_digit());
        if let Some(key) = last.worst().filter(|key| is_plain && !key.starts_with('-')) {
            let replay = ["replay", key, &file, "--seed", &last.seed].map(String::from);
            lenses.push(command("Replay worst", &replay));
        }
        lenses.push(json!({ "range": range, "command": { "title": last.words(), "command": "" } }));
    }
    lenses
}

/// What did not pass when it was last run, where its criteria stand now.
pub fn findings(shown: &Shown) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    let Some((root, _)) = shown.workspace.place(shown.path) else { return found };
    for one in runnables(shown.text) {
        let Some(last) = shown.last(&one) else { continue };
        for broken in last.broken.iter().filter(|one| one.place.is_in(root, shown.path)) {
            found.extend(finding(broken, &last, shown));
        }
        if let (None, Some(message)) = (last.worst(), &last.message) {
            let text = format!("`{}` was not judged: {message}", one.name);
            found.push(diagnostic(range_in(shown.text, &one.at), text, &last));
        }
    }
    found.dedup();
    found
}

fn finding(broken: &Broken, last: &LastResult, shown: &Shown) -> Option<Diagnostic> {
    let Broken { criterion, verdict, place, trials, worst } = broken;
    let line = line_of(shown.text, place.line, &place.source_line)?;
    let start = shown.text.split_inclusive('\n').take(line).map(str::len).sum::<usize>();
    let words = shown.text[start..].lines().next()?;
    let indent = words.len() - words.trim_start().len();
    let range = range_in(shown.text, &(start + indent..start + words.trim_end().len()));
    let times = if *trials == 1 { "1 trial".to_string() } else { format!("{trials} trials") };
    let what = if verdict == "failed" { "failed" } else { "could not be decided" };
    let worst = worst.as_ref().map(|key| format!("\nworst: {key}")).unwrap_or_default();
    Some(diagnostic(range, format!("`{criterion}` {what} in {times} of the last run{worst}"), last))
}

fn diagnostic(range: lsp_types::Range, message: String, last: &LastResult) -> Diagnostic {
    let (severity, message) = match &last.stale {
        None => (DiagnosticSeverity::WARNING, message),
        Some(why) => (DiagnosticSeverity::INFORMATION, format!("stale ({why}): {message}")),
    };
    let source = Some("last run".to_string());
    Diagnostic { range, severity: Some(severity), source, message, ..Diagnostic::default() }
}

/// The line, from 0, on which a text now has what stood on line `line`, from 1: there, or the nearest that reads the same.
fn line_of(text: &str, line: usize, words: &str) -> Option<usize> {
    let same =
        text.lines().enumerate().filter(|(_, one)| one.trim() == words.trim() && !words.trim().is_empty());
    same.map(|(at, _)| at).min_by_key(|at| at.abs_diff(line.saturating_sub(1)))
}
