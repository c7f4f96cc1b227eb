// Print how fast the studio is for an animator, and how large, in a headless browser:
//
//   LIPSYNC_LANG_NODE_MODULES=... node benchmarks/studio.mjs PYTHON [CHROMIUM [PAIR]]
//
// PAIR is a bigram of the lines that a key of its curve moves. An edit ends once the frame with the new curves is drawn. The
// face is drawn flat: in software, WebGL would take longer than all else. The machine should be idle.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { FLAT, launch } from "../tests/browser/browsing.mjs";

const [python, chromium = "/usr/bin/chromium", pair = "bmp-aa"] = process.argv.slice(2);
const PACKS = ["-l", "english", "-c", "facefx"], TEXT = "Bob bumps my blue boat, and a map of Mali falls into the bay. ";
const EDITS = 24, WAIT = { timeout: 120000 };
const folder = mkdtempSync(join(tmpdir(), "studio-")), env = { ...process.env, XDG_STATE_HOME: folder };
const show = (what, figure, goal) => console.log(what.padEnd(44), String(figure).padStart(10), ` goal ${goal}`);

/** Count the requests and answers that a page awaits. */
const counting = () => {
  const awaited = (globalThis.awaited = { now: 0, begun: 0 });
  for (const [owner, name] of [[globalThis, "fetch"], [Response.prototype, "json"], [Response.prototype, "arrayBuffer"]]) {
    const plain = owner[name];
    owner[name] = async function (...what) {
      awaited.now++;
      awaited.begun++;
      try { return await plain.apply(this, what); } finally { awaited.now--; }
    };
  }
};

const browser = await launch(process.env.LIPSYNC_LANG_NODE_MODULES, chromium, ...FLAT);
const began = performance.now();
const server = spawn(python, ["-m", "lipsync_lang", "studio", ...PACKS, "--no-browser"], { cwd: folder, env });
try {
  const [said] = await new Promise((done) => createInterface({ input: server.stdout }).once("line", (line) => done([line])));
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 } }), kinds = new Map();
  const network = await page.context().newCDPSession(page);
  let sent = 0;
  await network.send("Network.enable");
  network.on("Network.responseReceived", (one) => kinds.set(one.requestId, one.type));
  network.on("Network.loadingFinished", (one) => { if (kinds.get(one.requestId) === "Script") sent += one.encodedDataLength; });
  await page.addInitScript(counting);
  await page.goto(said.split(" ").at(-1));
  await page.waitForSelector("html[data-ready]", WAIT);
  show("start to usable with a pair, s", ((performance.now() - began) / 1000).toFixed(2), 2);
  show("scripts sent, kB", (sent / 1000).toFixed(0), 110);
  for (const [seconds, goal] of [[8.5, 80], [110, 150]]) {
    const text = TEXT.repeat(Math.round(seconds / 3.6));
    await page.evaluate(() => { location.hash = "#sentence"; });
    await page.fill("#text", text);
    await page.press("#text", "Enter");
    await page.waitForFunction(
      (least) => document.querySelector("#timeline")?.getAttribute("aria-label")?.length > least && !globalThis.awaited.now,
      text.length * 0.9, WAIT,
    );
    await page.evaluate((name) => { location.hash = `#bigrams/${name}`; }, pair);
    await page.focus(".curve-plot g.front [data-index='1']", WAIT);
    const spent = [];
    for (let n = 0; n < EDITS; n++) {
      spent.push(await page.evaluate(async (key) => {
        const frame = () => new Promise(requestAnimationFrame), { awaited } = globalThis, { begun } = awaited;
        const from = performance.now();
        document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey: true, bubbles: true, cancelable: true }));
        let drawn = from;
        for (let idle = 0; idle < 4; idle++) {
          await frame();
          if (awaited.now || awaited.begun === begun) idle = -1;
          if (idle) continue;
          const { port1, port2 } = new MessageChannel(); // its message comes once this frame is drawn
          await new Promise((done) => { port1.onmessage = done; port2.postMessage(0); });
          drawn = performance.now();
        }
        return drawn - from;
      }, n % 2 ? "ArrowDown" : "ArrowUp"));
    }
    spent.sort((a, b) => a - b);
    show(`edit to curves, line of ${seconds} s, median ms`, spent[EDITS / 2].toFixed(0), goal);
  }
  const status = readFileSync(`/proc/${server.pid}/status`, "utf8");
  show("memory of the server, MB", Math.round(Number(/VmRSS:\s+(\d+)/.exec(status)[1]) / 1024), 200);
  const out = join(folder, "line.html");
  execFileSync(python, ["-m", "lipsync_lang", "run", TEXT.repeat(36), ...PACKS, "-q", "-o", out], { env, stdio: "inherit" });
  show("page of a line of 130 s, MB", (statSync(out).size / 1e6).toFixed(2), 3);
} finally {
  server.kill();
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
