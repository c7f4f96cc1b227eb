/** The coverage view: what the project's script still needs, and the quality of the line beside it. */

import { button, made } from "../shell/elements.js";
import { QualityList } from "./quality_list.js";

/** Milliseconds between looks at a count under way. */
const LOOK = 400;
/** Rows of the plan that are drawn at first. */
const MOST = 100;
/** Minutes for a bigram unless stated, as `lipsync-lang coverage` has it. */
const MINUTES = "5";
const STATUSES = {
  approved: "approved",
  edited: "edited",
  fitted: "fitted to captures",
  drafted: "drafted only",
  gap: "gap: no curves",
};

/**
 * @typedef {{bigram: string, count: number, percent: number, layer: string, status: string, example: string, places:
 *   string[]}} Need
 */

export class CoverageView {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.place = place;
    place.classList.add("coverage");
    /** The server's answer. @type {any} */
    this.told = null;
    this.visible = false;
    this.asking = 0;
    this.all = false;
    /** @type {import("../payloads.js").NeededSentence[] | null} lines that show what is not drawn */
    this.sentences = null;
    this.choice = made("select", { "aria-label": "Script" });
    this.file = made("input", { type: "file", hidden: "", "aria-label": "Script to open" });
    this.column = made("input", { type: "text", placeholder: "automatic", autocomplete: "off", spellcheck: "false" });
    this.minutes = made("input", {
      type: "number", min: "0.1", max: "600", step: "0.5", value: remembered("minutes") || MINUTES,
    });
    this.columnLabel = made("label", "column", this.column);
    this.state = made("span", { role: "status", class: "row" });
    this.covered = made("section", { class: "covered", "aria-label": "Drawn share" });
    this.plan = made("section", { class: "plan", "aria-label": "What to draw next" });
    const quality = made("aside", { class: "quality", "aria-label": "Quality of the line" });
    this.quality = new QualityList(studio, quality);
    const open = button(
      "Open a script…",
      "Text, CSV, XLSX, PO, SRT, Ren'Py…; or drop a file here",
      () => this.file.click(),
    );
    place.append(
      made(
        "header",
        { class: "row" },
        this.choice,
        open,
        this.file,
        this.columnLabel,
        made("label", "minutes per bigram", this.minutes),
        this.state,
      ),
      this.covered,
      this.plan,
      quality,
    );
    this.file.addEventListener("change", () => this.file.files?.[0] && this.#send(this.file.files[0]));
    this.choice.addEventListener("change", () => this.#choose(this.choice.value));
    this.column.addEventListener("change", () => this.told?.script.name && this.#again());
    this.minutes.addEventListener("change", () => {
      if (!this.minutes.reportValidity() || !this.minutes.value) return;
      remember("minutes", this.minutes.value);
      this.#load();
    });
    this.#drops();
  }

  async show() {
    this.visible = true;
    this.quality.show();
    if (!this.told) {
      const script = remembered(`script of ${this.studio.project.folder}`);
      await this.#load();
      if (script && !this.told?.script.name && this.told?.offered.includes(script)) await this.#choose(script);
    } else await this.#load();
  }

  hide() {
    this.visible = false;
    this.quality.hide();
  }

  /** @param {KeyboardEvent} _event */
  key(_event) {
    return false;
  }

  /** @param {import("../shell/studio.js").Change} what */
  changed(what) {
    if (what === "state") this.#load();
    if (what === "take") this.quality.changed();
  }

  // The script

  #drops() {
    const over = (/** @type {boolean} */ is) => this.place.classList.toggle("dropping", is);
    this.place.addEventListener("dragover", (event) => {
      event.preventDefault();
      over(true);
    });
    this.place.addEventListener("dragleave", (event) => event.target === this.place && over(false));
    this.place.addEventListener("drop", (event) => {
      event.preventDefault();
      over(false);
      const [file] = event.dataTransfer?.files ?? [];
      if (file) this.#send(file);
      else this.studio.tell("Drop a file: text, CSV, XLSX, PO, SRT…");
    });
  }

  /** @param {File} file */
  async #send(file) {
    this.sent = file;
    const asked = new URLSearchParams({
      name: file.name,
      minutes: this.minutes.value,
      column: this.column.value.trim(),
    });
    await this.#take(() => this.studio.api.post(`coverage/script?${asked}`, file));
    this.file.value = "";
  }

