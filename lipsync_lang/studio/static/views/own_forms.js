/** Forms of a character's pronunciations and of the deliveries of its lines. */

import { button, made } from "../shell/elements.js";
import { textInput } from "../shell/form_fields.js";

/** @typedef {import("./words_view.js").Told} Told @typedef {import("./words_view.js").Line} Line */

/** The form of what is open, if it is no curve. */
export class OwnForms {
  /** @param {import("../shell/studio.js").Studio} studio @param {() => Promise<void>} load */
  constructor(studio, load) {
    this.studio = studio;
    this.load = load;
    this.place = made("form", { "aria-label": "Delivery or pronunciation" });
    /** Names of the open line or pronunciation, as one text. */
    this.shown = "";
    this.place.addEventListener("submit", (event) => event.preventDefault());
  }

  /** @param {Told} told @param {Line | undefined} line @param {Told["pronunciations"][number] | undefined} said */
  show(told, line, said) {
    const held = this.place.contains(document.activeElement) ? document.activeElement : null;
    const within = held?.getAttribute("data-field"),
      shown = JSON.stringify([line?.name, said?.language, said?.word]);
    const typing = held instanceof HTMLInputElement && held.value !== held.defaultValue;
    if (shown === this.shown && typing) return;
    this.shown = shown;
    this.place.hidden = !line && !said;
    this.place.replaceChildren(...(line ? this.#line(line) : said ? this.#said(told, said) : []));
    if (within)
      /** @type {HTMLElement | null} */ (this.place.querySelector(`[data-field="${CSS.escape(within)}"]`))?.focus();
  }

  /**
   * @param {string} text
   * @param {string} value
   * @param {string} hint
   * @param {(value: string, input: HTMLInputElement) => void} does
   * @returns {HTMLElement}
   */
  #field(text, value, hint, does) {
    const input = textInput(text, { value, placeholder: hint, "data-field": text, maxlength: "400" });
    input.addEventListener("change", () => {
      input.setCustomValidity("");
      does(input.value.trim(), input);
      if (input.validity.valid) input.defaultValue = input.value;
    });
    return made("label", made("span", text), input);
  }

  /** @param {Told} told @param {Told["pronunciations"][number]} said @returns {HTMLElement[]} */
  #said(told, { language, word, phonemes }) {
    const field = this.#field(
      "Common phonemes",
      phonemes.join(" "),
      "in order, separated by spaces",
      async (value, input) => {
        const wanted = value.split(/[\s,]+/).filter(Boolean),
          unknown = wanted.filter((one) => !told.phonemes.includes(one));
        input.setCustomValidity(
          !wanted.length
            ? "Enter at least one phoneme"
            : unknown.length
              ? `Unknown in this language: ${unknown.join(", ")}`
              : "",
        );
        if (!input.reportValidity()) return;
        await this.studio.edit(
          [{ file: "character", at: ["pronunciations", language, word], value: wanted }],
          `Pronunciation of ${word}`,
        );
        await this.#heard(word);
      },
    );
    return [
      field,
      made("p", { class: "note" }, `Phonemes of this language: ${told.phonemes.join(" ")}`),
      made("p", { class: "row" }, button(`▶ ${word}`, "", () => this.studio.speak(word))),
    ];
  }

  /** @param {string} word that is spoken again, within its line if it has one */
  async #heard(word) {
    const { text = "" } = this.studio.state;
    await this.studio.speak(text.toLocaleLowerCase().includes(word) ? text : word);
  }

  /** @param {Line} line @returns {HTMLElement[]} */
  #line(line) {
    const { studio } = this, { styles = [], regions = {} } = studio.state;
    const now = studio.settings.line === line.name;
    const use = button(
      now ? "Applied to the line" : "Apply to the line",
      { "aria-pressed": String(now), title: "Perform the line below with these edits and this delivery" },
      async () => {
        await studio.perform("take", { settings: { ...studio.settings, line: now ? null : line.name } });
        await this.load();
      },
    );
    const rows = (
      /** @type {"styles" | "dials"} */ kind,
      /** @type {string[]} */ names,
      /** @type {number} */ most,
      /** @type {string} */ hint,
    ) =>
      names.map((name) =>
        this.#field(name, levels(line[kind][name]), hint, (value, input) => {
          const found = read(value, most);
          input.setCustomValidity(
            found === undefined ? `Enter a number from 0 to ${most}, or pairs of word and level: 0 0.5, 2 1` : "",
          );
          if (!input.reportValidity()) return;
          const at = ["lines", line.name, kind, name];
          studio.edit(
            [found === null ? { file: "character", at } : { file: "character", at, value: found }],
            `${name} of ${line.name}`,
          );
        }),
      );
    const shares = rows(
      "styles",
      styles.filter((/** @type {string} */ one) => one !== "neutral"),
      1,
      "share of the style, 0 to 1",
    );
    return [
      made("p", { class: "row" }, use),
      ...(shares.length ? [made("h3", "Styles"), ...shares] : []),
      made("h3", "Dials"),
      ...rows("dials", Object.keys(regions), 2, "1 is normal, 0 still, 2 twice as far"),
      made(
        "p",
        { class: "note" },
        "One number is for the whole line. Pairs of word and level, separated by commas, change within the line: " +
          "0 0.5, 2.5 1 rises from the first word to the middle of the third.",
      ),
    ];
  }
}

/** @param {number[][] | undefined} points @returns {string} as it is typed */
function levels(points) {
  if (!points?.length) return "";
  return points.length === 1 && points[0][0] === 0
    ? String(points[0][1])
    : points.map((one) => one.join(" ")).join(", ");
}

/**
 * @param {string} text
 * @param {number} most
 * @returns {number | number[][] | null | undefined} null for nothing, undefined for a mistake
 */
function read(text, most) {
  if (!text) return null;
  const points = text.split(",").map((one) => one.trim().split(/\s+/).map(Number));
  if (!points.flat().every((one) => Number.isFinite(one) && one >= 0)) return undefined;
  if (points.length === 1 && points[0].length === 1) return points[0][0] <= most ? points[0][0] : undefined;
  const sound = points.every((one, n) => one.length === 2 && one[1] <= most && (!n || one[0] >= points[n - 1][0]));
  return sound ? points : undefined;
}
