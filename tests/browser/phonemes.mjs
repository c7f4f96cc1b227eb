// Change the phonemes of a line in the studio as an animator would, in a headless browser, and print what came of it:
//
//   node phonemes.mjs NODE_MODULES CHROMIUM ADDRESS [PICTURES]
//
// A line with sound is open. Printed is JSON: `said` and `asked`, the errors and the requests to other places; the
// rest below. With a folder, pictures of the steps are kept in it.
import { inStudio, lineOf, settle } from "./browsing.mjs";

await inStudio(async ({ open, result, given: [pictures] }) => {
  const page = await open("#sentence", { viewport: { width: 1400, height: 900 } });
  const picture = async (name) => pictures && await page.screenshot({ path: `${pictures}/${name}.png` });
  const { undoes, timings: line, settings, places } = lineOf(page);
  /** Undo a step, and wait for the line as it was: its phonemes are drawn where the next drag begins. */
  const undo = async (left) => {
    const performed = page.waitForResponse((told) => told.url().endsWith("/take"), { timeout: 60000 });
    await page.keyboard.press("Control+z");
    await performed;
    await undoes(left);
    await settle(page);
  };
  /** Wait, frame by frame, until the server has what is asked for. `waitForFunction` does not await an answer. */
  const until = async (fulfilled) => {
    while (!await fulfilled()) await page.evaluate(() => new Promise(requestAnimationFrame));
  };
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const labels = async () => (await line()).phonemes.map((one) => one.label);
  const times = async () => { const { phonemes } = await line(); return [phonemes[0].start, ...phonemes.map((one) => one.end)]; };
  const moved = (after, before) => after.map((one, n) => Number((one - before[n]).toFixed(3)));
  const chosen = () => page.textContent(".word:not([hidden]) bdi");
  await page.evaluate(() => {
    window.pieces = [];
    const { start } = AudioBufferSourceNode.prototype;
    AudioBufferSourceNode.prototype.start = function (...times) {
      window.pieces.push(times.slice(1).map((one) => Number(one.toFixed(3))));
      start.apply(this, times);
    };
  });
  const pieces = () => page.evaluate(() => window.pieces.splice(0));
  const place = await places(), box = await page.locator("#timeline").boundingBox();
  const whole = await times(), start = whole[0], end = whole.at(-1);
  /** Pixels of the page at some seconds, on a band of labels: 0 for words, 1 for phonemes. */
  const at = (seconds, band) => { const { x, y } = place(seconds, band); return [box.x + x, box.y + y]; };
  const middle = (n) => (whole[n] + whole[n + 1]) / 2;
  const drag = async (from, by) => {
    const [x, y] = from;
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (const part of [0.5, 0.8, 1]) await page.mouse.move(x + by * part, y);
    await page.mouse.up();
  };
  result.start = await labels();

  // a phoneme and a word are heard at a click, and the sound around the playhead in a drag
  await page.mouse.click(...at(middle(2), 1));
  result.heard = [await pieces()];
  await page.mouse.click(...at(middle(0), 0));
  result.heard.push(await pieces());
  const [, top] = at(start, -3);
  await page.mouse.move(at(middle(1), 0)[0], top);
  await page.mouse.down();
  for (const n of [2, 3, 4]) { // a piece is heard at each place
    const heard = await page.evaluate(() => window.pieces.length);
    do await page.mouse.move(at(middle(n), 0)[0], top); // a move too soon after a piece has none of its own
    while (await page.evaluate((before) => window.pieces.length === before, heard));
  }
  await page.mouse.up();
  result.scrubbed = await pieces();
  await press("Escape");

  // the sound as a spectrogram, and both
  const drawn = () => page.evaluate(() => document.querySelector("#timeline").toDataURL());
  const usual = await drawn();
  const changes = (from) => page.waitForFunction((before) => document.querySelector("#timeline").toDataURL() !== before, from);
  await press("w");
  await changes(usual);
  const spectrogram = await drawn();
  result.spectrogram = spectrogram !== usual;
  await page.click("button:text-is('Both')");
  await changes(spectrogram);
  const both = await drawn();
  result.both = [await page.getAttribute("button:text-is('Both')", "aria-pressed"), both !== usual];
  await picture("both");
  await page.click("button:text-is('Wave')");
  await changes(both);
  result.wave = await page.getAttribute("button:text-is('Wave')", "aria-pressed");

  // a phoneme is chosen and relabelled by hand: a wrong label is refused, with another
  await page.mouse.click(...at(middle(1), 1));
  result.chosen = await chosen();
  await page.mouse.dblclick(...at(middle(1), 1));
  await page.waitForSelector("#phoneme-labels option", { state: "attached" });
  result.offered = await page.$$eval("#phoneme-labels option", (all) => all.length);
  await page.keyboard.type("AEE");
  await press("Enter");
  await page.waitForSelector("#toasts .fault");
  result.refused = await page.textContent("#toasts .fault");
  await press("r");
  await page.keyboard.type("AE");
  await picture("relabel");
  await press("Enter");
  await undoes("Undo: Relabel");
  result.relabelled = await labels();

  // split, inserted, joined and deleted by keys
  await press("s");
  await undoes("Undo: Split");
  result.split = await labels();
  await press("Delete");
  await undoes("Undo: Delete");
  result.deleted = await labels();
  await press("i");
  await page.keyboard.type("T");
  await press("Enter");
  await undoes("Undo: Insert T");
  result.inserted = await labels();
  await picture("inserted");
  await press(",", "j");
  await undoes("Undo: Join");
  result.joined = await labels();
  for (const title of ["Undo: Insert", "Undo: Delete", "Undo: Split", "Undo: Relabel", "Nothing"]) {
    await press("Control+z");
    await undoes(title);
  }
  result.undone = [await labels(), moved(await times(), whole).every((one) => one === 0)];

  // a boundary rolls, or what follows it moves along; a whole word moves
  await page.click("text=Snap");
  await drag(at(whole[1], 1), 12);
  await undoes("Undo: Move the boundary");
  result.rolled = moved(await times(), whole);
  await undo("Nothing");
  await page.keyboard.down("Shift");
  await drag(at(whole[2], 1), 12);
  await page.keyboard.up("Shift");
  await undoes("Undo: Move the boundary");
  result.rippled = moved(await times(), whole);
  await settle(page);
  result.top = [box.y, (await page.locator("#timeline").boundingBox()).y];
  await undo("Nothing");
  const { words } = await line();
  result.word = words[1].text;
  await drag(at((words[1].start + words[1].end) / 2, 0), -9);
  await undoes("Undo: Move the word");
  result.carried = moved(await times(), whole);
  await picture("carried");
  const moves = moved(await times(), whole);
  await press("Alt+ArrowRight");
  await until(async () => moved(await times(), whole).some((one, n) => one !== moves[n]));
  result.nudged = Number(((await line()).words[1].start - words[1].start).toFixed(3));
  await page.click("text=Original times");
  await undoes("Undo: Restore");
  result.original = moved(await times(), whole).every((one) => one === 0);
  // a pose is bent at the playhead by keys, and by a drag with Ctrl
  const bends = async () => (await settings()).bends;
  const rows = await page.$$eval("#poses > li > button > span:first-child", (all) => all.map((one) => one.textContent));
  await page.mouse.click(...at(middle(1), 0));
  await page.mouse.click(at(middle(1), 0)[0], at(start, 3)[1] + 20);
  result.bent = rows[0];
  await press("k", "Shift+ArrowDown", "Shift+ArrowDown");
  await until(async () => (await bends())[rows[0]]?.[0][1] < -0.05);
  result.lowered = (await bends())[rows[0]];
  await page.waitForFunction(() => document.querySelector("#poses ol")?.textContent.includes("bent"));
  result.reasons = await page.$$eval("#poses ol li", (all) => all.map((one) => one.textContent));
  await picture("bent");
  await press("Delete");
  await until(async () => !Object.keys(await bends()).length);
  const [x, y] = [at(middle(1), 0)[0], at(start, 3)[1] + 20];
  await page.keyboard.down("Control");
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (const by of [5, 10, 14]) await page.mouse.move(x, y - by);
  await page.mouse.up();
  await page.keyboard.up("Control");
  await undoes("Undo: Bend");
  result.dragged = (await bends())[rows[0]];
  await press("Control+z");
  await until(async () => !Object.keys(await bends()).length);
  result.span = [start, end];
});
