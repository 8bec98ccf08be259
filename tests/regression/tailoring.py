"""What tailors ask of seams: how hard they are to close, many at once, zippers, shrinkage, pieces by a point of their own, one size of a nest."""

import csv

import numpy as np
from common import fresh, pixels
from harness import OUT, solve, test
from pattern_files import CLOTH, HEIGHT, RADIUS, part, rectangle, svg, tube
from patterns import dxf
from picturing import draw
from results import Results
from solver import invoke, run, write_case

LENGTH, WIDTH, GAP = 0.1, 0.05, 0.004


def strips(**changes):
    """Two pairs of strips, held at their far ends, GAP apart where each is sewn to the other; of the second pair the right one is narrower."""
    file = svg("tailoring_strips.svg", *(rectangle(name, LENGTH, width) for name, width in (("left_a", WIDTH), ("right_a", WIDTH), ("left_b", WIDTH), ("right_b", 0.9 * WIDTH))))
    panel = {"file": file, "size": 0.0125}
    places = {"left_a": (0, 0), "right_a": (LENGTH + GAP, 0), "left_b": (0, 0.2), "right_b": (LENGTH + GAP, 0.2)}
    return {"panel": [panel | {"pieces": [name], "translate": [x, 0, z]} for name, (x, z) in places.items()],
            "seam": [{"name": "side *", "edges": ["left_*/1"], "to": ["right_*/3"], "meet": ["left_*@1", "right_*@0"], "gather": "never"}],
            "material": [CLOTH], "sewing": {"speed": 0.02},
            "support": [{"type": "hinged", "group": ["left_a/3", "left_b/3", "right_a/1", "right_b/1"]}],
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["side *"], "time": {"end": 0.8, "step": 0.02}, "damping": {"mass": 200.0}}]} | changes


def seams_of(result):
    with open(result.folder / "sew" / "seams.csv", newline="") as file:
        return {row["seam"]: row for row in csv.DictReader(file)}


@test
def seam_report(report):
    """Strips that must be stretched by 2 % each to meet: seams.csv has the force of the closed form, lengths, ease and the widest place, on 1 and 2 ranks."""
    s = 1 + GAP / 2 / LENGTH
    force = s * 1e3 * (s**2 - 1) / 2  # N/m, as of a sheet of 1 MPa and 1 mm in one direction
    for ranks in (1, 2):
        result = solve(f"seam_report_{ranks}", strips(), ranks)
        seams, what = seams_of(result), f"{ranks} rank(s)"
        report.check(sorted(seams) == ["side a", "side b"], f"{what}: {sorted(seams)}")
        a, b = seams["side a"], seams["side b"]
        report.percent(float(a["mean_pull"]) / force, 0.03, f"{what}: pull, {force:.2f} N/m")
        report.percent(float(a["pull_at_end"]) / force, 0.03, f"{what}: and at the end")
        report.near(float(a["ease_percent"]), 0, 1e-9, f"{what}: no ease")
        report.near(float(b["ease_percent"]), 100 / 9, 1e-9, f"{what}: ease [%]")
        report.near(float(b["length_2"]), 0.9 * WIDTH, 1e-12, f"{what}: length [m]")
        report.check((b["edge_1"], b["edge_2"]) == ("left_b/1", "right_b/3"), f"{what}: between {b['edge_1']} and {b['edge_2']}")
        report.near(max(float(r["gap"]) for r in seams.values()), part(result, "sew").history["seam_gap"][-1], 1e-15, f"{what}: gap as in history.csv [m]")
        report.check(result.text.count("pulled with up to") == 2 and "(+11.1 %)" in result.text, f"{what}: and the log has them")
    early = strips()
    early["stage"][0]["time"]["end"] = 0.1
    (OUT / "seam_report_open").mkdir(exist_ok=True)
    result = run(write_case(early, OUT / "seam_report_open.toml"), OUT / "seam_report_open", 1, ["--overwrite"])
    report.check(result.code == 3 and float(seams_of(result)["side a"]["gap"]) > 1e-3, f"a stage that ends too early: code {result.code}, {seams_of(result)['side a']['gap']} m")
    worst, reds = max(seams_of(result).items(), key=lambda item: float(item[1]["gap"]))[0], []
    for words in ((), ("--seams",)):
        code, text = draw("render", result.folder, "--output", OUT / "seam_report.png", "--size", "240x180", "--quality", "draft", *words)
        red, green, blue = pixels(OUT / "seam_report.png")[..., :3].transpose(2, 0, 1)
        reds.append(int(((red > 0.6) & (green < 0.35) & (blue < 0.35)).sum()))
    report.check(code == 0 and reds[0] == 0 and reds[1] > 20, f"render --seams: red pixels without and with it: {reds}; widest open is {worst}")
    code, text = draw("render", OUT / "seam_report_1" / "no", "--seams")
    report.check(code == 2, f"render --seams without a run: {text.strip()[:100]}")


