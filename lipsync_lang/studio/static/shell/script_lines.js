/** Lines of the project's script: the line before and after, and a list to search. */

import { button, made, the } from "./elements.js";

/** @typedef {import("../payloads.js").ScriptLine} ScriptLine @typedef {import("../payloads.js").ScriptPlace} Place */

/** Milliseconds without a letter, after which lines are searched. */
const SEARCH_LATER = 150;

/** The lines of the script in the dock, and their list. */
export class ScriptLines {
  /** @param {import("./studio.js").Studio} studio */
  constructor(studio) {
    this.studio = studio;
    /** @type {Place | null} */
    this.place = null;
    /** Name of the line that was open last. */
    this.name = "";
    this.count = 0;
    this.answers = 0;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.later = undefined;
    this.search = made("input", {
      type: "search",
      dir: "auto",
      "aria-label": "Search the lines",
      placeholder: "Search names, speakers and texts",
    });
    this.told = made("p", { role: "status" });
    this.rows = made("ol");
    this.dialog = made(
      "dialog",
      { id: "script-list", "aria-labelledby": "script-lines" },
      made("h2", { id: "script-lines" }, "Lines of the script"),
      this.search,
      this.told,
      this.rows,
      made("form", { method: "dialog" }, made("button", "Close")),
    );
    document.body.append(this.dialog);
    this.search.addEventListener("input", () => {
      clearTimeout(this.later);
      this.later = setTimeout(() => this.#list(), SEARCH_LATER);
    });
    the("line-before").addEventListener("click", () => this.go(-1));
    the("line-after").addEventListener("click", () => this.go(1));
    the("all-lines").addEventListener("click", () => this.choose());
  }

  /** Open the line of the script that was open before, or the first; without a script, a line that is kept. */
  async start() {
    await this.studio.busy(async () => {
      const { lines, count } = await this.studio.api.get("script");
      this.count = count;
      this.#shown();
      const { line, kept = [] } = this.studio.state;
      if (!line && !count && kept.length) await this.studio.speak(kept[0]);
      if (line || !count) return;
      const named = this.name && await this.#asked(this.name);
      await this.#open(
        (named && named.lines.find((/** @type {ScriptLine} */ one) => one.name === this.name)) || lines[0],
      );
    });
  }

  /** @param {Place | null} place of the line that is open now */
  opened(place) {
    this.place = place;
    the("kept").replaceChildren(...(this.studio.state.kept ?? []).map((value) => made("option", { value })));
    if (place) [this.name, this.count] = [place.name, place.count];
    this.#shown();
  }

  #shown() {
    const { place, count } = this, button = (/** @type {string} */ id) => /** @type {HTMLButtonElement} */ (the(id));
    the("script").hidden = !count;
    button("line-before").disabled = Boolean(place && !place.beside[0]);
    button("line-after").disabled = Boolean(place && !place.beside[1]);
    button("all-lines").textContent = place ? `${place.name} · ${place.number} of ${place.count}` : `Lines (${count})`;
  }

  /** @param {-1 | 1} way the line before or after; without an open line, the last one or its list */
  go(way) {
    const next = this.place?.beside[way < 0 ? 0 : 1];
    if (next) this.studio.busy(() => this.#open(next));
    else if (!this.place && this.count) this.choose();
  }

  /** Show the list. */
  choose() {
    if (!this.count) return;
    this.dialog.showModal();
    this.search.value = "";
    this.search.focus();
    this.#list();
  }

  /** @param {string} sought @param {number} [first] @returns {Promise<any>} */
  #asked(sought, first = 0) {
    return this.studio.api.get(`script?${new URLSearchParams({ sought, first: String(first) })}`);
  }

  /** @param {number} [first] number of the first line to add to those that are listed */
  async #list(first = 0) {
    const answer = ++this.answers, sought = this.search.value;
    await this.studio.attempt(async () => {
      const { lines, found, several } = await this.#asked(sought, first);
      if (answer !== this.answers) return;
      const rows = lines.map((/** @type {ScriptLine} */ one) => this.#row(one, several));
      if (first) this.rows.append(...rows); // the button that had the focus goes
      else this.rows.replaceChildren(...rows);
      if (first) rows[0]?.querySelector("button")?.focus();
      const shown = this.rows.children.length;
      this.told.replaceChildren(
        found === shown
          ? `${found} of ${this.count} lines`
          : `${found} of ${this.count} lines; the first ${shown} are listed. `,
      );
      if (found === shown) return;
      this.told.append(button("Show more", "", () => this.#list(shown)));
    });
  }

  /** @param {ScriptLine} line @param {boolean} several characters are in the script */
  #row(line, several) {
    const told = [
      line.speaker,
      several ? line.character : "",
      line.recording ? "recording" : "",
      line.timings ? "timings" : "",
    ];
    const parts = [
      made("b", line.name),
      made("small", told.filter(Boolean).join(" · ")),
      made("span", { dir: "auto" }, line.text),
    ];
    return made("li", button(
      parts,
      line.name === this.place?.name ? { "aria-current": "true" } : {},
      () => {
        this.dialog.close();
        this.studio.busy(() => this.#open(line));
      },
    ));
  }

  /** @param {ScriptLine} line */
  async #open(line) {
    const { studio } = this,
      open = () => studio.state.language === line.language && studio.state.character === line.character;
    the("all-lines").textContent = `${line.name} …`;
    try {
      if (!open()) await studio.open(line.language, line.character, false);
      if (open()) await studio.openLine("script", { name: line.name }, `Opening ${line.name}`);
    } finally {
      this.#shown();
    }
  }
}
