"""Every class of the module: copies of plain data are equal, other objects are not copied, and what
no constructor made is refused wherever it is used."""

import copy
import inspect
import pickle
import subprocess
import sys

import numpy as np
import pytest

import gelight
from test_stubs import signature

CLASSES = [v for v in vars(gelight).values()
           if isinstance(v, type) and not issubclass(v, Exception)]
ENUMERATIONS = [c for c in CLASSES if hasattr(c, "__members__")]
OBJECTS = [c for c in CLASSES if not hasattr(c, "__members__")]


def everything():
    """An object of every class that is no enumeration."""
    surface = gelight.icosphere(2)
    exact = gelight.ExactSolver(surface, keep_windows=True)
    field = exact.solve([0, 7])
    smooth = gelight.SmoothDistanceSolver(surface, surface.vertices)
    smoothed = smooth.solve(0)
    planner = gelight.DistancePlanner(surface)
    vectors = gelight.VectorHeatSolver(surface)
    maps = gelight.ExactLogMapSolver(surface)
    certifier = gelight.Certifier(surface)
    camera = gelight.Camera.from_vertical_fov(1.0, 16, 12)
    rest = np.full((12, 16), 0.02, np.float32)
    depth = rest.copy()
    depth[4:8, 5:9] = 0.019
    depth[0, 0] = np.nan
    bed, layer = gelight.SpringBed(camera, 0.02), gelight.ElasticLayer(camera, 0.02)
    light = gelight.Light(np.tile(np.float32([0.6, 0, 0.8]), (12, 16, 1)), (0.1, 1, 0.3), 0.4)
    renderer = gelight.TactileRenderer(camera, rest, [light])
    sensor = gelight.geltip(8, 6, 0.005)
    sensor.led_width = 0.002
    background = 120 + np.random.default_rng(0).integers(0, 2, (60, 80, 3)).astype(np.uint8)
    v, u = np.mgrid[:60, :80].astype(float)
    presses = []
    for i in range(8):
        x, y = 20 + 5.5 * i, 18 + 6.0 * (i % 4)
        inside = (u - x) ** 2 + (v - y) ** 2 <= 11**2
        slope = np.stack([u - x, v - y, x - u], 2) * inside[..., None]
        photograph = (120 + 2.4 * slope).clip(0, 255).astype(np.uint8)
        presses.append(gelight.BallPress(photograph, 40.0, (x, y, 11.0), f"press {i}"))
    fitted = gelight.calibrate(background, presses, bulge_length=2.0)
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    cost = gelight.MethodCost(1, 2, 3, 4)
    costs = gelight.PlanCosts()
    costs.exact, costs.sample_share = cost, 0.5
    geodesic = gelight.GeodesicLight(surface)
    plan = gelight.plan_sensor(lambda edge: gelight.gelsight_mini(48, 36, edge), tolerance=200.0,
                               share=0.5, reference_edge=0.002, contacts=2,
                               light=gelight.PlannedLight.linear)
    things = [
        surface, gelight.face_point(3, (0.2, 0.3, 0.5)), gelight.Source(5, 0.25),
        gelight.check(surface.vertices, np.concatenate([surface.faces, [[3, 3, 4]]])),
        gelight.repair(surface.vertices, surface.faces[1:], orient=True), field.path(30),
        gelight.DijkstraSolver(surface), gelight.FastMarchingSolver(surface),
        gelight.VirtualSourceSolver(surface), gelight.HeatSolver(surface),
        gelight.HeatSolver(surface).solve(3), field.arrivals(30)[0], field.departure(30),
        field.isolines(0.5)[0], field.isolines(0.5)[0].arcs[0], field, exact,
        gelight.exact_voronoi_edges(field)[0], gelight.PathSolver(surface), smoothed,
        smooth.path(smoothed, 30), smooth, gelight.RelativeError(0.1, 0.2),
        certifier.bounds(0, exact.distance(0)), certifier, cost, costs,
        gelight.PlanMethod("mine", cost, gelight.RelativeError(0, 0), lambda surface: None),
        planner, planner.plan, planner.solve(0), vectors, vectors.solve(0, [0, 0, 1.0]),
        vectors.solve_log_map(0), maps, maps.solve(0), gelight.ParallelTransport(surface), camera,
        gelight.Pose(turn, (1, 2, 3)), gelight.RasterWorkspace(),
        gelight.rasterize(gelight.box(0.02, 0.02, 0.5), camera), gelight.Led([3, 4], (0, 0, 1)),
        geodesic.rays(0, [1, 2, 3]), geodesic, gelight.LinearLight(surface),
        gelight.PlaneLight(surface), gelight.TransportLight(surface), gelight.GelLight(surface),
        light, gelight.Gel(thickness=0.004), bed, bed.press(depth, 1.0), layer, layer.press(depth),
        gelight.GaussianMembrane(), gelight.BulgingMembrane(camera, 0.02),
        gelight.SpringMembrane(bed, 1.0), gelight.TensionMembrane(3.0), gelight.LayerMembrane(layer),
        gelight.TactileOptions(ambient=0.3, rectify=True, specular=gelight.Specular.unclamped),
        renderer, renderer.rest_frame(), gelight.LightLevels(0.2, 0.7),
        gelight.SeeThroughOptions(levels=gelight.LightLevels(0.1, 0.9), exposure=3),
        gelight.SeeThroughRenderer(camera, rest, [light]),
        gelight.PrintedDots(camera, rest, [(8, 6)], 0.001), presses[0], fitted.presses[0],
        fitted.regions[0], fitted.sensor, fitted, gelight.Falloff(2, 3), sensor,
        gelight.level_difference(background, photograph), gelight.PyramidMembrane([3, 2]),
        gelight.ContactShadow(contact=0.1, sigma=2, radius=5, gap=1),
        gelight.ShadowedMembrane(camera), gelight.FlatGelSightMembrane(),
        gelight.DraggedMarkers((1, 2), (3, 4), 5, 6),
        gelight.GaussianMarkers([(1, 2, 3), (4, 5, 6)], (7, 8), shift=(9, 10), twist=0.1,
                                push_decay=0.2, shift_decay=0.3, twist_decay=0.4),
        plan, plan.steps[0],
    ]
    if hasattr(gelight, "LightTracer"):
        tracer = gelight.LightTracer(surface)
        traced = tracer.trace((0, 0, 0), (0, 0, 1), paths=1000)
        things += [gelight.InnerLayer(surface, 1.2, 0.5), tracer, traced, traced.balance]
    return {type(thing): thing for thing in things}


