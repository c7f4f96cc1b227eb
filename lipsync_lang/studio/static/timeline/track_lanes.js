/** Tracks of a line above its timeline: points of seconds and level, dragged, added and deleted. */

import { drawn } from "../shell/drawings.js";
import { button, made } from "../shell/elements.js";
import { levelAt, movedPoint, pointsOf, withoutPoint, withPoint } from "./level_points.js";

const TALL = 46, PAD = 7, DOT = 5;
/** Pixels around a point in which a pointer takes it. */
const REACH = 11;
/** Steps of a point moved by keys: seconds and value. */
const STEP = [0.01, 0.05];

/** @typedef {import("./level_points.js").Level} Level */
/** @typedef {{kind: "dials" | "styles", name: string, level: Level, most: number, usual: number}} Track */

/** Lanes of tracks that share the time axis of a timeline. */
export class TrackLanes {
  /**
   * @param {HTMLElement} place
   * @param {import("./timeline.js").Timeline} timeline
   * @param {{set: (track: Track, level: Level | undefined, done: boolean) => void}} does without a level the track is
   *   taken away
   */
  constructor(place, timeline, does) {
    this.place = place;
    this.timeline = timeline;
    this.does = does;
    /** @type {{track: Track, svg: SVGElement}[]} */
    this.lanes = [];
    /** The point that is dragged or chosen. */
    this.which = -1;
    this.dragging = false;
  }

  /** @param {Track[]} tracks */
  show(tracks) {
    const same =
      tracks.length === this.lanes.length &&
      tracks.every((one, n) => one.name === this.lanes[n].track.name && one.kind === this.lanes[n].track.kind);
    if (same) tracks.forEach((one, n) => { this.lanes[n].track = one; });
    else this.#build(tracks);
    this.draw();
  }

