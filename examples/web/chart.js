// Speed against accuracy: a dot for each solver, both axes logarithmic.

import { solvers } from "./choices.js";

const width = 420;
const height = 310;
const box = { left: 56, right: 392, top: 14, bottom: 256 };
const least_error = 1e-5; // below, a dot stands on the axis: exact
const most_error = 0.3;
const colours = ["#1d2430", "#2a7f62", "#1b62c4", "#b4431f", "#8a5fb0", "#a07a12"];

const log = Math.log10;

function add(parent, name, attributes, text) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

function time_name(ms) {
  const digits = (x) => (x < 10 ? x.toFixed(1) : String(Math.round(x)));
  return ms < 1 ? `${digits(1000 * ms)} µs` : `${digits(ms)} ms`;
}

function error_name(error) {
  return error < 1e-6 ? "exact" : `${(100 * error).toPrecision(2)} %`;
}

/** Heights of labels, moved apart where they would lie on each other. */
function labels_apart(dots) {
  const sorted = [...dots].sort((a, b) => b.y - a.y); // from below
  let lowest = box.bottom - 2;
  for (const dot of sorted) {
    dot.label = Math.min(dot.y + 4, lowest);
    lowest = dot.label - 15;
  }
}

function table_of(rows, chosen) {
  const table = document.createElement("table");
  const line = (names, tag) => {
    const row = table.insertRow();
    names.forEach((name, column) => {
      const cell = document.createElement(column === 0 ? "th" : tag);
      cell.textContent = name;
      row.append(cell);
    });
    return row;
  };
  if (rows.length) line(["Solver", "set-up", "query", "error"], "th");
  for (const { solver, setup, query, error } of rows) {
    const row = line([solvers[solver], time_name(setup), time_name(query), error_name(error)], "td");
    if (solver === chosen) row.className = "chosen";
  }
  return table;
}

export function draw_chart(target, rows, chosen) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.setAttribute("role", "img");
  const told = rows.map((r) => `${solvers[r.solver]}: ${time_name(r.query)}, ${error_name(r.error)}`);
  svg.setAttribute("aria-label", `Time and error of each solver. ${told.join("; ")}`);
  const times = rows.map((r) => Math.max(r.query, 0.01));
  const least = Math.floor(log(Math.min(0.1, ...times)));
  const most = Math.max(least + 3, Math.ceil(log(Math.max(10, ...times)) + 0.001));
  const x = (ms) => box.left + ((log(ms) - least) / (most - least)) * (box.right - box.left);
  const y = (error) => {
    const share = (log(Math.max(error, least_error)) - log(least_error)) / log(most_error / least_error);
    return box.bottom - share * (box.bottom - box.top);
  };
  for (let power = least; power <= most; ++power) {
    const at = x(10 ** power);
    add(svg, "line", { x1: at, x2: at, y1: box.top, y2: box.bottom, stroke: "#e6e8ec" });
    const name = power < 0 ? `${1000 * 10 ** power} µs` : `${10 ** power} ms`;
    add(svg, "text", { x: at, y: box.bottom + 18, "text-anchor": "middle", fill: "#596273" }, name);
  }
  for (const [error, name] of [[0.1, "10 %"], [0.01, "1 %"], [1e-3, "0.1 %"], [1e-4, "0.01 %"], [least_error, "exact"]]) {
    add(svg, "line", { x1: box.left, x2: box.right, y1: y(error), y2: y(error), stroke: "#e6e8ec" });
    add(svg, "text", { x: box.left - 8, y: y(error) + 4, "text-anchor": "end", fill: "#596273" }, name);
  }
  add(svg, "text", { x: (box.left + box.right) / 2, y: height - 10, "text-anchor": "middle", fill: "#1d2430" },
    rows.length ? `time of a query, ${rows[0].vertices} vertices` : "measuring …");
  const dots = rows.map((row) => ({ row, x: x(Math.max(row.query, 0.01)), y: y(row.error), label: y(row.error) }));
  labels_apart(dots);
  for (const { row, x: at, y: level, label } of dots) {
    const colour = colours[row.solver];
    const is_chosen = row.solver === chosen;
    const dot = add(svg, "circle", { cx: at, cy: level, r: is_chosen ? 8 : 6, fill: colour });
    if (is_chosen) add(svg, "circle", { cx: at, cy: level, r: 12, fill: "none", stroke: colour, "stroke-width": 2 });
    add(dot, "title", {}, `${solvers[row.solver]}: ${time_name(row.query)} a query after ${time_name(row.setup)} of set-up, ${error_name(row.error)} on average`);
    const is_left = at > (box.left + box.right) / 2;
    const beside = is_left ? at - 15 : at + 15;
    const anchor = is_left ? "end" : "start";
    add(svg, "text", { x: beside, y: label, "text-anchor": anchor, fill: colour, "font-weight": 600 }, solvers[row.solver]);
  }
  target.replaceChildren(svg, table_of(rows, chosen));
}
