"""Garments from pieces of a pattern: cut, placed, sewn, welded; what is wrong with patterns is named."""

import copy
import json
import shutil
import struct
import tomllib

import numpy as np
from harness import OUT, solve, test
from results import Results
from solver import ROOT, Result, invoke, run, write_case

RADIUS, HEIGHT = 0.1, 0.15
ASSETS = ROOT.parent / "shared" / "assets"


def text_file(name, text):
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / name).write_text(text)
    return str(OUT / name)


def svg(name, *shapes):
    """Millimetres."""
    return text_file(name, '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="2000mm" viewBox="0 0 2000 2000">' + "".join(shapes) + "</svg>\n")


def rectangle(name, width, height):
    return f'<rect id="{name}" width="{1000 * width:.12g}" height="{1000 * height:.12g}"/>'


CLOTH = {"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 1e-3, "density": 300.0}


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


def masses(moment):
    """Of the vertices, up to the areal density, from the rest corners that are stored with the mesh."""
    rest = moment.mesh.rest
    mass = np.zeros(len(moment.mesh.positions))
    np.add.at(mass, moment.mesh.triangles.ravel(), np.repeat(np.linalg.norm(np.cross(rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]), axis=1) / 6, 3))
    return mass


@test
def garment_tube(report):
    """A flat sheet sewn into a tube has the energy of a cylinder, and no seam to be seen, on 1, 2 and 3 ranks."""
    bending = np.pi * HEIGHT / RADIUS * 1e6 * 1e-3**3 / 12
    for ranks in (1, 2, 3):
        result = solve(f"garment_tube_{ranks}", tube(), ranks)
        gap = part(result, "sew").history["seam_gap"]
        report.check(gap[0] > 0.02, f"{ranks} rank(s): the seam starts {gap[0]:.4f} m apart")
        report.below(gap[-1], 1e-4, f"{ranks} rank(s): and is welded from [m]")
        h = part(result, "rest").history
        report.percent(h["energy_bending"][-1] / bending, 0.005, f"{ranks} rank(s): bending energy")
        report.below(h["energy_membrane"][-1] / bending, 0.01, f"{ranks} rank(s): membrane, in bending energies")
        place = Results(result.folder / "rest")[-1].positions
        centre = place[:, :2].mean(axis=0)
        radius = np.linalg.norm(place[:, :2] - centre, axis=1)
        report.below(np.abs(radius / RADIUS - 1).max(), 0.01, f"{ranks} rank(s): radius, relative")


@test
def garment_measures(report):
    """A tube stretched by 2.7 % over a limb: ease, hoop tension in its seam before and after the weld, pressure T/R, its weight, on 1 and 2 ranks."""
    limb, tight = 0.095, 0.0935
    file = svg("garment_tight.svg", rectangle("tube", 2 * np.pi * tight, HEIGHT))
    case = tube(panel=[{"file": file, "size": 0.007, "wrap_axis": [0, 0, 1], "translate": [-np.pi * tight, -1.05 * RADIUS, 0]}],
                obstacle=[{"name": "limb", "type": "capsule", "point": [0, 0, -0.5], "end": [0, 0, 0.5 + HEIGHT], "radius": limb}],
                contact={"distance": 1e-3, "stiffness": 1e5},
                probe=[{"name": "around", "type": "ease"}, {"name": "hem", "type": "height", "group": "tube/0", "ground": -0.2}])
    case["stage"][0]["time"]["end"] = 0.5
    cells = round(2 * np.pi * tight / 0.007)
    for ranks in (1, 2):
        result = solve(f"garment_measures_{ranks}", case, ranks)
        for stage in ("sew", "rest"):
            measured = json.loads((result.folder / stage / "summary.json").read_text())["garment"]
            moment, history = Results(result.folder / stage)[-1], part(result, stage).history
            x, what = moment.positions, f"{ranks} rank(s), {stage}"
            distance = np.linalg.norm(x[:, :2], axis=1) - limb
            report.below(np.abs(moment["ease"] - distance).max(), 1e-9, f"{what}: ease is the distance to the limb [m]")
            report.near(history["around_min"][-1], distance.min(), 1e-9, f"{what}: the least of them")
            report.near(measured["mean_ease"], history["around_mean"][-1], 1e-12, f"{what}: mean ease [m]")
            hem = x[moment.mesh.group("tube/0"), 2]
            report.near(history["hem_max"][-1], hem.max() + 0.2, 1e-9, f"{what}: hem above the ground [m]")
            panel = measured["panels"][0]
            report.percent(panel["mass"] / (2 * np.pi * tight * HEIGHT * 0.3), 1e-9, f"{what}: mass")
            # Green-Lagrange strain (s^2 - 1)/2, a hoop force s E h (s^2 - 1)/2 per rest width; pressure per rest area.
            # The cells are chords of the circle that vertices lie on: that circle is larger than the tube by a sixth of the angle squared.
            s = (limb + history["around_mean"][-1]) * np.sinc(1 / cells) / tight
            hoop = s * 1e3 * (s**2 - 1) / 2
            (seam,) = measured["seams"]
            report.percent(seam["mean_tension"] / hoop, 0.03, f"{what}: tension of the seam, {hoop:.2f} N/m")
            if stage == "rest":
                inner = np.abs(x[:, 2] - x[:, 2].mean()) < 0.3 * HEIGHT
                report.percent(moment["contact_pressure"][inner].mean() / (hoop / tight), 0.02, f"{what}: pressure, {hoop / tight:.1f} Pa")
                report.check(measured["largest_contact_pressure"] == moment["contact_pressure"].max(), f"{what}: and the largest")


