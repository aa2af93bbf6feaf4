// Tables that sort by any column: a header button tells its state (aria-sort), empty cells always come last.
function cellText(cell, column) {
  if (cell === null || cell === undefined) return "";
  if (typeof cell === "string") return cell;
  return Array.isArray(cell) ? cell[0] : number(cell, column.decimals ?? 0);
}
function sortKey(cell) {
  if (cell === null || cell === undefined || cell === "") return null;
  return Array.isArray(cell) ? cell[1] : cell;
}
// "run 9" before "run 10"; the language of the page decides how letters sort.
const collator = new Intl.Collator(document.documentElement.lang || "en", { numeric: true });
function compare(a, b) {
  if (typeof a === "number" && typeof b === "number") return a - b;
  return collator.compare(String(a), String(b));
}

/* data: {columns: [{name, unit, number, decimals, words}], rows}. Options: label, choose(index) makes rows choosable, keep(row, index) filters,
   tall limits the height, sortable: false leaves the order alone. Returns {node, refresh, current}. */
function table(data, { label, choose, keep, tall, sortable = true } = {}) {
  let by = -1;
  let down = false;
  let current = -1;
  const heads = [];
  const head = element("tr");
  data.columns.forEach((column, i) => {
    const kind = column.number ? "number" : null;
    const unit = column.unit ? element("span", { class: "unit" }, column.unit) : null;
    const name = sortable ? element("button", { type: "button", onclick: () => sort(i) }, column.name) : column.name;
    heads.push(element("th", { scope: "col", class: kind, "aria-sort": sortable ? "none" : null }, [name, unit], head));
  });
  const rows = data.rows.map((row, index) => {
    const line = element("tr", { class: choose ? "choice" : null });
    row.forEach((cell, i) => {
      const column = data.columns[i];
      element("td", { class: column.number ? "number" : column.words ? "words" : null }, cellText(cell, column), line);
    });
    if (choose) {
      line.addEventListener("click", () => choose(index));
      line.addEventListener("keydown", (event) => key(event, line, index));
    }
    return line;
  });
  const body = element("tbody");
  const node = element("div", { class: tall ? "scroll tall" : "scroll", role: "region", "aria-label": label, tabindex: "0" });
  if (data.columns.length > 20) node.classList.add("wide");
  element("table", {}, [element("thead", {}, head), body], node);

  function key(event, line, index) {
    if (event.key === "Enter" || event.key === " ") choose(index);
    else if (event.key === "ArrowDown") line.nextElementSibling?.focus();
    else if (event.key === "ArrowUp") line.previousElementSibling?.focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
  function sort(i) {
    down = by === i ? !down : false;
    by = i;
    refresh();
  }
  function refresh() {
    const order = rows.map((_, i) => i).filter((i) => !keep || keep(data.rows[i], i));
    if (by >= 0) {
      order.sort((a, b) => {
        const [x, y] = [sortKey(data.rows[a][by]), sortKey(data.rows[b][by])];
        if (x === null || y === null) return (x === null) - (y === null) || a - b;
        return (down ? -1 : 1) * compare(x, y) || a - b;
      });
    }
    body.replaceChildren(...order.map((i) => rows[i]));
    if (!order.length) {
      const none = element("td", { colspan: data.columns.length, class: "empty" }, W.no_rows);
      body.append(element("tr", {}, none));
    }
    if (sortable) heads.forEach((th, i) => th.setAttribute("aria-sort", i !== by ? "none" : down ? "descending" : "ascending"));
    reach(order);
    return order.length;
  }
  // One row is in the tab order: the chosen one, or the first that is shown.
  function reach(order) {
    if (!choose) return;
    const first = order.includes(current) ? current : order[0];
    rows.forEach((line, i) => line.setAttribute("tabindex", i === first ? "0" : "-1"));
  }
  function mark(index) {
    current = index;
    rows.forEach((line, i) => (i === index ? line.setAttribute("aria-current", "true") : line.removeAttribute("aria-current")));
    reach(rows.map((_, i) => i).filter((i) => rows[i].isConnected));
    const line = rows[index];
    if (tall && line?.isConnected) {
      const above = line.offsetTop - 60 < node.scrollTop;
      if (above || line.offsetTop + line.offsetHeight > node.scrollTop + node.clientHeight) node.scrollTop = line.offsetTop - 120;
    }
  }
  refresh();
  return { node, refresh, mark };
}
// Two columns, name and text: what is said once and never sorted.
function list(pairs) {
  const rows = pairs.map(([name, text]) => element("tr", {}, [element("th", { scope: "row" }, name), element("td", {}, text)]));
  return element("div", { class: "scroll" }, element("table", { class: "list" }, element("tbody", {}, rows)));
}

// Titled parts below each other: sentences, a table whose rows may lead to a run, a caption.
function showParts(list, body, jump) {
  for (const part of list) {
    if (part.title) element("h3", {}, part.title, body);
    if (part.items?.length) body.append(bullets(part.items));
    if (part.table) {
      const choose = part.runs ? (row) => jump(part.runs[row]) : null;
      body.append(table(part.table, { label: part.title, choose, tall: part.table.rows.length > 18 }).node);
    }
    if (part.caption) element("p", { class: "caption" }, part.caption, body);
  }
}
