// Theory against measurement: predicted over fitted with the line of agreement, every dot a way to its run; the fidelities side by side.
const theory = (() => {
  let holders = [];

  function show(jump) {
    const body = at("theory-body");
    const all = DATA.theory;
    if (!all) return body.append(bullets(DATA.theory_missing.length ? DATA.theory_missing : [W.no_theory]));
    body.append(bullets(all.words));
    const three = element("div", { class: "three" }, null, body);
    holders = all.scatters.map((scatter, i) => {
      const figure = element("figure", {}, element("figcaption", {}, scatter.label), three);
      return element("div", { class: "chart", id: `scatter-${i}` }, null, figure);
    });
    element("p", { class: "caption" }, W.scatter_caption, body);
    showParts(all.parts, body, jump);
    theory.jump = jump;
    draw();
  }

  function draw() {
    holders.forEach((holder, i) => scatter(holder, DATA.theory.scatters[i]));
  }

  function scatter(holder, { points: list, unit, label, whole }) {
    const values = list.flatMap(({ x, y }) => [x, y]);
    if (!values.length) return clear(holder).append(element("p", { class: "empty" }, W.no_theory));
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const room = whole ? 0.7 : 0.07 * (high - low || 1);
    const range = [low - room, high + room];
    const width = Math.min(420, roomOf(holder));
    // Folds are counted in whole numbers.
    const step = whole ? Math.max(1, Math.round((high - low) / 8)) : undefined;
    const axis = (word) => (unit ? `${word}, ${unit}` : word);
    const { plot, sx, sy } = chart(holder, { width, height: width, x: range, y: range, xLabel: axis(W.fitted), yLabel: axis(W.predicted), label, xTicks: 5, yTicks: 5, xStep: step, yStep: step, left: 50 });
    shape("line", { x1: sx(range[0]), y1: sy(range[0]), x2: sx(range[1]), y2: sy(range[1]), stroke: "#6e6e6e", "stroke-width": 1.2 }, plot);
    // What coincides is one disc, as large as it has runs.
    const groups = new Map();
    for (const point of list) {
      const key = `${point.x} ${point.y}`;
      groups.set(key, [...(groups.get(key) ?? []), point]);
    }
    for (const group of groups.values()) {
      const [{ x, y }] = group;
      const names = group.map(({ run }) => DATA.runs[run].id).join(", ");
      const decimals = whole ? 0 : 1;
      const text = fill(W.scatter_point, { runs: names, fitted: number(x, decimals), predicted: number(y, decimals), unit });
      const r = whole ? 4 + 2.2 * Math.sqrt(group.length) : 4;
      const dot = shape("circle", { class: "hot", cx: sx(x), cy: sy(y), r, fill: "#0072b2", "fill-opacity": whole ? 0.25 : 0.75, stroke: "#0072b2" }, plot);
      if (whole) shape("text", { x: sx(x), y: sy(y) + 4, "text-anchor": "middle", "pointer-events": "none" }, plot, String(group.length));
      tip.on(dot, text, () => theory.jump(group[0].run));
    }
  }
  return { show, draw, jump: null };
})();
