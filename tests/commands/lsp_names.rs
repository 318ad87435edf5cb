//! Names, hints, colours and fixes as an editor asks for them: the program, over its standard input and output.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::lsp::{Editor, address};

const STREET: &str = "road street { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\n";
const WALK: &str = "\
use \"street.scn\"
scenario walk {
  road street
  vehicle av { controller idm_aeb; speed 36 km/h; start 40 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
  expect { no collision(av) }
}
";

fn workspace() -> (tempfile::TempDir, PathBuf, Editor) {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().canonicalize().unwrap();
    std::fs::create_dir(root.join("inner")).unwrap();
    std::fs::create_dir(root.join("target")).unwrap();
    std::fs::write(root.join("street.scn"), STREET).unwrap();
    std::fs::write(root.join("inner/walk.scn"), WALK.replace("street.scn", "../street.scn")).unwrap();
    std::fs::write(root.join("target/built.scn"), "scenario walk_built {\n}\n").unwrap();
    let editor = Editor::start_with(
        json!({ "capabilities": {}, "workspaceFolders": [{ "uri": address(&root), "name": "root" }] }),
    );
    (folder, root, editor)
}

fn offset(text: &str, position: &Value) -> usize {
    let line = position["line"].as_u64().unwrap() as usize;
    let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
    start + position["character"].as_u64().unwrap() as usize
}

/// A text of letters of one byte with the edits of a file.
fn with(text: &str, edits: &Value, path: &Path) -> String {
    let mut edits = edits["changes"][address(path)].as_array().cloned().unwrap_or_default();
    edits.sort_by_key(|edit| std::cmp::Reverse(offset(text, &edit["range"]["start"])));
    let mut text = text.to_string();
    for edit in edits {
        let range = offset(&text, &edit["range"]["start"])..offset(&text, &edit["range"]["end"]);
        text.replace_range(range, edit["newText"].as_str().unwrap());
    }
    text
}

#[test]
fn a_road_is_renamed_in_files_that_are_not_open() {
    let (_folder, root, mut editor) = workspace();
    let (street, walk) = (root.join("street.scn"), root.join("inner/walk.scn"));
    // What the editor holds counts, not what is saved.
    let edited = format!("# more\n{STREET}");
    editor.open(&street, &edited);
    let at = edited.find("street").unwrap();
    let place = editor.at("prepareRename", &street, &edited, at);
    assert_eq!(place["placeholder"], "street");
    let asked = |new: &str| json!({ "textDocument": { "uri": address(&street) }, "position": { "line": 1, "character": 6 }, "newName": new });
    let edits = editor.ask("textDocument/rename", asked("lane"));
    assert_eq!(with(&edited, &edits, &street), edited.replace("road street", "road lane"));
    let own = std::fs::read_to_string(&walk).unwrap();
    assert_eq!(with(&own, &edits, &walk), own.replace("road street", "road lane"));
    assert_eq!(edits["changes"].as_object().unwrap().len(), 2);
    for (new, why) in [("in", "is no name"), ("", "is no name")] {
        let refused = editor.ask("textDocument/rename", asked(new));
        assert!(refused["code"] == -32803 && refused["message"].as_str().unwrap().contains(why), "{refused}");
    }
    let refused = editor.at("prepareRename", &street, &edited, edited.find("zebra").unwrap() + 1);
    assert!(refused["message"].as_str().unwrap().contains("here stands none"), "{refused}");
    let all = json!({ "textDocument": { "uri": address(&street) }, "position": { "line": 1, "character": 6 }, "context": { "includeDeclaration": false } });
    let found = editor.ask("textDocument/references", all);
    assert_eq!(found.as_array().unwrap().len(), 1, "{found}");
    assert_eq!(found[0]["uri"], address(&walk));
    editor.end();
}

#[test]
fn symbols_are_those_of_the_workspace_and_not_of_what_tools_leave() {
    let (_folder, _, mut editor) = workspace();
    let names = |found: Value| -> Vec<String> {
        found.as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap().to_string()).collect()
    };
    assert_eq!(names(editor.ask("workspace/symbol", json!({ "query": "" }))), ["walk", "street"]);
    assert_eq!(names(editor.ask("workspace/symbol", json!({ "query": "WAL" }))), ["walk"]);
    editor.end();
}

