/** Targets of phonemes as a table of phonemes and poses, with one of them in detail. */

import { button, made } from "../shell/elements.js";
import { numberField, textInput } from "../shell/form_fields.js";
import { dominanceOf, stepsOf, targetOf, weightsOf, withDominance, withWeight, withWeights } from "./target_forms.js";

/**
 * @typedef {{name: string, title: string, example: string, like: string, contact: string, replaced: boolean}} Phoneme
 */
/**
 * @typedef {object} Hands
 * @property {(phoneme: string, target: unknown, title: string, done?: boolean) => void} edit undefined deletes it; not
 *   done while a slider moves
 * @property {(weights: Record<string, number>) => void} face show a target
 * @property {() => Record<string, number>} mix weights of the sliders
 */

/** The targets of a pose set. */
export class TargetTable {
  /** @param {HTMLElement} place @param {Hands} hands */
  constructor(place, hands) {
    this.hands = hands;
    this.detail = made("div", { class: "target-detail" });
    this.scroll = made("div", { class: "target-scroll" });
    place.append(this.detail, this.scroll);
    /** @type {Phoneme[]} */
    this.phonemes = [];
    /** @type {string[]} */
    this.poses = [];
    /** @type {Record<string, any>} */
    this.targets = {};
    this.own = false;
    this.phoneme = "";
    this.step = 0;
    this.pose = "";
    /** Sliders change the chosen target as they move. */
    this.live = false;
    this.scroll.addEventListener("keydown", (event) => this.#key(event));
    this.scroll.addEventListener("focusin", (event) => this.#focused(event));
  }

  /** @param {{phonemes: Phoneme[], poses: string[], targets: Record<string, any>, own: boolean}} told */
  show({ phonemes, poses, targets, own }) {
    Object.assign(this, { phonemes, poses, targets, own });
    if (!phonemes.some(({ name }) => name === this.phoneme)) [this.phoneme, this.step] = ["", 0];
    const cells = [...this.scroll.querySelectorAll("[data-cell]")],
      held = cells.indexOf(/** @type {Element} */ (document.activeElement));
    const key = held < 0 ? "" : cells[held].getAttribute("data-cell");
    const head = made("tr",
      made("th", { scope: "col" }, "sound"),
      ...poses.map((pose) => made("th", { scope: "col", title: pose }, made("span", { dir: "auto" }, pose))),
    );
    this.scroll.replaceChildren(
      made(
        "table",
        { role: "grid", "aria-label": "Targets: type a weight, or press Delete to remove it" },
        made("thead", head),
        made("tbody", ...phonemes.flatMap((one) => this.#rows(one))),
      ),
    );
    const first =
      this.#cell(this.phoneme || phonemes[0]?.name, this.step, this.pose || poses[0]) ??
      this.scroll.querySelector("td");
    first?.setAttribute("tabindex", "0");
    if (key) /** @type {HTMLElement | null} */ (this.scroll.querySelector(`[data-cell="${CSS.escape(key)}"]`))?.focus();
    this.#mark();
    this.#tell();
  }

  /** The target of a phoneme, or of the one that stands in for it. @param {Phoneme} phoneme */
  #given(phoneme) {
    const own = this.targets[phoneme.name];
    return { own: own !== undefined, steps: stepsOf(own ?? this.targets[phoneme.like]) };
  }

  /** @param {Phoneme} phoneme @returns {HTMLElement[]} */
  #rows(phoneme) {
    const { own, steps } = this.#given(phoneme), { name, title, example, like, replaced } = phoneme;
    return (steps.length ? steps : [{}]).map((step, number) => {
      const weights = weightsOf(step), { overall, poses } = dominanceOf(step);
      const told = [
        title,
        example && `as in "${example}"`,
        like && `a shade of ${like}`,
        !own && steps.length && `as ${like}`,
        !steps.length && "no target",
        replaced && "replaced by the character's own target",
      ];
      const head = made(
        "th",
        { scope: "row", title: told.filter(Boolean).join(", ") },
        name,
        ...(steps.length > 1 ? [made("sub", String(number + 1))] : []),
        ...(like ? [made("small", own ? "" : ` as ${like}`)] : []),
        ...(replaced ? [made("small", " replaced")] : []),
      );
      const cells = this.poses.map((pose) => {
        const weight = weights[pose], dominance = poses[pose] ?? overall;
        const step = steps.length > 1 ? ` step ${number + 1}` : "", value = weight === undefined ? "" : shown(weight);
        const factor = dominance === undefined || dominance === null || (!value && poses[pose] === undefined)
          ? "" : `×${shown(dominance)}`;
        const cell = made(
          "td",
          {
            role: "gridcell",
            tabindex: "-1",
            "data-cell": JSON.stringify([name, number, pose]),
            "data-pose": pose,
            "aria-label": `${name}${step}, ${pose}: ${value || factor ? `${value}${factor}` : "not named"}`,
          },
          value,
          ...(factor ? [made("sup", factor)] : []),
        );
        if (weight !== undefined) cell.style.setProperty("--share", String(weight));
        return cell;
      });
      return made(
        "tr",
        { "data-phoneme": name, "data-step": String(number), class: own ? "" : "lent" },
        head,
        ...cells,
      );
    });
  }

  /** @param {string} phoneme @param {number} step @param {string} pose @returns {HTMLElement | null} */
  #cell(phoneme, step, pose) {
    return this.scroll.querySelector(`[data-cell="${CSS.escape(JSON.stringify([phoneme, step, pose]))}"]`);
  }

  /** @param {FocusEvent} event */
  #focused(event) {
    const cell = /** @type {HTMLElement} */ (event.target).closest("td");
    const row = cell?.closest("tr");
    if (!cell || !row) return;
    for (const one of this.scroll.querySelectorAll("td[tabindex='0']")) one.setAttribute("tabindex", "-1");
    cell.setAttribute("tabindex", "0");
    this.pose = cell.getAttribute("data-pose") ?? "";
    const phoneme = row.getAttribute("data-phoneme") ?? "", step = Number(row.getAttribute("data-step"));
    if (phoneme !== this.phoneme || step !== this.step) this.choose(phoneme, step);
  }