  /** @param {string} name of a file of the project, or nothing */
  async #choose(name) {
    this.sent = null;
    remember(`script of ${this.studio.project.folder}`, name);
    await this.#take(() =>
      this.studio.api.post(`coverage?minutes=${this.minutes.value}`, { name, column: this.column.value.trim() }),
    );
  }

  #again() {
    if (this.sent) this.#send(this.sent);
    else this.#choose(this.told.script.name);
  }

  /** @param {() => Promise<any>} asks */
  async #take(asks) {
    await this.studio.attempt(async () => this.#told(await asks()));
    this.#options();
  }

  async #load() {
    const now = ++this.asking;
    await this.studio.attempt(async () => {
      const told = await this.studio.api.get(`coverage?minutes=${this.minutes.value || MINUTES}`);
      if (now === this.asking) this.#told(told);
    });
  }

  /** @param {any} told */
  #told(told) {
    this.told = told;
    this.file.accept = told.suffixes.join();
    this.sentences = null;
    this.#options();
    this.#progress();
    this.#facts();
    this.#list();
    clearTimeout(this.later);
    if (told.state === "counting") this.later = setTimeout(() => this.visible && this.#load(), LOOK);
  }

  #options() {
    const { script, offered } = this.told, names = script.sent ? [script.name, ...offered] : offered;
    this.choice.replaceChildren(
      made("option", { value: "" }, names.length ? "No script" : "No script in this folder"),
      ...names.map((/** @type {string} */ one) => made("option", { value: one }, one)),
    );
    this.choice.value = script.name;
    this.columnLabel.hidden = !/\.(csv|tsv|xlsx|ods)$/i.test(script.name);
  }

  #progress() {
    const { state, lines, fault, remarks, report } = this.told;
    /** @type {(Node | string)[]} */
    const parts = [];
    if (state === "counting")
      parts.push(made("progress", { "aria-label": "Counting" }), `${lines.toLocaleString()} lines read`);
    else if (report) parts.push(`${report.lines.toLocaleString()} lines, ${report.words.toLocaleString()} words`);
    if (fault) parts.push(made("span", { class: "fails", role: "alert" }, fault));
    parts.push(...remarks.map((/** @type {string} */ one) => made("small", { class: "note" }, one)));
    this.state.replaceChildren(...parts);
  }

  #facts() {
    const { report } = this.told;
    this.covered.hidden = !report;
    if (!report) return;
    const { status, occurrences, authored, left, next_hour, kinds } = report;
    const shown = /** @type {(keyof STATUSES)[]} */ (Object.keys(STATUSES)).filter((one) => status[one]);
    const bars = shown.map((one) => {
      const bar = made("i", {
        class: one,
        title: `${STATUSES[one]}: ${percent((100 * status[one][1]) / occurrences)} of the speech`,
      });
      bar.style.flexGrow = String(status[one][1]);
      return bar;
    });
    const fact = (/** @type {string} */ number, /** @type {string} */ words) =>
      made("li", made("b", number), words);
    this.covered.replaceChildren(
      made(
        "ul",
        { class: "facts" },
        fact(percent(authored.percent), "of the speech is drawn"),
        fact(`${authored.bigrams} of ${kinds}`, "bigrams"),
        fact(`${left.hours.toLocaleString(undefined, { maximumFractionDigits: 1 })} h`, "left"),
        ...(next_hour.bigrams
          ? [fact(`+${percent(next_hour.percent)}`, `in the next hour, ${next_hour.bigrams} bigrams`)]
          : []),
      ),
      made(
        "div",
        {
          class: "shares",
          role: "img",
          "aria-label": shown
            .map((one) => `${STATUSES[one]} ${percent((100 * status[one][1]) / occurrences)}`)
            .join(", "),
        },
        ...bars,
      ),
      made(
        "ul",
        { class: "statuses" },
        ...shown.map((one) =>
          made(
            "li",
            { class: one },
            `${STATUSES[one]}: ${status[one][0]} bigrams, ${percent((100 * status[one][1]) / occurrences)}`,
          ),
        ),
      ),
    );
  }

  // The plan

  #list() {
    const { report, state, script } = this.told;
    if (!report) {
      this.plan.replaceChildren(
        made(
          "div",
          { class: "empty" },
          made("h2", state === "counting" ? "Counting the script…" : "What will the character say?"),
          made("p", state === "counting"
            ? "You can use the other views meanwhile. This view appears when the count is done."
            : "Choose a script of this folder above, or drop one here: " +
                "a text, a table (CSV, XLSX), subtitles, or a PO file. " +
                "This view then lists the bigrams that the script needs, shows which are drawn, " +
                "and ranks the next to draw."),
        ),
      );
      return;
    }
    const most = Math.max(1, ...report.plan.map((/** @type {Need} */ one) => one.count));
    const rows = report.plan.slice(0, this.all ? undefined : MOST), rest = report.plan.length - rows.length;
    const more = button(`Show ${rest} more`, "", () => { this.all = true; this.#list(); });
    /** @type {HTMLElement[]} */
    const parts = [
      made("h3", "Draw next", made("small", report.plan.length ? "the most frequent first; click one to open it" : "")),
      made("ol", { class: "needs" }, ...rows.map((/** @type {Need} */ one) => this.#need(one, most))),
    ];
    if (!report.plan.length) parts.push(made("p", { class: "note" }, `Every bigram of ${script.name} is drawn.`));
    if (rest) parts.push(more);
    if (report.plan.length) parts.push(this.#sentenceList());
    for (const [title, tallies] of /** @type {[string, import("../payloads.js").Tally[]][]} */ ([
      ["Words that cannot be read", report.unread],
      ["Sounds without a mapping", report.unmapped],
      ["Words in another script", report.other_scripts],
      ["Words that deserve an entry in the language's pack", report.entries],
    ])) {
      if (tallies.length)
        parts.push(made("h3", title), made("ul", ...tallies.map((one) => this.#tally(title, one))));
    }
    if (report.silence.length)
      parts.push(
        made("h3", "Into and out of silence", made("small", "not in the percentages")),
        made("ol", ...report.silence.slice(0, MOST).map((/** @type {Need} */ one) =>
          this.#need(one, report.silence[0].count))),
      );
    const { scrollTop } = this.plan;
    this.plan.replaceChildren(...parts);
    this.plan.scrollTop = scrollTop;
  }

  /** @param {Need} need @param {number} most @returns {HTMLElement} */
  #need(need, most) {
    const about = { class: "pair", title: `Open ${need.bigram}` };
    const pair = button(need.bigram, about, () => this.studio.go("bigrams", need.bigram));
    const bar = made("i", { "aria-hidden": "true" });
    bar.style.setProperty("--share", (need.count / most).toFixed(3));
    const word = need.example
      ? button(`▶ ${need.example}`, { dir: "auto", title: "Speak it" }, () => this.studio.speak(need.example))
      : made("span");
    return made("li",
      pair,
      made("span", `${need.count.toLocaleString()}×`),
      bar,
      word,
      made("small", [need.layer === "like" ? "borrowed" : need.status || "gap", ...need.places].join(" · ")),
    );
  }

  /** @param {string} title @param {import("../payloads.js").Tally} one @returns {HTMLElement} */
  #tally(title, one) {
    const name = title.includes("mapping")
      ? button(one.what, { dir: "auto" }, () => this.studio.go("language", one.what))
      : made("b", { dir: "auto" }, one.what);
    return made("li", name, made("span", `${one.count}×`), made("i"), made("span"), made("small", one.place));
  }

  #sentenceList() {
    const list = made("ol"),
      box = made("details", made("summary", "Lines of the script that together have all undrawn bigrams"), list);
    box.addEventListener("toggle", async () => {
      if (!box.open || list.childElementCount) return;
      list.replaceChildren(made("li", "Searching…"));
      await this.studio.attempt(async () => {
        const { sentences } = await this.studio.api.get(`coverage/sentences?minutes=${this.minutes.value}`);
        list.replaceChildren(...sentences.map((/** @type {import("../payloads.js").NeededSentence} */ one) => {
          const speak = button("▶", { "aria-label": `Speak: ${one.text}` }, () => this.studio.speak(one.text));
          return made(
            "li",
            { class: "sentence" },
            speak,
            made("p", { dir: "auto" }, one.text, made("small", `${one.place} · ${one.bigrams.join(" ")}`)),
          );
        }));
      });
    });
    return box;
  }
}

/** @param {number} share @returns {string} as in reports: 100 % is all, and 0 % is nothing */
function percent(share) {
  if (share > 0 && share < 0.05) return "under 0.1 %";
  const shown = share > 0 && share < 100 ? Math.min(share, 99.9) : share;
  const digits = { minimumFractionDigits: shown % 100 ? 1 : 0, maximumFractionDigits: 1 };
  return `${shown.toLocaleString(undefined, digits)} %`;
}

/** @param {string} name @returns {string} what this browser keeps */
function remembered(name) {
  try { return localStorage.getItem(`coverage: ${name}`) ?? ""; } catch { return ""; }
}

/** @param {string} name @param {string} value */
function remember(name, value) {
  try { localStorage.setItem(`coverage: ${name}`, value); } catch { /* a browser that keeps nothing */ }
}
