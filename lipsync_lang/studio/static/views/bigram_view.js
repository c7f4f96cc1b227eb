/** The view of bigrams: the matrix of all, and one on the editor of curves with its status and notes. */

import { BigramMatrix } from "./bigram_matrix.js";
import { beside, editsOf, occurrences, spoken } from "./bigram_state.js";
import { CurveEditor } from "../curves/curve_editor.js";
import { press } from "../curves/curve_hands.js";
import { button, made } from "../shell/elements.js";
import { selectInput, textInput } from "../shell/form_fields.js";
import { tellKeys } from "../shell/studio_keys.js";

/** Milliseconds after a change of the packs, before they are requested again. */
const SETTLE = 120;
const STATUSES = ["drafted", "edited", "approved"];
/** Statuses that no person gave: a change makes the bigram an edited one. */
const UNDRAWN = ["drafted", "fitted"];

tellKeys({
  "n": "Bigrams: open the next bigram that is needed",
  "w": "Bigrams: show all of them (also Esc)",
  "j": "Bigrams: go to this bigram in the line, or speak its word",
  "1 2 3": "Bigrams: mark as drafted, edited or approved",
  "← → ↑ ↓": "Curves: move the chosen points by 0.01, with Shift 0.05, with Alt 0.001",
  "Tab, [ ]": "Curves: choose the next point, or the previous or next pose",
  "a, Delete": "Curves: add a point, or delete the chosen points",
  "Ctrl A, C, V": "Curves: choose all points of the pose (with Shift, of all poses), copy, or paste",
  "g, h, s": "Curves: snap to 0.05, hide the pose, or show it alone",
});

/** @typedef {import("./bigram_state.js").BigramState} BigramState */

