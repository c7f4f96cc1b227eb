/** Gestures of a line: those that came by rule, and those that a person placed, moved, scaled or took away. */

/** @typedef {import("../payloads.js").GestureByHand} ByHand as in the character's file */
/** @typedef {import("../payloads.js").Spoken & {first?: number}} Spoken with the number of its first word */
/**
 * A gesture in the lane; `hand` is its number among those placed by hand, or -1.
 * @typedef {{name: string, at: number, begin: number, end: number, scale: number, why: string, hand: number}} Shown
 */

/** Seconds around the shown part of a line in which its gestures are. */
const AROUND = 1;

/** @param {Spoken} spoken @returns {number[]} where the words begin */
export function wordStarts({ times, words }) {
  return words.map(([, first]) => times[first]);
}

/**
 * Say where a gesture is, by the word before it: so it stays with its word in another recording.
 * @param {string} gesture @param {number} seconds @param {number} scale @param {Spoken} spoken
 * @returns {ByHand}
 */
export function placedAt(gesture, seconds, scale, spoken) {
  const starts = wordStarts(spoken), at = Math.max(0, starts.findLastIndex((one) => one <= seconds + 1e-6));
  const after = Number((seconds - starts[at]).toFixed(4)), word = at + (spoken.first ?? 0);
  return {
    gesture,
    ...(starts.length ? { word, ...(after ? { after } : {}) } : { at: Number(Math.max(0, seconds).toFixed(4)) }),
    ...(scale === 1 ? {} : { scale: Number(scale.toFixed(3)) }),
  };
}

/** @param {ByHand} one @param {Spoken} spoken @returns {number} its seconds; NaN beside a word that is not shown */
export function secondsOf({ at, word, after = 0 }, spoken) {
  return word === undefined ? at ?? 0 : (wordStarts(spoken)[word - (spoken.first ?? 0)] ?? NaN) + after;
}

/**
 * List the gestures to show. Those by hand stand where they are put; those by rule that the last take has keep clear.
 * @param {import("../payloads.js").Gestures} gestures of the last take
 * @param {ByHand[]} placed
 * @param {Spoken} spoken
 * @returns {Shown[]}
 */
export function shownGestures({ kinds, rows }, placed, spoken) {
  const lengths = new Map(kinds.map((kind) => [kind.name, kind]));
  const hands = placed.flatMap((one, hand) => {
    const kind = lengths.get(one.gesture), at = secondsOf(one, spoken), { scale = 1 } = one;
    const shown = at > spoken.times[0] - AROUND && at < spoken.times[spoken.times.length - 1] + AROUND;
    if (!kind || !shown) return []; // it is off, or in another part of the line
    const begin = at - kind.lead;
    const told = rows.find((row) => row.hand === hand)?.why ?? "by hand, without room in the line";
    const why = scale ? told : "taken away by hand";
    return [{ name: one.gesture, at, begin, end: begin + kind.seconds, scale, why, hand }];
  });
  const ruled = rows.flatMap((row) => {
    const { seconds = 0, room = 0, lead = 0 } = lengths.get(row.name) ?? {};
    const near = hands.some((one) => one.name === row.name && Math.abs(one.begin - row.at + lead) < room);
    return row.hand < 0 && !near ? [{ ...row, end: row.begin + seconds }] : [];
  });
  return [...hands, ...ruled];
}

/**
 * Move a gesture. One that came by rule is taken away where it was, and placed by hand.
 * @param {ByHand[]} placed @param {Shown} own @param {number} seconds @param {Spoken} spoken
 * @returns {[ByHand[], number]} all by hand, and the number of the moved one
 */
export function withMovedGesture(placed, own, seconds, spoken) {
  const now = placedAt(own.name, seconds, own.scale, spoken);
  if (own.hand >= 0) return [placed.with(own.hand, now), own.hand];
  return [[...placed, placedAt(own.name, own.at, 0, spoken), now], placed.length + 1];
}

/**
 * @param {ByHand[]} placed @param {Shown} own @param {number} scale @param {Spoken} spoken
 * @returns {[ByHand[], number]} all by hand, and the number of the scaled one
 */
export function withScaledGesture(placed, own, scale, spoken) {
  const now = placedAt(own.name, own.at, scale, spoken);
  return own.hand >= 0 ? [placed.with(own.hand, now), own.hand] : [[...placed, now], placed.length];
}

/**
 * Take away a gesture that came by rule, or take back what a person did.
 * @param {ByHand[]} placed @param {Shown} own @param {Spoken} spoken
 * @returns {[ByHand[], number]} all by hand, and the number of what stands there now, or -1
 */
export function withoutGesture(placed, own, spoken) {
  if (own.hand >= 0) return [placed.toSpliced(own.hand, 1), -1];
  return [[...placed, placedAt(own.name, own.at, 0, spoken)], placed.length];
}