@test
def garment_restart(report):
    """A run goes on from a checkpoint amid sewing, from the stage after the weld, and from within that stage."""
    case = tube()
    fixed = {"step": 0.01, "max_step": 0.01, "target_iterations": 1000, "velocity_tolerance": 0.0}  # so that the runs take the same steps
    case["stage"][0]["time"] |= {"end": 0.16} | fixed
    case["stage"][1] = {"name": "move", "analysis": "dynamic", "time": {"end": 0.2} | fixed}
    case["spring"] = []
    case["initial_velocity"] = [{"velocity": [0.3, 0.2, 0.1]}]
    case["stage"][0]["damping"] = {"membrane": 0.01}
    whole = solve("garment_whole", case, 2)
    end = part(whole, "move").displacement()
    half = copy.deepcopy(case)
    half["stage"] = [case["stage"][0] | {"time": case["stage"][0]["time"] | {"end": 0.08}}]
    solve("garment_half", half, 1)
    folder = OUT / "garment_rest"
    shutil.rmtree(folder, ignore_errors=True)
    rest = run(OUT / "garment_whole.toml", folder, 3, ["--from", "sew", "--restart", OUT / "garment_half" / "sew" / "checkpoint.h5"])
    report.check(rest.code == 0, f"from amid sewing: code {rest.code}")
    report.below(np.abs(part(rest, "move").displacement() - end).max(), 1e-7, "on 3 ranks, to the same end [m]")
    again = run(OUT / "garment_whole.toml", whole.folder, 1, ["--from", "move"])
    report.check(again.code == 0, f"--from move welds what sew has left: code {again.code}")
    report.below(np.abs(part(again, "move").displacement() - end).max(), 1e-9, "to the same end [m]")
    folder = OUT / "garment_within"
    shutil.rmtree(folder, ignore_errors=True)
    within = run(OUT / "garment_whole.toml", folder, 2, ["--from", "move", "--restart", whole.folder / "move" / "results.vtkhdf", "--restart-step", "2"])
    report.check(within.code == 0, f"from the results within move, whose mesh is welded: code {within.code}")
    before, after = Results(whole.folder / "sew")[-1], Results(whole.folder / "move")[0]
    momentum = [(masses(m)[:, None] * m["velocity"]).sum(axis=0) for m in (before, after)]
    report.below(masses(after).sum() / masses(before).sum() - 1, 1e-12, "the weld keeps mass, relative")
    report.below(np.linalg.norm(momentum[1] - momentum[0]) / np.linalg.norm(momentum[0]), 1e-12, "and momentum, relative")
    report.check(len(after.positions) < len(before.positions), f"{len(before.positions)} vertices become {len(after.positions)}")


@test
def garment_sections(report):
    """Stitches between pieces of several sections of one file are seams; those to pieces that nothing cuts are named."""
    square = {"vertices": [[0, 0], [20, 0], [20, 20], [0, 20]], "edges": [{"endpoints": [k, (k + 1) % 4]} for k in range(4)], "rotation": [0, 0, 0]}
    panels = {name: square | {"translation": [x, 0, 0]} for name, x in (("a", 0), ("b", 30), ("c", 60))}
    stitches = [[{"panel": p, "edge": 1}, {"panel": q, "edge": 3}] for p, q in (("a", "b"), ("b", "c"))]
    file = text_file("garment_sections.json", json.dumps({"pattern": {"panels": panels, "stitches": stitches},
                                                          "properties": {"curvature_coords": "relative", "units_in_meter": 100}}))

    def said(*sections):
        case = tube(panel=[{"file": file, "size": 0.05} | keys for keys in sections], seam=[], spring=[])
        code, text = invoke(["check", write_case(case, OUT / "garment_sections.toml")])
        return code, text.count("apart at the start"), " ".join(text.split())

    for what, sections in (("one", [{}]), ("two", [{"pieces": ["a", "c"]}, {"pieces": ["b"], "name": "middle"}]),
                           ("three", [{"pieces": ["c"]}, {"pieces": ["b"]}, {"pieces": ["a"]}])):
        code, seams, text = said(*sections)
        report.check(code == 0 and seams == 2 and "is no seam" not in text, f"{what} section(s): code {code}, {seams} seams")
    code, seams, text = said({"pieces": ["a"]}, {"pieces": ["b"]})
    report.check(code == 0 and seams == 1 and "stitch 1 joins edge 3 of piece 'c', which no [[panel]] with stitches cuts" in text, f"one piece less: code {code}, {seams} seams")
    code, seams, text = said({"pieces": ["b", "c"]})
    report.check(code == 0 and seams == 1 and "stitch 0 joins edge 1 of piece 'a', which no [[panel]] with stitches cuts" in text, f"the first one less: code {code}, {seams} seams")
    code, seams, text = said({"pieces": ["a"]}, {"pieces": ["b"]}, {"pieces": ["b"], "name": "twin", "translate": [0, 0, 1]}, {"pieces": ["c"]})
    report.check(code == 0 and seams == 0 and text.count("piece 'b', which several [[panel]] sections cut") == 2, f"one piece twice: code {code}, {seams} seams")
    code, seams, text = said({"pieces": ["a"]}, {"pieces": ["b"], "stitches": False}, {"pieces": ["c"], "stitches": False})
    report.check(code == 0 and seams == 0, f"without stitches: code {code}, {seams} seams")


