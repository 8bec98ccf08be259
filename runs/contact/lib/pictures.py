"""Pictures of a scene: sheets in colours and obstacles in grey at some recorded times, side by side."""

import math
import tomllib

import matplotlib.pyplot as plt
import numpy as np

from render import Camera, normals_and_areas
from style import save

SHEETS = np.array([[0.42, 0.68, 0.80], [0.89, 0.60, 0.44], [0.55, 0.74, 0.51], [0.74, 0.60, 0.78], [0.88, 0.80, 0.46]])
GREY, FLOOR = np.array([0.72, 0.72, 0.72]), np.array([0.90, 0.90, 0.88])


def read_case(path):
    with open(path, "rb") as file:
        return tomllib.load(file)


def value(text, t):
    """An expression of the case file at time t."""
    def table(x, *pairs):
        return float(np.interp(x, pairs[0::2], pairs[1::2]))

    names = {"sin": math.sin, "cos": math.cos, "pi": math.pi, "table": table, "t": t, "__builtins__": {}}
    return float(eval(text.replace("^", "**"), names))  # the text is that of a case file of this repository


def moved(points, entry, t):
    points = np.asarray(points, float)
    result = points.copy()
    if "rotation_angle" in entry:
        axis = np.array(entry["rotation_axis"], float)
        axis /= np.linalg.norm(axis)
        x = points - np.array(entry.get("rotation_centre", [0, 0, 0]), float)
        a = math.radians(value(entry["rotation_angle"], t))
        result += (x * math.cos(a) + np.cross(axis, x) * math.sin(a) + np.outer(x @ axis, axis) * (1 - math.cos(a))) - x
    if "motion" in entry:
        result += [value(text, t) for text in entry["motion"]]
    return result


def capsule(a, b, radius, rings=9, around=20):
    """Points and triangles; a sphere if a = b. Its axis, or that of the poles, goes through a and b."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    axis = (b - a) / np.linalg.norm(b - a) if np.linalg.norm(b - a) > 0 else np.array([0.0, 0.0, 1.0])
    side = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.7 else [0, 1.0, 0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    points = []
    for centre, angles in ((a, np.linspace(-math.pi / 2, 0, rings)), (b, np.linspace(0, math.pi / 2, rings))):
        for e in angles:
            for k in range(around):
                f = 2 * math.pi * k / around
                points.append(centre + radius * (math.sin(e) * axis + math.cos(e) * (math.cos(f) * side + math.sin(f) * other)))
    triangles = []
    for r in range(2 * rings - 1):
        for k in range(around):
            p, q = r * around + k, r * around + (k + 1) % around
            triangles += [(p, q, q + around), (p, q + around, p + around)]
    return np.array(points), np.array(triangles)


def obj(path):
    rows = [line.split() for line in open(path)]
    return (np.array([row[1:] for row in rows if row and row[0] == "v"], float),
            np.array([[int(i.split("/")[0]) - 1 for i in row[1:]] for row in rows if row and row[0] == "f"]))


def obstacles(case, t, floor):
    """(name, corners, colour) of every obstacle at a time; planes as a rectangle `floor` = (low, high) in x, y."""
    for o in case.get("obstacle", []):
        colour = GREY
        if o["type"] == "mesh":
            points, triangles = obj(o["file"])
        elif o["type"] == "plane":
            if floor is None:
                continue
            z, colour = o["point"][2], FLOOR
            points = np.array([[x, y, z] for x in (floor[0][0], floor[1][0]) for y in (floor[0][1], floor[1][1])])
            triangles = np.array([(0, 2, 3), (0, 3, 1)])
        else:
            points, triangles = capsule(o["point"], o.get("end", o["point"]), o["radius"])
        yield o["name"], moved(points, o, t)[triangles], colour


def pieces(vertex_count, triangles):
    """Number of the connected piece of each triangle."""
    label = np.arange(vertex_count)
    while True:
        low = label[triangles].min(axis=1)
        new = label.copy()
        np.minimum.at(new, triangles.ravel(), np.repeat(low, 3))
        new = new[new]
        if (new == label).all():
            break
        label = new
    return np.unique(label[triangles[:, 0]], return_inverse=True)[1].ravel()


def paint(camera, corners, colours, low, high, pixels):
    """Image of triangles in the window from low to high of the camera's plane; at each pixel the nearest triangle shows."""
    flat, near = camera.project(corners)
    depth = 1.0 / (camera.distance - near)  # linear over the picture of a plane
    height = max(2, int(pixels * (high[1] - low[1]) / (high[0] - low[0])))
    scale = pixels / (high[0] - low[0])
    image, front = np.ones((height, pixels, 3)), np.zeros((height, pixels))
    place = (flat - low) * scale - 0.5
    for (a, b, c), d, colour in zip(place, depth, colours):
        (x0, y0), (x1, y1) = np.floor(np.min([a, b, c], axis=0)).astype(int), np.ceil(np.max([a, b, c], axis=0)).astype(int)
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, pixels - 1), min(y1, height - 1)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if x1 < x0 or y1 < y0 or abs(area) < 1e-12:
            continue
        x, y = np.meshgrid(np.arange(x0, x1 + 1), np.arange(y0, y1 + 1))
        u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
        v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
        w = 1.0 - u - v
        here = u * d[0] + v * d[1] + w * d[2]
        window = front[y0 : y1 + 1, x0 : x1 + 1]
        seen = (u >= -1e-9) & (v >= -1e-9) & (w >= -1e-9) & (here > window)
        window[seen] = here[seen]
        image[y0 : y1 + 1, x0 : x1 + 1][seen] = colour
    return image


