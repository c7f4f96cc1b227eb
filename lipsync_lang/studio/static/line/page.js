/** The page of a line: one clock moves the face, the playhead and the values. */

import { made, the } from "../shell/elements.js";
import { Overview } from "../timeline/overview.js";
import { Player } from "./player.js";
import { Portrait, label, turnByDrag } from "../face/portrait.js";
import { clock } from "../timeline/scales.js";
import { Take } from "./take.js";
import { TakeValues } from "./take_values.js";
import { findingTimes, listFigures, listStages, movingRows, tell } from "./take_words.js";
import { Timeline } from "../timeline/timeline.js";
import { unpack } from "./unpack.js";

/** Milliseconds after which a face is shaded: the first picture does not wait for it. */
const SHADE_LATER = 50;
const KEYS = {
  "Space": "Play or pause",
  "← →": "Go back or forward by a frame, with Shift by ten",
  ", .": "Go to the previous or next phoneme",
  "; '": "Go to the previous or next word",
  "Home End": "Go to the beginning or the end",
  "↑ ↓": "Choose a pose, and see its reasons",
  "1 2 4": "Play at full, half or quarter speed",
  "l": "Loop the word at the playhead; in a pause, the whole line",
  "c": "Show a close-up of the mouth",
  "o": "Turn the face: front or side",
  "a": "Switch between A and B",
  "n": "Go to the next missed limit, or else the next remark",
  "+ − 0": "Zoom in, zoom out, or show all",
  "?": "Show or hide this list",
};

/** The page as a whole. */
class Page {
  /** @param {import("../payloads.js").Page} data */
  constructor(data) {
    this.data = data;
    /** @type {Take[]} */
    this.takes = data.takes.map((one) => new Take(one));
    this.take = this.takes[0];
    /** @type {Take | null} */
    this.other = null;
    /** @type {string[]} poses in the order of their rows */
    this.rows = [];
    /** @type {number | undefined} */
    this.asked = undefined;
    [this.take, this.other] = [this.takes[0], this.takes[1] ?? null];
    const start = Math.min(...this.takes.map((one) => one.start));
    const end = Math.max(...this.takes.map((one) => one.end));
    this.player = new Player(start, end, data.sound, () => this.#playing());
    /** @type {Map<Take, Portrait>} */
    this.known = new Map();
    /** @type {Portrait[]} */
    this.portraits = [];
    the("main").classList.toggle("beside", this.takes.length > 1);
    this.timeline = new Timeline(/** @type {HTMLCanvasElement} */ (the("timeline")), {
      seek: (seconds) => this.seek(seconds),
      hover: (at) => this.#hover(at),
      pick: (row) => this.pick(row),
      moved: () => this.wake(),
    });
    this.overview = new Overview(/** @type {HTMLCanvasElement} */ (the("overview")), this.timeline);
    this.values = new TakeValues(
      { moment: the("moment"), bigrams: the("bigrams"), poses: the("poses") },
      { pick: (row) => this.pick(row), refold: () => this.#show() },
    );
    this.row = -1;
    the("main").hidden = false;
    this.#words();
    this.#listen();
    this.#compare(this.takes[1] ?? null);
    this.player.seek(start);
  }

  /** @param {Take | null} other to show beside the first take */
  #compare(other) {
    [this.take, this.other] = [this.takes[0], other];
    const shown = [this.take, ...(other ? [other] : [])];
    this.portraits = shown.map((one) => this.#portrait(one));
    the("faces").replaceChildren(...this.portraits.map((one) => one.figure));
    const notes = new Set(
      this.portraits.flatMap((one) => [...one.data.unshown, ...(one.trouble ? [one.trouble] : [])]),
    );
    the("notes").hidden = !notes.size;
    the("notes").replaceChildren(...[...notes].map((one) => made("li", one)));
    this.#show();
  }

  /** @param {Take} take @returns {Portrait} made when it is first shown, and shaded a little later */
  #portrait(take) {
    const known = this.known.get(take);
    if (known) return known;
    const portrait = new Portrait(this.data, take);
    portrait.setClose(this.portraits[0]?.close ?? false);
    portrait.canvas.setAttribute("aria-label", `${label(take)} speaking: ${this.data.title}`);
    this.#turning(portrait.canvas);
    this.known.set(take, portrait);
    setTimeout(() => {
      portrait.shade();
      this.wake();
    }, SHADE_LATER);
    return portrait;
  }

  /** Show the takes as they stand: one with its reasons, the other dashed. */
  #show() {
    const { take, other } = this, chosen = this.rows[this.row];
    the("against").setAttribute("aria-pressed", String(take !== this.takes[0]));
    this.rows = movingRows(take, other, this.values.opened);
    this.timeline.show({ take, other, sound: this.data.sound, rows: this.rows });
    this.values.show(take, this.rows);
    this.pick(this.rows.indexOf(chosen));
    this.#listFigures();
    this.#legend();
    for (const one of this.portraits) {
      one.caption.textContent = other ? label(one.take) : "";
      one.figure.classList.toggle("front", Boolean(other) && one.take === take);
    }
    const { scrub } = this;
    scrub.max = String(Math.round((this.player.end - this.player.start) * take.fps));
    this.wake();
  }

