/** The tour of a character: a few steps, each beside the part of the studio that it tells of. */

import { button, made, the } from "./elements.js";

/** @typedef {{view: string, at: string, title: string, text: string}} TourStep */

/** Pixels between a part and the words about it. */
const GAP = 12;

/** A tour that is being taken. */
export class Tour {
  /** @param {import("./studio.js").Studio} studio @param {TourStep[]} steps */
  constructor(studio, steps) {
    this.studio = studio;
    this.steps = steps;
    this.number = -1;
    this.card = made("div", { class: "tour", role: "dialog", "aria-label": "Tour", tabindex: "-1" });
    this.ring = made("div", { class: "tour-ring", "aria-hidden": "true" });
    this.place = () => this.#place();
    document.body.append(this.ring, this.card);
    this.moved = new ResizeObserver(this.place); // views and the dock change their sizes when they are filled
    for (const id of ["view", "dock"]) this.moved.observe(the(id));
    addEventListener("resize", this.place);
    this.card.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.end();
      event.stopPropagation();
    });
    this.go(0);
  }

  /** @param {number} number of the step */
  go(number) {
    const step = this.steps[number];
    if (!step) {
      this.end();
      /** @type {HTMLInputElement} */ (the("text")).select(); // work begins with a line
      return;
    }
    this.number = number;
    if (step.view) this.studio.go(...(/** @type {[string, string]} */ (step.view.split("/"))));
    const last = number === this.steps.length - 1;
    this.card.replaceChildren(
      made("h2", step.title), made("p", step.text),
      made("p", { class: "row" }, made("small", `${number + 1} of ${this.steps.length}`),
        ...(number ? [button("Back", "", () => this.go(number - 1))] : []),
        ...(last ? [] : [button("End", "", () => this.end())]),
        button(last ? "Done" : "Next", { class: "main" }, () => this.go(number + 1))));
    requestAnimationFrame(() => {
      this.#place();
      /** @type {HTMLElement} */ (this.card.querySelector(".main")).focus();
    });
  }

  #place() {
    const { card, ring } = this, part = document.querySelector(this.steps[this.number].at);
    if (!part) return;
    const box = part.getBoundingClientRect(), { offsetWidth: wide, offsetHeight: high } = card;
    const room = (/** @type {number} */ at, /** @type {number} */ size, /** @type {number} */ all) =>
      Math.max(8, Math.min(at, all - size - 8));
    let [x, y] = [box.left, box.bottom + GAP];
    if (y + high > innerHeight) y = box.top - high - GAP;
    if (y < 0) [x, y] = [box.right + GAP, box.top + GAP];
    if (x + wide > innerWidth) x = box.right - wide - GAP;
    card.style.left = `${room(x, wide, innerWidth)}px`;
    card.style.top = `${room(y, high, innerHeight)}px`;
    Object.assign(ring.style, {
      left: `${box.left - 3}px`,
      top: `${box.top - 3}px`,
      width: `${box.width + 6}px`,
      height: `${box.height + 6}px`,
    });
  }

  end() {
    this.moved.disconnect();
    removeEventListener("resize", this.place);
    this.card.remove();
    this.ring.remove();
  }
}
