// The library as the page calls it: page.wasm's plain functions, with words for what goes wrong.

const decoder = new TextDecoder();

export const image_width = 320;
export const image_height = 240;

/** Reads and compiles page.wasm, once; an Engine is made of the result as often as one likes. */
export async function compile(source) {
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(source);
  const response = await fetch(source);
  if (!response.ok) throw new Error(`page.wasm: ${response.status} ${response.statusText}`);
  // While it comes, where the server says what it is.
  return response.headers.get("content-type") === "application/wasm"
    ? WebAssembly.compileStreaming(response)
    : WebAssembly.compile(await response.arrayBuffer());
}

// What the C library would ask of a system; the page has none.
const system = {
  env: { emscripten_notify_memory_growth() {} },
  wasi_snapshot_preview1: new Proxy({}, { get: () => () => 0, has: () => true }),
};

export class Engine {
  static async from(module) {
    const imports = { env: system.env, wasi_snapshot_preview1: {} };
    for (const { module: name, name: call } of WebAssembly.Module.imports(module)) {
      imports[name][call] ??= system[name][call];
    }
    return new Engine((await WebAssembly.instantiate(module, imports)).exports);
  }

  constructor(wasm) {
    this.wasm = wasm;
    wasm._initialize?.();
  }

  /** Calls one of page.hpp's functions and answers with its numbers. */
  call(name, ...numbers) {
    const count = this.wasm[name](...numbers);
    if (count < 0) throw new Error(this.#reason());
    return new Float32Array(this.wasm.memory.buffer, this.wasm.answer(), count).slice();
  }

  sensor(kind, edge, width = image_width, height = image_height) {
    const [fx, fy, cx, cy] = this.call("set_sensor", kind, width, height, edge);
    this.camera = { fx, fy, cx, cy, width, height };
    return this.camera;
  }

  object(kind) {
    this.call("set_object", kind);
  }

  renderer({ light, smoothing, solver }) {
    this.call("set_renderer", light, smoothing, solver);
  }

  /** Presses the object in at a pixel; the pose it then has, a 4 x 4 matrix column by column. */
  press({ u, v, depth, turn }) {
    const p = this.call("press", u, v, depth, turn);
    return [p[0], p[1], p[2], 0, p[3], p[4], p[5], 0, p[6], p[7], p[8], 0, p[9], p[10], p[11], 1];
  }

  lift() {
    this.call("lift");
  }

  /** Red, green, blue and opacity of each pixel: a copy. */
  image() {
    const { width, height } = this.camera;
    const size = 4 * width * height;
    return new Uint8ClampedArray(this.wasm.memory.buffer, this.wasm.image(), size).slice();
  }

  /** The finger's mesh, or the object's. */
  mesh(of_object) {
    return {
      positions: this.call("mesh_positions", of_object ? 1 : 0),
      faces: Uint32Array.from(this.call("mesh_faces", of_object ? 1 : 0)),
    };
  }

  leds() {
    const numbers = this.call("leds");
    return Array.from({ length: numbers.length / 6 }, (_, k) => ({
      place: [...numbers.subarray(6 * k, 6 * k + 3)],
      colour: [...numbers.subarray(6 * k + 3, 6 * k + 6)],
    }));
  }

  #reason() {
    const bytes = new Uint8Array(this.wasm.memory.buffer, this.wasm.reason());
    return decoder.decode(bytes.subarray(0, bytes.indexOf(0)));
  }
}

/** Mean difference of two images, in grey levels, over the pixels that are not black in both. */
export function grey_levels(a, b) {
  let sum = 0;
  let count = 0;
  for (let i = 0; i < a.length; i += 4) {
    if (a[i] + a[i + 1] + a[i + 2] + b[i] + b[i + 1] + b[i + 2] === 0) continue;
    for (let c = i; c < i + 3; ++c) sum += Math.abs(a[c] - b[c]);
    count += 3;
  }
  return count ? sum / count : 0;
}
