/** Hands on the gestures of a line: they are added, moved, scaled and taken away in their lane. */

import { GestureLane } from "../timeline/gesture_lane.js";
import {
  placedAt,
  shownGestures,
  withMovedGesture,
  withoutGesture,
  withScaledGesture,
  wordStarts,
} from "../timeline/gesture_places.js";
import { snappedTo } from "../timeline/onsets.js";
import { GesturePanel, MOST_SCALE } from "./gesture_panel.js";

/** Pixels within which a gesture snaps to the beginning of a word. */
const SNAP = 6;

/** @typedef {import("../timeline/gesture_places.js").Shown} Shown */
/** @typedef {import("../payloads.js").GestureByHand} ByHand */

/** Gestures of the line in a sentence view. */
export class GestureHands {
  /** @param {import("./sentence_view.js").SentenceView} view @param {HTMLElement} lane @param {HTMLElement} panel */
  constructor(view, lane, panel) {
    this.view = view;
    this.studio = view.studio;
    /** The chosen gesture; an edit or another tab may have changed it. @type {Shown | null} */
    this.chosen = null;
    /** Gestures by hand before a drag. @type {ByHand[] | null} */
    this.before = null;
    this.lane = new GestureLane(lane, view.timeline, this);
    this.panel = new GesturePanel(panel, this);
  }

  get #placed() {
    return this.studio.settings.placed ?? [];
  }

  get #spoken() {
    const { spoken, gestures } = /** @type {import("../line/take.js").Take} */ (this.studio.take).data;
    return { ...spoken, first: gestures?.first };
  }

  show() {
    const { take } = this.studio, gestures = this.view.swapped ? null : take?.data.gestures;
    this.lane.place.hidden = !gestures;
    const every = gestures ? shownGestures(gestures, this.#placed, this.#spoken) : [], now = this.chosen;
    this.chosen = (now && every.find((one) => one.name === now.name
      && (now.hand < 0 ? one.hand < 0 && Math.abs(one.at - now.at) < 1e-3 : one.hand === now.hand))) ?? null;
    this.lane.show(every, this.chosen, gestures?.kinds.map((kind) => kind.name) ?? []);
    this.panel.show(this.chosen);
  }

  /** @param {Shown | null} gesture */
  choose(gesture) {
    this.view.choose({ gesture });
  }

  /** @param {number} [seconds] unless given, the chosen word or the playhead */
  add(seconds) {
    const { take, player } = this.studio, name = this.lane.kind.value, { word } = this.view.timeline;
    if (!take || !name || this.view.swapped) {
      this.studio.tell("This face has no gestures here");
      return;
    }
    const at = seconds ?? wordStarts(this.#spoken)[word] ?? player.time;
    const one = placedAt(name, at, 1, this.#spoken), hand = this.#placed.length;
    this.#set([...this.#placed, one], hand, name, at, `Add ${name}`, true);
    this.choose(this.chosen);
  }

  /** @param {Shown} own @param {number} to @param {boolean} done @param {boolean} free of the beginnings of words */
  move(own, to, done, free) {
    const { timeline } = this.view;
    this.before ??= this.#placed;
    const most = timeline.at(SNAP) - timeline.at(0);
    const at = free ? to : snappedTo(to, wordStarts(this.#spoken), most);
    const inside = Math.min(Math.max(at, timeline.start), timeline.end);
    const [placed, hand] = withMovedGesture(this.before, own, inside, this.#spoken);
    this.#set(placed, hand, own.name, inside, `Move ${own.name}`, done);
    this.studio.dragged(!done);
    if (done) this.before = null;
  }

  /** @param {Shown} own @param {number} scale @param {boolean} [done] */
  scale(own, scale, done = true) {
    const kept = Math.min(MOST_SCALE, Math.max(0, scale));
    const [placed, hand] = withScaledGesture(this.#placed, own, kept, this.#spoken);
    this.#set(placed, hand, own.name, own.at, `Scale ${own.name}`, done);
  }

  /** Delete a gesture, or the chosen one. @param {Shown | null} own @returns {boolean} false if there is none */
  remove(own = this.chosen) {
    if (own) {
      const [placed, hand] = withoutGesture(this.#placed, own, this.#spoken);
      this.#set(placed, hand, own.name, own.at, `Delete ${own.name}`, true);
    }
    return own !== null;
  }

  /**
   * @param {ByHand[]} placed @param {number} hand that is chosen then @param {string} name @param {number} at
   * @param {string} title of the step @param {boolean} done
   */
  #set(placed, hand, name, at, title, done) {
    this.chosen = { name, at, hand, begin: at, end: at, scale: 1, why: "" };
    this.view.set({ ...this.studio.settings, placed }, title, done);
  }
}
