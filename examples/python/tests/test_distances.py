"""Solvers against straight lines, great circles and cones laid flat."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gelight
from shapes import arc, cone, globe, sheet, unfolded

SOLVERS = {
    gelight.DijkstraSolver: 0.42,
    gelight.FastMarchingSolver: 0.02,
    gelight.VirtualSourceSolver: 1e-9,
    gelight.HeatSolver: 0.12,
    gelight.ExactSolver: 1e-12,
}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_straight_on_a_sheet(solver, dtype):
    vertices, faces = sheet()
    vertices = vertices.astype(dtype)
    distance = solver(gelight.Surface(vertices, faces)).distance(30)
    truth = np.linalg.norm(vertices.astype(float) - vertices[30].astype(float), axis=1)
    assert distance.dtype == np.float64
    assert distance[30] == 0
    off = np.abs(distance - truth)[truth > 0] / truth[truth > 0]
    assert off.max() < SOLVERS[solver]


@pytest.mark.parametrize("solver", SOLVERS)
def test_nearest_of_several_sources(solver):
    s = solver(gelight.Surface(*sheet()))
    both = np.minimum(s.distance(3), s.distance(80))
    for sources in ([3, 80], np.array([3, 80]), (gelight.vertex_point(3), 80)):
        assert np.abs(s.distance(sources) - both).mean() < 0.05  # edges are 0.25 long
    later = s.distance([gelight.Source(3, 0.5)])
    assert later == pytest.approx(s.distance(3) + 0.5)


def test_exact_on_a_cone():
    vertices, faces = cone()
    solver = gelight.ExactSolver(gelight.Surface(vertices, faces))
    for source in (0, 1, 200):
        assert solver.distance(source) == pytest.approx(unfolded(vertices, source), abs=1e-10)


def test_smooth_is_nearer_to_the_sphere_than_the_mesh():
    vertices, faces = globe()
    surface = gelight.Surface(vertices, faces)
    source = 500
    truth = arc(vertices, source)
    mesh = np.abs(gelight.ExactSolver(surface).distance(source) - truth).mean()
    solver = gelight.SmoothDistanceSolver(surface, vertices)
    found = solver.solve(source)
    assert np.abs(found.distance - truth).mean() < mesh / 20
    assert np.allclose(solver.distance(source), found.distance)
    assert set(np.unique(found.trust)) <= {0, 1, 2}
    path = solver.path(found, 100)
    assert np.linalg.norm(path.positions, axis=1) == pytest.approx(1, abs=1e-3)
    assert path.length == pytest.approx(truth[100], rel=1e-4)


def sides_of(edge, sites, starts):
    """How far an edge's points are from its two sources on a plane, with their start distances."""
    p = edge.points.positions
    return [np.linalg.norm(p - sites[k], axis=1) + starts[k] for k in edge.sources]


def test_voronoi_edges_of_a_plane_are_bisectors():
    vertices, faces = sheet()
    solver = gelight.ExactSolver(gelight.Surface(vertices, faces), keep_windows=True)
    edges = gelight.exact_voronoi_edges(solver.solve([57, 60]))
    assert len(edges) == 1 and edges[0].sources == [0, 1] and not edges[0].is_closed
    first, second = sides_of(edges[0], vertices[[57, 60]], [0, 0])
    assert np.abs(first - second).max() < 1e-12
    assert edges[0].points.length == pytest.approx(2, abs=1e-12)  # across the sheet
    assert np.ptp(edges[0].points.positions[:, 0]) < 1e-12
    # The cell of the first, at smaller x, is to the left of who looks at it from above.
    assert vertices[57, 0] < vertices[60, 0]
    assert edges[0].points.positions[0, 1] < edges[0].points.positions[-1, 1]


def test_voronoi_edges_of_three_cells_meet():
    vertices, faces = sheet()
    sites = [27, 36, 83]
    solver = gelight.ExactSolver(gelight.Surface(vertices, faces), keep_windows=True)
    edges = gelight.exact_voronoi_edges(solver.solve(sites))
    assert sorted(edge.sources for edge in edges) == [[0, 1], [0, 2], [1, 2]]
    a, b, c = vertices[sites][:, :2]
    system, right = 2 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a]
    middle = np.append(np.linalg.solve(system, right), 0)  # of the circle through all three
    for edge in edges:
        first, second = sides_of(edge, vertices[sites], [0, 0, 0])
        assert np.abs(first - second).max() < 1e-12
        ends = edge.points.positions[[0, -1]]
        assert np.linalg.norm(ends - middle, axis=1).min() < 1e-10


