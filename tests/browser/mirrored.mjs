// Open and bend the rows of mirrored poses in the studio, in a headless browser, and print what came of it:
//
//   node mirrored.mjs NODE_MODULES CHROMIUM ADDRESS PAIR LEFT PICTURE
//
// PAIR names the row of both poses, LEFT that of the left one. Printed is JSON: `said` and `asked`, the errors and the
// requests to other places; the rest below.
import { inStudio, lineOf, settle } from "./browsing.mjs";

await inStudio(async ({ open, result, given: [pair, left, picture] }) => {
  const page = await open("#sentence");
  const { settings, undoes } = lineOf(page);
  const rows = () => page.$$eval("#poses > li > button:first-child .middled", (all) => all.map((one) => one.title));
  const bend = async (row, title) => {
    await page.click(`#poses .middled[title='${row}']`);
    await page.keyboard.press("k");
    await page.keyboard.press("Shift+ArrowUp");
    await undoes(title);
    await settle(page); // both keys have that title
    return (await settings()).bends;
  };
  const folder = page.locator(`[data-pair='${pair}']`);

  await folder.waitFor();
  await page.keyboard.press("'"); // a key belongs to a word
  result.closed = await rows();
  result.both = await bend(pair, `Undo: Bend ${pair}`);
  await page.screenshot({ path: picture });
  await folder.focus();
  await page.keyboard.press("Enter");
  result.opened = await rows();
  result.focused = await page.evaluate(() => document.activeElement.dataset.pair);
  await page.screenshot({ path: picture.replace(".png", "-opened.png") });
  await page.keyboard.press("Enter");
  result.again = await rows();
  await folder.click();
  result.one = await bend(left, `Undo: Bend ${left}`);
  await folder.waitFor({ state: "detached" }); // the two move differently now
  result.apart = await rows();
});
