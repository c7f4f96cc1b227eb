/** The dialog of a conflict: curves of both sides over each other, and a choice for each entry. */

import { drawn } from "./drawings.js";
import { made } from "./elements.js";
import { bspline } from "../curves/bspline.js";

/** @typedef {{key: string, what: string, mine: string, theirs: string}} Conflict as JSON text, or words */
/** @typedef {"mine" | "theirs"} Side */

const SIDES = /** @type {[Side, string][]} */ ([["mine", "mine"], ["theirs", "the file's"]]);
/** Size of a picture in its own units, and the number of steps of a smooth curve. */
const WIDE = 320, HIGH = 110, STEPS = 64;

/** @param {unknown} value @returns {value is [number, number][]} */
function pointed(value) {
  return Array.isArray(value) && value.length > 0
    && value.every((one) => Array.isArray(one) && one.length === 2 && one.every((n) => typeof n === "number"));
}

/**
 * @param {unknown} value of an entry
 * @param {string} name
 * @returns {[string, unknown][]} its curves and plain values, by their names
 */
function leaves(value, name = "") {
  if (!value || typeof value !== "object" || pointed(value)) return [[name, value]];
  return Object.entries(value).flatMap(([key, one]) => leaves(one, name ? `${name} ${key}` : key));
}

/** @param {string} text @returns {Map<string, unknown>} */
function read(text) {
  try {
    return new Map(leaves(JSON.parse(text)));
  } catch {
    return new Map([["", text]]); // such as that it is deleted
  }
}

/**
 * A picture of both sides of a curve: mine as a line, that of the file dashed.
 * @param {string} name @param {Record<Side, unknown>} sides
 */
function picture(name, sides) {
  const both = SIDES.map(([side]) => sides[side]).filter(pointed).flat();
  const [left, right] = [Math.min(...both.map(([at]) => at)), Math.max(...both.map(([at]) => at))];
  const [low, high] = [Math.min(0, ...both.map(([, one]) => one)), Math.max(1, ...both.map(([, one]) => one))];
  const x = (/** @type {number} */ at) => 6 + ((at - left) / (right - left || 1)) * (WIDE - 12);
  const y = (/** @type {number} */ one) => HIGH - 6 - ((one - low) / (high - low)) * (HIGH - 12);
  const svg = drawn("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": `${name}: both curves` });
  svg.append(drawn("line", { x1: 0, x2: WIDE, y1: y(0), y2: y(0), class: "axis" }));
  for (const [side] of SIDES) {
    const points = sides[side];
    if (!pointed(points)) continue;
    const [first, last] = [points[0][0], points[points.length - 1][0]], smooth = name.includes("curves ");
    const at = Array.from({ length: STEPS + 1 }, (_, n) => first + ((last - first) * n) / STEPS);
    const values = smooth && points.length > 1 ? bspline(points, at) : null;
    const path = (values ? at.map((one, n) => [one, values[n]]) : points).map(([t, v]) => `${x(t)},${y(v)}`);
    svg.append(drawn("polyline", { points: path.join(" "), class: side }));
    svg.append(...points.map(([t, v]) => drawn("circle", { cx: x(t), cy: y(v), r: 2.5, class: side })));
  }
  return made("figure", made("figcaption", { dir: "auto" }, name.replace(/^curves /, "")), svg);
}

/** @param {Conflict} conflict @returns {Element[]} pictures of the curves that differ, and words for other values */
function comparison({ mine, theirs }) {
  const sides = { mine: read(mine), theirs: read(theirs) }, shown = [], words = /** @type {string[]} */ ([]);
  for (const name of new Set([...sides.mine.keys(), ...sides.theirs.keys()])) {
    const [own, other] = [sides.mine.get(name), sides.theirs.get(name)];
    if (JSON.stringify(own) === JSON.stringify(other)) continue;
    if (pointed(own) || pointed(other)) shown.push(picture(name, { mine: own, theirs: other }));
    else words.push(`${name ? `${name}: ` : ""}${told(own)} (mine), ${told(other)} (the file's)`);
  }
  return [...shown, ...words.map((one) => made("p", { dir: "auto" }, one))];
}

/** @param {unknown} value */
function told(value) {
  return value === undefined ? "not there" : String(value);
}

/**
 * Ask whose values to keep, where a file was changed on the disk as well.
 * @param {Conflict[]} conflict
 * @returns {Promise<Record<string, string> | null>} the side by key; null if nothing is chosen now
 */
export async function settled(conflict) {
  const rows = conflict.map((one) => made("li",
    made("b", one.what), " ",
    made("select", { "aria-label": `Version of ${one.what} to keep`, "data-key": one.key },
      ...SIDES.map(([value, name]) => made("option", { value }, `Keep ${name}`))),
    made("div", { class: "both" }, ...comparison(one))));
  const form = made("form", { method: "dialog" },
    made("h2", "Also changed on the disk"),
    made("p", { class: "both" }, ...SIDES.map(([side, name]) => made("span", { class: side }, name))),
    made("ul", ...rows),
    made("p", { class: "row" },
      made("button", { class: "main", value: "save" }, "Save"), made("button", "Not now")));
  const dialog = made("dialog", { class: "conflict", "aria-label": "Conflict" }, form);
  document.body.append(dialog);
  dialog.showModal();
  await new Promise((done) => dialog.addEventListener("close", done));
  dialog.remove();
  if (dialog.returnValue !== "save") return null;
  return Object.fromEntries([...dialog.querySelectorAll("select")].map((one) => [one.dataset.key, one.value]));
}
