"""Failure indices of plies against lamination theory, and a published laminate."""

import math

import numpy as np
from common import strip
from harness import OUT, solve, test
from solver import load_case, run, variant, write_case

# Graphite/epoxy of Kaw, Mechanics of Composite Materials, 2nd ed. (2006), table 2.1.
PLY = {"young_1": 181e9, "young_2": 10.3e9, "poisson_12": 0.28, "shear_12": 7.17e9}
STRENGTHS = {"tensile_strength_1": 1500e6, "compressive_strength_1": 1500e6, "tensile_strength_2": 40e6,
             "compressive_strength_2": 246e6, "shear_strength": 68e6}


def stiffness(angle):
    e1, e2, n, g = PLY.values()
    d = 1 - n * n * e2 / e1
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])  # strains
    q = np.array([[e1 / d, n * e2 / d, 0], [n * e2 / d, e2 / d, 0], [0, 0, g]])
    return turn.T @ q @ turn, q, turn


def indices(criterion, s):
    x, xc, y, yc, t = STRENGTHS.values()
    if criterion == "tsai_wu":
        a = s[0]**2 / (x * xc) + s[1]**2 / (y * yc) + s[2]**2 / t**2 - s[0] * s[1] / math.sqrt(x * xc * y * yc)
        b = s[0] * (1 / x - 1 / xc) + s[1] * (1 / y - 1 / yc)
        return (b + math.sqrt(b * b + 4 * a)) / 2
    if criterion == "maximum_strain":
        s = (s[0] - PLY["poisson_12"] * s[1], s[1] - PLY["poisson_12"] * PLY["young_2"] / PLY["young_1"] * s[0], s[2])
    along, across, shear = s[0] / (x if s[0] > 0 else -xc), s[1] / (y if s[1] > 0 else -yc), abs(s[2]) / t
    if criterion == "hashin":
        return max(math.hypot(along, shear if s[0] > 0 else 0), math.hypot(across, shear))
    return max(along, across, shear)


def by_theory(criterion, angles, thickness, force=(0, 0, 0), moment=(0, 0, 0)):
    """Largest index and the plies that have it under N [N/m] and M [N] (M = D k, strain e - z k)."""
    angles = [math.radians(a) for a in angles]
    heights = thickness * (np.arange(len(angles) + 1) - len(angles) / 2)
    a, b, d = (sum(stiffness(angle)[0] * (heights[k + 1]**n - heights[k]**n) / n for k, angle in enumerate(angles)) for n in (1, 2, 3))
    strain = np.linalg.solve(np.block([[a, -b], [-b, d]]), np.concatenate([force, moment]))
    found = []
    for k, angle in enumerate(angles):
        _, q, turn = stiffness(angle)
        for z in heights[k:k + 2]:
            found.append((indices(criterion, q @ turn @ (strain[:3] - z * strain[3:])), k + 1))
    largest = max(index for index, _ in found)
    return largest, {ply for index, ply in found if index > largest * (1 - 1e-9)}


def pulled(angles, thickness, force, criterion="tsai_wu"):
    """A strip of balanced plies under a force per width, held so that its strain is the same everywhere."""
    case = strip("linear", nx=8, ny=2, load=[{"type": "line", "group": "tip", "vector": [force, 0, 0]}])
    return case | {
        "material": [{"type": "laminate", "angles": angles, "ply_thicknesses": [thickness], "direction": [1, 0, 0], "failure": criterion} | PLY | STRENGTHS],
        "support": [{"type": "displacement", "group": "clamp", "components": ["x"]}, {"type": "displacement", "group": "side_low", "components": ["y"]},
                    {"type": "displacement", "group": "plate", "components": ["z"]}]}


