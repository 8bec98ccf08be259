"""Meshes and membranes: poor ones are told, formats agree, what locks and what does not."""

import re
import shutil
import subprocess

import numpy as np
import random_meshes
from benchmarks import BENCHMARKS
from calculix import annulus
from common import base, fresh, plate, sheet_on_ball, strip_case
from harness import OUT, solve, test
from jittered import strip_mesh
from linear import LINEAR, answer
from membrane_problems import Setting, linear_case
from membrane_references import reference
from pattern_files import tube
from shapes import write_msh
from solver import ROOT, command, environment, invoke, load_case, run, variant, write_case


@test
def poor_meshes(report):
    """Meshes that lock or stall are called so by info, check and run, also quietly; good ones are not."""
    for name, nx, ny, jitter, poor in (("stretched", 20, 16, 0.25, True), ("narrow", 20, 40, 0.0, True), ("even", 40, 4, 0.25, False)):
        mesh = strip_mesh(OUT / f"poor_{name}.msh", nx, ny, jitter)
        case = write_case(strip_case(mesh, load__0__vector=[0, 0, 1e-3]), OUT / f"poor_{name}.toml")
        texts = {command: invoke([command, file]) for command, file in (("info", mesh), ("check", case))}
        shutil.rmtree(OUT / f"poor_{name}_run", ignore_errors=True)
        texts["run"] = invoke(["run", case, "--output", OUT / f"poor_{name}_run", "--quiet"])
        for command, (code, text) in texts.items():
            said = "warning:" in text and "bending is too stiff" in text and "by 4 to 10 %" in text
            report.check(code == 0 and said == poor and "can lock" not in text, f"{name}, {command}: code {code}, {'a' if said else 'no'} warning of stiff bending")
        text = invoke(["check", case, "--set", 'element.type="six_node"'])[1]
        said = "the membrane can lock" in text
        report.check(said == poor, f"{name}, six-node membrane: {'a' if said else 'no'} warning of locking")
    mesh = strip_mesh(OUT / "poor_sliver.msh", 20, 2, 0.0)
    text = mesh.read_text().replace("\n14 2 0.5 0\n", "\n14 2.4995 0.499 0\n")  # next to a neighbour
    mesh.write_text(text)
    code, text = invoke(["info", mesh])
    report.check("below 2 degrees" in text and "Newton" in text, f"sliver: {[t for t in text.splitlines() if 'warning' in t]}")


def profile(legs, cells, file):
    """Two legs of 1 that meet at an angle [degree], 3 long, with so many cells to a leg and along."""
    angle, n = np.deg2rad(legs), cells
    across, along = np.linspace(-1, 1, 2 * n + 1), np.linspace(0, 3, n + 1)
    points = [(x if x < 0 else x * np.cos(angle), max(x, 0.0) * np.sin(angle), y) for y in along for x in across]
    corners = [(j * (2 * n + 1) + i, j * (2 * n + 1) + i + 1, (j + 1) * (2 * n + 1) + i + 1, (j + 1) * (2 * n + 1) + i) for j in range(n) for i in range(2 * n)]
    return write_msh(OUT / file, np.array(points), [("end", 1, [(i, i + 1) for i in range(2 * n)]),
                                                    ("sheet", 2, np.array([t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))]))])


