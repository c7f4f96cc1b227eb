/** Hands on the phonemes of a line: boundaries and words are moved, labels changed, split and joined. */

import { onsets, snappedTo } from "../timeline/onsets.js";

/** Pixels within which a boundary snaps to an onset of the sound. */
const SNAP = 7;
/** Seconds that a part of a split phoneme has at least. */
const LEAST = 0.005;

/** @typedef {import("../timeline/timeline_hands.js").Grab} Grab */

/** Changes of the phonemes of the line in a sentence view. */
export class PhonemeHands {
  /** @param {import("./sentence_view.js").SentenceView} view */
  constructor(view) {
    this.view = view;
    this.studio = view.studio;
    /** Sounds after a boundary move along, up to the next pause. */
    this.ripple = false;
    /** Boundaries snap to the onsets of the sound. */
    this.snap = true;
    this.dragging = false;
    this.dragTimes = [0];
    /** Place of the playhead before a drag, to which it returns. */
    this.timeBefore = 0;
    /** Times of boundaries that were asked for, until the take with them is here. @type {Map<number, number>} */
    this.sought = new Map();
    /** @type {{sound: import("../line/player.js").Sound | null, onsets: number[]}} */
    this.heard = { sound: null, onsets: [] };
  }

  /** Forget what is no longer asked for. */
  taken() {
    for (const boundary of this.sought.keys())
      if (!this.studio.wishes.has(`boundary/${boundary}`)) this.sought.delete(boundary);
  }

  /**
   * Move a boundary, or a word. Shift turns the ripple round, and Alt the snap.
   * @param {Grab} grab @param {number} seconds @param {boolean} done @param {PointerEvent} event
   */
  drag(grab, seconds, done, event) {
    const { take } = this.studio, { boundary, word } = grab;
    if (!take || this.view.swapped) return;
    if (!this.dragging) {
      this.dragging = true;
      this.dragTimes = [...take.data.spoken.times];
      this.timeBefore = this.studio.player.time;
      this.view.choose(word < 0 ? { boundary } : { word });
      if (!done) return; // pressed, not moved yet
    }
    const to = this.snap !== event.altKey ? this.#snapped(seconds) : seconds;
    const through = word < 0 && this.ripple !== event.shiftKey ? this.#beforePause(boundary) : grab.through;
    if (Math.abs(to - this.dragTimes[boundary]) > 1e-4 || !done) this.#move(boundary, through, to, !done);
    if (!this.studio.player.playing) this.studio.seek(done ? this.timeBefore : to);
    this.dragging = !done;
  }

