// Place gestures in their lane in the studio, by mouse and by keys, in a headless browser, and print what came of it:
//
//   node gestures.mjs NODE_MODULES CHROMIUM ADDRESS
//
// Printed is JSON: `said` and `asked`, the errors and the requests to other places; the rest below. With
// GESTURES_PICTURES, the studio is drawn into that folder.
import { readFileSync } from "node:fs";
import { WEBGL, launch, lineOf, studio } from "./browsing.mjs";

const [modules, chromium, address] = process.argv.slice(2);
const browser = await launch(modules, chromium, ...WEBGL);
const said = [], asked = [];
const open = studio(browser, address, said, asked);
const WAIT = { timeout: 60000 };

try {
  const result = { said, asked };
  const page = await open("#sentence", { viewport: { width: 1280, height: 800 } });
  const { places, settings, undoes } = lineOf(page);
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const bars = () => page.$$eval(".gesture", (all) => all.map((one) => ({
    name: one.getAttribute("aria-label"), at: Number(one.getAttribute("aria-valuenow")), told: one.getAttribute("aria-valuetext"),
    as: one.getAttribute("class").split(" ").find((name) => ["hand", "ruled", "silent"].includes(name)), chosen: one.classList.contains("chosen"),
  })));
  /** Wait until the lane has a gesture of a kind and a class near a time. */
  const there = (name, as, at, near = 0.02) => page.waitForFunction(
    ([kind, way, seconds, reach]) => [...document.querySelectorAll(`.gesture.${way}`)].some((one) =>
      one.getAttribute("aria-label") === kind && Math.abs(Number(one.getAttribute("aria-valuenow")) - seconds) < reach),
    [name, as, at, near], WAIT);
  const picture = async (name) => { if (process.env.GESTURES_PICTURES) await page.screenshot({ path: `${process.env.GESTURES_PICTURES}/${name}.png` }); };

  await page.waitForSelector(".gesture");
  const onto = await places();
  result.first = await bars();
  result.rows = await page.$$eval("#poses button", (all) => all.map((one) => one.textContent));

  // a nod that came by rule is dragged later, to the beginning of a word
  const nod = result.first.find((one) => one.name === "nod");
  const { words } = await page.evaluate(async () => JSON.parse((await (await fetch("api/timings/json")).json()).content));
  const word = words.find((one) => one.start > nod.at + 0.25);
  const bar = page.locator(".gesture.ruled[aria-label=nod]").first();
  await bar.hover(); // once it stands still
  const box = await bar.boundingBox(), from = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  await page.mouse.down();
  await page.mouse.move(from.x + 10, from.y);
  await page.mouse.move(from.x + onto(word.start, 0).x - onto(nod.at, 0).x + 3, from.y);
  await page.mouse.up();
  await undoes("Undo: Move nod");
  await there("nod", "hand", word.start, 0.001);
  result.word = words.indexOf(word);
  result.moved = { bars: await bars(), placed: (await settings()).placed };
  result.panel = await page.textContent("section[aria-label='Chosen gesture']");
  await picture("moved");

  // by keys: later, larger; then deleted, which leaves what was taken away
  await press("ArrowRight", "ArrowUp", "ArrowUp");
  await undoes("Undo: Scale nod");
  await there("nod", "hand", word.start + 0.01, 0.001);
  result.keyed = (await settings()).placed;
  await press("Delete");
  await undoes("Undo: Delete nod");
  result.deleted = (await settings()).placed;

  // what was taken away is taken back
  await page.focus(".gesture.silent");
  await press("Delete");
  await there("nod", "ruled", nod.at);
  result.restored = (await settings()).placed ?? [];

  // what came by rule is deleted; a blink is added at a word, and another at the playhead
  await page.focus(".gesture.ruled[aria-label=nod]");
  await press("Backspace");
  await there("nod", "silent", nod.at);
  await press("Escape", "Home", "'", "'");
  await page.selectOption("select[aria-label='Gesture to add']", "blink");
  await page.locator("select[aria-label='Gesture to add']").blur();
  await press("t");
  await undoes("Undo: Add blink");
  result.added = { placed: (await settings()).placed, time: words[1].start };
  await page.fill("input[aria-label='scale, as a number']", "0.5");
  await press("Enter");
  await undoes("Undo: Scale blink");
  await picture("added");
  result.scaled = (await settings()).placed;
  await press("Escape");

  // undone and done again; saved, and there after a new start of the page
  for (const key of ["Control+z", "Control+z", "Control+z"]) await Promise.all([page.waitForResponse((one) => one.url().endsWith("api/undo")), press(key)]);
  await there("nod", "ruled", nod.at);
  result.undone = (await settings()).placed ?? [];
  for (const key of ["Control+Shift+z", "Control+Shift+z", "Control+Shift+z"]) await Promise.all([page.waitForResponse((one) => one.url().endsWith("api/redo")), press(key)]);
  await undoes("Undo: Scale blink");
  await press("Control+s");
  await page.waitForFunction(() => document.querySelector("#save").disabled, null, WAIT);
  await page.evaluate(readFileSync(`${modules}/axe-core/axe.min.js`, "utf-8"));
  result.axe = (await page.evaluate(() => globalThis.axe.run())).violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.html)}`);
  await page.close();

  const small = await open("#sentence", { viewport: { width: 900, height: 600 } });
  await small.waitForSelector(".gesture.silent");
  result.again = await small.$$eval(".gesture.hand, .gesture.silent", (all) => all.map((one) => one.getAttribute("aria-label")));
  result.overflow = await small.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  if (process.env.GESTURES_PICTURES) await small.screenshot({ path: `${process.env.GESTURES_PICTURES}/small.png` });
  await small.evaluate(() => document.querySelector(".gestures").scrollIntoView({ block: "center" }));
  if (process.env.GESTURES_PICTURES) await small.screenshot({ path: `${process.env.GESTURES_PICTURES}/small-lane.png` });
  console.log(JSON.stringify(result));
} finally {
  await browser.close();
}