def test_voronoi_edges_of_a_later_source_are_hyperbolas():
    vertices, faces = sheet()
    solver = gelight.ExactSolver(gelight.Surface(vertices, faces), keep_windows=True)
    field = solver.solve([gelight.Source(57), gelight.Source(61, 0.3)])
    for deviation in (1e-2, 1e-4):
        (edge,) = gelight.exact_voronoi_edges(field, deviation=deviation)
        first, second = sides_of(edge, vertices[[57, 61]], [0, 0.3])
        assert np.abs(first - second).max() < 1e-12
        # Between its points, too, the line is nearly there.
        p = edge.points.positions
        half = (p[1:] + p[:-1]) / 2
        gap = np.linalg.norm(half - vertices[57], axis=1) - np.linalg.norm(half - vertices[61], axis=1)
        assert np.abs(gap - 0.3).max() < 2 * deviation * 0.36
    assert len(edge.points) > 30


def test_voronoi_edges_refused():
    surface = gelight.Surface(*sheet())
    with pytest.raises(ValueError, match="keep_windows"):
        gelight.exact_voronoi_edges(gelight.ExactSolver(surface).solve([0, 7]))
    solver = gelight.ExactSolver(surface, keep_windows=True)
    with pytest.raises(ValueError, match="deviation 0 is not positive"):
        gelight.exact_voronoi_edges(solver.solve([0, 7]), deviation=0.0)
    with pytest.raises(ValueError, match="segments"):
        gelight.exact_voronoi_edges(solver.solve(gelight.Path(surface, [0, 1])))
    with pytest.raises(gelight.Cancelled):
        gelight.exact_voronoi_edges(solver.solve([0, 7]), cancelled=lambda done: True)


def test_distance_into():
    solver = gelight.ExactSolver(gelight.Surface(*sheet()))
    out = np.empty(solver.surface.vertex_count)
    address = out.__array_interface__["data"][0]
    assert solver.distance_into(out, 7) is None
    assert np.array_equal(out, solver.distance(7))
    assert out.__array_interface__["data"][0] == address
    with pytest.raises(ValueError, match="the output has 3 elements, the mesh"):
        solver.distance_into(np.empty(3), 7)
    for wrong, words in ((np.empty(out.size, np.float32), "of type float32, not float64"),
                         (np.empty(out.size, ">f8"), "of type >f8, not float64"),
                         (np.empty(2 * out.size)[::2], "16 bytes after the other"),
                         (np.empty(out.size)[::-1], "-8 bytes after the other"),
                         (out.tolist(), "list.*, not an array to be written to")):
        with pytest.raises(TypeError, match=f"the output.*{words}"):
            solver.distance_into(wrong, 7)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="the output is read-only"):
        solver.distance_into(out, 7)


def test_points_inside_of_faces():
    vertices, faces = sheet()
    random = np.random.default_rng(1)
    f = random.integers(0, len(faces), 200)
    w = random.dirichlet([1, 1, 1], 200)
    places = np.einsum("ij,ijk->ik", w, vertices[faces[f]])
    truth = np.linalg.norm(places - vertices[40], axis=1)
    for keep_windows in (False, True):
        solver = gelight.ExactSolver(gelight.Surface(vertices, faces), keep_windows=keep_windows)
        field = solver.solve(40)
        assert field.distance(f, w) == pytest.approx(truth, abs=1e-12)
        assert field.distance(f, w.astype(np.float32)) == pytest.approx(truth, abs=1e-6)
        way = (places - vertices[40]) / truth[:, None]
        assert field.direction(f, w) == pytest.approx(way, abs=1e-9)
        point = gelight.face_point(f[0], w[0])
        assert field.distance(point) == pytest.approx(truth[0])
    with pytest.raises(ValueError, match="faces has shape"):
        field.distance(f[:-1], w)
    with pytest.raises(ValueError, match="negative or do not sum to 1"):
        field.distance(f, 2 * w)


def test_paths_of_points():
    vertices, faces = cone()
    surface = gelight.Surface(vertices, faces)
    solver = gelight.ExactSolver(surface)
    field = solver.solve(300)
    for target in range(0, len(vertices), 37):
        path = field.path(target)
        assert path.length == pytest.approx(field.distance(target), abs=1e-12)
        steps = np.linalg.norm(np.diff(path.positions, axis=0), axis=1)
        assert steps.sum() == pytest.approx(path.length)
        assert len(path.faces) == max(0, len(path) - 1)
        assert path.positions[-1] == pytest.approx(vertices[target])
    between = gelight.PathSolver(surface)
    assert between.shortest_path(300, 5).length == pytest.approx(field.distance(5))
    straight = between.straight_path(300, 5)
    assert straight.length >= field.distance(5) - 1e-12
    bent = gelight.Path(surface, [300, 301, 302, 303])
    assert between.straightened(bent).length <= bent.length
    with pytest.raises(IndexError):
        bent[4]
    assert [p.element for p in bent] == [300, 301, 302, 303]


