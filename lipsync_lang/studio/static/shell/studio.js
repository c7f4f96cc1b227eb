/** The shell of the studio: one pair, one line, one clock, and a view at a time. */

import { api, Refusal } from "./api.js";
import { BigramView } from "../views/bigram_view.js";
import { CharacterView } from "../views/character_view.js";
import { CoverageView } from "../views/coverage_view.js";
import { button, made, the } from "./elements.js";
import { FacePlace } from "../face/face_place.js";
import { ExportDialog } from "./export_dialog.js";
import { LanguageView } from "../views/language_view.js";
import { actButton, chosen, fillNames } from "./form_fields.js";
import { PlayerBar } from "./player_bar.js";
import { Edits } from "./studio_edits.js";
import { Player } from "../line/player.js";
import { Snippets } from "../line/snippets.js";
import { Portrait } from "../face/portrait.js";
import { clock } from "../timeline/scales.js";
import { ScriptLines } from "./script_lines.js";
import { SentenceView } from "../views/sentence_view.js";
import { shellKeys } from "./studio_keys.js";
import { Take } from "../line/take.js";
import { Timeline } from "../timeline/timeline.js";
import { Tour } from "./tour.js";
import { WordsView } from "../views/words_view.js";

/** @typedef {"state" | "take" | "time" | "theme" | "face"} Change a new state, curves, playhead, colours or model */
/**
 * @typedef {object} View
 * @property {(argument: string) => Promise<void>} show become visible, with what follows the view's name in the address
 * @property {() => void} hide
 * @property {(event: KeyboardEvent) => boolean} key true if the key was used
 * @property {(what: Change) => void} changed
 * @property {() => Partial<import("../timeline/timeline.js").Line>} [strip] what the strip below shows for it
 */
/** @typedef {import("../payloads.js").Fault} Fault */
/** @typedef {{file: string, at: (string | number)[], value?: unknown}} Edit without a value it deletes */

/** Names in the address, titles and classes of the views. */
const VIEWS = /** @type {[string, string, new (studio: Studio, place: HTMLElement) => View][]} */ ([
  ["sentence", "Sentence", SentenceView],
  ["bigrams", "Bigrams", BigramView],
  ["character", "Character", CharacterView],
  ["words", "Words & lines", WordsView],
  ["coverage", "Coverage", CoverageView],
  ["language", "Language", LanguageView],
]);

