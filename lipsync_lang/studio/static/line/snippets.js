/** Short pieces of a line's sound, heard while its player stands still: in scrubbing, and of a phoneme or a word. */

/** Seconds of a piece in scrubbing, between two of them, and of the fades of each. */
const GRAIN = 0.09, APART = 0.045, FADE = 0.008;

export class Snippets {
  constructor() {
    /** @type {AudioContext | null} */
    this.context = null;
    /** The sound, and what the browser made of it. @type {[import("./player.js").Sound, AudioBuffer] | null} */
    this.ready = null;
    /** @type {AudioBufferSourceNode | null} */
    this.playing = null;
    this.last = 0;
  }

  /**
   * Hear the sound around a moment, in the midst of a drag.
   * @param {import("./player.js").Sound | null} sound
   * @param {number} seconds
   */
  scrub(sound, seconds) {
    const now = performance.now() / 1000;
    if (now - this.last < APART) return;
    this.last = now;
    this.hear(sound, seconds - GRAIN / 2, seconds + GRAIN / 2);
  }

  /**
   * Hear a part of the sound; what is still heard ends.
   * @param {import("./player.js").Sound | null} sound
   * @param {number} from seconds of the line
   * @param {number} to
   */
  hear(sound, from, to) {
    if (!sound || !sound.samples.length || to <= from) return;
    this.context ??= new AudioContext();
    const { context } = this, begin = Math.max(0, from - (sound.start ?? 0)), length = to - (sound.start ?? 0) - begin;
    if (length <= 0) return;
    if (this.ready?.[0] !== sound) this.ready = [sound, bufferOf(context, sound)];
    context.resume();
    this.playing?.stop();
    const source = context.createBufferSource(), gain = context.createGain(), start = context.currentTime;
    source.buffer = this.ready[1];
    source.connect(gain).connect(context.destination);
    const fade = Math.min(FADE, length / 2);
    gain.gain.setValueAtTime(0, start);
    gain.gain.linearRampToValueAtTime(1, start + fade);
    gain.gain.setValueAtTime(1, start + length - fade);
    gain.gain.linearRampToValueAtTime(0, start + length);
    source.start(start, begin, length);
    this.playing = source;
  }
}

/** @param {AudioContext} context @param {import("./player.js").Sound} sound */
function bufferOf(context, { samples, rate }) {
  const buffer = context.createBuffer(1, samples.length, rate);
  buffer.copyToChannel(Float32Array.from(samples, (one) => one / 32768), 0);
  return buffer;
}