def layered(**changes):
    """A strip that hangs between the two layers of a band, 4 mm apart; the inner layer is 5 % longer, and finer."""
    file = svg("tailoring_layers.svg", rectangle("skirt", LENGTH, 0.06), rectangle("outer", LENGTH, 0.03), rectangle("inner", 1.05 * LENGTH, 0.03))
    panel = lambda name, size, x, y, z: {"file": file, "pieces": [name], "size": size, "translate": [x, y, z]}  # noqa: E731
    return {"panel": [panel("skirt", 0.0125, 0, 0, 0), panel("outer", 0.0125, 0, -0.004, 0.0325), panel("inner", 0.01, -0.025 * LENGTH, 0.004, 0.0325)],
            "seam": [{"name": "out", "edges": ["skirt/0"], "to": ["outer/2"], "meet": ["skirt@0", "outer@3"]},
                     {"name": "in", "edges": ["skirt/0"], "to": ["inner/2"], "meet": ["skirt@0", "inner@3"]}],
            "material": [CLOTH], "sewing": {"speed": 0.05, "allowance": 0.004}, "contact": {"distance": 0.0015},
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "support": [{"type": "hinged", "group": ["outer/0", "inner/0"]}],
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.3, "step": 0.02}, "damping": {"mass": 100.0}},
                      {"name": "hang", "analysis": "dynamic", "time": {"end": 0.34, "step": 0.01, "checkpoint_steps": 2}, "damping": {"mass": 20.0}}]} | changes


@test
def three_layers(report):
    """A strip sewn between two layers: one line of three sheets, on 1 and 2 ranks, and after a restart."""
    mass = []
    for ranks in (1, 2):
        result, what = solve(f"three_layers_{ranks}", layered(), ranks), f"{ranks} rank(s)"
        seams = seams_of(result)
        report.check(sorted(seams) == ["in", "out"] and max(float(r["gap"]) for r in seams.values()) < 1e-4, f"{what}: both pairs are closed: {[r['gap'] for r in seams.values()]} m")
        report.check((seams["in"]["edge_1"], seams["in"]["edge_2"]) == ("skirt/0", "inner/2"), f"{what}: {seams['in']['edge_1']} to {seams['in']['edge_2']}")
        report.check("edge skirt/0 is in 2 seams, 'out', 'in': 3 layers or more meet there" in result.text, f"{what}: a note says so")
        last, first = Results(part(result, "hang").folder)[-1], Results(part(result, "sew").folder)[0]
        lines = [set(last.mesh.group(name)) for name in ("skirt/0", "outer/2", "inner/2")]
        report.check(lines[0] == lines[1] == lines[2] and len(lines[0]) > 8, f"{what}: {[len(x) for x in lines]} vertices, the same of all three")
        report.check(len(first.positions) - len(last.positions) == 2 * len(lines[0]), f"{what}: two of three vertices are gone at each")
        hang = part(result, "hang").history
        report.check(max(h["intersections"].max() for h in (part(result, "sew").history, hang)) == 0, f"{what}: nothing intersects")
        lower = last.positions[last.mesh.group("skirt/2")]
        report.check(lower[:, 2].max() < last.positions[list(lines[0]), 2].min() - 0.055, f"{what}: the strip hangs")
        mass.append([part(result, stage).summary["garment"] for stage in ("sew", "hang")])
    weights = [[p["mass"] for p in g["panels"]] for g in mass[0]]
    report.below(np.abs(np.subtract(*weights)).max(), 1e-15, f"a weld leaves what pieces weigh with one allowance each: {weights[0]} kg")
    whole = part(result, "hang")
    folder = fresh("three_layers_rest")
    half = layered()
    half["stage"][1]["time"]["end"] = 0.32
    solve("three_layers_half", half, 2)
    rest = run(OUT / "three_layers_2.toml", folder, 2, ["--from", "hang", "--restart", OUT / "three_layers_half" / "hang" / "checkpoint.h5"])
    report.check(rest.code == 0, f"a restart: code {rest.code}")
    report.below(np.abs(Results(folder / "hang")[-1].positions - Results(whole.folder)[-1].positions).max(), 1e-8, "and ends at the same place [m]")


