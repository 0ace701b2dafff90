"""Rows of distances, operators, outlines, measures of images, markers, other simulators' membranes,
files and plans of sensors."""

import copy
import os
import pickle
import signal
import struct
import threading
import time
import zlib

import numpy as np
import pytest

import gelight
from shapes import arc, globe, sheet

SHEET = gelight.Surface(*sheet())
SOLVERS = [gelight.DijkstraSolver, gelight.FastMarchingSolver, gelight.VirtualSourceSolver,
           gelight.HeatSolver, gelight.ExactSolver, gelight.SmoothDistanceSolver,
           gelight.DistancePlanner]


# --- rows of distances ---------------------------------------------------------------------------

@pytest.mark.parametrize("kind", SOLVERS)
@pytest.mark.parametrize("threads", [1, 3, 0])
def test_rows_are_what_each_source_gives(kind, threads):
    solver, sources = kind(SHEET), [5, 0, 116, 5]
    matrix = gelight.distance_matrix(solver, sources, threads=threads)
    assert matrix.shape == (4, SHEET.vertex_count) and matrix.dtype == np.float64
    for row, source in zip(matrix, sources):
        assert np.array_equal(row, solver.distance(source))
    rows = {}
    assert gelight.distance_rows(solver, sources, rows.__setitem__, threads=threads) is None
    assert sorted(rows) == [0, 1, 2, 3]
    assert all(np.array_equal(rows[i], matrix[i]) for i in rows)


def test_matrix_of_a_plane():
    points = SHEET.vertices
    straight = np.linalg.norm(points[:, None] - points, axis=2)
    matrix = gelight.distance_matrix(gelight.ExactSolver(SHEET), np.arange(len(points)), threads=2)
    assert np.abs(matrix - straight).max() < 1e-12


def test_rows_of_all_kinds_of_sources():
    solver = gelight.ExactSolver(SHEET)
    middle = gelight.face_point(0, (1 / 3, 1 / 3, 1 / 3))
    matrix = gelight.distance_matrix(solver, [3, middle, gelight.Source(7, 2.5)])
    truth = [np.linalg.norm(SHEET.vertices - SHEET.position(p), axis=1) for p in (3, middle, 7)]
    assert np.allclose(matrix, np.array(truth) + [[0], [0], [2.5]], atol=1e-12)
    assert gelight.distance_matrix(solver, 3).shape == (1, SHEET.vertex_count)
    for nothing in ([], np.zeros(0, int), ()):
        assert gelight.distance_matrix(solver, nothing).shape == (0, SHEET.vertex_count)
    gelight.distance_rows(solver, [], None.__eq__)


def test_bad_rows_are_refused_before_any_is_solved():
    solver, rows = gelight.ExactSolver(SHEET), []
    for sources in ([0, -1], [0, SHEET.vertex_count], [0, gelight.Source(1, np.nan)],
                    np.array([0, 2**40])):
        for threads in (1, 2):
            with pytest.raises(gelight.InvalidInput):
                gelight.distance_rows(solver, sources, lambda i, d: rows.append(i), threads=threads)
            with pytest.raises(gelight.InvalidInput):
                gelight.distance_matrix(solver, sources, threads=threads)
    assert rows == []
    with pytest.raises(TypeError, match="take is 5, which cannot be called"):
        gelight.distance_rows(solver, [0], 5)
    for other in (SHEET, None, solver.distance, gelight.ExactSolver):
        with pytest.raises(TypeError, match="is no distance solver"):
            gelight.distance_matrix(other, [0])
    with pytest.raises(TypeError):
        gelight.distance_matrix(solver, [0.5])
    with pytest.raises(TypeError):
        gelight.distance_matrix(solver, [0], threads=-1)


@pytest.mark.parametrize("threads", [1, 4])
def test_what_take_raises_ends_the_rows(threads):
    taken = []

    def take(row, distances):
        taken.append(row)
        if len(taken) == 3:
            raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        gelight.distance_rows(gelight.DijkstraSolver(SHEET), range(100), take, threads=threads)
    assert 3 <= len(taken) <= 3 + threads
    shares = []
    with pytest.raises(gelight.Cancelled):
        gelight.distance_matrix(gelight.ExactSolver(gelight.icosphere(3)), range(100),
                                threads=threads, cancelled=lambda done: shares.append(done) or True)
    assert len(shares) == 1 and 0 <= shares[0] < 1


