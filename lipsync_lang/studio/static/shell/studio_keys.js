/** Keys of the studio's shell; views have keys of their own, which come first. */

import { made, the } from "./elements.js";

const KEYS = {
  "Space": "Play or pause",
  "← →": "Go back or forward by a frame, with Shift by ten (if no point is chosen)",
  ", .": "Go to the previous or next phoneme",
  "Ctrl Z, Ctrl Shift Z": "Undo or redo",
  "Ctrl S": "Save",
  "Ctrl E": "Export this line or all lines",
  "/": "Type a line",
  "Alt ↑, Alt ↓, o": "Open the previous or next line of the script, or the list of all",
  "Alt 1 … Alt 6": "Open a view, counted from the left",
  "l": "Loop the word at the playhead",
  "b": "Open the bigram at the playhead",
  "f h p m": "Turn the face to the front, half, or to the side, or show the mouth",
  "x": "See the tongue through the face, or the solid face",
  "+ − 0": "Zoom in, zoom out, or show all",
  "?": "Show or hide this list",
};

/** Keys that views add, and what they do; two views may share a key. @type {[string, string][]} */
const added = [];

/** @param {Record<string, string>} keys of a view, for the list of keys */
export function tellKeys(keys) {
  added.push(...Object.entries(keys));
}

/** Open the list of keys, or close it. */
export function showHelp() {
  const help = /** @type {HTMLDialogElement} */ (the("help"));
  const list = /** @type {HTMLElement} */ (help.querySelector("dl"));
  list.replaceChildren(
    ...[...Object.entries(KEYS), ...added].flatMap(([key, does]) => [made("dt", key), made("dd", does)]),
  );
  if (help.open) help.close();
  else help.showModal();
  help.scrollTop = 0; // the button at the end has the focus, and is scrolled to
}

/** @param {EventTarget | null} target @returns {boolean} true where letters are typed */
function typing(target) {
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement
    || (target instanceof HTMLInputElement && !["range", "checkbox", "button"].includes(target.type));
}

/**
 * Act on a key.
 * @param {import("./studio.js").Studio} studio
 * @param {KeyboardEvent} event
 */
export function shellKeys(studio, event) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const control = event.ctrlKey || event.metaKey;
  /** @type {Record<string, () => void>} */
  const always = {
    z: () => studio.edits.history(event.shiftKey ? "redo" : "undo"),
    y: () => studio.edits.history("redo"),
    s: () => studio.edits.save(),
    e: () => studio.exporting.show(),
  };
  const within = typing(event.target);
  if (control && always[key] && !(within && !"se".includes(key))) {
    event.preventDefault();
    always[key]();
    return;
  }
  if (document.querySelector("dialog[open]") && key !== "?") return;
  if (event.altKey && /^[1-9]$/.test(key)) {
    const tab = /** @type {HTMLAnchorElement | undefined} */ (the("tabs").children[Number(key) - 1]);
    if (tab) { event.preventDefault(); tab.click(); }
    return;
  }
  if (event.altKey && (key === "ArrowUp" || key === "ArrowDown")) {
    event.preventDefault();
    studio.script.go(key === "ArrowUp" ? -1 : 1);
    return;
  }
  if (within) {
    if (key === "Escape") /** @type {HTMLElement} */ (event.target).blur();
    return;
  }
  if (studio.view?.key(event)) {
    event.preventDefault();
    return;
  }
  if (control || event.altKey) return;
  if (event.target instanceof HTMLInputElement && key.startsWith("Arrow")) return;
  const frames = event.shiftKey ? 10 : 1;
  /** @type {Record<string, () => void>} */
  const does = {
    " ": () => studio.player.toggle(),
    "ArrowLeft": () => studio.step(-frames), "ArrowRight": () => studio.step(frames),
    ",": () => phoneme(studio, -1), ".": () => phoneme(studio, 1),
    "/": () => the("text").focus(),
    "o": () => studio.script.choose(),
    "l": () => studio.bar.toggleLoop(),
    "b": () => bigram(studio),
    "f": () => studio.bar.viewFrom("front"), "h": () => studio.bar.viewFrom("half"),
    "x": () => the("tongue").click(), "p": () => studio.bar.viewFrom("side"), "m": () => studio.bar.viewFrom("close"),
    "+": () => studio.bar.zoom(1.5), "=": () => studio.bar.zoom(1.5), "-": () => studio.bar.zoom(1 / 1.5),
    "0": () => studio.bar.zoomOut(),
    "?": showHelp,
  };
  const act = does[key];
  if (!act) return;
  event.preventDefault();
  act();
}

/** @param {import("./studio.js").Studio} studio @param {number} way */
function phoneme(studio, way) {
  const { take } = studio;
  if (!take) return;
  const { times } = take.data.spoken, now = studio.player.time;
  const next =
    way > 0
      ? times.find((/** @type {number} */ one) => one > now + 1e-4)
      : times.findLast((/** @type {number} */ one) => one < now - 1e-4);
  if (next !== undefined) studio.reveal(next);
}

/** @param {import("./studio.js").Studio} studio */
function bigram(studio) {
  const { take } = studio;
  const found = take?.bigramsAt(take.frameAt(studio.player.time)) ?? [];
  const nearest = found.toSorted(
    (a, b) => Math.abs(a.position - 0.5) - Math.abs(b.position - 0.5),
  )[0];
  if (nearest) studio.go("bigrams", nearest.drawn_as ?? nearest.pair);
}
