"""Pictures of triangulated surfaces with matplotlib: perspective, one lamp, flat shading, triangles drawn from far to near."""

import numpy as np
from matplotlib import cm, colors
from matplotlib.collections import LineCollection, PolyCollection

MOST_WITH_EDGES = 20_000  # edges of larger meshes are not drawn
MOST_TRIANGLES = 150_000  # larger meshes are coarsened
SHEET = colors.LinearSegmentedColormap.from_list("sheet", ["#e4ebef", "#9cc5cf", "#4d97bf", "#4f62a8", "#8a3f8c"])

GREY = np.array([0.72, 0.72, 0.72, 1.0])


def boundary_edges(triangles):
    """Vertex pairs of the edges that belong to one triangle only."""
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return unique[count == 1]


def normals_and_areas(corners):
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(length, 1e-300)[:, None], 0.5 * length


def coarsen(points, triangles, values, most=MOST_TRIANGLES):
    """A mesh of fewer triangles for a picture, by merging the vertices in cubes: sheets nearer to each other than a cube
    melt together."""
    cube = np.sqrt(normals_and_areas(points[triangles])[1].sum() / most)
    while True:
        cells = np.floor((points - points.min(axis=0)) / cube).astype(np.int64)
        _, merged = np.unique(cells, axis=0, return_inverse=True)
        merged = merged.ravel()
        count = np.bincount(merged)
        means = [np.bincount(merged, column) / count for column in (*points.T, values)]
        corners = merged[triangles]
        distinct = (np.diff(np.sort(corners, axis=1), axis=1) > 0).all(axis=1)
        _, first = np.unique(np.sort(corners[distinct], axis=1), axis=0, return_index=True)
        kept = corners[distinct][first]
        if len(kept) <= most:
            return np.column_stack(means[:3]), kept, means[3]
        cube *= 1.2


def split(corners, longest):
    """Triangles (n x 3 x 3) cut into four until no edge is longer than this: near and far parts of large ones then sort."""
    done = []
    while len(corners):
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        large = edges.max(axis=1) > longest
        done.append(corners[~large])
        a, b, c = corners[large].transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corners = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return np.concatenate(done)


class Camera:
    """Perspective view from a direction given by angles in degrees, aimed at the middle of some points."""

    def __init__(self, points, elevation, azimuth):
        e, a = np.radians(elevation), np.radians(azimuth)
        self.back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])  # towards the viewer
        self.right = np.array([-np.sin(a), np.cos(a), 0.0])
        self.up = np.cross(self.back, self.right)
        low, high = points.min(axis=0), points.max(axis=0)
        self.target = 0.5 * (low + high)
        self.distance = 3.2 * np.linalg.norm(high - low)

    def project(self, points):
        """Plane coordinates (..., 2) and nearness to the viewer (...)."""
        x = points - self.target
        near = x @ self.back
        scale = self.distance / (self.distance - near)
        return np.stack([x @ self.right * scale, x @ self.up * scale], axis=-1), near

    def lamp(self):
        direction = 0.75 * self.back + 0.55 * self.up + 0.45 * self.right
        return direction / np.linalg.norm(direction)


def _triad(figure, camera):
    """Small arrows along x, y, z in the lower right corner."""
    inset = figure.add_axes([0.85, 0.02, 0.13, 0.15])
    inset.set_axis_off()
    inset.set_aspect("equal")
    for name, direction in zip("xyz", np.eye(3)):
        tip = np.array([direction @ camera.right, direction @ camera.up])
        inset.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "-|>", "color": "#555555", "lw": 1.0, "shrinkA": 0,
                                                    "shrinkB": 0, "mutation_scale": 8})
        inset.text(*(1.28 * tip), name, ha="center", va="center", fontsize=9, color="#555555")
    inset.set(xlim=(-1.4, 1.4), ylim=(-1.4, 1.4))


def draw_surface(axes, points, triangles, values, outline, view, others=()):
    """Draws a surface coloured by `values` at its vertices, and `others` (triangles, n x 3 x 3) in grey. `outline`: line
    segments (n x 2 x 3) of the shape at rest; `view`: elevation and azimuth of the camera in degrees. Returns what a colour
    bar needs, or None if all values are zero."""
    if len(triangles) > MOST_TRIANGLES:
        points, triangles, values = coarsen(points, triangles, values)
    everything = np.vstack([points, np.reshape(outline, (-1, 3)), np.reshape(others, (-1, 3))])
    camera = Camera(everything, *view)
    corners = points[triangles]
    if len(others):
        corners = np.concatenate([corners, split(others, np.linalg.norm(np.ptp(everything, axis=0)) / 60)])
    normals, _ = normals_and_areas(corners)
    high = float(values.max(initial=0.0))
    norm = colors.Normalize(0.0, high if high > 0 else 1.0)
    face = np.tile(GREY, (len(corners), 1))
    face[: len(triangles)] = SHEET(norm(values[triangles].mean(axis=1)))
    face[:, :3] *= (0.58 + 0.42 * np.abs(normals @ camera.lamp()))[:, None]  # a thin shell is lit on both sides
    edge = face.copy()
    if len(triangles) <= MOST_WITH_EDGES:
        edge[: len(triangles), :3] = 0.75 * face[: len(triangles), :3] + 0.25
    flat, near = camera.project(corners)
    order = np.argsort(near.mean(axis=1))

    if len(outline):
        axes.add_collection(LineCollection(camera.project(np.asarray(outline))[0], colors="#bbbbbb", linewidths=1.0, zorder=0))
    axes.add_collection(PolyCollection(flat[order], facecolors=face[order], edgecolors=edge[order],
                                       linewidths=0.5 if len(triangles) < 2000 else 0.3))
    seen, _ = camera.project(everything)
    low, top = seen.min(axis=0), seen.max(axis=0)
    margin = 0.03 * (top - low).max()
    axes.set(xlim=(low[0] - margin, top[0] + margin), ylim=(low[1] - margin, top[1] + margin))
    axes.set_aspect("equal")
    axes.set_axis_off()
    width, height = top - low + 2 * margin
    inches = min(5.4, 7.4 * height / width)
    axes.figure.set_size_inches(max(inches * width / height, 2.5) + 1.6, max(inches, 2.6) + 0.4)
    _triad(axes.figure, camera)
    return cm.ScalarMappable(norm, SHEET) if high > 0 else None
