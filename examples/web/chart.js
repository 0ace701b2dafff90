// Speed against accuracy: a dot for each solver, both axes logarithmic.

import { solvers } from "./choices.js";

const width = 420;
const height = 330;
const box = { left: 56, right: 402, top: 14, bottom: 272 };
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
  return ms < 1 ? `${(1000 * ms).toPrecision(2)} µs` : `${ms.toPrecision(2)} ms`;
}

function error_name(error) {
  return error < 1e-6 ? "exact" : `${(100 * error).toPrecision(2)} % off`;
}

/** Places of labels, moved apart where they would lie on each other. */
function labels_apart(dots) {
  const sorted = [...dots].sort((a, b) => a.y - b.y);
  for (let i = 1; i < sorted.length; ++i) {
    sorted[i].label = Math.max(sorted[i].y, sorted[i - 1].label + 27);
  }
  const over = Math.max(0, (sorted.at(-1)?.label ?? 0) - box.bottom + 4);
  for (let i = sorted.length - 1, lowest = Infinity; over > 0 && i >= 0; --i) {
    sorted[i].label = Math.min(sorted[i].label, lowest, box.bottom - 4);
    lowest = sorted[i].label - 27;
  }
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
  add(svg, "text", { x: (box.left + box.right) / 2, y: height - 14, "text-anchor": "middle", fill: "#1d2430" },
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
    add(svg, "text", { x: beside, y: label - 2, "text-anchor": anchor, fill: colour, "font-weight": 600 }, solvers[row.solver]);
    add(svg, "text", { x: beside, y: label + 11, "text-anchor": anchor, fill: "#596273", "font-size": 11 }, `${time_name(row.query)}, ${error_name(row.error)}`);
  }
  target.replaceChildren(svg);
}