THINGS = everything()

# What works, not what it found, or what an open solver is part of.
NOT_DATA = {
    "DijkstraSolver", "FastMarchingSolver", "VirtualSourceSolver", "HeatSolver", "ExactField",
    "ExactSolver", "PathSolver", "SmoothDistances", "SmoothDistanceSolver", "Certifier",
    "PlanMethod", "DistancePlanner", "VectorHeatSolver", "ExactLogMap", "ExactLogMapSolver",
    "ParallelTransport", "RasterWorkspace", "LinearLight", "PlaneLight", "GeodesicLight",
    "TransportLight", "GelLight", "LightTracer", "SpringBed", "ElasticLayer", "Membrane",
    "GaussianMembrane", "BulgingMembrane", "SpringMembrane", "TensionMembrane", "LayerMembrane",
    "PyramidMembrane", "ShadowedMembrane", "FlatGelSightMembrane",
    "TactileFrame", "TactileRenderer", "SeeThroughRenderer", "PrintedDots", "CalibratedSensor",
    "Calibration",
}
DATA = [c for c in OBJECTS if c.__name__ not in NOT_DATA]


def copies(thing):
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        yield pickle.loads(pickle.dumps(thing, protocol))
    yield copy.copy(thing)
    yield copy.deepcopy(thing)


def value(thing):
    """All that can be read of an object, numbers as their bytes."""
    if isinstance(thing, np.ndarray):
        return thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, (list, tuple)):
        return [value(one) for one in thing]
    if type(thing) not in DATA:
        return repr(thing)
    named = {name: value(getattr(thing, name)) for name, member in inspect.getmembers(type(thing))
             if type(member) is property}
    return named, value(thing.__getstate__())


def test_there_is_one_of_every_class():
    assert set(THINGS) == set(OBJECTS) - {gelight.Membrane}  # that is only a base


@pytest.mark.parametrize("kind", DATA, ids=lambda kind: kind.__name__)
def test_copies_of_data_are_equal(kind):
    thing = THINGS[kind]
    before = value(thing)
    for other in copies(thing):
        assert type(other) is kind and other is not thing and value(other) == before


@pytest.mark.parametrize("kind", [c for c in THINGS if c.__name__ in NOT_DATA],
                         ids=lambda kind: kind.__name__)
def test_copying_others_is_refused(kind):
    thing = THINGS[kind]
    calls = [lambda p=p: pickle.dumps(thing, p) for p in range(pickle.HIGHEST_PROTOCOL + 1)]
    for call in (*calls, lambda: copy.copy(thing), lambda: copy.deepcopy(thing)):
        with pytest.raises(TypeError, match=f"gelight.{kind.__name__} cannot be pickled or copied"):
            call()


