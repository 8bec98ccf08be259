"""Pictures of a scene at some recorded steps side by side, drawn by voile."""

import math

import drawing
import numpy as np

SLOPE = 0.28  # of the left and right side of the picture, as voile render has it, less a margin


def eye_of(box, view, size):
    """Where the camera is and what it looks at, for a box (low, high) seen at (elevation, azimuth) in degrees, which fills the picture."""
    low, high = (np.array(x, float) for x in box)
    elevation, azimuth = (math.radians(a) for a in view)
    back = np.array([math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)])
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    middle = 0.5 * (low + high)
    corners = np.array([[(low, high)[k >> i & 1][i] for i in range(3)] for k in range(8)]) - middle
    width, height, depth = (np.abs(corners @ axis).max() for axis in (right, np.cross(back, right), back))
    return middle + (max(width, height * size[0] / size[1]) / SLOPE + depth) * back, middle


def draw(folder, steps, file, view=(25, -60), limits=None, columns=3, size=(360, 300), bodies=True):
    """`steps`: (number, positions of the sheet). `limits`: box to show, or one for each step; by default where the sheets are at all
    of these steps. `bodies`: whether obstacles are drawn."""
    boxes = limits if isinstance(limits, list) else [limits] * len(steps)
    if limits is None:
        everything = np.vstack([x for _, x in steps])
        boxes = [(everything.min(axis=0), everything.max(axis=0))] * len(steps)
    with drawing.Sheet(file, min(columns, len(steps))) as sheet:
        for (number, _), box in zip(steps, boxes):
            eye, middle = (",".join(f"{c:.6g}" for c in x) for x in eye_of(box, view, size))
            drawing.draw("render", folder, "--steps", number, "--eye", eye, "--target", middle, "--size", f"{size[0]}x{size[1]}", "--panels", "--output",
                         sheet.place(), "--quiet", *([] if bodies else ["--no-obstacles"]))
    print(f"wrote {file}")
