// Take pictures of the pages of a line and of two takes of it, on a desktop and on a phone:
//
//   node line_album.mjs NODE_MODULES CHROMIUM LINE TAKES FOLDER
import { pathToFileURL } from "node:url";
import { WEBGL, go, launch, settle } from "./browsing.mjs";

const [modules, chromium, line, takes, folder] = process.argv.slice(2);
const browser = await launch(modules, chromium, ...WEBGL);
const PHONE = { width: 405, height: 740 };

async function picture(name, file, seconds, viewport, colorScheme, use = () => {}) {
  const page = await browser.newPage({ viewport, colorScheme });
  page.awaited = new Set();
  await page.goto(String(pathToFileURL(file)));
  await page.waitForSelector("figure[data-shaded]", { timeout: 120000 });
  await go(page, seconds);
  await use(page);
  await settle(page);
  await page.screenshot({ path: `${folder}/${name}.png` });
}

await picture("desktop", line, 1.34, { width: 1366, height: 768 }, "light",
  (page) => page.locator("#poses button", { hasText: "PBM" }).click());
await picture("light", line, 0.24, PHONE, "light");
await picture("dark", takes, 0.24, PHONE, "dark", (page) => page.click("#close"));
await browser.close();