def dxf(name, blocks, header=((9, "$INSUNITS"), (70, 4))):
    """Millimetres. Each block: lists of (layer, closed, points), single points and lines included."""
    lines = []

    def put(*groups):
        lines.extend(f"{code:3}\n{value}" for code, value in groups)

    put((0, "SECTION"), (2, "HEADER"), *header, (0, "ENDSEC"), (0, "SECTION"), (2, "BLOCKS"))
    for block, shapes in blocks.items():
        put((0, "BLOCK"), (2, block))
        for layer, closed, points in shapes:
            if len(points) == 1:
                put((0, "POINT"), (8, layer), (10, points[0][0]), (20, points[0][1]))
                continue
            put((0, "POLYLINE"), (8, layer), (66, 1), (70, int(closed)))
            for x, y in points:
                put((0, "VERTEX"), (8, layer), (10, x), (20, y))
            put((0, "SEQEND"))
        put((0, "ENDBLK"))
    put((0, "ENDSEC"), (0, "EOF"))
    return text_file(name, "\n".join(lines) + "\n")


@test
def garment_dxf(report):
    """Half a piece of a DXF, with allowance and notch, and half a rectangle of an SVG unfold, and are sewn into tubes."""
    width, height = 1000 * 2 * np.pi * RADIUS, 1000 * HEIGHT
    half, allowance = width / 2, 10
    block = [(1, True, [(0, -allowance), (half + allowance, -allowance), (half + allowance, height + allowance), (0, height + allowance)]),
             (14, False, [(0, 0), (half, 0), (half, height), (0, height)]), (6, False, [(0, height + 20), (0, -20)]),
             (4, False, [(half + allowance, height / 3)]), (7, False, [(10, 20), (10, 120)])]
    case = tube(panel=[{"file": dxf("garment_half.dxf", {"tube": block}), "size": 0.015, "wrap_axis": [0, 0, 1], "translate": [0, -1.05 * RADIUS, 0]}],
                seam=[{"name": "side", "edges": ["tube/c1..c2"], "to": ["tube/c2'..c1'"], "meet": ["tube@c1", "tube@c1'"]}])
    folded = svg("garment_half.svg", f'<path id="tube" d="M 0 0 V {height} H {half} V 0 Z"/>')
    other = tube(panel=[{"file": folded, "size": 0.015, "unfold": "0", "wrap_axis": [0, 0, 1], "translate": [0, -1.05 * RADIUS, 0]}],
                 seam=[{"name": "side", "edges": ["tube/1"], "to": ["tube/4"], "meet": ["tube@1", "tube@5"]}])
    for what, wanted, edges in (("DXF", case, 8), ("SVG", other, 6)):
        wanted["stage"] = wanted["stage"][:1]
        wanted["spring"] = []
        code, text = invoke(["check", write_case(wanted, OUT / "garment_half.toml")], 2)
        report.check(code == 0 and f"'tube': {2 * half * height * 1e-6:.6g} m^2" in text and f"{edges} edges" in text, f"{what}: the whole piece without allowance: code {code}: {text[-200:] if code else ''}")
        result = solve(f"garment_half_{what}", wanted)
        gap = part(result, "sew").history["seam_gap"]
        report.check(gap[0] > 0.02, f"{what}: the seam starts {gap[0]:.4f} m apart")
        report.below(gap[-1], 1e-4, f"{what}: and closes to [m]")

    def refused(what, wanted, *words):
        code, text = invoke(["check", write_case(wanted, OUT / "garment_half.toml")])
        report.check(code == 2 and all(w in text for w in words), f"{what}: code {code}: {' '.join(text.split())[:260]}")

    refused("no unit", case | {"panel": [{"file": dxf("garment_unitless.dxf", {"tube": block}, ())}]}, "garment_unitless.dxf", "$INSUNITS", "key unit")
    refused("an unknown point", case | {"seam": [{"edges": ["tube/c1..c9"], "to": ["tube/c2'..c1'"]}]}, "tube/c1..c9", "FROM..TO", "n0'")
    refused("an unknown fold", other | {"panel": [other["panel"][0] | {"unfold": "9"}]}, 'unfold = "9"', "it has 4")
    refused("a grain line without direction", case | {"panel": [case["panel"][0] | {"grain": [0, 0]}]}, "panel.grain", "two numbers")


