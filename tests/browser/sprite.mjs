// Show the sprite page of docs/how-to/draw-a-2d-mouth.md at moments of its sound: node sprite.mjs NODE_MODULES CHROMIUM FOLDER SECONDS...
//
// Printed is a list: the position of the drawings at each moment.
import { readFileSync } from "node:fs";
import { join, normalize } from "node:path";
import { FLAT, launch, serve } from "./browsing.mjs";

const [modules, chromium, folder, ...seconds] = process.argv.slice(2);
const server = await serve((path) => readFileSync(join(folder, normalize(path))));
const browser = await launch(modules, chromium, ...FLAT);
try {
  const page = await browser.newPage();
  page.on("pageerror", (error) => console.error(String(error)));
  await page.goto(`${server.address}/page.html`);
  await page.waitForFunction(() => mouth.style.backgroundPositionX, null, { timeout: 60000 });
  console.log(JSON.stringify(await page.evaluate(async (moments) => {
    const shown = [], frame = () => new Promise(requestAnimationFrame);
    for (const moment of moments) {
      Object.defineProperty(voice, "currentTime", { get: () => moment, configurable: true });
      await frame();
      await frame();
      shown.push(mouth.style.backgroundPositionX);
    }
    return shown;
  }, seconds.map(Number))));
} finally {
  await browser.close();
  server.close();
}
