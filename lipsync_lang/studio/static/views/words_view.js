/** The view of words and lines: a character's own curves, pronunciations, and deliveries of lines. */

import { CurveEditor } from "../curves/curve_editor.js";
import { press } from "../curves/curve_hands.js";
import { button, made } from "../shell/elements.js";
import { OwnForms } from "./own_forms.js";
import { curveEdits, spanOf } from "../curves/own_spans.js";
import { tellKeys } from "../shell/studio_keys.js";

/** Milliseconds after a change of the packs, before they are requested again. */
const SETTLE = 120;

tellKeys({
  n: "Words: draw curves for the word at the playhead",
  j: "Words: go to this word in the line, or speak it",
});

/**
 * @typedef {import("../curves/curve_points.js").Curves} Curves
 * @typedef {{word: number | null, phoneme: number | null, curves: Curves}} LineEdit
 * @typedef {{name: string, edits: LineEdit[], styles: Record<string, number[][]>, dials: Record<string, number[][]>}}
 *   Line
 * @typedef {{character: string, file: string, words: {word: string, curves: Curves}[], lineage: string[], lines:
 *   Line[], phonemes: string[],
 *   pronunciations: {language: string, word: string, phonemes: string[]}[], sounds: string[][]}} Told
 */

export class WordsView {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    place.classList.add("words");
    /** @type {Told | null} */
    this.told = null;
    /** The open item: a kind, a name, and for edits of lines a number. @type {string[]} */
    this.open = [];
    /** Curves that the file is known to have, and was last asked to have. @type {Curves} */
    this.known = {};
    this.sending = 0;
    /** @type {Curves | null} */
    this.performed = null;
    this.list = made("nav", { class: "own", "aria-label": "Words and lines of the character" });
    this.desk = made("section", { class: "own-desk", "aria-label": "Open item" });
    this.head = made("div", { class: "row" });
    const curves = made("div", { class: "curves-place" });
    this.place = curves;
    this.empty = made("div", { class: "empty" });
    this.forms = new OwnForms(studio, () => this.#load());
    this.desk.append(this.head, this.forms.place, curves, this.empty);
    place.append(this.list, this.desk);
    this.editor = new CurveEditor(curves, {
      changed: (what, { merge, title }) => what.curves && this.#send(what.curves, title, merge),
      seek: (time) => this.#seek(time),
      tell: (text) => studio.tell(text),
      dragged: (dragging) => studio.dragged(dragging),
    });
  }

  /** @param {string} argument such as `word:hello`, `edit:greeting:0`, `line:greeting` or `said:english:hello` */
  async show(argument) {
    this.open = argument ? argument.split(":").map(decodeURIComponent) : [];
    this.performed = null;
    await this.#load();
  }

  hide() {
    this.open = [];
  }

