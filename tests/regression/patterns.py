"""Files of patterns: their pieces are found, joined and unfolded; what is wrong with them is named."""

import json
import shutil

import numpy as np
from common import fresh
from harness import OUT, solve, test
from pattern_files import CLOTH, HEIGHT, RADIUS, box_file, frames_file, part, rectangle, svg, text_file, tube
from results import Results
from solver import ROOT, invoke, run, write_case

ASSETS = ROOT.parent / "shared" / "assets"

# What holds a sheet that a test is not about.
HELD = {"type": "area", "stiffness": 1.0}


@test
def garment_sections(report):
    """Stitches between pieces of several sections of one file are seams; those to pieces that nothing cuts are named."""
    square = {"vertices": [[0, 0], [20, 0], [20, 20], [0, 20]], "edges": [{"endpoints": [k, (k + 1) % 4]} for k in range(4)], "rotation": [0, 0, 0]}
    panels = {name: square | {"translation": [x, 0, 0]} for name, x in (("a", 0), ("b", 30), ("c", 60))}
    stitches = [[{"panel": p, "edge": 1}, {"panel": q, "edge": 3}] for p, q in (("a", "b"), ("b", "c"))]
    file = text_file("garment_sections.json", json.dumps({"pattern": {"panels": panels, "stitches": stitches},
                                                          "properties": {"curvature_coords": "relative", "units_in_meter": 100}}))

    def said(*sections):
        case = tube(panel=[{"file": file, "size": 0.05} | keys for keys in sections], seam=[], spring=[HELD])
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
def garment_grain(report):
    """A fabric lies along the grain line of its piece by whichever key its direction is given; all draw one strip alike."""
    file, grain = svg("garment_grain.svg", rectangle("strip", 0.1, 0.1)), [0.5, 0.75**0.5]
    fabric = {"type": "fabric", "fabric": "polyester_tropical"}
    case = {"analysis": "static", "support": [{"group": "strip/0", "type": "hinged"}, {"group": "strip/2", "type": "displacement", "components": ["z"]}],
            "load": [{"type": "line", "group": "strip/2", "vector": [1.0, 20.0, 0.0]}]}
    ends = {}
    for what, panel, keys in (("texture_direction", {"grain": grain}, {"texture_direction": [0, 1]}), ("direction", {"grain": grain}, {"direction": [0, 1, 0]}),
                              ("as drawn", {}, {"direction": [*grain, 0]}), ("across it", {}, {"direction": [0, 1, 0]})):
        result = solve("garment_grain", case | {"panel": [{"file": file, "size": 0.02} | panel], "material": [fabric | keys]})
        ends[what] = result.displacement()
    scale = np.abs(ends["texture_direction"]).max()
    for what in ("direction", "as drawn"):
        report.below(np.abs(ends[what] - ends["texture_direction"]).max() / scale, 1e-6, f"{what}: deflection like that of texture_direction")
    report.check(np.abs(ends["across it"] - ends["texture_direction"]).max() > 0.2 * scale, "another direction deflects otherwise")


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
    upright = tube()
    upright["material"] = [{k: v for k, v in m.items() if k != "texture_direction"} | {"direction": [0.342, 0, 0.94]} for m in upright["material"]]
    refused("a direction in space", upright, "material.direction", "[u, v, 0]")
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
    refused("an edge sewn twice", tube(seam=[{"edges": ["tube/1"], "to": ["tube/3"]}, {"edges": ["tube/3"], "to": ["tube/1"]}]), "tube/3 is sewn to tube/1 in a seam already", "remove one")
    ends = ["front/0..2"], ["back/0..2"]  # two edges each
    twice = [{"name": "one", "edges": ends[0], "to": ends[1]}, {"name": "two", "edges": ends[1], "to": ends[0]}]
    sheets = [{"file": tube()["panel"][0]["file"], "name": n, "translate": [0, y, 0]} for n, y in (("front", 0), ("back", 0.05))]
    refused("ranges sewn twice", tube(panel=sheets, seam=twice, spring=[]), "[[seam]] two", "back/0, back/1 are sewn to front/0, front/1 in a seam already", "[[seam]] one")
    twice[1] = {"name": "two", "edges": ["back/0"], "to": ends[0]}
    refused("a part of a range sewn twice", tube(panel=sheets, seam=twice, spring=[]), "'one' and 'two' sew", "remove one")
    refused("an allowance wider than the piece", tube(sewing={"allowance": 0.7}), "'side'", "piece 'tube'", "0.7 m")
    refused("an unknown edge", tube(seam=[{"edges": ["tube/7"], "to": ["tube/3"]}]), "tube/7", "no such edge")
    refused("one point in meet", tube(seam=[{"edges": ["tube/1"], "to": ["tube/3"], "meet": ["tube@1"]}]), "seam.meet", "two are needed")
    wrong = tube()
    wrong["stage"][0]["sew"] = ["sied"]
    refused("an unknown seam", wrong, "'sied'", "side")
    wrong = tube()
    wrong["stage"][1]["sew"] = ["all"]
    refused("sewing without time", wrong, "'rest' sew", "dynamic")
    # Two pieces through each other, and one through a body.
    two = [{"file": tube()["panel"][0]["file"], "name": n, "size": 0.03, "translate": [0, y, 0], "rotate": [0, 0, a]} for n, y, a in (("front", 0, 0), ("back", -0.1, 70))]
    refused("pieces through each other", tube(panel=two, seam=[], spring=[HELD], stage=[{"name": "rest", "analysis": "drape"}]), "panel 'front'", "panel 'back'", "intersects", ranks=2)
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


