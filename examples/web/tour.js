// Eight steps of the course (../README.md): words, and the choices that show them.

const steps = [
  {
    title: "A finger that sees",
    words:
      "A camera inside looks at its own soft skin, which three LEDs light in three colours. Whatever presses in tilts the skin, and tilted skin catches other light: shape becomes colour.",
    changes: { sensor: 0, object: 4, light: 2, smoothing: 1, edge: 1, solver: 0, led: 0, u: 160, v: 120, depth: 0.0018, turn: 0.3, is_pressed: true },
  },
  {
    title: "Distance over the surface",
    words:
      "Light trapped in a thin skin cannot cut across the hollow. What counts is the distance along the skin: the bands and lines start at the ringed LED. The bright lines are the shortest ways to the contact.",
    changes: { object: 0, led: 1 },
  },
  {
    title: "Why Dijkstra is wrong",
    words:
      "Along edges alone, paths zigzag: see the dented lines, and the dot high up in the chart. A finer mesh has shorter edges but no more directions, so the error stays.",
    changes: { solver: 5 },
  },
  {
    title: "Heat spreads, distance follows",
    words:
      "The heat method lets warmth spread for a moment and asks which way it falls. Set up once, each query is a few sums: look for its dot, and at what it costs in accuracy.",
    changes: { solver: 3 },
  },
  {
    title: "Exact, by windows",
    words:
      "The exact solver remembers for each piece of an edge where its straight lines come from. Its dot stands on the axis: no error but rounding. The others are measured against it.",
    changes: { solver: 0 },
  },
  {
    title: "Four ways of light",
    words:
      "Straight through space now, as if the finger were glass. Under “What a choice changes” stands how many grey levels lie between this and light along shortest paths.",
    changes: { light: 0, object: 1 },
  },
  {
    title: "Gel is not a stencil",
    words:
      "Without smoothing the skin follows the screw like paint. Gel bulges around it: a Gaussian is the cheap answer, an elastic layer the better one. Try them.",
    changes: { light: 2, object: 3, smoothing: 0 },
  },
  {
    title: "Another shape",
    words:
      "A cat's paw, in ten lines of code. On bent skin the choice of light matters; on a flat pad shortest ways are straight, and it does not. See for yourself.",
    changes: { sensor: 3, object: 0, smoothing: 1, u: 160, v: 105 },
  },
];

export class Tour {
  /** Calls `show` with the choices of a step. */
  constructor(page, show) {
    this.at = (id) => page.getElementById(`tour-${id}`);
    this.box = page.getElementById("tour");
    this.show = show;
    this.at("start").addEventListener("click", () => this.go(0));
    this.at("next").addEventListener("click", () => this.go(this.step + 1));
    this.at("back").addEventListener("click", () => this.go(this.step - 1));
    this.at("end").addEventListener("click", () => this.go(steps.length));
  }

  go(step) {
    this.step = step;
    this.box.hidden = step >= steps.length;
    if (this.box.hidden) {
      this.at("start").focus();
      return;
    }
    const { title, words } = steps[step];
    this.at("count").textContent = `${step + 1} of ${steps.length}`;
    this.at("title").textContent = title;
    this.at("words").textContent = words;
    this.at("back").disabled = step === 0;
    this.at("next").textContent = step + 1 === steps.length ? "Finish" : "Next";
    // All that led here, whichever way it is come to.
    this.show(Object.assign({}, ...steps.slice(0, step + 1).map(({ changes }) => changes)));
  }
}
