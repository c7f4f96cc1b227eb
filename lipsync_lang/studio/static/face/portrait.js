/** A face that speaks: the model where the browser can draw it, else a drawn mouth. */

import { drawMouth, mouthOf } from "./drawn_mouth.js";
import { made } from "../shell/elements.js";
import { createFace } from "./gl_face.js";

/** Pixels of a canvas for a pixel of the page, at most. */
const FINEST = 2;
/** Degrees of the view for a pixel of a drag. */
const TURN = 0.5;

/** A face or a mouth on a canvas, with its take. */
export class Portrait {
  /** @param {{faces: import("../payloads.js").Face[]}} page @param {import("../line/take.js").Take} take */
  constructor(page, take) {
    this.take = take;
    this.data = page.faces[take.data.face];
    this.canvas = made("canvas", { role: "img" });
    this.caption = made("figcaption", { dir: "auto" });
    this.figure = made("figure", this.canvas, this.caption);
    this.close = false;
    /** @type {import("./gl_face.js").GlFace | null} */
    this.face = null;
    this.trouble = "";
    if (this.data.parts) {
      try { this.face = createFace(this.canvas, this.data); } catch (error) { this.trouble = String(error); }
      if (!this.face) this.trouble ||= "This browser does not show 3D (WebGL2), so a drawn mouth is shown";
    }
    const channels = take.moved.curves;
    this.moments = channels.map((one, /** @type {number} */ n) =>
      Float32Array.from(channels, (_, k) => (k === n ? one.high : 0)),
    );
  }

  /** Shade what little light reaches; the first picture does not wait for it. */
  shade() {
    this.face?.shade(this.moments);
    this.figure.dataset.shaded = "";
  }

  /** @param {boolean} close */
  setClose(close) {
    this.close = close;
    this.face?.setView({ close, yaw: 0, pitch: 0 });
  }

  /** @param {number} yaw @param {number} pitch degrees */
  turn(yaw, pitch) {
    if (this.face) this.face.setView({ yaw: this.face.yaw + yaw, pitch: this.face.pitch + pitch });
  }

  /**
   * @param {number} seconds
   * @param {Float32Array | null} [posed] weights of the channels in place of the take's
   */
  draw(seconds, posed = null) {
    const { canvas, take } = this;
    const ratio = Math.min(FINEST, window.devicePixelRatio || 1);
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.round(ratio * side));
    if (wide && (canvas.width !== wide || canvas.height !== high)) [canvas.width, canvas.height] = [wide, high];
    if (this.face) {
      this.face.setWeights(posed ?? take.channelsAt(seconds));
      this.face.render();
      return;
    }
    const context = canvas.getContext("2d");
    if (context)
      drawMouth(
        context,
        mouthOf(take.data.measures, take.poses, posed ?? take.posesAt(take.frameAt(seconds))),
        this.close,
      );
  }
}

/**
 * Let drags on a canvas turn faces.
 * @param {HTMLCanvasElement} canvas
 * @param {() => Portrait[]} portraits
 * @param {() => void} wake
 */
export function turnByDrag(canvas, portraits, wake) {
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!canvas.hasPointerCapture(event.pointerId)) return;
    for (const one of portraits()) one.turn(event.movementX * TURN, event.movementY * TURN);
    wake();
  });
}

/** @param {import("../line/take.js").Take} take @returns {string} */
export function label(take) {
  return take.name || [take.data.language, take.data.character].filter(Boolean).join(" on ");
}
