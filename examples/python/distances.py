"""Distances over a bent sheet by five methods, their errors, and exact paths and circles.

Run: python3 distances.py [picture.png]
"""

import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import gelight


def bent_sheet():
    """A flat sheet of 3 x 2 rolled round a cylinder, and its points before that."""
    flat = gelight.grid(45, 30, 3.0, 2.0)
    u, v = flat.vertices[:, 0], flat.vertices[:, 1]
    return gelight.Surface(np.stack([np.sin(u), v, np.cos(u)], axis=1), flat.faces), u, v


surface, u, v = bent_sheet()
source = 712
truth = np.hypot(u - u[source], v - v[source])  # rolling changes no distance on the sheet

solvers = {
    "Dijkstra": gelight.DijkstraSolver(surface),
    "heat": gelight.HeatSolver(surface),
    "fast marching": gelight.FastMarchingSolver(surface),
    "virtual source": gelight.VirtualSourceSolver(surface),
    "smooth": gelight.SmoothDistanceSolver(surface),
    "exact": gelight.ExactSolver(surface, keep_windows=True),
}
far = truth > 0.1
for name, solver in solvers.items():
    off = np.abs(solver.distance(source) / np.where(far, truth, 1) - 1)[far]
    print(f"{name:15} mean error {100 * off.mean():.4f} %, at most {100 * off.max():.4f} %")

field = solvers["exact"].solve(source)
figure, axes = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
for axis, name in zip(axes, ("Dijkstra", "exact")):
    distance = solvers[name].distance(source)
    lines = axis.tricontourf(u, v, surface.faces, distance, levels=np.arange(0, 2.6, 0.1))
    axis.tricontour(u, v, surface.faces, distance, levels=np.arange(0, 2.6, 0.2), colors="k",
                    linewidths=0.5)
    axis.set(title=f"{name}, the sheet laid flat", aspect="equal")
figure.colorbar(lines, ax=axes, label="distance")

# Any point inside of a face has a distance and a path, not only the vertices.
random = np.random.default_rng(5)
for face in random.integers(0, surface.face_count, 12):
    point = gelight.face_point(face, (0.2, 0.3, 0.5))
    places = field.path(point).positions
    axes[1].plot(np.arctan2(places[:, 0], places[:, 2]) % (2 * np.pi), places[:, 1], "w-", lw=1)
circle = field.isolines(0.7)[0]
print(f"circle of radius 0.7: {circle.length:.12f} long, 1.4 pi is {1.4 * np.pi:.12f}")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "distances.png", dpi=80)
