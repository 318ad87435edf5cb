//! Files that use each other, and the names that each can see.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use super::backslashes;
use super::check;
use super::codes::{Code, Severity};
use super::decimal_commas;
use super::diagnostic::Diagnostic;
use super::file_kind::{ENDINGS, FileKind, file_kind};
use super::overrides::{self, Edit, Overrides};
use super::replacement::Outside;
use super::source::{SourceId, Sources, Span};
use super::syntax::ast::{self, View};
use super::syntax::{Node, NodeIndex, Tree};
use super::value::{self, Binding, NameScope};
use super::yaml;
use files::{self, ReadError};
use scenario::registry::Registry;
use scenario::{TextDigest, sha256};

/// Larger files are refused.
pub const LARGEST_FILE: usize = 16 << 20;

/// Of all files together that make up a text while it is edited, bytes: checking takes up to 200 times as much memory.
const LARGEST_WHILE_EDITED: usize = 3 << 20;

/// A file that was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FileId(u32);

/// Something with a name, where it is defined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NameDefinition {
    pub file: FileId,
    pub node: NodeIndex,
    /// Of the name.
    pub span: Span,
}

/// The names that a file can see: its own and those of the files it uses.
#[derive(Debug, Default)]
pub struct Names {
    pub roads: HashMap<String, NameDefinition>,
    /// Controllers of one's own.
    pub controllers: HashMap<String, NameDefinition>,
    /// Scenarios and templates.
    pub scenarios: HashMap<String, NameDefinition>,
    /// Searches, tunes, evaluates and statements.
    pub blocks: HashMap<String, NameDefinition>,
}

struct File {
    tree: Tree,
    names: Names,
    scope: NameScope<'static>,
}

/// Controllers in the place of others.
#[derive(Default)]
pub struct Tests {
    /// Those of the command line.
    outside: Vec<Tree>,
    /// The names that these know.
    outside_scope: NameScope<'static>,
    /// The suite whose statements of that kind hold.
    pub suite: Option<FileId>,
    /// What each vehicle would have had, by the vehicle's name; known as scenarios are checked.
    replaced: Mutex<BTreeMap<String, BTreeSet<String>>>,
}

impl Tests {
    /// What each vehicle would have had.
    pub fn replaced(&self) -> MutexGuard<'_, BTreeMap<String, BTreeSet<String>>> {
        locked(&self.replaced)
    }
}

/// What was said before somebody panicked is as it was said.
fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Every file that was read, each once.
pub struct Texts<'f> {
    /// What they may name.
    pub registry: Registry,
    /// Where they are read.
    texts: &'f dyn files::Files,
    pub sources: Sources,
    files: Vec<File>,
    /// By canonical path; `None` while it is being read or when it could not be.
    by_path: HashMap<PathBuf, Option<FileId>>,
    /// Files that are opened next, parsed before that, by canonical path.
    ahead: HashMap<PathBuf, Tree>,
    /// The files being read, with the `use` that led to each.
    reading: Vec<(PathBuf, Option<Span>)>,
    /// What the command line says otherwise.
    pub outside: Outside,
    /// Values that are set from outside.
    pub overrides: Overrides,
    /// Controllers in the place of others.
    pub tests: Tests,
    /// Where they stand in the texts.
    pub set: Vec<Span>,
    /// What stands in files that are no scenarios, by path.
    others: Mutex<HashMap<String, Result<Arc<str>, String>>>,
    /// SHA-256 of what was read, hexadecimal, by path.
    digests: Mutex<BTreeMap<String, String>>,
    /// Of all texts, bytes.
    size: usize,
    /// More are not read, bytes.
    largest: usize,
}

impl<'f> Texts<'f> {
    /// None yet, that are in `texts` and may name what is in `registry`.
    pub fn new(registry: &Registry, texts: &'f dyn files::Files) -> Self {
        Self {
            registry: registry.clone(),
            texts,
            sources: Sources::default(),
            files: Vec::new(),
            by_path: HashMap::new(),
            ahead: HashMap::new(),
            reading: Vec::new(),
            outside: Outside::default(),
            overrides: Overrides::default(),
            tests: Tests::default(),
            set: Vec::new(),
            others: Mutex::default(),
            digests: Mutex::default(),
            size: 0,
            largest: usize::MAX,
        }
    }

