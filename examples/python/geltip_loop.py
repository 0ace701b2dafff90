"""A GelTip in a simulator's loop: poses in, tactile images out, frame to frame.

A pose file has a line a frame: x y z (m) and a quaternion w x y z of the object in the camera's
frame. Without one a toy makes the poses: a torus comes, rolls over the tip and goes.

Run: python3 geltip_loop.py [picture.png] [poses.txt]
"""

import sys
import time

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import gelight


def toy(frames=100):
    """Kinematics in ten lines: height and roll of the object over time."""
    poses = []
    for t in np.linspace(0, 1, frames):
        press = np.sin(np.pi * t) ** 0.5  # comes fast, stays, goes
        roll = 1.2 * (t - 0.5)
        x = 0.006 * roll
        z = 0.0475 - 0.0022 * press
        poses.append([x, 0, z, np.cos(roll / 2), 0, np.sin(roll / 2), 0])
    return np.array(poses)


def rotation(*quaternion):
    """Of a quaternion, which a file's few digits leave longer or shorter than 1."""
    w, x, y, z = np.array(quaternion) / np.linalg.norm(quaternion)
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


poses = np.loadtxt(sys.argv[2]) if len(sys.argv) > 2 else toy()

# Once: the sensor with its light, and the object.
sensor = gelight.geltip(320, 240)
sensor.camera = gelight.Camera.from_vertical_fov(1.0, 320, 240)  # close to the tip
renderer = gelight.tactile_renderer(sensor)
torus = gelight.torus(0.004, 0.0015, 96, 32)
work = gelight.RasterWorkspace()
depth = np.empty((240, 320), np.float32)
frame = renderer.rest_frame()
kept = []

start = time.perf_counter()
for i, (x, y, z, *quaternion) in enumerate(poses):
    depth.fill(np.inf)
    pose = gelight.Pose(rotation(*quaternion), (x, y, z))
    gelight.rasterize_into(depth, torus, pose, sensor.camera, work)
    renderer.render_next_into(frame, depth)
    if i in np.linspace(0, len(poses) - 1, 8).astype(int):
        kept.append((i, frame.image.copy()))  # the next frame is written over this one
seconds = time.perf_counter() - start
print(f"{1e3 * seconds / len(poses):.2f} ms a frame")

figure, axes = plt.subplots(2, 4, figsize=(11, 4.6), layout="constrained")
for axis, (i, image) in zip(axes.flat, kept):
    axis.imshow(image)
    axis.set(title=f"frame {i}", xticks=[], yticks=[])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "geltip_loop.png", dpi=80)
