// What each choice changes: a bar for every option of every switch.

import { switches } from "./choices.js";

const least = 0.01; // grey levels of no bar
const most = 100; // of a whole one; between them bars are logarithmic
const shortest_paths = 2; // the light that asks a solver

/** The levels of each switch; those that are not `newest` stand there faded until they come. */
export function show_levels(target, levels, state, newest) {
  target.replaceChildren(...switches.filter(({ key }) => levels[key]).map(({ key, label, options }) => {
    const group = document.createElement("div");
    const title = document.createElement("h3");
    const is_idle = key === "solver" && state.light !== shortest_paths;
    title.textContent = is_idle ? `${label}: for light along shortest paths` : label;
    group.className = newest[key] ? "" : "old";
    group.append(title);
    options.forEach((option, k) => group.append(bar(option, levels[key][k], k === state[key])));
    return group;
  }));
}

function bar(name, level, is_chosen) {
  const line = document.createElement("div");
  line.className = is_chosen ? "bar chosen" : "bar";
  const label = document.createElement("span");
  label.textContent = name;
  const track = document.createElement("i");
  const filled = document.createElement("i");
  const share = Math.log(Math.max(level, least) / least) / Math.log(most / least);
  filled.style.width = `${100 * Math.min(1, share)}%`;
  track.append(filled);
  const value = document.createElement("b");
  value.textContent = is_chosen ? "now" : level.toFixed(level < 10 ? 2 : 1);
  line.append(label, track, value);
  return line;
}
