// The page in a real browser: node browser_test.js FOLDER (of page/, npm/ and native/poses).
// Pictures of it go to FOLDER/pictures.

import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

import { edge_length, objects, sensors, switches } from "./choices.js";
import { compile, Engine } from "./engine.js";
import { serve } from "./serve.js";

const folder = resolve(process.argv[2]);
const pictures = join(folder, "pictures");
const programs = ["chromium", "chromium-browser", "google-chrome"].map((name) => `/usr/bin/${name}`);
const program = programs.find((path) => existsSync(path));
if (!program) {
  console.log(`SKIPPED: the page was built, but not tested: none of ${programs.join(", ")} is here.`);
  process.exit(0);
}

let failures = 0;
function expect(is_true, words) {
  console.log(`${is_true ? "ok    " : "FAILED"} ${words}`);
  if (!is_true) failures += 1;
}

const threads = await Engine.from(await compile(readFileSync(join(folder, "wasm/threads.wasm"))));
expect(threads.wasm.differences() === 0, "work for several threads comes out right on one");

const { chromium } = createRequire(join(folder, "npm/"))("playwright-core");
mkdirSync(pictures, { recursive: true });
const server = await serve(join(folder, "page"));
const browser = await chromium.launch({
  executablePath: program,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
const complaints = [];
page.on("console", (message) => {
  if (message.type() === "error") complaints.push(message.text());
});
page.on("pageerror", (error) => complaints.push(error.message));

async function shown() {
  const text = await page.evaluate(() => {
    const { width, height } = document.getElementById("image");
    const pen = document.getElementById("image").getContext("2d");
    const { data } = pen.getImageData(0, 0, width, height);
    const rows = Array.from({ length: height }, (_, y) =>
      String.fromCharCode(...data.subarray(4 * width * y, 4 * width * (y + 1))),
    );
    return btoa(rows.join(""));
  });
  return Buffer.from(text, "base64");
}
const state = () => page.evaluate(() => ({ ...window.gelight.state }));
const is_wrong = () => page.evaluate(() => !document.getElementById("error").hidden);
const frame = () =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
const done = (task) =>
  page.waitForFunction((name) => document.body.dataset[name] === "done", task, { timeout: 180000 });
const is_other = (a, b) => !a.equals(b);

/** The same press by the same code compiled for this machine. */
function native_image(s) {
  const object = s.is_pressed ? s.object : -1;
  const line = [s.sensor, edge_length(s), object, s.light, s.smoothing, s.solver, s.u, s.v, s.depth, s.turn];
  const run = spawnSync(join(folder, "native/poses"), [folder], { input: `${line.join(" ")}\n` });
  if (run.status !== 0) throw new Error(`poses: ${run.stderr}`);
  return readFileSync(join(folder, "press_0.rgba"));
}

/** The share of an image's values that differ by more than one grey level from another's. */
function share_off(a, b) {
  let count = 0;
  for (let i = 0; i < a.length; ++i) count += Math.abs(a[i] - b[i]) > 1;
  return count / a.length;
}

await page.goto(`http://127.0.0.1:${server.address().port}/`);
await page.waitForFunction(() => document.body.dataset.picture, null, { timeout: 60000 });
console.log(`       first picture after ${await page.evaluate(() => document.body.dataset.picture)} ms`);

const marks = await page.evaluate(() =>
  performance.getEntriesByType("mark").map(({ name, startTime }) => `${name} ${Math.round(startTime)}`),
);
console.log(`       ms until: ${marks.join(", ")}`);
await done("measure");
const waited_for = await page.evaluate(() =>
  performance
    .getEntriesByType("resource")
    .filter(({ name, startTime }) => startTime < Number(document.body.dataset.picture) && /three|worker/.test(name))
    .map(({ name }) => name),
);
expect(waited_for.length === 0, `the first picture waits for nothing else ${waited_for.join(", ")}`);

// A drag presses.
await page.keyboard.press("Tab");
await page.focus("#image");
await page.keyboard.press("Escape");
await frame();
const rest = await shown();
expect(rest.some((value, i) => i % 4 < 3 && value > 20), "the finger at rest is lit");
expect(share_off(rest, native_image(await state())) === 0, "at rest it is the native image");
const box = await page.locator("#image").boundingBox();
await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
await page.mouse.down();
await page.mouse.move(box.x + 0.62 * box.width, box.y + 0.45 * box.height, { steps: 5 });
await page.mouse.up();
await frame();
const pressed = await shown();
expect(is_other(rest, pressed), "a drag presses");
for (const object of [4, 0, 3]) {
  await page.selectOption("#choice-object", String(object));
  await frame();
  const off = share_off(await shown(), native_image(await state()));
  expect(off === 0, `${objects[object]}: equal to the native image within one grey level (${off} off)`);
}

// On the finger itself, and by keys.
const finger = await page.locator("#finger").boundingBox();
const before = await state();
await page.mouse.move(finger.x + 0.52 * finger.width, finger.y + 0.42 * finger.height);
await page.mouse.down();
await page.mouse.up();
await frame();
const after = await state();
expect(before.u !== after.u || before.v !== after.v, "a press on the finger in space moves the object");
await page.focus("#finger");
await page.keyboard.press("ArrowLeft");
await page.keyboard.press("+");
await frame();
const moved = await state();
expect(moved.u === after.u - 6 && moved.depth > after.depth, "keys move and press");
for (const key of ["+", "-"]) {
  await page.keyboard.press("Escape");
  await frame();
  const lifted = await shown();
  await page.keyboard.press(key);
  await frame();
  expect((await state()).is_pressed && is_other(lifted, await shown()), `after Esc, ${key} presses again`);
}

// A finger on glass does what the mouse does.
const touch = await page.context().newCDPSession(page);
async function swipe(selector, from, to) {
  await page.locator(selector).scrollIntoViewIfNeeded();
  const box = await page.locator(selector).boundingBox();
  const points = ([x, y], id = 0) => [{ x: box.x + x * box.width, y: box.y + y * box.height, id }];
  const other = points([0.1, 0.9], 1); // a second finger, which changes nothing
  const send = (type, touchPoints) => touch.send("Input.dispatchTouchEvent", { type, touchPoints });
  await send("touchStart", points(from));
  await send("touchMove", points(to));
  await send("touchStart", [...points(to), ...other]);
  await send("touchEnd", points(to));
  await send("touchEnd", []);
  await frame();
}
await swipe("#image", [0.3, 0.3], [0.6, 0.5]);
const touched = await state();
expect(
  Math.abs(touched.u - (0.6 * 320 - 0.5)) < 1 && Math.abs(touched.v - (0.5 * 240 - 0.5)) < 1,
  `a touch that moves presses there (${touched.u}, ${touched.v})`,
);
await swipe("#finger", [0.5, 0.42], [0.52, 0.42]);
const on_finger = await state();
expect(
  on_finger.u === after.u && on_finger.v === after.v,
  `on the finger in space, too (${on_finger.u}, ${on_finger.v}; by mouse ${after.u}, ${after.v})`,
);
await page.focus("#finger");

// Every choice works, and each switch changes the image.
for (let sensor = 0; sensor < sensors.length; ++sensor) {
  await page.selectOption("#choice-sensor", String(sensor));
  await frame();
  const off = share_off(await shown(), native_image(await state()));
  expect(!(await is_wrong()) && off === 0, `${sensors[sensor].name}: the native image (${off} off)`);
}
await page.selectOption("#choice-sensor", "0");
for (const { key, label, options } of switches) {
  const first = (await state())[key];
  const at_first = await shown();
  for (let option = 0; option < options.length; ++option) {
    await page.selectOption(`#choice-${key}`, String(option));
    await frame();
    const differs = is_other(at_first, await shown());
    expect(!(await is_wrong()) && differs === (option !== first), `${label}: ${options[option]}`);
  }
  await page.selectOption(`#choice-${key}`, String(first));
}
for (let object = 0; object < objects.length; ++object) {
  await page.selectOption("#choice-object", String(object));
  await frame();
  expect(!(await is_wrong()), objects[object]);
}
const kept = () => page.evaluate(() => window.gelight.view().renderer.info.memory.geometries);
await page.selectOption("#choice-sensor", "1");
await page.selectOption("#choice-sensor", "0");
await frame();
const kept_first = await kept();
for (let i = 0; i < 10; ++i) {
  await page.selectOption("#choice-sensor", String((i + 1) % 2));
  await page.selectOption("#choice-object", String(i % 3));
  await frame();
}
await page.waitForTimeout(200);
const kept_last = await kept();
expect(kept_last <= kept_first + 4, `shapes no longer shown are let go (${kept_first}, then ${kept_last})`);
const words = await page.evaluate(() => {
  try {
    window.gelight.engine().call("isolines", -1);
    return "";
  } catch (error) {
    return error.message;
  }
});
expect(words.includes("isolines"), `bad input comes out in words: ${words}`);

// How fast. (A busy machine says little: told, not held to.)
const rate = await page.evaluate(() => {
  const engine = window.gelight.engine();
  const begin = performance.now();
  for (let i = 0; i < 200; ++i) {
    engine.press({ u: 160 + 30 * Math.cos(i / 10), v: 120 + 30 * Math.sin(i / 10), depth: 0.001, turn: 0 });
    engine.image();
  }
  return 200000 / (performance.now() - begin);
});
console.log(`       ${Math.round(rate)} tactile images a second`);

// The tour and the charts, and what they look like.
await page.selectOption("#choice-object", "4");
await done("measure");
await page.evaluate(() => window.gelight.choose("object", 4));
await done("compare");
await page.screenshot({ path: join(pictures, "desktop.png"), fullPage: true });
const dots = await page.locator("#chart circle").count();
// One for each, and a ring round the chosen one.
expect(dots === switches.at(-1).options.length + 1, "the chart has a dot for each solver");
const bars = await page.locator("#level-bars .bar").count();
expect(bars === switches.reduce((sum, { options }) => sum + options.length, 0), "each option has a bar");
const fewest = await page.evaluate(
  () =>
    new Promise((end) => {
      let count = Infinity;
      const all = document.getElementById("level-bars");
      new MutationObserver(() => {
        count = Math.min(count, all.querySelectorAll(".bar").length);
        if (document.body.dataset.compare === "done") end(count);
      }).observe(all, { childList: true });
      window.gelight.choose("depth", 0.001);
    }),
);
expect(fewest === bars, `bars stay until newer ones come (${fewest})`);
await page.evaluate(() => window.gelight.choose("light", 0));
await done("compare");
const idle = await page.locator("#level-bars h3").last().textContent();
expect(idle.includes("shortest paths"), `straight light asks no solver: ${idle}`);
await page.click("#tour-start");
const steps = [];
for (let step = 1; step <= 8; ++step) {
  await frame();
  const count = await page.textContent("#tour-count");
  expect(count === `${step} of 8` && !(await is_wrong()), `tour: ${await page.textContent("#tour-title")}`);
  if (step === 3) await page.screenshot({ path: join(pictures, "tour.png") });
  steps.push(await state());
  if (step < 8) await page.click("#tour-next");
}
for (let step = 7; step >= 1; --step) {
  await page.click("#tour-back");
  await frame();
  const [there, back] = [steps[step - 1], await state()].map((s) => JSON.stringify(s));
  expect(there === back, `back at step ${step} is as it was`);
}
await page.click("#tour-end");
expect(!(await page.isVisible("#tour")), "the tour ends");

// A telephone.
await page.setViewportSize({ width: 360, height: 740 });
await frame();
const widest = await page.evaluate(() => document.documentElement.scrollWidth);
expect(widest <= 360, `nothing to scroll sideways at 360 pixels (${widest})`);
await page.screenshot({ path: join(pictures, "phone.png"), fullPage: true });
const unnamed = await page.evaluate(() =>
  [...document.querySelectorAll("button, select, input, canvas")].filter(
    (e) => !(e.textContent.trim() || e.labels?.length || e.getAttribute("aria-label")),
  ).length,
);
expect(unnamed === 0, "all that one can reach has a name");
expect(complaints.length === 0, `the console has no errors: ${complaints.join("; ")}`);
await browser.close();

// Where nothing is drawn in three dimensions, the rest goes on.
const flat = await chromium.launch({ executablePath: program, args: ["--no-sandbox", "--disable-3d-apis"] });
const plain = await flat.newPage();
await plain.goto(`http://127.0.0.1:${server.address().port}/`);
const is_done = () => document.body.dataset.measure === "done" && document.body.dataset.compare === "done";
const goes_on = await plain.waitForFunction(is_done, null, { timeout: 60000 }).then(() => true, () => false);
expect(goes_on, "without WebGL solvers are measured and choices compared");
const told = await plain.textContent("#finger-view p");
expect(told.includes("WebGL") && !(await plain.isVisible("#error")), `it is said in its place: ${told}`);
await flat.close();
server.close();
console.log(failures === 0 ? "The page works." : `${failures} failed.`);
process.exit(failures === 0 ? 0 : 1);
