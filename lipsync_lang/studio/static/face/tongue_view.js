/** The tongue seen through the cheek: a button beside the views of the face. */

import { innerKinds } from "./inner_mouth.js";

/** Region of the poses that move the tongue. */
export const REGION = "tongue";

/**
 * Faces with the kinds of their triangles; null for a face without a tongue.
 * @type {WeakMap<object, Uint8Array | null>}
 */
const known = new WeakMap();

/**
 * Show the tongue through the face, or the solid face again.
 * @param {import("../shell/studio.js").Studio} studio
 * @param {HTMLElement} button
 */
export async function toggleTongue(studio, button) {
  const face = studio.portrait?.face;
  if (!face) {
    studio.tell("There is no model. The drawn mouth shows its tongue between the open lips.");
    return;
  }
  const on = face.through === null, kinds = on ? await kindsOf(studio, face) : null;
  if (on && !kinds) studio.tell(`No pose of the region "${REGION}" moves anything in this model`);
  if (studio.portrait?.face !== face) return;
  face.seeThrough(kinds);
  button.setAttribute("aria-pressed", String(Boolean(kinds)));
  studio.wake();
}

/**
 * @param {import("../shell/studio.js").Studio} studio
 * @param {import("./gl_face.js").GlFace} face
 * @returns {Promise<Uint8Array | null>}
 */
export async function kindsOf(studio, face) {
  if (!known.has(face)) {
    const names = studio.state.poses
      .filter((one) => one.region === REGION)
      .map((one) => one.name);
    const mixes = [{}, ...names.map((/** @type {string} */ name) => ({ [name]: 1 }))];
    const [rest, ...moved] = (await studio.api.post("pose", { mixes })).rows.map(
      (/** @type {{channels: number[]}} */ row) => row.channels,
    );
    known.set(face, moved.length ? innerKinds(face.shape, rest, moved) : null);
    face.stale = true;
  }
  return known.get(face) ?? null;
}