  /** @param {Track[]} tracks */
  #build(tracks) {
    this.lanes = tracks.map((track) => ({
      track,
      svg: drawn("svg", { role: "group", "aria-label": `Track of ${track.name}`, height: TALL, tabindex: "-1" }),
    }));
    this.place.replaceChildren(...this.lanes.map((lane) => {
      const away = button(
        "×",
        { title: "Remove this track", "aria-label": `Remove the track of ${lane.track.name}` },
        () => this.does.set(lane.track, undefined, true),
      );
      this.#listen(lane);
      return made(
        "div",
        { class: "lane" },
        made(
          "span",
          { class: "lane-name" },
          made("span", { dir: "auto", title: lane.track.name }, lane.track.name),
          away,
        ),
        lane.svg,
      );
    }));
  }

  draw() {
    const { timeline } = this;
    if (!timeline.shown) return;
    this.place.style.setProperty("--left", `${this.#left}px`);
    this.place.classList.toggle("narrow", timeline.narrow);
    for (const { track, svg } of this.lanes) {
      const wide = this.#wide, level = pointsOf(track.level, timeline.start, timeline.end);
      const at = level.map(([seconds, value]) => [this.#x(seconds), this.#y(track, value)]);
      const path = [
        [0, this.#y(track, levelAt(track.level, timeline.at(this.#left)))],
        ...at.filter(([x]) => x > 0 && x < wide),
        [wide, this.#y(track, levelAt(track.level, timeline.to))],
      ]
        .map((one) => one.map((n) => n.toFixed(1)).join(","))
        .join(" ");
      const focused =
        document.activeElement instanceof SVGElement && svg.contains(document.activeElement)
          ? Number(document.activeElement.dataset.point)
          : -1;
      svg.setAttribute("width", String(wide));
      svg.replaceChildren(
        drawn("line", {
          class: "usual",
          x1: 0,
          x2: wide,
          y1: this.#y(track, track.usual),
          y2: this.#y(track, track.usual),
        }),
        drawn("polygon", { class: "area", points: `0,${TALL} ${path} ${wide},${TALL}` }),
        drawn("polyline", { class: "level", points: path }),
        ...(typeof track.level === "number" ? [] : track.level.map((one, n) => this.#dot(track, one, n))),
      );
      if (focused >= 0)
        /** @type {SVGElement | null} */ (svg.querySelector(`[data-point="${focused}"]`))?.focus({
          preventScroll: true,
        });
    }
  }

  /** @param {Track} track @param {[number, number]} point @param {number} n */
  #dot(track, [seconds, value], n) {
    return drawn("circle", {
      cx: this.#x(seconds),
      cy: this.#y(track, value),
      r: DOT,
      "data-point": n,
      tabindex: 0,
      role: "slider",
      "aria-label": `${track.name} at ${seconds.toFixed(2)} s`,
      "aria-valuenow": value,
      "aria-valuemin": 0,
      "aria-valuemax": track.most,
    });
  }

  get #left() {
    return this.timeline.narrow ? 0 : this.timeline.left;
  }

  get #wide() {
    return Math.max(50, this.timeline.wide - this.#left);
  }

  /** @param {number} seconds */
  #x(seconds) {
    return this.timeline.x(seconds) - this.#left;
  }

  /** @param {Track} track @param {number} value */
  #y(track, value) {
    return PAD + (1 - value / track.most) * (TALL - 2 * PAD);
  }

  /** @param {{track: Track, svg: SVGElement}} lane */
  #listen(lane) {
    const { svg } = lane;
    const place = (/** @type {PointerEvent | MouseEvent} */ event) => {
      const box = svg.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      const value = (1 - (y - PAD) / (TALL - 2 * PAD)) * lane.track.most;
      return {
        x,
        y,
        point: /** @type {[number, number]} */ ([
          this.timeline.at(x + this.#left),
          Math.min(Math.max(value, 0), lane.track.most),
        ]),
      };
    };
    svg.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      event.preventDefault();
      svg.setPointerCapture(event.pointerId);
      const { x, y, point } = place(event), { track } = lane;
      let points = pointsOf(track.level, this.timeline.start, this.timeline.end);
      this.which =
        typeof track.level === "number"
          ? -1
          : points.findIndex(([at, value]) => Math.hypot(this.#x(at) - x, this.#y(track, value) - y) < REACH);
      this.dragging = true;
      if (this.which < 0) {
        [points, this.which] = withPoint(points, point);
        this.does.set(track, points, false);
      }
      const handle = /** @type {SVGElement | null} */ (svg.querySelector(`[data-point="${this.which}"]`));
      handle?.focus({ preventScroll: true });
    });
    svg.addEventListener("pointermove", (event) => {
      if (!this.dragging || !svg.hasPointerCapture(event.pointerId) || typeof lane.track.level === "number") return;
      this.does.set(lane.track, movedPoint(lane.track.level, this.which, place(event).point, lane.track.most), false);
    });
    for (const name of ["pointerup", "pointercancel"]) svg.addEventListener(name, () => {
      if (this.dragging) this.does.set(lane.track, lane.track.level, true);
      this.dragging = false;
    });
    svg.addEventListener("dblclick", () => this.#delete(lane.track));
    svg.addEventListener("keydown", (event) => this.#key(lane.track, event));
    svg.addEventListener("focusin", (event) => {
      if (event.target instanceof SVGElement && event.target.dataset.point)
        this.which = Number(event.target.dataset.point);
    });
  }

  /** @param {Track} track */
  #delete(track) {
    if (typeof track.level === "number" || this.which < 0) return;
    this.does.set(track, withoutPoint(track.level, this.which), true);
    this.which = -1;
  }

  /** @param {Track} track @param {KeyboardEvent} event */
  #key(track, event) {
    const [seconds, value] = STEP.map((one) => one * (event.shiftKey ? 5 : 1));
    const by = { ArrowLeft: [-seconds, 0], ArrowRight: [seconds, 0], ArrowUp: [0, value], ArrowDown: [0, -value] }[
      event.key
    ];
    if (typeof track.level === "number" || this.which < 0 || event.ctrlKey || event.metaKey) return;
    if (by) {
      const [at, now] = track.level[this.which];
      this.does.set(track, movedPoint(track.level, this.which, [at + by[0], now + by[1]], track.most), true);
    } else if (event.key === "Delete" || event.key === "Backspace") this.#delete(track);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}
