"""What goes wrong from Python's side: right all the same, or refused with words."""

import array
import gc
import threading

import numpy as np
import pytest

import gelight
from shapes import sheet

CAMERA = gelight.Camera.from_vertical_fov(1.0, 64, 48)
BALL, HERE = gelight.icosphere(3, 0.3), gelight.Pose(None, [0, 0, 2])


def flat_renderer(camera=CAMERA):
    shape = (camera.height, camera.width)
    light = gelight.Light(np.tile(np.float32([1, 0, 0]), (*shape, 1)))
    return gelight.TactileRenderer(camera, np.full(shape, 2, np.float32), [light])


class Lookalike:
    """Of which NumPy makes an array, anew each time."""

    def __init__(self, values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype=dtype)


@pytest.mark.parametrize("make", [lambda a: a.tolist(), Lookalike, lambda a: None])
def test_only_arrays_are_written_to(make):
    """Else what was written would be gone with a copy."""
    image, depth = np.zeros((48, 64, 3), np.uint8), np.full((48, 64), np.inf, np.float32)
    renderer = flat_renderer()
    dots = gelight.PrintedDots(CAMERA, np.full((48, 64), 2.0), [(30, 20)], 0.1)
    for call in (lambda: gelight.add_noise(make(image), 3.0, 1),
                 lambda: renderer.render_into(make(image), depth),
                 lambda: dots.draw_into(make(image)),
                 lambda: gelight.rasterize_into(make(depth), BALL, HERE, CAMERA)):
        with pytest.raises(TypeError, match="not an array to be written to"):
            call()


def test_the_machines_own_order_of_bytes_however_it_is_said():
    """A type that is another object than NumPy's own, yet the same, is written in place."""
    own = np.full((48, 64), np.inf, np.float32)
    turned = own.astype(">f4").byteswap().view(np.dtype(">f4").newbyteorder())
    tagged = own.view(np.dtype(np.float32, metadata={"unit": "m"}))
    gelight.rasterize_into(own, BALL, HERE, CAMERA)
    for depth in (turned, tagged):
        gelight.rasterize_into(depth, BALL, HERE, CAMERA)
        assert np.array_equal(depth, own)
    with pytest.raises(TypeError, match=">f4"):
        gelight.rasterize_into(own.astype(">f4"), BALL, HERE, CAMERA)


def test_depths_in_any_bytes():
    depth = np.full((48, 64), np.inf, np.float32)
    gelight.rasterize_into(depth, BALL, HERE, CAMERA)
    renderer = flat_renderer()
    truth = renderer.render(depth)
    odd = np.zeros(depth.nbytes + 1, np.uint8)[1:].view(np.float32).reshape(depth.shape)  # unaligned
    odd[:] = depth
    read_only = depth.copy()
    read_only.flags.writeable = False
    record = np.zeros(depth.shape, np.dtype([("a", "i1"), ("z", "<f4")]))
    record["z"] = depth
    for given in (odd, read_only, record["z"], depth.astype(">f4"), depth.astype(">f8"),
                  depth.tolist(), Lookalike(depth), depth[::-1].copy()[::-1],
                  np.ma.masked_array(depth)):
        assert np.array_equal(renderer.render(given), truth)


def test_hooks_are_callable():
    with pytest.raises(TypeError, match="cancelled is 5, which cannot be called"):
        gelight.ExactSolver(BALL, cancelled=5)
    with pytest.raises(ValueError, match="truth"):
        gelight.ExactSolver(gelight.icosphere(5), cancelled=lambda done: np.zeros(2)).distance(0)