@test
def three_layers_turned(report):
    """An inner layer whose right side is inside, and which is welded before the outer one: one line, nothing intersects."""
    turned = layered()
    turned["panel"][2] |= {"rotate": [0, 0, 180], "translate": [1.025 * LENGTH, 0.004, 0.0325]}
    turned["seam"][1]["meet"] = ["skirt@0", "inner@2"]
    sew = turned["stage"][0]
    turned["stage"] = [sew | {"name": "inside", "sew": ["in"]}, sew | {"name": "sew", "sew": ["out"], "time": {"end": 0.6, "step": 0.02}}, {"name": "hang", "analysis": "dynamic", "time": {"end": 0.62, "step": 0.01}}]
    result = solve("three_layers_turned", turned)
    last = Results(result.folder / "hang")[-1]
    lines = [set(last.mesh.group(name)) for name in ("skirt/0", "outer/2", "inner/2")]
    report.check(lines[0] == lines[1] == lines[2] and part(result, "hang").history["intersections"].max() == 0, "one line, nothing intersects")


@test
def patch_pocket(report):
    """A pocket is sewn on three sides to a front, which is cut there and filled by a patch: three layers round its corners, two at its opening."""
    front = '<path id="front" d="M 0 0 L 300 0 L 300 300 L 0 300 Z M 100 100 L 200 100 L 200 200 L 100 200 Z"/>'
    file = svg("tailoring_pocket.svg", front, rectangle("patch", 0.1, 0.1), rectangle("pocket", 0.1, 0.1))
    panel = lambda name, x, z, layer: {"file": file, "pieces": [name], "size": 0.025, "translate": [x, 0, z], "layer": layer}  # noqa: E731
    case = {"panel": [panel("front", 0, 0, 0), panel("patch", 0.1, -0.1, 0), panel("pocket", 0.1, -0.1, 1)],
            "seam": [{"name": "ground", "edges": ["front/4..7", "front/7"], "to": ["patch/0..3", "patch/3"], "meet": ["front@4", "patch@0"]},
                     {"name": "pocket", "edges": ["front/5..4"], "to": ["pocket/1..0"], "meet": ["front@5", "pocket@1"]}],
            "material": [{"type": "fabric", "fabric": "wool_tropical", "texture_direction": [0, 1]}], "contact": {"distance": 1e-3},
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "support": [{"type": "hinged", "group": "front/0"}],
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.4, "step": 0.02}, "damping": {"mass": 20.0}},
                      {"name": "hang", "analysis": "dynamic", "time": {"end": 0.5, "step": 0.02}, "damping": {"mass": 10.0}}]}
    result = solve("patch_pocket", case, 2)
    last = Results(result.folder / "hang")[-1]
    lines = {name: set().union(*(last.mesh.group(f"{name}/{k}") for k in edges)) for name, edges in (("front", (5, 6, 7)), ("patch", (1, 2, 3)), ("pocket", (1, 2, 3)))}
    report.check(lines["front"] == lines["patch"] == lines["pocket"], f"one line of {len(lines['front'])} vertices")
    opening = set(last.mesh.group("pocket/0")) & set(last.mesh.group("patch/0"))
    report.check(set(last.mesh.group("front/4")) == set(last.mesh.group("patch/0")) and len(opening) == 2, "the pocket is open above, the patch is not")
    report.check(max(part(result, s).history["intersections"].max() for s in ("sew", "hang")) == 0, "nothing intersects")


