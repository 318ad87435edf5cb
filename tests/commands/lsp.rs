//! The language server as an editor meets it: the program, over its standard input and output.

use std::collections::HashMap;
use std::io::{BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use lsp_server::{Message, Notification, Request};
use serde_json::{Value, json};

/// An editor with the server that it started.
pub struct Editor {
    server: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    requests: i32,
    /// The last findings shown for each address.
    pub findings: HashMap<String, Vec<Value>>,
}

impl Editor {
    pub fn start() -> Self {
        Self::start_with(json!({ "capabilities": {} }))
    }

    /// As an editor does that says more of itself.
    pub fn start_with(parameters: Value) -> Self {
        let mut server = Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
            .args(["lsp", "--stdio"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let to = server.stdin.take().unwrap();
        let from = BufReader::new(server.stdout.take().unwrap());
        let mut editor = Self { server, to, from, requests: 0, findings: HashMap::new() };
        let able = editor.ask("initialize", parameters)["capabilities"].clone();
        for ability in [
            "hoverProvider",
            "completionProvider",
            "definitionProvider",
            "documentFormattingProvider",
            "referencesProvider",
            "renameProvider",
            "workspaceSymbolProvider",
            "inlayHintProvider",
            "semanticTokensProvider",
            "codeActionProvider",
            "codeLensProvider",
        ] {
            assert!(!able[ability].is_null(), "{able}");
        }
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: Message) {
        message.write(&mut self.to).unwrap();
        self.to.flush().unwrap();
    }

    pub fn tell(&mut self, method: &str, parameters: Value) {
        self.send(Message::Notification(Notification::new(method.to_string(), parameters)));
    }

    /// The answer, or the error in its place.
    pub fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.requests += 1;
        let id = self.requests.into();
        self.send(Message::Request(Request::new(id, method.to_string(), parameters)));
        loop {
            match Message::read(&mut self.from).unwrap().expect("the server answers") {
                Message::Response(response) => {
                    assert_eq!(response.id, self.requests.into());
                    let answer = serde_json::to_value(&response).unwrap();
                    return if answer["error"].is_null() {
                        answer["result"].clone()
                    } else {
                        answer["error"].clone()
                    };
                }
                Message::Notification(Notification { method, .. }) if method == "window/showMessage" => {}
                Message::Notification(Notification { method, params }) => {
                    assert_eq!(method, "textDocument/publishDiagnostics");
                    let uri = params["uri"].as_str().unwrap().to_string();
                    self.findings.insert(uri, params["diagnostics"].as_array().unwrap().clone());
                }
                Message::Request(request) => panic!("an editor answers nothing: {request:?}"),
            }
        }
    }

    pub fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "languageId": "scn", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    pub fn change(&mut self, path: &Path, text: &str) {
        let changes = json!([{ "text": text }]);
        let document = json!({ "uri": address(path), "version": 2 });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": changes }));
    }

    /// Codes of what is shown for a file, once everything sent before was heard.
    fn codes(&mut self, path: &Path) -> Vec<String> {
        self.at("hover", path, "", 0);
        let shown = self.findings.get(&address(path));
        shown
            .expect("findings were shown")
            .iter()
            .map(|one| one["code"].as_str().unwrap().to_string())
            .collect()
    }

    /// Asks about the place `behind` bytes after the beginning of `word` in `text`.
    pub fn at(&mut self, what: &str, path: &Path, text: &str, behind: usize) -> Value {
        let before = &text[..behind];
        let line = before.matches('\n').count();
        let character = before.rsplit('\n').next().unwrap().encode_utf16().count();
        self.ask(
            &format!("textDocument/{what}"),
            json!({ "textDocument": { "uri": address(path) }, "position": { "line": line, "character": character } }),
        )
    }

    fn format(&mut self, path: &Path) -> Value {
        let options = json!({ "tabSize": 2, "insertSpaces": true });
        self.ask(
            "textDocument/formatting",
            json!({ "textDocument": { "uri": address(path) }, "options": options }),
        )
    }

    pub fn end(mut self) {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        drop(self.to);
        assert!(self.server.wait().unwrap().success());
    }
}

pub fn address(path: &Path) -> String {
    format!("file://{}", path.display())
}

const STREET: &str = "road street {\n  lane_width 3.5 m\n  speed_limit 50 km/h\n  crossing zebra\n}\n";

/// With every kind of thing that an editor may ask about; `é` and `😀` so that columns are not bytes.
const WALK: &str = "use \"street.scn\"
let pace = 1.4 m/s  # é😀

scenario walk {
  road street
  vehicle av {
    controller carla_behavior { profile: normal, braking_distance: 5 m }
    speed 30 km/h
  }
  pedestrian walker {
    model scripted { speed: pace }
    start 2 m from kerb
    appears when time_to_arrival(av) = tta
  }
  vary tta in [6 s, 10 s]
  expect { no collision; pet >= 1.5 s }
}
";

fn project() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("street.scn"), STREET).unwrap();
    let path = folder.path().canonicalize().unwrap().join("walk.scn");
    (folder, path)
}

