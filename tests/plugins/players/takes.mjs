// Play the example of an archive in a headless browser: node takes.mjs NODE_MODULES CHROMIUM FOLDER [PICTURE]
//
// Printed is JSON: the errors, the sounds that were asked for, where they and the face were when they started, and
// the weights by shape at a time of the line, after Play, after the language has changed, and after Skip.
import { readFileSync } from "node:fs";
import { join, normalize } from "node:path";
import { WEBGL, launch, serve, watch } from "../../browser/browsing.mjs";

const [modules, chromium, folder, picture] = process.argv.slice(2);
const MODULES = "/node_modules/";
const server = await serve((path) => readFileSync(
  path.startsWith(MODULES) ? join(modules, normalize(path.slice(MODULES.length))) : join(folder, normalize(path)),
));
const browser = await launch(modules, chromium, ...WEBGL, "--autoplay-policy=no-user-gesture-required");
const said = [], sounds = [];
try {
  const page = await browser.newPage({ viewport: { width: 480, height: 360 } });
  watch(page, said);
  page.on("request", (one) => one.url().endsWith(".wav") && sounds.push(one.url().split("/sound/")[1]));
  await page.addInitScript(() => {
    const kind = AudioBufferSourceNode.prototype, start = kind.start;
    window.starts = [];
    kind.start = function (when, offset) { // seconds of the sound now, as it is started and as the face has it
      window.starts.push([offset - (when - this.context.currentTime), window.crab.player.soundTime]);
      start.call(this, when, offset);
    };
  });
  await page.goto(`${server.address}/beach.html`);
  await page.waitForFunction(() => window.crab, null, { timeout: 60000 });
  const shown = () => page.evaluate(() => {
    const { player, meshes } = window.crab;
    const shapes = {};
    for (const { morphTargetDictionary: names, morphTargetInfluences: values } of meshes)
      for (const [name, number] of Object.entries(names)) shapes[name] = values[number];
    return { shapes, time: player.time, lines: document.forms[0].line.length };
  });
  const faded = () => page.waitForFunction(() => window.crab.player.left === 0, null, { timeout: 60000 });
  await page.selectOption("#line", "beach_02");
  await page.click("#play");
  await page.waitForFunction(() => Math.max(...window.crab.player.weights) > 0.3, null, { timeout: 60000 });
  await faded();
  if (picture) await page.screenshot({ path: picture });
  const played = await shown();
  await page.selectOption("#language", "spanish");
  await page.waitForFunction(() => window.starts.length === 2, null, { timeout: 60000 });
  await faded();
  const switched = await shown();
  await page.click("#skip");
  await page.waitForFunction(() => Math.max(...window.crab.player.weights) === 0, null, { timeout: 60000 });
  const starts = await page.evaluate(() => window.starts);
  console.log(JSON.stringify({ said, sounds, starts, played, switched, skipped: await shown() }));
} finally {
  await browser.close();
  server.close();
}
