/** Elements of drawings; pages of a line have none, and no address. */

const SPACE = "http://www.w3.org/2000/svg";

/**
 * Make an element of a drawing.
 * @param {string} name
 * @param {Record<string, string | number>} [traits]
 * @param {...(Node | string)} content
 * @returns {SVGElement}
 */
export function drawn(name, traits = {}, ...content) {
  const element = /** @type {SVGElement} */ (document.createElementNS(SPACE, name));
  for (const [key, value] of Object.entries(traits)) element.setAttribute(key, String(value));
  element.append(...content);
  return element;
}