/** Milliseconds for which a message stays. */
const TOLD = 6000;
const SECOND = 1000;
/** Milliseconds between looks for edits of another tab. */
const LOOK = 3000;
/** Milliseconds from a change of another tab to the look for it: a drag changes much at once. */
const FOLLOW = 100;
/** Milliseconds after which a face is shaded. */
const SHADE_LATER = 600;
/** Milliseconds after which the server prepares for edits: the first picture does not wait for it. */
const WARM_LATER = 800;
/** The studio as a whole; views get it. */
export class Studio {
  constructor() {
    this.api = api;
    /** The server's state: the pair, its poses and phonemes, unsaved edits. */
    this.state = /** @type {import("../payloads.js").State} */ ({});
    /** Languages and characters to choose from. */
    this.project = /** @type {import("../payloads.js").Project} */ ({});
    /** The line's curves. @type {Take | null} */
    this.take = null;
    /** The take to compare with. @type {Take | null} */
    this.other = null;
    /** @type {import("../line/player.js").Sound | null} */
    this.sound = null;
    /**
     * The model, and a take of rest.
     * @type {{face: import("../payloads.js").Face, take: import("../payloads.js").TakeData} | null}
     */
    this.model = null;
    /** How the line is performed: fps, line, styles, dials, intensity. @type {import("../payloads.js").Settings} */
    this.settings = {};
    this.against = "";
    this.player = new Player(0, 1, null, () => this.#playing());
    this.snippets = new Snippets();
    /** @type {Portrait | null} */
    this.portrait = null;
    /** Weights of the model's channels shown in place of the take's. @type {Float32Array | null} */
    this.posed = null;
    this.tab = crypto.randomUUID();
    this.strip = new Timeline(/** @type {HTMLCanvasElement} */ (the("strip")), {
      seek: (seconds) => this.seek(seconds),
      scrub: (seconds) => this.scrub(seconds),
      hover: () => {},
      pick: () => {},
      moved: () => this.wake(),
      word: (word) => this.hear({ word }),
      phoneme: (phoneme) => this.hear({ phoneme }),
    });
    /** @type {Map<string, {view: View, place: HTMLElement}>} */
    this.views = new Map();
    /** @type {View | null} */
    this.view = null;
    this.viewName = "";
    /** @type {number | undefined} */
    this.asked = undefined;
    this.edits = new Edits(this);
    this.bar = new PlayerBar(this);
    this.facePlace = new FacePlace(this);
    this.script = new ScriptLines(this);
    this.exporting = new ExportDialog(this);
    this.performing = false;
    /** The line plays because something is dragged. */
    this.heldPlaying = false;
    /** Requests that opened the line, for a server that is started again. @type {[string, object][]} */
    this.openings = [];
    /** Wishes for another take: the newest of each path. @type {Map<string, Record<string, any>>} */
    this.wishes = new Map();
    /**
     * Which part of a long line is shown, of how many.
     * @type {{number: number, count: number, seconds: number} | null}
     */
    this.part = null;
  }

  async start() {
    this.#listen();
    this.api.lost = (why) => this.tell(why, "fault", true);
    this.api.back = () => this.#back();
    const face = this.api.packed("face").catch(() => null); // asked for at once: it takes longest
    this.project = await this.api.get("project");
    this.state = this.project.state;
    fillNames(the("of-language"), this.project.languages, this.state.language);
    fillNames(the("of-character"), this.project.characters, this.state.character);
    this.facePlace.offer(this.project.characters);
    const { restored, notes = [] } = this.state;
    const told = [...(restored ? [`Restored ${restored} unsaved edits of the last session`] : []), ...notes];
    if (told.length) this.tell(told.join("\n"), notes.length ? "fault" : "");
    if (this.state.language) await this.#opened(await face);
    await this.script.start();
    await this.#first();
    the("tours").replaceChildren(...this.#tours());
    document.documentElement.dataset.ready = "";
    setTimeout(() => this.api.post("warm").catch(() => {}), WARM_LATER);
  }

  // The pair

  /**
   * @param {string} language
   * @param {string} character
   * @param {boolean} [scripted] a line of the script is opened if the pair leaves none
   */
  async open(language, character, scripted = true) {
    await this.attempt(async () => {
      this.state = await this.api.post("open", { language, character });
      fillNames(the("of-language"), this.project.languages, this.state.language);
      fillNames(the("of-character"), this.project.characters, this.state.character);
      await this.#opened();
    });
    if (scripted) await this.script.start();
  }

  /**
   * Show the face and the line of the pair.
   * @param {{face: import("../payloads.js").Face | null} | null} [face] that was asked for already
   */
  async #opened(face) {
    the("main").querySelector(".empty")?.remove();
    this.take = this.other = null;
    this.script.opened(null);
    this.settings = this.state.settings ?? {};
    await this.loadFace(face);
    if (this.state.line) await this.attempt(async () => this.#heard(await this.api.packed("line")));
    this.edits.show();
    await this.#go();
    this.notify("state");
    this.wake();
  }

  /**
   * Draw the model again after it was opened or replaced.
   * @param {{face: import("../payloads.js").Face | null} | null} [face] that was asked for already
   */
  async loadFace(face) {
    const model = face?.face ? face : await this.api.packed("face");
    this.model = model;
    this.posed = null;
    const rest = new Take(model.take);
    this.portrait = new Portrait({ faces: [model.face] }, this.take ?? rest);
    const { data, trouble } = this.portrait;
    this.facePlace.show(this.portrait, this.state.character);
    the("tongue").setAttribute("aria-pressed", "false");
    const notes = [...data.unshown, ...(trouble ? [trouble] : [])];
    the("notes").hidden = !notes.length;
    the("notes").replaceChildren(...notes.map((/** @type {string} */ one) => made("li", one)));
    const shown = this.portrait;
    setTimeout(() => { shown.shade(); this.wake(); }, SHADE_LATER);
    this.notify("face");
  }

  /** Open a pair if none is chosen, say a line if there is none, and offer the tours. */
  async #first() {
    const { first } = this.project;
    const asked = this.state.language;
    if (first && !asked) await this.open(first.language, first.character);
    if (!this.state.language) {
      const words = "Choose a language and a character above. Edits are saved in this folder only.";
      the("view").replaceChildren(made("section", { class: "empty" }, made("h2", words)));
    }
    if (this.state.language && !this.take && first?.line) await this.speak(first.line);
    if (!asked) this.tell("Edits are saved in this folder only.", "", true, ...this.#tours());
  }

  /** @returns {HTMLElement[]} a button for each tour */
  #tours() {
    return this.project.tours.map((name) => actButton(`Take the tour: ${name}`, `Take the tour: ${name}`, () => {
      /** @type {HTMLDialogElement} */ (the("help")).close();
      the("toasts").replaceChildren();
      this.tour(name);
    }));
  }

  /** @param {string} character that has a tour */
  async tour(character) {
    await this.busy(async () => {
      const { language, line, steps } = await this.api.get(`tour/${encodeURIComponent(character)}`);
      await this.open(language, character);
      if (!this.take) await this.speak(line);
      new Tour(this, steps);
    });
  }

  /** Go on with a server that was started again: open the pair there, and the line if it still can be opened. */
  async #back() {
    const { direct } = this.api, { language, character, line, name } = this.state;
    const { time } = this.player, { fps } = this.settings;
    let state = await direct.get("state"), lacking = "";
    const notes = [...(state.notes ?? [])];
    if (language && (state.language !== language || state.character !== character))
      state = await direct.post("open", { language, character });
    this.state = state;
    try {
      if (line && (!state.line || state.name !== name))
        for (const [path, body] of this.openings) this.#heard(await direct.sent(path, body));
      else if (state.line) this.#heard(await direct.packed("line"));
      if (line && this.settings.fps !== fps) await direct.sent("take", { settings: { ...this.settings, fps } });
    } catch (error) { // the line was taken out of the script, or its recording away
      if (!(error instanceof Refusal) || !error.status) throw error;
      lacking = error.message;
    }
    this.seek(time);
    this.stated(await direct.get("state"));
    const count = this.state.unsaved?.length, edits = count ? ` with your unsaved edits (${count})` : "";
    const page = `The studio was started again, and this page goes on${edits}`;
    if (lacking) this.tell([page, lacking, ...notes].join("\n"), "fault", true);
    else this.tell([page, ...notes].join("\n"));
  }

