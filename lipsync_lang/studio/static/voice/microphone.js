/** Sends the samples of a microphone to the page in parts of some 10 ms. */

// The globals of an audio worklet are no part of the usual types.
const { AudioWorkletProcessor, registerProcessor, sampleRate } = /** @type {any} */ (globalThis);

class Microphone extends AudioWorkletProcessor {
  constructor() {
    super();
    this.part = new Float32Array(Math.ceil(sampleRate / 100 / 128) * 128);
    this.filled = 0;
  }

  /** @param {Float32Array[][]} inputs @returns {boolean} */
  process([[samples]]) {
    if (!samples) return true;
    this.part.set(samples, this.filled);
    this.filled += samples.length;
    if (this.filled >= this.part.length) {
      this.port.postMessage(this.part.slice());
      this.filled = 0;
    }
    return true;
  }
}

registerProcessor("microphone", Microphone);
