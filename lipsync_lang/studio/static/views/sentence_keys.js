/** Keys of the sentence view. */

import { tellKeys } from "../shell/studio_keys.js";

/** Seconds that a boundary is moved by a key, with Shift, and with Alt. */
const NUDGE = 0.005, FAR = 0.02, FINE = 0.001;

tellKeys({
  "[ ]": "Sentence: choose the previous or next boundary; ← → then move it by 5 ms, with Shift 20 ms, with Alt 1 ms",
  "; '": "Sentence: choose the previous or next word; Alt ← → then moves it by 5 ms, with Shift by 20 ms",
  ", .": "Sentence: choose the previous or next phoneme",
  "r s j i Delete": "Sentence: relabel, split, join, insert or delete the chosen phoneme",
  "g": "Sentence: align the chosen words or phonemes again; Shift and a click choose up to another",
  "w": "Sentence: show the sound as a wave, a spectrogram or both",
  "e": "Sentence: emphasise the word, or stop emphasising it",
  "↑ ↓": "Sentence: choose a pose, and see its reasons",
  "k": "Sentence: bend the pose at the playhead by a key; Shift ↑ ↓ then raises or lowers it, Delete removes it",
  "t": "Sentence: add a gesture at the word or playhead; in their lane, ← → move it, ↑ ↓ scale it, Delete removes it",
  "Enter": "Sentence: open the bigram of the pose at the playhead",
  "a": "Sentence: switch between A and B",
  "d": "Sentence: go to the next word that the aligner doubts",
  "n": "Sentence: go to the next finding of the check",
  "Esc": "Sentence: clear the choice",
});

/**
 * @param {import("./sentence_view.js").SentenceView} view
 * @param {KeyboardEvent} event
 * @returns {boolean} true if used
 */
export function sentenceKey(view, event) {
  const { timeline, studio } = view, { take } = studio;
  if (!take || event.ctrlKey || event.metaKey || event.target instanceof HTMLInputElement) return false;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (
    key === "Enter" &&
    (event.target instanceof HTMLButtonElement ||
      event.target instanceof HTMLAnchorElement ||
      /** @type {Element} */ (event.target).localName === "summary")
  )
    return false;
  if (timeline.boundary >= 0 && (key === "ArrowLeft" || key === "ArrowRight")) {
    const by = event.shiftKey ? FAR : event.altKey ? FINE : NUDGE;
    view.phonemes.nudge(key === "ArrowLeft" ? -by : by);
    return true;
  }
  if (timeline.word >= 0 && event.altKey && (key === "ArrowLeft" || key === "ArrowRight")) {
    const by = event.shiftKey ? FAR : NUDGE;
    view.phonemes.nudge(key === "ArrowLeft" ? -by : by);
    return true;
  }
  if (event.altKey) return false;
  /** @type {Record<string, () => void>} */
  const does = {
    "[": () => chooseBoundary(view, -1), "]": () => chooseBoundary(view, 1),
    ";": () => chooseWord(view, -1), "'": () => chooseWord(view, 1),
    ",": () => choosePhoneme(view, -1), ".": () => choosePhoneme(view, 1),
    "r": () => onPhoneme(view, () => view.phonemePanel.ask()),
    "i": () => onPhoneme(view, () => view.phonemePanel.ask(true)),
    "s": () => onPhoneme(view, () => view.phonemes.split()),
    "j": () => onPhoneme(view, () => view.phonemes.join()),
    "Delete": () => view.gestures.remove() || view.bends.remove() || view.phonemes.remove(),
    "g": () => view.phonemes.align(),
    "d": () => nextDoubt(view),
    "k": () => view.bends.addHere(), "t": () => view.gestures.add(),
    "w": () => view.picture(),
    "e": () => emphasise(view), "a": () => view.swap(), "n": () => view.nextFinding(),
    "ArrowUp": () => (event.shiftKey && view.bends.raise(1)) || view.pick(timeline.row - 1),
    "ArrowDown": () => (event.shiftKey && view.bends.raise(-1)) || view.pick(timeline.row + 1),
    "Home": () => view.reveal(take.start), "End": () => view.reveal(take.end),
    "Enter": () => view.openBigram(studio.player.time, timeline.row), "Escape": () => view.choose({}),
  };
  if (!does[key]) return false;
  does[key]();
  return true;
}

