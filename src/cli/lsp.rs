//! `scenario-runner lsp`: the language server, over standard input and output.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use clap::Args;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::{
    CompletionItem, CompletionOptions, CompletionParams, DiagnosticRelatedInformation, DiagnosticSeverity,
    DidChangeTextDocumentParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    DocumentFormattingParams, GotoDefinitionParams, Hover, HoverContents, HoverParams,
    HoverProviderCapability, Location, MarkupContent, MarkupKind, NumberOrString, OneOf, Position,
    PublishDiagnosticsParams, Range, ServerCapabilities, TextDocumentPositionParams,
    TextDocumentSyncCapability, TextDocumentSyncKind, TextEdit, Uri,
};
use serde_json::Value;

use super::{Exit, load};
use crate::lang::{self, Diagnostic, Severity, Sources, Span, Tree};
use crate::report::findings::uri_path;

#[derive(Debug, Args)]
pub struct LspArguments {
    /// What editors pass; standard input and output are used in any case.
    #[arg(long, hide = true)]
    stdio: bool,
}

pub fn lsp(_: &LspArguments) -> Exit {
    let (connection, threads) = Connection::stdio();
    let served = serve(&connection);
    drop(connection);
    match served.and_then(|()| threads.join().map_err(Into::into)) {
        Ok(()) => Exit::Success,
        Err(error) => {
            eprintln!("error: the editor's connection failed: {error}");
            Exit::Output
        }
    }
}

/// Answers until the other side says goodbye.
pub fn serve(connection: &Connection) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let capabilities = ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(vec![" ".to_string(), "{".to_string(), ":".to_string()]),
            ..CompletionOptions::default()
        }),
        definition_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    };
    connection.initialize(serde_json::to_value(capabilities)?)?;
    let mut server = Server { connection, texts: HashMap::new(), shown: HashMap::new() };
    for message in &connection.receiver {
        match message {
            Message::Request(request) => {
                if connection.handle_shutdown(&request)? {
                    break;
                }
                let response = server.answer(request);
                connection.sender.send(Message::Response(response))?;
            }
            Message::Notification(notification) => {
                let method = notification.method.clone();
                if let Err(error) = server.hear(notification) {
                    eprintln!("`{method}` is not understood: {error}");
                }
            }
            Message::Response(_) => {}
        }
    }
    Ok(())
}

struct Server<'a> {
    connection: &'a Connection,
    texts: HashMap<Uri, String>,
    /// The files that a document's findings were last shown in.
    shown: HashMap<Uri, Vec<Uri>>,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

