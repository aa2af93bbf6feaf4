// One hem three ways: from above, unrolled round its centre, and as distances along the outline; one cursor through all three.
const hem = (() => {
  const CURVES = ["measured", "fitted", "predicted", "free", "whiskers"];
  const shown = { measured: true, fitted: true, predicted: true, free: false, whiskers: true };
  const boxes = {};
  let magnified = null;
  let slider, said;
  let now = null; // the curves of the run that is shown, mm
  let cursor = -1;
  let charts = [];

  function controls(holder) {
    for (const name of CURVES) {
      const box = element("input", { type: "checkbox", onchange: () => ((shown[name] = box.checked), draw()) });
      box.checked = shown[name];
      const key = shape("svg", { class: "key", viewBox: "0 0 22 10", "aria-hidden": "true" });
      if (name === "measured") [3, 11, 19].forEach((x) => shape("circle", { class: "measured", cx: x, cy: 5, r: 1.9 }, key));
      else shape("path", { class: name === "whiskers" ? "whisker" : name, d: name === "whiskers" ? "M3,9V1M8,9V3M13,9V2M18,9V4" : "M0,5H22" }, key);
      boxes[name] = element("label", {}, [box, key, W[name]], holder);
      boxes[name].box = box;
    }
    slider = element("input", { type: "range", min: 1, max: 50, step: 1, value: 1, oninput: () => ((magnified = Number(slider.value)), draw()) });
    said = element("output", {}, "");
    element("label", {}, [W.magnified, slider, said], holder);
  }

  function load(run) {
    const raw = run.hem;
    cursor = -1;
    now = null;
    if (raw) {
      const curve = (name) => (raw[name] ? points(raw[name], DATA.step) : []);
      now = { raw, measured: curve("measured"), feet: curve("feet"), fitted: curve("fitted"), predicted: curve("predicted"), free: curve("free") };
      now.index = unpacked(raw.index, 1, 1);
      now.distance = raw.distance ? raw.distance.map((d) => d * DATA.step) : [];
      magnified = raw.magnified;
    }
    for (const name of CURVES) {
      const there = now && (name === "whiskers" ? now.feet.length : now[name].length) > 0;
      boxes[name].box.disabled = !there;
      boxes[name].hidden = !there;
    }
    slider.parentNode.hidden = boxes.whiskers.hidden;
    draw();
  }

  const polar = ([x, y]) => [Math.hypot(x - now.raw.centre[0], y - now.raw.centre[1]), Math.atan2(y - now.raw.centre[1], x - now.raw.centre[0])];
  const degrees = (angle) => ((angle * 180) / Math.PI + 360) % 360;
  const has = (name) => shown[name] && now[name].length > 0;

  function draw() {
    charts = [];
    if (!now) {
      for (const id of ["plan", "unrolled", "distance"]) clear(at(id)).append(element("p", { class: "empty" }, W.no_profile));
      at("readout").textContent = "";
      return;
    }
    slider.value = String(magnified);
    said.textContent = `× ${magnified}`;
    plan();
    unrolled();
    distances();
    point(cursor);
  }

  function plan() {
    const width = roomOf(at("plan"));
    const half = 1.06 * now.raw.reach;
    const [cx, cy] = now.raw.centre;
    const view = chart(at("plan"), {
      width, height: width, x: [cx - half, cx + half], y: [cy - half, cy + half], xLabel: W.x_axis, yLabel: W.y_axis,
      left: 48, bottom: 36, right: 14, top: 10, label: W.plan_label, focus: true, xTicks: 6, yTicks: 6,
    });
    const { plot, sx, sy } = view;
    shape("path", { class: "axis", d: `M${sx(cx) - 6},${sy(cy)}h12M${sx(cx)},${sy(cy) - 6}v12` }, plot);
    if (now.raw.support) {
      const r = sx(now.raw.support) - sx(0);
      shape("circle", { cx: sx(cx), cy: sy(cy), r, fill: "none", stroke: "#8a8a8a", "stroke-dasharray": "2 3" }, plot);
      shape("text", { class: "quiet", x: sx(cx), y: sy(cy) + 20, "text-anchor": "middle" }, plot, W.support);
    }
    if (shown.whiskers && now.feet.length) {
      const d = now.feet.map(([fx, fy], i) => {
        const [mx, my] = now.measured[i];
        return `M${sx(fx).toFixed(1)},${sy(fy).toFixed(1)}L${sx(fx + magnified * (mx - fx)).toFixed(1)},${sy(fy + magnified * (my - fy)).toFixed(1)}`;
      });
      shape("path", { class: "whisker", d: d.join("") }, plot);
    }
    for (const name of ["predicted", "free", "fitted"]) if (has(name)) shape("path", { class: name, d: path(now[name], sx, sy, true) }, plot);
    if (has("measured")) marks(plot, now.measured, sx, sy, true);
    follow(view, now.measured);
  }

  // Dots, or a line where dots would run into each other.
  function marks(plot, list, sx, sy, closed) {
    if (list.length > 260) return shape("path", { class: "measured-line", d: path(list, sx, sy, closed) }, plot);
    const r = 1.9;
    const d = list.map(([x, y]) => `M${(sx(x) - r).toFixed(1)},${sy(y).toFixed(1)}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0`);
    return shape("path", { class: "measured", d: d.join("") }, plot);
  }

  // Angle against radius, turned so that the curve begins at 0°; where it runs backwards (overhang) it is drawn so.
  function laid(list) {
    let before = null;
    const out = list.map((p) => {
      let [r, angle] = polar(p);
      if (before !== null) while (angle - before > Math.PI) angle -= 2 * Math.PI;
      if (before !== null) while (angle - before < -Math.PI) angle += 2 * Math.PI;
      before = angle;
      return [(angle * 180) / Math.PI, r];
    });
    const shift = Math.floor(out[0][0] / 360) * 360;
    return out.map(([a, r]) => [a - shift, r]);
  }
  function unrolled() {
    const width = roomOf(at("unrolled"));
    const radii = [...now.measured, ...now.fitted, ...now.predicted].map((p) => polar(p)[0]);
    const [low, high] = [Math.min(...radii), Math.max(...radii)];
    const room = 0.06 * (high - low || high);
    const view = chart(at("unrolled"), {
      width, height: Math.round(Math.max(190, Math.min(260, 0.3 * width))), x: [0, 360], y: [low - room, high + room], xLabel: W.angle_axis, yLabel: W.radius_axis,
      label: W.unrolled_label, focus: true, xNames: (v) => `${v}°`, xStep: width > 700 ? 30 : 60,
    });
    const { plot, sx, sy } = view;
    const round = (name, attributes) => {
      const curve = laid(now[name]);
      const [a, r] = curve[0];
      const closed = curve.concat([[a + (curve[curve.length - 1][0] >= a ? 360 : -360), r]]);
      for (const turn of [-360, 0, 360]) shape("path", { ...attributes, d: path(closed.map(([x, y]) => [x + turn, y]), sx, sy) }, plot);
    };
    for (const name of ["predicted", "free", "fitted"]) if (has(name)) round(name, { class: name });
    const flat = now.measured.map((p) => [degrees(polar(p)[1]), polar(p)[0]]);
    if (has("measured")) now.measured.length > 260 ? round("measured", { class: "measured-line" }) : marks(plot, flat, sx, sy);
    follow(view, flat);
  }

  function distances() {
    const holder = at("distance");
    if (!now.distance.length) return clear(holder).append(element("p", { class: "empty" }, W.no_distances));
    const along = [0];
    for (let i = 1; i < now.measured.length; i++) {
      const [[a, b], [c, d]] = [now.measured[i - 1], now.measured[i]];
      along.push(along[i - 1] + Math.hypot(c - a, d - b));
    }
    const end = along[along.length - 1];
    const rms = now.raw.rms;
    const most = 1.08 * Math.max(1.3 * rms, ...now.distance.map(Math.abs));
    const width = roomOf(holder);
    const view = chart(holder, {
      width, height: Math.round(Math.max(170, Math.min(220, 0.25 * width))), x: [0, end], y: [-most, most], xLabel: W.along_axis, yLabel: W.distance_axis,
      label: W.distance_label, focus: true, top: 18,
    });
    const { plot, sx, sy } = view;
    const list = now.distance.map((d, i) => [along[i], d]);
    shape("path", { d: path(list.concat([[end, 0], [0, 0]]), sx, sy, true), fill: "#56b4e9", "fill-opacity": 0.35 }, plot);
    shape("line", { class: "axis", x1: sx(0), x2: sx(end), y1: sy(0), y2: sy(0) }, plot);
    for (const side of [-rms, rms]) {
      shape("line", { x1: sx(0), x2: sx(end), y1: sy(side), y2: sy(side), stroke: "#6e6e6e", "stroke-dasharray": "4 3" }, plot);
    }
    shape("text", { class: "quiet", x: sx(end), y: 11, "text-anchor": "end" }, view.svg, fill(W.rms_line, { rms: number(rms, 2) }));
    shape("path", { d: path(list, sx, sy), stroke: "#0072b2", "stroke-width": 1.3, fill: "none" }, plot);
    follow(view, list);
  }

  // Pointer and arrow keys move the cursor to a measured point, in whichever chart they are.
  function follow(view, list) {
    const mark = shape("circle", { class: "cursor", r: 5.5, visibility: "hidden" }, view.plot);
    charts.push({ view, list, mark });
    const screen = list.map(([x, y]) => [view.sx(x), view.sy(y)]);
    view.svg.addEventListener("pointermove", (event) => {
      const [px, py] = place(view.svg, event, view.width, view.height);
      let [best, least] = [-1, Infinity];
      screen.forEach(([x, y], i) => {
        const d = (x - px) ** 2 + (y - py) ** 2;
        if (d < least) [best, least] = [i, d];
      });
      point(best);
    });
    view.svg.addEventListener("keydown", (event) => {
      const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!steps) return;
      event.preventDefault();
      event.stopPropagation();
      const n = now.measured.length;
      point(cursor < 0 ? 0 : (cursor + steps + n) % n);
    });
  }
  function point(i) {
    cursor = i;
    for (const { view, list, mark } of charts) {
      if (i < 0) mark.setAttribute("visibility", "hidden");
      else {
        mark.setAttribute("visibility", "visible");
        mark.setAttribute("cx", view.sx(list[i][0]));
        mark.setAttribute("cy", view.sy(list[i][1]));
      }
    }
    if (i < 0) return (at("readout").textContent = W.readout_hint);
    const [x, y] = now.measured[i];
    const [r, angle] = polar(now.measured[i]);
    const said = { n: now.index[i], x: number(x, 2), y: number(y, 2), r: number(r, 2), angle: number(degrees(angle), 1) };
    at("readout").textContent =
      fill(W.readout, said) + (now.distance.length ? fill(W.readout_distance, { d: signed(now.distance[i], 2) }) : "");
  }
  return { controls, load, draw, get hemPoints() { return now ? now.measured.map(([x, y]) => [x - now.raw.centre[0], y - now.raw.centre[1]]) : []; } };
})();
