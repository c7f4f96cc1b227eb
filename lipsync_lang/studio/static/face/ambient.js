/**
 * Light that reaches each point from around: a mouth is darker inside.
 *
 * The same estimate as `render/model/light.py`: each direction has a grid of the nearest surfaces,
 * and what lies behind them is in the shade.
 */

/** @param {number} count @returns {number[][]} evenly spread directions */
export function sphere(count) {
  return Array.from({ length: count }, (_, n) => {
    const height = 1 - (2 * n + 1) / count;
    const turn = n * Math.PI * (3 - Math.sqrt(5));
    const across = Math.sqrt(1 - height * height);
    return [across * Math.cos(turn), height, across * Math.sin(turn)];
  });
}

/** @param {number[]} a @param {number[]} b */
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/**
 * Estimate the share of light at each point, from 0 to 255.
 * @param {import("./face_shape.js").FaceShape} shape at the time of its widest movement
 * @returns {Uint8Array}
 */
export function openness(shape) {
  const { face, points, normals } = shape;
  const { around, cells, bias, least } = face.light;
  const { middle, half } = face.camera;
  const count = face.count;
  const reached = new Float32Array(count), all = new Float32Array(count).fill(1e-9);
  const across = new Float32Array(count), down = new Float32Array(count), near = new Float32Array(count);
  const grid = new Float32Array(cells * cells);
  for (const way of sphere(around)) {
    const sideways = cross(way, [0.3, 1, 0.2]);
    const long = Math.hypot(...sideways) || 1;
    const right = sideways.map((one) => one / long), up = cross(way, right);
    for (let n = 0; n < count; n++) {
      const x = (points[3 * n] - middle[0]) / half, y = (points[3 * n + 1] - middle[1]) / half;
      const z = (points[3 * n + 2] - middle[2]) / half;
      across[n] = ((x * right[0] + y * right[1] + z * right[2] + 1) * cells) / 2;
      down[n] = ((x * up[0] + y * up[1] + z * up[2] + 1) * cells) / 2;
      near[n] = x * way[0] + y * way[1] + z * way[2];
    }
    grid.fill(-Infinity);
    for (let n = 0; n < face.triangles.length; n += 3) {
      fill(grid, cells, across, down, near, face.triangles[n], face.triangles[n + 1], face.triangles[n + 2]);
    }
    const room = (2 * bias) / cells;
    for (let n = 0; n < count; n++) {
      const facing = Math.max(0, normals[3 * n] * way[0] + normals[3 * n + 1] * way[1] + normals[3 * n + 2] * way[2]);
      const column = clamp(Math.round(across[n]), cells), row = clamp(Math.round(down[n]), cells);
      if (near[n] >= grid[row * cells + column] - room) reached[n] += facing;
      all[n] += facing;
    }
  }
  return Uint8Array.from(reached, (one, n) => 255 * (least + (1 - least) * Math.sqrt(one / all[n])));
}

/** @param {number} value @param {number} count */
function clamp(value, count) {
  return Math.min(Math.max(value, 0), count - 1);
}

/**
 * Enter a triangle into a grid of the nearest surfaces.
 * @param {Float32Array} grid
 * @param {number} cells on a side
 * @param {Float32Array} x @param {Float32Array} y @param {Float32Array} depth of the points
 * @param {number} a @param {number} b @param {number} c corners
 */
function fill(grid, cells, x, y, depth, a, b, c) {
  const area = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a]);
  if (Math.abs(area) < 1e-6) return;
  const left = Math.max(0, Math.ceil(Math.min(x[a], x[b], x[c])));
  const right = Math.min(cells - 1, Math.floor(Math.max(x[a], x[b], x[c])));
  const top = Math.max(0, Math.ceil(Math.min(y[a], y[b], y[c])));
  const bottom = Math.min(cells - 1, Math.floor(Math.max(y[a], y[b], y[c])));
  for (let row = top; row <= bottom; row++) {
    for (let column = left; column <= right; column++) {
      const u = ((x[b] - column) * (y[c] - row) - (x[c] - column) * (y[b] - row)) / area;
      const v = ((x[c] - column) * (y[a] - row) - (x[a] - column) * (y[c] - row)) / area;
      const w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      const here = u * depth[a] + v * depth[b] + w * depth[c];
      const at = row * cells + column;
      if (here > grid[at]) grid[at] = here;
    }
  }
}