def test_arrivals_on_the_cut_locus():
    vertices, faces = cone(spread=3.0)
    field = gelight.ExactSolver(gelight.Surface(vertices, faces)).solve(1 + 9 * 64)
    opposite = 1 + 9 * 64 + 32
    ways = field.arrivals(opposite, 1e-9)
    assert len(ways) == 2
    assert ways[0].distance == pytest.approx(field.distance(opposite))
    assert ways[0].origin == gelight.vertex_point(1 + 9 * 64)
    assert len(field.arrivals(opposite + 5, 1e-9)) == 1


def test_departure_and_trace_come_back():
    vertices, faces = sheet()
    surface = gelight.Surface(vertices, faces)
    field = gelight.ExactSolver(surface).solve(40)
    way = field.departure(77)
    path = gelight.trace_geodesic(surface, 40, way.direction, field.distance(77))
    assert path.positions[-1] == pytest.approx(vertices[77], abs=1e-9)
    with pytest.raises(ValueError, match="direction"):
        gelight.trace_geodesic(surface, 40, [0, 0, 0], 1)


def test_curves_as_sources():
    vertices, faces = sheet()
    surface = gelight.Surface(vertices, faces)
    bottom = np.flatnonzero(vertices[:, 1] == 0)
    field = gelight.ExactSolver(surface).solve(gelight.Path(surface, bottom))
    assert field.distances() == pytest.approx(vertices[:, 1], abs=1e-9)


def test_circles():
    vertices, faces = sheet(20, 20, 2, 2)
    middle = 10 * 21 + 10
    surface = gelight.Surface(vertices, faces)
    field = gelight.ExactSolver(surface, keep_windows=True).solve(middle)
    (circle,) = field.isolines(0.73)
    assert circle.is_closed
    assert circle.length == pytest.approx(2 * np.pi * 0.73, rel=1e-9)
    assert field.area_within(0.73) == pytest.approx(np.pi * 0.73**2, rel=1e-9)
    (line,) = gelight.isolines(surface, field.distances(), 0.73)
    assert line.length == pytest.approx(2 * np.pi * 0.73, rel=0.01)
    area = gelight.area_below(surface, field.distances(), 0.73)
    assert area == pytest.approx(np.pi * 0.73**2, rel=0.01)
    with pytest.raises(ValueError, match="windows"):
        gelight.ExactSolver(surface).solve(middle).isolines(0.73)


def test_regions():
    vertices, faces = sheet()
    solver = gelight.ExactSolver(gelight.Surface(vertices, faces))
    points = gelight.farthest_points(solver, 4, 0)
    assert points[0] == 0 and points[1] == 116
    for count in range(1, 4):  # each is the farthest from all before it
        before = np.linalg.norm(vertices[:, None] - vertices[points[:count]], axis=2).min(1)
        assert before[points[count]] == pytest.approx(before.max())
    nearest = gelight.voronoi(solver, points)
    truth = points[np.argmin(np.linalg.norm(vertices[:, None] - vertices[points], axis=2), 1)]
    gap = np.abs(np.linalg.norm(vertices - vertices[nearest], axis=1)
                 - np.linalg.norm(vertices - vertices[truth], axis=1))
    assert gap.max() < 1e-12


def test_limits_and_parts():
    a, b = sheet()
    vertices = np.concatenate([a, a + [0, 0, 5]])
    faces = np.concatenate([b, b + len(a)])
    surface = gelight.Surface(vertices, faces)
    assert np.array_equal(np.unique(surface.components), [0, len(a)])
    distance = gelight.ExactSolver(surface).distance(0)
    assert np.all(np.isinf(distance[len(a):])) and np.all(np.isfinite(distance[: len(a)]))
    near = gelight.ExactSolver(surface, max_distance=1.0).distance(0)
    assert np.array_equal(np.isfinite(near), distance <= 1.0)
    targets = gelight.ExactSolver(surface, targets=[1, 2]).distance(0)
    assert np.isfinite(targets[:3]).all() and np.isinf(targets[100])
    field = gelight.ExactSolver(surface).solve(0)
    assert len(field.path(len(a))) == 0
    with pytest.raises(gelight.MemoryLimit):
        gelight.ExactSolver(gelight.icosphere(5), max_memory=1000).distance(0)


