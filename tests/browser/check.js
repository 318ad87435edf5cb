// Opens reports as people do, and compares them with what the program wrote as JSON. `check` says what it needs.
"use strict";
const assert = require("node:assert");
const fs = require("node:fs");
const path = require("node:path");
const { spawnSync } = require("node:child_process");
const { pathToFileURL } = require("node:url");
const { chromium } = require("playwright-core");

const [folder, ...options] = process.argv.slice(2);
assert(options.every((option) => option === "--quick"), options.join(" "));
const quick = options.length > 0;
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const WIDTHS = [1400, 820, 390];
const THEMES = quick ? ["light"] : ["light", "dark"];
const program = process.env.SCENARIO_RUNNER;
assert(program, "SCENARIO_RUNNER names the program");
const pictures = path.join(folder, "pictures");
fs.mkdirSync(pictures, { recursive: true });

const reports = fs.readdirSync(folder).filter((name) => name.endsWith(".html")).map((name) => path.basename(name, ".html"));
const expected = ["late_perception", "two_variations", ...(quick ? [] : ["diff", "gentle_braking", "worst_arrival", "zebra_gate", "zebra_unsafe"])];
assert.deepStrictEqual([...reports].sort(), expected.sort(), "the reports are those of the check");
const address = (name) => pathToFileURL(path.join(folder, `${name}.html`)).href;

// Opens a page of a browser of its own, and collects whatever goes wrong in it.
const open = async (browser, options, name, hash = "") => {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, ...options });
  const page = await context.newPage(), wrong = [];
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) wrong.push(message.text()); });
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("request", (request) => { if (!request.url().startsWith("file:") && !request.url().startsWith("data:")) wrong.push(`asks for ${request.url()}`); });
  await page.goto(address(name) + hash);
  const close = async () => {
    assert.deepStrictEqual(wrong, [], `${name}: nothing goes wrong`);
    await context.close();
  };
  return { page, close };
};

// Leaves a picture for people to look at; a quick check leaves none. A busy machine has failed once to capture one: there is a second attempt.
const picture = async (page, file, options = {}) => {
  if (quick) return;
  const capture = () => page.screenshot({ path: path.join(pictures, file), ...options });
  await capture().catch(capture);
};

