"""A sensor of your own, calibrated from photographs of a ball pressed into it.

With a folder: background.png, photographs and presses.csv (image, center_x_px, center_y_px,
contact_radius_px, ball_radius_mm, mm_per_px). Without one the photographs are made here, by a
renderer that the fit knows nothing of; the last three presses are kept back to compare with.

Run: python3 calibrate_sensor.py [picture.png] [folder]
"""

import csv
import pathlib
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import gelight


def from_folder(folder):
    """Photographs of a real sensor: the one untouched, and those of presses."""
    def photograph(name):
        image = plt.imread(folder / name)[..., :3]
        return np.ascontiguousarray((255 * image).round().astype(np.uint8))

    presses = []
    for row in csv.DictReader(open(folder / "presses.csv")):
        circle = [float(row[k]) for k in ("center_x_px", "center_y_px", "contact_radius_px")]
        ball = float(row["ball_radius_mm"]) / float(row["mm_per_px"])
        presses.append(gelight.BallPress(photograph(row["image"]), ball, circle, row["image"]))
    return photograph("background.png"), presses


def made_here(width=160, height=120, ball=45.0, radius=16.0):
    """Photographs by near lights over a gel that bulges, with a camera's noise."""
    camera = gelight.Camera(4000, 4000, (width - 1) / 2, (height - 1) / 2, width, height)
    v, u = np.mgrid[:height, :width].astype(float)
    lights = []
    for x, y, rgb in ((1.4, 0.5, (1, 0, 0)), (-0.2, -0.4, (0, 1, 0)), (-0.2, 1.4, (0, 0, 1))):
        way = np.stack([u - x * width, v - y * height, np.full_like(u, 30.0)], axis=2)
        lights.append(gelight.Light(way / np.linalg.norm(way, axis=2, keepdims=True), rgb))
    real = gelight.TactileRenderer(camera, np.ones((height, width)), lights, (0.45, 0.5, 0.55),
                                   gelight.TactileOptions(ambient=0.8),
                                   gelight.TensionMembrane(6.0))
    background = real.rest_image.copy()
    gelight.add_noise(background, 1.0, seed=0)
    presses = []
    random = np.random.default_rng(3)
    for i in range(15):
        x, y = random.uniform((25, 25), (width - 25, height - 25))
        deep = ball - np.sqrt(ball**2 - radius**2) + gelight.rim_height(radius, ball, 6.0)
        square = ball**2 - (u - x) ** 2 - (v - y) ** 2
        up = np.sqrt(np.maximum(square, 0)) - (ball - deep)
        photo = real.render(np.where(square > 0, 1 - up / 4000, np.inf))
        gelight.add_noise(photo, 1.0, seed=1, frame=i)
        presses.append(gelight.BallPress(photo, ball, (x, y, radius), f"press {i}"))
    return background, presses


folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
background, presses = from_folder(folder) if folder else made_here()
known, unseen = presses[:-3], presses[-3:]
fit = gelight.calibrate(background, known)
print(f"bulge {fit.sensor.bulge_length:.1f} +- {fit.bulge_doubt:.1f} pixels")
for region in fit.regions:
    print(f"  {region.region:8} signal {region.signal:.2f}, left {region.residual:.2f} grey levels")
for warning in fit.warnings:
    print("  warning:", warning)
gelight.write_sensor("mine.sensor", fit.sensor)  # read_sensor gives it back to any renderer

figure, axes = plt.subplots(3, len(unseen), figsize=(8, 6), layout="constrained")
for (photo, ours, difference), press in zip(axes.T, unseen):
    made = gelight.predict(fit.sensor, press.contact, press.ball_radius)
    off = press.photograph - made
    x, y, radius = press.contact
    v, u = np.mgrid[: off.shape[0], : off.shape[1]]
    inside = (u - x) ** 2 + (v - y) ** 2 < radius**2
    print(f"{press.name}, not fitted: {np.abs(off)[inside].mean():.2f} grey levels off in the "
          f"contact, of {np.abs(press.photograph.astype(float) - background)[inside].mean():.2f}")
    photo.imshow(press.photograph)
    ours.imshow(np.clip(made, 0, 255).astype(np.uint8))
    difference.imshow(np.clip(128 + 2 * off, 0, 255).astype(np.uint8))
for axis, name in zip(axes[:, 0], ("photograph", "ours", "difference x 2")):
    axis.set_ylabel(name)
for axis in axes.flat:
    axis.set(xticks=[], yticks=[])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "calibrate_sensor.png", dpi=80)
