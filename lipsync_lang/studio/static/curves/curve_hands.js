/** Pointers on an editor of curves: drag, choose, scale, add, pan and zoom. */

import { FINE, GRID, STEP, chosenPoints, clamp, scaled, shifted, snapped } from "./curve_points.js";

/** Pixels within which a pointer takes hold: of a mouse, and of a finger. */
const REACH = { mouse: 12, pen: 16, touch: 26 };
/** Pixels that a pointer moves before a press becomes a drag. */
const SLACK = 3;
/** Pixels of a wheel for a zoom by e. */
const WHEEL = 400;

/** @typedef {import("./curve_editor.js").CurveEditor} CurveEditor */

/** @param {CurveEditor} editor */
export function listenPointers(editor) {
  const { drawing } = editor, { svg } = drawing;
  /** @type {Map<number, [number, number]>} */
  const down = new Map();
  /** @type {Drag | null} */
  let drag = null;
  /** @param {MouseEvent} event @returns {[number, number]} */
  const place = (event) => {
    const box = svg.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const reach = (/** @type {PointerEvent} */ event) =>
    REACH[/** @type {keyof typeof REACH} */ (event.pointerType)] ?? REACH.mouse;

  svg.addEventListener("pointerdown", (event) => {
    if (event.button > 1) return;
    svg.setPointerCapture(event.pointerId);
    down.set(event.pointerId, place(event));
    if (down.size > 1) {
      drag?.cancel();
      drag = null;
      return;
    }
    const [x, y] = place(event);
    drag =
      event.button === 1
        ? new Drag(editor, x, y, { kind: "pan", pose: "", index: -1 }, event)
        : new Drag(editor, x, y, drawing.hit(x, y, reach(event)), event);
    event.preventDefault();
  });
  svg.addEventListener("pointermove", (event) => {
    const [x, y] = place(event), before = down.get(event.pointerId);
    if (!before) {
      editor.hover(drawing.at(x, y), drawing.hit(x, y, reach(event)));
      return;
    }
    if (down.size === 2) pinch(editor, before, [x, y], [...down].find(([id]) => id !== event.pointerId)?.[1] ?? before);
    else drag?.move(x, y, event);
    down.set(event.pointerId, [x, y]);
  });
  for (const name of ["pointerup", "pointercancel"]) {
    svg.addEventListener(name, (event) => {
      down.delete(/** @type {PointerEvent} */ (event).pointerId);
      if (name === "pointerup") drag?.end();
      else drag?.cancel();
      drag = null;
    });
  }
  svg.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !drag) return;
    drag.cancel();
    drag = null;
    event.stopImmediatePropagation();
  });
  svg.addEventListener("pointerleave", () => editor.hover(null, null));
  svg.addEventListener("dblclick", (event) => {
    const [x, y] = place(event), hit = drawing.hit(x, y, REACH.mouse);
    if (hit.kind === "point" || hit.kind === "handle") return;
    if (hit.kind === "curve") editor.focusPose(hit.pose);
    const [time, value] = drawing.at(x, y);
    editor.add(snapped(time, editor.step(event)), snapped(value, editor.step(event)));
  });
  svg.addEventListener("wheel", (event) => {
    const [x, y] = place(event), { view, wide, high } = drawing;
    const across = ((event.deltaX || event.deltaY) / wide) * (view[1] - view[0]);
    const sideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    const moved = sideways
      ? drawing.zoom(1, [0, 0], across, event.shiftKey ? 0 : (-event.deltaY / high) * (view[3] - view[2]))
      : drawing.zoom(Math.exp(-event.deltaY / WHEEL), drawing.at(x, y));
    if (moved || event.ctrlKey) event.preventDefault();
  }, { passive: false });
}

/**
 * @param {CurveEditor} editor
 * @param {[number, number]} before
 * @param {[number, number]} after
 * @param {[number, number]} still
 */
function pinch({ drawing }, before, after, still) {
  const apart = (/** @type {[number, number]} */ one) => Math.max(20, Math.hypot(one[0] - still[0], one[1] - still[1]));
  const [t, v] = drawing.at(before[0], before[1]), [to, high] = drawing.at(after[0], after[1]);
  drawing.zoom(
    apart(after) / apart(before),
    drawing.at((after[0] + still[0]) / 2, (after[1] + still[1]) / 2),
    (t - to) / 2,
    (v - high) / 2,
  );
}

/** One drag, from press to release; all its changes are one step. */
class Drag {
  /**
   * @param {CurveEditor} editor @param {number} x @param {number} y
   * @param {{kind: string, pose: string, index: number}} hit @param {PointerEvent} event
   */
  constructor(editor, x, y, hit, event) {
    this.editor = editor;
    this.x = x;
    this.y = y;
    this.hit = hit;
    this.dragged = false;
    this.known = false;
    this.more = event.shiftKey || event.ctrlKey || event.metaKey;
    this.chosen = editor.chosen;
    this.curves = editor.curves;
    this.boundary = editor.boundary;
    this.merge = editor.newStep("drag");
    if (hit.kind === "point") {
      this.known = editor.chosen.get(hit.pose)?.has(hit.index) ?? false;
      if (!this.known) editor.choose(hit.pose, hit.index, this.more);
      editor.focusPoint(hit.pose, hit.index);
    } else if (hit.kind === "boundary") editor.drawing.boundary.focus();
    else editor.drawing.svg.focus({ preventScroll: true });
    editor.held = true;
  }

