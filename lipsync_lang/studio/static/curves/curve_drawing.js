/** Drawing of curves in SVG: grid, ghosts, boundary, smooth curves over their polygons, points. */

import { valuesAt } from "./bspline.js";
import { chosenPoints, clamp } from "./curve_points.js";
import { drawn } from "../shell/drawings.js";
import { ticks } from "../timeline/scales.js";

/** Pixels around the plot: left, top, right, bottom. */
const MARGIN = [34, 26, 12, 22];
/** Widest view: times, then values; and the closest zoom. */
const WHOLE = [-0.02, 1.02, -0.04, 1.06], CLOSEST = 0.05;
const SAMPLES = 160, COLOURS = 8;
const DASHES = ["", "9 4", "2.5 3.5", "10 3.5 2 3.5"];
/** Markers of a radius of 1. */
const MARKERS = [
  "M-1 0A1 1 0 1 1 1 0A1 1 0 1 1-1 0Z", "M-.9-.9H.9V.9H-.9Z", "M0-1.25L1.25 0L0 1.25L-1.25 0Z",
  "M0-1.2L1.15.85H-1.15Z", "M0 1.2L1.15-.85H-1.15Z", "M-.6-1.1H.6L1.2 0L.6 1.1H-.6L-1.2 0Z",
];

/** @typedef {import("./curve_points.js").Curves} Curves @typedef {import("./bspline.js").Point} Point */
/** @typedef {{kind: "point" | "curve" | "boundary" | "handle" | "plot", pose: string, index: number}} Hit */

/** @param {Element} element @param {Record<string, string | number>} traits */
function put(element, traits) {
  for (const [key, value] of Object.entries(traits)) {
    if (element.getAttribute(key) !== String(value)) element.setAttribute(key, String(value));
  }
}

/** @param {number} index of a pose in its set @param {string} colour its own, or "" */
export function look(index, colour = "") {
  const round = Math.floor(index / COLOURS);
  return {
    colour: colour || `var(--curve-${index % COLOURS})`,
    dash: DASHES[round % DASHES.length],
    marker: MARKERS[(index + round) % MARKERS.length],
  };
}

/** @param {{index: number, colour?: string}} pose @returns {SVGElement} its line and marker, for a list */
export function sample(pose) {
  const { colour, dash, marker } = look(pose.index, pose.colour);
  const icon = drawn(
    "svg",
    { class: "sample", viewBox: "0 0 34 14", "aria-hidden": "true" },
    drawn("path", { d: "M1 7H33", "stroke-dasharray": dash }),
    drawn("path", { d: marker, transform: "translate(17 7) scale(4)" }),
  );
  icon.style.setProperty("--c", colour);
  return icon;
}

/** The picture of an editor. */
export class CurveDrawing {
  /** @param {import("./curve_editor.js").CurveEditor} editor @param {HTMLElement} place */
  constructor(editor, place) {
    this.editor = editor;
    this.view = [...WHOLE];
    this.wide = 0;
    this.high = 0;
    const group = (/** @type {string} */ name) => drawn("g", { class: name, "pointer-events": "none" });
    this.grid = group("grid");
    this.ghosts = group("ghosts");
    this.curves = group("curves");
    this.over = group("over");
    this.boundary = drawn(
      "g",
      {
        class: "boundary",
        "pointer-events": "none",
        tabindex: "0",
        role: "slider",
        "aria-valuemin": "0",
        "aria-valuemax": "1",
      },
      drawn("line"),
      drawn("path", { d: "M-5-8H5V-1L0 5L-5-1Z" }),
    );
    this.now = drawn("line", { class: "now" });
    this.plot = drawn("svg", { class: "inner", overflow: "hidden", "pointer-events": "none" }, this.ghosts, this.now);
    this.svg = drawn(
      "svg",
      { class: "plot", role: "application", "aria-label": "Curves", tabindex: "0" },
      this.grid,
      this.plot,
      this.boundary,
      this.curves,
      this.over,
    );
    /** @type {Map<string, {group: SVGElement, polygon: SVGElement, smooth: SVGElement, points: SVGElement}>} */
    this.pool = new Map();
    /** Paths of curves, with the view that they are for. @type {WeakMap<Point[], [string, string]>} */
    this.paths = new WeakMap();
    this.key = "";
    place.append(this.svg);
    new ResizeObserver(() => this.resize()).observe(this.svg);
  }

  resize() {
    const { width, height } = this.svg.getBoundingClientRect();
    if (!width || (width === this.wide && height === this.high)) return;
    [this.wide, this.high] = [width, height];
    this.draw();
  }

