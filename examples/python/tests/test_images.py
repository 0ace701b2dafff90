"""Rasteriser, light and renderers."""

import numpy as np
import pytest

import gelight

CAMERA = gelight.Camera.from_vertical_fov(1.0, 64, 48)


def empty(dtype=np.float32):
    return np.full((48, 64), np.inf, dtype)


def plane_at(z):
    """A square across the camera's axis that it sees nothing beside of."""
    corner = 4 * z
    vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * corner + [0, 0, z]
    return gelight.Surface(vertices, [[0, 1, 2], [0, 2, 3]])


def ball_depth(z, radius):
    """What the camera sees of a ball on its axis, by the quadratic equation."""
    v, u = np.mgrid[:48, :64].astype(float)
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    a, b, c = x**2 + y**2 + 1, -2 * z, z**2 - radius**2
    root = b**2 - 4 * a * c
    return np.where(root > 0, (-b - np.sqrt(np.maximum(0, root))) / (2 * a), np.inf)


def test_rasterised_plane_and_ball():
    raster = gelight.rasterize(plane_at(2.0), CAMERA)
    assert raster.depth == pytest.approx(2.0)
    assert raster.face.shape == (48, 64) and set(np.unique(raster.face)) == {0, 1}
    assert raster.barycentric.sum(axis=2) == pytest.approx(1, abs=1e-6)
    depth = gelight.rasterize(gelight.joined([plane_at(9.0), plane_at(3.0)]), CAMERA).depth
    assert depth == pytest.approx(3.0)

    ball = empty()
    gelight.rasterize_into(ball, gelight.icosphere(5, 0.5), gelight.Pose(None, [0, 0, 2]), CAMERA)
    truth = ball_depth(2.0, 0.5)
    inside = np.isfinite(truth) & np.isfinite(ball)
    assert np.mean(np.isfinite(truth) != np.isfinite(ball)) < 0.01
    assert np.abs(ball - truth)[inside].max() < 0.02 and inside.sum() > 200


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_rasterize_into_draws_where_it_lies(dtype):
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    box, pose = gelight.box(0.5, 0.2, 0.1), gelight.Pose(turn, [0.1, 0, 2])
    work = gelight.RasterWorkspace()
    truth = empty(dtype)
    gelight.rasterize_into(truth, box, pose, CAMERA, work)
    rows = np.zeros((96, 64), dtype)
    for view in (rows[::2], rows[::-2], np.zeros((48, 128), dtype)[:, ::2],
                 np.zeros((64, 48), dtype).T):
        view[:] = np.inf
        gelight.rasterize_into(view, box, pose, CAMERA, work)
        assert np.array_equal(view, truth)
    assert np.array_equal(pose.rotation, turn) and np.array_equal(pose.translation, [0.1, 0, 2])
    # What is nearer already stays.
    near = np.full((48, 64), 1.0, dtype)
    gelight.rasterize_into(near, box, pose, CAMERA)
    assert np.all(near == 1)


def test_normals_and_points():
    depth = np.full((48, 64), 2.0, np.float32)
    points = gelight.unproject(depth, CAMERA)
    v, u = np.mgrid[:48, :64]
    assert points[..., 0] == pytest.approx((u - CAMERA.cx) / CAMERA.fx * 2, abs=1e-5)
    assert points[..., 1] == pytest.approx((v - CAMERA.cy) / CAMERA.fy * 2, abs=1e-5)
    normals = gelight.sobel_normals(depth, CAMERA, gelight.BorderNormals.extrapolated)
    assert normals == pytest.approx(np.tile([0, 0, -1.0], (48, 64, 1)), abs=1e-4)
    assert CAMERA.project(points[10, 20]) == pytest.approx([20, 10], abs=1e-3)


