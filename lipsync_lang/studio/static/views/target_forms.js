/**
 * Targets as a pose set states them: one mapping of poses, or a list of steps.
 *
 * A step is flat, poses beside `dominance`, or has `weights`, `dominance` and `overall`. Changes keep
 * the form and the order of what is stated, so that a file changes only where it must. The `status` of
 * a fitted target is lost by a change: a person draws it from then on.
 */

/** @typedef {Record<string, any>} Step */

/** @param {any} target @returns {Step[]} */
export function stepsOf(target) {
  if (target === undefined || target === null) return [];
  return Array.isArray(target) ? target : [target];
}

/** @param {Step[]} steps @returns {any} a target of them, drawn by a person; undefined for none */
export function targetOf(steps) {
  const drawn = steps.map((step) => {
    const { status, ...rest } = step;
    return status === undefined ? step : rest;
  });
  return drawn.length > 1 ? drawn : drawn[0];
}

/** @param {Step} step @returns {Record<string, number>} */
export function weightsOf(step) {
  if (isWhole(step)) return step.weights ?? {};
  return Object.fromEntries(Object.entries(step).filter(([key]) => key !== "dominance" && key !== "status"));
}

/** @param {Step} step @returns {{overall: number | null, poses: Record<string, number>}} */
export function dominanceOf(step) {
  if (typeof step.dominance === "number") return { overall: step.dominance, poses: {} };
  return { overall: isWhole(step) ? step.overall ?? null : null, poses: step.dominance ?? {} };
}

/**
 * @param {Step} step
 * @param {string} pose
 * @param {number | null} weight null leaves the pose out, so that its neighbours decide
 * @returns {Step}
 */
export function withWeight(step, pose, weight) {
  if (isWhole(step)) return { ...step, weights: put(step.weights ?? {}, pose, weight) };
  const { dominance } = step, made = put(weightsOf(step), pose, weight);
  return dominance === undefined ? made : { ...made, dominance };
}

/**
 * @param {Step} step
 * @param {Record<string, number>} weights of the poses above rest; poses that were named stay so
 * @returns {Step}
 */
export function withWeights(step, weights) {
  const named = new Set([...Object.keys(weightsOf(step)), ...Object.keys(weights).filter((pose) => weights[pose] > 0)]);
  return [...named].reduce((made, pose) => withWeight(made, pose, weights[pose] ?? 0), step);
}

/**
 * @param {Step} step
 * @param {string | null} pose null for all poses
 * @param {number | null} value null for the usual one
 * @returns {Step}
 */
export function withDominance(step, pose, value) {
  const { overall, poses } = dominanceOf(step);
  const own = pose === null ? poses : put(poses, pose, value), whole = pose === null ? value : overall;
  const some = Object.keys(own).length > 0;
  if (isWhole(step) || (some && whole !== null)) {
    const { dominance: _, overall: __, ...rest } = isWhole(step) ? step : { weights: weightsOf(step) };
    return { ...rest, ...(some ? { dominance: own } : {}), ...(whole === null ? {} : { overall: whole }) };
  }
  const weights = weightsOf(step);
  return some ? { ...weights, dominance: own } : whole === null ? weights : { ...weights, dominance: whole };
}

/** @param {Step} step */
function isWhole(step) {
  return typeof step.weights === "object" && step.weights !== null;
}

/** @param {Record<string, number>} table @param {string} key @param {number | null} value */
function put(table, key, value) {
  if (value !== null) return { ...table, [key]: value };
  return Object.fromEntries(Object.entries(table).filter(([one]) => one !== key));
}
