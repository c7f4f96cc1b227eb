/** The language view: a pack's table of sounds to mouths, a word to try, and the pack's tests. */

import { button, made } from "../shell/elements.js";
import { fillNames, selectInput, textInput } from "../shell/form_fields.js";
import { SoundEditor } from "./sound_editor.js";
import { tellKeys } from "../shell/studio_keys.js";

/** Milliseconds without a key, after which a typed word is transcribed. */
const TYPED = 180;
/** Milliseconds for which each part of a sound that moves is held. */
const HELD = 500;
/** Rows drawn at first; the rest follow on demand. */
const MOST = 400;

/** Needs of rows, with the headings of their parts of the table. */
const NEEDS = {
  unmapped: "Unmapped: these have no mouth yet",
  doubtful: "Doubtful: the features of the sound disagree, and no reason is given",
  automatic: "Mapped by features alone: nobody has checked these",
  loses: "Much is not shown: the nearest mouth differs",
  "": "Settled",
};
const FILTERS = [
  ["", "All sounds"],
  ["look", "Needs review"],
  ["own", "Stated in this file"],
  ["several", "Several mouths"],
  ["mute", "Mute"],
];

tellKeys({
  "↑ ↓": "Language: choose the sound above or below",
  "Enter": "Language: edit the sound; press Esc when done",
  "v, t": "Language: hear the sound in a word, or show its mouth",
});

/**
 * @typedef {import("../payloads.js").Transcript} Transcript
 * @typedef {import("../payloads.js").TranscribedWord} TranscribedWord
 * @typedef {{notation: string, label: string, to: string[], shares: number[], reason: string, own: boolean,
 *   own_reason: boolean,
 *   why: string, need: keyof NEEDS, says: string, losses: string[], distance: number, words: string[], automatic:
 *   string[]}} Sound
 * @typedef {{name: string, title: string, ipa: string[], example: string, like: string, reason: string}} CommonPhoneme
 */