/// Behind the first letter of the last `word`.
fn on(word: &str) -> usize {
    WALK.rfind(word).unwrap_or_else(|| panic!("no {word}")) + 1
}

#[test]
fn hover_tells_units_documentation_and_sources() {
    let (_folder, path) = project();
    let mut editor = Editor::start();
    editor.open(&path, WALK);
    assert_eq!(editor.codes(&path), [""; 0]);
    for (word, words) in [
        ("km/h", "kilometre per hour"),
        ("carla_behavior", "Source: "),
        ("braking_distance", "a length in m"),
        ("profile", "Named settings"),
        ("pet", "Post-encroachment time"),
        ("collision;", "**collision**"),
        ("pace }", "let pace = 1.4 m/s"),
        ("appears", "appears"),
        ("tta\n", "vary tta in [6 s, 10 s]"),
    ] {
        let hover = editor.at("hover", &path, WALK, on(word));
        let text = hover["contents"]["value"].as_str().unwrap_or_default();
        assert!(text.contains(words), "{word}: {hover}");
    }
    // Of nothing there is nothing to say.
    assert_eq!(editor.at("hover", &path, WALK, WALK.find("\n\n").unwrap() + 1)["contents"], Value::Null);
    editor.end();
}

#[test]
fn findings_come_while_typing_and_go_when_they_are_mended() {
    let (folder, path) = project();
    let mut editor = Editor::start();
    editor.open(&path, &WALK.replace("30 km/h", "30 kmh").replace("no collision", "no colision"));
    assert_eq!(editor.codes(&path), ["E0401", "E0311"]);
    let shown = &editor.findings[&address(&path)];
    assert_eq!(shown[0]["severity"], 1);
    assert_eq!(shown[0]["range"]["start"]["line"], 7);
    assert!(shown[1]["message"].as_str().unwrap().contains("did you mean `collision`?"), "{}", shown[1]);
    editor.change(&path, WALK);
    assert_eq!(editor.codes(&path), [""; 0]);
    // What only the models refuse is shown too.
    editor.change(&path, &WALK.replace("model scripted { speed: pace }", "model commotions { dt: 30 ms }"));
    let codes = editor.codes(&path);
    assert!(codes.contains(&"E0519".to_string()), "{codes:?}");
    // A mistake in a used file is shown in that file, and goes when the document is closed.
    std::fs::write(folder.path().join("street.scn"), STREET.replace("3.5 m", "3.5")).unwrap();
    editor.change(&path, WALK);
    let street = path.with_file_name("street.scn");
    assert_eq!(editor.codes(&street), ["E0403"]);
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": address(&path) } }));
    assert_eq!(editor.codes(&street), [""; 0]);
    editor.end();
}

