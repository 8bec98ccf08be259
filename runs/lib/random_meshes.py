"""Grids on the surfaces of meshes/*.geo whose inner vertices are moved at random along the surface, with the groups that these files have.

Symbols   s, t  place in the grid, both from 0 to 1
"""

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "contact" / "lib"))

from shapes import write_msh  # noqa: E402


def grid_mesh(file, cells, place, groups, jitter=0.25, seed=1, falling=False):
    """`place`: (s, t) -> x, y, z. `groups`: name -> a side ("left" is s = 0, "right", "low" is t = 0, "high") or the (s, t) of a vertex.
    Diagonals run from the lower left to the upper right vertex of a cell, or are falling."""
    nx, ny = cells
    rng = np.random.default_rng(seed)
    i, j = (g.astype(float) for g in np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="ij"))
    inside = (i > 0) & (i < nx) & (j > 0) & (j < ny)
    i += inside * rng.uniform(-jitter, jitter, i.shape)
    j += inside * rng.uniform(-jitter, jitter, j.shape)
    points = np.column_stack([np.broadcast_to(x, i.shape).ravel() for x in place(i / nx, j / ny)])
    at = lambda i, j: i * (ny + 1) + j
    sides = {"left": [(at(0, j), at(0, j + 1)) for j in range(ny)], "right": [(at(nx, j), at(nx, j + 1)) for j in range(ny)],
             "low": [(at(i, 0), at(i + 1, 0)) for i in range(nx)], "high": [(at(i, ny), at(i + 1, ny)) for i in range(nx)]}
    corners = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(nx) for j in range(ny)]
    triangles = [t for a, b, c, d in corners for t in (((a, b, d), (b, c, d)) if falling else ((a, b, c), (a, c, d)))]
    named = [(name, 1, sides[g]) if isinstance(g, str) else (name, 0, [(at(round(g[0] * nx), round(g[1] * ny)),)])
             for name, g in groups.items()]
    return write_msh(file, points, [*named, ("shell", 2, np.array(triangles))])


def cantilever(p):
    """12 x 1, flat."""
    return (p["nx"], p["ny"]), lambda s, t: (12 * s, t, 0 * s), {"clamp": "left", "tip": "right"}


def hemisphere(p):
    """Of meshes/hemisphere.geo, radius 10: s is the longitude, t the latitude up to the hole."""
    def place(s, t):
        lon, lat = s * math.pi / 2, t * math.radians(72)
        return 10 * np.cos(lat) * np.cos(lon), 10 * np.cos(lat) * np.sin(lon), 10 * np.sin(lat)
    return (p["n"], p["n"]), place, {"sym_y": "left", "sym_x": "right", "equator": "low", "hole": "high", "load_x": (0, 0), "load_y": (1, 0)}


def hypar(p):
    return (p["n"], p["n"] // 2), lambda s, t: (s - 0.5, t / 2, (s - 0.5) ** 2 - t**2 / 4), {"clamp": "left", "middle": "low", "A": (1, 0)}


def cylinder(radius, length):
    """The octant of meshes/cylinder.geo: s goes around from the crown to the flank, t along the axis."""
    def mesh(p):
        place = lambda s, t: (radius * np.sin(s * math.pi / 2), t * length / 2, radius * np.cos(s * math.pi / 2))
        return (p["n_circ"], p["n_axial"]), place, {"crown": "left", "flank": "right", "middle": "low", "end": "high",
                                                    "A": (0, 0), "B": (1, 0), "C": (1, 1)}
    return mesh


def panel(radius, length, half_angle):
    """The quarter of meshes/panel.geo, as the octant of a cylinder."""
    def mesh(p):
        place = lambda s, t: (radius * np.sin(s * half_angle), t * length / 2, radius * np.cos(s * half_angle))
        return (p["n_circ"], p["n_axial"]), place, {"crown": "left", "edge": "right", "middle": "low", "end": "high", "edge_middle": (1, 0)}
    return mesh


def twisted_strip(p):
    """Of meshes/twisted_strip.geo, 12 x 1.1."""
    def place(s, t):
        v, angle = 1.1 * (t - 0.5), math.pi / 2 * s
        return 12 * s, v * np.cos(angle), v * np.sin(angle)
    return (p["nx"], p["ny"]), place, {"clamp": "left", "tip": "right", "tip_centre": (1, 0.5)}
