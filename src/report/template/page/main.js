// The page: which run is shown (the address keeps it), how one gets about by keyboard, what is opened for print.
const page = (() => {
  let runs = null;
  let current = -1;
  let select, before, after, place;
  const builders = [];
  const SHORT = 700; // cells of a table that is printed without being asked for: a page of them

  function start() {
    showSummary();
    runs = showRuns((index) => jump(index));
    controls();
    hem.controls(at("plan-controls"));
    skirt.controls(at("skirt-controls"));
    if (DATA.irregular) showParts(DATA.irregular, at("folds-body"), jump);
    else at("folds").remove();
    regression.show();
    theory.show(jump);
    tables();
    contents();
    show(named() ?? 0, false);
    window.addEventListener("hashchange", () => {
      const index = named();
      if (index !== null && index !== current) show(index, false);
    });
    document.addEventListener("keydown", keys);
    let waiting = 0;
    window.addEventListener("resize", () => {
      cancelAnimationFrame(waiting);
      waiting = requestAnimationFrame(redraw);
    });
    // What is open is printed; of what is closed, what is short.
    let opened = [];
    window.addEventListener("beforeprint", () => {
      opened = [...document.querySelectorAll("details:not([open])")].filter((details) => Number(details.dataset.cells) <= SHORT);
      for (const details of opened) details.open = true;
      builders.filter(({ details }) => details.open).forEach(({ build }) => build());
      regression.print(true);
      printing = true;
      hem.draw();
    });
    window.addEventListener("afterprint", () => {
      for (const details of opened) details.open = false;
      regression.print(false);
      printing = false;
      hem.draw();
    });
  }

  function redraw() {
    hem.draw();
    skirt.draw();
    regression.draw();
    theory.draw();
  }

  // The run in the address; null where there is none or it is not known.
  function named() {
    const found = /(?:^#|&)run=([^&]*)/.exec(location.hash);
    if (!found) return null;
    let id = found[1];
    try {
      id = decodeURIComponent(id);
    } catch {
      return null;
    }
    const index = DATA.runs.findIndex((run) => run.id === id);
    return index < 0 ? null : index;
  }

  function controls() {
    const holder = at("run-switch");
    before = element("button", { type: "button", onclick: () => show(current - 1), "aria-label": W.previous_run }, `‹ ${W.previous}`, holder);
    select = element("select", { id: "run-select", onchange: () => show(Number(select.value)) });
    DATA.runs.forEach((run, i) => element("option", { value: String(i) }, run.id, select));
    element("label", {}, [W.run, select], holder);
    after = element("button", { type: "button", onclick: () => show(current + 1), "aria-label": W.next_run }, `${W.next} ›`, holder);
    place = element("output", { "aria-live": "polite" }, "", holder);
    element("span", { class: "about" }, W.run_keys, holder);
  }

  function show(index, remember = true) {
    if (!(index >= 0 && index < DATA.runs.length)) return;
    current = index;
    const run = DATA.runs[index];
    select.value = String(index);
    before.disabled = index === 0;
    after.disabled = index === DATA.runs.length - 1;
    place.textContent = fill(W.position, { n: index + 1, all: DATA.runs.length });
    at("run-head").textContent = fill(W.run_head, { id: run.id });
    at("treatment").textContent = run.treatment;
    clear(at("run-notes")).append(...run.notes.map((note) => element("li", {}, note)));
    clear(at("numbers")).append(table(run.numbers, { label: W.numbers, sortable: false }).node);
    if (run.folds.rows.length) {
      const details = element("details", { "data-cells": 0 }, element("summary", {}, [W.folds_of_run, element("span", { class: "count" }, String(run.folds.rows.length))]), at("numbers"));
      details.append(table(run.folds, { label: W.folds_of_run }).node);
    }
    hem.load(run);
    skirt.load(run);
    runs.mark(index);
    document.body.dataset.run = run.id;
    if (!remember) return;
    try {
      history.replaceState(null, "", `#run=${encodeURIComponent(run.id)}`);
    } catch {
      // A viewer that shows the page within its own may forbid it; the page works without.
    }
  }

  // As show, and the run comes into view.
  function jump(index) {
    show(index);
    go("run");
  }
  function go(id) {
    at(id).scrollIntoView({ block: "start" });
    at(`${id}-head`)?.focus({ preventScroll: true });
  }

  function keys(event) {
    if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return;
    if (event.target.classList?.contains("scroll")) return;
    if (event.target.closest?.("input, select, textarea, canvas, svg, .scroll table button")) return;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    show(current + step);
  }

  function contents() {
    for (const section of document.querySelectorAll("main > section")) {
      const name = section.id === "run" ? W.run : section.querySelector("h2").textContent;
      element("a", { href: `#${section.id}`, onclick: (event) => (event.preventDefault(), go(section.id)) }, name, at("contents"));
    }
  }

  // A table is built when it is first opened: most never are.
  function tables() {
    for (const item of DATA.tables) {
      const count = element("span", { class: "count" }, fill(W.rows, { n: item.table.rows.length }));
      const details = element("details", { id: `table-${item.id}`, "data-cells": item.table.rows.length * item.table.columns.length }, element("summary", {}, [item.title, count]), at("tables-body"));
      let built = false;
      const build = () => {
        if (built) return;
        built = true;
        if (item.about) element("p", { class: "about" }, item.about, details);
        details.append(table(item.table, { label: item.title, tall: item.table.rows.length > 18 }).node);
      };
      details.addEventListener("toggle", build);
      builders.push({ details, build });
    }
  }
  return { start };
})();
page.start();