#[test]
fn completion_knows_the_place() {
    let (_folder, path) = project();
    let mut editor = Editor::start();
    for (text, word) in [
        ("sc", "scenario"),
        ("scenario a {\n  ve", "vehicle"),
        ("scenario a {\n  vehicle av {\n    controller ", "careful_human"),
        ("scenario a {\n  vehicle av {\n    controller carla_behavior { ", "braking_distance"),
        ("scenario a {\n  vehicle av {\n    controller carla_behavior { profile: ", "cautious"),
        ("scenario a {\n  vehicle av {\n    speed 30 ", "km/h"),
        ("scenario a {\n  expect {\n    ", "min_ttc"),
        ("search s {\n  ", "minimise"),
        ("suite s {\n  ", "time_limit"),
        ("statement s {\n  ", "claim"),
        ("use \"street.scn\"\nscenario a {\n  road ", "street"),
        ("search nearest {\n}\nevaluate e {\n  on ", "nearest"),
        ("search nearest {\n}\nstatement e {\n  claim mean(pet) of ", "nearest"),
    ] {
        editor.open(&path, text);
        let proposals = editor.at("completion", &path, text, text.len());
        let found = proposals.as_array().unwrap().iter().find(|one| one["label"] == word);
        let found = found.unwrap_or_else(|| panic!("{text:?}: no {word} in {proposals}"));
        assert!(!found["detail"].as_str().unwrap_or_default().is_empty(), "{found}");
    }
    editor.end();
}

#[test]
fn definitions_are_found_here_and_in_used_files() {
    let (_folder, path) = project();
    let mut editor = Editor::start();
    editor.open(&path, WALK);
    let here = editor.at("definition", &path, WALK, on("pace }"));
    assert_eq!(here["uri"], address(&path));
    assert_eq!(here["range"]["start"], json!({ "line": 1, "character": 4 }));
    let there = editor.at("definition", &path, WALK, on("street\n"));
    assert_eq!(there["uri"], address(&path.with_file_name("street.scn")));
    assert_eq!(there["range"]["start"], json!({ "line": 0, "character": 5 }));
    let vehicle = editor.at("definition", &path, WALK, on("av) "));
    assert_eq!(vehicle["range"]["start"]["line"], 5);
    editor.end();
}

#[test]
fn formatting_replaces_the_whole_text_or_nothing() {
    let (_folder, path) = project();
    let mut editor = Editor::start();
    editor.open(&path, &WALK.replace("    speed 30 km/h", "  speed   30 km/h"));
    let edits = editor.format(&path);
    assert_eq!(
        edits[0]["newText"].as_str().map(|text| text.contains("\n    speed 30 km/h\n")),
        Some(true),
        "{edits}"
    );
    assert_eq!(edits[0]["range"]["start"], json!({ "line": 0, "character": 0 }));
    assert_eq!(edits[0]["range"]["end"], json!({ "line": WALK.lines().count(), "character": 0 }));
    // A text that cannot be read stays as it is, and so does YAML, which has no one style.
    editor.change(&path, "scenario a {");
    assert_eq!(editor.format(&path), Value::Null);
    let yaml = path.with_extension("yaml");
    editor.open(&yaml, "roads: {}\n");
    assert_eq!(editor.format(&yaml), Value::Null);
    editor.end();
}

#[test]
fn what_is_not_known_is_refused_and_the_server_lives_on() {
    let (_folder, path) = project();
    let mut editor = Editor::start();
    let refused = editor.ask("textDocument/declaration", json!({}));
    assert!(refused["message"].as_str().unwrap().contains("textDocument/declaration"), "{refused}");
    let malformed = editor.ask("textDocument/hover", json!({ "textDocument": 5 }));
    assert!(malformed["code"].is_number(), "{malformed}");
    editor.tell("textDocument/didOpen", json!({ "textDocument": 5 }));
    editor.tell("$/setTrace", json!({ "value": "off" }));
    editor.open(&path, "scenario a {");
    assert_eq!(editor.codes(&path), ["E0101"]);
    editor.end();
}

