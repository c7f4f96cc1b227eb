/** Numbers for drawing: ticks, times as text, and the outline of a sound. */

/**
 * Choose round numbers on an axis.
 * @param {number} low
 * @param {number} high
 * @param {number} most how many at most
 * @returns {number[]}
 */
export function ticks(low, high, most) {
  const rough = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough * (1 - 1e-9)) ?? 10 * power;
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9; n++)
    found.push(Number((n * step).toPrecision(12)));
  return found;
}

/** @param {number} seconds @param {number} digits @returns {string} such as 0.50 s, or 1:02.50 */
export function clock(seconds, digits = 2) {
  const size = Math.abs(seconds), sign = seconds < 0 ? "−" : "";
  if (size < 60) return `${sign}${size.toFixed(digits)} s`;
  const minutes = Math.floor(size / 60);
  return `${sign}${minutes}:${(size - 60 * minutes).toFixed(digits).padStart(digits ? digits + 3 : 2, "0")}`;
}

/**
 * Lowest and highest sample of each column of a picture, in [-1, 1].
 * @param {Int16Array} samples
 * @param {number} rate in hertz
 * @param {number} from seconds at the left
 * @param {number} to seconds at the right
 * @param {number} columns
 * @returns {[number, number][]}
 */
export function outline(samples, rate, from, to, columns) {
  const step = ((to - from) / columns) * rate;
  return Array.from({ length: columns }, (_, column) => {
    const first = Math.floor(from * rate + column * step),
      stop = Math.max(first + 1, Math.floor(from * rate + (column + 1) * step));
    const stride = Math.max(1, Math.floor((stop - first) / 64));
    let low = 0, high = 0;
    for (let n = Math.max(0, first); n < Math.min(samples.length, stop); n += stride) {
      low = Math.min(low, samples[n]);
      high = Math.max(high, samples[n]);
    }
    return [low / 32768, high / 32768];
  });
}

/**
 * Keep a span of time within a line, and no shorter than a least.
 * @param {number} from
 * @param {number} to
 * @param {number} start
 * @param {number} end
 * @param {number} least
 * @returns {[number, number]}
 */
export function within(from, to, start, end, least = 0.1) {
  const length = Math.min(end - start, Math.max(least, to - from));
  const first = Math.min(Math.max(start, from), end - length);
  return [first, first + length];
}