// Every width and theme: nothing is wider than the page, and axe-core has no serious finding.
const looks = async (browser, name) => {
  for (const colorScheme of THEMES) {
    for (const width of WIDTHS) {
      const { page, close } = await open(browser, { colorScheme, viewport: { width, height: 900 }, reducedMotion: "reduce" }, name);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert(wide <= 0, `${name} at ${width}: ${wide} px too wide`);
      await picture(page, `${name}_${width}_${colorScheme}.png`, { fullPage: true });
      if (colorScheme === "light" ? width === 820 : width !== 390) {
        await close();
        continue;
      }
      // What is folded is looked at, too.
      await page.evaluate(() => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
      const found = await audit(page);
      const serious = found.filter((one) => ["serious", "critical"].includes(one.impact));
      const told = serious.map((one) => `${one.id}: ${one.help}\n${one.nodes.slice(0, 5).map((node) => `  ${node.target}: ${node.failureSummary}`).join("\n")}`);
      assert.deepStrictEqual(told, [], `${name} at ${width}, ${colorScheme}: axe-core finds nothing serious`);
      await close();
    }
  }
};

const audit = async (page) => {
  await page.evaluate(axe);
  return page.evaluate(async () => (await globalThis.axe.run(document, { resultTypes: ["violations"] })).violations);
};

// What the clock of the player shows, s.
const time = (page) => page.locator("#clock").evaluate((clock) => parseFloat(clock.value));

// Without JavaScript, printed, and for whom nothing is to move.
const quiet = async (browser, name) => {
  const plain = await open(browser, { javaScriptEnabled: false }, name);
  assert(await plain.page.locator("h1").isVisible() && await plain.page.locator(".verdict").isVisible());
  if (await plain.page.locator("#view").count()) assert(await plain.page.locator("#view .vehicle").first().isVisible(), `${name}: a picture without JavaScript`);
  await plain.close();
  const printed = await open(browser, {}, name);
  await printed.page.emulateMedia({ media: "print" });
  await printed.page.pdf({ path: path.join(pictures, `${name}.pdf`), format: "A4" });
  await printed.close();
  const still = await open(browser, { reducedMotion: "reduce" }, name);
  if (await still.page.locator("#clock").count()) {
    const before = await time(still.page);
    await still.page.waitForTimeout(300);
    assert.strictEqual(await time(still.page), before, `${name}: nothing moves for who asked for that`);
  }
  await still.close();
};

// The player by keyboard alone: reached by Tab, played by Space, scrubbed by arrows.
const player = async (browser, name) => {
  const { page, close } = await open(browser, { reducedMotion: "reduce" }, name);
  const at = (id) => page.evaluate((wanted) => document.activeElement && document.activeElement.id === wanted, id);
  let presses = 0;
  while (!(await at("play"))) {
    assert(presses++ < 60, `${name}: Tab reaches the player`);
    await page.keyboard.press("Tab");
  }
  await page.keyboard.press("Space");
  await page.waitForTimeout(400);
  await page.keyboard.press("Space");
  const stopped = await time(page);
  await page.waitForTimeout(200);
  assert.strictEqual(await time(page), stopped, `${name}: it stands where it was stopped`);
  while (!(await at("time"))) {
    assert(presses++ < 80, `${name}: Tab reaches the slider`);
    await page.keyboard.press("Tab");
  }
  await page.keyboard.press("Home");
  assert.strictEqual(await time(page), 0);
  const cursor = () => page.locator(".plots:not([hidden]) .cursor").first().getAttribute("x1");
  const before = await cursor();
  for (let press = 0; press < 20; press++) await page.keyboard.press("ArrowRight");
  assert(await time(page) > 0, `${name}: arrows scrub`);
  assert.notStrictEqual(await cursor(), before, `${name}: the line over the plots goes along`);
  await close();
};

// Two runs beside each other, at the same time.
const beside = async (browser, name) => {
  const { page, close } = await open(browser, { reducedMotion: "reduce" }, name);
  assert(!(await page.locator("#second").isVisible()), `${name}: one run alone`);
  await page.locator("#also").selectOption({ index: 2 });
  assert(await page.locator("#view2 rect.vehicle").first().isVisible() && (await page.locator("#sentence2").textContent()).length > 10);
  const place = () => page.locator("#view2 g:has(> rect.vehicle)").first().getAttribute("transform");
  await page.locator("#time").fill("0.5");
  const before = await place();
  await page.locator("#time").fill("2.5");
  assert.notStrictEqual(await place(), before, `${name}: the run beside moves, too`);
  await picture(page, `${name}_beside.png`);
  const chosen = await page.locator("#also").inputValue();
  await page.locator("#choice").selectOption(chosen);
  assert(!(await page.locator("#second").isVisible()), `${name}: no run stands beside itself`);
  await close();
};

// Two sides of one run under one slider: both have the same key, and each is drawn by itself.
const sides = async (browser, name) => {
  const { page, close } = await open(browser, { reducedMotion: "reduce" }, name);
  // How far along the road, m; what is up and down is each picture's own.
  const place = async (view) => /translate\(([-.\d]+)/.exec(await page.locator(`#${view} g:has(> rect.vehicle)`).first().getAttribute("transform"))[1];
  assert.notStrictEqual(await page.locator("#sentence").textContent(), await page.locator("#sentence2").textContent());
  await page.locator("#time").fill("0");
  assert.strictEqual(await place("view"), await place("view2"), `${name}: both begin alike`);
  const before = await place("view2"), last = await page.locator("#time").getAttribute("max");
  await page.locator("#time").fill(last);
  assert.notStrictEqual(await place("view2"), before, `${name}: both move`);
  assert.notStrictEqual(await place("view"), await place("view2"), `${name}: the two part`);
  await page.locator("#why button").first().click();
  assert(await time(page) < +last, `${name}: a moment is gone to`);
  await close();
};

// Where controllers perceive others late, others have a second outline where they are perceived, with and without JavaScript; and margins are drawn.
// In the report `without` controllers perceive others as they are, and none has an outline.
const perceived = async (browser, name, without) => {
  const { page, close } = await open(browser, { reducedMotion: "reduce" }, name);
  const seen = () => page.locator("#view g:has(> title):not([visibility=hidden]) .ghost").count();
  assert(await page.locator("#ghosts").isVisible(), `${name}: the legend says what they are`);
  await page.locator("#time").fill("0");
  assert.strictEqual(await seen(), 0, `${name}: none before anybody decides`);
  await page.locator("#time").fill("4");
  assert(await seen() > 1, `${name}: outlines where they are perceived`);
  assert.match(await page.locator("#states").textContent(), /perceives walker \d+\.\d\d m from where they are, moving at \d+\.\d m\/s, 0\.\d+ s late/);
  await page.locator("#also").selectOption({ index: 2 });
  assert(await page.locator("#view2 .ghost").count() > 1, `${name}: beside it, too`);
  assert(await page.locator(".plots:not([hidden]) svg", { hasText: "Margins of criteria" }).count() > 1, `${name}: margins`);
  await picture(page, `${name}_perceived.png`);
  await close();
  const plain = await open(browser, { javaScriptEnabled: false }, name);
  assert(await plain.page.locator("#view .ghost").first().isVisible(), `${name}: an outline without JavaScript`);
  assert(await plain.page.locator("#ghosts").isVisible());
  await plain.close();
  const none = await open(browser, { reducedMotion: "reduce" }, without);
  assert(!(await none.page.locator("#ghosts").isVisible()) && await none.page.locator(".ghost:not(.swatch *)").count() === 0, "who sees everything has none");
  await none.close();
};

// Tables are sorted by a click and by Enter, and filtered.
const tables = async (browser, name) => {
  const { page, close } = await open(browser, {}, name);
  await page.evaluate(() => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
  const table = page.locator("table.sortable", { has: page.locator("tbody tr:nth-child(8)") }).first();
  const column = () => table.evaluate((one) => [...one.tBodies[0].rows].filter((row) => !row.hidden).map((row) => row.cells[0].textContent.trim()));
  const before = await column(), heading = table.locator("thead button").first();
  await heading.focus();
  await page.keyboard.press("Enter");
  const rising = await column();
  await heading.click();
  const falling = await column();
  assert.deepStrictEqual([...rising].sort(), [...before].sort(), `${name}: sorting loses no row`);
  assert.notDeepStrictEqual(rising, falling, `${name}: sorted the other way round`);
  const filter = page.locator(".filter input").first(), wanted = before[1];
  await filter.fill(wanted);
  const left = await column();
  assert(left.length > 0 && left.length < before.length && left.includes(wanted), `${name}: filtered`);
  await close();
};

// What the page says of two sides is what JSON says: metrics that are lengths, times and speeds.
const metrics = async (browser, name) => {
  const told = JSON.parse(fs.readFileSync(path.join(folder, `${name}.json`), "utf8"));
  const { page, close } = await open(browser, {}, name);
  const rows = await page.locator("#results .sortable tbody tr").evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.innerText.trim())));
  let compared = 0;
  for (const [metric, ...sides] of rows) {
    const { a, b } = told.metrics.find((one) => one.metric === metric);
    for (const [text, value] of [[sides[0], a], [sides[1], b]]) {
      const said = text.match(/^(-?[\d.]+) (m|s|m\/s)$/);
      if (!said || typeof value !== "number") continue;
      assert(Math.abs(+said[1] - value) <= 0.006 * Math.abs(value) + 1e-3, `${metric}: ${text} is ${value}`);
      compared += 1;
    }
  }
  assert(compared > 2, `${compared} metrics of two sides`);
  await close();
  return compared;
};

