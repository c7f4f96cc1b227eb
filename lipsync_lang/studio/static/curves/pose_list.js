/** The poses of an editor of curves: found, shown, hidden, alone, in front, with their values. */

import { valuesAt } from "./bspline.js";
import { sample } from "./curve_drawing.js";
import { button, made, middled } from "../shell/elements.js";

/** Poses from which a list can be searched. */
const MANY = 12;

/** A list with one row for each pose; those that move come first. */
export class PoseList {
  /** @param {import("./curve_editor.js").CurveEditor} editor @param {HTMLElement} place */
  constructor(editor, place) {
    this.editor = editor;
    this.search = made("input", { type: "search", placeholder: "Find a pose", "aria-label": "Find a pose" });
    this.list = made("ul", {
      class: "pose-list",
      role: "listbox",
      "aria-label": "Poses: arrows choose, Enter adds a curve, H hides, S shows alone",
    });
    place.append(this.search, this.list);
    /** @type {Map<string, {row: HTMLElement, bar: HTMLElement, value: HTMLElement, state: string}>} */
    this.rows = new Map();
    this.order = "";
    this.search.addEventListener("input", () => this.draw());
    this.search.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.#first()?.click();
      if (event.key === "Escape") this.search.value = "";
      event.stopPropagation();
      if (event.key === "Escape") this.draw();
    });
    this.list.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Show the poses as they stand. */
  draw() {
    const { editor } = this, sought = this.search.value.trim().toLowerCase();
    const all = [...editor.poses.values()].filter(({ name, title }) =>
      `${name} ${title ?? ""}`.toLowerCase().includes(sought),
    );
    const shown = [...all.filter(({ name }) => editor.curves[name]), ...all.filter(({ name }) => !editor.curves[name])];
    this.search.hidden = editor.poses.size < MANY;
    const order = shown.map(({ name }) => name).join("\n");
    if (order !== this.order) {
      const focused = document.activeElement?.closest(".pose-list li")?.getAttribute("data-pose");
      this.order = order;
      this.list.replaceChildren(
        ...shown.map((pose) => this.#row(pose)),
        ...(shown.length ? [] : [made("li", { class: "none" }, "No pose has this name.")]),
      );
      if (focused) this.rows.get(focused)?.row.focus();
    }
    shown.forEach(({ name }) => this.#state(name));
    if (![...this.list.children].some((row) => row.getAttribute("tabindex") === "0"))
      this.list.firstElementChild?.setAttribute("tabindex", "0");
    this.values();
  }

  /** @param {import("./curve_editor.js").Pose} pose @returns {HTMLElement} */
  #row(pose) {
    const known = this.rows.get(pose.name);
    if (known) return known.row;
    const { editor } = this, name = pose.name;
    const tool = (
      /** @type {string} */ kind,
      /** @type {string} */ text,
      /** @type {string} */ label,
      /** @type {() => void} */ does,
    ) => button(text, { class: kind, tabindex: "-1", "aria-label": `${label} ${name}`, title: label }, (event) => {
      event.stopPropagation();
      does();
    });
    const bar = made("i"), value = made("span", { class: "value" });
    const row = made(
      "li",
      { role: "option", "data-pose": name, title: pose.title || name },
      sample(pose),
      middled(name, { class: "name" }),
      bar,
      value,
      made(
        "span",
        { class: "own" },
        tool("eye", "◉", "Hide or show", () => editor.toggleHidden(name)),
        tool("solo", "S", "Show alone", () => editor.toggleSolo(name)),
        tool("add", "+", "Add a curve for", () => editor.addPose(name)),
        tool("remove", "×", "Remove the curve of", () => editor.removePose(name)),
      ),
    );
    row.addEventListener("click", () => editor.focusPose(name));
    row.addEventListener("dblclick", () => editor.curves[name] || editor.addPose(name));
    this.rows.set(name, { row, bar, value, state: "" });
    return row;
  }

  /** @param {string} name */
  #state(name) {
    const { editor } = this,
      item = this.rows.get(name),
      moves = Boolean(editor.curves[name]),
      front = editor.focus === name;
    const hidden = editor.hidden.has(name), solo = editor.solo === name, state = String([moves, front, hidden, solo]);
    if (!item || item.state === state) return;
    item.state = state;
    item.row.className = [moves ? "moves" : "", front ? "front" : "", hidden || (editor.solo && !solo) ? "hidden" : ""]
      .join(" ")
      .trim();
    item.row.setAttribute("aria-selected", String(front));
    item.row.setAttribute("tabindex", front ? "0" : "-1");
    item.row.querySelector(".eye")?.setAttribute("aria-pressed", String(!hidden));
    item.row.querySelector(".solo")?.setAttribute("aria-pressed", String(solo));
  }

  /** Show the values at the moment of the pointer or the playhead. */
  values() {
    const { editor } = this, time = editor.cursor ?? editor.time;
    for (const [name, { row, bar, value }] of this.rows) {
      if (!row.isConnected) continue;
      const curve = editor.curves[name],
        weight = curve && time !== null ? valuesAt(curve, editor.interpolation, [time])[0] : 0;
      bar.style.setProperty("--share", String(weight));
      value.textContent = curve && time !== null ? weight.toFixed(2) : "";
    }
  }

  #first() {
    return /** @type {HTMLElement | null} */ (this.list.querySelector("li[data-pose]"));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const row = /** @type {HTMLElement} */ (event.target).closest("li"), name = row?.getAttribute("data-pose");
    if (!row || !name || event.ctrlKey || event.metaKey || event.altKey) return;
    const { editor } = this, rows = /** @type {HTMLElement[]} */ ([...this.list.children]), at = rows.indexOf(row);
    const go = (/** @type {number} */ index) => {
      const next = rows[Math.max(0, Math.min(rows.length - 1, index))], pose = next.getAttribute("data-pose");
      if (pose) editor.focusPose(pose);
      next.focus();
    };
    /** @type {Record<string, () => void>} */
    const does = {
      ArrowUp: () => go(at - 1), ArrowDown: () => go(at + 1), Home: () => go(0), End: () => go(rows.length - 1),
      Enter: () => (editor.curves[name] ? editor.focusPoint(name, 0) : editor.addPose(name)),
      Delete: () => editor.removePose(name), h: () => editor.toggleHidden(name), s: () => editor.toggleSolo(name),
    };
    const act = does[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }
}
