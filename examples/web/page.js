// The page: what is chosen, and the views that follow it.

import { draw_chart } from "./chart.js";
import { edge_length, led_key, objects, sensors, start, switches } from "./choices.js";
import { compile, Engine, image_height, image_width } from "./engine.js";
import { show_levels } from "./levels.js";
import { Tour } from "./tour.js";

const state = { ...start };
const step = 0.002; // between isolines, in metres
const element = (id) => document.getElementById(id);
const image = element("image");
const pen = image.getContext("2d");
let engine;
let view; // comes after the first picture, as does all that the picture does not need
let is_ready = false; // has come, or cannot: without WebGL there is none
let worker;
let rates = [];
let is_waiting = false;
let following;

/** Runs what may fail on a choice, and tells why it did. */
function attempt(work) {
  try {
    const result = work();
    element("error").hidden = true;
    return result;
  } catch (error) {
    element("error").textContent = error.message;
    element("error").hidden = false;
    return undefined;
  }
}

// --- what follows a choice -----------------------------------------------------------------------

function set_sensor() {
  attempt(() => {
    engine.sensor(state.sensor, edge_length(state));
    view?.set_sensor(engine.mesh(false), engine.leds());
    state.led = Math.min(state.led, engine.leds().length - 1);
    show_leds();
    set_object();
    set_renderer();
    // After the picture is shown.
    clearTimeout(following);
    following = setTimeout(follow, 20);
  });
}

function follow() {
  if (!is_ready) return;
  set_distances();
  measure();
}

function set_object() {
  attempt(() => {
    engine.object(state.object);
    view?.set_object(engine.mesh(true));
  });
}

function set_renderer() {
  attempt(() => {
    engine.renderer(state);
    press();
  });
}

function set_distances() {
  attempt(() => {
    show_led();
    if (!view) return;
    const distances = engine.call("distances", state.solver, state.led);
    view.set_distances(
      distances,
      engine.call("isolines", step),
      engine.call("fan", state.led, 36),
      state.led,
    );
    view.draw();
  });
}

function press() {
  attempt(() => {
    const begin = performance.now();
    const pose = state.is_pressed ? engine.press(state) : engine.lift();
    const pixels = engine.image();
    rates.push(performance.now() - begin);
    pen.putImageData(new ImageData(pixels, image_width, image_height), 0, 0);
    document.body.dataset.picture ??= String(Math.round(performance.now()));
    view?.set_pose(pose ?? null);
    view?.draw();
    show_numbers();
    trace_soon();
  });
}

let tracing;
function trace_soon() {
  clearTimeout(tracing);
  const count = element("leds").childElementCount;
  const path = (_, k) => (state.is_pressed ? engine.call("path", k, state.u, state.v) : []);
  tracing = setTimeout(() => attempt(() => view?.set_paths(Array.from({ length: count }, path))), 15);
}

/** At most one press for each picture of the screen. */
function press_soon() {
  if (is_waiting) return;
  is_waiting = true;
  requestAnimationFrame(() => {
    is_waiting = false;
    press();
  });
}

function press_at(u, v) {
  state.u = Math.min(Math.max(u, 0), image_width - 1);
  state.v = Math.min(Math.max(v, 0), image_height - 1);
  state.is_pressed = true;
  press_soon();
}

// --- what runs beside the page -------------------------------------------------------------------

let measured = [];
let levels = {};

function measure() {
  measured = [];
  draw_chart(element("chart"), measured, state.solver);
  worker?.postMessage({ task: "measure", state: { ...state } });
  compare();
}

let comparing;
function compare() {
  clearTimeout(comparing);
  comparing = setTimeout(() => worker?.postMessage({ task: "compare", state: { ...state } }), 150);
}

function heard({ data }) {
  document.body.dataset[data.task] = data.is_last ? "done" : "busy";
  if (data.row?.of === led_key(state)) {
    measured = measured.filter(({ solver }) => solver !== data.row.solver);
    measured.push(data.row);
    draw_chart(element("chart"), measured, state.solver);
  }
  if (data.task === "compare") {
    levels = { ...levels, ...data.levels };
    show_levels(element("level-bars"), levels, state, data.levels ?? {});
  }
  if (data.error) attempt(() => {
    throw new Error(data.error);
  });
}

// --- numbers and buttons -------------------------------------------------------------------------

function show_numbers() {
  rates = rates.slice(-30);
  const middle = [...rates].sort((a, b) => a - b)[Math.floor(rates.length / 2)];
  element("rate").textContent = Math.round(1000 / middle);
  element("depth").value = 1000 * state.depth;
  element("depth-value").textContent = `${(1000 * state.depth).toFixed(2)} mm`;
  const degrees = Math.round((state.turn * 180) / Math.PI);
  element("turn").value = degrees;
  element("turn-value").textContent = `${degrees}°`;
  element("lift").textContent = state.is_pressed ? "Lift" : "Press";
}

function show_leds() {
  element("leds").replaceChildren(
    ...engine.leds().map(({ colour }, k) => {
      const button = document.createElement("button");
      button.type = "button";
      const dot = document.createElement("span");
      dot.className = "dot";
      dot.style.background = `rgb(${colour.map((c) => 255 * c).join()})`;
      button.append(dot, `LED ${k + 1}`);
      button.addEventListener("click", () => choose_led(k));
      return button;
    }),
  );
}

