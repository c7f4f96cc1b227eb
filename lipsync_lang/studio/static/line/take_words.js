/** A take in words: the tip of a moment, the figures of a check, the colours of the stages. */

import { button, made, swatch } from "../shell/elements.js";
import { label } from "../face/portrait.js";
import { clock } from "../timeline/scales.js";

/** Findings of a figure that are listed. */
const FINDINGS = 20;
/** Pixels around a finding in which its words are shown. */
const NEAR = 6;

/** @typedef {{seconds: number, row: number, x: number, y: number}} Pointed a place on a timeline */

/**
 * Rows of two takes that move, in the order of the first; mirrored poses that move alike have one row.
 * @param {import("./take.js").Take} take
 * @param {import("./take.js").Take | null} other
 * @param {Set<string>} opened rows of pairs whose poses have rows of their own
 * @returns {string[]}
 */
export function movingRows(take, other, opened) {
  const takes = other ? [take, other] : [take], moving = new Set(takes.flatMap((one) => one.moving));
  const apart = (/** @type {string[]} */ sides, /** @type {string} */ both) =>
    opened.has(both) || takes.some((one) => one.rows.has(sides[0]) && !one.rows.has(both));
  const hidden = takes.flatMap((one) => [...one.rows]).flatMap(([name, { sides }]) =>
    sides ? apart(sides, name) ? [name] : sides : []);
  const every = takes.flatMap((one) => [...one.rows.keys()]);
  return [...new Set(every.filter((one) => moving.has(one) && !hidden.includes(one)))];
}

/**
 * Tell what is at a place on a timeline.
 * @param {HTMLElement} tip
 * @param {import("../timeline/timeline.js").Timeline} timeline
 * @param {Pointed | null} at null hides the tip
 */
export function tell(tip, timeline, at) {
  const take = timeline.shown?.take;
  tip.hidden = !at || !take || at.seconds < take.start || at.seconds > take.end;
  if (!at || !take || tip.hidden) return;
  const frame = take.frameAt(at.seconds), sound = take.soundAt(frame);
  const lines = [`${clock(at.seconds)}  ${sound.label}${sound.word ? `, in ${sound.word}` : ""}`];
  const name = timeline.line.rows[at.row], own = take.rows.get(name);
  if (own) {
    lines.push(`${name} = ${take.weight(name, frame).toFixed(3)}`);
    lines.push(...take.stepsAt(own.pose, frame).map((one) => `${one.label} ${one.weight.toFixed(3)}  ${one.why}`));
  }
  const near = take.data.figures.flatMap((one) =>
    one.findings
      .filter(
        (/** @type {[number, string]} */ [seconds]) => Math.abs(timeline.x(seconds) - timeline.x(at.seconds)) < NEAR,
      )
      .map((/** @type {[number, string]} */ [, what]) => `${one.verdict === "FAIL" ? "▲" : "●"} ${one.name}: ${what}`),
  );
  const sure = take.data.spoken.doubts[take.wordOf(take.phonemeAt(at.seconds))];
  if (at.row < 0 && sure !== undefined) lines.push(`The aligner doubts this word (confidence ${sure.toFixed(2)})`);
  if (at.row < 0) lines.push(...near);
  tip.textContent = lines.join("\n");
  tip.style.left = `${Math.max(4, Math.min(at.x + 14, innerWidth - tip.offsetWidth - 8))}px`;
  tip.style.top = `${at.y + 18 + tip.offsetHeight > innerHeight ? at.y - tip.offsetHeight - 10 : at.y + 18}px`;
}

/**
 * @param {import("../payloads.js").Figure[]} figures of a check
 * @returns {number[]} seconds of what missed a limit, else of every remark
 */
export function findingTimes(figures) {
  const missed = figures.filter((one) => one.verdict === "FAIL" && one.findings.length);
  return (missed.length ? missed : figures)
    .flatMap((one) => one.findings.map((/** @type {[number, string]} */ [seconds]) => seconds))
    .sort((a, b) => a - b);
}

/**
 * List the figures of a check.
 * @param {{figures: HTMLElement, judged: HTMLElement, missed: HTMLElement, measured: HTMLElement}} places
 * @param {import("../payloads.js").Figure[]} figures
 * @param {(seconds: number) => void} go to a finding
 */
export function listFigures(places, figures, go) {
  const missed = figures.filter((one) => one.verdict === "FAIL"),
    others = figures.filter((one) => one.verdict !== "FAIL");
  places.figures.hidden = !figures.length;
  places.judged.textContent = missed.length
    ? `Check: ${missed.length} limit${missed.length > 1 ? "s" : ""} missed`
    : "Check: all limits are met";
  places.missed.replaceChildren(...missed.map((one) => figureItem(one, go)));
  places.measured.replaceChildren(...others.map((one) => figureItem(one, go)));
}

/**
 * @param {import("../payloads.js").Figure} figure of the check
 * @param {(seconds: number) => void} go
 * @returns {HTMLElement} with buttons that go to its findings
 */
function figureItem(figure, go) {
  const verdict = made("b", figure.verdict);
  const row = made("li", { class: figure.verdict, title: figure.name }, verdict, ` ${figure.told} `);
  for (const [seconds, what] of figure.findings.slice(0, FINDINGS)) {
    row.append(button(`${clock(seconds)}: ${what}`, "", () => go(seconds)));
  }
  if (figure.findings.length > FINDINGS) row.append(`and ${figure.findings.length - FINDINGS} more`);
  return row;
}

/** @param {import("./take.js").Take} take @returns {import("../payloads.js").Stage[]} its stages that change a curve */
export function usedStages(take) {
  return (take.data.making?.stages ?? []).filter((stage) => stage.curves.some(Boolean));
}

/**
 * List the colours of the stages, and of the other take.
 * @param {HTMLElement} list
 * @param {import("./take.js").Take} take
 * @param {import("./take.js").Take | null} other
 */
export function listStages(list, take, other) {
  const first = take.data.making?.stages[0];
  list.replaceChildren(
    ...usedStages(take).map((stage) =>
      swatch(stage.label, stage.colour, stage === first ? "dots" : "", stage.hatch),
    ),
  );
  if (other) list.append(swatch(label(other), getComputedStyle(document.body).getPropertyValue("--other"), "line"));
}
