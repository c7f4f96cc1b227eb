/** The mouths of sounds in measures, as a character shows them on a model whose targets are solved. */

import { made } from "../shell/elements.js";
import { actButton, numberField } from "../shell/form_fields.js";

/** @typedef {Record<string, number>} Mouth measures in widths of the closed mouth */
/** @typedef {{name: string, own: boolean, steps: Mouth[]}} SoundMouth */

/** Measures with their least and largest values; the last three may stay open. @type {[string, number, number][]} */
const MEASURES = [["aperture", 0, 1], ["width", -1, 1], ["protrusion", -1, 1], ["jaw", 0, 1], ["firm", 0.1, 4]];

/** Measures that every mouth states. */
const STATED = new Set(["aperture", "width"]);

export class MouthTable {
  /**
   * @param {HTMLElement} place
   * @param {(phoneme: string, mouth: Mouth | Mouth[] | undefined, title: string) => void} edit undefined for the usual
   * @param {(phoneme: string, step: number) => void} pose show it on the face
   */
  constructor(place, edit, pose) {
    this.edit = edit;
    this.body = made("tbody");
    /** @type {SoundMouth[]} */
    this.mouths = [];
    this.body.addEventListener("focusin", (event) => {
      const row = /** @type {HTMLElement} */ (event.target).closest("tr");
      pose(row?.dataset.phoneme ?? "", Number(row?.dataset.step));
    });
    const heads = ["sound", ...MEASURES.map(([name]) => name), ""].map((name) => made("th", { scope: "col" }, name));
    place.append(
      made("section", { class: "rule-part" },
        made("h3", "Mouths"),
        made("p", { class: "note" }, "The mouth of each sound as a viewer sees it, in widths of the closed mouth. " +
          "Targets that are solved on your model follow it; `firm` is how firmly the aperture is held (1). " +
          "A change belongs to this character, and the face shows the sound that you are at."),
        made("table", { class: "times mouths" }, made("thead", made("tr", ...heads)), this.body)),
    );
  }

  /** @param {SoundMouth[]} mouths */
  show(mouths) {
    this.mouths = mouths;
    const held = document.activeElement?.getAttribute("aria-label") ?? "";
    this.body.replaceChildren(...mouths.flatMap((mouth) => mouth.steps.map((_, step) => this.#row(mouth, step))));
    const again = held ? this.body.querySelector(`[aria-label="${CSS.escape(held)}"]`) : null;
    /** @type {HTMLElement | null} */ (again)?.focus();
  }

  /** @param {SoundMouth} mouth @param {number} step */
  #row({ name, own, steps }, step) {
    const label = steps.length > 1 ? `${name} ${step + 1}` : name;
    const cells = MEASURES.map(([measure, min, max]) => {
      const now = steps[step][measure] ?? null;
      const field = numberField(`${label}, ${measure}`, now, { min, max, step: 0.005 }, (value) => {
        if (value === null && STATED.has(measure)) {
          this.show(this.mouths);
          return;
        }
        const { [measure]: _, ...rest } = steps[step];
        const changed = steps.with(step, value === null ? rest : { ...steps[step], [measure]: value });
        this.edit(name, changed.length > 1 ? changed : changed[0], `Mouth of ${name}`);
      });
      return made("td", field);
    });
    const usual = own && !step
      ? [actButton("Usual", `The usual mouth of ${name}`, () => this.edit(name, undefined, `Usual mouth of ${name}`))]
      : [];
    const traits = { class: own ? "own" : "", "data-phoneme": name, "data-step": String(step) };
    return made("tr", traits, made("th", { scope: "row" }, label), ...cells, made("td", ...usual));
  }
}
