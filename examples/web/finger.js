// The finger from outside: its mesh with distances as bands, LEDs, paths, and the object.

import * as three from "three";

const near = new three.Color("#fff4dc");
const far = new three.Color("#7fa3b8");

function geometry_of({ positions, faces }) {
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(positions, 3));
  geometry.setIndex(new three.BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry;
}

/** Off the scene, and out of the graphics card's memory. */
function drop(thing) {
  thing?.traverse(({ geometry, material }) => {
    geometry.dispose();
    material.dispose();
  });
  thing?.removeFromParent();
}

function lines(colour, opacity = 1) {
  const material = new three.LineBasicMaterial({ color: colour, transparent: true, opacity });
  const result = new three.LineSegments(new three.BufferGeometry(), material);
  result.frustumCulled = false;
  return result;
}

function set_lines(target, numbers) {
  target.geometry.dispose();
  target.geometry = new three.BufferGeometry();
  target.geometry.setAttribute("position", new three.BufferAttribute(numbers, 3));
}

function tube(pieces, thickness) {
  const points = [];
  for (let i = 0; i < pieces.length; i += 6) {
    if (i === 0) points.push(new three.Vector3(...pieces.slice(0, 3)));
    points.push(new three.Vector3(...pieces.slice(i + 3, i + 6)));
  }
  if (points.length < 2) return new three.BufferGeometry();
  const path = new three.CurvePath();
  for (let i = 1; i < points.length; ++i) path.add(new three.LineCurve3(points[i - 1], points[i]));
  return new three.TubeGeometry(path, 80, thickness, 6);
}

export class FingerView {
  /** Calls `on_press(x, y, z)` where the finger is dragged upon, `on_led(k)` where an LED is. */
  constructor(canvas, { on_press, on_led, on_release }) {
    this.canvas = canvas;
    this.renderer = new three.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.camera = new three.PerspectiveCamera(30, 4 / 3, 0.001, 1);
    this.camera.position.set(0, 0, 0.09);
    this.scene = new three.Scene();
    this.scene.add(new three.HemisphereLight("#ffffff", "#8a8072", 2.2));
    const sun = new three.DirectionalLight("#ffffff", 1.6);
    sun.position.set(0.5, 1, 1);
    this.scene.add(sun);
    this.body = new three.Group();
    this.scene.add(this.body);
    this.isolines = lines("#26364d", 0.55);
    this.fan = lines("#26364d", 0.22);
    this.body.add(this.isolines, this.fan);
    this.paths = [];
    this.leds = [];
    this.yaw = 0.5;
    this.pitch = -0.95;
    this.#listen(on_press, on_led, on_release);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  set_sensor(mesh, leds) {
    [this.skin, ...this.leds, ...this.paths].forEach(drop);
    this.skin = new three.Mesh(
      geometry_of(mesh),
      new three.MeshStandardMaterial({
        vertexColors: true,
        side: three.DoubleSide,
        roughness: 0.75,
        transparent: true,
        opacity: 0.85,
        polygonOffset: true,
        polygonOffsetFactor: 2,
        polygonOffsetUnits: 2,
      }),
    );
    this.skin.renderOrder = 1; // over the lines behind it
    this.body.add(this.skin);
    this.skin.geometry.computeBoundingSphere();
    const { center, radius } = this.skin.geometry.boundingSphere;
    this.centre = center.clone();
    this.camera.position.z = radius * 4.1;
    this.leds = leds.map(({ place, colour }) => {
      const ball = new three.Mesh(
        new three.SphereGeometry(radius * 0.05, 24, 16),
        new three.MeshBasicMaterial({ color: new three.Color(...colour) }),
      );
      ball.position.set(...place);
      const ring = new three.Mesh(
        new three.SphereGeometry(radius * 0.075, 24, 16),
        new three.MeshBasicMaterial({ color: "#1d2430", side: three.BackSide }),
      );
      ball.add(ring);
      this.body.add(ball);
      return ball;
    });
    this.paths = leds.map(({ colour }) => {
      const material = new three.MeshBasicMaterial({ color: new three.Color(...colour) });
      const path = new three.Mesh(new three.BufferGeometry(), material);
      this.body.add(path);
      return path;
    });
  }

