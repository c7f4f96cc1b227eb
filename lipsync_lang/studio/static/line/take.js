/** A take: the curves of a line, and why each value is as it is. */

/** Least change of a weight that is explained, as in `performing/trace.py`. */
const VISIBLE = 5e-4;

const FULL = 65535;

/** @typedef {{stage: string, label: string, weight: number, why: string}} Step */

/** @typedef {import("../payloads.js").Curve} Curve */
/**
 * @typedef {{pose: number, curve: Curve, both?: string, sides?: string[]}} Row a curve and its pose; -1 for a channel
 *   of a rig; a pose that moves as its mirrored one has the name of the row for `both`, whose poses are its `sides`
 */

/** Curves over time, with what is known of their making. */
export class Take {
  /** @param {import("../payloads.js").TakeData} data */
  constructor(data) {
    this.data = data;
    this.name = data.name;
    /** @type {string[]} */
    this.poses = data.poses;
    this.start = data.start;
    this.fps = data.fps;
    this.count = data.count;
    this.end = this.start + (this.count - 1) / this.fps;
    this.moved = data.channels ?? data;
    /** @type {Map<string, Row>} poses by name, mirrored ones after a row for both, and then the channels of a rig */
    this.rows = new Map(this.poses.flatMap((name, pose) => this.#posed(name, pose)));
    const { channels, making } = data;
    channels?.poses.forEach((name, n) => this.rows.set(`rig: ${name}`, { pose: -1, curve: channels.curves[n] }));
    /** @type {Uint16Array[][]} for each moving pose, its curve after each stage */
    this.stages = (making?.moving ?? []).map((_, row) => {
      /** @type {Uint16Array} */
      let last = new Uint16Array(this.count);
      return (making?.stages ?? []).map((stage) => (last = stage.curves[row] ?? last));
    });
  }

  /** @param {string} name @param {number} pose @returns {[string, Row][]} its row, after that of a pair it begins */
  #posed(name, pose) {
    const { curves, mirrored = {} } = this.data, curve = curves[pose];
    const [both, sides] = Object.entries(mirrored).find(([, pair]) => pair.includes(name)) ?? ["", [name, name]];
    const other = curves[this.poses.indexOf(sides[name === sides[0] ? 1 : 0])];
    if (!both || !other?.values.every((one, n) => one === curve.values[n])) return [[name, { pose, curve }]];
    /** @type {[string, Row]} */
    const own = [name, { pose, curve, both }];
    return name === sides[0] ? [[both, { pose, curve, sides }], own] : [own];
  }

  /** @param {number} seconds @returns {number} the nearest frame */
  frameAt(seconds) {
    return Math.max(0, Math.min(this.count - 1, Math.round((seconds - this.start) * this.fps)));
  }

  /** @param {number} frame @returns {number} seconds */
  timeOf(frame) {
    return this.start + frame / this.fps;
  }

  /** @param {string} row @param {number} frame @returns {number} */
  weight(row, frame) {
    const found = this.rows.get(row);
    return found ? level(found.curve, frame) : 0;
  }

  /**
   * Weights of the model's channels between two frames.
   * @param {number} seconds
   * @returns {Float32Array}
   */
  channelsAt(seconds) {
    const place = Math.max(0, Math.min(this.count - 1, (seconds - this.start) * this.fps));
    const low = Math.floor(place), high = Math.min(this.count - 1, low + 1), share = place - low;
    return Float32Array.from(
      this.moved.curves,
      (curve) => (1 - share) * level(curve, low) + share * level(curve, high),
    );
  }

  /** @param {number} frame @returns {Float32Array} weights of the poses */
  posesAt(frame) {
    return Float32Array.from(this.data.curves, (curve) => level(curve, frame));
  }

  /** Rows that move at any time; gestures that have a lane have no rows. @returns {string[]} */
  get moving() {
    const beside = new Set((this.data.gestures?.poses ?? []).flatMap((name) => [name, `rig: ${name}`]));
    return [...this.rows].flatMap(([name, { curve, sides = [name] }]) =>
      curve.moves && !sides.every((one) => beside.has(one)) ? [name] : []);
  }

  /** @param {number} seconds @returns {number} the phoneme of the schedule, or -1 outside */
  phonemeAt(seconds) {
    const { times } = this.data.spoken;
    if (seconds < times[0] || seconds >= times[times.length - 1]) return -1;
    return times.findLastIndex((/** @type {number} */ time) => time <= seconds);
  }

  /** @param {number} phoneme @returns {number} the word that it is in, or -1 */
  wordOf(phoneme) {
    return this.data.spoken.words.findIndex(
      (/** @type {[string, number, number]} */ [, first, stop]) => first <= phoneme && phoneme < stop,
    );
  }

  /**
   * Say what is spoken at a frame.
   * @param {number} frame
   */
  soundAt(frame) {
    const { labels, times, words } = this.data.spoken;
    const { making } = this.data;
    const at = making ? making.phoneme[frame] : -1;
    const phoneme = making ? making.source[at] : this.phonemeAt(this.timeOf(frame));
    const word = phoneme < 0 ? -1 : this.wordOf(phoneme);
    return {
      label: phoneme < 0 ? "_" : labels[phoneme],
      common: making ? making.common[at] : "",
      start: making ? making.bounds[at] : times[Math.max(0, phoneme)],
      end: making ? making.bounds[at + 1] : times[phoneme + 1],
      word: word < 0 ? "" : words[word][0],
    };
  }

  /**
   * List the bigrams that cover a frame: the one that ends, and the one that begins.
   * @param {number} frame
   * @returns {import("../payloads.js").PlacedBigram[]}
   */
  bigramsAt(frame) {
    const { making } = this.data;
    if (!making) return [];
    const at = making.phoneme[frame];
    return [at - 1, at].flatMap((number, side) => {
      const place = making.places[side][frame];
      return place === FULL ? [] : [{ ...making.bigrams[making.said[number]], side, position: place / FULL }];
    });
  }

  /**
   * Explain the weight of a pose at a frame, stage by stage.
   * @param {number} pose
   * @param {number} frame
   * @returns {Step[]}
   */
  stepsAt(pose, frame) {
    const { making } = this.data;
    const row = making ? making.moving.indexOf(pose) : -1;
    if (!making || row < 0) return [];
    let before = 0;
    return making.stages.flatMap((stage, /** @type {number} */ number) => {
      const weight = this.stages[row][number][frame] / FULL;
      const changed = Math.abs(weight - before) > VISIBLE;
      before = weight;
      return changed
        ? [{ stage: stage.name, label: stage.label, weight, why: this.#why(stage, row, pose, frame) }]
        : [];
    });
  }

  /**
   * @param {import("../payloads.js").Stage} stage
   * @param {number} row
   * @param {number} pose
   * @param {number} frame
   * @returns {string}
   */
  #why(stage, row, pose, frame) {
    const { making } = this.data;
    if (making && stage.name === "stitch") {
      return this.bigramsAt(frame)
        .map(({ pair, side }) => `${pair} gives ${(making.given[side][row][frame] / FULL).toFixed(3)}`)
        .join(", ");
    }
    if (making && stage.name === "dial") {
      const told = making.dials
        .filter((dial) => dial.poses.includes(pose) && Math.abs(dial.level[frame] - 1) > VISIBLE)
        .map((dial) => `${dial.name} x ${dial.level[frame].toFixed(2)}`);
      return `scaled by ${told.join(", ")}`;
    }
    const run = stage.reasons[row].find(
      (/** @type {[number, number, string]} */ [first, stop]) => first <= frame && frame < stop,
    );
    return run ? run[2] : stage.why;
  }
}

/** @param {{low: number, high: number, values: Uint16Array}} curve @param {number} frame */
function level(curve, frame) {
  return curve.low + ((curve.high - curve.low) * curve.values[frame]) / FULL;
}