class WhenBothWork:
    """A solver's hook that acts once two threads solve, and notes who is asked how far it is. The
    first waits for the other, which on a busy machine may begin when it would be done."""

    def __init__(self, act):
        self.act, self.shares, self.asked_after = act, {}, 0

    def __call__(self, done):
        self.asked_after += self.act is None
        self.shares[threading.get_ident()] = done
        end = time.monotonic() + 10
        while len(self.shares) < 2 and time.monotonic() < end:
            time.sleep(0.001)
        if len(self.shares) == 2 and self.act is not None:
            act, self.act = self.act, None
            act()
        return False


def raise_enough():
    raise KeyError("enough")


@pytest.mark.parametrize("act, error", [
    (raise_enough, KeyError), (lambda: os.kill(os.getpid(), signal.SIGINT), KeyboardInterrupt)])
def test_what_ends_one_row_ends_those_of_other_threads(act, error):
    ask, taken = WhenBothWork(act), []
    # A solve of longer than it takes to hear of a signal.
    solver = gelight.ExactSolver(gelight.icosphere(7), cancelled=ask)
    # Where Python was begun in the background, it ignores the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for rows in (lambda: gelight.distance_matrix(solver, [0, 1], threads=2),
                     lambda: gelight.distance_rows(solver, [0, 1], lambda *r: taken.append(r),
                                                   threads=2)):
            ask.__init__(act)
            with pytest.raises(error):
                rows()
            assert ask.act is None and len(ask.shares) == 2
            assert max(ask.shares.values()) < 0.9 and taken == []
            if error is KeyError:
                assert ask.asked_after <= 1  # it was asking already
    finally:
        signal.signal(signal.SIGINT, before)


def test_take_may_ask_the_library_and_other_threads_too():
    solver, found = gelight.ExactSolver(SHEET), []

    def take(row, distances):
        gelight.distance_rows(solver, [row, 3], lambda i, d: found.append(d[0]), threads=2)

    threads = [threading.Thread(target=gelight.distance_rows, args=(solver, range(8), take),
                                kwargs={"threads": 3}) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    truth = np.linalg.norm(SHEET.vertices[[*range(8), *8 * [3]]], axis=1)
    assert np.allclose(np.sort(found), np.sort(np.repeat(truth, 3)), atol=1e-12)


@pytest.mark.parametrize("kind", [gelight.DijkstraSolver, gelight.VirtualSourceSolver,
                                  gelight.ExactSolver])
def test_spread_points_and_cells_by_any_solver(kind):
    solver = kind(gelight.Surface(*globe()))
    points = gelight.farthest_points(solver, 6, 17)
    distance = gelight.distance_matrix(solver, points)
    assert points[0] == 17 and points.dtype == np.int32
    for k in range(1, 6):
        nearest = distance[:k].min(axis=0)
        assert nearest[points[k]] == pytest.approx(nearest.max(), rel=1e-12)
    cells = gelight.voronoi(solver, points)
    nearest = distance.min(axis=0)
    column = {site: row for row, site in enumerate(points)}
    chosen = np.array([distance[column[site], v] for v, site in enumerate(cells)])
    assert np.allclose(chosen, nearest, rtol=1e-12, atol=1e-12)
    with pytest.raises(TypeError, match="is no distance solver"):
        gelight.voronoi(SHEET, [0])
    with pytest.raises(gelight.InvalidInput, match="no site"):
        gelight.voronoi(solver, [])


# --- operators -----------------------------------------------------------------------------------

def dense(rows, count):
    data, indices, indptr = rows
    assert data.dtype == np.float64 and indices.dtype == np.int32 and indptr.dtype == np.int32
    matrix = np.zeros((count, count))
    matrix[np.repeat(np.arange(count), np.diff(indptr)), indices] = data
    for row in range(count):
        assert np.all(np.diff(indices[indptr[row]:indptr[row + 1]]) > 0)
    return matrix


def cotangents(vertices, faces):
    """The same matrix by angles, and the areas."""
    n = len(vertices)
    matrix, areas = np.zeros((n, n)), np.zeros(n)
    for face in faces:
        for k in range(3):
            i, j, o = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            a, b = vertices[i] - vertices[o], vertices[j] - vertices[o]
            double = np.linalg.norm(np.cross(a, b))
            half = a @ b / double / 2
            matrix[i, j] -= half
            matrix[j, i] -= half
            matrix[i, i] += half
            matrix[j, j] += half
            areas[o] += double / 6
    return matrix, areas


FLAP = (np.array([[0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.2, -1, 0.1], [0.6, 0, 1.0], [9, 9, 9]]),
        np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]]))  # an edge of three faces, a vertex of none