@test
def three_layers_mistakes(report):
    """What seams of three layers cannot have ends with code 2, the file and a remedy."""
    def refused(what, case, *words):
        code, text = invoke(["check", write_case(case, OUT / "three_layers_wrong.toml")])
        report.check(code == 2 and all(w in " ".join(text.split()) for w in words), f"{what}: code {code}: {' '.join(text.split())[-250:]}")

    out, inside = layered()["seam"]
    refused("an edge sewn to itself", layered(seam=[out, inside | {"to": ["skirt/0"]}]), "[[seam]] in", "skirt/0 is in it twice", "name another edge")
    refused("a pair twice", layered(seam=[out, inside, inside | {"name": "again", "edges": ["inner/2"], "to": ["skirt/0"], "meet": ["inner@3", "skirt@0"]}]), "[[seam]] again", "inner/2 is sewn to skirt/0 in a seam already", "[[seam]] in", "remove one")
    refused("a circle", layered(seam=[out, inside, {"edges": ["outer/2"], "to": ["inner/2"], "meet": ["outer@3", "inner@3"]}]), "[[seam]] number 3", "twice along one line", "remove this seam")
    refused("another mesh", layered(remesh={"smallest": 0.005}), "[remesh]", "skirt/0", "'out' and 'in'", "remove the section")
    refused("two allowances", layered(seam=[out, inside | {"allowance": 0.01}]), "[[seam]] allowance", "skirt/0", "give both seams the same")
    refused("two factors of bending", layered(seam=[out, inside | {"bending": 0.5}]), "[[seam]] bending", "skirt/0", "give both seams the same")
    code, text = invoke(["check", write_case(layered(), OUT / "three_layers_good.toml")])
    report.check(code == 0 and "'out': 0.1 m to 0.1 m" in text and "'in': 0.1 m to 0.105 m" in text, f"check lists both pairs: code {code}: {text[-600:] if code else ''}")


def dressed(layer, **changes):
    """A shirt and a jacket drawn alike: a tube round the body, and a flat front over it, each at the same place twice."""
    file = svg("tailoring_layer.svg", rectangle("shirt", 0.6, 0.1), rectangle("jacket", 0.6, 0.1), rectangle("pocket", 0.1, 0.1), rectangle("flap", 0.1, 0.1))
    worn = lambda name, layer, size: {"file": file, "pieces": [name], "size": size, "wrap_axis": [0, 0, 1], "translate": [-0.3, -0.1, 0]} | ({"layer": layer} if layer else {})  # noqa: E731
    flat = lambda name, layer: {"file": file, "pieces": [name], "size": 0.04, "translate": [0, -0.3, 0]} | ({"layer": layer} if layer else {})  # noqa: E731
    return {"panel": [worn("shirt", 0, 0.04), worn("jacket", layer, 0.033), flat("pocket", 0), flat("flap", 2 * layer)],
            "material": [CLOTH], "contact": {"distance": 1e-3, "thickness": 5e-4},
            "stage": [{"name": "move", "analysis": "dynamic", "time": {"end": 0.02, "step": 0.01}}]} | changes


