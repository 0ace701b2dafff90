"""Meshes and their true distances, by NumPy alone."""

import numpy as np


def sheet(columns=12, rows=8, width=3.0, height=2.0):
    """A flat sheet of columns x rows cells: vertices, faces."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    b = a + columns + 1
    return vertices, np.concatenate([np.stack([a, a + 1, b + 1], 1), np.stack([a, b + 1, b], 1)])


def globe(rings=24, around=48):
    """A unit sphere by longitude and latitude, poles included."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]
    longitude = np.arange(around) * 2 * np.pi / around
    t, p = np.meshgrid(longitude, latitude)
    ring = np.stack([np.cos(p) * np.cos(t), np.cos(p) * np.sin(t), np.sin(p)], -1).reshape(-1, 3)
    vertices = np.concatenate([[[0, 0, -1]], ring, [[0, 0, 1]]])
    faces = []
    for k in range(around):
        n = (k + 1) % around
        faces.append([0, 1 + n, 1 + k])
        for i in range(rings - 2):
            a, b = 1 + i * around, 1 + (i + 1) * around
            faces += [[a + k, a + n, b + n], [a + k, b + n, b + k]]
        top = 1 + (rings - 2) * around
        faces.append([top + k, top + n, len(vertices) - 1])
    return vertices, np.array(faces)


def arc(vertices, source):
    """Distances along great circles of the unit sphere."""
    return np.arccos(np.clip(vertices @ vertices[source], -1, 1))


def cone(sides=64, rings=10, spread=1.5):
    """A cone folded from a flat sector of so many radians: apex first, polar coordinates too."""
    r = np.linspace(0, 1, rings + 1)[1:]
    turn = np.arange(sides) * 2 * np.pi / sides
    half = spread / (2 * np.pi)
    rr, tt = np.meshgrid(r, turn, indexing="ij")
    z = np.sqrt(1 - half**2) * rr
    ring = np.stack([half * rr * np.cos(tt), half * rr * np.sin(tt), z], -1).reshape(-1, 3)
    vertices = np.concatenate([[[0.0, 0, 0]], ring])
    k, n = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = [np.stack([0 * k, 1 + k, 1 + n], 1)]
    for i in range(rings - 1):
        a, b = 1 + i * sides, 1 + (i + 1) * sides
        faces += [np.stack([a + k, b + k, b + n], 1), np.stack([a + k, b + n, a + n], 1)]
    return vertices, np.concatenate(faces)


def unfolded(vertices, source):
    """Distances on such a cone with its apex cut open, each of its plane triangles laid flat."""
    sides = 64
    slant = np.linalg.norm(vertices, axis=1)
    corner = 2 * np.arcsin(np.linalg.norm(vertices[1] - vertices[2]) / (2 * slant[1]))
    index = (np.arange(len(vertices)) - 1) % sides
    apart = np.abs(index - index[source])
    angle = np.minimum(apart, sides - apart) * corner
    angle[0] = 0
    a, b = slant, slant[source]
    straight = np.sqrt(np.maximum(0, a**2 + b**2 - 2 * a * b * np.cos(angle)))
    return np.where(angle < np.pi, straight, a + b)
