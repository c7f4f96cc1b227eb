/** Forms of a pose set's rules: constraints, priorities, contacts, softness, anticipation and speed. */

import { made } from "../shell/elements.js";
import { actButton, choiceField, numberField, sliderField, textInput } from "../shell/form_fields.js";

/**
 * @typedef {object} Rules what a pose set states
 * @property {any} stated
 * @property {Record<string, any>} motion settings in force
 * @property {Record<string, number[]>} ranges of the settings
 * @property {number} softness seconds where none are stated
 * @property {boolean} own
 * @property {{name: string, title: string, region: string}[]} poses
 * @property {string[]} phonemes
 */
/**
 * @typedef {object} RuleHands
 * @property {(at: (string | number)[], value: unknown, title: string, done?: boolean) => void} edit a value of
 *   undefined
 *   deletes it
 * @property {(mix: Record<string, number>) => void} attempt show a mix within the constraints
 */

const FREE = 2;

/** Effects of the settings of motion. @type {[string, string, string][]} name, words and unit */
const MOTION = [
  ["speed_limit", "Speed limit: weight per second that no pose exceeds", "per s"],
  ["softness", "Softness: factor of the seconds that round poses off", "×"],
  ["anticipate", "Anticipation: factor of how early poses begin", "×"],
  ["silence_reach", "Silence: seconds of a pause in which the mouth moves", "s"],
  ["sound_reach", "Long sounds: seconds in which the mouth moves", "s"],
  ["stress", "Stress: factor of how far it opens vowels", "×"],
  ["loudness", "Loudness: factor of how far it moves the mouth", "×"],
];
/** Largest values of sliders; numbers may be larger. @type {Record<string, number>} */
const FAR = { speed_limit: 40, silence_reach: 1, sound_reach: 1 };

/** The forms, drawn again when the stated values change. */
export class RuleForms {
  /** @param {HTMLElement} place @param {RuleHands} hands */
  constructor(place, hands) {
    this.hands = hands;
    this.place = place;
    /** Rules that act on the sliders. @type {{pose: string, other: string}[]} */
    this.acting = [];
    /** @type {Rules} */
    this.rules = { stated: {}, motion: {}, ranges: {}, softness: 0, own: false, poses: [], phonemes: [] };
  }

  /** @param {Rules} rules */
  show(rules) {
    this.rules = rules;
    const held = focusKey(this.place);
    this.place.replaceChildren(
      part(
        "Constraints",
        "Two poses that may not add up to more than a threshold, or a pose that may not exceed another. " +
          "The pose with the lower rank yields.",
        this.#constraints(),
      ),
      part(
        "Ranks",
        "If two poses conflict, the one that is higher in this list yields. " +
          "Poses that are not listed never yield. Drag a pose to move it, or use the arrow keys.",
        this.#priority(),
      ),
      part(
        "Contacts",
        "Weights that certain sounds reach at any speed: lips that touch, teeth that show.",
        this.#contacts(),
      ),
      part(
        "Softness and anticipation",
        "Softness is the time over which a pose is rounded off, by region or by pose. " +
          "Anticipation is the time by which a pose begins before its sound.",
        this.#softness(),
      ),
      part("Speed", "Settings of the pose set. A character may change them.", this.#motion()),
    );
    number(this.place);
    refocus(this.place, held);
    this.acts(this.acting);
  }

  /** @param {{pose: string, other: string}[]} acts rules that act on the mix of the sliders */
  acts(acts) {
    this.acting = acts;
    for (const row of this.place.querySelectorAll("[data-pair]")) {
      const [a, b] = JSON.parse(row.getAttribute("data-pair") ?? "[]");
      row.classList.toggle(
        "acts",
        acts.some(({ pose, other }) => (pose === a && other === b) || (pose === b && other === a)),
      );
    }
  }

  get #names() {
    return this.rules.poses.map(({ name }) => name);
  }

