// The scenarios and suites of the workspace in the editor's test explorer.
//
// What is shown as passed was run now and passed: whatever else happens is a failure, an error or skipped.
"use strict";

const { spawn } = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");
const vscode = require("vscode");
const { isTrusted } = require("./run");

const PATTERN = "**/*.{scn,suite}";
/** More files are not listed. */
const MOST_FILES = 2000;
/** Larger results are not read, bytes. */
const LARGEST = 256 * 1024 * 1024;

/** The program to its end: its exit code, `undefined` if it was ended or could not be started, and what it wrote. */
function ended(command, words, cwd, token, said = () => {}) {
  return new Promise((resolve) => {
    const child = spawn(command, words, { cwd, shell: false, stdio: ["ignore", "pipe", "pipe"] });
    const pieces = [];
    let errors = "";
    const stopping = token && token.onCancellationRequested(() => child.kill());
    const done = (code, error) => {
      if (stopping) stopping.dispose();
      resolve({ code, error, output: Buffer.concat(pieces).toString(), errors });
    };
    child.stdout.on("data", (data) => {
      pieces.push(data);
      said(data.toString());
    });
    child.stderr.on("data", (data) => {
      errors = (errors + data.toString()).slice(-20000);
      said(data.toString());
    });
    child.on("error", (error) => done(undefined, error.message));
    child.on("close", (code, signal) => done(signal ? undefined : code, signal ? `ended by ${signal}` : undefined));
  });
}

/** The scenarios of a file as the program lists them; nothing if it cannot be read, which its findings say. */
async function listed(command, file, cwd) {
  const { code, output } = await ended(command, ["list", file, "--format", "json"], cwd);
  if (code !== 0) return [];
  try {
    return JSON.parse(output).listed.filter((one) => one.kind === "scenario");
  } catch {
    return [];
  }
}

/**
 * What results say of a scenario: `{ outcome, message }`. Only where each trial that there is passed has it passed.
 * `key` is SUITE/SCENARIO, as `list` gives it.
 */
function judged(document, key) {
  const suites = document && Array.isArray(document.suites) ? document.suites : [];
  const trials = suites.flatMap((suite) =>
    (suite.trials || []).filter((trial) => `${suite.suite}/${trial.scenario}` === key),
  );
  if (trials.length === 0) return { outcome: "errored", message: `the results hold no trial of ${key}` };
  if (suites.some((suite) => suite.interrupted)) return { outcome: "skipped", message: "it was interrupted" };
  const words = (trial) => {
    const broken = (trial.findings || []).filter((one) => one.verdict !== "passed");
    const said = broken.map((one) => `${one.criterion}: ${one.verdict}`);
    return [`${trial.key}: ${trial.verdict}`, ...said, ...(trial.message ? [trial.message] : [])].join("\n  ");
  };
  const of = (verdict) => trials.filter((trial) => trial.verdict === verdict);
  const failed = [...of("failed"), ...of("inconclusive")];
  if (failed.length > 0) return { outcome: "failed", message: failed.map(words).join("\n") };
  const others = trials.filter((trial) => trial.verdict !== "passed");
  if (others.some((trial) => trial.verdict === "error")) return { outcome: "errored", message: others.map(words).join("\n") };
  if (others.length > 0) return { outcome: "skipped", message: others.map(words).join("\n") };
  return { outcome: "passed" };
}

/** Runs scenarios of a file and reads what came of it: for each name `{ outcome, message }`. */
async function outcomes(command, file, keys, cwd, token, said) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "scenario-runner-"));
  const all = (outcome, message) => new Map(keys.map((key) => [key, { outcome, message }]));
  try {
    const results = path.join(folder, "results.json");
    // Names are words of the language: nothing in them means anything in a filter.
    const filters = keys.flatMap((key) => ["-E", `scenario(=${key})`]);
    const { code, error, errors } = await ended(command, ["run", file, ...filters, "--json", results], cwd, token, said);
    if (token && token.isCancellationRequested) return all("skipped", "it was cancelled");
    if (code === undefined) return all("errored", `${command}: ${error}`);
    let document;
    try {
      if (fs.statSync(results).size > LARGEST) return all("errored", "the results are too large to be read");
      document = JSON.parse(fs.readFileSync(results, "utf8"));
    } catch (unread) {
      return all("errored", `no results (exit code ${code}): ${errors.trim() || unread.message}`);
    }
    const found = new Map(keys.map((key) => [key, judged(document, key)]));
    // The program says by 0 that everything passed: results that say so of a run that ended otherwise are not believed.
    for (const [key, { outcome }] of found) {
      const failed = [...found.values()].some((one) => one.outcome !== "passed");
      if (outcome === "passed" && code !== 0 && !failed) {
        found.set(key, { outcome: "errored", message: `it passed, and the program ended with ${code}: ${errors.trim()}` });
      }
    }
    return found;
  } finally {
    fs.rmSync(folder, { recursive: true, force: true });
  }
}

