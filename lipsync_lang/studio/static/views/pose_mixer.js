/** Sliders of poses by region: a mix of poses for the face. */

import { made, middled } from "../shell/elements.js";

/** @typedef {{name: string, title: string, region: string}} Pose */
/** @typedef {{pose: string, other: string, why: string}} Act a rule that lowers a pose */

/** Poses from which the list can be searched. */
const MANY = 12;

/** Sliders, one for each pose. */
export class PoseMixer {
  /** @param {HTMLElement} place @param {(pose: string, weight: number, done: boolean) => void} moved */
  constructor(place, moved) {
    this.moved = moved;
    this.search = made("input", { type: "search", placeholder: "Find a pose", "aria-label": "Find a pose" });
    this.groups = made("div", { class: "mixer-groups" });
    place.append(this.search, this.groups);
    /** @type {Map<string, {row: HTMLElement, slider: HTMLInputElement, number: HTMLInputElement, act: HTMLElement}>} */
    this.rows = new Map();
    this.search.addEventListener("input", () => this.#find());
    this.search.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key !== "Escape") return;
      this.search.value = "";
      this.#find();
    });
  }

  /** @param {Pose[]} poses */
  show(poses) {
    /** @type {Map<string, Pose[]>} */
    const regions = new Map();
    for (const pose of poses) regions.set(pose.region, [...(regions.get(pose.region) ?? []), pose]);
    this.rows.clear();
    this.search.hidden = poses.length < MANY;
    this.search.value = "";
    this.groups.replaceChildren(
      ...[...regions].map(([region, some]) =>
        made(
          "section",
          { class: "mixer-group" },
          made("h3", region || "other"),
          made("ul", ...some.map((pose) => this.#row(pose))),
        ),
      ),
    );
  }

  /** @param {Pose} pose @returns {HTMLElement} */
  #row({ name, title }) {
    const label = title ? `${name}: ${title}` : name;
    const slider = made("input", { type: "range", min: "0", max: "1", step: "0.01", value: "0", "aria-label": label });
    const number = made("input", {
      type: "number", min: "0", max: "1", step: "0.05", value: "0", "aria-label": `Weight of ${name}`,
    });
    const act = made("small");
    const row = made(
      "li",
      { "data-pose": name, title },
      middled(name, { class: "name" }),
      slider,
      number,
      act,
    );
    slider.addEventListener("input", () => this.#set(name, slider.valueAsNumber, false));
    slider.addEventListener("change", () => this.#set(name, slider.valueAsNumber, true));
    slider.addEventListener("dblclick", () => this.#set(name, 0, true));
    number.addEventListener("change", () => this.#set(name, Math.max(0, Math.min(1, number.valueAsNumber || 0)), true));
    this.rows.set(name, { row, slider, number, act });
    return row;
  }

  /** @param {string} name @param {number} weight @param {boolean} done */
  #set(name, weight, done) {
    this.#put(name, weight);
    this.moved(name, weight, done);
  }

  /** @param {string} name @param {number} weight */
  #put(name, weight) {
    const item = this.rows.get(name);
    if (!item) return;
    const shown = String(Math.round(weight * 1000) / 1000);
    if (item.slider.value !== shown) item.slider.value = shown;
    if (document.activeElement !== item.number || Number(item.number.value) !== Number(shown))
      item.number.value = weight ? Number(shown).toFixed(2) : "0";
    item.row.classList.toggle("moves", weight > 0.0005);
  }

  /** @param {Record<string, number>} weights */
  values(weights) {
    for (const name of this.rows.keys()) this.#put(name, weights[name] ?? 0);
  }

  /** @param {Act[]} acts @param {Record<string, number>} kept weights after the constraints */
  acts(acts, kept) {
    const by = new Map(acts.map((act) => [act.pose, act]));
    for (const [name, { row, act }] of this.rows) {
      const one = by.get(name);
      act.textContent = one ? `→ ${kept[name].toFixed(2)} by ${one.other}: ${one.why}` : "";
      row.classList.toggle("kept", Boolean(one));
    }
  }

  #find() {
    const sought = this.search.value.trim().toLowerCase();
    for (const [name, { row }] of this.rows) row.hidden = !`${name} ${row.title}`.toLowerCase().includes(sought);
    for (const group of /** @type {Iterable<HTMLElement>} */ (/** @type {unknown} */ (this.groups.children))) {
      group.hidden = ![...group.querySelectorAll("li")].some((row) => !row.hidden);
    }
  }
}
