"""Regression tests of remeshing while seams are open."""

import json

import numpy as np
from common import fresh
from harness import OUT, solve, test
from pattern_files import CLOTH, part, rectangle, svg
from results import Results
from solver import invoke, run

RADIUS, WIDTH, HEIGHT = 0.1, 0.33, 0.16


def sleeve():
    """Two flat panels, one on either side of a limb, sewn to each other along both sides; they fit closely. The same steps on any number of ranks."""
    file = svg("sewn_sleeve.svg", rectangle("front", WIDTH, HEIGHT), rectangle("back", WIDTH, HEIGHT))
    steps = {"step": 0.01, "max_step": 0.01, "target_iterations": 1000, "velocity_tolerance": 1e-8}
    panel = {"file": file, "size": 0.03}
    return {"panel": [panel | {"pieces": ["front"], "translate": [-WIDTH / 2, -1.2 * RADIUS, 0]},
                      panel | {"pieces": ["back"], "rotate": [0, 0, 180], "translate": [WIDTH / 2, 1.2 * RADIUS, 0]}],
            "seam": [{"name": "right", "edges": ["front/1"], "to": ["back/3"], "meet": ["front@1", "back@0"]},
                     {"name": "left", "edges": ["front/3"], "to": ["back/1"], "meet": ["front@0", "back@1"]}],
            "sewing": {"speed": 0.8, "allowance": 0.01, "bending": 0.5},
            "mark": [{"name": "button", "panel": "front", "at": [0.1, -0.05]}],
            "material": [CLOTH], "contact": {"distance": 1e-3},
            "obstacle": [{"name": "limb", "type": "capsule", "point": [0, 0, -0.6], "end": [0, 0, 0.4], "radius": RADIUS}],
            "remesh": {"smallest": 0.012, "largest": 0.04, "angle": 8},
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.42} | steps, "damping": {"mass": 20.0}},
                      {"name": "move", "analysis": "dynamic", "time": {"end": 0.45} | steps, "damping": {"mass": 20.0}}]}


def same_meshes(a, b):
    """At each recorded step; bit by bit, but for the positions of a welded mesh, which are those of a moment."""
    first = {s.number: s.mesh for s in Results(a)}
    return all(np.array_equal(first[s.number].triangles, s.mesh.triangles) and np.abs(first[s.number].positions - s.mesh.positions).max() <= (1e-9 if a.name == "move" else 0.0)
               for s in Results(b))


@test
def remesh_sewing(report):
    """Panels are remeshed while their seams are pulled together: both sides stay node by node, the seams close, the same on 1 and 3 ranks and after a restart amid it on 2."""
    case, whole = sleeve(), None
    for ranks in (1, 3):
        result = solve(f"remesh_sewing_{ranks}", case, ranks)
        whole, what = whole or result, f"{ranks} rank(s)"
        sew, move = part(result, "sew"), part(result, "move")
        report.check(sew.summary["remeshing"]["count"] >= 3 and sew.summary["remeshing"]["refused"] == 0, f"{what}: {sew.summary['remeshing']['count']} remeshings while seams are open, none refused")
        report.below(sew.history["seam_gap"][-1], 1e-4, f"{what}: and they close, {sew.history['seam_gap'][0]:.3f} m apart at first, to [m]")
        report.check(max(sew.history["contact_pairs"]) > 0 and max(sew.history["intersections"]) + max(move.history["intersections"]) == 0, f"{what}: nothing intersects")
        before, after = Results(result.folder / "sew"), Results(result.folder / "move")
        first, last = before[0].mesh, before[-1].mesh
        gained = len(last.group("seam left")) - len(first.group("seam left"))
        report.check(gained > 0 and len(last.positions) - len(after[0].mesh.positions) == (len(last.group("seam left")) + len(last.group("seam right"))) // 2,
                     f"{what}: a seam has got {gained} nodes, and is welded node by node")
        report.check(len(last.group("button")) == 1, f"{what}: the mark is a point still")
        report.check(all(same_meshes(whole.folder / s, result.folder / s) for s in ("sew", "move")), f"{what}: the same meshes as on one")
    file = OUT / "remesh_sewing_1.toml"
    short = run(file, fresh("remesh_sewing_short"), 1, ["-ts_max_steps", "33"])
    checkpoint = OUT / "remesh_sewing_short" / "sew" / "checkpoint.h5"
    changes = json.loads((checkpoint.parent / "summary.json").read_text())["remeshing"]["count"]
    again = run(file, fresh("remesh_sewing_again"), 2, ["--from", "sew", "--restart", checkpoint])
    report.check(changes > 0 and again.code == 0, f"from step 33, after {changes} remeshings, on 2 ranks: codes {short.code}, {again.code}")
    report.check(all(same_meshes(whole.folder / s, again.folder / s) for s in ("sew", "move")), "the meshes of the unbroken run")
    report.below(np.abs(part(again, "move").displacement() - part(whole, "move").displacement()).max(), 1e-6, "and its end [m]")
    code, text = invoke(["export", whole.folder, "--stage", "sew", "--to", "pc2", "--output", OUT / "remesh_sewing.pc2"])
    report.check(code == 0 and "nothing intersects" in text, f"on one mesh for all frames nothing intersects: code {code}, {text.splitlines()[-1][:150]}")
    code, text = invoke(["check", file])
    report.check(code == 0 and "remeshing: edges of 0.012 to 0.04 m" in text, f"check tells what it would do: code {code}")