@pytest.mark.parametrize("mesh", [sheet(4, 3), globe(8, 12), FLAP])
@pytest.mark.parametrize("scale", [1, 1e-40, 1e40])
def test_laplacian_and_areas(mesh, scale):
    surface = gelight.Surface(mesh[0] * scale, mesh[1])
    truth, areas = cotangents(*mesh)
    matrix = dense(gelight.cotan_laplacian(surface), len(mesh[0]))
    assert np.allclose(matrix, truth, rtol=1e-9, atol=1e-11)
    assert np.array_equal(matrix, matrix.T)
    assert np.allclose(gelight.vertex_areas(surface) / scale**2, areas, rtol=1e-12)


def test_delaunay_has_no_negative_weight():
    vertices, faces = sheet(6, 5)
    vertices = vertices * [8, 1, 1] + [[0, 0, 0]]
    vertices[:, 0] += 3 * vertices[:, 1]  # slanted: its own diagonals are bad ones
    surface = gelight.Surface(vertices, faces)
    for flips, has_negative in ((False, True), (True, False)):
        matrix = dense(gelight.cotan_laplacian(surface, intrinsic_delaunay=flips), len(vertices))
        inside = matrix - np.diag(np.diag(matrix))
        border = np.isclose(vertices[:, 1] % 2, 0)
        inner = inside[~border][:, ~border]
        assert (inner.max() > 1e-9) == has_negative
        assert np.abs(matrix.sum(axis=1)).max() < 1e-9
        straight = matrix @ vertices[:, :2]  # linear functions are harmonic but at the border
        rim = np.isin(np.arange(len(vertices)), border_of(faces))
        assert np.abs(straight[~rim]).max() < 1e-9
        areas = gelight.vertex_areas(surface, intrinsic_delaunay=flips)
        assert areas.sum() == pytest.approx(48)


def border_of(faces):
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    once, counts = np.unique(edges, axis=0, return_counts=True)
    return np.unique(once[counts == 1])


# --- shapes --------------------------------------------------------------------------------------

def test_outlines_turn():
    angle = np.linspace(-np.pi / 2, np.pi / 2, 40)
    profile = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    profile[[0, -1], 0] = 0
    ball = gelight.revolve(profile, 0.08)
    assert np.allclose(np.linalg.norm(ball.vertices, axis=1), 1)
    assert gelight.vertex_areas(ball).sum() == pytest.approx(4 * np.pi, rel=0.01)
    a, b, c = (ball.vertices[ball.faces[:, k]] for k in range(3))
    assert np.sum(np.cross(a, b) * c) / 6 == pytest.approx(4 / 3 * np.pi, rel=0.01)  # outwards
    assert gelight.revolve(profile[::-1].tolist(), 0.5).face_count > 0
    for bad in (np.zeros((0, 2)), [[1, 0]], [[1, 0], [-1, 1]], [[0, 0], [0, 1]], [[np.nan, 0], [1, 1]],
                [[1, np.inf], [1, 1]], np.zeros((3, 3)), [1, 2], [[1e30, 0], [1e30, 1]]):
        with pytest.raises(gelight.InvalidInput):
            gelight.revolve(bad, 0.1)
    for edge in (0.0, -1.0, np.nan):
        with pytest.raises(gelight.InvalidInput, match="edge length"):
            gelight.revolve(profile, edge)


def test_placed_meshes():
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    moved = gelight.placed(SHEET, gelight.Pose(turn, [1, 2, 3]))
    assert np.allclose(moved.vertices, SHEET.vertices @ turn.T + [1, 2, 3])
    assert np.array_equal(moved.faces, SHEET.faces)


# --- images --------------------------------------------------------------------------------------

def pictures():
    random = np.random.default_rng(4)
    one = random.integers(0, 256, (23, 31, 3), np.uint8)
    return one, np.clip(one + random.integers(-30, 30, one.shape), 0, 255).astype(np.uint8)