#[test]
fn hints_colours_and_fixes_come_over_the_wire() {
    let (_folder, root, mut editor) = workspace();
    let path = root.join("b.scn");
    let text = WALK.replace("no collision", "no colision");
    editor.open(&path, &text);
    let whole = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let document = json!({ "uri": address(&path) });
    let hints = editor.ask("textDocument/inlayHint", json!({ "textDocument": document, "range": whole }));
    assert_eq!(hints.as_array().unwrap().len(), 1, "{hints}");
    assert_eq!(hints[0]["label"], "= 10 m/s");
    let line = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 1, "character": 0 } });
    assert_eq!(
        editor.ask("textDocument/inlayHint", json!({ "textDocument": document, "range": line })),
        json!([])
    );
    let tokens = editor.ask("textDocument/semanticTokens/full", json!({ "textDocument": document }));
    let tokens = tokens["data"].as_array().unwrap();
    assert!(tokens.len() > 100 && tokens.len() % 5 == 0, "{}", tokens.len());
    // `use` and the path behind it.
    assert_eq!(tokens[..10], [0, 0, 3, 0, 0, 0, 4, 12, 2, 0].map(Value::from));
    let findings = editor.findings[&address(&path)].clone();
    let asked = json!({ "textDocument": document, "range": findings[0]["range"], "context": { "diagnostics": findings } });
    let actions = editor.ask("textDocument/codeAction", asked);
    assert_eq!(actions[0]["title"], "Write `collision`");
    assert_eq!(actions[0]["diagnostics"][0]["code"], "E0311");
    let mended = with(&text, &actions[0]["edit"], &path);
    assert_eq!(mended, WALK);
    editor.end();
}

/// Whatever is asked of whatever text, there is an answer, and the server lives on.
#[test]
fn every_request_is_answered_whatever_it_holds() {
    let (_folder, root, mut editor) = workspace();
    let path = root.join("b.scn");
    let own = json!({ "uri": address(&path) });
    let places = [
        Value::Null,
        json!(5),
        json!({}),
        json!({ "textDocument": { "uri": "not a uri" } }),
        json!({ "textDocument": { "uri": "file:///dev/zero" }, "position": { "line": 0, "character": 0 } }),
        json!({ "textDocument": own, "position": { "line": 4294967295u32, "character": 4294967295u32 }, "newName": "x", "context": { "includeDeclaration": true } }),
        json!({ "textDocument": own, "position": { "line": 1, "character": 11 }, "newName": "\u{0}", "context": { "includeDeclaration": true } }),
        json!({ "textDocument": own, "range": { "start": { "line": 9, "character": 9 }, "end": { "line": 0, "character": 0 } }, "context": { "diagnostics": [{ "range": { "start": { "line": 9, "character": 9 }, "end": { "line": 0, "character": 0 } }, "message": "" }] } }),
        json!({ "textDocument": own, "query": "\u{fffd}" }),
    ];
    let methods = [
        "textDocument/hover",
        "textDocument/references",
        "textDocument/prepareRename",
        "textDocument/rename",
        "textDocument/inlayHint",
        "textDocument/semanticTokens/full",
        "textDocument/codeAction",
        "textDocument/codeLens",
        "workspace/symbol",
        "scenario-runner/sketch",
    ];
    for text in ["", "\u{feff}", "😀", "scenario a {", WALK, "{{{{\"", "use \"b.scn\"\nscenario a : a {\n}\n"]
    {
        editor.open(&path, text);
        for method in methods {
            for place in &places {
                let answer = editor.ask(method, place.clone());
                assert_ne!(answer["code"], -32603, "{method} {place} of {text:?}: {answer}");
            }
        }
    }
    editor.end();
}

/// The largest text that is checked is answered about in seconds, also where all of it stands on one line.
#[test]
fn large_texts_are_answered_about_in_seconds() {
    let (_folder, root, mut editor) = workspace();
    let path = root.join("b.scn");
    let lines = "let a = 30 km/h # more\n".repeat(40_000);
    let line = format!("let a = {}1\n", "1 km + ".repeat(100_000));
    for text in [lines, line] {
        editor.open(&path, &text[..text.len().min(1 << 20)]);
        let document = json!({ "uri": address(&path) });
        let begun = std::time::Instant::now();
        let whole = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
        for (method, asked) in [
            ("textDocument/semanticTokens/full", json!({ "textDocument": document })),
            ("textDocument/inlayHint", json!({ "textDocument": document, "range": whole })),
            ("textDocument/codeLens", json!({ "textDocument": document })),
        ] {
            let answer = editor.ask(method, asked);
            assert!(answer["code"].is_null(), "{method}: {answer}");
        }
        assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
    }
    editor.end();
}