/** The controller of the test explorer. */
function explorer(commandOf) {
  const controller = vscode.tests.createTestController("scenario-runner", "scenario-runner");
  const folderOf = (uri) => {
    const folder = vscode.workspace.getWorkspaceFolder(uri);
    return folder ? folder.uri.fsPath : path.dirname(uri.fsPath);
  };

  const add = async (uri) => {
    const cwd = folderOf(uri);
    const scenarios = await listed(commandOf(), path.relative(cwd, uri.fsPath), cwd);
    if (scenarios.length === 0) {
      controller.items.delete(uri.toString());
      return;
    }
    const item = controller.createTestItem(uri.toString(), path.relative(cwd, uri.fsPath), uri);
    for (const one of scenarios) {
      const child = controller.createTestItem(one.name, one.name.split("/").pop(), vscode.Uri.file(path.resolve(cwd, one.file)));
      child.range = new vscode.Range(one.line - 1, 0, one.line - 1, 0);
      item.children.add(child);
    }
    controller.items.add(item);
  };

  controller.resolveHandler = async (item) => {
    // Listing starts the program.
    if (item || !vscode.workspace.isTrusted) return;
    for (const uri of await vscode.workspace.findFiles(PATTERN, "**/{target,node_modules}/**", MOST_FILES)) await add(uri);
  };

  const run = async (request, token) => {
    if (!isTrusted()) return;
    const test = controller.createTestRun(request);
    const left = new Set((request.exclude || []).map((item) => item.id));
    const wanted = new Map();
    const want = (file, scenario) => {
      if (left.has(file.id) || left.has(scenario.id)) return;
      const known = wanted.get(file) || new Set();
      wanted.set(file, known.add(scenario));
    };
    const everything = [];
    controller.items.forEach((item) => everything.push(item));
    for (const item of request.include || everything) {
      if (item.parent) want(item.parent, item);
      else item.children.forEach((scenario) => want(item, scenario));
    }
    for (const [file, scenarios] of wanted) {
      scenarios.forEach((one) => test.enqueued(one));
      if (token.isCancellationRequested) {
        scenarios.forEach((one) => test.skipped(one));
        continue;
      }
      scenarios.forEach((one) => test.started(one));
      const cwd = folderOf(file.uri);
      const keys = [...scenarios].map((one) => one.id);
      const said = (text) => test.appendOutput(text.replace(/\r?\n/g, "\r\n"));
      const found = await outcomes(commandOf(), path.relative(cwd, file.uri.fsPath), keys, cwd, token, said);
      for (const one of scenarios) {
        const { outcome, message } = found.get(one.id);
        if (outcome === "passed" || outcome === "skipped") test[outcome](one);
        else test[outcome](one, new vscode.TestMessage(message));
      }
    }
    test.end();
  };
  const profile = controller.createRunProfile("Run", vscode.TestRunProfileKind.Run, run, true);
  const watcher = vscode.workspace.createFileSystemWatcher(PATTERN);
  const renew = (uri) => (vscode.workspace.isTrusted ? add(uri) : undefined);
  watcher.onDidCreate(renew);
  watcher.onDidChange(renew);
  watcher.onDidDelete((uri) => controller.items.delete(uri.toString()));
  return { controller, dispose: () => [watcher, profile, controller].forEach((one) => one.dispose()) };
}

module.exports = { explorer, outcomes, judged, listed };
