// Answer the page of a study in a headless browser as a rater would, and print what came of it:
//
//   node study.mjs NODE_MODULES CHROMIUM ADDRESS FOLDER
//
// ADDRESS is a file or a URL. Printed is JSON: `said` and `asked`, the errors and the requests of all
// this; the rest below. Pictures and the export go to FOLDER.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, watch } from "./browsing.mjs";

const [modules, chromium, address, folder] = process.argv.slice(2);
const url = /^https?:/.test(address) ? address : String(pathToFileURL(address));
const browser = await launch(modules, chromium);
const said = [], asked = [];

async function show(options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  if (options.storeless) await page.addInitScript(() => { Object.defineProperty(window, "localStorage", { get() { throw new Error("refused"); } }); });
  watch(page, said);
  page.on("request", (one) => /^(file|data|blob):/.test(one.url()) || asked.push(`${one.method()} ${new URL(one.url()).pathname}`));
  await page.goto(url);
  await page.waitForSelector("html[data-ready]", { timeout: 60000 });
  return page;
}

const heading = (page) => page.textContent("#which");
const nameless = (page) => page.$$eval("button, input, select, video, textarea, progress, a", (all) => all
  .filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim() || one.closest("label")?.textContent.trim()))
  .map((one) => one.outerHTML));
const open = (page) => page.$$eval(".question", (all) => all.every((one) => !one.disabled));
const over = (page, side) => page.waitForFunction((one) => document.querySelector(`#video-${one}`).ended, side, { timeout: 30000 });

/** Play both clips, by button and by key, and say when the questions opened. */
async function play(page) {
  const opened = [await open(page)];
  await page.click("#play-left");
  await over(page, "left");
  opened.push(await open(page));
  await page.keyboard.press("b");
  await over(page, "right");
  await page.waitForFunction(() => !document.querySelector(".question").disabled);
  opened.push(await open(page));
  return opened;
}

async function answer(page, choice, strength) {
  for (const key of await page.$$eval("input[value=left]", (all) => all.map((one) => one.name.slice("choice-".length)))) {
    await page.check(`input[name=choice-${key}][value=${choice}]`);
    await page.check(`input[name=strength-${key}][value="${strength}"]`);
  }
}

/** Let the store of a page hold an older state of the answers, as a page that is reloaded at once can find it. */
const older = (page) => page.evaluate(() => {
  for (const [key, kept] of Object.entries(localStorage)) {
    const given = JSON.parse(kept);
    localStorage.setItem(key, JSON.stringify({ ...given, finished: null, answers: given.answers.slice(0, -1) }));
  }
});

try {
  const result = { said, asked };
  const page = await show();
  result.title = await page.title();
  await page.screenshot({ path: join(folder, "welcome-desktop.png") });
  await page.click("#begin"); // without consent
  result.refused = await page.isHidden("#rating");
  for (const one of await page.$$("#asked select")) await one.selectOption({ index: 1 });
  await page.check("#agree");
  await page.click("#begin");
  result.first = await heading(page);
  result.opened = await play(page);
  result.early = await page.isDisabled("#next");
  await page.screenshot({ path: join(folder, "pair-desktop.png") });
  await answer(page, "left", 4);
  result.nameless = await nameless(page);
  await page.click("#next");
  result.second = await heading(page);

  await older(page);
  await page.reload();
  await page.waitForSelector("html[data-ready]");
  result.reloaded = await heading(page);
  await page.click("#stop");
  result.stopped = JSON.parse(await page.inputValue("#text"));
  await page.click("#resume");
  result.resumed = await heading(page);

  while (await page.isVisible("#rating")) {
    await play(page);
    await answer(page, "right", 2);
    await page.click("#next");
  }
  result.end = await page.textContent("#thanks");
  await page.waitForFunction(() => document.querySelector("#sent").textContent.match(/^(The answers were|Save or copy)/));
  result.sent = await page.textContent("#sent");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  result.file = download.suggestedFilename();
  const path = join(folder, "answers.json");
  await download.saveAs(path);
  result.saved = JSON.parse(readFileSync(path, "utf-8"));
  await page.click("#shown summary");
  result.shown = await page.inputValue("#text");
  await page.screenshot({ path: join(folder, "end-desktop.png") });
  await older(page);
  await page.reload();
  await page.waitForSelector("html[data-ready]");
  result.stays = await page.textContent("#thanks");
  await page.click("#another");
  result.asks = await page.textContent("#another");
  await page.evaluate(() => { Storage.prototype.removeItem = () => {}; }); // as if the store still had them
  await Promise.all([page.waitForNavigation(), page.click("#another")]);
  await page.waitForSelector("html[data-ready]");
  result.anew = [await page.isVisible("#welcome"), await page.isChecked("#agree")];
  await page.context().close();

  const phone = await show({ storeless: true, viewport: { width: 360, height: 740 }, colorScheme: "dark", hasTouch: true, isMobile: true });
  await phone.screenshot({ path: join(folder, "welcome-phone.png") });
  await phone.check("#agree");
  await phone.click("#begin");
  result.warned = await phone.textContent("#trouble");
  await phone.reload();
  await phone.waitForSelector("html[data-ready]");
  result.storeless = await phone.isVisible("#rating");
  await play(phone);
  result.overflow = await phone.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  await phone.screenshot({ path: join(folder, "pair-phone.png"), fullPage: true });
  await phone.click("#stop");
  result.others = JSON.parse(await phone.inputValue("#text"));
  console.log(JSON.stringify(result));
} finally {
  await browser.close();
}
