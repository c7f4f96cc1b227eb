/**
 * A drawn mouth, for pose sets without a model: how open and how round it is, and its tongue.
 */

/** @typedef {{aperture: number, protrusion: number, tip: number}} Mouth */

const LIMITS = { aperture: [-0.4, 1.1], protrusion: [-0.6, 1.1], tip: [0, 1] };

/**
 * Read a mouth out of pose weights.
 * @param {Record<string, Record<string, number>>} measures gains of the poses, by measure
 * @param {string[]} poses
 * @param {ArrayLike<number>} weights
 * @returns {Mouth}
 */
export function mouthOf(measures, poses, weights) {
  const read = (/** @type {string} */ name, /** @type {number[]} */ [low, high]) => {
    const gains = measures[name] ?? {};
    const sum = poses.reduce((total, pose, n) => total + (gains[pose] ?? 0) * weights[n], 0);
    return Math.max(low, Math.min(high, sum));
  };
  return {
    aperture: read("aperture", LIMITS.aperture),
    protrusion: read("protrusion", LIMITS.protrusion),
    tip: read("tongue_tip", LIMITS.tip),
  };
}

/**
 * Draw a mouth.
 * @param {CanvasRenderingContext2D} context
 * @param {Mouth} mouth
 * @param {boolean} close fill the canvas with it
 */
export function drawMouth(context, { aperture, protrusion, tip }, close) {
  const { width, height } = context.canvas;
  const size = Math.min(width, height) * (close ? 1.6 : 1);
  context.clearRect(0, 0, width, height);
  context.save();
  context.translate(width / 2, height / 2);
  context.scale(size, size);
  const round = Math.max(0, protrusion), spread = Math.max(0, -protrusion);
  const across = 0.26 - 0.13 * round + 0.05 * spread;
  const open = Math.max(0, aperture), press = Math.max(0, -aperture);
  const up = 0.012 + 0.07 * open + 0.02 * round * open, down = 0.012 + 0.2 * open;
  const lip = 0.036 * (1 + 0.5 * round) * (1 - 0.9 * press);
  if (!close) head(context);
  context.translate(0, close ? 0 : 0.16);
  lips(context, across + lip, up + lip, down + lip * 1.3, "#b9524c");
  lips(context, across, open > 0.02 ? up : 0.004, open > 0.02 ? down : 0.004, "#43131a");
  if (open > 0.02) {
    context.save();
    outline(context, across, up, down);
    context.clip();
    context.fillStyle = "#fbf6ea";
    context.fillRect(-across, -up - 0.02, 2 * across, 0.02 + Math.min(0.045, up * 0.9));
    context.fillStyle = "#d4666d";
    context.beginPath();
    context.ellipse(0, down * (1 - 0.75 * tip) + 0.02, across * 0.62, 0.05 + down * 0.35, 0, 0, 2 * Math.PI);
    context.fill();
    context.restore();
  }
  context.restore();
}

/** @param {CanvasRenderingContext2D} context */
function head(context) {
  context.fillStyle = "#e9bd98";
  context.beginPath();
  context.ellipse(0, 0, 0.4, 0.47, 0, 0, 2 * Math.PI);
  context.fill();
  for (const side of [-1, 1]) {
    context.fillStyle = "#ffffff";
    context.beginPath();
    context.ellipse(side * 0.15, -0.14, 0.07, 0.055, 0, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = "#2c3e46";
    context.beginPath();
    context.arc(side * 0.15, -0.14, 0.03, 0, 2 * Math.PI);
    context.fill();
  }
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} up @param {number} down */
function outline(context, x, up, down) {
  context.beginPath();
  context.moveTo(-x, 0);
  context.bezierCurveTo(-x * 0.6, -up * 1.33, x * 0.6, -up * 1.33, x, 0);
  context.bezierCurveTo(x * 0.75, down * 1.33, -x * 0.75, down * 1.33, -x, 0);
  context.closePath();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} up
 * @param {number} down
 * @param {string} colour
 */
function lips(context, x, up, down, colour) {
  outline(context, x, up, down);
  context.fillStyle = colour;
  context.fill();
}
