/**
 * Clock of a line: the sound's own where there is sound, else the browser's.
 */

/**
 * Write a WAV file with silence before the sound, and after it up to the end.
 * @param {Int16Array} samples
 * @param {number} rate in hertz
 * @param {number} start seconds of the file's first sample; negative before the sound
 * @param {number} end seconds of its end
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function wave(samples, rate, start, end) {
  const first = Math.round(start * rate);
  const count = Math.max(1, Math.ceil((end - start) * rate));
  const out = new Uint8Array(44 + 2 * count);
  const view = new DataView(out.buffer);
  const text = (/** @type {number} */ at, /** @type {string} */ letters) =>
    [...letters].forEach((letter, n) => { out[at + n] = letter.charCodeAt(0); });
  text(0, "RIFF"); view.setUint32(4, 36 + 2 * count, true); text(8, "WAVEfmt ");
  view.setUint32(16, 16, true); view.setUint16(20, 1, true); view.setUint16(22, 1, true);
  view.setUint32(24, rate, true); view.setUint32(28, 2 * rate, true);
  view.setUint16(32, 2, true); view.setUint16(34, 16, true);
  text(36, "data"); view.setUint32(40, 2 * count, true);
  for (let n = Math.max(0, -first); n < count && n + first < samples.length; n++) {
    view.setInt16(44 + 2 * n, samples[n + first], true);
  }
  return out;
}

/** Seconds for which the clock runs on by itself while the sound's own stands still. */
const PATIENCE = 0.25;
/** Seconds by which the sound's clock may be rounded. */
const SAME = 1e-4;

/**
 * Sound of a line; `start` is the seconds of its first sample, 0 unless given.
 * @typedef {{rate: number, samples: Int16Array, start?: number}} Sound
 */

/** A playing line. Times are seconds of the schedule: the sound starts at 0. */
export class Player {
  /**
   * @param {number} start
   * @param {number} end
   * @param {Sound | null} sound
   * @param {() => void} changed called when playing starts or stops
   */
  constructor(start, end, sound, changed = () => {}) {
    this.start = start;
    this.end = end;
    this.changed = changed;
    this.playing = false;
    this.rate = 1;
    /** @type {[number, number] | null} seconds */
    this.loop = null;
    this.now = start;
    this.since = 0;
    /** True once the sound is heard: until then, no time passes. */
    this.heard = false;
    /** @type {HTMLAudioElement | null} */
    this.audio = null;
    if (sound) {
      const begins = sound.start ?? 0;
      const audio = new Audio();
      audio.preservesPitch = true;
      audio.src = URL.createObjectURL(
        new Blob([wave(sound.samples, sound.rate, start - begins, end - begins)], { type: "audio/wav" }),
      );
      audio.addEventListener("error", () => { this.audio = null; });
      audio.addEventListener("pause", () => { if (!audio.ended) this.pause(); }); // a headset's button, for one
      this.audio = audio;
    }
  }

  /** @returns {number} */
  get time() {
    if (!this.playing) return this.now;
    const clock = this.#clock();
    const [low, high] = this.loop ?? [this.start, this.end];
    if (clock < high) return clock;
    if (this.loop) {
      this.seek(low);
      return low;
    }
    this.pause();
    this.now = this.end;
    return this.end;
  }

  set time(seconds) {
    this.seek(seconds);
  }

  /** @returns {number} seconds, running on between the ticks of the sound's clock */
  #clock() {
    const passed = (performance.now() - this.since) / 1000;
    if (!this.audio) return this.now + passed * this.rate;
    const heard = this.start + this.audio.currentTime;
    if (Math.abs(heard - this.now) > SAME || this.audio.ended) {
      this.heard = true;
      this.now = this.audio.ended ? this.end : heard;
      this.since = performance.now();
      return this.now;
    }
    return this.now + (this.heard ? Math.min(passed, PATIENCE) * this.rate : 0);
  }

  play() {
    if (this.playing) return;
    const [low, high] = this.loop ?? [this.start, this.end];
    if (this.now >= high - 1e-3 || this.now < low) this.now = low;
    this.playing = true;
    this.heard = false;
    this.since = performance.now();
    if (this.audio) {
      this.audio.currentTime = this.now - this.start;
      this.audio.playbackRate = this.rate;
      this.#sound();
    }
    this.changed();
  }

  pause() {
    if (!this.playing) return;
    this.now = Math.min(this.#clock(), this.end);
    this.playing = false;
    this.audio?.pause();
    this.changed();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  /** @param {number} seconds */
  seek(seconds) {
    this.now = Math.max(this.start, Math.min(this.end, seconds));
    this.since = performance.now();
    this.heard = false;
    if (!this.audio) return;
    this.audio.currentTime = this.now - this.start;
    if (this.playing && this.audio.paused) this.#sound();
  }

  /** Start the sound; without a device, the browser's clock goes on alone. */
  #sound() {
    const { audio } = this;
    audio?.play().catch((error) => {
      if (error.name === "AbortError") return; // paused before it began
      this.audio = null;
      this.since = performance.now();
    });
  }

  /** Let go of the sound. */
  close() {
    this.pause();
    if (this.audio) URL.revokeObjectURL(this.audio.src);
    this.audio = null;
  }

  /** @param {number} rate 1 for ordinary speed; the pitch stays */
  setRate(rate) {
    const now = this.time;
    this.rate = rate;
    this.now = now;
    this.since = performance.now();
    if (this.audio) this.audio.playbackRate = rate;
  }
}
