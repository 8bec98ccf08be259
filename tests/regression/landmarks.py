"""Pieces of garments placed by named points of a body."""

import shutil

import numpy as np
from pattern_files import CLOTH, box_file, frames_file, rectangle, svg, text_file
from harness import OUT, test
from results import Results
from solver import ROOT, invoke, run, write_case

LENGTH, RADIUS, SHIFT = 0.3, 0.2, 0.1
WAY = np.array([0.5, -0.1, 0.2])


def worn(panels, marks, **body):
    """Pieces round a limb, which at the start lies elsewhere than its mesh."""
    limb, points = box_file("landmarks_limb.obj")
    csv = text_file("landmarks_limb.csv", "# of the mesh\ntop,0,0,0.3\n\nlower arm, left, 0.1, 0, -0.3\n")
    limb |= frames_file("landmarks_limb.pc2", [points + WAY] * 2) | {"landmarks": csv} | body
    return {"analysis": "dynamic", "time": {"end": 0.002, "step": 0.002}, "material": [CLOTH], "contact": {"distance": 1e-3}, "obstacle": [limb],
            "landmark": [{"obstacle": "body"} | mark for mark in marks], "panel": panels}


def piece(**keys):
    """Drawn right of the origin and below it."""
    return {"file": svg("landmarks.svg", rectangle("piece", LENGTH, LENGTH)), "name": "sleeve", "size": 0.05, "wrap_radius": RADIUS} | keys


def corners(what, case, report, name="sleeve"):
    """Places of the four corners, in the order of their distance from the origin of the axis."""
    folder = OUT / "landmarks"
    shutil.rmtree(folder, ignore_errors=True)
    result = run(write_case(case, OUT / "landmarks.toml"), folder, 2)
    report.check(result.code == 0, f"{what}: code {result.code}{result.text[-300:] if result.code else ''}")
    step = Results(folder)[0]
    edges = [np.unique(step.mesh.group(f"{name}/{k}")) for k in range(4)]
    return np.array([step.positions[np.intersect1d(edges[k - 1], edges[k])[0]] for k in range(4)])


def check_round(what, x, top, bottom, report):
    """The line of the piece with x = 0 is on the outer side of the axis, straight; its corners are as far along it as they are drawn."""
    axis = (bottom - top) / np.linalg.norm(bottom - top)
    way = (x - top) @ axis
    out = x - top - np.outer(way, axis)
    report.below(np.abs(np.linalg.norm(out, axis=1) - RADIUS).max(), 1e-6, f"{what}: distance of the corners from the axis [m]")
    report.below(np.abs(np.sort(way) - SHIFT - [0, 0, LENGTH, LENGTH]).max(), 1e-6, f"{what}: their way along it [m]")
    lean = np.cross(np.eye(3), np.cross([0, 0, -1], axis)).T  # by the least angle from the vertical
    outside = (np.eye(3) - lean + lean @ lean / (1 - axis[2]))[:, 0]
    straight = out @ outside
    report.below(np.abs(np.sort(straight) - RADIUS * np.sort(np.cos([LENGTH / RADIUS] * 2 + [0, 0]))).max(), 1e-6, f"{what}: the side at the origin faces outwards [m]")


