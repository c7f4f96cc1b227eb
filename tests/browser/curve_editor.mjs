// Use the editor of curves and the matrix of bigrams in a headless browser, and print what it reports:
//
//   node curve_editor.mjs NODE_MODULES CHROMIUM STATIC [FOLDER]
//
// Printed is JSON: `said`, the errors; and for each thing done, the changes reported since. A FOLDER gets
// pictures.
import { readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { FLAT, launch, serve, watch } from "./browsing.mjs";

const [modules, chromium, folder, pictures] = process.argv.slice(2);

const PAGE = `<!DOCTYPE html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,"><title>Curves</title>
<link rel="stylesheet" href="line/page.css"><link rel="stylesheet" href="curves/curves.css"><link rel="stylesheet" href="own.css">
<div id="here"></div><script type="module" src="own.js"></script></html>`;
const STYLE = "#here { height: 32rem; padding: 1rem }";
const SCRIPT = `import { CurveEditor } from "./curves/curve_editor.js";
window.changes = [];
window.tells = [];
const editor = new CurveEditor(document.getElementById("here"), {
  changed: (what, step) => changes.push({ ...structuredClone(what), ...step }), tell: (text) => tells.push(text),
});
const poses = ["open", "<b>round</b>", ...Array.from({ length: 48 }, (_, n) => "pose" + n)].map((name) => ({ name, title: name + " in words" }));
editor.show({
  poses, pair: ["l", "ow"], boundary: 0.5,
  curves: { open: [[0, 0], [0.3, 0.4], [0.7, 0.6], [1, 0]], "<b>round</b>": [[0, 0.2], [0.5, 0.9], [1, 0.2]] },
  ghosts: [{ name: "draft", kind: "draft", boundary: 0.4, curves: { open: [[0, 0], [0.5, 0.3], [1, 0]] } }],
});
window.editor = editor;
document.documentElement.dataset.ready = "";`;
const MATRIX = `import { BigramMatrix } from "./views/bigram_matrix.js";
window.opened = [];
const matrix = new BigramMatrix(document.getElementById("here"), { open: (pair) => opened.push(pair) });
const pairs = {
  "_-a": { status: "drafted", layer: "draft" }, "a-_": { status: "gap", layer: "gap" }, "a-m": { status: "drafted", layer: "draft", need: 2, word: "am" },
  "m-a": { status: "approved", layer: "shared", need: 1, word: "ma" }, "m-m": { status: "edited", layer: "shared" },
};
matrix.show({ phonemes: ["_", "a", "m"], pairs, wanted: [{ pair: "a-m", count: 2, word: "am" }] });
window.more = () => matrix.show({ phonemes: ["_", "a", "m"], pairs: { ...pairs, "a-m": { status: "edited", need: 2 } }, wanted: [] });
document.documentElement.dataset.ready = "";`;
const OWN = { "": PAGE, matrix: PAGE.replace("own.js", "matrix.js"), "own.js": SCRIPT, "matrix.js": MATRIX, "own.css": STYLE };

const POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:";
const server = await serve(
  (path) => OWN[basename(path)] ?? readFileSync(join(folder, path)), { "content-security-policy": POLICY },
);
const browser = await launch(modules, chromium, ...FLAT);
const said = [];

async function open(options = {}, path = "") {
  const page = await browser.newPage({ viewport: { width: 1280, height: 700 }, ...options });
  watch(page, said);
  await page.goto(`${server.address}/${path}`);
  await page.waitForSelector("html[data-ready]");
  return page;
}

try {
  const page = await open();
  const result = { said };
  const changes = () => page.evaluate(() => changes.splice(0));
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  /** Pixels of a time and a value. */
  const spot = async (time, value) => {
    const box = await page.locator("svg.plot").boundingBox();
    const [x, y] = await page.evaluate(([t, v]) => [editor.drawing.x(t), editor.drawing.y(v)], [time, value]);
    return [box.x + x, box.y + y];
  };
  const drag = async (from, to) => {
    await page.mouse.move(...await spot(...from));
    await page.mouse.down();
    await page.mouse.move(...await spot((from[0] + to[0]) / 2, (from[1] + to[1]) / 2));
    await page.mouse.move(...await spot(...to));
    await page.mouse.up();
  };
  const focused = () => page.evaluate(() => document.activeElement.getAttribute("aria-label"));

  await drag([0.3, 0.4], [0.4, 0.55]);
  result.dragged = await changes();
  await page.keyboard.down("Shift");
  await drag([0.4, 0.55], [0.433, 0.583]);
  await page.keyboard.up("Shift");
  await page.evaluate(() => editor.choose("open", 1, false));
  result.snapped = (await changes()).at(-1);

  result.focused = await focused();
  await press("ArrowUp", "ArrowRight", "Alt+ArrowRight", "Shift+ArrowDown");
  result.nudged = await changes();
  await press("Tab");
  result.tabbed = await focused();
  await press("a");
  result.added = (await changes()).at(-1);
  await press("Delete");
  result.deleted = (await changes()).at(-1);
  await page.mouse.dblclick(...await spot(0.85, 0.9));
  result.clicked = (await changes()).at(-1);

  await drag([0.5, 1.03], [0.62, 1.03]);
  result.boundary = await changes();
  await press("ArrowLeft", "ArrowLeft");
  result.walked = await changes();

  // several: a marquee, then typed, copied, pasted
  await page.mouse.click(...await spot(0.2, 0.98));
  await drag([0.35, 0.98], [0.8, 0.3]);
  result.swept = await page.evaluate(() => [...editor.chosen].map(([pose, all]) => [pose, [...all]]));
  await page.fill("input[aria-label^='Value']", "*0.5");
  await press("Enter");
  result.typed = (await changes()).at(-1);
  await page.locator("svg.plot").focus();
  await press("Escape", "]");
  await press("Control+a");
  result.whole = await page.evaluate(() => [...editor.chosen].map(([pose, all]) => [pose, [...all]]));
  await page.evaluate(() => {
    const copied = new ClipboardEvent("copy", { clipboardData: new DataTransfer(), bubbles: true, cancelable: true });
    editor.drawing.svg.dispatchEvent(copied);
    window.copied = copied.clipboardData.getData("text/plain");
  });
  result.copied = JSON.parse(await page.evaluate(() => copied)).curves;
  await press("Delete");
  result.gone = { change: (await changes()).at(-1), tells: await page.evaluate(() => tells.splice(0)) };
  await page.click("button:text('Paste')");
  await page.waitForFunction(() => window.changes.length); // the clipboard of a system answers in its own time
  result.pasted = (await changes()).at(-1);

  // a drag that is given up, and edits of a server that come in while it lasts
  await page.evaluate(() => editor.chooseAll(new Map()));
  const start = await page.evaluate(() => structuredClone(editor.curves));
  const [time, value] = start.open[1];
  await page.mouse.move(...await spot(time, value));
  await page.mouse.down();
  await page.mouse.move(...await spot(time + 0.05, value));
  await page.evaluate(() => editor.show({ poses: [...editor.poses.values()], curves: { open: [[0, 0], [1, 1]] }, pair: editor.pair }));
  result.held = await page.evaluate(() => editor.curves.open.length);
  await press("Escape");
  await page.mouse.up();
  result.escaped = { start, end: (await changes()).at(-1) };

  // poses: found, added, alone
  await page.fill("input[type=search]", "pose31");
  result.found = await page.$$eval(".pose-list li .name", (all) => all.map((one) => one.textContent));
  await press("Enter");
  await page.focus(".pose-list li");
  await press("Enter");
  result.more = (await changes()).at(-1);
  await page.fill("input[type=search]", "");
  await page.locator("svg.plot").focus();
  await press("s");
  result.alone = await page.evaluate(() => editor.shown);
  await press("s");
  await page.evaluate(() => editor.show({ poses: [...editor.poses.values()], curves: editor.curves, pair: editor.pair, ghosts: [{ name: "draft", kind: "draft", boundary: 0.4, curves: { open: [[0, 0], [1, 0.3]] } }] }));
  await page.selectOption("select", "draft");
  result.started = (await changes()).at(-1);

  // zoom with the wheel, and back
  await page.mouse.move(...await spot(0.5, 0.5));
  await page.mouse.wheel(0, -400);
  await page.waitForFunction(() => editor.drawing.view[1] - editor.drawing.view[0] < 0.6);
  result.zoomed = await page.evaluate(() => editor.drawing.view);
  await press("0");
  result.fitted = await page.evaluate(() => editor.drawing.view);
  result.nameless = await page.$$eval("button, input, select, [tabindex='0']", (all) => all
    .filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim())).map((one) => one.outerHTML));
  result.markup = await page.$$eval("#here b", (all) => all.length);
  if (pictures) await page.screenshot({ path: join(pictures, "light.png") });
  await page.close();

  const board = await open({}, "matrix");
  const info = () => board.textContent(".matrix-info");
  const cells = () => board.$$eval("td[data-pair]", (all) => all.map((one) => [one.dataset.pair, one.className, one.textContent]));
  result.matrix = { cells: await cells(), told: [await info()], wanted: await board.$$eval(".wanted button", (all) => all.map((one) => one.textContent)) };
  await board.focus("td[tabindex='0']");
  for (const key of ["ArrowLeft", "ArrowDown", "ArrowDown", "Enter"]) {
    await board.keyboard.press(key);
    result.matrix.told.push(await info());
  }
  await board.click("td[data-pair='m-m']");
  await board.click(".wanted button");
  result.matrix.opened = await board.evaluate(() => opened);
  await board.evaluate(() => more());
  result.matrix.changed = (await cells()).find(([pair]) => pair === "a-m");
  result.matrix.none = await board.isVisible(".bigram-matrix .note");
  await board.close();

  const phone = await open({ viewport: { width: 360, height: 740 }, colorScheme: "dark", hasTouch: true });
  result.overflow = await phone.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  const [x, y] = await phone.evaluate(() => {
    const box = editor.drawing.svg.getBoundingClientRect();
    return [box.x + editor.drawing.x(0.3), box.y + editor.drawing.y(0.4)];
  });
  await phone.touchscreen.tap(x + 12, y - 12);
  result.tapped = await phone.evaluate(() => [...editor.chosen].map(([pose, all]) => [pose, [...all]]));
  const touch = await phone.context().newCDPSession(phone);
  const fingers = (type, ...points) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
  await phone.evaluate(() => changes.splice(0));
  await fingers("touchStart", [x + 8, y + 8]);
  await fingers("touchMove", [x + 8, y - 20]);
  await fingers("touchMove", [x + 8, y - 42]);
  await fingers("touchEnd");
  result.touched = await phone.evaluate(() => changes.splice(0));
  await fingers("touchStart", [x, y + 60], [x + 40, y + 60]);
  await fingers("touchMove", [x - 20, y + 60], [x + 60, y + 60]);
  await fingers("touchMove", [x - 40, y + 60], [x + 80, y + 60]);
  await fingers("touchEnd");
  result.pinched = await phone.evaluate(() => ({ wide: editor.drawing.view[1] - editor.drawing.view[0], changes: changes.length, chosen: editor.chosen.size, marquee: editor.marquee }));
  if (pictures) await phone.screenshot({ path: join(pictures, "phone.png") });
  console.log(JSON.stringify(result));
} finally {
  await browser.close();
  server.close();
}
