"use strict";
(() => {
  const one = (selector, root = document) => root.querySelector(selector);
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const picker = one("#picker");
  if (!picker) return;

  const { statuses, layers } = one(".picker").dataset;
  const STATUSES = statuses.split(" "), LAYERS = layers.split(" ");
  const map = one("#map"), ranked = one("#ranked"), silence = one("#silence");
  const slots = all("[data-part]"), options = all("option", picker);
  let rows = [];

  // The report that is shown

  const PARTS = picker.dataset.parts.split(" ");
  const stored = new Map(all("template[data-key]").map((t) => [t.dataset.key, t.content]));

  /** Put away the parts that the page came with, before others take their place. */
  function keep(slot) {
    const kept = document.createDocumentFragment();
    kept.append(...slot.childNodes);
    stored.set(slot.dataset.key, kept);
  }

  function show(option) {
    const keys = option.dataset.keys.split(" ");
    for (const slot of slots) {
      const key = keys[PARTS.indexOf(slot.dataset.part)];
      if (slot.dataset.key === key) continue;
      if (!stored.has(slot.dataset.key)) keep(slot);
      slot.replaceChildren(stored.get(key).cloneNode(true));
      slot.dataset.key = key;
    }
    paint(ranked, ...option.dataset.ranked.split(" "));
    paint(silence, ...option.dataset.silence.split(" "));
    const [codes, from] = option.dataset.ranked.split(" ");
    for (const cell of all("td[data-i]", map)) {
      const shade = cell.className.split(" ")[0];
      cell.className = `${shade} s${codes[cell.dataset.i]} l${from[cell.dataset.i]}`;
    }
    settle(option);
  }

  /** Do what every report needs once it stands there. */
  function settle(option) {
    rows = option.dataset.ranked.trim() ? byRank(ranked) : [];
    all("[data-report] button").forEach((button) => {
      const here = button.parentNode.dataset.report === option.value;
      here ? button.setAttribute("aria-current", "true") : button.removeAttribute("aria-current");
    });
    prepare();
    all("th[aria-sort]").forEach((head) => head.removeAttribute("aria-sort"));
    filter();
  }

  /** The rows of a ranking as they were before they were sorted. */
  function byRank(table) {
    const rank = (row) => Number(row.cells[0].textContent);
    return [...table.tBodies[0].rows].sort((a, b) => rank(a) - rank(b));
  }

  function paint(table, codes, from) {
    if (!codes) return;
    const found = byRank(table);
    table.tBodies[0].append(...found);
    [...codes].forEach((code, i) => {
      const [status, layer] = [found[i].cells[5], found[i].cells[6]];
      status.className = `s${code}`;
      status.firstChild.textContent = STATUSES[parseInt(code, 36)];
      layer.textContent = LAYERS[parseInt(from[i], 36)];
    });
  }

  const slug = (option) => `#${encodeURIComponent(option.textContent)}`;

  function follow() {
    const option = options.find((each) => slug(each) === location.hash);
    if (!option || option.selected) return;
    option.selected = true;
    show(option);
  }

  function choose(option) {
    option.selected = true;
    show(option);
    history.replaceState(null, "", slug(option));
  }

  picker.addEventListener("change", () => choose(picker.selectedOptions[0]));
  addEventListener("hashchange", follow);
  for (const cell of all("[data-report]")) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...cell.childNodes);
    button.setAttribute("aria-label", `${options[cell.dataset.report].textContent}: ${button.textContent}`);
    button.addEventListener("click", () => {
      choose(options[cell.dataset.report]);
      one("#report").scrollIntoView();
      one("#report").focus({ preventScroll: true });
    });
    cell.append(button);
  }

  // Search, filter, sort

  const search = one("#search"), found = one("#found"), filters = all(".filters button");

  function filter() {
    const sought = search.value.trim().toLowerCase();
    const wanted = filters.filter((b) => b.ariaPressed === "true").map((b) => b.textContent);
    let shown = 0;
    for (const row of rows) {
      const fits = wanted.includes(row.cells[5].textContent)
        && row.textContent.toLowerCase().includes(sought);
      row.hidden = !fits;
      shown += fits;
    }
    found.textContent = shown === rows.length ? `${shown} bigrams` : `${shown} of ${rows.length} bigrams`;
  }

  search.addEventListener("input", filter);
  for (const button of filters) {
    button.addEventListener("click", () => {
      button.ariaPressed = button.ariaPressed === "true" ? "false" : "true";
      filter();
    });
  }

  function sort(head) {
    const table = head.closest("table"), body = table.tBodies[0];
    const column = head.cellIndex, number = head.dataset.sort === "number";
    const down = head.ariaSort ? head.ariaSort === "ascending" : number && column > 0;
    const value = (row) => row.cells[column]?.textContent ?? "";
    const order = number
      ? (a, b) => Number(value(a).replaceAll(",", "")) - Number(value(b).replaceAll(",", ""))
      : (a, b) => value(a).localeCompare(value(b));
    const sorted = [...body.rows].sort((a, b) => (down ? -order(a, b) : order(a, b)));
    body.append(...sorted);
    all("th", table.tHead).forEach((other) => other.removeAttribute("aria-sort"));
    head.ariaSort = down ? "descending" : "ascending";
  }

  for (const head of all("th[data-sort]")) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sort(head));
    head.append(button);
  }

  // The map and the charts: what a place stands for

  const tip = document.createElement("div");
  tip.className = "tip";
  tip.setAttribute("role", "status");
  tip.hidden = true;
  document.body.append(tip);

  function tell(row, x, y) {
    const [rank, bigram, count, share, total, status, layer, word, places] = [...row.cells].map((c) => c.textContent);
    const name = document.createElement("b");
    name.textContent = bigram;
    const lines = [
      `  ${status}${layer === status ? "" : `, from ${layer}`}`,
      `\nspoken ${count} times, ${share} %`,
      `\nrank ${rank}, ${total} % so far`,
      word && `\nas in “${word}”`, places && `\n${places}`,
    ];
    tip.replaceChildren(name, lines.filter(Boolean).join(""));
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    tip.style.left = `${Math.max(8, Math.min(x + 14, innerWidth - box.width - 8))}px`;
    tip.style.top = `${y + 18 + box.height > innerHeight ? y - box.height - 12 : y + 18}px`;
  }

  const hush = () => { tip.hidden = true; all(".point").forEach((point) => point.remove()); };

  function prepare() {
    hush();
    all("td[title]", map).forEach((cell, number) => {
      cell.ariaLabel = cell.title;
      cell.removeAttribute("title");
      cell.tabIndex = number ? -1 : 0;
    });
  }

  map.addEventListener("focusout", hush);
  map.addEventListener("focusin", (event) => {
    const cell = event.target.closest("td[data-i]");
    if (!cell) return;
    const box = cell.getBoundingClientRect();
    tell(rows[cell.dataset.i], box.right - 14, box.bottom - 12);
  });

  const STEPS = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };
  map.addEventListener("keydown", (event) => {
    const cell = event.target.closest("td[data-i]"), step = STEPS[event.key];
    if (event.key === "Escape") hush();
    if (!cell || !step) return;
    event.preventDefault();
    const table = cell.closest("table");
    let [y, x] = [cell.parentNode.rowIndex + step[0], cell.cellIndex + step[1]];
    while (table.rows[y]?.cells[x] && !table.rows[y].cells[x].dataset.i) { y += step[0]; x += step[1]; }
    const next = table.rows[y]?.cells[x];
    if (!next?.dataset.i) return;
    cell.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });

  for (const input of all("input[name=colour]")) {
    input.addEventListener("change", () => { map.dataset.colour = input.value; });
  }

  function at(plot, x) {
    const box = plot.getBoundingClientRect();
    const place = Math.floor((x - box.left) / box.width * rows.length);
    if (!rows[place]) return undefined;
    const point = document.createElement("span");
    point.className = "point";
    point.style.left = `${(place + 0.5) / rows.length * 100}%`;
    plot.append(point);
    return rows[place];
  }

  document.addEventListener("pointermove", (event) => {
    if (!event.movementX && !event.movementY) return; // the page moved, not the pointer
    const { target, clientX, clientY } = event;
    hush();
    const cell = target.closest("#map td[data-i]"), plot = target.closest(".plot");
    const row = cell ? rows[cell.dataset.i] : plot && at(plot, clientX);
    if (row) tell(row, clientX, clientY);
  });

  all(".picker, .tools, .switch").forEach((control) => { control.hidden = false; });
  picker.selectedIndex = 0;
  settle(options[0]);
  follow();
})();