def similarity(a, b):
    x = np.arange(-5, 6)
    weights = np.exp(-x**2 / (2 * 1.5**2))
    weights /= weights.sum()

    def mean(image):
        for axis in (0, 1):
            pad = [(5, 5) if k == axis else (0, 0) for k in range(3)]
            wide = np.pad(image, pad, mode="reflect")
            image = sum(w * np.take(wide, range(k, k + image.shape[axis]), axis)
                        for k, w in enumerate(weights))
        return image

    p, q = a.astype(float), b.astype(float)
    mp, mq = mean(p), mean(q)
    vp, vq, pq = mean(p * p) - mp**2, mean(q * q) - mq**2, mean(p * q) - mp * mq
    c1, c2 = (0.01 * 255)**2, (0.03 * 255)**2
    return np.mean((2 * mp * mq + c1) * (2 * pq + c2) / ((mp**2 + mq**2 + c1) * (vp + vq + c2)))


def test_measures_of_images():
    a, b = pictures()
    off = np.abs(a.astype(int) - b).max(axis=2)
    found = gelight.level_difference(a, b)
    assert np.array_equal(found.pixels, np.bincount(off.ravel(), minlength=256))
    assert found.worst == off.max() and found.mean == pytest.approx(off.mean())
    assert [found.beyond(k) for k in (-5, 0, 10, 254, 255, 1000)] == [
        np.count_nonzero(off > k) for k in (-5, 0, 10, 254, 255, 1000)]
    assert not found.pixels.flags.writeable
    for again in (pickle.loads(pickle.dumps(found)), copy.copy(found)):
        assert np.array_equal(again.pixels, found.pixels) and again.mean == found.mean
    mean_square = np.mean((a.astype(float) - b)**2)
    assert gelight.psnr(a, b) == pytest.approx(10 * np.log10(255**2 / mean_square))
    assert gelight.ssim(a, b) == pytest.approx(similarity(a, b), rel=1e-9)
    assert gelight.psnr(a, a) == np.inf and gelight.ssim(a, a) == pytest.approx(1)


def test_measures_at_any_strides_and_of_no_other_images():
    a, b = pictures()
    truth = gelight.ssim(a, b)
    wide = np.zeros((46, 62, 3), np.uint8)
    wide[::2, ::2] = a
    for same in (wide[::2, ::2], np.asfortranarray(a), a[::-1].copy()[::-1],
                 a[..., ::-1].copy()[..., ::-1]):
        assert gelight.ssim(same, b) == truth
        assert gelight.level_difference(same, a).worst == 0
    for measure in (gelight.ssim, gelight.psnr, gelight.level_difference):
        with pytest.raises(gelight.InvalidInput):
            measure(a, b[:5])
        with pytest.raises(gelight.InvalidInput, match="shape"):
            measure(a, b[..., 0])
        for other in (a.astype(float), a.astype(np.int8), a.astype(np.uint16)):
            with pytest.raises(TypeError):
                measure(other, b)
    with pytest.raises(gelight.InvalidInput):
        gelight.ssim(a[:0], b[:0])


CAMERA = gelight.Camera(80.0, 70.0, 19.5, 14.5, 40, 30)


def plane(slope_x, slope_y):
    v, u = np.mgrid[:30, :40]
    ray = np.stack([(u - 19.5) / 80, (v - 14.5) / 70, np.ones_like(u, float)], axis=-1)
    normal = np.array([slope_x, slope_y, -1.0])
    return (-2 / (ray @ normal)).astype(np.float32), normal / np.linalg.norm(normal)


def test_normals_of_planes():
    depth, normal = plane(0.3, -0.2)
    inner = np.s_[1:-1, 1:-1]
    central = gelight.central_normals(depth, CAMERA)
    assert np.abs(central[inner] - normal).max() < 1e-4 and np.all(central[0] == 0)
    fitted = gelight.plane_fit_normals(depth, CAMERA, 2)
    assert fitted.shape == (30, 40, 3) and np.abs(fitted - normal).max() < 1e-3
    with pytest.raises(gelight.InvalidInput, match="radius 0"):
        gelight.plane_fit_normals(depth, CAMERA, 0)
    with pytest.raises(gelight.InvalidInput):
        gelight.central_normals(depth[:3], CAMERA)


# --- markers -------------------------------------------------------------------------------------

def projected(points):
    return np.stack([80 * points[..., 0] / points[..., 2] + 19.5,
                     70 * points[..., 1] / points[..., 2] + 14.5], axis=-1)


