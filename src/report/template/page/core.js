// What every part needs: the data, elements, numbers, curves unpacked, charts with axes, the tip beside the pointer.
const DATA = JSON.parse(document.getElementById("data").textContent);
// What many runs say alike is sent once: heads of tables, and [i] for the i-th text.
const told = (cell) => (Array.isArray(cell) && cell.length === 1 ? DATA.texts[cell[0]] : cell);
for (const run of DATA.runs) {
  for (const name of ["numbers", "folds"]) run[name] = { columns: DATA.run_columns[name], rows: run[name].map((row) => row.map(told)) };
  for (const surface of run.surfaces) surface.about = told(surface.about);
}
const W = DATA.words;
const SVG = "http://www.w3.org/2000/svg";
const at = (id) => document.getElementById(id);

// A word with its blanks filled: fill("‹n› of ‹all›", {n: 3, all: 40}).
const fill = (word, values) => word.replace(/‹(\w+)›/g, (whole, name) => (name in values ? values[name] : whole));

// Text is always a text node: whatever a user wrote is shown, never parsed.
function add(parent, node, children) {
  for (const child of [].concat(children ?? [])) {
    if (child !== null && child !== undefined) node.append(child);
  }
  if (parent) parent.append(node);
  return node;
}
function element(name, attributes, children, parent) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes ?? {})) {
    if (value === false || value === null || value === undefined) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else node.setAttribute(key, value === true ? "" : value);
  }
  return add(parent, node, children);
}
function shape(name, attributes, parent, text) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes ?? {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined) node.setAttribute(key, value);
  }
  if (text !== undefined) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}
const clear = (node) => (node.replaceChildren(), node);
const bullets = (items) => element("ul", {}, items.map((item) => element("li", {}, item)));

// The true minus, and the decimals asked: numbers come rounded.
function number(value, decimals) {
  const text = Math.abs(value).toFixed(decimals);
  return (value < 0 && /[1-9]/.test(text) ? "−" : "") + text.replace(".", DATA.decimal);
}
const signed = (value, decimals) => (value > 0 && /[1-9]/.test(value.toFixed(decimals)) ? "+" : "") + number(value, decimals);

// Curves and fields are sent as differences of whole steps, `width` numbers to a point.
function unpacked(packed, width, step) {
  const values = new Float64Array(packed.length);
  for (let i = 0; i < packed.length; i++) values[i] = packed[i] + (i < width ? 0 : values[i - width]);
  for (let i = 0; i < values.length; i++) values[i] *= step;
  return values;
}
function points(packed, step) {
  const values = unpacked(packed, 2, step);
  return Array.from({ length: values.length / 2 }, (_, i) => [values[2 * i], values[2 * i + 1]]);
}

// Round numbers between low and high, about `wanted` of them.
function ticks(low, high, wanted, given) {
  const raw = (high - low) / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = given ?? [1, 2, 5, 10].map((f) => f * power).find((s) => s >= raw * 0.999);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return { found, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

// A chart with axes: scales, the group to draw in, and the size in pixels.
function chart(holder, { width, height, x, y, xLabel, yLabel, label, left = 52, bottom = 38, top = 8, right = 16, xTicks, yTicks, xStep, yStep, xNames, focus }) {
  const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, role: focus ? "application" : "img", "aria-label": label });
  if (focus) svg.setAttribute("tabindex", "0");
  const span = ([low, high]) => (high > low ? [low, high] : [low - 1, high + 1]);
  const [x0, x1] = span(x);
  const [y0, y1] = span(y);
  const sx = (v) => left + ((v - x0) / (x1 - x0)) * (width - left - right);
  const sy = (v) => height - bottom - ((v - y0) / (y1 - y0)) * (height - top - bottom);
  const xs = ticks(x0, x1, xTicks ?? Math.max(2, width / 90), xStep);
  const ys = ticks(y0, y1, yTicks ?? Math.max(2, height / 55), yStep);
  for (const v of xs.found) {
    shape("line", { class: "grid", x1: sx(v), x2: sx(v), y1: top, y2: height - bottom }, svg);
    shape("text", { x: sx(v), y: height - bottom + 15, "text-anchor": "middle" }, svg, xNames ? xNames(v) : number(v, xs.decimals));
  }
  for (const v of ys.found) {
    shape("line", { class: "grid", x1: left, x2: width - right, y1: sy(v), y2: sy(v) }, svg);
    shape("text", { x: left - 6, y: sy(v) + 4, "text-anchor": "end" }, svg, number(v, ys.decimals));
  }
  shape("path", { class: "axis", d: `M${left},${top}V${height - bottom}H${width - right}` }, svg);
  shape("text", { class: "quiet", x: (left + width - right) / 2, y: height - 5, "text-anchor": "middle" }, svg, xLabel);
  const middle = (top + height - bottom) / 2;
  shape("text", { class: "quiet", x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }, svg, yLabel);
  const clip = `clip-${holder.id}`;
  const inner = shape("clipPath", { id: clip }, shape("defs", {}, svg));
  shape("rect", { x: left, y: top, width: width - left - right, height: height - top - bottom }, inner);
  const plot = shape("g", { "clip-path": `url(#${clip})` }, svg);
  clear(holder).append(svg);
  return { svg, plot, sx, sy, width, height, left, right, top, bottom };
}
const path = (list, sx, sy, closed) =>
  "M" + list.map(([x, y]) => `${sx(x).toFixed(1)},${sy(y).toFixed(1)}`).join("L") + (closed ? "Z" : "");

// Where a pointer is on a chart, in its own pixels.
function place(svg, event, width, height) {
  const box = svg.getBoundingClientRect();
  return [((event.clientX - box.left) * width) / box.width, ((event.clientY - box.top) * height) / box.height];
}

// The box beside the pointer, or beside an element that has the focus.
const tip = {
  show(text, x, y) {
    const box = at("tip");
    box.textContent = text;
    box.hidden = false;
    const right = Math.min(x + 14, window.innerWidth - box.offsetWidth - 8);
    const below = y + 18 + box.offsetHeight > window.innerHeight ? y - box.offsetHeight - 10 : y + 18;
    box.style.left = `${Math.max(4, right)}px`;
    box.style.top = `${Math.max(4, below)}px`;
  },
  hide() {
    at("tip").hidden = true;
  },
  // Makes an element tell `text` to pointer and keyboard, and act on a click or Enter.
  on(node, text, act) {
    const beside = () => {
      const box = node.getBoundingClientRect();
      tip.show(text, box.right, box.top);
    };
    node.setAttribute("tabindex", "0");
    node.setAttribute("role", act ? "button" : "img");
    node.setAttribute("aria-label", text.replace(/\n/g, ", "));
    node.addEventListener("mousemove", (event) => tip.show(text, event.clientX, event.clientY));
    node.addEventListener("mouseleave", tip.hide);
    node.addEventListener("focus", beside);
    node.addEventListener("blur", tip.hide);
    if (!act) return;
    node.addEventListener("click", () => (tip.hide(), act()));
    node.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      tip.hide();
      act();
    });
  },
};
// Width of a chart's drawing, pixels. On paper it is that of the column, whatever the window: a drawing for a telephone would be printed in giant letters.
const PAPER = { plan: 400, unrolled: 680, distance: 680 };
let printing = false;
const roomOf = (holder) => (printing && PAPER[holder.id]) || Math.max(260, Math.round(holder.clientWidth || 560));
