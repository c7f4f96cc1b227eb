/** The whole line in a strip: its sound, its findings, and the part that the timeline shows. */

import { outline } from "./scales.js";

const HEIGHT = 36;

/** A strip that moves the view of a timeline. */
export class Overview {
  /**
   * @param {HTMLCanvasElement} canvas @param {import("./timeline.js").Timeline} timeline
   * @param {boolean} [stays] also while the timeline shows all: a strip that came and went would move it under the hand
   */
  constructor(canvas, timeline, stays = false) {
    this.canvas = canvas;
    this.timeline = timeline;
    this.stays = stays;
    /** @type {[number, number][]} */
    this.shape = [];
    const go = (/** @type {PointerEvent} */ event) => {
      const box = canvas.getBoundingClientRect();
      const { start, end, from, to } = timeline;
      const seconds = start + ((event.clientX - box.left) / box.width) * (end - start);
      timeline.setView(seconds - (to - from) / 2, seconds + (to - from) / 2);
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      go(event);
    });
    canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && go(event));
  }

  /** @param {number} seconds of the playhead */
  draw(seconds) {
    const { canvas, timeline } = this, { start, end, from, to, line, colours } = timeline;
    canvas.hidden = !this.stays && to - from >= end - start - 1e-6;
    const context = canvas.getContext("2d");
    if (canvas.hidden || !context) return;
    const ratio = Math.min(3, window.devicePixelRatio || 1), wide = canvas.clientWidth;
    if (canvas.width !== Math.round(wide * ratio))
      [canvas.width, canvas.height] = [Math.round(wide * ratio), HEIGHT * ratio];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, wide, HEIGHT);
    const x = (/** @type {number} */ time) => ((time - start) / (end - start)) * wide;
    context.fillStyle = colours.wave;
    if (line.sound) {
      const { samples, rate, start: begins = 0 } = line.sound;
      if (this.shape.length !== wide) this.shape = outline(samples, rate, start - begins, end - begins, wide);
      const tall = HEIGHT / 2 - 2, most = timeline.loudest || 1;
      this.shape.forEach(([low, high], column) =>
        context.fillRect(column, HEIGHT / 2 - (high / most) * tall, 1, Math.max(1, ((high - low) / most) * tall)),
      );
    }
    for (const { verdict, findings } of line.take.data.figures) {
      context.fillStyle = colours.fail;
      if (verdict === "FAIL") for (const [time] of findings) context.fillRect(x(time) - 1, 0, 2, 6);
    }
    context.fillStyle = colours.accent;
    context.globalAlpha = 0.2;
    context.fillRect(x(from), 0, x(to) - x(from), HEIGHT);
    context.globalAlpha = 1;
    context.fillRect(x(seconds) - 0.75, 0, 1.5, HEIGHT);
  }
}
