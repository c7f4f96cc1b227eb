// @ts-check
/**
 * Player of archives of takes (.takes) for the web and three.js; no dependency.
 *
 *   const archive = new Archive(await (await fetch("crab.takes")).arrayBuffer());
 *   const player = new Player(archive);
 *   player.play("english/intro_001", 0.1);
 *   player.advance(seconds);       // once in each frame
 *   player.apply(mesh);            // three.js: morph targets of the poses' names
 *
 * Times are seconds on the timeline of a line, whose sound starts at `player.delay`. After
 * `play`, playing makes no objects. A damaged curve holds where its keys run out.
 */

const MAGIC = "LLTAKES\0";
const VERSION = 1;
const HEADER = 64;
const SLOT = 16;
const HEAD = 20;
const TRACK = 16;
const STEPS = 1023;
const CRC_AT = 48;
const DECODER = new TextDecoder();
const ENCODER = new TextEncoder();

const CRC_PARTS = Uint32Array.from({ length: 256 }, (_, number) => {
  let value = number;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

/**
 * @param {Uint8Array} bytes
 * @param {number} first
 * @param {number} end
 * @param {number} [crc]
 */
function crc32(bytes, first, end, crc = 0) {
  let value = ~crc;
  for (let at = first; at < end; at++) {
    value = CRC_PARTS[(value ^ bytes[at]) & 255] ^ (value >>> 8);
  }
  return ~value >>> 0;
}

/** An archive or a part of it is damaged, of another version, or not an archive. */
export class TakesError extends Error {}

/** An archive in memory. */
export class Archive {
  /** @param {ArrayBuffer} buffer the file; its bytes are not copied */
  constructor(buffer) {
    this.bytes = new Uint8Array(buffer);
    this.view = new DataView(buffer);
    const size = buffer.byteLength;
    const magic = String.fromCharCode(...this.bytes.subarray(0, 8));
    if (magic !== MAGIC) throw new TakesError("is not an archive of takes");
    if (size < HEADER) throw new TakesError("its header ends early");
    const version = this.view.getUint16(8, true);
    if (version !== VERSION) {
      throw new TakesError(`has version ${version}; this player reads ${VERSION}`);
    }
    if (this.view.getUint16(10, true)) throw new TakesError("is a patch, not an archive");
    this.count = this.view.getUint32(12, true);
    this.slots = this.view.getUint32(16, true);
    const poses = this.view.getUint32(20, true);
    this.index = this.long(24);
    this.takes = this.long(32);
    if (this.long(40) !== size) throw new TakesError(`has ${size} bytes of ${this.long(40)}`);
    const ordered = HEADER <= this.index && this.index <= this.takes && this.takes <= size;
    const whole = ordered && this.takes - this.index === this.slots * SLOT;
    if (!whole || !this.slots || this.slots & (this.slots - 1)) {
      throw new TakesError("its parts overlap");
    }
    const crc = crc32(this.bytes, CRC_AT + 4, this.takes, crc32(this.bytes, 0, CRC_AT));
    if (crc !== this.view.getUint32(CRC_AT, true)) {
      throw new TakesError("the checksum of its index is wrong");
    }
    /** End of the take that `find` found last. */
    this.stop = 0;
    /** Names of the poses, in the order of `Player.weights`. @type {string[]} */
    this.poses = [];
    for (let at = HEADER; this.poses.length < poses; ) {
      const length = at + 2 <= this.index ? this.view.getUint16(at, true) : size;
      if (at + 2 + length > this.index) throw new TakesError("its names of poses are damaged");
      this.poses.push(DECODER.decode(this.bytes.subarray(at + 2, at + 2 + length)));
      at += 2 + length;
    }
  }

  /** @param {number} at */
  long(at) {
    return this.view.getUint32(at, true) + this.view.getUint32(at + 4, true) * 2 ** 32;
  }

  /** Returns true if the checksum of all takes is right. */
  isWhole() {
    const body = crc32(this.bytes, this.takes, this.bytes.length);
    return body === this.view.getUint32(CRC_AT + 4, true);
  }

  /**
   * Returns the position of a take such as `english/intro_001`, or 0 if there is none.
   * @param {string} name
   */
  find(name) {
    const text = ENCODER.encode(name);
    let hash = 0x811c9dc5;
    for (const byte of text) hash = Math.imul(hash ^ byte, 0x01000193) >>> 0;
    for (let probe = 0; probe < this.slots; probe++) {
      const slot = this.index + ((hash + probe) & (this.slots - 1)) * SLOT;
      const at = this.long(slot);
      if (!at) return 0;
      const end = at + this.view.getUint32(slot + 12, true);
      if (this.view.getUint32(slot + 8, true) !== hash || end > this.bytes.length) continue;
      if (end < at + 4 + text.length || this.view.getUint16(at, true) !== text.length) continue;
      if (!text.every((byte, number) => byte === this.bytes[at + 4 + number])) continue;
      const body = at + 4 + Math.ceil(text.length / 4) * 4;
      this.stop = end;
      return this.isSound(body, end) ? body : 0;
    }
    return 0;
  }

  /**
   * Returns true if the head of a take and its tracks are sound; keys are checked as they play.
   * @param {number} body
   * @param {number} end
   */
  isSound(body, end) {
    const view = this.view;
    if (body + HEAD > end) return false;
    const rate = view.getFloat32(body, true);
    const frames = view.getUint32(body + 12, true);
    const tracks = view.getUint16(body + 16, true);
    const [start, delay] = [view.getFloat32(body + 4, true), view.getFloat32(body + 8, true)];
    if (!(rate > 0 && rate < 1e6 && Math.abs(start) < 1e6 && Math.abs(delay) < 1e6)) return false;
    if (!frames || tracks > this.poses.length || body + HEAD + tracks * TRACK > end) return false;
    for (let number = 0; number < tracks; number++) {
      const track = body + HEAD + number * TRACK;
      const [pose, count] = [view.getUint16(track, true), view.getUint16(track + 2, true)];
      if (pose >= this.poses.length || !count) return false;
      if (body + view.getUint32(track + 4, true) + 2 > end) return false;
      const [low, span] = [view.getFloat32(track + 8, true), view.getFloat32(track + 12, true)];
      if (!(Math.abs(low) < 1e9 && Math.abs(span) < 1e9)) return false;
    }
    return true;
  }
}

/** One character that plays lines of an archive. */
export class Player {
  /** @param {Archive} archive */
  constructor(archive) {
    const poses = archive.poses.length;
    this.archive = archive;
    /** Weight of each pose of the archive now; 0 at rest. */
    this.weights = new Float32Array(poses);
    this.time = this.start = this.delay = this.end = this.rate = this.frames = 0;
    this.playing = false;
    this.from = new Float32Array(poses);
    this.fade = this.left = this.tracks = this.stop = 0;
    // Cursors: a column for each number of a span between two keys.
    this.pose = new Uint16Array(poses);
    this.keys = new Float64Array(poses);
    this.at = new Float64Array(poses);
    this.keyCount = new Uint16Array(poses);
    this.keysLeft = new Uint16Array(poses);
    this.first = new Uint32Array(poses);
    this.last = new Uint32Array(poses);
    this.begin = new Float32Array(poses);
    this.finish = new Float32Array(poses);
    this.low = new Float32Array(poses);
    this.scale = new Float32Array(poses);
  }

  /** Seconds of the sound now; it has not started below 0. */
  get soundTime() {
    return this.time - this.delay;
  }

  /**
   * Plays a line, from its movement before the sound or from a time; fades from what is shown.
   * Returns false, and goes on as before, if the archive lacks the line.
   * @param {string} name
   * @param {number} [fade]
   * @param {number} [at]
   */
  play(name, fade = 0, at) {
    const body = this.archive.find(name);
    if (!body) return false;
    const view = this.archive.view;
    this.hold(fade);
    this.stop = this.archive.stop;
    this.rate = view.getFloat32(body, true);
    this.start = view.getFloat32(body + 4, true);
    this.delay = view.getFloat32(body + 8, true);
    this.frames = view.getUint32(body + 12, true);
    this.tracks = view.getUint16(body + 16, true);
    this.end = this.start + (this.frames - 1) / this.rate;
    this.playing = true;
    for (let n = 0; n < this.tracks; n++) {
      const track = body + HEAD + n * TRACK;
      this.pose[n] = view.getUint16(track, true);
      this.keyCount[n] = view.getUint16(track + 2, true);
      this.keys[n] = body + view.getUint32(track + 4, true);
      this.low[n] = view.getFloat32(track + 8, true);
      this.scale[n] = view.getFloat32(track + 12, true) / STEPS;
      this.rewind(n);
    }
    this.time = at ?? Math.min(0, this.start);
    this.show();
    return true;
  }

  /**
   * Plays the same line in another language, from the same share of its length.
   * @param {string} name
   * @param {number} [fade]
   */
  switch(name, fade = 0) {
    const share = (this.time - this.start) / Math.max(this.end - this.start, 1e-6);
    if (!this.play(name, fade)) return false;
    this.time = this.start + share * (this.end - this.start);
    this.show();
    return true;
  }

  /** Moves on by the time of a frame. @param {number} seconds */
  advance(seconds) {
    this.time += seconds;
    this.left = Math.max(0, this.left - seconds);
    this.show();
  }

  /** Goes to a time on the line's timeline; a fade ends. @param {number} time */
  seek(time) {
    this.time = time;
    this.left = 0;
    this.show();
  }

  /** Ends the line: fades to rest. @param {number} [fade] */
  skip(fade = 0) {
    this.hold(fade);
    this.playing = false;
    this.tracks = 0;
    this.show();
  }

  /**
   * Combines speech with the game's own weights into `out`: `max`, `add`, or `replace`, which
   * takes speech where `region` is 1 and the game's own where it is 0.
   * @param {ArrayLike<number>} own
   * @param {"max" | "add" | "replace"} mode
   * @param {ArrayLike<number>} region
   * @param {Float32Array | number[]} out
   */
  blend(own, mode, region, out) {
    for (let pose = 0; pose < this.weights.length; pose++) {
      const mine = own[pose];
      const speech = this.weights[pose];
      if (mode === "max") out[pose] = Math.max(mine, speech);
      else if (mode === "add") out[pose] = Math.min(mine + speech, 1);
      else out[pose] = mine + (speech - mine) * region[pose];
    }
  }

  /**
   * Moves the morph targets of a three.js mesh that have the names of poses.
   * @param {{morphTargetDictionary?: Record<string, number>, morphTargetInfluences?: number[]}} mesh
   * @param {ArrayLike<number>} [weights] those of `blend`
   */
  apply(mesh, weights = this.weights) {
    const { morphTargetDictionary: numbers, morphTargetInfluences: shapes } = mesh;
    if (!numbers || !shapes) return;
    for (let pose = 0; pose < weights.length; pose++) {
      const number = numbers[this.archive.poses[pose]];
      if (number !== undefined) shapes[number] = weights[pose];
    }
  }

  /** @param {number} fade */
  hold(fade) {
    this.from.set(this.weights);
    this.fade = this.left = Math.max(0, fade);
  }

  /** @param {number} n */
  rewind(n) {
    const word = this.archive.view.getUint16(this.keys[n], true);
    this.at[n] = this.keys[n] + 2;
    this.keysLeft[n] = this.keyCount[n] - 1;
    this.first[n] = this.last[n] = 0;
    this.begin[n] = this.finish[n] = this.low[n] + (word & STEPS) * this.scale[n];
  }

  /** @param {number} n */
  next(n) {
    const view = this.archive.view;
    let at = this.at[n];
    const word = at + 2 <= this.stop ? view.getUint16(at, true) : 0;
    let step = word >> 10;
    if (!step) {
      at += 2;
      if (at + 2 > this.stop) {
        this.keysLeft[n] = 0;
        return;
      }
      step = view.getUint16(at, true);
    }
    this.at[n] = at + 2;
    this.keysLeft[n]--;
    this.first[n] = this.last[n];
    this.begin[n] = this.finish[n];
    this.last[n] += step;
    this.finish[n] = this.low[n] + (word & STEPS) * this.scale[n];
  }

  show() {
    const { weights, first, last } = this;
    weights.fill(0);
    const most = Math.max(this.frames - 1, 0);
    const frame = Math.min(Math.max((this.time - this.start) * this.rate, 0), most);
    for (let n = 0; n < this.tracks; n++) {
      if (frame < first[n]) this.rewind(n);
      while (frame > last[n] && this.keysLeft[n]) this.next(n);
      const share = last[n] > first[n] ? (frame - first[n]) / (last[n] - first[n]) : 1;
      weights[this.pose[n]] = this.begin[n] + (this.finish[n] - this.begin[n]) * share;
    }
    if (this.time >= this.end) this.playing = false;
    if (this.left <= 0) return;
    const share = this.left / this.fade;
    for (let pose = 0; pose < weights.length; pose++) {
      weights[pose] += (this.from[pose] - weights[pose]) * share;
    }
  }
}
