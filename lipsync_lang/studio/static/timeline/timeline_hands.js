/** Hands on a timeline: scrub, pick a row, tap for a reason, zoom with two fingers or the wheel. */

/** Pixels that a finger may move in a tap. */
const TAP = 8;
/** Pixels between two fingers, below which their distance says nothing. */
const APART = 10;
/** Pixels around a boundary in which it is taken: by a mouse or pen, and by a finger. */
const REACH = 5, FINGER_REACH = 16;
/** Pixels of a wheel for a zoom by e. */
const WHEEL = 300;
/** Pixels after which a press on a word moves it. */
const SLACK = 4;

/**
 * The target of a pointer: a boundary (`through` itself), or a word with all of its boundaries.
 * @typedef {{boundary: number, through: number, word: number}} Grab
 */

/**
 * Listen to the pointers on a timeline.
 * @param {import("./timeline.js").Timeline} timeline
 */
export function listen(timeline) {
  const { canvas, does } = timeline;
  /** @type {number[]} */
  let pressed = [];
  /** The taken target, the distance of the pointer from it, and whether it is dragged yet. @type {Grab | null} */
  let grab = null;
  let apart = 0, dragging = false, pulling = false;
  /** @type {Map<number, PointerEvent>} */
  const down = new Map();
  const place = (/** @type {MouseEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const taken = (/** @type {PointerEvent} */ event) => {
    const [x, y] = place(event);
    if (!does.drag) return null;
    const word = timeline.wordAt(x, y);
    if (word >= 0) {
      const [, boundary, through] = timeline.line.take.data.spoken.words[word];
      return { boundary, through, word };
    }
    const boundary = timeline.boundaryAt(x, y, event.pointerType === "touch" ? FINGER_REACH : REACH);
    return boundary < 0 ? null : { boundary, through: boundary, word };
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, event);
    const [x, y] = place(event);
    pressed = [x, y];
    does.hover(null);
    pulling = down.size === 1 && Boolean(does.press?.(x, y, event));
    if (pulling) return;
    grab = down.size === 1 ? taken(event) : null;
    if (grab) apart = x - timeline.x(timeline.line.take.data.spoken.times[grab.boundary]);
    dragging = grab !== null && grab.word < 0;
    if (grab && dragging) {
      does.drag?.(grab, timeline.at(x - apart), false, event);
      return;
    }
    if (down.size === 1) {
      does.seek(timeline.at(x));
      does.word?.(timeline.wordAt(x, y), event.shiftKey);
      does.phoneme?.(timeline.phonemeAt(x, y), event.shiftKey);
      const row = timeline.rowAt(y);
      if (row >= 0) does.pick(row);
    }
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = place(event);
    const before = down.get(event.pointerId);
    if (!before) {
      const over = taken(event);
      canvas.style.cursor = over ? (over.word < 0 ? "ew-resize" : "grab") : "";
      if (event.pointerType === "mouse")
        does.hover({ seconds: timeline.at(x), row: timeline.rowAt(y), x: event.clientX, y: event.clientY });
      return;
    }
    if (pulling) {
      if (Math.hypot(x - pressed[0], y - pressed[1]) > SLACK) does.pull?.(x, y, false);
      return;
    }
    dragging ||= grab !== null && Math.abs(x - pressed[0]) > SLACK;
    if (grab && dragging) does.drag?.(grab, timeline.at(x - apart), false, event);
    else if (down.size === 1 && !grab) (does.scrub ?? does.seek)(timeline.at(x));
    if (down.size === 2) {
      const still = [...down.values()].find((one) => one.pointerId !== event.pointerId) ?? event;
      const [fixed] = place(still), [old] = place(before);
      if (Math.abs(old - fixed) > APART)
        timeline.zoom(Math.abs(x - fixed) / Math.abs(old - fixed), timeline.at((x + fixed) / 2));
    }
    down.set(event.pointerId, event);
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      const { pointerId, pointerType, clientX, clientY } = /** @type {PointerEvent} */ (event);
      down.delete(pointerId);
      const [x, y] = place(/** @type {PointerEvent} */ (event)), [a, b] = pressed;
      if (pulling) {
        pulling = false;
        does.pull?.(x, y, true);
        return;
      }
      const held = dragging ? grab : null;
      grab = null;
      dragging = false;
      if (held) {
        does.drag?.(held, timeline.at(x - apart), true, /** @type {PointerEvent} */ (event));
        return;
      }
      const tap = name === "pointerup" && pointerType !== "mouse" && Math.hypot(x - a, y - b) < TAP;
      if (tap) does.hover({ seconds: timeline.at(x), row: timeline.rowAt(y), x: clientX, y: clientY });
    });
  }
  canvas.addEventListener("dblclick", (event) => {
    const [x, y] = place(event);
    does.open?.(timeline.at(x), timeline.rowAt(y), timeline.phonemeAt(x, y));
  });
  canvas.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && does.hover(null));
  canvas.addEventListener("wheel", (event) => {
    const [x] = place(event);
    if (event.ctrlKey) timeline.zoom(Math.exp(-event.deltaY / WHEEL), timeline.at(x));
    else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      const step = ((event.deltaX || event.deltaY) / timeline.plotWidth) * (timeline.to - timeline.from);
      timeline.setView(timeline.from + step, timeline.to + step);
    } else return;
    event.preventDefault();
  }, { passive: false });
}
