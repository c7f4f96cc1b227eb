/** Fields of forms: numbers with sliders, choices, and short lists. */

import { button, made, the } from "./elements.js";

/**
 * @typedef {object} Span
 * @property {number} min
 * @property {number} max
 * @property {number} step
 * @property {string} [usual] value if none is stated
 * @property {string} [unit]
 * @property {boolean} [disabled]
 */

/**
 * A field for words that no browser completes or corrects.
 * @param {string} label
 * @param {Record<string, string>} [traits]
 */
export function textInput(label, traits = {}) {
  return made("input", { type: "text", "aria-label": label, autocomplete: "off", spellcheck: "false", ...traits });
}

/**
 * A choice.
 * @param {string} label
 * @param {string[][]} pairs value and text of each option
 * @param {Record<string, string>} [traits]
 */
export function selectInput(label, pairs, traits = {}) {
  const options = pairs.map(([value, text]) => made("option", { value }, text));
  return made("select", { "aria-label": label, ...traits }, ...options);
}

/**
 * A number to type; empty for what is usual.
 * @param {string} label
 * @param {number | null} value
 * @param {Span} span
 * @param {(value: number | null) => void} changed
 */
export function numberField(label, value, span, changed) {
  const input = numberInput(label, value, span);
  input.addEventListener("change", () => changed(read(input, span)));
  return made(
    "label",
    { class: "number-field" },
    made("span", { dir: "auto" }, label),
    input,
    ...(span.unit ? [made("small", span.unit)] : []),
  );
}

/**
 * A number with a slider; a drag is reported while it goes on.
 * @param {string} label
 * @param {number | null} value
 * @param {Span} span
 * @param {(value: number | null, done: boolean) => void} changed
 */
export function sliderField(label, value, span, changed) {
  const input = numberInput(label, value, span), { min, max, step } = span;
  const slider = made("input", {
    type: "range", min: String(min), max: String(max), step: String(step), "aria-label": label,
  });
  slider.value = String(value ?? span.usual ?? min);
  slider.disabled = span.disabled ?? false;
  slider.addEventListener("input", () => {
    input.value = slider.value;
    changed(slider.valueAsNumber, false);
  });
  slider.addEventListener("change", () => changed(slider.valueAsNumber, true));
  input.addEventListener("change", () => {
    const now = read(input, span);
    slider.value = String(now ?? span.usual ?? min);
    changed(now, true);
  });
  return made(
    "div",
    { class: "slider-field" },
    made("span", { dir: "auto" }, label),
    slider,
    input,
    made("small", span.unit ?? ""),
  );
}

/** @param {string} label @param {number | null} value @param {Span} span */
function numberInput(label, value, { min, max, step, usual = "", disabled = false }) {
  const input = made("input", {
    type: "number",
    min: String(min),
    max: String(max),
    step: String(step),
    placeholder: usual,
    "aria-label": label,
  });
  input.value = value === null ? "" : String(value);
  input.disabled = disabled;
  return input;
}

/** @param {HTMLInputElement} input @param {Span} span @returns {number | null} */
function read(input, { min, max }) {
  if (input.value.trim() === "" || Number.isNaN(input.valueAsNumber)) return null;
  const value = Math.max(min, Math.min(max, input.valueAsNumber));
  input.value = String(value);
  return value;
}

/**
 * A choice of names.
 * @param {string} label
 * @param {string[]} names
 * @param {string} value "" shows the label as a hint
 * @param {(name: string) => void} changed
 * @param {boolean} [disabled]
 */
export function choiceField(label, names, value, changed, disabled = false) {
  const select = selectInput(label, [...(value ? [] : [["", label]]), ...names.map((name) => [name, name])]);
  select.value = value;
  select.disabled = disabled;
  select.addEventListener("change", () => select.value && changed(select.value));
  return select;
}

/**
 * @param {string} text @param {string} label @param {() => void} does @param {boolean} [disabled]
 * @returns {HTMLButtonElement}
 */
export function actButton(text, label, does, disabled = false) {
  return Object.assign(button(text, { "aria-label": label, title: label }, does), { disabled });
}

/** @param {string} id of a list @returns {string} its chosen value */
export function chosen(id) {
  return /** @type {HTMLSelectElement} */ (the(id)).value;
}

/** @param {HTMLElement} select @param {string[]} names @param {string} now the chosen one */
export function fillNames(select, names, now) {
  fillOptions(select, (names.includes(now) || !now ? names : [...names, now]).map((one) => [one, one]));
  if (now) /** @type {HTMLSelectElement} */ (select).value = now;
}

/** @param {HTMLElement} select @param {string[][]} pairs value and text */
export function fillOptions(select, pairs) {
  select.replaceChildren(...pairs.map(([value, text]) => made("option", { value }, text)));
}
