//! The scenario language: from `.scn` and `.suite` files to a checked suite, or to everything that is wrong with them.
//!
//! A text becomes a lossless [`Tree`]; `check` turns trees into plain [`scenario`] data; what is wrong is a
//! list of [`Diagnostic`]s, which [`render`] shows. What a text may name is in the [`Registry`] that it is read with.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod assist;
mod backslashes;
mod blocks;
mod check;
mod codes;
mod complete;
mod consequences;
mod decimal_commas;
mod declared;
mod diagnostic;
mod excerpt;
mod file_kind;
pub mod filter;
mod fixes;
mod hints;
mod notations;
mod overrides;
mod reference;
mod render;
mod replacement;
mod runnables;
mod settings;
mod source;
mod suite;
mod symbols;
mod syntax;
#[cfg(test)]
mod tests;
mod texts;
mod tokens;
mod units;
mod value;
mod write;
mod yaml;

use std::path::Path;

pub use assist::{definition, hover};
pub use check::write_scenario;
pub use codes::{Code, Severity};
pub use complete::{Completion, complete};
pub use diagnostic::{Diagnostic, Label, Remedy, nearest};
pub use excerpt::Excerpt;
pub use fixes::{Fix, fixes};
pub use hints::{Hint, hints};
pub use notations::{unit_in, unit_in_claim};
pub use overrides::Override;
pub use reference::reference;
pub use render::{Style, count, render, render_all};
pub use replacement::{Outside, Replacement};
pub use runnables::{Runnable, runnables};
pub use source::{Location, Source, SourceId, Sources, Span};
pub use suite::DEFAULT_SEED;
pub use symbols::{
    FileEdit, NamedPlace, Rename, SymbolKind, WorkspaceSymbol, references, rename, rename_place,
    workspace_symbols,
};
pub use syntax::{Tree, format};
pub use texts::{LARGEST_FILE, with_declared};
pub use tokens::{ColouredToken, TokenColour, coloured};
pub use units::{UNITS, UnitEntry};
pub use write::{quantity, quoted, write_comparison};
pub use yaml::schema as yaml_schema;

use ::files::{Files, Overlay};
use scenario::registry::Registry;
use scenario::{ControllerModel, Dimension, Expression, Origin, Reference, Suite, Value};
use texts::Texts;
use value::{Binding, Typed, ValueKind};

/// A suite without errors.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Ready to be planned.
    pub suite: Suite,
    /// What may not be what was meant, by file and place.
    pub warnings: Vec<Diagnostic>,
    /// Every text that it was read from, for showing places.
    pub sources: Sources,
}

/// Everything that is wrong, errors and warnings, by file and place.
#[derive(Debug, Clone)]
pub struct Failure {
    /// At least one of them is an error.
    pub diagnostics: Vec<Diagnostic>,
    /// Every text that was read, for showing places.
    pub sources: Sources,
}

/// What there is to say about a file, and the suite it is, if it has no errors.
#[derive(Debug, Clone)]
pub struct Examined {
    /// `None` where there are errors.
    pub suite: Option<Suite>,
    /// Errors and warnings, by file and place.
    pub found: Vec<Diagnostic>,
    /// Every text that was read, for showing places.
    pub sources: Sources,
}

/// A constant with a name, such as `let braking_distance = 4.75 m`.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedValue {
    /// As it is defined.
    pub name: String,
    /// SI units.
    pub value: Value,
    /// Of a number.
    pub dimension: Option<Dimension>,
    /// Whether another definition builds on it.
    pub used: bool,
    /// Where it is defined.
    pub origin: Origin,
}