export class BigramView {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.pair = "";
    /** The server's answer about the bigram. @type {any} */
    this.told = null;
    /** @type {BigramState} */
    this.now = { curves: {}, boundary: 0.5, interpolation: "", contact: "hold", status: "edited", word: "", why: "" };
    /**
     * The known content of the file, and the content that was last requested.
     * @type {[BigramState | null, BigramState | null]}
     */
    this.known = [null, null];
    /** The word of the line that has the bigram, for a new drawing of a bigram. */
    this.said = "";
    /** The line as it was when the bigram was opened. @type {import("../line/take.js").Take | null} */
    this.takeBefore = null;
    /** The bigram, the line and the pose that the strip shows. @type {unknown[]} */
    this.inStrip = [];
    this.sending = 0;
    this.revision = -1;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.later = undefined;
    /** @type {import("./bigram_matrix.js").Matrix | null} */
    this.matrixData = null;
    this.head = made("div", { class: "bigram-head" });
    this.title = made("h2");
    this.target = textInput("Bigram to go to", { class: "go", placeholder: "Go to l-ow" });
    this.status = made("span", { class: "group status", role: "group", "aria-label": "Status" });
    this.word = this.#input("Word", "word");
    this.why = this.#input("Note", "why");
    this.kind = this.#select(
      "Kind of curve",
      [
        ["", "Curve: as in the bank"],
        ["bspline", "Curve: smooth"],
        ["linear", "Curve: straight"],
      ],
      "interpolation",
    );
    this.contact = this.#select("Contacts", [["hold", "Contacts held"], ["free", "Contacts free"]], "contact");
    /** Target of edits: the bank, or the character alone. */
    this.into = selectInput("Edits are for", [["bank", "For every face"], ["character", "For this character"]]);
    this.into.addEventListener("change", () => this.#base());
    /** The style whose bank is drawn; empty for neutral. */
    this.manner = made("select", { "aria-label": "Style of the bank" });
    this.manner.addEventListener("change", () => {
      this.told = null;
      studio.attempt(() => this.#load());
    });
    this.origin = made("p", { class: "origin" });
    const board = made("div"), desk = made("div", { class: "bigram-view" }, this.head), curves = made("div");
    desk.append(curves);
    this.board = board;
    this.desk = desk;
    place.append(board, desk);
    place.classList.add("bigrams");
    this.matrix = new BigramMatrix(board, { open: (pair) => studio.go("bigrams", pair) });
    this.#makeHead();
    this.editor = new CurveEditor(curves, {
      changed: (what, { merge, title }) => {
        this.now = {
          ...this.now,
          ...what,
          status: what.curves || UNDRAWN.includes(this.now.status) ? "edited" : this.now.status,
        };
        this.#send(`${title} in ${this.pair}`, merge);
      },
      seek: (time) => this.#seek(time),
      tell: (text) => studio.tell(text),
      dragged: (dragging) => studio.dragged(dragging),
    });
  }

  // Parts

  /** @param {string} label @param {"word" | "why"} field @returns {HTMLInputElement} */
  #input(label, field) {
    const one = textInput(label, { dir: "auto", maxlength: "300", spellcheck: "true" });
    one.addEventListener("change", () => this.#set({ [field]: one.value.trim() }, `${label} of ${this.pair}`));
    return one;
  }

  /**
   * @param {string} label
   * @param {string[][]} options
   * @param {"interpolation" | "contact"} field
   * @returns {HTMLSelectElement}
   */
  #select(label, options, field) {
    const one = selectInput(label, options);
    one.addEventListener("change", () => this.#set({ [field]: one.value }, `${label} of ${this.pair}`));
    return one;
  }

  #makeHead() {
    const { studio } = this;
    this.target.addEventListener(
      "change",
      () => this.target.value.trim() && studio.go("bigrams", this.target.value.trim()),
    );
    this.status.append(...STATUSES.map((status, n) => {
      const one = button(status, `Mark as ${status} (${n + 1})`, () =>
        this.#set({ status }, `Mark ${this.pair} as ${status}`),
      );
      one.setAttribute("data-status", status);
      return one;
    }));
    this.head.append(
      made(
        "div",
        { class: "row" },
        this.title,
        this.status,
        button("In the line", "Go to this bigram in the line, or speak its word (J)", () => this.#find()),
        button("Next needed", "Open the next bigram that is needed and not drawn (N)", () => this.next()),
        button("All bigrams", "Show the matrix of all bigrams (W)", () => studio.go("bigrams")),
        this.target,
        this.origin,
      ),
      made(
        "div",
        { class: "row" },
        made("label", { class: "word" }, "Word", this.word),
        made("label", { class: "why" }, "Note", this.why),
        this.kind,
        this.contact,
        this.manner,
        this.into,
      ),
    );
  }

  // The view

  /** @param {string} argument a bigram, or nothing for the matrix */
  async show(argument) {
    if (argument !== this.pair) this.told = null;
    this.pair = argument;
    this.desk.hidden = !argument;
    this.board.hidden = Boolean(argument);
    if (!argument) return this.#loadMatrix(true);
    await this.#load();
    const { take, player } = this.studio, here = take?.bigramsAt(take.frameAt(player.time)) ?? [];
    if (!player.playing && !here.some((one) => one.pair === argument)) this.#seek(this.now.boundary);
  }

  hide() {
    this.pair = "";
  }

  async #loadMatrix(focus = false) {
    /** @type {import("./bigram_matrix.js").Matrix} */
    const matrix = await this.studio.api.get("matrix");
    this.matrixData = matrix;
    this.matrix.show(matrix);
    if (focus && document.activeElement === document.body) this.matrix.focus();
  }

  /** Ask for the bigram, with those that the line says before and after it. */
  async #load() {
    const { pair, studio } = this, found = studio.take && spoken(studio.take, pair, studio.player.time);
    this.#listStyles();
    const style = this.manner.value;
    const query = new URLSearchParams({ style, ...(found ? { before: found.before, after: found.after } : {}) });
    let told;
    try {
      told = await studio.api.get(`bigram/${encodeURIComponent(pair)}?${query}`);
    } catch (error) {
      if (this.pair === pair && !this.told) studio.go("bigrams");
      throw error;
    }
    if (this.pair !== pair || this.manner.value !== style || this.sending) return;
    this.revision = studio.state.revision;
    this.told = told;
    this.said = found?.word ?? "";
    const { curves, boundary, interpolation, contact, status, word, why } = told;
    this.now = { curves, boundary, interpolation, contact, status, word, why };
    this.into.hidden = Boolean(style) || !told.character || told.character === told.file;
    this.into.value = "bank";
    this.#base();
    this.#draw();
  }

  /** List neutral and the styles of the face; a style that is gone gives way to neutral. */
  #listStyles() {
    const chosen = this.manner.value, { styles } = this.studio.state;
    this.manner.replaceChildren(
      ...["", ...styles].map((style) => made("option", { value: style }, `Style: ${style || "neutral"}`)),
    );
    this.manner.value = styles.includes(chosen) ? chosen : "";
    this.manner.hidden = !styles.length;
  }

  /** Take what the file of the edits says of the bigram: all, or nothing. */
  #base() {
    const here = this.told.stated && this.into.value === "bank";
    if (!here && !this.now.interpolation && this.told.kind !== this.#kind()) this.now.interpolation = this.told.kind;
    this.known = here ? [this.now, this.now] : [null, null];
  }

  /** The kind of curve of a bigram that names none, where edits go. @returns {string} */
  #kind() {
    return this.into.value === "character" ? "bspline" : this.told.bank_kind;
  }

  #draw() {
    const { told, now, pair } = this;
    const [first, second] = pair.split("-");
    this.title.textContent = `${first} → ${second}`;
    for (const one of this.status.children)
      one.setAttribute("aria-pressed", String(one.getAttribute("data-status") === now.status));
    [this.word.value, this.why.value, this.kind.value, this.contact.value, this.target.value] = [
      now.word,
      now.why,
      now.interpolation,
      now.contact,
      "",
    ];
    const drawn = told.drawn_as ? `, drawn as ${told.drawn_as}` : "";
    const from = told.place ? `${told.layer}: ${told.place}${drawn}` : told.layer,
      fitted = now.status === "fitted" ? ", fitted to captures" : "";
    this.origin.textContent = told.locked
      ? `${from}${fitted}; ${told.locked}`
      : told.stated
        ? `${told.place}${fitted}`
        : `${from}${fitted}; edits go into ${told.file}`;
    const ghosts = [...told.ghosts, ...["before", "after"].flatMap((side) => {
      const one = told[side];
      return one
        ? [
            {
              name: one.pair,
              kind: "neighbour",
              curves: beside(one.curves, one.boundary, now.boundary, /** @type {"before" | "after"} */ (side)),
            },
          ]
        : [];
    })];
    this.editor.show({
      poses: this.studio.state.poses,
      curves: now.curves,
      boundary: now.boundary,
      pair: [first, second],
      ghosts,
      interpolation: now.interpolation || this.#kind(),
    });
    this.#time();
  }

  // Edits

  /** @param {Partial<BigramState>} what @param {string} title */
  #set(what, title) {
    this.now = { ...this.now, ...what };
    this.#send(title, "");
    this.#draw();
  }

  /**
   * Send what differs from what the file says, or may say once the last edit is done.
   * @param {string} title
   * @param {string} merge
   */
  async #send(title, merge) {
    const { pair, now, studio } = this, [base, sent] = this.known, style = this.manner.value;
    const file = style ? `bank:${style}` : this.into.value;
    if (!base && !now.word) now.word = this.said;
    const edits = editsOf(file, pair, base, now);
    if (base && sent) {
      const places = new Set(edits.map((one) => JSON.stringify(one.at)));
      edits.push(...editsOf(file, pair, sent, now).filter((one) => !places.has(JSON.stringify(one.at))));
    }
    if (!edits.length) return;
    this.known = [base, now];
    this.sending++;
    await studio.edit(edits, title, merge && `${merge} ${studio.tab}`);
    this.sending--;
    if (this.pair !== pair) return;
    this.revision = studio.state.revision;
    if (this.sending) return;
    if (studio.state.undo === title && file.startsWith("bank")) {
      this.known = [now, now];
      Object.assign(this.told, { stated: true, place: this.told.file });
      this.#draw();
    } else await studio.attempt(() => this.#load());
  }

  // Moves

  /** Go to the next bigram that the script needs and nobody drew. */
  async next() {
    await this.studio.attempt(() => this.#loadMatrix());
    const wanted = this.matrixData?.wanted ?? [],
      at = wanted.findIndex((one) => one.pair === this.pair);
    const next = wanted[at + 1] ?? wanted[0];
    if (next && next.pair !== this.pair) this.studio.go("bigrams", next.pair);
    else this.studio.tell("Nothing is left to draw: every bigram of the line and the script is drawn.");
  }

  /** Go to the bigram in the line, or speak its word. */
  async #find() {
    const { studio, pair } = this, found = studio.take && spoken(studio.take, pair, studio.player.time);
    if (found) studio.reveal(found.seconds);
    else if (this.now.word) await studio.speak(this.now.word);
    else studio.tell(`The line does not have ${pair}. Enter a word for it, and the studio can speak it.`);
  }

  /** @param {number} time within the bigram */
  #seek(time) {
    const { studio, pair } = this, found = studio.take && spoken(studio.take, pair, studio.player.time, time);
    if (found) studio.reveal(found.seconds);
  }

  /** The curve of the pose in front before and after the edits, at each place of the bigram. */
  strip() {
    const { take, player } = this.studio, { focus } = this.editor;
    const [pair, line] = this.inStrip;
    if (pair !== this.pair || line !== player) this.takeBefore = take;
    this.inStrip = [this.pair, player, focus];
    if (!take || !this.pair) return {};
    const rows = take.rows.has(focus) ? [focus] : [];
    return { rows, other: this.takeBefore === take ? null : this.takeBefore, marked: occurrences(take, this.pair) };
  }

  #time() {
    const { take, player } = this.studio;
    if (this.editor.focus !== this.inStrip[2]) {
      this.studio.drawStrip();
      this.studio.wake();
    }
    const here = take?.bigramsAt(take.frameAt(player.time)).find((one) => one.pair === this.pair);
    this.editor.setTime(here ? here.position : null);
  }

  /** @param {KeyboardEvent} event @returns {boolean} */
  key(event) {
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    /** @type {Record<string, () => void>} */
    const does = !plain
      ? {}
      : {
          n: () => this.next(),
          ...(this.pair && {
            w: () => this.studio.go("bigrams"),
            j: () => this.#find(),
            Escape: () => this.studio.go("bigrams"),
            ...Object.fromEntries(
              STATUSES.map((status, n) => [
                String(n + 1),
                () => this.#set({ status }, `Mark ${this.pair} as ${status}`),
              ]),
            ),
          }),
        };
    if (does[event.key]) does[event.key]();
    else return Boolean(this.pair && this.editor.chosen.size) && press(this.editor, event);
    return true;
  }

  /** @param {import("../shell/studio.js").Change} what */
  changed(what) {
    if (what === "time") {
      if (this.pair && this.told) this.#time();
    } else if (what === "theme") this.editor.draw();
    else {
      clearTimeout(this.later);
      this.later = setTimeout(() => this.studio.attempt(async () => {
        if (!this.pair) await (this.board.isConnected ? this.#loadMatrix() : undefined);
        else if (!this.sending && !this.editor.held && this.revision !== this.studio.state.revision) await this.#load();
      }), SETTLE);
    }
  }
}
