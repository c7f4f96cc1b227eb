/**
 * Data of a page: JSON, and arrays from one compressed block.
 *
 * `array_pack.py` writes it: numbers of several bytes are differences between neighbours, with the
 * first bytes of all numbers before the second bytes of all.
 */

/** @typedef {Uint8Array | Int8Array | Uint16Array | Int16Array | Uint32Array | Float32Array} Numbers */

const WIDTHS = { u1: 1, i1: 1, u2: 2, i2: 2, u4: 4, f4: 4 };

/**
 * Undo the difference code of one array.
 * @param {Uint8Array} bytes
 * @param {keyof typeof WIDTHS} kind
 * @param {number} count of numbers
 * @returns {Numbers}
 */
export function decoded(bytes, kind, count) {
  if (kind === "u1") return bytes;
  if (kind === "i1") return new Int8Array(bytes.buffer, bytes.byteOffset, count);
  if (kind === "f4") return new Float32Array(bytes.slice().buffer);
  const whole = kind === "u4" ? new Uint32Array(count) : new Uint16Array(count);
  for (let byte = 0; byte < WIDTHS[kind]; byte++) {
    for (let n = 0; n < count; n++) whole[n] += bytes[byte * count + n] << (8 * byte);
  }
  for (let n = 1; n < count; n++) whole[n] += whole[n - 1]; // wraps around, as the writer does
  return kind === "i2" ? new Int16Array(whole.buffer) : whole;
}

/**
 * Cut a block into its arrays.
 * @param {Uint8Array} block
 * @param {[keyof typeof WIDTHS, number][]} layout type and length of each array
 * @returns {Numbers[]}
 */
export function arraysOf(block, layout) {
  let at = 0;
  return layout.map(([kind, count]) => {
    const bytes = block.subarray(at, at + count * WIDTHS[kind]);
    at += bytes.length;
    return decoded(bytes, kind, count);
  });
}

/**
 * Put arrays in place of their references.
 * @param {any} value of JSON
 * @param {Numbers[]} arrays
 * @returns {any}
 */
export function filled(value, arrays) {
  if (value === null || typeof value !== "object") return value;
  if ("$array" in value) return arrays[value.$array];
  if (Array.isArray(value)) return value.map((one) => filled(one, arrays));
  return Object.fromEntries(Object.entries(value).map(([name, one]) => [name, filled(one, arrays)]));
}

/**
 * Compute the samples of a sound that `array_pack.py` stored in steps.
 * @param {{block: number, steps: Uint16Array, changes: Uint8Array}} sound
 */
export function samplesOf({ block, steps, changes }) {
  let count = 0;
  return Int16Array.from(changes, (change, n) => {
    count = (count + change) % 256;
    const sample = (count < 128 ? count : count - 256) * steps[Math.floor(n / block)];
    return Math.max(-32768, Math.min(32767, sample));
  });
}

/**
 * Read the document of a page.
 * @param {string} json
 * @param {string} text the block, compressed, in base64
 * @returns {Promise<any>}
 */
export async function unpack(json, text) {
  const document = JSON.parse(json);
  const packed = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const block = new Uint8Array(await new Response(stream).arrayBuffer());
  const data = filled(document, arraysOf(block, document.arrays));
  return { ...data, sound: data.sound && { rate: data.sound.rate, samples: samplesOf(data.sound) } };
}