@test
def garment_holes(report):
    """A patch sewn into a hole and a lens sewn to itself leave a sheet with the hole that is left; wrong holes are refused."""
    lens = "M 200 40 Q 210 100 200 160 Q 190 100 200 40 Z"
    sheet = svg("garment_holes.svg", f'<path id="sheet" d="M 0 0 H 300 V 200 H 0 Z M 40 60 H 120 V 140 H 40 Z {lens} M 240 90 h 30 v 30 h -30 Z"/>', rectangle("patch", 0.08, 0.08))
    case = tube(panel=[{"file": sheet, "pieces": ["sheet"], "size": 0.02}, {"file": sheet, "pieces": ["patch"], "size": 0.02, "translate": [0.04, 0.01, -0.06]}],
                seam=[{"name": "patch", "edges": ["sheet/4..7", "sheet/7"], "to": ["patch/0..3", "patch/3"], "meet": ["sheet@4", "patch@0"]},
                      {"name": "lens", "edges": ["sheet/8"], "to": ["sheet/9"], "meet": ["sheet@8", "sheet@8"]}], spring=[],
                stage=[{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.3, "step": 0.01}, "damping": {"mass": 20.0}},
                       {"name": "rest", "analysis": "dynamic", "time": {"end": 0.32, "step": 0.01}}])
    code, text = invoke(["check", write_case(case, OUT / "garment_holes.toml")], 2)
    area = 0.06 - 0.0064 - 2 * 2 / 3 * 0.12 * 0.005 - 0.0009
    report.check(code == 0 and f"'sheet': {area:.6g} m^2" in text and "14 edges" in text and "3 holes" in text, f"check: code {code}")
    result = solve("garment_holes", case, 2)
    h = part(result, "sew").history
    report.check(h["seam_gap"][0] > 0.009, f"seams start {h['seam_gap'][0]:.4f} m apart")
    report.below(h["seam_gap"][-1], 1e-4, "and close to [m]")
    report.check(h["intersections"].max() == 0, "no intersection")
    end = Results(result.folder / "rest")[0].mesh
    edges, count = np.unique(np.sort(end.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    report.near(len(end.positions) - len(edges) + len(end.triangles), 0, 0, "Euler's number: a sheet with one hole")
    report.check((count <= 2).all(), "a manifold")
    panels = part(result, "rest").summary["garment"]["panels"]
    report.near(sum(p["area"] for p in panels), area + 0.0064, 3e-5, "area of the fabric [m^2]")

    def refused(what, loops, *words):
        wrong = svg("garment_holes_wrong.svg", f'<path id="sheet" d="M 0 0 H 300 V 200 H 0 Z {loops}"/>')
        code, text = invoke(["check", write_case(tube(panel=[{"file": wrong}], seam=[], spring=[]), OUT / "garment_holes_wrong.toml")])
        report.check(code == 2 and all(w in text for w in ("piece 'sheet'", *words)), f"{what}: code {code}: {' '.join(text.split())[:260]}")

    refused("a hole outside", "M 310 10 h 9 v 9 Z", "edges 4 to 6", "no hole", "pieces of their own")
    refused("a hole across", "M 290 10 h 30 v 9 Z", "edges 1 and 4", "the hole (edges 4 to 6)", "move the hole")
    refused("a hole that touches", "M 300 50 l -20 10 v -20 Z", "near (0.3, -0.05) m", "clear of each other")
    refused("holes across each other", "M 10 10 h 50 v 50 Z M 40 10 h 50 v 50 Z", "the hole (edges 4 to 6)", "the hole (edges 7 to 9)")
    refused("a hole within a hole", "M 10 10 h 50 v 50 h -50 Z M 20 20 h 9 v 9 Z", "edges 8 to 10", "inside of the hole (edges 4 to 7)")


@test
def garment_refused(report):
    """Patterns and seams that cannot be: each mistake is named with its file and remedy; nothing crashes."""
    def refused(what, case, *words, ranks=1):
        code, text = invoke(["check", write_case(case, OUT / "garment_wrong.toml")], ranks)
        report.check(code == 2 and all(w in text for w in words), f"{what}: code {code}: {' '.join(text.split())[:260]}")

    def panel(**keys):
        case = tube()
        case["panel"][0] |= keys
        return case

    def pattern(name, text, **keys):
        return tube(panel=[{"file": text_file(name, text)} | keys], seam=[])

    code, text = invoke(["check", write_case(tube(), OUT / "garment_good.toml")], 2)
    report.check(code == 0 and "fabric: 0.0942" in text and "'side'" in text, f"the tube itself: code {code}")
    refused("no such file", panel(file="nowhere.svg"), "nowhere.svg", "no such file", ranks=2)
    refused("an empty file", pattern("garment_empty.svg", ""), "garment_empty.svg", "empty")
    refused("a file that is no JSON", pattern("garment_bad.json", '{"pattern": [1, '), "garment_bad.json", "not valid JSON")
    refused("a file that is no XML", pattern("garment_bad.svg", "<svg><path d="), "garment_bad.svg", "not valid XML")
    refused("millimetres for metres", panel(unit=1.0), "'tube'", "628.3 m", "unit")
    refused("an unknown piece", panel(pieces=["sleeve"]), "garment_tube.svg", "none of those there are: tube")
    refused("one name for two", tube(panel=[{"file": svg("garment_two.svg", rectangle("a", 0.2, 0.1), rectangle("b", 0.2, 0.1)), "name": "c"}], seam=[]), "is for one piece")
    refused("another key of a mesh", tube(mesh={"size": 0.1}), "mesh.size", "[[panel]]")
    refused("a cylinder too thin", panel(wrap_radius=0.05), "'tube'", "overlap itself")
    refused("a cone whose apex is in the piece", panel(wrap_angle=30, wrap_radius=0.05), "'tube'", "would pass the apex")
    refused("a piece too wide for a cone", panel(wrap_angle=5), "'tube'", "overlap itself on a cone")
    refused("a cone of no direction", panel(wrap_axis=[0, 0, 0]), "panel.wrap_axis", "must not be zero")
    refused("a cone without an axis", tube(panel=[{"file": tube()["panel"][0]["file"], "wrap_angle": 5}]), "panel.wrap_axis", "wrap_angle is about an axis")
    refused("an axis twice", panel(wrap_end=[0, 0, 1]), "panel.wrap_axis", "remove one")
    two = panel(wrap_point=[0, 0, -HEIGHT], wrap_end=[0, 0, 0], wrap_radii=[0.11, 0.13])
    del two["panel"][0]["wrap_axis"]
    refused("an angle beside two radii", {**two, "panel": [two["panel"][0] | {"wrap_angle": 5}]}, "panel.wrap_radii", "remove those")
    refused("three radii", {**two, "panel": [two["panel"][0] | {"wrap_radii": [1, 2, 3]}]}, "panel.wrap_radii", "two numbers")
    refused("an end without length", {**two, "panel": [two["panel"][0] | {"wrap_end": [0, 0, -HEIGHT]}]}, "panel.wrap_end", "another point")
    refused("radii without an end", panel(wrap_radii=[0.1, 0.2]), "panel.wrap_end", "the second of wrap_radii")
    code, text = invoke(["check", write_case(two, OUT / "garment_cone.toml")])
    report.check(code == 0 and "'side'" in text, f"a cone of two radii: code {code}: {text[-200:] if code else ''}")
    refused("a cone that begins with its apex", {**two, "panel": [two["panel"][0] | {"wrap_point": [0, 0, -0.1], "wrap_end": [0, 0, -0.05], "wrap_radii": [0, 0.03]}]}, "apex of the cone at (0, 0, -0.1) m")
    refused("a leaning axis", panel(wrap_axis=[0, 0.2, 1]), "leans by")
    refused("a twisted seam", tube(seam=[{"name": "side", "edges": ["tube/1"], "to": ["tube/3"], "meet": ["tube@1", "tube@3"]}]), "'side'", "twist")
    refused("an edge sewn twice", tube(seam=[{"edges": ["tube/1"], "to": ["tube/3"]}, {"edges": ["tube/1"], "to": ["tube/0"]}]), "tube/1 is in a seam already")
    refused("an unknown edge", tube(seam=[{"edges": ["tube/7"], "to": ["tube/3"]}]), "tube/7", "no such edge")
    refused("one point in meet", tube(seam=[{"edges": ["tube/1"], "to": ["tube/3"], "meet": ["tube@1"]}]), "seam.meet", "two are needed")
    wrong = tube()
    wrong["stage"][0]["sew"] = ["sied"]
    refused("an unknown seam", wrong, "'sied'", "side")
    wrong = tube()
    wrong["stage"][1]["sew"] = ["all"]
    refused("sewing without time", wrong, "'rest' sew", "dynamic")
    refused("remeshing open seams", tube(remesh={}), "[remesh]", "'side'", "still open")
    # Two pieces through each other, and one through a body.
    two = [{"file": tube()["panel"][0]["file"], "name": n, "size": 0.03, "translate": [0, y, 0], "rotate": [0, 0, a]} for n, y, a in (("front", 0, 0), ("back", -0.1, 70))]
    refused("pieces through each other", tube(panel=two, seam=[], spring=[], stage=[{"name": "rest", "analysis": "drape"}]), "panel 'front'", "panel 'back'", "intersects", ranks=2)
    ball = tube(obstacle=[{"name": "body", "type": "sphere", "point": [0.105, 0, -0.07], "radius": 0.03}])
    refused("a piece through the body", ball, "body", "[contact]")
    # A seam that has no time to close ends the run, with its name.
    late = tube()
    late["stage"][0]["time"] |= {"end": 0.03}
    folder = OUT / "garment_late"
    shutil.rmtree(folder, ignore_errors=True)
    result = run(write_case(late, OUT / "garment_late.toml"), folder, 2)
    report.check(result.code == 3 and "'side' is still open" in result.text, f"a seam without time: code {result.code}")


def code_file(name, panels, stitches=()):
    """GarmentCode, centimetres."""
    return text_file(name, json.dumps({"pattern": {"panels": panels, "stitches": list(stitches)}, "properties": {"curvature_coords": "relative", "units_in_meter": 100}}))


def panel_of(vertices=((0, 0), (20, 0), (20, 20), (0, 20)), edges=4, at=(0, 0, 0), turned=(0, 0, 0)):
    return {"vertices": [list(v) for v in vertices], "translation": list(at), "rotation": list(turned), "edges": [{"endpoints": [k, (k + 1) % len(vertices)]} for k in range(edges)]}


def box_file(name, flip=False, whole=True):
    """A limb of twelve triangles, or of ten with two holes."""
    points = [(x, y, z) for z in (-0.3, 0.3) for x, y in ((-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05))]
    faces = [(1, 3, 2), (5, 6, 7), (1, 4, 3), (5, 7, 8), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 4, 8), (3, 8, 7), (4, 1, 5), (4, 5, 8)][0 if whole else 2:]
    lines = ["v {} {} {}".format(*p) for p in points] + ["f {} {} {}".format(*(f[::-1] if flip else f)) for f in faces]
    return {"name": "body", "type": "mesh", "file": text_file(name, "\n".join(lines) + "\n")}, np.array(points)


def frames_file(name, frames):
    (OUT / name).write_bytes(b"POINTCACHE2\0" + struct.pack("<iiffi", 1, len(frames[0]), 0.0, 1.0, len(frames)) + np.array(frames, "<f4").tobytes())
    return {"frames": str(OUT / name), "frames_per_second": 25}


@test
def garment_hostile(report):
    """Patterns and bodies that go wrong in use: each ends with a message that tells what, where and what to do, or does no harm."""
    def says(what, code, case, *words):
        got, text = invoke(["check", write_case(case, OUT / "garment_hostile.toml")])
        text = " ".join(text.split())
        report.check(got == code and all(w in text for w in words), f"{what}: code {got}{'' if all(w in text for w in words) else ': ' + text[:300]}")

    def pattern(panels, stitches=()):
        return tube(panel=[{"file": code_file("garment_hostile.json", panels, stitches), "size": 0.05}], seam=[], spring=[])

    says("a panel turned by two angles", 0, pattern({"a": panel_of(turned=(90, 45, 0))}), "'a' is turned about more than one axis", 'euler = "xyz"')
    says("an open loop", 2, pattern({"a": panel_of(edges=3)}), "'a'", "the outline is open", "vertex 3")
    says("a figure of eight", 2, pattern({"a": panel_of(((0, 0), (20, 20), (20, 0), (0, 20)))}), "edges 0 and 2", "near (0.1, 0.1) m")
    says("an outline that touches itself", 2, pattern({"a": panel_of(((0, 0), (10, 10), (20, 0), (20, 20), (10, 10), (0, 20)), 6)}), "near (0.1, 0.1) m")
    says("metres for centimetres", 2, pattern({"a": panel_of(((0, 0), (0.2, 0), (0.2, 0.2), (0, 0.2)))}), "0.002 m x 0.002 m", "unit")
    chain = {"a": panel_of(), "b": panel_of(at=(30, 0, 0)), "c": panel_of(at=(15, 0, -30), turned=(0, 180, 0))}
    ring = [[{"panel": p, "edge": 1}, {"panel": q, "edge": 3}] for p, q in (("a", "b"), ("b", "c"), ("c", "a"))]
    says("a ring of three", 0, pattern(chain, ring), "'c/1-a/3'")
    says("a ring with a twist", 2, pattern(chain, ring[:2] + [ring[2] + ["right_wrong"]]), "stitch 2", "with a twist")
    says("an edge in two seams", 2, pattern(chain, ring[:1] + [ring[0][::-1]]), "stitch 1", "is in a seam already", "divide it")
    dart = svg("garment_tipless.svg", '<path id="piece" d="M 0 0 L 400 0 L 400 300 L 230 300 L 210 180 L 190 180 L 170 300 L 0 300 Z"/>')
    says("a dart without a tip", 2, tube(panel=[{"file": dart, "size": 0.025}], seam=[{"edges": ["piece/3"], "to": ["piece/5"]}], spring=[]), "[[seam]] number 0", "no common tip")
    body, points = box_file("garment_box.obj")
    short = tube(spring=[], obstacle=[body])
    short["stage"][1] = {"name": "rest", "analysis": "dynamic", "time": {"end": 0.35, "step": 0.01}}
    for what, other in (("a body with holes", box_file("garment_open.obj", whole=False)), ("an inverted body", box_file("garment_inverted.obj", flip=True))):
        says(what, 0, short | {"obstacle": [other[0]]}, "no errors found")
    says("a body in millimetres", 0, short | {"obstacle": [body | {"scale": 1000.0}]}, "'body' measures 600 m", "0.001 for millimetres")
    inner = {"file": svg("garment_inner.svg", rectangle("inner", 0.03, 0.03)), "size": 0.02, "translate": [-0.015, 0, 0]}
    for what, limb in (("a piece inside of the body", body), ("inside of an inverted body", box_file("garment_inverted.obj", flip=True)[0])):
        says(what, 0, short | {"obstacle": [limb], "panel": [*short["panel"], inner]}, "panel 'inner' lies inside of [[obstacle]] 'body'", "origin")
    got, text = invoke(["check", write_case(short | {"obstacle": [body]}, OUT / "garment_hostile.toml")])
    report.check(got == 0 and "lies inside" not in text, f"a tube round the body does not: code {got}")
    early = {"groups": ["tube/0"], "obstacle": "body"}
    says("held to a body that comes later", 2, short | {"obstacle": [body | {"stages": ["rest"]}], "attachment": [early]}, "attachment.obstacle", "no [[obstacle]] 'body' in stage 'sew': there is none")
    leap = [points, points, points + [0.5, 0, 0], points + [0.5, 0, 0]]
    says("ease without a body", 2, short | {"obstacle": [], "probe": [{"name": "waist", "type": "ease"}]}, "[[probe]] 'waist'", "there is no body")
    says("height of no edge", 2, short | {"probe": [{"name": "hem", "type": "height", "group": "tube/9"}]}, "tube/9")
    says("a height along two axes", 2, short | {"probe": [{"name": "hem", "type": "height", "group": "tube/0", "components": ["x", "z"]}]}, "probe.components", "points up")
    says("a frame that leaps", 0, short | {"obstacle": [body | frames_file("garment_leap.pc2", leap)]}, "from frame 2 of", "goes 0.5 m")
    walk = [points + [0.01 * k, 0, 0] for k in range(5)]
    got, text = invoke(["check", write_case(short | {"obstacle": [body | frames_file("garment_walk.pc2", walk)]}, OUT / "garment_hostile.toml")])
    report.check(got == 0 and "leap" not in text, f"steady frames: code {got}")
    says("frames of another mesh", 2, short | {"obstacle": [body | frames_file("garment_other.pc2", [points[:6]] * 2)]}, "6 vertices", "has 8")
    says("a clamp that lies inside once the seam is welded", 2, tube(spring=[], support=[{"group": "tube/1", "type": "clamped"}]), "stage 'rest'", "'tube/1'")
    folder = OUT / "garment_pinned"
    shutil.rmtree(folder, ignore_errors=True)
    pinned = short | {"obstacle": [], "support": [{"group": g, "type": "hinged"} for g in ("tube/1", "tube/3")]}
    result = run(write_case(pinned, OUT / "garment_pinned.toml"), folder, 2)
    report.check(result.code == 3 and "hold both of its sides there, by the groups 'tube/1' and 'tube/3'" in result.text, f"both sides pinned apart: code {result.code}")


@test
def garment_dress(report):
    """A whole GarmentCode dress on a mannequin, where they are at hand: it is cut, placed clear of the body, and begins to close."""
    pattern, body = ASSETS / "garmentcode_dress_pencil_pattern.json", ASSETS / "manikin_static.obj"
    if not (pattern.is_file() and body.is_file()):
        print(f"  skipped: there is no {pattern}")
        return
    pieces = json.loads(pattern.read_text())["pattern"]["panels"]
    case = {"panel": [{"file": str(pattern), "size": 0.03}],
            "material": [CLOTH | {"thickness": 5e-4}], "contact": {"distance": 2e-3}, "obstacle": [{"name": "body", "type": "mesh", "file": str(body)}], "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.02, "step": 5e-3}}]}
    code, text = invoke(["check", write_case(case, OUT / "garment_dress.toml")], 2)
    report.check(code == 0 and f"in {len(pieces)} panels" in text, f"the pattern round the body: code {code}: {text.strip().splitlines()[-1]}")
    folder = OUT / "garment_dress"
    shutil.rmtree(folder, ignore_errors=True)
    result = run(write_case(case, OUT / "garment_dress.toml"), folder, 2)
    report.check(result.code == 3 and "is still open" in result.text, f"in so short a time they do not close: code {result.code}")
    gap = part(result, "sew").history["seam_gap"]
    report.check(gap[-1] < gap[0] - 0.005, f"but begin to: {gap[0]:.3f} m to {gap[-1]:.3f} m")


def tight(share, **changes):
    """A sheet round a smooth rod whose girth it falls short of by this share, pulled together round it."""
    width = 2 * np.pi * (RADIUS + 1e-3) * (1 - share)
    file = svg(f"garment_tight_{1000 * share:.0f}.svg", rectangle("tube", width, HEIGHT))
    return tube(panel=[{"file": file, "size": 0.015, "wrap_axis": [0, 0, 1], "translate": [-width / 2, -1.2 * RADIUS, 0]}], spring=[],
                obstacle=[{"name": "body", "type": "capsule", "point": [0, 0, -0.2], "end": [0, 0, HEIGHT + 0.2], "radius": RADIUS, "friction": 0.0}],
                stage=[{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.7, "step": 0.01}, "damping": {"mass": 20.0}}]) | changes


@test
def garment_tight(report):
    """A sheet that must stretch by 4 % closes to the gap that is asked for; one that must stretch by 30 % stays open with a bounded force, and is told."""
    result = solve("garment_tight_4", tight(0.04), 2)
    h = part(result, "sew").history
    report.below(h["seam_gap"][-1], 1e-4, "4 % short: gap [m]")
    report.check(h["largest_strain"][-1] > 0.02, f"4 % short: largest strain {h['largest_strain'][-1]:.3f}")
    folder = OUT / "garment_tight_30"
    shutil.rmtree(folder, ignore_errors=True)
    result = run(write_case(tight(0.3), OUT / "garment_tight_30.toml"), folder, 2)
    report.check(result.code == 3 and "'side' is still open" in result.text and "too tight" in result.text, f"30 % short: code {result.code}: {result.text.strip()[-300:]}")
    h = part(result, "sew").history
    report.below(h["largest_strain"].max(), 0.15, "30 % short: largest strain, where the springs stretch by a tenth")
    report.below(len(h["time"]), 100, "30 % short: steps, of 70 whole ones")
    report.check(h["smallest_gap"][-1] > 2e-4, f"30 % short: smallest gap to the body {h['smallest_gap'][-1]:.2e} m")
    report.check(h["intersections"].max() == 0, "30 % short: no intersection")


@test
def garment_slides(report):
    """A strip sewn round a cone that is too wide for it: friction holds it there; with less while it is sewn it goes up to where it fits."""
    low, high, slope, height = -0.2, 0.2, 0.25, 0.04
    turns = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    points = [(r * np.cos(a), r * np.sin(a), z) for z in (low, high) for r in [RADIUS - slope * z] for a in turns] + [(0, 0, low), (0, 0, high)]
    n = len(turns)
    faces = [f for k in range(n) for m in [(k + 1) % n] for f in ((k, m, n + m), (k, n + m, n + k), (2 * n, m, k), (2 * n + 1, n + k, n + m))]
    cone = text_file("garment_cone.obj", "".join("v %.9g %.9g %.9g\n" % p for p in points) + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces))
    width = 2 * np.pi * RADIUS * 0.97
    case = tube(panel=[{"file": svg("garment_strip.svg", rectangle("tube", width, height)), "size": 0.015, "wrap_axis": [0, 0, 1], "translate": [-width / 2, -1.25 * RADIUS, -height / 2]}],
                spring=[], obstacle=[{"name": "body", "type": "mesh", "file": cone, "friction": 0.5}], contact={"distance": 1e-3, "friction": 0.5},
                stage=[{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.8, "step": 0.01}, "damping": {"mass": 20.0}}])
    shutil.rmtree(OUT / "garment_slides_held", ignore_errors=True)
    held = run(write_case(case, OUT / "garment_slides_held.toml"), OUT / "garment_slides_held", 1)
    report.check(held.code == 3 and "[sewing] friction lets it slide" in held.text, f"held: code {held.code}")
    sliding = solve("garment_slides", case | {"sewing": {"friction": 0.02}}, 2)
    report.below(part(sliding, "sew").history["seam_gap"][-1], 1e-4, "sliding: gap [m]")
    report.check(part(sliding, "sew").history["intersections"].max() == 0, "sliding: no intersection")
    rise = part(sliding, "sew").results[-1].positions[:, 2].mean()
    report.check(rise > 5e-3, f"sliding: up by {rise:.4f} m")