  /** @param {number} time */
  x(time) {
    return MARGIN[0] + ((time - this.view[0]) / (this.view[1] - this.view[0])) * (this.wide - MARGIN[0] - MARGIN[2]);
  }

  /** @param {number} value */
  y(value) {
    return (
      this.high -
      MARGIN[3] -
      ((value - this.view[2]) / (this.view[3] - this.view[2])) * (this.high - MARGIN[1] - MARGIN[3])
    );
  }

  /** @param {number} x @param {number} y pixels @returns {Point} time and value */
  at(x, y) {
    const across = (x - MARGIN[0]) / (this.wide - MARGIN[0] - MARGIN[2]),
      up = (this.high - MARGIN[3] - y) / (this.high - MARGIN[1] - MARGIN[3]);
    return [this.view[0] + across * (this.view[1] - this.view[0]), this.view[2] + up * (this.view[3] - this.view[2])];
  }

  /**
   * Zoom about a place, or move with a factor of 1; the view stays within the whole.
   * @param {number} factor above 1 shows less @param {Point} about
   * @param {number} time @param {number} value by which the view moves
   */
  zoom(factor, about = [0.5, 0.5], time = 0, value = 0) {
    const before = String(this.view);
    for (const axis of [0, 1]) {
      const [low, high] = [WHOLE[2 * axis], WHOLE[2 * axis + 1]], span = this.view[2 * axis + 1] - this.view[2 * axis];
      const length = clamp(span / factor, CLOSEST, high - low);
      const first = about[axis] - ((about[axis] - this.view[2 * axis]) * length) / span + [time, value][axis];
      this.view[2 * axis] = clamp(first, low, high - length);
      this.view[2 * axis + 1] = this.view[2 * axis] + length;
    }
    this.draw();
    return String(this.view) !== before;
  }

  fit() {
    this.view = [...WHOLE];
    this.draw();
  }

  // Drawing

  draw() {
    if (!this.wide) return;
    const { editor } = this;
    this.key = `${this.view}|${this.wide}|${this.high}|${editor.interpolation}`;
    put(this.svg, { viewBox: `0 0 ${this.wide} ${this.high}` });
    const [left, top] = MARGIN;
    const inner = { x: left, y: top, width: this.wide - left - MARGIN[2], height: this.high - top - MARGIN[3] };
    put(this.plot, { ...inner, viewBox: `${inner.x} ${inner.y} ${inner.width} ${inner.height}` });
    this.#drawGrid();
    this.#drawGhosts();
    const shown = editor.shown;
    for (const [pose, { group }] of this.pool) {
      if (shown.includes(pose)) continue;
      group.remove();
      this.pool.delete(pose);
    }
    for (const pose of shown) this.#drawCurve(pose);
    const front = this.pool.get(editor.focus)?.group;
    if (front && front !== this.curves.lastElementChild) this.curves.append(front);
    this.#drawBoundary();
    this.#drawOver();
  }

