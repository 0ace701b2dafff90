"""A sensor whose photographs are made here, by a formula of one line."""

import numpy as np
import pytest

import gelight

HEIGHT, WIDTH, BALL = 60, 80, 40.0


def photograph(x, y, radius):
    """Grey that brightens to the right and below with the slope of the ball; none beside it."""
    v, u = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    inside = (u - x) ** 2 + (v - y) ** 2 <= radius**2
    change = np.stack([(u - x) / BALL, (v - y) / BALL, -(u - x) / BALL], axis=2)
    return np.clip(120 * (1 + 0.8 * change * inside[..., None]), 0, 255).round().astype(np.uint8)


@pytest.fixture(scope="module")
def fitted():
    random = np.random.default_rng(0)
    background = np.full((HEIGHT, WIDTH, 3), 120) + random.integers(0, 2, (HEIGHT, WIDTH, 3))
    presses = []
    for i in range(8):
        circle = (20 + 5.5 * i, 18 + 3.0 * (i % 4) * 2, 11.0)
        presses.append(gelight.BallPress(photograph(*circle), BALL, circle, f"press {i}"))
    return gelight.calibrate(background.astype(np.uint8), presses, bulge_length=2.0)


def test_fit_predicts_a_press_it_has_not_seen(fitted):
    circle = (43.0, 31.0, 11.0)
    truth = photograph(*circle).astype(float)
    ours = gelight.predict(fitted.sensor, circle, BALL)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    inside = (u - 43) ** 2 + (v - 31) ** 2 < 9**2
    assert np.abs(truth - 120)[inside].mean() > 8
    assert np.abs(ours - truth)[inside].mean() < 2.5
    assert len(fitted.presses) == 8 and fitted.presses[3].name == "press 3"
    assert {r.region for r in fitted.regions} and isinstance(fitted.warnings, list)


def test_sensor_file_and_renderer(fitted, tmp_path):
    path = tmp_path / "mïne.sensor"
    gelight.write_sensor(path, fitted.sensor)
    sensor = gelight.read_sensor(str(path))
    assert np.array_equal(sensor.background, gelight.read_sensor(path).background)
    assert np.array_equal(sensor.background, fitted.sensor.background)
    camera = gelight.Camera(4000, 4000, (WIDTH - 1) / 2, (HEIGHT - 1) / 2, WIDTH, HEIGHT)
    rest = np.ones((HEIGHT, WIDTH), np.float32)
    renderer = gelight.TactileRenderer(camera, rest, sensor)
    assert np.abs(renderer.rest_image.astype(int) - sensor.background).max() <= 1
    x, y, radius = 43.0, 31.0, 11.0
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    square = BALL**2 - (u - x) ** 2 - (v - y) ** 2
    cap = np.sqrt(BALL**2 - radius**2)
    deep = BALL - cap + gelight.rim_height(radius, BALL, sensor.bulge_length)
    depth = np.where(square > 0, 1 - (deep - BALL + np.sqrt(np.maximum(square, 0))) / 4000, np.inf)
    image = renderer.render(depth.astype(np.float32)).astype(float)
    inside = (u - x) ** 2 + (v - y) ** 2 < 8**2
    assert np.abs(image - photograph(x, y, radius))[inside].mean() < 3


def test_presses_that_cannot_be_used():
    grey = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    with pytest.raises(ValueError):
        gelight.calibrate(grey, [])
    press = gelight.BallPress(photograph(40, 30, 11), BALL, (400, 30, 11), "far out")
    with pytest.raises(ValueError, match="far out|constant"):
        gelight.calibrate(grey, [press])
    random = np.random.default_rng(1)
    background = (grey + random.integers(0, 3, grey.shape)).astype(np.uint8)
    for contact in ((40, 30, 11), None):
        press = gelight.BallPress(background, BALL, contact, "untouched")
        with pytest.raises(ValueError, match="untouched shows no press"):
            gelight.calibrate(background, [press])
    seen = photograph(40, 30, 11)
    for photo, ball, contact, said in (
            (seen, BALL, (40, np.nan, 11), "has contact.y nan, which is not finite"),
            (seen, BALL, (40, 30, 0), "has contact.radius 0, which is not positive"),
            (seen, 0, (40, 30, 11), "has ball radius 0, which is not positive"),
            (seen[:0], BALL, (40, 30, 11), "has 80 x 0 pixels"),
            (seen[:, :0], BALL, (40, 30, 11), "has 0 x 60 pixels")):
        with pytest.raises(ValueError, match="spoilt " + said):
            gelight.calibrate(background, [gelight.BallPress(photo, ball, contact, "spoilt")])
        with pytest.raises(ValueError):
            gelight.calibrate(background[:0], [gelight.BallPress(photo, ball, contact, "spoilt")])
    with pytest.raises(TypeError):
        gelight.BallPress(np.zeros((5, 5, 3)), BALL)
    with pytest.raises(ValueError, match="cannot be opened"):
        gelight.read_sensor("/nowhere/at/all")
    with pytest.raises(TypeError):
        gelight.read_sensor(3)
