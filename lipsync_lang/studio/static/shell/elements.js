/** Elements of a page: found by name, or made; text is never markup. */

/** @param {string} id @returns {HTMLElement} */
export function the(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/**
 * Make an element.
 * @template {keyof HTMLElementTagNameMap} Name
 * @param {Name} name
 * @param {...(Record<string, string> | Node | string)} parts its traits, if any, and its content
 * @returns {HTMLElementTagNameMap[Name]}
 */
export function made(name, ...parts) {
  const element = document.createElement(name);
  for (const one of parts) {
    if (typeof one === "string" || one instanceof Node) element.append(one);
    else for (const [key, value] of Object.entries(one)) element.setAttribute(key, value);
  }
  return element;
}

/**
 * Make a button.
 * @param {string | Node[]} content
 * @param {string | Record<string, string>} about its title, or its traits
 * @param {(pressed: MouseEvent) => void} does
 * @returns {HTMLButtonElement}
 */
export function button(content, about, does) {
  const traits = typeof about === "string" ? { ...(about && { title: about }) } : about;
  const one = made("button", { type: "button", ...traits }, ...[content].flat());
  one.addEventListener("click", does);
  return one;
}

/** Signs at the end of a name that are always seen. */
const TAIL = 7;

/**
 * Make a name that is cut in the middle where it has no room.
 * @param {string} name
 * @param {Record<string, string>} [traits]
 */
export function middled(name, traits = {}) {
  const signs = [...name], cut = Math.max(0, signs.length - TAIL), { class: more = "", ...rest } = traits;
  return made("span", { ...rest, class: `middled ${more}`.trim(), dir: "auto", title: name },
    made("span", signs.slice(0, cut).join("")), made("span", signs.slice(cut).join("")));
}

/**
 * Angles of the lines on the colour of a stage, by its number. Stages seven apart share a pattern; no colours that
 *   look alike do.
 */
export const HATCHES = [[], [45], [], [90], [0], [-45], [45, -45]];

/** @param {number} number of a stage @returns {string} its lines, as a picture of style sheets */
export const hatching = (number) => HATCHES[number % HATCHES.length].map((angle) =>
  `repeating-linear-gradient(${angle % 90 ? -angle : angle}deg,#0000 0 3px,#222c 3px 4px)`,
).join() || "none";

/**
 * @param {string} text
 * @param {string} colour
 * @param {string} form of the sample: a patch, `dots` or a dashed `line`
 * @param {number} number of the stage that a patch is for
 */
export function swatch(text, colour, form = "", number = 0) {
  const one = made("li", { class: `swatch ${form}` }, text);
  one.style.setProperty("--c", colour);
  one.style.setProperty("--hatch", hatching(number));
  return one;
}
