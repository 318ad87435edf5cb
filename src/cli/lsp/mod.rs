//! `scenario-runner lsp`: the language server, over standard input and output.

mod actions;
mod document;
mod frame;
mod last_run;
mod lenses;
mod marks;
mod names;
mod workspace;

use std::collections::{BTreeMap, HashMap};
use std::io::{self, BufRead, BufReader, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use clap::Args;
use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::{
    CodeActionParams, CodeLensParams, CompletionItem, CompletionOptions, CompletionParams,
    DiagnosticRelatedInformation, DiagnosticSeverity, DidChangeTextDocumentParams,
    DidCloseTextDocumentParams, DidOpenTextDocumentParams, DocumentFormattingParams, GotoDefinitionParams,
    Hover, HoverContents, HoverParams, HoverProviderCapability, InlayHintParams, Location, MarkupContent,
    MarkupKind, MessageType, NumberOrString, OneOf, Position, PublishDiagnosticsParams, Range,
    ReferenceParams, RenameParams, SemanticTokensParams, ServerCapabilities, ShowMessageParams,
    TextDocumentPositionParams, TextDocumentSyncCapability, TextDocumentSyncKind, TextEdit, Uri,
    WorkspaceSymbolParams,
};
use serde_json::{Value, json};

use super::Exit;
use document::{Document, changed, offset_of, path_of, position_of, range_of, uri_of};
use files::{Disk, Overlay};
use frame::Frame;
use lang::{self, Code, Diagnostic, Severity, Sources, Tree};
use last_run::{LastResults, TextsNow};
use lenses::Shown;
use names::{AskedName, Refused};
use report::Sketch;
use report::console::{stderr, stdout};
use runner::plan::plan_scenario;
use runner::project::examine_edited;
use scenario::registry::Registry;
use workspace::Workspace;

#[derive(Debug, Args)]
pub struct LspArguments {
    /// What editors pass; standard input and output are used in any case.
    #[arg(long, hide = true)]
    stdio: bool,
}

/// How long after `shutdown` an editor may take to say `exit`.
const PATIENCE: Duration = Duration::from_secs(2);

#[expect(
    clippy::disallowed_methods,
    reason = "the editor's messages are no file: they are read as they come, each bounded"
)]
pub fn lsp(_: &LspArguments, registry: &Registry) -> Exit {
    match serve(BufReader::new(io::stdin()), Answers, registry) {
        Ok(Farewell::Proper | Farewell::Closed) => Exit::Success,
        Ok(Farewell::Abrupt) => Exit::Output,
        // The editor has gone, or the program says in the end what happened.
        Err(_) if stdout().is_broken() => Exit::Success,
        Err(error) => {
            writeln!(stderr(), "error: the editor's connection failed: {error}");
            Exit::Output
        }
    }
}

/// Standard output, as what frames are written to.
struct Answers;

impl Write for Answers {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Headers and JSON, written in whole pieces of text.
        let text =
            std::str::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
        stdout().verbatim(text);
        if stdout().is_broken() { Err(io::ErrorKind::BrokenPipe.into()) } else { Ok(bytes.len()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        stdout().flush();
        if stdout().is_broken() { Err(io::ErrorKind::BrokenPipe.into()) } else { Ok(()) }
    }
}

/// How a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Farewell {
    /// With `shutdown`.
    Proper,
    /// With `exit` alone, which the protocol wants to be told from the proper way.
    Abrupt,
    /// The input ended between two messages.
    Closed,
}

