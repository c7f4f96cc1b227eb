/** The bar below the face: playing, looping, zooming, the angle of the face and the take to compare with. */

import { the } from "./elements.js";
import { chosen, fillOptions } from "./form_fields.js";
import { showHelp } from "./studio_keys.js";
import { toggleTongue } from "../face/tongue_view.js";
import { Timeline } from "../timeline/timeline.js";

/** Takes to compare with: their names and titles. */
const AGAINST = [
  ["", "No comparison"],
  ["saved", "A/B: as saved"],
  ["keyframes", "A/B: keyframes"],
  ["dominance", "A/B: dominance"],
  ["held", "A/B: held"],
];

/** The buttons of a studio that play its line and turn its face. */
export class PlayerBar {
  /** @param {import("./studio.js").Studio} studio */
  constructor(studio) {
    this.studio = studio;
    fillOptions(the("against"), AGAINST);
    const click = (/** @type {string} */ id, /** @type {() => void} */ does) => the(id).addEventListener("click", does);
    click("play", () => studio.player.toggle());
    click("back", () => studio.step(-1));
    click("on", () => studio.step(1));
    click("keys", showHelp);
    click("loop", () => this.toggleLoop());
    click("in", () => this.zoom(1.5));
    click("out", () => this.zoom(1 / 1.5));
    click("fit", () => this.zoomOut());
    for (const one of document.querySelectorAll("[data-rate]"))
      one.addEventListener("click", () => this.setRate(Number(one.getAttribute("data-rate"))));
    click("tongue", () => studio.attempt(() => toggleTongue(studio, the("tongue"))));
    for (const one of document.querySelectorAll("#angles [data-view]"))
      one.addEventListener("click", () => this.viewFrom(one.getAttribute("data-view") ?? "front"));
    the("against").addEventListener("change", () => {
      studio.against = chosen("against");
      studio.perform();
    });
  }

  /** Show whether the line plays. @param {boolean} playing */
  show(playing) {
    the("play").textContent = playing ? "❚❚" : "▶";
    the("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  /** @param {number} factor by which the time around the playhead grows */
  zoom(factor) {
    this.timeline.zoom(factor, this.studio.player.time);
  }

  /** Show the whole line. */
  zoomOut() {
    const timeline = this.timeline;
    timeline.setView(timeline.start, timeline.end);
  }

  /** The timeline that is seen. @returns {Timeline} */
  get timeline() {
    const { timeline: own } = /** @type {{timeline?: unknown}} */ (this.studio.view ?? {});
    return own instanceof Timeline ? own : this.studio.strip;
  }

  toggleLoop() {
    const { take, player } = this.studio;
    if (!take) return;
    const phoneme = take.phonemeAt(player.time), word = phoneme < 0 ? -1 : take.wordOf(phoneme);
    const [, first, stop] = take.data.spoken.words[word] ?? ["", 0, 0];
    const { times } = take.data.spoken;
    player.loop = player.loop ? null : word < 0 ? [take.start, take.end] : [times[first], times[stop]];
    this.studio.strip.loop = player.loop;
    this.studio.strip.stale = true;
    the("loop").setAttribute("aria-pressed", String(Boolean(player.loop)));
    this.studio.wake();
  }

  /** @param {number} rate */
  setRate(rate) {
    this.studio.player.setRate(rate);
    for (const one of document.querySelectorAll("[data-rate]"))
      one.setAttribute("aria-pressed", String(Number(one.getAttribute("data-rate")) === rate));
  }

  /** @param {string} way front, half, side or close */
  viewFrom(way) {
    const yaw = { half: 40, side: 90 }[way] ?? 0;
    for (const one of this.studio.facePlace.portraits) {
      one.setClose(way === "close");
      if (yaw) one.turn(yaw, 0);
    }
    for (const one of document.querySelectorAll("#angles [data-view]"))
      one.setAttribute("aria-pressed", String(one.getAttribute("data-view") === way));
    this.studio.wake();
  }
}