def test_markers_are_where_their_points_are_seen():
    rest, _ = plane(0.1, 0.2)
    by = np.random.default_rng(5).normal(0, 0.05, (30, 40, 3)).astype(np.float32)
    points = gelight.unproject(rest, CAMERA).astype(float)
    truth = projected(points + by) - projected(points)
    moved = gelight.marker_displacement(CAMERA, rest, by)
    assert moved.shape == (30, 40, 2) and moved.dtype == np.float32
    assert np.abs(moved - truth).max() < 1e-4
    at = np.array([[3, 4], [3.5, 4], [10.25, 7.75], [39, 29]])
    between = []
    for x, y in at:
        i, j = min(int(x), 38), min(int(y), 28)
        s, t = x - i, y - j
        between.append((1 - t) * ((1 - s) * truth[j, i] + s * truth[j, i + 1])
                       + t * ((1 - s) * truth[j + 1, i] + s * truth[j + 1, i + 1]))
    for found in (gelight.marker_displacement(CAMERA, rest, by, at),
                  gelight.marker_displacement(CAMERA, rest, by.astype(float)[::-1].copy()[::-1],
                                              at.astype(np.float32)),
                  gelight.sample_markers(moved, at), gelight.sample_markers(moved, at.tolist())):
        assert found.dtype == np.float32 and np.abs(found - between).max() < 1e-4
    rest[0, 0] = np.nan
    assert np.isnan(gelight.marker_displacement(CAMERA, rest, by)[0, 0]).all()


def test_markers_of_a_dragged_disc():
    disc = gelight.DraggedMarkers.of_disc((20, 15), (3, -1), 6, 0.4)
    moved = disc.image(40, 30)
    v, u = np.mgrid[:30, :40]
    r = np.stack([u - 20, v - 15], axis=-1)
    rho = np.sqrt((r**2).sum(axis=-1, keepdims=True) + disc.reach**2)
    along = (r @ [3, -1])[..., None]
    truth = disc.reach * (np.array([3, -1]) / rho + disc.stretch * r * along / rho**3)
    assert disc.reach == pytest.approx(4 * 6 * 0.6 / (np.pi * 1.6)) and disc.stretch == pytest.approx(2 / 3)
    assert moved.shape == (30, 40, 2) and np.allclose(moved, truth, atol=1e-6)
    pixels = np.stack([u, v], axis=-1)
    assert np.allclose(disc(pixels), truth) and disc(pixels).shape == (30, 40, 2)
    assert np.allclose(disc(pixels[::3, ::-1].astype(np.float32)), truth[::3, ::-1])
    assert np.allclose(disc((20, 15)), [3, -1]) and disc(np.zeros((0, 2))).shape == (0, 2)
    again = pickle.loads(pickle.dumps(disc))
    assert np.array_equal(again(pixels), disc(pixels))
    image = np.full((30, 40, 3), 255, np.uint8)
    gelight.PrintedDots(CAMERA, np.full((30, 40), 2.0), [(20, 15)], 0.05).draw_into(image, moved)
    dark = 255 - image[..., 0].astype(float)
    middle = np.array([(dark * u).sum(), (dark * v).sum()]) / dark.sum()
    assert np.abs(middle - [23, 14]).max() < 0.2
    for bad in (lambda: disc((1, 2, 3)), lambda: disc(3), lambda: disc.image(-1, 3),
                lambda: gelight.DraggedMarkers((1, 2, 3), (0, 0)),
                lambda: gelight.DraggedMarkers((1, 2), (0, 0), 0.0),
                lambda: gelight.DraggedMarkers((1, 2), (0, 0), np.nan),
                lambda: gelight.DraggedMarkers((1, np.inf), (0, 0)),
                lambda: gelight.DraggedMarkers.of_disc((0, 0), (1, 0), -1, 0.4),
                lambda: gelight.DraggedMarkers.of_disc((0, 0), (1, 0), 1, 0.6)):
        with pytest.raises(gelight.InvalidInput):
            bad()


def test_markers_by_gaussians():
    fitted = gelight.GaussianMarkers([(5, 5, 0.2), (8, 5, 0.1)], (6, 5), shift=(2, 1), twist=0.3,
                                     push_decay=0.01, shift_decay=0.02, twist_decay=0.03)
    p = np.array([[0.0, 0], [6, 9], [11, 5]])
    r = p - (6, 5)
    square = (r**2).sum(axis=1, keepdims=True)
    turn = np.array([[np.cos(0.3) - 1, -np.sin(0.3)], [np.sin(0.3), np.cos(0.3) - 1]])
    truth = np.exp(-0.02 * square) * [2, 1] + np.exp(-0.03 * square) * (r @ turn.T)
    for x, y, push in fitted.touched:
        away = p - (x, y)
        truth += push * np.exp(-0.01 * (away**2).sum(axis=1, keepdims=True)) * away
    assert np.allclose(fitted(p), truth)
    assert np.allclose(fitted.image(12, 10)[9, 6], truth[1])
    assert np.array_equal(copy.deepcopy(fitted)(p), fitted(p))
    assert np.all(gelight.GaussianMarkers(np.zeros((0, 3)), (0, 0))(p) == 0)
    with pytest.raises(gelight.InvalidInput, match="touched has shape"):
        gelight.GaussianMarkers([(1, 2)], (0, 0))


