"""Meshes that no .geo describes: a cone, plates and a box as obstacles (OBJ), two ribbons in a reef knot and sheets at random
places (MSH 2.2)."""

import math
from pathlib import Path

import numpy as np


def write_obj(path, points, triangles):
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_msh(path, points, groups):
    """`groups`: (name, dimension, cells) with rows of 1, 2 or 3 vertices as cells; each triangle in one group."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    lines += [f'{dimension} {k} "{name}"' for k, (name, dimension, _) in enumerate(groups, 1)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{k} {x:.12g} {y:.12g} {z:.12g}" for k, (x, y, z) in enumerate(points, 1)]
    elements = [(dimension, k, cell) for k, (_, dimension, cells) in enumerate(groups, 1) for cell in cells]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{number} {dimension or 15} 2 {k} {k} " + " ".join(str(v + 1) for v in cell)
              for number, (dimension, k, cell) in enumerate(elements, 1)]
    path.write_text("\n".join([*lines, "$EndElements"]) + "\n")
    return path


def strip(rows, columns):
    """Triangles of a grid of vertices numbered along the columns first; diagonals alternate."""
    triangles = []
    for i in range(rows - 1):
        for j in range(columns - 1):
            a = i * columns + j
            b, c, d = a + 1, a + columns, a + columns + 1
            triangles += [(a, c, d), (a, d, b)] if (i + j) % 2 == 0 else [(a, c, b), (b, c, d)]
    return np.array(triangles)


# ------------------------------------------------------------------------------------------------------------ obstacles

def box(low, high):
    points = [[(low, high)[k >> 2 & 1][0], (low, high)[k >> 1 & 1][1], (low, high)[k & 1][2]] for k in range(8)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def funnel(top_radius, hole_radius, height, pipe, around=48):
    """Open cone with its rim in z = 0, and a pipe below its hole."""
    rings = [(top_radius, 0.0), (hole_radius, -height), (hole_radius, -height - pipe)]
    angles = 2 * math.pi * np.arange(around) / around
    points = [(r * math.cos(a), r * math.sin(a), z) for r, z in rings for a in angles]
    triangles = []
    for k in range(len(rings) - 1):
        for i in range(around):
            a, b = k * around + i, k * around + (i + 1) % around
            triangles += [(a, a + around, b + around), (a, b + around, b)]
    return points, triangles


def plates(places, length, height):
    """Thin vertical plates along y whose upper edges lie in z = 0 at the given x."""
    points, triangles = [], []
    for x in places:
        n = len(points)
        points += [(x, -length / 2, -height), (x, length / 2, -height), (x, length / 2, 0), (x, -length / 2, 0)]
        triangles += [(n, n + 1, n + 2), (n, n + 2, n + 3)]
    return points, triangles


# --------------------------------------------------------------------------------------------------------------- sheets

def smooth_curve(corners, rounds=5):
    """Polygon rounded by cutting its corners; its ends stay."""
    p = np.array(corners, float)
    for _ in range(rounds):
        cut = np.empty((2 * len(p) - 2, p.shape[1]))
        cut[0::2], cut[1::2] = 0.75 * p[:-1] + 0.25 * p[1:], 0.25 * p[:-1] + 0.75 * p[1:]
        p = np.vstack([p[:1], cut, p[-1:]])
    return p


def resample(curve, spacing):
    """Points of a curve at equal distances in its plane z = constant."""
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(curve[:, :2], axis=0), axis=1)))
    s = np.linspace(0.0, length[-1], max(2, round(length[-1] / spacing)) + 1)
    return np.column_stack([np.interp(s, length, curve[:, k]) for k in range(curve.shape[1])])


def reef_knot(path, width=0.024, cells=3, tail=0.45, narrow=0.03, wide=0.13, reach=0.14, lift=0.018):
    """Two ribbons on edge (their width along z), each a bight around the legs of the other; they cross six times and are
    2 lift - width apart there. Ends: "left ends" of the one, "right ends" of the other."""
    # One bight seen from above: x, y, height. It comes in over the bend of the other, dives under its flank and goes over
    # its legs; the other is its mirror image in x, and passes where this one does not.
    n, w, c, z = narrow, wide, reach, lift
    half = [(-tail, n, 0), (-1.7 * c, n, 0), (-1.3 * c, n, z), (-0.7 * c, n, z), (-0.2 * c, 0.5 * (n + w) - 0.2 * (w - n), -z),
            (0.2 * c, 0.5 * (n + w) + 0.2 * (w - n), -z), (0.6 * c, w, -0.3 * z), (c, w, z), (1.05 * c, 0.6 * w, z)]
    bend = half + [(x, -y, h) for x, y, h in reversed(half)]
    h = width / cells
    points, groups = [], []
    for name, sign in (("left", 1.0), ("right", -1.0)):
        curve = resample(smooth_curve([(sign * x, y, sign * u) for x, y, u in bend]), h)
        across = np.linspace(-width / 2, width / 2, cells + 1)
        first, rows = len(points), len(curve)
        points += [(x, y, u + v) for x, y, u in curve for v in across]
        last = first + (rows - 1) * (cells + 1)
        ends = [(a + k, a + k + 1) for a in (first, last) for k in range(cells)]
        groups += [(f"{name} ends", 1, ends), (f"{name} ribbon", 2, strip(rows, cells + 1) + first)]
    return write_msh(path, points, groups)


def sheet_pieces(path, pieces):
    """Rectangles. `pieces`: (centre, two unit vectors along the sides, lengths, cells); they become "sheet 1", ..."""
    points, groups = [], []
    for k, (centre, axes, lengths, cells) in enumerate(pieces, 1):
        first = len(points)
        u, v = (np.linspace(-0.5, 0.5, c + 1) * length for c, length in zip(cells, lengths))
        points += [np.asarray(centre) + a * axes[0] + b * axes[1] for a in u for b in v]
        groups.append((f"sheet {k}", 2, strip(len(u), len(v)) + first))
    return write_msh(path, points, groups)