/// The program with a client that says what it likes; stderr goes nowhere.
fn served(input: &[u8]) -> (std::process::ExitStatus, Vec<Value>) {
    let mut server = Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
        .args(["lsp"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the server starts");
    let mut to = server.stdin.take().unwrap();
    let sent = input.to_vec();
    // Whoever hangs up early breaks the pipe.
    let writing = std::thread::spawn(move || drop(to.write_all(&sent)));
    let mut from = BufReader::new(server.stdout.take().unwrap());
    let mut answers = Vec::new();
    while let Some(answer) = next(&mut from) {
        answers.push(answer);
    }
    writing.join().unwrap();
    (server.wait().unwrap(), answers)
}

/// The next message as it is, also what `lsp-server` would not read.
fn next(from: &mut impl std::io::BufRead) -> Option<Value> {
    let mut header = String::new();
    from.read_line(&mut header).unwrap();
    let size: usize = header.strip_prefix("Content-Length: ")?.trim().parse().unwrap();
    let mut bytes = vec![0; size + 2];
    from.read_exact(&mut bytes).unwrap();
    Some(serde_json::from_slice(&bytes[2..]).unwrap())
}

fn framed(text: &str) -> Vec<u8> {
    format!("Content-Length: {}\r\n\r\n{text}", text.len()).into_bytes()
}

fn asks(id: u32, method: &str, parameters: Value) -> Vec<u8> {
    framed(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": parameters }).to_string())
}

fn tells(method: &str, parameters: Value) -> Vec<u8> {
    framed(&json!({ "jsonrpc": "2.0", "method": method, "params": parameters }).to_string())
}

fn begins() -> Vec<u8> {
    [asks(1, "initialize", json!({ "capabilities": {} })), tells("initialized", json!({}))].concat()
}

fn ends() -> Vec<u8> {
    [asks(99, "shutdown", Value::Null), tells("exit", Value::Null)].concat()
}

fn opens(uri: &str, text: &str) -> Vec<u8> {
    let document = json!({ "uri": uri, "languageId": "scn", "version": 5, "text": text });
    tells("textDocument/didOpen", json!({ "textDocument": document }))
}

fn changes(uri: &str, version: i32, change: Value) -> Vec<u8> {
    let document = json!({ "uri": uri, "version": version });
    tells("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }))
}

/// The codes of the findings shown for an address, time after time.
fn shown(answers: &[Value], uri: &str) -> Vec<Vec<String>> {
    let published = answers.iter().filter(|answer| answer["params"]["uri"] == uri);
    let codes = |answer: &Value| {
        let findings = answer["params"]["diagnostics"].as_array().unwrap();
        findings.iter().map(|one| one["code"].as_str().unwrap().to_string()).collect()
    };
    published.map(codes).collect()
}

fn answer(answers: &[Value], id: u32) -> Value {
    answers.iter().find(|answer| answer["id"] == id).cloned().unwrap_or(Value::Null)
}

const URI: &str = "file:///nowhere/a.scn";

#[test]
fn a_frame_that_holds_nothing_readable_is_refused_and_the_server_lives_on() {
    let garbage = [
        framed("{"),
        framed("[]"),
        framed("null"),
        framed(r#"{"id": 3}"#),
        framed(&"[".repeat(5000)),
        framed(""),
        b"Content-Length: 2\r\n\r\n\xff\xff".to_vec(),
        asks(7, "no/such", json!({ "deep": [[[[]]]] })),
        tells("no/such", json!(5)),
        asks(
            8,
            "textDocument/hover",
            json!({ "textDocument": { "uri": "not a uri at all" }, "position": {} }),
        ),
        tells("textDocument/didOpen", json!([])),
        framed(r#"{"jsonrpc": "2.0", "id": 12345, "result": null}"#),
    ];
    let (status, answers) =
        served(&[begins(), garbage.concat(), opens(URI, "scenario a {"), ends()].concat());
    assert!(status.success(), "{status}");
    assert_eq!(shown(&answers, URI).last().unwrap(), &["E0101"]);
    let refused = answers.iter().filter(|answer| answer["id"].is_null() && answer["error"]["code"] == -32700);
    assert_eq!(refused.count(), 7);
    assert_eq!(answer(&answers, 7)["error"]["code"], -32601);
    assert_eq!(answer(&answers, 8)["error"]["code"], -32602);
    assert_eq!(answer(&answers, 99)["result"], Value::Null);
}

#[test]
fn a_lost_frame_ends_the_session_with_an_error() {
    for lost in [
        &b"no header at all\r\n\r\n{}"[..],
        b"Content-Length: many\r\n\r\n{}",
        b"Content-Length: 18446744073709551615\r\n\r\n{}",
        b"Content-Length: 99999999999999999999999999\r\n\r\n{}",
        b"Content-Length: 500\r\n\r\n{}",
        b"\r\n\r\n",
        &[b'x'; 100_000],
        &[0; 100_000],
    ] {
        let (status, answers) = served(&[&begins(), lost].concat());
        assert_eq!(status.code(), Some(110), "{}", String::from_utf8_lossy(&lost[..lost.len().min(60)]));
        assert_eq!(answers.len(), 1);
    }
}

#[test]
fn input_may_end_at_any_message() {
    let all = [begins(), opens(URI, "scenario a {"), asks(2, "shutdown", Value::Null)];
    for count in 0..=all.len() {
        let (status, _) = served(&all[..count].concat());
        assert!(status.success(), "{count}: {status}");
    }
    // `exit` alone is no proper end.
    let (status, _) = served(&[begins(), tells("exit", Value::Null)].concat());
    assert_eq!(status.code(), Some(110));
}

#[test]
fn shutdown_without_exit_ends_by_itself() {
    let mut editor = Editor::start();
    assert_eq!(editor.ask("shutdown", Value::Null), Value::Null);
    // Its input stays open.
    assert!(editor.server.wait().unwrap().success());
    drop(editor.to);
}

#[test]
fn changes_of_what_is_closed_or_older_change_nothing() {
    let whole = |text: &str| json!({ "text": text });
    let part = |line: u32, from: u32, to: u32, text: &str| {
        let at = |character: u32| json!({ "line": line, "character": character });
        json!({ "range": { "start": at(from), "end": at(to) }, "text": text })
    };
    let hover = |id| {
        let place = json!({ "textDocument": { "uri": URI }, "position": { "line": 0, "character": 0 } });
        asks(id, "textDocument/hover", place)
    };
    let good = "road a { lane_width 3 m; speed_limit 9 m/s; crossing zebra }\n";
    let session = [
        begins(),
        // Never opened.
        changes(URI, 9, whole("scenario a {")),
        hover(2),
        opens(URI, good),
        // Older than version 5.
        changes(URI, 4, whole("scenario a {")),
        changes(URI, 6, part(0, 0, 4, "rod")),
        changes(URI, 7, part(9, 9, 2, "\n")),
        changes(URI, 8, whole(good)),
        tells("textDocument/didClose", json!({ "textDocument": { "uri": URI } })),
        changes(URI, 9, whole("scenario a {")),
        tells("textDocument/didClose", json!({ "textDocument": { "uri": URI } })),
        hover(3),
        ends(),
    ];
    let (status, answers) = served(&session.concat());
    assert!(status.success(), "{status}");
    // Opened, version 6, 7, 8, closed.
    let codes = shown(&answers, URI);
    let known: Vec<&str> = codes.iter().map(|codes| codes.first().map_or("", String::as_str)).collect();
    assert_eq!(known, ["", "E0107", "E0107", "", ""], "{codes:?}");
    assert_eq!(
        (&answer(&answers, 2)["result"], &answer(&answers, 3)["result"]),
        (&Value::Null, &Value::Null)
    );
}

/// The most memory that a process had so far, bytes.
#[cfg(target_os = "linux")]
fn peak(server: &Child) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.id())).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).expect("a peak");
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() << 10
}

/// Documents of 64 MiB, and ones just small enough that take much memory to read, ten after each other.
#[cfg(target_os = "linux")]
#[test]
fn no_document_takes_a_gigabyte() {
    let (_folder, path) = project();
    let mut editor = Editor::start();
    let mut heaviest = format!("let a = {}1\n", "1+".repeat((1 << 19) - 16));
    assert!(heaviest.len() < 1 << 20);
    editor.open(&path, &heaviest);
    assert_eq!(editor.codes(&path), [""; 0]);
    for text in ["{".repeat(1 << 20), "\"".repeat(900_000)] {
        editor.change(&path, &text);
        assert!(!editor.codes(&path).is_empty());
    }
    // A used file that is larger than what is checked.
    let beside = path.with_file_name("beside.scn");
    std::fs::write(&beside, " ".repeat(4 << 20)).unwrap();
    editor.change(&path, "use \"beside.scn\"\n");
    assert_eq!(editor.codes(&path), ["E0204"]);
    heaviest.push_str(&" ".repeat(1 << 20));
    editor.change(&path, &heaviest);
    assert_eq!(editor.codes(&path), ["E0204"]);
    let other = path.with_file_name("other.scn");
    for size in [64 << 20, 9 << 20] {
        editor.open(&other, &"x".repeat(size));
    }
    editor.change(&path, WALK);
    assert_eq!(editor.codes(&path), [""; 0]);
    assert!(!editor.findings.contains_key(&address(&other)));
    let most = peak(&editor.server);
    assert!(most < 1 << 30, "{} MB", most >> 20);
    editor.end();
}

#[test]
fn the_scenario_at_the_cursor_is_drawn() {
    let road = "road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }";
    let one = |name: &str| {
        format!(
            "scenario {name} {{\n  {road}\n  vehicle av {{ start 40 m before crossing; speed 36 km/h; controller constant_speed }}\n  pedestrian walker {{ model scripted; start 2 m from kerb; appears at 0 s }}\n}}\n"
        )
    };
    let text = one("first") + &one("second");
    let folder = tempfile::tempdir().unwrap();
    let uri = format!("file://{}", folder.path().join("a.scn").display());
    let mut editor = Editor::start();
    let document = |text: &str| json!({ "uri": uri, "languageId": "scn", "version": 1, "text": text });
    editor.tell("textDocument/didOpen", json!({ "textDocument": document(&text) }));
    let mut at = |line: u32| {
        editor.ask(
            "scenario-runner/sketch",
            json!({ "textDocument": { "uri": uri }, "position": { "line": line, "character": 0 } }),
        )
    };
    for (line, name) in
        [(0, "a/first/rep=1"), (4, "a/first/rep=1"), (5, "a/second/rep=1"), (99, "a/second/rep=1")]
    {
        let drawn = at(line);
        assert_eq!(drawn["name"], name, "line {line}");
        assert!(drawn["svg"].as_str().unwrap().starts_with("<svg"), "{drawn}");
    }
    // While a text has errors there is nothing to draw, which is said and no error of the server's.
    let broken = json!({ "uri": uri, "version": 2 });
    editor.tell(
        "textDocument/didChange",
        json!({ "textDocument": broken, "contentChanges": [{ "text": "scenario {" }] }),
    );
    let said = editor.ask(
        "scenario-runner/sketch",
        json!({ "textDocument": { "uri": uri }, "position": { "line": 0, "character": 0 } }),
    );
    assert!(said["svg"].is_null() && said["message"].as_str().unwrap().contains("errors"), "{said}");
}
