// Use the studio and a page of a line in a headless Firefox, and print what came of it:
//
//   node firefox.mjs NODE_MODULES FIREFOX ADDRESS PAIR PAGE FOLDER
//
// PAIR is a bigram of the line, PAGE the file of a page; FOLDER gets the exported files and the pictures. Printed is JSON:
// `said`, the errors of the pages; the rest below. Playwright drives a Firefox of its own alone, so Puppeteer does here.
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const [modules, executablePath, address, pair, file, folder] = process.argv.slice(2);
const WAIT = { timeout: 60000 };
const browser = await createRequire(`${modules}/`)("puppeteer-core").launch({
  browser: "firefox", executablePath, headless: true,
  extraPrefsFirefox: { "browser.download.folderList": 2, "browser.download.dir": folder },
});
const said = [];

/** Open an address, and watch the errors of its page. */
async function open(where) {
  const page = await browser.newPage();
  page.on("pageerror", (error) => said.push(String(error)));
  page.on("console", (one) => ["error", "warn"].includes(one.type()) && said.push(one.text()));
  page.on("dialog", (dialog) => { said.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  await page.setViewport({ width: 1366, height: 768 });
  await page.goto(where);
  const press = async (...keys) => {
    for (const key of keys) {
      const held = key.split("+"), last = held.pop();
      for (const one of held) await page.keyboard.down(one);
      await page.keyboard.press(last);
      for (const one of held) await page.keyboard.up(one);
    }
  };
  const text = (selector) => page.$eval(selector, (one) => one.textContent);
  const until = (holds, ...given) => page.waitForFunction(holds, WAIT, ...given);
  const undoes = (title) => until((wanted) => document.querySelector("#undo").title.startsWith(wanted), title);
  /** Play until the clock has moved. */
  const plays = async (clock) => {
    const before = await text(clock);
    await press(" ");
    await until((one, was) => document.querySelector(one).textContent !== was, clock, before);
    await press(" ");
  };
  const shot = (name) => page.screenshot({ path: `${folder}/${name}.png` });
  return { page, press, text, until, undoes, plays, shot };
}

try {
  const result = { said };
  const { page, press, text, until, undoes, plays, shot } = await open(`${address}#sentence`);
  await page.waitForSelector("html[data-ready]", WAIT);
  await until(() => !document.body.classList.contains("busy"));
  await plays("#clock");
  await press("Home", "]", "]", "ArrowRight");
  await undoes("Undo: Move the boundary");
  await shot("sentence");

  await page.evaluate((name) => { location.hash = `#bigrams/${name}`; }, pair);
  await page.waitForSelector(".curve-plot g.front [data-index='1']", WAIT);
  await page.$eval(".curve-plot g.front [data-index='1']", (one) => one.focus());
  await press("Shift+ArrowUp");
  await until(() => !document.querySelector("#undo").title.startsWith("Undo: Move the boundary"));
  result.edited = await page.$eval("#undo", (one) => one.title);
  await press("Control+z");
  await undoes("Undo: Move the boundary");
  await press("Control+Shift+Z");
  await undoes(result.edited);
  await shot("bigrams");

  result.views = [];
  for (const name of ["character", "words", "coverage", "language", "sentence"]) {
    await page.evaluate((one) => { location.hash = `#${one}`; }, name);
    await until((one) => document.body.dataset.view === one && !document.body.classList.contains("busy"), name);
    await until(() => document.querySelector("#view > section").innerText.trim().length > 20);
    result.views.push(name);
    await shot(name);
  }

  await press("Control+s");
  await until(() => document.querySelector("#save").textContent === "Saved");
  await page.click("#export");
  await page.waitForSelector("dialog[open] input[value='csv']", WAIT);
  await page.click("dialog[open] input[value='csv']");
  await page.click("dialog[open] button.main");
  await until(() => /^Exported/.test(document.querySelector("dialog[open] [role=status]").textContent));
  result.exported = await text("dialog[open] [role=status]");

  const line = await open(String(pathToFileURL(file)));
  await line.page.waitForSelector("#poses li", WAIT);
  await line.plays("#moment");
  result.title = await line.text("#title");
  await line.shot("page");
  console.log(JSON.stringify(result));
} finally {
  await browser.close();
}
