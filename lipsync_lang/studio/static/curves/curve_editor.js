/** Editor of the curves of one bigram or word: a plot, a list of poses, and tools. */

import { CurveDrawing } from "./curve_drawing.js";
import { listenKeys, listenPointers } from "./curve_hands.js";
import {
  FINE,
  GRID,
  STEP,
  asText,
  changedBy,
  chosenPoints,
  everyPoint,
  fromText,
  inserted,
  clamp,
  shifted,
  size,
  snapped,
  typed,
  without,
} from "./curve_points.js";
import { valuesAt } from "./bspline.js";
import { CurveTools } from "./curve_tools.js";
import { made } from "../shell/elements.js";
import { PoseList } from "./pose_list.js";

/** Least and most time of a boundary. */
const EDGE = 0.01;
/** Times of a new curve. */
const NEW = [0, 0.25, 0.5, 0.75, 1];

/** @typedef {import("./curve_points.js").Curves} Curves @typedef {import("./curve_points.js").Chosen} Chosen */
/** @typedef {{name: string, title?: string, colour?: string, index: number}} Pose */
/**
 * @typedef {{name: string, kind: string, curves: Curves, boundary?: number}} Ghost kind: draft, beneath, neighbour or
 *   targets
 */
/**
 * @typedef {{merge: string, done: boolean, title: string}} Step changes with one `merge` are one step of undo; the
 *   last is `done`
 */
/**
 * @typedef {{poses: Omit<Pose, "index">[], curves: Curves, boundary?: number, interpolation?: string, ghosts?: Ghost[],
 *   pair?: [string, string], fixed?: boolean, sounds?: {time: number, label: string}[]}} Shown `fixed` hides the
 *   boundary; `sounds`
 *   are lines where sounds of a word begin, with their labels, in place of those of the pair
 */
/**
 * @typedef {{changed: (what: {curves?: Curves, boundary?: number}, step: Step) => void,
 *   selected?: (info: {pose: string, points: number}) => void, seek?: (time: number) => void, tell?: (text: string)
 *   => void, dragged?: (dragging: boolean) => void}} Does `dragged` tells that points are dragged, and no longer
 */

/** Curves that were copied last, in this or another editor of the page. */
const clipboard = { text: "" };
/** Steps so far: each has a name of its own. */
let steps = 0;

/** An editor; it knows nothing of files or servers. */
export class CurveEditor {
  /** @param {HTMLElement} place @param {Does} does */
  constructor(place, does) {
    this.does = does;
    /** @type {Map<string, Pose>} */
    this.poses = new Map();
    /** @type {Curves} */
    this.curves = {};
    this.boundary = 0.5;
    this.interpolation = "bspline";
    /** @type {Ghost[]} */
    this.ghosts = [];
    /** Names of the ghosts that are seen. */
    this.haunting = new Set(["draft"]);
    this.pair = ["", ""];
    /** @type {{time: number, label: string}[]} */
    this.sounds = [];
    this.focus = "";
    this.solo = "";
    /** @type {Set<string>} */
    this.hidden = new Set();
    /** @type {Chosen} */
    this.chosen = new Map();
    /** @type {number | null} time of the playhead */
    this.time = null;
    /** @type {number | null} time under the pointer */
    this.cursor = null;
    /** @type {[number, number, number, number] | null} */
    this.marquee = null;
    /** A pointer drags. */
    this.held = false;
    this.snap = false;
    this.repeated = { what: "", step: "" };
    const tools = made("div", { class: "curve-tools row" }),
      plot = made("div", { class: "curve-plot" }),
      list = made("div", { class: "curve-poses" });
    this.readout = made("output", { class: "curve-readout" });
    this.root = made("section", { class: "curve-editor", "aria-label": "Curve editor" }, tools, plot, list);
    plot.append(this.readout);
    place.append(this.root);
    this.drawing = new CurveDrawing(this, plot);
    this.list = new PoseList(this, list);
    this.tools = new CurveTools(this, tools);
    listenPointers(this);
    listenKeys(this);
    this.#listenClipboard();
  }

  /** @param {Shown} shown */
  show({
    poses,
    curves,
    boundary = 0.5,
    interpolation = "bspline",
    ghosts = [],
    pair = ["", ""],
    fixed = false,
    sounds = [],
  }) {
    if (poses.map(({ name }) => name).join("\n") !== [...this.poses.keys()].join("\n")) this.list.rows.clear();
    this.poses = new Map(poses.map((pose, index) => [pose.name, { ...pose, index }]));
    if (String(pair) !== String(this.pair)) [this.chosen, this.repeated.what, this.focus] = [new Map(), "", ""];
    [this.ghosts, this.interpolation, this.pair, this.sounds] = [ghosts, interpolation, pair, sounds];
    if (!this.held) [this.curves, this.boundary] = [curves, boundary];
    if (!this.poses.has(this.focus) || (!this.curves[this.focus] && !this.chosen.size)) this.focus = this.#highest();
    this.root.classList.toggle("fixed", fixed);
    this.tools.ghosts();
    this.draw();
  }

