"""Runs the test set of membrane_problems.py. Every number is kept as it comes, so that what was cut off goes on where it was."""

import concurrent.futures
import json
import shutil
import threading
import time

from membrane_cases import FABRICS, OUT
from membrane_problems import (ANNULUS_THIN, SAID, SEEDS, SHELL, CubeProblem, annulus, clamped_disc, cloth, drum, hemisphere, linear, pinched_path,
                               pullout, rolled, sizes, strip)

FLAT = ("one way", "random")
DISC = ("one way", "union jack", "gmsh")
STRIPS = [(nx * f, ny * f) for nx, ny in ((20, 2), (10, 2), (10, 4), (10, 8)) for f in (1, 2, 4)]


def fewer_at_finest(*finest):
    """One seed on these meshes, three on others."""
    return lambda kind, size: (1,) if tuple(size.values()) in finest else SEEDS[kind]


def coarsest_at_random(coarsest):
    return lambda kind, size: (1,) if kind != "random" else (1, 2, 3) if tuple(size.values()) == coarsest else ()


CUBE = {
    "cube_strips": CubeProblem(
        "Strips under an end shear, cells of aspect 1, 2, 4 and 8 at random", "length",
        "Against the elastica; Young's modulus keeps the bending stiffness. Ten cells of aspect 1 have no vertex inside to move: 20, 40 and 80 there.",
        sizes(nx=[a for a, _ in STRIPS], ny=[b for _, b in STRIPS]), ("random",), strip, seeds_of=fewer_at_finest((40, 32))),
    "cube_annulus": CubeProblem(
        "Slit annulus", "outer radius",
        "A and B at the last load; bending stiffness kept. Cells of 24 x 60 and 12 x 120, and 2/3 and 4/3 of them. Thinner than 1e-3 a load step takes "
        "hundreds of Newton iterations: left out. One seed from 12 x 120 on.",
        sizes(n_radial=[16, 24, 32, 8, 12, 16], n_circ=[40, 60, 80, 80, 120, 160]), FLAT, annulus, thicknesses=ANNULUS_THIN,
        compared_with="slit_annulus", seeds_of=fewer_at_finest((32, 80), (12, 120), (16, 160))),
    "cube_hemisphere": CubeProblem(
        "Hemisphere with a hole under four forces", "radius",
        "Both points at the last load, which is the published one at 4e-3 times the cube of the thickness.",
        sizes(n=[12, 24, 48]), SHELL, hemisphere, compared_with="hemisphere", seeds_of=fewer_at_finest((48,))),
    "cube_rolled": CubeProblem(
        "Cantilever rolled into a circle", "length", "Both components of the tip in % of the length; bending stiffness kept.",
        sizes(nx=[24, 48, 96], ny=[2, 4, 8]), ("one way", "union jack", "random"), rolled),
    "cube_hypar": CubeProblem(
        "Saddle clamped at one edge, linear", "side", "Bathe, Iosilevich & Chapelle (2000). Three seeds on all meshes.",
        sizes(n=[16, 32, 64]), SHELL, linear("hypar")),
    "cube_pinched_free": CubeProblem(
        "Pinched cylinder with free ends, linear", "radius", "It bends without stretching.",
        sizes(n_axial=[8, 16, 32], n_circ=[12, 24, 48]), SHELL, linear("pinched_free"),
        compared_with="pinched_free", seeds_of=fewer_at_finest((32, 48))),
    "cube_pinched_diaphragm": CubeProblem(
        "Pinched cylinder on diaphragms, linear", "radius",
        "It stretches as much as it bends: waves around the force shorten with the root of the thickness, and no mesh here resolves them at 1e-4.",
        sizes(n_axial=[16, 32, 64], n_circ=[16, 32, 64]), SHELL, linear("pinched_diaphragm"),
        compared_with="pinched_diaphragm", seeds_of=fewer_at_finest((64, 64))),
    "cube_scordelis_lo": CubeProblem(
        "Scordelis-Lo roof, linear", "radius", "Its edge layers shorten with the root of the thickness, as above.",
        sizes(n_axial=[8, 16, 32], n_circ=[8, 16, 32]), SHELL, linear("scordelis_lo"),
        compared_with="scordelis_lo", seeds_of=fewer_at_finest((32, 32))),
    "cube_twisted_beam": CubeProblem(
        "Twisted beam, force along y, linear", "length",
        "Against finer meshes: at 1e-2 these, too, are stiffer than a beam by what [limits](../../docs/verification/limits.md) says of strips that bend in their plane.",
        sizes(nx=[24, 48, 96], ny=[2, 4, 8]), SHELL, linear("twisted_beam"),
        compared_with="twisted_beam", seeds_of=fewer_at_finest((96, 8))),
    "cube_disc": CubeProblem(
        "Clamped disc under one pressure", "radius",
        "Against von Karman's equations: at 1e-2 it hardly stretches, at 1e-3 it bends by 6.4 times its thickness, at 1e-4 by 141.",
        sizes(n=[8, 16, 32]), DISC, clamped_disc, compared_with="clamped_disc", seeds_of=fewer_at_finest((32,))),
    "cube_drum": CubeProblem(
        "Drum", "radius", "The frequency furthest off, of six, of a hinged disc that is stretched by 1 % and has bending stiffness; consistent mass.",
        sizes(n=[8, 16, 32]), DISC, drum, seeds_of=fewer_at_finest((32,))),
    "cube_pullout": CubeProblem(
        "Pulled cylinder, along its path", "radius",
        "Load, B and C where A has moved by a quarter of the radius: there it bends without stretching. The published path, which goes on: below.",
        sizes(n_axial=[8, 12, 20], n_circ=[12, 18, 30]), FLAT, pullout, compared_with="pullout_cylinder", seeds_of=fewer_at_finest((20, 30))),
    "cube_cloth": CubeProblem(
        "Cloth square", "", "", sizes(n=[12, 20, 28]), ("gmsh",), cloth, thicknesses=tuple(range(1, len(FABRICS) + 1))),
    "cube_pinched_path": CubeProblem(
        "Pinched cylinder on diaphragms, along its path", "radius",
        "Largest distance of a published point from the curve. At the published thickness alone: thinner ones buckle into dimples that these meshes "
        "do not resolve, and there are no references. At random on the coarsest mesh.",
        sizes(n_axial=[24, 32, 40], n_circ=[24, 32, 40]), FLAT, pinched_path, thicknesses=(1e-2,), seeds_of=coarsest_at_random((24, 24))),
}


