"""Pattern files and cases that several groups of tests of garments share."""

import struct

import numpy as np
from harness import OUT
from solver import Result

RADIUS, HEIGHT = 0.1, 0.15
CLOTH = {"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 1e-3, "density": 300.0}


def text_file(name, text):
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / name).write_text(text)
    return str(OUT / name)


def svg(name, *shapes):
    """Millimetres."""
    return text_file(name, '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="2000mm" viewBox="0 0 2000 2000">' + "".join(shapes) + "</svg>\n")


def rectangle(name, width, height):
    return f'<rect id="{name}" width="{1000 * width:.12g}" height="{1000 * height:.12g}"/>'


def tube(**changes):
    """One sheet round a cylinder whose girth is 5 % more than its width, sewn to itself, then let go of all strain."""
    file = svg("garment_tube.svg", rectangle("tube", 2 * np.pi * RADIUS, HEIGHT))
    return {"panel": [{"file": file, "size": 0.015, "wrap_axis": [0, 0, 1], "translate": [-np.pi * RADIUS, -1.05 * RADIUS, 0]}],
            "seam": [{"name": "side", "edges": ["tube/1"], "to": ["tube/3"], "meet": ["tube@1", "tube@0"]}],
            "material": [CLOTH],
            "spring": [{"type": "point", "group": "tube/0", "stiffness": 1e-4}],
            "contact": {"distance": 1e-3},
            "probe": [{"name": "energy", "type": "energy"}],
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.3, "step": 0.01}, "damping": {"mass": 20.0}},
                      {"name": "rest", "analysis": "drape"}]} | changes


def part(result, stage):
    return Result(result.folder / stage, result.code, result.text, 0.0)


def box_file(name, flip=False, whole=True):
    """A limb of twelve triangles, or of ten with two holes."""
    points = [(x, y, z) for z in (-0.3, 0.3) for x, y in ((-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05))]
    faces = [(1, 3, 2), (5, 6, 7), (1, 4, 3), (5, 7, 8), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 4, 8), (3, 8, 7), (4, 1, 5), (4, 5, 8)][0 if whole else 2:]
    lines = ["v {} {} {}".format(*p) for p in points] + ["f {} {} {}".format(*(f[::-1] if flip else f)) for f in faces]
    return {"name": "body", "type": "mesh", "file": text_file(name, "\n".join(lines) + "\n")}, np.array(points)


def frames_file(name, frames):
    (OUT / name).write_bytes(b"POINTCACHE2\0" + struct.pack("<iiffi", 1, len(frames[0]), 0.0, 1.0, len(frames)) + np.array(frames, "<f4").tobytes())
    return {"frames": str(OUT / name), "frames_per_second": 25}