@test
def layers_of_clothes(report):
    """`layer` starts a piece outside those at the same place, bent or flat, so that nothing intersects and nothing is pushed; without it they lie in each other."""
    code, text = invoke(["check", write_case(dressed(0), OUT / "layers_none.toml")])
    report.check(code == 2, f"without layers: code {code}: {' '.join(text.split())[:200]}")
    result = solve("layers_of_clothes", dressed(1))
    first = Results(part(result, "move").folder)[0]
    place = lambda name: np.concatenate([first.positions[first.mesh.group(f"{name}/{k}")] for k in range(4)])  # noqa: E731
    radius = {name: np.linalg.norm(place(name)[:, :2], axis=1) for name in ("shirt", "jacket")}
    report.near(radius["shirt"].max(), 0.1, 1e-12, "the shirt keeps its radius [m]")
    gap = 1.5e-3 + (1.5 * 0.04) ** 2 / (8 * 0.1)
    report.below(np.ptp(radius["jacket"]), 1e-12, "the jacket is round [m]")
    report.near(radius["jacket"].mean(), 0.1 + gap, 1e-12, "and lies outside by contact and what cells cut off [m]")
    report.near(place("pocket")[:, 1].mean() - place("flap")[:, 1].mean(), 2 * 1.5e-3, 1e-12, "layer 2 of flat pieces is two steps to the right side [m]")
    history = part(result, "move").history
    report.check(history["intersections"].max() == 0, "nothing intersects")
    report.check(history["contact_pairs"][0] == 0, "and nothing pushes at the start")
    code, text = invoke(["check", write_case(dressed(1, contact={"self": False}), OUT / "layers_wrong.toml")])
    report.check(code == 2 and "layer" in text and "add [contact]" in text, f"without contact: code {code}")


@test
def seam_that_hangs(report):
    """A piece hangs on its seam, with the default tolerance: the springs carry its weight and do not pull by turns."""
    file = svg("tailoring_hangs.svg", rectangle("a", 0.1, 0.08), rectangle("b", 0.1, 0.12))
    case = {"panel": [{"file": file, "size": 0.004, "pieces": [name], "translate": [0, 0, z]} for name, z in (("a", 0.084 + 0.04), ("b", 0))],
            "seam": [{"name": "s", "edges": ["a/0"], "to": ["b/2"], "meet": ["a@0", "b@3"]}],
            "material": [{"type": "fabric", "fabric": "wool_tropical", "texture_direction": [0, 1]}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "support": [{"type": "hinged", "group": "a/2"}],
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["s"], "time": {"end": 1.0, "step": 0.01}, "damping": {"mass": 20.0}}]}
    result = solve("seam_that_hangs", case)
    weight = 0.12 * 9.81 * 0.1629
    report.percent(float(seams_of(result)["s"]["pull_at_end"]) / weight, 0.005, f"its pull, {weight:.4g} N/m")


