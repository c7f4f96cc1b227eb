/** State of a bigram, and the edits of its file that lead from one state to another. */

/** @typedef {import("../curves/curve_points.js").Curves} Curves */
/**
 * @typedef {{curves: Curves, boundary: number, interpolation: string, contact: string, status: string, word: string,
 *   why: string}} BigramState
 * @typedef {{file: string, at: (string | number)[], value?: unknown}} Edit without a value, what stands there is
 *   deleted
 */

/** Fields of a bigram in its file, with the values that need no writing. */
const PLAIN = { word: "", status: "edited", boundary: 0.5, contact: "hold", interpolation: "", why: "" };

/** @param {unknown} a @param {unknown} b */
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/**
 * List the edits that make one state of a bigram another.
 * @param {string} file @param {string} pair
 * @param {BigramState | null} before what the file says, or null if it says nothing of the bigram
 * @param {BigramState} after
 * @returns {Edit[]}
 */
export function editsOf(file, pair, before, after) {
  const at = ["bigrams", pair], fields = /** @type {(keyof typeof PLAIN)[]} */ (Object.keys(PLAIN));
  if (!before) {
    const stated = fields
      .filter((field) => field === "status" || !same(after[field], PLAIN[field]))
      .map((field) => [field, after[field]]);
    return [{ file, at, value: { ...Object.fromEntries(stated), curves: after.curves } }];
  }
  const changed = fields
    .filter((field) => !same(before[field], after[field]))
    .map((field) =>
      same(after[field], PLAIN[field]) && field !== "status"
        ? { file, at: [...at, field] }
        : { file, at: [...at, field], value: after[field] },
    );
  const poses = [...new Set([...Object.keys(before.curves), ...Object.keys(after.curves)])];
  if (!Object.keys(before.curves).length || !Object.keys(after.curves).length) {
    return same(before.curves, after.curves)
      ? changed
      : [...changed, { file, at: [...at, "curves"], value: after.curves }];
  }
  return [
    ...changed,
    ...poses
      .filter((pose) => !same(before.curves[pose], after.curves[pose]))
      .map((pose) =>
        pose in after.curves
          ? { file, at: [...at, "curves", pose], value: after.curves[pose] }
          : { file, at: [...at, "curves", pose] },
      ),
  ];
}

/**
 * Curves of a neighbour, in the time of a bigram with which it shares a phoneme.
 * @param {Curves} curves @param {number} own boundary of the neighbour @param {number} boundary @param {"before" |
 *   "after"} side
 * @returns {Curves}
 */
export function beside(curves, own, boundary, side) {
  const time = side === "before" ? (/** @type {number} */ t) => ((t - own) * boundary) / (1 - own)
    : (/** @type {number} */ t) => boundary + (t * (1 - boundary)) / own;
  return Object.fromEntries(Object.entries(curves).map(([pose, points]) =>
    [pose, points.map(([t, v]) => /** @type {[number, number]} */ ([time(t), v]))]));
}

/**
 * Spans of seconds in which a line says a bigram.
 * @param {import("../line/take.js").Take} take @param {string} pair @returns {[number, number][]}
 */
export function occurrences(take, pair) {
  const { bigrams = [], bounds = [] } = take.data.making ?? {};
  /** @type {[number, number][]} */
  const found = [];
  bigrams.forEach((one, n) => one.pair === pair && found.push([bounds[n], bounds[n + 2]]));
  return found;
}

/**
 * Find where a line says a bigram: the time nearest to a moment.
 * @param {import("../line/take.js").Take} take @param {string} pair @param {number} seconds @param {number}
 *   [position] within the bigram
 * @returns {{seconds: number, before: string, after: string, word: string} | null} null if the line does not say it
 */
export function spoken(take, pair, seconds, position) {
  const { making } = take.data, FULL = 65535;
  if (!making) return null;
  const said = making.said.map((one) => making.bigrams[one].pair);
  const all = said.flatMap((one, n) => (one === pair ? [n] : []));
  if (!all.length) return null;
  const middle = (/** @type {number} */ n) => making.bounds[n + 1];
  const n = all.reduce((/** @type {number} */ best, /** @type {number} */ one) =>
    Math.abs(middle(one) - seconds) < Math.abs(middle(best) - seconds) ? one : best,
  );
  let [found, least] = [take.frameAt(middle(n)), Infinity];
  for (let frame = 0; position !== undefined && frame < take.count; frame++) {
    const side = [n + 1, n].indexOf(making.phoneme[frame]);
    const place = side < 0 ? FULL : making.places[side][frame],
      far = place === FULL ? Infinity : Math.abs(place / FULL - position);
    if (far < least) [found, least] = [frame, far];
  }
  const [word, other] = [making.source[n], making.source[n + 1]].map((phoneme) =>
    phoneme < 0 ? -1 : take.wordOf(phoneme),
  );
  return {
    seconds: take.timeOf(found),
    word: word >= 0 && word === other ? take.data.spoken.words[word][0] : "",
    before: said[n - 1] ?? "",
    after: said[n + 1] ?? "",
  };
}
