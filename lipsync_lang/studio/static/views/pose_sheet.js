/** A sheet of small pictures: the face in each pose, drawn by the face beside it. */

import { drawMouth, mouthOf } from "../face/drawn_mouth.js";
import { button, made, middled } from "../shell/elements.js";

/** Pixels of a picture. */
const SIDE = 176;
/** Pictures drawn before the page may answer again. */
const AT_ONCE = 4;

/** Degrees from the front, where the tongue is seen through the cheek. */
const ASIDE = 55;

/** @typedef {{name: string, title: string}} Picture */

/** Pictures of mixes to choose from. */
export class PoseSheet {
  /** @param {HTMLElement} place @param {(name: string, add: boolean) => void} pick */
  constructor(place, pick) {
    this.pick = pick;
    this.list = made("ul", { class: "pose-sheet" });
    place.append(this.list);
    /** @type {Map<string, {canvas: HTMLCanvasElement, button: HTMLElement}>} */
    this.items = new Map();
    this.drawing = 0;
  }

  /** @param {Picture[]} pictures */
  show(pictures) {
    this.items.clear();
    this.list.replaceChildren(...pictures.map(({ name, title }) => {
      const canvas = made("canvas", { width: String(SIDE), height: String(SIDE), "aria-hidden": "true" });
      const one = button(
        [canvas, middled(name)],
        { title: title || name, "aria-pressed": "false" },
        (event) => this.pick(name, event.shiftKey),
      );
      this.items.set(name, { canvas, button: one });
      return made("li", one);
    }));
  }

  /** @param {Record<string, number>} mix */
  mark(mix) {
    for (const [name, { button }] of this.items) button.setAttribute("aria-pressed", String((mix[name] ?? 0) > 0));
  }

  /**
   * Draw the pictures, a few in each frame; a newer call ends an older one.
   * @param {import("../shell/studio.js").Studio} studio
   * @param {Map<string, Float32Array>} mixes channels of the model, or poses where there is none
   * @param {Uint8Array | null} kinds of the triangles, to see what a pose moves behind the lips
   * @param {Set<string>} inner poses that are seen through the face
   */
  draw(studio, mixes, kinds, inner) {
    const own = ++this.drawing, left = [...this.items];
    const some = () => {
      if (own !== this.drawing || !studio.portrait) return;
      snapshots(studio, left.splice(0, AT_ONCE).flatMap(([name, { canvas }]) => {
        const weights = mixes.get(name);
        return weights ? [{ canvas, weights, kinds: inner.has(name) ? kinds : null }] : [];
      }));
      if (left.length) requestAnimationFrame(some);
    };
    some();
  }
}

/**
 * Draw mouths into canvases with the face of the studio, which looks the same afterwards.
 * @param {import("../shell/studio.js").Studio} studio
 * @param {{canvas: HTMLCanvasElement, weights: Float32Array, kinds: Uint8Array | null}[]} wanted
 */
export function snapshots(studio, wanted) {
  const portrait = /** @type {import("../face/portrait.js").Portrait} */ (studio.portrait), { face, take } = portrait;
  if (!face) {
    for (const { canvas, weights } of wanted) {
      const context = canvas.getContext("2d");
      if (context) drawMouth(context, mouthOf(take.data.measures, take.poses, weights), true);
    }
    return;
  }
  const { close, yaw, pitch, through } = face, { width, height } = face.canvas;
  [face.canvas.width, face.canvas.height] = [SIDE, SIDE];
  for (const { canvas, weights, kinds } of wanted) {
    face.seeThrough(kinds);
    face.setView({ close: true, yaw: kinds ? ASIDE : 0, pitch: 0 });
    face.setWeights(weights);
    face.render();
    const context = canvas.getContext("2d");
    context?.clearRect(0, 0, SIDE, SIDE);
    context?.drawImage(face.canvas, 0, 0);
  }
  [face.canvas.width, face.canvas.height] = [width, height];
  face.setView({ close, yaw, pitch });
  face.seeThrough(through);
  portrait.draw(studio.player.time, studio.posed);
}