@test
def zipper(report):
    """A slider of 0.1 m/s closes a seam of 0.05 m from the upper end on; its pairs close one after the other."""
    case = strips()
    case["seam"][0]["zip_speed"] = 0.1
    case["stage"][0]["time"]["end"] = 1.3
    result = solve("zipper", case)
    moments = Results(result.folder / "sew")
    mesh = moments[0].mesh
    left, right = mesh.group("left_a/1"), mesh.group("right_a/3")
    height = lambda moment, group: moment.positions[group, 2]  # noqa: E731
    left, right = (g[np.argsort(height(moments[0], g))] for g in (left, right))
    gap = np.array([np.linalg.norm(m.positions[left] - m.positions[right], axis=1) for m in moments])
    times = np.array([m.time for m in moments])
    half = gap[np.argmin(np.abs(times - 0.3))]
    report.check(half[0] > half[len(half) // 2] > half[-1], f"at 0.3 s the seam is wider below: {1e3 * half} mm")
    report.check(half[0] > GAP and half[-1] < 0.1 * GAP, "it is open yet at its lower end, which the slider reaches after 0.5 s, and closed above")
    report.below(gap[-1].max(), 1e-4, "closed at the end [m]")
    # The same on meshes that get finer, from a checkpoint amid it.
    case |= {"remesh": {"smallest": 0.004, "size": "0.008"}}
    whole = solve("zipper_remeshed", case)
    report.check(part(whole, "sew").summary["remeshing"]["count"] > 0, "remeshed on the way")
    row = seams_of(whole)["side a"]
    report.check(all(abs(float(row[k]) - WIDTH) < 1e-9 for k in ("length_1", "length_2")) and (row["edge_1"], row["edge_2"]) == ("left_a/1", "right_a/3"),
                 f"lengths {row['length_1']} and {row['length_2']} m, from {row['edge_1']} to {row['edge_2']}")
    slow = strips()
    slow["seam"][0]["zip_speed"] = 1e-3
    result = run(write_case(slow, OUT / "zipper_slow.toml"), fresh("zipper_slow"))
    report.check(result.code == 3 and "a zipper is closed at t = " in result.text, f"a zipper that is too slow: code {result.code}")
    run(OUT / "zipper_remeshed.toml", fresh("zipper_half"), 1, ["-ts_max_steps", "20"])
    rest = run(OUT / "zipper_remeshed.toml", fresh("zipper_rest"), 2, ["--from", "sew", "--restart", OUT / "zipper_half" / "sew" / "checkpoint.h5"])
    ends = [part(r, "sew").history["seam_gap"] for r in (whole, rest)]
    report.check(rest.code == 0 and len(ends[1]) < len(ends[0]), f"and continued on 2 ranks: code {rest.code}")
    report.below(max(e[-1] for e in ends), 1e-4, "closed at the end [m]")
    middle = [np.interp(0.5, part(r, "sew").history["time"], part(r, "sew").history["seam_gap"]) for r in (whole, rest)]
    report.near(middle[1], middle[0], 0.02 * GAP, "as wide at 0.5 s as in the unbroken run [m]")
    for wrong, says in (({"meet": []}, "meet"), ({"zip_speed": -1}, "must be >= 0")):
        bad = strips()
        bad["seam"][0] |= {"zip_speed": 0.1} | wrong
        if not bad["seam"][0]["meet"]:
            del bad["seam"][0]["meet"]
        code, text = invoke(["check", write_case(bad, OUT / "zipper_wrong.toml")])
        report.check(code == 2 and says in text and "seam" in text, f"{wrong}: code {code}, {text.strip()[-160:]}")


@test
def seams_by_star(report):
    """What a * and a list of groups cannot mean is said."""
    for change, says in (({"seam": [{"edges": ["cuff_*/1"], "to": ["right_*/3"]}]}, "'cuff_*/1': no piece matches"),
                         ({"seam": [{"edges": ["left_*/1"], "to": ["right_a/3"]}]}, "to: there is no * in it"),
                         ({"seam": [{"edges": ["*_a/1"], "to": ["right_*/3"]}]}, "stands for left, right"),
                         ({"support": [{"type": "hinged", "group": ["left_a/3", "left_c/3"]}]}, '[[support]] group = "left_c/3"'),
                         ({"support": [{"type": "hinged", "group": ["left_a/3", "left_a"]}]}, "'left_a/3' is a curve and 'left_a' a surface"),
                         ({"support": [{"type": "hinged", "group": []}]}, "the list is empty")):
        code, text = invoke(["check", write_case(strips(**change), OUT / "star_wrong.toml")])
        report.check(code == 2 and says in text, f"{change}: code {code}, {text.strip()[-200:] if says not in text else 'told'}")


@test
def shrunk_tube(report):
    """A tube whose fabric shrinks by 4 % round it and 6 % along it, while it is sewn and hangs, with and without remeshing."""
    cloth = CLOTH | {"initial_strain": [-0.04, -0.06], "texture_direction": [1, 0]}
    hold = {"spring": [{"type": "line", "group": "tube/0", "stiffness": 1e-3}]}
    for name, more in (("plain", {}), ("remeshed", {"remesh": {"smallest": 0.012, "largest": 0.02, "angle": 12}})):
        result = solve(f"shrunk_tube_{name}", tube(material=[cloth]) | hold | more)
        place = Results(result.folder / "rest")[-1].positions
        # The circle through all of them: 2 c x + (r^2 - c^2) = x^2. Their mean is not its centre.
        (*centre, rest), *_ = np.linalg.lstsq(np.column_stack([2 * place[:, :2], np.ones(len(place))]), (place[:, :2]**2).sum(axis=1), rcond=None)
        report.percent(np.sqrt(rest + np.dot(centre, centre)) / (0.96 * RADIUS), 0.005, f"{name}: radius")
        report.percent(np.ptp(place[:, 2]) / (0.94 * HEIGHT), 0.005, f"{name}: height")


@test
def anchored_piece(report):
    """The point of a piece that `anchor` names comes to origin + translate, turned as it is, in a panel of two pieces and with a shift along the axis."""
    file = svg("tailoring_anchor.svg", rectangle("left_a", LENGTH, WIDTH), rectangle("right_a", LENGTH, WIDTH))
    still = {"material": [CLOTH], "stage": [{"name": "still", "analysis": "dynamic", "time": {"end": 1e-6, "step": 1e-6}}]}
    panel = {"file": file, "size": 0.02, "rotate": [0, 0, 90], "origin": [1, 2, 3], "translate": [0, 0, 0.5]}
    for name, more, target in (("flat", {}, [1, 2, 3.5]), ("bent", {"wrap_axis": [0, 0, 1], "wrap_point": [0.7, 2, 0], "wrap_shift": 0.2}, [1, 2, 3.7])):
        case = still | {"panel": [panel | more | {"pieces": ["left_a"], "anchor": "left_a@2"}]}
        mesh = Results(solve(f"anchor_{name}", case).folder / "still")[0]
        corner = set(mesh.mesh.group("left_a/1")) & set(mesh.mesh.group("left_a/2"))
        report.below(np.abs(mesh.positions[corner.pop()] - target).max(), 1e-9, f"{name}: the corner is at {target} [m]")
    for anchor, says in (("left_a@9", "the piece has points 0 to 3"), ("sleeve@1", "there is no piece 'sleeve'"), ("left_a", "PIECE@POINT")):
        code, text = invoke(["check", write_case(still | {"panel": [panel | {"pieces": ["left_a"], "anchor": anchor}]}, OUT / "anchor_wrong.toml")])
        report.check(code == 2 and says in text and "anchor" in text, f"anchor = {anchor}: code {code}, {text.strip()[-160:]}")


@test
def nest_of_sizes(report):
    """One size of a nest, by its texts; and a size that it has not."""
    square = lambda w: [("1", True, [(0, 0), (w, 0), (w, 100), (0, 100)])]  # noqa: E731
    file = dxf("tailoring_nest.dxf", {f"*U{size}": square(2 * size + 100) for size in (36, 38, 40)})
    lines = open(file).read().split("\n")
    for size in (36, 38, 40):
        at = lines.index(f"*U{size}") + 1
        lines[at:at] = [line for text in ("Piece Name: FRONT", f"Size: {size}") for line in ("  0", "TEXT", "  8", "1", "  1", text)]
    open(file, "w").write("\n".join(lines))
    case = {"panel": [{"file": file, "size": 0.05, "nest_size": "38", "pieces": ["FRONT"]}], "material": [CLOTH],
            "stage": [{"name": "still", "analysis": "dynamic"}]}
    code, text = invoke(["check", write_case(case, OUT / "nest.toml")])
    report.check(code == 0 and "'FRONT': 0.0176 m^2" in text, f"size 38: code {code}")
    lines[lines.index("Size: 40") - 5: lines.index("Size: 40") + 1] = []
    open(file, "w").write("\n".join(lines))
    code, text = invoke(["check", write_case({**case, "panel": [{"file": file, "size": 0.05, "nest_size": "38"}]}, OUT / "nest.toml")])
    report.check(code == 0 and "0.0176 m^2" in text and "0.018 m^2" in text, f"a piece without a size is of all of them: code {code}, {text[-300:]}")
    case["panel"][0]["nest_size"] = "42"
    code, text = invoke(["check", write_case(case, OUT / "nest.toml")])
    report.check(code == 2 and "there are 36, 38" in text, f"size 42: code {code}, {text.strip()[-120:]}")


def pleated():
    """A strip with a knife pleat in its waist, sewn to a band: points A, B, C and D of the waist, the way A to B folds under, B to C back, and C to D lies over both.
    Supports fold it: while C comes to A, B swings out behind, and back on the same arc to D."""
    visible, under, height = 0.06, 0.03, 0.10
    waist = [0, visible, visible + under, visible + 2 * under, visible + 3 * under, 2 * visible + 2 * under]
    outline = [(x, 0) for x in waist] + [(waist[-1], height), (0, height)]
    path = lambda name, points: f'<path id="{name}" d="M {" L ".join(f"{1000 * x:.6g} {1000 * y:.6g}" for x, y in points)} Z"/>'  # noqa: E731
    band = [(0, 0), (2 * visible, 0), (2 * visible, 0.03), (0, 0.03)]
    out, back = "pi/180*table(t, 0, 0, 0.2, 90)", "pi/180*table(t, 0, 0, 0.2, 90, 0.4, 5)"
    held = {"type": "displacement", "components": ["x", "y", "z"], "stages": ["fold"]}
    stage = {"analysis": "dynamic", "damping": {"mass": 10.0}}
    return {"panel": [{"file": svg("tailoring_pleat.svg", path("skirt", outline)), "size": 0.0075},
                      {"file": svg("tailoring_band.svg", path("band", band)), "size": 0.0075, "translate": [under, 0, 0.045]}],
            "seam": [{"name": "pleat", "edges": ["skirt/1"], "to": ["skirt/2"], "bending": 0},
                     {"name": "waist", "edges": ["band/2"], "to": ["skirt/0", "skirt/3", "skirt/4"], "meet": ["band@3", "skirt@0"]}],
            "mark": [{"name": "B", "point": "skirt@2"}, {"name": "D", "point": "skirt@4"}],
            "spring": [{"type": "pair", "group": "B", "to": "D", "length": 1.5e-3, "stiffness": 200, "stages": ["close"]}],
            "material": [{"type": "fabric", "fabric": "wool_tropical", "texture_direction": [0, 1]}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81], "stages": ["close"]}],
            "contact": {"distance": 1e-3, "friction": 0.1},
            "support": [{"type": "displacement", "group": "band/0", "components": ["y", "z"]}, {"type": "displacement", "group": "band/3", "components": ["x"]},
                        held | {"group": "skirt/0"}, held | {"group": ["skirt/3", "skirt/4"], "motion": [f"{2 * under}*(cos({out}) - 1)", "0", "0"]},
                        held | {"group": "B", "motion": [f"{under}*(cos({back}) - 1)", f"{under}*sin({back})", "0"]}],
            "stage": [stage | {"name": "fold", "sew": ["pleat"], "time": {"end": 0.4, "step": 5e-3}}, stage | {"name": "close", "sew": ["waist"], "time": {"end": 0.8, "step": 5e-3}}]}


@test
def knife_pleat(report):
    """Supports fold a pleat, its point lies at the waist, the waist closes over it, and nothing intersects."""
    result = solve("knife_pleat", pleated())
    moment, history = Results(result.folder / "close")[-1], part(result, "close").history
    place = lambda group: moment.positions[moment.mesh.group(group)]  # noqa: E731
    report.check(history["intersections"].max() == 0, "nothing intersects")
    report.below(np.linalg.norm(place("B") - place("D")), 3e-3, "the point of the pleat is at the waist [m]")
    report.check(place("skirt/1")[:, 1].mean() > place("skirt/3")[:, 1].mean(), "what is folded lies behind")
    ends = [np.linalg.norm(place("skirt/0")[:, None] - place("skirt/3")[None], axis=2).min()]
    report.below(ends[0], 1e-4, "and the visible parts meet [m]")
    report.below(history["seam_gap"][-1], 1e-4, "all seams are closed [m]")