/// The constants that a file defines, by name: what `tune --save` writes.
pub fn named_values(path: &Path, registry: &Registry, texts: &dyn Files) -> Result<Vec<NamedValue>, Failure> {
    let (mut files, mut report) = (Texts::new(registry, texts), Vec::new());
    let file = files.open(path, None, &mut report);
    let names = file.into_iter().flat_map(|file| &files.scope(file).names);
    let constant = |(name, binding): (&String, &Binding)| {
        let Typed { expression: Expression::Constant(value), kind, .. } = binding.value.as_ref()? else {
            return None;
        };
        Some(NamedValue {
            name: name.clone(),
            value: value.clone(),
            dimension: if let ValueKind::Number(dimension) = kind { Some(*dimension) } else { None },
            used: binding.used.get(),
            origin: files.sources.origin(binding.span),
        })
    };
    let mut found: Vec<NamedValue> = names.filter_map(constant).collect();
    found.sort_by(|left, right| left.name.cmp(&right.name));
    if texts::has_errors(&report) {
        report.iter_mut().flat_map(|one| &mut one.labels).for_each(|label| {
            label.span = files.sources.resolve(label.span);
        });
        return Err(Failure { diagnostics: report, sources: files.sources });
    }
    Ok(found)
}

/// Reads and checks a `.suite` file, or a `.scn` file as a suite named after it with seed [`DEFAULT_SEED`].
pub fn load(path: &Path, registry: &Registry, texts: &dyn Files) -> Result<Loaded, Failure> {
    load_with(path, Texts::new(registry, texts))
}

/// The controllers that a file declares or brings along, by the order in which they are declared.
pub fn controllers(
    path: &Path,
    registry: &Registry,
    texts: &dyn Files,
) -> Result<Vec<Reference<ControllerModel>>, Failure> {
    let known = with_controllers(path, registry, texts)?;
    let own = known.controllers().iter().filter(|known| known.program.is_some());
    Ok(own.map(Reference::from).collect())
}

/// What is registered, with the controllers that a file declares or brings along.
///
/// # Errors
/// If the file, or one that it uses, does not read.
pub fn with_controllers(path: &Path, registry: &Registry, texts: &dyn Files) -> Result<Registry, Failure> {
    let (mut files, mut report) = (Texts::new(registry, texts), Vec::new());
    files.open(path, None, &mut report);
    if texts::has_errors(&report) {
        report.iter_mut().flat_map(|one| &mut one.labels).for_each(|label| {
            label.span = files.sources.resolve(label.span);
        });
        return Err(Failure { diagnostics: report, sources: files.sources });
    }
    Ok(files.registry)
}

/// As [`load`], with what the command line says otherwise of this file and all it uses.
pub fn load_otherwise(
    path: &Path,
    outside: &Outside,
    registry: &Registry,
    texts: &dyn Files,
) -> Result<Loaded, Failure> {
    load_with(path, Texts::new(registry, texts).otherwise(outside))
}

/// What the suite in a text says of itself, as far as it can be read.
pub fn suite_doc(text: &str) -> Option<String> {
    let (tree, _) = Tree::parse(Sources::default().add("", ""), text.into());
    check::doc(tree.file().suites().next()?.block().doc())
}

/// Everything that is to be said about a file, which may be there only to be used by others.
pub fn examine(path: &Path, registry: &Registry, texts: &dyn Files) -> Examined {
    examine_with(path, Texts::new(registry, texts))
}

/// As [`examine`], of a text that is being edited and stands for the file at `path`: no more is read than can be checked
/// at every stroke of a key.
pub fn examine_edited(path: &Path, text: &str, registry: &Registry, texts: &dyn Files) -> Examined {
    examine_with(path, Texts::new(registry, &Overlay::new(texts, path, text)).while_edited())
}

fn examine_with(path: &Path, files: Texts) -> Examined {
    let (suite, mut found, sources) = match load_with(path, files) {
        Ok(loaded) => (Some(loaded.suite), loaded.warnings, loaded.sources),
        Err(failure) => (None, failure.diagnostics, failure.sources),
    };
    if file_kind::file_kind(path) == Some(file_kind::FileKind::Scenarios) {
        found.retain(|diagnostic| diagnostic.code != Code::NoScenario);
    }
    Examined { suite, found, sources }
}