  get #off() {
    return !this.rules.own;
  }

  // Constraints

  #constraints() {
    const { edit, attempt } = this.hands, off = this.#off, stated = this.rules.stated.constraints ?? {};
    /** @type {any[]} */
    const pairs = stated.pairs ?? [];
    const put = (/** @type {any[]} */ now, /** @type {string} */ title) => edit(["constraints", "pairs"], now, title);
    const change = (/** @type {number} */ at, /** @type {object} */ one) =>
      pairs.map((old, n) => (n === at ? { ...old, ...one } : old));
    const rows = pairs.map((pair, at) => {
      const capped = "at_most" in pair, [a, b] = capped ? [pair.pose, pair.at_most] : pair.between;
      const one = (
        /** @type {string} */ label,
        /** @type {string} */ now,
        /** @type {(name: string) => any} */ made_,
      ) => choiceField(label, this.#names, now, (name) => put(change(at, made_(name)), `Constraint of ${name}`), off);
      return made(
        "li",
        { class: "rule", "data-pair": JSON.stringify([a, b]) },
        one("Pose", a, (name) => (capped ? { pose: name } : { between: [name, b] })),
        made("span", capped ? "never above" : "and"),
        one("Other pose", b, (name) => (capped ? { at_most: name } : { between: [a, name] })),
        ...(capped
          ? [made("span")]
          : [
              sliderField(
                `At most together: ${a} and ${b}`,
                pair.threshold,
                { min: 0.05, max: FREE, step: 0.05, disabled: off },
                (value, done) =>
                  value !== null &&
                  edit(["constraints", "pairs"], change(at, { threshold: value }), `Threshold of ${a} and ${b}`, done),
              ),
            ]),
        actButton("Try", `Try ${a} and ${b} at 1, within the constraints`, () =>
          attempt({ [a]: 1, [b]: capped ? 0.3 : 1 }),
        ),
        actButton(
          "×",
          `Remove the constraint of ${a} and ${b}`,
          () =>
            put(
              pairs.filter((_, n) => n !== at),
              `Remove a constraint of ${a}`,
            ),
          off,
        ),
      );
    });
    const [first, second] = free(this.#names, pairs);
    return [
      made("ul", { class: "rules" }, ...rows),
      made(
        "div",
        { class: "row" },
        actButton(
          "+ Threshold",
          "Add a threshold of two poses",
          () => put([...pairs, { between: [first, second], threshold: 1 }], "Add a constraint"),
          off || !second,
        ),
        actButton(
          "+ Upper limit",
          "+ Upper limit: a pose that is never above another",
          () => put([...pairs, { pose: first, at_most: second }], "Add an upper limit"),
          off || !second,
        ),
        numberField(
          "all other pairs",
          stated.default ?? null,
          { min: 0.05, max: FREE, step: 0.05, usual: String(FREE), disabled: off },
          (value) => edit(["constraints", "default"], value ?? undefined, "Threshold of other pairs"),
        ),
      ),
    ];
  }

  // Ranks

  #priority() {
    const { edit } = this.hands, off = this.#off;
    /** @type {string[]} */
    const order = this.rules.stated.priority ?? [];
    const put = (/** @type {string[]} */ now, /** @type {string} */ title) =>
      edit(["priority"], now.length ? now : undefined, title);
    const move = (/** @type {number} */ from, /** @type {number} */ to) => {
      if (off || to < 0 || to >= order.length || from === to) return;
      const rest = order.filter((_, n) => n !== from);
      put([...rest.slice(0, to), order[from], ...rest.slice(to)], `Rank of ${order[from]}`);
      /** @type {HTMLElement | null} */ (this.place.querySelector(`.ranks [data-at="${to}"]`))?.focus();
    };
    const list = made(
      "ol",
      { class: "ranks", "aria-label": "Ranks: the first yields to all below it" },
      ...order.map((name, at) => {
        const row = made(
          "li",
          {
            tabindex: "0",
            draggable: String(!off),
            "data-at": String(at),
            "aria-label": `${name}, rank ${at + 1} of ${order.length}`,
          },
          made("span", { "aria-hidden": "true" }, "⠿"),
          made("span", { dir: "auto" }, name),
          actButton(
            "×",
            `${name} never yields`,
            () =>
              put(
                order.filter((_, n) => n !== at),
                `${name} never yields`,
              ),
            off,
          ),
        );
        row.addEventListener("keydown", (event) => {
          const way = { ArrowUp: -1, ArrowDown: 1 }[event.key];
          if (!way || event.target !== row) return;
          event.preventDefault();
          event.stopPropagation();
          move(at, at + way);
        });
        row.addEventListener("dragstart", (event) => event.dataTransfer?.setData("text/plain", String(at)));
        row.addEventListener("dragover", (event) => event.preventDefault());
        row.addEventListener("drop", (event) => {
          event.preventDefault();
          const from = Number(event.dataTransfer?.getData("text/plain") || NaN);
          if (Number.isInteger(from)) move(from, at);
        });
        return row;
      }),
    );
    const rest = this.#names.filter((name) => !order.includes(name));
    return [
      list,
      choiceField(
        "Add a pose that yields",
        rest,
        "",
        (name) => put([...order, name], `${name} yields`),
        off || !rest.length,
      ),
    ];
  }

  // Contacts

  #contacts() {
    const { edit } = this.hands, off = this.#off;
    /** @type {Record<string, any>} */
    const contacts = this.rules.stated.contacts ?? {};
    const cards = Object.entries(contacts).map(([name, rule]) => {
      const phonemes = textInput(`Sounds of the contact ${name}`, { value: rule.phonemes.join(" ") });
      phonemes.disabled = off;
      phonemes.addEventListener("change", () => {
        const now = phonemes.value.split(/[\s,]+/).filter(Boolean);
        if (now.length) edit(["contacts", name, "phonemes"], now, `Sounds of ${name}`);
      });
      return made(
        "section",
        { class: "card" },
        made("h4",
          name,
          " ",
          actButton(
            "×",
            `Remove the contact ${name}`,
            () => edit(["contacts", name], undefined, `Remove the contact ${name}`),
            off,
          ),
        ),
        made("label", { class: "number-field wide" }, made("span", "sounds"), phonemes),
        this.#levels(name, rule, "floor", "at least"),
        this.#levels(name, rule, "ceiling", "at most"),
      );
    });
    const name = textInput("Name of a new contact", { placeholder: "Name of a new contact" });
    name.disabled = off;
    const add = () => {
      const own = name.value.trim(), pose = this.#names[0];
      if (own && !contacts[own])
        edit(
          ["contacts", own],
          { phonemes: [this.rules.phonemes.find((one) => one !== "_") ?? ""], floor: { [pose]: 0.5 } },
          `Add the contact ${own}`,
        );
    };
    name.addEventListener("keydown", (event) => { if (event.key === "Enter") add(); });
    return [
      made("div", { class: "cards" }, ...cards),
      made("div", { class: "row" }, name, actButton("+ Contact", "Add a contact", add, off)),
    ];
  }

  /** @param {string} name @param {any} rule @param {"floor" | "ceiling"} side @param {string} words */
  #levels(name, rule, side, words) {
    const { edit } = this.hands, off = this.#off, levels = rule[side] ?? {};
    const rest = this.#names.filter((pose) => !(pose in levels));
    return made(
      "div",
      { class: "levels" },
      made("span", words),
      ...Object.entries(levels).map(([pose, value]) =>
        made(
          "div",
          { class: "level" },
          sliderField(
            pose,
            value,
            { min: 0, max: 1, step: 0.05, disabled: off },
            (now, done) => now !== null && edit(["contacts", name, side, pose], now, `${pose} in ${name}`, done),
          ),
          actButton(
            "×",
            `${pose} is free in ${name}`,
            () => {
              const left = Object.fromEntries(Object.entries(levels).filter(([one]) => one !== pose));
              edit(["contacts", name, side], Object.keys(left).length ? left : undefined, `${pose} is free in ${name}`);
            },
            off,
          ),
        ),
      ),
      choiceField(
        `+ pose ${words} …`,
        rest,
        "",
        (pose) => edit(["contacts", name, side], { ...levels, [pose]: side === "floor" ? 1 : 0 }, `${pose} in ${name}`),
        off || !rest.length,
      ),
    );
  }

  // Time

  #softness() {
    const { edit } = this.hands,
      off = this.#off,
      { poses, stated, softness } = this.rules,
      regions = stated.softness ?? {};
    const span = { min: 0, max: 0.2, step: 0.005, unit: "s", disabled: off };
    const groups = [...new Set(poses.map(({ region }) => region))]
      .filter(Boolean)
      .map((region) =>
        sliderField(region, regions[region] ?? null, { ...span, usual: String(softness) }, (value, done) =>
          edit(["softness", region], value ?? undefined, `Softness of ${region}`, done),
        ),
      );
    const own = poses.map(({ name, region }) => {
      const pose = stated.poses?.[name] ?? {};
      return made("tr",
        made("th", { scope: "row" }, name),
        made("td", numberField(
          `Softness of ${name}`,
          pose.softness ?? null,
          { ...span, unit: "", usual: String(regions[region] ?? softness) },
          (value) => edit(["poses", name, "softness"], value ?? undefined, `Softness of ${name}`),
        )),
        made("td", sliderField(
          `Anticipation of ${name}`,
          pose.anticipate ?? null,
          { min: 0, max: 0.4, step: 0.01, usual: "0", disabled: off },
          (value, done) => edit(["poses", name, "anticipate"], value ?? undefined, `Anticipation of ${name}`, done),
        )),
      );
    });
    return [
      made("div", { class: "fields" }, ...groups),
      made(
        "details",
        { open: "" },
        made("summary", "Each pose"),
        made(
          "table",
          { class: "times" },
          made("thead", made("tr", made("th", "pose"), made("th", "softness, s"), made("th", "begins early, s"))),
          made("tbody", ...own),
        ),
      ),
    ];
  }

  #motion() {
    const { edit } = this.hands, { motion, ranges, stated } = this.rules;
    return [made("div", { class: "fields" }, ...MOTION.filter(([name]) => ranges[name]).map(([name, words, unit]) => {
      const [min, most] = ranges[name], max = Math.min(most, FAR[name] ?? most), now = stated.motion?.[name] ?? null;
      return sliderField(
        words,
        now,
        {
          min,
          max,
          step: max > 10 ? 0.5 : 0.05,
          usual: motion[name] === null ? "" : String(motion[name]),
          unit,
          disabled: this.#off,
        },
        (value, done) => edit(["motion", name], value ?? undefined, words.split(":")[0], done),
      );
    }))];
  }
}