@pytest.mark.parametrize("kind", ENUMERATIONS, ids=lambda kind: kind.__name__)
def test_copies_of_enumerators_are_equal(kind):
    for member in kind.__members__.values():
        assert all(other == member and repr(other) == repr(member) for other in copies(member))


def test_copies_have_their_own_memory_and_work_alike():
    light = THINGS[gelight.Light]
    other = copy.copy(light)
    other.diffuse = 0.125
    assert light.diffuse != 0.125 and not np.shares_memory(light.direction, other.direction)
    surface = gelight.icosphere(3)
    twin = pickle.loads(pickle.dumps(surface))
    found = gelight.ExactSolver(twin).distance(7)
    assert np.array_equal(found, gelight.ExactSolver(surface).distance(7))
    sensor = gelight.geltip(16, 12, 0.005)
    images = [gelight.tactile_renderer(s).rest_image for s in (sensor, copy.deepcopy(sensor))]
    assert images[0].any() and np.array_equal(*images)


def test_pickles_of_what_cannot_be_are_refused():
    surface = gelight.icosphere(0)
    _, _, (vertices, faces) = surface.__reduce__()
    with pytest.raises(gelight.InvalidInput, match="has vertex 87"):
        gelight.Surface.__new__(gelight.Surface).__setstate__((vertices, faces + 87))
    for state in (None, (), (1,), ("a", "b"), (vertices, faces, 3)):
        with pytest.raises(TypeError):
            gelight.Surface.__new__(gelight.Surface).__setstate__(state)


class Named(gelight.Camera):
    """With a name of the caller's."""


def test_classes_of_the_callers_own():
    camera = Named(10, 11, 3, 4, 8, 6)
    other = pickle.loads(pickle.dumps(camera))
    assert type(other) is Named and other.fy == 11
    camera.name = "left"
    for call in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(TypeError, match="Named has attributes of its own"):
            call(camera)


HALF_MADE = """
import gelight
import test_stubs


def check(kind):
    half = kind.__new__(kind)
    left = ("__init__", "__new__", "__setstate__", "__eq__", "__ne__", "__hash__")
    for owner in kind.__mro__[:-2]:
        for name, member in vars(owner).items():
            if type(member) is property:  # none of pybind11's, which are the class's
                call = lambda: member.fget(half)
            elif type(member).__name__ == "instancemethod" and name not in left:
                names = test_stubs.signature(member)
                call = lambda: member(half, **{n: 0 for n in names})
            else:
                continue
            try:
                call()
            except TypeError as error:
                words = str(error)
                assert "was not constructed" in words or name == "__reduce__", (name, words)
            else:
                assert hasattr(kind, "__members__"), name
    for use in (repr, str, hash, lambda half: half == half, lambda half: half != kind):
        try:
            use(half)
        except TypeError:
            pass
    for user in (lambda: gelight.ExactSolver(half), lambda: gelight.Source(half),
                 lambda: gelight.Led(half), lambda: gelight.joined([half]),
                 lambda: gelight.tactile_renderer(half, half), lambda: gelight.pixel_points(half),
                 lambda: gelight.predict(half, (1, 2, 3), 4)):
        try:
            user()
        except TypeError:
            continue
        raise AssertionError("not refused")


for kind in vars(gelight).values():
    if isinstance(kind, type) and not issubclass(kind, Exception):
        print(kind.__name__, flush=True)
        check(kind)
"""


def test_what_no_constructor_made_is_refused():
    """In a process of its own, which a crash would end."""
    path = ":".join(p for p in sys.path if p)
    done = subprocess.run([sys.executable, "-B", "-c", HALF_MADE], capture_output=True, text=True,
                          timeout=120, env={"PYTHONPATH": path})
    names = done.stdout.split()
    assert done.returncode == 0, f"gelight.{names[-1]}: {done.stderr[-2000:]}"
    assert names == [kind.__name__ for kind in CLASSES]


def test_methods_before_the_constructor_are_refused():
    class Eager(gelight.Surface):
        def __init__(self):
            self.seen = self.vertex_count
            super().__init__(np.eye(3), [[0, 1, 2]])

    class Lazy(Eager):
        def __init__(self):
            gelight.Surface.__init__(self, np.eye(3), [[0, 1, 2]])

    with pytest.raises(TypeError, match="its __init__ was not called"):
        Eager()
    assert Lazy().vertex_count == 3
