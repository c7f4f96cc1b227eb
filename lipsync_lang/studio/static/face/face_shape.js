/**
 * Points and normals of a face: morph targets, bones and skin, on the processor.
 *
 * The data is that of `face_data.py`; the normals are those of the pictures (`render/model/light.py`):
 * those of the file turn with the surface. Matrices act on rows, as there.
 */

const RADIANS = Math.PI / 180;

/**
 * Multiply two matrices of 16 numbers, rows first.
 * @param {ArrayLike<number>} a
 * @param {ArrayLike<number>} b
 * @returns {Float64Array}
 */
export function times(a, b) {
  const out = new Float64Array(16);
  for (let row = 0; row < 4; row++) {
    for (let column = 0; column < 4; column++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * row + k] * b[4 * k + column];
      out[4 * row + column] = sum;
    }
  }
  return out;
}

/**
 * Compose two rotations: the first, then the other about the rotated axes.
 * @param {number[]} q x, y, z, w
 * @param {number[]} r
 * @returns {number[]}
 */
export function composed([a, b, c, d], [x, y, z, w]) {
  return [
    d * x + w * a + b * z - c * y,
    d * y + w * b + c * x - a * z,
    d * z + w * c + a * y - b * x,
    d * w - a * x - b * y - c * z,
  ];
}

/**
 * Build the matrix of a node from its parts.
 * @param {number[]} translation
 * @param {number[]} rotation a quaternion
 * @param {number[]} scale
 * @returns {Float64Array}
 */
export function placed(translation, rotation, scale) {
  const length = Math.hypot(...rotation) || 1;
  const [x, y, z, w] = rotation.map((one) => one / length);
  const rows = [
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
  ];
  const out = new Float64Array(16);
  rows.forEach((row, n) => row.forEach((value, k) => { out[4 * n + k] = value * scale[n]; }));
  translation.forEach((value, k) => { out[12 + k] = value; });
  out[15] = 1;
  return out;
}

/**
 * Matrix of a node with its channels' movement.
 * @param {import("../payloads.js").FaceNode} node
 * @param {ArrayLike<number>} weights of the channels
 * @returns {ArrayLike<number>}
 */
function local(node, weights) {
  if (!node.moves) return node.matrix;
  let rotation = node.rotation;
  const translation = [...node.translation];
  for (const { channel, turn, shift } of node.moves) {
    const level = weights[channel] ?? 0;
    if (turn) {
      const half = (level * RADIANS) / 2;
      const share = Math.sin(half) / (Math.hypot(...turn) || 1);
      rotation = composed(rotation, [turn[0] * share, turn[1] * share, turn[2] * share, Math.cos(half)]);
    }
    if (shift)
      shift.forEach((/** @type {number} */ one, /** @type {number} */ k) => {
        translation[k] += level * one;
      });
  }
  return placed(translation, rotation, node.scale);
}

const STILL = new Float64Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** A face that moves by the weights of its channels. */
export class FaceShape {
  /** @param {import("../payloads.js").Face} face */
  constructor(face) {
    this.face = face;
    this.points = new Float32Array(3 * face.count);
    this.normals = new Float32Array(3 * face.count);
    this.sums = new Float32Array(3 * face.count);
    this.change = new Float32Array(3 * face.count);
    /** Triangles and points whose normals turn when points move. */
    this.bent = new Uint32Array();
    this.turned = new Uint32Array();
    this.bases = face.parts.map(base);
    const none = new Float64Array(4096);
    this.matrices = this.#matrices(none);
    face.parts.forEach((_, /** @type {number} */ number) => this.#movePart(number, none));
    this.live = face.parts.map((part) => isLive(part, face.nodes));
    this.#group();
  }

  /**
   * Move the points and normals.
   * @param {ArrayLike<number>} weights one for each channel
   */
  move(weights) {
    this.matrices = this.#matrices(weights);
    this.live.forEach(
      (/** @type {boolean} */ live, /** @type {number} */ number) => live && this.#movePart(number, weights),
    );
    this.#shade(this.bent, this.turned);
  }

  /** @param {ArrayLike<number>} weights */
  #matrices(weights) {
    /** @type {ArrayLike<number>[]} */
    const found = [];
    for (const node of this.face.nodes) {
      const own = local(node, weights);
      found.push(node.parent < 0 ? own : times(own, found[node.parent]));
    }
    return found;
  }

