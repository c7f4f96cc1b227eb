/** Values of a take at a moment: the sound, its bigrams, and a row for each pose with its reasons. */

import { button, made, middled } from "../shell/elements.js";

/** Lists beside a timeline. */
export class TakeValues {
  /**
   * @param {{moment: HTMLElement, bigrams: HTMLElement, poses: HTMLElement}} places
   * @param {{pick: (row: number) => void, refold: () => void,
   *   more?: (bigram: import("../payloads.js").PlacedBigram) => Node[]}} does
   *   `refold` shows other rows after a pair is opened or closed; `more` adds to a bigram's line
   */
  constructor(places, does) {
    this.places = places;
    this.does = does;
    /** @type {import("./take.js").Take | null} */
    this.take = null;
    /** @type {string[]} */
    this.rows = [];
    this.row = -1;
    /** Rows of mirrored pairs whose poses have rows of their own. @type {Set<string>} */
    this.opened = new Set();
    this.told = "";
    this.drawn = Number.NaN;
    this.playing = false;
  }

  /** @param {import("./take.js").Take} take @param {string[]} rows names of the poses */
  show(take, rows) {
    this.take = take;
    this.drawn = Number.NaN;
    const pairs = rows.map((name) => pairOf(take, name)), told = JSON.stringify([rows, pairs]);
    if (told === this.told) return;
    [this.told, this.rows, this.row] = [told, rows, -1];
    this.places.poses.replaceChildren(...rows.map((name, row) => {
      const one = button(
        [middled(name), made("i"), made("span", "")],
        { "aria-expanded": "false" },
        () => this.does.pick(row === this.row ? -1 : row),
      );
      return made("li", one, ...(pairs[row] ? [this.#folder(pairs[row])] : []));
    }));
  }

  /** @param {string} both name of a pair's row @returns {HTMLElement} a button that opens or closes the pair */
  #folder(both) {
    const open = this.opened.has(both);
    const title = open ? `Show ${both} as one row` : `Show the two poses of ${both} in rows of their own`;
    const label = { "aria-label": title, "aria-expanded": String(open), "data-pair": both };
    return button(open ? "−" : "+", { class: "fold", title, ...label }, () => {
      if (!this.opened.delete(both)) this.opened.add(both);
      this.does.refold();
      const anew = this.places.poses.querySelector(`[data-pair="${CSS.escape(both)}"]`);
      /** @type {HTMLElement | null} */ (anew)?.focus();
    });
  }

  /** @param {number} row whose reasons are shown; -1 for none */
  pick(row) {
    this.row = row;
    [...this.places.poses.children].forEach((one, n) =>
      one.firstElementChild?.setAttribute("aria-expanded", String(n === row)),
    );
    this.drawn = Number.NaN;
  }

  /** @param {number} frame @param {boolean} playing then no reasons are listed */
  draw(frame, playing) {
    const { take } = this;
    if (!take || (frame === this.drawn && playing === this.playing)) return;
    [this.drawn, this.playing] = [frame, playing];
    const sound = take.soundAt(frame);
    const as = sound.common && sound.common !== sound.label ? ` as ${sound.common}` : "";
    this.places.moment.replaceChildren(
      made("b", { dir: "auto" }, sound.label),
      `${as}${sound.word ? ", in " : ""}`,
      made("bdi", sound.word),
    );
    this.places.bigrams.replaceChildren(...take.bigramsAt(frame).map((one) => {
      const drawn = one.drawn_as ? `, drawn as ${one.drawn_as}` : "", word = one.word ? `, as in ${one.word}` : "";
      const half = one.trigram ? `, in the trigram ${one.trigram}` : "";
      return made("li",
        `${one.pair} at ${one.position.toFixed(2)}: ${one.layer}, ${one.status || "none"}${drawn}${half}${word} `,
        made("small", one.from.join(", ")),
        ...(this.does.more?.(one) ?? []),
      );
    }));
    this.rows.forEach((name, row) => this.#value(take, name, row, frame, playing));
  }

  /**
   * @param {import("./take.js").Take} take
   * @param {string} name
   * @param {number} row
   * @param {number} frame
   * @param {boolean} playing
   */
  #value(take, name, row, frame, playing) {
    const item = this.places.poses.children[row], own = take.rows.get(name);
    const [, bar, number] = /** @type {HTMLElement[]} */ ([
      .../** @type {Element} */ (item.firstElementChild).children,
    ]);
    const weight = take.weight(name, frame), { low, high } = own?.curve ?? { low: 0, high: 1 };
    bar.style.setProperty("--share", String((weight - low) / (high - low)));
    number.textContent = weight.toFixed(2);
    item.querySelector("ol")?.remove();
    if (row !== this.row || playing) return;
    const steps = own ? take.stepsAt(own.pose, frame) : [];
    const listed = steps.map((step) =>
      made("li", made("span", step.label), made("span", step.weight.toFixed(3)), made("span", step.why)),
    );
    const rest = own?.pose === -1 ? "played from the poses by the rig" : "at rest";
    item.append(made("ol", ...(listed.length ? listed : [made("li", rest)])));
  }
}

/** @param {import("./take.js").Take} take @param {string} name of a row @returns {string} its pair, or none */
export function pairOf(take, name) {
  const { both = "", sides } = take.rows.get(name) ?? {};
  return sides ? name : take.rows.get(both)?.sides?.[0] === name ? both : "";
}
