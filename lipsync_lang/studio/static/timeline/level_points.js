/** Levels over time: a number, or points of seconds and value, as `perform` takes them. */

/** @typedef {[number, number]} LevelPoint seconds and value */
/** @typedef {number | LevelPoint[]} Level */

/** Seconds in which a level changes before a word, and after it. */
const RAMP = 0.06;

/**
 * @param {Level} level
 * @param {number} seconds
 * @returns {number} straight between points, level before and after them
 */
export function levelAt(level, seconds) {
  if (typeof level === "number") return level;
  const after = level.findIndex(([at]) => at > seconds);
  if (after < 0) return level[level.length - 1][1];
  if (!after) return level[0][1];
  const [a, low] = level[after - 1], [b, high] = level[after];
  return low + ((high - low) * (seconds - a)) / (b - a);
}

/** @param {Level} level @param {number} start @param {number} end @returns {LevelPoint[]} */
export function pointsOf(level, start, end) {
  return typeof level === "number" ? [[start, level], [end, level]] : level.map(([at, value]) => [at, value]);
}

/**
 * Set the level of a word; what lies around stays.
 * @param {Level} level
 * @param {number} from start of the word in seconds
 * @param {number} to its end
 * @param {number} value
 * @param {number} start of the line
 * @param {number} end
 * @returns {LevelPoint[]}
 */
export function withWord(level, from, to, value, start, end) {
  const before = Math.max(start, from - RAMP), after = Math.min(end, to + RAMP);
  const around = pointsOf(level, start, end).filter(([at]) => at < before || at > after);
  /** @type {LevelPoint[]} */
  const own = [[from, value], [to, value]];
  if (before < from) own.unshift([before, levelAt(level, before)]);
  if (after > to) own.push([after, levelAt(level, after)]);
  return rounded([...around, ...own].sort(([a], [b]) => a - b));
}

/**
 * Add a point.
 * @param {LevelPoint[]} points
 * @param {LevelPoint} point
 * @returns {[LevelPoint[], number]} the points, and the place of the new one
 */
export function withPoint(points, point) {
  const at = points.filter(([seconds]) => seconds <= point[0]).length;
  return [rounded(points.toSpliced(at, 0, point)), at];
}

/**
 * Move a point; it stays between its neighbours, and its value within the range.
 * @param {LevelPoint[]} points
 * @param {number} which
 * @param {LevelPoint} to
 * @param {number} most
 * @returns {LevelPoint[]}
 */
export function movedPoint(points, which, [seconds, value], most) {
  const low = points[which - 1]?.[0] ?? -Infinity, high = points[which + 1]?.[0] ?? Infinity;
  return rounded(points.with(which, [Math.min(Math.max(seconds, low), high), Math.min(Math.max(value, 0), most)]));
}

/** @param {LevelPoint[]} points @param {number} which @returns {Level} a number where one point is left */
export function withoutPoint(points, which) {
  const left = points.toSpliced(which, 1);
  return left.length > 1 ? left : (left[0] ?? points[0])[1];
}

/** @param {LevelPoint[]} points @returns {LevelPoint[]} in milliseconds and hundredths */
function rounded(points) {
  return points.map(([at, value]) => [Number(at.toFixed(3)), Number(value.toFixed(2))]);
}
