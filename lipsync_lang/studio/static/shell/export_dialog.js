/** The dialog that exports lines: formats to choose, and files to download or to write into the project. */

import { made, the } from "./elements.js";

/** @typedef {{name: string, suffix: string, title: string, refused: string}} FormatRow */
/** @typedef {{name: string, character: string}} LineRow */

/** @param {string} name @param {Uint8Array} content of a file that the browser puts into its downloads */
function download(name, content) {
  const address = URL.createObjectURL(new Blob([/** @type {BlobPart} */ (content)]));
  made("a", { href: address, download: name }).click();
  URL.revokeObjectURL(address);
}

/** Exports the open line, or all lines of its language. */
export class ExportDialog {
  /** @param {import("./studio.js").Studio} studio */
  constructor(studio) {
    this.studio = studio;
    /** Formats that were chosen last. @type {Set<string>} */
    this.chosen = new Set();
    this.dialog = made("dialog", { id: "exporting", "aria-labelledby": "exported" });
    document.body.append(this.dialog);
    the("export").addEventListener("click", () => this.show());
  }

  /** Show the formats. */
  async show() {
    if (this.dialog.open) return;
    await this.studio.attempt(async () => {
      const { formats, lines, folder } = await this.studio.api.get("export");
      this.#fill(formats, lines, folder);
      this.dialog.showModal();
    });
  }

  /** @param {FormatRow[]} formats @param {LineRow[]} lines @param {string} folder */
  #fill(formats, lines, folder) {
    const { state, take } = this.studio, [go, close, told] = [
      made("button", { type: "button", class: "main" }, "Export"),
      made("button", "Close"), made("p", { role: "status" }),
    ];
    const check = (/** @type {string} */ type, /** @type {string} */ name, /** @type {string} */ value,
      /** @type {boolean} */ on, /** @type {boolean} */ off, /** @type {(Node | string)[]} */ ...content) =>
      made("label", { class: "check" },
        made("input", { type, name, value, ...(on ? { checked: "" } : {}), ...(off ? { disabled: "" } : {}) }),
        made("span", ...content));
    const form = made("form", { method: "dialog" },
      made("h2", { id: "exported" }, "Export"),
      made("ul", { "aria-label": "Formats" }, ...formats.map(({ name, suffix, title, refused }) =>
        made("li", check("checkbox", "format", name, this.chosen.has(name), Boolean(refused),
          made("b", name), ` ${suffix} `, made("small", refused || title))))),
      check("radio", "lines", "one", Boolean(take), !take, `This line (${state.name}), into your downloads`),
      check("radio", "lines", "all", !take, !lines.length,
        `All lines in ${state.language} (${lines.length}), into this folder of the project:`),
      made("input", { type: "text", name: "folder", value: folder, "aria-label": "Folder of the project" }),
      check("checkbox", "replace", "yes", false, false, "Replace files that exist"),
      told, made("p", { class: "row" }, go, close));
    go.addEventListener("click", () => this.#run(form, lines, told));
    this.dialog.replaceChildren(form);
  }

  /** @param {HTMLFormElement} form @param {LineRow[]} lines @param {HTMLElement} told */
  async #run(form, lines, told) {
    const stated = new FormData(form), button = /** @type {HTMLButtonElement} */ (form.querySelector(".main"));
    this.chosen = new Set(stated.getAll("format").map(String));
    if (!this.chosen.size) {
      told.textContent = "Choose a format first";
      return;
    }
    button.disabled = true;
    await this.studio.edits.sent;
    /** @type {string[]} */
    const done = [], faults = /** @type {string[]} */ ([]);
    const all = stated.get("lines") === "all", several = new Set(lines.map((one) => one.character)).size > 1;
    const asked = all ? lines : [{ name: this.studio.state.name ?? "", character: "" }];
    for (const [number, { name, character }] of asked.entries()) {
      if (!this.dialog.open) break; // closing it ends the export
      told.textContent = `Writing ${name}: ${number + 1} of ${asked.length}`;
      const folder = `${stated.get("folder")}${several ? `/${character}` : ""}`;
      const where = all ? { line: name, character, folder, replace: stated.has("replace") } : {};
      await this.#export(name, where, done, faults);
    }
    button.disabled = false;
    const count = done.length > 2 ? `${done.length} files: ${done[0]} … ${done.at(-1)}` : done.join(", ");
    told.textContent = [done.length ? `Exported ${count}` : "Nothing was exported", ...faults].join("\n");
  }

  /**
   * @param {string} name of a line
   * @param {object} where its files go; {} into the downloads
   * @param {string[]} done gets its files
   * @param {string[]} faults gets what is to be told about it
   */
  async #export(name, where, done, faults) {
    try {
      const told = await this.studio.api.sent("export", { formats: [...this.chosen], ...where });
      for (const file of told.files ?? []) download(file.name, file.content);
      done.push(...(told.written ?? told.files.map((/** @type {{name: string}} */ file) => file.name)));
      faults.push(...[...told.failed, ...told.remarks].map((one) => `${name}: ${one}`));
    } catch (error) {
      faults.push(`${name}: ${error instanceof Error ? error.message : error}`);
    }
  }
}