/// Answers until the other side says goodbye or is gone. One message is read ahead while another is answered; no more
/// are kept.
fn serve(
    input: impl BufRead + Send + 'static,
    output: impl Write,
    registry: &Registry,
) -> io::Result<Farewell> {
    let frames = frames(input);
    let mut server = Server {
        output,
        registry,
        documents: HashMap::new(),
        shown: HashMap::new(),
        last_shown: HashMap::new(),
        workspace: Workspace::default(),
        runs: LastResults::default(),
    };
    let mut phase = Phase::New;
    loop {
        let next = match phase {
            Phase::Leaving => frames.recv_timeout(PATIENCE),
            Phase::New | Phase::Open => frames.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        let gone = if phase == Phase::Leaving { Farewell::Proper } else { Farewell::Closed };
        let message = match next {
            Err(_) => return Ok(gone),
            Ok(frame) => match frame? {
                Frame::Message(message) => message,
                Frame::Malformed(why) => {
                    server.refuse_malformed(&why)?;
                    continue;
                }
                Frame::TooLarge(size) => {
                    let text =
                        format!("a message of {size} bytes was passed over: so large a text is not checked");
                    server.warn(text)?;
                    continue;
                }
            },
        };
        match message {
            Message::Request(request) => {
                let response = match (phase, request.method.as_str()) {
                    (Phase::New, "initialize") => {
                        phase = Phase::Open;
                        server.workspace = Workspace::new(&request.params);
                        Response::new_ok(request.id, json!({ "capabilities": capabilities() }))
                    }
                    (Phase::New, _) => {
                        let code = ErrorCode::ServerNotInitialized as i32;
                        Response::new_err(request.id, code, "`initialize` comes first".to_string())
                    }
                    (Phase::Open, "shutdown") => {
                        phase = Phase::Leaving;
                        Response::new_ok(request.id, Value::Null)
                    }
                    (Phase::Open, "initialize") => refused(request, "is said once"),
                    (Phase::Leaving, _) => refused(request, "comes after `shutdown`"),
                    (Phase::Open, _) => server.answer(request),
                };
                server.send(Message::Response(response))?;
            }
            Message::Notification(notification) if notification.method == "exit" => {
                return Ok(if phase == Phase::Leaving { Farewell::Proper } else { Farewell::Abrupt });
            }
            Message::Notification(notification) if phase == Phase::Open => server.hear(notification)?,
            Message::Notification(_) | Message::Response(_) => {}
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    New,
    Open,
    Leaving,
}

/// Reads on a thread of its own, so that nobody waits for ever for an `exit` that does not come.
fn frames(mut input: impl BufRead + Send + 'static) -> Receiver<io::Result<Frame>> {
    let (sender, receiver) = mpsc::sync_channel(0);
    thread::spawn(move || {
        while let Some(frame) = frame::read(&mut input).transpose() {
            let lost = frame.is_err();
            if sender.send(frame).is_err() || lost {
                break;
            }
        }
    });
    receiver
}

fn refused(request: Request, why: &str) -> Response {
    let message = format!("`{}` {why}", request.method);
    Response::new_err(request.id, ErrorCode::InvalidRequest as i32, message)
}

/// Some of them in JSON, since the types of the protocol have many members that are not there.
fn capabilities() -> Value {
    let older = ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(vec![" ".to_string(), "{".to_string(), ":".to_string()]),
            ..CompletionOptions::default()
        }),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        workspace_symbol_provider: Some(OneOf::Left(true)),
        inlay_hint_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    };
    let mut all = json!(older);
    all["renameProvider"] = json!({ "prepareProvider": true });
    all["semanticTokensProvider"] = json!({ "legend": marks::legend(), "full": true });
    all["codeActionProvider"] = json!({ "codeActionKinds": ["quickfix"] });
    all["codeLensProvider"] = json!({});
    all
}

struct Server<'r, W> {
    registry: &'r Registry,
    output: W,
    documents: HashMap<Uri, Document>,
    /// The files that a document's findings were last shown in.
    shown: HashMap<Uri, Vec<Uri>>,
    /// What the last run found in each document, as it is shown.
    last_shown: HashMap<Uri, Vec<lsp_types::Diagnostic>>,
    workspace: Workspace,
    runs: LastResults,
}

/// A request of our own: a place in a document, answered by the `name` and the `svg` of the scenario there, or by a `message`.
const SKETCH: &str = "scenario-runner/sketch";

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What a panic leaves of an answer.
const BUG: &str = "scenario-runner could not answer: a bug of ours";