export class LanguageView {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.place = place;
    place.classList.add("language");
    /** The table of the server. @type {any} */
    this.told = null;
    this.asked = "";
    /** Row that is edited, as `key` names it. */
    this.open = "";
    this.standing = "";
    this.title = made("h2", "Language");
    this.search = textInput("Search the table", { type: "search", placeholder: "Sound, mouth, word…" });
    this.notation = made("select", { "aria-label": "Notation" });
    this.filter = selectInput("Rows to show", FILTERS);
    this.word = textInput("Word to try", { placeholder: "Try a word", dir: "auto", maxlength: "300" });
    this.tried = made("div", { class: "tried", role: "status", "aria-label": "Transcription" });
    this.caveats = made("details");
    this.list = made("div", { class: "sounds", role: "region", "aria-label": "Sounds" });
    this.tests = made("aside", { class: "tests", "aria-label": "Tests of the pack" });
    const speak = made("button", { type: "button" }, "Speak it"),
      keep = button("Keep as a test", "Add the word with this transcription to the pack's tests", () => this.#keep());
    place.append(made("header",
      made("div", { class: "row" }, this.title, this.search, this.notation, this.filter),
      made("div", { class: "row" }, this.word, speak, keep, this.tried),
      this.#beginner(), this.caveats), this.list, this.tests);
    this.editor = new SoundEditor({
      edit: (edits, title) => studio.edit(edits, title),
      close: () => this.#edit(""),
    });
    for (const one of [this.search, this.notation, this.filter]) one.addEventListener("input", () => this.#list());
    this.word.addEventListener("input", () => this.#typed());
    this.word.addEventListener(
      "keydown",
      (event) => event.key === "Enter" && this.word.value.trim() && studio.speak(this.word.value.trim()),
    );
    speak.addEventListener("click", () => this.word.value.trim() && studio.speak(this.word.value.trim()));
    /** Phonemes of the word. @type {Transcript | null} */
    this.transcript = null;
    this.list.addEventListener("focusin", (event) => { this.standing = keyOf(event.target) ?? this.standing; });
  }

  /** @param {string} argument a label to look for */
  async show(argument) {
    if (argument) this.search.value = argument;
    await this.#load();
  }

  hide() {
    this.studio.pose(null);
  }

  /** @param {KeyboardEvent} event @returns {boolean} */
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const rows = /** @type {HTMLElement[]} */ ([...this.list.querySelectorAll("li[data-row]")]);
    const at = rows.findIndex((one) => one.dataset.row === this.standing),
      here = this.#rows().find((one) => key(one) === this.standing);
    const inList = this.list.contains(document.activeElement);
    if (event.key === "Escape" && this.open) this.#edit("");
    else if (event.key === "v" && here) this.hear(here);
    else if (event.key === "t" && here) this.pose(here);
    else if ((event.key === "ArrowUp" || event.key === "ArrowDown") && (inList || at < 0)) {
      const next = rows[Math.min(rows.length - 1, Math.max(0, at + (event.key === "ArrowUp" ? -1 : 1)))];
      /** @type {HTMLElement | null} */ (next?.querySelector("button"))?.focus();
    } else return false;
    return true;
  }

  /** @param {import("../shell/studio.js").Change} what */
  changed(what) {
    if (what === "state" || what === "take") this.#load();
  }

  /** @returns {HTMLElement} a form that begins a language of the project */
  #beginner() {
    const name = textInput("Name", { placeholder: "Name", size: "12", required: "" });
    const title = "Such as sw or pt-BR; if empty, that of the other language";
    const tag = textInput("Code", { placeholder: "Code", size: "12", title });
    const base = made("select", { "aria-label": "Language to start from" });
    const form = made("form", { class: "row" }, name, " starts from ", base, tag,
      made("button", { type: "submit" }, "Begin"));
    const opened = made("details", { class: "beginner" }, made("summary", "New language…"), form);
    opened.addEventListener("toggle", () => fillNames(base, this.studio.project.languages, this.studio.state.language));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.studio.attempt(async () => {
        const stated = { name: name.value, base: base.value, tag: tag.value };
        const begun = await this.studio.api.post("language", stated);
        this.studio.project = await this.studio.api.get("project");
        await this.studio.open(begun.name, this.studio.state.character ?? "");
        opened.removeAttribute("open");
        name.value = tag.value = "";
        this.studio.tell(`Began ${begun.name}: its pack is ${begun.file}`); // in the place of a refusal
      });
    });
    return opened;
  }

  // The table

