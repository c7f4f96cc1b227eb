/** Places in a line to which a character's own curves apply, and the edits that change such curves. */

/** @typedef {import("./curve_points.js").Curves} Curves */
/**
 * @typedef {{from: number, to: number, query: string, sounds: {seconds: number, label: string}[]}} Span seconds;
 *   `query` names it to the server
 */

/**
 * Find the span of a word or of an edit of a line.
 * @param {import("../line/take.js").Take} take @param {string[][]} said common phonemes of each label; none for silence
 * @param {{text: string} | {word: number | null, phoneme: number | null}} wanted a word by its text (that nearest to
 *   a moment), or by number
 * @param {number} seconds
 * @returns {Span | null} null if the line has no such place
 */
export function spanOf(take, said, wanted, seconds) {
  const { words, times, labels } = take.data.spoken;
  let word = "word" in wanted ? wanted.word : null, first = 0, stop = labels.length;
  if ("text" in wanted) {
    const same = words.flatMap(([text], n) =>
      text.toLocaleLowerCase() === wanted.text.toLocaleLowerCase() ? [n] : [],
    );
    if (!same.length) return null;
    const far = (/** @type {number} */ n) => Math.max(times[words[n][1]] - seconds, seconds - times[words[n][2]], 0);
    word = same.reduce((/** @type {number} */ best, /** @type {number} */ n) => (far(n) < far(best) ? n : best));
  }
  if (word !== null) {
    if (!words[word]) return null;
    [, first, stop] = words[word];
  }
  const phoneme = "phoneme" in wanted ? wanted.phoneme : null;
  if (phoneme !== null) {
    const spoken = said.flatMap((one, n) => (one.length && n >= first && n < stop ? [n] : []));
    if (spoken[phoneme] === undefined) return null;
    [first, stop] = [spoken[phoneme], spoken[phoneme] + 1];
  }
  const sounds = Array.from({ length: stop - first }, (_, n) => ({
    seconds: times[first + n],
    label: labels[first + n],
  }));
  const query = new URLSearchParams({
    ...(word === null ? {} : { word: String(word) }),
    ...(phoneme === null ? {} : { phoneme: String(phoneme) }),
  });
  return { from: times[first], to: times[stop], query: String(query), sounds };
}

/**
 * List the edits that make curves of a character's pack others.
 * @param {(string | number)[]} at location of the curves @param {Curves} before @param {Curves} after
 * @returns {import("../shell/studio.js").Edit[]}
 */
export function curveEdits(at, before, after) {
  const file = "character",
    same = (/** @type {object} */ a, /** @type {object} */ b) => JSON.stringify(a) === JSON.stringify(b);
  if (!Object.keys(before).length || !Object.keys(after).length)
    return same(before, after) ? [] : [{ file, at, value: after }];
  return [...new Set([...Object.keys(before), ...Object.keys(after)])]
    .filter((pose) => !same(before[pose], after[pose]))
    .map((pose) => (pose in after ? { file, at: [...at, pose], value: after[pose] } : { file, at: [...at, pose] }));
}
