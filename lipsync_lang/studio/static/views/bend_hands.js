/** Hands on the keys of a line: a pose is bent where it is seen, on its curve in the timeline. */

import { withKey, withMoved } from "../timeline/bend_points.js";

/** Pixels around a key in which a pointer takes it. */
const REACH = 9;
/** Weight of a press of a key. */
const STEP = 0.05;

/** @typedef {import("../timeline/bend_points.js").Key} Key */

/** Bends of the line in a sentence view. */
export class BendHands {
  /** @param {import("./sentence_view.js").SentenceView} view */
  constructor(view) {
    this.view = view;
    this.studio = view.studio;
    /** A press on a curve bends it. */
    this.on = false;
    /** The key that is chosen. @type {{pose: string, which: number} | null} */
    this.chosen = null;
    /** Seconds and amount between the pointer and the key that is dragged. */
    this.apart = [0, 0];
  }

  /** @param {string} row @returns {string[]} its poses: two for a mirrored pair, which are bent as one */
  #sides(row) {
    return this.studio.take?.rows.get(row)?.sides ?? [row];
  }

  /** @param {string} row @returns {Key[]} */
  keys(row) {
    return this.studio.settings.bends?.[this.#sides(row)[0]] ?? [];
  }

  /** @param {import("../line/take.js").Take} take @returns {string[]} mirrored pairs that different keys bend alike */
  uneven(take) {
    const [bends, pairs] = [this.studio.settings.bends ?? {}, [...take.rows].filter(([, { sides }]) => sides)];
    return pairs.flatMap(([both, { sides = [] }]) =>
      new Set(sides.map((one) => JSON.stringify(bends[one]))).size > 1 ? [both] : []);
  }

  /** Keys to draw on a pose: seconds, and the weight that is asked for. @param {string} pose @returns {Key[]} */
  shown(pose) {
    return this.keys(pose).map(([at, amount]) => [at, Math.min(1, Math.max(0, this.#plain(pose, at) + amount))]);
  }

  /** @param {string} pose @param {number} seconds @returns {number} its weight without the bend */
  #plain(pose, seconds) {
    const { take } = this.studio, { making } = take?.data ?? {}, row = take?.rows.get(pose);
    if (!take || !making || !row) return 0;
    const names = making.stages.map((one) => one.name), bent = names.indexOf("bend");
    const last = (bent < 0 ? names.findIndex((one) => one === "rest" || one === "switch") : bent) - 1;
    const curve = take.stages[making.moving.indexOf(row.pose)]?.[last];
    return curve ? curve[take.frameAt(seconds)] / 65535 : 0;
  }

  /**
   * Take a key under the pointer; with Ctrl, or where bending is on, a new one.
   * @param {number} x @param {number} y @param {PointerEvent} event
   * @returns {boolean} true if a key is taken
   */
  press(x, y, event) {
    const { timeline, swapped } = this.view, row = timeline.rowAt(y), pose = timeline.shown?.rows[row];
    if (!pose || swapped) return false;
    const which = this.shown(pose).findIndex(
      ([at, weight]) => Math.hypot(timeline.x(at) - x, timeline.y(row, weight) - y) < REACH,
    );
    const adds = this.on || event.ctrlKey || event.metaKey;
    if (which < 0 && !(adds && this.#add(pose, timeline.at(x), timeline.weightAt(row, y)))) return false;
    if (which >= 0) this.choose(pose, which);
    const [at, amount] = this.#now() ?? [0, 0];
    this.apart = [at - timeline.at(x), amount - timeline.weightAt(row, y)];
    this.view.pick(row);
    return true;
  }

  /** The chosen key; another tab or an undo may have deleted it. @returns {Key | undefined} */
  #now() {
    return this.chosen ? this.keys(this.chosen.pose)[this.chosen.which] : undefined;
  }

  /** @param {string} pose @param {number} which */
  choose(pose, which) {
    this.chosen = { pose, which };
    this.view.timeline.stale = true;
    this.studio.wake();
  }

  /**
   * @param {string} pose @param {number} seconds @param {number} weight that the pose should have there
   * @returns {boolean} false where there cannot be a key
   */
  #add(pose, seconds, weight) {
    const { take } = this.studio, row = take?.rows.get(pose);
    if (!take || !row || row.pose < 0) {
      this.studio.tell("A channel of the rig follows its poses: bend a pose");
      return false;
    }
    if (take.data.spoken.words.length && take.wordOf(take.phonemeAt(seconds)) < 0) {
      this.studio.tell("A key belongs to a word: put it within one, not in a pause");
      return false;
    }
    const amount = Math.min(1, Math.max(-1, weight - this.#plain(pose, seconds)));
    const [keys, which] = withKey(this.keys(pose), seconds, amount);
    this.#set(pose, keys, false);
    this.choose(pose, which);
    return true;
  }

  /** Add a key at the playhead to the chosen pose, or choose the one there. */
  addHere() {
    const { timeline } = this.view, pose = timeline.line.rows[timeline.row], { time } = this.studio.player;
    if (!pose) this.studio.tell("Choose a pose with ↑ or ↓ first");
    else if (this.#add(pose, time, this.studio.take?.weight(pose, this.studio.take.frameAt(time)) ?? 0))
      this.#done();
  }

  /** @param {number} x @param {number} y @param {boolean} done */
  drag(x, y, done) {
    const { timeline } = this.view;
    if (!this.chosen || !this.#now()) return;
    const { pose, which } = this.chosen, [seconds, amount] = this.apart;
    const weight = timeline.weightAt(timeline.line.rows.indexOf(pose), y) + amount;
    this.#set(pose, withMoved(this.keys(pose), which, timeline.at(x) + seconds, weight), done);
    this.studio.dragged(!done);
  }

  /** @param {number} way by which the chosen key is raised, in steps @returns {boolean} false if none is chosen */
  raise(way) {
    const now = this.#now();
    if (!this.chosen || !now) return false;
    const { pose, which } = this.chosen, [at, amount] = now;
    this.#set(pose, withMoved(this.keys(pose), which, at, amount + way * STEP), true);
    return true;
  }

  /** Delete the chosen key. @returns {boolean} false if none is chosen */
  remove() {
    if (!this.chosen || !this.#now()) return false;
    const { pose, which } = this.chosen;
    this.chosen = null;
    this.#set(pose, this.keys(pose).toSpliced(which, 1), true);
    return true;
  }

  #done() {
    if (this.chosen) this.#set(this.chosen.pose, this.keys(this.chosen.pose), true);
  }

  /** @param {string} pose @param {Key[]} keys @param {boolean} done */
  #set(pose, keys, done) {
    const { settings } = this.studio, bends = { ...settings.bends };
    for (const side of this.#sides(pose)) {
      if (keys.length) bends[side] = keys;
      else delete bends[side];
    }
    this.view.set({ ...settings, bends }, `Bend ${pose}`, done);
  }
}
