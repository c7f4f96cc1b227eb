/** The sentence view: a line on its timeline, corrected and delivered by hand; each value tells why. */

import { BendHands } from "./bend_hands.js";
import { DeliveryPanel } from "./delivery_panel.js";
import { GestureHands } from "./gesture_hands.js";
import { button, made } from "../shell/elements.js";
import { actButton } from "../shell/form_fields.js";
import { withWord } from "../timeline/level_points.js";
import { fileButton, LineFiles } from "./line_files.js";
import { Overview } from "../timeline/overview.js";
import { clock } from "../timeline/scales.js";
import { PhonemeHands } from "./phoneme_hands.js";
import { PhonemePanel } from "./phoneme_panel.js";
import { sentenceKey } from "./sentence_keys.js";
import { TakeValues } from "../line/take_values.js";
import { findingTimes, listFigures, listStages, movingRows, tell, usedStages } from "../line/take_words.js";
import { Timeline } from "../timeline/timeline.js";
import { TrackLanes } from "../timeline/track_lanes.js";

/** Milliseconds without a change, after which the line is checked. */
const CHECK_LATER = 350;
/** Pixels of a pose's row, at least and at most, and what is left below the legend. */
const ROW = 50, MOST_ROW = 96, BELOW = 14;
/** Files that a button asks for. */
const TIMINGS = ".json,.textgrid,.TextGrid,.csv,.tsv,.txt,.xml,.ctm,.lab,.phn,.eaf,.pho,.bml,.vtt,.par",
  RECORDINGS = "audio/*,.wav,.flac,.mp4,.mov,.webm";

/** Pictures of a sound, and their buttons. @type {["wave" | "spectrogram" | "both", string][]} */
const PICTURES = [["wave", "Wave"], ["spectrogram", "Spectrogram"], ["both", "Both"]];

/** @typedef {import("../timeline/track_lanes.js").Track} Track */
/** @typedef {import("../timeline/level_points.js").Level} Level */