function show_led() {
  [...element("leds").children].forEach((button, k) => {
    button.setAttribute("aria-pressed", String(k === state.led));
  });
}

function choose_led(k) {
  if (k === state.led) return;
  state.led = k;
  set_distances();
  measure();
}

/** A choice by the key of the page's state; the views follow. */
function choose(key, value) {
  state[key] = value;
  if (key === "depth" || key === "turn") state.is_pressed = true; // else nothing shows it
  const select = element(`choice-${key}`);
  if (select) select.value = String(value);
  element("status").textContent = select ? `${key}: ${select.selectedOptions[0].text}` : "";
  document.body.dataset.compare = "busy";
  if (key === "sensor" || key === "edge") set_sensor();
  else if (key === "object") {
    set_object();
    press();
  } else if (key === "solver") {
    set_renderer();
    set_distances();
    draw_chart(element("chart"), measured, state.solver);
  } else if (key === "light" || key === "smoothing") set_renderer();
  else press();
  compare();
}

function add_choice({ key, label, options }) {
  const line = document.createElement("label");
  const select = document.createElement("select");
  select.id = `choice-${key}`;
  select.append(...options.map((text, value) => new Option(text, value)));
  select.value = String(state[key]);
  select.addEventListener("change", () => choose(key, Number(select.value)));
  line.append(label, select);
  element("choices").append(line);
}

function press_key(event) {
  const reach = event.shiftKey ? 1 : 6;
  const moves = {
    ArrowLeft: () => press_at(state.u - reach, state.v),
    ArrowRight: () => press_at(state.u + reach, state.v),
    ArrowUp: () => press_at(state.u, state.v - reach),
    ArrowDown: () => press_at(state.u, state.v + reach),
    "+": () => choose("depth", Math.min(state.depth + 1e-4, 0.0025)),
    "-": () => choose("depth", Math.max(state.depth - 1e-4, 0)),
    Escape: () => choose("is_pressed", false),
  };
  moves["="] = moves["+"];
  const move = moves[event.key];
  if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  move();
  compare();
}

function drag_image() {
  let is_down = false;
  const at = (event) => {
    const box = image.getBoundingClientRect();
    press_at(
      ((event.clientX - box.left) / box.width) * image_width - 0.5,
      ((event.clientY - box.top) / box.height) * image_height - 0.5,
    );
  };
  image.addEventListener("pointerdown", (event) => {
    if (!event.isPrimary || event.button !== 0) return;
    image.setPointerCapture(event.pointerId);
    is_down = true;
    at(event);
  });
  image.addEventListener("pointermove", (event) => event.isPrimary && is_down && at(event));
  for (const name of ["pointerup", "pointercancel"]) {
    image.addEventListener(name, (event) => {
      if (!event.isPrimary) return;
      is_down = false;
      compare();
    });
  }
}

function wire() {
  add_choice({ key: "sensor", label: "Sensor", options: sensors.map(({ name }) => name) });
  add_choice({ key: "object", label: "Object", options: objects });
  switches.forEach(add_choice);
  drag_image();
  for (const canvas of [image, element("finger")]) canvas.addEventListener("keydown", press_key);
  element("depth").addEventListener("input", ({ target }) => choose("depth", target.value / 1000));
  element("turn").addEventListener("input", ({ target }) => {
    choose("turn", (target.value * Math.PI) / 180);
  });
  element("lift").addEventListener("click", () => choose("is_pressed", !state.is_pressed));
  new Tour(document, (changes) => {
    const is_other = Object.entries(changes).filter(([key, value]) => state[key] !== value);
    for (const [key, value] of is_other) {
      if (key === "led") choose_led(value);
      else choose(key, value);
    }
  });
}

// --- the beginning -------------------------------------------------------------------------------

/** When the browser has shown what was drawn. */
const shown = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

async function begin() {
  wire();
  const module = await compile("page.wasm");
  performance.mark("compiled");
  engine = await Engine.from(module);
  set_sensor();
  await shown();
  worker = new Worker("worker.js", { type: "module" });
  worker.addEventListener("message", heard);
  worker.postMessage({ task: "begin", module });
  try {
    const { FingerView } = await import("./finger.js");
    view = new FingerView(element("finger"), {
      on_press(x, y, z) {
        const { fx, fy, cx, cy } = engine.camera;
        press_at((fx * x) / z + cx, (fy * y) / z + cy);
      },
      on_led: choose_led,
      on_release: compare,
    });
    view.set_sensor(engine.mesh(false), engine.leds());
    view.set_object(engine.mesh(true));
  } catch (error) {
    view = undefined;
    element("finger").hidden = true;
    element("finger-words").textContent = `Not shown, but all else works: ${error.message}`;
  }
  is_ready = true;
  press();
  follow();
}

begin().catch((error) => attempt(() => {
  throw error;
}));

// For tests, and for who opens the console.
window.gelight = {
  state,
  choose,
  rest_image: () => (engine.lift(), engine.image()),
  press,
  engine: () => engine,
  view: () => view,
};
