// What one can choose; the order of each list is that of choices.hpp.

/** Mesh edges in metres: coarse, middle, fine. */
export const sensors = [
  { name: "GelTip, a finger", edges: [0.004, 0.002, 0.001] },
  { name: "Dome", edges: [0.003, 0.0015, 0.001] },
  { name: "Flat pad", edges: [0.002, 0.001, 0.0005] },
  { name: "Cat's paw", edges: [0.002, 0.001, 0.0007] },
];

export const objects = ["Ball", "Ring", "Cube", "Screw", "Ball bearing", "Braille"];

export const solvers = [
  "Exact",
  "Virtual sources",
  "Fast marching",
  "Heat method",
  "Dijkstra, 3 points",
  "Dijkstra",
];

/** The switches: a key of the page's state, a label, and the options by name. */
export const switches = [
  {
    key: "light",
    label: "Light",
    options: ["Straight", "In a plane", "Shortest paths", "Transported"],
  },
  {
    key: "smoothing",
    label: "Smoothing",
    options: ["None", "Gaussian", "Wide Gaussian", "Elastic layer"],
  },
  { key: "edge", label: "Mesh edge", options: ["Coarse", "Middle", "Fine"] },
  { key: "solver", label: "Solver", options: solvers },
];

export const start = {
  sensor: 0,
  object: 4,
  light: 2,
  smoothing: 1,
  edge: 1,
  solver: 0,
  led: 0,
  u: 160,
  v: 120,
  depth: 0.0018,
  turn: 0.3,
  is_pressed: true,
};

/** What measurements of solvers are of: an LED on a mesh. */
export function led_key({ sensor, edge, led }) {
  return `${sensor} ${edge} ${led}`;
}

export function edge_length(state) {
  return sensors[state.sensor].edges[state.edge];
}