  /** @param {number} x @param {number} y @param {PointerEvent} event */
  move(x, y, event) {
    if (!this.dragged && Math.hypot(x - this.x, y - this.y) < SLACK) return;
    if (!this.dragged && this.hit.kind === "point") this.editor.does.dragged?.(true);
    this.dragged = true;
    const { editor, hit } = this, { drawing } = editor, step = editor.step(event);
    const [t, v] = drawing.at(x, y), [from, base] = drawing.at(this.x, this.y);
    if (hit.kind === "point") this.#shift(t - from, v - base, step);
    else if (hit.kind === "handle") this.#scale(t - from, v - base);
    else if (hit.kind === "boundary") editor.setBoundary(snapped(t, step), { merge: this.merge, done: false });
    else if (hit.kind === "pan") drawing.zoom(1, [0, 0], from - t, base - v);
    else this.#sweep(x, y);
    if (hit.kind === "pan") [this.x, this.y] = [x, y];
  }

  /** @param {number} time @param {number} value @param {number} step */
  #shift(time, value, step) {
    const { editor, hit } = this, [t, v] = this.curves[hit.pose][hit.index];
    const right = time && snapped(t + time, step) - t, above = value && snapped(v + value, step) - v;
    editor.change(shifted(this.curves, editor.chosen, right, above), {
      merge: this.merge,
      done: false,
      title: editor.title("Move"),
    });
  }

  /** @param {number} time @param {number} value */
  #scale(time, value) {
    const { editor, hit } = this, points = chosenPoints(this.curves, editor.chosen).map(({ point }) => point);
    const times = points.map(([t]) => t), [first, last] = [Math.min(...times), Math.max(...times)];
    const most = Math.max(...points.map(([, v]) => v)), long = Math.max(FINE, last - first);
    const [kt, kv, about] = [
      [(long - time) / long, 1, last],
      [(long + time) / long, 1, first],
      [1, (most + value) / Math.max(STEP, most), first],
    ][hit.index];
    editor.change(scaled(this.curves, editor.chosen, kt, kv, about), {
      merge: this.merge,
      done: false,
      title: editor.title("Scale"),
    });
  }

  /** @param {number} x @param {number} y */
  #sweep(x, y) {
    const { editor } = this, { drawing } = editor;
    editor.marquee = [this.x, this.y, x, y];
    const [left, top] = drawing.at(Math.min(x, this.x), Math.min(y, this.y)),
      [right, low] = drawing.at(Math.max(x, this.x), Math.max(y, this.y));
    const chosen = new Map([...(this.more ? this.chosen : [])].map(([pose, all]) => [pose, new Set(all)]));
    for (const pose of editor.shown) {
      editor.curves[pose].forEach(([t, v], index) => {
        if (t >= left && t <= right && v >= low && v <= top)
          chosen.set(pose, (chosen.get(pose) ?? new Set()).add(index));
      });
    }
    editor.chooseAll(chosen);
  }

  end() {
    const { editor, hit } = this;
    editor.does.dragged?.(false);
    editor.held = false;
    editor.marquee = null;
    if (this.dragged) {
      if (editor.boundary !== this.boundary) editor.setBoundary(editor.boundary, { merge: this.merge, done: true });
      if (editor.curves !== this.curves)
        editor.change(editor.curves, {
          merge: this.merge,
          done: true,
          title: editor.title(hit.kind === "handle" ? "Scale" : "Move"),
        });
    } else if (hit.kind === "curve") editor.focusPose(hit.pose);
    else if (hit.kind === "point" && this.known) editor.choose(hit.pose, hit.index, this.more);
    else if (hit.kind === "plot") {
      editor.chooseAll(new Map());
      editor.seek(clamp(editor.drawing.at(this.x, this.y)[0], 0, 1));
    }
    editor.draw();
  }

  cancel() {
    const { editor } = this, { curves, boundary } = this;
    editor.does.dragged?.(false);
    editor.held = false;
    editor.marquee = null;
    if (editor.curves !== curves) editor.change(curves, { merge: this.merge, done: true, title: editor.title("Move") });
    if (editor.boundary !== boundary) editor.setBoundary(boundary, { merge: this.merge, done: true });
    editor.draw();
  }
}

/**
 * Listen to the keys of an editor, where the plot has the focus.
 * @param {CurveEditor} editor
 */
export function listenKeys(editor) {
  const { svg } = editor.drawing;
  svg.addEventListener("focusin", (event) => {
    const target = /** @type {Element} */ (event.target), index = Number(target.getAttribute("data-index") ?? -1);
    const pose = target.closest("[data-pose]")?.getAttribute("data-pose");
    if (pose && index >= 0 && !editor.chosen.get(pose)?.has(index) && !editor.held) editor.choose(pose, index, false);
  });
  svg.addEventListener("keydown", (event) => {
    if (!press(editor, event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
}

/**
 * Act on a key.
 * @param {CurveEditor} editor @param {KeyboardEvent} event
 * @returns {boolean} whether it does anything
 */
export function press(editor, event) {
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
  const [right, up] = steps[/** @type {keyof typeof steps} */ (event.key)] ?? [0, 0];
  const step = event.altKey ? FINE : event.shiftKey ? GRID : STEP;
  const command = event.ctrlKey || event.metaKey, { drawing } = editor;
  if (event.key !== "a") editor.cursor = null;
  if (!right && !up)
    return (
      !event.altKey && editor.key(event.key.length === 1 ? event.key.toLowerCase() : event.key, command, event.shiftKey)
    );
  if (command) return false;
  if (event.target === drawing.boundary) {
    editor.setBoundary(snapped(editor.boundary + (right + up) * step), {
      merge: editor.sameStep("boundary"),
      done: true,
    });
  } else if (editor.chosen.size) editor.nudge(right * step, up * step);
  else return false;
  return true;
}
