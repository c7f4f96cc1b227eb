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

/** Milliseconds between looks for a server that has ended. */
const LOOK = 1000;

/** Notices of a server that has ended, and of another one at its address. */
const STOPPED =
  "The studio has stopped. Start it again in its folder with the same command: this page then goes on by itself. " +
  "Your edits are kept.";
const MOVED =
  "Another program has the address of this page. Open the address that the studio printed. Your edits are kept.";

/** Requests that are not repeated: whether the ended server has done them cannot be known. */
const ONCE = ["undo", "redo"];

/** The other tabs of this studio, which hear of each change. */
const others = new BroadcastChannel(location.pathname);

/** Name of the server that answered last. */
let server = "";

/** Ends when a server answers again; null while one does. @type {Promise<void> | null} */
let away = null;

/**
 * True if the server knows the token of the address, which is not sent to one that does not.
 * @returns {Promise<boolean>}
 */
async function proved() {
  const [, token] = location.pathname.split("/"), nonce = crypto.randomUUID(), text = new TextEncoder();
  const kind = { name: "HMAC", hash: "SHA-256" };
  const key = await crypto.subtle.importKey("raw", text.encode(token), kind, false, ["verify"]);
  const answer = await fetch(`/proof/${nonce}`);
  return answer.ok && crypto.subtle.verify("HMAC", key, await answer.arrayBuffer(), text.encode(nonce));
}

/** Wait for a server at this address that opens the pair again, and let the studio go on. */
async function back() {
  for (let told = ""; ; await new Promise((done) => setTimeout(done, LOOK))) {
    const known = await proved().catch(() => null);
    let why = known === false ? MOVED : STOPPED;
    if (known) {
      try {
        await api.back();
        return;
      } catch (error) { // it has ended again, or a file of the pair must be mended first
        const ended = error instanceof Refusal && !error.status;
        if (!ended) why = `The studio cannot go on yet: ${error instanceof Error ? error.message : error}`;
      }
    }
    if (why !== told) api.lost(why);
    told = why;
  }
}

/**
 * @param {string} path @param {RequestInit} init @param {boolean} direct not to wait for a server that has ended
 * @returns {Promise<Response>}
 */
async function asked(path, init, direct) {
  if (away && !direct) await away;
  const returned = () => (away ??= back().finally(() => { away = null; }));
  const known = server;
  let answer;
  try {
    answer = await fetch(`api/${path}`, init);
  } catch {
    if (direct) throw new Refusal(0, { error: "The studio does not answer" });
    await returned();
    if (ONCE.includes(path)) throw new Refusal(0, { error: `The studio ended before it could ${path}` });
    return asked(path, init, direct);
  }
  const name = answer.headers.get("x-studio") ?? "", noticed = name === server;
  server = name;
  if (known !== "" && name !== known && !direct) { // it was started again in between, and may know no line yet
    await (noticed ? away : returned());
    if (!answer.ok || init.method !== "POST") return asked(path, init, direct);
  }
  if (answer.ok) {
    if (init.method === "POST") others.postMessage(path);
    return answer;
  }
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

/** @param {boolean} direct */
const requests = (direct) => ({
  /** @param {string} path @returns {Promise<any>} */
  get: async (path) => (await asked(path, {}, direct)).json(),
  /** @param {string} path @param {object} body @returns {Promise<any>} */
  post: async (path, body = {}) => (await asked(path, posted(body), direct)).json(),
  /** @param {string} path @returns {Promise<any>} */
  packed: async (path) => unpacked(await asked(path, {}, direct)),
  /** @param {string} path @param {object} body a JSON value, or a file @returns {Promise<any>} */
  sent: async (path, body = {}) => unpacked(await asked(path, posted(body), direct)),
});

/** Requests; while no server answers, they wait for the next one. */
export const api = {
  ...requests(false),
  /** Requests that do not wait. */
  direct: requests(true),
  /** Called when requests must wait, with the reason. @param {string} _ */
  lost: (_) => {},
  /** Called when a server answers again, before the requests that wait. @type {() => Promise<void>} */
  back: async () => {},
  /** Call a function when another tab may have changed something. @param {() => void} does */
  heard: (does) => { others.onmessage = does; },
};
