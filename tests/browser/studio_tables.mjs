// Use the tables of the studio in a headless browser, and print what came of it:
//
//   node studio_tables.mjs NODE_MODULES CHROMIUM ADDRESS STORY
//
// Printed is JSON: `said` and `asked`, the errors and the requests to other places; the rest is the story's.
import { createRequire } from "node:module";

const [modules, chromium, address, story] = process.argv.slice(2);
const { chromium: browsers } = createRequire(`${modules}/`)("playwright-core");
const flags = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"];
const browser = await browsers.launch({ executablePath: chromium, headless: true, args: flags });
const said = [], asked = [];

async function show(hash) {
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 } });
  page.on("pageerror", (error) => said.push(String(error)));
  page.on("console", (one) => ["error", "warning"].includes(one.type()) && !/GPU stall|GL Driver/.test(one.text()) && said.push(one.text()));
  page.on("dialog", (dialog) => { said.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  page.on("request", (one) => one.url().startsWith(new URL(address).origin) || /^(data|blob):/.test(one.url()) || asked.push(one.url()));
  await page.goto(address + hash);
  await page.waitForSelector("html[data-ready]");
  return page;
}

const tests = (page, text) => page.waitForFunction((wanted) => document.querySelector(".tests h3")?.textContent === wanted, text);
const nameless = (page) => page.evaluate(() => [...document.querySelectorAll("#view button, #view select, #view input")]
  .filter((one) => !one.textContent && !one.getAttribute("aria-label") && !one.closest("label")).map((one) => one.outerHTML));

const stories = {
  /** A mapping is changed: a test fails; it is undone, and the test passes. */
  async language() {
    const page = await show("#language");
    await tests(page, "Tests: all 2 pass");
    const rows = await page.$$eval(".sounds li", (all) => all.map((one) => one.dataset.row));
    const title = await page.textContent(".language h2");
    await page.fill("[aria-label='Word to try']", "pam");
    await page.waitForSelector(".tried button");
    const before = await page.textContent(".tried");
    await page.click("li[data-row='ipa m'] .to");
    await page.selectOption("[data-field=to-0]", "aa");
    await tests(page, "Tests: 1 of 2 fail");
    await page.waitForFunction((was) => document.querySelector(".tried").textContent !== was, before);
    const after = await page.textContent(".tried");
    const marked = await page.$$eval(".tests mark", (all) => all.map((one) => one.textContent.trim()));
    const first = await page.getAttribute(".sounds li", "data-row");
    await page.fill("[data-field=reason]", "only for <b>this</b> test");
    await page.press("[data-field=reason]", "Enter");
    await page.waitForFunction(() => document.querySelector("#save").textContent === "Save 2");
    await page.waitForFunction(() => document.querySelector("li[data-row='ipa m'] p").textContent.includes("only for"));
    const reasons = await page.textContent("li[data-row='ipa m'] p");
    await page.keyboard.press("Escape");
    await page.click("#undo");
    await page.click("#undo");
    await tests(page, "Tests: all 2 pass");
    const unnamed = await nameless(page);
    return { rows, title, before, after, marked, first, reasons, unnamed };
  },
};

const told = await stories[story]();
await browser.close();
process.stdout.write(JSON.stringify({ ...told, said, asked }));
