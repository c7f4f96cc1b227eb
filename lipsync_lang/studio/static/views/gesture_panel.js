/** The chosen gesture beside the timeline: why it is there, its scale, and its end. */

import { button, made } from "../shell/elements.js";
import { dial } from "./delivery_panel.js";

/** As in a character's file. */
export const MOST_SCALE = 2;

/** @typedef {import("../timeline/gesture_places.js").Shown} Shown */

export class GesturePanel {
  /**
   * @param {HTMLElement} place
   * @param {{scale: (own: Shown, scale: number, done: boolean) => void, remove: (own: Shown) => boolean}} does
   */
  constructor(place, does) {
    this.place = place;
    /** @type {Shown | null} */
    this.own = null;
    this.name = made("bdi");
    this.why = made("p");
    this.scale = dial("scale", MOST_SCALE, (value, done) => this.own && does.scale(this.own, value, done));
    this.away = button("Delete", "", () => this.own && does.remove(this.own));
    place.append(
      made("h2", "Gesture ", this.name, " ", made("small", "Esc closes")),
      this.why,
      this.scale.node,
      made("p", { class: "row" }, this.away),
    );
  }

  /** @param {Shown | null} own */
  show(own) {
    this.place.hidden = !own;
    this.own = own;
    if (!own) return;
    this.name.textContent = own.name;
    this.why.textContent = own.why;
    this.scale.show(own.scale, "");
    this.away.textContent = own.scale ? "Delete" : "Take back";
    this.away.title = own.scale ? "Delete it (Delete)" : "Let gestures come here by rule again (Delete)";
  }
}
