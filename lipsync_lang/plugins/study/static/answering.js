"use strict";
/**
 * The page of a study: consent, pairs of clips with questions, and the export of answers.
 *
 * @typedef {{key: string, label: string, choices: string[]}} Asked
 * @typedef {{key: string, ask: string, means: string}} Question
 * @typedef {{post: string | null, study: string, title: string, consent: string[], asked: Asked[],
 *   questions: Question[], groups: {take: number, pairs: string[]}[]}} StudyDocument
 * @typedef {{pair: string, question: string, choice: string, strength: number, seconds: number, plays: number}} PairAnswer
 * @typedef {{kind: "answers", format: 1, study: string, rater: string, consent: true, started: string,
 *   finished: string | null, asked: Record<string, string>, answers: PairAnswer[]}} Submission
 * @typedef {{pair: string, began: number, plays: number, seen: Set<string>, chosen: Map<string, number>, urls: string[]}} Shown
 */

const SIDES = ["left", "right"];
const LETTERS = /** @type {Record<string, string>} */ ({ left: "A", right: "B" });
const STRENGTHS = [1, 2, 3, 4, 5];
const SEND_MS = 20000;

/** @param {string} id @returns {HTMLElement} */
function the(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/** @param {string} id @returns {HTMLVideoElement} */
function video(id) {
  return /** @type {HTMLVideoElement} */ (the(`video-${id}`));
}

/** @param {string} id @returns {HTMLButtonElement} */
function button(id) {
  return /** @type {HTMLButtonElement} */ (the(id));
}

/**
 * Make an element; text is never markup.
 * @param {string} name
 * @param {Record<string, string>} [traits]
 * @param {...(Node | string)} content
 * @returns {HTMLElement}
 */
function made(name, traits = {}, ...content) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(traits)) element.setAttribute(key, value);
  element.append(...content);
  return element;
}

const asked = /** @type {StudyDocument} */ (JSON.parse(the("document").textContent ?? ""));
const KEPT = `lipsync-study-${asked.study}`;

// Chance that a rater's number repeats

/** @param {string} seed @returns {() => number} numbers from 0 to 1, the same for the same seed */
function chance(seed) {
  let state = 2166136261;
  for (const one of seed) state = Math.imul(state ^ one.charCodeAt(0), 16777619);
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}

/** @template T @param {T[]} items @param {() => number} next @returns {T[]} */
function shuffled(items, next) {
  const all = [...items];
  for (let last = all.length - 1; last > 0; last--) {
    const other = Math.floor(next() * (last + 1));
    [all[last], all[other]] = [all[other], all[last]];
  }
  return all;
}

/** @param {string} rater @returns {string[]} the pairs that a rater sees, in order */
function orderFor(rater) {
  const next = chance(asked.study + rater);
  return shuffled(asked.groups.flatMap(({ take, pairs }) => shuffled(pairs, next).slice(0, take)), next);
}

function randomRater() {
  return [...crypto.getRandomValues(new Uint8Array(8))].map((one) => one.toString(16).padStart(2, "0")).join("");
}

// What is kept in the browser

/**
 * The answers given before a reload. The tab's history holds them too. A page that is reloaded at once can find an
 * older state in the store. A page that may not use the store finds none.
 * @returns {Submission | null}
 */
function kept() {
  const own = whole(history.state);
  let stored = null;
  try {
    stored = whole(JSON.parse(localStorage.getItem(KEPT) ?? "null"));
  } catch {
    // the history is left
  }
  if (!stored || stored.rater === history.state?.forgotten) return own;
  return stored.rater === own?.rater && (own.finished || own.answers.length > stored.answers.length) ? own : stored;
}

/** @param {any} found @returns {Submission | null} answers to this study, or nothing */
function whole(found) {
  return found?.study === asked.study && /^[0-9a-f]{16}$/.test(found.rater) && Array.isArray(found.answers) ? found : null;
}

function keep() {
  history.replaceState(given, "");
  try {
    localStorage.setItem(KEPT, JSON.stringify(given));
  } catch {
    trouble("This browser does not store answers for this page. Do not close the page, and save the answers at the end.");
  }
}

/** @param {string} text */
function trouble(text) {
  the("trouble").textContent = text;
  the("trouble").hidden = false;
}

/** @type {Submission | null} */
let given = kept();
/** @type {string[]} */
let order = given ? orderFor(given.rater) : [];
/** @type {Shown | null} */
let shown = null;

/** @param {string} pair */
function answered(pair) {
  return asked.questions.every(({ key }) => given?.answers.some((one) => one.pair === pair && one.question === key));
}

// Consent

function welcome() {
  the("consent").replaceChildren(...asked.consent.map((text) => made("p", {}, text)));
  the("asked").replaceChildren(...asked.asked.map(question));
  the("welcome").hidden = false;
}