impl<W: Write> Server<'_, W> {
    fn send(&mut self, message: Message) -> io::Result<()> {
        message.write(&mut self.output)
    }

    fn notify(&mut self, method: &str, parameters: impl serde::Serialize) -> io::Result<()> {
        self.send(Message::Notification(Notification::new(method.to_string(), parameters)))
    }

    fn warn(&mut self, message: String) -> io::Result<()> {
        self.notify("window/showMessage", ShowMessageParams { typ: MessageType::WARNING, message })
    }

    /// An error without the number of a request, as there is none to be read.
    fn refuse_malformed(&mut self, why: &str) -> io::Result<()> {
        let error = json!({ "code": ErrorCode::ParseError as i32, "message": why });
        let text = json!({ "jsonrpc": "2.0", "id": null, "error": error }).to_string();
        write!(self.output, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        self.output.flush()
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let result = catch_unwind(AssertUnwindSafe(|| match method.as_str() {
            "textDocument/hover" => Some(self.hover(params)),
            "textDocument/completion" => Some(self.completion(params)),
            "textDocument/definition" => Some(self.definition(params)),
            "textDocument/formatting" => Some(self.formatting(params)),
            "textDocument/references" => Some(self.references(params)),
            "textDocument/prepareRename" => Some(self.prepare_rename(params)),
            "textDocument/rename" => Some(self.rename(params)),
            "textDocument/inlayHint" => Some(self.inlay_hints(params)),
            "textDocument/semanticTokens/full" => Some(self.semantic_tokens(params)),
            "textDocument/codeAction" => Some(self.code_actions(params)),
            "textDocument/codeLens" => Some(self.code_lenses(params)),
            "workspace/symbol" => Some(self.symbols(params)),
            SKETCH => Some(self.sketch(params)),
            _ => None,
        }));
        match result {
            Ok(Some(Ok(value))) => Response::new_ok(id, value),
            Ok(Some(Err(error))) => {
                let is_refused = error.is::<Refused>();
                let code = if is_refused { ErrorCode::RequestFailed } else { ErrorCode::InvalidParams };
                Response::new_err(id, code as i32, error.to_string())
            }
            Ok(None) => {
                Response::new_err(id, ErrorCode::MethodNotFound as i32, format!("`{method}` is not known"))
            }
            Err(_) => Response::new_err(id, ErrorCode::InternalError as i32, BUG.to_string()),
        }
    }

    /// # Errors
    /// Only of the connection: what is not understood is said on stderr and forgotten.
    fn hear(&mut self, notification: Notification) -> io::Result<()> {
        let Notification { method, params } = notification;
        let heard = match method.as_str() {
            "textDocument/didOpen" => serde_json::from_value(params).map(|opened| self.open(opened)),
            "textDocument/didChange" => serde_json::from_value(params).map(|changed| self.change(changed)),
            "textDocument/didClose" => serde_json::from_value(params).map(|closed| self.close(&closed)),
            // Files changed beside the editor, results among them.
            "workspace/didChangeWatchedFiles" => Ok(self.publish_all()),
            _ => Ok(Ok(())),
        };
        heard.unwrap_or_else(|error| {
            writeln!(stderr(), "`{method}` is not understood: {error}");
            Ok(())
        })
    }

    fn open(&mut self, opened: DidOpenTextDocumentParams) -> io::Result<()> {
        let document = opened.text_document;
        self.keep(document.uri, document.version, document.text)
    }

    /// A document that is not open, or a text older than the one that is known, changes nothing.
    fn change(&mut self, change: DidChangeTextDocumentParams) -> io::Result<()> {
        let (uri, version) = (change.text_document.uri, change.text_document.version);
        let Some(known) = self.documents.get_mut(&uri).filter(|known| version >= known.version) else {
            return Ok(());
        };
        let whole = change.content_changes.iter().any(|change| change.range.is_none());
        if known.refused.is_some() && !whole {
            known.version = version;
            return Ok(());
        }
        let text = changed(std::mem::take(&mut known.text), change.content_changes);
        self.keep(uri, version, text)
    }

    fn keep(&mut self, uri: Uri, version: i32, text: String) -> io::Result<()> {
        self.documents.remove(&uri);
        if self.documents.len() >= document::MOST {
            return self
                .warn(format!("more than {} documents are open: others are not checked", document::MOST));
        }
        let kept: usize = self.documents.values().map(|document| document.text.len()).sum();
        let document = Document::new(version, text, document::LARGEST_TOGETHER - kept);
        self.documents.insert(uri.clone(), document);
        self.publish(&uri)?;
        self.publish_resting_on(&uri)
    }

    fn close(&mut self, closed: &DidCloseTextDocumentParams) -> io::Result<()> {
        self.documents.remove(&closed.text_document.uri);
        self.last_shown.remove(&closed.text_document.uri);
        self.publish_resting_on(&closed.text_document.uri)?;
        for uri in self.shown.remove(&closed.text_document.uri).unwrap_or_default() {
            self.show(uri, None, Vec::new())?;
        }
        Ok(())
    }

    fn publish_all(&mut self) -> io::Result<()> {
        let all: Vec<Uri> = self.documents.keys().cloned().collect();
        all.iter().try_for_each(|uri| self.publish(uri))
    }

    /// Checks a document and shows what was found, in it and in the files that it uses.
    fn publish(&mut self, uri: &Uri) -> io::Result<()> {
        let (Some(document), Some(path)) = (self.documents.get(uri), path_of(uri)) else { return Ok(()) };
        let version = Some(document.version);
        let own = path.display().to_string();
        let mut by_file: BTreeMap<String, Vec<lsp_types::Diagnostic>> = BTreeMap::new();
        if let Some(why) = &document.refused {
            by_file.insert(own.clone(), vec![at_the_beginning(Code::FileTooLarge.name(), why)]);
        } else {
            match catch_unwind(AssertUnwindSafe(|| {
                examine_edited(&path, &document.text, self.registry, &Disk)
            })) {
                Ok((found, sources)) => {
                    for diagnostic in &found {
                        let name = sources.get(diagnostic.span().source).name.clone();
                        by_file.entry(name).or_default().push(shown(diagnostic, &sources));
                    }
                }
                Err(_) => _ = by_file.insert(own.clone(), vec![at_the_beginning("bug", BUG)]),
            }
        }
        let last = self.last_findings(uri);
        by_file.entry(own.clone()).or_default().extend(last.iter().cloned());
        self.last_shown.insert(uri.clone(), last);
        let mut fresh = Vec::new();
        for (name, diagnostics) in by_file {
            let is_own = name == own;
            let target = if is_own { Some(uri.clone()) } else { uri_of(&name) };
            if let Some(target) = target {
                self.show(target.clone(), version.filter(|_| is_own), diagnostics)?;
                fresh.push(target);
            }
        }
        for stale in self.shown.insert(uri.clone(), fresh.clone()).unwrap_or_default() {
            if !fresh.contains(&stale) {
                self.show(stale, None, Vec::new())?;
            }
        }
        Ok(())
    }

    /// What the last run found in a document, as of the texts that are open now.
    fn last_findings(&self, uri: &Uri) -> Vec<lsp_types::Diagnostic> {
        let (Some(document), Some(path)) = (self.documents.get(uri), path_of(uri)) else { return Vec::new() };
        let files = self.files();
        let shown = Shown {
            path: &path,
            text: &document.text,
            workspace: &self.workspace,
            runs: &self.runs,
            texts: TextsNow::new(&files),
        };
        catch_unwind(AssertUnwindSafe(|| lenses::findings(&shown))).unwrap_or_default()
    }

    /// Shows other documents again whose findings of the last run rest on a text that has changed, saved or not.
    fn publish_resting_on(&mut self, changed: &Uri) -> io::Result<()> {
        let others = self.documents.keys().filter(|uri| *uri != changed);
        let outdated = |uri: &&Uri| {
            let shown = self.last_shown.get(*uri);
            shown.is_some_and(|shown| !shown.is_empty() && *shown != self.last_findings(uri))
        };
        let outdated: Vec<Uri> = others.filter(outdated).cloned().collect();
        outdated.iter().try_for_each(|uri| self.publish(uri))
    }

    fn show(
        &mut self,
        uri: Uri,
        version: Option<i32>,
        diagnostics: Vec<lsp_types::Diagnostic>,
    ) -> io::Result<()> {
        self.notify("textDocument/publishDiagnostics", PublishDiagnosticsParams { uri, diagnostics, version })
    }

    fn text(&self, uri: &Uri) -> &str {
        self.documents.get(uri).map_or("", |document| document.text.as_str())
    }

    fn place(&self, place: &TextDocumentPositionParams) -> (&str, usize) {
        let text = self.text(&place.text_document.uri);
        (text, offset_of(text, place.position))
    }

    fn hover(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: HoverParams = serde_json::from_value(parameters)?;
        let (text, offset) = self.place(&parameters.text_document_position_params);
        let (tree, _) = Tree::parse(Sources::default().add("", ""), text.into());
        let uri = &parameters.text_document_position_params.text_document.uri;
        let registry = lang::with_declared(&path_of(uri).unwrap_or_default(), text, self.registry, &Disk);
        let hover = lang::hover(&tree, offset, &registry).map(|(span, value)| Hover {
            contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value }),
            range: Some(range_of(text, span)),
        });
        Ok(serde_json::to_value(hover)?)
    }

    fn completion(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: CompletionParams = serde_json::from_value(parameters)?;
        let (text, offset) = self.place(&parameters.text_document_position);
        let path = path_of(&parameters.text_document_position.text_document.uri).unwrap_or_default();
        let items: Vec<CompletionItem> = lang::complete(&path, text, offset, self.registry, &Disk)
            .into_iter()
            .map(|found| CompletionItem {
                label: found.word,
                detail: Some(found.detail),
                ..CompletionItem::default()
            })
            .collect();
        Ok(serde_json::to_value(items)?)
    }

    fn definition(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: GotoDefinitionParams = serde_json::from_value(parameters)?;
        let place = &parameters.text_document_position_params;
        let (text, offset) = self.place(place);
        let Some(path) = path_of(&place.text_document.uri) else { return Ok(Value::Null) };
        let location =
            lang::definition(&path, text, offset, self.registry, &Disk).and_then(|(span, sources)| {
                let source = sources.get(span.source);
                Some(Location { uri: uri_of(&source.name)?, range: range_of(&source.text, span) })
            });
        Ok(serde_json::to_value(location)?)
    }

    /// The first run of the scenario at a place, drawn without running it.
    fn sketch(&self, parameters: Value) -> Result<Value, Failure> {
        let place: TextDocumentPositionParams = serde_json::from_value(parameters)?;
        let Some(path) = path_of(&place.text_document.uri) else { return Ok(Value::Null) };
        let text = self.text(&place.text_document.uri);
        let drawn = drawn_at(&path, text, place.position.line as usize + 1, self.registry);
        Ok(drawn.map_or_else(
            |message| json!({ "message": message }),
            |(name, svg)| json!({ "name": name, "svg": svg }),
        ))
    }

    /// The disk, with the texts of open documents for their files.
    fn files(&self) -> Overlay<'_> {
        let kept = self.documents.iter().filter(|(_, document)| document.refused.is_none());
        let texts = kept.filter_map(|(uri, document)| Some((path_of(uri)?, document.text.as_str())));
        texts.fold(Overlay::of(&Disk), |files, (path, text)| files.with(&path, text))
    }

    fn references(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: ReferenceParams = serde_json::from_value(parameters)?;
        let with_definitions = parameters.context.include_declaration;
        let found = self.asked(&parameters.text_document_position, true, |asked, _| {
            names::references(asked, with_definitions)
        });
        Ok(serde_json::to_value(found?)?)
    }

    fn prepare_rename(&self, parameters: Value) -> Result<Value, Failure> {
        let place: TextDocumentPositionParams = serde_json::from_value(parameters)?;
        Ok(self.asked(&place, false, names::rename_place)?)
    }

    fn rename(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: RenameParams = serde_json::from_value(parameters)?;
        Ok(self.asked(&parameters.text_document_position, true, |asked, _| {
            names::rename(asked, &parameters.new_name, &self.workspace)
        })?)
    }

    /// Answers about the name at a place, with all files where it may stand besides if those are `wanted`.
    fn asked<T>(
        &self,
        place: &TextDocumentPositionParams,
        wanted: bool,
        answer: impl FnOnce(&AskedName, &str) -> Result<T, Refused>,
    ) -> Result<T, Refused> {
        let path = path_of(&place.text_document.uri).ok_or_else(|| Refused("it is no file".to_string()))?;
        let (text, offset) = self.place(place);
        let (others, all) = if wanted { self.workspace.files(&path) } else { (Vec::new(), true) };
        if !all {
            return Err(Refused("the folder has so many files that not all are gone through".to_string()));
        }
        let files = self.files();
        let (others, registry) = (others.as_slice(), self.registry);
        answer(&AskedName { path: &path, offset, others, registry, files: &files }, text)
    }

    fn symbols(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: WorkspaceSymbolParams = serde_json::from_value(parameters)?;
        let (paths, _) = self.workspace.files(Path::new(""));
        Ok(json!(names::symbols(&parameters.query, &paths, self.registry, &self.files())))
    }

    fn inlay_hints(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: InlayHintParams = serde_json::from_value(parameters)?;
        let uri = &parameters.text_document.uri;
        let Some(path) = path_of(uri) else { return Ok(json!([])) };
        Ok(json!(marks::inlay_hints(&path, self.text(uri), parameters.range, self.registry, &self.files())))
    }

    fn semantic_tokens(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: SemanticTokensParams = serde_json::from_value(parameters)?;
        let uri = &parameters.text_document.uri;
        let Some(path) = path_of(uri) else { return Ok(json!({ "data": [] })) };
        Ok(marks::semantic_tokens(&path, self.text(uri), self.registry, &self.files()))
    }

    fn code_actions(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: CodeActionParams = serde_json::from_value(parameters)?;
        let uri = &parameters.text_document.uri;
        let Some(path) = path_of(uri) else { return Ok(json!([])) };
        Ok(json!(actions::code_actions(&path, self.text(uri), &parameters, self.registry, &self.files())))
    }

    fn code_lenses(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: CodeLensParams = serde_json::from_value(parameters)?;
        let uri = &parameters.text_document.uri;
        let Some(path) = path_of(uri) else { return Ok(json!([])) };
        let (text, files) = (self.text(uri), self.files());
        let shown = Shown {
            path: &path,
            text,
            workspace: &self.workspace,
            runs: &self.runs,
            texts: TextsNow::new(&files),
        };
        Ok(json!(lenses::code_lenses(&shown)))
    }

    fn formatting(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: DocumentFormattingParams = serde_json::from_value(parameters)?;
        let text = self.text(&parameters.text_document.uri);
        let has_style = !path_of(&parameters.text_document.uri).is_some_and(|path| is_yaml(&path));
        let formatted = lang::format(Sources::default().add("", ""), text).ok().filter(|_| has_style);
        let edits = formatted.map(|new_text| {
            let range = Range { start: Position::default(), end: position_of(text, text.len()) };
            vec![TextEdit { range, new_text }]
        });
        Ok(serde_json::to_value(edits)?)
    }
}

