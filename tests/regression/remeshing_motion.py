"""Regression tests of remeshing in motions with contact: friction that holds, and what a sheet comes near."""

import math

from harness import solve, test
from solver import ROOT
from staging import end_of, stage

ANGLE, FRICTION, SLIP_SPEED, STEP, STAGES = math.radians(15), 0.4, 1e-3, 2e-3, 16


def on_slope(name, sizes, ranks):
    """A limp sheet that lies on a plane, gravity turned by 15 degrees: a stage in which it comes to rest, then one after the
    other with wanted sizes of their own, of two steps each. Returns how far its middle and its corner slip."""
    def motion(k, size):
        return stage(f"part_{k}", "dynamic", time={"end": 0.1 + 2 * k * STEP, "step": STEP, "velocity_tolerance": 1e-6},
                     **({"remesh": {"size": size, "smallest": 0.01, "largest": 0.04, "every": 1}} if size else {}))

    case = {"title": "A sheet on a slope", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.2, "n": 8, "pattern": 2}},
            "material": [{"type": "isotropic", "young": 2e6, "poisson": 0.3, "thickness": 0.4e-3, "density": 400}],
            "load": [{"type": "gravity", "vector": [9.81 * math.sin(ANGLE), 0, -9.81 * math.cos(ANGLE)]}],
            "contact": {"distance": 1e-3, "stiffness": 1e4, "slip_speed": SLIP_SPEED},
            "obstacle": [{"name": "slope", "type": "plane", "normal": [0, 0, 1], "friction": FRICTION, "point": [0, 0, -0.9e-3]}],
            "damping": {"mass": 5.0}, "output": {"fields": ["displacement"], "every": 1000},
            "probe": [{"name": "middle", "type": "displacement", "point": [0.1, 0.1, 0]}, {"name": "corner", "type": "displacement", "point": [0, 0, 0]}],
            "stage": [motion(k, size) for k, size in enumerate([None, *sizes])]}
    result = solve(name, case, ranks)
    last, first = end_of(result, f"part_{len(sizes)}"), end_of(result, "part_1")
    changes = [end_of(result, f"part_{k}").summary["remeshing"]["count"] for k in range(1, len(sizes) + 1) if sizes[k - 1]]
    return [last.history[p][-1] - first.history[p][0] for p in ("middle_x", "corner_x")], changes, result


@test
def remesh_on_slope(report):
    """Friction that holds a sheet below the angle at which it would slide goes on holding it through a remeshing in every other step: it slips as on one mesh."""
    time = 2 * STAGES * STEP
    share = 1 - math.sqrt(1 - math.tan(ANGLE) / FRICTION)  # of the slip speed at which smoothed friction bears the weight
    still, _, _ = on_slope("remesh_slope_still", [None] * STAGES, 1)
    report.percent(still[0] / (share * SLIP_SPEED * time), 0.05, f"on one mesh it slips by {still[0]:.3g} m")
    for ranks in (1, 2):
        slips, changes, result = on_slope(f"remesh_slope_{ranks}", ["0.014", "0.03"] * (STAGES // 2), ranks)
        report.check(changes == [1] * STAGES and "refused" not in result.text.replace("0 refused", ""), f"{ranks} rank(s): {sum(changes)} remeshings in {2 * STAGES} steps")
        for slip, plain, what in zip(slips, still, ("middle", "corner")):
            report.percent(slip / plain, 1e-4, f"{ranks} rank(s): slip of the {what}, {slip:.3g} m, against one mesh")
