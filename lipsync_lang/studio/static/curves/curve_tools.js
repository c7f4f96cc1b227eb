/** Tools above a plot of curves: time and value of what is chosen, points, clipboard, ghosts, zoom. */

import { chosenPoints } from "./curve_points.js";
import { button, made } from "../shell/elements.js";
import { actButton, fillOptions, textInput } from "../shell/form_fields.js";

const TYPED = "0.4 sets, +0.1 and -0.1 shift, *0.8 and 80% scale";

/** The row of tools of an editor. */
export class CurveTools {
  /** @param {import("./curve_editor.js").CurveEditor} editor @param {HTMLElement} place */
  constructor(editor, place) {
    this.editor = editor;
    /** @type {HTMLInputElement[]} */
    this.inputs = ["Time", "Value"].map((name, axis) => this.#input(name, /** @type {0 | 1} */ (axis)));
    const group = (/** @type {string} */ label, /** @type {HTMLElement[]} */ ...all) =>
      made("span", { class: "group", role: "group", "aria-label": label }, ...all);
    this.grid = actButton("Snap", "Snap to steps of 0.05 (G). Hold Shift while dragging for the opposite.", () =>
      this.snapped(),
    );
    this.delete = actButton("− Point", "− Point: delete the chosen points (Delete)", () => editor.remove());
    this.haunts = made("span", { class: "group ghosts", role: "group", "aria-label": "Faint curves for comparison" });
    this.start = made("select", { "aria-label": "Start from other curves" });
    this.start.addEventListener("change", () => {
      editor.startFrom(this.start.value);
      this.start.value = "";
    });
    const zoom = group(
      "Zoom of the plot",
      actButton("−", "Zoom out (−)", () => editor.drawing.zoom(1 / 1.4)),
      actButton("↔", "Show all (0)", () => editor.drawing.fit()),
      actButton("+", "Zoom in (+)", () => editor.drawing.zoom(1.4)),
    );
    zoom.classList.add("zoom");
    place.append(
      ...this.inputs.map((input, axis) => made("label", ["Time", "Value"][axis], input)),
      this.grid,
      group(
        "Points",
        actButton("+ Point", "Add a point (A, or double click)", () => {
          editor.cursor = null;
          editor.add();
        }),
        this.delete,
      ),
      group(
        "Clipboard",
        actButton("Copy", "Copy the chosen curves, or all (Ctrl+C)", () => this.#copy()),
        actButton("Paste", "Paste curves (Ctrl+V)", () => this.#paste()),
      ),
      this.start,
      this.haunts,
      zoom,
    );
    this.snapped(false);
  }

  /** @param {string} name @param {0 | 1} axis @returns {HTMLInputElement} */
  #input(name, axis) {
    const traits = { inputmode: "decimal", size: "6", title: `${name}: ${TYPED}` };
    const input = textInput(`${name} of the chosen points`, traits);
    input.addEventListener("change", () => {
      const read = this.editor.type(axis, input.value);
      if (!read) this.editor.does.tell?.(`${name} cannot be '${input.value}': ${TYPED}`);
      this.draw();
    });
    input.addEventListener("focus", () => input.select());
    input.addEventListener("keydown", (event) => {
      const up = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (event.key === "Enter") input.dispatchEvent(new Event("change"));
      if (up && this.editor.chosen.size) {
        const step = up * (event.altKey ? 0.001 : event.shiftKey ? 0.05 : 0.01);
        this.editor.nudge(axis ? 0 : step, axis ? step : 0);
        event.preventDefault();
      }
      if (!event.ctrlKey && !event.metaKey) event.stopPropagation();
    });
    return input;
  }

  /** Show what is chosen. */
  draw() {
    const points = chosenPoints(this.editor.curves, this.editor.chosen).map(({ point }) => point);
    this.inputs.forEach((input, axis) => {
      const values = new Set(points.map((point) => String(Number(point[axis].toFixed(3)))));
      input.value = values.size === 1 ? [...values][0] : "";
      input.placeholder = values.size > 1 ? "several" : "";
      input.disabled = !points.length;
    });
    /** @type {HTMLButtonElement} */ (this.delete).disabled = !points.length;
  }

  /** Show the available ghosts. */
  ghosts() {
    const { editor } = this;
    this.haunts.replaceChildren(...editor.ghosts.map(({ name, kind }) => {
      const one = button(
        name,
        {
          class: `ghost ${kind}`,
          "aria-pressed": String(editor.haunting.has(name)),
          title: `Show or hide the curves of ${name}`,
        },
        () => {
          if (!editor.haunting.delete(name)) editor.haunting.add(name);
          one.setAttribute("aria-pressed", String(editor.haunting.has(name)));
          editor.drawing.draw();
        },
      );
      return one;
    }));
    this.start.hidden = !editor.ghosts.length;
    fillOptions(this.start, [["", "Start from…"], ...editor.ghosts.map(({ name }) => [name, name])]);
  }

  /** @param {boolean} on */
  snapped(on = !this.editor.snap) {
    this.editor.snap = on;
    this.grid.setAttribute("aria-pressed", String(on));
  }

  async #copy() {
    const text = this.editor.copy();
    try { await navigator.clipboard.writeText(text); } catch { /* the page's own clipboard has it */ }
  }

  async #paste() {
    let text;
    try { text = await navigator.clipboard.readText(); } catch { /* not allowed: the page's own clipboard has it */ }
    this.editor.paste(text);
  }
}