  draw() {
    this.chosen = new Map(
      [...this.chosen]
        .filter(([pose]) => this.curves[pose])
        .map(([pose, all]) => [pose, new Set([...all].filter((index) => index < this.curves[pose].length))]),
    );
    for (const [pose, all] of this.chosen) if (!all.size) this.chosen.delete(pose);
    this.drawing.draw();
    this.list.draw();
    this.tools.draw();
    this.#read();
  }

  // What is seen

  /** @param {string[]} names @returns {string[]} those that are not hidden, in the order of the poses */
  visible(names) {
    return [...this.poses.keys()].filter(
      (name) => names.includes(name) && (this.solo ? name === this.solo : !this.hidden.has(name)),
    );
  }

  /** Poses whose curves are seen. */
  get shown() {
    return this.visible(Object.keys(this.curves));
  }

  /** @param {string} pose */
  indexOf(pose) {
    return this.poses.get(pose)?.index ?? 0;
  }

  /** The pose that moves most. @returns {string} */
  #highest() {
    const tops = this.shown.map(
      (pose) => /** @type {[string, number]} */ ([pose, Math.max(...this.curves[pose].map(([, value]) => value))]),
    );
    return tops.sort(([, a], [, b]) => b - a)[0]?.[0] ?? "";
  }

  /**
   * @param {string} pose
   * @param {number} index
   * @returns {string} such as `open, point 3 of 5: time 0.40, value 0.62`
   */
  told(pose, index) {
    const [time, value] = this.curves[pose][index];
    const number = `point ${index + 1} of ${this.curves[pose].length}`;
    return `${pose}, ${number}: time ${time.toFixed(2)}, value ${value.toFixed(2)}`;
  }

  /** @param {number | null} time of the playhead within the curves */
  setTime(time) {
    if (time === this.time) return;
    this.time = time;
    this.drawing.drawNow();
    this.list.values();
  }

  /** @param {[number, number] | null} at @param {{kind: string, pose: string, index: number} | null} hit */
  hover(at, hit) {
    this.cursor = at && clamp(at[0], 0, 1);
    this.drawing.svg.setAttribute("data-over", hit?.kind ?? "");
    this.#read(at, hit);
    this.list.values();
  }

  /** @param {[number, number] | null} at @param {{kind: string, pose: string, index: number} | null} hit */
  #read(at = null, hit = null) {
    this.readout.textContent = this.#readout(at, hit);
  }

  /**
   * Describe what is under the pointer, or else the chosen points.
   * @param {[number, number] | null} at @param {{kind: string, pose: string, index: number} | null} hit
   * @returns {string}
   */
  #readout(at, hit) {
    if (hit?.kind === "point") return this.told(hit.pose, hit.index);
    if (at && hit?.kind === "curve") {
      const [value] = valuesAt(this.curves[hit.pose], this.interpolation, [at[0]]);
      return `${hit.pose} ${value.toFixed(2)} at ${at[0].toFixed(2)}`;
    }
    if (at) return `time ${clamp(at[0], 0, 1).toFixed(2)}, value ${clamp(at[1], 0, 1).toFixed(2)}`;
    const all = chosenPoints(this.curves, this.chosen);
    if (all.length === 1) return this.told(all[0].pose, all[0].index);
    return all.length ? `${all.length} points` : "";
  }

  /** @param {string} pose */
  focusPose(pose) {
    this.focus = pose;
    this.hidden.delete(pose);
    if (this.solo) this.solo = pose;
    if (![...this.chosen.keys()].includes(pose)) this.chosen = new Map();
    this.#selected();
  }

  /** @param {string} pose @param {number} index of the point that gets the keys */
  focusPoint(pose, index) {
    this.focus = pose;
    this.draw();
    /** @type {SVGElement | undefined} */ (this.drawing.pool.get(pose)?.points.children[index])?.focus({
      preventScroll: true,
    });
  }

  /** @param {string} pose */
  toggleHidden(pose) {
    if (!this.hidden.delete(pose)) this.hidden.add(pose);
    this.chosen.delete(pose);
    this.draw();
  }

  /** @param {string} pose */
  toggleSolo(pose) {
    this.solo = this.solo === pose ? "" : pose;
    if (this.solo) this.focus = pose;
    this.chosen = new Map([...this.chosen].filter(([one]) => one === this.focus));
    this.draw();
  }

  /** @param {number} by how many poses on */
  nextPose(by) {
    const shown = this.solo ? Object.keys(this.curves).filter((name) => this.poses.has(name)) : this.shown;
    if (!shown.length) return;
    const pose = shown[(shown.indexOf(this.focus) + by + shown.length) % shown.length];
    if (this.solo) this.solo = pose;
    this.focusPoint(pose, 0);
  }

  // What is chosen

  /**
   * @param {string} pose
   * @param {number} index
   * @param {boolean} more keeps the others, and takes back what was chosen
   */
  choose(pose, index, more) {
    const chosen = more ? new Map(this.chosen) : new Map(),
      own = new Set(chosen.get(pose));
    if (!more || !own.delete(index)) own.add(index);
    this.chosen = chosen.set(pose, own);
    this.focus = pose;
    this.#selected();
  }

  /** @param {Chosen} chosen */
  chooseAll(chosen) {
    this.chosen = chosen;
    if (chosen.size && !chosen.has(this.focus)) [this.focus] = chosen.keys();
    this.#selected();
  }

  #selected() {
    this.repeated.what = "";
    this.draw();
    this.does.selected?.({ pose: this.focus, points: size(this.chosen) });
  }

  // Changes

  /** @param {string} kind @returns {string} a name for changes that are one step */
  newStep(kind) {
    this.repeated.what = "";
    return `${kind}-${++steps}`;
  }

  /** @param {string} what @returns {string} the step of the same change just before, or a new one */
  sameStep(what) {
    if (this.repeated.what !== what) this.repeated = { what, step: `${what}-${++steps}` };
    return this.repeated.step;
  }

  /** @param {{altKey: boolean, shiftKey: boolean}} keys @returns {number} to which a pointer rounds */
  step({ altKey, shiftKey }) {
    return altKey ? FINE : this.snap !== shiftKey ? GRID : STEP;
  }

  /** @param {string} verb @returns {string} for the list of undo */
  title(verb) {
    const all = chosenPoints(this.curves, this.chosen);
    const [first] = all,
      one = all.every(({ pose }) => pose === first?.pose);
    const which = all.length === 1 ? `point ${first.index + 1}` : `${all.length} points`;
    return `${verb} ${one && first ? `${first.pose} ` : ""}${which}`;
  }

  /** @param {Curves} curves @param {Step} step */
  change(curves, step) {
    this.curves = curves;
    this.draw();
    this.does.changed({ curves }, step);
  }

  /** @param {Curves} curves @param {string} title @param {string} kind */
  #once(curves, title, kind) {
    this.change(curves, { merge: this.newStep(kind), done: true, title });
  }

  /** @param {number} time @param {{merge: string, done: boolean}} step */
  setBoundary(time, step) {
    this.boundary = clamp(time, EDGE, 1 - EDGE);
    this.draw();
    this.does.changed({ boundary: this.boundary }, { ...step, title: "Move the boundary" });
  }

  /** @param {number} time @param {number} value */
  nudge(time, value) {
    this.change(shifted(this.curves, this.chosen, time, value), {
      merge: this.sameStep("nudge"),
      done: true,
      title: this.title("Move"),
    });
  }

  /** @param {0 | 1} axis @param {string} text @returns {boolean} whether it could be read */
  type(axis, text) {
    const what = typed(text);
    if (!what || !this.chosen.size) return false;
    this.#once(
      changedBy(this.curves, this.chosen, axis, what),
      this.title(what.does === "scale" ? "Scale" : "Set"),
      "type",
    );
    return true;
  }

  /**
   * Add a point to the curve in front: at a place, or in the middle of a gap.
   * @param {number} [time]
   * @param {number} [value]
   */
  add(time, value) {
    const points = this.curves[this.focus];
    if (!points) {
      if (this.poses.has(this.focus)) this.addPose(this.focus);
      return;
    }
    const at = time ?? this.#gap(points),
      high = value ?? valuesAt(points, this.interpolation, [at])[0];
    const added = inserted(points, at, high);
    this.chosen = new Map([[this.focus, new Set([added.index])]]);
    this.#once({ ...this.curves, [this.focus]: added.points }, `Add a point to ${this.focus}`, "add");
    this.focusPoint(this.focus, added.index);
  }

  /**
   * @param {[number, number][]} points
   * @returns {number} the pointer's time, or the middle after the chosen point, or of the widest gap
   */
  #gap(points) {
    if (this.cursor !== null) return this.cursor;
    const chosen = Math.max(-1, ...(this.chosen.get(this.focus) ?? []));
    const gaps = points.slice(1).map(([time], n) => time - points[n][0]);
    const n = chosen >= 0 && chosen < gaps.length ? chosen : gaps.indexOf(Math.max(...gaps));
    return snapped(points[n][0] + gaps[n] / 2);
  }

  remove() {
    const all = chosenPoints(this.curves, this.chosen);
    if (!all.length) return;
    const curves = without(this.curves, this.chosen),
      gone = [...this.chosen.keys()].filter((pose) => !curves[pose]);
    const title = this.title("Delete"),
      [{ pose, index }] = all;
    this.chosen = new Map();
    if (gone.length) this.does.tell?.(`A curve needs two points, so ${gone.join(", ")} is removed.`);
    this.#once(curves, title, "delete");
    if (curves[pose]) this.focusPoint(pose, Math.min(index, curves[pose].length - 1));
    else this.drawing.svg.focus({ preventScroll: true });
  }

  /** Give a pose a curve at rest. @param {string} pose */
  addPose(pose) {
    if (this.curves[pose]) return;
    const value = this.ghosts.find(({ kind, curves }) => kind === "draft" && curves[pose])?.curves[pose];
    this.focusPose(pose);
    this.#once({ ...this.curves, [pose]: value ?? NEW.map((time) => [time, 0]) }, `Add ${pose}`, "pose");
    this.focusPoint(pose, 0);
  }

  /** @param {string} pose */
  removePose(pose) {
    if (!this.curves[pose]) return;
    const { [pose]: _, ...rest } = this.curves;
    this.#once(rest, `Remove ${pose}`, "pose");
  }

  /** Take the curves of a ghost, and its boundary. @param {string} name */
  startFrom(name) {
    const ghost = this.ghosts.find((one) => one.name === name);
    if (!ghost) return;
    const curves = Object.fromEntries(Object.entries(ghost.curves).filter(([pose]) => this.poses.has(pose)));
    const merge = this.newStep("start"),
      title = `Start from ${name}`;
    [this.chosen, this.curves, this.boundary] = [new Map(), curves, ghost.boundary ?? this.boundary];
    this.draw();
    this.does.changed({ curves, boundary: this.boundary }, { merge, done: true, title });
  }

  // Clipboard

  /** @returns {string} the curves with chosen points, or all */
  copy() {
    const poses = this.chosen.size ? [...this.chosen.keys()] : Object.keys(this.curves);
    clipboard.text = asText(Object.fromEntries(poses.map((pose) => [pose, this.curves[pose]])));
    this.does.tell?.(`Copied ${poses.join(", ")}`);
    return clipboard.text;
  }

  /** @param {string} [text] instead of what was copied here */
  paste(text) {
    const found = fromText(text ?? "") ?? fromText(clipboard.text);
    const fitting = Object.entries(found ?? {}).filter(([pose]) => this.poses.has(pose));
    if (!fitting.length) {
      this.does.tell?.(
        found
          ? "This character does not have the poses of the copied curves."
          : "Nothing is copied yet. Choose points and press Ctrl+C.",
      );
      return;
    }
    const curves = Object.fromEntries(fitting);
    this.chosen = everyPoint(curves);
    [this.focus] = Object.keys(curves);
    this.#once({ ...this.curves, ...curves }, `Paste ${Object.keys(curves).join(", ")}`, "paste");
  }

  #listenClipboard() {
    const typing = (/** @type {Event} */ event) => event.target instanceof HTMLInputElement;
    this.root.addEventListener("copy", (event) => {
      if (typing(event)) return;
      event.clipboardData?.setData("text/plain", this.copy());
      event.preventDefault();
    });
    this.root.addEventListener("paste", (event) => {
      if (typing(event)) return;
      this.paste(event.clipboardData?.getData("text/plain"));
      event.preventDefault();
    });
  }

  /** @param {number} time */
  seek(time) {
    this.does.seek?.(time);
  }

  /**
   * @param {string} key
   * @param {boolean} command Ctrl or Cmd
   * @param {boolean} shift
   * @returns {boolean} whether it does anything
   */
  key(key, command, shift) {
    /** @type {Record<string, () => void>} */
    const does = command
      ? {
          a: () => this.chooseAll(everyPoint(this.curves, shift ? this.shown : [this.focus])),
        }
      : {
          Delete: () => this.remove(),
          Backspace: () => this.remove(),
          a: () => this.add(),
          Escape: () => this.chooseAll(new Map()),
          "[": () => this.nextPose(-1),
          "]": () => this.nextPose(1),
          PageUp: () => this.nextPose(-1),
          PageDown: () => this.nextPose(1),
          h: () => this.focus && this.toggleHidden(this.focus),
          s: () => this.focus && this.toggleSolo(this.focus),
          g: () => this.tools.snapped(),
          "+": () => this.drawing.zoom(1.4),
          "=": () => this.drawing.zoom(1.4),
          "-": () => this.drawing.zoom(1 / 1.4),
          0: () => this.drawing.fit(),
        };
    does[key]?.();
    return Boolean(does[key]);
  }
}
