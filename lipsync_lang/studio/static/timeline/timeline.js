/**
 * Timeline on a canvas: sound, words, phonemes, and a row for each pose with its stages.
 *
 * What does not move is drawn once for each view; the playhead is drawn over it.
 */

import { HATCHES } from "../shell/elements.js";
import { clock, outline, ticks, within } from "./scales.js";
import { Spectrogram } from "./spectrogram.js";
import { listen } from "./timeline_hands.js";

const RULER = 24, BAND = 22, GAP = 8;
/** Heights of the wave and of the spectrogram, by what of a sound is seen. */
const SOUNDS = /** @type {const} */ ({ wave: [52, 0], spectrogram: [0, 84], both: [44, 84] });
/** Least share of its usual width to which a label is squeezed before it is shortened. */
const SQUEEZE = 0.75;
const NARROW = 600;
/** Pixels per second at which phonemes can be read: with a pointer that shows the rest, and without. */
const READABLE = 110, NARROW_READABLE = 190;
/** Least pixels between boundaries that are drawn. */
const APART = 4;
const FULL = 65535;

/**
 * @typedef {{take: import("../line/take.js").Take, other: import("../line/take.js").Take | null,
 *   sound: import("../line/player.js").Sound | null, rows: string[], marked?: [number, number][]}} Line
 *   `marked` are spans of time in the rows
 */
/**
 * Actions of a timeline: seek, describe a place under the pointer, pick a row, and report that its view moved.
 *   Optional: `scrub` seeks in a drag. Drags move what is grabbed (`drag`, at the end with `done`). Clicks choose one
 *   (`word`, `phoneme`), and a double click is `open`. Keys on a pose are drawn (`keys`), taken (`press`) and dragged
 *   (`pull`).
 * @typedef {{seek: (seconds: number) => void, hover: (at: {seconds: number, row: number, x: number, y: number} |
 *   null) => void,
 *   pick: (row: number) => void, moved: () => void,
 *   scrub?: (seconds: number) => void,
 *   drag?: (grab: import("./timeline_hands.js").Grab, seconds: number, done: boolean, event: PointerEvent) => void,
 *   press?: (x: number, y: number, event: PointerEvent) => boolean,
 *   pull?: (x: number, y: number, done: boolean) => void,
 *   keys?: (pose: string) => {shown: [number, number][], chosen?: number | null},
 *   word?: (word: number, more: boolean) => void, phoneme?: (phoneme: number, more: boolean) => void,
 *   open?: (seconds: number, row: number, phoneme: number) => void}} Hands
 */

/** A timeline; times are seconds. */
export class Timeline {
  /** @param {HTMLCanvasElement} canvas @param {Hands} does */
  constructor(canvas, does) {
    this.canvas = canvas;
    this.does = does;
    this.layer = document.createElement("canvas");
    this.stale = true;
    this.row = -1;
    /** The boundary, the word and the phoneme that are chosen; -1 for none. */
    this.boundary = -1;
    this.word = -1;
    this.phoneme = -1;
    /** The last phoneme of a chosen range, or the chosen one. */
    this.until = -1;
    /** Names of stages that are not drawn. @type {Set<string>} */
    this.hidden = new Set();
    /** The picture of the sound. @type {keyof typeof SOUNDS} */
    this.sounds = "wave";
    /** @type {Spectrogram | null} */
    this.spectrogram = null;
    /** @type {[number, number] | null} */
    this.loop = null;
    /** @type {Line | null} */
    this.shown = null;
    /** False until the line was fitted to a canvas that is seen. */
    this.fitted = false;
    /** The line, and the part of it in view. */
    this.start = 0;
    this.end = 1;
    this.from = 0;
    this.to = 1;
    this.height = 0;
    /** Height of a row in pixels of the page; 0 for the usual. */
    this.tall = 0;
    /**
     * Width of the canvas in pixels of the page; asking the page for it at every point would lay it out again each
     *   time.
     */
    this.wide = canvas.clientWidth;
    this.loudest = 0;
    this.font = "sans-serif";
    /** @type {Record<string, string>} */
    this.colours = {};
    listen(this);
  }

