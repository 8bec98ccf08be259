"""Garments from pieces of a pattern: placed, sewn, welded, worn."""

import copy
import json
import shutil
import signal
import tomllib

import numpy as np
from common import fresh, started, wait_for
from harness import OUT, solve, test
from pattern_files import CLOTH, HEIGHT, RADIUS, part, rectangle, svg, text_file, tube
from results import Results
from solver import ROOT, invoke, run, write_case


def masses(moment):
    """Of the vertices, up to the areal density, from the rest corners that are stored with the mesh."""
    rest = moment.mesh.rest
    mass = np.zeros(len(moment.mesh.positions))
    np.add.at(mass, moment.mesh.triangles.ravel(), np.repeat(np.linalg.norm(np.cross(rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]), axis=1) / 6, 3))
    return mass


@test
def garment_tube(report):
    """A flat sheet sewn into a tube has the energy of a cylinder, and no seam to be seen, on 1 and 3 ranks."""
    bending = np.pi * HEIGHT / RADIUS * 1e6 * 1e-3**3 / 12
    for ranks in (1, 3):
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


def sheet_file(name, cells, reach, unit):
    """An OBJ of a sheet, bent to a cylinder that it does not close; vertices of its upper end are stitched between two of its other one."""
    around, up = cells
    lines, width = [], 2 * np.pi * RADIUS
    for i in range(around + 1):
        for j in range(up + 1):
            # Rows of the two ends lie at different heights, so that no stitch joins two vertices.
            f, z = i / around, (j / up) ** (1 + 0.3 * i / around)
            angle, r = reach * 2 * np.pi * (f - 0.5), RADIUS / reach
            lines += [f"v {r * np.sin(angle):.12g} {HEIGHT * z:.12g} {-r * np.cos(angle):.12g}", f"vt {width * f / unit:.12g} {HEIGHT * z / unit:.12g}"]
    corner = lambda i, j: (lambda v: f"{v}/{v}")(i * (up + 1) + j + 1)  # noqa: E731
    lines += ["f {} {} {} {}".format(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)) for i in range(around) for j in range(up)]
    last = around * (up + 1)
    for j in range(up + 1):
        z = (j / up) ** 1.3
        k = min(int(z * up), up - 1)
        lines.append(f"stitch {last + j} {k} {k + 1} {z * up - k:.12g}")
    return text_file(name, "\n".join(lines) + "\n")