def test_bad_markers_are_refused():
    rest, by = np.full((30, 40), 2.0), np.zeros((30, 40, 3))
    for pixels in ([(40, 3)], [(-0.1, 3)], [(np.nan, 3)], [(3, 29.5)], [(1, 2, 3)], [1, 2]):
        with pytest.raises(gelight.InvalidInput):
            gelight.marker_displacement(CAMERA, rest, by, pixels)
        with pytest.raises(gelight.InvalidInput):
            gelight.sample_markers(by[..., :2], pixels)
    for a, b in ((rest[:3], by), (rest, by[:, :3]), (rest, by[..., :2]), (rest, rest)):
        with pytest.raises(gelight.InvalidInput):
            gelight.marker_displacement(CAMERA, a, b)
    assert gelight.sample_markers(by[..., :2], np.zeros((0, 2))).shape == (0, 2)


# --- membranes of other simulators ---------------------------------------------------------------

REST = np.full((30, 40), 2.0, np.float32)


def seen(membrane, depth):
    lights = [gelight.Light(np.tile(np.float32(way), (30, 40, 1)), rgb=(1, 1, 1), specular=0)
              for way in ([1, 0, 0], [0, 1, 0])]
    return gelight.TactileRenderer(CAMERA, REST, lights, membrane=membrane).render(depth)


def pressed():
    depth = np.full((30, 40), np.inf, np.float32)
    depth[12:18, 16:25] = 1.9
    return depth


def test_taxims_membrane_blurs_beside_what_is_pressed_in():
    """A flat stamp is the highest there is: there one Gaussian is the GelTip's."""
    depth = pressed()
    gaussian = seen(gelight.GaussianMembrane(2.0, 8), depth)
    assert gelight.level_difference(seen(gelight.PyramidMembrane([2.0]), depth), gaussian).worst <= 1
    follows = seen(gelight.GaussianMembrane(0.0, 0), depth)
    assert np.array_equal(seen(gelight.PyramidMembrane([]), depth), follows)
    assert gelight.level_difference(gaussian, follows).worst > 20
    for bad in ([-1.0], [np.nan], [1e9]):
        with pytest.raises(gelight.InvalidInput, match="sigma"):
            gelight.PyramidMembrane(bad)
    with pytest.raises(gelight.InvalidInput, match="sigmas has shape"):
        gelight.PyramidMembrane(3.0)


def test_what_the_object_hides():
    depth = pressed()
    bulge = seen(gelight.GaussianMembrane(3.0, 12), depth)
    none = gelight.ShadowedMembrane(CAMERA, 3.0, 12, shadow=gelight.ContactShadow(gap=100))
    assert np.array_equal(seen(none, depth), bulge)
    some = gelight.ShadowedMembrane(CAMERA, 3.0, 12, shadow=gelight.ContactShadow(gap=1, sigma=2.0))
    assert np.array_equal(seen(some, depth), bulge)  # in the middle nothing is hidden
    depth = np.roll(pressed(), 10, axis=1)  # columns 26 to 34
    off = seen(some, depth).astype(int) - seen(none, depth)
    assert np.abs(off[12:18, 20:26]).max() > 5 and np.all(off[12:18, 36:] == 0)
    again = pickle.loads(pickle.dumps(gelight.ContactShadow(gap=1)))
    assert (again.gap, again.radius) == (1, 27)
    other = gelight.ShadowedMembrane(gelight.Camera.from_vertical_fov(1.0, 8, 6))
    with pytest.raises(gelight.InvalidInput, match="8 x 6"):
        seen(other, depth)
    for bad in (dict(gap=-1), dict(sigma=-1.0), dict(contact=np.nan)):
        with pytest.raises(gelight.InvalidInput):
            gelight.ShadowedMembrane(CAMERA, shadow=gelight.ContactShadow(**bad))


