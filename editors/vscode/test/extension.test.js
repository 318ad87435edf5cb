// The extension against a stub of the editor's API and the real server. `SCENARIO_RUNNER` is the program.
"use strict";

const assert = require("assert");
const fs = require("fs");
const Module = require("module");
const os = require("os");
const path = require("path");
const { execFileSync } = require("child_process");
const { editor } = require("./stub/vscode");

const PROGRAM = process.env.SCENARIO_RUNNER;
const STREET = "road street { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\n";
const scenario = (name, criterion) => `scenario ${name} {
  road street
  vehicle av { controller constant_speed; speed 36 km/h; start 40 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears when time_to_arrival(av) = tta }
  vary tta in [2 s, 3 s]
  expect { ${criterion} }
}
`;
const WALK = `use "street.scn"\n${scenario("good", "impact_speed <= 60 m/s undefined passes")}${scenario("bad", "min_ttc >= 19 s undefined fails")}`;

const whole = { start: { line: 0, character: 0 }, end: { line: 99, character: 0 } };
const never = { isCancellationRequested: false, onCancellationRequested: () => ({ dispose() {} }) };

/** Waits until something is so. */
async function until(holds, what) {
  for (let tries = 0; tries < 600; tries++) {
    if (holds()) return;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  assert.fail(`it never came that ${what}`);
}

/** The extension in an editor of its own, with the folder that it has open. */
function loaded(settings = { path: PROGRAM, results: [] }) {
  const folder = fs.realpathSync(fs.mkdtempSync(path.join(os.tmpdir(), "scenario-runner-extension-")));
  fs.writeFileSync(path.join(folder, "street.scn"), STREET);
  fs.writeFileSync(path.join(folder, "walk.scn"), WALK);
  const own = editor(folder, settings);
  own.state.files = [own.api.Uri.file(path.join(folder, "walk.scn"))];
  const load = Module._load;
  Module._load = (name, ...others) => (name === "vscode" ? own.api : load(name, ...others));
  const extension = path.join(__dirname, "..");
  for (const known of Object.keys(require.cache)) {
    if (path.dirname(known) === extension) delete require.cache[known];
  }
  const required = (name) => require(path.join(extension, name));
  const modules = { extension: required("extension.js"), explorer: required("explorer.js"), sketch: required("sketch.js") };
  Module._load = load;
  return { ...own, ...modules, folder, at: (name) => path.join(folder, name), context: { subscriptions: [] } };
}

/** A program that does what a shell script says. */
function program(own, script) {
  const file = own.at("program");
  fs.writeFileSync(file, `#!/bin/sh\n${script}\n`, { mode: 0o755 });
  return file;
}

describe("the extension", function () {
  this.timeout(60000);
  let own;
  beforeEach(() => {
    own = loaded();
  });
  afterEach(async () => {
    await own.extension.deactivate();
    fs.rmSync(own.folder, { recursive: true, force: true });
  });

  const opened = async (text = WALK) => {
    await own.extension.activate(own.context);
    const document = own.document(own.at("walk.scn"), text);
    await until(() => own.state.findings.has(document.uri.fsPath), "findings are shown");
    return document;
  };
  const ask = (kind, method, ...parameters) => own.state.providers[kind][method](...parameters);

  it("shows findings with their severities, and takes them away", async () => {
    const document = await opened(WALK.replace("36 km/h", "36 kmh"));
    const [found] = own.state.findings.get(document.uri.fsPath);
    assert.deepStrictEqual([found.code, found.severity, found.source], ["E0401", 0, "scenario-runner"]);
    own.type(document, WALK);
    await until(() => own.state.findings.get(document.uri.fsPath).length === 0, "nothing is wrong");
  });

  it("answers with what the editor asks for", async () => {
    const document = await opened();
    const at = { line: 3, character: 11 };
    assert.match((await ask("Hover", "provideHover", document, { line: 3, character: 3 })).contents.value, /vehicle/);
    const hints = await ask("InlayHints", "provideInlayHints", document, whole);
    assert.deepStrictEqual(hints.map((one) => one.label), ["= 10 m/s", "= 10 m/s"]);
    const tokens = await ask("DocumentSemanticTokens", "provideDocumentSemanticTokens", document);
    assert.ok(tokens.data instanceof Uint32Array && tokens.data.length % 5 === 0 && tokens.data.length > 100);
    const references = await ask("Reference", "provideReferences", document, at, { includeDeclaration: true });
    assert.deepStrictEqual(references.map((one) => one.range.start.line), [3, 4]);
    const place = await ask("Rename", "prepareRename", document, at);
    assert.strictEqual(place.placeholder, "av");
    const { edits } = await ask("Rename", "provideRenameEdits", document, at, "ego");
    assert.deepStrictEqual(edits.map((one) => one.newText), ["ego", "ego"]);
    await assert.rejects(ask("Rename", "provideRenameEdits", document, at, "walker"), /already/);
    await assert.rejects(ask("Rename", "prepareRename", document, { line: 3, character: 3 }), /here stands none/);
    const symbols = await ask("WorkspaceSymbol", "provideWorkspaceSymbols", "");
    assert.deepStrictEqual(symbols.map((one) => one.name).sort(), ["bad", "good", "street"]);
    assert.strictEqual(symbols.find((one) => one.name === "good").kind, 11);
    const formatted = await ask("DocumentFormattingEdit", "provideDocumentFormattingEdits", document, { tabSize: 2, insertSpaces: true });
    assert.strictEqual(formatted.length, 1);
  });

  it("offers fixes for what is shown", async () => {
    const document = await opened(WALK.replace("36 km/h", "36 kmh"));
    const diagnostics = own.state.findings.get(document.uri.fsPath);
    const [action] = await ask("CodeActions", "provideCodeActions", document, diagnostics[0].range, { diagnostics });
    assert.deepStrictEqual([action.title, action.edit.edits[0].newText, action.diagnostics], ["Write `km/h`", "km/h", diagnostics]);
  });

  it("starts the program of a lens without a shell, and shows what came of it until the text changes", async () => {
    const document = await opened();
    const lenses = async () => ask("CodeLens", "provideCodeLenses", document);
    const run = (await lenses()).find((one) => one.command.title === "Run" && one.range.start.line === 8);
    await own.state.commands[run.command.command](...run.command.arguments);
    const [{ execution }] = own.state.tasks;
    assert.strictEqual(execution.process, PROGRAM);
    assert.strictEqual(execution.options.cwd, own.folder);
    assert.ok(Array.isArray(execution.args) && execution.args.includes("scenario(=bad)"));
    assert.throws(() => execFileSync(execution.process, execution.args, { cwd: own.folder, stdio: "ignore" }));
    for (const { created } of own.state.watchers) created.fire(own.api.Uri.file(own.at("results.json")));
    const titles = async () => (await lenses()).filter((one) => one.range.start.line === 8).map((one) => one.command.title);
    assert.deepStrictEqual(await titles(), ["Run", "Replay worst", "last run failed: 2 of 2 trials"]);
    await until(() => own.state.findings.get(document.uri.fsPath).some((one) => one.source === "last run"), "failures are findings");
    own.type(document, WALK.replace("19 s", "18 s"));
    assert.match((await titles())[2], /^stale \(walk\.scn has changed\): last run failed/);
  });

  it("runs nothing in a folder that is not trusted", async () => {
    await opened();
    own.api.workspace.isTrusted = false;
    await own.state.commands["scenarioRunner.run"]({ folder: own.folder, arguments: ["run", "walk.scn"], name: "walk" });
    await own.state.profile.run({ include: undefined }, never);
    await own.state.controller.resolveHandler(undefined);
    assert.deepStrictEqual([own.state.tasks, own.state.runs, own.state.controller.items.size], [[], [], 0]);
    assert.strictEqual(own.state.messages.length, 2);
  });

  it("draws the scenario at the cursor on a page without scripts", async () => {
    const document = await opened();
    own.select(document, 3);
    await own.state.commands["scenarioRunner.sketch"]();
    const [panel] = own.state.panels;
    assert.match(panel.webview.html, /<svg/);
    assert.match(panel.webview.html, /default-src 'none'/);
    assert.ok(!/<script/i.test(panel.webview.html) && panel.options.enableScripts === false);
    assert.match(panel.title, /walk\/good/);
    assert.ok(!own.sketch.page({ message: "<script>alert(1)</script>" }).includes("<script>"));
  });

  it("says that a program is missing, and does not wait for it", async () => {
    const lost = loaded({ path: "/nowhere/scenario-runner", results: [] });
    await assert.rejects(lost.extension.activate(lost.context));
    assert.match(lost.state.messages[0], /scenarioRunner\.path/);
    fs.rmSync(lost.folder, { recursive: true, force: true });
  });

  describe("test explorer", () => {
    const discovered = async () => {
      await own.extension.activate(own.context);
      await own.state.controller.resolveHandler(undefined);
      const [file] = [...own.state.controller.items.values()];
      return file;
    };

    it("lists scenarios where they stand, runs those that are wanted, and shows what came of each", async () => {
      const file = await discovered();
      const items = [...file.children.values()];
      assert.deepStrictEqual(items.map((one) => [one.id, one.range.start.line]), [["walk/good", 1], ["walk/bad", 8]]);
      await own.state.profile.run({ include: undefined }, never);
      let [run] = own.state.runs;
      assert.deepStrictEqual([...run.results], [["walk/good", "passed"], ["walk/bad", "failed"]]);
      assert.match(run.messages.get("walk/bad"), /min_ttc/);
      assert.ok(run.ended && run.output.length > 0);
      await own.state.profile.run({ include: [items[0]] }, never);
      [, run] = own.state.runs;
      assert.deepStrictEqual([...run.results], [["walk/good", "passed"]]);
      await own.state.profile.run({ include: [file], exclude: [items[1]] }, never);
      assert.deepStrictEqual([...own.state.runs[2].results], [["walk/good", "passed"]]);
    });

    const outcome = async (script, key = "walk/good") => {
      const command = script === undefined ? "/nowhere/scenario-runner" : program(own, script);
      const found = await own.explorer.outcomes(command, "walk.scn", [key], own.folder, never);
      return found.get(key);
    };
    /** A program that writes results where it is told to and ends with a code. */
    const writes = (text, code) => `while [ "$1" != --json ]; do shift; done\ncat > "$2" <<'END'\n${text}\nEND\nexit ${code}`;
    const results = (trials, more = {}) => JSON.stringify({ suites: [{ suite: "walk", trials, ...more }] });
    const trial = (verdict, more = {}) => ({ key: "walk/good/tta=2s", scenario: "good", verdict, ...more });

    it("never shows as passed what did not run and pass", async () => {
      for (const [script, expected] of [
        [undefined, "errored"],
        ["exit 0", "errored"],
        ["exit 101", "errored"],
        ["kill -9 $$", "errored"],
        [writes("{", 0), "errored"],
        [writes("null", 0), "errored"],
        [writes("{}", 0), "errored"],
        [writes('{"suites": 5}', 0), "errored"],
        [writes(results([]), 0), "errored"],
        [writes(results([trial("passed", { scenario: "bad" })]), 0), "errored"],
        [writes(results([trial("passed")]).replace('"walk"', '"other"'), 0), "errored"],
        [writes(results([trial("passed")]), 100), "errored"],
        [writes(results([trial("error")]), 102), "errored"],
        [writes(results([trial("passed")], { interrupted: true }), 0), "skipped"],
        [writes(results([trial("passed"), trial("not_finished")]), 100), "skipped"],
        [writes(results([trial("passed"), trial("skipped")]), 0), "skipped"],
        [writes(results([trial("inconclusive")]), 100), "failed"],
        [writes(results([trial("passed"), trial("failed")]), 100), "failed"],
        [writes(results([trial("something else")]), 0), "skipped"],
        [writes(results([trial("passed")]), 0), "passed"],
      ]) {
        const found = await outcome(script);
        assert.strictEqual(found.outcome, expected, `${script}: ${JSON.stringify(found)}`);
      }
    });

    it("ends the program when it is cancelled, and shows nothing as passed", async () => {
      const started = own.at("started");
      const command = program(own, `touch "${started}"\nexec sleep 60`);
      let cancel;
      const token = {
        isCancellationRequested: false,
        onCancellationRequested: (listener) => {
          cancel = () => {
            token.isCancellationRequested = true;
            listener();
          };
          return { dispose() {} };
        },
      };
      const begun = Date.now();
      const running = own.explorer.outcomes(command, "walk.scn", ["walk/good"], own.folder, token);
      await until(() => fs.existsSync(started), "it has begun");
      cancel();
      assert.strictEqual((await running).get("walk/good").outcome, "skipped");
      assert.ok(Date.now() - begun < 30000);
    });
  });
});
