"""Dots on a gel, and light that is traced through one."""

import numpy as np
import pytest

import gelight

CAMERA = gelight.Camera(100.0, 100.0, 39.5, 29.5, 80, 60)
REST = np.full((60, 80), 0.5, np.float32)  # a pixel is 5 mm wide there


def ink_of(image):
    """How many pixels the ink covers, and the middle of it."""
    share = 1 - image[..., 1] / 255.0
    v, u = np.mgrid[:60, :80]
    return share.sum(), np.array([(share * u).sum(), (share * v).sum()]) / share.sum()


def test_dots_are_discs_that_go_where_the_gel_takes_them():
    dots = gelight.PrintedDots(CAMERA, REST, [(30.25, 20.5)], 0.02, ink=(0, 0, 0))
    image = np.full((60, 80, 3), 255, np.uint8)
    dots.draw_into(image)
    area, middle = ink_of(image)
    assert area == pytest.approx(np.pi * 4**2, rel=0.01)
    assert middle == pytest.approx([30.25, 20.5], abs=0.02)
    moved = np.full((60, 80, 3), 255, np.uint8)
    dots.draw_into(moved, np.broadcast_to(np.array([12.5, -3.0]), (60, 80, 2)))
    area, middle = ink_of(moved)
    assert area == pytest.approx(np.pi * 4**2, rel=0.01)
    assert middle == pytest.approx([42.75, 17.5], abs=0.02)
    unknown = np.full((60, 80, 3), 255, np.uint8)
    dots.draw_into(unknown, np.full((60, 80, 2), np.nan, np.float32))
    assert np.all(unknown == 255)


def test_dots_are_drawn_at_any_strides():
    pixels = gelight.dot_grid(3, 2, (20, 15), (18.5, 21))
    assert np.array_equal(pixels[:4], [[20, 15], [38.5, 15], [57, 15], [20, 36]])
    dots = gelight.PrintedDots(CAMERA, REST.astype(">f8"), pixels[::-1], 0.015)
    assert np.array_equal(dots.centres, pixels[::-1])
    packed = np.random.default_rng(1).integers(0, 255, (60, 80, 3), np.uint8)
    for turned in (packed[..., ::-1].copy()[..., ::-1], np.asfortranarray(packed),
                   np.repeat(packed, 2, axis=1)[:, ::2]):
        image = packed.copy()
        dots.draw_into(image)
        dots.draw_into(turned)
        assert np.array_equal(turned, image) and not np.array_equal(packed, image)


def test_bad_dots_are_named():
    with pytest.raises(ValueError, match="radius"):
        gelight.PrintedDots(CAMERA, REST, [(3, 3)], np.nan)
    with pytest.raises(ValueError, match="centres has shape"):
        gelight.PrintedDots(CAMERA, REST, [(3, 3, 3)], 1)
    with pytest.raises(ValueError, match="rest depth"):
        gelight.PrintedDots(CAMERA, REST[:5], [(3, 3)], 1)
    with pytest.raises(ValueError):
        gelight.PrintedDots(CAMERA, REST, [(80, 3)], 1)
    with pytest.raises(ValueError, match="step has 3 numbers"):
        gelight.dot_grid(1, 1, (0, 0), (1, 2, 3))
    dots = gelight.PrintedDots(CAMERA, REST, np.zeros((0, 2)), 0.01)
    image = np.zeros((60, 80, 3), np.uint8)
    with pytest.raises(TypeError):
        dots.draw_into(image.astype(float))
    with pytest.raises(ValueError, match="displacement has shape"):
        dots.draw_into(image, REST)
    with pytest.raises(ValueError, match="camera"):
        dots.draw_into(image, np.zeros((3, 4, 2)))
    image.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        dots.draw_into(image)


needs_embree = pytest.mark.skipif(not hasattr(gelight, "LightTracer"), reason="without Embree")


def hung(depth, rest, fall):
    """Every pixel's highest tent, of all pixels: the way of a knight's, a bishop's and a rook's
    steps is straight along two neighbouring ones of sixteen."""
    height, width = depth.shape
    own = np.where(depth <= rest, rest - depth, 0)
    y, x = np.mgrid[:height, :width]
    most = own.copy()
    for v in range(height):
        for u in range(width):
            dx, dy = np.abs(x - u), np.abs(y - v)
            far, near = np.maximum(dx, dy), np.minimum(dx, dy)
            flat = far - 2 * near + near * np.sqrt(5)
            steep = (2 * near - far) * np.sqrt(2) + (far - near) * np.sqrt(5)
            way = np.where(far >= 2 * near, flat, steep)
            most = np.maximum(most, own[v, u] - fall * way)
    return np.where(most > own, rest - most, depth)