@test
def folded_at_rest(report):
    """An L profile of long cells vibrates too fast with six_node, and the run says by how much; the default bends by angles beside the fold, and does not; a shallow fold is none."""
    keys = {"analysis": "modal", "eigen": {"modes": 1}, "support": [{"type": "clamped", "group": "end"}],
            "material": [{"type": "isotropic", "young": 1e3, "poisson": 0.3, "thickness": 0.03, "density": 1.0}]}
    first, said = {}, {}
    for element, cells in (("six_node", 8), ("six_node", 16), ("corrected", 8), ("angles", 8), ("angles", 24)):
        case = keys | {"mesh": {"file": str(profile(90, cells, f"profile_{cells}.msh"))}, "element": {"type": element}}
        result = solve(f"profile_{element}_{cells}", case)
        first[element, cells] = np.loadtxt(result.folder / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[0, 1]
        said[element, cells] = re.findall(r"folded at rest, .* frequencies too high by about ([\d.]+) %", result.text)
        by_angles = {"six_node": 0, "corrected": 4 * cells, "angles": 4 * cells * cells}[element]
        report.check(result.summary["angle_triangles"] == by_angles, f"{element}, {cells} cells: {result.summary['angle_triangles']} triangles bend by angles")
    right = first["angles", 24]
    report.below(abs(first["angles", 8] / right - 1), 0.02, "by angles, 8 cells against 24")
    report.below(abs(first["corrected", 8] / first["angles", 8] - 1), 1e-4, "by default, against angles everywhere")
    report.check(not said["corrected", 8] and not said["angles", 24], "nothing said where angles are taken")
    for cells in (8, 16):
        told = 0.01 * float((said["six_node", cells] or ["0"])[0])
        report.near(told, first["six_node", cells] / right - 1, 0.3 * told, f"six_node, {cells} cells: what the run says of the frequency")
    report.check("bend by angles" not in invoke(["info", profile(30, 8, "profile_shallow.msh")])[1], "30 degrees: nothing said")
    # Folded back: by angles a load that closes it would take the angle from pi to -pi.
    for angle in (170, 180):
        case = keys | {"analysis": "static", "mesh": {"file": str(profile(angle, 4, f"profile_{angle}.msh"))}, "load": [{"type": "gravity", "vector": [0, 0, -1e-3]}]}
        result = solve(f"profile_{angle}", case)
        report.check(result.summary["angle_triangles"] == 0 and "folded at rest" in result.text, f"{angle} degrees: bends by slopes, and warns")


@test
def taut_sheets(report):
    """Drums: the corrected membrane measures slopes in full, as the lumped mass does; the six-node membrane and the consistent mass both too small."""
    stiffness, strain, density = 1000.0, 0.01, 0.2
    exact = 2.404826 * np.sqrt(stiffness * (strain + strain**2 / 2) / density) / (2 * np.pi)
    for membrane, mass, low, high in (("six_node", "consistent", -0.001, 0.004), ("corrected", "consistent", 0.006, 0.012),
                                      ("corrected", "lumped", -0.004, 0.001), ("six_node", "lumped", -0.012, -0.006)):
        case = {"analysis": "modal", "element": {"type": membrane}, "eigen": {"modes": 1, "load_factor": 1.0, "mass": mass},
                "mesh": {"file": str(ROOT / "meshes" / "disc.geo"), "parameters": {"radius": 1, "inner_radius": 0.4, "n": 8}},
                "material": [{"type": "matrices", "membrane": np.diag([stiffness, stiffness, stiffness / 2]).tolist(),
                              "bending": np.diag([1e-6, 1e-6, 5e-7]).tolist(), "areal_density": density}],
                "support": [{"type": "displacement", "group": "edge", "components": ["x", "y", "z"], "cylinder_axis": [0, 0, 1], "value": [strain, 0, 0]}]}
        result = solve(f"drum_{membrane}_{mass}", case, 1)
        error = np.loadtxt(result.folder / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[0, 1] / exact - 1
        report.check(low < error < high, f"{membrane}, {mass} mass: first frequency {100 * error:+.2f} %")


@test
def estimated_errors(report):
    """Wrong deflections are told: chords of uneven cells by the share of the energy, thin curved shells by how much they lock."""
    reference = BENCHMARKS["cantilever_shear"].reference
    words = {"six_node": "spurious membrane strains", "corrected": "second derivatives within the surface"}
    for element, nx, ny, jitter in (("six_node", 20, 16, 0.25), ("six_node", 20, 2, 0.0), ("corrected", 20, 16, 0.25), ("corrected", 20, 2, 0.0)):
        case = base("cantilever_shear", element={"type": element}, output={"fields": ["displacement", "membrane_error"], "every": 100})
        case["mesh"] = {"file": str(strip_mesh(OUT / f"estimated_{ny}.msh", nx, ny, jitter))}
        result = solve(f"estimated_{element}_{ny}", case, 1)
        error, estimate = 1 + result.history["tip_x"][-1] / reference["minus_u_tip_elastica"][-1], result.summary["membrane_error"]
        told = words[element] in result.text
        field = result.results[-1]["membrane_error"]
        report.check(np.all(field >= 0) and field.max() > 0, "the field says where")
        if jitter:
            report.check((told or estimate < 0.05) and 0.5 < estimate / error < 2, f"{element}: -u of the tip is {100 * error:.1f} % too small, estimated {100 * estimate:.1f} %")
        else:
            report.check(not told and estimate < 3e-3, f"even cells: {100 * error:.2f} %, estimated {100 * estimate:.3f} %")
    hypar = load_case(ROOT / "runs" / "linear" / "hypar_1000.toml") | {"element": {"type": "six_node"}}
    deflection = {}
    for n in (16, 64):
        result = solve(f"estimated_hypar_{n}", variant(hypar, {"mesh.parameters.n": n}), 1)
        deflection[n] = result.history["A_z"][-1]
        said = re.findall(r"too small by about (\d+) %", result.text)
        checked = re.findall(r"too small by about (\d+) %", invoke(["check", OUT / f"estimated_hypar_{n}.toml"])[1])
        report.check(said == checked and bool(said) == (n == 16), f"saddle, n = {n}: run says {said}, check {checked}")
        if said:
            estimate = 0.01 * int(said[0])
    error = 1 - deflection[16] / deflection[64]
    report.check(0.5 < estimate / error < 2, f"it is {100 * error:.0f} % too small, estimated {100 * estimate:.0f} %")


@test
def unresolved(report):
    """Deflections that are too large or too small because cells do not resolve moments or forces are told with cause and place; fine cells are not."""
    around, wide = {"n_axial": 16, "n_circ": 16}, {"n_axial": 8, "n_circ": 8}
    for name, kind, size, cause, place in (("pinched_diaphragm", "random", around, "bending moments", (0.0, 0.0, 300.0)),
                                           ("scordelis_lo", "union jack", wide, "membrane forces", None),
                                           ("scordelis_lo", "union jack", {k: 4 * n for k, n in wide.items()}, "", None)):
        setting = Setting("corrected", kind, size, 1e-3, 1)
        label = f"unresolved_{name}_{setting.mesh_name.replace(' ', '')}"
        case = linear_case(name, setting, OUT / f"{label}_mesh")
        estimates = []
        for ranks in (1, 2, 3) if place else (1,):
            result = solve(f"{label}_{ranks}", case, ranks)
            estimates.append(result.summary["recovery_error"])
        error = -result.history["A_z"][-1] / reference(name, 1e-3)["A_z"] - 1
        said = re.findall(r"cells do not resolve how (.*) change, most near \(([^)]*)\) m", result.text)
        report.check([s[0] for s in said] == ([cause] if cause else []), f"{label}: {100 * error:+.1f} %, estimated {100 * estimates[0]:.1f} %: {said}")
        report.below(np.ptp(estimates) / estimates[0], 1e-6, "the same on all numbers of ranks")
        report.check(("not resolved: by estimate" in result.text) == bool(cause), "the last lines state whether it is resolved")
        if cause:
            report.check(0.4 < estimates[0] / abs(error) < 2.5 and result.summary["membrane_error"] < 0.05, "within a factor of 2.5; chords say nothing")
        if place and said:
            where = np.array([float(x) for x in said[0][1].split(",")])
            report.below(np.linalg.norm(where - place), 40.0, "the place is at the force")
            fields = result.results[-1]
            report.check(all(fields[f"{part}_recovery_error"].min() >= 0 for part in ("membrane", "bending"))
                         and fields["bending_recovery_error"].max() > fields["membrane_recovery_error"].max(), "the fields say where")
    # A thick strip that bends in its plane, at any mesh.
    width, thickness, young = 0.1, 0.05, 7e10
    thick = {"analysis": "linear", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 1.0, "width": width, "nx": 60, "ny": 6}},
             "material": [{"type": "isotropic", "young": young, "poisson": 0.0, "thickness": thickness}], "support": [{"type": "clamped", "group": "clamp"}],
             "load": [{"type": "line", "group": "tip", "vector": [0, 100.0, 0]}], "probe": [{"name": "tip", "type": "displacement", "group": "tip", "components": ["y"]}]}
    result = solve("unresolved_thick", thick)
    force, inertia, area = 100.0 * width, thickness * width**3 / 12, thickness * width
    short = 1 - result.history["tip_y"][-1] / (force / (3 * young * inertia) + 1.2 * force / (0.5 * young * area))
    report.percent(result.summary["membrane_error"] / short, 0.05, f"a strip that bends in its plane is {100 * short:.0f} % too stiff: membrane_error")
    report.check("\nnot resolved" in result.text and f"too small by up to {100 * result.summary['membrane_error']:.0f} %" in result.text and '"angles"' in result.text, f"and is told so: {result.text[-900:] if 'angles' not in result.text else ''}")


PLATE_DECK = """*Heading
Plate of "steel"
*Node
{nodes}
*Element, type=S4R, elset=PLATE
{elements}
*Nset, nset=Edge
{edge}
*Shell Section, elset=plate, material=Steel
2.
*Material, name=STEEL
*Elastic
210000., 0.3
*Density
7.85e-9
*Boundary
EDGE, ENCASTRE
{rest}
"""


