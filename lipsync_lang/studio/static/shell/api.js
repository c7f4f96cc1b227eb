/** Requests to the studio's server: JSON, and arrays as bytes. */

import { arraysOf, filled } from "../line/unpack.js";

/**
 * @typedef {object} Told
 * @property {string} [error]
 * @property {import("../payloads.js").Fault[]} [faults]
 * @property {{key: string, what: string, mine: string, theirs: string}[]} [conflict]
 */

/** A request that the server refuses; `told` has its faults, or the two sides of a conflict. */
export class Refusal extends Error {
  /** @param {number} status @param {Told} told */
  constructor(status, told) {
    super(told.error ?? `The studio answered ${status}`);
    this.status = status;
    this.told = told;
  }
}

/** @param {string} path @param {RequestInit} [init] @returns {Promise<Response>} */
async function asked(path, init) {
  let answer;
  try {
    answer = await fetch(`api/${path}`, init);
  } catch {
    throw new Refusal(0, { error: "The studio does not answer. Start it again in its terminal. Your edits are kept." });
  }
  if (answer.ok) return answer;
  const told = await answer.json().catch(() => ({}));
  throw new Refusal(answer.status, told);
}

/** @param {object} body @returns {RequestInit} */
function posted(body) {
  return body instanceof Blob
    ? { method: "POST", body }
    : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) };
}

/** @param {Response} answer @returns {Promise<any>} a document with its arrays in their places */
async function unpacked(answer) {
  const bytes = new Uint8Array(await answer.arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const document = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  return filled(document, arraysOf(bytes.subarray(4 + length), document.arrays));
}

export const api = {
  /** @param {string} path @returns {Promise<any>} */
  get: async (path) => (await asked(path)).json(),
  /** @param {string} path @param {object} body @returns {Promise<any>} */
  post: async (path, body = {}) => (await asked(path, posted(body))).json(),
  /** @param {string} path @returns {Promise<any>} */
  packed: async (path) => unpacked(await asked(path)),
  /** @param {string} path @param {object} body a JSON value, or a file @returns {Promise<any>} */
  sent: async (path, body = {}) => unpacked(await asked(path, posted(body))),
};
