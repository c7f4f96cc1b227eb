// Use the studio in a headless browser as an animator would, and print what came of it:
//
//   node studio.mjs NODE_MODULES CHROMIUM ADDRESS STORY [FOLDER]
//
// A story is one of the functions below. Printed is JSON: `said` and `asked`, the errors and the requests
// to other places of all this; the rest is the story's. FOLDER gets pictures, where one is named.
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { VIEWS, WEBGL, launch, settle, visit, watch } from "./browsing.mjs";

const [modules, chromium, address, story, folder] = process.argv.slice(2);

const browser = await launch(modules, chromium, ...WEBGL, "--autoplay-policy=no-user-gesture-required");
const said = [], asked = [];
const own = new RegExp(`^(${new URL(address).origin}/|data:|blob:)`);

async function show(hash = "", options = {}) {
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 }, ...options });
  watch(page, said, asked, own);
  page.on("response", (one) => one.status() >= 400 && one.status() !== 409 && said.push(`${one.status()} ${one.url()}`));
  await page.goto(address + hash);
  await page.waitForSelector("html[data-ready]", { timeout: 120000 });
  return page;
}

const text = (page, selector) => page.textContent(selector);
const saved = (page) => page.waitForFunction(() => document.querySelector("#save").textContent === "Saved");
const unsaved = (page) => page.waitForFunction(() => /\d/.test(document.querySelector("#save").textContent));
const picture = async (page, name) => folder && page.screenshot({ path: `${folder}/${name}.png` });

/** Speak a line, and wait until its curves are here. */
async function speak(page, line) {
  await page.fill("#text", line);
  await page.press("#text", "Enter");
  await page.waitForFunction(() => document.querySelector("#clock").textContent !== "" && !document.body.classList.contains("busy"), null, { timeout: 120000 });
  await page.evaluate(() => document.activeElement.blur());
  await settle(page);
}

/** The pixels of the face, small. */
const pixels = (page) => page.evaluate(() => {
  const small = Object.assign(document.createElement("canvas"), { width: 64, height: 64 });
  const context = small.getContext("2d");
  context.drawImage(document.querySelector("#faces canvas"), 0, 0, 64, 64);
  return [...context.getImageData(0, 0, 64, 64).data];
});
const differing = (a, b) => a.filter((one, n) => Math.abs(one - b[n]) > 24).length;

/** The points of the pose in front, as [time, value]. */
const points = (page) => page.$$eval(".curve-plot g.front [data-index]", (all) => all.map((one) => one.getAttribute("aria-valuetext")));

/** Wait until the pose in front has these points. */
const become = (page, wanted) => page.waitForFunction((told) => JSON.stringify([...document.querySelectorAll(".curve-plot g.front [data-index]")].map((one) => one.getAttribute("aria-valuetext"))) === told, JSON.stringify(wanted), { timeout: 60000 });

/** Drag a point of the pose in front by pixels. */
async function drag(page, index, right, down) {
  const box = await page.locator(`.curve-plot g.front [data-index="${index}"]`).boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (const share of [0.3, 0.6, 1]) await page.mouse.move(x + share * right, y + share * down);
  await page.mouse.up();
  await settle(page);
}

/** What axe-core finds on a page as it stands, by some of its rules if they are named. */
async function findings(page, name, ...rules) {
  await page.evaluate(readFileSync(`${modules}/axe-core/axe.min.js`, "utf-8"));
  const asked = { resultTypes: ["violations"], ...rules.length && { runOnly: rules } };
  const { violations } = await page.evaluate((chosen) => globalThis.axe.run(chosen), asked);
  return violations.map((one) => [name, one.id, one.impact, ...one.nodes.slice(0, 3).map((node) => node.html.slice(0, 160))]);
}

/** Wait for a word from the test. */
const told = () => new Promise((done) => createInterface({ input: process.stdin }).once("line", done));
const tell = (word) => process.stdout.write(`${word}\n`);

const SCRIPT = `Please buy five more maps before Bob moves away.
The crab walks sideways along the beach, and nobody minds.
My blue boat goes home when the wind comes up.
Would you bring me the big red bucket, please?
`;