    /// The same, of which no more is read than can be checked at every stroke of a key.
    pub fn while_edited(self) -> Self {
        Self { largest: LARGEST_WHILE_EDITED, ..self }
    }

    /// The same, of which the command line says something otherwise.
    pub fn otherwise(self, outside: &Outside) -> Self {
        Self { overrides: Overrides::new(&outside.set), outside: outside.clone(), ..self }
    }

    /// Reads the files that the command line uses, and what controllers it puts in the place of others.
    pub fn open_outside(&mut self, report: &mut Vec<Diagnostic>) {
        const NAME: &str = "the command line";
        let mut names = Names::default();
        for path in self.outside.uses.clone() {
            let text = path.display().to_string();
            let asked = Span::new(self.sources.add(NAME, text.as_str()), 0, text.len());
            if let Some(used) = self.open(&path, Some(asked), report) {
                let mut scope = std::mem::take(&mut self.tests.outside_scope);
                self.import(used, asked, &mut names, &mut scope, report);
                self.tests.outside_scope = scope;
            }
        }
        for replacement in self.outside.controllers.clone() {
            let source = self.sources.add(NAME, replacement.to_string());
            self.tests.outside.extend(replacement.tree().map(|tree| tree.of_source(source)));
        }
    }

    /// Every statement that puts a controller in the place of others, with the names that it knows.
    pub fn tested(&self) -> impl Iterator<Item = (ast::Tested<'_>, &NameScope<'static>)> {
        let outside = self.tests.outside.iter().filter_map(|tree| ast::Tested::cast(tree.root()));
        let suite = self.tests.suite.into_iter().flat_map(move |file| {
            let suite = self.tree(file).file().suites().next();
            suite
                .into_iter()
                .flat_map(|suite| suite.block().tests())
                .map(move |node| (node, self.scope(file)))
        });
        outside.map(|node| (node, &self.tests.outside_scope)).chain(suite)
    }

