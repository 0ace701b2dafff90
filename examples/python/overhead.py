"""What a call from Python costs over the work itself, and what a pixel does.

The work itself is next to nothing in each of these calls. Run: python3 overhead.py
"""

import time

import numpy as np

import gelight


def microseconds(call, rounds=2000, calls=50):
    """The least of many short rounds, a call: what else the machine does is in the others."""
    least = np.inf
    for _ in range(rounds):
        begin = time.perf_counter_ns()
        for _ in range(calls):
            call()
        least = min(least, time.perf_counter_ns() - begin)
    return 1e-3 * least / calls


def tell(what, call):
    print(f"{what:34}{microseconds(call) - nothing:8.2f} us")


nothing = microseconds(lambda: None)
field = gelight.ExactSolver(gelight.icosphere(3)).solve(0)
tell("distance of a vertex:", lambda: field.distance(5))
tetrahedron = gelight.Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                              [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
dijkstra = gelight.DijkstraSolver(tetrahedron)
out = np.empty(4)
tell("distances of a tetrahedron:", lambda: dijkstra.distance(0))
tell("the same into an array:", lambda: dijkstra.distance_into(out, 0))

for width, height in ((1, 1), (160, 120), (1280, 960)):
    camera = gelight.Camera.from_vertical_fov(1.0, width, height)
    depth = np.full((height, width), np.inf, np.float32)
    aside = gelight.Pose(None, (100, 0, 1))
    box, work = gelight.box(0.1, 0.1, 0.1), gelight.RasterWorkspace()
    tell(f"nothing drawn into {width} x {height}:",
         lambda: gelight.rasterize_into(depth, box, aside, camera, work))
