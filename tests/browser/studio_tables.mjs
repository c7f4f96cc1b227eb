// Use the tables of the studio in a headless browser, and print what came of it:
//
//   node studio_tables.mjs NODE_MODULES CHROMIUM ADDRESS STORY
//
// Printed is JSON: `said` and `asked`, the errors and the requests to other places; the rest is the story's.
import { WEBGL, launch, studio } from "./browsing.mjs";

const [modules, chromium, address, story] = process.argv.slice(2);
const browser = await launch(modules, chromium, ...WEBGL);
const said = [], asked = [];
const show = studio(browser, address, said, asked);

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

  /** A script is dropped, a line judged; a row of the plan opens its bigram, a finding its moment. */
  async coverage() {
    const page = await show("#coverage");
    await page.setInputFiles(".coverage input[type=file]", { name: "<b>script.txt", mimeType: "text/plain", buffer: Buffer.from("ma pa\nay ma\n") });
    await page.waitForSelector(".needs button.pair");
    const plan = await page.$$eval(".needs .pair", (all) => all.map((one) => one.textContent));
    const script = await page.$eval("[aria-label=Script]", (one) => one.selectedOptions[0].textContent);
    const accepted = await page.$eval("[aria-label='Script to open']", (one) => one.accept);
    const facts = await page.textContent(".facts");
    await page.click("text=Lines of the script");
    const sentence = await page.textContent(".sentence p");
    await page.fill("#text", "ma pa may");
    await page.press("#text", "Enter");
    await page.waitForFunction(() => !document.body.classList.contains("busy"));
    await page.waitForLoadState("networkidle");
    await page.waitForSelector(".quality li button");
    // read and pressed at once: the list may be drawn again between two steps
    const at = await page.$eval(".quality li button", (one) => { one.click(); return parseFloat(one.textContent); });
    await page.waitForFunction((wanted) => Math.abs(parseFloat(document.querySelector("#clock").textContent) - wanted) < 0.02, at);
    const unnamed = await nameless(page);
    await page.click(".needs .pair");
    await page.waitForFunction(() => document.body.dataset.view === "bigrams");
    const opened = await page.evaluate(() => location.hash);
    await page.goto(address + "#bigrams");
    await page.waitForSelector(".wanted button");
    const wanted = await page.textContent(".wanted button b");
    return { plan, script, accepted, facts, sentence, opened, wanted, unnamed };
  },

  /** The word at the playhead gets curves of its own, a line its delivery; both are saved. */
  async words() {
    const page = await show("#words");
    await page.fill("#text", "ma pa may");
    await page.press("#text", "Enter");
    await page.waitForFunction(() => !document.body.classList.contains("busy"));
    await page.evaluate(() => document.activeElement.blur());
    for (let n = 0; n < 4; n++) await page.keyboard.press(".");
    await page.keyboard.press("n");
    await page.waitForSelector(".curves-place .point");
    await page.waitForFunction(() => document.querySelector(".grid text.sound"));
    const opened = await page.evaluate(() => location.hash);
    const sounds = await page.$$eval(".grid text.sound", (all) => all.map((one) => one.textContent));
    const before = await page.getAttribute(".curves-place .front .point:nth-child(3)", "aria-label");
    await page.focus(".curves-place .front .point:nth-child(3)");
    await page.keyboard.press("Shift+ArrowUp");
    await page.waitForFunction((was) => document.querySelector(".curves-place .front .point:nth-child(3)").getAttribute("aria-label") !== was, before);
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("of pa"));
    await page.click("text=+ new");
    await page.waitForFunction(() => location.hash.includes("line"));
    await page.click("#undo");
    await page.waitForFunction(() => document.querySelectorAll(".own li").length === 1);
    await page.click("text=+ new");
    await page.waitForFunction(() => document.querySelectorAll(".own li").length === 2);
    await page.fill("[data-field=jaw]", "0.5");
    const loaded = page.waitForResponse((answer) => answer.url().endsWith("/words"));
    let answered;
    const typing = new Promise((done) => { answered = done; });
    await page.route("**/words", async (route) => { await typing; await route.continue(); }); // the answer comes after the word
    await page.press("[data-field=jaw]", "Enter");
    await page.waitForFunction(() => document.querySelector("#undo").title.includes("jaw"));
    const unnamed = await nameless(page);
    await page.fill("[data-field=jaw]", "three");
    answered();
    await loaded;
    await page.unroute("**/words");
    await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
    const typed = await page.inputValue("[data-field=jaw]");
    await page.press("[data-field=jaw]", "Enter");
    const refused = await page.$eval("[data-field=jaw]", (one) => one.validationMessage);
    await page.evaluate(() => document.activeElement.blur());
    await page.click("#save");
    await page.waitForFunction(() => document.querySelector("#save").textContent === "Saved");
    const items = await page.$$eval(".own li a", (all) => all.map((one) => one.firstChild.textContent));
    return { opened, sounds, typed, refused, items, unnamed };
  },
};

const told = await stories[story]();
await browser.close();
process.stdout.write(JSON.stringify({ ...told, said, asked }));
