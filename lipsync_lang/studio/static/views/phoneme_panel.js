/** The chosen phoneme beside the timeline: its label, typed or picked, and what may become of it. */

import { button, made } from "../shell/elements.js";

/**
 * @typedef {{relabel: (label: string) => void, split: (label?: string) => void, join: () => void,
 *   remove: () => void, align: () => void}} PhonemeChanges
 */

export class PhonemePanel {
  /** @param {HTMLElement} place @param {PhonemeChanges} does */
  constructor(place, does) {
    this.place = place;
    this.inserting = false;
    this.name = made("bdi");
    const traits = { type: "text", list: "phoneme-labels", autocomplete: "off", dir: "auto", size: "6" };
    this.field = made("input", { ...traits, "aria-label": "Label of the phoneme" });
    this.list = made("datalist", { id: "phoneme-labels" });
    const label = () => this.field.value.trim();
    this.joiner = button("Join", "Join it with the next phoneme, and keep this label (J)", () => does.join());
    const form = made("form", { class: "row" }, this.field, this.list,
      made("button", { type: "submit", title: "Give the phoneme this label (R, Enter)" }, "Relabel"),
      button("Insert", "Insert a phoneme of this label at the playhead (I, Enter)", () => does.split(label())));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (this.inserting) does.split(label());
      else does.relabel(label());
      this.field.blur();
    });
    this.field.addEventListener("blur", () => { this.inserting = false; });
    place.append(made("h2", "Phoneme ", this.name, " ", made("small", "Esc closes")), form,
      made("p", { class: "row" }, button("Split", "Split it at the playhead (S)", () => does.split()), this.joiner,
        button("Delete", "Delete it; a neighbour takes its time (Delete)", () => does.remove()),
        button("Align again", "Find the times of the chosen words again; Shift and a click choose more (G)",
          () => does.align())));
  }

  /** @param {{label: string, last: boolean} | null} chosen */
  show(chosen) {
    this.place.hidden = !chosen;
    if (!chosen) return;
    this.name.textContent = chosen.label;
    /** @type {HTMLButtonElement} */ (this.joiner).disabled = chosen.last;
    if (document.activeElement !== this.field) this.field.value = chosen.label;
  }

  /** @param {[label: string, mouths: string][]} labels to pick from */
  offer(labels) {
    this.list.replaceChildren(
      ...labels.map(([value, mouths]) => made("option", { value, label: mouths && `${value}  ${mouths}` })),
    );
  }

  /** Ask for a label. @param {boolean} inserting for a further phoneme */
  ask(inserting = false) {
    if (this.place.hidden) return;
    this.inserting = inserting;
    if (inserting) this.field.value = "";
    this.field.focus();
    this.field.select();
  }
}