@test
def failure_pulled(report):
    """Four criteria of laminates that are pulled and pressed, by lamination theory."""
    for k, (angles, force) in enumerate((([0, 90, 90, 0], 3e5), ([30, -30, -30, 30], 2e5), ([0, 45, -45, 90, 90, -45, 45, 0], -8e5))):
        for criterion in ("tsai_wu", "hashin", "maximum_stress", "maximum_strain"):
            result = solve(f"failure_{k}_{criterion}", pulled(angles, 1e-3, force, criterion))
            index, plies = by_theory(criterion, angles, 1e-3, (force, 0, 0))
            fields = result.results[-1]
            found = np.ravel(fields["failure_index"])
            report.below(np.abs(found / index - 1).max(), 1e-6, f"{angles}, {criterion}: index {index:.5g}")
            report.check(set(np.ravel(fields["failure_ply"])) <= plies, f"one of the plies {sorted(plies)}")
            first = result.summary["first_ply_failure"]
            report.percent(first["load_factor_left"] * index, 1e-6, f"the load may grow by {first['load_factor_left']:.5g}")
            report.check("fails first" in result.text, "the run says so")


@test
def failure_published(report):
    """[0/90/0] of 5 mm each: the 90 degree ply fails first, by Tsai-Wu at 7.277 MN/m (Kaw, 2006, example 5.3)."""
    result = solve("failure_kaw", pulled([0, 90, 0], 5e-3, 1e6))
    first = result.summary["first_ply_failure"]
    report.percent(first["load_factor_left"] / 7.277, 2e-4, f"first ply failure at {first['load_factor_left']:.5g} MN/m")
    report.check(first["ply"] == 2, f"ply {first['ply']}")


@test
def failure_bent(report):
    """A laminate bent by a moment at its end: index and face in the middle by lamination theory, static, on 2 ranks as on 1."""
    angles, moment = [0, 90, 90, 0, 0, 90], 20.0
    case = pulled(angles, 0.5e-3, 0.0) | {"analysis": "static", "support": [{"type": "clamped", "group": "clamp"}],
                                          "load": [{"type": "follower_moment", "group": "tip", "magnitude": moment}]}
    ends = []
    for ranks in (1, 2):
        result = solve(f"failure_bent_{ranks}", case, ranks)
        mesh = result.results[-1].mesh
        middle = np.abs(mesh.positions[mesh.triangles].mean(axis=1)[:, 0] - 5) < 1
        ends.append(np.ravel(result.results[-1]["failure_index"]))
    index = by_theory("tsai_wu", angles, 0.5e-3, moment=(moment, 0, 0))[0]  # positive moments lift the end
    report.percent(float(ends[0][middle].mean()) / index, 0.02, f"index in the middle, {index:.4g} by theory")
    report.below(np.abs(ends[1] / ends[0] - 1).max(), 1e-6, "2 ranks and 1")
    again = solve("failure_bent_again", load_case(OUT / "failure_bent_1" / "resolved_case.toml")).results[-1]
    report.below(np.abs(np.ravel(again["failure_index"]) / ends[0] - 1).max(), 1e-9, "the resolved case knows the plies and their strengths")


@test
def failure_mistakes(report):
    """Strengths that are not complete are refused."""
    good = pulled([0, 90, 0], 1e-3, 1e5)
    for name, changes, wanted in (
            ("missing", {"material.0.shear_strength": None}, ("material.shear_strength", "go together")),
            ("zero", {"material.0.tensile_strength_2": 0.0}, ("material.tensile_strength_2", "> 0")),
            ("negative", {"material.0.compressive_strength_1": -1.0}, ("material.compressive_strength_1", "> 0")),
            ("criterion", {"material.0.failure": "puck"}, ("material.failure", "tsai_wu")),
            ("alone", {f"material.0.{k}": None for k in STRENGTHS} | {"material.0.failure": "hashin"}, ("material.failure", "strengths")),
            ("isotropic", {"material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-3, "shear_strength": 1e6}]},
             ("shear_strength", "does not belong"))):
        result = run(write_case(variant(good, changes), OUT / f"failure_wrong_{name}.toml"), OUT / f"failure_wrong_{name}")
        report.check(result.code == 2 and all(w in result.text for w in wanted), f"{name}: {result.text.strip().splitlines()[-1][:140]}")
