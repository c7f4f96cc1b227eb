/** The place of the face: a window of its own, and another character or a video of reference beside it. */

import { Portrait, turnByDrag } from "./portrait.js";
import { Take } from "../line/take.js";
import { made, the } from "../shell/elements.js";
import { actButton, fillOptions } from "../shell/form_fields.js";

/** Seconds by which a playing video may be off before it is set again. */
const DRIFT = 0.08;
const SECOND = 1000;
/** Width of the face as a share of the window's: the least, the most, and a step of an arrow key. */
const [LEAST_SHARE, MOST_SHARE, STEP] = [0.11, 0.6, 0.02];
/** Milliseconds after which a face is shaded; its first picture does not wait. */
const SHADE_LATER = 300;

/** The face with what is beside it. */
export class FacePlace {
  /** @param {import("../shell/studio.js").Studio} studio */
  constructor(studio) {
    this.studio = studio;
    this.faces = the("faces");
    /** The faces of the character, and of the one beside it. @type {Portrait[]} */
    this.portraits = [];
    this.second = made("select", {
      "aria-label": "Character beside the face", title: "Another character that says the same line",
    });
    this.second.addEventListener("change", () => this.#beside());
    /** The take of the character beside the face is older than the line. */
    this.stale = false;
    this.renewing = false;
    /** @type {HTMLVideoElement | null} */
    this.video = null;
    /** @type {Window | null} */
    this.window = null;
    this.file = made("input", { type: "file", accept: "video/*", hidden: "", "aria-label": "Video of reference" });
    this.offset = made("input", { type: "number", value: "0", step: "10",
      "aria-label": "Offset of the video in milliseconds",
      title: "Milliseconds after the line begins, at which the video begins" });
    this.offset.hidden = true;
    this.button = actButton("Video…", "Video… of reference beside the face", () => {
      if (this.video) this.#close();
      else this.file.click();
    });
    this.file.addEventListener("change", () => this.file.files?.[0] && this.open(this.file.files[0]));
    this.offset.addEventListener("input", () => studio.wake());
    the("beside-face").append(
      actButton("Own window", "Own window of the face", () => this.detach()),
      this.second, this.button, this.offset, this.file,
    );
    this.#split();
  }

  /** Let the splitter change the width of the face: by drags, arrow keys, Home and End; a double click forgets it. */
  #split() {
    const splitter = the("splitter"), stage = the("stage");
    const steps = { ArrowLeft: -STEP, ArrowRight: STEP, Home: -1, End: 1 };
    const set = (/** @type {number} */ share) => {
      stage.style.width = `${100 * Math.min(MOST_SHARE, Math.max(LEAST_SHARE, share))}vw`;
      tell();
    };
    const share = () => stage.offsetWidth / innerWidth;
    const tell = () => {
      const values = { now: share(), min: LEAST_SHARE, max: MOST_SHARE };
      for (const [name, value] of Object.entries(values))
        splitter.setAttribute(`aria-value${name}`, String(Math.round(100 * value)));
      splitter.setAttribute("aria-valuetext", `${Math.round(100 * share())} % of the window`);
      this.studio.wake();
    };
    splitter.addEventListener("pointerdown", (event) => splitter.setPointerCapture(event.pointerId));
    splitter.addEventListener("pointermove", (event) => {
      if (splitter.hasPointerCapture(event.pointerId)) set((event.clientX - stage.offsetLeft) / innerWidth);
    });
    splitter.addEventListener("keydown", (event) => {
      const step = steps[/** @type {keyof typeof steps} */ (event.key)];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      set(share() + step);
    });
    splitter.addEventListener("dblclick", () => { stage.style.width = ""; tell(); });
    addEventListener("resize", tell);
    tell();
  }

  /** @param {string[]} characters to choose from */
  offer(characters) {
    fillOptions(this.second, [["", "Nobody beside"], ...characters.map((one) => [one, `Beside: ${one}`])]);
  }

  /** @param {Portrait} portrait of the open character @param {string} character */
  show(portrait, character) {
    this.portraits = [this.#named(portrait, character), ...this.portraits.slice(1)];
    this.#place();
  }

  /** @param {Portrait} portrait @param {string} character */
  #named(portrait, character) {
    portrait.canvas.setAttribute("aria-label", `Face of ${character}`);
    turnByDrag(portrait.canvas, () => [portrait], () => this.studio.wake());
    return portrait;
  }

  #place() {
    this.faces.replaceChildren(...this.portraits.map((one) => one.figure), ...(this.video ? [this.video] : []));
  }

  async #beside() {
    this.portraits = this.portraits.slice(0, 1);
    this.#place();
    await this.renew();
    this.studio.wake();
  }

  /** Perform the line on the character beside; while one request is in flight, the newest change waits. */
  async renew() {
    this.stale = true;
    if (this.renewing) return;
    this.renewing = true;
    let done = false;
    await this.studio.attempt(async () => {
      while (this.stale && this.second.value) {
        this.stale = false;
        const character = this.second.value, fresh = this.portraits.length < 2;
        const { face, take } = await this.studio.api.sent("beside", { character, face: fresh });
        if (character !== this.second.value) this.stale = true;
        else if (fresh) this.#arrive(this.#named(new Portrait({ faces: [face] }, new Take(take)), character));
        else this.portraits[1].take = new Take(take);
        this.studio.wake();
      }
      done = true;
    });
    this.renewing = false;
    if (!done && this.second.value) {
      this.second.value = "";
      this.#beside();
    }
  }

  /** @param {Portrait} portrait of the character beside */
  #arrive(portrait) {
    this.portraits[1] = portrait;
    this.#place();
    setTimeout(() => { portrait.shade(); this.studio.wake(); }, SHADE_LATER);
  }

  /** @param {File} file that is played in step with the line; it stays on this machine */
  open(file) {
    const address = URL.createObjectURL(file);
    const attributes = { src: address, playsinline: "", "aria-label": file.name };
    this.video = made("video", attributes);
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

  /** Keep what is beside the face in step. @param {number} seconds of the line */
  follow(seconds) {
    this.portraits[1]?.draw(seconds);
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
