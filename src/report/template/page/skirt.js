// The skirt in space: faces painted from far to near on a plain canvas, coloured by one field, turned by pointer and keyboard.
const skirt = (() => {
  // Dark blue over grey to yellow: lightness grows evenly, so it is read the same by colour-blind eyes and in grey.
  const STOPS = [[0, 34, 78], [29, 56, 110], [62, 77, 108], [88, 97, 110], [113, 116, 117], [139, 137, 118], [167, 160, 111], [197, 185, 99], [227, 209, 79], [253, 234, 69]];
  const FIRST = { azimuth: 0.5, elevation: 0.42, zoom: 1 };
  const view = { ...FIRST };
  let canvas, which, by, alike, alikeLabel;
  let holder, said;
  let run = null;
  let mesh = null;
  let painted = []; // the faces on screen, nearest last: for the pointer

  function controls(place) {
    which = element("select", { onchange: () => (build(), draw()) });
    by = element("select", { onchange: () => draw() });
    alike = element("input", { type: "checkbox", onchange: () => draw() });
    alike.checked = true;
    element("label", {}, [W.surface, which], place);
    element("label", {}, [W.colour, by], place);
    alikeLabel = element("label", {}, [alike, W.same_scale], place);
    element("button", { type: "button", onclick: () => (Object.assign(view, FIRST), draw()) }, W.reset_view, place);
    holder = at("skirt");
    canvas = element("canvas", { tabindex: "0", role: "img" }, null, holder);
    said = element("p", { class: "caption" }, "", holder);
    listen();
  }

  function load(next) {
    run = next;
    const before = which.value;
    clear(which);
    run.surfaces.forEach((surface) => element("option", { value: surface.key }, surface.label, which));
    if ([...which.options].some((o) => o.value === before)) which.value = before;
    for (const node of [which.parentNode, by.parentNode, canvas, alikeLabel]) node.hidden = !run.surfaces.length;
    build();
    draw();
  }

  // The whole grid out of one copy: corners in mm, one value of every field at each.
  function build() {
    const surface = run.surfaces.find((s) => s.key === which.value);
    mesh = null;
    if (!surface) return;
    const { copies, round, down } = surface;
    const xyz = unpacked(surface.points, 3, DATA.space_step);
    const across = copies * (round - 1);
    const corners = new Float64Array(3 * across * down);
    const fields = surface.fields.map((field) => ({ ...field, one: unpacked(field.values, 1, field.step), all: new Float64Array(across * down) }));
    for (let c = 0; c < copies; c++) {
      const [sin, cos] = [Math.sin((2 * Math.PI * c) / copies), Math.cos((2 * Math.PI * c) / copies)];
      for (let j = 0; j < down; j++) {
        for (let i = 0; i < round - 1; i++) {
          const [from, to] = [j * round + i, j * across + c * (round - 1) + i];
          const [x, y] = [xyz[3 * from], xyz[3 * from + 1]];
          corners[3 * to] = x * cos - y * sin;
          corners[3 * to + 1] = x * sin + y * cos;
          corners[3 * to + 2] = xyz[3 * from + 2];
          for (const field of fields) field.all[to] = field.one[from];
        }
      }
    }
    let [low, widest] = [0, 0];
    for (let k = 0; k < corners.length; k += 3) {
      low = Math.min(low, corners[k + 2]);
      widest = Math.max(widest, Math.hypot(corners[k], corners[k + 1]));
    }
    mesh = { surface, across, down, corners, fields, low, widest };
    const before = by.value;
    clear(by);
    fields.forEach((field) => element("option", { value: String(field.field) }, DATA.fields[field.field].label, by));
    if ([...by.options].some((o) => o.value === before)) by.value = before;
  }

  function colour(share, light) {
    const x = Math.max(0, Math.min(1, share)) * (STOPS.length - 1);
    const i = Math.min(STOPS.length - 2, Math.floor(x));
    const mix = (k) => Math.round(light * (STOPS[i][k] + (x - i) * (STOPS[i + 1][k] - STOPS[i][k])));
    return `rgb(${mix(0)},${mix(1)},${mix(2)})`;
  }

  function draw() {
    if (!run) return;
    if (!mesh) {
      said.textContent = run.surface_missing;
      return;
    }
    const width = roomOf(holder);
    const height = Math.round(Math.min(width, 560));
    const sharp = Math.min(3, window.devicePixelRatio || 1);
    canvas.width = width * sharp;
    canvas.height = height * sharp;
    const pen = canvas.getContext("2d");
    pen.scale(sharp, sharp);
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, width, height);
    const field = mesh.fields.find((f) => String(f.field) === by.value) ?? mesh.fields[0];
    const about = DATA.fields[field.field];
    const [low, high] = alike.checked ? [about.low, about.high] : [field.low, field.high];
    const [sa, ca, se, ce] = [Math.sin(view.azimuth), Math.cos(view.azimuth), Math.sin(view.elevation), Math.cos(view.elevation)];
    const room = height - 66;
    const scale = view.zoom * Math.min((0.94 * width) / (2 * mesh.widest), room / (Math.abs(mesh.low) * ce + 2 * mesh.widest * Math.abs(se)));
    const [ox, oy] = [width / 2, room / 2 + 6];
    const { corners, across, down } = mesh;
    const n = corners.length / 3;
    const [px, py, near] = [new Float64Array(n), new Float64Array(n), new Float64Array(n)];
    const seen = (x, y, z) => {
      const [right, away, up] = [x * ca - y * sa, x * sa + y * ca, z - mesh.low / 2];
      return [ox + scale * right, oy - scale * (up * ce + away * se), up * se - away * ce];
    };
    for (let k = 0; k < n; k++) [px[k], py[k], near[k]] = seen(corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]);
    const items = [];
    for (let j = 0; j + 1 < down; j++) {
      for (let i = 0; i < across; i++) {
        const k = [j * across + i, j * across + ((i + 1) % across), (j + 1) * across + ((i + 1) % across), (j + 1) * across + i];
        items.push({ k, near: (near[k[0]] + near[k[1]] + near[k[2]] + near[k[3]]) / 4 });
      }
    }
    // The disc that the cloth lies on.
    if (mesh.surface.disc) {
      const middle = seen(0, 0, 0);
      for (let i = 0; i < across; i++) {
        const k = [i, (i + 1) % across];
        items.push({ wedge: [middle, ...k.map((q) => [px[q], py[q]])], near: (middle[2] + near[k[0]] + near[k[1]]) / 3 });
      }
    }
    // The measured points hang at the hem of a level surface.
    if (mesh.surface.level) {
      for (const [x, y] of hem.hemPoints) {
        const [sx, sy, depth] = seen(x, y, mesh.low);
        items.push({ dot: [sx, sy], near: depth + 2 });
      }
    }
    items.sort((a, b) => a.near - b.near);
    pen.lineJoin = "round";
    for (const item of items) {
      if (item.dot) {
        pen.fillStyle = "#d55e00";
        pen.beginPath();
        pen.arc(item.dot[0], item.dot[1], 1.7, 0, 7);
        pen.fill();
        continue;
      }
      if (item.wedge) {
        pen.fillStyle = pen.strokeStyle = "#e9e9e9";
        pen.beginPath();
        item.wedge.forEach(([x, y]) => pen.lineTo(x, y));
        pen.closePath();
        pen.fill();
        pen.stroke();
        continue;
      }
      const [a, b, c, d] = item.k;
      item.value = (field.all[a] + field.all[b] + field.all[c] + field.all[d]) / 4;
      pen.fillStyle = pen.strokeStyle = colour((item.value - low) / (high - low || 1), lightness(a, b, c, d));
      pen.lineWidth = 0.7;
      pen.beginPath();
      pen.moveTo(px[a], py[a]);
      pen.lineTo(px[b], py[b]);
      pen.lineTo(px[c], py[c]);
      pen.lineTo(px[d], py[d]);
      pen.closePath();
      pen.fill();
      pen.stroke();
      item.corners = [a, b, c, d].map((q) => [px[q], py[q]]);
      item.down = (corners[3 * a + 2] + corners[3 * c + 2]) / 2;
    }
    painted = items.filter((item) => item.k);
    painted.about = about;
    legend(pen, width, height, about, low, high);
    canvas.setAttribute("aria-label", fill(W.skirt_label, { surface: mesh.surface.label, field: about.label, low: number(low, about.decimals), high: number(high, about.decimals), unit: about.unit }));
    said.textContent = `${mesh.surface.about} ${about.about} ${W.skirt_hint}`;
    canvas.dataset.drawn = String(painted.length);

    // Lit from the upper left behind the eye; the inner side is darker.
    function lightness(a, b, c, d) {
      const u = [px[c] - px[a], py[c] - py[a], (near[c] - near[a]) * scale];
      const v = [px[d] - px[b], py[d] - py[b], (near[d] - near[b]) * scale];
      const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const size = Math.hypot(...normal) || 1;
      const outside = normal[2] > 0;
      const lit = Math.abs((-0.35 * normal[0] - 0.45 * normal[1] + 0.82 * normal[2]) / size);
      return (outside ? 0.8 : 0.6) + 0.2 * lit;
    }
  }

  function legend(pen, width, height, about, low, high) {
    const [left, right, y] = [24, width - 24, height - 40];
    const shade = pen.createLinearGradient(left, 0, right, 0);
    for (let i = 0; i <= 20; i++) shade.addColorStop(i / 20, colour(i / 20, 1));
    pen.fillStyle = shade;
    pen.fillRect(left, y, right - left, 9);
    pen.fillStyle = "#1b1b1b";
    pen.strokeStyle = "#1b1b1b";
    pen.lineWidth = 1;
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    const marks = ticks(low, high, Math.max(2, width / 110));
    for (const v of marks.found) {
      const x = left + ((v - low) / (high - low || 1)) * (right - left);
      pen.fillRect(x - 0.5, y + 9, 1, 4);
      pen.fillText(number(v, marks.decimals), x, y + 24);
    }
    pen.fillStyle = "#5c5c5c";
    pen.fillText(`${about.label}${about.unit ? `, ${about.unit}` : ""}`, width / 2, y + 37);
  }

  function listen() {
    let from = null;
    canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
      canvas.focus({ preventScroll: true });
      tip.hide();
    });
    canvas.addEventListener("pointerup", () => (from = null));
    canvas.addEventListener("pointercancel", () => (from = null));
    canvas.addEventListener("pointermove", (event) => {
      if (!from) return tell(event);
      turn((event.clientX - from[0]) * 0.01, (event.clientY - from[1]) * 0.01);
      from = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerleave", tip.hide);
    // The wheel belongs to the page until the skirt has been clicked.
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(event.deltaY < 0 ? 1.1 : 1 / 1.1);
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const step = 0.12;
      const acts = {
        ArrowLeft: () => turn(-step, 0), ArrowRight: () => turn(step, 0), ArrowUp: () => turn(0, -step), ArrowDown: () => turn(0, step),
        "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), Home: () => (Object.assign(view, FIRST), draw()),
      };
      if (!acts[event.key]) return;
      event.preventDefault();
      event.stopPropagation();
      acts[event.key]();
    });
  }
  function turn(right, down) {
    view.azimuth = (view.azimuth + right) % (2 * Math.PI);
    view.elevation = Math.max(-1.5, Math.min(1.5, view.elevation + down));
    canvas.dataset.azimuth = view.azimuth.toFixed(3);
    draw();
  }
  function zoom(by) {
    view.zoom = Math.max(0.4, Math.min(6, view.zoom * by));
    draw();
  }
  function tell(event) {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const inside = ({ corners: c }) => {
      let odd = false;
      for (let i = 0, j = 3; i < 4; j = i++) {
        if (c[i][1] > y !== c[j][1] > y && x < ((c[j][0] - c[i][0]) * (y - c[i][1])) / (c[j][1] - c[i][1]) + c[i][0]) odd = !odd;
      }
      return odd;
    };
    const face = painted.findLast(inside);
    if (!face) return tip.hide();
    const { about } = painted;
    const text = fill(W.skirt_value, { field: about.label, value: number(face.value, about.decimals), unit: about.unit, down: number(-face.down, 0) });
    tip.show(text, event.clientX, event.clientY);
  }
  return { controls, load, draw };
})();