@test
def garment_hostile(report):
    """Patterns and bodies that go wrong in use: each ends with a message that tells what, where and what to do, or does no harm."""
    def says(what, code, case, *words):
        got, text = invoke(["check", write_case(case, OUT / "garment_hostile.toml")])
        text = " ".join(text.split())
        report.check(got == code and all(w in text for w in words), f"{what}: code {got}{'' if all(w in text for w in words) else ': ' + text[:300]}")

    def pattern(panels, stitches=()):
        return tube(panel=[{"file": code_file("garment_hostile.json", panels, stitches), "size": 0.05}], seam=[], spring=[HELD])

    says("a panel turned by two angles", 0, pattern({"a": panel_of(turned=(90, 45, 0))}), "'a' is turned about more than one axis", 'euler = "xyz"')
    says("an open loop", 2, pattern({"a": panel_of(edges=3)}), "'a'", "the outline is open", "vertex 3")
    says("a figure of eight", 2, pattern({"a": panel_of(((0, 0), (20, 20), (20, 0), (0, 20)))}), "edges 0 and 2", "near (0.1, 0.1) m")
    says("an outline that touches itself", 2, pattern({"a": panel_of(((0, 0), (10, 10), (20, 0), (20, 20), (10, 10), (0, 20)), 6)}), "near (0.1, 0.1) m")
    says("metres for centimetres", 2, pattern({"a": panel_of(((0, 0), (0.2, 0), (0.2, 0.2), (0, 0.2)))}), "0.002 m x 0.002 m", "unit")
    chain = {"a": panel_of(), "b": panel_of(at=(30, 0, 0)), "c": panel_of(at=(15, 0, -30), turned=(0, 180, 0))}
    ring = [[{"panel": p, "edge": 1}, {"panel": q, "edge": 3}] for p, q in (("a", "b"), ("b", "c"), ("c", "a"))]
    says("a ring of three", 0, pattern(chain, ring), "'c/1-a/3'")
    says("a ring with a twist", 2, pattern(chain, ring[:2] + [ring[2] + ["right_wrong"]]), "stitch 2", "with a twist")
    says("an edge in two seams", 2, pattern(chain, ring[:1] + [ring[0][::-1]]), "stitch 1", "is sewn to a/1 in a seam already", "divide the edge", "pleat")
    dart = svg("garment_tipless.svg", '<path id="piece" d="M 0 0 L 400 0 L 400 300 L 230 300 L 210 180 L 190 180 L 170 300 L 0 300 Z"/>')
    says("a dart without a tip", 2, tube(panel=[{"file": dart, "size": 0.025}], seam=[{"edges": ["piece/3"], "to": ["piece/5"]}], spring=[]), "[[seam]] number 1", "no common tip")
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
    clasped = short | {"attachment": [{"groups": [g], "obstacle": "body", "hard": True} for g in ("tube/1", "tube/3")]}
    result = run(write_case(clasped, OUT / "garment_clasped.toml"), fresh("garment_clasped"))
    report.check(result.code == 3 and "hold both of its sides there, by the groups 'tube/1' and 'tube/3'" in result.text, f"both sides attached: code {result.code}: {result.text[-200:]}")
    says("a spring from the start over a weld", 0, short | {"spring": [HELD]}, "stage 'rest' begins with welded seams", "[[spring]]")


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


