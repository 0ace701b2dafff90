"""Whose memory an array is, how long it lives, and what threads and Ctrl-C do."""

import gc
import os
import signal
import threading
import time

import numpy as np
import pytest

import gelight


def address(array):
    return array.__array_interface__["data"][0]


def owner(array):
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array.base


def test_results_own_the_solvers_memory():
    surface = gelight.icosphere(3)
    field = gelight.ExactSolver(surface).solve(0)
    for array in (field.distances(), field.path(7).positions,
                  gelight.VectorHeatSolver(surface).radial(0)):
        assert not array.flags.owndata and type(owner(array)).__name__ == "PyCapsule"
        assert array.flags.writeable and array.flags.c_contiguous


def test_views_are_the_objects_own_memory():
    surface = gelight.icosphere(2)
    assert owner(surface.vertices) is surface
    assert address(surface.vertices) == address(surface.vertices)
    assert not surface.vertices.flags.writeable
    camera = gelight.Camera.from_vertical_fov(1.0, 32, 24)
    raster = gelight.rasterize(gelight.icosphere(2), camera)
    for name in ("depth", "face", "barycentric"):
        array = getattr(raster, name)
        assert owner(array) is raster and address(array) == address(getattr(raster, name))


def test_written_into_the_callers_memory():
    """Strided images are drawn where they lie: their neighbours stay, and nothing moves."""
    camera = gelight.Camera.from_vertical_fov(1.0, 32, 24)
    whole = np.full((48, 96), 5.0, np.float32)
    part = whole[12:36, 32:64]
    part[:] = np.inf
    before = address(part)
    gelight.rasterize_into(part, gelight.icosphere(2, 0.3), gelight.Pose(None, [0, 0, 2]), camera)
    assert address(part) == before and np.isfinite(part).any()
    outside = np.ones(whole.shape, bool)
    outside[12:36, 32:64] = False
    assert np.all(whole[outside] == 5)


def test_arrays_outlive_what_made_them():
    surface = gelight.icosphere(3)
    solver = gelight.ExactSolver(surface)
    field = solver.solve(0)
    path = field.path(100)
    arrays = [surface.vertices, field.distances(), path.positions,
              gelight.SmoothDistanceSolver(surface).solve(0).direction,
              gelight.HeatSolver(surface).solve(0).distance]
    camera = gelight.Camera.from_vertical_fov(1.0, 32, 24)
    arrays.append(gelight.rasterize(surface, camera).depth)
    light = gelight.Light(np.tile(np.float32([1, 0, 0]), (24, 32, 1)))
    renderer = gelight.TactileRenderer(camera, np.ones((24, 32), np.float32), [light])
    frame = renderer.rest_frame()
    arrays += [renderer.rest_image, frame.image, light.direction]
    copies = [a.copy() for a in arrays]
    del surface, solver, field, light, renderer, frame
    gc.collect()
    churn = [np.random.bytes(len(a.tobytes())) for a in arrays for _ in range(5)]
    for array, copy in zip(arrays, copies):
        assert np.array_equal(array, copy)
    assert churn and path.length > 0 and path[0].element == 0


def test_inputs_may_go():
    vertices, faces = np.array(gelight.icosphere(2).vertices), gelight.icosphere(2).faces
    surface = gelight.Surface(vertices, faces)
    truth = gelight.ExactSolver(surface).distance(0)
    vertices[:] = 0
    del faces
    gc.collect()
    assert np.array_equal(gelight.ExactSolver(surface).distance(0), truth)


def test_no_leak():
    surface = gelight.icosphere(4)
    solver = gelight.FastMarchingSolver(surface)

    def resident():
        return int(open("/proc/self/statm").read().split()[1]) * os.sysconf("SC_PAGESIZE")

    if not os.path.exists("/proc/self/statm"):
        pytest.skip("no /proc")
    for _ in range(20):
        solver.distance(0)
    before = resident()
    for _ in range(200):
        solver.distance(0)
        with pytest.raises(ValueError):
            solver.distance(-1)
    assert resident() - before < 2_000_000  # one result alone has 20 kB


def test_other_threads_run_meanwhile():
    """A thread that counts gets on while another solves: the interpreter is free."""
    solver = gelight.ExactSolver(gelight.icosphere(5))
    solving, counts = threading.Event(), []

    def solve():
        solving.set()
        solver.distance(0)
        solving.clear()

    worker = threading.Thread(target=solve)
    worker.start()
    solving.wait()
    while solving.is_set():
        counts.append(time.perf_counter())
        time.sleep(0.001)
    worker.join()
    assert len(counts) > 10


def test_one_solver_from_several_threads():
    solver = gelight.ExactSolver(gelight.icosphere(3))
    truth = [solver.distance(v) for v in range(8)]
    found = [None] * 8

    def solve(v):
        for _ in range(5):
            found[v] = solver.distance(v)

    threads = [threading.Thread(target=solve, args=(v,)) for v in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(a, b) for a, b in zip(truth, found))


def test_cancelled():
    shares = []

    def ask(done):
        shares.append(done)
        return len(shares) > 3

    solver = gelight.ExactSolver(gelight.icosphere(5), cancelled=ask)
    with pytest.raises(gelight.Cancelled, match="cancelled"):
        solver.distance(0)
    assert shares == sorted(shares) and len(shares) == 4

    def broken(done):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        gelight.HeatSolver(gelight.icosphere(3), cancelled=broken)


def test_ctrl_c_ends_long_work():
    solver = gelight.ExactSolver(gelight.icosphere(6))
    timer = threading.Timer(0.4, lambda: os.kill(os.getpid(), signal.SIGINT))
    # Where Python was begun in the background, it ignores the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    start = time.perf_counter()
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            for _ in range(100):
                solver.distance(0)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert time.perf_counter() - start < 20
