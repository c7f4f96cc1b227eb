// Edit a bigram in the studio as an animator would, in a headless browser, and print what came of it:
//
//   node bigrams.mjs NODE_MODULES CHROMIUM ADDRESS PAIR
//
// PAIR is a bigram of the line. Printed is JSON: `said` and `asked`, the errors and the requests to other
// places; the rest below.
import { inStudio } from "./browsing.mjs";

await inStudio(async ({ open, result, given: [pair] }) => {
  const page = await open("#bigrams");
  const idle = (title) => page.waitForFunction((wanted) => document.querySelector("#undo").title === wanted, title, { timeout: 60000 });
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const status = () => page.textContent(".status [aria-pressed=true]");
  const points = () => page.$$eval(".front .point", (all) => all.map((one) => one.getAttribute("aria-label")));

  // from the matrix, by keyboard, to the bigram that the line needs
  await page.waitForSelector("td.need");
  result.needs = await page.$$eval("td.need", (all) => all.map((one) => one.dataset.pair));
  await page.focus(`td[data-pair='${pair}']`);
  await press("Enter");
  await page.waitForSelector(".front .point");
  result.title = await page.textContent(".bigram-head h2");
  result.ghosts = await page.$$eval(".ghosts button", (all) => all.map((one) => one.textContent));
  result.draft = { status: await status(), origin: await page.textContent(".origin"), points: await points() };
  await page.waitForSelector(".now[visibility=visible]", { state: "attached", timeout: 60000 });
  result.playhead = await page.getAttribute(".now", "visibility");

  // a point is dragged, and nudged; the word and the status follow
  const middle = await page.$$eval(".front .point", (all) => {
    const far = all.map((one) => Math.abs(Number(one.getAttribute("aria-valuenow")) - 0.5));
    return far.indexOf(Math.min(...far));
  });
  const box = await page.locator(".front .point").nth(middle).boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const before = await page.evaluate(() => document.querySelector(".front .smooth").getAttribute("d"));
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x, y + 6);
  await page.mouse.move(x + 8, y + 12);
  await page.mouse.up();
  await page.waitForFunction(() => document.querySelector("#undo").title.startsWith("Undo: Move"), null, { timeout: 60000 });
  await page.waitForFunction(() => /common\.yaml$/.test(document.querySelector(".origin").textContent) && !/draft/.test(document.querySelector(".origin").textContent), null, { timeout: 60000 });
  result.moved = before !== await page.evaluate(() => document.querySelector(".front .smooth").getAttribute("d"));
  await press("ArrowDown", "ArrowDown");
  result.edited = { status: await status(), points: await points() };
  result.word = await page.inputValue("input[aria-label='Word']");
  await page.fill("input[aria-label='Word']", "aloud");
  await press("Enter");
  await idle(`Undo: Word of ${pair}`);
  await press("Escape");
  await press("3");
  await idle(`Undo: Mark ${pair} as approved`);
  result.approved = await status();

  // undo all of it, and do it again
  const step = async (key, path) => Promise.all([page.waitForResponse((one) => one.url().endsWith(`api/${path}`)), press(key)]);
  const shows = (labels) => page.waitForFunction(([n, wanted]) => document.querySelectorAll(".front .point")[n]?.getAttribute("aria-label") === wanted, [middle, labels[middle]], { timeout: 60000 });
  for (let n = 0; n < 4; n++) await step("Control+z", "undo");
  await idle("Nothing to undo");
  await shows(result.draft.points);
  result.undone = { status: await status(), points: await points() };
  for (let n = 0; n < 4; n++) await step("Control+Shift+z", "redo");
  await idle(`Undo: Mark ${pair} as approved`);
  await shows(result.edited.points);
  await page.waitForFunction(() => document.querySelector(".status [aria-pressed=true]").textContent === "approved", null, { timeout: 60000 });
  result.again = { status: await status(), points: await points() };
  await press("Control+s");
  await page.waitForFunction(() => document.querySelector("#save").disabled, null, { timeout: 60000 });

  await press("w");
  await page.waitForSelector(`td[data-pair='${pair}'].approved`, { timeout: 60000 });
  result.cell = await page.getAttribute(`td[data-pair='${pair}']`, "aria-label");
  result.overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

  // the same bigram in a style, in a bank of its own
  await page.focus(`td[data-pair='${pair}']`);
  await press("Enter");
  await page.waitForSelector(".front .point");
  const manner = "select[aria-label='Style of the bank']";
  result.styles = await page.$$eval(`${manner} option`, (all) => all.map((one) => one.textContent));
  await page.selectOption(manner, "angry");
  await page.waitForFunction(() => /angry\.yaml/.test(document.querySelector(".origin").textContent), null, { timeout: 60000 });
  result.styled = await page.textContent(".origin");
  if (process.env.BIGRAMS_PICTURE) await page.screenshot({ path: process.env.BIGRAMS_PICTURE });
  await page.click(".status [data-status=edited]");
  await page.waitForFunction(() => document.querySelector(".origin").textContent === "posesets/crab/banks/angry.yaml", null, { timeout: 60000 });
  await press("Control+s");
  await page.waitForFunction(() => document.querySelector("#save").disabled, null, { timeout: 60000 });
  await page.close();

  const phone = await open(`#bigrams/${pair}`, { viewport: { width: 390, height: 844 }, colorScheme: "dark", hasTouch: true });
  await phone.waitForSelector(".front .point");
  result.narrow = await phone.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  result.kept = await phone.$$eval(".front .point", (all) => all.map((one) => one.getAttribute("aria-label")));
});
