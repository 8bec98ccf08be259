"""What the drape scripts share: runs in fresh folders, deformed surfaces and figures measured on them."""

import shutil

import numpy as np

from solver import Result, run, to_toml, write_case

PATTERNS = {"one_way": 0, "union_jack": 1, "unstructured": 2}


def solve(case, folder, ranks=1, options=(), timeout=3600, keep=False):
    """Runs a case (dictionaries) in an emptied folder; None, and a line on the screen, if it fails. With `keep`, a run of
    the same case that is there already is taken instead."""
    file = folder.parent / f"{folder.name}.toml"
    if keep and file.is_file() and file.read_text() == to_toml(case) and (folder / "summary.json").is_file():
        result = Result(folder, 0, "", 0.0)
        if result.summary["converged"]:
            return result
    shutil.rmtree(folder, ignore_errors=True)
    result = run(write_case(case, file), folder, ranks, options, timeout)
    if result.code == 0:
        return result
    last = result.text.strip().splitlines()[-1:] or [""]
    print(f"  {folder.name} ended with code {result.code}: {last[0]}", flush=True)
    return None


def start_file(case, displacement, folder):
    """Results for --restart whose step has a displacement of one's own, a function of the rest positions (vertices x 3).
    None if the mesh cannot be made."""
    still = [{key: value for key, value in s.items() if not key.startswith("rotation")} for s in case["support"]]
    flat = solve({**case, "analysis": "linear", "support": still}, folder)
    if flat is None:
        return None
    results = flat.results
    results.replace(len(results) - 1, "displacement", displacement(results[-1].mesh.positions))
    return results.file


def rotated(stiffness, degrees):
    """Stiffness (order 11, 22, 12, engineering shear) in axes from which material axis 1 lies at an angle."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    strain = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    return strain.T @ stiffness @ strain


class Surface:
    """Mesh at rest and displaced, with the fields of one recorded step (the last by default)."""

    def __init__(self, result, step=-1):
        at = result.results[step]
        self.rest, self.triangles = at.mesh.positions, at.mesh.triangles
        self.groups = {name: at.mesh.group(name) for name, _ in at.mesh.groups}
        self.fields = {name: at[name] for name in at.names()}
        self.points = self.rest + self.fields["displacement"]

    def centroids(self):
        return self.rest[self.triangles].mean(axis=1)

    def curvature_along(self, direction, degrees):
        """Normal curvature of every triangle along a direction in the plane at rest; the field is in material axes, whose
        first lies at an angle to x."""
        a = np.radians(degrees)
        one, two = np.dot(direction, [np.cos(a), np.sin(a)]), np.dot(direction, [-np.sin(a), np.cos(a)])
        k = self.fields["curvature"]
        return k[:, 0] * one**2 + k[:, 1] * two**2 + k[:, 2] * one * two

    def inner_edges(self):
        """Vertex pairs of the edges with two triangles, and the angles in degrees between the normals there."""
        corners = self.points[self.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        edges = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        owner = np.repeat(np.arange(len(self.triangles)), 3)
        order = np.lexsort(edges.T)
        edges, owner = edges[order], owner[order]
        pairs = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
        cosine = (normals[owner[pairs]] * normals[owner[pairs + 1]]).sum(axis=1)
        return edges[pairs], np.degrees(np.arccos(np.clip(cosine, -1, 1)))


class FlatInterpolation:
    """Barycentric coordinates of places in a flat mesh: `self @ field` are the values of a field of its vertices there; nan outside."""

    def __init__(self, positions, triangles, places, slack=1e-9):
        corners = positions[triangles]
        low, high = corners.min(axis=1), corners.max(axis=1)
        size, origin = np.median(high - low) + 1e-300, low.min(axis=0)
        # The triangles over each cell of a grid.
        first, last = ((x - origin) // size for x in (low, high))
        cells = {}
        for t, (a, b) in enumerate(zip(first.astype(int), last.astype(int))):
            for i in range(a[0], b[0] + 1):
                for j in range(a[1], b[1] + 1):
                    cells.setdefault((i, j), []).append(t)
        self.vertices, self.weights = np.zeros((len(places), 3), int), np.full((len(places), 3), np.nan)
        for k, (place, cell) in enumerate(zip(places, ((places - origin) // size).astype(int))):
            near = np.array(cells.get(tuple(cell), []), int)
            if len(near) == 0:
                continue
            a, b, c = corners[near].transpose(1, 0, 2)
            weights = np.linalg.solve(np.stack([b - a, c - a], axis=-1), (place - a)[..., None])[..., 0]
            weights = np.column_stack([1 - weights.sum(axis=1), weights])
            best = np.argmax(weights.min(axis=1))
            if weights[best].min() >= -slack:
                self.vertices[k], self.weights[k] = triangles[near[best]], weights[best]

    def __matmul__(self, field):
        return np.einsum("ki,ki...->k...", self.weights, field[self.vertices])


def outline(surface, vertices, at_rest=False):
    """Displaced positions of vertices on a closed curve, or those at rest, in order around its centre at rest."""
    place = surface.rest[vertices, :2] - surface.rest[vertices, :2].mean(axis=0)
    return (surface.rest if at_rest else surface.points)[vertices[np.argsort(np.arctan2(place[:, 1], place[:, 0]))]]


def shadow_area(surface, pixel=2.5e-4):
    """Area in plan view, folds under each other counted once: by pixels."""
    plan = surface.points[:, :2]
    low = plan.min(axis=0) - pixel
    lit = np.zeros(np.ceil((plan.max(axis=0) - low) / pixel).astype(int) + 1, dtype=bool)
    for a, b, c in (plan[surface.triangles] - low) / pixel:
        first = np.floor(np.min([a, b, c], axis=0)).astype(int)
        last = np.ceil(np.max([a, b, c], axis=0)).astype(int) + 1
        x, y = np.meshgrid(np.arange(first[0], last[0]), np.arange(first[1], last[1]), indexing="ij")
        side = [(q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) for p, q in ((a, b), (b, c), (c, a))]
        inside = ((side[0] >= 0) & (side[1] >= 0) & (side[2] >= 0)) | ((side[0] <= 0) & (side[1] <= 0) & (side[2] <= 0))
        lit[first[0] : last[0], first[1] : last[1]] |= inside
    return lit.sum() * pixel**2


def prominent_maxima(values, height):
    """Number of maxima of a periodic sequence that stand out by a height from the minima on both sides."""
    values = np.roll(values, -int(np.argmin(values)))
    values = np.append(values, values[0])
    count, rising, extreme = 0, True, values[0]
    for v in values:
        if rising:
            extreme = max(extreme, v)
            if v < extreme - height:
                count, rising, extreme = count + 1, False, v
        else:
            extreme = min(extreme, v)
            if v > extreme + height:
                rising, extreme = True, v
    return count
