/** Files of a line: timings and recordings that are opened or dropped, and timings that are saved. */

import { button, made } from "../shell/elements.js";
import { textInput } from "../shell/form_fields.js";

const SOUNDS = /\.(wav|flac|ogg|oga|opus|mp3|m4a|aac|mp4|mov|webm|wma|aif|aiff)$/i;

/** @param {File} file @returns {boolean} */
function sounds(file) {
  return SOUNDS.test(file.name) || file.type.startsWith("audio/");
}

/**
 * @param {string} text
 * @param {string} accept
 * @param {(files: File[]) => void} does
 * @returns {HTMLElement} a button that asks for a file
 */
export function fileButton(text, accept, does) {
  const input = made("input", { type: "file", accept, multiple: "", hidden: "", "aria-label": text });
  input.addEventListener("change", () => {
    does([...(input.files ?? [])]);
    input.value = "";
  });
  return made("span", button(text, "", () => input.click()), input);
}

/** Opens and saves the files of a line. */
export class LineFiles {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    place.addEventListener("dragover", (event) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      place.classList.add("dropping");
    });
    for (const name of ["dragleave", "drop"]) place.addEventListener(name, () => place.classList.remove("dropping"));
    place.addEventListener("drop", (event) => {
      event.preventDefault();
      this.open([...(event.dataTransfer?.files ?? [])]);
    });
  }

  /** @param {File[]} files timings and their recording, or one of the two */
  async open(files) {
    const timings = files.find((one) => !sounds(one)), recording = files.find(sounds);
    if (timings) {
      const path = `timings?${new URLSearchParams({ name: timings.name })}`;
      await this.studio.openLine(path, timings, `Reading ${timings.name}`);
    }
    if (!recording) return;
    const name = recording.name;
    if (timings) {
      await this.studio.openLine(`sound?${new URLSearchParams({ name })}`, recording);
      return;
    }
    const asked = await this.#asked(name);
    if (!asked) return;
    const words = "text" in asked ? `Finding the phonemes of the text in ${name}` : `Listening to ${name}`;
    await this.studio.openLine(`sound?${new URLSearchParams({ name, ...asked })}`, recording, words);
  }

  /**
   * @param {string} name of a recording
   * @returns {Promise<Record<string, string> | null>} its text, or that it is heard without one; {} if the times of
   *   the line hold for it
   */
  #asked(name) {
    const input = textInput("Words of the recording", { dir: "auto", maxlength: "2000", spellcheck: "true" });
    input.value = this.studio.state.text ?? "";
    const button = (/** @type {string} */ value, /** @type {string} */ text) =>
      made("button", { value, class: value === "find" ? "main" : "" }, text);
    const form = made(
      "form",
      { method: "dialog" },
      made("h2", `Words of ${name}`),
      input,
      made(
        "p",
        { class: "row" },
        button("find", "Find its phonemes"),
        button("hear", "Hear it without words"),
        ...(this.studio.take ? [button("keep", "Keep the times of the line")] : []),
        button("", "Cancel"),
      ),
    );
    const dialog = made("dialog", { class: "recording", "aria-label": "Recording" }, form);
    document.body.append(dialog);
    dialog.showModal();
    return new Promise((done) => dialog.addEventListener("close", () => {
      dialog.remove();
      const { returnValue } = dialog, text = input.value.trim();
      if (returnValue === "find" && !text)
        this.studio.tell("Type the words of the recording to find its phonemes", "fault");
      const choices = /** @type {Record<string, Record<string, string>>} */ ({ hear: { hear: "" }, keep: {} });
      done(returnValue === "find" && text ? { text } : choices[returnValue] ?? null);
    }));
  }

  /** @param {string} suffix json or TextGrid */
  async save(suffix) {
    await this.studio.attempt(async () => {
      const { name, content } = await this.studio.api.get(`timings/${suffix}`);
      const address = URL.createObjectURL(new Blob([content], { type: "text/plain" }));
      made("a", { href: address, download: name }).click();
      URL.revokeObjectURL(address);
      this.studio.tell(`Saved ${name} to your downloads`);
    });
  }
}
