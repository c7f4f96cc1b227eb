/**
 * The smooth curve of control points, by the arithmetic of `pipeline/curve.py`.
 *
 * Points are (time, value) with times that never fall. On each span the curve is a polynomial in a
 * local w in [0, 1]: t(w) = x is solved for w, then v(w) is read.
 */

/** @typedef {[number, number]} Point */

/** Most iterations to invert t(w), and the smallest change of w that continues. */
const STEPS = 40, ENOUGH = 1e-13;

/** @type {Map<number, number[][][]>} */
const known = new Map();

/**
 * Basis polynomials of a clamped uniform B-spline of degree min(3, count - 1).
 * @param {number} count of control points, 2 or more
 * @returns {number[][][]} on span s, the weight of point s + i is the sum of basis[s][i][k] w^k
 */
export function spanBasis(count) {
  const found = known.get(count);
  if (found) return found;
  const degree = Math.min(3, count - 1), spans = count - degree;
  const knots = Array.from({ length: count + degree + 1 }, (_, n) => Math.min(spans, Math.max(0, n - degree)));
  const basis = Array.from({ length: spans }, (_, span) => {
    /** @type {Map<number, number[]>} */
    let here = new Map([[span + degree, [1]]]);
    for (let p = 1; p <= degree; p++) {
      const raised = new Map();
      for (let i = span + degree - p; i <= span + degree; i++) {
        const terms = Array(p + 1).fill(0), left = here.get(i), right = here.get(i + 1);
        if (left) add(terms, left, span - knots[i], 1, knots[i + p] - knots[i]);
        if (right) add(terms, right, knots[i + p + 1] - span, -1, knots[i + p + 1] - knots[i + 1]);
        raised.set(i, terms);
      }
      here = raised;
    }
    return Array.from({ length: degree + 1 }, (_, i) => here.get(span + i) ?? []);
  });
  known.set(count, basis);
  return basis;
}

/**
 * Add a polynomial times (constant + slope w) / width.
 * @param {number[]} terms @param {number[]} polynomial
 * @param {number} constant @param {number} slope @param {number} width
 */
function add(terms, polynomial, constant, slope, width) {
  polynomial.forEach((one, k) => {
    terms[k] += (one * constant) / width;
    terms[k + 1] += (one * slope) / width;
  });
}

/**
 * Evaluate the smooth curve; 0 outside its points.
 * @param {Point[]} points 2 or more
 * @param {ArrayLike<number>} at times
 * @returns {Float64Array}
 */
export function bspline(points, at) {
  const spans = spanBasis(points.length).map((span, first) => [0, 1].map((axis) =>
    span[0].map((_, k) => span.reduce((sum, terms, i) => sum + terms[k] * points[first + i][axis], 0))));
  const begin = points[0][0], end = points[points.length - 1][0];
  return Float64Array.from(at, (x) => {
    if (!(x >= begin && x <= end)) return 0;
    let span = 0;
    while (span + 1 < spans.length && spans[span + 1][0][0] <= x) span++;
    const [time, value] = spans[span];
    return horner(value, inverse(time, x));
  });
}

/**
 * Evaluate the control polygon; 0 outside its points.
 * @param {Point[]} points
 * @param {ArrayLike<number>} at times
 * @returns {Float64Array}
 */
export function polyline(points, at) {
  const last = points.length - 1;
  return Float64Array.from(at, (x) => {
    if (!(x >= points[0][0] && x <= points[last][0])) return 0;
    const n = points.findLastIndex(([time]) => time <= x);
    if (n === last) return points[last][1];
    const [[t, v], [to, high]] = [points[n], points[n + 1]];
    return v + ((high - v) / (to - t)) * (x - t);
  });
}

/**
 * Evaluate a curve by its kind.
 * @param {Point[]} points @param {string} kind `bspline` or `linear` @param {ArrayLike<number>} at times
 */
export function valuesAt(points, kind, at) {
  return (kind === "linear" ? polyline : bspline)(points, at);
}

/** @param {number[]} terms lowest power first @param {number} w @returns {number} */
function horner(terms, w) {
  return terms.reduceRight((sum, term) => sum * w + term, 0);
}

/** @param {number[]} time a rising polynomial @param {number} x @returns {number} w with time(w) = x */
function inverse(time, x) {
  const slope = time.slice(1).map((term, k) => term * (k + 1));
  let low = 0, high = 1, w = 0.5;
  for (let n = 0; n < STEPS; n++) {
    const error = horner(time, w) - x, steep = horner(slope, w);
    if (error < 0) low = w;
    else high = w;
    const step = w - error / steep;
    const wanted = steep > 0 && step >= low && step <= high ? step : (low + high) / 2;
    if (Math.abs(wanted - w) < ENOUGH) break;
    w = wanted;
  }
  return w;
}