def test_certificates_and_plans():
    surface = gelight.icosphere(4)
    exact = gelight.ExactSolver(surface).distance(0)
    marched = gelight.FastMarchingSolver(surface).distance(0)
    bounds = gelight.Certifier(surface).bounds(0, marched)
    assert np.all(bounds.lower <= exact * (1 + 1e-12))
    assert np.all(exact <= bounds.upper * (1 + 1e-12))
    off = np.abs(marched[1:] / exact[1:] - 1)
    assert off.max() <= bounds.error_of(marched).max
    planner = gelight.DistancePlanner(surface, tolerance=0.02)
    assert planner.plan.method in ("dijkstra", "fast_marching", "virtual_source", "exact")
    found = planner.solve(0)
    assert np.array_equal(found.distance, planner.distance(0))
    assert found.satisfies and found.achieved == gelight.Assurance.certified
    off = np.abs(found.distance[1:] / exact[1:] - 1)
    assert off.mean() <= found.error <= 0.02
    with pytest.raises(ValueError, match="tolerance"):
        gelight.DistancePlanner(surface, tolerance=-1)


def always_right(calls):
    """A method of Python's own that answers with the exact distances, for next to nothing."""

    def make(surface):
        solver = gelight.ExactSolver(surface)

        def query(sources):
            calls.append(sources)
            return solver.distance(sources)

        return query

    cost = gelight.MethodCost(query_ns=1e-3)
    return gelight.PlanMethod("mine", cost, gelight.RelativeError(1e-9, 1e-9), make)


def test_plans_choose_methods_of_the_callers_own():
    surface = gelight.icosphere(3)
    exact = gelight.ExactSolver(surface).distance(5)
    calls = []
    planner = gelight.DistancePlanner(
        surface,
        tolerance=1e-6,
        assurance=gelight.Assurance.expected,
        methods=[always_right(calls)],
    )
    assert planner.plan.method == "mine"
    found = planner.solve(gelight.Source(5))
    assert found.method == "mine" and found.satisfies and found.error <= 1e-6
    assert np.array_equal(found.distance, exact)
    assert len(calls) == 1 and len(calls[0]) == 1
    # In several threads, and after all names of it are gone.
    with ThreadPoolExecutor(3) as pool:
        for distance in pool.map(planner.distance, [5] * 6):
            assert np.array_equal(distance, exact)


def test_what_a_method_of_the_callers_own_does_wrong_is_told():
    surface = gelight.icosphere(2)
    cost, error = gelight.MethodCost(), gelight.RelativeError(0, 0)

    def fails(sources):
        raise KeyError("mine")

    for query, failure, words in (
        (lambda sources: [1.0, 2.0], ValueError, "2 distances of 162"),
        (lambda sources: np.full(162, np.nan), ValueError, "nan at vertex 0"),
        (lambda sources: np.zeros((162, 1)), ValueError, "shape"),
        (lambda sources: "far", TypeError, "distances"),
        (lambda sources: None, TypeError, "distances"),
        (fails, KeyError, "mine"),
    ):
        method = gelight.PlanMethod("mine", cost, error, lambda surface, query=query: query)
        with pytest.raises(failure, match=words):
            gelight.DistancePlanner(
                surface, assurance=gelight.Assurance.expected, methods=[method]
            ).distance(0)
    with pytest.raises(TypeError, match="cannot be called"):
        gelight.PlanMethod("mine", cost, error, 7)
    with pytest.raises(ValueError, match="mine"):
        wrong = gelight.PlanMethod("mine", cost, gelight.RelativeError(1, 0), fails)
        gelight.DistancePlanner(surface, methods=[wrong])
    with pytest.raises(TypeError):
        gelight.DistancePlanner(surface, methods=[fails])


def test_plans_follow_costs():
    surface = gelight.icosphere(4)
    costs = gelight.PlanCosts()
    assert costs.exact.seconds(10000, 2) > costs.dijkstra.seconds(10000, 2) > 0
    plan = gelight.DistancePlanner(surface, tolerance=0.02, costs=costs).plan
    assert plan.method == gelight.DistancePlanner(surface, tolerance=0.02).plan.method != "exact"
    costs.exact = gelight.MethodCost(query_ns=1e-3)  # no other is as cheap
    assert gelight.DistancePlanner(surface, tolerance=0.02, costs=costs).plan.method == "exact"
    costs.exact.query_ns = np.nan
    with pytest.raises(ValueError, match="exact"):
        gelight.DistancePlanner(surface, costs=costs)
    with pytest.raises(gelight.Cancelled):
        gelight.measured_plan_costs(cancelled=lambda done: True)


def test_heat_tells_its_error():
    surface = gelight.icosphere(3)
    result = gelight.HeatSolver(surface, refinements=1).solve(0)
    assert result.is_reliable and 0 < result.error < 0.07
    with pytest.raises(ValueError, match="time factor"):
        gelight.HeatSolver(surface, time_factor=0)