  /**
   * Show a line.
   * @param {Line} line
   */
  show(line) {
    const first = !this.shown;
    if (this.shown?.sound !== line.sound) this.loudest = 0;
    this.shown = line;
    this.wide = this.canvas.clientWidth;
    const { take, other } = line;
    const start = Math.min(take.start, other?.start ?? take.start), end = Math.max(take.end, other?.end ?? take.end);
    this.start = start;
    this.end = Math.max(end, start + 0.1);
    if (first) this.fitted = false;
    if (first && this.wide) this.fit();
    this.stale = true;
  }

  /** @returns {Line} */
  get line() {
    if (!this.shown) throw new Error("a timeline is shown a line before it is drawn");
    return this.shown;
  }

  /** Show the line, or as much of its beginning as can be read. */
  fit() {
    this.fitted = true;
    this.setView(
      this.start,
      this.start + Math.min(this.end - this.start, this.plotWidth / (this.narrow ? NARROW_READABLE : READABLE)),
    );
  }

  /** @param {number} from @param {number} to */
  setView(from, to) {
    [this.from, this.to] = within(from, to, this.start, this.end, Math.min(0.1, this.end - this.start));
    this.stale = true;
    this.does.moved();
  }

  /** @param {number} factor above 1 shows less @param {number} about seconds that stay in place */
  zoom(factor, about) {
    const left = (about - this.from) / factor, right = (this.to - about) / factor;
    this.setView(about - left, about + right);
  }

  /** @param {number} seconds to keep in view while playing */
  follow(seconds) {
    const length = this.to - this.from;
    if (seconds < this.from || seconds > this.to - 0.08 * length) {
      if (length < this.end - this.start - 1e-6) this.setView(seconds - 0.1 * length, seconds + 0.9 * length);
    }
  }

  get left() {
    return this.narrow ? 6 : 104;
  }

  /** True where names stand above their rows, not beside them. */
  get narrow() {
    return this.wide < NARROW;
  }

  get plotWidth() {
    return Math.max(50, this.wide - this.left - 8);
  }

  get top() {
    const [wave, spectrogram] = SOUNDS[this.sounds];
    return RULER + (this.line.sound ? wave + spectrogram : 0) + 3 * BAND + GAP;
  }

  /** Top of the words; phonemes and mouths follow below. */
  get bandTop() {
    return this.top - GAP - 3 * BAND;
  }

  get rowHeight() {
    return this.tall || (this.narrow ? 54 : 50);
  }

  /** @param {number} seconds @returns {number} */
  x(seconds) {
    return this.left + ((seconds - this.from) / (this.to - this.from)) * this.plotWidth;
  }

  /** @param {number} x @returns {number} seconds */
  at(x) {
    return this.from + ((x - this.left) / this.plotWidth) * (this.to - this.from);
  }

