/** How a line is delivered: sliders for the whole line, and for a chosen word. */

import { button, made } from "../shell/elements.js";
import { selectInput } from "../shell/form_fields.js";
import { levelAt } from "../timeline/level_points.js";

const MOST_EMPHASIS = 2, MOST_INTENSITY = 2;
const RATES = [24, 25, 30, 48, 50, 60, 120];

/** @typedef {import("../timeline/track_lanes.js").Track} Track */
/** @typedef {import("../timeline/level_points.js").Level} Level */

/**
 * @typedef {object} DeliveryHands
 * @property {(track: Track, level: Level | undefined, done: boolean) => void} set the level of the line
 * @property {(track: Track, value: number, done: boolean) => void} setWord the level over the chosen word
 * @property {(level: number, done: boolean) => void} emphasise the chosen word
 * @property {(name: "intensity" | "fps", value: number | null, done: boolean) => void} state a number of the line
 * @property {(track: Track) => void} open a track of points
 */

/** Sliders beside a timeline. */
export class DeliveryPanel {
  /** @param {HTMLElement} word @param {HTMLElement} line @param {DeliveryHands} does */
  constructor(word, line, does) {
    this.word = word;
    this.line = line;
    this.does = does;
    this.built = "";
    /** Sliders by their name, and what they show. @type {Map<string, (value: number | null, note: string) => void>} */
    this.shows = new Map();
  }

  /**
   * @param {Track[]} tracks every region and style @param {import("../payloads.js").Settings} settings
   * @param {{text: string, emphasis: number, from: number, to: number} | null} word that is chosen
   * @param {boolean} sound
   */
  show(tracks, settings, word, sound) {
    const built = JSON.stringify([
      tracks.map((one) => [one.kind, one.name]),
      word?.text,
      word?.from === undefined,
      sound,
    ]);
    if (built !== this.built) this.#build(tracks, word !== null, sound);
    this.built = built;
    for (const track of tracks) {
      const steady = typeof track.level === "number";
      this.shows.get(`line ${track.kind} ${track.name}`)?.(steady ? Number(track.level) : null, steady ? "" : "points");
      if (word)
        this.shows.get(`word ${track.kind} ${track.name}`)?.(levelAt(track.level, (word.from + word.to) / 2), "");
    }
    this.shows.get("intensity")?.(
      settings.intensity ?? null,
      settings.intensity === null || settings.intensity === undefined ? "auto" : "",
    );
    if (word) this.shows.get("emphasis")?.(word.emphasis, "");
    const title = this.word.querySelector("bdi");
    if (title && word) title.textContent = word.text;
    const rate = /** @type {HTMLSelectElement | null} */ (this.line.querySelector("select"));
    if (rate) {
      const fps = String(settings.fps ?? 60);
      if (![...rate.options].some((one) => one.value === fps)) rate.append(made("option", { value: fps }, fps));
      rate.value = fps;
    }
  }

  /** @param {Track[]} tracks @param {boolean} word @param {boolean} sound */
  #build(tracks, word, sound) {
    this.shows.clear();
    const { does } = this;
    this.word.hidden = !word;
    const close = made("small", "Esc closes");
    this.word.replaceChildren(
      made("h2", "Word ", made("bdi"), " ", close),
      this.#slider("emphasis", "emphasis", MOST_EMPHASIS, (value, done) => does.emphasise(value, done)),
      ...tracks.map((one) =>
        this.#slider(`word ${one.kind} ${one.name}`, one.name, one.most, (value, done) =>
          does.setWord(one, value, done),
        ),
      ),
    );
    const rate = selectInput("Frames per second", RATES.map(String).map((one) => [one, one]));
    rate.addEventListener("change", () => does.state("fps", Number(rate.value), true));
    const loud = this.#slider("intensity", "loudness", MOST_INTENSITY, (value, done) =>
      does.state("intensity", value, done),
    );
    if (!sound) {
      loud.title = "Needs the sound of the line";
      for (const one of loud.querySelectorAll("input")) one.disabled = true;
    }
    this.line.replaceChildren(
      ...tracks.map((one) => {
        const open = button(
          "∿",
          { title: `Points of ${one.name} over time`, "aria-label": `Track of ${one.name}` },
          () => does.open(one),
        );
        return this.#slider(
          `line ${one.kind} ${one.name}`,
          one.name,
          one.most,
          (value, done) => does.set(one, value, done),
          open,
        );
      }),
      loud, made("label", { class: "dial" }, made("span", { title: "frames per second" }, "fps"), rate));
  }

  /**
   * @param {string} key @param {string} name @param {number} most
   * @param {(value: number, done: boolean) => void} set @param {...HTMLElement} more
   */
  #slider(key, name, most, set, ...more) {
    const { node, show } = dial(name, most, set, ...more);
    this.shows.set(key, show);
    return node;
  }
}

/**
 * Make a slider with a number beside it, and what shows a value in both.
 * @param {string} name
 * @param {number} most
 * @param {(value: number, done: boolean) => void} set
 * @param {...HTMLElement} more
 */
export function dial(name, most, set, ...more) {
  const traits = { min: "0", max: String(most), step: "0.05" };
  const slider = made("input", { type: "range", "aria-label": name, ...traits });
  const number = made("input", { type: "number", "aria-label": `${name}, as a number`, ...traits });
  slider.addEventListener("input", () => { number.value = slider.value; set(Number(slider.value), false); });
  slider.addEventListener("change", () => set(Number(slider.value), true));
  number.addEventListener(
    "change",
    () => number.value !== "" && set(Math.min(most, Math.max(0, Number(number.value))), true),
  );
  return {
    node: made("div", { class: "dial" }, made("span", { dir: "auto", title: name }, name), slider, number, ...more),
    show: (/** @type {number | null} */ value, /** @type {string} */ note) => {
      number.placeholder = note;
      if (document.activeElement !== number) number.value = value === null ? "" : String(Number(value.toFixed(2)));
      if (document.activeElement !== slider) slider.value = String(value ?? most / 2);
    },
  };
}
