// Beside the page: measures the solvers, and renders what other choices would have made.

import { edge_length, led_key, switches } from "./choices.js";
import { Engine, grey_levels } from "./engine.js";

let module;
const newest = { measure: 0, compare: 0 }; // number of the newest of each task
const engines = new Map(); // of a sensor and an edge

async function engine_of(state) {
  const key = `${state.sensor} ${state.edge}`;
  if (!engines.has(key)) {
    if (![...engines.keys()].some((known) => known.startsWith(`${state.sensor} `))) engines.clear();
    const engine = await Engine.from(module);
    engine.sensor(state.sensor, edge_length(state));
    engines.set(key, engine);
  }
  return engines.get(key);
}

// Milliseconds of a run, the fastest of some series: the clock has steps of 0.1 ms.
function time_of(work, patience = 60) {
  let fastest = Infinity;
  let runs = 1;
  for (let spent = 0; spent < patience; ) {
    const start = performance.now();
    for (let run = 0; run < runs; ++run) work();
    const time = performance.now() - start;
    spent += Math.max(time, 0.1);
    if (time < 5) runs *= 2;
    else fastest = Math.min(fastest, time / runs);
  }
  return fastest;
}

function mean_error(distances, exact) {
  let sum = 0;
  let count = 0;
  exact.forEach((d, v) => {
    if (!(d > 0) || !Number.isFinite(d)) return;
    sum += Math.abs(distances[v] - d) / d;
    count += 1;
  });
  return sum / count;
}

async function measure(state, number) {
  const engine = await engine_of(state);
  const exact = engine.call("distances", 0, state.led);
  const count = switches.find(({ key }) => key === "solver").options.length;
  for (let solver = 0; solver < count; ++solver) {
    if (number !== newest.measure) return;
    const setup = time_of(() => engine.call("set_solver", solver), 20);
    let distances;
    const query = time_of(() => {
      distances = engine.call("distances", solver, state.led);
    });
    const error = mean_error(distances, exact);
    const row = { of: led_key(state), solver, setup, query, error, vertices: exact.length };
    postMessage({ task: "measure", row, is_last: solver === count - 1 });
    await new Promise((resolve) => setTimeout(resolve)); // lets a newer question in
  }
}

async function image_of(state) {
  const engine = await engine_of(state);
  engine.object(state.object);
  engine.renderer(state);
  if (state.is_pressed) engine.press(state);
  return engine.image();
}

async function compare(state, number) {
  const chosen = await image_of(state);
  const levels = {};
  for (const { key, options } of switches) {
    levels[key] = [];
    for (let option = 0; option < options.length; ++option) {
      // Only light along shortest paths asks a solver.
      const other = await image_of({ ...state, [key]: option });
      levels[key].push(grey_levels(chosen, other));
      await new Promise((resolve) => setTimeout(resolve)); // lets a newer question in
      if (number !== newest.compare) return;
    }
    postMessage({ task: "compare", levels, is_last: key === switches.at(-1).key });
  }
}

const tasks = { measure, compare };
let queue = Promise.resolve();
onmessage = ({ data: { task, state, module: compiled } }) => {
  if (task === "begin") {
    module = compiled;
    return;
  }
  const number = ++newest[task];
  queue = queue.then(() => (number === newest[task] ? tasks[task](state, number) : undefined));
  queue = queue.catch((error) => postMessage({ task, error: error.message }));
};
