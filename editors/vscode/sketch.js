// The scenario at the cursor, drawn by the server.
"use strict";

const vscode = require("vscode");
const { place } = require("./providers");

const escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;");

/** A page without scripts, which loads nothing. The SVG is the server's, in which names are escaped; a message is put in as text. */
function page(found) {
  const policy = `<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">`;
  const shown = found && found.svg ? found.svg : `<p>${escaped((found && found.message) || "")}</p>`;
  return `<!DOCTYPE html><meta charset="utf-8">${policy}${shown}`;
}

/** Opens a view that follows the cursor. */
function sketch(client, isOurs) {
  const editor = vscode.window.activeTextEditor;
  if (!editor || !isOurs(editor.document)) return undefined;
  const options = { enableScripts: false, localResourceRoots: [] };
  const panel = vscode.window.createWebviewPanel("scenarioRunner.sketch", "Sketch", vscode.ViewColumn.Beside, options);
  let shown = editor;
  const draw = async () => {
    const found = await client.request("scenario-runner/sketch", place(shown.document, shown.selection.active));
    panel.title = found && found.name ? found.name : "Sketch";
    panel.webview.html = page(found);
  };
  const follow = vscode.window.onDidChangeTextEditorSelection((event) => {
    if (!isOurs(event.textEditor.document)) return;
    shown = event.textEditor;
    draw().catch(() => {});
  });
  panel.onDidDispose(() => follow.dispose());
  return draw().catch((error) => vscode.window.showErrorMessage(`scenario-runner: ${error.message}`));
}

module.exports = { sketch, page };
