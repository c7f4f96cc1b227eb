// Open a page of a file in a headless browser, use it as a reader would, and print what came of it:
//
//   node show.mjs NODE_MODULES CHROMIUM FILE REPORT SOUGHT [FOLDER]
//
// REPORT is the number of the report to choose, SOUGHT what to search for. A FOLDER gets pictures.
// Printed is JSON: `said` and `asked`, the errors and the requests of all this; the rest below.
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { FLAT, launch, watch } from "./browsing.mjs";

const [modules, chromium, file, report, sought, folder] = process.argv.slice(2);

const browser = await launch(modules, chromium, ...FLAT);
const said = [], asked = [];

async function open(options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  watch(page, said, asked);
  await page.goto(String(pathToFileURL(file)));
  return page;
}

const picture = (page, name) =>
  folder && page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });

/** The report as it stands: its name, and the cells of its rankings that are not filtered away. */
const read = (page) => page.evaluate(() => {
  const rows = (id) => [...document.querySelectorAll(`#${id} tbody tr:not([hidden])`)];
  const cells = (id) => rows(id).map((row) => [...row.cells].map((cell) => cell.textContent));
  return {
    title: document.querySelector("#report h2")?.textContent ?? null,
    ranked: cells("ranked"),
    silence: cells("silence"),
    html: [...document.querySelectorAll("[data-part]")].map((part) => part.innerHTML).join("\n"),
  };
});

const choose = (page, number) => page.selectOption("#picker", String(number));

/** The controls that can be seen. */
const controls = (page) => page.evaluate(() =>
  [...document.querySelectorAll("select, input, .filters button, noscript")]
    .filter((one) => one.checkVisibility()).map((one) => one.localName));

try {
  const result = { said, asked };
  const page = await open({ colorScheme: "light" });
  await picture(page, "light");
  const first = await read(page);
  if (await page.locator("#picker").count()) {
    await choose(page, report);
    result.chosen = await read(page);
    result.address = page.url();
    await choose(page, 0);
    result.again = (await read(page)).html === first.html;

    await page.fill("#search", sought);
    result.sought = (await read(page)).ranked.map((cells) => cells[1]);
    await page.fill("#search", "");
    if (await page.locator(".filters button").count()) {
      await page.click(".filters button >> nth=0");
      result.filtered = (await read(page)).ranked.map((cells) => cells[5]);
      await page.click(".filters button >> nth=0");
    }
    await page.click("#ranked th >> nth=1 >> button");
    result.sorted = (await read(page)).ranked.map((cells) => cells[1]);

    // by keyboard: along the map, and into a report from the matrix
    if (await page.locator("#map td[tabindex='0']").count()) {
      await page.focus("#map td[tabindex='0']");
      result.tips = [await page.textContent(".tip b")];
      await page.keyboard.press("ArrowDown");
      result.tips.push(await page.textContent(".tip b"));
      await page.keyboard.press("Escape");
      result.hushed = await page.isHidden(".tip");
    }
    await page.focus(`#matrix [data-report='${report}'] button`);
    await page.keyboard.press("Enter");
    result.entered = (await read(page)).title;

    await page.emulateMedia({ media: "print" });
    result.printed = await controls(page);
    result.cut = await page.evaluate(() => [...document.querySelectorAll(".scroll")]
      .filter((box) => box.scrollHeight > box.clientHeight + 1).length);
    await picture(page, "print");
  }
  result.title = first.title;
  result.ranked = first.ranked;

  const linked = await open({ colorScheme: "dark" });
  if (result.address) {
    await linked.goto(result.address);
    await linked.reload();
    result.linked = (await read(linked)).title;
  }
  await picture(linked, "dark");

  const narrow = await open({ viewport: { width: 360, height: 740 } });
  result.overflow = await narrow.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  await picture(narrow, "narrow");

  const plain = await browser.newContext({ javaScriptEnabled: false });
  const still = await plain.newPage();
  await still.goto(String(pathToFileURL(file)));
  result.still = {
    controls: await still.locator("select:visible, input:visible, button:visible").count(),
    text: await still.innerText("main"),
  };
  console.log(JSON.stringify(result));
} finally {
  await browser.close();
}
