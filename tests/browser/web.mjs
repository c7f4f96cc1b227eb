// Play the page of docs/how-to/web.md in a headless browser, and print what it shows while it sounds:
//
//   node web.mjs NODE_MODULES CHROMIUM FOLDER
//
// FOLDER holds the files of the page, and is served with NODE_MODULES beside them. Printed is JSON:
// `soundStart`, and `frames`, of each frame the seconds of the sound that are `heard`, the time of the
// clip (`at`), and the `weights` by shape, how many `parts` of meshes have shapes, and shapes whose parts
// are `apart`; and `weighed`, what weights.js says of hello.json at TIMES.
import { readFileSync } from "node:fs";
import { join, normalize } from "node:path";
import { WEBGL, launch, serve } from "./browsing.mjs";

const [modules, chromium, folder, times] = process.argv.slice(2);

const MODULES = "/node_modules/";

const server = await serve((path) => readFileSync(
  path.startsWith(MODULES) ? join(modules, normalize(path.slice(MODULES.length))) : join(folder, normalize(path)),
));
const browser = await launch(modules, chromium, ...WEBGL);
try {
  const page = await browser.newPage({ viewport: { width: 200, height: 200 } });
  page.on("pageerror", (error) => console.error(String(error)));
  page.on("console", (said) => said.type() === "error" && !/favicon/.test(said.location().url) && console.error(said.text()));
  await page.addInitScript(() => {
    const start = AudioBufferSourceNode.prototype.start;
    AudioBufferSourceNode.prototype.start = function (when) {
      window.soundAt = when;
      start.call(this, when);
    };
  });
  await page.goto(`${server.address}/index.html`);
  await page.waitForFunction(() => window.line, null, { timeout: 60000 });
  await page.evaluate(() => {
    const { face, mixer, audio } = window.line;
    const setTime = mixer.setTime.bind(mixer);
    window.frames_ = [];
    mixer.setTime = (at) => {
      const heard = audio.currentTime - (audio.outputLatency || 0) - window.soundAt;
      setTime(at);
      if (window.soundAt === undefined || audio.state !== "running") return;
      const weights = {}, apart = new Set();
      let parts = 0;
      face.scene.traverse((one) => {
        parts += Boolean(one.morphTargetDictionary);
        for (const [name, index] of Object.entries(one.morphTargetDictionary ?? {})) {
          const weight = one.morphTargetInfluences[index];
          if (weight !== (weights[name] ??= weight)) apart.add(name);
        }
      });
      window.frames_.push({ heard, at, weights, parts, apart: [...apart] });
    };
  });
  await page.mouse.click(100, 100);
  await page.waitForFunction(() => window.frames_.at(-1)?.heard > 0.8, null, { timeout: 60000 });
  const shown = await page.evaluate(() => ({ soundStart: window.line.soundStart, frames: window.frames_ }));
  shown.weighed = await page.evaluate(async (asked) => {
    const { weights } = await import("/weights.js");
    const line = await (await fetch("/hello.json")).json();
    return asked.map((seconds) => weights(line, seconds));
  }, JSON.parse(times));
  console.log(JSON.stringify(shown));
} finally {
  await browser.close();
  server.close();
}