def fill(axes, case, surface, t, view, limits, floor, cut, pixels):
    corners = surface.points[surface.triangles]
    camera = Camera(np.array(limits, float), *view)
    parts = [(corners, SHEETS[pieces(len(surface.points), surface.triangles) % len(SHEETS)])]
    for name, c, colour in obstacles(case, t, floor):
        if name in cut:
            c = c[(c.mean(axis=1) - c.mean(axis=(0, 1))) @ camera.back < 0]
        parts.append((c, np.tile(colour, (len(c), 1))))
    corners, colours = np.vstack([p[0] for p in parts]), np.vstack([p[1] for p in parts])
    normals, _ = normals_and_areas(corners)
    face = np.clip(colours * (0.45 + 0.55 * np.abs(normals @ camera.lamp()))[:, None], 0, 1)
    low, high = limits
    seen, _ = camera.project(np.array([[(low, high)[k >> 2 & 1][0], (low, high)[k >> 1 & 1][1], (low, high)[k & 1][2]]
                                       for k in range(8)], float))
    low, high = seen.min(axis=0), seen.max(axis=0)
    image = paint(camera, corners, face, low, high, 2 * pixels)
    axes.imshow(image, origin="lower", extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased")
    axes.set_title(f"t = {t:.3g} s", pad=3)
    axes.set_axis_off()


def draw(case, frames, file, view=(25, -60), limits=None, floor=None, cut=(), columns=3, size=(3.6, 3.0), dpi=100):
    """`frames`: (time, surface) pairs. `limits`: box to show, or one for each frame (None: where the sheets are then); by
    default where they are at all of these times. `cut`: obstacles whose half towards the viewer is left out."""
    boxes = limits if isinstance(limits, list) else [limits] * len(frames)
    if limits is None:
        everything = np.vstack([s.points for _, s in frames])
        boxes = [(everything.min(axis=0), everything.max(axis=0))] * len(frames)
    columns = min(columns, len(frames))
    rows = math.ceil(len(frames) / columns)
    figure, places = plt.subplots(rows, columns, figsize=(size[0] * columns, size[1] * rows), layout="constrained", squeeze=False)
    for axes, (t, surface), box in zip(places.ravel(), frames, boxes):
        box = (surface.points.min(axis=0), surface.points.max(axis=0)) if box is None else box
        fill(axes, case, surface, t, view, box, floor, cut, int(size[0] * dpi))
    save(figure, file, dpi=dpi)