/// Key and picture of the first run of the scenario in whose text a line is, else of the first that there is.
fn drawn_at(path: &Path, text: &str, line: usize, registry: &Registry) -> Result<(String, String), String> {
    let examined = lang::examine_edited(path, text, registry, &Disk);
    let suite = examined.suite.ok_or("the text has errors, so that there is nothing to draw")?;
    let own = path.display().to_string();
    let before = suite.scenarios.iter().filter(|one| *one.origin.file == *own && one.origin.line <= line);
    let at = before.max_by_key(|one| one.origin.line).or(suite.scenarios.first());
    let scenario = at.ok_or("there is no scenario to draw")?;
    let planned = plan_scenario(&suite, scenario).map_err(|error| error.to_string())?;
    let mut trials = planned.trials().filter(|trial| !trial.cases.is_empty());
    let case = trials.next().map(|trial| trial.cases.get(0)).ok_or("it has no runs")?;
    Ok((case.key.clone(), Sketch::of(&case).to_svg()))
}

fn shown(diagnostic: &Diagnostic, sources: &Sources) -> lsp_types::Diagnostic {
    let span = diagnostic.span();
    let message: Vec<&str> = std::iter::once(&diagnostic.message)
        .chain(&diagnostic.notes)
        .chain(&diagnostic.hints)
        .map(String::as_str)
        .collect();
    let related = diagnostic.labels[1..].iter().filter_map(|label| {
        let source = sources.get(label.span.source);
        let location = Location { uri: uri_of(&source.name)?, range: range_of(&source.text, label.span) };
        Some(DiagnosticRelatedInformation { location, message: label.text.clone() })
    });
    lsp_types::Diagnostic {
        range: range_of(&sources.get(span.source).text, span),
        severity: Some(match diagnostic.severity {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
        }),
        code: Some(NumberOrString::String(diagnostic.code.name().to_string())),
        source: Some("scenario-runner".to_string()),
        message: message.join("\n"),
        related_information: Some(related.collect()),
        ..lsp_types::Diagnostic::default()
    }
}

