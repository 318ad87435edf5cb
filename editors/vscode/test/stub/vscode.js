// What the extension needs of the editor's API, as far as a test can see it.
"use strict";

const path = require("path");
const { pathToFileURL, fileURLToPath } = require("url");

class Position {
  constructor(line, character) {
    Object.assign(this, { line, character });
  }
}

class Range {
  constructor(startLine, startCharacter, endLine, endCharacter) {
    this.start = new Position(startLine, startCharacter);
    this.end = new Position(endLine, endCharacter);
  }
}

class Uri {
  constructor(fsPath) {
    this.fsPath = fsPath;
    this.scheme = "file";
  }
  static file(fsPath) {
    return new Uri(fsPath);
  }
  static parse(text) {
    return new Uri(fileURLToPath(text));
  }
  toString() {
    return pathToFileURL(this.fsPath).toString();
  }
}

class EventEmitter {
  constructor() {
    this.listeners = [];
    this.event = (listener) => {
      this.listeners.push(listener);
      return { dispose: () => this.listeners.splice(this.listeners.indexOf(listener), 1) };
    };
  }
  fire(value) {
    this.listeners.forEach((listener) => listener(value));
  }
  dispose() {}
}

/** A class whose instances hold what they were made with under these names. */
const record = (...names) =>
  class {
    constructor(...values) {
      names.forEach((name, index) => (this[name] = values[index]));
    }
  };

class WorkspaceEdit {
  constructor() {
    this.edits = [];
  }
  replace(uri, range, newText) {
    this.edits.push({ uri, range, newText });
  }
}

class Items extends Map {
  add(item) {
    this.set(item.id, item);
  }
  forEach(seen) {
    for (const item of [...this.values()]) seen(item);
  }
}

/** An editor with a folder open. Tests look into `providers`, `commands`, `findings`, `messages`, `tasks`, `panels` and `runs`. */
function editor(folder, settings) {
  const state = { providers: {}, commands: {}, findings: new Map(), messages: [], tasks: [], panels: [], runs: [], watchers: [] };
  const opened = new EventEmitter();
  const changed = new EventEmitter();
  const closed = new EventEmitter();
  const selected = new EventEmitter();
  const provider = (kind) => (first, second) => {
    state.providers[kind] = second === undefined || typeof second === "string" ? first : second;
    return { dispose() {} };
  };
  const languages = {
    createDiagnosticCollection: () => ({ set: (uri, found) => state.findings.set(uri.fsPath, found), dispose() {} }),
  };
  for (const kind of [
    "Hover", "CompletionItem", "Definition", "Reference", "Rename", "WorkspaceSymbol", "InlayHints", "DocumentSemanticTokens",
    "CodeActions", "CodeLens", "DocumentFormattingEdit",
  ]) {
    languages[`register${kind}Provider`] = provider(kind);
  }
  const workspace = {
    isTrusted: true,
    workspaceFolders: [{ uri: Uri.file(folder), name: path.basename(folder) }],
    textDocuments: [],
    getConfiguration: () => ({ get: (name) => settings[name] }),
    getWorkspaceFolder: () => workspace.workspaceFolders[0],
    onDidOpenTextDocument: opened.event,
    onDidChangeTextDocument: changed.event,
    onDidCloseTextDocument: closed.event,
    saveAll: async () => true,
    findFiles: async () => state.files,
    createFileSystemWatcher: () => {
      const created = new EventEmitter();
      const changedFile = new EventEmitter();
      const deleted = new EventEmitter();
      state.watchers.push({ created, changed: changedFile, deleted });
      return { onDidCreate: created.event, onDidChange: changedFile.event, onDidDelete: deleted.event, dispose() {} };
    },
  };
  const tests = {
    createTestController: () => {
      const items = new Items();
      const make = (id, label, uri) => {
        const item = { id, label, uri, children: new Items() };
        const add = item.children.add.bind(item.children);
        item.children.add = (child) => {
          child.parent = item;
          add(child);
        };
        return item;
      };
      state.controller = {
        items,
        createTestItem: make,
        createRunProfile: (label, kind, run) => {
          state.profile = { label, kind, run };
          return { dispose() {} };
        },
        createTestRun: () => {
          const run = { results: new Map(), messages: new Map(), output: "", ended: false };
          for (const outcome of ["enqueued", "started", "passed", "failed", "errored", "skipped"]) {
            run[outcome] = (item, message) => {
              run.results.set(item.id, outcome);
              run.messages.set(item.id, message && message.message);
            };
          }
          run.appendOutput = (text) => (run.output += text);
          run.end = () => (run.ended = true);
          state.runs.push(run);
          return run;
        },
        dispose() {},
      };
      return state.controller;
    },
  };
  const window = {
    showErrorMessage: (text) => state.messages.push(text),
    showWarningMessage: (text) => state.messages.push(text),
    onDidChangeTextEditorSelection: selected.event,
    createWebviewPanel: (type, title, column, options) => {
      const panel = { title, options, webview: { html: "" }, onDidDispose() {} };
      state.panels.push(panel);
      return panel;
    },
  };
  const api = {
    Position, Range, Uri, EventEmitter, WorkspaceEdit, languages, workspace, tests, window,
    Location: record("uri", "range"),
    Hover: record("contents", "range"),
    MarkdownString: record("value"),
    CompletionItem: record("label"),
    Diagnostic: record("range", "message", "severity"),
    DiagnosticRelatedInformation: record("location", "message"),
    SymbolInformation: record("name", "kind", "containerName", "location"),
    InlayHint: record("position", "label"),
    SemanticTokens: record("data"),
    SemanticTokensLegend: record("tokenTypes", "tokenModifiers"),
    CodeAction: record("title", "kind"),
    CodeLens: record("range", "command"),
    ProcessExecution: record("process", "args", "options"),
    Task: record("definition", "scope", "name", "source", "execution"),
    TestMessage: record("message"),
    TextEdit: { replace: (range, newText) => ({ range, newText }) },
    DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2, Hint: 3 },
    CodeActionKind: { QuickFix: "quickfix" },
    TaskScope: { Workspace: 2 },
    TestRunProfileKind: { Run: 1 },
    ViewColumn: { Beside: -2 },
    tasks: { executeTask: async (task) => state.tasks.push(task) },
    commands: {
      registerCommand: (name, handler) => {
        state.commands[name] = handler;
        return { dispose() {} };
      },
    },
  };
  const document = (fsPath, text) => {
    const one = { uri: Uri.file(fsPath), languageId: "scn", version: 1, text, getText: () => one.text };
    workspace.textDocuments.push(one);
    opened.fire(one);
    return one;
  };
  const type = (one, text) => {
    Object.assign(one, { text, version: one.version + 1 });
    changed.fire({ document: one });
  };
  const select = (one, line) => {
    window.activeTextEditor = { document: one, selection: { active: new Position(line, 0) } };
    selected.fire({ textEditor: window.activeTextEditor });
  };
  return { api, state, document, type, select };
}

module.exports = { editor };