/** @param {string} title @param {string} words @param {(Node | string)[]} content */
function part(title, words, content) {
  return made(
    "section",
    { class: "rule-part" },
    made("h3", title),
    made("p", { class: "note" }, words),
    ...content,
  );
}

/** Two poses without a constraint yet. @param {string[]} names @param {any[]} pairs @returns {string[]} */
function free(names, pairs) {
  const known = new Set(
    pairs.map((pair) => ("at_most" in pair ? [pair.pose, pair.at_most] : pair.between).toSorted().join("\n")),
  );
  for (const a of names) for (const b of names) if (a !== b && !known.has([a, b].toSorted().join("\n"))) return [a, b];
  return [];
}

/** @param {HTMLElement} place number its fields, so that the focus finds its way back */
function number(place) {
  place
    .querySelectorAll("input, select, button, li[tabindex]")
    .forEach((one, n) => one.setAttribute("data-number", String(n)));
}

/** @param {HTMLElement} place @returns {string} the field that has the focus */
function focusKey(place) {
  const one = document.activeElement;
  return one && place.contains(one) ? one.getAttribute("data-number") ?? "" : "";
}

/** @param {HTMLElement} place @param {string} key */
function refocus(place, key) {
  if (key) /** @type {HTMLElement | null} */ (place.querySelector(`[data-number="${key}"]`))?.focus();
}