// What the page says is what JSON says.
const numbers = async (browser, name) => {
  const results = JSON.parse(fs.readFileSync(path.join(folder, `${name}.json`), "utf8"));
  const { page, close } = await open(browser, {}, name);
  let compared = 0;
  for (const trial of results.suites.flatMap((suite) => suite.trials)) {
    const row = await page.evaluate((key) => {
      const found = document.getElementById(key);
      return found && [...found.cells].map((cell) => ({ text: cell.innerText.trim(), kind: cell.className }));
    }, trial.key);
    if (!row) continue;
    const failed = trial.findings.some((one) => one.verdict === "failed");
    assert.strictEqual(row[1].kind === "failed", failed, `${trial.key}: its verdict`);
    for (const finding of trial.findings) {
      const place = await page.evaluate(({ key, text }) => {
        const headings = [...document.getElementById(key).closest("table").tHead.rows[0].cells];
        return headings.findIndex((heading) => heading.textContent.trim() === text);
      }, { key: trial.key, text: finding.criterion });
      if (place < 0) continue;
      const said = row[place].text.match(/^\S+\s+(-?[\d.]+) (%|s|m\/s\^2|m)(?![\w/^])/);
      if (!said || typeof finding.observed !== "number") continue;
      const value = +said[1] / (said[2] === "%" ? 100 : 1);
      assert(Math.abs(value - finding.observed) <= 0.006 * Math.abs(finding.observed) + 1e-9, `${trial.key}, ${finding.criterion}: ${row[place].text} is ${finding.observed}`);
      compared += 1;
    }
  }
  const all = results.suites.flatMap((suite) => suite.trials).length;
  const failed = results.suites.flatMap((suite) => suite.trials).filter((trial) => trial.findings.some((one) => one.verdict === "failed")).length;
  // Where there is more than trials, all of it is counted together.
  const others = results.suites.flatMap((suite) => [...suite.blocks, ...suite.gates]).length;
  if (!others) {
    const tile = (kind) => page.locator(`.tiles .${kind} b`).first().textContent().then(Number);
    assert.strictEqual(await tile("failed"), failed, `${name}: failed`);
    assert.strictEqual(await tile("passed"), all - failed, `${name}: passed`);
  }
  await close();
  return compared;
};