  /** @param {string} phoneme @param {number} [step] */
  choose(phoneme, step = 0) {
    [this.phoneme, this.step] = [phoneme, step];
    this.#mark();
    this.#tell();
    const one = this.chosen();
    if (one) this.hands.face(weightsOf(one.step));
  }

  /** The chosen step. @returns {{phoneme: Phoneme, steps: any[], step: any} | null} */
  chosen() {
    const phoneme = this.phonemes.find(({ name }) => name === this.phoneme);
    if (!phoneme) return null;
    const { steps } = this.#given(phoneme);
    this.step = Math.max(0, Math.min(this.step, steps.length - 1));
    return { phoneme, steps, step: steps[this.step] ?? {} };
  }

  /** Weights of the chosen step, if one is chosen. @returns {Record<string, number> | null} */
  weights() {
    const one = this.phoneme ? this.chosen() : null;
    return one && weightsOf(one.step);
  }

  #mark() {
    for (const row of this.scroll.querySelectorAll("tbody tr")) {
      row.classList.toggle(
        "front",
        row.getAttribute("data-phoneme") === this.phoneme && Number(row.getAttribute("data-step")) === this.step,
      );
    }
  }

  /**
   * @param {import("./target_forms.js").Step} step the chosen one, changed
   * @param {string} title
   * @param {boolean} [done]
   */
  #put(step, title, done = true) {
    const one = this.chosen();
    if (!one) return;
    const steps = one.steps.length ? one.steps.map((old, n) => (n === this.step ? step : old)) : [step];
    this.hands.edit(this.phoneme, targetOf(steps), title, done);
  }

  /** Make the mix of the sliders the chosen target. @param {boolean} [done] false while a slider moves */
  take(done = true) {
    const one = this.chosen();
    if (!one || !this.own) return;
    const mix = Object.fromEntries(
      Object.entries(this.hands.mix()).map(([pose, weight]) => [pose, Math.round(weight * 100) / 100]),
    );
    this.#put(withWeights(one.step, mix), `Target of ${this.phoneme}`, done);
  }

  // One target

  #tell() {
    const one = this.chosen();
    if (!one) {
      this.detail.replaceChildren(
        made(
          "p",
          { class: "note" },
          "Choose a sound below, and the face shows its target. " +
            "Type weights into its row, or set the sliders and take them.",
        ),
      );
      return;
    }
    const { phoneme, steps, step } = one, { overall, poses } = dominanceOf(step), many = steps.length > 1;
    const act = (
      /** @type {string} */ text,
      /** @type {string} */ title,
      /** @type {() => void} */ does,
      /** @type {string} */ kind = "",
    ) => Object.assign(button(text, { title, class: kind }, does), { disabled: !this.own });
    const live = made("input", { type: "checkbox" });
    [live.checked, live.disabled] = [this.live, !this.own];
    live.addEventListener("change", () => { this.live = live.checked; });
    const told = [
      phoneme.title,
      phoneme.example && `as in “${phoneme.example}”`,
      phoneme.contact && `contact ${phoneme.contact}`,
    ]
      .filter(Boolean)
      .join(" · ");
    const dominance = (
      /** @type {string} */ label,
      /** @type {string | null} */ pose,
      /** @type {number | null} */ value,
      /** @type {string} */ usual,
    ) =>
      numberField(label, value, { min: 0, max: 100, step: 0.5, usual, disabled: !this.own }, (now) =>
        this.#put(withDominance(step, pose, now), `Dominance of ${pose ?? "all poses"} in ${this.phoneme}`),
      );
    const named = Object.keys({ ...weightsOf(step), ...poses });
    this.detail.replaceChildren(
      made(
        "p",
        { class: "target-name" },
        made("b", this.phoneme, ...(many ? [` step ${this.step + 1} of ${steps.length}`] : [])),
        ` ${told}`,
      ),
      made(
        "div",
        { class: "row" },
        act(`Take the sliders as ${this.phoneme}`, "T", () => this.take(), "main"),
        made("label", { class: "check" }, live, "as they move"),
        act("+ Step", "A sound that moves has several steps", () =>
          this.hands.edit(
            this.phoneme,
            targetOf([...steps.slice(0, this.step + 1), { ...weightsOf(step) }, ...steps.slice(this.step + 1)]),
            `Add a step to ${this.phoneme}`,
          ),
        ),
        ...(many
          ? [
              act("− Step", "Remove this step", () =>
                this.hands.edit(
                  this.phoneme,
                  targetOf(steps.filter((_, n) => n !== this.step)),
                  `Remove a step of ${this.phoneme}`,
                ),
              ),
            ]
          : []),
        ...(phoneme.like && this.targets[phoneme.name] !== undefined
          ? [
              act(`As ${phoneme.like}`, `Remove this target: ${phoneme.name} is then drawn as ${phoneme.like}`, () =>
                this.hands.edit(this.phoneme, undefined, `Remove the target of ${this.phoneme}`),
              ),
            ]
          : []),
      ),
      made(
        "div",
        { class: "dominances" },
        made("span", "Dominance over the neighbours:"),
        dominance("all", null, overall, "1"),
        ...named.map((pose) => dominance(pose, pose, poses[pose] ?? null, overall === null ? "1" : String(overall))),
      ),
    );
  }

  // Keys

  /** @param {KeyboardEvent} event */
  #key(event) {
    const cell = /** @type {HTMLElement} */ (event.target).closest("td"), row = cell?.closest("tr");
    if (!cell || !row || event.target instanceof HTMLInputElement || event.ctrlKey || event.metaKey || event.altKey)
      return;
    const rows = /** @type {HTMLElement[]} */ ([...this.scroll.querySelectorAll("tbody tr")]),
      at = rows.indexOf(row),
      column = [...row.children].indexOf(cell);
    const go = (/** @type {number} */ down, /** @type {number} */ right) => {
      const next = rows[Math.max(0, Math.min(rows.length - 1, at + down))];
      /** @type {HTMLElement} */ (next.children[Math.max(1, Math.min(this.poses.length, column + right))]).focus();
    };
    /** @type {Record<string, () => void>} */
    const does = {
      ArrowUp: () => go(-1, 0), ArrowDown: () => go(1, 0), ArrowLeft: () => go(0, -1), ArrowRight: () => go(0, 1),
      PageUp: () => go(-10, 0), PageDown: () => go(10, 0), Home: () => go(0, -1000), End: () => go(0, 1000),
      Enter: () => this.#type(cell, null), F2: () => this.#type(cell, null),
      Delete: () => this.#weigh(null), Backspace: () => this.#weigh(null),
    };
    const act = does[event.key] ?? (/^[0-9.]$/.test(event.key) ? () => this.#type(cell, event.key) : null);
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }

  /** @param {number | null} weight of the cell that has the focus */
  #weigh(weight) {
    const one = this.chosen();
    if (!one || !this.own) return;
    const step = withWeight(one.step, this.pose, weight);
    this.hands.face(weightsOf(step));
    this.#put(step, `${this.pose} in ${this.phoneme}`);
  }

  /** @param {HTMLElement} cell @param {string | null} start what was typed; null to change what is there */
  #type(cell, start) {
    if (!this.own) return;
    const before = cell.firstChild?.nodeType === Node.TEXT_NODE ? cell.firstChild.textContent ?? "" : "";
    const content = [...cell.childNodes];
    const input = textInput(cell.getAttribute("aria-label") ?? "", { inputmode: "decimal" });
    input.value = start ?? before;
    cell.replaceChildren(input);
    input.focus();
    if (start === null) input.select();
    let open = true;
    const close = (/** @type {boolean} */ keep) => {
      if (!open) return;
      open = false;
      const value = Number(input.value.replace(",", "."));
      cell.replaceChildren(...content);
      if (keep && input.value.trim() === "") this.#weigh(null);
      else if (keep && input.value.trim() !== before && Number.isFinite(value))
        this.#weigh(Math.max(0, Math.min(1, value)));
    };
    input.addEventListener("blur", () => close(true));
    input.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (!["Enter", "Escape", "Tab"].includes(event.key)) return;
      if (event.key !== "Tab") event.preventDefault();
      close(event.key !== "Escape");
      this.#cell(this.phoneme, this.step, this.pose)?.focus();
    });
  }
}

/** @param {number} value */
function shown(value) {
  return String(Math.round(value * 1000) / 1000).replace(/^0\./, ".");
}
