// Open the page of a line in a headless browser, use it as a viewer would, and print what came of it:
//
//   node line.mjs NODE_MODULES CHROMIUM FILE CLOSED OPEN
//
// CLOSED and OPEN are seconds at which the mouth is shut and open. Printed is JSON: `said` and `asked`,
// the errors and the requests of all this; the rest below.
import { pathToFileURL } from "node:url";
import { WEBGL, go, launch, settle, watch } from "./browsing.mjs";

const [modules, chromium, file, closed, open] = process.argv.slice(2);

const browser = await launch(modules, chromium, ...WEBGL);
const said = [], asked = [];

async function show(options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, ...options });
  watch(page, said, asked);
  await page.goto(String(pathToFileURL(file)));
  await page.waitForSelector("html[data-ready]", { timeout: 120000 });
  return page;
}

/** The pixels of a face, small. */
const pixels = (page, number = 0) => page.evaluate((which) => {
  const small = Object.assign(document.createElement("canvas"), { width: 64, height: 64 });
  const context = small.getContext("2d");
  context.drawImage(document.querySelectorAll("#faces canvas")[which], 0, 0, 64, 64);
  return [...context.getImageData(0, 0, 64, 64).data];
}, number);

const differing = (a, b) => a.filter((one, n) => Math.abs(one - b[n]) > 24).length;
const clock = async (page) => parseFloat((await page.textContent("#clock")).replace("−", "-"));

try {
  const result = { said, asked };
  const page = await show();
  await page.waitForSelector("figure[data-shaded]"); // after the first picture
  result.title = await page.textContent("#title");
  result.poses = await page.$$eval("#poses button > span:first-child", (all) => all.map((one) => one.textContent));

  result.at = [await go(page, Number(closed))];
  const shut = await pixels(page);
  result.at.push(await go(page, Number(open)));
  const wide = await pixels(page);
  result.moved = differing(shut, wide);
  result.picture = wide;
  await settle(page);
  result.still = differing(wide, await pixels(page));

  // by keyboard: frames, phonemes, a pose and its reasons, the help
  await page.keyboard.press("Home");
  await settle(page);
  const first = await clock(page);
  for (const key of ["ArrowRight", "ArrowRight", "ArrowRight", "ArrowLeft"]) await page.keyboard.press(key);
  await settle(page);
  result.stepped = (await clock(page)) - first;
  for (const key of [".", "."]) await page.keyboard.press(key);
  await settle(page);
  result.moment = await page.textContent("#moment");
  await page.keyboard.press("ArrowDown");
  await settle(page);
  result.reasons = await page.$$eval("#poses ol li", (all) => all.map((one) => one.textContent));
  await page.keyboard.press("?");
  result.help = await page.isVisible("#help dt");
  await page.keyboard.press("Escape");
  result.helped = await page.isVisible("#help dt");
  await page.keyboard.press("c");
  await settle(page);
  result.closer = differing(wide, await pixels(page));
  await page.keyboard.press("c");

  // a tap on the timeline, and playing at half speed
  const box = await page.locator("#timeline").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + 60);
  await settle(page);
  result.tapped = await clock(page);
  await page.keyboard.press("Home");
  await page.keyboard.press("2");
  result.pitch = await page.evaluate(() => HTMLAudioElement.prototype.hasOwnProperty("preservesPitch") || "preservesPitch" in new Audio());
  await page.keyboard.press(" ");
  await page.waitForFunction((from) => parseFloat(document.querySelector("#clock").textContent.replace("−", "-")) > from + 0.2, first, { timeout: 60000 });
  await page.keyboard.press(" ");
  result.paused = await page.getAttribute("#play", "aria-label");

  // the first word again and again, to its end and back to its beginning
  for (const key of ["Home", "'", "1", "l"]) await page.keyboard.press(key);
  await settle(page);
  const begin = await clock(page);
  await page.keyboard.press(" ");
  result.looped = await page.evaluate(async (from) => {
    const now = () => parseFloat(document.querySelector("#clock").textContent.replace("−", "-"));
    let turns = 0, last = now(), far = last;
    for (const end = performance.now() + 60000; turns < 2 && performance.now() < end;) {
      await new Promise(requestAnimationFrame);
      if (now() < last - 0.05) turns++;
      last = now();
      far = Math.max(far, last);
    }
    return { turns, long: far - from, before: from - last };
  }, begin);
  await page.keyboard.press(" ");
  await page.keyboard.press("l");

  const nameless = await page.$$eval("button, input, select, canvas:not([aria-hidden])", (all) => all
    .filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim())).map((one) => one.outerHTML));
  result.nameless = nameless;
  if (await page.isVisible("#against")) {
    const before = await page.textContent(".front figcaption");
    await page.keyboard.press("a");
    await settle(page);
    result.swapped = [before, await page.textContent(".front figcaption")];
  }
  await page.close();

  const phone = await show({ viewport: { width: 360, height: 740 }, colorScheme: "dark", hasTouch: true, reducedMotion: "reduce" });
  result.overflow = await phone.evaluate(() => document.documentElement.scrollWidth - innerWidth);

  // on paper the colours are light, and the reader's own again after it
  result.inks = await phone.evaluate(() => ["", "beforeprint", "afterprint"].map((event) => {
    if (event) { dispatchEvent(new Event(event)); }
    const plot = document.querySelector("#timeline");
    const copy = Object.assign(document.createElement("canvas"), { width: plot.width, height: plot.height });
    const context = copy.getContext("2d");
    context.drawImage(plot, 0, 0);
    const pixels = context.getImageData(0, 0, plot.width, plot.height).data;
    const solid = [...pixels.keys()].filter((n) => n % 4 === 0 && pixels[n + 3] > 250);
    return [getComputedStyle(document.body).color, solid.reduce((sum, n) => sum + pixels[n], 0) / solid.length];
  }));
  console.log(JSON.stringify(result));
} finally {
  await browser.close();
}
