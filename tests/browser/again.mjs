// Align words of a line again in the studio, and begin a language, in a headless browser, and print what came of it:
//
//   node again.mjs NODE_MODULES CHROMIUM ADDRESS [PICTURES]
//
// A spoken line is open. Printed is JSON: `said` and `asked`, the errors and the requests to other places; the rest below.
import { WEBGL, launch, studio } from "./browsing.mjs";

const [modules, chromium, address, pictures] = process.argv.slice(2);
const RULER = 24 + 52, BAND = 22, LEFT = 104, WAIT = { timeout: 60000 };
const browser = await launch(modules, chromium, ...WEBGL);
const said = [], asked = [];
const open = studio(browser, address, said, asked);

try {
  const result = { said, asked };
  const page = await open("#sentence", { viewport: { width: 1400, height: 900 } });
  const picture = async (name) => pictures && await page.screenshot({ path: `${pictures}/${name}.png` });
  const undoes = (title) =>
    page.waitForFunction((wanted) => document.querySelector("#undo").title.startsWith(wanted), title, WAIT);
  const line = () => page.evaluate(async () => JSON.parse((await (await fetch("api/timings/json")).json()).content));
  await page.click("#fit");
  const box = await page.locator("#timeline").boundingBox();
  const [width, take] = await page.evaluate(async () => {
    const bytes = new Uint8Array(await (await fetch("api/line")).arrayBuffer());
    const length = new DataView(bytes.buffer).getUint32(0, true);
    const { takes } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    const from = takes[0].start, to = from + (takes[0].count - 1) / takes[0].fps;
    return [document.querySelector("#timeline").clientWidth, { from, to }];
  });
  const plot = width - LEFT - 8, { phonemes } = await line();
  /** @param {number} n a phoneme @returns {{x: number, y: number}} its middle */
  const middle = (n) => ({
    x: LEFT + (((phonemes[n].start + phonemes[n].end) / 2 - take.from) / (take.to - take.from)) * plot,
    y: RULER + 1.5 * BAND,
  });
  result.before = phonemes;
  await page.click("#timeline", { position: middle(2) });
  await page.click("#timeline", { position: middle(6), modifiers: ["Shift"] });
  await picture("range");
  await page.click("button:text-is('Align again')");
  await undoes("Undo: Align again");
  result.after = (await line()).phonemes;
  await page.keyboard.press("Control+z");
  await undoes("Nothing");
  result.undone = (await line()).phonemes;

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
  await picture("begun");
  process.stdout.write(JSON.stringify(result));
} finally {
  await browser.close();
}