def spread(field, sigma, size):
    """One of FlatGelSight's rounds: SciPy's Gaussian of a pulse as a kernel, then the larger."""
    radius = int(4 * sigma + 0.5)
    gaussian = np.exp(-np.arange(-radius, radius + 1)**2 / (2 * sigma**2))
    gaussian /= gaussian.sum()
    pulse = np.zeros(size)
    pulse[size // 2] = 1
    kernel = np.convolve(np.pad(pulse, radius, mode="symmetric"), gaussian, mode="valid")
    return kernel


def blurred(image, kernel):
    before, after = len(kernel) // 2, len(kernel) - 1 - len(kernel) // 2
    for axis in (0, 1):
        pad = [(before, after) if k == axis else (0, 0) for k in range(2)]
        wide = np.pad(image, pad, mode="reflect")
        image = sum(w * np.take(wide, range(k, k + image.shape[axis]), axis)
                    for k, w in enumerate(kernel))
    return image


def test_the_flat_gelsights_membrane():
    depth = pressed()
    own = np.where(depth < REST, REST - depth, 0).astype(float)
    narrow, wide = own.copy(), own.copy()

    def rounds(field, sigma, size):
        for _ in range(3):
            more = blurred(field, spread(field, sigma, size))
            field = np.maximum(more * own.max() / more.max(), own)
        return field

    sunk = 2 * rounds(narrow, 7, 21) - rounds(rounds(wide, 9, 52), 7, 21)
    follows = gelight.GaussianMembrane(0.0, 0, clip_to_rest=False)
    truth = seen(follows, (REST - sunk).astype(np.float32))
    assert gelight.level_difference(seen(gelight.FlatGelSightMembrane(), depth), truth).worst <= 1


# --- files ---------------------------------------------------------------------------------------

needs_stb = pytest.mark.skipif(not hasattr(gelight, "read_png"), reason="without stb's headers")


def png(path, pixels, bits, colour):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    rows = b"".join(b"\0" + row.astype(">u2" if bits == 16 else "u1").tobytes() for row in pixels)
    size = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], bits, colour, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size)
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


@needs_stb
def test_png_files(tmp_path):
    a, _ = pictures()
    gelight.write_png(tmp_path / "ä b.png", a[:, ::-1])
    assert np.array_equal(gelight.read_png(str(tmp_path / "ä b.png")), a[:, ::-1])
    png(tmp_path / "ours.png", a, 8, 2)
    assert np.array_equal(gelight.read_png(tmp_path / "ours.png"), a)
    steps = np.random.default_rng(6).integers(0, 65536, (7, 9))
    steps[2, 3] = 0
    png(tmp_path / "depth.png", steps, 16, 0)
    depth = gelight.read_depth_png(tmp_path / "depth.png", 1e-3)
    assert depth.dtype == np.float32 and depth[2, 3] == 0
    assert np.allclose(depth, steps * 1e-3, rtol=1e-6)
    for unit in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(gelight.InvalidInput, match="unit"):
            gelight.read_depth_png(tmp_path / "depth.png", unit)
    with pytest.raises(gelight.InvalidInput, match="channels"):
        gelight.read_depth_png(tmp_path / "ours.png", 1.0)
    with pytest.raises(gelight.InvalidInput, match="cannot be opened"):
        gelight.read_png(tmp_path / "none.png")
    with pytest.raises(gelight.InvalidInput, match="let its name end in .png"):
        gelight.write_png(tmp_path / "a.jpg", a)
    with pytest.raises(gelight.InvalidInput, match="cannot be written"):
        gelight.write_png(tmp_path / "no" / "a.png", a)
    with pytest.raises(gelight.InvalidInput):
        gelight.write_png(tmp_path / "a.png", a[:0])
    with pytest.raises(TypeError):
        gelight.write_png(tmp_path / "a.png", a / 255)
    with pytest.raises(TypeError):
        gelight.read_png(7.5)


@needs_stb
def test_folders_of_presses(tmp_path):
    a, b = pictures()
    gelight.write_png(tmp_path / "background.png", a)
    gelight.write_png(tmp_path / "one.png", b)
    table = "image,center_x_px,center_y_px,contact_radius_px,ball_radius_mm,mm_per_px\n"
    (tmp_path / "presses.csv").write_text(table + "one.png,10,12,5,4,0.05\none.png,,,,4,0.05\n")
    background, presses = gelight.read_presses(tmp_path)
    assert np.array_equal(background, a) and np.array_equal(presses[0].photograph, b)
    assert [p.contact for p in presses] == [(10, 12, 5), (0, 0, 0)]
    assert presses[1].ball_radius == pytest.approx(80)
    (tmp_path / "presses.csv").write_text(table + "one.png,10,x,5,4,0.05\n")
    with pytest.raises(gelight.InvalidInput, match="presses.csv line 2 has x"):
        gelight.read_presses(tmp_path)


