// Draw frames of a line's page in a headless browser, close to the mouth, as pictures in a folder:
//
//   node pinholes.mjs NODE_MODULES CHROMIUM FILE FRAMES FOLDER
//
// FRAMES is a JSON list of numbers. Printed is JSON: `said`, the errors of the page, and `frames`, those that were drawn.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { WEBGL, launch, settle, watch } from "./browsing.mjs";

const [modules, chromium, file, frames, folder] = process.argv.slice(2);
const browser = await launch(modules, chromium, ...WEBGL);
const said = [];

try {
  const page = watch(await browser.newPage({ viewport: { width: 1280, height: 800 } }), said);
  await page.goto(String(pathToFileURL(file)));
  await page.waitForSelector("figure[data-shaded]", { timeout: 120000 });
  await page.keyboard.press("c");
  await settle(page);
  const drawn = [];
  for (const frame of JSON.parse(frames)) {
    const [shown, picture] = await page.evaluate(async (wanted) => {
      const slider = document.querySelector("#scrub"), canvas = document.querySelector("#faces canvas");
      slider.value = wanted;
      slider.dispatchEvent(new Event("input"));
      await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
      return [Number(slider.value), canvas.toDataURL("image/png")];
    }, frame);
    drawn.push(shown);
    writeFileSync(join(folder, `${frame}.png`), Buffer.from(picture.split(",")[1], "base64"));
  }
  console.log(JSON.stringify({ said, frames: drawn }));
} finally {
  await browser.close();
}