  /** @param {number} row @returns {[number, number]} the bottom of a pose and its height, in pixels */
  #place(row) {
    return [this.top + (row + 1) * this.rowHeight - 6, this.rowHeight - (this.narrow ? 18 : 10)];
  }

  /** @param {number} row @param {number} weight @returns {number} */
  y(row, weight) {
    const [bottom, tall] = this.#place(row);
    return bottom - weight * tall;
  }

  /** @param {number} row @param {number} y @returns {number} weight */
  weightAt(row, y) {
    const [bottom, tall] = this.#place(row);
    return (bottom - y) / tall;
  }

  /** @param {number} seconds of the playhead */
  draw(seconds) {
    const { canvas } = this;
    this.wide = canvas.clientWidth;
    if (!this.wide) return; // not seen
    if (!this.fitted) {
      this.fit();
      this.follow(seconds);
    }
    const ratio = Math.min(3, window.devicePixelRatio || 1);
    const height = this.top + this.line.rows.length * this.rowHeight + 4;
    const wide = Math.round(this.wide * ratio), high = Math.round(height * ratio);
    if (canvas.width !== wide || canvas.height !== high) {
      canvas.style.height = `${height}px`;
      [canvas.width, canvas.height] = [wide, high];
      this.setView(this.from, this.to);
    }
    if (this.stale) {
      this.stale = false; // drawing may need another frame
      this.#drawLayer(wide, high, ratio, height);
    }
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, wide, high);
    context.drawImage(this.layer, 0, 0);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const x = this.x(seconds);
    if (x < this.left - 1 || x > this.wide) return;
    context.fillStyle = this.colours.accent;
    context.fillRect(x - 0.75, 8, 1.5, height);
    context.beginPath();
    context.moveTo(x - 6, 2); context.lineTo(x + 6, 2); context.lineTo(x, 11);
    context.fill();
  }

  /** @param {number} wide @param {number} high @param {number} ratio @param {number} height */
  #drawLayer(wide, high, ratio, height) {
    [this.layer.width, this.layer.height] = [wide, high];
    const context = /** @type {CanvasRenderingContext2D} */ (this.layer.getContext("2d"));
    const style = getComputedStyle(this.canvas);
    const colour = (/** @type {string} */ name) => style.getPropertyValue(`--${name}`).trim();
    this.colours = Object.fromEntries(
      ["ink", "soft", "rule", "accent", "raised", "paper", "other", "fail", "wave"].map((name) => [name, colour(name)]),
    );
    this.font = style.fontFamily;
    context.scale(ratio, ratio);
    this.height = height;
    this.#grounds(context);
    this.#ruler(context);
    this.#sound(context);
    this.#bands(context);
    this.line.rows.forEach((name, row) => this.#pose(context, name, row));
    this.#chosen(context);
  }

  /** @param {CanvasRenderingContext2D} context @param {() => void} draw within the plot */
  #clipped(context, draw) {
    context.save();
    context.beginPath();
    context.rect(this.left, 0, this.plotWidth + 8, this.height);
    context.clip();
    draw();
    context.restore();
  }

  /** @param {CanvasRenderingContext2D} context */
  #grounds(context) {
    const { take } = this.line, { times, words } = take.data.spoken;
    this.#clipped(context, () => {
      words.forEach((/** @type {[string, number, number]} */ [, first, stop], /** @type {number} */ n) => {
        if (n % 2 || this.x(times[stop]) - this.x(times[first]) < APART) return;
        context.fillStyle = this.colours.raised;
        const x = this.x(times[first]);
        context.fillRect(x, RULER, this.x(times[stop]) - x, this.height);
      });
      context.fillStyle = this.colours.accent;
      context.globalAlpha = 0.14;
      for (const [from, to] of this.line.marked ?? [])
        context.fillRect(this.x(from), this.bandTop, this.x(to) - this.x(from), this.height);
      context.globalAlpha = 1;
      if (this.loop) {
        const [a, b] = this.loop.map((one) => this.x(one));
        context.fillStyle = this.colours.accent;
        context.globalAlpha = 0.18;
        context.fillRect(a, 0, b - a, RULER);
        context.globalAlpha = 0.06;
        context.fillRect(a, RULER, b - a, this.height);
        context.globalAlpha = 1;
      }
    });
  }

  /** @param {CanvasRenderingContext2D} context */
  #ruler(context) {
    const { soft, rule } = this.colours;
    context.font = `11px ${this.font}`;
    context.fillStyle = soft;
    context.textBaseline = "top";
    context.textAlign = "center";
    const marks = ticks(this.from, this.to, this.plotWidth / 70);
    const step = marks.length > 1 ? marks[1] - marks[0] : 1;
    const digits = step < 0.0995 ? 2 : step < 0.995 ? 1 : 0;
    for (const mark of marks) {
      const x = this.x(mark);
      context.fillStyle = rule;
      context.fillRect(x, RULER - 7, 1, 5);
      context.fillStyle = soft;
      if (x > this.left + 12) context.fillText(clock(mark, digits), x, 3);
    }
    this.#findings(context);
  }

  /** @param {CanvasRenderingContext2D} context */
  #findings(context) {
    this.#clipped(context, () => {
      const missedLast = this.line.take.data.figures.toSorted(
        (a, b) => Number(a.verdict === "FAIL") - Number(b.verdict === "FAIL"),
      );
      for (const { verdict, findings } of missedLast) {
        for (const [seconds] of findings) {
          const x = this.x(seconds), y = RULER - 4;
          context.fillStyle = verdict === "FAIL" ? this.colours.fail : this.colours.soft;
          context.beginPath();
          if (verdict === "FAIL") {
            context.moveTo(x - 5, y + 4);
            context.lineTo(x + 5, y + 4);
            context.lineTo(x, y - 5);
          } else context.arc(x, y, 2.5, 0, 7);
          context.fill();
        }
      }
    });
  }

  /** @param {CanvasRenderingContext2D} context */
  #sound(context) {
    const [wave, spectrogram] = SOUNDS[this.sounds];
    if (spectrogram) this.#spectrogram(context, RULER + wave, spectrogram);
    if (!this.line.sound || !wave) return;
    const { samples, rate, start = 0 } = this.line.sound;
    const columns = Math.round(this.plotWidth);
    const shape = outline(samples, rate, this.from - start, this.to - start, columns);
    this.loudest ||= Math.max(0.05, samples.reduce((top, one) => Math.max(top, Math.abs(one)), 0) / 32768);
    const most = this.loudest;
    const middle = RULER + wave / 2;
    context.fillStyle = this.colours.wave;
    shape.forEach(([low, high], column) => {
      const up = (high / most) * (wave / 2 - 3), down = (low / most) * (wave / 2 - 3);
      context.fillRect(this.left + column, middle - up, 1, Math.max(1, up - down));
    });
    if (!this.narrow) this.#name(context, "sound", middle);
  }

  /** @param {CanvasRenderingContext2D} context @param {number} top @param {number} tall */
  #spectrogram(context, top, tall) {
    const { sound } = this.line, { ink } = this.colours;
    if (!sound) return;
    if (this.spectrogram?.sound !== sound || this.spectrogram.colour !== ink)
      this.spectrogram = new Spectrogram(sound, ink);
    const { spectrogram } = this;
    this.#clipped(context, () => {
      if (spectrogram.draw(context, (seconds) => this.x(seconds), [this.from, this.to], top + 1, tall - 2)) return;
      this.stale = true; // the rest is drawn in the next frame
      this.does.moved();
    });
    if (!this.narrow) this.#name(context, "0 to 8 kHz", top + tall / 2);
  }

  /** @param {CanvasRenderingContext2D} context */
  #bands(context) {
    const { take } = this.line, { times, labels, words } = take.data.spoken, { making } = take.data;
    const top = this.bandTop;
    /** @type {[string, [string, number, number][], number][]} */
    const bands = [
      ["words", words.map((/** @type {[string, number, number]} */ [text, a, b]) => [text, times[a], times[b]]), 13],
      [
        "phonemes",
        labels.map((/** @type {string} */ text, /** @type {number} */ n) => [text, times[n], times[n + 1]]),
        12,
      ],
      [
        "mouths",
        making ? making.common.map((text, n) => [text, making.bounds[n], making.bounds[n + 1]]) : [],
        11,
      ],
    ];
    bands.forEach(([name, spans, size], band) => {
      const y = top + band * BAND;
      if (!this.narrow) this.#name(context, name, y + BAND / 2);
      context.fillStyle = this.colours.rule;
      context.fillRect(this.left, y, this.plotWidth + 8, 1);
      this.#clipped(context, () => {
        context.font = `${size}px ${this.font}`;
        context.textAlign = "center";
        context.textBaseline = "middle";
        for (const [text, a, b] of spans) {
          const low = this.x(a), high = this.x(b);
          if (high < this.left || low > this.left + this.plotWidth + 8) continue;
          if (high - low < APART) continue;
          context.fillStyle = this.colours.rule;
          context.fillRect(low, y, 1, BAND);
          context.fillRect(high, y, 1, BAND);
          context.fillStyle = band === 2 ? this.colours.soft : this.colours.ink;
          const room = high - low - 1;
          context.fillText(shortened(context, text, room), (low + high) / 2, y + BAND / 2 + 1, room);
        }
      });
    });
  }

  /** @param {CanvasRenderingContext2D} context @param {string} text @param {number} y */
  #name(context, text, y) {
    context.font = `12px ${this.font}`;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillStyle = this.colours.soft;
    let shown = text;
    for (let kept = text.length - 1; kept > 2 && context.measureText(shown).width > this.left - 10; kept--) {
      shown = `${text.slice(0, Math.ceil(kept / 2))}…${text.slice(text.length - Math.floor(kept / 2))}`;
    }
    context.fillText(shown, this.left - 8, y);
  }

  /** @param {CanvasRenderingContext2D} context @param {string} text @param {number} y */
  #above(context, text, y) {
    context.font = `11px ${this.font}`;
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.fillStyle = this.colours.soft;
    context.fillText(text, this.left + 2, y);
  }

  /** @param {CanvasRenderingContext2D} context @param {string} name @param {number} row */
  #pose(context, name, row) {
    const { take, other } = this.line;
    const [bottom, tall] = this.#place(row);
    if (row === this.row) {
      context.fillStyle = this.colours.accent;
      context.globalAlpha = 0.08;
      context.fillRect(0, bottom - tall - 4, this.wide, this.rowHeight);
      context.globalAlpha = 1;
    }
    if (!this.narrow) this.#name(context, name, bottom - tall / 2);
    context.fillStyle = this.colours.rule;
    context.fillRect(this.left, bottom, this.plotWidth + 8, 1);
    this.#clipped(context, () => {
      const own = take.rows.get(name), same = other?.rows.get(name);
      const rank = own && own.pose >= 0 ? take.data.making?.moving.indexOf(own.pose) ?? -1 : -1;
      const place = (/** @type {Uint16Array} */ values) => ({ values, take, bottom, tall });
      if (rank >= 0) this.#stages(context, rank, bottom, tall);
      if (own) this.#curve(context, place(own.curve.values), this.colours.ink, 1.8, []);
      if (other && same) {
        this.#curve(context, { ...place(same.curve.values), take: other }, this.colours.other, 1.8, [5, 3]);
      }
      this.#keys(context, name, row);
    });
    if (this.narrow) this.#above(context, name, bottom - tall - 5);
  }

  /** @param {CanvasRenderingContext2D} context @param {string} name @param {number} row */
  #keys(context, name, row) {
    const { shown, chosen = null } = this.does.keys?.(name) ?? { shown: [] };
    context.lineWidth = 2;
    shown.forEach(([at, weight], n) => {
      context.beginPath();
      context.arc(this.x(at), this.y(row, weight), 4.5, 0, 7);
      context.fillStyle = n === chosen ? this.colours.accent : this.colours.paper;
      context.strokeStyle = this.colours.accent;
      context.fill();
      context.stroke();
    });
  }

  /** @param {CanvasRenderingContext2D} context @param {number} rank @param {number} bottom @param {number} tall */
  #stages(context, rank, bottom, tall) {
    const { take } = this.line, curves = take.stages[rank], stages = take.data.making?.stages ?? [];
    const place = (/** @type {Uint16Array} */ values) => ({ values, take, bottom, tall });
    const last = this.#path(place(curves[curves.length - 1]));
    this.#area(context, last, last.map(([x]) => [x, bottom]), this.colours.wave, 0.22);
    curves.forEach((curve, number) => {
      if (number && curve !== curves[number - 1] && !this.hidden.has(stages[number].name)) {
        this.#area(
          context,
          this.#path(place(curve)),
          this.#path(place(curves[number - 1])),
          hatched(context, stages[number].colour, stages[number].hatch),
          0.85,
        );
      }
    });
    this.#curve(context, place(curves[0]), this.colours.soft, 1, [1, 2]);
  }

  /**
   * @param {{values: Uint16Array, take: import("../line/take.js").Take, bottom: number, tall: number}} curve
   * @returns {[number, number][]}
   */
  #path({ values, take, bottom, tall }) {
    const first = Math.max(0, Math.floor((this.from - take.start) * take.fps) - 1);
    const stop = Math.min(take.count, Math.ceil((this.to - take.start) * take.fps) + 2);
    const stride = Math.max(1, Math.floor((stop - first) / (2 * this.plotWidth)));
    /** @type {[number, number][]} */
    const found = [];
    for (let n = first; n < stop; n += stride) {
      let most = values[n];
      for (let k = n + 1; k < Math.min(stop, n + stride); k++) most = Math.max(most, values[k]);
      found.push([this.x(take.timeOf(n)), bottom - (most / FULL) * tall]);
    }
    return found;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {[number, number][]} over
   * @param {number[][]} under
   * @param {string | CanvasPattern} colour
   * @param {number} alpha
   */
  #area(context, over, under, colour, alpha) {
    context.beginPath();
    for (const [x, y] of over) context.lineTo(x, y);
    for (const [x, y] of under.slice().reverse()) context.lineTo(x, y);
    context.globalAlpha = alpha;
    context.fillStyle = colour;
    context.fill();
    context.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {{values: Uint16Array, take: import("../line/take.js").Take, bottom: number, tall: number}} curve
   * @param {string} colour
   * @param {number} width
   * @param {number[]} dashes
   */
  #curve(context, curve, colour, width, dashes) {
    context.beginPath();
    for (const [x, y] of this.#path(curve)) context.lineTo(x, y);
    context.setLineDash(dashes);
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.stroke();
    context.setLineDash([]);
  }

  /** @param {CanvasRenderingContext2D} context */
  #chosen(context) {
    const { times, words, emphasis, doubts } = this.line.take.data.spoken;
    this.#clipped(context, () => {
      context.strokeStyle = this.colours.fail;
      context.lineWidth = 1.5;
      for (const [, first, stop] of words.filter((_, n) => n in doubts))
        wavy(context, this.x(times[first]) + 2, this.x(times[stop]) - 2, this.bandTop + BAND - 3);
      context.strokeStyle = context.fillStyle = this.colours.accent;
      context.lineWidth = 2;
      words.forEach((/** @type {[string, number, number]} */ [, first, stop], /** @type {number} */ n) => {
        const low = this.x(times[first]), high = this.x(times[stop]);
        if (emphasis?.[n])
          context.fillRect(low + 2, this.bandTop + BAND - 4, Math.max(2, high - low - 4), 1 + 1.5 * emphasis[n]);
        if (n === this.word) context.strokeRect(low + 1, this.bandTop + 1, high - low - 2, BAND - 2);
      });
      if (this.phoneme >= 0 && this.phoneme + 1 < times.length) {
        const stop = Math.min(Math.max(this.until, this.phoneme) + 1, times.length - 1);
        const low = this.x(times[this.phoneme]), high = this.x(times[stop]);
        context.strokeRect(low + 1, this.bandTop + BAND + 1, high - low - 2, BAND - 2);
      }
      if (this.boundary < 0 || this.boundary >= times.length) return;
      const x = this.x(times[this.boundary]), y = this.bandTop + BAND;
      context.fillRect(x - 1, y, 2, this.height - y);
      context.beginPath();
      context.roundRect(x - 4, y + 3, 8, BAND - 6, 3);
      context.fill();
    });
  }

  /**
   * @param {number} x
   * @param {number} y
   * @param {number} reach pixels
   * @returns {number} the nearest boundary of phonemes there, or -1
   */
  boundaryAt(x, y, reach) {
    const down = y - this.bandTop - BAND;
    if (!this.shown || down < -reach / 4 || down > 2 * BAND) return -1;
    const { times } = this.line.take.data.spoken;
    let nearest = -1, least = reach;
    times.forEach((/** @type {number} */ time, /** @type {number} */ n) => {
      const apart = Math.abs(this.x(time) - x);
      if (apart < least) [nearest, least] = [n, apart];
    });
    return nearest;
  }

  /** @param {number} x @param {number} y @returns {number} the word there, or -1 */
  wordAt(x, y) {
    if (!this.shown || y < this.bandTop || y >= this.bandTop + BAND) return -1;
    const { times, words } = this.line.take.data.spoken, seconds = this.at(x);
    return words.findIndex(
      (/** @type {[string, number, number]} */ [, first, stop]) => times[first] <= seconds && seconds < times[stop],
    );
  }

  /** @param {number} x @param {number} y @returns {number} the phoneme there, or -1 */
  phonemeAt(x, y) {
    const down = y - this.bandTop - BAND;
    return this.shown && down >= 0 && down < BAND ? this.line.take.phonemeAt(this.at(x)) : -1;
  }

  /** @param {number} y @returns {number} the row there, or -1 */
  rowAt(y) {
    const row = Math.floor((y - this.top) / this.rowHeight);
    return row >= 0 && row < this.line.rows.length ? row : -1;
  }
}

