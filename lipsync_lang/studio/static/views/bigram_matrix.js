/** Matrix of first by second phoneme: the status of each bigram, and how often the script needs it. */

import { button, made } from "../shell/elements.js";

/** Statuses with their sign and their words; the sign distinguishes them without colours. */
const STATUSES = {
  approved: ["✓", "approved"],
  edited: ["●", "edited"],
  fitted: ["◦", "fitted to captures"],
  drafted: ["·", "drafted"],
  gap: ["×", "gap: no curves"],
  none: ["", "never spoken"],
};
/** Bigrams that are listed as wanted. */
const MOST = 40;

/** @typedef {{status: string, layer?: string, need?: number, word?: string | null}} Cell */
/**
 * @typedef {{phonemes: string[], pairs: Record<string, Cell>, wanted: {pair: string, count: number, word?: string |
 *   null}[], source?: string}} Matrix `source`: script or line
 */

/** A grid that is walked by arrows and opens a bigram by Enter or click. */
export class BigramMatrix {
  /** @param {HTMLElement} place @param {{open: (pair: string) => void}} does */
  constructor(place, does) {
    this.does = does;
    /** @type {Matrix} */
    this.data = { phonemes: [], pairs: {}, wanted: [] };
    /** @type {Map<string, HTMLElement>} */
    this.cells = new Map();
    this.at = "";
    this.table = made("table", {
      class: "matrix",
      role: "grid",
      "aria-label": "Bigrams: the first phoneme down, the second across",
    });
    this.info = made("p", { class: "matrix-info", role: "status" });
    this.legend = made("ul", { class: "matrix-legend", "aria-label": "Statuses" });
    this.only = button("Only needed bigrams", { "aria-pressed": "false" }, () =>
      this.only.setAttribute("aria-pressed", String(this.table.classList.toggle("needed"))));
    this.wanted = made("ol", { class: "wanted" });
    this.none = made("p", { class: "note" }, "Every needed bigram is drawn.");
    place.append(
      made(
        "section",
        { class: "bigram-matrix", "aria-label": "All bigrams" },
        made("div", { class: "row matrix-head" }, this.legend, this.only),
        this.info,
        made("div", { class: "matrix-scroll" }, this.table),
        made("aside", { "aria-label": "Next most wanted" }, made("h2", "Next most wanted"), this.wanted, this.none),
      ),
    );
    this.table.addEventListener("keydown", (event) => this.#key(event));
    this.table.addEventListener("click", (event) => this.#pick(event, (pair) => does.open(pair)));
    this.table.addEventListener("focusin", (event) => this.#pick(event, (pair) => this.#stand(pair)));
    this.table.addEventListener("pointerover", (event) => this.#pick(event, (pair) => this.#tell(pair)));
    this.table.addEventListener("pointerleave", () => this.#tell(this.at));
  }

  /** @param {Event} event @param {(pair: string) => void} does */
  #pick(event, does) {
    const pair = /** @type {Element} */ (event.target).closest("td")?.getAttribute("data-pair");
    if (pair) does(pair);
  }

  /** @param {Matrix} data */
  show(data) {
    const same = String(data.phonemes) === String(this.data.phonemes);
    this.data = data;
    if (!same) this.#build();
    const most = Math.max(1, ...Object.values(data.pairs).map(({ need = 0 }) => need));
    for (const [pair, cell] of this.cells) {
      const { status, need = 0 } = this.#cell(pair),
        sign = STATUSES[/** @type {keyof typeof STATUSES} */ (status)]?.[0] ?? "";
      const share = need ? 0.25 + (0.75 * Math.log1p(need)) / Math.log1p(most) : 0,
        name = `${status}${need ? " need" : ""}`;
      if (cell.className !== name) cell.className = name;
      if (cell.textContent !== sign) cell.textContent = sign;
      cell.style.setProperty("--need", share.toFixed(2));
      cell.setAttribute("aria-label", this.told(pair));
    }
    this.#listWanted();
    this.#count();
    this.#tell(this.at);
  }

  /** @param {string} pair @returns {Cell} */
  #cell(pair) {
    return this.data.pairs[pair] ?? { status: "none" };
  }

  /** @param {string} pair @returns {string} all that is known of it */
  told(pair) {
    const { status, layer, need = 0, word } = this.#cell(pair), { source = "script" } = this.data;
    const times = need ? `the ${source} needs it ${need} time${need > 1 ? "s" : ""}` : "";
    const words = STATUSES[/** @type {keyof typeof STATUSES} */ (status)]?.[1] ?? status;
    return [
      pair,
      words,
      layer && layer !== status && layer !== "draft" ? `by ${layer}` : "",
      word ? `as in ${word}` : "",
      times,
    ]
      .filter(Boolean)
      .join(", ");
  }

  #build() {
    const { phonemes } = this.data, all = phonemes.flatMap((first) => phonemes.map((second) => `${first}-${second}`));
    this.cells = new Map(
      all.map((pair) => [pair, made("td", { "data-pair": pair, tabindex: "-1", role: "gridcell" })]),
    );
    const head = made("tr",
      made("td", { class: "corner" }),
      ...phonemes.map((one) => made("th", { scope: "col" }, one)),
    );
    const rows = phonemes.map((first) => made("tr", made("th", { scope: "row" }, first),
      ...phonemes.map((second) => /** @type {HTMLElement} */ (this.cells.get(`${first}-${second}`)))));
    this.table.replaceChildren(made("thead", head), made("tbody", ...rows));
    if (!this.cells.has(this.at)) this.at = this.data.wanted[0]?.pair ?? all[0] ?? "";
    this.#stand(this.at);
  }

  /** @param {string} pair that arrows start from */
  #stand(pair) {
    this.cells.get(this.at)?.setAttribute("tabindex", "-1");
    this.at = pair;
    this.cells.get(pair)?.setAttribute("tabindex", "0");
    this.#tell(pair);
  }

  /** @param {string} pair */
  #tell(pair) {
    this.info.textContent = pair && this.cells.has(pair) ? this.told(pair) : "";
    const [first, second] = pair.split("-"), { phonemes } = this.data;
    for (const [at, row] of [...this.table.querySelectorAll("tbody th")].entries())
      row.classList.toggle("on", phonemes[at] === first);
    for (const [at, column] of [...this.table.querySelectorAll("thead th")].entries())
      column.classList.toggle("on", phonemes[at] === second);
  }

