"""The aims that the membrane was given, with what the stored results of runs/membranes say."""

import math

from membrane_cases import DISTANCE, FABRICS
from membrane_cube import CUBE, stored
from membrane_cube_tables import is_flat, rows_of
from membrane_problems import Setting
from tables import markdown


def largest(answers, membrane, *beginnings):
    """Largest error of the rows that begin so [%]; nan if one is missing or failed."""
    found = [a["value"] for a in answers if a["membrane"] == membrane and a["row"].startswith(beginnings)]
    return max((abs(v) if v is not None else math.nan for v in found), default=math.nan)


def cube_largest(name, mesh, membrane, thickness, kinds=None):
    found = [cells[membrane, thickness].size for kind, cells_of, cells in rows_of(name, [membrane])
             if cells_of == mesh and (kinds is None or kind in kinds) and (membrane, thickness) in cells]
    return max(found, default=math.nan)


def cloth_ratio(quantity, old, new):
    """New over old, of the means over the seeds: (largest, mean) over fabrics and meshes."""
    found, ratios = stored("cube_cloth"), []
    for number in range(1, len(FABRICS) + 1):
        for size in CUBE["cube_cloth"].sizes:
            mean = {}
            for m in (old, new):
                values = [r[quantity] for seed in (1, 2, 3) if (r := found.get(Setting(m, "gmsh", size, number, seed).key, {}).get("values"))]
                mean[m] = sum(values) / len(values) if values else math.nan
            if not math.isnan(ratio := mean[new] / mean[old]):
                ratios.append(ratio)
    return (max(ratios), sum(ratios) / len(ratios)) if ratios else (math.nan, math.nan)


def flat_share(membrane):
    counted = [is_flat(errors) for name, p in CUBE.items() if len(p.thicknesses) > 1 and name != "cube_cloth"
               for _, _, cells in rows_of(name, [membrane])
               if len(errors := [cells[membrane, t] for t in p.thicknesses if (membrane, t) in cells]) == len(p.thicknesses)]
    return sum(counted), len(counted)


def percent_row(title, limit, old, new):
    verdict = "" if math.isnan(new) else "reached" if new <= limit else "missed"
    return [title, f"<= {limit:g} %", *(("-" if math.isnan(v) else f"{v:.2f} %") for v in (old, new)), verdict]


def ratio_row(title, limit, new):
    verdict = "" if math.isnan(new) else "reached" if new <= limit else "missed"
    return [title, f"<= {limit:g}", "1", "-" if math.isnan(new) else f"{new:.2f}", verdict]


def error_rows(sections, *membranes):
    aims = sections.get("aims", [])
    both = lambda of: tuple(map(of, membranes))
    hypar = lambda mesh, kinds: both(lambda m: cube_largest("cube_hypar", mesh, m, 1e-4, kinds))
    even = ("one way", "union jack")
    yield percent_row("strip 20 x 16, cells of aspect 8 at random, h/L = 1e-2", 1, *both(lambda m: cube_largest("cube_strips", "20 x 16", m, 1e-2, ["random"])))
    patterns = [f"slit_annulus, {p}" for p in ("one", "union", "unstr")]
    yield percent_row("slit annulus 24 x 60, one way, union jack, Gmsh", 1, *both(lambda m: largest(aims, m, *patterns)))
    yield percent_row("slit annulus 24 x 60, at random", 1, *both(lambda m: largest(aims, m, "slit_annulus, moved")))
    for label, row in (("one way", "one way"), ("union jack", "union jack"), ("Gmsh", "unstructured"), ("at random", "moved")):
        start = f"hemisphere, {row}"
        yield percent_row(f"hemisphere 24, {label}", 1, *both(lambda m: largest(aims, m, start)))
    for mesh, limit in (("32", 3), ("64", 1)):
        yield percent_row(f"saddle 1e-4, {mesh} cells, one way and union jack", limit, *hypar(mesh, even))
        yield percent_row(f"saddle 1e-4, {mesh} cells, at random and Gmsh", limit, *hypar(mesh, ("random", "gmsh")))
    for mesh in ("24 x 2", "48 x 4"):
        before, after = both(lambda m: largest(aims, m, f"cantilever_moment, one way, {mesh}"))
        yield percent_row(f"rolled cantilever {mesh}, no worse", round(before, 2) if before == before else 0, before, after)


def aims_table(sections, old, new):
    """Two membranes side by side; what is counted or timed is that of the new one over the old one."""
    rows = list(error_rows(sections, old, new))
    for_each = lambda m: [a["value"] for a in sections.get("curves", []) if a["membrane"] == m and a["quantity"] == DISTANCE]
    within = [sum(v is not None and v <= 1 for v in for_each(m)) for m in (old, new)]
    if count := len(for_each(new)):
        rows.append([f"published curves at half the vertices within 1 %, of {count}", "all", *map(str, within),
                     "reached" if within[1] == count else "missed"])
    rows.append(ratio_row("largest dihedral of the cloth square, worst fabric and mesh", 1, cloth_ratio("largest dihedral [degrees]", old, new)[0]))
    rows.append(ratio_row("sharpest turn of its free edge, the same", 1, cloth_ratio("sharpest turn of the free edge [degrees]", old, new)[0]))
    rows.append(ratio_row("Newton iterations to drape it, mean", 1.1, cloth_ratio("Newton iterations", old, new)[1]))
    cost = {(a["row"], a["membrane"]): a["value"] for a in sections.get("cost", []) if a["quantity"].startswith("tangent")}
    ratios = [cost[row, new] / cost[row, old] for row, m in cost if m == new and (row, old) in cost]
    if ratios:
        rows.append(ratio_row("time of a tangent, worse of two meshes", 1.3, max(ratios)))
    flat = {m: flat_share(m) for m in (old, new)}
    rows.append(["meshes of the test set whose error is flat over the thickness", "all", *(f"{a} of {b}" for a, b in flat.values()),
                 "reached" if flat[new][0] == flat[new][1] else "missed"])
    return markdown(["aim", "wanted", f"`{old}`", f"`{new}`", ""], rows)