impl Server<'_> {
    fn answer(&self, request: Request) -> Response {
        let result = match request.method.as_str() {
            "textDocument/hover" => self.hover(request.params),
            "textDocument/completion" => self.completion(request.params),
            "textDocument/definition" => self.definition(request.params),
            "textDocument/formatting" => self.formatting(request.params),
            method => {
                let message = format!("`{method}` is not known");
                return Response::new_err(request.id, ErrorCode::MethodNotFound as i32, message);
            }
        };
        match result {
            Ok(value) => Response::new_ok(request.id, value),
            Err(error) => Response::new_err(request.id, ErrorCode::InvalidParams as i32, error.to_string()),
        }
    }

    fn hear(&mut self, notification: Notification) -> Result<(), Failure> {
        match notification.method.as_str() {
            "textDocument/didOpen" => {
                let opened: DidOpenTextDocumentParams = serde_json::from_value(notification.params)?;
                self.texts.insert(opened.text_document.uri.clone(), opened.text_document.text);
                self.publish(&opened.text_document.uri)
            }
            "textDocument/didChange" => {
                let changed: DidChangeTextDocumentParams = serde_json::from_value(notification.params)?;
                if let Some(change) = changed.content_changes.into_iter().next_back() {
                    self.texts.insert(changed.text_document.uri.clone(), change.text);
                }
                self.publish(&changed.text_document.uri)
            }
            "textDocument/didClose" => {
                let closed: DidCloseTextDocumentParams = serde_json::from_value(notification.params)?;
                self.texts.remove(&closed.text_document.uri);
                for uri in self.shown.remove(&closed.text_document.uri).unwrap_or_default() {
                    self.show(uri, Vec::new())?;
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Checks a document and shows what was found, in it and in the files that it uses.
    fn publish(&mut self, uri: &Uri) -> Result<(), Failure> {
        let (Some(text), Some(path)) = (self.texts.get(uri), path_of(uri)) else { return Ok(()) };
        let (found, sources) = load::examine(&path, Some(text));
        let mut by_file: BTreeMap<String, Vec<lsp_types::Diagnostic>> = BTreeMap::new();
        for diagnostic in &found {
            let name = sources.get(diagnostic.span().source).name.clone();
            by_file.entry(name).or_default().push(shown(diagnostic, &sources));
        }
        let mut fresh = Vec::new();
        let own = path.display().to_string();
        by_file.entry(own.clone()).or_default();
        for (name, diagnostics) in by_file {
            let target = if name == own { Some(uri.clone()) } else { uri_of(&name) };
            if let Some(target) = target {
                self.show(target.clone(), diagnostics)?;
                fresh.push(target);
            }
        }
        for stale in self.shown.insert(uri.clone(), fresh.clone()).unwrap_or_default() {
            if !fresh.contains(&stale) {
                self.show(stale, Vec::new())?;
            }
        }
        Ok(())
    }

    fn show(&self, uri: Uri, diagnostics: Vec<lsp_types::Diagnostic>) -> Result<(), Failure> {
        let parameters = PublishDiagnosticsParams { uri, diagnostics, version: None };
        let notification = Notification::new("textDocument/publishDiagnostics".to_string(), parameters);
        Ok(self.connection.sender.send(Message::Notification(notification))?)
    }

    fn text(&self, uri: &Uri) -> &str {
        self.texts.get(uri).map_or("", String::as_str)
    }

    fn place(&self, place: &TextDocumentPositionParams) -> (&str, usize) {
        let text = self.text(&place.text_document.uri);
        (text, offset_of(text, place.position))
    }

    fn hover(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: HoverParams = serde_json::from_value(parameters)?;
        let (text, offset) = self.place(&parameters.text_document_position_params);
        let (tree, _) = Tree::parse(Sources::default().add("", ""), text.into());
        let hover = lang::hover(&tree, offset).map(|(span, value)| Hover {
            contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value }),
            range: Some(range_of(text, span)),
        });
        Ok(serde_json::to_value(hover)?)
    }

    fn completion(&self, parameters: Value) -> Result<Value, Failure> {
        let parameters: CompletionParams = serde_json::from_value(parameters)?;
        let (text, offset) = self.place(&parameters.text_document_position);
        let path = path_of(&parameters.text_document_position.text_document.uri).unwrap_or_default();
        let items: Vec<CompletionItem> = lang::complete(&path, text, offset)
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
        let location = lang::definition(&path, text, offset).and_then(|(span, sources)| {
            let source = sources.get(span.source);
            Some(Location { uri: uri_of(&source.name)?, range: range_of(&source.text, span) })
        });
        Ok(serde_json::to_value(location)?)
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

fn range_of(text: &str, span: Span) -> Range {
    Range { start: position_of(text, span.start), end: position_of(text, span.end) }
}

/// Lines from 0, columns in UTF-16 units, as the protocol wants them.
fn position_of(text: &str, offset: usize) -> Position {
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = before.matches('\n').count() as u32;
    Position { line, character: before[line_start..].encode_utf16().count() as u32 }
}

fn offset_of(text: &str, position: Position) -> usize {
    let line_start = match position.line {
        0 => 0,
        line => match text.match_indices('\n').nth(line as usize - 1) {
            Some((at, _)) => at + 1,
            None => return text.len(),
        },
    };
    let mut units = position.character as usize;
    for (at, character) in text[line_start..].char_indices() {
        if units == 0 || character == '\n' {
            return line_start + at;
        }
        units = units.saturating_sub(character.len_utf16());
    }
    text.len()
}

/// The path of a `file:` address.
fn path_of(uri: &Uri) -> Option<PathBuf> {
    let encoded = uri.as_str().strip_prefix("file://")?;
    let mut bytes = Vec::with_capacity(encoded.len());
    let mut rest = encoded.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped =
            tail.get(..2).filter(|_| *first == b'%').and_then(|digits| std::str::from_utf8(digits).ok());
        match escaped.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok().map(PathBuf::from)
}

fn uri_of(name: &str) -> Option<Uri> {
    let path = std::path::absolute(name).ok()?;
    format!("file://{}", uri_path(path.to_str()?)).parse().ok()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn request(id: i32, method: &str, parameters: Value) -> Message {
        Message::Request(Request::new(id.into(), method.to_string(), parameters))
    }

    fn notification(method: &str, parameters: Value) -> Message {
        Message::Notification(Notification::new(method.to_string(), parameters))
    }

    #[test]
    fn a_client_gets_findings_hover_completion_definition_and_format() {
        let (server, client) = Connection::memory();
        let serving = std::thread::spawn(move || serve(&server).map_err(|error| error.to_string()));
        let uri = "file:///nowhere/a%20b.scn";
        let text =
            "let pace = 3 m/s\nscenario a {\n  vehicle av { speed  pace; controller carla_behavior }\n}\n";
        let at = |line: u32, character: u32| json!({ "textDocument": { "uri": uri }, "position": { "line": line, "character": character } });
        let options =
            json!({ "textDocument": { "uri": uri }, "options": { "tabSize": 2, "insertSpaces": true } });
        for message in [
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
        ] {
            client.sender.send(message).unwrap();
        }
        let mut answers = HashMap::new();
        for message in &client.receiver {
            match message {
                Message::Response(response) => {
                    let id = response.id.to_string();
                    answers.insert(id.clone(), serde_json::to_value(&response).unwrap()["result"].clone());
                    if id == "6" {
                        break;
                    }
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
        serving.join().unwrap().unwrap();
    }

    #[test]
    fn places_count_in_utf16() {
        let text = "a\n😀b\n";
        assert_eq!(position_of(text, 6), Position { line: 1, character: 2 });
        assert_eq!(offset_of(text, Position { line: 1, character: 2 }), 6);
        assert_eq!(offset_of(text, Position { line: 9, character: 0 }), text.len());
    }
}