@test
def merged_boundary(report):
    """Two halves with vertices of their own that are merged are one sheet: its boundary is what is left, not where they meet."""
    folder = fresh("merged_meshes")
    folder.mkdir(parents=True, exist_ok=True)
    deflection = {}
    for name, parts in (("whole", ((0, 16),)), ("halves", ((0, 8), (8, 16)))):
        vertices, faces = [], []
        for low, high in parts:
            first = len(vertices) + 1
            vertices += [(0.0125 * i, 0.0125 * j, 0) for i in range(low, high + 1) for j in range(9)]
            at = lambda i, j: first + 9 * (i - low) + j  # noqa: B023, E731
            faces += [f for i in range(low, high) for j in range(8)
                      for f in ((at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1)))]
        (folder / f"{name}.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in vertices) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces))
        case = {"analysis": "static", "mesh": {"file": str(folder / f"{name}.obj"), "merge": name == "halves"},
                "material": [{"type": "isotropic", "young": 3e9, "poisson": 0.3, "thickness": 1e-3}],
                "support": [{"type": "hinged", "group": "boundary"}], "load": [{"type": "pressure", "magnitude": 100.0}]}
        deflection[name] = np.abs(solve(f"merged_{name}", case).displacement()).max()
    report.percent(deflection["halves"] / deflection["whole"], 1e-9, f"halves deflect as the whole, {deflection['whole']:.3g} m")


@test
def deck_cases(report):
    """voile init --from: an annulus of S8R under NLGEOM bends as in CalculiX, a clamped plate in mm and t vibrates as it should; what is not understood is listed with its line."""
    def begin(name, text):
        file = OUT / f"{name}.inp"
        OUT.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        code, said = invoke(["init", fresh(name), "--from", file])
        return code, said, (OUT / name / "case.toml")

    code, said, case = begin("deck_annulus", annulus(16, True)[0])
    report.check(code == 0 and "left out" not in said, f"annulus: code {code}: {said[:200]}")
    result = run(case, fresh("deck_annulus_run"), 1)
    u, x = result.displacement(), result.results[-1].mesh.positions
    lip = [max(u[np.linalg.norm(x - [r, 0, 0], axis=1) < 1e-6][:, 2]) for r in (6, 10)]
    # CalculiX 2.20 (Debian 12) with this deck, of 4 x 32 elements: 13.763 and 17.403.
    for got, calculix in zip(lip, (13.763, 17.403)):
        report.percent(got / calculix, 0.01, "annulus: deflection over that of CalculiX on the same nodes")
    n, side = 16, 200.0
    nodes = "\n".join(f"{1 + i + j * (n + 1)}, {side * i / n}, {side * j / n}, 0." for j in range(n + 1) for i in range(n + 1))
    elements = "\n".join(f"{1 + i + j * n}, {1 + i + j * (n + 1)}, {2 + i + j * (n + 1)}, {2 + i + (j + 1) * (n + 1)}, {1 + i + (j + 1) * (n + 1)}"
                         for j in range(n) for i in range(n))
    edge = ",\n".join(str(1 + i + j * (n + 1)) for j in range(n + 1) for i in range(n + 1) if i in (0, n) or j in (0, n))
    plate = lambda rest: PLATE_DECK.format(nodes=nodes, elements=elements, edge=edge, rest=rest)  # noqa: E731
    crlf = "\ufeff" + plate("*Step\n*Frequency\n4,\n*End Step").replace("\n", "\r\n")
    code, said, case = begin("deck_crlf", crlf)
    report.check(code == 0 and 'analysis = "modal"' in case.read_text() and invoke(["check", case])[0] == 0, f"a mark of byte order and lines of Windows: {said[:200]}")
    code, said, case = begin("deck_plate", plate("*Step\n*Frequency\n4,\n*Output, field\n*End Step"))
    exact = 35.985 / (2 * np.pi) * np.sqrt(210000 * 8 / 12 / 0.91 / (2 * 7.85e-9)) / side**2
    report.percent(run(case, fresh("deck_plate_run"), 2).summary["eigenvalues"][0] / exact, 0.025, "plate: first frequency")
    layers = plate("*Step\n*Frequency\n4,\n*End Step").replace("*Shell Section, elset=plate, material=Steel\n2.\n", (
        "*Orientation, name=Fibres\n0., 1., 0., -1., 0., 0.\n3, 30.\n"
        "*Shell Section, elset=plate, composite, symmetric, orientation=fibres\n0.5, 3, Steel, 0.\n0.5, 3, Steel, 90.\n"))
    upright = plate("*Step\n*Frequency\n4,\n*End Step").replace("*Elastic\n210000., 0.3", "*Elastic, type=lamina\n140000., 10000., 0.3, 5000., 5000., 4000.")
    upright = upright.replace(nodes, "\n".join(f"{k}, 0., {x}, {y}" for k, x, y, _ in (line.split(", ") for line in nodes.splitlines())))
    code, said, case = begin("deck_upright", upright)
    report.check(code == 0 and "direction = [0, 0, 1]" in case.read_text(), f"without an orientation axis 1 is z where the sheet is square to x: {said[:200]}")
    folded = upright.replace("\n".join(f"{k}, 0., {x}, {y}" for k, x, y, _ in (line.split(", ") for line in nodes.splitlines())),
                             "\n".join(f"{k}, {min(float(x), side / 2)}, {y}, {max(float(x) - side / 2, 0)}" for k, x, y, _ in (line.split(", ") for line in nodes.splitlines())))
    code, said, case = begin("deck_folded", folded)
    report.check(code == 0 and f"on {n * n} of its {2 * n * n} triangles, square to x" in said, f"one section on both kinds of place is listed: {said[:300]}")
    layers = layers.replace("*Elastic\n210000., 0.3", "*Elastic, type=lamina\n140000., 10000., 0.3, 5000., 5000., 4000.")
    code, said, case = begin("deck_layers", layers)
    found = case.read_text()
    report.check(code == 0 and "left out" not in said and "angles = [30, 120, 120, 30]\nply_thicknesses = [0.5, 0.5, 0.5, 0.5]" in found
                 and "direction = [0, 1, 0]" in found, f"a symmetric stack with an orientation: {said[:300]}\n{found[:600]}")
    mixed = layers.replace("0.5, 3, Steel, 90.", "0.5, 3, Foam, 90.")
    code, said, case = begin("deck_mixed", mixed)
    report.check(code == 0 and "several materials" in said, f"plies of two materials: {said[:300]}")
    code, said, case = begin("deck_left", plate("*Boundary\n20, 1, 3\n*Rigid Body, ref node=20\n*Step, nlgeom\n*Static\n1., 1.\n*Cload\n145, 3, 2.\n"
                                                "146, 3, 2.\n145, 5, 1.\n*Dload\nplate, P, 0.01\n*End Step"))
    found = case.read_text()
    report.check(code == 0 and re.search(r"left out: .*deck_left.inp:\d+: \*RIGID BODY", said) and "*CLOAD 145: a moment" in said, f"left out is listed: {said[:400]}")
    report.check('analysis = "static"' in found and 'type = "follower_pressure"\ngroup = "PLATE"' in found and "LOADED_2" in found and "HELD_1" in found, "sets of single nodes")
    code, said = invoke(["check", case])
    report.check(code == 0, f"and the case is whole: {said[-200:]}")
    code, said, case = begin("deck_moving", plate("*Boundary, type=velocity\n20, 1, 3, 5.\n*Boundary, op=new\n21, YSYMM\n22, 2, 2, 0.5\n*Step\n*Static\n*Dload\nplate, P, 1e-4\nplate, GRAV, 9810., 0., 0., -1.\n*End Step"))
    found = case.read_text()
    report.check("*BOUNDARY, TYPE=VELOCITY" in said and "OP=NEW" in said and "value = [0, 0.5, 0]" in found and "normal = [0, 1, 0]" in found
                 and "vector = [0, 0, -9810]" in found, f"velocities are no displacements; mirror planes, values and gravity: {said[:300]}")
    edges = lambda at: ",\n".join(str(1 + at + j * (n + 1)) for j in range(n + 1))  # noqa: E731
    for name, held in (("numbers", "RIGHT, 1\nRIGHT, 5, 6"), ("mirror", "RIGHT, XSYMM")):
        pushed = plate("").replace("*Boundary\nEDGE, ENCASTRE\n", "") + f"*Nset, nset=LEFT\n{edges(0)}\n*Nset, nset=RIGHT\n{edges(n)}\n*Boundary\nLEFT, ENCASTRE\n{held}\n*Step, nlgeom\n*Static\n*Boundary\nRIGHT, 1, 1, -0.002\n*End Step\n"
        code, said, case = begin(f"deck_pushed_{name}", pushed)
        report.check(code == 0 and 'type = "sliding"\ncomponents = ["x"]\nvalue = [-0.002, 0, 0]' in case.read_text(), f"an edge that is pushed and does not turn, by {name}: {said[:200]}")
        u = run(case, fresh("deck_pushed_run"), 1).displacement() if name == "mirror" else np.full((1, 3), -0.002)
        report.near(u[:, 0].min(), -0.002, 1e-12, "and it is where it is pushed to")
    code, said, case = begin("deck_riks", plate("*Step, nlgeom\n*Static, riks\n0.05, 1., 1e-5, 0.2, 3.\n*Dload\nplate, P, 1e-4\n*End Step"))
    report.check('control = "arc_length"\nfinal_load_factor = 3\ninitial_step = 0.05\n' in case.read_text() and "arc length of at least or at most 1e-5" in said, f"a path of Riks: {said[:300]}")
    code, said, case = begin("deck_other_set", plate("*Step\n*Frequency\n4, 10., 500.\n*End Step").replace("elset=plate, material", "elset=plat, material"))
    report.check(code == 0 and "SHELL SECTION of plat: there is no such set of shells" in said and "a bound or shift of 500." in said and invoke(["check", case])[0] == 2, f"a section of a set that is not there: {said[:300]}")
    code, said, case = begin("deck_pressed", plate("*Step\n*Static\n*Dload\nplate, P, 1e-4\n*End Step\n*Step\n*Frequency\n4\n*End Step"))
    report.check("a second *STEP" in said and 'analysis = "linear"' in case.read_text(), "of two steps the first is taken")
    # CalculiX 2.20 lifts such a plate along the normals of its elements, too.
    report.check(run(case, fresh("deck_pressed_run"), 1).displacement()[:, 2].max() > 0, "a pressure acts along the normals")
    table = "*Amplitude, name=RISE\n0., 0., 0.5, 0.2, 1., 0.8\n*Node\n9001, 0., 0., 50.\n9002, 0., 0., 60.\n*Element, type=SPRINGA, elset=SPRINGS\n9001, 9001, 9002\n*Boundary\n9001, 1, 3\n9002, 1, 3\n"
    step = "*Step, nlgeom\n{}\n0.1, 1.\n*Cload, amplitude=rise\n145, 3, 2.\n*Boundary, amplitude=Rise\n147, 3, 3, 5.\n*Cload, amplitude=none\n146, 3, 1.\n*Dload\nsprings, GRAV, 1., 0., 0., 1.\n*End Step"
    code, said, case = begin("deck_history", plate(table + step.format("*Dynamic")))
    found = case.read_text()
    report.check('history = "table(t, 0, 0, 0.5, 0.2, 1, 0.8)"' in found and 'motion = ["0", "0", "5 * table(t, 0, 0, 0.5, 0.2, 1, 0.8)"]' in found
                 and "AMPLITUDE=NONE: there is no such table" in said, f"amplitudes become histories of a motion: {said[:300]}")
    report.check("1 elements of type SPRINGA, which are no shells" in said and "2 places are no part of a shell: 9001" in said and "gravity" not in found,
                 f"what is no shell is named and left out: {said[-700:]}")
    report.check(invoke(["check", case])[0] == 0, "and the case is whole")
    code, said, case = begin("deck_at_end", plate(table + step.format("*Static")))
    found = case.read_text()
    report.check("vector = [0, 0, 1.6]" in found and "value = [0, 0, 4]" in found and "*AMPLITUDE RISE: loads grow in proportion to 0.8" in said,
                 f"in a static step the end of a table counts: {said[:300]}")
    code, said, case = begin("deck_bare", plate("").replace("*Elastic\n210000., 0.3", "*Depvar\n3"))
    report.check(code == 0 and "it has no [[material]] yet" in said and "voile run" not in said, f"without a material nothing can be run: {said[-200:]}")
    code, said, case = begin("deck_dialect", plate("*Nset, nset=ALL, elset=PLATE\n*Boundary\nALL, 3\n*Step\n*Static\n*End Step")
                             .replace("elset=plate, material", "elset=plate,\nmaterial").replace("*Shell S", "*Membrane S").replace("0.3\n", "0.3, 20.\n190000., 0.3, 200.\n"))
    report.check(code == 0 and "*ELASTIC: properties at other temperatures" in said and "*MEMBRANE SECTION: it bends" in said and "young = 210000" in case.read_text(),
                 f"lines that continue, moduli by temperature and membranes: {said[:400]}")
    report.check('group = "ALL"' in case.read_text() and invoke(["check", case])[0] == 0, "nodes of a set of elements")
    for what, change in (("an amplitude whose times do not ascend", ("*Boundary", "*Amplitude, name=A\n0., 0., 0., 1.\n*Boundary")), ("a modulus that is no number", ("210000.", "many")), ("an include that is not there", ("*Heading", "*Include, input=none.inp\n*Heading"))):
        code, said, _ = begin("deck_wrong", plate("").replace(*change))
        report.check(code == 2 and re.search(r"deck_wrong\.inp:\d+: ", said), f"{what}: code {code}: {said[:150]}")


@test
def unresolved_modes(report):
    """Frequencies of a clamped plate: the estimate is 0.5 to 2.5 times the error, and warns of coarse cells."""
    material = [{"type": "isotropic", "young": 2e11, "poisson": 0.3, "thickness": 0.01, "density": 7850}]
    factor = np.sqrt(2e11 * 0.01**3 / (12 * 0.91) / 78.5) / (2 * np.pi)  # Leissa, NASA SP-160 (1969), table 4.22
    exact = factor * np.array([35.985, 73.394, 73.394, 108.22])
    for cells, ranks in ((8, 1), (32, 2)):
        case = {"analysis": "modal", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": cells}}, "material": material,
                "support": [{"type": "clamped", "group": g} for g in ("left", "right", "bottom", "top")], "eigen": {"modes": 4}}
        result = solve(f"unresolved_modes_{cells}", case, ranks)
        table = np.loadtxt(result.folder / "modes.csv", delimiter=",", skiprows=1)
        ratio = table[:, 4] / np.abs(table[:, 1] / exact - 1.0)
        report.check(0.5 < ratio.min() and ratio.max() < 2.5, f"{cells} cells: estimates are {ratio.min():.2f} to {ratio.max():.2f} times the errors")
        report.check(("cells do not resolve mode(s) 1, 2, 3, 4" in result.text) == (cells == 8), f"{cells} cells: warned, or not")
        report.below(max(abs(np.array(result.summary["eigenvalue_errors"]) - table[:, 4])), 1e-12, "the summary has them too")
    slow = case | {"analysis": "harmonic", "mesh": case["mesh"] | {"parameters": {"n": 4}}, "eigen": {}, "load": [{"type": "pressure", "magnitude": 1.0}],
                   "damping": {"ratio": [0.01]}, "harmonic": {"from": 0.01, "to": 0.1}, "probe": [{"name": "middle", "type": "displacement", "point": [0, 0, 0], "components": ["z"]}]}
    report.check("cells do not resolve mode(s) 1:" in solve("unresolved_modes_slow", slow).text, "a response below all modes is that of the first")

    # Thirty modes of a long strip: its first frequency is a thousandth of the last, but no rigid motion.
    strip = {"analysis": "modal", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": 120, "ny": 2, "length": 10, "width": 0.1}},
             "material": material, "support": [{"type": "clamped", "group": "clamp"}], "eigen": {"modes": 30}}
    errors = solve("unresolved_modes_strip", strip).summary["eigenvalue_errors"]
    report.check(0 < errors[0] < 1e-3 and min(errors) > 0, f"a long strip: estimates from {errors[0]:.1e}")
    loose = solve("unresolved_modes_loose", {k: v for k, v in case.items() if k != "support"} | {"eigen": {"modes": 8}}).summary
    report.check(loose["eigenvalue_errors"][:6] == [0] * 6 and loose["eigenvalue_errors"][6] > 0, "rigid motions have none")


@test
def twisted_tapes(report):
    """A taut tape twists with 2 to 8 cells across, a flange buckles by twisting: the estimate is the error, and warns of few cells."""
    def strip(length, width, nx, ny):
        return {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": length, "width": width, "nx": nx, "ny": ny}}

    tape = {"analysis": "modal", "material": [{"type": "isotropic", "young": 2.1e11, "poisson": 0, "thickness": 1e-4, "density": 7800, "prestress": [5000, 0], "direction": [1, 0, 0]}],
            "support": [{"type": "hinged", "group": g} for g in ("clamp", "tip")]}
    length, width, h = 1.0, 0.01, 1e-4
    polar, torsion = width**3 * h / 12, 2.1e11 / 2 * width * h**3 / 3
    exact = np.sqrt((5000 / h * polar + torsion) / (7800 * polar)) / (2 * length)
    for mass, least, most in (("consistent", 0.8, 1.6), ("lumped", 0.4, 1.2)):
        for cells in (2, 4, 8):
            result = solve(f"twisted_tapes_{mass}_{cells}", tape | {"mesh": strip(length, width, 10 * cells, cells), "eigen": {"modes": 2, "mass": mass}})
            table = np.loadtxt(result.folder / "modes.csv", delimiter=",", skiprows=1)
            error = table[1, 1] / exact - 1
            report.check((error > 0) == (mass == "consistent") and least < table[1, 4] / abs(error) < most,
                         f"{mass} mass, {cells} cells: {100 * error:+.2f} %, estimated {100 * table[1, 4]:.2f} %")
            report.check(("cells do not resolve mode(s) 2:" in result.text) == (cells == 2), "warned, or not")
    flange = {"analysis": "buckling", "material": [{"type": "isotropic", "young": 2.1e11, "poisson": 0.3, "thickness": 1e-3, "density": 7800}],
              "mesh": strip(0.5, 0.1, 20, 4), "load": [{"type": "line", "group": "tip", "vector": [-1e4, 0, 0]}], "eigen": {"modes": 1},
              "support": [{"type": "displacement", "group": g, "components": c} for g, c in (("clamp", ["x", "z"]), ("tip", ["z"]), ("side_low", ["y", "z"]))]}
    load = (0.425 + 1 / 25) * np.pi**2 * 2.1e11 * 1e-9 / (12 * 0.91) / 0.01 / 1e4  # Timoshenko & Gere, Theory of Elastic Stability (1961), 9.4
    result = solve("twisted_flange", flange)
    error, estimate = result.summary["eigenvalues"][0] / load - 1, result.summary["eigenvalue_errors"][0]
    report.check(-0.05 < error < -0.02 and 0.8 < estimate / -error < 1.8, f"flange, 4 cells across: {100 * error:+.2f} %, estimated {100 * estimate:.2f} %")
    hot = {k: v for k, v in flange.items() if k != "load"} | {"material": [flange["material"][0] | {"expansion": 1e-5}], "temperature": [{"change": "1"}]}
    hot["support"] = [flange["support"][0], flange["support"][0] | {"group": "tip"}, flange["support"][2]]
    heated = solve("twisted_flange_heated", hot).summary
    report.percent(heated["eigenvalues"][0] * 2.1e11 * 1e-5 * 1e-3 / (result.summary["eigenvalues"][0] * 1e4), 1e-5, "held and heated it buckles at the same force")
    report.percent(heated["eigenvalue_errors"][0] / estimate, 1e-5, "and is estimated alike")


@test
def unresolved_on_the_way(report):
    """A shallow roof on 8 x 8 cells: its bending is less resolved at the limit load than at the end, and the warning says where."""
    case = variant(load_case(ROOT / "runs" / "roof_isotropic_6.35" / "case.toml"), {"mesh.parameters.n_axial": 8, "mesh.parameters.n_circ": 8})
    case["mesh"]["file"] = str(ROOT / "meshes" / "panel.geo")
    case["probe"].append({"name": "shell", "type": "energy"})
    result = solve("unresolved_on_the_way", case, 1)
    bent, stretched = (result.history[f"shell_{part}"][-1] for part in ("bending", "membrane"))
    parts = bent * result.summary["recovery_error_of_bending"] + stretched * result.summary["recovery_error_of_stretching"]
    report.percent(parts / (bent + stretched) / result.summary["recovery_error"], 0.02, "those of bending and stretching, weighed by their energies, are that of all")
    report.check(result.summary["recovery_error"] < 0.05 < result.summary["largest_recovery_error"], "less than 5 % at the end, more before")
    report.check("warning: at load factor" in result.text and "resolved at the end" in result.text, "the warning names the load factor")


@test
def corrected_membrane(report):
    """Where straight chords lock, the corrected membrane does not; where they do no harm it agrees with the six-node one."""
    reference = BENCHMARKS["cantilever_shear"].reference["minus_u_tip_elastica"][-1]
    beam, saddle, answers = LINEAR["twisted_beam_thin_y"], LINEAR["hypar_10000"], {}
    for membrane in ("six_node", "corrected"):
        case = variant(load_case(beam.case), {"mesh.parameters": {"nx": 24, "ny": 2, "pattern": 0}, "element": {"type": membrane}})
        answers[membrane] = [answer(beam, solve(f"corrected_beam_{membrane}", case, 2)) / beam.reference - 1]
        case = variant(load_case(saddle.case), {"mesh.parameters.n": 48, "mesh.parameters.pattern": 1, "element": {"type": membrane}})
        answers[membrane].append(answer(saddle, solve(f"corrected_saddle_{membrane}", case, 1)) / saddle.reference - 1)
        # The last one is a tenth as thick, at the same bending stiffness.
        for nx, ny, jitter, thin in ((20, 16, 0.25, 1.0), (20, 2, 0.0, 1.0), (20, 16, 0.25, 0.1)):
            case = base("cantilever_shear", element={"type": membrane})
            case["mesh"] = {"file": str(strip_mesh(OUT / f"corrected_{ny}.msh", nx, ny, jitter))}
            case["material"][0] |= {"thickness": 0.1 * thin, "young": 1.2e6 / thin**3}
            result = solve(f"corrected_{ny}_{membrane}", case, 1)
            answers[membrane].append(-result.history["tip_x"][-1] / reference - 1)
            if membrane == "corrected" and ny == 16:
                error, estimate = -answers[membrane][-1], result.summary["membrane_error"]
                report.check(0.5 < estimate / error < 2, f"thickness {thin}: -u is {100 * error:.1f} % too small, estimated {100 * estimate:.1f} %")
    plain, corrected = answers["six_node"], answers["corrected"]
    names = ("thin twisted beam, 24 x 2", "saddle, t/L = 1e-4, n = 48", "strip of uneven cells of aspect 8", "strip of even cells",
             "thin strip of uneven cells")
    for name, before, after, limit in zip(names, plain, corrected, (0.006, 0.01, 0.045, 0.002, 0.055)):
        report.below(abs(after), limit, f"{name}: error; of six_node {100 * before:.2f} %")
    report.check(abs(plain[0]) > 0.4 and abs(plain[1]) > 0.1 and abs(plain[2]) > 0.1 and abs(plain[4]) > 0.6, "the six-node membrane locks there")


@test
def meshes_at_random(report):
    """Grids of runs/lib/random_meshes.py are the meshes of meshes/*.geo before their vertices are moved, and hardly another answer after."""
    for name, shape, size, column in (
            ("linear/hypar_100", random_meshes.hypar, {"n": 16}, "A_z"),
            ("linear/twisted_beam_thick_y", random_meshes.twisted_strip, {"nx": 24, "ny": 2}, "tip_y"),
            ("linear/pinched_cylinder_free_100", random_meshes.cylinder(4.953, 10.35), {"n_axial": 16, "n_circ": 24}, "A_z"),
            ("linear/scordelis_lo", random_meshes.panel(25.0, 50.0, np.radians(40)), {"n_axial": 16, "n_circ": 16}, "A_z"),
            ("hemisphere/case", random_meshes.hemisphere, {"n": 24}, "pulled_x"), ("cantilever_shear/case", random_meshes.cantilever, {"nx": 24, "ny": 2}, "tip_z")):
        case = variant(load_case(ROOT / "runs" / f"{name}.toml"), {"analysis": "linear", "steps": None})
        if name.startswith("cantilever"):
            case["mesh"]["parameters"]["length"] = 12
        label = name.replace("/", "_")
        told = variant(case, {f"mesh.parameters.{k}": v for k, v in (size | {"pattern": 0}).items()})
        expected = solve(f"random_{label}", told, 1).history[column][-1]
        # Gmsh puts vertices evenly along the saddle's edges, not along x.
        for jitter, limit in ((0.0, 0.01 if name == "linear/hypar_100" else 1e-5), (0.25, 0.03)):
            falling = "cylinder" in name or "scordelis" in name  # as Gmsh cuts cells of these
            mesh = random_meshes.grid_mesh(OUT / f"random_{label}_{jitter}.msh", *shape(size), jitter=jitter, falling=falling)
            computed = solve(f"random_{label}_{jitter}", case | {"mesh": {"file": str(mesh)}}, 1).history[column][-1]
            report.percent(computed / expected, limit, f"{name}, moved by {jitter} of a cell")


@test
def element_types(report):
    """The element is named by one key, of every stage alike; what 0.1 had in its place is refused with what to write."""
    case = base("hemisphere", mesh__parameters__n=4)
    case = variant(case, {"analysis": "linear", "steps": None})
    found = {}
    for element in (None, "corrected", "six_node", "angles", "sze_zhou_2016", "zhou_sze_2012"):
        result = solve(f"element_{element}", variant(case, {"element": {"type": element} if element else None}), 1)
        found[element] = result.history["pulled_x"][-1]
        report.check(result.summary["element"] == (element or "corrected"), f"{element}: {result.summary['element']}")
    report.check(found[None] == found["corrected"] and len(set(found.values())) == 5, f"the default is corrected, the others differ: {found}")
    for key, value, instead in (("membrane", "cst", "element.type"), ("bending", "edge_angle", "element.type"), ("cst_share", 0.3, "cst_fraction")):
        code, text = invoke(["check", str(write_case(variant(case, {"element": {key: value}}), OUT / "element_former.toml"))])
        report.check(code == 2 and instead in text and key in text, f"{key}: code {code}: {text.splitlines()[-1:]}")
    staged = variant(case, {"analysis": None, "stage": [{"name": "first", "analysis": "static", "steps": {"final_load_factor": 0.01}}]})
    report.check(solve("element_staged", staged, 1).summary["stages"][0]["element"] == "corrected", "a stage")


# Strip of 10 x 2, clamped, that changes at half its length: tip deflection under a unit line load and first angular frequency with
# unit mass, by Morley's element with all slopes unknown on 40, 80, 160 cells, extrapolated (D = 1 beyond the change, nu = 0.3; ply:
# D1 = 10, D2 = 1, D66 = 0.5).
JUMPS = {"five times as stiff": (5.0, 107.7304, 0.0689842), "125 times": (125.0, 46.7333, 0.1306382), "a 125th": (1 / 125, 38901.7, 0.00312739),
         "0/90": ((0.0, 90.0), 70.7458, 0.0911225), "30/-45": ((30.0, -45.0), 140.991, 0.0563261), "soft band": ("band", 2922.8, 0.0146888)}


def jump_case(jump, n, jitter, analysis):
    """`jump`: stiffness of the clamped half, or directions of both halves, or a band of a 125th and one width."""
    mesh = OUT / f"jump_{n}_{jitter}.msh"
    across = max(2, n // 5)
    points, cells = strip_cells(n, across, 10.0, 2.0, jitter)
    middle = np.array([points[list(c)].mean(axis=0)[0] for c in cells])
    parts = ("root", middle < 5), ("band", (middle > 5) & (middle < 6)), ("tip", middle > 6)
    write_msh(mesh, points, [("left", 1, [(j * (n + 1), (j + 1) * (n + 1)) for j in range(across)]),
                             ("right", 1, [(j * (n + 1) + n, (j + 1) * (n + 1) + n) for j in range(across)]),
                             *((name, 2, np.array(cells)[where]) for name, where in parts)])
    plain = lambda d: [[d, 0.3 * d, 0], [0.3 * d, d, 0], [0, 0, 0.35 * d]]  # noqa: E731
    stiff = np.diag([1e4, 1e4, 4e3]).tolist()

    def material(groups, bending, angle=0.0):
        return {"type": "matrices", "groups": groups, "membrane": stiff, "bending": bending, "areal_density": 1.0,
                "direction": [float(np.cos(np.radians(angle))), float(np.sin(np.radians(angle))), 0.0]}
    if isinstance(jump, tuple):
        c = 1 / (1 - 0.09 * 0.1)
        ply = [[10 * c, 0.3 * c, 0], [0.3 * c, c, 0], [0, 0, 0.5]]
        materials = [material(["root"], ply, jump[0]), material(["band", "tip"], ply, jump[1])]
    elif jump == "band":
        materials = [material(["root", "tip"], plain(1.0)), material(["band"], plain(1 / 125))]
    else:
        materials = [material(["root"], plain(jump)), material(["band", "tip"], plain(1.0))]
    return {"analysis": analysis, "mesh": {"file": str(mesh)}, "material": materials, "support": [{"type": "clamped", "group": "left"}],
            "load": [{"type": "line", "group": "right", "vector": [0, 0, 1.0]}], "eigen": {"modes": 1, "mass": "lumped"},
            "probe": [{"name": "tip", "type": "displacement", "group": "right", "components": ["z"]}]}


def strip_cells(nx, ny, length, width, jitter):
    """Points and triangles of a strip; vertices inside are moved by up to `jitter` of a cell, but stay on the lines at 5 and 6."""
    moved = np.random.default_rng(1)
    points = []
    for y in np.linspace(0, width, ny + 1):
        for x in np.linspace(0, length, nx + 1):
            dx, dy = moved.uniform(-jitter, jitter, 2) * (length / nx, width / ny)
            on_line = min(abs(x - at) for at in (0, 5, 6, length)) < 1e-9
            points.append((x + (0 if on_line else dx), y + (0 if y in (0, width) else dy), 0.0))
    corners = [(j * (nx + 1) + i, j * (nx + 1) + i + 1, (j + 1) * (nx + 1) + i + 1, (j + 1) * (nx + 1) + i) for j in range(ny) for i in range(nx)]
    return np.array(points), [t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))]


@test
def stiffness_jumps(report):
    """Where the bending stiffness jumps deflections and frequencies converge with second order, by slopes and by angles."""
    for name, (jump, deflection, frequency) in JUMPS.items():
        errors = {}
        for jitter in (0.0, 0.25):
            for n in (10, 40):
                case = jump_case(jump, n, jitter, "linear")
                errors[jitter, n] = abs(solve("jump", case, 1).history["tip_z"][-1] / deflection - 1)
            order = np.log(errors[jitter, 10] / errors[jitter, 40]) / np.log(4)
            report.check(errors[jitter, 40] < 1.5e-3 and (order > 1.6 or errors[jitter, 10] < 0.01),
                         f"{name}, vertices moved by {jitter}: error {100 * errors[jitter, 10]:.2f}, {100 * errors[jitter, 40]:.2f} %, order {order:.1f}")
        modal = solve("jump", jump_case(jump, 20, 0.25, "modal"), 1)
        first = 2 * np.pi * np.loadtxt(modal.folder / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[0, 1]
        report.below(abs(first / frequency - 1), 0.015, f"{name}: first frequency at 20 cells")
    by_angles = solve("jump", variant(jump_case(125.0, 20, 0.25, "linear"), {"element": {"type": "angles"}}), 1)
    report.percent(by_angles.history["tip_z"][-1] / JUMPS["125 times"][1], 0.01, "by angles")


@test
def membrane_jumps(report):
    """Constant forces through borders of materials: each side has its own strain, not the mean of both, on any mesh."""
    def pulled(band, analysis, load):
        case = jump_case(1.0, 10, 0.25, analysis)
        del case["eigen"]
        common = {**case["material"][1], "membrane": np.diag([1e8, 2e7, 4e7]).tolist(), "bending": np.diag([1e-5] * 3).tolist()}
        case["material"] = [{**common, "groups": ["root", "tip"]}, {**common, "groups": ["band"], **band}]
        case["load"][0]["vector"], case["probe"][0]["components"] = [load, 0, 0], ["x"]
        return case

    def stretch(natural):  # of 1e8 N/m under 1e4 N/m, from its natural length
        return max(np.roots([0.5, 0, -0.5 * natural**2, -1e-4]).real)

    def grained(across):  # one fabric whose pieces are cut along and across
        case = pulled({}, "linear", 1.0)
        file = OUT / "grained.obj"
        points, cells = strip_cells(10, 2, 10.0, 2.0, 0.25)
        text = "".join(f"v {x} {y} {z}\n" for x, y, z in points) + "".join(f"vt {x} {y}\nvt {y} {x + 20}\n" for x, y, _ in points)
        middle = [points[list(c)].mean(axis=0)[0] for c in cells]
        for name, here in (("root", lambda x: x < 5), ("band", lambda x: 5 < x < 6), ("tip", lambda x: x > 6)):
            text += f"g {name}\n" + "".join("f " + " ".join(f"{v + 1}/{2 * v + (2 if name == across else 1)}" for v in c) + "\n" for c, x in zip(cells, middle) if here(x))
        for name, x in (("left", 0.0), ("right", 10.0)):
            on = [k + 1 for k, p in enumerate(points) if abs(p[0] - x) < 1e-9]
            text += f"g {name}\nl " + " ".join(map(str, on)) + "\n"
        file.write_text(text)
        fabric = {k: v for k, v in case["material"][0].items() if k not in ("direction", "groups")} | {"texture_direction": [1.0, 0.0]}
        return case | {"mesh": {"file": str(file)}, "material": [fabric]}

    def heated():  # one material that is warmer in the band
        case = pulled({"expansion_strain": [-1e-4, 0, 0]}, "static", 1e4)
        band = case["material"].pop()
        return case | {"material": [band | {"groups": ["root", "band", "tip"]}], "temperature": [{"group": "band", "change": "30"}]}

    tight = max(np.roots([0.5e8, 0, 3e5 - 0.5e8, -1e4]).real)  # of a membrane with a force of 3e5 N/m at rest
    soft, turned = {"membrane": np.diag([1e7, 1e7, 4e6]).tolist()}, {"direction": [0.0, 1.0, 0.0]}
    for name, case, exact in (("a tenth as stiff", pulled(soft, "linear", 1.0), 9 / 1e8 + 1 / 1e7),
                              ("turned by 90 degrees", pulled(turned, "linear", 1.0), 9 / 1e8 + 1 / 2e7),
                              ("of the same fabric, cut across", grained("band"), 9 / 1e8 + 1 / 2e7),
                              ("prestressed", pulled({"prestress": [3e5, 0.0]}, "static", 1e4), 9 * stretch(1.0) + tight - 10),
                              ("of other temperature", heated(), 9 * stretch(1.0) + stretch(0.997) - 10),
                              ("shrunk", pulled({"initial_strain": [-3e-3, 0, 0]}, "static", 1e4), 9 * stretch(1.0) + stretch(0.997) - 10)):
        for ranks in (1, 2):
            moved = solve("membrane_jump", case, ranks).history["tip_x"][-1]
            # The correction of chords takes the kink of a line across the border for a bend: of second order in the jump of strain.
            report.below(abs(moved / exact - 1), 1e-4 if name in ("shrunk", "prestressed", "of other temperature") else 1e-6, f"a band {name}, {ranks} rank(s)")


@test
def corrected_roll(report):
    """Twelve cells rolled into a circle: without the term of fourth order in the curvature -u is 8 % too small."""
    case = base("cantilever_moment", mesh__parameters__nx=12, mesh__parameters__ny=1, mesh__parameters__pattern=0)
    result = solve("corrected_roll", case, 2)
    benchmark = BENCHMARKS["cantilever_moment"]
    computed, published = -result.history["tip_x"][-1], benchmark.reference[benchmark.curves[0].reference][-1]
    # Of an exact couple at the end; `angles` is off by 1e-4 on twice the cells.
    report.below(abs(computed / published - 1), 0.01, "error of -u")


@test
def stalled(report):
    """A run that ends without convergence names the triangles where the residual is largest, alike on 1 and 2 ranks."""
    case = strip_case(strip_mesh(OUT / "stalled.msh", 20, 2, 0.0), load__0__vector=[0, 0, 400.0])
    case["steps"] = {"initial_step": 1.0, "min_step": 0.9, "fallback": False}
    said = []
    for ranks in (1, 2):
        shutil.rmtree(OUT / f"stalled_{ranks}", ignore_errors=True)
        result = run(write_case(case, OUT / "stalled.toml"), OUT / f"stalled_{ranks}", ranks, ["-snes_max_it", "2"], 300)
        found = re.findall(r"the residual is largest at triangle \d+ at \([^)]*\), smallest angle [\d.e+]+ degrees", result.text)
        report.check(result.code == 3 and len(found) == 1, f"{ranks} rank(s): code {result.code}: {found}")
        said += found
    report.check(len(set(said)) == 1, "the same place")


@test
def coincident_vertices(report):
    """A plate with its middle line doubled bends like two plates; with mesh.merge it is the plate that was meant."""
    whole = strip_mesh(OUT / "coincident_whole.msh", 20, 2, 0.0)
    double = strip_mesh(OUT / "coincident_double.msh", 20, 2, 0.0, split=10)
    base_case = strip_case(whole, load__0__vector=[0, 0, 0.04])
    good = solve("coincident_whole", base_case, 1)
    case = variant(base_case, {"mesh.file": str(double), "mesh.merge": True})
    merged = solve("coincident_merged", case, 2)
    report.near(merged.history["tip_z"][-1] / good.history["tip_z"][-1], 1.0, 1e-9, "merged against whole, deflection")
    report.check("3 vertices were merged" in merged.text, "the run says how many were merged")
    code, text = invoke(["info", double])
    report.check(code == 0 and "6 vertices lie at 3 places" in text and "(5, 0, 0) to (5, 1, 0)" in text, "info counts them and says where")
    case["mesh"].pop("merge")
    code, text = invoke(["check", write_case(case, OUT / "coincident.toml")])
    report.check(code == 2 and "nothing holds it" in text and "20 triangles" not in text and "40 triangles" in text,
                 f"the loose half is refused: code {code}: {text.strip()[-160:]}")


@test
def sheet_formats(report):
    """One orthotropic sheet from OBJ (axis by texture), Abaqus, VTK and Gmsh (axis by direction): the same bending."""
    seeds = ROOT / "tests" / "fuzz" / "seeds"
    material = {"type": "orthotropic", "young_1": 1.2e6, "young_2": 1e5, "poisson_12": 0.2, "shear_12": 4e4, "thickness": 0.1}
    found = []
    for name, clamp, axis in (("square.obj", "rim", {"texture_direction": [2.0, 1.0]}), ("square.obj", "rim", {"direction": [2, 1, 0]}),
                              ("square.inp", "LEFT", {"direction": [2, 1, 0]}), ("square.vtk", "group-3", {"direction": [2, 1, 0]}),
                              ("square.obj", "rim", {"texture_direction": [1.0, 2.0]})):
        case = {"title": name, "mesh": {"file": str(seeds / name)}, "material": [material | axis],
                "support": [{"type": "clamped", "group": clamp}], "load": [{"type": "pressure", "magnitude": 2.0}],
                "probe": [{"name": "inside", "type": "displacement", "point": [1 / 3, 1 / 3, 0], "components": ["z"]}]}
        result = solve(f"sheet_formats_{len(found)}", case, 1 + len(found) % 2)
        found.append(result.history["inside_z"][-1])
        echo, text = invoke(["check", result.folder / "resolved_case.toml"])
        report.check(echo == 0, f"{name}: the echoed case is a valid case" + ("" if echo == 0 else f": {text.strip()}"))
    *found, other = found
    for value, name in zip(found[1:], ("OBJ by direction", "Abaqus", "VTK")):
        report.near(value / found[0], 1.0, 1e-9, f"{name} against OBJ by texture, deflection")
    report.check(abs(other / found[0]) > 1.2, f"it bends by {found[0]:.4g} m, with another axis by {other:.4g} m")


def two_pieces(file):
    """Squares one above the other, 10 mm apart: left is held, a and b are the edges that face each other."""
    file.write_text("""SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 1, 0.5};
Rectangle(2) = {0, -0.51, 0, 1, 0.5};
Physical Curve("left") = {3};
Physical Curve("b") = {1};
Physical Curve("a") = {7};
Physical Surface("plate") = {1, 2};
MeshSize { PointsOf{ Surface{1, 2}; } } = 0.25;
""")
    return file


@test
def nothing_held(report):
    """Statics of a sheet that nothing holds ends with code 2 before anything is factorised; motion and modes take it."""
    case = plate(6, 1.0)
    case["support"] = []
    code, text = invoke(["check", write_case(case, OUT / "nothing_held.toml")], 2)
    report.check(code == 2 and "6 free rigid-body motions" in text, f"check: code {code}: {text.strip()[-150:]}")
    code, text = invoke(["run", OUT / "nothing_held.toml", "--output", OUT / "nothing_held"])
    report.check(code == 2 and "nothing holds it" in text, f"run: code {code}")
    touching = case | {"contact": {"distance": 1e-3}}
    for c in (touching | {"analysis": "drape"}, {k: v for k, v in touching.items() if k != "analysis"} | {"stage": [{"name": "rest", "analysis": "drape"}]}):
        code, text = invoke(["check", write_case(c, OUT / "touching.toml")])
        report.check(code == 2 and "nothing ends a free translation" in text and text.count("touching.toml") == 1, f"contact holds nothing where nothing else is: code {code}: {text.strip()[-300:]}")
    case["support"] = [{"type": "displacement", "group": "left", "components": ["x", "z"]}]
    code, text = invoke(["check", write_case(case, OUT / "sliding.toml")])
    report.check(code == 2 and "1 translation(s) along (0, 1, 0)" in text, f"free to slide: code {code}: {text.strip()[-150:]}")
    case["support"] = [{"type": "hinged", "group": "left"}]
    code, text = invoke(["check", write_case(case, OUT / "hinged.toml")])
    report.check(code == 0 and "1 free rigid-body motion(s), 1 rotation(s)" in text, f"hung by one edge: code {code}, a note")
    threads = case | {"support": [{"type": "hinged", "group": "left"}], "spring": [{"type": "pair", "group": "a", "to": "b", "stiffness": 20.0, "length": 0.01}],
                      "mesh": {"file": str(two_pieces(OUT / "threads.geo"))}, "probe": [], "analysis": "drape"}
    code, text = invoke(["check", write_case(threads, OUT / "threads.toml")])
    report.check(code == 0 and "only loads can hold that" in text, f"a piece that hangs on threads: code {code}: {text.strip()[-150:]}")
    code, text = invoke(["check", write_case(threads | {"analysis": "linear"}, OUT / "threads.toml")])
    report.check(code == 2 and "translation(s)" in text and "along ," not in text, f"linear analysis knows no pendulum: code {code}: {text.strip()[-150:]}")
    case |= {"support": [], "analysis": "modal"}
    case["material"][0]["density"] = 7800
    code, text = invoke(["check", write_case(case, OUT / "free_modes.toml")])
    report.check(code == 0 and "nothing holds it" in text, f"modes of a free plate: code {code}")


@test
def absurd_numbers(report):
    """Sizes that no power of is a number end with code 2 on reading, whatever file or key they come from."""
    seeds = ROOT / "tests" / "fuzz" / "seeds"
    body = {"name": "body", "type": "mesh", "file": str(seeds / "body.obj")}
    huge = OUT / "absurd.obj"
    OUT.mkdir(parents=True, exist_ok=True)
    huge.write_text((seeds / "body.obj").read_text().replace("v 0.3 0.3 -0.3", "v 0.3 1e200 -0.3"))
    for k in range(2):
        (OUT / f"absurd_{k}.obj").write_text((seeds / "body.obj").read_text().replace("-0.3", "1e120" if k else "-0.3"))
    frames = {"frames": str(OUT / "absurd_*.obj"), "frames_per_second": 25}
    for name, changes, word in (
        ("sheet scaled up", {"mesh.scale": 1e300}, "scale"), ("sheet scaled down", {"mesh.scale": 1e-300}, "scale"),
        ("sheet with one far vertex", {"mesh.file": str(huge), "mesh.parameters": None}, "absurd.obj"),
        ("obstacle scaled up", {"obstacle": [body | {"scale": 1e300}]}, "body.obj"),
        ("obstacle with one far vertex", {"obstacle": [body | {"file": str(huge)}]}, "absurd.obj"),
        ("key frame far away", {"obstacle": [body | frames]}, "absurd_*.obj"),
        ("ball far away", {"obstacle.0.point": [0, 1e200, 0]}, "'ball'"), ("huge ball", {"obstacle.0.radius": 1e300}, "'ball'"),
        ("thick ball", {"obstacle.0.thickness": 1e300}, "radius and thickness"),
        ("stiff seams", {"sewing.stiffness": 1e30}, "sewing.stiffness: 1e+30: must be > 0 and <= 1e+10 [N/m^2]"),
        ("fast seams", {"sewing.speed": 1e30}, "sewing.speed"), ("strong seams", {"sewing.force": 1e30}, "sewing.force"),
        ("wide seams", {"sewing.gap": 1e30}, "sewing.gap"),
        *((f"a panel's {key}", {"mesh": None, "panel": [tube()["panel"][0] | {"name": "sleeve", key: value}]}, f"panel.{key}: [{value[0]:g}, 0, 0]: panel 'sleeve'")
          for key, value in (("origin", [1e300, 0, 0]), ("translate", [-2e6, 0, 0]), ("wrap_point", [1e300, 0, 0]))),
        ("a panel's wrap_shift", {"mesh": None, "panel": [tube()["panel"][0] | {"wrap_shift": 1e300}]}, "panel.wrap_shift"),
    ):
        code, text = invoke(["check", write_case(variant(sheet_on_ball(), changes), OUT / "absurd.toml")])
        text = " ".join(text.split())
        report.check(code == 2 and word in text, f"{name}: code {code}: {text[-130:]}")
    for key, value in (("material.0.membrane_damping", 1e300), ("time.step", 1e-300)):
        file = write_case(variant(sheet_on_ball(), {key: value, "contact": None, "obstacle": None}), OUT / "absurd.toml")
        code, text = invoke(["run", file, "--output", OUT / "absurd_run", "--overwrite"])
        text = " ".join(text.split())
        report.check(code == 3 and "no acceleration follows" in text, f"{key} = {value:g}: code {code}: {text[-130:]}")


@test
def foreign_scripts(report):
    """A .geo that runs a command does so under no subcommand unless it is allowed to; n = 1e9 is a user's mistake."""
    script, made = OUT / "foreign.geo", OUT / "foreign_was_here"
    made.unlink(missing_ok=True)
    script.write_text(f'SystemCall "touch {made}";\nInclude "{ROOT / "meshes" / "plate.geo"}";\n')
    case = variant(plate(4, 1.0), {"mesh": {"file": str(script)}})
    write_case(case, OUT / "foreign.toml")
    for arguments in (["info", script], ["check", OUT / "foreign.toml"], ["run", OUT / "foreign.toml", "--output", OUT / "foreign"]):
        code, text = invoke(arguments)
        report.check(code == 2 and "foreign.geo:1: 'SystemCall'" in text and not made.exists(), f"{arguments[0]}: code {code}")
    code, text = invoke(["info", script, "--allow-system-call"])
    report.check(code == 0 and made.exists(), f"info --allow-system-call: code {code}")
    # A machine of 3 GB: half of what is free is what a mesh may take, and to fill that of a large one takes long.
    limit = "ulimit -v 3000000; exec \"$0\" \"$@\""
    done = subprocess.run(["bash", "-c", limit, *command(["check", write_case(plate(1e9, 1.0), OUT / "huge.toml")])],
                          env=environment(1), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
    report.check(done.returncode == 2 and "plate.geo" in done.stdout and "memory" in done.stdout,
                 f"n = 1e9: code {done.returncode}: {done.stdout.strip()[-150:]}")