export class SentenceView {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.place = place;
    place.classList.add("sentence");
    const at = {
      canvas: made("canvas", { id: "timeline", role: "img", tabindex: "0" }),
      overview: made("canvas", { id: "overview", "aria-hidden": "true" }),
      lanes: made("div", { class: "lanes" }),
      gestures: made("div", { class: "gestures", hidden: "" }),
      legend: made("ul", { id: "legend", "aria-label": "Stages: press one to hide it" }),
      moment: made("p", { id: "moment", "aria-live": "polite" }),
      bigrams: made("ul", { id: "bigrams" }),
      poses: made("ul", { id: "poses" }),
      gesture: made("section", { class: "word", "aria-label": "Chosen gesture", hidden: "" }),
      phoneme: made("section", { class: "word", "aria-label": "Chosen phoneme", hidden: "" }),
      word: made("section", { class: "word", "aria-label": "Chosen word", hidden: "" }),
      leftOut: made("section", { class: "word", "aria-label": "Words that are left out", hidden: "" }),
      line: made("div"),
      parts: made("span", { class: "row parts", hidden: "" }),
      figures: made("section", { id: "figures", "aria-labelledby": "judged" }),
      judged: made("h2", { id: "judged" }),
      missed: made("ul", { id: "missed" }),
      measured: made("ul", { id: "measured" }),
    };
    this.at = at;
    this.whole = made("div", { class: "sentence-desk" });
    this.nothing = made("div", { class: "empty" });
    this.swapButton = made("button");
    /** @type {HTMLElement[]} */
    this.pictures = [];
    this.original = made("button");
    this.files = new LineFiles(studio, place);
    this.timeline = new Timeline(this.at.canvas, {
      seek: (seconds) => studio.seek(seconds),
      scrub: (seconds) => studio.scrub(seconds),
      hover: (at) => tell(this.#tip, this.timeline, studio.player.playing ? null : at),
      pick: (row) => this.pick(row),
      moved: () => { this.moved = true; studio.wake(); },
      drag: (grab, seconds, done, event) => this.phonemes.drag(grab, seconds, done, event),
      word: (word, more) => {
        if (!more) this.choose({ word }, true);
        else if (word >= 0) this.phonemes.extend({ word });
      },
      phoneme: (phoneme, more) =>
        phoneme >= 0 && (more ? this.phonemes.extend({ phoneme }) : this.choose({ phoneme }, true)),
      press: (x, y, event) => this.bends.press(x, y, event),
      pull: (x, y, done) => this.bends.drag(x, y, done),
      keys: (pose) => {
        const { chosen } = this.bends;
        return { shown: this.bends.shown(pose), chosen: chosen?.pose === pose ? chosen.which : null };
      },
      open: (seconds, row, phoneme) => {
        if (phoneme >= 0) this.phonemePanel.ask();
        else if (row >= 0) this.openBigram(seconds, row);
      },
    });
    this.bends = new BendHands(this);
    this.phonemes = new PhonemeHands(this);
    this.phonemePanel = new PhonemePanel(this.at.phoneme, this.phonemes);
    this.overview = new Overview(this.at.overview, this.timeline, true);
    this.values = new TakeValues(at, {
      pick: (row) => this.pick(row),
      refold: () => this.#take(),
      more: (bigram) => [this.#opener(bigram)],
    });
    this.lanes = new TrackLanes(this.at.lanes, this.timeline, {
      set: (track, level, done) => this.setLevel(track, level, done),
    });
    this.gestures = new GestureHands(this, at.gestures, at.gesture);
    this.panel = new DeliveryPanel(this.at.word, this.at.line, {
      set: (track, level, done) => this.setLevel(track, level, done),
      setWord: (track, value, done) => this.#setWord(track, value, done),
      emphasise: (level, done) => this.emphasise(level, done),
      state: (name, value, done) => this.set({ ...studio.settings, [name]: value }, `${name} ${value}`, done),
      open: (track) => this.#openTrack(track),
    });
    /** Keys of the tracks that are shown as lanes. @type {Set<string>} */
    this.open = new Set();
    /** The other take is on the face. */
    this.swapped = false;
    /** The labels to pick from are those of this line. */
    this.labelled = false;
    this.moved = true;
    /** @type {Level | undefined} */
    this.wordBefore = undefined;
    /** The player of the line that is shown. @type {import("../line/player.js").Player | null} */
    this.player = null;
    /** @type {import("../line/player.js").Sound | null} */
    this.heard = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.later = undefined;
    this.#furnish();
  }

  #furnish() {
    const open = () => [
      fileButton("Open timings…", TIMINGS, (files) => this.files.open(files)),
      fileButton("Open sound…", RECORDINGS, (files) => this.files.open(files)),
    ];
    this.swapButton = button("A/B", "Switch between A and B (A)", () => this.swap());
    this.original = button(
      "Original times",
      "Restore the phonemes and their times as they were opened or spoken",
      () => this.restore(),
    );
    const picture = "Picture of the sound (W)";
    this.pictures = PICTURES.map(([name, text]) => button(text, picture, () => this.picture(name)));
    this.picture("wave");
    /**
     * A button that turns a hand on and off.
     * @param {string} text @param {string} title @param {() => boolean} turned that turns it, and tells its state
     * @param {boolean} on
     */
    const toggle = (text, title, turned, on) => {
      const one = button(text, title, () => one.setAttribute("aria-pressed", String(turned())));
      one.setAttribute("aria-pressed", String(on));
      return one;
    };
    const { phonemes, bends } = this;
    const snap = toggle("Snap", "Boundaries stop at onsets of the sound; Alt turns it round in a drag",
      () => (phonemes.snap = !phonemes.snap), true);
    const ripple = toggle("Ripple", "Sounds after a boundary follow, up to a pause; Shift turns it round in a drag",
      () => (phonemes.ripple = !phonemes.ripple), false);
    const bend = toggle("Bend", "Drag a curve to bend it on this line; Ctrl does it without this button",
      () => (bends.on = !bends.on), false);
    const tools = made("div", { class: "row tools" }, ...open(),
      made("span", { class: "group", role: "group", "aria-label": "Save the timings" },
        button("Save timings", "As JSON, with emphasis and stress", () => this.files.save("json")),
        button("TextGrid", "Save the timings as a TextGrid, for Praat", () => this.files.save("TextGrid"))),
      made("span", { class: "group", role: "group", "aria-label": "Dragging boundaries" },
        snap, ripple), bend,
      made("span", { class: "group", role: "group", "aria-label": "Picture of the sound" },
        ...this.pictures),
      this.original, this.swapButton, this.at.parts);
    const { at } = this, { figures } = at;
    figures.append(
      this.at.judged,
      this.at.missed,
      made("details", made("summary", "Other figures"), this.at.measured),
    );
    const aside = made(
      "aside",
      { class: "why", "aria-label": "Values and reasons" },
      this.at.leftOut,
      this.at.word,
      this.at.phoneme,
      this.at.gesture,
      this.at.moment,
      this.at.bigrams,
      this.at.poses,
      made("details", { class: "delivery", open: "" }, made("summary", "Delivery of the line"), this.at.line),
      figures,
    );
    this.whole.append(
      tools,
      made("div", { class: "lines" }, at.overview, at.lanes, at.canvas, at.gestures, at.legend),
      aside,
    );
    this.nothing.append(
      made("h2", "No line yet"),
      made("p", "Type a line below and press Enter. " +
        "Or drop timed phonemes (TextGrid, JSON, CSV …) and their recording here."),
      made("p", { class: "row" }, ...open()),
    );
    this.place.append(this.whole, this.nothing);
  }