/** @param {Asked} one @returns {HTMLElement} */
function question({ key, label, choices }) {
  if (!choices.length) return made("label", {}, label, made("input", { id: `asked-${key}`, maxlength: "200", autocomplete: "off" }));
  const options = [made("option", { value: "" }, "No answer"), ...choices.map((choice) => made("option", {}, choice))];
  return made("label", {}, label, made("select", { id: `asked-${key}` }, ...options));
}

/** @param {SubmitEvent} event */
function begin(event) {
  event.preventDefault();
  if (!(/** @type {HTMLInputElement} */ (the("agree")).checked)) return;
  const own = asked.asked.map(({ key }) => [key, /** @type {HTMLInputElement} */ (the(`asked-${key}`)).value.trim()]);
  given = {
    kind: "answers", format: 1, study: asked.study, rater: randomRater(), consent: true,
    started: new Date().toISOString(), finished: null,
    asked: Object.fromEntries(own.filter(([, value]) => value)), answers: [],
  };
  order = orderFor(given.rater);
  keep();
  the("welcome").hidden = true;
  proceed();
}

// Pairs

/** Show the next pair without answers, or the end. */
function proceed() {
  const pair = order.find((one) => !answered(one));
  if (pair === undefined) {
    if (given && !given.finished) {
      given.finished = new Date().toISOString();
      keep();
    }
    end();
    return;
  }
  show(pair);
}

/** @param {string} pair */
function show(pair) {
  release();
  const number = order.indexOf(pair) + 1;
  shown = { pair, began: performance.now(), plays: 0, seen: new Set(), chosen: new Map(), urls: [] };
  for (const side of SIDES) {
    const url = URL.createObjectURL(clip(`${pair}-${side}`));
    shown.urls.push(url);
    video(side).src = url;
  }
  the("end").hidden = true;
  the("rating").hidden = false;
  the("which").textContent = `Pair ${number} of ${order.length}`;
  the("hint").textContent = "Play both clips to the end, then answer.";
  the("questions").replaceChildren(...asked.questions.map(fieldset));
  button("next").disabled = true;
  progress();
  the("which").focus();
  scrollTo(0, 0);
}

function release() {
  for (const url of shown?.urls ?? []) URL.revokeObjectURL(url);
  for (const side of SIDES) video(side).closest("figure")?.classList.remove("playing");
}

function progress() {
  const done = order.filter(answered).length;
  const bar = /** @type {HTMLProgressElement} */ (the("progress"));
  bar.max = order.length;
  bar.value = done;
  the("count").textContent = `${done} of ${order.length}`;
  the("far").hidden = false;
}

/** @param {string} id @returns {Blob} */
function clip(id) {
  const bytes = Uint8Array.from(atob(the(id).textContent ?? ""), (one) => one.charCodeAt(0));
  return new Blob([bytes], { type: "video/mp4" });
}

/** @param {Question} one @returns {HTMLElement} */
function fieldset({ key, ask, means }) {
  const better = SIDES.map((side) => radio(`choice-${key}`, side, LETTERS[side], `${LETTERS[side]} is better`));
  const strengths = STRENGTHS.map((one) => radio(`strength-${key}`, String(one), String(one), `${one} of 5`));
  return made(
    "fieldset", { disabled: "", class: "question" },
    made("legend", {}, ask), made("p", { class: "means" }, means),
    made("fieldset", {}, made("legend", {}, "The better clip"), made("div", { class: "choices" }, ...better)),
    made("fieldset", {}, made("legend", {}, "How strong is your preference? 1 is weak, 5 is strong"),
      made("div", { class: "choices" }, ...strengths)),
  );
}

/** @param {string} name @param {string} value @param {string} label @param {string} said */
function radio(name, value, label, said) {
  return made("label", {}, made("input", { type: "radio", name, value, "aria-label": said, required: "" }), label);
}

/** @param {string} side */
function play(side) {
  for (const other of SIDES) {
    if (other !== side) video(other).pause();
  }
  const one = video(side);
  one.currentTime = 0;
  one.play().catch((error) => {
    if (error.name !== "AbortError") trouble(`Clip ${LETTERS[side]} cannot be played here (${error.name}). Try another browser.`);
  });
}

/** @param {string} side */
function ended(side) {
  if (!shown) return;
  shown.seen.add(side);
  const missing = SIDES.filter((one) => !shown?.seen.has(one));
  if (missing.length) {
    the("hint").textContent = `Now play clip ${LETTERS[missing[0]]}.`;
    return;
  }
  the("hint").textContent = "You can play them again.";
  for (const one of document.querySelectorAll(".question")) one.removeAttribute("disabled");
}

/** @param {string} name @returns {string | null} */
function chosen(name) {
  return document.querySelector(`input[name="${name}"]:checked`)?.getAttribute("value") ?? null;
}