  /** @param {KeyboardEvent} event @returns {boolean} */
  key(event) {
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    if (plain && event.key === "n") this.#addWord();
    else if (plain && event.key === "j" && this.open.length) this.#find();
    else if (plain && event.key === "Escape" && this.open.length) this.studio.go("words");
    else return Boolean(this.#curves() && this.editor.chosen.size) && press(this.editor, event);
    return true;
  }

  /** @param {import("../shell/studio.js").Change} what */
  changed(what) {
    if (what === "time") this.#time();
    else if (what === "theme") this.editor.draw();
    else {
      clearTimeout(this.later);
      this.later = setTimeout(
        () => !this.sending && !this.editor.held && this.studio.attempt(() => this.#load()),
        SETTLE,
      );
    }
  }

  async #load() {
    this.told = await this.studio.api.get("words");
    this.#list();
    await this.#draw();
  }

  // The list

  #list() {
    const told = /** @type {Told} */ (this.told);
    const head = (
      /** @type {string} */ text,
      /** @type {string} */ adds,
      /** @type {string} */ title,
      /** @type {() => void} */ does,
    ) => {
      return made("h3", made("span", text), button(adds, title, does));
    };
    const note = (/** @type {string} */ text) => made("p", { class: "note" }, text);
    this.list.replaceChildren(
      head("Words", "+ at the playhead", "Curves for the word at the playhead, wherever it is spoken (N)", () =>
        this.#addWord(),
      ),
      ...(told.words.length
        ? [
            made("ul", ...told.words.map(({ word, curves }) =>
              this.#item(["word", word], word, poses(curves), { at: ["words", word] }),
            )),
          ]
        : [note("The character's own curves for a whole word, wherever the word is spoken.")]),
      head("Pronunciations", "+ at the playhead", "Pronunciation of the word at the playhead", () => this.#addSaid()),
      ...(told.pronunciations.length
        ? [
            made("ul", ...told.pronunciations.map(({ language, word, phonemes }) =>
              this.#item(["said", language, word], word, `${language}: ${phonemes.join(" ")}`, {
                at: ["pronunciations", language, word],
              }),
            )),
          ]
        : [note("Words that this character pronounces in its own way.")]),
      head("Lines", "+ new", "Edits and delivery of one line", () => this.#addLine()),
      ...(told.lines.length
        ? [made("ul", ...told.lines.flatMap((line) => this.#lineItems(line)))]
        : [
            note(
              "Edits of single words and sounds of one line, its styles and dials. " +
                "They apply to every recording of the line.",
            ),
          ]),
    );
  }

  /** @param {Line} line @returns {HTMLElement[]} */
  #lineItems(line) {
    const said = this.studio.settings.line === line.name ? "performed now" : "";
    return [
      this.#item(["line", line.name], line.name, said, { at: ["lines", line.name] }),
      ...line.edits.map((edit, n) => {
        const rest = line.edits.filter((_, other) => other !== n).map(stated);
        return this.#item(["edit", line.name, String(n)], this.#named(edit), poses(edit.curves), {
          at: ["lines", line.name, "edits"],
          value: rest,
        });
      }),
    ];
  }

