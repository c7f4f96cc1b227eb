/** Steps of a view's own that are undone and done again, apart from edits of packs. */

/** @typedef {{title: string, merge: string, back: () => void, forth: () => void}} LineStep */

/** Undo without end for a line. */
export class LineSteps {
  /** @param {() => void} changed */
  constructor(changed) {
    this.changed = changed;
    /** @type {LineStep[]} */
    this.done = [];
    /** @type {LineStep[]} */
    this.undone = [];
  }

  get undo() {
    return this.done.at(-1)?.title ?? null;
  }

  get redo() {
    return this.undone.at(-1)?.title ?? null;
  }

  /** @param {LineStep} step one with the `merge` of the last, if not empty, becomes part of it */
  push(step) {
    const last = this.done.at(-1);
    if (last && step.merge && last.merge === step.merge) this.done[this.done.length - 1] = { ...step, back: last.back };
    else this.done.push(step);
    this.undone = [];
    this.changed();
  }

  /** @param {"undo" | "redo"} way */
  go(way) {
    const [from, to] = way === "undo" ? [this.done, this.undone] : [this.undone, this.done];
    const step = from.pop();
    if (!step) return;
    to.push({ ...step, merge: "" });
    step[way === "undo" ? "back" : "forth"]();
    this.changed();
  }

  clear() {
    this.done = [];
    this.undone = [];
    this.changed();
  }
}