def cache_file(name):
    return OUT / f"{name}.json"


def stored(name):
    """Key of a setting -> its quantities and seconds; empty if there is nothing yet."""
    file = cache_file(name)
    return json.loads(file.read_text()) if file.is_file() else {}


def told(folder):
    """What a run said: whether it warned of wrong deflections, the estimates of its summary, and its iterations."""
    said, summary = folder / SAID, folder / "summary.json"
    found = json.loads(summary.read_text()) if summary.is_file() else {}
    text = said.read_text() if said.is_file() else ""
    return {"warned": any(words in text for words in ("too small by", "wrong by about")),
            "estimates": {name: found.get(name) for name in ("membrane_error", "recovery_error")},
            "iterations": found.get("newton_iterations")}


def wanted(problem, membranes, meshes, seeds):
    """The settings on the `meshes` coarsest of each three meshes, with no more than so many seeds."""
    shown = [size for place, size in enumerate(problem.sizes) if place % 3 < meshes]
    return [s for s in problem.settings(membranes) if s.size in shown and s.seed <= seeds]


def refresh(name, membranes, jobs=1, again=False, meshes=3, seeds=3):
    """Solves what the cache of a problem does not have; all with `again`."""
    problem, found, lock = CUBE[name], stored(name), threading.Lock()
    missing = [s for s in wanted(problem, membranes, meshes, seeds) if again or s.key not in found]

    def one(numbered):
        number, setting = numbered
        folder = OUT / name / str(number)
        folder.parent.mkdir(parents=True, exist_ok=True)
        start = time.time()
        values = problem.solve(setting, folder)
        with lock:
            found[setting.key] = {"values": values, "seconds": round(time.time() - start, 2)} | told(folder)
            partly = cache_file(name).with_suffix(".part")
            partly.write_text(json.dumps(found, indent=0))
            partly.replace(cache_file(name))
        shutil.rmtree(folder, ignore_errors=True)
        for kind in (".msh", ".toml"):
            folder.with_suffix(kind).unlink(missing_ok=True)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, enumerate(missing)))
    return len(missing)