/** @param {Event} event */
function changed(event) {
  const name = event.target instanceof HTMLInputElement ? event.target.name : "";
  if (shown && name.startsWith("choice-")) {
    shown.chosen.set(name.slice("choice-".length), (performance.now() - shown.began) / 1000);
  }
  button("next").disabled = !asked.questions.every(({ key }) => chosen(`choice-${key}`) && chosen(`strength-${key}`));
}

/** @param {SubmitEvent} event */
function next(event) {
  event.preventDefault();
  if (!shown || !given || button("next").disabled) return;
  for (const { key } of asked.questions) {
    given.answers.push({
      pair: shown.pair, question: key, choice: chosen(`choice-${key}`) ?? "", strength: Number(chosen(`strength-${key}`)),
      seconds: Math.round((shown.chosen.get(key) ?? 0) * 100) / 100, plays: shown.plays,
    });
  }
  keep();
  proceed();
}

// The end

function exported() {
  return JSON.stringify(given);
}

function end() {
  release();
  shown = null;
  for (const side of SIDES) video(side).removeAttribute("src");
  the("rating").hidden = true;
  the("end").hidden = false;
  progress();
  const done = Boolean(given?.finished);
  the("thanks").textContent = done ? "Thank you. All pairs are answered." : "You have stopped.";
  button("resume").hidden = done;
  button("another").hidden = !done;
  button("another").textContent = "Let another person answer";
  const save = /** @type {HTMLAnchorElement} */ (the("save"));
  if (save.href) URL.revokeObjectURL(save.href);
  save.href = URL.createObjectURL(new Blob([exported()], { type: "application/json" }));
  save.download = `answers-${asked.study.slice(0, 8)}-${given?.rater.slice(0, 8)}.json`;
  /** @type {HTMLTextAreaElement} */ (the("text")).value = exported();
  button("send").hidden = asked.post === null;
  if (asked.post === null) the("sent").textContent = "Save or copy the answers, and send them to the person who asked you.";
  else if (done) void send();
  the("thanks").focus();
}

async function send() {
  if (asked.post === null) return;
  button("send").disabled = true;
  the("sent").textContent = "Sending the answers ...";
  let told = "";
  try {
    const answer = await fetch(asked.post, {
      method: "POST", body: exported(), headers: { "Content-Type": "application/json" },
      credentials: "omit", redirect: "error", signal: AbortSignal.timeout(SEND_MS),
    });
    if (!answer.ok) told = `the server says ${answer.status}`;
  } catch {
    told = "no connection";
  }
  button("send").disabled = false;
  button("send").hidden = !told;
  the("sent").textContent = told ? `The answers were not sent (${told}). Send them again, or save them as a file.` : "The answers were sent. You can close this page.";
}

async function copy() {
  const text = /** @type {HTMLTextAreaElement} */ (the("text"));
  let copied = false;
  try {
    await navigator.clipboard.writeText(text.value);
    copied = true;
  } catch {
    /** @type {HTMLDetailsElement} */ (the("shown")).open = true;
    text.select();
  }
  the("sent").textContent = copied ? "The answers are copied." : "The answers are selected below. Copy them.";
}

/** Forget this rater, for the next one at the same device; a second press is needed. */
function another() {
  const one = button("another");
  const sure = "Press again to remove the answers of this person from this browser";
  if (one.textContent !== sure) {
    one.textContent = sure;
    return;
  }
  history.replaceState({ forgotten: given?.rater }, "");
  try {
    localStorage.removeItem(KEPT);
  } catch {
    // nothing was kept
  }
  location.reload();
}

// Wiring

/** @param {KeyboardEvent} event */
function pressed(event) {
  const side = SIDES.find((one) => LETTERS[one].toLowerCase() === event.key.toLowerCase());
  const typing = event.target instanceof HTMLInputElement && event.target.type === "text";
  if (shown && side && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) play(side);
}

for (const side of SIDES) {
  const one = video(side);
  button(`play-${side}`).addEventListener("click", () => play(side));
  one.addEventListener("play", () => {
    if (shown) shown.plays += 1;
    one.closest("figure")?.classList.add("playing");
  });
  for (const kind of ["pause", "ended"]) {
    one.addEventListener(kind, () => one.closest("figure")?.classList.remove("playing"));
  }
  one.addEventListener("ended", () => ended(side));
  one.addEventListener("error", () => {
    if (one.getAttribute("src")) trouble("This browser cannot show the clips, which are H.264 video. Try another browser.");
  });
}
the("welcome").addEventListener("submit", begin);
the("rating").addEventListener("submit", next);
the("questions").addEventListener("change", changed);
button("stop").addEventListener("click", end);
button("resume").addEventListener("click", proceed);
button("send").addEventListener("click", () => void send());
button("another").addEventListener("click", another);
button("copy").addEventListener("click", () => void copy());
document.addEventListener("keydown", pressed);
document.title = asked.title;
the("title").textContent = asked.title;
if (given) proceed();
else welcome();
document.documentElement.dataset.ready = "";
