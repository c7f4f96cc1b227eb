/** Curves of control points, edited: each function returns new curves within what a pack allows. */

/** @typedef {import("./bspline.js").Point} Point */
/** @typedef {Record<string, Point[]>} Curves control points by pose */
/** @typedef {Map<string, Set<number>>} Chosen numbers of the chosen points by pose */

/** Steps of time and value: by hand, on the grid, and fine. */
export const STEP = 0.01;
export const GRID = 0.05;
export const FINE = 0.001;
const FORM = "lipsync-lang curves";

/** @param {number} value @param {number} low @param {number} high */
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** @param {number} value @param {number} step @returns {number} the nearest multiple */
export function snapped(value, step = FINE) {
  return Number((Math.round(value / step) * step).toFixed(3));
}

/** @param {Chosen} chosen @returns {number} how many points */
export const size = (chosen) => [...chosen.values()].reduce((sum, one) => sum + one.size, 0);

/**
 * List the chosen points that exist.
 * @param {Curves} curves @param {Chosen} chosen
 * @returns {{pose: string, index: number, point: Point}[]}
 */
export function chosenPoints(curves, chosen) {
  return [...chosen].flatMap(([pose, numbers]) => [...numbers].sort((a, b) => a - b)
    .flatMap((index) => (curves[pose]?.[index] ? [{ pose, index, point: curves[pose][index] }] : [])));
}

/** @param {Curves} curves @returns {Chosen} every point of the poses */
export function everyPoint(curves, poses = Object.keys(curves)) {
  return new Map(poses.filter((pose) => curves[pose]).map((pose) => [pose, new Set(curves[pose].keys())]));
}

/**
 * @param {Point[]} points
 * @param {Set<number>} moving
 * @param {number} index
 * @returns {[number, number]} times between which a chosen point may lie
 */
function room(points, moving, index) {
  let before = index - 1, after = index + 1;
  while (moving.has(before)) before--;
  while (moving.has(after)) after++;
  return [points[before]?.[0] ?? 0, points[after]?.[0] ?? 1];
}

/**
 * Change the chosen points by a function; times keep their order, and both keep to [0, 1].
 * @param {Curves} curves @param {Chosen} chosen @param {(point: Point) => Point} change
 * @returns {Curves}
 */
export function mapped(curves, chosen, change) {
  const out = { ...curves };
  for (const [pose, numbers] of chosen) {
    const points = curves[pose];
    if (!points) continue;
    let least = 0;
    out[pose] = points.map((point, index) => {
      if (!numbers.has(index)) return point;
      const [low, high] = room(points, numbers, index), [t, v] = change(point);
      least = clamp(Math.max(least, snapped(t)), low, high);
      return /** @type {Point} */ ([least, snapped(clamp(v, 0, 1))]);
    });
  }
  return out;
}

/**
 * Shift the chosen points together, as far as all of them can go.
 * @param {Curves} curves @param {Chosen} chosen @param {number} time @param {number} value
 * @returns {Curves}
 */
export function shifted(curves, chosen, time, value) {
  let [back, on, down, up] = [-1, 1, -1, 1];
  for (const { pose, index, point: [t, v] } of chosenPoints(curves, chosen)) {
    const [low, high] = room(curves[pose], chosen.get(pose) ?? new Set(), index);
    [back, on] = [Math.max(back, low - t), Math.min(on, high - t)];
    [down, up] = [Math.max(down, -v), Math.min(up, 1 - v)];
  }
  const [right, above] = [clamp(time, back, on), clamp(value, down, up)];
  return mapped(curves, chosen, ([t, v]) => [t + right, v + above]);
}

/**
 * Scale the chosen points: times about a moment, values about 0.
 * @param {Curves} curves @param {Chosen} chosen @param {number} time @param {number} value factors
 * @param {number} about the moment
 */
export function scaled(curves, chosen, time, value, about) {
  return mapped(curves, chosen, ([t, v]) => [about + (t - about) * Math.max(0, time), v * Math.max(0, value)]);
}

/**
 * Read what was typed for a time or a value.
 * @param {string} text `0.4` sets, `+0.1` and `-0.1` shift, `*0.8` and `80%` scale
 * @returns {{does: "set" | "shift" | "scale", amount: number} | null}
 */
export function typed(text) {
  const found = /^\s*([-+−*×x]?)\s*(\d*[.,]?\d+|\d+[.,])\s*(%?)\s*$/.exec(text);
  if (!found) return null;
  const [, sign, digits, percent] = found, number = Number(digits.replace(",", "."));
  if (percent) return sign ? null : { does: "scale", amount: number / 100 };
  if (!sign) return { does: "set", amount: number };
  if ("*×x".includes(sign)) return { does: "scale", amount: number };
  return { does: "shift", amount: sign === "+" ? number : -number };
}

/**
 * Change the chosen points by what was typed; a time that is set is that of the first of them.
 * @param {Curves} curves @param {Chosen} chosen @param {0 | 1} axis 0 time, 1 value
 * @param {{does: string, amount: number}} what
 */
export function changedBy(curves, chosen, axis, { does, amount }) {
  const times = chosenPoints(curves, chosen).map(({ point }) => point[0]), first = Math.min(...times);
  if (does === "scale") return axis ? scaled(curves, chosen, 1, amount, 0) : scaled(curves, chosen, amount, 1, first);
  if (does === "set" && axis) return mapped(curves, chosen, ([t]) => [t, amount]);
  const by = does === "set" ? amount - first : amount;
  return shifted(curves, chosen, axis ? 0 : by, axis ? by : 0);
}

/**
 * Add a point where its time belongs.
 * @param {Point[]} points @param {number} time @param {number} value
 * @returns {{points: Point[], index: number}}
 */
export function inserted(points, time, value) {
  const t = snapped(clamp(time, 0, 1)), v = snapped(clamp(value, 0, 1));
  const after = points.findIndex(([other]) => other > t), index = after < 0 ? points.length : after;
  return { points: points.toSpliced(index, 0, [t, v]), index };
}

/**
 * Delete the chosen points. A curve needs two: with fewer it goes.
 * @param {Curves} curves @param {Chosen} chosen
 * @returns {Curves}
 */
export function without(curves, chosen) {
  return Object.fromEntries(
    Object.entries(curves)
      .map(
        ([pose, points]) =>
          /** @type {[string, Point[]]} */ ([pose, points.filter((_, index) => !chosen.get(pose)?.has(index))]),
      )
      .filter(([, points]) => points.length > 1),
  );
}

/** @param {Curves} curves @returns {string} for a clipboard */
export function asText(curves) {
  return JSON.stringify({ form: FORM, curves });
}

/** @param {string} text of a clipboard @returns {Curves | null} null if it holds no curves */
export function fromText(text) {
  try {
    const { form, curves } = JSON.parse(text), all = Object.values(curves);
    const sound = (/** @type {unknown} */ points) =>
      Array.isArray(points) &&
      points.length > 1 &&
      points.every(
        (point, n) =>
          Array.isArray(point) &&
          point.length === 2 &&
          point.every((one) => typeof one === "number" && one >= 0 && one <= 1) &&
          (!n || points[n - 1][0] <= point[0]),
      );
    return form === FORM && all.length && all.every(sound) ? curves : null;
  } catch { return null; }
}
