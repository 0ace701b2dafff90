"""The GelTip frame in NumPy and OpenCV: what frame_benchmark.cpp is measured against.

Usage: python3 frame_numpy.py REFERENCE_DIR [REPEATS]

Prints the milliseconds of every frame, one line per contact, best and median of REPEATS runs on one
thread, and how far the image is from the published one. The elastic membrane, the point cloud, its
Sobel normals and three Phong lights follow the description in the reference data's README; as in
the simulator it describes, the light fields are made tangent to the membrane anew in every frame.
"""

import statistics
import sys
import time
from pathlib import Path

import cv2
import numpy as np

WIDTH, HEIGHT = 640, 480
FOCAL = HEIGHT / 2  # a vertical field of view of 90 degrees
AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.5, 0.5, 0.1, 100


def gaussian_kernel(sigma, radius):
    taps = np.exp(-np.arange(-radius, radius + 1) ** 2 / (2.0 * sigma**2))
    return taps / taps.sum()


def normalised(vectors):
    length = np.linalg.norm(vectors, axis=2, keepdims=True)
    return vectors / np.where(length > 1e-12, length, 1.0)


def dot(a, b):
    return np.sum(a * b, axis=2)


def unprojected(depth):
    columns = (np.arange(WIDTH) - (WIDTH - 1) / 2) / FOCAL
    rows = (np.arange(HEIGHT) - (HEIGHT - 1) / 2) / FOCAL
    x, y = np.meshgrid(columns, rows)
    return np.dstack([x * depth, y * depth, depth])


def normals_towards_camera(points):
    along_x = np.array([[-1.0, 0, 1], [-2, 0, 2], [-1, 0, 1]])
    slope_x = cv2.filter2D(points, cv2.CV_64F, along_x)
    slope_y = cv2.filter2D(points, cv2.CV_64F, along_x.T)
    return -normalised(np.cross(normalised(slope_x), normalised(slope_y)))


class Simulator:
    def __init__(self, rest, background, fields, rectify):
        self.rest = rest.astype(np.float64)
        self.ambient = AMBIENT * background / 255.0
        self.fields = fields  # of the red, the green and the blue light
        self.rectify = rectify
        self.rest_normals = normals_towards_camera(unprojected(self.rest))
        self.kernel = gaussian_kernel(5.0, 20)

    def membrane(self, contact):
        spread = cv2.sepFilter2D(self.rest - contact, cv2.CV_64F, self.kernel, self.kernel)
        # The simulator hands its depth maps on as 32-bit numbers.
        return np.minimum(contact, self.rest - spread).astype(np.float32).astype(np.float64)

    def phong(self, field, normals, view):
        to_light = -field
        if self.rectify:
            along = dot(to_light, self.rest_normals)[..., None]
            to_light = normalised(to_light - along * self.rest_normals)
        facing = np.maximum(dot(to_light, normals), 0.0)
        mirrored = 2.0 * facing[..., None] * normals - to_light
        return DIFFUSE * facing + SPECULAR * dot(mirrored, view) ** SHININESS

    def render(self, contact):
        points = unprojected(self.membrane(contact.astype(np.float64)))
        normals = normals_towards_camera(points)
        view = -normalised(points)
        lit = [self.ambient + self.phong(field, normals, view) for field in self.fields]
        return np.clip(np.dstack(lit) * 255.0, 0, 255).astype(np.uint8)


def main():
    folder = Path(sys.argv[1]) / "geltip"
    repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    cv2.setNumThreads(1)
    fields = []
    for led in (1, 2, 0):
        coarse = np.load(folder / "field" / f"geodesic_led{led}.npy")
        fields.append(cv2.resize(cv2.GaussianBlur(coarse, (25, 25), 0), (WIDTH, HEIGHT)))
    background = cv2.imread(str(folder / "image" / "background.png"), cv2.IMREAD_COLOR)
    background = cv2.cvtColor(background, cv2.COLOR_BGR2GRAY)
    simulator = Simulator(np.load(folder / "depth" / "rest.npy"), background, fields, True)
    published = cv2.imread(str(folder / "image" / "expected_geodesic.png"))[..., ::-1].astype(int)
    for k in range(6):
        contact = np.load(folder / "depth" / f"contact_{k}.npy")
        times = []
        for _ in range(repeats):
            start = time.perf_counter()
            image = simulator.render(contact)
            times.append(1e3 * (time.perf_counter() - start))
        wrong = np.abs(image - published[:, WIDTH * k : WIDTH * (k + 1)]).max(axis=2)
        print(f"contact_{k} best_ms {min(times):.2f} median_ms {statistics.median(times):.2f} "
              f"worst_grey_levels {wrong.max()} pixels_off {(wrong > 0).sum()}")
        if wrong.max() > 1:
            sys.exit("the frame is not the published one")


if __name__ == "__main__":
    main()
