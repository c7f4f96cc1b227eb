/**
 * Edits of the studio, and its buttons Undo, Redo and Save.
 *
 * Edits are sent one after the other. Where a file changed as well, the user settles the conflict.
 */

import { Refusal } from "./api.js";
import { settled } from "./conflict_dialog.js";
import { the } from "./elements.js";

/** @typedef {import("./studio.js").Edit} Edit @typedef {import("../payloads.js").Fault} Fault */

/** The edits of a studio on their way to its server. */
export class Edits {
  /** @param {import("./studio.js").Studio} studio */
  constructor(studio) {
    this.studio = studio;
    /**
     * Edits that wait for the one in flight.
     * @type {{edits: Edit[], title: string, merge: string, done: (() => void)[]}[]}
     */
    this.waiting = [];
    this.sending = false;
    /** Ends when no edit waits; undo and saving come after the edits before them. @type {Promise<void>} */
    this.sent = Promise.resolve();
    the("undo").addEventListener("click", () => this.history("undo"));
    the("redo").addEventListener("click", () => this.history("redo"));
    the("save").addEventListener("click", () => this.save());
  }

  /** Show which steps can be undone, and what is unsaved. */
  show() {
    const { state } = this.studio, { unsaved = [] } = state;
    const button = (/** @type {string} */ id) => /** @type {HTMLButtonElement} */ (the(id));
    for (const way of /** @type {const} */ (["undo", "redo"])) {
      const title = state[way], name = way === "undo" ? "Undo" : "Redo";
      button(way).disabled = !title;
      button(way).title = title ? `${name}: ${title}` : `Nothing to ${way}`;
    }
    button("save").disabled = !unsaved.length;
    button("save").textContent = unsaved.length ? `Save ${unsaved.length}` : "Saved";
    button("save").title = unsaved.map((one) => `${one.file}: ${one.what}`).join("\n");
    document.title = `${unsaved.length ? "● " : ""}${state.language} on ${state.character} · studio`;
  }

  /**
   * Change packs; resolves when the curves are new. The newest edits of one drag win.
   * @param {Edit[]} edits
   * @param {string} title of the step in undo
   * @param {string} [merge] edits with one key are one step
   * @returns {Promise<void>}
   */
  make(edits, title, merge = "") {
    return new Promise((done) => {
      const last = this.waiting.at(-1);
      if (last && merge && last.merge === merge) {
        const places = new Set(edits.map((one) => JSON.stringify([one.file, one.at])));
        last.edits = [...last.edits.filter((one) => !places.has(JSON.stringify([one.file, one.at]))), ...edits];
        last.done.push(done);
      } else this.waiting.push({ edits, title, merge, done: [done] });
      if (!this.sending) this.sent = this.#send();
    });
  }

  async #send() {
    this.sending = true;
    for (let next = this.waiting.shift(); next; next = this.waiting.shift()) {
      const { edits, title, merge, done } = next;
      try {
        this.studio.stated(
          await this.studio.api.post("edit", {
            edits,
            title,
            merge,
            seen: this.studio.state.revision,
            tab: this.studio.tab,
          }),
        );
        await this.studio.perform();
      } catch (error) {
        this.#refused(error);
      }
      done.forEach((one) => one());
    }
    this.sending = false;
  }

  /** @param {unknown} error of an edit: the state is requested again, so that views show the truth */
  async #refused(error) {
    const faults = error instanceof Refusal ? error.told.faults ?? [] : [];
    const told = faults.map((/** @type {Fault} */ one) => `${one.what}${one.hint ? `: ${one.hint}` : ""}`);
    this.studio.tell(
      told.length ? told.slice(0, 3).join("\n") : String(error instanceof Error ? error.message : error),
      "fault",
    );
    await this.studio.look();
  }

  /**
   * Undo a step, or do it again.
   * @param {"undo" | "redo"} way
   */
  async history(way) {
    await this.sent;
    while (this.studio.performing) await new Promise(requestAnimationFrame); // a change of the line is on its way
    await this.studio.attempt(async () => {
      const title = this.studio.state[way];
      if (!title) return;
      this.studio.stated(await this.studio.api.post(way, { tab: this.studio.tab }));
      this.studio.tell(`${way === "undo" ? "Undone" : "Redone"}: ${title}`);
      await this.studio.perform();
    });
  }

  /** @param {Record<string, string>} [keep] the side to keep of each entry that was changed on the disk as well */
  async save(keep) {
    await this.sent;
    while (this.studio.performing) await new Promise(requestAnimationFrame);
    try {
      const told = await this.studio.api.post("save", { keep });
      this.studio.stated(told.state);
      this.studio.tell(told.saved.length ? `Saved ${told.saved.join(", ")}` : "Nothing to save");
      if (keep) await this.studio.perform();
    } catch (error) {
      const conflict = error instanceof Refusal && error.told.conflict;
      if (!conflict) await this.#refused(error);
      else {
        const sides = await settled(conflict);
        if (sides) await this.save(sides);
      }
    }
  }
}
