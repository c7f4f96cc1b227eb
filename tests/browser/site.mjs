// Open every page of the built site from its files, on a phone and a desk, light and dark, and search:
//
//   node site.mjs NODE_MODULES CHROMIUM SEARCHER FOLDER SOUGHT [PICTURES]
//
// SOUGHT is searched for on the first page, by the browser SEARCHER. A folder PICTURES gets one picture of each view.
// Printed is JSON: `said` and `asked`, the errors and the requests of all this; `wide`, the pages that
// scroll sideways; `faint`, the pages whose text has little contrast; `found`, the results of the search.
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { FLAT, launch, watch } from "./browsing.mjs";

const [modules, chromium, searcher, folder, sought, pictures] = process.argv.slice(2);

const CONTRAST = 4.5; // WCAG 2, level AA
const said = [], asked = [], wide = [], faint = [];

async function context(browser, options) {
  const made = await browser.newContext(options);
  const page = await made.newPage();
  await page.addInitScript(() => { // colours are judged as they stay, and no frame of a change is painted
    const still = Object.assign(document.createElement("style"), { textContent: "* { transition: none !important }" });
    addEventListener("DOMContentLoaded", () => document.head.append(still));
  });
  watch(page, said, asked);
  return page;
}

/** The parts of a page that are wider than the window, apart from boxes that scroll by themselves. */
const overflow = (page) => page.evaluate(() => {
  if (document.documentElement.scrollWidth <= innerWidth) { return []; }
  const scrolls = (one) => one && (getComputedStyle(one).overflowX !== "visible" || scrolls(one.parentElement));
  return [...document.querySelectorAll("article *")]
    .filter((one) => one.getBoundingClientRect().right > innerWidth + 1 && !scrolls(one.parentElement))
    .map((one) => `${one.tagName} ${one.textContent?.slice(0, 40)}`).slice(0, 3);
});

/** The least contrast of text with the colour behind it (WCAG), of headings, paragraphs, cells and code. */
const contrast = (page) => page.evaluate(() => {
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const seen = new Map(); // a page has thousands of texts and few colours
  const rgba = (colour) => {
    if (seen.has(colour)) { return seen.get(colour); }
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    seen.set(colour, [r, g, b, a / 255]);
    return seen.get(colour);
  };
  const over = (top, below) => top.slice(0, 3).map((c, n) => c * top[3] + below[n] * (1 - top[3]));
  const backs = new Map([[null, [255, 255, 255]]]); // parts of a page share what they stand on
  const behind = (one) => {
    if (!backs.has(one)) { backs.set(one, over(rgba(getComputedStyle(one).backgroundColor), behind(one.parentElement))); }
    return backs.get(one);
  };
  const light = (colour) => {
    const [r, g, b] = colour.map((c) => c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  let least = [99, ""];
  for (const one of document.querySelectorAll("article :is(h1,h2,h3,p,li,td,th,a:not(.headerlink),code,pre span)")) {
    const text = [...one.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!text || !one.checkVisibility()) { continue; }
    const back = behind(one);
    const [a, b] = [light(over(rgba(getComputedStyle(one).color), back)), light(back)];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < least[0]) { least = [ratio, `${one.tagName} ${one.textContent.slice(0, 30)}`]; }
  }
  return least;
});

const pages = readdirSync(folder, { recursive: true })
  .map(String).filter((name) => name.endsWith(".html") && name !== "404.html").sort();
const url = (name) => String(pathToFileURL(join(folder, name)));

const sizes = { phone: { width: 390, height: 844 }, desk: { width: 1440, height: 900 } };

// Widths depend on the size and colours on the scheme, so that two views show both; pictures show all four.
const views = pictures
  ? [["phone", "light"], ["phone", "dark"], ["desk", "light"], ["desk", "dark"]]
  : [["phone", "light"], ["desk", "dark"]];

/** Look at a page that is open, in one size and colour scheme. */
async function look(page, name, size, colorScheme) {
  await page.setViewportSize(sizes[size]);
  await page.emulateMedia({ colorScheme });
  const view = `${name} ${size} ${colorScheme}`;
  const parts = await overflow(page);
  if (parts.length) { wide.push([view, parts]); }
  const [ratio, where] = await contrast(page);
  if (ratio < CONTRAST) { faint.push([view, Math.round(ratio * 100) / 100, where]); }
  if (pictures) {
    const path = join(pictures, `${view.replaceAll(/[/ ]/g, "_")}.png`);
    await page.screenshot({ path });
  }
}

/** Do something with a browser, and close it. */
async function within(path, work, ...flags) {
  const browser = await launch(modules, path, ...FLAT, ...flags);
  try { return await work(browser); } finally { await browser.close(); }
}

await within(chromium, async (browser) => {
  const reader = await context(browser, { viewport: sizes.phone, colorScheme: "light" });
  for (const name of pages) {
    await reader.goto(url(name));
    for (const [size, colorScheme] of views) { await look(reader, name, size, colorScheme); }
    views.reverse(); // the next page opens as this one ends, which saves it a layout
  }
}, ...(pictures ? [] : ["--disable-threaded-compositing"])); // without it no frame is painted, which takes a third less time
const found = await within(searcher, async (browser) => {
  const page = await context(browser, { viewport: sizes.desk });
  await page.goto(url(pages[0]));
  await page.fill("[data-md-component=search-query]", sought);
  const results = page.locator(".md-search-result__item h1");
  await results.first().waitFor({ timeout: 30000 });
  return results.allTextContents();
});
console.log(JSON.stringify({ said, asked, wide, faint, read: pages.length, found }));
