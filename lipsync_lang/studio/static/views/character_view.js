/** The character view: a mix of poses on the face, and the rules that the pose set states. */

import { button, made } from "../shell/elements.js";
import { ModelPanel } from "./model_panel.js";
import { MouthTable } from "./mouth_table.js";
import { PoseMixer } from "./pose_mixer.js";
import { PoseSheet } from "./pose_sheet.js";
import { RuleForms } from "./rule_forms.js";
import { tellKeys } from "../shell/studio_keys.js";
import { TargetTable } from "./target_table.js";
import { kindsOf, REGION } from "../face/tongue_view.js";

/** @typedef {Record<string, number>} Mix weights by pose */

/** Names in the address, and titles, of the sheets beside the sliders. @type {[string, string][]} */
const SHEETS = [
  ["poses", "Poses"], ["targets", "Targets"], ["mouths", "Mouths"], ["rules", "Rules"], ["model", "Model"],
];

tellKeys({
  t: "Character: take the sliders as the target of the chosen sound",
  r: "Character: move all sliders to rest",
  k: "Character: keep the sliders within the constraints",
});

/** Sliders of poses, their pictures, and what a pose set states. */
export class CharacterView {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.place = place;
    place.classList.add("character-view");
    /** The server's answer about the character. @type {any} */
    this.told = null;
    /** @type {Mix} */
    this.mix = {};
    /** True while the face shows the mix rather than the line. */
    this.posing = false;
    this.within = false;
    this.sheet = "poses";
    /** The portrait whose poses are pictured. @type {import("../face/portrait.js").Portrait | null} */
    this.face = null;
    /** Edits that are not answered yet. */
    this.open = 0;
    /** Edits that ended, for the keys that join those of one drag. */
    this.steps = 0;
    this.asking = false;
    this.stale = false;
    this.visible = false;
    this.banner = made("div", { class: "banner", role: "status", hidden: "" });
    this.mixerPlace = made("section", { class: "mixer", "aria-label": "Poses" });
    this.tabs = made("div", { class: "group sheet-tabs", role: "group", "aria-label": "Values to edit" });
    this.sheets = new Map(SHEETS.map(([name]) => [name, made("div", { class: `sheet ${name}` })]));
    place.append(
      this.banner,
      this.mixerPlace,
      made("section", { class: "sheets" }, this.tabs, ...this.sheets.values()),
    );
    this.#buildMixer();
    for (const [name, title] of SHEETS) {
      this.tabs.append(button(title, { "data-sheet": name }, () => studio.go("character", name)));
    }
    this.pictures = new PoseSheet(this.#place("poses"), (name, add) => this.#picked(name, add));
    this.targets = new TargetTable(this.#place("targets"), {
      edit: (phoneme, target, title, done) => this.#edit(["targets", phoneme], target, title, done),
      face: (weights) => this.pose({ ...weights }),
      mix: () => this.mix,
    });
    this.mouths = new MouthTable(
      this.#place("mouths"),
      (phoneme, mouth, title) => this.#editMouth(["mouths", phoneme], mouth, title),
      (phoneme, step) => this.#showMouth(phoneme, step),
    );
    this.rules = new RuleForms(this.#place("rules"), {
      edit: (at, value, title, done) => this.#edit(at, value, title, done),
      attempt: (mix) => {
        this.#setWithin(true);
        this.pose(mix);
      },
    });
    this.model = new ModelPanel(this.#place("model"), studio);
  }

  /** @param {string} name @returns {HTMLElement} */
  #place(name) {
    return /** @type {HTMLElement} */ (this.sheets.get(name));
  }

  #buildMixer() {
    this.keep = made("input", { type: "checkbox", id: "within" });
    this.keep.addEventListener("change", () => {
      this.#setWithin(Boolean(this.keep?.checked));
      this.pose(this.mix);
    });
    this.whose = made("p", { class: "whose" });
    this.mixerPlace.append(made("div", { class: "row" },
      button("Rest", "All sliders to rest (R)", () => this.pose({})),
      button("From the line", "Take the face at the playhead", () => this.pose(this.#spoken())),
      made("label", { class: "check" }, this.keep, "Keep within constraints")), this.whose);
    this.mixer = new PoseMixer(this.mixerPlace, (pose, weight, done) => this.#moved(pose, weight, done));
  }

  // The shell's calls

  /** @param {string} argument the sheet */
  async show(argument) {
    this.visible = true;
    this.sheet = this.sheets.has(argument) ? argument : this.sheet;
    for (const [name, place] of this.sheets) place.hidden = name !== this.sheet;
    for (const tab of this.tabs.children)
      tab.setAttribute("aria-pressed", String(tab.getAttribute("data-sheet") === this.sheet));
    await this.#load();
  }

  hide() {
    this.visible = false;
    if (this.posing || this.sheet === "mouths") this.studio.pose(null);
    this.posing = false;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    /** @type {Record<string, () => void>} */
    const does = {
      t: () => this.targets.take(), r: () => this.pose({}),
      k: () => { this.#setWithin(!this.within); this.pose(this.mix); },
    };
    const act = does[event.key.toLowerCase()];
    act?.();
    return Boolean(act);
  }

  /** @param {import("../shell/studio.js").Change} what */
  changed(what) {
    if (what === "time") this.#follow();
    else if (what === "state") this.studio.attempt(() => this.#load());
    else if (what === "face") {
      this.posing = false;
      this.face = null;
      this.studio.attempt(() => this.#load());
    }
  }

  // What is told

  async #load() {
    if (!this.visible || this.open) return;
    const { studio } = this, told = await studio.api.get("character");
    if (this.open) return;
    const before = this.told;
    this.told = told;
    if (before && (before.model !== told.model || before.rig !== told.rig)) {
      this.#forms();
      await studio.loadFace(); // and comes back here for the pictures
      return;
    }
    const poses = studio.state.poses, face = studio.portrait;
    if (!before || before.poseset !== told.poseset || face !== this.face) {
      this.face = face;
      this.mixer?.show(poses);
      this.pictures.show(poses);
      this.#follow();
      this.#draw();
    }
    if (!before || JSON.stringify(before) !== JSON.stringify(told)) this.#forms();
  }

  #forms() {
    const { told, studio } = this, { own, stated } = told, poses = studio.state.poses;
    this.#warn();
    const before = this.targets.weights();
    this.targets.show({
      phonemes: told.phonemes,
      poses: poses.map((one) => one.name),
      targets: stated.targets ?? {},
      own,
    });
    this.rules.show({ ...told, poses, phonemes: told.phonemes.map((/** @type {{name: string}} */ one) => one.name) });
    this.mouths.show(told.mouths);
    this.model.show(told);
    const now = this.targets.weights();
    if (this.posing && before && now && alike(before, this.mix) && !alike(before, now)) this.pose({ ...now });
  }

  #warn() {
    const { told, studio } = this;
    this.banner.hidden = told.own;
    if (told.own) return;
    const copy = button("Make a copy in this project", { class: "main" }, () => studio.busy(async () => {
      const made_ = await studio.api.post("own");
      await studio.open(studio.state.language, studio.state.character);
      studio.tell(`${made_.wrote.length} files copied to posesets/${told.poseset}. You can edit them now.`);
    }));
    this.banner.replaceChildren(
      made("span", `The pose set ${told.poseset} is installed. ` +
        "To edit it, make a copy in this project. The copy performs the same, bit for bit."),
      copy,
    );
  }

  /** Draw the pictures of the sheet. */
  async #draw() {
    const { studio } = this, names = studio.state.poses.map((one) => one.name);
    const told = await studio.api.post("pose", { mixes: names.map((/** @type {string} */ name) => ({ [name]: 1 })) });
    const face = studio.portrait?.face, drawn = Boolean(face), kinds = face ? await kindsOf(studio, face) : null;
    const inner = new Set(
      studio.state.poses
        .filter((one) => one.region === REGION)
        .map((one) => one.name),
    );
    this.pictures.draw(studio, new Map(names.map((/** @type {string} */ name, /** @type {number} */ n) =>
      [name, Float32Array.from(drawn ? told.rows[n].channels : told.rows[n].weights)])), kinds, inner);
  }

  // Edits

  /**
   * @param {(string | number)[]} at
   * @param {unknown} value
   * @param {string} title
   * @param {boolean} [done] false while a slider moves
   */
  async #edit(at, value, title, done = true) {
    const edit = value === undefined ? { file: "poseset", at } : { file: "poseset", at, value };
    put(this.told.stated, at, value);
    const merge = `${JSON.stringify(at)} ${this.steps}`; // one drag is one step of undo
    if (done) {
      this.steps += 1;
      this.#forms();
    }
    this.open += 1;
    await this.studio.edit([edit], title, merge);
    this.open -= 1;
    await this.studio.attempt(() => this.#load());
  }

  /** @param {string[]} at @param {unknown} value @param {string} title */
  async #editMouth(at, value, title) {
    const edit = value === undefined ? { file: "character", at } : { file: "character", at, value };
    await this.studio.edit([edit], title);
    await this.studio.attempt(() => this.#load());
  }

  /** @param {string} phoneme @param {number} step */
  async #showMouth(phoneme, step) {
    const { studio } = this;
    studio.player.pause();
    await studio.attempt(async () => {
      const { steps } = await studio.api.get(`language/mouth/${encodeURIComponent(phoneme)}`);
      studio.pose(Float32Array.from(steps[Math.min(step, steps.length - 1)]));
    });
  }

  // The face

  /** Show a mix on the face. @param {Mix} mix */
  pose(mix) {
    this.mix = mix;
    this.posing = true;
    this.mixer?.values(mix);
    this.pictures.mark(mix);
    this.#tellWhose();
    this.#face();
  }

  /** @param {string} pose @param {number} weight @param {boolean} done */
  #moved(pose, weight, done) {
    const from = this.posing ? this.mix : this.#spoken();
    this.pose({ ...from, [pose]: weight });
    if (this.targets.live && this.sheet === "targets") this.targets.take(done);
  }

  /** @param {string} name @param {boolean} add */
  #picked(name, add) {
    const now = this.posing ? this.mix : {};
    this.pose(add ? { ...now, [name]: now[name] ? 0 : 1 } : { [name]: 1 });
  }

  /** @param {boolean} within */
  #setWithin(within) {
    this.within = within;
    if (this.keep) this.keep.checked = within;
  }

  /** Send the mix to the model; the newest wins, and one request is in flight. */
  async #face() {
    const { studio } = this, names = studio.state.poses.map((one) => one.name);
    const plain = Float32Array.from(names, (/** @type {string} */ name) => this.mix[name] ?? 0);
    if (!this.within) this.#acts(null);
    if (!this.within && (!this.told?.rig || !studio.portrait?.face)) {
      studio.pose(plain);
      return;
    }
    this.stale = true;
    if (this.asking) return;
    this.asking = true;
    await studio.attempt(async () => {
      while (this.stale) {
        this.stale = false;
        const { rows: [row] } = await studio.api.post("pose", { mixes: [this.mix], within: this.within });
        if (!this.posing || !this.visible) break;
        if (this.within) this.#acts(row);
        studio.pose(Float32Array.from(studio.portrait?.face ? row.channels : row.weights));
      }
    });
    this.asking = false;
  }

  /** @param {{acts: import("../payloads.js").Act[], weights: number[]} | null} row */
  #acts(row) {
    const kept = Object.fromEntries(
      this.studio.state.poses.map((one, n) => [
        one.name,
        row?.weights[n] ?? 0,
      ]),
    );
    this.mixer?.acts(row?.acts ?? [], kept);
    this.rules.acts(row?.acts ?? []);
  }

  /** Weights of the line at the playhead. @returns {Mix} */
  #spoken() {
    const { take, player } = this.studio;
    if (!take) return {};
    const frame = take.frameAt(player.time);
    return Object.fromEntries(
      this.studio.state.poses.map(({ name }) => [name, Math.round(take.weight(name, frame) * 100) / 100]),
    );
  }

  /** While the line is shown, the sliders move with it. */
  #follow() {
    if (this.posing && this.studio.posed === null && !this.asking) {
      this.posing = false;
      this.#acts(null);
    }
    if (this.posing) return;
    const now = this.#spoken();
    this.mixer?.values(now);
    this.pictures.mark({});
    this.#tellWhose();
  }

  #tellWhose() {
    const words = this.posing
      ? "The face shows the sliders until you play or seek."
      : this.studio.take
        ? "The face shows the line until you move a slider."
        : "The face is at rest. Move a slider, or choose a picture.";
    if (this.whose && this.whose.textContent !== words) this.whose.textContent = words;
  }
}

/** @param {Mix} a @param {Mix} b @returns {boolean} true for the same weights */
function alike(a, b) {
  return Object.keys({ ...a, ...b }).every((name) => Math.abs((a[name] ?? 0) - (b[name] ?? 0)) < 1e-6);
}

/**
 * Set or delete a value of a copy of what is stated.
 * @param {any} data
 * @param {(string | number)[]} at
 * @param {unknown} value
 */
function put(data, at, value) {
  const last = at[at.length - 1];
  let place = data;
  for (const step of at.slice(0, -1)) place = place[step] ??= {};
  if (value === undefined) delete place[last];
  else place[last] = value;
}
