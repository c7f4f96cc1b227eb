/** Keys that bend a pose of a line: seconds and the amount that is added, smooth between them and faded at the ends. */

/** Seconds in which a bend fades, as in `pipeline/bend.py`, and within which two keys are one. */
const FADE = 0.12, SAME = 0.012;

/** @typedef {[number, number]} Key seconds and amount */

/**
 * Set the amount at a moment; what lies farther away stays.
 * @param {Key[]} keys
 * @param {number} seconds
 * @param {number} amount
 * @returns {[Key[], number]} the keys, and the place of the one that is set
 */
export function withKey(keys, seconds, amount) {
  const known = keys.findIndex(([at]) => Math.abs(at - seconds) < SAME);
  if (known >= 0) return [rounded(keys.with(known, [keys[known][0], amount])), known];
  const before = keys.findLast(([at]) => at < seconds), after = keys.find(([at]) => at > seconds);
  /** @type {Key} */
  const key = [seconds, amount], own = [key];
  if (before && seconds - before[0] > 2 * FADE) own.unshift([before[0] + FADE, 0], [seconds - FADE, 0]);
  if (after && after[0] - seconds > 2 * FADE) own.push([seconds + FADE, 0], [after[0] - FADE, 0]);
  const every = [...keys, ...own].sort(([a], [b]) => a - b);
  return [rounded(every), every.indexOf(key)];
}

/**
 * Move a key between its neighbours.
 * @param {Key[]} keys @param {number} which @param {number} seconds @param {number} amount
 * @returns {Key[]}
 */
export function withMoved(keys, which, seconds, amount) {
  const low = keys[which - 1]?.[0] ?? -Infinity, high = keys[which + 1]?.[0] ?? Infinity;
  const at = Math.min(Math.max(seconds, low), high);
  return rounded(keys.with(which, [at, Math.min(1, Math.max(-1, amount))]));
}

/** @param {Key[]} keys @returns {Key[]} in tenths of milliseconds and thousandths */
function rounded(keys) {
  return keys.map(([at, amount]) => [Number(at.toFixed(4)), Number(amount.toFixed(3))]);
}
