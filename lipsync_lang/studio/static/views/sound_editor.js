/** The editor of one row of a language's table of sounds: its mouths, their shares, the reason. */

import { button, made } from "../shell/elements.js";
import { selectInput, textInput } from "../shell/form_fields.js";

/** @typedef {import("./language_view.js").Sound} Sound */
/** @typedef {import("./language_view.js").CommonPhoneme} CommonPhoneme */

/** Selects of mouths in their order, with what is needed to choose among them. */
export class SoundEditor {
  /**
   * @param {{edit: (edits: import("../shell/studio.js").Edit[], title: string) => Promise<void>, close: () => void}}
   *   does
   */
  constructor(does) {
    this.does = does;
    this.place = made("div", { class: "sound-editor" });
    /** @type {Sound | null} */
    this.sound = null;
    /** @type {CommonPhoneme[]} */
    this.common = [];
  }

  /**
   * Show a row.
   * @param {Sound} sound @param {CommonPhoneme[]} common @param {{parent: boolean}} pack
   * @returns {HTMLElement}
   */
  show(sound, common, { parent }) {
    const within =
      document.activeElement instanceof HTMLElement && this.place.contains(document.activeElement)
        ? document.activeElement.dataset.field
        : "";
    [this.sound, this.common] = [sound, common];
    const selects = [...sound.to, ""].map((name, at) => this.#select(name, at));
    const row = made(
      "div",
      { class: "row" },
      ...selects.flatMap((one, at) => (at ? [made("span", "then"), one] : [one])),
    );
    if (sound.to.length) row.append(button("Mute", "This sound moves nothing", () => this.#map([])));
    if (sound.own && parent)
      row.append(button("As inherited", "Remove this mapping from the file, and use that of the extended pack", () =>
        this.#edit(undefined)));
    row.append(button("Done", "Close (Esc)", () => this.does.close()));
    /** @type {HTMLElement[]} */
    const parts = [row];
    if (sound.to.length > 1) parts.push(this.#shares(sound));
    parts.push(this.#reason(sound), ...sound.to.map((name) => this.#about(name)));
    this.place.replaceChildren(...parts);
    if (within)
      setTimeout(() =>
        /** @type {HTMLElement | null} */ (this.place.querySelector(`[data-field="${within}"]`))?.focus(),
      );
    return this.place;
  }

  focus() {
    this.place.querySelector("select")?.focus();
  }

  /** @param {string} name @param {number} at @returns {HTMLElement} */
  #select(name, at) {
    const none = this.sound?.to.length ? (name ? "— remove —" : "+ another…") : "Choose a mouth…";
    const mouths = [["", none], ...this.common.map((one) => [one.name, this.#words(one)])];
    if (!mouths.some(([value]) => value === name)) mouths.push([name, name]);
    const select = selectInput(`Mouth ${at + 1} of ${this.sound?.label}`, mouths, { "data-field": `to-${at}` });
    select.value = name;
    select.addEventListener("change", () => {
      const to = [...(this.sound?.to ?? [])];
      to.splice(at, 1, ...(select.value ? [select.value] : []));
      this.#map(to);
    });
    return select;
  }

  /** @param {CommonPhoneme} one @returns {string} */
  #words({ name, title, ipa, like, example }) {
    const letters = ipa.length ? ` [${ipa.slice(0, 4).join(" ")}]` : "";
    return `${like ? "   " : ""}${name}${letters} ${title}${example ? `, ${example}` : ""}`;
  }

  /** @param {string} name @returns {HTMLElement} */
  #about(name) {
    const one = this.common.find((common) => common.name === name);
    if (!one) return made("small", name);
    const like = one.like ? `; a shade of ${one.like}: ${one.reason}` : "";
    const ipa = one.ipa.length ? `; as in IPA ${one.ipa.join(" ")}` : "";
    const example = one.example ? `, English ‘${one.example}’` : "";
    return made("small", made("b", name), ` ${one.title}${ipa}${example}${like}`);
  }

  /** @param {Sound} sound @returns {HTMLElement} */
  #shares(sound) {
    const even = sound.to.map(() => Math.round(100 / sound.to.length)),
      now = sound.shares.length ? sound.shares.map((one) => Math.round(100 * one)) : even;
    const label = "Shares of its time, %";
    const input = textInput(label, { value: now.join(" "), inputmode: "numeric", "data-field": "shares" });
    input.addEventListener("change", () => {
      const parts = input.value.trim().split(/[\s,;/]+/).map(Number), whole = parts.reduce((sum, one) => sum + one, 0);
      const fit = parts.length === sound.to.length && parts.every((one) => one > 0) && Number.isFinite(whole);
      input.setCustomValidity(fit ? "" : `Enter ${sound.to.length} numbers above 0`);
      if (!input.reportValidity()) return;
      const even = parts.every((one) => one === parts[0]);
      this.#map(sound.to, even ? [] : exact(parts.map((one) => one / whole)));
    });
    return made("label", label, input);
  }

  /** @param {Sound} sound @returns {HTMLElement} */
  #reason(sound) {
    const placeholder = sound.why || "A reason, if the mapping is not obvious";
    const traits = { value: sound.reason, dir: "auto", maxlength: "500", placeholder, "data-field": "reason" };
    const input = textInput("Reason", { ...traits, spellcheck: "true" });
    input.addEventListener("change", () => {
      const value = input.value.trim(), at = ["reasons", sound.label];
      if (value !== sound.reason)
        this.does.edit(
          [value || !sound.own_reason ? { file: "language", at, value } : { file: "language", at }],
          `Reason of ${sound.label}`,
        );
    });
    return made("label", "Reason", input);
  }

  /** @param {string[]} to @param {number[]} [shares] */
  #map(to, shares = []) {
    this.#edit(shares.length ? { to, shares } : to.length === 1 ? to[0] : to);
  }

  /** @param {unknown} value of the row, or nothing to take it out */
  #edit(value) {
    if (!this.sound) return;
    const { notation, label } = this.sound, at = ["notations", notation, label];
    this.does.edit(
      [value === undefined ? { file: "language", at } : { file: "language", at, value }],
      value === undefined ? `${label} as inherited` : `Map ${label}`,
    );
  }
}

/** @param {number[]} shares @returns {number[]} to three places, with a sum of 1 */
function exact(shares) {
  const rough = shares.map((one) => Math.round(1000 * one)), rest = 1000 - rough.reduce((sum, one) => sum + one, 0);
  return rough.map((one, at) => (one + (at ? 0 : rest)) / 1000);
}