@test
def garment_landmarks(report):
    """Pieces wrapped between points of a body: by file, coordinates, vertices and the nearest one, where the body is at the start; of mirror images too."""
    keys = {"rotate": [0, 0, 90], "wrap_along": "-y", "wrap_shift": SHIFT}
    between = keys | {"origin": "body.top", "wrap_point": "body.top", "wrap_end": "body.end"}
    # Two vertices opposite to each other, and a corner, are where the first frame has them.
    marks = [{"name": "top", "vertices": [5, 7]}, {"name": "end", "near": list(WAY + [0.06, 0.06, -0.28])}]
    left = corners("by vertices", worn([piece(**between)], marks), report)
    check_round("by vertices", left, WAY + [0, 0, 0.3], WAY + [0.05, 0.05, -0.3], report)
    marks = [{"name": "end", "point": [0.1, 0.2, 0.0]}]
    check_round("by file and coordinates", corners("by file", worn([piece(**between)], marks), report), np.array([0, 0, 0.3]), np.array([0.1, 0.2, 0]), report)
    placed = {"scale": 2.0, "translate": [0.1, 0, 0]}
    named = between | {"wrap_end": "body.lower arm, left"}
    check_round("a body in place", corners("a body in place", worn([piece(**named)], [], **placed), report), np.array([0.1, 0, 0.6]), np.array([0.3, 0, -0.6]), report)
    marks = [{"name": "top", "point": [-0.2, 0, 0.3]}, {"name": "end", "point": [-0.5, 0.1, 0]}]
    right = corners("mirrored", worn([piece(**(between | {"mirror": True, "rotate": [0, 0, -90]}))], marks), report)
    marks = [{"name": "top", "point": [0.2, 0, 0.3]}, {"name": "end", "point": [0.5, 0.1, 0]}]
    left = corners("its pair", worn([piece(**between)], marks), report)
    report.below(np.abs(right * [-1, 1, 1] - left).max(), 1e-12, "corners of the mirror image between mirrored points [m]")
    along = between | {"wrap_along": "x", "rotate": [0, 0, 0]}
    marks = [{"name": "top", "point": [-0.2, 0, 0.3]}, {"name": "end", "point": [-0.5, 0.1, 0]}]
    right = corners("along x mirrored", worn([piece(**(along | {"mirror": True, "rotate": [0, 0, 180]}))], marks), report)
    left = corners("along x", worn([piece(**along)], marks), report)
    axis = np.array([-0.3, 0.1, -0.3])
    report.below(np.abs(np.sort(right @ axis) - np.sort(left @ axis)).max(), 1e-9, "x is as it is drawn: way along the axis of the mirror image [m^2]")


@test
def garment_landmark_mistakes(report):
    """Names of points that are not there, or do not help, are named with what would."""
    def says(what, panel, marks, *words, ranks=1, **body):
        code, text = invoke(["check", write_case(worn([piece(**panel)], marks, **body), OUT / "landmarks_wrong.toml")], ranks)
        text = " ".join(text.split())
        missing = [w for w in words if w not in text]
        report.check(code == 2 and not missing, f"{what}: code {code}{f', without {missing}: {text[:300]}' if missing else ''}")

    ends = {"wrap_point": "body.top", "wrap_end": "body.lower arm, left"}
    says("a name that is not there", ends | {"wrap_end": "body.tpo"}, [], "[[panel]] 'sleeve' wrap_end", "no landmark 'tpo'", "did you mean 'top'?", ranks=2)
    says("a body that is not there", ends | {"origin": "boddy.top"}, [], "[[panel]] 'sleeve' origin", "no [[obstacle]] 'boddy'", "did you mean 'body'?")
    says("both ends in one point", ends | {"wrap_end": "body.end"}, [{"name": "end", "point": [0, 0, 0.3]}], "wrap_end", "it is where wrap_point is")
    says("a vertex too many", ends | {"wrap_end": "body.end"}, [{"name": "end", "vertices": [1, 9]}], "[[landmark]] 'end' vertices: 9", "has 8, counted from 1")
    says("half a vertex", ends, [{"name": "end", "vertices": [1.5]}], "landmark.vertices", "whole number")
    says("two places of a point", ends, [{"name": "end", "vertices": [1], "point": [0, 0, 0]}], "one of point, near and vertices")
    says("a name twice", ends, [{"name": "end", "point": [0, 0, 0]}] * 2, "landmark.name", "another landmark of this name")
    says("a piece against the axis", ends | {"origin": "body.top", "wrap_end": "body.end", "wrap_along": "y"}, [{"name": "end", "point": [0, 0, 0]}], "wrap_along", "180 degrees", "rotate")
    says("a cylinder without an axis", {"wrap_shift": 0.1, "wrap_radius": 0.1}, [], "panel.wrap_axis", "wrap_shift is about an axis")
    for line, words in (("top,0,0", "NAME,X,Y,Z"), ("top,0,0,nan", "NAME,X,Y,Z"), ("top,0,0,1\ntop,0,0,2", "'top' is there twice")):
        says("a file of points that is wrong", ends, [], "landmarks_wrong.csv:", words, landmarks=text_file("landmarks_wrong.csv", line + "\n"))
    says("a file of points that is not there", ends, [], "landmarks_none.csv", "cannot be opened", landmarks=str(OUT / "landmarks_none.csv"))