def test_fields_of_light_on_a_plane():
    surface = gelight.grid(20, 20)
    led = 10 * 21 + 10
    truth = surface.vertices - surface.vertices[led]
    far = np.linalg.norm(truth, axis=1)
    truth /= np.where(far > 0, far, 1)[:, None]
    points = np.arange(surface.vertex_count)
    for model in (gelight.LinearLight, gelight.PlaneLight, gelight.GeodesicLight):
        field = model(surface).field(led, points)
        assert field.dtype == np.float32
        assert field == pytest.approx(truth, abs=2e-5)
    transport = gelight.TransportLight(surface)
    off = np.linalg.norm(transport.field(led, points) - truth, axis=1)
    assert np.median(off) < 0.1
    straight = transport.field(gelight.Led(led, [1, 0, 0]), points)
    assert straight == pytest.approx(np.tile([1, 0, 0], (441, 1)), abs=1e-3)
    rays = gelight.GeodesicLight(surface).rays(led, points)
    assert rays.distance == pytest.approx(far, abs=1e-5)
    assert rays.lighting[led] == int(gelight.Lighting.at_led)
    with pytest.raises(ValueError, match="emission"):
        gelight.GelLight(surface).field(led, points)
    ball = gelight.icosphere(2)
    gelight.GelLight(ball)
    inside_out = gelight.Surface(ball.vertices, ball.faces[:, ::-1])
    gelight.GelLight(inside_out, has_normals_inwards=True)
    with pytest.raises(ValueError, match="normals inwards"):
        gelight.GelLight(inside_out)


def test_baking_puts_directions_where_pixels_are():
    mesh = plane_at(2.0)
    raster = gelight.rasterize(mesh, CAMERA)
    faces, barycentric = gelight.pixel_points(raster)
    assert len(faces) == 48 * 64
    light = gelight.LinearLight(mesh)
    baked = gelight.bake(light.field(0, raster), raster)
    by_points = gelight.bake(light.field(0, faces, barycentric), raster)
    assert baked.shape == (48, 64, 3)
    assert baked == pytest.approx(by_points, abs=1e-6)
    way = gelight.unproject(raster.depth, CAMERA) - mesh.vertices[0]
    assert baked == pytest.approx(way / np.linalg.norm(way, axis=2, keepdims=True), abs=1e-5)


def small_renderer(**changed):
    direction = np.zeros((48, 64, 3), np.float32)
    direction[:] = [1, 0, 0]
    options = gelight.TactileOptions(**{"smoothing_sigma": 2, "smoothing_radius": 6, **changed})
    rest = np.full((48, 64), 0.02, np.float32)
    return gelight.TactileRenderer(CAMERA, rest, [gelight.Light(direction, (1, 0, 0))],
                                   (0.2, 0.4, 0.6), options)


def pressed():
    """A ball 1.5 mm into gel that is 20 mm away."""
    return ball_depth(0.0235, 0.005).astype(np.float32)


def test_phong_of_an_untouched_membrane():
    renderer = small_renderer(ambient=0.5)
    # Ambient light alone: the light runs along the membrane.
    assert np.all(renderer.rest_image[5, 5] == [25, 51, 76])
    assert np.array_equal(renderer.render(empty()), renderer.rest_image)
    image = renderer.render(pressed())
    changed = np.any(image != renderer.rest_image, axis=2)
    v, u = np.nonzero(changed)
    assert 50 < changed.sum() < 48 * 64 / 2
    # Light that travels to the right meets the slope that faces left; green and blue have no light.
    assert np.all(image[..., 1] == 51) and np.all(image[..., 2] == 76)
    red = image[..., 0].astype(int) - 25
    assert red[:, 32:].max() != red[:, :32].max()


