"""What a call from Python costs over the work itself, and what a pixel does.

Run: python3 overhead.py
"""

import timeit

import numpy as np

import gelight


def microseconds(call):
    """The least of several rounds, a call."""
    timer = timeit.Timer(call)
    count, _ = timer.autorange()
    return 1e6 * min(timer.repeat(7, max(1, count // 4))) / max(1, count // 4)


field = gelight.ExactSolver(gelight.icosphere(3)).solve(0)
print(f"distance of a vertex, 1 number:   {microseconds(lambda: field.distance(5)):8.2f} us")

tetrahedron = gelight.Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                              [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
dijkstra = gelight.DijkstraSolver(tetrahedron)
print(f"all distances of a tetrahedron:   {microseconds(lambda: dijkstra.distance(0)):8.2f} us")
out = np.empty(4)
print(f"the same into an array:           "
      f"{microseconds(lambda: dijkstra.distance_into(out, 0)):8.2f} us")

for width, height in ((1, 1), (160, 120), (1280, 960)):
    camera = gelight.Camera.from_vertical_fov(1.0, width, height)
    depth = np.full((height, width), np.inf, np.float32)
    aside = gelight.Pose(None, (100, 0, 1))
    box = gelight.box(0.1, 0.1, 0.1)
    time = microseconds(lambda: gelight.rasterize_into(depth, box, aside, camera))
    print(f"nothing drawn into {width:4} x {height:4}:  {time:8.2f} us")