  #drawGrid() {
    const { view, editor } = this, [left, top] = MARGIN, right = this.wide - MARGIN[2], base = this.high - MARGIN[3];
    const parts = [drawn("rect", { x: left, y: top, width: right - left, height: base - top })];
    const label = (
      /** @type {number} */ x,
      /** @type {number} */ y,
      /** @type {string} */ text,
      /** @type {string} */ anchor,
      kind = "",
    ) => parts.push(drawn("text", { x, y, "text-anchor": anchor, class: kind }, text));
    for (const time of ticks(Math.max(0, view[0]), Math.min(1, view[1]), Math.max(2, (right - left) / 90))) {
      parts.push(drawn("line", { x1: this.x(time), x2: this.x(time), y1: top, y2: base }));
      label(this.x(time), base + 15, String(time), "middle");
    }
    for (const value of ticks(Math.max(0, view[2]), Math.min(1, view[3]), Math.max(2, (base - top) / 50))) {
      parts.push(
        drawn("line", { x1: left, x2: right, y1: this.y(value), y2: this.y(value), class: value === 0 ? "zero" : "" }),
      );
      label(left - 6, this.y(value) + 4, String(value), "end");
    }
    for (const [n, { time, label: sound }] of editor.sounds.entries()) {
      const [from, to] = [time, editor.sounds[n + 1]?.time ?? 1].map((one) => clamp(this.x(one), left, right));
      if (time > view[0] && time < view[1])
        parts.push(drawn("line", { x1: this.x(time), x2: this.x(time), y1: top - 8, y2: base, class: "sound" }));
      if (to - from > 14) label((from + to) / 2, 16, sound, "middle", "sound");
    }
    const [first, second] = editor.sounds.length ? ["", ""] : editor.pair,
      middle = clamp(this.x(editor.boundary), left, right);
    if (first && middle - left > 40) label((left + middle) / 2, 16, first, "middle", "sound");
    if (second && right - middle > 40) label((right + middle) / 2, 16, second, "middle", "sound");
    this.grid.replaceChildren(...parts);
  }

  #drawGhosts() {
    const { editor } = this, parts = [];
    for (const { name, kind, curves } of editor.ghosts) {
      if (!editor.haunting.has(name)) continue;
      for (const pose of editor.visible(Object.keys(curves))) {
        const { colour } = look(editor.indexOf(pose), editor.poses.get(pose)?.colour);
        const path = drawn("path", {
          class: `ghost ${kind} ${pose === editor.focus ? "front" : ""}`,
          d: this.#smooth(curves[pose]),
        });
        path.style.setProperty("--c", colour);
        parts.push(path);
      }
    }
    this.ghosts.replaceChildren(...parts);
  }

  /** @param {Point[]} points @returns {string} a path */
  #smooth(points) {
    const kind = this.editor.interpolation, [known, path] = this.paths.get(points) ?? [];
    if (path && known === this.key) return path;
    const first = points[0][0], last = points[points.length - 1][0];
    const from = clamp(this.view[0], first, last), to = clamp(this.view[1], first, last);
    const inner = points.map(([time]) => time).filter((time) => kind === "linear" && time > from && time < to);
    const times = [
      ...Array.from({ length: SAMPLES }, (_, n) => from + ((to - from) * n) / (SAMPLES - 1)),
      ...inner,
    ].sort((a, b) => a - b);
    const values = valuesAt(points, kind, times);
    const made = times
      .map((time, n) => `${n ? "L" : "M"}${this.x(time).toFixed(1)} ${this.y(values[n]).toFixed(1)}`)
      .join("");
    this.paths.set(points, [this.key, made]);
    return made;
  }

  /** @param {string} pose */
  #drawCurve(pose) {
    const { editor } = this, points = editor.curves[pose], front = pose === editor.focus;
    let item = this.pool.get(pose);
    if (!item) {
      const { colour, dash } = look(editor.indexOf(pose), editor.poses.get(pose)?.colour);
      const [polygon, smooth, marks] = [
        drawn("polyline"),
        drawn("path", { class: "smooth", "stroke-dasharray": dash }),
        drawn("g"),
      ];
      const group = drawn(
        "g",
        { "data-pose": pose },
        drawn("svg", { class: "inner", overflow: "hidden" }, polygon, smooth),
        marks,
      );
      group.style.setProperty("--c", colour);
      item = { group, polygon, smooth, points: marks };
      this.pool.set(pose, item);
      this.curves.append(group);
    }
    put(item.group, { class: front ? "front" : "" });
    put(item.points, { "aria-hidden": String(!front) });
    const inner = item.group.firstElementChild;
    for (const trait of ["x", "y", "width", "height", "viewBox"])
      inner?.setAttribute(trait, this.plot.getAttribute(trait) ?? "");
    put(item.polygon, { points: points.map(([t, v]) => `${this.x(t).toFixed(1)},${this.y(v).toFixed(1)}`).join(" ") });
    put(item.smooth, { d: this.#smooth(points) });
    this.#drawPoints(pose, item.points, front);
  }

  /** @param {string} pose @param {SVGElement} place @param {boolean} front */
  #drawPoints(pose, place, front) {
    const { editor } = this, points = editor.curves[pose], { marker } = look(editor.indexOf(pose));
    while (place.childElementCount > points.length) place.lastElementChild?.remove();
    while (place.childElementCount < points.length) {
      place.append(
        drawn("path", {
          d: marker,
          role: "slider",
          "data-index": place.childElementCount,
          "aria-valuemin": "0",
          "aria-valuemax": "1",
        }),
      );
    }
    points.forEach(([time, value], index) => {
      const chosen = editor.chosen.get(pose)?.has(index) ?? false,
        away = time < this.view[0] || time > this.view[1] || value < this.view[2] || value > this.view[3];
      put(place.children[index], {
        transform: `translate(${this.x(time).toFixed(1)} ${this.y(value).toFixed(1)}) scale(${front ? 5.5 : 3})`,
        class: `point${chosen ? " chosen" : ""}`,
        tabindex: front ? 0 : -1,
        visibility: away ? "hidden" : "visible",
        "aria-label": editor.told(pose, index),
        "aria-valuenow": value.toFixed(3),
        "aria-valuetext": `time ${time.toFixed(2)}, value ${value.toFixed(2)}`,
      });
    });
  }

  #drawBoundary() {
    const { boundary, pair } = this.editor, x = this.x(boundary), [line, grip] = this.boundary.children;
    put(line, { x1: x, x2: x, y1: MARGIN[1], y2: this.high - MARGIN[3] });
    put(grip, { transform: `translate(${x} ${MARGIN[1] - 6})` });
    put(this.boundary, {
      "aria-label": `Boundary: ${pair[0]} ends, ${pair[1]} begins, at ${boundary.toFixed(2)}`,
      "aria-valuenow": boundary.toFixed(3),
      visibility: x < MARGIN[0] - 1 || x > this.wide - MARGIN[2] + 1 ? "hidden" : "visible",
    });
    this.drawNow();
  }

  /** Draw the playhead. */
  drawNow() {
    const { time } = this.editor, x = this.x(time ?? 0);
    put(this.now, {
      x1: x,
      x2: x,
      y1: MARGIN[1],
      y2: this.high - MARGIN[3],
      visibility: time === null ? "hidden" : "visible",
    });
  }

  /** The box around the chosen points with its handles, and the marquee. */
  #drawOver() {
    const { marquee } = this.editor, box = this.box(), parts = [];
    if (box) {
      const [left, right, low, high] = box, [x, y] = [this.x(left), this.y(high)];
      parts.push(
        drawn("rect", {
          class: "box",
          x: x - 10,
          y: y - 10,
          width: this.x(right) - x + 20,
          height: this.y(low) - y + 20,
        }),
      );
      for (const [hx, hy] of this.handles(box))
        parts.push(drawn("rect", { class: "handle", x: hx - 5, y: hy - 5, width: 10, height: 10, rx: 2 }));
    }
    if (marquee) {
      const [x, y, u, v] = marquee;
      parts.push(
        drawn("rect", {
          class: "marquee",
          x: Math.min(x, u),
          y: Math.min(y, v),
          width: Math.abs(u - x),
          height: Math.abs(v - y),
        }),
      );
    }
    this.over.replaceChildren(...parts);
  }

  /** @returns {[number, number, number, number] | null} times and values of the chosen points, if several */
  box() {
    const points = chosenPoints(this.editor.curves, this.editor.chosen).map(({ point }) => point);
    if (points.length < 2) return null;
    const [times, values] = [points.map(([t]) => t), points.map(([, v]) => v)];
    return [Math.min(...times), Math.max(...times), Math.min(...values), Math.max(...values)];
  }

  /**
   * @param {[number, number, number, number]} box
   * @returns {Point[]} handles that scale: the times from the left and the right, the values
   */
  handles([left, right, low, high]) {
    const middle = (this.y(low) + this.y(high)) / 2;
    return [
      [this.x(left) - 10, middle],
      [this.x(right) + 10, middle],
      [(this.x(left) + this.x(right)) / 2, this.y(high) - 10],
    ];
  }

  /**
   * Find what lies under a pointer: a point of the pose in front before others.
   * @param {number} x @param {number} y pixels @param {number} reach in pixels
   * @returns {Hit}
   */
  hit(x, y, reach) {
    const { editor } = this, box = this.box();
    /** @type {Hit} */
    let best = { kind: "plot", pose: "", index: -1 };
    let least = reach;
    for (const pose of editor.shown) {
      editor.curves[pose].forEach(([time, value], index) => {
        const far = Math.hypot(this.x(time) - x, this.y(value) - y) * (pose === editor.focus ? 0.6 : 1);
        if (far < least) [best, least] = [{ kind: "point", pose, index }, far];
      });
    }
    if (best.kind === "point") return best;
    const handle = box ? this.handles(box).findIndex(([hx, hy]) => Math.hypot(hx - x, hy - y) < reach) : -1;
    if (handle >= 0) return { kind: "handle", pose: "", index: handle };
    if (Math.abs(this.x(editor.boundary) - x) < reach / (y < MARGIN[1] ? 1 : 2))
      return { kind: "boundary", pose: "", index: -1 };
    const [time] = this.at(x, y);
    least = reach / 1.5;
    for (const pose of editor.shown) {
      const far = Math.abs(this.y(valuesAt(editor.curves[pose], editor.interpolation, [time])[0]) - y);
      if (far < least) [best, least] = [{ kind: "curve", pose, index: -1 }, far];
    }
    return best;
  }
}