fn load_with(path: &Path, mut files: Texts) -> Result<Loaded, Failure> {
    let mut report = Vec::new();
    let Some(kind) = file_kind::file_kind(path) else {
        let source = files.sources.add(path.display().to_string(), "");
        report.push(
            Diagnostic::new(
                Code::UnknownFileKind,
                Span::beginning(source),
                format!("`{}` is neither a scenario file nor a suite", path.display()),
            )
            .label("unknown kind of file")
            .hint(match files.texts().is_folder(path) {
                true => format!("it is a folder; name the files in it: `{}`", path.join("*.scn").display()),
                false => {
                    "scenario files end in `.scn`, suites in `.suite`, and both may be `.yaml`".to_string()
                }
            }),
        );
        return Err(Failure { diagnostics: report, sources: files.sources });
    };
    let file = files.open(path, None, &mut report);
    files.open_outside(&mut report);
    let suite = file.and_then(|file| suite::suite(&mut files, file, path, kind, &mut report));
    if let Some(file) = file {
        let root = files.tree(file).source;
        files.trace(root, &mut report);
    }
    consequences::remove(&files, &mut report);
    say_what_is_set(&mut files, &mut report);
    for label in report.iter_mut().flat_map(|diagnostic| &mut diagnostic.labels) {
        label.span = files.sources.resolve(label.span);
    }
    report.sort_by_key(|diagnostic| (diagnostic.span().source, diagnostic.span().start));
    let failed = texts::has_errors(&report);
    let more = report.len().saturating_sub(diagnostic::MOST_FINDINGS);
    report.truncate(diagnostic::MOST_FINDINGS);
    if let Some(last) = report.last_mut().filter(|_| more > 0) {
        last.notes.push(format!("at least {more} more findings are not shown"));
    }
    let set = files.outside.words();
    let own = files.registry.controllers().iter().filter(|known| known.program.is_some());
    let controllers = own.map(Reference::from).collect();
    let texts = files.digests();
    let suite =
        suite.map(|suite| Suite { set, controllers, texts, notations: notations::of(&suite), ..suite });
    let sources = files.sources;
    match suite {
        Some(suite) if !failed => Ok(Loaded { suite, warnings: report, sources }),
        _ => Err(Failure { diagnostics: report, sources }),
    }
}

/// Findings about values that are set from outside: those that nothing has the name of, and those that are wrong.
fn say_what_is_set(files: &mut Texts, report: &mut Vec<Diagnostic>) {
    for finding in report.iter_mut() {
        let at = finding.span();
        let own = files.set.iter().filter(|set| {
            set.source == at.source && set.start < at.end.max(at.start + 1) && at.start < set.end
        });
        let text: String = own.map(|set| files.sources.text(*set)).collect();
        for one in files.overrides.all().iter().filter(|one| text.contains(&one.value)) {
            finding.notes.push(format!("`{one}` is set on the command line"));
        }
    }
    // What could not be read may well have the name.
    let unread =
        |finding: &Diagnostic| ["E01", "E02"].iter().any(|group| finding.code.name().starts_with(group));
    if report.iter().any(unread) {
        return;
    }
    let (unknown, known) = files.overrides.unknown();
    for one in unknown {
        let text = one.to_string();
        let source = files.sources.add("the command line", text.as_str());
        report.push(
            Diagnostic::new(
                Code::UnknownSetting,
                Span::new(source, 0, one.name.len()),
                format!("there is nothing called `{}` to be set", one.name),
            )
            .label("no variation, `let`, parameter or statement has this name")
            .suggest(&one.name, known.iter().map(String::as_str)),
        );
    }
}

/// The YAML form of a scenario file or suite. Comments are not kept.
pub fn to_yaml(source: SourceId, text: &str) -> Result<String, Vec<Diagnostic>> {
    let (tree, diagnostics) = Tree::parse(source, text.into());
    if diagnostics.is_empty() { Ok(yaml::to_yaml(&tree)) } else { Err(diagnostics) }
}

/// The scenario file or suite that a YAML text stands for, in the one style.
pub fn from_yaml(source: SourceId, text: &str) -> Result<String, Vec<Diagnostic>> {
    let yaml::Translation { text, places } = yaml::to_scn(source, text)?;
    format(source, &text).map_err(|mut diagnostics| {
        for label in diagnostics.iter_mut().flat_map(|diagnostic| &mut diagnostic.labels) {
            (label.span.start, label.span.end) = places.original(label.span.start, label.span.end);
        }
        diagnostics
    })
}

impl Failure {
    /// All diagnostics as text.
    pub fn render(&self, style: Style) -> String {
        render_all(&self.diagnostics, &self.sources, style)
    }
}