@test
def garment_obj(report):
    """The sheet as an OBJ with texture coordinates and lines 'stitch', bent where it lies: the tube again; and what is not possible with it."""
    bending = np.pi * HEIGHT / RADIUS * 1e6 * 1e-3**3 / 12
    file = sheet_file("garment_sheet.obj", (40, 9), 0.95, 0.001)
    keys = {"file": file, "size": 0.015, "name": "tube"}
    change = {"panel": [keys], "seam": [], "spring": [{"type": "point", "group": "tube/3", "stiffness": 1e-4}]}
    for ranks in (1, 2):
        result = solve(f"garment_obj_{ranks}", tube(**change), ranks)
        report.check("1 in texture coordinates (vt) is taken for 0.001 m" in result.text, f"{ranks} rank(s): the unit is told")
        gap = part(result, "sew").history["seam_gap"]
        report.check(0.02 < gap[0] < 0.04, f"{ranks} rank(s): the seam starts {gap[0]:.4f} m apart")
        report.below(gap[-1], 1e-4, f"{ranks} rank(s): and is welded from [m]")
        h = part(result, "rest").history
        report.percent(h["energy_bending"][-1] / bending, 0.005, f"{ranks} rank(s): bending energy")
    for text, more in (("is bent already", {"wrap_axis": [0, 0, 1]}), ("mirror: piece 'piece' is bent", {"mirror": True}), ("unfold: it is bent", {"unfold": "0"}),
                       ("no piece 'front': valid: piece", {"pieces": ["front"]}), ("the length of a unit must be wrong", {"texture_unit": 1.0}),
                       ("only an .obj has texture coordinates", {"file": svg("garment_tube.svg", rectangle("tube", 0.4, 0.2)), "texture_unit": 0.01})):
        code, said = invoke(["check", write_case(tube(**change | {"panel": [keys | more]}), OUT / "garment_obj_wrong.toml")])
        report.check(code == 2 and text in said, f"{more}: code {code}, {said.strip()[-200:] if text not in said else 'told'}")


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
    """A run continues from a checkpoint amid sewing, killed in the weld, from the stage after it, and from within that stage."""
    case = tube()
    fixed = {"step": 0.01, "max_step": 0.01, "target_iterations": 1000, "velocity_tolerance": 0.0}  # so that the runs take the same steps
    case["stage"][0]["time"] |= {"end": 0.16} | fixed
    # Steps of 0.01 have two solutions here, and which is found depends on the number of ranks.
    case["stage"][1] = {"name": "move", "analysis": "dynamic", "time": {"end": 0.2} | fixed | {"step": 0.005, "max_step": 0.005}}
    case["spring"] = [{"type": "band", "group": "tube/0", "length": 0.8 * 2 * np.pi * RADIUS, "stiffness": 0.5, "stages": ["move"]}]
    case["initial_velocity"] = [{"velocity": [0.3, 0.2, 0.1]}]
    case["stage"][0]["damping"] = {"membrane": 0.01}
    whole = solve("garment_whole", case, 2)
    end = part(whole, "move").displacement()
    h = part(whole, "move").history
    report.check(h["remeshing_gain"][0] < -0.5 * h["stored_energy"][0], f"the welded seam unfolds before it moves: {h['remeshing_gain'][0]:.3g} J")
    report.below(np.abs(h["energy_unaccounted"]).max(), 1e-4 * h["stored_energy"][0], "what that sets free is accounted for, unaccounted [J]")
    report.check(h["work_of_supports"][-1] > 0, f"a band gets shorter from the start of its stage: {h['work_of_supports'][-1]:.3g} J")
    half = copy.deepcopy(case)
    half["spring"] = []
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
    folder = fresh("garment_killed")
    process = started(OUT / "garment_whole.toml", folder)
    wait_for(lambda: (folder / "move").exists(), process)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    amid = (folder / "sew" / "checkpoint.h5").exists() and not (folder / "move" / "checkpoint.h5").exists()
    report.check(amid, "killed in the weld, after the last checkpoint of sew and before the first of move")
    again = run(OUT / "garment_whole.toml", folder, 1, ["--from", "move"])
    report.check(again.code == 0, f"--from move in its folder: code {again.code}")
    report.below(np.abs(part(again, "move").displacement() - end).max(), 1e-7, "to the same end [m]")
    folder = OUT / "garment_within"
    shutil.rmtree(folder, ignore_errors=True)
    within = run(OUT / "garment_whole.toml", folder, 2, ["--from", "move", "--restart", whole.folder / "move" / "results.vtkhdf", "--restart-step", "2"])
    report.check(within.code == 0, f"from the results within move, whose mesh is welded: code {within.code}")
    before, after = Results(whole.folder / "sew")[-1], Results(whole.folder / "move")[0]
    momentum = [(masses(m)[:, None] * m["velocity"]).sum(axis=0) for m in (before, after)]
    report.below(masses(after).sum() / masses(before).sum() - 1, 1e-12, "the weld keeps mass, relative")
    report.below(np.linalg.norm(momentum[1] - momentum[0]) / np.linalg.norm(momentum[0]), 1e-12, "and momentum, relative")
    report.check(len(after.positions) < len(before.positions), f"{len(before.positions)} vertices become {len(after.positions)}")


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
    result = run(write_case(tight(0.3, sewing={"strain": 0.1}), OUT / "garment_tight_30.toml"), folder, 2)
    report.check(result.code == 3 and "'side' is still open" in result.text and "too tight" in result.text and "[sewing] strain lets it rise" in result.text, f"30 % short: code {result.code}: {result.text.strip()[-300:]}")
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
    # A force that rose further would stretch it where it lies.
    case = tube(sewing={"strain": 0.1}, panel=[{"file": svg("garment_strip.svg", rectangle("tube", width, height)), "size": 0.015, "wrap_axis": [0, 0, 1], "translate": [-width / 2, -1.25 * RADIUS, -height / 2]}],
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
def garment_in_the_way(report):
    """What lies between the two sides of a seam is named: an arm through it, a fin, a piece, on 1 and 2 ranks; what does not is not."""
    arm = {"name": "arm", "type": "capsule", "point": [0, -0.5 * RADIUS, -HEIGHT / 2], "end": [0, 2.5 * RADIUS, -HEIGHT / 2], "radius": 8e-3}
    stage = [tube()["stage"][0] | {"time": {"end": 0.15, "step": 0.01}}]
    corners = [(x, y, z) for z in (-0.3, 0.1) for x, y in ((-2e-3, -0.7 * RADIUS), (2e-3, -0.7 * RADIUS), (2e-3, 2 * RADIUS), (-2e-3, 2 * RADIUS))]
    faces = [(1, 4, 3, 2), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]
    fin = {"name": "fin", "type": "mesh", "file": text_file("garment_fin.obj", "".join("v %g %g %g\n" % c for c in corners) + "".join("f %d %d %d %d\n" % f for f in faces))}
    for ranks, name, bodies in ((1, "arm", [arm]), (2, "fin", [fin])):
        shutil.rmtree(OUT / "garment_fin", ignore_errors=True)
        ended = run(write_case(tube(obstacle=bodies, stage=stage), OUT / "garment_fin.toml"), OUT / "garment_fin", ranks)
        report.check(ended.code == 3 and f"obstacle '{name}' (at " in ended.text, f"{name}: code {ended.code}, {ended.text[-400:]}")
    strip = svg("garment_strap.svg", rectangle("strap", 2.7 * RADIUS, 1.4 * HEIGHT))
    case = tube(stage=stage, panel=[*tube()["panel"], {"file": strip, "size": 0.02, "rotate": [0, 0, 90], "translate": [0, -0.7 * RADIUS, -0.2 * HEIGHT]}],
                support=[{"type": "clamped", "group": "strap"}])
    shutil.rmtree(OUT / "garment_strap", ignore_errors=True)
    ended = run(write_case(case, OUT / "garment_strap.toml"), OUT / "garment_strap", 1)
    report.check(ended.code == 3 and "lies piece 'strap' (at " in ended.text, f"a piece: code {ended.code}, {ended.text[-400:]}")
    slow = tube(stage=[stage[0] | {"time": {"end": 0.02, "step": 0.01}}])
    shutil.rmtree(OUT / "garment_slow", ignore_errors=True)
    ended = run(write_case(slow, OUT / "garment_slow.toml"), OUT / "garment_slow", 1)
    report.check(ended.code == 3 and "is still open" in ended.text and "between the two sides" not in ended.text, f"nothing: code {ended.code}, {ended.text[-300:]}")


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
    eye = svg("garment_eye.svg", '<path id="piece" d="M 0 0 L 300 0 L 300 300 L 0 300 Z M 150 70 Q 190 150 150 230 Q 110 150 150 70 Z"/>')
    flat = case | {"panel": [{"file": eye, "size": 0.015}], "stage": case["stage"][:1], "seam": [{"edges": ["piece/4"], "to": ["piece/5"]}],
                   "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 1e-3, "density": 200.0}]}
    flat.pop("contact")
    for name, changes, code in (("closed", {}, 0), ("open", {"sewing": {"force": 300.0}}, 3)):
        result = run(write_case(flat | changes, OUT / f"garment_eye_{name}.toml"), OUT / f"garment_eye_{name}")
        report.check(result.code == code and "in one plane" in result.text, f"a stiff cloth with a dart in a plane, {name}: code {result.code}: {result.text.strip()[-400:]}")


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


@test
def garment_seam_bending(report):
    """Two pieces sewn edge to edge, one clamped: the other hangs from a hinge, or goes on as the fabric; allowances weigh and stiffen."""
    side, density = 0.2, 0.2
    piece = {"file": svg("garment_square.svg", rectangle("piece", side, side)), "size": 0.025, "rotate": [-90, 0, 0]}
    flat = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0.5]])

    def case(sewing=None, **seam):
        return {"panel": [piece | {"name": "a"}, piece | {"name": "b", "translate": [side, 0, 0]}],
                "seam": [{"name": "middle", "edges": ["a/1"], "to": ["b/3"], "meet": ["a@1", "b@0"]} | seam],
                "sewing": sewing or {},
                "material": [{"type": "matrices", "membrane": (1e4 * flat).tolist(), "bending": (0.1 * flat).tolist(), "areal_density": density}],
                "support": [{"type": "clamped", "group": "a/3"}],
                "load": [{"type": "gravity", "vector": [0, 0, -9.81], "stages": ["hang"]}],
                "probe": [{"name": name, "type": "height", "group": group} for name, group in (("hem", "b/1"), ("seam", "seam middle"))],
                "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.2, "step": 0.02}, "damping": {"mass": 10.0}},
                          {"name": "hang", "analysis": "drape"}]}

    def hang(name, ranks, *args, **keys):
        """By how much the second piece leans down [degrees], how far the seam hangs [m], and the mass of both [kg]."""
        result = part(solve(f"garment_seam_{name}", case(*args, **keys), ranks), "hang")
        hem, seam = (result.history[f"{k}_mean"][-1] for k in ("hem", "seam"))
        panels = json.loads((result.folder / "summary.json").read_text())["garment"]["panels"]
        return np.degrees(np.arcsin(min((seam - hem) / side, 1.0))), -seam, sum(p["mass"] for p in panels)

    whole = hang("fabric", 1)
    report.near(whole[2], 2 * side**2 * density, 1e-12, "without allowance: mass [kg]")
    # A cantilever of both pieces at small deflections: q x^2 (6 L^2 - 4 L x + x^2) / 24 D.
    q, length = 9.81 * density, 2 * side
    deflection = lambda x: q * x**2 * (6 * length**2 - 4 * length * x + x**2) / (24 * 0.1)  # noqa: E731
    report.percent(whole[1] / deflection(side), 0.04, "as the fabric: deflection of the seam")
    for ranks in (1, 2):
        angle, sag, _ = hang(f"hinge_{ranks}", ranks, bending=0)
        report.near(angle, 90.0, 2.0, f"{ranks} rank(s), hinge: the second piece hangs down [degrees]")
        # The first is a cantilever with the weight of the second at its end.
        report.percent(sag / (q * side**4 / 8 / 0.1 + q * side * side**3 / 3 / 0.1), 0.04, f"{ranks} rank(s), hinge: deflection of the seam")
    soft, stiff = hang("soft", 1, bending=0.1), hang("stiff", 2, {"bending": 10})
    report.check(whole[0] < soft[0] < 80 and stiff[0] < whole[0], f"leaning by {stiff[0]:.1f}, {whole[0]:.1f}, {soft[0]:.1f} degrees with factors 10, 1, 0.1")
    heavy = hang("allowance", 2, {"allowance": 0.02}, bending=0)
    report.near(heavy[2], 2 * (side**2 + 0.02 * side) * density, 1e-12, "with allowances of 2 cm: mass [kg]")
    said = invoke(["check", write_case(case({"allowance": 0.02}), OUT / "garment_seam_check.toml")])
    report.check(said[0] == 0 and "and 0.008 m^2 of seam allowances" in said[1], f"check tells the fabric they take: code {said[0]}")
    for key, value in (("bending", -1), ("allowance", -0.01), ("allowance", 5.0), ("bending", "hinge")):
        code, text = invoke(["check", write_case(case(**{key: value}), OUT / "garment_seam_wrong.toml")])
        report.check(code == 2 and f"seam.{key}: " in text, f"{key} = {value}: code {code}: {text.strip()[:160]}")