def test_any_layout_gives_the_same_image():
    renderer, depth = small_renderer(), pressed()
    truth = renderer.render(depth)
    wide = np.full((96, 128), np.inf, np.float32)
    wide[::2, ::2] = depth
    packed_in_a_record = np.zeros((48, 64), np.dtype([("a", "u1"), ("z", "f4")]))
    packed_in_a_record["z"] = depth  # not aligned
    for layout in (depth.astype(np.float64), wide[::2, ::2], np.asfortranarray(depth),
                   depth[::-1, ::-1].copy()[::-1, ::-1], depth.astype(">f4"),
                   packed_in_a_record["z"]):
        assert np.array_equal(renderer.render(layout), truth)
    for out in (np.zeros((48, 64, 3), np.uint8), np.zeros((96, 128, 3), np.uint8)[::2, ::2],
                np.zeros((48, 64, 3), np.uint8)[::-1, ::-1],
                np.zeros((48, 64, 4), np.uint8)[..., :3],
                np.zeros((48, 64, 3), np.uint8)[..., ::-1],  # blue, green, red
                np.moveaxis(np.zeros((3, 48, 64), np.uint8), 0, 2)):  # planes
        renderer.render_into(out, depth)
        assert np.array_equal(out, truth)


def test_frame_to_frame_is_the_same_bit_for_bit():
    renderer = small_renderer()
    frame = renderer.rest_frame()
    image = frame.image
    address = image.__array_interface__["data"][0]
    for shift in range(8):
        depth = np.roll(pressed(), 3 * shift, axis=1) + np.float32(1e-4 * shift)
        renderer.render_next_into(frame, depth)
        assert np.array_equal(frame.image, renderer.render(depth))
        assert np.array_equal(image, frame.image)  # the same memory
        assert frame.image.__array_interface__["data"][0] == address
    with pytest.raises(ValueError, match="read-only"):
        frame.image[0, 0, 0] = 1


def test_membranes():
    rest, depth = np.full((48, 64), 0.02, np.float32), pressed()
    gel = gelight.Gel(thickness=0.004)
    light = gelight.Light(np.tile(np.float32([1, 0, 0]), (48, 64, 1)))
    options = gelight.TactileOptions(smoothing_sigma=2, smoothing_radius=6)
    default = gelight.TactileRenderer(CAMERA, rest, [light], None, options).render(depth)
    bed = gelight.SpringBed(CAMERA, 0.02, gel)
    layer = gelight.ElasticLayer(CAMERA, 0.02, gel, sideways=False)
    for membrane in (gelight.GaussianMembrane(2, 6), gelight.BulgingMembrane(CAMERA, 0.02, gel),
                     gelight.SpringMembrane(bed, 1.0), gelight.LayerMembrane(layer),
                     gelight.TensionMembrane(4)):
        renderer = gelight.TactileRenderer(CAMERA, rest, [light], None, options, membrane)
        image = renderer.render(depth)
        assert np.any(image != renderer.rest_image)
        if isinstance(membrane, gelight.GaussianMembrane):
            assert np.array_equal(image, default)


def test_springs_bear_the_force():
    gel = gelight.Gel(elastic_modulus=1e5, thickness=0.004)
    depth = pressed()
    contact = gelight.SpringBed(CAMERA, 0.02, gel).press(depth, 2.0)
    assert contact.equilibrium == gelight.Equilibrium.reached
    assert contact.force == pytest.approx(2.0)
    area = 0.02**2 / (CAMERA.fx * CAMERA.fy)
    borne = contact.indentation[contact.touching == 1].sum() * area * gel.stiffness
    assert borne == pytest.approx(2.0, rel=1e-4)


def test_layer_against_hertz():
    """Force and radius of a ball on a half-space: F = 4/3 E* sqrt(R) d^1.5, a^2 = R d."""
    camera = gelight.Camera(2000, 2000, 63.5, 63.5, 128, 128)
    radius, press, rest = 0.005, 1.2e-5, 0.02
    v, u = (np.mgrid[:128, :128] - 63.5) * rest / 2000
    depth = (rest - press + (u**2 + v**2) / (2 * radius)).astype(np.float32)
    gel = gelight.Gel(elastic_modulus=1e5, poisson_ratio=0.3, thickness=np.inf)
    contact = gelight.ElasticLayer(camera, rest, gel).press(depth)
    modulus = 1e5 / (1 - 0.3**2)
    assert contact.converged
    hertz = 4 / 3 * modulus * np.sqrt(radius) * press**1.5
    assert -contact.force[2] == pytest.approx(hertz, rel=0.02)
    touched = (contact.pressure > 0).sum() * (rest / 2000) ** 2
    assert touched == pytest.approx(np.pi * radius * press, rel=0.05)
    assert contact.displacement.shape == (128, 128, 3) and contact.traction.shape == (0, 0, 2)
    by_force = gelight.ElasticLayer(camera, rest, gel).press(depth, force=-contact.force[2])
    assert by_force.travel == pytest.approx(0, abs=press / 50)


