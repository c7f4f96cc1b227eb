// Align words of a line again in the studio, and begin a language, in a headless browser, and print what came of it:
//
//   node again.mjs NODE_MODULES CHROMIUM ADDRESS [PICTURES]
//
// A spoken line is open. Printed is JSON: `said` and `asked`, the errors and the requests to other places; the rest below.
import { inStudio, lineOf } from "./browsing.mjs";

const WAIT = { timeout: 60000 };

await inStudio(async ({ open, result, given: [pictures] }) => {
  const page = await open("#sentence", { viewport: { width: 1400, height: 900 } });
  const picture = async (name) => pictures && await page.screenshot({ path: `${pictures}/${name}.png` });
  const { undoes, timings, places } = lineOf(page), at = await places(), { phonemes } = await timings();
  /** @param {number} n a phoneme @returns {{x: number, y: number}} its middle */
  const middle = (n) => at((phonemes[n].start + phonemes[n].end) / 2, 1);
  result.before = phonemes;
  await page.click("#timeline", { position: middle(2) });
  await page.click("#timeline", { position: middle(6), modifiers: ["Shift"] });
  await picture("range");
  await page.click("button:text-is('Align again')");
  await undoes("Undo: Align again");
  result.after = (await timings()).phonemes;
  await page.keyboard.press("Control+z");
  await undoes("Nothing");
  result.undone = (await timings()).phonemes;

  await page.evaluate(() => { location.hash = "#language"; });
  await page.click("summary:text-is('New language…')", WAIT);
  await page.fill("[aria-label='Name']", "english");
  await page.selectOption("[aria-label='Language to start from']", "english");
  await page.click("button:text-is('Begin')");
  await page.waitForSelector("#toasts .fault", WAIT);
  result.refused = await page.textContent("#toasts .fault");
  await picture("refused");
  await page.fill("[aria-label='Name']", "elvish");
  await page.fill("[aria-label='Code']", "qya");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelector(".language h2")?.textContent?.startsWith("Elvish"), null, WAIT);
  result.title = await page.textContent(".language h2");
  result.open = await page.inputValue("#of-language");
  await page.waitForSelector("#toasts .fault", { state: "detached" });
  result.told = await page.textContent("#toasts");
  await picture("begun");
});