    /// Where they are read.
    pub fn texts(&self) -> &'f dyn files::Files {
        self.texts
    }

    pub fn tree(&self, file: FileId) -> &Tree {
        &self.files[file.0 as usize].tree
    }

    pub fn node(&self, definition: NameDefinition) -> Node<'_> {
        self.tree(definition.file).node(definition.node)
    }

    /// The scenario or template that a definition is of.
    ///
    /// # Panics
    /// If it is of something else.
    pub fn scenario(&self, definition: NameDefinition) -> ast::Scenario<'_> {
        ast::Scenario::cast(self.node(definition)).expect("it is the definition of a scenario")
    }

    pub fn names(&self, file: FileId) -> &Names {
        &self.files[file.0 as usize].names
    }

    /// The values that a file can see.
    pub fn scope(&self, file: FileId) -> &NameScope<'static> {
        &self.files[file.0 as usize].scope
    }

    pub fn ids(&self) -> impl Iterator<Item = FileId> + use<> {
        (0..self.files.len() as u32).map(FileId)
    }

    /// Parses scenario files that are opened next, side by side. What is wrong with one is said when it is opened.
    pub fn parse_ahead<'p>(&mut self, paths: impl Iterator<Item = &'p Path>) {
        // Of a text that is changed, or is not read at all, there is nothing to parse ahead.
        if !self.overrides.is_empty() || self.largest != usize::MAX {
            return;
        }
        let identified = paths.map(|path| (self.texts.identity(path), path));
        let unread: Vec<_> = identified
            .filter(|(identity, path)| {
                file_kind(path) != Some(FileKind::Yaml) && !self.by_path.contains_key(identity)
            })
            .collect();
        let texts = self.texts;
        let parsed = unread.into_par_iter().filter_map(|(identity, path)| {
            let text = String::from_utf8(texts.read(path, &ENDINGS, LARGEST_FILE as u64).ok()?).ok()?;
            let (tree, wrong) = Tree::parse(SourceId(u32::MAX), text.into());
            wrong.is_empty().then_some((identity, tree))
        });
        self.ahead = parsed.collect();
    }

    /// Reads the file at `path` and all it uses; `asked` is the place that names it.
    pub fn open(&mut self, path: &Path, asked: Option<Span>, report: &mut Vec<Diagnostic>) -> Option<FileId> {
        let identity = self.texts.identity(path);
        if let Some(known) = self.by_path.get(&identity) {
            if known.is_none()
                && let Some(asked) = asked
                && let Some(first) = self.reading.iter().position(|(reading, _)| *reading == identity)
            {
                report.push(self.circle(first, path, asked));
            }
            return *known;
        }
        self.by_path.insert(identity.clone(), None);
        let name = path.display().to_string();
        let ahead = self.ahead.remove(&identity);
        let read = match &ahead {
            Some(tree) => {
                self.note(path, tree.text().as_bytes());
                Ok(tree.text().into())
            }
            None => self.read(path),
        };
        let read = read.and_then(|text| self.within_bounds(path, text));
        let source = match read {
            Ok(text) => match file_kind(path) {
                Some(FileKind::Yaml) => self.sources.add(name, text),
                _ => {
                    let (text, edits) = self.with_values(&text);
                    let source = self.sources.add(name, text);
                    self.mark(source, &edits);
                    source
                }
            },
            Err((code, message, hint, before)) => {
                let (span, label) = match (asked, before) {
                    (Some(asked), None) => (asked, "named here"),
                    (_, before) => {
                        let text = before.unwrap_or_default();
                        let at = text.len();
                        let source = self.sources.add(name, text);
                        (Span::new(source, at, at), "here")
                    }
                };
                report.push(Diagnostic::new(code, span, message).label(label).hint(hint));
                return None;
            }
        };
        self.reading.push((identity.clone(), asked));
        let text = self.sources.get(source).text.clone();
        let file = match file_kind(path) {
            Some(FileKind::Yaml) => match yaml::to_scn(source, &text) {
                Ok(yaml::Translation { text, places }) => {
                    let (text, edits) = self.with_values(&text);
                    let lengths: Vec<_> =
                        edits.iter().map(|edit| (edit.range.clone(), edit.text.len())).collect();
                    let places = places.edited(&lengths);
                    let translation = self.sources.add_translation(text.to_string(), source, places);
                    self.mark(translation, &edits);
                    Some(self.add(translation, path, None, report))
                }
                Err(diagnostics) => {
                    report.extend(diagnostics);
                    None
                }
            },
            _ => Some(self.add(source, path, ahead, report)),
        };
        self.reading.pop();
        self.by_path.insert(identity, file);
        file
    }

    /// A text with the values that are set in it, and what was changed. One that cannot be read stays as it is.
    fn with_values(&mut self, text: &str) -> (Arc<str>, Vec<Edit>) {
        if self.overrides.is_empty() {
            return (text.into(), Vec::new());
        }
        let (tree, unreadable) = Tree::parse(SourceId(u32::MAX), text.into());
        if !unreadable.is_empty() {
            return (text.into(), Vec::new());
        }
        let edits = self.overrides.edits(&tree, &self.registry);
        (overrides::apply(text, &edits).into(), edits)
    }

    fn mark(&mut self, source: SourceId, edits: &[Edit]) {
        let mut shift = 0isize;
        for edit in edits {
            let start = edit.range.start.saturating_add_signed(shift);
            self.set.push(Span::new(source, start, start + edit.text.len()));
            shift += edit.text.len() as isize - edit.range.len() as isize;
        }
    }

    /// The text, or code, message, hint and the part that could be read.
    fn read(&self, path: &Path) -> Result<Arc<str>, (Code, String, String, Option<String>)> {
        let shown = path.display();
        let bytes = self.texts.read(path, &ENDINGS, LARGEST_FILE as u64).map_err(|error| {
            let (code, hint) = match &error {
                ReadError::OtherKind { .. } => (
                    Code::UnknownFileKind,
                    "scenario files end in `.scn` or `.yaml`, suites in `.suite`".to_string(),
                ),
                ReadError::TooLarge { .. } => (Code::FileTooLarge, "split it into several files".to_string()),
                error if error.is_missing() => (Code::UnreadableFile, self.neighbour(path)),
                _ => (Code::UnreadableFile, "it must be a regular file that may be read".to_string()),
            };
            (code, format!("cannot read `{shown}`: {error}"), hint, None)
        })?;
        self.note(path, &bytes);
        String::from_utf8(bytes).map(Arc::from).map_err(|error| {
            let valid = error.utf8_error().valid_up_to();
            let before = String::from_utf8_lossy(&error.as_bytes()[..valid]).into_owned();
            let message =
                format!("`{shown}` is not UTF-8 text: byte {valid} is 0x{:02x}", error.as_bytes()[valid]);
            (Code::NotUtf8, message, "save the file as UTF-8".to_string(), Some(before))
        })
    }

    /// The text, unless it stands among so much that it is not checked while it is edited.
    fn within_bounds(
        &mut self,
        path: &Path,
        text: Arc<str>,
    ) -> Result<Arc<str>, (Code, String, String, Option<String>)> {
        self.size += text.len();
        if self.size <= self.largest {
            return Ok(text);
        }
        let message = format!(
            "with `{}` these files have {} bytes, more than the {} that are checked while edited",
            path.display(),
            self.size,
            self.largest
        );
        Err((Code::FileTooLarge, message, "run `scenario-runner check` on the file".to_string(), None))
    }

    /// What stands in a file of another kind, or why it cannot be read; each file is read once.
    pub fn text_of(&self, path: &str, endings: &[&str]) -> Result<Arc<str>, String> {
        let read = || {
            let text = self.texts.read_text(Path::new(path), endings).map_err(|error| error.to_string())?;
            self.note(Path::new(path), text.as_bytes());
            Ok(Arc::from(text))
        };
        locked(&self.others).entry(path.to_string()).or_insert_with(read).clone()
    }

    fn note(&self, path: &Path, bytes: &[u8]) {
        locked(&self.digests).insert(path.display().to_string(), sha256(bytes));
    }

    /// Every file of which text was read, by name.
    pub fn digests(&self) -> Vec<TextDigest> {
        let known = locked(&self.digests);
        known.iter().map(|(file, sha256)| TextDigest { file: file.clone(), sha256: sha256.clone() }).collect()
    }

    fn circle(&self, first: usize, path: &Path, asked: Span) -> Diagnostic {
        let message = format!("`{}` uses itself in a circle", path.display());
        let mut diagnostic = Diagnostic::new(Code::CircularUse, asked, message).label("leads back to it");
        for (_, asked) in &self.reading[first + 1..] {
            if let Some(asked) = asked {
                diagnostic = diagnostic.context(*asked, "which is used here");
            }
        }
        diagnostic.hint("move what both need into a third file")
    }

    /// Adds a text, whose tree is there if it was parsed `ahead`, with all it uses.
    fn add(
        &mut self,
        source: SourceId,
        path: &Path,
        ahead: Option<Tree>,
        report: &mut Vec<Diagnostic>,
    ) -> FileId {
        let (tree, diagnostics) = match ahead {
            Some(tree) => (tree.of_source(source), Vec::new()),
            None => Tree::parse(source, self.sources.get(source).text.clone()),
        };
        report.extend(diagnostics);
        let is_translated = self.sources.resolve(Span::new(source, 0, 0)).source != source;
        backslashes::refuse(&tree, is_translated, report);
        report.extend(decimal_commas::found(&tree));
        let uses: Vec<(String, Span)> =
            tree.file().uses().map(|used| (used.path().path(), used.path().span())).collect();
        let mut names = Names::default();
        let mut scope = NameScope::default();
        for (named, span) in uses {
            if let Some(used) = self.open(&join(path, &named), Some(span), report) {
                self.import(used, span, &mut names, &mut scope, report);
            }
        }
        let file = FileId(self.files.len() as u32);
        let inner = tree.file().suites().flat_map(|suite| suite.block().children());
        for node in tree.root().children().chain(inner) {
            let Some(node) = ast::Defining::cast(node) else { continue };
            let (name, table, what) = match node {
                ast::Defining::RoadDefinition(road) => (road.name(), &mut names.roads, "road"),
                ast::Defining::ControllerDefinition(own) => {
                    (own.name(), &mut names.controllers, "controller")
                }
                ast::Defining::Scenario(scenario) => (scenario.name(), &mut names.scenarios, "scenario"),
                ast::Defining::Search(search) => (search.name(), &mut names.blocks, "search"),
                ast::Defining::Tune(tune) => (tune.name(), &mut names.blocks, "tune"),
                ast::Defining::Evaluate(evaluate) => (evaluate.name(), &mut names.blocks, "evaluate"),
                ast::Defining::Calibrate(calibrate) => (calibrate.name(), &mut names.blocks, "calibrate"),
                ast::Defining::Estimate(estimate) => (estimate.name(), &mut names.blocks, "estimate"),
                ast::Defining::Statement(statement) => (statement.name(), &mut names.blocks, "statement"),
                ast::Defining::Binding(binding) => {
                    bind(binding, &mut scope, report);
                    continue;
                }
            };
            define(*node, name, file, table, what, report);
        }
        self.files.push(File { tree, names, scope });
        self.declare_controllers(file, report);
        file
    }

    /// Makes the controllers that a file declares known beside those that ship.
    fn declare_controllers(&mut self, file: FileId, report: &mut Vec<Diagnostic>) {
        let mut registry = self.registry.clone();
        for node in self.tree(file).file().controllers() {
            let name = node.name();
            let is_first =
                self.names(file).controllers.get(name.text()).is_some_and(|one| one.span == name.span());
            let Some(model) = check::controller(node, &registry, self.scope(file), &self.sources, report)
            else {
                continue;
            };
            // Of two in one file that is said already.
            let known = registry.controllers().get(name.text()).and_then(|known| known.program.as_ref());
            if let Some(known) = known.filter(|_| is_first) {
                report.push(
                    Diagnostic::new(
                        Code::DuplicateName,
                        name.span(),
                        format!("there is another controller `{}`", name.text()),
                    )
                    .label("declared again")
                    .note(format!("declared first in {}:{}", known.origin.file, known.origin.line))
                    .hint("rename one of them: reports and baselines tell controllers by their names"),
                );
            } else if is_first {
                match registry.clone().with_controller(model) {
                    Ok(more) => registry = more,
                    Err(error) => report.push(
                        Diagnostic::new(Code::WrongParameter, name.span(), error.to_string())
                            .label("declared wrongly")
                            .hint("change the name or the value"),
                    ),
                }
            }
        }
        self.registry = registry;
    }

    /// Makes the names of `used` known; one and the same definition may arrive over several ways.
    fn import(
        &self,
        used: FileId,
        asked: Span,
        names: &mut Names,
        scope: &mut NameScope,
        report: &mut Vec<Diagnostic>,
    ) {
        let from = &self.files[used.0 as usize];
        let mut clash = |name: &str, first: Span, second: Span| {
            report.push(
                Diagnostic::new(Code::DuplicateName, asked, format!("`{name}` comes from two files"))
                    .label("brings it a second time")
                    .context(first, "defined here")
                    .context(second, "and here")
                    .hint("rename one of them"),
            );
        };
        for (table, more) in [
            (&mut names.roads, &from.names.roads),
            (&mut names.controllers, &from.names.controllers),
            (&mut names.scenarios, &from.names.scenarios),
            (&mut names.blocks, &from.names.blocks),
        ] {
            for (name, definition) in more {
                match table.get(name) {
                    Some(known) if known != definition => clash(name, known.span, definition.span),
                    _ => {
                        table.insert(name.clone(), *definition);
                    }
                }
            }
        }
        for (name, binding) in &from.scope.names {
            match scope.names.get(name) {
                Some(known) if known.span != binding.span => clash(name, known.span, binding.span),
                _ => {
                    scope.names.insert(name.clone(), binding.clone());
                }
            }
        }
    }

    /// Adds to every diagnostic of a used file by which way it came in.
    pub fn trace(&self, root: SourceId, report: &mut [Diagnostic]) {
        let mut users: HashMap<SourceId, Span> = HashMap::new();
        for file in &self.files {
            for string in file.tree.file().uses().map(ast::UseFile::path) {
                let name = &self.sources.get(file.tree.source).name;
                let used = self.texts.identity(&join(Path::new(name), &string.path()));
                if let Some(Some(used)) = self.by_path.get(&used) {
                    users.entry(self.tree(*used).source).or_insert(string.span());
                }
            }
        }
        for diagnostic in report {
            let mut source = diagnostic.span().source;
            let mut way = Vec::new();
            while source != root && way.len() < self.files.len() {
                let Some(user) = users.get(&source) else { break };
                let place = self.sources.location(*user);
                way.push(format!("{}:{}", self.sources.get(user.source).name, place.line));
                source = user.source;
            }
            if !way.is_empty() {
                diagnostic.notes.push(format!("this file is used by {}", way.join(", which is used by ")));
            }
        }
    }
}

