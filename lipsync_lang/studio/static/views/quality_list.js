/** Figures of the line with their findings; a click goes to the moment. */

import { button, made } from "../shell/elements.js";

/** Milliseconds after the last change of the curves, before they are judged. */
const SETTLE = 300;
/** Findings of a figure that are named. */
const MOST = 12;

/** The list of figures beside a view. */
export class QualityList {
  /** @param {import("../shell/studio.js").Studio} studio @param {HTMLElement} place */
  constructor(studio, place) {
    this.studio = studio;
    this.list = made("ul");
    this.summary = made("small", { role: "status" });
    place.append(made("h3", "This line", this.summary), this.list);
    this.visible = false;
    /** Take that was judged. @type {unknown} */
    this.judged = null;
  }

  show() {
    this.visible = true;
    this.#ask();
  }

  hide() {
    this.visible = false;
  }

  /** The curves are new. */
  changed() {
    clearTimeout(this.later);
    if (this.visible) this.later = setTimeout(() => this.#ask(), SETTLE);
  }

  async #ask() {
    const { take, api } = this.studio;
    if (!take) {
      this.judged = null;
      this.summary.textContent = "";
      this.list.replaceChildren(made("li", "Speak a line below to judge its contacts, limits and stillness."));
      return;
    }
    if (take === this.judged) return;
    this.judged = take;
    await this.studio.attempt(async () => {
      /** @type {{figures: import("../payloads.js").Figure[]}} */
      const { figures } = await api.get("figures");
      if (this.judged !== take) return;
      const failed = figures.filter((one) => one.verdict === "FAIL").length;
      this.summary.textContent = failed
        ? `${failed} of ${figures.length} figures fail`
        : figures.length
          ? "all limits are met"
          : "";
      const order = (/** @type {import("../payloads.js").Figure} */ one) =>
        one.verdict === "FAIL" ? 0 : one.findings.length ? 1 : one.verdict === "ok" ? 2 : 3;
      const sorted = figures.toSorted((a, b) => order(a) - order(b));
      const first = sorted.filter((one) => order(one) < 3), rest = sorted.slice(first.length);
      const others = made("details",
        made("summary", `${rest.length} more, without a limit or not judged`),
        made("ul", ...rest.map((one) => this.#figure(one))),
      );
      this.list.replaceChildren(
        ...first.map((one) => this.#figure(one)),
        ...(rest.length ? [made("li", others)] : []),
      );
    });
  }

  /**
   * @param {{name: string, verdict: string, told: string, findings: [number, string][]}} figure
   * @returns {HTMLElement}
   */
  #figure({ name, verdict, told, findings }) {
    const moments = findings.slice(0, MOST).map(([seconds, what]) =>
      button(`${seconds.toFixed(2)} s ${what}`, "Go to the moment", () => this.studio.reveal(seconds)));
    const rest = findings.length - moments.length;
    const sign = verdict === "FAIL" ? "✗ " : verdict === "ok" ? "✓ " : "";
    return made(
      "li",
      { class: verdict, title: name },
      made("b", `${sign}${told}`),
      made("div", ...moments, ...(rest > 0 ? [`and ${rest} more`] : [])),
    );
  }
}
