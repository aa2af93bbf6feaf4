// Responses: verdicts and coefficients of one at a time, its effects as bars in the order of their size.
const regression = (() => {
  let panel;
  let chosen = 0;
  const tabs = [];

  function show() {
    const body = at("regression-body");
    if (!DATA.responses.length) return body.append(element("p", { class: "empty" }, W.no_regression));
    const bar = element("div", { class: "tabs", role: "tablist", "aria-label": W.response }, null, body);
    DATA.responses.forEach((response, i) => {
      const tab = element("button", { type: "button", role: "tab", id: `response-${i}`, "aria-controls": "response", onclick: () => choose(i) }, response.name, bar);
      tab.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (!step) return;
        event.preventDefault();
        event.stopPropagation();
        const n = tabs.length;
        choose((chosen + step + n) % n);
        tabs[chosen].focus();
      });
      tabs.push(tab);
    });
    panel = element("div", { role: "tabpanel", id: "response", class: "response" }, null, body);
    choose(0);
    showParts(DATA.beyond, body);
  }

  function choose(i) {
    chosen = i;
    tabs.forEach((tab, k) => {
      tab.setAttribute("aria-selected", String(k === i));
      tab.setAttribute("tabindex", k === i ? "0" : "-1");
    });
    panel.setAttribute("aria-labelledby", `response-${i}`);
    draw();
  }

  function draw() {
    if (panel) drawOne(DATA.responses[chosen], clear(panel), "bars");
  }

  // On paper nothing can be switched: the other responses follow the one that is shown.
  function print(others) {
    if (!panel) return;
    for (const old of panel.querySelectorAll(".response")) old.remove();
    if (!others) return;
    DATA.responses.forEach((response, i) => {
      if (i !== chosen) drawOne(response, element("div", { class: "response" }, null, panel), `bars-${i}`);
    });
  }

  function drawOne(response, panel, id) {
    element("h3", {}, response.name, panel);
    if (response.failure) return element("p", {}, response.failure, panel);
    const two = element("div", { class: "two" }, element("div", {}, bullets(response.words)), panel);
    const right = element("figure", {}, element("figcaption", {}, response.bars_title), two);
    bars(element("div", { class: "chart", id }, null, right), response);
    panel.append(table(response.coefficients, { label: W.coefficients }).node);
    element("p", { class: "caption" }, response.caption, panel);
    if (response.verdicts.rows.length) {
      element("h3", {}, W.tests, panel);
      panel.append(table(response.verdicts, { label: W.tests, sortable: false }).node);
    }
    element("p", { class: "equation" }, [element("strong", {}, W.equation), " ", response.equation], panel);
    if (response.notes) element("p", {}, response.notes, panel);
  }

  function bars(holder, response) {
    const list = response.bars;
    const width = roomOf(holder);
    const pitch = 24;
    const height = 24 + pitch * list.length + 34;
    const longest = Math.max(...list.map((bar) => bar.term.length), 4);
    const left = Math.min(0.5 * width, 14 + 6.4 * longest);
    const most = 1.12 * Math.max(response.line ?? 0, ...list.map((bar) => bar.size));
    const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, role: "group", "aria-label": response.bars_title }, holder);
    const sx = (v) => left + (v / (most || 1)) * (width - left - 12);
    const [top, bottom] = [20, 20 + pitch * list.length];
    const marks = ticks(0, most || 1, Math.max(2, (width - left) / 70));
    for (const v of marks.found) {
      shape("line", { class: "grid", x1: sx(v), x2: sx(v), y1: top, y2: bottom }, svg);
      shape("text", { x: sx(v), y: bottom + 14, "text-anchor": "middle" }, svg, number(v, marks.decimals));
    }
    list.forEach((bar, i) => {
      const y = top + pitch * i;
      shape("text", { x: left - 6, y: y + pitch / 2 + 4, "text-anchor": "end" }, svg, bar.term);
      const rect = shape("rect", {
        class: "hot", x: left, y: y + 4, width: Math.max(1, sx(bar.size) - left), height: pitch - 8,
        fill: bar.significant ? "#0072b2" : "#fff", stroke: bar.significant ? "#0072b2" : "#6e6e6e",
      }, svg);
      tip.on(rect, bar.about.join("\n"));
    });
    if (response.line) {
      shape("line", { x1: sx(response.line), x2: sx(response.line), y1: top - 4, y2: bottom, stroke: "#d55e00", "stroke-width": 1.5, "stroke-dasharray": "5 3" }, svg);
      const beyond = sx(response.line) > (left + width) / 2;
      shape("text", { class: "quiet", x: sx(response.line) + (beyond ? -4 : 4), y: 11, "text-anchor": beyond ? "end" : "start" }, svg, response.line_words);
    }
    shape("path", { class: "axis", d: `M${left},${top}V${bottom}` }, svg);
    shape("text", { class: "quiet", x: (left + width) / 2, y: height - 4, "text-anchor": "middle" }, svg, response.bars_axis);
  }
  return { show, draw, print };
})();