# --- plans of sensors ----------------------------------------------------------------------------

def small(edge):
    return gelight.gelsight_mini(48, 36, edge)


QUICK = dict(reference_edge=0.002, contacts=2, light=gelight.PlannedLight.linear)


@pytest.fixture(scope="module")
def plan():
    return gelight.plan_sensor(small, tolerance=255, share=0.5, **QUICK)


def test_a_plan_takes_what_suffices(plan):
    assert plan.satisfies and plan.needed == ""
    assert plan.share == 1 and plan.light == gelight.PlannedLight.linear
    assert plan.edge_length > 0.002 and plan.light_grid > 1 and plan.single_precision
    assert plan.smoothing_radius < 30 and plan.steps[0].topic == "mesh edges"
    again = pickle.loads(pickle.dumps(plan))
    assert again.reason == plan.reason and again.steps[2].choice == plan.steps[2].choice
    image = gelight.planned_renderer(small, plan).rest_image
    assert image.shape == (36, 48, 3) and image.any()


def test_a_planned_renderer_is_the_sensors_own(plan):
    """Of the same mesh, light and smoothing."""
    sensor = small(0.002)
    own = gelight.tactile_renderer(sensor, gelight.LinearLight(sensor.membrane))
    exact = copy.copy(plan)
    exact.edge_length, exact.light_grid = 0.002, 1
    exact.smoothing_sigma = sensor.options.smoothing_sigma
    exact.smoothing_radius = sensor.options.smoothing_radius
    renderer = gelight.planned_renderer(small, exact)
    assert gelight.level_difference(renderer.rest_image, own.rest_image).worst <= 1
    assert gelight.level_difference(renderer.rest_image, np.zeros_like(own.rest_image)).mean > 20
    depth = np.full((36, 48), np.inf, np.float32)
    ball = gelight.icosphere(3, 0.004)
    at = gelight.rasterize(sensor.membrane, sensor.camera).depth[18, 24]
    gelight.rasterize_into(depth, ball, gelight.Pose(None, [0, 0, at + 0.0034]), sensor.camera)
    pressed_in = renderer.render(depth)
    assert gelight.level_difference(pressed_in, own.render(depth)).worst <= 1
    assert gelight.level_difference(pressed_in, own.rest_image).worst > 5


def test_plans_that_fail_say_so(plan):
    worse = copy.copy(plan)
    worse.satisfies = False
    with pytest.raises(gelight.InvalidInput, match="does not satisfy"):
        gelight.planned_renderer(small, worse)
    exact = copy.copy(plan)
    exact.single_precision = False
    with pytest.raises(gelight.InvalidInput, match="wants double"):
        gelight.planned_renderer(small, exact)
    for bad, words in ((dict(tolerance=-1.0), "tolerance"), (dict(share=2.0), "share"),
                       (dict(contacts=1), "contacts"), (dict(frames=np.nan), "frames")):
        with pytest.raises(gelight.InvalidInput, match=words):
            gelight.plan_sensor(small, **{**QUICK, **bad})
    with pytest.raises(TypeError, match="sensor is 3, which cannot be called"):
        gelight.plan_sensor(3)
    with pytest.raises(TypeError, match="sensor makes None, not a SensorPreset"):
        gelight.plan_sensor(lambda edge: None)
    with pytest.raises(KeyError, match="mine"):
        gelight.plan_sensor(lambda edge: {}["mine"])
    with pytest.raises(gelight.Cancelled):
        gelight.plan_sensor(small, cancelled=lambda done: True, **QUICK)


def test_edges_too_coarse_for_a_sensor_are_not_chosen():
    def picky(edge):
        if edge > 0.005:
            raise gelight.InvalidInput(f"edges of {edge}")
        return small(edge)

    found = gelight.plan_sensor(picky, tolerance=255, share=0.5, **QUICK)
    assert found.satisfies and found.edge_length <= 0.005
    with pytest.raises(gelight.InvalidInput, match="edges of 0.006"):
        gelight.plan_sensor(picky, **{**QUICK, "reference_edge": 0.006})
