/** The model of a character: which it is, another one, and a character drafted from one. */

import { Refusal } from "../shell/api.js";
import { made } from "../shell/elements.js";
import { actButton, textInput } from "../shell/form_fields.js";

/** The panel of the model. */
export class ModelPanel {
  /** @param {HTMLElement} place @param {import("../shell/studio.js").Studio} studio */
  constructor(place, studio) {
    this.place = place;
    this.studio = studio;
    /** @type {File | null} */
    this.file = null;
    this.character = "";
    this.told = made("div", { role: "status" });
  }

  /** @param {{model: string | null, rig: string | null, poseset: string}} character */
  show({ model, rig, poseset }) {
    const { studio } = this, { character } = studio.state;
    const file = made("input", { type: "file", accept: ".glb,model/gltf-binary", "aria-label": "A model as GLB" });
    file.addEventListener("change", () => {
      this.file = file.files?.[0] ?? null;
      if (this.file) this.#try(this.file);
    });
    const area = made(
      "label",
      { class: "drop" },
      made("b", "Choose a model, or drop it here"),
      made("span", "GLB with the shapes of the poses, at most 64 MB. " +
        "It is copied into the project, beside the character's pack."),
      file,
    );
    area.addEventListener("dragover", (event) => event.preventDefault());
    area.addEventListener("drop", (event) => {
      event.preventDefault();
      this.file = event.dataTransfer?.files[0] ?? null;
      if (this.file) this.#try(this.file);
    });
    if (this.character !== character) this.told.replaceChildren();
    this.character = character;
    this.place.replaceChildren(
      made(
        "section",
        { class: "rule-part" },
        made("h3", "Model"),
        made("p", model
          ? `${character} is shown on ${model}${rig ? `, by the rig ${rig}` : ""}.`
          : `${character} has no model. A drawn mouth shows the poses of ${poseset}.`),
        area,
        this.told,
      ),
    );
  }

  /** @param {File} file @param {string | null} [rig] that is chosen for it, "" for none; null to be asked */
  async #try(file, rig = null) {
    const { studio } = this, query = new URLSearchParams({ name: file.name, ...(rig === null ? {} : { rig }) });
    this.told.replaceChildren(made("p", { class: "note" }, `Reading ${file.name}…`));
    await studio.busy(async () => {
      try {
        const told = await studio.api.post(`model?${query}`, file);
        if (told.offer) {
          this.#offerRig(file, told.offer);
          return;
        }
        await studio.edit([
          { file: "character", at: ["model"], value: told.name },
          ...(rig ? [{ file: "character", at: ["rig"], value: rig }] : []),
        ], `Model ${told.name}`);
        const words = `${told.shown} of ${told.channels} channels have a shape in ${told.name}.`;
        this.told.replaceChildren(
          made("p", words),
          ...(told.missing.length
            ? [made("p", { class: "note" }, `Missing: ${told.missing.join(", ")}`), this.#offer(file)]
            : []),
        );
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
        this.told.replaceChildren(made("p", { class: "fault" }, error.message), this.#offer(file));
      }
    }, `Reading ${file.name}`);
  }

  /** @param {File} file @param {{rig: string, shown: number, poses: number}} offer */
  #offerRig(file, { rig, shown, poses }) {
    const use = actButton(`Use ${rig}`, `Use the rig ${rig}`, () => this.#try(file, rig));
    use.classList.add("main");
    this.told.replaceChildren(
      made("p", `The rig ${rig} shows ${shown} of ${poses} poses on ${file.name}; without it, fewer are seen.`),
      made("p", { class: "row" }, use, actButton("Go on without it", "Use no other rig", () => this.#try(file, ""))),
    );
  }

  /** @param {File} file */
  #offer(file) {
    const value = file.name.replace(/\.glb$/i, "").replace(/[^A-Za-z0-9_-]+/g, "-");
    const name = textInput("Name of the character", { value });
    const go = actButton("Draft a character from it", "Find the pose set and the rig that fit this model", () =>
      this.#draft(file, name.value.trim()),
    );
    return made("div", { class: "row" }, made("span", "or, as"), name, go);
  }

  /** @param {File} file @param {string} name */
  async #draft(file, name) {
    const { studio } = this;
    await studio.busy(async () => {
      const told = await studio.api.post(
        `drafted?name=${encodeURIComponent(file.name)}&as=${encodeURIComponent(name)}`,
        file,
      );
      studio.tell([`${told.name} shows ${told.match}`, ...told.doubts].join("\n"));
      studio.project = await studio.api.get("project");
      await studio.open(studio.state.language, told.name);
    }, `Looking for the pose set and the rig that fit ${file.name}`);
  }
}
