/** The words view. */

import { made } from "./elements.js";

export class WordsView {
  /** @param {import("./studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.place = place;
    place.append(made("p", {}, "to come"));
  }

  /** @param {string} argument */
  async show(argument) {
    this.argument = argument;
  }

  hide() {}

  /** @param {KeyboardEvent} _event */
  key(_event) {
    return false;
  }

  /** @param {import("./studio.js").Change} _what */
  changed(_what) {}
}
