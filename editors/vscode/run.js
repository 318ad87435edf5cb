// Starts the program for code lenses: a task in the editor's terminal, without a shell.
"use strict";

const vscode = require("vscode");

/** Whether programs may be started: what a folder holds is not run before its user trusts it. */
function isTrusted() {
  if (vscode.workspace.isTrusted) return true;
  vscode.window.showWarningMessage("scenario-runner: nothing is run in a folder that is not trusted");
  return false;
}

/** Starts the program with the arguments of a lens; the terminal shows what it says. */
async function run(command, { folder, arguments: words, name }) {
  if (!isTrusted()) return undefined;
  await vscode.workspace.saveAll(false);
  const execution = new vscode.ProcessExecution(command, words, { cwd: folder });
  const definition = { type: "scenario-runner", arguments: words };
  const task = new vscode.Task(definition, vscode.TaskScope.Workspace, name, "scenario-runner", execution);
  task.presentationOptions = { clear: true };
  return vscode.tasks.executeTask(task);
}

module.exports = { run, isTrusted };
