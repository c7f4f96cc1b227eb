/** Spectrogram of a sound: its frequencies over time, drawn once in pieces, and then scaled to any view. */

/** Samples of a transform, seconds of its window and between two columns, and of a piece. */
const SIZE = 512, WINDOW = 0.011, HOP = 0.004, PIECE = 2;
/** Highest frequency in hertz, and the decibels below the loudest that are seen. */
const TOP = 8000, RANGE = 60;
/** Pieces that are drawn in one frame; the others follow. */
const AT_ONCE = 3;

/**
 * Transform real numbers in place of a pair of arrays.
 * @param {Float32Array} real
 * @param {Float32Array} imaginary
 */
export function transform(real, imaginary) {
  const size = real.length;
  for (let i = 1, j = 0; i < size; i++) {
    let bit = size >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j |= bit;
    if (i < j) [real[i], real[j]] = [real[j], real[i]];
  }
  for (let length = 2; length <= size; length *= 2) {
    const angle = (-2 * Math.PI) / length;
    for (let k = 0; k < length / 2; k++) {
      const cos = Math.cos(angle * k), sin = Math.sin(angle * k);
      for (let first = k; first < size; first += length) {
        const second = first + length / 2;
        const a = real[second] * cos - imaginary[second] * sin, b = real[second] * sin + imaginary[second] * cos;
        real[second] = real[first] - a;
        imaginary[second] = imaginary[first] - b;
        real[first] += a;
        imaginary[first] += b;
      }
    }
  }
}

/** The spectrogram of one sound, in one colour. */
export class Spectrogram {
  /** @param {import("../line/player.js").Sound} sound @param {string} colour of its loudest places */
  constructor(sound, colour) {
    this.sound = sound;
    this.colour = colour;
    this.bins = Math.min(SIZE / 2, Math.round((TOP / sound.rate) * SIZE));
    /** @type {Map<number, HTMLCanvasElement>} */
    this.pieces = new Map();
    this.loudest = sound.samples.reduce((top, one) => Math.max(top, Math.abs(one)), 1);
  }

  /**
   * Draw the part in view.
   * @param {CanvasRenderingContext2D} context
   * @param {(seconds: number) => number} x of a time
   * @param {[number, number]} view seconds @param {number} top @param {number} tall
   * @returns {boolean} true once all of it is drawn
   */
  draw(context, x, [from, to], top, tall) {
    const start = this.sound.start ?? 0, end = this.sound.samples.length / this.sound.rate;
    let left = AT_ONCE;
    for (let n = Math.max(0, Math.floor((from - start) / PIECE)); n * PIECE < Math.min(to - start, end); n++) {
      if (!this.pieces.has(n)) {
        if (!left) return false;
        left -= 1;
        this.pieces.set(n, this.#piece(n));
      }
      const low = x(start + n * PIECE), high = x(start + (n + 1) * PIECE);
      context.drawImage(/** @type {HTMLCanvasElement} */ (this.pieces.get(n)), low, top, high - low, tall);
    }
    return true;
  }

  /** @param {number} number @returns {HTMLCanvasElement} */
  #piece(number) {
    const columns = Math.round(PIECE / HOP), canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [columns, this.bins];
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const image = context.createImageData(columns, this.bins);
    for (let column = 0; column < columns; column++) {
      this.#levels(number * PIECE + column * HOP).forEach((level, bin) => {
        image.data[4 * ((this.bins - 1 - bin) * columns + column) + 3] = 255 * Math.min(1, Math.max(0, level));
      });
    }
    context.putImageData(image, 0, 0);
    context.globalCompositeOperation = "source-in";
    context.fillStyle = this.colour;
    context.fillRect(0, 0, columns, this.bins);
    return canvas;
  }

  /** @param {number} seconds of the sound @returns {Float32Array} of each bin: 0 for silent, 1 for loudest */
  #levels(seconds) {
    const { samples, rate } = this.sound, real = new Float32Array(SIZE), imaginary = new Float32Array(SIZE);
    const width = Math.min(SIZE, Math.round(WINDOW * rate)), first = Math.round(seconds * rate - width / 2);
    for (let n = 0; n < width; n++) {
      const hann = 0.5 - 0.5 * Math.cos((2 * Math.PI * (n + 0.5)) / width);
      // the difference lifts the high frequencies, which are softer in speech
      real[n] = hann * ((samples[first + n] ?? 0) - 0.95 * (samples[first + n - 1] ?? 0));
    }
    transform(real, imaginary);
    const most = this.loudest * width * 0.1;
    return Float32Array.from({ length: this.bins }, (_, bin) =>
      1 + (20 * Math.log10(Math.hypot(real[bin], imaginary[bin]) / most + 1e-9)) / RANGE);
  }
}
