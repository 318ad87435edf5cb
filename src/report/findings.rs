//! What the checker found, for other programs: JSON, GitHub workflow commands and SARIF.

use serde_json::{Value, json};

use super::Repository;
use files::escape::{github_data, github_property};
use lang::{Code, Diagnostic, Location, Severity, Sources, Span};

/// Diagnostics with the texts they are about.
pub type Findings = [(Vec<Diagnostic>, Sources)];

struct Region<'a> {
    file: &'a str,
    from: Location,
    to: Location,
}

fn region(sources: &Sources, span: Span) -> Region<'_> {
    let source = sources.get(span.source);
    Region { file: &source.name, from: source.location(span.start), to: source.location(span.end) }
}

/// A path as it stands in a URI.
pub fn uri_path(path: &str) -> String {
    let mut encoded = String::new();
    for byte in path.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b'~' => {
                encoded.push(byte as char)
            }
            _ => encoded.push_str(&format!("%{byte:02X}")),
        }
    }
    encoded
}

fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

fn each(findings: &Findings) -> impl Iterator<Item = (&Diagnostic, &Sources)> {
    findings.iter().flat_map(|(diagnostics, sources)| diagnostics.iter().map(move |found| (found, sources)))
}

/// One object: `diagnostics`, each with code, severity, message, labels (the first is the place), notes and hints.
/// Lines and columns count from 1, columns in characters.
pub fn json(findings: &Findings) -> String {
    let diagnostics: Vec<Value> = each(findings)
        .map(|(found, sources)| {
            let labels: Vec<Value> = found
                .labels
                .iter()
                .map(|label| {
                    let Region { file, from, to } = region(sources, label.span);
                    json!({
                        "file": file, "line": from.line, "column": from.column,
                        "end_line": to.line, "end_column": to.column, "text": label.text,
                    })
                })
                .collect();
            json!({
                "code": found.code.name(), "severity": level(found.severity), "message": found.message,
                "labels": labels, "notes": found.notes, "hints": found.hints,
            })
        })
        .collect();
    format!("{:#}\n", json!({ "version": 1, "diagnostics": diagnostics }))
}

/// One workflow command a line, such as `::error file=…,line=…::message`, with files from the root of the repository on.
pub fn github(findings: &Findings, repository: &Repository) -> String {
    let mut text = String::new();
    for (found, sources) in each(findings) {
        let Region { file, from, to } = region(sources, found.span());
        let message: Vec<&str> = std::iter::once(&found.message)
            .chain(&found.notes)
            .chain(&found.hints)
            .map(String::as_str)
            .collect();
        text.push_str(&format!(
            "::{} file={},line={},endLine={},col={},endColumn={},title={}::{}\n",
            level(found.severity),
            github_property(&repository.path(file)),
            from.line,
            to.line,
            from.column,
            to.column,
            found.code.name(),
            github_data(&message.join("\n")),
        ));
    }
    text
}

/// A SARIF 2.1.0 log with one run; files are named from the root of the repository on.
pub fn sarif(findings: &Findings, repository: &Repository) -> String {
    let rules: Vec<Value> = Code::ALL
        .iter()
        .map(|code| {
            json!({
                "id": code.name(),
                "shortDescription": { "text": code.title() },
                "fullDescription": { "text": code.explanation() },
                "defaultConfiguration": { "level": level(code.severity()) },
            })
        })
        .collect();
    let place = |sources: &Sources, span: Span| {
        let Region { file, from, to } = region(sources, span);
        json!({
            "artifactLocation": { "uri": uri_path(&repository.path(file)) },
            "region": {
                "startLine": from.line, "startColumn": from.column, "endLine": to.line, "endColumn": to.column,
            },
        })
    };
    let results: Vec<Value> = each(findings)
        .map(|(found, sources)| {
            let related: Vec<Value> = found.labels[1..]
                .iter()
                .map(|label| {
                    json!({
                        "physicalLocation": place(sources, label.span),
                        "message": { "text": label.text },
                    })
                })
                .collect();
            let text: Vec<&str> = std::iter::once(&found.message)
                .chain(&found.notes)
                .chain(&found.hints)
                .map(String::as_str)
                .collect();
            json!({
                "ruleId": found.code.name(),
                "level": level(found.severity),
                "message": { "text": text.join("\n") },
                "locations": [{ "physicalLocation": place(sources, found.span()) }],
                "relatedLocations": related,
            })
        })
        .collect();
    let log = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "scenario-runner", "version": env!("CARGO_PKG_VERSION"), "rules": rules,
            } },
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    });
    format!("{log:#}\n")
}