  /**
   * @param {number} number
   * @param {ArrayLike<number>} weights
   */
  #movePart(number, weights) {
    const part = this.face.parts[number];
    const shaped = Float32Array.from(this.bases[number]);
    for (const { channels, rest, scale, points, deltas } of part.shapes) {
      let weight = channels.length ? -Infinity : rest;
      for (const channel of channels) weight = Math.max(weight, weights[channel] ?? 0); // a plain take has no gestures
      if (!weight) continue;
      const step = weight * scale;
      for (let n = 0; n < points.length; n++) {
        const at = 3 * points[n];
        shaped[at] += step * deltas[3 * n];
        shaped[at + 1] += step * deltas[3 * n + 1];
        shaped[at + 2] += step * deltas[3 * n + 2];
      }
    }
    const out = this.points.subarray(3 * part.first, 3 * (part.first + part.count));
    if (part.skin) skinned(shaped, part.skin, this.matrices, out);
    else transformed(shaped, this.matrices[part.node], out);
  }

  /** Find what turns when points move, and how the file's normals differ from smooth ones. */
  #group() {
    const { triangles, groups, moving, normals, count } = this.face;
    const bent = new Uint8Array(count);
    for (let n = 0; n < triangles.length; n += 3) {
      const corners = triangles.subarray(n, n + 3);
      if (corners.some((/** @type {number} */ point) => moving[point]))
        for (const point of corners) bent[groups[point]] = 1;
    }
    const every = Uint32Array.from({ length: triangles.length / 3 }, (_, n) => n);
    const touched = (/** @type {number} */ n) => [0, 1, 2].some((k) => bent[groups[triangles[3 * n + k]]]);
    this.bent = every.filter(touched);
    this.turned = Uint32Array.from({ length: count }, (_, n) => n).filter((n) => bent[groups[n]]);
    const all = Uint32Array.from({ length: count }, (_, n) => n);
    this.#shade(every, all);
    for (let n = 0; n < count; n++) {
      const own = [normals[3 * n] / 127, normals[3 * n + 1] / 127, normals[3 * n + 2] / 127];
      if (Math.hypot(...own) < 0.5) continue;
      for (let k = 0; k < 3; k++) this.change[3 * n + k] = own[k] - this.normals[3 * n + k];
    }
    this.#shade(every, all);
  }

  /**
   * Compute the normals of some points from the triangles around them.
   * @param {Uint32Array} triangles their numbers
   * @param {Uint32Array} points
   */
  #shade(triangles, points) {
    const { points: p, sums, change, normals } = this;
    const { triangles: corners, groups } = this.face;
    for (const n of points) sums.fill(0, 3 * groups[n], 3 * groups[n] + 3);
    for (const n of triangles) {
      const a = corners[3 * n], b = corners[3 * n + 1], c = corners[3 * n + 2];
      const ux = p[3 * b] - p[3 * a], uy = p[3 * b + 1] - p[3 * a + 1], uz = p[3 * b + 2] - p[3 * a + 2];
      const vx = p[3 * c] - p[3 * a], vy = p[3 * c + 1] - p[3 * a + 1], vz = p[3 * c + 2] - p[3 * a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      for (const point of [a, b, c]) {
        const at = 3 * groups[point];
        sums[at] += x; sums[at + 1] += y; sums[at + 2] += z;
      }
    }
    for (const n of points) {
      const from = 3 * groups[n], at = 3 * n;
      const long = Math.hypot(sums[from], sums[from + 1], sums[from + 2]) || 1;
      const x = sums[from] / long + change[at], y = sums[from + 1] / long + change[at + 1];
      const z = sums[from + 2] / long + change[at + 2];
      const length = Math.hypot(x, y, z) || 1;
      normals[at] = x / length; normals[at + 1] = y / length; normals[at + 2] = z / length;
    }
  }
}

/**
 * Points of a part at rest.
 * @param {import("../payloads.js").FacePart} part
 * @returns {Float32Array}
 */
function base(part) {
  const out = new Float32Array(3 * part.count);
  for (let n = 0; n < out.length; n++) out[n] = part.middle[n % 3] + part.points[n] * part.scale;
  return out;
}

/**
 * Test a part for points that can move.
 * @param {import("../payloads.js").FacePart} part
 * @param {import("../payloads.js").FaceNode[]} nodes
 */
function isLive(part, nodes) {
  const driven = (/** @type {number} */ number) => {
    for (let n = number; n >= 0; n = nodes[n].parent) if (nodes[n].moves) return true;
    return false;
  };
  const bones = part.skin ? part.skin.bones : [part.node];
  return bones.some(driven) || part.shapes.some((shape) => shape.channels.length);
}

/**
 * @param {Float32Array} points
 * @param {ArrayLike<number>} m
 * @param {Float32Array} out
 */
function transformed(points, m, out) {
  for (let n = 0; n < points.length; n += 3) {
    const x = points[n], y = points[n + 1], z = points[n + 2];
    out[n] = x * m[0] + y * m[4] + z * m[8] + m[12];
    out[n + 1] = x * m[1] + y * m[5] + z * m[9] + m[13];
    out[n + 2] = x * m[2] + y * m[6] + z * m[10] + m[14];
  }
}

/**
 * @param {Float32Array} points
 * @param {import("../payloads.js").Skin} skin
 * @param {ArrayLike<number>[]} matrices of the nodes
 * @param {Float32Array} out
 */
function skinned(points, skin, matrices, out) {
  const bones = skin.bones.map((/** @type {number} */ node, /** @type {number} */ n) =>
    times(skin.inverse.subarray(16 * n, 16 * n + 16), node < 0 ? STILL : matrices[node]));
  out.fill(0);
  for (let n = 0; n < points.length; n += 3) {
    const x = points[n], y = points[n + 1], z = points[n + 2];
    for (let set = 0; set < skin.sets; set++) {
      const at = (n / 3) * skin.sets + set;
      const share = skin.shares[at] / 65535;
      if (!share) continue;
      const m = bones[skin.joints[at]];
      out[n] += share * (x * m[0] + y * m[4] + z * m[8] + m[12]);
      out[n + 1] += share * (x * m[1] + y * m[5] + z * m[9] + m[13]);
      out[n + 2] += share * (x * m[2] + y * m[6] + z * m[10] + m[14]);
    }
  }
}