@test
def garment_marks(report):
    """Buttons: named points of pieces are vertices there, in mirrored pieces too, and springs bring them together; wrong ones are named."""
    side = 0.2
    file = svg("garment_square.svg", rectangle("piece", side, side))
    piece = {"file": file, "size": 0.025}
    flat = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0.5]])

    def case(*marks, **changes):
        return {"panel": [piece | {"name": "a"}, piece | {"name": "b", "mirror": True, "translate": [0.25, 0, 0]}],
                "mark": list(marks),
                "material": [{"type": "matrices", "membrane": (1e3 * flat).tolist(), "bending": (1e-4 * flat).tolist(), "areal_density": 0.2}],
                "support": [{"type": "hinged", "group": g} for g in ("a/0", "b/0")],
                "stage": [{"name": "button", "analysis": "drape"}]} | changes

    button, hole = {"name": "button", "panel": "a", "at": [0.17, -0.13]}, {"name": "hole", "panel": "b", "at": [0.171, -0.131]}
    corner = {"name": "corner", "point": "b@2"}
    for ranks in (2,):
        spring = [{"type": "pair", "group": "button", "to": "hole", "stiffness": 50.0, "length": 0.0}]
        result = part(solve(f"garment_marks_{ranks}", case(button, hole, corner, spring=spring), ranks), "button")
        last = Results(result.folder)[-1]
        at = {name: last.mesh.group(name, 0) for name in ("button", "hole", "corner")}
        report.check(all(len(v) == 1 for v in at.values()), f"{ranks} rank(s): a vertex each: {at}")
        start = {name: last.mesh.positions[v[0]] for name, v in at.items()}
        report.near(np.abs(start["button"] - [0.17, 0, -0.13]).max(), 0, 1e-12, f"{ranks} rank(s): the button begins where it is drawn [m]")
        report.near(np.abs(start["hole"] - [0.25 - 0.171, 0, -0.131]).max(), 0, 1e-12, f"{ranks} rank(s): the hole of a mirrored piece [m]")
        away = np.linalg.norm(last.positions[at["button"][0]] - last.positions[at["hole"][0]])
        report.below(away, 0.02, f"{ranks} rank(s): from {np.linalg.norm(start['button'] - start['hole']):.3f} m apart to [m]")

    def refused(what, *words, marks):
        code, text = invoke(["check", write_case(case(*marks), OUT / "garment_marks_wrong.toml")], 2)
        report.check(code == 2 and all(w in text for w in words), f"{what}: code {code}: {' '.join(text.split())[:260]}")

    refused("outside", "[[mark]] 'button'", "outside of piece 'a'", "from [0, -0.2] to [0.2, 0]", marks=[button | {"at": [17, -13]}])
    refused("near an edge", "'button'", "too near for cells", marks=[button | {"at": [0.17, -0.001]}])
    refused("near another", "'button'", "mark 'other'", "too near", marks=[button | {"name": "other", "at": [0.171, -0.13]}, button])
    refused("not a number", "mark.at", "finite", marks=[button | {"at": [float("nan"), 0.1]}])
    refused("no such piece", "'button'", "there is no piece 'c'", marks=[button | {"panel": "c"}])
    refused("no such point", "'corner'", "points 0 to 3", marks=[corner | {"point": "b@9"}])
    refused("twice", "another mark has this name", marks=[button, button | {"at": [0.1, -0.1]}])
    refused("a name that is taken", "'a/0'", "choose another", marks=[button | {"name": "a/0"}])
    refused("both", "mark.point", marks=[button | {"point": "a@1"}])
    refused("neither", "mark.point", marks=[{"name": "button"}])
    refused("one number", "mark.at", "two numbers", marks=[button | {"at": [0.1]}])
