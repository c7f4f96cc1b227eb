// An animator's hour in the studio, in a headless browser, and print what came of it:
//
//   node hour.mjs NODE_MODULES CHROMIUM ADDRESS [PICTURES]
//
// A project with a script is open. The script prints `kill`, waits for a line of input while the test ends the server
// and starts another, and prints JSON: `said` and `asked`, the errors and the requests to other places; the rest below.
import { createInterface } from "node:readline";
import { inStudio, lineOf } from "./browsing.mjs";

const WAIT = { timeout: 60000 };

await inStudio(async ({ open, result, given: [pictures] }) => {
  const page = await open("#sentence", { viewport: { width: 1400, height: 900 } });
  let shown = 10;
  const picture = async (name) => pictures && await page.screenshot({ path: `${pictures}/${shown++}-${name}.png` });
  const { undoes, timings, settings, places } = lineOf(page);
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const labels = async () => (await timings()).phonemes.map((one) => one.label);
  const save = (wanted) => page.waitForFunction((text) => document.querySelector("#save").textContent.includes(text), wanted, WAIT);
  result.line = await page.textContent("#all-lines");
  result.labels = [await labels()];
  await picture("opened");

  // a boundary is mended, and a phoneme relabelled
  await press("Home", "]", "]", "ArrowRight", "Shift+ArrowRight");
  await undoes("Undo: Move the boundary");
  await picture("boundary");
  await press("Escape");
  const at = await places(), { phonemes, words } = await timings();
  const middle = (one) => (one.start + one.end) / 2;
  await page.click("#timeline", { position: at(middle(phonemes[1]), 1) });
  await press("r");
  await page.keyboard.type("æ");
  await press("Enter");
  await undoes("Undo: Relabel");
  await picture("relabelled");
  result.labels.push(await labels());

  // one frame is bent: the pose of the first row, at the playhead
  await page.click("#timeline", { position: at(middle(phonemes[1]), 4) });
  await press("k", "Shift+ArrowDown", "Shift+ArrowDown");
  await undoes("Undo: Bend");
  await picture("bent");

  // one word is shouted
  await page.click("#timeline", { position: at(middle(words[1]), 0) });
  await page.fill("[aria-label='Chosen word'] [aria-label='shout, as a number']", "1");
  await press("Tab");
  await undoes("Undo: shout");
  await picture("shouted");
  result.settings = await settings();

  // a bigram is drawn
  await page.evaluate(() => { location.hash = "#bigrams/bmp-aa"; });
  await page.focus(".curve-plot g.front [data-index='1']", WAIT);
  await press("Shift+ArrowUp");
  await undoes("Undo: Move mouthOpen");
  result.unsaved = await page.textContent("#save");
  await picture("bigram");
  await page.evaluate(() => { location.hash = "#sentence"; });

  // the line is exported as a model and as a page
  await page.click("#export");
  for (const format of ["glb", "html"]) await page.check(`dialog[open] input[value='${format}']`, WAIT);
  const files = [];
  page.on("download", (one) => files.push(one.suggestedFilename()));
  await page.click("dialog[open] button.main");
  await page.waitForFunction(() => /^Exported/.test(document.querySelector("dialog[open] [role=status]").textContent), null, { timeout: 120000 });
  await picture("exported");
  result.exported = await page.textContent("dialog[open] [role=status]");
  await press("Escape");

  // the server is killed; the page asks the next one twice at once, and goes on
  const started = new Promise((done) => createInterface({ input: process.stdin }).once("line", done));
  let together, asking = 0;
  const twice = new Promise((done) => { together = done; });
  await page.route("**/api/state", async (route) => {
    if (++asking === 2) together();
    await Promise.all([started, twice]);
    await route.continue();
  });
  await page.evaluate(() => {
    globalThis.told = []; // a notice can be replaced before a busy machine draws it
    new MutationObserver(() => told.push(document.querySelector("#toasts").textContent)).observe(document.querySelector("#toasts"), { childList: true });
  });
  // one in the server as it is killed would find it away, and the page then asks for the state once alone
  while (page.awaited.size > asking) await page.evaluate(() => new Promise(requestAnimationFrame));
  process.stdout.write("kill\n");
  await started;
  await page.evaluate(() => dispatchEvent(new Event("focus"))); // the animator comes back to the window
  const again = page.waitForFunction(() => told.some((one) => one.includes("was started again")), null, WAIT);
  await again.catch(async (cause) => { throw new Error(`only told ${JSON.stringify(await page.evaluate(() => told))}, asked ${asking} times`, { cause }); });
  await picture("started-again");
  await page.click("#timeline", { position: at(middle(words[0]), 0) });
  await press("e");
  await undoes("Undo: Emphasis");
  result.mended = [await labels(), await settings()];
  result.said.length = 0; // a request that found no server is an error of the browser
  await press("Control+s");
  await save("Saved");
  result.files = files.sort();
  await picture("saved");

  // the next line is as it was
  await page.click("#line-after");
  await page.waitForFunction(() => /^line_02 · /.test(document.querySelector("#all-lines").textContent), null, WAIT); // "line_02 …" until it is open
  await picture("next");
  result.next = [await page.textContent("#all-lines"), await settings()];
});
