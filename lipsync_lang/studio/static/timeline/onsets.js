/** Onsets of a sound: moments at which it rises, where a boundary between phonemes belongs. */

/** Seconds of a frame and between frames, and around an onset that has no other. */
const FRAME = 0.01, HOP = 0.005, APART = 0.03;
/** Decibels of a rise that counts, and the floor below which there is silence. */
const RISE = 6, FLOOR = -60;

/**
 * Find the onsets of a sound, by its energy and that of its hiss.
 * @param {Int16Array} samples
 * @param {number} rate in hertz
 * @returns {number[]} seconds, rising
 */
export function onsets(samples, rate) {
  const size = Math.round(FRAME * rate), count = Math.max(0, Math.floor((samples.length / rate - FRAME) / HOP));
  const levels = Array.from({ length: count }, (_, n) => {
    const first = Math.round(n * HOP * rate);
    let whole = 0, hiss = 0;
    for (let k = first + 1; k < first + size; k++) {
      whole += samples[k] ** 2;
      hiss += (samples[k] - samples[k - 1]) ** 2;
    }
    return [whole, hiss].map((one) => Math.max(FLOOR, 10 * Math.log10(one / size / 32768 ** 2 + 1e-12)));
  });
  const rise = levels.map((_, n) => {
    if (n < 2 || n + 2 >= count) return 0;
    const [a, b, , c, d] = levels.slice(n - 2, n + 3);
    return Math.max(c[0] + d[0] - a[0] - b[0], c[1] + d[1] - a[1] - b[1]) / 2;
  });
  const reach = Math.round(APART / HOP);
  return rise.flatMap((one, n) => {
    if (one < RISE || rise.slice(Math.max(0, n - reach), n).some((other) => other >= one)) return [];
    return rise.slice(n + 1, n + reach + 1).some((other) => other > one) ? [] : [n * HOP + FRAME / 2];
  });
}

/**
 * @param {number} seconds
 * @param {number[]} places
 * @param {number} reach
 * @returns {number} the nearest place within reach, or the time itself
 */
export function snappedTo(seconds, places, reach) {
  const apart = (/** @type {number} */ one) => Math.abs(one - seconds);
  const nearest = places.reduce((best, one) => (apart(one) < apart(best) ? one : best), Infinity);
  return apart(nearest) <= reach ? nearest : seconds;
}