  /** @param {number} seconds */
  #snapped(seconds) {
    const { sound } = this.studio, { timeline } = this.view;
    if (this.heard.sound !== sound) {
      const found = sound ? onsets(sound.samples, sound.rate) : [];
      this.heard = { sound, onsets: found.map((one) => one + (sound?.start ?? 0)) };
    }
    return snappedTo(seconds, this.heard.onsets, timeline.at(SNAP) - timeline.at(0));
  }

  /** @param {number} boundary @returns {number} the start of the pause after it, or the end of the line */
  #beforePause(boundary) {
    const { data } = /** @type {import("../line/take.js").Take} */ (this.studio.take), { making, spoken } = data;
    const rest = this.studio.state.phonemes?.[0] ?? "_";
    const sounds = new Set(making?.source.filter((_, n) => making.common[n] !== rest));
    const pause = spoken.labels.findIndex((_, n) => n >= boundary && !sounds.has(n));
    return pause < 0 ? spoken.times.length - 1 : pause;
  }

  /**
   * @param {number} boundary @param {number} through the last that moves along
   * @param {number} seconds @param {boolean} passing @param {string} [merge]
   */
  #move(boundary, through, seconds, passing, merge = "") {
    const { labels, words } = this.studio.take?.data.spoken ?? { labels: [], words: [] };
    const { word } = this.view.timeline, before = `the boundary before ${labels[boundary] ?? "the end"}`;
    const title = `Move ${word < 0 ? before : `the word ${words[word][0]}`}`;
    this.studio.perform(`boundary/${boundary}`, { seconds, through, passing, title, merge });
  }

  /** @param {number} by seconds that the chosen boundary or word is moved */
  nudge(by) {
    const { boundary, word } = this.view.timeline, { take } = this.studio;
    if (!take || (boundary < 0 && word < 0)) return;
    const { times, words } = take.data.spoken, at = word < 0 ? boundary : words[word][1];
    const through = word < 0 ? (this.ripple ? this.#beforePause(at) : at) : words[word][2];
    const to = (this.sought.get(at) ?? times[at]) + by;
    this.sought.set(at, to);
    this.#move(at, through, to, false, `nudge ${at} ${through}`);
    this.studio.seek(to);
  }

  /** @returns {[number, number] | null} the first and the last chosen phoneme, or those of the chosen word */
  get range() {
    const { word, phoneme, until } = this.view.timeline, chosen = this.studio.take?.data.spoken.words[word];
    return phoneme >= 0 ? [phoneme, Math.max(phoneme, until)] : chosen ? [chosen[1], chosen[2] - 1] : null;
  }

  /** Extend the choice to a word or a phoneme. @param {{word?: number, phoneme?: number}} to */
  extend({ word = -1, phoneme = -1 }) {
    const own = this.studio.take?.data.spoken.words[word], now = this.range;
    const [first, last] = own ? [own[1], own[2] - 1] : [phoneme, phoneme];
    this.view.choose({ phoneme: Math.min(first, now?.[0] ?? first), until: Math.max(last, now?.[1] ?? last) });
  }

  /** Find the times of the chosen phonemes again, in their part of the sound. */
  align() {
    const { range } = this;
    if (range) this.studio.perform(`align/${range[0]}`, { count: range[1] - range[0] + 1, title: "Align again" });
    else this.studio.tell("Choose the phonemes or the word to align; Shift and a click choose up to another");
  }

  /** The chosen phoneme with its times. */
  get chosen() {
    const { labels, times } = this.studio.take?.data.spoken ?? { labels: [], times: [] };
    const { phoneme } = this.view.timeline, label = labels[phoneme];
    if (label === undefined) return null;
    return { phoneme, label, start: times[phoneme], end: times[phoneme + 1], last: phoneme + 1 === labels.length };
  }

  /** @param {string} label */
  relabel(label) {
    const { chosen } = this;
    if (chosen && label && label !== chosen.label)
      this.#change(`Relabel ${chosen.label} as ${label}`, chosen.phoneme, 1, [label]);
  }

  /**
   * Give the end of the chosen phoneme, from the playhead, to another.
   * @param {string} [label] its own unless given
   */
  split(label) {
    const { chosen } = this;
    if (!chosen) return;
    const { phoneme, start, end } = chosen, now = this.studio.player.time;
    const at = now > start + LEAST && now < end - LEAST ? now : (start + end) / 2;
    const title = label ? `Insert ${label}` : `Split ${chosen.label}`;
    this.#change(title, phoneme, 1, [chosen.label, label || chosen.label], [at]);
    this.view.choose({ phoneme: phoneme + 1 });
  }

  /** Join the chosen phoneme with the next; its label stays. */
  join() {
    const { chosen } = this;
    if (chosen && !chosen.last) this.#change(`Join ${chosen.label} with the next`, chosen.phoneme, 2, [chosen.label]);
  }

  /** Delete the chosen phoneme; a neighbour in its word takes its time, the one before if it can. */
  remove() {
    const { chosen } = this, { take } = this.studio;
    if (!chosen || !take) return;
    const { labels } = take.data.spoken, { phoneme } = chosen, word = take.wordOf(phoneme);
    const alone = chosen.last || take.wordOf(phoneme + 1) !== word;
    const before = phoneme > 0 && (alone || take.wordOf(phoneme - 1) === word);
    const first = before ? phoneme - 1 : phoneme;
    this.#change(`Delete ${chosen.label}`, first, 2, [labels[before ? phoneme - 1 : phoneme + 1]]);
    this.view.choose({ phoneme: first });
  }

  /**
   * @param {string} title @param {number} first @param {number} count @param {string[]} labels
   * @param {number[]} [times] of the boundaries between them
   */
  #change(title, first, count, labels, times = []) {
    this.studio.perform(`phonemes/${first}`, { count, labels, times, title });
  }
}
