"""Vectors and log maps against flat sheets, cones and spheres."""

import numpy as np
import pytest

import gelight
from shapes import arc, cone, globe, sheet


def test_vectors_stay_parallel_on_a_sheet():
    vertices, faces = sheet()
    surface = gelight.Surface(vertices, faces)
    vector = np.array([0.3, -0.4, 0])
    solver = gelight.VectorHeatSolver(surface)
    assert solver.transport(40, vector) == pytest.approx(np.tile(vector, (117, 1)), abs=1e-3)
    assert solver.solve(40, vector).is_reliable
    path = gelight.PathSolver(surface).shortest_path(40, 110)
    carried = gelight.ParallelTransport(surface).along(path, vector)
    assert carried == pytest.approx(vector, abs=1e-12)


def test_several_vectors():
    surface = gelight.Surface(*sheet())
    solver = gelight.VectorHeatSolver(surface)
    vectors = solver.transport([0, 116], [[1, 0, 0], [0, 2, 0]])
    assert vectors[1] == pytest.approx([1, 0, 0], abs=0.2)
    assert vectors[115] == pytest.approx([0, 2, 0], abs=0.3)
    with pytest.raises(ValueError, match="there are 2 points"):
        solver.transport([0, 116], [1, 0, 0])


def test_holonomy_of_a_cone():
    vertices, faces = cone(spread=2.0)
    corner = 2 * np.arcsin(np.linalg.norm(vertices[1] - vertices[2]) / 2 / 0.1)
    ring = np.append(np.arange(65, 129), 65)
    surface = gelight.Surface(vertices, faces)
    turn = gelight.ParallelTransport(surface).holonomy(gelight.Path(surface, ring))
    lacks = 2 * np.pi - 64 * corner
    assert abs(np.remainder(turn - lacks + np.pi, 2 * np.pi) - np.pi) < 1e-9


def test_log_map_of_a_sheet():
    vertices, faces = sheet()
    solver = gelight.ExactLogMapSolver(gelight.Surface(vertices, faces))
    basis = solver.tangent_basis(40)
    assert basis @ basis.T == pytest.approx(np.eye(2), abs=1e-12)
    truth = (vertices - vertices[40]) @ basis.T
    assert solver.log_map(40) == pytest.approx(truth, abs=1e-9)


def test_log_map_of_a_sphere_by_heat():
    """As far as great circles are long, in the direction in which they leave."""
    vertices, faces = globe()
    solver = gelight.VectorHeatSolver(gelight.Surface(vertices, faces))
    x, y = solver.tangent_basis(500)
    far = arc(vertices, 500)
    way = np.stack([vertices @ x, vertices @ y], axis=1)
    truth = way * (far / np.maximum(np.linalg.norm(way, axis=1), 1e-12))[:, None]
    near = far < 2
    off = np.linalg.norm(solver.log_map(500) - truth, axis=1)[near]
    assert off.mean() < 0.05
    result = solver.solve_log_map(500)
    assert np.array_equal(result.coordinates, solver.log_map(500)) and 0 < result.error < 0.07


def test_one_map():
    vertices, faces = globe(12, 24)
    surface = gelight.Surface(vertices, faces)
    log = gelight.ExactLogMapSolver(surface).solve(100)
    field = gelight.ExactSolver(surface).solve(100)
    assert np.linalg.norm(log.at_vertices(), axis=1) == pytest.approx(field.distances())
    assert log(5) == pytest.approx(log.at_vertices()[5])
    assert not log.is_on_cut_locus(101, 1e-9)


def test_extend():
    surface = gelight.Surface(*sheet())
    solver = gelight.VectorHeatSolver(surface)
    values = solver.extend([0, 116], [1.0, 3.0])
    assert values.min() >= 1 - 1e-9 and values.max() <= 3 + 1e-9
    assert values[0] < 1.5 < 2.5 < values[116]
