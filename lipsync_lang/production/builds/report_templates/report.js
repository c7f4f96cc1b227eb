"use strict";
(() => {
  const one = (selector, root = document) => root.querySelector(selector);
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const body = one(".worst tbody");
  if (!body) return;

  const rows = [...body.rows], found = one("#found");
  const choices = { language: one("#language"), character: one("#character"), figure: one("#figure") };
  const search = one("#search");
  const words = new Map(rows.map((row) => [row, row.textContent.toLowerCase()]));

  // Filter

  function filter() {
    const sought = search.value.trim().toLowerCase();
    const { language, character, figure } = choices;
    let shown = 0;
    for (const row of rows) {
      const fits = (!language.value || row.cells[2].textContent === language.value)
        && (!character.value || row.cells[3].textContent === character.value)
        && (!figure.value || row.dataset.figures.split("|").includes(figure.value))
        && words.get(row).includes(sought);
      row.hidden = !fits;
      shown += fits;
    }
    found.textContent = shown === rows.length ? `${shown} lines` : `${shown} of ${rows.length} lines`;
  }

  search.addEventListener("input", filter);
  Object.values(choices).forEach((choice) => choice.addEventListener("change", filter));

  /** Set the filters and go to the rows. */
  function choose(wanted) {
    for (const [name, choice] of Object.entries(choices)) choice.value = wanted[name] ?? "";
    search.value = "";
    filter();
    one("#worst").scrollIntoView();
    one("#worst").focus({ preventScroll: true });
  }

  function pressed(cell, label, press) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...cell.childNodes);
    if (label) button.setAttribute("aria-label", label);
    button.addEventListener("click", press);
    cell.append(button);
    return button;
  }

  for (const cell of all("#matrix td[data-language]")) {
    const { language, character } = cell.dataset;
    cell.dataset.report = "";
    pressed(cell, `${language} on ${character}: ${cell.textContent}`, () => choose({ language, character }));
  }
  for (const cell of all("[data-figure]")) {
    if (![...choices.figure.options].some((option) => option.value === cell.dataset.figure)) continue;
    pressed(cell, "", () => choose({ figure: cell.dataset.figure }));
  }

  // Sort

  const value = {
    rank: (row) => Number(row.cells[0].textContent),
    number: (row, column) => parseFloat(row.cells[column].textContent),
    text: (row, column) => row.cells[column].textContent,
  };

  function sort(head) {
    const kind = head.dataset.sort, column = head.cellIndex;
    const down = head.ariaSort === "ascending";
    const keys = new Map(rows.map((row) => [row, value[kind](row, column)]));
    const order = kind === "text"
      ? (a, b) => keys.get(a).localeCompare(keys.get(b), undefined, { numeric: true })
      : (a, b) => keys.get(a) - keys.get(b);
    const known = rows.filter((row) => !Number.isNaN(keys.get(row)));
    const rest = rows.filter((row) => Number.isNaN(keys.get(row)));
    body.append(...known.sort((a, b) => (down ? -order(a, b) : order(a, b))), ...rest);
    all("th", head.parentNode).forEach((other) => other.removeAttribute("aria-sort"));
    head.ariaSort = down ? "descending" : "ascending";
  }

  for (const head of all("th[data-sort]")) pressed(head, "", () => sort(head));

  // Copy the command of a line without a page

  for (const cell of all("[data-command]")) {
    const { command } = cell.dataset;
    const button = pressed(cell, `Copy the command that writes the page of ${cell.textContent}`, async () => {
      try {
        await navigator.clipboard.writeText(command);
        found.textContent = `Copied: ${command}`;
      } catch {
        prompt("The command that writes the page of this line:", command);
      }
    });
    button.title = command;
  }

  one(".tools").hidden = false;
  filter();
})();