/** @type {Map<string, CanvasPattern>} */
const patterns = new Map();

/**
 * Make the colour of a stage, with lines that tell it from its neighbours without the colour.
 * @param {CanvasRenderingContext2D} context @param {string} colour @param {number} number of the stage
 * @returns {string | CanvasPattern}
 */
function hatched(context, colour, number) {
  const ways = HATCHES[number % HATCHES.length], key = `${colour} ${ways}`;
  let known = patterns.get(key);
  if (known || !ways.length) return known ?? colour;
  const tile = document.createElement("canvas"), side = (tile.width = tile.height = 6);
  const pen = /** @type {CanvasRenderingContext2D} */ (tile.getContext("2d"));
  pen.fillStyle = colour;
  pen.fillRect(0, 0, side, side);
  pen.strokeStyle = "#222c";
  for (const way of ways) {
    pen.beginPath();
    for (const by of [-side, 0, side]) {
      const at = by + side / 2;
      if (way === 0) { pen.moveTo(0, at); pen.lineTo(side, at); }
      else if (way === 90) { pen.moveTo(at, 0); pen.lineTo(at, side); }
      else { pen.moveTo(by, way > 0 ? side : 0); pen.lineTo(by + side, way > 0 ? 0 : side); }
    }
    pen.stroke();
  }
  known = /** @type {CanvasPattern} */ (context.createPattern(tile, "repeat"));
  patterns.set(key, known);
  return known;
}

/** @param {CanvasRenderingContext2D} context @param {string} text @param {number} room pixels @returns {string} */
function shortened(context, text, room) {
  const signs = [...text];
  let shown = text;
  for (let kept = signs.length - 1; kept > 0 && context.measureText(shown).width * SQUEEZE > room; kept--)
    shown = `${signs.slice(0, kept).join("")}…`;
  return shown;
}

/**
 * Underline what is in doubt.
 * @param {CanvasRenderingContext2D} context @param {number} x @param {number} to @param {number} y
 */
function wavy(context, x, to, y) {
  context.beginPath();
  context.moveTo(x, y);
  for (let n = 1; x + 2 * n <= to; n++) context.lineTo(x + 2 * n, y + (n % 2 ? -2 : 1));
  context.stroke();
}