def test_frames_of_another_renderer_are_refused_and_stay():
    frame = flat_renderer().rest_frame()
    image = frame.image
    before = image.copy()
    other = gelight.Camera.from_vertical_fov(1.0, 640, 480)
    with pytest.raises(ValueError):
        flat_renderer(other).render_next_into(frame, np.full((480, 640), 2, np.float32))
    gc.collect()
    assert np.array_equal(image, before)
    # Of the same size, too: where nothing changes its image would stay.
    light = gelight.Light(np.tile(np.float32([0, 1, 0]), (48, 64, 1)), rgb=(0, 1, 0))
    green = gelight.TactileRenderer(CAMERA, np.full((48, 64), 2, np.float32), [light])
    depth = np.full((48, 64), np.inf, np.float32)
    gelight.rasterize_into(depth, BALL, HERE, CAMERA)
    with pytest.raises(ValueError, match="the frame is of another renderer"):
        green.render_next_into(frame, depth)
    assert np.array_equal(image, before)
    frame = green.rest_frame()
    green.render_next_into(frame, depth)
    assert np.array_equal(frame.image, green.render(depth))


def test_threads_that_share_what_is_of_one():
    """Each call is done, or refused in words; nothing breaks."""
    renderer = flat_renderer()
    frame, work = renderer.rest_frame(), gelight.RasterWorkspace()
    told, done = [], []

    def draw(k):
        depth = np.full((48, 64), np.inf, np.float32)
        for turn in range(100):
            try:
                gelight.rasterize_into(depth, BALL, gelight.Pose(None, [0.01 * k, 0, 2]), CAMERA, work)
                renderer.render_next_into(frame, depth)
                done.append(k)
            except ValueError as error:
                told.append(str(error))

    threads = [threading.Thread(target=draw, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert done and all("is in use by another thread" in words for words in told)
    depth = np.full((48, 64), np.inf, np.float32)
    gelight.rasterize_into(depth, BALL, HERE, CAMERA, work)
    renderer.render_next_into(frame, depth)
    assert np.array_equal(frame.image, renderer.render(depth))


def test_results_are_not_made_by_hand():
    for kind in (gelight.ExactField, gelight.MeshReport, gelight.Raster, gelight.TactileFrame,
                 gelight.DistancePlan, gelight.PlannedDistances):
        with pytest.raises(TypeError, match=f"{kind.__name__}: No constructor"):
            kind()


def test_faces_of_any_whole_numbers():
    vertices, faces = sheet()
    truth = gelight.Surface(vertices, faces).faces
    for kind in ("i1", "u1", ">i2", "u2", "<u4", ">i8", "u8", np.longlong, np.intp):
        assert np.array_equal(gelight.Surface(vertices, faces.astype(kind)).faces, truth)
    for k in (2**31, 2**32 + 5, 2**63 - 1, -(2**31) - 1, -(2**63)):
        bad = faces.astype(np.int64)
        bad[7, 1] = k
        with pytest.raises(ValueError, match="beyond what an index can be"):
            gelight.Surface(vertices, bad)
    assert np.array_equal(gelight.Surface(memoryview(vertices), memoryview(faces)).faces, truth)
    with pytest.raises(ValueError, match="shape"):
        gelight.Surface(array.array("d", [1, 2, 3]), faces)


def test_outputs_of_distances():
    surface = gelight.icosphere(2)
    solver = gelight.DijkstraSolver(surface)
    truth = solver.distance(3)
    n = surface.vertex_count
    wide = np.zeros(2 * n)
    for out, error in ((np.zeros(n - 1), ValueError), (np.zeros((n, 1)), ValueError),
                       (np.zeros(0), ValueError), (wide[::2], TypeError),
                       (np.zeros(n, np.float32), TypeError), (np.zeros(n, ">f8"), TypeError),
                       ([0.0] * n, TypeError), (surface.vertices[:, 0], TypeError)):
        with pytest.raises(error):
            solver.distance_into(out, 3)
    fixed = np.zeros(n)
    fixed.flags.writeable = False
    with pytest.raises(ValueError):
        solver.distance_into(fixed, 3)
    out = np.full(n, np.nan)
    solver.distance_into(out, 3)
    assert np.array_equal(out, truth) and not wide.any()


def test_numbers_that_are_not_aligned():
    vertices, faces = sheet()

    def shifted(numbers):
        odd = np.zeros(numbers.nbytes + 1, np.uint8)[1:].view(numbers.dtype).reshape(numbers.shape)
        odd[:] = numbers
        return odd

    truth = gelight.Surface(vertices, faces)
    surface = gelight.Surface(shifted(vertices), shifted(faces.astype(np.int32)))
    assert np.array_equal(surface.vertices, truth.vertices)
    assert np.array_equal(surface.faces, truth.faces)
    solver = gelight.DijkstraSolver(surface)
    with pytest.raises(ValueError, match="not aligned"):
        solver.distance_into(shifted(np.zeros(len(vertices))), 0)


def test_what_lies_under_a_mask_is_no_value():
    vertices, faces = sheet()
    depth = np.full((48, 64), 2.0, np.float32)
    hidden = np.zeros(depth.shape, bool)
    hidden[3, 4] = True
    for call in (lambda: gelight.Surface(np.ma.masked_greater(vertices, 1.5), faces),
                 lambda: flat_renderer().render(np.ma.masked_array(depth, hidden)),
                 lambda: gelight.DijkstraSolver(BALL).distance(np.ma.masked_equal([1, 2], 2))):
        with pytest.raises(ValueError, match="masked numbers"):
            call()
    assert np.array_equal(gelight.Surface(np.ma.masked_greater(vertices, 9), faces).vertices, vertices)


def test_nothing_is_written_beneath_a_mask():
    depth = np.ma.masked_array(np.full((48, 64), 2.0, np.float32), False)
    depth[3, 4] = np.ma.masked
    distances = np.ma.masked_array(np.full(BALL.vertex_count, 7.0), False)
    distances[5] = np.ma.masked
    for call in (lambda: gelight.rasterize_into(depth, BALL, HERE, CAMERA),
                 lambda: gelight.DijkstraSolver(BALL).distance_into(distances, 0)):
        with pytest.raises(ValueError, match="1 masked numbers"):
            call()
    assert (depth.data == 2).all() and (distances.data == 7).all()
    unmasked = np.ma.masked_array(np.zeros(BALL.vertex_count))
    gelight.DijkstraSolver(BALL).distance_into(unmasked, 0)
    assert np.array_equal(unmasked.data, gelight.DijkstraSolver(BALL).distance(0))


def test_bytes_and_truths_are_no_vertices():
    solver = gelight.DijkstraSolver(BALL)
    for sources in (True, [True, False], b"\1\2", bytearray(2)):
        with pytest.raises(TypeError):
            solver.distance(sources)
    for truth in (True, np.True_, np.array(True), np.array([True])[0]):
        with pytest.raises(TypeError, match="True.*, not a whole number"):
            gelight.vertex_point(truth)
        for sources in (truth, [truth], [0, truth]):
            with pytest.raises(TypeError):
                solver.distance(sources)
    assert np.array_equal(solver.distance(np.uint8(2)), solver.distance([2]))


def test_rows_of_vertices_are_rows():
    solver, square = gelight.ExactSolver(BALL), np.array([[0, 1], [2, 3]])
    for call in (lambda: gelight.voronoi(solver, square),
                 lambda: gelight.DistancePlanner(BALL, targets=square),
                 lambda: gelight.VectorHeatSolver(BALL).extend(square, [1.0, 2, 3, 4])):
        with pytest.raises(ValueError, match=r"shape \(2, 2\)"):
            call()


@pytest.mark.skipif(not hasattr(gelight, "read_png"), reason="without stb's headers")
def test_names_of_files(tmp_path):
    """The whole of each: what stands behind a null character, too, and what is not text."""
    image = np.zeros((2, 2, 3), np.uint8)
    with pytest.raises(ValueError, match="null character"):
        gelight.write_png(str(tmp_path / "a\0b.png"), image)
    with pytest.raises(ValueError, match="null character"):
        gelight.read_sensor("a\0b")
    assert list(tmp_path.iterdir()) == []
    name = bytes(tmp_path) + b"/\xff\xfe.png"
    gelight.write_png(name, image)
    assert np.array_equal(gelight.read_png(name), image)