  #listWanted() {
    const { wanted } = this.data;
    this.none.hidden = wanted.length > 0;
    this.wanted.replaceChildren(...wanted.slice(0, MOST).map(({ pair, count, word }) => {
      const parts = [made("b", pair), made("span", { dir: "auto" }, word ?? ""), made("span", `${count}×`)];
      return made("li", button(parts, "", () => this.does.open(pair)));
    }));
  }

  #count() {
    this.legend.replaceChildren(...Object.entries(STATUSES).flatMap(([status, [sign, words]]) => {
      const count = [...this.cells.keys()].filter((pair) => this.#cell(pair).status === status).length;
      return count ? [made("li", made("i", { class: status }, sign), `${words} ${count}`)] : [];
    }));
  }

  /** @param {string} pair to stand on, when the matrix comes to the front */
  focus(pair = this.at) {
    if (this.cells.has(pair)) this.#stand(pair);
    this.cells.get(this.at)?.focus();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { phonemes } = this.data,
      [first, second] = this.at.split("-").map((one) => phonemes.indexOf(one)),
      last = phonemes.length - 1;
    /** @type {Record<string, [number, number]>} */
    const moves = {
      ArrowUp: [-1, 0],
      ArrowDown: [1, 0],
      ArrowLeft: [0, -1],
      ArrowRight: [0, 1],
      PageUp: [-5, 0],
      PageDown: [5, 0],
      Home: [0, -last],
      End: [0, last],
    };
    const move = moves[event.key];
    if (move) {
      const [row, column] = [first + move[0], second + move[1]].map((one) => Math.min(last, Math.max(0, one)));
      this.focus(`${phonemes[row]}-${phonemes[column]}`);
    } else if (event.key === "Enter") this.does.open(this.at);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}