// Links name runs and trials; marks of charts open their runs, or say how to see them, which is then done.
const links = async (browser, name) => {
  const { page, close } = await open(browser, { reducedMotion: "reduce" }, name);
  const watch = page.locator("a.watch:visible").last();
  const wanted = (await watch.getAttribute("href")).slice("#run=".length);
  await watch.click();
  const chosen = () => page.locator("#choice").evaluate((list) => list.selectedOptions[0].textContent);
  assert((await chosen()).startsWith(decodeURI(wanted)), `${name}: the link leads to its run`);
  const click = (selector) => page.locator(selector).first().dispatchEvent("click");
  await click(".figures .opens");
  const opened = await page.locator(".figures .opens").first().getAttribute("data-run");
  await page.waitForFunction((key) => document.getElementById("choice").selectedOptions[0].textContent.startsWith(key), opened);
  await click(".figures [data-run]:not(.opens)");
  const command = await page.locator(".pointed code").first().textContent();
  const key = await page.locator(".figures [data-run]:not(.opens)").first().getAttribute("data-run");
  assert(command.includes(`'${key}'`), command);
  const words = command.match(/'[^']*'|\S+/g).map((word) => word.replace(/^'|'$/g, ""));
  assert.strictEqual(words.shift(), "scenario-runner");
  const again = spawnSync(program, words, { encoding: "utf8" });
  assert([0, 100].includes(again.status) && again.stdout.includes(key), `${command}: ${again.status} ${again.stderr}`);
  await close();
  // A link that names a run opens the page at it.
  const direct = await open(browser, {}, name, `#run=${wanted}`);
  const there = await direct.page.locator("#choice").evaluate((list) => list.selectedOptions[0].textContent);
  assert(there.startsWith(decodeURI(wanted)), `${name}: a link from elsewhere leads to its run`);
  await direct.close();
};

// A cell of a map leads to its trial.
const map = async (browser, name) => {
  const { page, close } = await open(browser, {}, name);
  const cell = page.locator(".figures a:has(.cell)").nth(3);
  const target = (await cell.getAttribute("href")).slice(1);
  await cell.focus();
  await page.keyboard.press("Enter");
  assert.strictEqual(decodeURI(new URL(page.url()).hash.slice(1)), target);
  assert(await page.evaluate((key) => document.getElementById(key) !== null, target), `${target} is in the page`);
  await close();
};

(async () => {
  const browser = await chromium.launch({ executablePath: process.env.BROWSER || undefined, args: ["--no-sandbox"] });
  let compared = 0;
  const left = [...reports];
  const some = async () => {
    for (let name = left.shift(); name; name = left.shift()) {
      await looks(browser, name);
      await quiet(browser, name);
      const own = await (name === "diff" ? metrics : numbers)(browser, name);
      compared += own;
      console.log(`${name}: ${WIDTHS.join(", ")} px, ${THEMES.join(" and ")}, no script, print, ${own} numbers`);
    }
  };
  await Promise.all([some(), some()]);
  assert(compared > 20, `${compared} numbers were compared`);
  const played = quick ? "late_perception" : "zebra_unsafe";
  await player(browser, played);
  await beside(browser, played);
  if (!quick) {
    await player(browser, "diff");
    await sides(browser, "diff");
  }
  await perceived(browser, "late_perception", quick ? "two_variations" : "zebra_unsafe");
  await tables(browser, "two_variations");
  await links(browser, "two_variations");
  await map(browser, "two_variations");
  console.log(`keyboard, sorting, filters, links, maps; ${compared} numbers are those of JSON (Chromium ${browser.version()})`);
  await browser.close();
})().catch((error) => {
  console.error(error.message || error);
  process.exit(1);
});
