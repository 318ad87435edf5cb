// Starts `scenario-runner lsp` and hands what it says to the editor. Needs nothing but VS Code itself.
"use strict";

const { spawn } = require("child_process");
const vscode = require("vscode");

/** Speaks JSON-RPC with the server over its standard input and output. */
class Client {
  constructor(command, onNotification, onEnd) {
    this.waiting = new Map();
    this.next = 1;
    this.buffer = Buffer.alloc(0);
    this.onNotification = onNotification;
    this.process = spawn(command, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
    this.process.on("error", onEnd);
    this.process.on("exit", () => this.fail(new Error("the language server ended")));
    this.process.stdin.on("error", () => {});
    this.process.stdout.on("data", (data) => this.receive(data));
  }

  fail(error) {
    for (const { reject } of this.waiting.values()) reject(error);
    this.waiting.clear();
  }

  send(message) {
    const body = Buffer.from(JSON.stringify({ jsonrpc: "2.0", ...message }));
    this.process.stdin.write(`Content-Length: ${body.length}\r\n\r\n`);
    this.process.stdin.write(body);
  }

  notify(method, params) {
    this.send({ method, params });
  }

  request(method, params) {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.send({ id, method, params });
    });
  }

  receive(data) {
    this.buffer = Buffer.concat([this.buffer, data]);
    for (;;) {
      const end = this.buffer.indexOf("\r\n\r\n");
      if (end < 0) return;
      const length = /content-length: *(\d+)/i.exec(this.buffer.toString("ascii", 0, end));
      const start = end + 4;
      const size = length ? Number(length[1]) : 0;
      if (this.buffer.length < start + size) return;
      const message = JSON.parse(this.buffer.toString("utf8", start, start + size));
      this.buffer = this.buffer.subarray(start + size);
      const waiting = this.waiting.get(message.id);
      if (waiting) {
        this.waiting.delete(message.id);
        if (message.error) waiting.reject(new Error(message.error.message));
        else waiting.resolve(message.result);
      } else if (message.method) {
        this.onNotification(message.method, message.params);
      }
    }
  }
}

const range = (r) => new vscode.Range(r.start.line, r.start.character, r.end.line, r.end.character);
const place = (document, position) => ({
  textDocument: { uri: document.uri.toString() },
  position: { line: position.line, character: position.character },
});

let client;

async function activate(context) {
  const findings = vscode.languages.createDiagnosticCollection("scenario-runner");
  const command = vscode.workspace.getConfiguration("scenarioRunner").get("path");
  const selector = { language: "scn" };
  client = new Client(
    command,
    (method, params) => {
      if (method !== "textDocument/publishDiagnostics") return;
      const shown = params.diagnostics.map((found) => {
        const severity = found.severity === 1 ? vscode.DiagnosticSeverity.Error : vscode.DiagnosticSeverity.Warning;
        const diagnostic = new vscode.Diagnostic(range(found.range), found.message, severity);
        diagnostic.code = found.code;
        diagnostic.source = found.source;
        diagnostic.relatedInformation = (found.relatedInformation || []).map(
          (related) =>
            new vscode.DiagnosticRelatedInformation(
              new vscode.Location(vscode.Uri.parse(related.location.uri), range(related.location.range)),
              related.message,
            ),
        );
        return diagnostic;
      });
      findings.set(vscode.Uri.parse(params.uri), shown);
    },
    (error) => vscode.window.showErrorMessage(`scenario-runner: ${error.message}; set "scenarioRunner.path"`),
  );
  await client.request("initialize", { processId: process.pid, rootUri: null, capabilities: {} });
  client.notify("initialized", {});

  const isOurs = (document) => document.languageId === "scn" && document.uri.scheme === "file";
  const open = (document) => {
    if (!isOurs(document)) return;
    const item = { uri: document.uri.toString(), languageId: "scn", version: document.version, text: document.getText() };
    client.notify("textDocument/didOpen", { textDocument: item });
  };
  vscode.workspace.textDocuments.forEach(open);
  context.subscriptions.push(
    findings,
    vscode.workspace.onDidOpenTextDocument(open),
    vscode.workspace.onDidChangeTextDocument(({ document }) => {
      if (!isOurs(document)) return;
      const textDocument = { uri: document.uri.toString(), version: document.version };
      client.notify("textDocument/didChange", { textDocument, contentChanges: [{ text: document.getText() }] });
    }),
    vscode.workspace.onDidCloseTextDocument((document) => {
      if (isOurs(document)) client.notify("textDocument/didClose", { textDocument: { uri: document.uri.toString() } });
    }),
    vscode.languages.registerHoverProvider(selector, {
      async provideHover(document, position) {
        const found = await client.request("textDocument/hover", place(document, position));
        return found && new vscode.Hover(new vscode.MarkdownString(found.contents.value), range(found.range));
      },
    }),
    vscode.languages.registerCompletionItemProvider(
      selector,
      {
        async provideCompletionItems(document, position) {
          const items = await client.request("textDocument/completion", place(document, position));
          return (items || []).map(({ label, detail }) => Object.assign(new vscode.CompletionItem(label), { detail }));
        },
      },
      " ",
      "{",
      ":",
    ),
    vscode.languages.registerDefinitionProvider(selector, {
      async provideDefinition(document, position) {
        const found = await client.request("textDocument/definition", place(document, position));
        return found && new vscode.Location(vscode.Uri.parse(found.uri), range(found.range));
      },
    }),
    vscode.commands.registerCommand("scenarioRunner.sketch", () => {
      const editor = vscode.window.activeTextEditor;
      if (!editor || !isOurs(editor.document)) return;
      const panel = vscode.window.createWebviewPanel("scenarioRunner.sketch", "Sketch", vscode.ViewColumn.Beside, {});
      let shown = editor;
      const draw = async () => {
        const found = await client.request("scenario-runner/sketch", place(shown.document, shown.selection.active));
        // The SVG is the server's, in which names are escaped; a message is put in as text.
        const text = (found && found.message ? found.message : "").replace(/&/g, "&amp;").replace(/</g, "&lt;");
        panel.title = found && found.name ? found.name : "Sketch";
        panel.webview.html = `<!DOCTYPE html><meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">${found && found.svg ? found.svg : `<p>${text}</p>`}`;
      };
      const follow = vscode.window.onDidChangeTextEditorSelection((event) => {
        if (!isOurs(event.textEditor.document)) return;
        shown = event.textEditor;
        draw().catch(() => {});
      });
      panel.onDidDispose(() => follow.dispose());
      draw().catch((error) => vscode.window.showErrorMessage(`scenario-runner: ${error.message}`));
    }),
    vscode.languages.registerDocumentFormattingEditProvider(selector, {
      async provideDocumentFormattingEdits(document, options) {
        const params = { textDocument: { uri: document.uri.toString() }, options };
        const edits = await client.request("textDocument/formatting", params);
        return (edits || []).map((edit) => vscode.TextEdit.replace(range(edit.range), edit.newText));
      },
    }),
  );
}

async function deactivate() {
  if (!client) return;
  await client.request("shutdown", null).catch(() => {});
  client.notify("exit", null);
}

module.exports = { activate, deactivate, Client };
