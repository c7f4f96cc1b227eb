/**
 * The parts of a face that its skin hides: the tongue, and what is near it, such as the teeth.
 *
 * The tongue is found by what its poses move, never by a name: a connected surface of which they
 * move half the points. Where the surface is one with the head, the triangles that they move stand in.
 */

/** Share of the farthest movement from which a point counts as moved. */
const MOVED = 0.03;
/** Share of a surface's points that the tongue's poses must move. */
const MOST = 0.5;
/** Room around the tongue, as a share of its size, within which surfaces are near it. */
const AROUND = 0.6;

/** Kinds of triangles. */
export const TONGUE = 0;
export const NEAR = 1;
export const OUTER = 2;

/**
 * Tell the tongue, what is near it, and all else.
 * @param {import("./face_shape.js").FaceShape} shape
 * @param {ArrayLike<number>} rest weights of the channels at rest
 * @param {ArrayLike<number>[]} moved weights of the channels in each pose of the tongue
 * @returns {Uint8Array | null} a kind for each triangle; null if nothing moves
 */
export function innerKinds(shape, rest, moved) {
  const { face } = shape, { triangles, groups, count } = face;
  const reach = reachOf(shape, rest, moved), most = reach.reduce((a, b) => Math.max(a, b), 0);
  if (!most) return null;
  const touched = Uint8Array.from(reach, (one) => Number(one > MOVED * most));
  const surface = surfaces(triangles, groups, count);
  const size = new Map(), hits = new Map();
  for (let n = 0; n < count; n++) {
    const own = surface[groups[n]];
    size.set(own, (size.get(own) ?? 0) + 1);
    hits.set(own, (hits.get(own) ?? 0) + touched[n]);
  }
  const tongues = new Set([...size.keys()].filter((own) => hits.get(own) >= MOST * size.get(own)));
  const whole = tongues.size > 0, kinds = new Uint8Array(triangles.length / 3).fill(OUTER);
  for (let n = 0; n < kinds.length; n++) {
    const corners = [triangles[3 * n], triangles[3 * n + 1], triangles[3 * n + 2]];
    if (whole ? tongues.has(surface[groups[corners[0]]]) : corners.every((point) => touched[point])) kinds[n] = TONGUE;
  }
  if (whole) markNear(shape, surface, tongues, kinds);
  return kinds;
}

/**
 * How far each point goes in any of the poses.
 * @param {import("./face_shape.js").FaceShape} shape @param {ArrayLike<number>} rest @param {ArrayLike<number>[]} moved
 */
function reachOf(shape, rest, moved) {
  shape.move(rest);
  const still = Float32Array.from(shape.points), reach = new Float32Array(shape.face.count);
  for (const weights of moved) {
    shape.move(weights);
    for (let n = 0; n < reach.length; n++) {
      const far = Math.hypot(
        shape.points[3 * n] - still[3 * n],
        shape.points[3 * n + 1] - still[3 * n + 1],
        shape.points[3 * n + 2] - still[3 * n + 2],
      );
      reach[n] = Math.max(reach[n], far);
    }
  }
  shape.move(rest);
  return reach;
}

/**
 * Number the connected surfaces: a root for each group of points.
 * @param {ArrayLike<number>} triangles @param {ArrayLike<number>} groups @param {number} count
 */
function surfaces(triangles, groups, count) {
  const root = Uint32Array.from({ length: count }, (_, n) => n);
  const find = (/** @type {number} */ n) => {
    while (root[n] !== n) n = root[n] = root[root[n]];
    return n;
  };
  for (let n = 0; n < triangles.length; n += 3) {
    const a = find(groups[triangles[n]]);
    for (const k of [1, 2]) root[find(groups[triangles[n + k]])] = a;
  }
  return root.map((_, n) => find(n));
}

/**
 * Mark the surfaces that lie around the tongue.
 * @param {import("./face_shape.js").FaceShape} shape
 * @param {Uint32Array} surface @param {Set<number>} tongues @param {Uint8Array} kinds
 */
function markNear({ face, points }, surface, tongues, kinds) {
  /** @type {Map<number, number[]>} lowest and highest corner of each surface */
  const boxes = new Map();
  const grow = (/** @type {number} */ own, /** @type {number} */ n) => {
    const box = boxes.get(own) ?? [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
    for (let k = 0; k < 3; k++) {
      box[k] = Math.min(box[k], points[3 * n + k]);
      box[3 + k] = Math.max(box[3 + k], points[3 * n + k]);
    }
    boxes.set(own, box);
  };
  for (let n = 0; n < face.count; n++) {
    const own = surface[face.groups[n]];
    grow(own, n);
    if (tongues.has(own)) grow(-1, n);
  }
  const tongue = /** @type {number[]} */ (boxes.get(-1));
  const room = AROUND * Math.max(...[0, 1, 2].map((k) => tongue[3 + k] - tongue[k]));
  const within = (/** @type {number[]} */ box) =>
    [0, 1, 2].every((k) => box[k] >= tongue[k] - room && box[3 + k] <= tongue[3 + k] + room);
  for (let n = 0; n < kinds.length; n++) {
    const own = surface[face.groups[face.triangles[3 * n]]];
    if (kinds[n] === OUTER && within(/** @type {number[]} */ (boxes.get(own)))) kinds[n] = NEAR;
  }
}
