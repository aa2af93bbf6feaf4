// Uses the page as a reader does and writes down what it saw; tests/report_page.rs judges.
window.addEventListener("load", () => setTimeout(async () => {
  const seen = {};
  const $ = (selector) => document.querySelector(selector);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const key = (node, name) => node.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true }));
  const run = () => document.body.dataset.run;
  const firsts = () => all("#runs-table tbody tr").map((row) => row.cells[0].textContent);
  const column = (name) => all("#runs-table thead th").findIndex((th) => th.textContent.startsWith(name));
  const values = (i) => all("#runs-table tbody tr").map((row) => row.cells[i]?.textContent ?? "");
  const head = (i) => all("#runs-table thead th")[i];
  try {
    seen.title = document.title;
    seen.heading = $("h1").textContent;
    seen.runs = firsts();
    seen.first = run();
    seen.summary = all("#summary-words li").length;
    seen.sections = all("main > section").map((section) => section.id);
    seen.images = all("img, iframe, object, embed").length;
    seen.foreign = all("script").length;

    const rows = all("#runs-table tbody tr");
    if (rows.length > 4) {
      rows[2].click();
      seen.clicked = { run: run(), head: $("#run-head").textContent, hash: location.hash, marked: all("tr[aria-current]").length };
      key(rows[3], "Enter");
      seen.entered = run();
      key(document.body, "ArrowRight");
      seen.right = run();
      key(document.body, "ArrowLeft");
      seen.left = run();
      all("#run-switch button")[1].click();
      seen.next = run();
      $("#run-select").value = "0";
      $("#run-select").dispatchEvent(new Event("change", { bubbles: true }));
      seen.selected = run();

      const rms = column("rms");
      head(rms).querySelector("button").click();
      seen.ascending = { state: head(rms).getAttribute("aria-sort"), values: values(rms), runs: firsts() };
      head(rms).querySelector("button").click();
      seen.descending = { state: head(rms).getAttribute("aria-sort"), values: values(rms) };

      const text = $("#filter-text");
      text.value = "no run says this";
      text.dispatchEvent(new Event("input"));
      seen.nothing = all("#runs-table tbody tr.choice").length;
      text.value = "";
      text.dispatchEvent(new Event("input"));
      const level = $("#runs-filter select");
      if (level) {
        level.value = "0";
        level.dispatchEvent(new Event("change"));
        seen.filtered = all("#runs-table tbody tr.choice").length;
        all("#runs-filter button")[0].click();
      }
      seen.unfiltered = all("#runs-table tbody tr.choice").length;
    }

    seen.plan = all("#plan svg").length;
    if (seen.plan) {
      const svg = $("#plan svg");
      const box = svg.getBoundingClientRect();
      svg.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + 0.5 * box.width, clientY: box.top + 0.2 * box.height, bubbles: true }));
      seen.hover = $("#readout").textContent;
      key(svg, "ArrowRight");
      seen.stepped = $("#readout").textContent;
      seen.curves = ["fitted", "predicted", "whisker"].map((name) => all(`#plan svg path.${name}`).length);
      const toggle = all("#plan-controls label").find((label) => label.textContent === "fitted")?.querySelector("input");
      if (toggle && !toggle.disabled) {
        toggle.click();
        seen.untoggled = all("#plan svg path.fitted").length;
        toggle.click();
      }
      const slider = $("#plan-controls input[type=range]");
      const before = $("#plan svg path.whisker")?.getAttribute("d");
      slider.value = "30";
      slider.dispatchEvent(new Event("input"));
      seen.magnified = before !== $("#plan svg path.whisker")?.getAttribute("d");
    }

    const canvas = $("#skirt canvas");
    seen.faces = Number(canvas?.dataset.drawn ?? 0);
    seen.surface_words = $("#skirt .caption")?.textContent;
    if (canvas && !canvas.hidden) {
      const picture = () => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
      const painted = picture();
      let dark = 0;
      for (let i = 0; i < painted.length; i += 4) if (painted[i] + painted[i + 1] + painted[i + 2] < 600) dark++;
      seen.painted = dark / (painted.length / 4);
      key(canvas, "ArrowRight");
      const turned = picture();
      seen.turned = painted.some((v, i) => v !== turned[i]);
      seen.field_options = all("#skirt-controls select").map((select) => select.options.length);
    }

    const tabs = all("[role=tab]");
    seen.responses = tabs.length;
    if (tabs.length > 1) {
      tabs[1].click();
      seen.response = { head: $("#response h3").textContent, name: tabs[1].textContent, bars: all("#bars rect").length, rows: all("#response tbody tr").length };
      key(tabs[1], "ArrowRight");
      seen.response_key = $("#response h3").textContent;
    }
    const open = () => all("details[open]").length;
    seen.paper = { before: open() };
    window.dispatchEvent(new Event("beforeprint"));
    Object.assign(seen.paper, { open: open(), responses: all("#response .response").length });
    window.dispatchEvent(new Event("afterprint"));
    Object.assign(seen.paper, { after: open(), left: all("#response .response").length });
    const dot = all("#scatter-0 circle")[5];
    if (dot) {
      dot.dispatchEvent(new MouseEvent("mousemove", { clientX: 50, clientY: 50, bubbles: true }));
      seen.tip = $("#tip").textContent;
      dot.dispatchEvent(new MouseEvent("click", { bubbles: true }));
      seen.jumped = run();
    }
    seen.tables = all("#tables-body details").length;
    all("#tables-body details").forEach((details) => (details.open = true));
    await wait(200);
    seen.table_rows = all("#tables-body details").map((details) => details.querySelectorAll("tbody tr").length);
    if (seen.runs.length > 1) {
      location.hash = `#run=${encodeURIComponent(seen.runs[seen.runs.length - 1])}`;
      await wait(200);
      seen.hashed = run();
    }
    seen.unnamed = all("button, select, input, canvas, svg[tabindex]").filter(
      (node) => !(node.textContent.trim() || node.getAttribute("aria-label") || node.closest("label")?.textContent.trim()),
    ).length;
    seen.wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  } catch (error) {
    window.faults.push(`probe: ${error.stack}`);
  }
  seen.faults = window.faults;
  const out = document.createElement("pre");
  out.id = "probe";
  out.textContent = JSON.stringify(seen).replace(/[<>&\u0080-\uffff]/g, (c) => `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}`);
  document.body.append(out);
}, 50));
