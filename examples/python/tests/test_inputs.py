"""What cannot be used is refused, with words; what can be used in another layout is."""

import numpy as np
import pytest

import gelight
from shapes import sheet

V, F = sheet()


def test_errors_are_the_usual_ones():
    assert issubclass(gelight.InvalidInput, ValueError)
    assert issubclass(gelight.MemoryLimit, MemoryError)
    assert issubclass(gelight.Cancelled, RuntimeError)


def with_nan():
    bad = V.copy()
    bad[5, 1] = np.nan
    return bad


@pytest.mark.parametrize("vertices, faces, words", [
    (with_nan(), F, r"vertex 5 has position .*nan.*not finite"),
    (V * 1e80, F, r"too far out"),
    (V[:, :2], F, r"vertices has shape \(117, 2\), not \(any, 3\)"),
    (V.ravel(), F, r"vertices has shape \(351,\)"),
    (V, F[:, :2], r"faces has shape \(192, 2\)"),
    (V, F + 50, r"has vertex 117, the mesh has vertices 0 to 116"),
    (V, F - 1, r"has vertex -1"),
    (V, np.concatenate([F, [[3, 3, 4]]]), r"face 192"),
    (V, np.concatenate([F, F[:1]]), r"192"),
    (V, F.astype(np.int64) + 2**40, r"beyond what an index can be"),
    (V, F.astype(np.uint64) + np.uint64(2**63), r"beyond what an index can be"),
    (V, np.empty((0, 3), int), r"faces"),
    (np.empty((0, 3)), np.empty((0, 3), int), r"vertices"),
    ([], [], r"shape"),
])
def test_meshes_refused(vertices, faces, words):
    with pytest.raises(gelight.InvalidInput, match=words):
        gelight.Surface(vertices, faces)


@pytest.mark.parametrize("vertices, faces", [
    (V.astype(complex), F), (V.astype(str), F), (V.astype(object), F), (V, F.astype(float)),
    (V, F.astype(bool)), (None, F), (V, None), ("mesh", F),
])
def test_types_refused(vertices, faces):
    with pytest.raises(TypeError):
        gelight.Surface(vertices, faces)


def test_any_layout_of_a_mesh():
    truth = gelight.Surface(V, F)
    wide = np.zeros((len(V), 8))
    wide[:, 1:7:2] = V
    for vertices in (V.tolist(), wide[:, 1:7:2], V[::-1].copy()[::-1], np.asfortranarray(V),
                     V.astype(">f8"), V.astype(np.float128) if hasattr(np, "float128") else V):
        for faces in (F.tolist(), F.astype(np.uint8), F.astype(">i4"), np.asfortranarray(F)):
            surface = gelight.Surface(vertices, faces)
            assert np.array_equal(surface.vertices, truth.vertices)
            assert np.array_equal(surface.faces, truth.faces)
    whole = np.round(V).astype(int) * 0 + np.arange(len(V))[:, None] ** [1, 2, 1]
    assert gelight.Surface(whole, F).vertices[3].tolist() == [3, 9, 3]


def test_check_and_repair():
    bad = np.concatenate([F, [[3, 3, 4], [0, 1, 500]], F[:1]])
    report = gelight.check(with_nan(), bad)
    assert not report.is_accepted
    assert report.not_finite == (1, [5])
    assert report.repeated_vertices == (1, [192])
    assert report.out_of_range == (1, [193])
    assert report.repeated_faces[0] == 1
    assert "with a vertex twice: 192 (refused)" in str(report)
    seam = np.concatenate([V, V[:13]])
    torn = F.copy()
    torn[:12][torn[:12] < 13] += 117
    fixed = gelight.repair(seam, torn, weld_distance=0.0, drop_unused_vertices=True)
    assert fixed.welded_vertices == 13
    assert len(fixed.vertices) == 117 and fixed.vertex_of.tolist() == list(range(117))
    assert gelight.check(fixed.vertices, fixed.faces).is_oriented
    left = gelight.repair(with_nan(), bad, drop_unusable_faces=True, drop_unused_vertices=True)
    assert gelight.Surface(left.vertices, left.faces).vertex_count == 116
    order = np.random.default_rng(1).permutation(len(V))
    tidy = gelight.repair(V[order], np.argsort(order)[F], order_in_space=True)
    assert np.array_equal(tidy.vertices, V[order][tidy.vertex_of])
    assert np.array_equal(order[tidy.vertex_of][tidy.faces], F[tidy.face_of])
    with pytest.raises(ValueError, match="weld distance"):
        gelight.repair(V, F, weld_distance=-1.0)


@pytest.mark.parametrize("source, error", [
    (117, gelight.InvalidInput), (-1, gelight.InvalidInput), (2**40, gelight.InvalidInput),
    ([], gelight.InvalidInput), (np.array([], int), gelight.InvalidInput),
    ([0, 500], gelight.InvalidInput), (np.zeros((2, 2), int), gelight.InvalidInput),
    (1.5, TypeError), ("0", TypeError), (None, TypeError), ([0, "1"], TypeError),
    (np.array([0.5]), TypeError),
    (gelight.face_point(9999, (0.2, 0.3, 0.5)), gelight.InvalidInput),
    (gelight.face_point(3, (0.2, 0.3, 0.6)), gelight.InvalidInput),
    (gelight.edge_point(0, 99, 0.5), gelight.InvalidInput),
    (gelight.Source(0, float("nan")), gelight.InvalidInput),
])
def test_sources_refused(source, error):
    surface = gelight.Surface(V, F)
    for solver in (gelight.ExactSolver(surface), gelight.FastMarchingSolver(surface)):
        with pytest.raises(error):
            solver.distance(source)
        assert solver.distance(0)[0] == 0  # usable as before


