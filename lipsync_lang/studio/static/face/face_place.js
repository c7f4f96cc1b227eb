/** The place of the face: a window of its own, and a video of reference beside it. */

import { made, the } from "../shell/elements.js";
import { actButton } from "../shell/form_fields.js";

/** Seconds by which a playing video may be off before it is set again. */
const DRIFT = 0.08;
const SECOND = 1000;

/** The face with the video beside it. */
export class FacePlace {
  /** @param {import("../shell/studio.js").Studio} studio */
  constructor(studio) {
    this.studio = studio;
    this.faces = the("faces");
    /** @type {HTMLVideoElement | null} */
    this.video = null;
    /** @type {Window | null} */
    this.window = null;
    this.file = /** @type {HTMLInputElement} */ (
      made("input", { type: "file", accept: "video/*", hidden: "", "aria-label": "Video of reference" })
    );
    this.offset = /** @type {HTMLInputElement} */ (
      made("input", { type: "number", value: "0", step: "10", "aria-label": "Offset of the video in milliseconds",
        title: "Milliseconds after the line begins, at which the video begins" })
    );
    this.offset.hidden = true;
    this.button = actButton("Video…", "Video… of reference beside the face", () => {
      if (this.video) this.#close();
      else this.file.click();
    });
    this.file.addEventListener("change", () => this.file.files?.[0] && this.open(this.file.files[0]));
    this.offset.addEventListener("input", () => studio.wake());
    the("beside-face").append(
      actButton("Own window", "Own window of the face", () => this.detach()),
      this.button, this.offset, this.file,
    );
  }

  /** @param {HTMLElement} figure of a new face */
  show(figure) {
    this.faces.replaceChildren(figure, ...(this.video ? [this.video] : []));
  }

  /** @param {File} file that is played in step with the line; it stays on this machine */
  open(file) {
    const address = URL.createObjectURL(file);
    const attributes = { src: address, playsinline: "", "aria-label": file.name };
    this.video = /** @type {HTMLVideoElement} */ (made("video", attributes));
    this.video.muted = true;
    this.video.addEventListener("loadeddata", () => this.studio.wake());
    this.video.addEventListener("error", () => {
      if (!this.video) return;
      this.#close();
      this.studio.tell(`This browser cannot play ${file.name}. Convert it to MP4 (H.264) or WebM.`, "fault");
    });
    this.faces.append(this.video);
    this.#shown();
  }

  #close() {
    if (this.video) URL.revokeObjectURL(this.video.src);
    this.video?.remove();
    this.video = null;
    this.file.value = "";
    this.#shown();
  }

  #shown() {
    this.offset.hidden = !this.video;
    this.button.textContent = this.video ? "Close video" : "Video…";
    this.button.title = `${this.button.textContent} of reference beside the face`;
    this.button.setAttribute("aria-label", this.button.title);
  }

  /** Keep the video in step. @param {number} seconds of the line */
  follow(seconds) {
    const { video } = this, { playing, rate } = this.studio.player;
    if (!video?.duration) return;
    const wanted = seconds - Number(this.offset.value) / SECOND;
    const at = Math.max(0, Math.min(video.duration, wanted)), runs = playing && at === wanted;
    if (Math.abs(video.currentTime - at) > (runs ? DRIFT : 1e-3) && !video.seeking) video.currentTime = at;
    video.playbackRate = rate;
    if (runs && video.paused) video.play().catch(() => {});
    else if (!runs && !video.paused) video.pause();
  }

  /** Move the face to a window of its own; it comes back when that is closed. */
  detach() {
    if (this.window && !this.window.closed) return this.window.focus();
    const own = window.open("", "", "popup,width=640,height=640"), home = the("stage");
    if (!own) return this.studio.tell("The browser blocked the window. Allow windows for this page.", "fault");
    this.window = own;
    own.document.title = `Face of ${this.studio.state.character}`;
    own.document.documentElement.lang = "en";
    const sheets = document.querySelectorAll("link[rel=stylesheet]");
    for (const { href } of /** @type {NodeListOf<HTMLLinkElement>} */ (sheets))
      own.document.head.append(made("link", { rel: "stylesheet", href }));
    own.document.body.className = "detached";
    own.document.body.append(this.faces);
    own.addEventListener("resize", () => this.studio.wake());
    own.addEventListener("pagehide", () => {
      home.prepend(this.faces);
      this.studio.wake();
    });
    addEventListener("pagehide", () => own.close());
    this.studio.wake();
  }
}
