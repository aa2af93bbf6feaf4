// Summary in words, and the table of all runs: sorted by any column, filtered by text and by the level of each factor.
function showSummary() {
  const words = at("summary-words");
  for (const part of DATA.summary) {
    if (!part.items.length) continue;
    element("h3", {}, part.title, words);
    words.append(bullets(part.items));
  }
  if (DATA.verdicts.rows.length) {
    element("h3", {}, W.verdicts, at("verdicts"));
    at("verdicts").append(table(DATA.verdicts, { label: W.verdicts }).node);
    element("p", { class: "caption" }, W.verdicts_caption, at("verdicts"));
  }
  element("h3", {}, W.provenance, at("facts"));
  at("facts").append(list(DATA.facts));
}

function showRuns(choose) {
  const controls = at("runs-filter");
  const text = element("input", { type: "search", id: "filter-text", "aria-label": W.filter, placeholder: W.filter, oninput: () => apply() }, null, controls);
  const levels = DATA.filters.map((filter) => {
    const options = [element("option", { value: "" }, W.all_levels)].concat(
      filter.levels.map((level, i) => element("option", { value: String(i) }, level)),
    );
    const select = element("select", { onchange: () => apply() }, options);
    element("label", {}, [filter.name, select], controls);
    return select;
  });
  const reset = element("button", { type: "button", onclick: () => clearAll() }, W.filter_clear, controls);
  const count = element("output", { "aria-live": "polite" }, "", controls);
  const haystack = DATA.overview.rows.map((row, i) =>
    row.map((cell, c) => cellText(cell, DATA.overview.columns[c])).concat(DATA.runs[i].notes).join(" ").toLocaleLowerCase(),
  );
  const keep = (row, i) =>
    text.value.toLocaleLowerCase().split(/\s+/).every((word) => haystack[i].includes(word)) &&
    levels.every((select, f) => select.value === "" || DATA.filters[f].of_run[i] === Number(select.value));
  const runs = table(DATA.overview, { label: W.runs, choose, keep, tall: true });
  function apply() {
    const shown = runs.refresh();
    count.textContent = fill(W.filter_count, { shown, all: DATA.runs.length });
    reset.disabled = !text.value && levels.every((select) => !select.value);
  }
  function clearAll() {
    text.value = "";
    for (const select of levels) select.value = "";
    apply();
  }
  apply();
  at("runs-table").append(runs.node);
  return runs;
}