@test
def garment_dart(report):
    """A dart: two edges of one piece that share a point become one."""
    w, depth = 15, 120
    file = svg("garment_dart.svg", f'<path id="piece" d="M 0 0 L 400 0 L 400 300 L {200 + w} 300 L 200 {300 - depth} L {200 - w} 300 L 0 300 Z"/>')
    case = tube(panel=[{"file": file, "size": 0.025, "wrap_axis": [0, 0, 1], "translate": [-0.2, -0.2, 0]}],
                seam=[{"name": "dart", "edges": ["piece/3"], "to": ["piece/4"]}], spring=[],
                stage=[{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.4, "step": 0.01}, "damping": {"mass": 20.0}},
                       {"name": "rest", "analysis": "dynamic", "time": {"end": 0.45, "step": 0.01}}])
    result = solve("garment_dart", case, 2)
    h = part(result, "sew").history
    report.near(h["seam_gap"][0], 2e-3 * w, 6e-3, "the dart is as wide as it was drawn [m]")
    report.below(h["seam_gap"][-1], 1e-4, "and closes [m]")
    end = Results(result.folder / "rest")[0].mesh
    edges = np.sort(end.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    report.check((count <= 2).all(), "the welded mesh is a manifold")
    report.check(h["intersections"].max() == 0, "no intersection")


@test
def garment_tshirt(report):
    """The T-shirt of runs/garments with coarse cells: sleeves, armholes, shoulders, sides and neck close, it hangs on the figure and turns with it."""
    file = ROOT / "runs" / "garments" / "tshirt" / "case.toml"
    case = tomllib.loads(file.read_text())
    for panel in case["panel"]:
        panel |= {"file": str(file.parent / panel["file"]), "size": 0.04}
    OUT.mkdir(parents=True, exist_ok=True)
    figure = OUT / "garment_figure.obj"
    code, text = invoke(["manikin", figure, "--arms", 53, "--motion", "turn", "--seconds", 2, "--angle", 90])
    report.check(code == 0, f"manikin: code {code}: {text[-200:]}")
    case["obstacle"][0] |= {"file": str(figure), "frames": str(figure.with_suffix(".pc2")), "landmarks": str(figure.with_suffix(".landmarks.csv"))}
    case["material"] = [CLOTH]
    case["stage"][2]["time"]["end"] = 1.5
    result = solve("garment_tshirt", case, 2)
    h = part(result, "sew").history
    report.check(h["seam_gap"][0] > 0.3, f"seams start {h['seam_gap'][0]:.2f} m apart")
    report.below(h["seam_gap"][-1], 1e-4, "and close to [m]")
    end = Results(result.folder / "settle")[-1]
    edges = np.sort(end.mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    border = edges[count == 1]
    loops = {int(v): int(v) for v in border.ravel()}
    find = lambda v: v if loops[v] == v else find(loops[v])  # noqa: E731
    for a, b in border:
        loops[find(int(a))] = find(int(b))
    report.near(len({find(v) for v in loops}), 4, 0, "borders left: neck, hem, two sleeves")
    for stage in ("sew", "settle", "turn"):
        report.check(part(result, stage).history["intersections"].max() == 0, f"{stage}: no intersection")
    turned = Results(result.folder / "turn")[-1].positions - end.positions
    report.check(turned[:, 1].max() > 0.03 and turned[:, 1].min() < -0.03, f"one side goes forward, the other back: {turned[:, 1].min():.3f}, {turned[:, 1].max():.3f} m")
    report.check(end.positions[:, 2].max() > 1.4, f"it hangs on the shoulders, up to {end.positions[:, 2].max():.3f} m")


@test
def garment_sewn_dress(report):
    """The dress of runs/garments with coarse cells: half pieces unfold, four darts, sides, shoulders and waist close round the figure; welded it is one sheet without a dart."""
    file = ROOT / "runs" / "garments" / "dress" / "case.toml"
    case = tomllib.loads(file.read_text())
    for panel in case["panel"]:
        panel |= {"file": str(file.parent / panel["file"]), "size": 0.06}
    OUT.mkdir(parents=True, exist_ok=True)
    figure = OUT / "garment_dress_figure.obj"
    code, text = invoke(["manikin", figure, "--arms", 53, "--size", 0.05])
    report.check(code == 0, f"manikin: code {code}: {text[-200:]}")
    body = case["obstacle"][0]
    for key in ("frames", "frames_per_second", "frames_start"):
        del body[key]
    case["obstacle"] = [body | {"file": str(figure)}]
    case["material"] = [CLOTH]
    case["load"][0]["stages"] = ["rest"]
    case["stage"] = [case["stage"][0], {"name": "rest", "analysis": "dynamic", "time": {"end": 1.22, "step": 0.01}}]
    case["stage"][0]["time"]["step"] = 0.01
    result = solve("garment_sewn_dress", case)
    h = part(result, "sew").history
    report.check(h["seam_gap"][0] > 0.25, f"seams start {h['seam_gap'][0]:.2f} m apart")
    report.below(h["seam_gap"][-1], 1e-4, "and close to [m]")
    for stage in ("sew", "rest"):
        report.check(part(result, stage).history["intersections"].max() == 0, f"{stage}: no intersection")
    before, after = Results(result.folder / "sew")[-1], Results(result.folder / "rest")[0]
    report.below(abs(masses(after).sum() / masses(before).sum() - 1), 1e-12, "the weld keeps mass, relative")
    edges, count = np.unique(np.sort(after.mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    report.check((count <= 2).all(), "the welded mesh is a manifold")
    # Borders: neck, two armholes and the hem, so that Euler's number of the sphere loses four.
    report.near(len(after.positions) - len(edges) + len(after.mesh.triangles), 2 - 4, 0, "Euler's number")
    seams = {s["name"] for s in part(result, "rest").summary["garment"]["seams"]}
    report.check(len(seams) == 12 and "front waist" in seams, f"{len(seams)} seams are measured")