  /**
   * @param {string[]} open what it opens @param {string} text @param {string} about @param {{at: (string | number)[],
   *   value?: any}} drop what deletes it
   * @returns {HTMLElement}
   */
  #item(open, text, about, drop) {
    const link = made(
      "a",
      {
        href: `#words/${encodeURIComponent(open.map(encodeURIComponent).join(":"))}`,
        class: open[0] === "edit" ? "within" : "",
        dir: "auto",
        "aria-current": String(String(open) === String(this.open)),
      },
      text,
      made("small", about),
    );
    const remove = button("×", { "aria-label": `Delete ${text}`, title: "Delete" }, async () => {
      await this.studio.edit([{ file: "character", ...drop }], `Delete ${text}`);
      if (open[0] === "said") await this.#respoken();
      if (open[0] === this.open[0] || open[1] === this.open[1]) this.studio.go("words");
    });
    return made("li", link, remove);
  }

  /** @param {LineEdit} edit @returns {string} what it is for, with the word that the line has there */
  #named({ word, phoneme }) {
    const text = word === null ? "" : this.studio.take?.data.spoken.words[word]?.[0] ?? "";
    const sound = phoneme === null ? "" : `sound ${phoneme + 1}`;
    return word === null
      ? sound || "the whole line"
      : `word ${word + 1}${text ? ` ‘${text}’` : ""}${sound ? `, ${sound}` : ""}`;
  }

  // What is open

  /** @returns {{curves: Curves, at: (string | number)[], title: string} | null} curves that are open */
  #curves() {
    const [kind, name, number] = this.open, told = this.told;
    if (kind === "word") {
      const found = told?.words.find(({ word }) => word === name);
      return found ? { curves: found.curves, at: ["words", name, "curves"], title: name } : null;
    }
    const edit = kind === "edit" ? told?.lines.find((line) => line.name === name)?.edits[Number(number)] : undefined;
    return edit
      ? {
          curves: edit.curves,
          at: ["lines", name, "edits", Number(number), "curves"],
          title: `${this.#named(edit)} of ${name}`,
        }
      : null;
  }

  async #draw() {
    const [kind, name, word] = this.open, told = /** @type {Told} */ (this.told), curves = this.#curves();
    this.place.hidden = !curves;
    const line = kind === "line" ? told.lines.find((one) => one.name === name) : undefined;
    const said =
      kind === "said" ? told.pronunciations.find((one) => one.language === name && one.word === word) : undefined;
    this.forms.show(told, line, said);
    this.empty.hidden = Boolean(curves || line || said);
    if (!this.empty.hidden) this.#welcome();
    const parts = [];
    if (curves)
      parts.push(
        button(
          this.#span() ? "In the line" : kind === "word" ? "Speak it" : "Not in this line",
          "Go to it in the line, or speak it (J)",
          () => this.#find(),
        ),
        button("As performed", "Start from the curves that the character performs without these", () =>
          this.#restart(),
        ),
      );
    if (line)
      parts.push(
        button("+ word at the playhead", "Curves for one word of this line", () => this.#addEdit(line, false)),
        button("+ sound at the playhead", "Curves for one sound of this line", () => this.#addEdit(line, true)),
      );
    const about =
      { word: "wherever it is spoken", edit: "in this line only", line: "delivery of one line", said: "pronunciation" }[
        kind
      ] ?? "";
    this.head.replaceChildren(
      ...(curves || line || said
        ? [
            made(
              "h2",
              { dir: "auto" },
              curves?.title ?? said?.word ?? name,
              made("small", `${about}${told.file ? ` · ${told.file}` : ""}`),
            ),
            ...parts,
          ]
        : []),
    );
    if (!curves) return;
    this.known = curves.curves;
    await this.#ghost();
    this.#show(curves.curves);
  }

  /** @param {Curves} curves */
  #show(curves) {
    const span = this.#span();
    const sounds = span
      ? span.sounds.map(({ seconds, label }) => ({ time: (seconds - span.from) / (span.to - span.from), label }))
      : [];
    this.editor.show({
      poses: this.studio.state.poses,
      curves,
      boundary: 1,
      fixed: true,
      sounds,
      pair: [this.open.slice(1).join(" "), ""],
      ghosts: this.performed ? [{ name: "as performed", kind: "beneath", curves: this.performed }] : [],
    });
    this.#time();
  }

  #welcome() {
    const { take } = this.studio, told = /** @type {Told} */ (this.told);
    const nothing = !told.words.length && !told.pronunciations.length && !told.lines.length;
    this.empty.replaceChildren(
      made("h2", nothing ? `${told.character} has no own words or lines yet` : "Choose a word or a line"),
      made("p", take
        ? "Move the playhead to a word of the line below, and add the word. " +
            "Its curves start as they are performed now."
        : "Speak a line below. Then move the playhead to a word, and add the word."),
    );
  }

  /** @returns {import("../curves/own_spans.js").Span | null} where the line says what is open */
  #span() {
    const { take, player } = this.studio, [kind, name, number] = this.open;
    if (!take || !this.told) return null;
    const edit =
      kind === "edit" ? this.told.lines.find((line) => line.name === name)?.edits[Number(number)] : undefined;
    return spanOf(take, this.told.sounds, edit ?? { text: name }, player.time);
  }

  /** Ask for what the character performs without its own curves. */
  async #ghost() {
    const span = this.#span(), wanted = String(this.open);
    if (this.performed || !span) return;
    try {
      const alone = this.open[0] === "word" ? "&alone=1" : "";
      const { curves } = await this.studio.api.get(`words/start?${span.query}${alone}`);
      if (String(this.open) === wanted) this.performed = curves;
    } catch { this.performed = null; }
  }

  async #restart() {
    this.performed = null;
    await this.#ghost();
    if (this.performed) await this.#send(this.performed, "Start as performed", "");
    else this.studio.tell("The line does not have it. Speak a line that does.");
  }

  // Edits

  /** @param {Curves} curves @param {string} title @param {string} merge */
  async #send(curves, title, merge) {
    const open = this.#curves();
    if (!open) return;
    const edits = curveEdits(open.at, this.known, curves);
    if (!edits.length) return;
    this.sending++;
    await this.studio.edit(edits, `${title} of ${open.title}`, merge && `${merge} ${this.studio.tab}`);
    this.sending--;
    if (!this.sending && !this.editor.held) await this.studio.attempt(() => this.#load());
  }

  /**
   * @returns {{number: number, text: string, first: number, stop: number} | null} the word at the playhead, or the
   *   first after it
   */
  #here() {
    const { take, player } = this.studio, { words = [], times = [] } = take?.data.spoken ?? {};
    const number = words.findIndex(([, , stop]) => times[stop] > player.time);
    if (number < 0) {
      this.studio.tell(
        take
          ? "There is no word at the playhead. Move the playhead to a word."
          : "Speak a line first. Then move the playhead to a word.",
      );
      return null;
    }
    const [text, first, stop] = words[number];
    return { number, text, first, stop };
  }

  async #addWord() {
    const here = this.#here();
    if (!here || !this.told) return;
    const word = here.text.toLocaleLowerCase(),
      known = this.told.words.find((one) => one.word.toLocaleLowerCase() === word);
    if (!known) {
      await this.studio.attempt(async () => {
        const { curves } = await this.studio.api.get(`words/start?word=${here.number}&alone=1`);
        await this.studio.edit([{ file: "character", at: ["words", word], value: { curves } }], `Curves of ${word}`);
      });
    }
    this.#go("word", known?.word ?? word);
  }

  async #addSaid() {
    const here = this.#here(), told = this.told;
    if (!here || !told) return;
    const [language] = told.lineage,
      word = here.text.toLocaleLowerCase(),
      known = told.pronunciations.some((one) => one.language === language && one.word === word);
    const sounds = told.sounds.slice(here.first, here.stop).flat();
    if (!known && sounds.length)
      await this.studio.edit(
        [{ file: "character", at: ["pronunciations", language, word], value: sounds }],
        `Pronunciation of ${word}`,
      );
    this.#go("said", language, word);
  }

  async #addLine() {
    const { line, name, text } = this.studio.state;
    if (!line) this.studio.tell("Speak a line first");
    else if (!this.told?.lines.some((one) => one.name === name))
      await this.studio.edit([{ file: "character", at: ["lines", name], value: { text, edits: [] } }], `Line ${name}`);
    if (line) this.#go("line", name);
  }

  /** @param {Line} line @param {boolean} sound the sound at the playhead, or its word */
  async #addEdit(line, sound) {
    const here = this.#here(), { take, player, api } = this.studio;
    if (!here || !take || !this.told) return;
    const { times } = take.data.spoken;
    const spoken = this.told.sounds.flatMap((said, n) => (said.length && n >= here.first && n < here.stop ? [n] : []));
    const at = Math.max(0, spoken.findIndex((n) => times[n + 1] > player.time));
    await this.studio.attempt(async () => {
      const { curves } = await api.get(`words/start?word=${here.number}${sound ? `&phoneme=${at}` : ""}`);
      const edit = { word: here.number, ...(sound ? { phoneme: at } : {}), curves };
      await this.studio.edit(
        [{ file: "character", at: ["lines", line.name, "edits"], value: [...line.edits.map(stated), edit] }],
        `Edit of ${line.name}`,
      );
      if (this.studio.settings.line !== line.name)
        await this.studio.perform("take", { settings: { ...this.studio.settings, line: line.name } });
      this.#go("edit", line.name, String(line.edits.length));
    });
  }

  /** Speak the line again: pronunciations matter when a text is read. */
  async #respoken() {
    if (this.studio.state.text) await this.studio.speak(this.studio.state.text);
  }

  /** @param {...string} open */
  #go(...open) {
    this.studio.go("words", open.map(encodeURIComponent).join(":"));
  }

  // Time

  async #find() {
    const span = this.#span(), [kind, name, word] = this.open;
    if (span) this.studio.reveal(span.from);
    else if (kind === "word" || kind === "said") await this.studio.speak(kind === "word" ? name : word);
    else this.studio.tell("The line does not have this word. Speak the line that these edits belong to.");
  }

  /** @param {number} time within the curves */
  #seek(time) {
    const span = this.#span();
    if (span) this.studio.reveal(span.from + time * (span.to - span.from));
  }

  #time() {
    const span = this.#curves() && this.#span(), seconds = this.studio.player.time;
    this.editor.setTime(
      span && seconds >= span.from && seconds <= span.to ? (seconds - span.from) / (span.to - span.from) : null,
    );
  }
}

/** @param {LineEdit} edit @returns {Record<string, any>} as a pack states it */
function stated({ word, phoneme, curves }) {
  return { ...(word === null ? {} : { word }), ...(phoneme === null ? {} : { phoneme }), curves };
}

/** @param {Curves} curves @returns {string} */
function poses(curves) {
  const names = Object.keys(curves);
  return names.length > 2 ? `${names.length} poses` : names.join(", ");
}