  // The line

  /** @param {string} text */
  async speak(text) {
    await this.openLine("line", { text }, "Speaking the line");
  }

  /** @param {string} path of the request @param {object} body @param {string} [words] about long work */
  async openLine(path, body, words) {
    await this.busy(async () => {
      this.#heard(await this.api.sent(path, body));
      const added = path.startsWith("sound") && !/[?&](text|hear)=/.test(path);
      this.openings = [...(added ? this.openings : []), [path, body]];
    }, words);
  }

  /** @param {import("../payloads.js").Line} told take and sound of a new line */
  #heard(told) {
    this.sound = told.sound;
    this.settings = told.settings;
    this.state = { ...this.state, line: true, text: told.text, name: told.name, opened: told.opened };
    this.script.opened(told.script);
    /** @type {HTMLInputElement} */ (the("text")).value = told.text;
    this.#taken(told);
    const { rate } = this.player;
    this.player.close();
    const take = /** @type {Take} */ (this.take);
    this.player = new Player(take.start, take.end, this.sound, () => this.#playing());
    this.player.setRate(rate);
    this.strip.shown = null;
    this.drawStrip();
    const remarks = [...told.remarks, ...(told.unread ? [`Not read: ${told.unread}`] : [])];
    if (remarks.length) this.tell(remarks.join("\n"), told.unread ? "fault" : "");
    this.notify("take");
    this.wake();
  }

  /**
   * Perform the line once more; the newest wish of each path wins, and one is in flight.
   * @param {string} [path] what is changed of the line before, such as `boundary/3`
   * @param {Record<string, any>} [body] with `passing`, the change goes on, and is no step of undo yet
   */
  async perform(path = "take", body = {}) {
    if (!this.take) return;
    const last = this.wishes.get(path);
    this.wishes.set(path, last && !last.passing ? { ...last, ...body, passing: undefined } : body);
    if (this.performing) return;
    this.performing = true;
    try {
      for (let next = this.wishes.entries().next(); !next.done; next = this.wishes.entries().next()) {
        const [where, wish] = next.value;
        this.wishes.delete(where);
        const told = await this.api.sent(where, { ...wish, against: this.against, tab: this.tab });
        this.#taken(told);
        if (told.state) this.stated(told.state);
        this.drawStrip();
        this.notify("take");
        this.wake();
      }
    } catch (error) {
      this.wishes.clear();
      this.tell(String(error instanceof Error ? error.message : error), "fault");
    } finally {
      this.performing = false;
    }
  }