impl Texts<'_> {
    /// A hint with the nearest name in the folder of a file that is not there.
    fn neighbour(&self, path: &Path) -> String {
        let names = path.parent().map(|folder| self.texts.names(folder)).unwrap_or_default();
        let wanted = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        match super::diagnostic::nearest(wanted, names.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "paths are relative to the file they stand in".to_string(),
        }
    }
}

fn define(
    node: Node,
    name: ast::Name,
    file: FileId,
    table: &mut HashMap<String, NameDefinition>,
    what: &str,
    report: &mut Vec<Diagnostic>,
) {
    let definition = NameDefinition { file, node: node.index(), span: name.span() };
    match table.get(name.text()) {
        Some(first) => report.push(
            Diagnostic::new(
                Code::DuplicateName,
                name.span(),
                format!("{what} `{}` is defined twice", name.text()),
            )
            .label("defined again")
            .context(first.span, "defined first here")
            .hint("give one of them another name"),
        ),
        None => {
            table.insert(name.text().to_string(), definition);
        }
    }
}

/// Adds the name of a `let` to the scope it stands in.
pub fn bind(node: ast::Binding, scope: &mut NameScope, report: &mut Vec<Diagnostic>) {
    let name = node.name();
    let value = value::evaluate(node.value(), scope, report);
    if let Some(first) = scope.names.get(name.text()) {
        report.push(
            Diagnostic::new(Code::DuplicateName, name.span(), format!("`{}` is defined twice", name.text()))
                .label("defined again")
                .context(first.span, "defined first here")
                .hint("give one of them another name"),
        );
        return;
    }
    scope.names.insert(name.text().to_string(), Binding::new(value, name.span()));
}

/// What is in `registry`, with the controllers that a text, which is being edited and stands for the file at `path`, declares or
/// brings along.
pub fn with_declared(path: &Path, text: &str, registry: &Registry, texts: &dyn files::Files) -> Registry {
    let texts = files::Overlay::new(texts, path, text);
    let mut read = Texts::new(registry, &texts).while_edited();
    read.open(path, None, &mut Vec::new());
    read.registry
}

/// Whether anything in the report is an error.
pub fn has_errors(report: &[Diagnostic]) -> bool {
    report.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
}

/// The file called `name` by a file at `path`, without `.` and `..` where that is possible.
pub fn join(path: &Path, name: &str) -> PathBuf {
    let mut joined = PathBuf::new();
    let folder = path.parent().unwrap_or(Path::new(""));
    for component in folder.join(name).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(joined.components().next_back(), Some(Component::Normal(_))) => {
                joined.pop();
            }
            other => joined.push(other),
        }
    }
    joined
}