  /** @returns {HTMLInputElement} */
  get scrub() {
    return /** @type {HTMLInputElement} */ (the("scrub"));
  }

  /** Draw at the next frame of the screen. */
  wake() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = undefined;
      this.draw();
    });
  }

  draw() {
    const seconds = this.player.time;
    if (this.player.playing) this.timeline.follow(seconds);
    this.portraits.forEach((one) => one.draw(seconds));
    this.timeline.draw(seconds);
    this.overview.draw(seconds);
    this.#values(seconds);
    if (this.player.playing) this.wake();
  }

  /** @param {number} seconds */
  seek(seconds) {
    this.player.seek(seconds);
    this.wake();
  }

  /** @param {number} frames */
  step(frames) {
    this.player.pause();
    const { take } = this;
    this.reveal(take.timeOf(Math.max(0, Math.min(take.count - 1, take.frameAt(this.player.time) + frames))));
  }

  /** @param {number} seconds to go to, and to bring into view */
  reveal(seconds) {
    this.seek(seconds);
    if (seconds < this.timeline.from || seconds > this.timeline.to) this.timeline.follow(seconds);
  }

  /** @param {number} by phonemes */
  stepPhoneme(by) {
    this.#stepTo(this.take.data.spoken.times, by);
  }

  /** @param {number} by words */
  stepWord(by) {
    const { times, words } = this.take.data.spoken;
    this.#stepTo(words.map((/** @type {[string, number, number]} */ [, first]) => times[first]), by);
  }

  /** @param {number[]} times @param {number} by */
  #stepTo(times, by) {
    const now = this.player.time;
    const found = by > 0 ? times.find((one) => one > now + 1e-3) : times.findLast((one) => one < now - 1e-3);
    this.player.pause();
    if (found !== undefined) this.reveal(found);
  }

  /** @param {number} row of the timeline; -1 for none */
  pick(row) {
    this.row = Math.max(-1, Math.min(this.rows.length - 1, row));
    this.timeline.row = this.row;
    this.timeline.stale = true;
    this.values.pick(this.row);
    this.wake();
  }

  swap() {
    if (!this.other) return;
    [this.take, this.other] = [this.other, this.take];
    this.#show();
  }

  /** @param {number} rate */
  setRate(rate) {
    this.player.setRate(rate);
    for (const one of document.querySelectorAll("[data-rate]"))
      one.setAttribute("aria-pressed", String(Number(one.getAttribute("data-rate")) === rate));
  }

  toggleLoop() {
    const { take } = this, { times, words } = take.data.spoken;
    if (this.player.loop) this.player.loop = null;
    else {
      const word = take.wordOf(take.phonemeAt(this.player.time));
      const whole = /** @type {[number, number]} */ ([this.player.start, this.player.end]);
      this.player.loop = word < 0 ? whole : [times[words[word][1]], times[words[word][2]]];
    }
    this.timeline.loop = this.player.loop;
    this.timeline.stale = true;
    the("loop").setAttribute("aria-pressed", String(Boolean(this.player.loop)));
    this.wake();
  }

  toggleClose() {
    const close = !this.portraits[0].close;
    this.portraits.forEach((one) => one.setClose(close));
    the("close").setAttribute("aria-pressed", String(close));
    this.wake();
  }

  toggleSide() {
    for (const { face } of this.portraits) face?.setView({ yaw: face.yaw ? 0 : 75, pitch: 0 });
    this.wake();
  }

  nextFinding() {
    const times = findingTimes(this.take.data.figures);
    if (!times.length) return;
    this.player.pause();
    this.reveal(times.find((one) => one > this.player.time + 0.01) ?? times[0]);
  }

  #playing() {
    const button = the("play");
    button.textContent = this.player.playing ? "❚❚" : "▶";
    button.setAttribute("aria-label", this.player.playing ? "Pause" : "Play");
    the("moment").setAttribute("aria-live", this.player.playing ? "off" : "polite");
    this.wake();
  }

  // What is said in words

  #words() {
    const { data, take } = this, { estimated, left_out: leftOut } = take.data.spoken;
    const title = data.title || "A line";
    document.title = `${title} · lip sync`;
    the("title").textContent = title;
    const told = [take.data.language, take.data.character, `${Number(take.fps.toFixed(3))} fps`, ...data.settings];
    if (estimated) told.push("times are estimated");
    if (!data.sound) told.push("no sound");
    if (leftOut.length) told.push(`words left out: ${leftOut.join(", ")}`);
    the("subtitle").textContent = told.filter(Boolean).join("  ·  ");
    the("against").hidden = !this.other;
    the("others").hidden = this.takes.length < 3;
    the("others").append(...this.takes.slice(1).map((one, n) => made("option", { value: String(n + 1) }, label(one))));
    the("help")
      .querySelector("dl")
      ?.append(...Object.entries(KEYS).flatMap(([keys, what]) => [made("dt", keys), made("dd", what)]));
    the("timeline").setAttribute(
      "aria-label",
      `Sound, words, phonemes and poses of: ${title}. ` +
        "The arrow keys step through it, and the values are listed beside it.",
    );
  }

  /** Draw with the colours of the style as it is now. */
  #recolour() {
    this.timeline.stale = true;
    this.#legend();
    this.wake();
  }

  /** Draw at once in light colours for a printer, or in the reader's own again. @param {boolean} printed */
  #paper(printed) {
    document.documentElement.classList.toggle("paper", printed);
    this.#recolour();
    this.draw();
  }

  #legend() {
    listStages(the("legend"), this.take, this.other);
  }

  #listFigures() {
    const places = { figures: the("figures"), judged: the("judged"), missed: the("missed"), measured: the("measured") };
    listFigures(places, this.take.data.figures, (seconds) => {
      this.player.pause();
      this.reveal(seconds);
    });
  }

  /** @param {number} seconds */
  #values(seconds) {
    const { take, scrub } = this;
    const frame = take.frameAt(seconds), sound = take.soundAt(frame);
    scrub.value = String(Math.round((seconds - this.player.start) * take.fps));
    the("clock").textContent = clock(seconds);
    scrub.setAttribute("aria-valuetext", `${clock(seconds)}, ${sound.label}${sound.word ? ` in ${sound.word}` : ""}`);
    this.values.draw(frame, this.player.playing);
  }

  /** @param {import("./take_words.js").Pointed | null} at */
  #hover(at) {
    tell(the("tip"), this.timeline, this.player.playing ? null : at);
  }

  // Hands

  #listen() {
    const click = (/** @type {string} */ id, /** @type {() => void} */ does) => the(id).addEventListener("click", does);
    click("play", () => this.player.toggle());
    click("back", () => this.step(-1));
    click("on", () => this.step(1));
    click("loop", () => this.toggleLoop());
    click("close", () => this.toggleClose());
    click("against", () => this.swap());
    click("in", () => this.timeline.zoom(1.5, this.player.time));
    click("out", () => this.timeline.zoom(1 / 1.5, this.player.time));
    click("fit", () => this.timeline.setView(this.timeline.start, this.timeline.end));
    click("keys", () => this.#help());
    for (const one of document.querySelectorAll("[data-rate]"))
      one.addEventListener("click", () => this.setRate(Number(one.getAttribute("data-rate"))));
    this.scrub.addEventListener("input", () =>
      this.reveal(this.player.start + Number(this.scrub.value) / this.take.fps),
    );
    the("others").addEventListener("change", (event) =>
      this.#compare(this.takes[Number(/** @type {HTMLSelectElement} */ (event.target).value)]),
    );
    addEventListener("resize", () => { this.timeline.stale = true; this.wake(); });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#recolour());
    addEventListener("beforeprint", () => this.#paper(true));
    addEventListener("afterprint", () => this.#paper(false));
    document.addEventListener("keydown", (event) => this.#key(event));
    addEventListener("scroll", () => this.#hover(null), { passive: true });
  }

  /** @param {HTMLCanvasElement} canvas */
  #turning(canvas) {
    turnByDrag(canvas, () => this.portraits, () => this.wake());
    canvas.addEventListener("dblclick", () => {
      this.portraits.forEach((one) => one.setClose(one.close));
      this.wake();
    });
  }

  #help() {
    const help = /** @type {HTMLDialogElement} */ (the("help"));
    if (help.open) help.close();
    else help.showModal();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const help = /** @type {HTMLDialogElement} */ (the("help"));
    if (event.ctrlKey || event.metaKey || event.altKey || (help.open && event.key !== "?")) return;
    if (event.key === " " && event.target instanceof HTMLButtonElement) return;
    if (event.target instanceof HTMLSelectElement && event.key !== "?") return;
    const ten = event.shiftKey ? 10 : 1;
    /** @type {Record<string, () => void>} */
    const does = {
      " ": () => this.player.toggle(),
      "ArrowLeft": () => this.step(-ten), "ArrowRight": () => this.step(ten),
      "ArrowUp": () => this.pick(this.row - 1), "ArrowDown": () => this.pick(this.row + 1),
      ",": () => this.stepPhoneme(-1), ".": () => this.stepPhoneme(1),
      ";": () => this.stepWord(-1), "'": () => this.stepWord(1),
      "Home": () => this.reveal(this.player.start), "End": () => this.reveal(this.player.end),
      "1": () => this.setRate(1), "2": () => this.setRate(0.5), "4": () => this.setRate(0.25),
      "l": () => this.toggleLoop(), "c": () => this.toggleClose(), "o": () => this.toggleSide(),
      "a": () => this.swap(), "n": () => this.nextFinding(),
      "+": () => this.timeline.zoom(1.5, this.player.time), "=": () => this.timeline.zoom(1.5, this.player.time),
      "-": () => this.timeline.zoom(1 / 1.5, this.player.time),
      "0": () => this.timeline.setView(this.timeline.start, this.timeline.end),
      "?": () => this.#help(),
    };
    const act = does[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }
}

async function start() {
  try {
    const data = await unpack(the("document").textContent ?? "", the("block").textContent ?? "");
    new Page(data);
    document.documentElement.dataset.ready = "";
  } catch (error) {
    the("trouble").hidden = false;
    the("trouble").textContent =
      `This page cannot be shown here: ${error instanceof Error ? error.message : error}. ` +
      "This page needs a browser of 2023 or later.";
    throw error;
  }
}

start();
