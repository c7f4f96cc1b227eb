// Talk to the page of a voice by a recording in place of a microphone, and print what it showed:
//
//   node voice.mjs NODE_MODULES CHROMIUM ADDRESS RECORDING [FOLDER]
//
// Printed is JSON: the states, the phones, the weights that moved, the delay before and after a
// change, and the errors. Pictures of the page go to a folder, with the seconds of each as its name.
import { WEBGL, launch, watch } from "./browsing.mjs";

const [modules, chromium, address, recording, folder] = process.argv.slice(2);
const FILM_FRAMES = 60;
const FAKE = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream", `--use-file-for-fake-audio-capture=${recording}`];
const browser = await launch(modules, chromium, ...WEBGL, ...FAKE);
const said = [], asked = [], states = [];

const page = await browser.newPage({ permissions: ["microphone"] });
page.setDefaultTimeout(120000);
watch(page, said, asked, new RegExp(`^(${new URL(address).origin}/|data:|blob:)`));
const frames = [];
page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => {
  for (const { weights } of JSON.parse(payload).frames ?? []) frames.push(weights);
}));
await page.goto(address);
await page.waitForSelector("html[data-ready]", { timeout: 120000 });
const state = (text) => page.waitForFunction((wanted) => document.querySelector("#state").textContent.startsWith(wanted), text);
const heard = async (count) => {
  while (frames.length < count) await page.waitForEvent("websocket", { timeout: 100 }).catch(() => {});
};

await state("The microphone is off");
await page.click("#listen");
await state("Listening");
states.push(await page.textContent("#state"));
await heard(90);
const phones = await page.locator("#belief li").allTextContents();
if (folder) await page.setViewportSize({ width: 1000, height: 460 });
for (let n = 0, began = performance.now(); folder && n < FILM_FRAMES; n++) {
  const seconds = ((performance.now() - began) / 1000).toFixed(3);
  await page.screenshot({ path: `${folder}/${seconds.padStart(7, "0")}.png` });
}
await page.fill("#delay", "200");
await page.dispatchEvent("#delay", "change");
const first = frames.length;
await heard(first + 30);
const delay = await page.textContent("#told");
await page.click("#listen");
await state("The microphone is off");
states.push(await page.textContent("#state"));
const named = await page.evaluate(() => [...document.querySelectorAll("button, input, canvas")].every(
  (one) => one.getAttribute("aria-label") || one.textContent.trim() || one.labels?.length));
console.log(JSON.stringify({ said, asked, states, phones, frames, delay, named }));
await browser.close();
