/** Elements of a page: found by name, or made; text is never markup. */

/** @param {string} id @returns {HTMLElement} */
export function the(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/**
 * Make an element.
 * @param {string} name
 * @param {Record<string, string>} [traits]
 * @param {...(Node | string)} content
 * @returns {HTMLElement}
 */
export function made(name, traits = {}, ...content) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(traits)) element.setAttribute(key, value);
  element.append(...content);
  return element;
}

/**
 * @param {string} text
 * @param {string} colour
 * @param {string} form of the sample: a patch, `dots` or a dashed `line`
 */
export function swatch(text, colour, form = "") {
  const one = made("li", { class: `swatch ${form}` }, text);
  one.style.setProperty("--c", colour);
  return one;
}