def test_sources_in_numpys_numbers():
    solver = gelight.ExactSolver(gelight.Surface(V, F))
    truth = solver.distance(7)
    for source in (np.int32(7), np.uint8(7), np.array([7]), np.array(7), [np.int64(7)], (7,)):
        assert np.array_equal(solver.distance(source), truth)


def images():
    camera = gelight.Camera.from_vertical_fov(1.0, 8, 6)
    light = gelight.Light(np.tile(np.float32([1, 0, 0]), (6, 8, 1)))
    return camera, gelight.TactileRenderer(camera, np.ones((6, 8), np.float32), [light])


@pytest.mark.parametrize("depth, error, words", [
    (np.ones((8, 6), np.float32), ValueError, "the depth image is 6 x 8 pixels"),
    (np.ones((6, 8, 1), np.float32), ValueError, "the depth image has shape"),
    (np.ones(48, np.float32), ValueError, "the depth image has shape"),
    (np.ones((0, 0), np.float32), ValueError, "0 x 0 pixels"),
    (np.ones((6, 8), int), TypeError, "int64"),
    (np.ones((6, 8), complex), TypeError, "complex128"),
    (None, TypeError, "the depth image"),
])
def test_depths_refused(depth, error, words):
    camera, renderer = images()
    out = np.full((6, 8, 3), 7, np.uint8)
    frame = renderer.rest_frame()
    for call in (lambda: renderer.render(depth), lambda: renderer.render_into(out, depth),
                 lambda: renderer.render_next_into(frame, depth),
                 lambda: gelight.unproject(depth, camera)):
        with pytest.raises(error, match=words):
            call()
    assert np.all(out == 7)


@pytest.mark.parametrize("out, error", [
    (np.zeros((6, 8, 3), np.float32), TypeError), (np.zeros((6, 8), np.uint8), ValueError),
    (np.zeros((6, 8, 4), np.uint8), ValueError), (np.zeros((5, 8, 3), np.uint8), ValueError),
])
def test_outputs_refused(out, error):
    _, renderer = images()
    with pytest.raises(error):
        renderer.render_into(out, np.ones((6, 8), np.float32))
    fixed = np.zeros((6, 8, 3), np.uint8)
    fixed.setflags(write=False)
    with pytest.raises(ValueError, match="read-only"):
        renderer.render_into(fixed, np.ones((6, 8), np.float32))
    with pytest.raises(ValueError, match="memory of the depth"):
        depth = np.ones((6, 8), np.float32)
        renderer.render_into(np.frombuffer(depth.data, np.uint8)[:144].reshape(6, 8, 3), depth)


def test_cameras_and_options_refused():
    with pytest.raises(ValueError, match="field of view"):
        gelight.Camera.from_vertical_fov(4.0, 8, 6)
    with pytest.raises(ValueError, match="focal lengths"):
        gelight.Camera(0, 1, 0, 0, 8, 6)
    camera, _ = images()
    rest = np.ones((6, 8), np.float32)
    with pytest.raises(ValueError, match="darkening"):
        gelight.TactileRenderer(camera, rest, [], options=gelight.TactileOptions(darkening=2))
    with pytest.raises(ValueError, match="background"):
        gelight.TactileRenderer(camera, rest, [], background=(2.0, 0, 0))
    with pytest.raises(ValueError, match="thickness"):
        gelight.ElasticLayer(camera, 1.0, gelight.Gel(thickness=-1))
    with pytest.raises(TypeError):
        gelight.tactile_renderer(gelight.geltip(8, 6, 0.005), "geodesic")
    depth = np.full((6, 8), np.inf, np.float32)
    with pytest.raises(ValueError, match="rotation"):
        gelight.Pose(np.eye(4)[:2, :3])
    with pytest.raises(TypeError):
        gelight.rasterize_into(depth.astype(int), gelight.box(1, 1, 1), gelight.Pose(), camera)


TURN = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])


@pytest.mark.parametrize("rotation, words", [
    (2 * TURN, "columns 0 and 0 is 4, not 1"),
    (1.001 * TURN, "columns 0 and 0 is 1.002"),
    (TURN @ np.diag([1, 1, 3]), "columns 2 and 2 is 9, not 1"),
    (TURN + [[0, 0, 0], [0, 0, 0.01], [0, 0, 0]], "columns 0 and 2 is 0.008, not 0"),
    (np.zeros((3, 3)), "columns 0 and 0 is 0, not 1"),
    (-np.eye(3), "reflection"),
    (np.diag([1, -1, 1]) @ TURN, "reflection"),
    (np.full((3, 3), np.nan), "rotation is none"),
    (TURN[:2], "shape"),
])
def test_poses_are_rigid(rotation, words):
    with pytest.raises(gelight.InvalidInput, match=words):
        gelight.Pose(rotation)


def test_rotations_of_float_are_poses():
    turn = np.eye(3, dtype=np.float32)
    for _ in range(500):
        turn = turn @ TURN.astype(np.float32)
    assert np.array_equal(gelight.Pose(turn).rotation, turn)
    with pytest.raises(gelight.InvalidInput, match="translation .* is not finite"):
        gelight.Pose(None, (0, np.inf, 1))
