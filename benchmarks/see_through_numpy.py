"""The STS frame in NumPy and OpenCV: what see_through_benchmark.cpp is measured against.

Usage: python3 see_through_numpy.py DEPTH.npy IMAGE.npy FIELD_OF_VIEW RADIUS TILT [REPEATS]

Clips a depth map to 5 mm of gel at its largest depth, finds the normals as the directions of least
covariance of (2 RADIUS + 1)^2 neighbours, lights them by Phong's equation with the constants of the
STS paper and four lights at the edges, darkens what is pressed in, and writes the image. Prints the
milliseconds of a frame and of its normals, best and median of REPEATS runs on one thread. Windows
are summed up by OpenCV's box filter, and all eigenvectors found in one call.
"""

import statistics
import sys
import time

import cv2
import numpy as np

THICKNESS, DARKENING, DARKENING_DEPTH = 0.005, 0.2, 0.002
AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.8, 1.0, 0.5, 5
GEL = np.array([0.7, 0.7, 0.8])


def rays(height, width, field_of_view):
    focal = height / 2 / np.tan(field_of_view / 2)
    x, y = np.meshgrid((np.arange(width) - (width - 1) / 2) / focal,
                       (np.arange(height) - (height - 1) / 2) / focal)
    return np.dstack([x, y, np.ones_like(x)])


def covariance_normals(points, radius):
    size = (2 * radius + 1, 2 * radius + 1)

    def window_sum(values):
        return cv2.boxFilter(values, cv2.CV_64F, size, normalize=False,
                             borderType=cv2.BORDER_CONSTANT)

    count = window_sum(np.ones(points.shape[:2]))
    mean = window_sum(points) / count[..., None]
    covariance = np.empty(points.shape[:2] + (3, 3))
    for i in range(3):
        for j in range(i, 3):
            product = window_sum(points[..., i] * points[..., j]) / count
            covariance[..., i, j] = covariance[..., j, i] = product - mean[..., i] * mean[..., j]
    normals = np.linalg.eigh(covariance)[1][..., 0]
    away = np.sum(normals * points, axis=2) > 0
    return np.where(away[..., None], -normals, normals)


def render(depth, ray, radius, tilt):
    rest = depth.max()
    gel = np.maximum(depth, rest - THICKNESS)
    start = time.perf_counter()
    normals = covariance_normals(gel[..., None] * ray, radius)
    normals_time = time.perf_counter() - start
    view = -ray / np.linalg.norm(ray, axis=2, keepdims=True)
    light = np.full(depth.shape + (3,), AMBIENT)
    for x, y, rgb in [(1, 0, (1, 0, 0)), (-1, 0, (0, 1, 0)), (0, 1, (0, 0, 1)), (0, -1, (1, 1, 1))]:
        to_light = np.array([x * np.cos(tilt), y * np.cos(tilt), -np.sin(tilt)])
        facing = np.maximum(normals @ to_light, 0)
        mirrored = np.sum((2 * facing[..., None] * normals - to_light) * view, axis=2)
        shine = np.where(facing > 0, np.maximum(mirrored, 0), 0) ** SHININESS
        light += (DIFFUSE * facing + SPECULAR * shine)[..., None] * np.array(rgb)
    lost = DARKENING * np.minimum((rest - gel) / DARKENING_DEPTH, 1)
    image = light * GEL * (1 - lost)[..., None]
    return np.clip(255 * image, 0, 255).astype(np.uint8), normals_time


def main():
    depth = np.load(sys.argv[1]).astype(np.float64)
    ray = rays(*depth.shape, float(sys.argv[3]))
    radius, tilt = int(sys.argv[4]), float(sys.argv[5])
    cv2.setNumThreads(1)
    frames, normals = [], []
    for _ in range(int(sys.argv[6]) if len(sys.argv) > 6 else 3):
        start = time.perf_counter()
        image, normals_time = render(depth, ray, radius, tilt)
        frames.append(1e3 * (time.perf_counter() - start))
        normals.append(1e3 * normals_time)
    np.save(sys.argv[2], image.astype(np.float32))
    print(f"frame best_ms {min(frames):.2f} median_ms {statistics.median(frames):.2f} "
          f"normals_best_ms {min(normals):.2f}")


if __name__ == "__main__":
    main()