  /** @param {import("../payloads.js").Line} told */
  #taken(told) {
    this.part = told.part;
    [this.take, this.other] = [new Take(told.takes[0]), told.takes[1] ? new Take(told.takes[1]) : null];
    if (this.portrait) this.portrait.take = this.take;
    this.facePlace.renew();
  }

  /** Show the strip beside every view but that of the whole timeline. */
  drawStrip() {
    the("strip").hidden = !this.take || this.viewName === "sentence";
    const more = this.view?.strip?.();
    if (this.take) this.strip.show({ take: this.take, other: null, sound: this.sound, rows: [], ...more });
  }

  // Edits

  /**
   * Change packs; resolves when the curves are new. The newest edits of one drag win.
   * @param {Edit[]} edits
   * @param {string} title of the step in undo
   * @param {string} [merge] edits with one key are one step
   * @returns {Promise<void>}
   */
  edit(edits, title, merge = "") {
    return this.edits.make(edits, title, merge);
  }

  /** Take a new state of the server over. @param {import("../payloads.js").State} state */
  stated(state) {
    const text = /** @type {HTMLInputElement} */ (the("text"));
    if (state.text !== this.state.text && text.value === this.state.text) text.value = state.text;
    this.state = state;
    if (!this.wishes.has("take")) this.settings = state.settings; // else they are newer here
    this.edits.show();
    this.notify("state");
  }

  /** Request the state, and perform again if another tab changed it. */
  async look() {
    await this.attempt(async () => {
      const state = await this.api.get("state");
      const moved = state.revision !== this.state.revision || state.unsaved.length !== this.state.unsaved?.length;
      const pair = state.language !== this.state.language || state.character !== this.state.character;
      if (pair || (!state.line && this.take)) {
        this.state = state;
        fillNames(the("of-language"), this.project.languages, state.language);
        fillNames(the("of-character"), this.project.characters, state.character);
        await this.#opened();
      } else if (state.opened !== this.state.opened) {
        this.stated(state);
        if (state.line) this.#heard(await this.api.packed("line"));
      } else if (moved) {
        this.stated(state);
        await this.perform();
      }
    });
  }

  // Views

  /** @param {string} name @param {string} [argument] */
  go(name, argument = "") {
    const address = `#${name}${argument ? `/${encodeURIComponent(argument)}` : ""}`;
    if (location.hash === address) this.#go();
    else location.hash = address;
  }

  async #go() {
    if (!this.state.language) return;
    const [asked, argument = ""] = location.hash.slice(1).split("/");
    const [name, title, Kind] = VIEWS.find(([one]) => one === asked) ?? VIEWS[0];
    let known = this.views.get(name);
    if (!known) {
      const place = made("section", { "aria-label": name });
      known = { place, view: new Kind(this, place) };
      this.views.set(name, known);
    }
    if (this.view !== known.view) {
      this.view?.hide();
      scrollTo(0, 0);
    }
    [this.view, this.viewName] = [known.view, name];
    document.body.dataset.view = name;
    the("view").replaceChildren(made("h2", { class: "unseen" }, title), known.place);
    for (const one of the("tabs").children) {
      if (one.getAttribute("href") === `#${name}`) one.setAttribute("aria-current", "page");
      else one.removeAttribute("aria-current");
    }
    this.drawStrip();
    await this.attempt(() => known.view.show(decodeURIComponent(argument)));
    this.edits.show();
    this.drawStrip();
    this.bar.timeline.follow(this.player.time);
    this.wake();
  }

  /** @param {Change} what */
  notify(what) {
    this.view?.changed(what);
  }

  // Time

  /** @param {number} seconds */
  seek(seconds) {
    this.posed = null;
    this.player.seek(seconds);
    this.wake();
  }

  /** Go to a time in a drag, and hear it. @param {number} seconds */
  scrub(seconds) {
    this.seek(seconds);
    if (!this.player.playing) this.snippets.scrub(this.sound, seconds);
  }

  /** Hear a word or a phoneme of the line. @param {{word?: number, phoneme?: number}} what */
  hear({ word = -1, phoneme = -1 }) {
    const { times, words } = this.take?.data.spoken ?? { times: [], words: [] };
    const [first, stop] = words[word]?.slice(1).map(Number) ?? [phoneme, phoneme + 1];
    if (first >= 0 && !this.player.playing) this.snippets.hear(this.sound, times[first], times[stop]);
  }

  /** Play a looped line while something is dragged. @param {boolean} dragging */
  dragged(dragging) {
    if (dragging && this.player.loop && !this.player.playing) {
      this.heldPlaying = true;
      this.player.play();
    } else if (!dragging && this.heldPlaying) {
      this.heldPlaying = false;
      this.player.pause();
    }
  }

  /** @param {number} seconds to go to, and to bring into view */
  reveal(seconds) {
    this.player.pause();
    this.seek(seconds);
    this.bar.timeline.follow(seconds);
  }

  /** @param {number} frames */
  step(frames) {
    if (!this.take) return;
    this.player.pause();
    this.reveal(this.take.timeOf(this.take.frameAt(this.player.time) + frames));
  }

  /** @param {Float32Array | null} weights of the model's channels to show in place of the take's */
  pose(weights) {
    this.posed = weights;
    this.wake();
  }

  #playing() {
    this.bar.show(this.player.playing);
    if (this.player.playing) this.posed = null;
    this.wake();
  }

  /** Draw a frame soon. */
  wake() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = undefined;
      const seconds = this.player.time;
      if (this.player.playing) this.strip.follow(seconds);
      this.portrait?.draw(seconds, this.posed);
      this.facePlace.follow(seconds);
      if (this.strip.shown && !the("strip").hidden) this.strip.draw(seconds);
      the("clock").textContent = this.take ? clock(seconds) : "";
      this.notify("time");
      if (this.player.playing) this.wake();
    });
  }

  // Words

  /**
   * Show a notice in the place of the last one.
   * @param {string} text @param {"" | "fault"} [kind] @param {boolean} [stays] until the next one
   * @param {...Node} more after the text
   */
  tell(text, kind = "", stays = false, ...more) {
    const one = made("li", { class: kind }, text);
    one.append(...more, button("×", { "aria-label": "Close" }, () => one.remove()));
    the("toasts").replaceChildren(one);
    if (!stays) setTimeout(() => one.remove(), kind ? 2 * TOLD : TOLD);
    return one;
  }

  /** @param {() => Promise<void>} does @returns {Promise<void>} a refusal is told, not thrown */
  async attempt(does) {
    try {
      await does();
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      const faults = (error.told.faults ?? [])
        .slice(0, 3)
        .map((/** @type {Fault} */ { place, what, hint }) => `${place}: ${what}${hint ? `\n${hint}` : ""}`);
      this.tell(faults.length ? faults.join("\n") : error.message, "fault");
    }
  }

  /** @param {() => Promise<void>} does what takes a while @param {string} [words] about it, after a second */
  async busy(does, words = "") {
    const since = performance.now(), seconds = made("span", { "aria-hidden": "true" });
    document.body.classList.add("busy");
    const working = setInterval(() => {
      if (words && !seconds.textContent) this.tell(words, "", true, seconds);
      seconds.textContent = ` … ${Math.round((performance.now() - since) / SECOND)} s`;
    }, SECOND);
    await this.attempt(does);
    clearInterval(working);
    seconds.closest("#toasts li")?.remove();
    document.body.classList.remove("busy");
  }

  // Hands

  #listen() {
    for (const [name, title] of VIEWS) the("tabs").append(made("a", { href: `#${name}` }, title));
    for (const id of ["of-language", "of-character"])
      the(id).addEventListener(
        "change",
        () => this.open(chosen("of-language"), chosen("of-character")),
      );
    the("pair").addEventListener("submit", (event) => event.preventDefault());
    the("say").addEventListener("submit", (event) => {
      event.preventDefault();
      const text = /** @type {HTMLInputElement} */ (the("text")).value.trim();
      if (text) this.speak(text);
      else this.tell("Type a line first");
    });
    addEventListener("hashchange", () => this.#go());
    addEventListener("resize", () => { this.strip.stale = true; this.notify("theme"); this.wake(); });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.strip.stale = true;
      this.notify("theme");
      this.wake();
    });
    document.addEventListener("keydown", (event) => shellKeys(this, event));
    addEventListener("focus", () => this.state.language && this.look());
    /** @type {Promise<void> | null} */
    let looks = null; // one at a time: while the studio is stopped none ends
    setInterval(() => {
      if (this.state.language && !document.hidden && !this.edits.sending)
        looks ??= this.look().finally(() => { looks = null; });
    }, LOOK);
    let soon = 0;
    this.api.heard(() => {
      clearTimeout(soon);
      soon = setTimeout(() => { if (this.state.language && !this.edits.sending) this.look(); }, FOLLOW);
    });
  }
}

new Studio().start().catch((error) => {
  the("view").replaceChildren(made("p", { class: "note", role: "alert" }, `The studio cannot start: ${error.message}`));
  throw error;
});
