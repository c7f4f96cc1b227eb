/** Lane of gestures under a timeline: a row for each kind, with a bar for each gesture at its time. */

import { drawn } from "../shell/drawings.js";
import { button, made } from "../shell/elements.js";

const ROW = 18, PAD = 3;
/** Height of a bar without a scale, and what a scale of 1 adds. */
const LEAST = 6, MORE = 5;
/** Pixels after which a press on a gesture moves it. */
const SLACK = 4;
/** Steps by keys: seconds and scale. */
const STEP = [0.01, 0.05];

/** @typedef {import("./gesture_places.js").Shown} Shown */
/**
 * @typedef {object} GestureLaneHands
 * @property {(gesture: Shown | null) => void} choose
 * @property {(gesture: Shown, seconds: number, done: boolean, free: boolean) => void} move `free` of the words
 * @property {(gesture: Shown, scale: number) => void} scale
 * @property {(gesture: Shown) => boolean} remove
 * @property {(seconds?: number) => void} add the kind that is picked, here or where the hand is
 */

export class GestureLane {
  /** @param {HTMLElement} place @param {import("./timeline.js").Timeline} timeline @param {GestureLaneHands} does */
  constructor(place, timeline, does) {
    this.place = place;
    this.timeline = timeline;
    this.does = does;
    /** @type {Shown[]} */
    this.gestures = [];
    /** @type {Shown | null} */
    this.chosen = null;
    /** The pressed gesture as it was, and the press. @type {{own: Shown, x: number, moved: boolean} | null} */
    this.pressed = null;
    this.svg = drawn("svg", { role: "group", "aria-label": "Gestures", tabindex: "-1" });
    this.kind = made("select", { "aria-label": "Gesture to add" });
    const add = button(
      "+",
      {
        title: "Add this gesture at the chosen word, or at the playhead (T); a double click adds it there",
        "aria-label": "Add the gesture",
      },
      () => does.add(),
    );
    const name = made("span", { class: "lane-name" }, this.kind, add);
    place.append(made("div", { class: "gesture-lane" }, name, this.svg));
    this.#listen();
  }

  /** @param {Shown[]} gestures @param {Shown | null} chosen @param {string[]} kinds that may be added */
  show(gestures, chosen, kinds) {
    [this.gestures, this.chosen] = [gestures, chosen];
    if (kinds.join() !== [...this.kind.options].map((one) => one.value).join())
      this.kind.replaceChildren(...kinds.map((one) => made("option", { value: one }, one)));
    this.draw();
  }

  draw() {
    const { timeline, svg } = this;
    if (!timeline.shown || this.place.hidden) return;
    const left = timeline.narrow ? 0 : timeline.left;
    this.place.style.setProperty("--left", `${left}px`);
    this.place.classList.toggle("narrow", timeline.narrow);
    const used = new Set(this.gestures.map((one) => one.name));
    const names = [...this.kind.options].map((one) => one.value).filter((name) => used.has(name));
    const { activeElement } = document;
    const focused = activeElement instanceof SVGElement && svg.contains(activeElement);
    svg.setAttribute("width", String(Math.max(50, timeline.wide - left)));
    svg.setAttribute("height", String(Math.max(1, names.length) * ROW + 2 * PAD));
    svg.replaceChildren(...this.gestures.map((one, n) => this.#bar(one, n, names.indexOf(one.name), left)));
    if (focused) /** @type {SVGElement | null} */ (svg.querySelector(".chosen"))?.focus({ preventScroll: true });
  }

  /** @param {Shown} own @param {number} n @param {number} row @param {number} left */
  #bar(own, n, row, left) {
    const { timeline } = this, x = timeline.x(own.begin) - left, middle = PAD + (row + 0.5) * ROW;
    const tall = LEAST + MORE * (own.scale || 1), wide = Math.max(6, timeline.x(own.end) - left - x);
    const as = own.scale ? (own.hand < 0 ? "ruled" : "hand") : "silent";
    return drawn("g", {
      class: `gesture ${as}${own === this.chosen ? " chosen" : ""}`,
      "data-gesture": n,
      tabindex: 0,
      role: "slider",
      "aria-label": own.name,
      "aria-valuenow": own.at.toFixed(3),
      "aria-valuemin": timeline.start,
      "aria-valuemax": timeline.end,
      "aria-valuetext": `${own.at.toFixed(2)} s, scale ${own.scale.toFixed(2)}, ${own.why}`,
    },
    drawn("title", {}, own.why),
    drawn("rect", { x, y: middle - tall / 2, width: wide, height: tall, rx: 3 }),
    drawn("text", { x: x + 4, y: middle + 4 }, own.name));
  }

  /** @param {Event} event @returns {Shown | undefined} the gesture under a pointer, or with the focus */
  #at({ target }) {
    const bar = /** @type {SVGElement} */ (target).closest("[data-gesture]");
    return this.gestures[Number(bar?.getAttribute("data-gesture") ?? -1)];
  }

  #listen() {
    const { svg, does, timeline } = this;
    svg.addEventListener("pointerdown", (event) => {
      const own = this.#at(event);
      if (event.button) return;
      event.preventDefault();
      svg.setPointerCapture(event.pointerId);
      this.pressed = own ? { own, x: event.clientX, moved: false } : null;
      does.choose(own ?? null);
      /** @type {SVGElement | null} */ (svg.querySelector(".chosen"))?.focus({ preventScroll: true });
    });
    const drag = (/** @type {PointerEvent} */ event, /** @type {boolean} */ done) => {
      const { pressed } = this;
      if (!pressed) return;
      const across = event.clientX - pressed.x;
      pressed.moved ||= Math.abs(across) > SLACK;
      const seconds = pressed.own.at + timeline.at(across) - timeline.at(0);
      if (pressed.moved) does.move(pressed.own, seconds, done, event.altKey);
      if (done) this.pressed = null;
    };
    svg.addEventListener("pointermove", (event) => drag(event, false));
    for (const name of /** @type {const} */ (["pointerup", "pointercancel"]))
      svg.addEventListener(name, (event) => drag(event, true));
    svg.addEventListener("dblclick", (event) => {
      const left = timeline.narrow ? 0 : timeline.left;
      if (!this.#at(event)) does.add(timeline.at(event.clientX - svg.getBoundingClientRect().left + left));
    });
    svg.addEventListener("focusin", (event) => {
      const own = this.#at(event);
      if (own && own !== this.chosen) does.choose(own);
    });
    svg.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const own = this.#at(event), [seconds, scale] = STEP.map((one) => one * (event.shiftKey ? 5 : 1));
    if (!own || event.ctrlKey || event.metaKey || event.altKey) return;
    const by = { ArrowLeft: -seconds, ArrowRight: seconds }[event.key];
    const grown = { ArrowUp: scale, ArrowDown: -scale }[event.key];
    if (by) this.does.move(own, own.at + by, true, true);
    else if (grown) this.does.scale(own, own.scale + grown);
    else if (event.key === "Delete" || event.key === "Backspace") this.does.remove(own);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}