def test_see_through():
    camera = CAMERA
    rest = np.full((48, 64), 0.02, np.float32)
    lights = gelight.edge_lights(camera, 0.3)
    assert len(lights) == 4 and lights[0].direction.shape == (48, 64, 3)
    options = gelight.SeeThroughOptions(thickness=0.004)
    renderer = gelight.SeeThroughRenderer(camera, rest, lights, options=options)
    visual = np.random.default_rng(0).integers(0, 255, (48, 64, 3)).astype(np.uint8)
    seen = renderer.render(empty(), visual, gelight.LightLevels.visual())
    # Half of the light comes through, a gain of two.
    assert np.abs(seen.astype(int) - visual).max() <= 1
    dark = renderer.render(empty(), visual, gelight.LightLevels.tactile())
    shares = visual.astype(np.float32) / 255
    felt = renderer.render(pressed(), shares, gelight.LightLevels.tactile())
    assert np.any(dark != felt)
    out = np.zeros((48, 64, 3), np.uint8)[:, ::-1]
    renderer.render_into(out, pressed(), visual)
    assert np.array_equal(out, renderer.render(pressed(), visual))
    assert np.array_equal(renderer.render(empty()), renderer.rest_image)


@pytest.mark.parametrize(
    "make", [gelight.geltip, gelight.gelsight_mini, gelight.digit, gelight.sts])
def test_presets(make):
    sensor = make(48, 36, 0.004 if make is gelight.geltip else 0.002)
    renderer = gelight.tactile_renderer(sensor)
    rest = gelight.rasterize(sensor.membrane, sensor.camera).depth
    assert renderer.rest_image.shape == (36, 48, 3)
    v, u = np.mgrid[-18:18, -24:24]
    press = np.where(u**2 + v**2 < 60, rest - np.float32(0.001), np.inf)
    assert np.any(renderer.render(press) != renderer.rest_image)
    other = gelight.tactile_renderer(sensor, gelight.LinearLight(sensor.membrane))
    off = np.abs(other.render(press).astype(int) - renderer.render(press))
    # On a flat pad shortest paths are straight lines.
    is_flat = np.ptp(np.asarray(sensor.membrane.vertices)[:, 2]) < 1e-9
    assert off.max() <= 1 if is_flat else off.max() > 1


def test_a_sensor_of_ones_own():
    pad = gelight.grid(10, 8, 0.02, 0.016)
    moved = gelight.Surface(pad.vertices + [-0.01, -0.008, 0.02], pad.faces)
    leds = gelight.points_of_border(moved, [0, np.pi])
    assert moved.position(leds[0]) == pytest.approx([0.01, 0, 0.02], abs=1e-9)
    sensor = gelight.SensorPreset(moved, CAMERA, leds, [(1, 0, 0), (0, 1, 0)])
    sensor.falloff = gelight.Falloff(absorption=50)
    sensor.options.smoothing_sigma = 3
    assert sensor.options.smoothing_sigma == 3
    assert gelight.tactile_renderer(sensor).rest_image.any()
    sensor.colours = [(1, 0, 0)]
    with pytest.raises(ValueError, match="2 LEDs and 1 colours"):
        gelight.tactile_renderer(sensor)


def test_noise():
    image = np.full((100, 100, 3), 128, np.uint8)
    gelight.add_noise(image[:, ::2], 5.0, seed=1)
    assert image[:, 1::2].std() == 0
    assert image[:, ::2].std() == pytest.approx(5, rel=0.05)