  async #load() {
    const { language, revision = 0, text = "" } = this.studio.state, wanted = `${language} ${revision} ${text}`;
    if (wanted === this.asked) return;
    this.asked = wanted;
    if (this.told?.name !== language)
      this.list.replaceChildren(made("p", { class: "note" }, "Reading the pack and running its tests…"));
    await this.studio.attempt(async () => {
      const told = await this.studio.api.get("language");
      if (this.asked !== wanted) return;
      if (this.told?.name !== told.name) this.#first(told);
      this.told = told;
      this.#head();
      this.#list();
      this.#listTests();
      if (this.word.value.trim()) this.#try();
    });
    if (!this.told && this.asked === wanted) this.asked = "";
  }

  /** @param {any} told of a language that was not shown before */
  #first(told) {
    this.open = this.standing = "";
    this.word.value = "";
    this.tried.replaceChildren(made("i", "Type a word to see its sounds and mouths, with your unsaved edits."));
    const names = [...told.notations, ...(told.automatic && !told.notations.includes("ipa") ? ["ipa"] : [])];
    this.notation.replaceChildren(
      made("option", { value: "" }, "All notations"),
      ...names.map((one) => made("option", { value: one }, one)),
    );
    this.notation.value = names.includes("ipa") ? "ipa" : told.read;
  }

  #head() {
    const { told } = this,
      look = told.rows.filter((/** @type {Sound} */ one) => one.need && one.need !== "loses").length;
    const facts = [
      told.tag,
      told.extends ? `extends ${told.extends}` : "",
      `${told.rows.length} labels`,
      look ? `${look} need review` : "",
      told.speaks ? "" : "no voice: times are estimated, without sound",
    ];
    this.title.replaceChildren(told.title, made("small", facts.filter(Boolean).join(" · ")));
    this.caveats.hidden = !told.caveats.length;
    this.caveats.replaceChildren(
      made("summary", `Known mistakes: ${told.caveats.length}`),
      made("ul", ...told.caveats.map((/** @type {string} */ one) => made("li", one))),
    );
  }

  /** @returns {Sound[]} rows that the search and the filters leave */
  #rows() {
    if (!this.told) return [];
    const wanted = this.search.value.trim().toLocaleLowerCase(),
      { value: notation } = this.notation,
      { value: filter } = this.filter;
    const fits = {
      "": () => true,
      look: (/** @type {Sound} */ one) => Boolean(one.need),
      own: (/** @type {Sound} */ one) => one.own,
      several: (/** @type {Sound} */ one) => one.to.length > 1,
      mute: (/** @type {Sound} */ one) => !one.to.length && one.need !== "unmapped",
    }[filter] ?? (() => true);
    return this.told.rows.filter(
      (/** @type {Sound} */ one) =>
        (one.need === "unmapped" || !notation || one.notation === notation) &&
        fits(one) &&
        (!wanted ||
          [one.label, ...one.to, ...one.words, one.reason, one.why].some((text) =>
            text.toLocaleLowerCase().includes(wanted),
          )),
    );
  }

  #list() {
    const rows = this.#rows(), shown = rows.slice(0, MOST);
    /** @type {Node[]} */
    const parts = [];
    for (const [need, title] of Object.entries(NEEDS)) {
      const some = shown.filter((one) => one.need === need);
      if (some.length)
        parts.push(
          made("h3", made("b", String(rows.filter((one) => one.need === need).length)), ` ${title}`),
          made("ul", ...some.map((one) => this.#row(one))),
        );
    }
    if (rows.length > shown.length)
      parts.push(made("p", { class: "note" }, `${rows.length - shown.length} more. Search to find one.`));
    if (!rows.length)
      parts.push(
        made(
          "p",
          { class: "empty" },
          this.told.rows.length
            ? "No sound matches. Search for a label, a mouth or a word."
            : "This language has no table. Speak a line in it to list its sounds here, mapped by their features.",
        ),
      );
    const focus = this.list.contains(document.activeElement)
      ? /** @type {HTMLElement} */ (document.activeElement).dataset.part
      : "";
    const { scrollTop } = this.list;
    this.list.replaceChildren(...parts);
    this.list.scrollTop = scrollTop;
    if (focus)
      /** @type {HTMLElement | null} */ (
        this.list.querySelector(`li[data-row="${CSS.escape(this.standing)}"] [data-part="${focus}"]`)
      )?.focus();
  }

  /** @param {Sound} one @returns {HTMLElement} */
  #row(one) {
    const open = this.open === key(one), words = this.#describe(one);
    const to = button(
      one.to.join(" ") || (one.need === "unmapped" ? "choose…" : "mute"),
      { class: "to", "data-part": "to", "aria-expanded": String(open), title: "Edit" },
      () => this.#edit(open ? "" : key(one)),
    );
    const hear = button(
      one.words[0] ? `▶ ${one.words[0]}` : "▶ alone",
      {
        class: "hear",
        "data-part": "hear",
        dir: "auto",
        title: one.words.length
          ? `Hear it in: ${one.words.join(", ")} (V)`
          : "No word of the pack has this sound, so the mouth moves without a voice (V)",
      },
      () => this.hear(one),
    );
    const show = button("Show", { "data-part": "show", title: "Show its mouth on the face (T)" }, () => this.pose(one));
    if (one.need === "unmapped") [hear, show].forEach((button) => button.setAttribute("disabled", ""));
    const label = made(
      "dfn",
      { dir: "auto", title: `${one.notation}${one.own ? ", stated in this file" : ""}` },
      one.label,
    );
    const row = made(
      "div",
      { class: `sound ${one.need}` },
      label,
      to,
      made("p", ...words),
      made("span", { class: "row" }, hear, show),
    );
    const item = made("li", { "data-row": key(one) }, row);
    if (open) item.append(this.editor.show(one, this.told.common, { parent: Boolean(this.told.extends) }));
    return item;
  }

  /** @param {Sound} one @returns {(Node | string)[]} what it looks like, and why */
  #describe(one) {
    const looks = one.to
      .map((name) => this.told.common.find((/** @type {CommonPhoneme} */ common) => common.name === name)?.title ?? "")
      .filter(Boolean)
      .join(", then ");
    const why = [...new Set([one.says, one.reason || one.why])].filter(
      (text) => text && !(one.need === "loses" && text.startsWith("by its features")),
    );
    return [made("b", looks), looks && why.length ? " · " : "", why.join(" · ")];
  }

  /** @param {string} row to edit, "" for none */
  #edit(row) {
    this.open = row;
    if (row) this.standing = row;
    this.#list();
    if (row) this.editor.focus();
    else
      /** @type {HTMLElement | null} */ (
        this.list.querySelector(`li[data-row="${CSS.escape(this.standing)}"] .to`)
      )?.focus();
  }

  // A sound

  /** @param {Sound} one */
  async hear(one) {
    const { studio } = this;
    if (one.words[0]) await studio.speak(one.words[0]);
    else {
      await studio.openLine("language/sound", { notation: one.notation, label: one.label });
      studio.tell(`No word of the pack has ${one.label}, so the mouth moves without a voice`);
    }
    studio.player.seek(studio.take?.start ?? 0);
    studio.player.toggle();
  }

  /** @param {Sound} one */
  async pose(one) {
    const { studio } = this;
    studio.player.pause();
    this.posing = one;
    await studio.attempt(async () => {
      for (const name of one.to) {
        const { steps } = await studio.api.get(`language/mouth/${encodeURIComponent(name)}`);
        for (const weights of steps) {
          if (this.posing !== one) return;
          studio.pose(Float32Array.from(weights));
          await new Promise((done) => setTimeout(done, HELD));
        }
      }
    });
  }

  // A word

  #typed() {
    clearTimeout(this.later);
    this.later = setTimeout(() => this.#try(), TYPED);
  }

  async #try() {
    const text = this.word.value.trim();
    this.transcript = null;
    if (!text) {
      this.tried.replaceChildren();
      return;
    }
    try {
      const told = await this.studio.api.post("language/transcript", { text });
      if (this.word.value.trim() !== text) return;
      this.transcript = told;
      this.tried.replaceChildren(
        ...told.words.map((/** @type {TranscribedWord} */ word) =>
          made("span", { class: "word" }, ...this.#word(word, told)),
        ),
      );
      if (told.unread.length) this.tried.append(made("i", `Not read: ${told.unread.join(" ")}`));
    } catch (error) {
      this.tried.replaceChildren(made("i", error instanceof Error ? error.message : String(error)));
    }
  }

  /** @param {TranscribedWord} word @param {Transcript} told @returns {HTMLElement[]} its labels with their mouths */
  #word(word, told) {
    if (!word.labels.length) return [made("i", word.text || "|")];
    const labels = word.labels.map(({ label, common }) => {
      const loses = told.automatic[label]?.loses ?? [], unmapped = told.unmapped.includes(label);
      const mouths = word.pronounced ? "" : common.join(" ") || (unmapped ? "unmapped" : "mute");
      return button(
        [made("span", label), made("small", mouths)],
        {
          class: unmapped ? "unmapped" : "",
          title: loses.length ? `by its features; not shown: ${loses.join(", ")}` : "Find it in the table",
        },
        () => this.find(label),
      );
    });
    return word.pronounced ? [...labels, made("i", `pronounced ${word.pronounced.join(" ")}`)] : labels;
  }

  /** @param {string} label to look for in the table */
  find(label) {
    this.search.value = label;
    this.notation.value = this.told.read;
    this.filter.value = "";
    this.#list();
  }

  async #keep() {
    const { transcript } = this;
    if (!transcript) {
      this.studio.tell("Type a word first");
      return;
    }
    const test = {
      text: transcript.text,
      phonemes: transcript.phonemes.filter((/** @type {string} */ one) => one !== "_"),
    };
    const count = this.told.own_tests;
    const edit = count
      ? { file: "language", at: ["tests", count], value: test }
      : { file: "language", at: ["tests"], value: [test] };
    await this.studio.edit([edit], `Test '${test.text}'`);
  }

  // Tests

  #listTests() {
    const { refusal } = this.told, tests = /** @type {import("../payloads.js").PackTest[]} */ (this.told.tests);
    const failed = tests.filter((/** @type {import("../payloads.js").PackTest} */ one) => !one.passed).length;
    const summary = refusal
      ? made("span", "not run")
      : failed
        ? made("span", { class: "fails" }, `${failed} of ${tests.length} fail`)
        : made("span", { class: "passes" }, tests.length ? `all ${tests.length} pass` : "none");
    const rows = tests.toSorted((a, b) => Number(a.passed) - Number(b.passed));
    this.tests.replaceChildren(
      made("div", { role: "status" }, made("h3", "Tests: ", summary)),
      ...(refusal ? [made("p", { class: "note" }, `${refusal}. Below, only the IPA of their sources is mapped.`)] : []),
      ...(tests.length
        ? []
        : [
            made(
              "p",
              { class: "note" },
              "The pack has no tests. Try a word above. " +
                "If its mouths are right, keep it as a test, which then runs after each edit.",
            ),
          ]),
      made("ol", ...rows.map((one) => this.#test(one))),
    );
  }

  /** @param {import("../payloads.js").PackTest} test @returns {HTMLElement} */
  #test(test) {
    const text = button(
      test.text,
      { class: "text", dir: "auto", title: `Speak it${test.source ? `. ${test.source}` : ""}` },
      () => this.studio.speak(test.text),
    );
    const said = test.right ? test.expected : test.said;
    const differs = (/** @type {string} */ one, /** @type {number} */ at) => !test.right && test.expected[at] !== one;
    const mouths = said.map((/** @type {string} */ one, /** @type {number} */ at) =>
      made(differs(one, at) ? "mark" : "span", {}, `${one} `),
    );
    const box = made("div", text, " ", ...mouths);
    if (!test.passed) {
      const labels = test.labels.map((/** @type {string} */ label) =>
        button(label, { class: test.unmapped.includes(label) ? "unmapped" : "" }, () => this.find(label)));
      const notes = [
        test.right ? "" : `expected ${test.expected.join(" ")}`,
        test.claimed.length ? `its source's /${test.ipa}/ becomes ${test.claimed.join(" ")}` : "",
      ];
      box.append(
        ...notes.filter(Boolean).map((one) => made("small", one)),
        made("div", { class: "labels" }, ...labels),
      );
    }
    return made(
      "li",
      { class: test.passed ? "" : "failed" },
      made("b", { "aria-label": test.passed ? "passes" : "fails" }, test.passed ? "✓" : "✗"),
      box,
    );
  }
}

/** @param {Sound} one @returns {string} */
function key(one) {
  return `${one.notation} ${one.label}`;
}

/** @param {EventTarget | null} target @returns {string | undefined} */
function keyOf(target) {
  return /** @type {HTMLElement | null} */ (target instanceof Element ? target.closest("li[data-row]") : null)?.dataset
    .row;
}