  get #tip() {
    return /** @type {HTMLElement} */ (document.getElementById("tip"));
  }

  /** @param {string} argument seconds to go to */
  async show(argument) {
    this.place.append(this.nothing);
    this.#take();
    if (argument && Number.isFinite(Number(argument))) this.reveal(Number(argument));
  }

  hide() {
    this.#tip.hidden = true;
    if (this.swapped) this.swap();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    return sentenceKey(this, event);
  }

  /** @param {import("../shell/studio.js").Change} what */
  changed(what) {
    if (what === "take" || what === "state" || what === "face") this.#take();
    if (what === "theme") {
      this.timeline.stale = true;
      this.moved = true;
      this.#legend();
    }
    if (what === "time") this.#draw();
  }

  /**
   * The take in front, and the one beside it.
   * @returns {[import("../line/take.js").Take | null, import("../line/take.js").Take | null]}
   */
  get shown() {
    const { take, other } = this.studio;
    return this.swapped && other ? [other, take] : [take, other];
  }

  #take() {
    const { studio } = this, { sound } = studio;
    if (!studio.other) this.swapped = false;
    const [take, other] = this.shown;
    this.whole.hidden = !take;
    this.nothing.hidden = Boolean(take);
    if (!take) return;
    if (studio.sound !== this.heard || this.player !== studio.player) this.#newLine();
    this.phonemes.taken();
    const opened = new Set([...this.values.opened, ...this.bends.uneven(take)]);
    const rows = movingRows(take, other, opened), picked = this.timeline.shown?.rows[this.timeline.row];
    this.timeline.show({ take, other, sound, rows });
    this.values.show(take, rows);
    this.pick(picked === undefined ? -1 : rows.indexOf(picked));
    this.swapButton.hidden = !studio.other;
    this.swapButton.setAttribute("aria-pressed", String(this.swapped));
    if (studio.portrait) studio.portrait.take = take;
    this.#legend();
    this.#levels();
    this.#parts();
    this.#leftOut(take.data.spoken.left_out);
    this.at.canvas.setAttribute(
      "aria-label",
      `Timeline of: ${take.data.spoken.title}. ` +
        "Brackets choose a boundary, and arrows move it. The values are beside it.",
    );
    this.at.figures.ariaBusy = "true";
    clearTimeout(this.later);
    this.later = setTimeout(() => this.#check(), CHECK_LATER);
    this.moved = true;
    studio.wake();
  }

  /** List the words that the aligner left out. @param {string[]} words */
  #leftOut(words) {
    const { leftOut } = this.at;
    leftOut.hidden = !words.length;
    const why = made("p", { class: "note" }, "Not heard in the sound, so the mouth does not say them.");
    leftOut.replaceChildren(made("h2", "Words left out"), why, ...words.map((word, number) => {
      const title = `Put '${word}' in asterisks, so that it is always spoken, and align the line again`;
      const say = button("It is spoken", title, () => this.#say(word, number));
      return made("p", { class: "row" }, made("bdi", word), say);
    }));
  }

  /** @param {string} word @param {number} number of it among those that are left out */
  #say(word, number) {
    const { studio } = this, { take } = studio;
    return studio.busy(async () => {
      await studio.perform(`say/${number}`, { title: `Say '${word}'` });
      if (studio.take !== take) studio.tell(`'${word}' is spoken now. Save keeps it.`); // a refusal is told already
    }, "Aligning the line again");
  }

  /** Forget what belongs to the line before. */
  #newLine() {
    this.heard = this.studio.sound;
    this.player = this.studio.player;
    this.timeline.shown = null;
    this.overview.shape = [];
    this.timeline.boundary = this.timeline.word = this.timeline.phoneme = -1;
    this.phonemes.dragging = false;
    this.bends.chosen = this.gestures.chosen = null;
    this.labelled = false;
    this.open = new Set(this.tracks().filter((one) => typeof one.level !== "number").map(keyOf));
  }

  async #check() {
    const { take } = this.studio;
    if (!take || this.phonemes.dragging || this.swapped || this.studio.view !== this) return;
    await this.studio.attempt(async () => {
      const { figures } = await this.studio.api.get("figures");
      if (this.studio.take !== take) return;
      take.data.figures = figures;
      listFigures(this.at, figures, (seconds) => {
        this.studio.player.pause();
        this.reveal(seconds);
      });
      this.at.figures.ariaBusy = "false";
      this.timeline.stale = true;
      this.studio.wake();
    });
  }

  #draw() {
    const { player } = this.studio, seconds = player.time, [take] = this.shown;
    if (!take || !this.timeline.shown) return;
    if (player.playing) this.timeline.follow(seconds);
    if (this.timeline.loop !== player.loop) [this.timeline.loop, this.timeline.stale] = [player.loop, true];
    if (this.moved) this.#stretch();
    this.timeline.draw(seconds);
    this.overview.draw(seconds);
    if (this.moved) {
      this.lanes.draw();
      this.gestures.lane.draw();
    }
    this.moved = false;
    this.values.draw(take.frameAt(seconds), player.playing);
  }

  /** Give the poses the available room. */
  #stretch() {
    const { timeline, at } = this, room = /** @type {HTMLElement} */ (at.canvas.parentElement);
    if (timeline.narrow || getComputedStyle(room).overflowY !== "auto") {
      timeline.tall = 0;
      return;
    }
    const beside = [at.legend, at.lanes, at.gestures, at.overview];
    const used = beside.reduce((sum, one) => sum + one.offsetHeight, timeline.top + BELOW);
    timeline.tall = Math.max(
      ROW,
      Math.min(MOST_ROW, Math.floor((room.clientHeight - used) / Math.max(1, timeline.line.rows.length))),
    );
  }

  /** @param {number} seconds to go to, and to bring into view */
  reveal(seconds) {
    this.studio.seek(seconds);
    if (seconds < this.timeline.from || seconds > this.timeline.to) this.timeline.follow(seconds);
  }

  /** @param {number} row of the timeline; -1 for none */
  pick(row) {
    const most = (this.timeline.shown?.rows.length ?? 0) - 1;
    this.timeline.row = Math.max(-1, Math.min(most, row));
    this.timeline.stale = true;
    this.values.pick(this.timeline.row);
    this.studio.wake();
  }

  /** Choose the picture of the sound. @param {"wave" | "spectrogram" | "both"} [name] the next unless given */
  picture(name) {
    const { timeline } = this, next = PICTURES.findIndex(([one]) => one === timeline.sounds) + 1;
    timeline.sounds = name ?? PICTURES[next % PICTURES.length][0];
    this.pictures.forEach((one, n) => one.setAttribute("aria-pressed", String(PICTURES[n][0] === timeline.sounds)));
    timeline.stale = this.moved = true;
    this.studio.wake();
  }

  swap() {
    if (!this.studio.other) return;
    this.swapped = !this.swapped;
    this.#take();
  }

  nextFinding() {
    const times = findingTimes(this.studio.take?.data.figures ?? []);
    const next = times.find((one) => one > this.studio.player.time + 0.01) ?? times[0];
    this.studio.player.pause();
    if (next === undefined) this.studio.tell("The check found nothing in this line");
    else this.reveal(next);
  }

  // Bigrams

  /** @param {import("../payloads.js").Bigram} bigram @returns {HTMLElement} */
  #opener(bigram) {
    const pair = bigram.drawn_as ?? bigram.pair,
      one = button(`Open bigram ${pair}`, { class: "open-bigram" }, () => this.studio.go("bigrams", pair));
    return one;
  }

  /** @param {number} seconds @param {number} row opens the bigram that gives most to the pose, else the nearest one */
  openBigram(seconds, row) {
    const { take } = this.studio, name = this.timeline.line.rows[row];
    if (!take) return;
    const frame = take.frameAt(seconds), { making } = take.data, found = take.bigramsAt(frame);
    const moving = making?.moving.indexOf(take.rows.get(name)?.pose ?? -1) ?? -1;
    const given = (/** @type {import("../payloads.js").PlacedBigram} */ one) =>
      (making && moving >= 0 ? making.given[one.side][moving][frame] : 0) - Math.abs(one.position - 0.5);
    const most = found.toSorted((a, b) => given(b) - given(a))[0];
    if (most) this.studio.go("bigrams", most.drawn_as ?? most.pair);
    else this.studio.tell("No bigram covers this moment");
  }

  // Phonemes and words

  /**
   * @param {{boundary?: number, word?: number, phoneme?: number, until?: number,
   *   gesture?: import("../timeline/gesture_places.js").Shown | null}} what is chosen; the rest no longer is
   * @param {boolean} [heard] once, as well
   */
  choose({ boundary = -1, word = -1, phoneme = -1, until = phoneme, gesture = null }, heard = false) {
    if (heard) this.studio.hear({ word, phoneme });
    this.bends.chosen = null;
    this.gestures.chosen = gesture;
    Object.assign(this.timeline, { boundary, word, phoneme, until });
    this.timeline.stale = true;
    this.#levels();
    if (phoneme >= 0 && !this.labelled) this.#offerLabels();
    this.studio.wake();
  }

  /** Ask for the labels of the line's notation, once. */
  async #offerLabels() {
    this.labelled = true;
    await this.studio.attempt(async () => this.phonemePanel.offer((await this.studio.api.get("labels")).labels));
  }

  restore() {
    this.studio.perform("original");
  }

  // Delivery

  /** @returns {Track[]} every region and style, with its level */
  tracks() {
    const { state, settings } = this.studio;
    const level = (/** @type {"dials" | "styles"} */ kind, /** @type {string} */ name, /** @type {number} */ usual) =>
      settings[kind]?.[name] ?? usual;
    return [
      ...Object.keys(state.regions ?? {}).map(
        (name) => /** @type {Track} */ ({ kind: "dials", name, level: level("dials", name, 1), most: 2, usual: 1 }),
      ),
      ...(state.styles ?? []).map(
        (/** @type {string} */ name) =>
          /** @type {Track} */ ({ kind: "styles", name, level: level("styles", name, 0), most: 1, usual: 0 }),
      ),
    ];
  }

  #levels() {
    const { take, settings, sound } = this.studio, tracks = this.tracks(), { word } = this.timeline;
    if (!take) return;
    const { times, words, emphasis } = take.data.spoken, chosen = words[word];
    this.panel.show(
      tracks,
      settings,
      chosen ? { text: chosen[0], emphasis: emphasis[word], from: times[chosen[1]], to: times[chosen[2]] } : null,
      Boolean(sound),
    );
    this.phonemePanel.show(this.phonemes.chosen);
    this.lanes.show(tracks.filter((one) => this.open.has(keyOf(one))));
    this.gestures.show();
  }

  /** @param {Track} track */
  #openTrack(track) {
    const key = keyOf(track);
    if (this.open.has(key)) this.open.delete(key);
    else this.open.add(key);
    this.#levels();
  }

  /** @param {Track} track @param {Level | undefined} level undefined puts it back as usual @param {boolean} done */
  setLevel(track, level, done) {
    const { settings } = this.studio, levels = { ...settings[track.kind] };
    if (level === undefined) this.open.delete(keyOf(track));
    else if (typeof level !== "number") this.open.add(keyOf(track));
    if (level === undefined || level === track.usual) delete levels[track.name];
    else levels[track.name] = level;
    this.set({ ...settings, [track.kind]: levels }, track.name, done);
  }

  /** @param {Track} track @param {number} value @param {boolean} done */
  #setWord(track, value, done) {
    const { take } = this.studio, own = this.tracks().find((one) => keyOf(one) === keyOf(track));
    const { times, words } = take?.data.spoken ?? { times: [], words: [] }, word = words[this.timeline.word];
    if (!take || !own || !word) return;
    this.wordBefore ??= own.level;
    this.setLevel(own, withWord(this.wordBefore, times[word[1]], times[word[2]], value, take.start, take.end), done);
    if (done) this.wordBefore = undefined;
  }

  /**
   * @param {import("../payloads.js").Settings} settings
   * @param {string} title of the step in undo
   * @param {boolean} done
   */
  set(settings, title, done) {
    if (!done && JSON.stringify(settings) === JSON.stringify(this.studio.settings)) return;
    this.studio.settings = settings;
    this.#levels();
    this.studio.perform("take", { settings, title, passing: !done });
  }

  /** @param {number} level of the chosen word @param {boolean} done */
  emphasise(level, done) {
    const { word } = this.timeline, { take } = this.studio;
    if (!take || word < 0) return;
    const title = `Emphasis of ${take.data.spoken.words[word][0]}`;
    this.studio.perform(`emphasis/${word}`, { level, title, passing: !done });
  }

  // What is said in words

  #legend() {
    const [take, other] = this.shown;
    if (!take) return;
    listStages(this.at.legend, take, other);
    usedStages(take).forEach((stage, n) => {
      const item = this.at.legend.children[n],
        one = button(
          item.textContent ?? "",
          { "aria-pressed": String(!this.timeline.hidden.has(stage.name)), title: stage.why || stage.label },
          () => {
            if (!this.timeline.hidden.delete(stage.name)) this.timeline.hidden.add(stage.name);
            one.setAttribute("aria-pressed", String(!this.timeline.hidden.has(stage.name)));
            this.timeline.stale = true;
            this.studio.wake();
          },
        );
      item.replaceChildren(one);
    });
  }

  /** A line of hours is shown in parts. */
  #parts() {
    const { part } = this.studio, { parts } = this.at;
    parts.hidden = !part;
    if (!part) return;
    const turn = (/** @type {string} */ text, /** @type {string} */ name, /** @type {number} */ to) =>
      actButton(text, name, () => this.studio.openLine(`part/${to}`, {}), to < 0 || to >= part.count);
    parts.replaceChildren(
      turn("◂", "Previous part", part.number - 1),
      made("span", `part ${part.number + 1} of ${part.count} (the line lasts ${clock(part.seconds, 0)})`),
      turn("▸", "Next part", part.number + 1),
    );
  }
}

/** @param {Track} track @returns {string} */
function keyOf(track) {
  return `${track.kind} ${track.name}`;
}
