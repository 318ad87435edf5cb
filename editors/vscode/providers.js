// What the server answers, as the editor's API has it.
"use strict";

const vscode = require("vscode");

const range = (r) => new vscode.Range(r.start.line, r.start.character, r.end.line, r.end.character);
const position = (p) => new vscode.Position(p.line, p.character);
const location = (l) => new vscode.Location(vscode.Uri.parse(l.uri), range(l.range));
const named = (document) => ({ textDocument: { uri: document.uri.toString() } });
const place = (document, at) => ({ ...named(document), position: { line: at.line, character: at.character } });
const plain = (r) => ({
  start: { line: r.start.line, character: r.start.character },
  end: { line: r.end.line, character: r.end.character },
});

const SEVERITIES = () => [
  undefined,
  vscode.DiagnosticSeverity.Error,
  vscode.DiagnosticSeverity.Warning,
  vscode.DiagnosticSeverity.Information,
  vscode.DiagnosticSeverity.Hint,
];

function finding(found) {
  const diagnostic = new vscode.Diagnostic(range(found.range), found.message, SEVERITIES()[found.severity]);
  diagnostic.code = found.code;
  diagnostic.source = found.source;
  diagnostic.relatedInformation = (found.relatedInformation || []).map(
    (related) => new vscode.DiagnosticRelatedInformation(location(related.location), related.message),
  );
  return diagnostic;
}

function workspaceEdit(answer) {
  const edit = new vscode.WorkspaceEdit();
  for (const [uri, edits] of Object.entries((answer && answer.changes) || {})) {
    for (const one of edits) edit.replace(vscode.Uri.parse(uri), range(one.range), one.newText);
  }
  return edit;
}

/** Registers everything that the server can do. `lensesChanged` says when lenses are to be asked for again. */
function register(client, able, selector, lensesChanged) {
  const languages = vscode.languages;
  const { tokenTypes, tokenModifiers } = able.semanticTokensProvider.legend;
  const legend = new vscode.SemanticTokensLegend(tokenTypes, tokenModifiers);
  return [
    languages.registerHoverProvider(selector, {
      async provideHover(document, at) {
        const found = await client.request("textDocument/hover", place(document, at));
        return found && new vscode.Hover(new vscode.MarkdownString(found.contents.value), range(found.range));
      },
    }),
    languages.registerCompletionItemProvider(
      selector,
      {
        async provideCompletionItems(document, at) {
          const items = await client.request("textDocument/completion", place(document, at));
          return (items || []).map(({ label, detail }) => Object.assign(new vscode.CompletionItem(label), { detail }));
        },
      },
      " ",
      "{",
      ":",
    ),
    languages.registerDefinitionProvider(selector, {
      async provideDefinition(document, at) {
        const found = await client.request("textDocument/definition", place(document, at));
        return found && location(found);
      },
    }),
    languages.registerReferenceProvider(selector, {
      async provideReferences(document, at, context) {
        const parameters = { ...place(document, at), context: { includeDeclaration: context.includeDeclaration } };
        return (await client.request("textDocument/references", parameters)).map(location);
      },
    }),
    languages.registerRenameProvider(selector, {
      async prepareRename(document, at) {
        const found = await client.request("textDocument/prepareRename", place(document, at));
        return { range: range(found.range), placeholder: found.placeholder };
      },
      async provideRenameEdits(document, at, newName) {
        return workspaceEdit(await client.request("textDocument/rename", { ...place(document, at), newName }));
      },
    }),
    languages.registerWorkspaceSymbolProvider({
      async provideWorkspaceSymbols(query) {
        const found = await client.request("workspace/symbol", { query });
        // The numbers of the editor begin at 0, those of the protocol at 1.
        return found.map((one) => new vscode.SymbolInformation(one.name, one.kind - 1, "", location(one.location)));
      },
    }),
    languages.registerInlayHintsProvider(selector, {
      async provideInlayHints(document, within) {
        const hints = await client.request("textDocument/inlayHint", { ...named(document), range: plain(within) });
        return hints.map((one) =>
          Object.assign(new vscode.InlayHint(position(one.position), one.label), { paddingLeft: one.paddingLeft }),
        );
      },
    }),
    languages.registerDocumentSemanticTokensProvider(
      selector,
      {
        async provideDocumentSemanticTokens(document) {
          const found = await client.request("textDocument/semanticTokens/full", named(document));
          return new vscode.SemanticTokens(new Uint32Array(found.data));
        },
      },
      legend,
    ),
    languages.registerCodeActionsProvider(
      selector,
      {
        async provideCodeActions(document, within, context) {
          const shown = context.diagnostics.map((one) => ({ range: plain(one.range), code: one.code, message: one.message }));
          const parameters = { ...named(document), range: plain(within), context: { diagnostics: shown } };
          const found = await client.request("textDocument/codeAction", parameters);
          return found.map((one) => {
            const action = new vscode.CodeAction(one.title, vscode.CodeActionKind.QuickFix);
            action.edit = workspaceEdit(one.edit);
            action.diagnostics = context.diagnostics.filter((known) => one.diagnostics.some((about) => about.code === known.code));
            return action;
          });
        },
      },
      { providedCodeActionKinds: [vscode.CodeActionKind.QuickFix] },
    ),
    languages.registerCodeLensProvider(selector, {
      onDidChangeCodeLenses: lensesChanged,
      async provideCodeLenses(document) {
        const found = await client.request("textDocument/codeLens", named(document));
        return found.map((one) => new vscode.CodeLens(range(one.range), one.command));
      },
    }),
    languages.registerDocumentFormattingEditProvider(selector, {
      async provideDocumentFormattingEdits(document, options) {
        const edits = await client.request("textDocument/formatting", { ...named(document), options });
        return (edits || []).map((edit) => vscode.TextEdit.replace(range(edit.range), edit.newText));
      },
    }),
  ];
}

module.exports = { register, finding, place };