const stories = {
  /** The walk of two minutes: hear the line, see why, shape a bigram, undo, save. */
  async walk() {
    const page = await show();
    await speak(page, "Bob bumps my blue boat.");
    await picture(page, "sentence");
    const rest = await pixels(page);
    await page.click('[data-rate="0.25"]'); // time enough for a slow machine to draw frames
    await page.keyboard.press("Escape");
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("Space");
    const heard = [], faces = [rest];
    for (let n = 0; n < 200 && (heard.length < 4 || Math.max(...faces.map((one) => differing(one, rest))) <= 20); n++) {
      const before = await text(page, "#clock");
      await page.waitForFunction((was) => document.querySelector("#clock").textContent !== was, before);
      heard.push(parseFloat((await text(page, "#clock")).replace("−", "-")));
      faces.push(await pixels(page));
    }
    await page.keyboard.press("Space");
    await page.click('[data-rate="1"]');
    await page.evaluate(() => document.activeElement.blur());
    const moved = Math.max(...faces.map((one) => differing(one, rest)));
    await page.evaluate(() => { location.hash = "#bigrams/b-w"; location.hash = "#bigrams/w-bmp"; });
    await page.waitForSelector(".curve-plot g.front [data-index]");
    await settle(page);
    await picture(page, "bigram");
    const before = await points(page);
    await drag(page, 3, 0, -60);
    await unsaved(page);
    const after = await points(page);
    await page.keyboard.press("Control+z");
    await saved(page);
    await become(page, before);
    const undone = await points(page);
    await page.keyboard.press("Control+Shift+z");
    await unsaved(page);
    await become(page, after);
    await page.click('[data-status="approved"]');
    await page.waitForFunction(() => document.querySelector('[data-status="approved"]').getAttribute("aria-pressed") === "true");
    await page.keyboard.press("Control+s");
    await saved(page);
    await settle(page);
    return { heard, moved, before, after, undone, saved: await points(page) };
  },

  /** Everything by keys alone. */
  async keyboard() {
    const page = await show();
    await page.keyboard.press("/");
    await page.keyboard.type("My map");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => !document.body.classList.contains("busy"), null, { timeout: 120000 });
    await page.keyboard.press("Escape");
    const clock = await text(page, "#clock");
    let stepped = clock;
    // a line that opens late goes back to its start
    for (let n = 0; n < 10 && stepped === clock; n++) {
      await page.keyboard.press(".");
      await settle(page);
      stepped = await text(page, "#clock");
    }
    await page.keyboard.press("b");
    await page.waitForSelector(".curve-plot g.front [data-index]");
    const hash = await page.evaluate(() => location.hash);
    await page.focus(".curve-plot g.front [data-index='1']");
    const before = await points(page);
    await page.keyboard.press("ArrowUp");
    await unsaved(page);
    const after = await points(page);
    await page.keyboard.press("Control+z");
    await saved(page);
    await page.keyboard.press("?");
    const keys = await page.$$eval("#help dt", (all) => all.length);
    await page.keyboard.press("Escape");
    await page.keyboard.press("Alt+1");
    await page.waitForFunction(() => location.hash === "#sentence");
    const nameless = await page.$$eval("button, input, select, textarea, [role=slider], [role=application]", (all) => all
      .filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim() || one.closest("label") || one.title)).map((one) => one.outerHTML.slice(0, 80)));
    return { clock, stepped, hash, before, after, keys, nameless };
  },

  /** Two tabs on one bigram, a file that changed on the disk, and a server that is killed. */
  async trouble() {
    const one = await show("#bigrams/w-bmp"), other = await show("#bigrams/w-bmp");
    await Promise.all([one, other].map((page) => page.waitForSelector(".curve-plot g.front [data-index]")));
    await one.bringToFront();
    await drag(one, 3, 0, -40);
    await unsaved(one);
    await other.evaluate(() => dispatchEvent(new Event("focus")));
    await other.bringToFront();
    await unsaved(other);
    await become(other, await points(one));
    await one.bringToFront();
    const shared = JSON.stringify(await points(one)) === JSON.stringify(await points(other));
    await one.keyboard.press("Control+s");
    await saved(one);
    await drag(one, 3, 0, -20);
    await unsaved(one);
    tell("edited"); // the test changes the file
    await told();
    await one.keyboard.press("Control+s");
    await one.waitForSelector("dialog[open] select");
    const conflict = await text(one, "dialog[open] li b");
    const drawn = await one.$$eval("dialog[open] figure", (all) => all.map((figure) => [figure.querySelector("figcaption").textContent, ...[...figure.querySelectorAll("polyline")].map((line) => line.getAttribute("class"))]));
    await picture(one, "conflict");
    const found = await findings(one, "conflict");
    await one.selectOption("dialog[open] select", "mine");
    await one.click("dialog[open] .main");
    await saved(one);
    await drag(one, 3, 0, 50);
    await unsaved(one);
    const last = await points(one);
    await other.evaluate(() => dispatchEvent(new Event("focus")));
    await other.bringToFront();
    await become(other, last); // the server has the last edit of the drag
    await other.close();
    tell("kill"); // the test kills the server, and starts it anew at the same address
    await told();
    said.length = 0; // requests to a dead server are errors of the browser
    await one.goto("about:blank");
    await one.goto(`${address}#bigrams/w-bmp`);
    await one.waitForSelector("html[data-ready]", { timeout: 120000 });
    await one.waitForSelector(".curve-plot g.front [data-index]");
    await unsaved(one);
    return { shared, conflict, drawn, found, kept: JSON.stringify(await points(one)) === JSON.stringify(last) };
  },

  /** Two tabs on one line: what one does, the other shows. */
  async tabs() {
    const one = await show(), other = await show();
    await speak(one, "Bob bumps my blue boat.");
    const follow = (page, text) => page.waitForFunction((told) => document.querySelector("#text").value === told && document.querySelector("#clock").textContent, text, { timeout: 60000 });
    await follow(other, "Bob bumps my blue boat.");
    const jaw = (page) => page.locator("[type=range][aria-label=jaw]").last();
    await jaw(other).evaluate((input) => { input.value = "1.6"; for (const kind of ["input", "change"]) input.dispatchEvent(new Event(kind, { bubbles: true })); });
    await unsaved(one);
    await one.waitForFunction(() => [...document.querySelectorAll("[type=range][aria-label=jaw]")].at(-1).value === "1.6");
    await one.keyboard.press("Control+z");
    await other.waitForFunction(() => [...document.querySelectorAll("[type=range][aria-label=jaw]")].at(-1).value === "1");
    await one.selectOption("#of-character", "facefx");
    await other.waitForSelector("#faces canvas[aria-label='Face of facefx']", { timeout: 60000 });
    return { character: await other.inputValue("#of-character") };
  },

  /** A server that is killed while a line is edited, and started again: the page goes on. */
  async killed() {
    const page = await show();
    await speak(page, "Bob bumps my blue boat.");
    const jaw = page.locator("[type=range][aria-label=jaw]").last();
    const set = (level) => jaw.evaluate((one, value) => {
      one.value = value;
      for (const kind of ["input", "change"]) one.dispatchEvent(new Event(kind, { bubbles: true }));
    }, level);
    const kept = () => page.waitForFunction(() => document.querySelector("#toasts").textContent.includes("was started again"), null, { timeout: 60000 });
    const notices = () => page.$$eval("#toasts li", (all) => all.map((one) => one.textContent));
    await set("1.4");
    await unsaved(page);
    tell("kill");
    await told();
    await set("1.7"); // with no server
    await page.waitForFunction(() => document.querySelector("#toasts").textContent.includes("stopped"), null, { timeout: 60000 });
    const lost = await notices();
    await picture(page, "stopped");
    tell("start");
    await told();
    await kept();
    const found = await notices();
    await picture(page, "back");
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("Undo"));
    said.length = 0; // requests to a dead server are errors of the browser
    await page.keyboard.press("Control+s");
    await saved(page);
    return { lost, found, text: await page.inputValue("#text"), level: await jaw.inputValue() };
  },

  /** A line whose recording lacks a word: it is shown, said, undone, done again and saved. */
  async lacking() {
    const page = await show("#sentence"), words = "[aria-label='Words that are left out']";
    const left = () => page.$$eval(`${words} bdi`, (all) => all.map((one) => one.textContent));
    const stated = (wanted) => page.waitForFunction((marked) => document.querySelector("#text").value.includes("*") === marked, wanted, { timeout: 60000 });
    await page.waitForSelector(`${words}:not([hidden])`, { timeout: 60000 });
    const result = { lines: [await left()], why: await text(page, `${words} .note`) };
    await picture(page, "lacking");
    await page.click(`${words} button`);
    await page.waitForFunction(() => document.querySelector("#toasts").textContent.includes("is spoken now"), null, { timeout: 60000 });
    result.marked = await page.inputValue("#text");
    result.lines.push(await left());
    await page.click("#undo");
    await stated(false);
    await page.waitForSelector(`${words}:not([hidden])`);
    result.lines.push(await left());
    await page.click("#redo");
    await stated(true);
    await page.click("#save");
    await saved(page);
    result.lines.push(await left());
    return result;
  },

  /** The first start: a line is spoken at once; the tour is taken to its end, and again. */
  async tour() {
    const page = await show();
    await page.waitForFunction(() => !document.body.classList.contains("busy"));
    const result = { pair: [await page.inputValue("#of-language"), await page.inputValue("#of-character")], line: await page.inputValue("#text"), seen: await page.isVisible("#timeline") };
    await picture(page, "first");
    await page.click("#toasts button:not([aria-label=Close])");
    await page.waitForSelector(".tour", { timeout: 120000 });
    result.found = await findings(page, "tour");
    const titles = [], outside = [];
    for (;;) {
      titles.push(await text(page, ".tour h2"));
      await settle(page);
      await picture(page, `tour-${titles.length}`);
      const { x, y, width, height } = await page.locator(".tour").boundingBox();
      if (x < 0 || y < 0 || x + width > 1366 || y + height > 768) outside.push(titles.at(-1));
      const last = (await text(page, ".tour .main")) === "Done";
      await page.click(".tour .main");
      if (last) break;
    }
    const left = await page.locator(".tour").count(), focus = await page.evaluate(() => document.activeElement.id);
    await page.click("#keys");
    await page.click("#tours button");
    await page.waitForSelector(".tour", { timeout: 120000 });
    const again = await text(page, ".tour h2");
    return { ...result, titles, outside, left, focus, again, view: await page.evaluate(() => document.body.dataset.view) };
  },

  /** A character: its poses, its targets, its rules and its tongue. */
  async character() {
    const page = await show("#character/poses");
    const face = async () => { await settle(page); return pixels(page); };
    const rest = await face();
    await page.click("#tongue");
    await page.waitForFunction(() => document.querySelector("#tongue").getAttribute("aria-pressed") === "true");
    const through = differing(await face(), rest);
    await page.keyboard.press("x");
    const solid = differing(await face(), rest);
    await page.locator('[data-pose="mouthOpen"] input[type=range]').fill("1");
    const slid = differing(await face(), rest);
    await page.locator('[data-pose="tongueOut"] input[type=range]').fill("0.9");
    await page.keyboard.press("k");
    await page.locator('[data-pose="mouthOpen"] input[type=number]').fill("0.4");
    await page.locator('[data-pose="mouthOpen"] input[type=number]').press("Enter");
    await page.waitForFunction(() => document.querySelector('[data-pose="tongueOut"] small').textContent.includes("0.40"));
    const rule = await text(page, '[data-pose="tongueOut"] small');
    const pictured = await page.$$eval(".pose-sheet canvas", (all) => new Set(all.map((one) => one.toDataURL())).size);
    await page.click('[data-sheet="targets"]');
    const off = await page.isDisabled(".target-detail button.main").catch(() => null);
    await page.click(".banner button");
    await page.waitForFunction(() => document.querySelector(".banner").hidden);
    await speak(page, "Father");
    await picture(page, "character-targets");
    const cell = (sound, pose) => `tr[data-phoneme="${sound}"] td[data-pose="${pose}"]`;
    await page.click(cell("aa", "mouthOpen"));
    const shown = await page.inputValue('[data-pose="mouthOpen"] input[type=number]');
    await page.keyboard.type(".9");
    await page.keyboard.press("Enter");
    await unsaved(page);
    await page.focus(cell("aa", "smile"));
    await page.locator('[data-pose="smile"] input[type=range]').fill("0.3");
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("t");
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("Target of aa"));
    await page.click('[data-sheet="rules"]');
    await page.waitForSelector(".ranks li");
    await page.locator(".ranks li").first().focus();
    await page.keyboard.press("ArrowDown");
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("Rank of smile"));
    const ranks = await page.$$eval(".ranks li > span:nth-child(2)", (all) => all.map((one) => one.textContent));
    const threshold = page.locator('.rule input[type=range]').first(), undo = () => page.getAttribute("#undo", "title");
    const thresholds = [];
    for (const values of [["0.9", "1"], ["1.2", "1.1"]]) {
      for (const value of values) await threshold.evaluate((one, now) => { one.value = now; one.dispatchEvent(new Event("input")); }, value);
      await threshold.evaluate((one) => one.dispatchEvent(new Event("change")));
    }
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("Threshold"));
    await page.waitForFunction(() => document.querySelector(".rule input[type=number]").value === "1.1");
    for (let n = 0; n < 2; n++) {
      await page.click("#undo");
      await page.waitForFunction((before) => document.querySelector(".rule input[type=number]").value !== before, thresholds[n - 1] ?? "1.1");
      thresholds.push(await page.inputValue(".rule input[type=number]"));
    }
    const title = await undo();
    await page.click('[data-sheet="mouths"]');
    const aperture = page.getByLabel("w, aperture", { exact: true }), before = await face();
    await aperture.fill("0.31");
    await page.keyboard.press("Tab");
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("Mouth of w"));
    await page.waitForFunction(() => document.activeElement.ariaLabel === "w, width");
    const posed = differing(await face(), before);
    await page.keyboard.press("Control+s");
    await saved(page);
    const nameless = await page.$$eval(".character-view :is(input, select, button)", (all) => all.filter((one) => !(one.ariaLabel || one.textContent || one.labels?.length)).length);
    return { through, solid, slid, rule, pictured, off, shown, ranks, thresholds, title, posed, nameless };
  },

  /** An album for the documentation: each view with something in it; FOLDER gets the pictures. */
  async album() {
    const page = await show();
    await speak(page, "Bob bumps my blue boat.");
    for (let n = 0; n < 3; n++) await page.keyboard.press("Shift+ArrowRight");
    await page.keyboard.press("ArrowDown");
    await settle(page);
    await picture(page, "sentence");
    const to = async (hash, selector) => {
      await page.evaluate((wanted) => { location.hash = wanted; }, hash);
      await page.waitForSelector(selector);
      await settle(page);
    };
    await to("#bigrams", ".wanted button");
    await picture(page, "matrix");
    await to("#character", ".pose-sheet canvas");
    await page.waitForSelector("#faces figure[data-shaded]");
    await picture(page, "character");
    await to("#words", ".words, .empty");
    for (let n = 0; n < 3; n++) await page.keyboard.press(".");
    await page.keyboard.press("n");
    await page.waitForSelector(".curves-place .point");
    await settle(page);
    await picture(page, "words");
    await to("#coverage", "[aria-label=Script]");
    await page.setInputFiles(".coverage input[type=file]", { name: "script.txt", mimeType: "text/plain", buffer: Buffer.from(SCRIPT) });
    await page.waitForSelector(".needs button.pair");
    await settle(page);
    await picture(page, "coverage");
    await to("#language", ".sounds li");
    await page.fill("[aria-label='Word to try']", "boat");
    await page.waitForSelector(".tried button");
    await picture(page, "language");
    await page.emulateMedia({ colorScheme: "dark" });
    await to("#bigrams/w-bmp", ".curve-plot g.front [data-index]");
    await picture(page, "bigram");
    return {};
  },

  /** A moving picture: the line, a point that is dragged, and the line again; frames go to FOLDER. */
  async film() {
    const page = await show("", { viewport: { width: 1280, height: 720 } });
    let count = 0;
    const frame = async () => page.screenshot({ path: `${folder}/film-${String(count++).padStart(3, "0")}.png` });
    const run = async (frames, steps) => {
      for (let n = 0; n < frames; n++) {
        for (let k = 0; k < steps; k++) await page.keyboard.press("ArrowRight");
        await settle(page);
        await frame();
      }
    };
    await speak(page, "Bob bumps my blue boat.");
    await run(24, 5);
    await page.evaluate(() => { location.hash = "#bigrams/w-bmp"; });
    await page.waitForSelector(".curve-plot g.front [data-index]");
    await settle(page);
    for (let n = 0; n < 5; n++) await frame();
    const box = await page.locator(".curve-plot g.front [data-index='3']").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let n = 1; n <= 12; n++) {
      await page.mouse.move(x - 2 * n, y - 7 * n);
      await settle(page);
      await frame();
    }
    await page.mouse.up();
    await page.click("#back");
    await run(16, 5);
    return { frames: count };
  },

  /** The lines of a script: the first is opened, others by keys and from the list, also in another language. */
  async script() {
    const page = await show();
    const opened = async (name) => {
      await page.waitForFunction((told) => document.querySelector("#all-lines").textContent.startsWith(`${told} ·`) && !document.body.classList.contains("busy"), name, { timeout: 60000 });
      return [await text(page, "#all-lines"), await page.inputValue("#text"), await page.inputValue("#of-character")];
    };
    const rows = () => page.$$eval("#script-list li b", (all) => all.map((one) => one.textContent));
    const result = { first: await opened("line_0001") };
    await page.keyboard.press("Alt+ArrowDown");
    result.second = await opened("line_0002");
    await page.click("#line-before");
    await opened("line_0001");
    result.ends = [await page.isDisabled("#line-before"), await page.isDisabled("#line-after")];
    await page.keyboard.press("o");
    await page.waitForSelector("#script-list li");
    result.listed = (await rows()).length;
    await page.click("#script-list p button");
    await page.waitForFunction((shown) => document.querySelectorAll("#script-list li").length > shown, result.listed);
    result.more = (await rows()).length;
    await picture(page, "script");
    await page.fill("#script-list input", "BOB 0987");
    await page.waitForFunction(() => document.querySelectorAll("#script-list li").length === 1);
    result.found = await rows();
    await page.setViewportSize({ width: 390, height: 844 });
    await picture(page, "script-390");
    result.wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    await page.setViewportSize({ width: 1366, height: 768 });
    await page.click("#script-list li button");
    result.chosen = await opened("line_0987");
    await page.reload();
    await page.waitForSelector("html[data-ready]");
    result.again = await opened("line_0987");
    await page.selectOption("#of-language", "finnish");
    await page.waitForFunction(() => document.querySelector("#text").value.startsWith("Rivi"), null, { timeout: 60000 });
    result.other = await opened("line_0987");
    await speak(page, "Hei");
    result.typed = await text(page, "#all-lines");
    return result;
  },

  /** This line in two formats as downloads, and all lines of the script in a folder. */
  async exports() {
    const page = await show(), files = {};
    page.on("download", async (one) => { files[one.suggestedFilename()] = (await import("node:fs")).statSync(await one.path()).size; });
    await page.click("#export");
    await page.waitForSelector("#exporting [name=format]");
    const result = { formats: await page.$$eval("#exporting li b", (all) => all.map((one) => one.textContent)) };
    const done = (words) => page.waitForFunction((told) => document.querySelector("#exporting [role=status]").textContent.includes(told), words, { timeout: 120000 });
    await page.click("#exporting .main");
    await done("Choose a format");
    for (const name of ["csv", "html"]) await page.check(`#exporting [value=${name}]`);
    await page.click("#exporting .main");
    await done("Exported");
    await page.waitForFunction(() => true);
    await picture(page, "export");
    await page.check("#exporting [value=all]");
    await page.click("#exporting .main");
    await done("files:");
    result.told = await text(page, "#exporting [role=status]");
    await page.click("#exporting .main");
    await done("exists");
    said.splice(0); // the refusals, which a browser tells of
    await page.keyboard.press("Escape");
    await page.keyboard.press("Control+e");
    result.kept = await page.$$eval("#exporting [name=format]:checked", (all) => all.map((one) => one.value));
    return { ...result, files };
  },

  /** What is open at the start, without a hand on it. */
  async start() {
    const page = await show();
    await page.waitForFunction(() => !document.body.classList.contains("busy"));
    await picture(page, "start");
    return {
      line: await text(page, "#all-lines"), text: await page.inputValue("#text"),
      pair: [await page.inputValue("#of-language"), await page.inputValue("#of-character")],
      drawn: await page.isVisible("#timeline"),
    };
  },

  /** Findings of axe-core in every view and dialog; in the dark they differ by their colours alone. */
  async axe() {
    const found = [], page = await show();
    await speak(page, "Bob bumps my blue boat.");
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      for (const view of Object.keys(VIEWS)) {
        await visit(page, view);
        found.push(...await findings(page, `${view} ${colorScheme}`, ...colorScheme === "dark" ? ["color-contrast", "link-in-text-block"] : []));
      }
      for (const button of colorScheme === "dark" ? [] : ["#export", "#keys"]) {
        await page.click(button);
        await page.waitForSelector("dialog[open]");
        found.push(...await findings(page, `${button} ${colorScheme}`));
        await page.keyboard.press("Escape");
      }
    }
    return { found };
  },

  /** A face in its own window, beside a video that follows the line. */
  async beside() {
    const page = await show();
    await speak(page, "Bob bumps my blue boat.");
    await page.evaluate(async () => {
      const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
      const recorder = new MediaRecorder(canvas.captureStream(25), { mimeType: "video/webm" }), parts = [];
      recorder.ondataavailable = ({ data }) => parts.push(data);
      const ended = new Promise((done) => { recorder.onstop = done; });
      recorder.start();
      for (let n = 0; n < 60; n++) {
        pen.fillRect(n, n, 5, 5);
        await new Promise(requestAnimationFrame);
      }
      recorder.stop();
      await ended;
      const held = new DataTransfer(), input = document.querySelector("#beside-face input[type=file]");
      held.items.add(new File(parts, "take.webm", { type: "video/webm" }));
      input.files = held.files;
      input.dispatchEvent(new Event("change"));
    });
    await page.waitForFunction(() => document.querySelector("#faces video").duration > 0.2);
    await page.fill("#beside-face input[type=number]", "-100");
    const moments = await page.waitForFunction(() => {
      const now = Number.parseFloat(document.querySelector("#clock").textContent.replace("\u2212", "-"));
      const video = document.querySelector("#faces video"), wanted = Math.max(0, Math.min(video.duration, now + 0.1));
      return Math.abs(video.currentTime - wanted) < 0.02;
    });
    const [own] = await Promise.all([page.waitForEvent("popup"), page.click("text=Own window")]);
    await own.waitForSelector("#faces canvas");
    const apart = await page.$$eval("#stage canvas", (all) => all.length);
    await own.close();
    await page.waitForSelector("#stage #faces canvas");
    return { follows: await moments.jsonValue(), apart };
  },

  /** The splitter beside the face, by keys and by drags. */
  async splitter() {
    const page = await show(), splitter = page.locator("#splitter");
    const width = () => page.$eval("#stage", (one) => one.offsetWidth);
    const usual = await width(), widths = [];
    await splitter.focus();
    for (const key of ["ArrowRight", "ArrowRight", "ArrowLeft", "End", "Home"]) {
      await page.keyboard.press(key);
      widths.push(await width());
    }
    const stated = await splitter.getAttribute("aria-valuenow"), box = await splitter.boundingBox();
    await page.mouse.move(box.x + 2, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 202, box.y + 200);
    await page.mouse.up();
    const dragged = await width() - widths.at(-1);
    await splitter.dblclick();
    return { usual, widths, stated, dragged, again: await width() };
  },

  /** A second character, which says the same line as it is delivered. */
  async second() {
    const page = await show(), head = page.locator("canvas[aria-label='Face of facefx']");
    await speak(page, "Bob bumps my blue boat.");
    const look = async () => (await head.screenshot()).toString("base64");
    const other = (before) => async () => (await look()) !== before;
    const until = async (does) => { while (!await does()) await page.evaluate(() => new Promise(requestAnimationFrame)); };
    await page.selectOption("#beside-face select", "facefx");
    await head.waitFor();
    const rest = await look();
    await page.click("#fit");
    for (let n = 0; n < 20; n++) await page.click("#on");
    await until(other(rest));
    const said = await look();
    await page.fill("input[aria-label='jaw, as a number']:visible", "0");
    await page.keyboard.press("Tab");
    await until(other(said));
    await page.selectOption("#beside-face select", "");
    return { left: await page.$$eval("#faces canvas", (all) => all.length) };
  },

  /** Every view, light and dark, on small and large screens: nothing overflows. */
  async views() {
    const overflow = [];
    const page = await show();
    await speak(page, "Bob bumps my blue boat.");
    for (const width of [1350, 1340, 1000, 800, 660]) {
      await page.setViewportSize({ width, height: 800 });
      const cut = await page.$$eval("#tabs, #say", (all) => all.filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.id));
      if (cut.length) overflow.push(["bars", width, cut]);
    }
    for (const [width, height] of [[1366, 768], [3840, 2160], [800, 1000], [390, 844], [900, 600], [844, 390]]) {
      await page.setViewportSize({ width, height });
      for (const view of Object.keys(VIEWS)) {
        await visit(page, view);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
        if (wide > 0) overflow.push([view, width, wide]);
        await picture(page, `${view.replace("/", "-")}-${width}`);
      }
    }
    return { overflow };
  },
};

const found = await stories[story]();
await browser.close();
tell(JSON.stringify({ said, asked, ...found }));
process.exit(0);
