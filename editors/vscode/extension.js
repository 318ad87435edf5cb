// Starts `scenario-runner lsp` and hands what it says to the editor. Needs nothing but VS Code itself.
"use strict";

const vscode = require("vscode");
const { Client } = require("./client");
const { explorer } = require("./explorer");
const { finding, register } = require("./providers");
const { run } = require("./run");
const { sketch } = require("./sketch");

let client;

async function activate(context) {
  const findings = vscode.languages.createDiagnosticCollection("scenario-runner");
  const settings = () => vscode.workspace.getConfiguration("scenarioRunner");
  const commandOf = () => settings().get("path");
  const selector = { language: "scn" };
  const lensesChanged = new vscode.EventEmitter();
  client = new Client(
    commandOf(),
    (method, params) => {
      if (method === "textDocument/publishDiagnostics") {
        findings.set(vscode.Uri.parse(params.uri), params.diagnostics.map(finding));
      } else if (method === "window/showMessage") {
        vscode.window.showWarningMessage(`scenario-runner: ${params.message}`);
      }
    },
    (error) => vscode.window.showErrorMessage(`scenario-runner: ${error.message}; set "scenarioRunner.path"`),
  );
  const folders = (vscode.workspace.workspaceFolders || []).map(({ uri, name }) => ({ uri: uri.toString(), name }));
  const able = await client.request("initialize", {
    processId: process.pid,
    rootUri: folders.length > 0 ? folders[0].uri : null,
    workspaceFolders: folders,
    initializationOptions: { results: settings().get("results") || [] },
    capabilities: {},
  });
  client.notify("initialized", {});

  const isOurs = (document) => document.languageId === "scn" && document.uri.scheme === "file";
  const open = (document) => {
    if (!isOurs(document)) return;
    const item = { uri: document.uri.toString(), languageId: "scn", version: document.version, text: document.getText() };
    client.notify("textDocument/didOpen", { textDocument: item });
  };
  vscode.workspace.textDocuments.forEach(open);
  // Results, and files that open ones use.
  const watched = vscode.workspace.createFileSystemWatcher("**/*.{scn,suite,yaml,yml,csv,json}");
  const changed = (type) => (uri) => {
    client.notify("workspace/didChangeWatchedFiles", { changes: [{ uri: uri.toString(), type }] });
    lensesChanged.fire();
  };
  watched.onDidCreate(changed(1));
  watched.onDidChange(changed(2));
  watched.onDidDelete(changed(3));
  context.subscriptions.push(
    findings,
    lensesChanged,
    watched,
    vscode.workspace.onDidOpenTextDocument(open),
    vscode.workspace.onDidChangeTextDocument(({ document }) => {
      if (!isOurs(document)) return;
      const textDocument = { uri: document.uri.toString(), version: document.version };
      client.notify("textDocument/didChange", { textDocument, contentChanges: [{ text: document.getText() }] });
    }),
    vscode.workspace.onDidCloseTextDocument((document) => {
      if (isOurs(document)) client.notify("textDocument/didClose", { textDocument: { uri: document.uri.toString() } });
    }),
    ...register(client, able.capabilities, selector, lensesChanged.event),
    vscode.commands.registerCommand("scenarioRunner.sketch", () => sketch(client, isOurs)),
    vscode.commands.registerCommand("scenarioRunner.run", (lens) => run(commandOf(), lens)),
    explorer(commandOf),
  );
}

async function deactivate() {
  if (client) await client.leave();
}

module.exports = { activate, deactivate, Client };
