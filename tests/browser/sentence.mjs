// Correct and deliver a line in the studio as an animator would, in a headless browser, and print what came of it:
//
//   node sentence.mjs NODE_MODULES CHROMIUM ADDRESS RECORDING
//
// A line with sound is open. Printed is JSON: `said` and `asked`, the errors and the requests to other
// places; the rest below.
import { readFileSync } from "node:fs";
import { inStudio, settle } from "./browsing.mjs";

// pixels of the timeline: its ruler with the sound, a band of labels, a pose, and where the poses begin
const RULER = 24 + 52, BAND = 22, ROW = 50, TOP = RULER + 3 * BAND + 8;

await inStudio(async ({ open, result, given: [recording] }) => {
  const page = await open("#sentence");
  const idle = async (title) => {
    await page.waitForFunction((wanted) => document.querySelector("#undo").title.startsWith(wanted), title, { timeout: 60000 });
    await still();
  };
  /** Wait for the curves, and for the check that comes after them. */
  const still = async () => {
    await settle(page);
    await page.waitForSelector("#figures[aria-busy=false]", { timeout: 60000 });
    await settle(page);
  };
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const drawn = () => page.evaluate(() => document.querySelector("#timeline").toDataURL());
  const timings = () => page.evaluate(async () => JSON.parse((await (await fetch("api/timings/json")).json()).content));
  const times = async () => { const { phonemes } = await timings(); return [phonemes[0].start, ...phonemes.map((one) => one.end)]; };
  const settings = () => page.evaluate(async () => (await (await fetch("api/state")).json()).settings);
  await idle("Nothing");

  // a boundary is dragged: its curves follow, and undo puts it back
  const box = await page.locator("#timeline").boundingBox();
  const before = await times(), plain = await drawn();
  const y = box.y + RULER + 1.5 * BAND;
  let x = 0;
  const cursor = () => page.evaluate(() => document.querySelector("#timeline").style.cursor);
  for (x = box.x + box.width / 2; x < box.x + box.width && (await cursor()) !== "ew-resize"; x += 3) await page.mouse.move(x, y);
  await page.mouse.down();
  const clock = () => page.textContent("#clock");
  const rested = await clock();
  for (const by of [4, 9, 14]) await page.mouse.move(x + by, y);
  await settle(page);
  const dragged = await clock();
  await page.mouse.up();
  await idle("Undo: Move the boundary");
  result.followed = [dragged !== rested, (await clock()) === rested];
  const after = await times();
  result.moved = after.map((one, n) => Number((one - before[n]).toFixed(4)));
  await press("Escape");
  await settle(page);
  result.redrawn = (await drawn()) !== plain;
  await press("Control+z");
  await idle("Nothing");
  result.undone = (await times()).map((one, n) => Number((one - before[n]).toFixed(4)));
  result.alike = (await drawn()) === plain;
  await press("Control+Shift+z");
  await idle("Undo: Move the boundary");
  await page.click("text=Original times");
  await idle("Undo: Restore the original");
  result.original = (await times()).map((one, n) => Number((one - before[n]).toFixed(4)));

  // by keys
  await press("Home", "]", "]", "ArrowRight", "Shift+ArrowRight");
  await idle("Undo: Move the boundary");
  result.nudged = (await times()).map((one, n) => Number((one - before[n]).toFixed(4)));
  await press("Escape");

  // a moment says why, and leads to its bigram
  await page.mouse.click(box.x + 104 + 200, box.y + TOP + ROW / 2);
  await settle(page);
  result.reasons = await page.$$eval("#poses ol li", (all) => all.map((one) => one.textContent));
  result.pairs = await page.$$eval(".open-bigram", (all) => all.map((one) => one.textContent));
  await press("Enter");
  await page.waitForSelector(".bigram-head h2:not(:empty)");
  result.entered = [await page.evaluate(() => decodeURIComponent(location.hash)), await page.textContent(".bigram-head h2")];
  await page.goBack();
  await page.waitForSelector("#timeline");
  await settle(page);
  await page.mouse.dblclick(box.x + 104 + 200, box.y + TOP + ROW / 2);
  await page.waitForSelector(".bigram-head h2:not(:empty)");
  result.clicked = await page.evaluate(() => decodeURIComponent(location.hash));
  await page.goBack();
  await page.waitForSelector("#timeline");
  await settle(page);

  // a word is emphasised, and a region has a track
  await page.mouse.click(box.x + 104 + 200, box.y + RULER + BAND / 2);
  await press("e");
  await idle("Undo: Emphasis");
  result.word = await page.textContent(".word bdi");
  result.emphasis = (await timings()).words.map((one) => one.emphasis ?? 0);
  await page.fill(".word input[type=number] >> nth=1", "1.5");
  await press("Tab");
  await idle("Undo: ");
  result.dials = (await settings()).dials;
  result.lanes = await page.$$eval(".lane-name > span", (all) => all.map((one) => one.textContent));
  const points = () => page.$$eval(".lane circle", (all) => all.length);
  result.points = [await points()];
  const lane = await page.locator(".lane svg").boundingBox();
  await page.mouse.click(lane.x + lane.width - 40, lane.y + 20);
  await settle(page);
  result.points.push(await points());
  await press("ArrowUp", "Delete");
  await settle(page);
  result.points.push(await points());
  await page.click(".lane button");
  await idle("Undo: ");
  result.without = (await settings()).dials;

  // A and B, and the stages
  await page.selectOption("#against", "keyframes");
  await page.waitForSelector("#legend .line");
  await page.evaluate(() => document.activeElement.blur());
  await press("a");
  result.swapped = await page.getAttribute("text=A/B", "aria-pressed");
  await press("a");
  await settle(page);
  const whole = await drawn();
  await page.locator("#legend button").last().click();
  await settle(page);
  result.hidden = (await drawn()) !== whole;

  // timings are saved, and others opened
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("button:text-is('TextGrid')")]);
  result.saved = [download.suggestedFilename(), readFileSync(await download.path(), "utf-8").split("\n")[1]];
  await page.evaluate(() => {
    const data = new DataTransfer();
    const line = { notation: "arpabet", phonemes: [{ label: "M", start: 0, end: 0.2 }, { label: "AA", start: 0.2, end: 0.5 }], words: [{ text: "<b>ma</b>", start: 0, end: 0.5 }] };
    data.items.add(new File([JSON.stringify(line)], "ma.json"));
    document.querySelector(".sentence").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  });
  await page.waitForFunction(() => document.querySelector("#text").value === "<b>ma</b>");
  result.opened = await times();
  result.steps = await page.getAttribute("#undo", "title");

  // a recording is opened: its text is asked for, and its phonemes are found
  const words = async () => (await timings()).words.map((one) => one.text);
  await page.setInputFiles(".sentence input[type=file]", recording);
  await page.fill("dialog.recording input", "");
  await page.click("text=Find its phonemes");
  await page.waitForFunction(() => document.body.textContent.includes("Type the words of the recording"));
  result.untold = await words();
  await page.setInputFiles(".sentence input[type=file]", recording);
  await page.fill("dialog.recording input", "Bob may buy a map");
  await page.click("text=Find its phonemes");
  await page.waitForFunction(() => document.querySelector("#text").value === "Bob may buy a map", { timeout: 120000 });
  await still();
  result.heard = await words();
  result.nameless = await page.$$eval("button, input:not([hidden]), select, canvas:not([aria-hidden]), [tabindex='0']", (all) => all
    .filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim())).map((one) => `${one.localName} ${one.id} ${one.className}`));
  await page.close();

  const phone = await open("#sentence", { viewport: { width: 360, height: 740 }, colorScheme: "dark", hasTouch: true });
  result.overflow = await phone.evaluate(() => document.documentElement.scrollWidth - innerWidth);
});
