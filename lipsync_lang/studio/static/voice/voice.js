/** The page of a voice: samples of the microphone go out, and frames of the lips come back. */

import { made, the } from "../shell/elements.js";
import { Portrait } from "../face/portrait.js";
import { Take } from "../line/take.js";
import { unpack } from "../line/unpack.js";

const SHOWN_PHONES = 4;
const STRIP_SECONDS = 4;
const RETRY_MS = 1000;
const OFF = "The microphone is off";
const REFUSED = "The browser does not allow the microphone. Allow it for this page, and press Listen";
const ABSENT = "No microphone is plugged in. Plug one in, and press Listen";

/** @typedef {{time: number, weights: number[]}} Frame */
/** @typedef {{error?: string, listening?: {phones?: string[]}, frames?: Frame[], belief?: number[]}} Answer */

class VoicePage {
  /** @param {import("../payloads.js").Page} data */
  constructor(data) {
    this.portrait = new Portrait(data, new Take(data.takes[0]));
    this.portrait.canvas.setAttribute("aria-label", "The face, moving with your voice");
    the("faces").append(this.portrait.figure);
    this.strip = /** @type {HTMLCanvasElement} */ (the("strip"));
    this.delay = /** @type {HTMLInputElement} */ (the("delay"));
    /** @type {{context: AudioContext, stream: MediaStream} | null} */
    this.sound = null;
    /** @type {string[]} */
    this.phones = [];
    /** @type {number[]} */
    this.belief = [];
    /** @type {{at: number, phone: string, share: number}[]} */
    this.heard = [];
    /** @type {Float32Array | null} */
    this.weights = null;
    this.asked = 0;
    this.socket = this.connect();
    the("listen").addEventListener("click", () => (this.sound ? this.stop(OFF) : this.listen()));
    this.delay.addEventListener("input", () => (the("told").textContent = `${this.delay.value} ms`));
    this.delay.addEventListener("change", () => this.hello());
    window.addEventListener("resize", () => this.drawSoon());
    this.drawSoon();
    setTimeout(() => { this.portrait.shade(); this.drawSoon(); }, 50);
  }

  /** @param {string} text */
  say(text) {
    if (the("state").textContent !== text) the("state").textContent = text;
  }

  connect() {
    const address = new URL("sound", location.href);
    address.protocol = "ws:";
    const socket = new WebSocket(address);
    socket.addEventListener("open", () => (this.sound ? this.hello() : this.say(OFF)));
    socket.addEventListener("message", ({ data }) => this.told(JSON.parse(data)));
    socket.addEventListener("close", ({ reason }) => {
      this.say(reason || "Reconnecting: the program in the terminal does not answer");
      setTimeout(() => (this.socket = this.connect()), RETRY_MS);
    });
    return socket;
  }

  /** @param {string | Float32Array<ArrayBuffer>} message */
  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(message);
  }

  /** State the form of the samples that follow. */
  hello() {
    if (!this.sound) return;
    const rate = this.sound.context.sampleRate;
    this.send(JSON.stringify({ sound: { rate, format: "f32", delay: Number(this.delay.value) / 1000 } }));
  }

  async listen() {
    try {
      // The model of speech expects the sound of a voice as it is.
      const audio = { channelCount: 1, echoCancellation: false, noiseSuppression: false, autoGainControl: true };
      const stream = await navigator.mediaDevices.getUserMedia({ audio });
      const context = new AudioContext();
      await context.audioWorklet.addModule("voice/microphone.js");
      const node = new AudioWorkletNode(context, "microphone");
      node.port.onmessage = ({ data }) => this.send(data);
      context.createMediaStreamSource(stream).connect(node);
      stream.getTracks()[0].addEventListener("ended", () => this.stop("The microphone has gone. Press Listen"));
      this.sound = { context, stream };
    } catch (error) {
      const name = error instanceof DOMException ? error.name : "";
      this.say(name === "NotFoundError" ? ABSENT : name === "NotAllowedError" ? REFUSED : `No sound: ${error}`);
      return;
    }
    the("listen").textContent = "Stop";
    this.hello();
  }

  /** @param {string} why */
  stop(why) {
    if (!this.sound) return;
    this.sound.stream.getTracks().forEach((one) => one.stop());
    this.sound.context.close();
    this.sound = null;
    this.send(JSON.stringify({ finish: true }));
    the("listen").textContent = "Listen";
    this.say(why);
  }

  /** @param {Answer} answer */
  told({ error, listening, frames, belief }) {
    if (error) this.say(error);
    if (listening) {
      this.phones = listening.phones ?? [];
      this.heard = [];
      this.say("Listening: talk");
    }
    const last = frames?.at(-1);
    if (last) this.weights = Float32Array.from(last.weights);
    if (belief) {
      this.belief = belief;
      const share = Math.max(...belief);
      this.heard.push({ at: performance.now(), phone: this.phones[belief.indexOf(share)] ?? "", share });
    }
    this.drawSoon();
  }

  /** Draw at the next frame of the screen: samples arrive more often than a slow screen draws. */
  drawSoon() {
    this.asked ||= requestAnimationFrame(() => {
      this.asked = 0;
      this.portrait.draw(0, this.weights);
      this.drawStrip();
      const likeliest = this.belief
        .map((share, n) => /** @type {const} */ ([share, this.phones[n]]))
        .sort(([one], [other]) => other - one)
        .slice(0, SHOWN_PHONES);
      the("belief").replaceChildren(
        ...likeliest.map(([share, phone]) => made("li", `${phone} ${Math.round(100 * share)} %`)),
      );
    });
  }

  /** Draw the likeliest phones of the last seconds; doubtful ones are faint. */
  drawStrip() {
    const { strip } = this, context = strip.getContext("2d"), now = performance.now();
    if (!context) return;
    strip.width = 2 * strip.clientWidth;
    this.heard = this.heard.filter(({ at }) => now - at < 1000 * STRIP_SECONDS);
    context.font = `${strip.height / 2}px sans-serif`;
    context.textBaseline = "middle";
    context.fillStyle = getComputedStyle(strip).color;
    let before = "", free = 0;
    for (const { at, phone, share } of this.heard) {
      if (!/^\w/.test(phone)) continue; // a noise of the model
      const x = strip.width * (1 - (now - at) / (1000 * STRIP_SECONDS));
      if (phone !== before && x >= free) {
        context.globalAlpha = 0.3 + 0.7 * share;
        context.fillText(phone, x, strip.height / 2);
        free = x + context.measureText(`${phone} `).width;
      }
      before = phone;
    }
  }
}

async function start() {
  const { document: json, block } = await (await fetch("face.json")).json();
  new VoicePage(await unpack(json, block));
  document.documentElement.dataset.ready = "";
}

start().catch((error) => (the("state").textContent = `The face cannot be shown: ${error}`));