/// YAML has no one style.
fn is_yaml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml")
}

/// A finding about a text as a whole.
fn at_the_beginning(code: &str, message: &str) -> lsp_types::Diagnostic {
    lsp_types::Diagnostic {
        range: Range::default(),
        severity: Some(DiagnosticSeverity::WARNING),
        code: Some(NumberOrString::String(code.to_string())),
        source: Some("scenario-runner".to_string()),
        message: message.to_string(),
        ..lsp_types::Diagnostic::default()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use models::standard;

    fn request(id: i32, method: &str, parameters: Value) -> Message {
        Message::Request(Request::new(id.into(), method.to_string(), parameters))
    }

    fn notification(method: &str, parameters: Value) -> Message {
        Message::Notification(Notification::new(method.to_string(), parameters))
    }

    /// What comes of messages after which the input ends.
    fn session(messages: &[Message]) -> (io::Result<Farewell>, Vec<Message>) {
        let mut input = Vec::new();
        messages.iter().for_each(|message| message.write(&mut input).unwrap());
        let mut output = Vec::new();
        let farewell = serve(io::Cursor::new(input), &mut output, &standard());
        let mut rest = output.as_slice();
        (farewell, std::iter::from_fn(|| Message::read(&mut rest).unwrap()).collect())
    }

    #[test]
    fn a_client_gets_findings_hover_completion_definition_and_format() {
        let uri = "file:///nowhere/a%20b.scn";
        let text =
            "let pace = 3 m/s\nscenario a {\n  vehicle av { speed  pace; controller carla_behavior }\n}\n";
        let at = |line: u32, character: u32| json!({ "textDocument": { "uri": uri }, "position": { "line": line, "character": character } });
        let options =
            json!({ "textDocument": { "uri": uri }, "options": { "tabSize": 2, "insertSpaces": true } });
        let (farewell, messages) = session(&[
            request(1, "initialize", json!({ "capabilities": {} })),
            notification("initialized", json!({})),
            notification(
                "textDocument/didOpen",
                json!({ "textDocument": { "uri": uri, "languageId": "scn", "version": 1, "text": text } }),
            ),
            request(2, "textDocument/hover", at(2, 42)),
            request(3, "textDocument/completion", at(2, 15)),
            request(4, "textDocument/definition", at(2, 23)),
            request(5, "textDocument/formatting", options),
            request(6, "shutdown", Value::Null),
            notification("exit", Value::Null),
        ]);
        assert_eq!(farewell.unwrap(), Farewell::Proper);
        let mut answers = HashMap::new();
        for message in messages {
            match message {
                Message::Response(response) => {
                    let answer = serde_json::to_value(&response).unwrap()["result"].clone();
                    answers.insert(response.id.to_string(), answer);
                }
                Message::Notification(found) => {
                    assert_eq!(found.method, "textDocument/publishDiagnostics");
                    let codes: Vec<_> = found.params["diagnostics"]
                        .as_array()
                        .unwrap()
                        .iter()
                        .map(|one| one["code"].clone())
                        .collect();
                    assert_eq!(codes, ["E0501"]);
                }
                Message::Request(_) => {}
            }
        }
        assert!(answers["2"]["contents"]["value"].as_str().unwrap().starts_with("**carla_behavior**"));
        assert!(answers["3"].as_array().unwrap().iter().any(|item| item["label"] == "controller"));
        assert_eq!(answers["4"]["range"]["start"], json!({ "line": 0, "character": 4 }));
        assert!(
            answers["5"][0]["newText"]
                .as_str()
                .unwrap()
                .contains("{ speed pace; controller carla_behavior }")
        );
    }

    /// The errors' codes among what was answered.
    fn codes(messages: &[Message]) -> Vec<i64> {
        let errors = messages.iter().filter_map(|message| match message {
            Message::Response(response) => serde_json::to_value(response).unwrap()["error"]["code"].as_i64(),
            _ => None,
        });
        errors.collect()
    }

    #[test]
    fn each_phase_has_its_requests_and_every_end_its_name() {
        let initialize = |id| request(id, "initialize", json!({ "capabilities": {} }));
        let (shutdown, exit) = (request(9, "shutdown", Value::Null), notification("exit", Value::Null));
        let hover = || request(5, "textDocument/hover", json!({}));
        for (messages, expected, refusals) in [
            (vec![], Farewell::Closed, vec![]),
            (vec![hover(), shutdown.clone()], Farewell::Closed, vec![-32002, -32002]),
            (vec![exit.clone()], Farewell::Abrupt, vec![]),
            (vec![initialize(1), initialize(2), exit.clone()], Farewell::Abrupt, vec![-32600]),
            (vec![initialize(1), shutdown.clone(), hover(), exit.clone()], Farewell::Proper, vec![-32600]),
            (vec![initialize(1), shutdown], Farewell::Proper, vec![]),
        ] {
            let (farewell, answers) = session(&messages);
            assert_eq!((farewell.unwrap(), codes(&answers)), (expected, refusals), "{messages:?}");
        }
    }
}
