// A headless browser, pages that are watched, and a server of files, for the scripts of this folder.
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname } from "node:path";

const FLAGS = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync",
];
/** Flags of a browser that draws WebGL in software, and pages without it: as WebGL they cost twice the time. */
export const WEBGL = ["--use-gl=angle", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader"];
/** Flags of a browser that draws no WebGL; without a GPU alone it would draw it in software. */
export const FLAT = ["--disable-gpu", "--disable-3d-apis"];
const TYPES = {
  "": "text/html", ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".mjs": "text/javascript", ".wav": "audio/wav",
};
const DRIVER = /GPU stall|GL Driver/; // warnings of drawing in software

/** Start the browser at a path, with the `playwright-core` of a folder of modules. */
export const launch = (modules, executablePath, ...more) =>
  createRequire(`${modules}/`)("playwright-core").chromium.launch({ executablePath, headless: true, args: [...FLAGS, ...more] });

/** Add the errors and dialogs of a page to `said`, and its requests to addresses that are not `own` to `asked`. */
export function watch(page, said, asked = [], own = /^(file|data|blob|about):/) {
  page.awaited = new Set();
  page.on("request", (one) => /\/api\//.test(one.url()) && page.awaited.add(one));
  for (const end of ["requestfinished", "requestfailed"]) page.on(end, (one) => page.awaited.delete(one));
  page.on("pageerror", (error) => said.push(String(error)));
  page.on("console", (one) => ["error", "warning"].includes(one.type()) && !DRIVER.test(one.text()) && said.push(one.text()));
  page.on("dialog", (dialog) => { said.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  page.on("request", (one) => own.test(one.url()) || asked.push(one.url()));
  return page;
}

/** Wait until a watched page has drawn some frames in which it awaited no answer. */
export async function settle(page) {
  for (let frames = 0; frames < 4; frames++) {
    await page.evaluate(() => new Promise(requestAnimationFrame));
    if (page.awaited.size) frames = -1;
  }
}

/** Go to a moment of the page of a line by the slider, halving the way, and wait until it is drawn. */
export const go = (page, seconds) => page.evaluate(async (wanted) => {
  const slider = document.querySelector("#scrub");
  const clock = () => parseFloat(document.querySelector("#clock").textContent.replace("−", "-"));
  let low = 0, high = Number(slider.max);
  while (low < high) {
    const middle = (low + high) >> 1;
    slider.value = middle;
    slider.dispatchEvent(new Event("input"));
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    if (clock() < wanted - 1e-3) low = middle + 1;
    else high = middle;
  }
  slider.value = low;
  slider.dispatchEvent(new Event("input"));
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  return clock();
}, seconds);

/** Addresses of the studio's views, with what each shows once it is loaded. */
export const VIEWS = {
  "sentence": "#timeline",
  "bigrams": "td[data-pair]",
  "bigrams/aa-bmp": ".curve-plot g.front [data-index]",
  "character": ".pose-sheet canvas",
  "character/targets": "[data-phoneme]",
  "character/rules": ".ranks li",
  "character/model": ".drop",
  "words": "nav.own button",
  "coverage": ".quality li",
  "language": ".sounds li",
};

/** Go to a view of the studio, and wait until it is loaded and its small faces are drawn. */
export async function visit(page, view) {
  await page.evaluate((name) => { location.hash = `#${name}`; }, view);
  await page.waitForSelector(`body[data-view='${view.split("/")[0]}'] ${VIEWS[view]}`, { state: "attached", timeout: 30000 });
  await page.waitForFunction(() => [...document.querySelectorAll(".pose-sheet canvas")].every((one) => {
    const blank = Object.assign(document.createElement("canvas"), { width: one.width, height: one.height });
    return !one.checkVisibility() || one.toDataURL() !== blank.toDataURL();
  }));
  await settle(page);
}

/** Return a function that opens a view of the studio at an address, watched, once it is ready. */
export const studio = (browser, address, said, asked) => async (view = "", options = {}) => {
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 }, ...options });
  watch(page, said, asked, new RegExp(`^(${new URL(address).origin}/|data:|blob:)`));
  await page.goto(address + view);
  await page.waitForSelector("html[data-ready]", { timeout: 120000 });
  return page;
};

/**
 * Run a script on the studio at an address, `node SCRIPT NODE_MODULES CHROMIUM ADDRESS GIVEN...`, and print its `result` as JSON,
 * with `said` and `asked`: the errors and the requests to other places.
 */
export async function inStudio(script) {
  const [modules, chromium, address, ...given] = process.argv.slice(2);
  const browser = await launch(modules, chromium, ...WEBGL), result = { said: [], asked: [] };
  try {
    await script({ open: studio(browser, address, result.said, result.asked), result, given });
    process.stdout.write(JSON.stringify(result));
  } finally {
    await browser.close();
  }
}

/** Pixels of the timeline: its ruler, the sound, a band of labels, and the left end of the curves. */
const RULER = 24, SOUND = 52, BAND = 22, LEFT = 104;
const WAIT = { timeout: 60000 };

/** Return ways to ask a page of the studio about its open line, and to find a moment of it on the timeline. */
export const lineOf = (page) => ({
  /** Wait until undo has this title. */
  async undoes(title) {
    const named = page.waitForFunction((wanted) => document.querySelector("#undo").title.startsWith(wanted), title, WAIT);
    await named.catch(async (cause) => {
      throw new Error(`not '${title}' but '${await page.getAttribute("#undo", "title")}'`, { cause });
    });
  },
  /** Return the phonemes and the words, with their times. */
  timings: () => page.evaluate(async () => JSON.parse((await (await fetch("api/timings/json")).json()).content)),
  settings: () => page.evaluate(async () => (await (await fetch("api/state")).json()).settings),
  /** Show the whole line; return a function from seconds and a band of labels (0: words, 1: phonemes, 4: the first pose) to pixels. */
  async places() {
    await page.click("#fit");
    const [width, from, to, top] = await page.evaluate(async ([ruler, wave]) => {
      const bytes = new Uint8Array(await (await fetch("api/line")).arrayBuffer());
      const length = new DataView(bytes.buffer).getUint32(0, true);
      const { sound, takes } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
      const { start, count, fps } = takes[0], end = start + (count - 1) / fps;
      return [document.querySelector("#timeline").clientWidth, start, end, ruler + (sound ? wave : 0)];
    }, [RULER, SOUND]);
    return (seconds, band) => ({
      x: LEFT + ((seconds - from) / (to - from)) * (width - LEFT - 8), y: top + (band + 0.5) * BAND,
    });
  },
});

/** Serve the contents that `find` has for paths, and return the address and a function that ends it. */
export async function serve(find, headers = {}) {
  const server = createServer((request, response) => {
    const path = new URL(request.url, "http://here").pathname;
    try {
      const content = find(path);
      response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream", ...headers }).end(content);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}