  set_object(mesh) {
    drop(this.object);
    const material = new three.MeshStandardMaterial({
      color: "#d08a4a",
      roughness: 0.5,
      flatShading: mesh.faces.length < 60,
      transparent: true,
      opacity: 0.82,
    });
    this.object = new three.Mesh(geometry_of(mesh), material);
    this.object.matrixAutoUpdate = false;
    this.object.renderOrder = 2;
    this.body.add(this.object);
  }

  /** Where the object is; null hides it. */
  set_pose(matrix) {
    this.object.visible = matrix !== null;
    if (matrix) this.object.matrix.fromArray(matrix);
    this.object.matrixWorldNeedsUpdate = true;
  }

  set_distances(distances, isolines, fan, led) {
    const finite = distances.filter(Number.isFinite);
    const most = finite.reduce((a, b) => Math.max(a, b), 0);
    const colours = new Float32Array(3 * distances.length);
    const colour = new three.Color();
    distances.forEach((d, v) => {
      colour.lerpColors(near, far, Number.isFinite(d) ? d / most : 1).toArray(colours, 3 * v);
    });
    this.skin.geometry.setAttribute("color", new three.BufferAttribute(colours, 3));
    set_lines(this.isolines, isolines);
    set_lines(this.fan, fan);
    this.leds.forEach((ball, k) => {
      ball.children[0].visible = k === led;
      ball.scale.setScalar(k === led ? 1.25 : 0.85);
    });
  }

  /** Thick lines from the LEDs, each as pieces of two points. */
  set_paths(paths) {
    this.paths.forEach((path, k) => {
      path.geometry.dispose();
      path.geometry = tube(paths[k] ?? [], 0.0002);
    });
    this.draw();
  }

  draw() {
    if (!this.centre) return;
    const turn = new three.Quaternion().setFromEuler(new three.Euler(this.pitch, this.yaw, 0, "XYZ"));
    this.body.quaternion.copy(turn);
    this.body.position.copy(this.centre).negate().applyQuaternion(turn);
    this.renderer.render(this.scene, this.camera);
  }

  #hit(event) {
    const box = this.canvas.getBoundingClientRect();
    const place = new three.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    );
    const ray = new three.Raycaster();
    ray.setFromCamera(place, this.camera);
    const led = ray.intersectObjects(this.leds, false)[0];
    if (led) return { led: this.leds.indexOf(led.object) };
    const skin = this.skin && ray.intersectObject(this.skin, false)[0];
    return skin ? { point: this.body.worldToLocal(skin.point.clone()) } : {};
  }

  #listen(on_press, on_led, on_release) {
    let dragged = "";
    let before = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      if (!event.isPrimary || event.button !== 0) return;
      this.canvas.setPointerCapture(event.pointerId);
      const { led, point } = this.#hit(event);
      dragged = led !== undefined ? "led" : point ? "skin" : "view";
      before = event;
      if (dragged === "led") on_led(led);
      if (dragged === "skin") on_press(point.x, point.y, point.z);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!event.isPrimary) return;
      if (dragged === "skin") {
        const { point } = this.#hit(event);
        if (point) on_press(point.x, point.y, point.z);
      } else if (dragged === "view") {
        this.yaw += (event.clientX - before.clientX) * 0.01;
        this.pitch += (event.clientY - before.clientY) * 0.01;
        before = event;
        this.draw();
      } else if (dragged === "" && event.pointerType === "mouse") {
        const { led } = this.#hit(event);
        if (led !== undefined) on_led(led);
      }
    });
    for (const name of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(name, (event) => {
        if (!event.isPrimary) return;
        dragged = "";
        on_release();
      });
    }
  }
}