def test_drape_is_the_highest_of_all_tents():
    random = np.random.default_rng(3)
    rest = (2 + 0.1 * random.random((19, 24))).astype(np.float32)
    depth = np.full(rest.shape, np.inf, np.float32)
    depth[5:9, 7:12] = 1.2
    depth[14, 20] = 0.9
    depth[2, 3] = 2.5  # behind the gel
    for fall in (0.05, 0.13, 10.0):
        draped = gelight.drape(depth, rest, fall)
        assert draped.dtype == np.float32
        truth = hung(depth.astype(float), rest.astype(float), fall)
        assert np.array_equal(np.isinf(draped), np.isinf(truth))
        known = np.isfinite(truth)
        assert np.abs(draped[known] - truth[known]).max() < 2e-6
        for out in (depth.copy(), rest.copy(), np.zeros((38, 72), np.float32)[::2, ::3]):
            given = [out if np.array_equal(out, a) else a for a in (depth, rest)]
            gelight.drape_into(out, *given, fall)
            assert np.array_equal(out, draped)
    assert np.array_equal(gelight.drape(depth, rest, 10.0), depth)
    depth[0, 0] = np.nan
    assert np.isnan(gelight.drape(depth, rest, 0.1)[0, 0])


def test_drape_refuses():
    image = np.ones((6, 8), np.float32)
    out = np.full((6, 8), 7, np.float32)
    for fall in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="fall"):
            gelight.drape_into(out, image, image, fall)
    with pytest.raises(ValueError, match="8 x 5"):
        gelight.drape_into(out, image[:5], image, 1.0)
    with pytest.raises(ValueError, match="the output image is 8 x 5"):
        gelight.drape_into(out[:5], image, image, 1.0)
    with pytest.raises(TypeError):
        gelight.drape_into(out.astype(float), image, image, 1.0)
    assert np.all(out == 7)


@pytest.mark.parametrize("columns, rows", [(2**20, 2**20), (4097, 4096), (1, 2**24 + 1)])
def test_dots_beyond_count_are_refused_at_once(columns, rows):
    with pytest.raises(gelight.InvalidInput, match=f"{columns} x {rows} dots are more than 16777216"):
        gelight.dot_grid(columns, rows, (0, 0), (1, 1))


def test_the_contact_of_another_bed_is_refused():
    camera = gelight.Camera.from_vertical_fov(1.0, 16, 12)
    turned = gelight.Camera.from_vertical_fov(1.0, 12, 16)
    bed, other = (gelight.SpringBed(eye, 0.02) for eye in (camera, turned))
    contact = other.press(np.full((16, 12), 0.02, np.float32), 1.0)
    assert other.depth(contact).shape == (16, 12)
    with pytest.raises(gelight.InvalidInput, match="the contact is 12 x 16 pixels"):
        bed.depth(contact)


@needs_embree
def test_light_from_the_middle_of_a_ball_is_the_same_all_over_half_of_it():
    ball = gelight.icosphere(2, 2.0)
    tracer = gelight.LightTracer(ball, albedo=0)
    light = tracer.trace((0, 0, 0), (0, 0, 1), power=3, narrowness=0, paths=1 << 15, threads=2)
    up = ball.vertices[:, 2] / 2
    lit = up > 0.3  # whose faces are all in front of the LED
    # But for the edges between faces, which lie up to 3 % nearer to the middle than the ball.
    ball_itself = 3 / (2 * np.pi * 2**2)
    off = np.abs(light.irradiance - ball_itself)
    assert np.all((off < 6 * light.irradiance_error + 0.06 * ball_itself)[lit])
    a, b, c = (ball.vertices[ball.faces[:, k]] for k in range(3))
    thirds = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    area = np.bincount(ball.faces.T.ravel(), np.tile(thirds, 3))
    assert np.sum(light.irradiance * area) == pytest.approx(3)
    assert np.all(light.irradiance[up < -0.3] == 0)
    assert np.all(np.sum(light.direction[lit] * ball.vertices[lit] / 2, axis=1) > 0.97)
    assert light.balance.coating == pytest.approx(1, abs=1e-9)
    assert light.direction.shape == light.vector.shape == (ball.vertex_count, 3)
    again = tracer.trace((0, 0, 0), (0, 0, 1), power=3, narrowness=0, paths=1 << 15)
    assert np.array_equal(again.irradiance, light.irradiance)


@needs_embree
def test_light_meets_layers():
    ball = gelight.icosphere(3)
    core = gelight.beneath(ball, 0.25)
    assert np.allclose(np.linalg.norm(core.vertices, axis=1), 0.75, atol=1e-3)
    glass = gelight.LightTracer(ball, albedo=0, layers=[gelight.InnerLayer(core, 1.5, 100.0)])
    light = glass.trace((0, 0, 0), (0, 0, 1), layer=1, paths=4096)
    assert light.balance.gel > 0.99  # absorbed in the core
    with pytest.raises(ValueError, match="layer"):
        glass.trace((0, 0, 0), (0, 0, 1), layer=2)
    with pytest.raises(ValueError, match="shines along"):
        glass.trace((0, 0, 0), (0, 0, 0))
    with pytest.raises(ValueError, match="paths"):
        glass.trace((0, 0, 0), (0, 0, 1), paths=0)
    with pytest.raises(ValueError, match="place has 2"):
        glass.trace((0, 0), (0, 0, 1))
    with pytest.raises(gelight.Cancelled):
        glass.trace((0, 0, 0), (0, 0, 1), cancelled=lambda done: True)