/** @param {import("./sentence_view.js").SentenceView} view @param {number} way */
function chooseBoundary(view, way) {
  const { times } = /** @type {import("../line/take.js").Take} */ (view.studio.take).data.spoken,
    now = view.studio.player.time,
    { boundary } = view.timeline;
  const from =
    boundary >= 0
      ? boundary + way
      : way > 0
        ? times.findIndex((/** @type {number} */ one) => one > now)
        : times.findLastIndex((/** @type {number} */ one) => one <= now);
  const next = Math.max(0, Math.min(times.length - 1, from));
  view.studio.player.pause();
  view.choose({ boundary: next });
  view.reveal(times[next]);
}

/** @param {import("./sentence_view.js").SentenceView} view @param {number} way */
function choosePhoneme(view, way) {
  const take = /** @type {import("../line/take.js").Take} */ (view.studio.take), { times, labels } = take.data.spoken;
  const from = view.timeline.phoneme >= 0 ? view.timeline.phoneme + way : take.phonemeAt(view.studio.player.time);
  const phoneme = Math.max(0, Math.min(labels.length - 1, from));
  view.studio.player.pause();
  view.choose({ phoneme }, true);
  view.reveal(times[phoneme]);
}

/**
 * Act on the chosen phoneme, or on that at the playhead.
 * @param {import("./sentence_view.js").SentenceView} view @param {() => void} act
 */
function onPhoneme(view, act) {
  if (view.timeline.phoneme < 0) view.choose({ phoneme: view.studio.take?.phonemeAt(view.studio.player.time) ?? -1 });
  act();
}

/** @param {import("./sentence_view.js").SentenceView} view @param {number} way */
function chooseWord(view, way) {
  const take = /** @type {import("../line/take.js").Take} */ (view.studio.take), { times, words } = take.data.spoken;
  if (!words.length) return;
  const at = view.timeline.word >= 0 ? view.timeline.word + way : wordNow(view);
  const next = Math.max(0, Math.min(words.length - 1, at));
  view.studio.player.pause();
  view.choose({ word: next }, true);
  view.reveal(times[words[next][1]]);
}

/** @param {import("./sentence_view.js").SentenceView} view */
function nextDoubt(view) {
  const take = /** @type {import("../line/take.js").Take} */ (view.studio.take);
  const { times, words, doubts } = take.data.spoken;
  const every = Object.keys(doubts).map(Number), word = every.find((one) => one > view.timeline.word) ?? every[0];
  if (word === undefined) view.studio.tell("The aligner doubts no word of this line");
  else {
    view.choose({ word }, true);
    view.reveal(times[words[word][1]]);
  }
}

/** @param {import("./sentence_view.js").SentenceView} view @returns {number} the word at the playhead, or the next */
function wordNow(view) {
  const take = /** @type {import("../line/take.js").Take} */ (view.studio.take),
    { times, words } = take.data.spoken,
    now = view.studio.player.time;
  return words.findIndex((/** @type {[string, number, number]} */ [, , stop]) => times[stop] > now);
}

/** @param {import("./sentence_view.js").SentenceView} view */
function emphasise(view) {
  const take = /** @type {import("../line/take.js").Take} */ (view.studio.take);
  if (view.timeline.word < 0) view.choose({ word: wordNow(view) });
  if (view.timeline.word >= 0) view.emphasise(take.data.spoken.emphasis[view.timeline.word] ? 0 : 1, true);
}
