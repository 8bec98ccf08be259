"""Cases from Nastran decks: what is read gives the answers of plate theory, what is not is listed."""

import math
import shutil

import numpy as np
from common import fresh
from harness import OUT, test
from solver import invoke, run

SIDE, THICKNESS, YOUNG, POISSON, DENSITY, PRESSURE = 1000.0, 10.0, 210e3, 0.3, 7.85e-9, 1e-3  # mm, N, t
CELLS = 40


def fixed(name, *fields):
    """A card in small fields, continued after eight."""
    words = [f"{f:>8}" for f in fields]
    return "".join(f"{name if k == 0 else '':<8}{''.join(words[k:k + 8])}\n" for k in range(0, len(words), 8))


def nastran_plate(solution, control):
    """A clamped plate whose points are given in axes that are turned and moved, in every form of field."""
    text = f"SOL {solution}\nCEND\nTITLE = Clamped plate\n{control}BEGIN BULK\n"
    text += "CORD2R,5,,100.,200.,300.,200.,200.,300.\n,100.,300.,300.\n"  # z along x, x along y, y along z
    for j in range(CELLS + 1):
        for i in range(CELLS + 1):
            x, y, tag = SIDE * i / CELLS, SIDE * j / CELLS, 1 + i + (CELLS + 1) * j
            if i % 3 == 0:
                text += fixed("GRID", tag, 5, f"{x:.1f}", f"{y:.1f}", "0.")
            elif i % 3 == 1:
                text += f"GRID,{tag},5,{x},{y},0.\n"
            else:
                text += f"{'GRID*':<8}{tag:>16}{5:>16}{x:>16.6E}{y:>16.6E}\n{'*':<8}{'0.':>16}\n"
    for j in range(CELLS):
        for i in range(CELLS):
            a = 1 + i + (CELLS + 1) * j
            text += fixed("CQUAD4", 1 + i + CELLS * j, 3, a, a + 1, a + CELLS + 2, a + CELLS + 1)
    edge = [1 + i + (CELLS + 1) * j for j in range(CELLS + 1) for i in range(CELLS + 1) if i in (0, CELLS) or j in (0, CELLS)]
    text += fixed("SPC1", 7, 123456, *edge) + "SPCADD,70,7\n"
    text += f"LOAD,40,2.,.5,4\nPLOAD4,4,1,{PRESSURE}\n" + f"PLOAD4,4,2,{PRESSURE},,,,THRU,30000000\nPLOAD4,9,1,77.\n"
    return text + f"PSHELL,3,2,{THICKNESS},2\nMAT1,2,2.1+5,,.3,7.85-9\nEIGRL,6,,,2\nTEMP,1,1,20.\nENDDATA\n"


@test
def nastran_decks(report):
    """A clamped plate from a Nastran deck deflects and vibrates as it should; what is not understood is listed with its line."""
    rigidity = YOUNG * THICKNESS**3 / 12 / (1 - POISSON**2)
    for solution, control in ((101, "LOAD = 41\nSUBCASE 1\n  SPC = 70\n  LOAD = 40\n"), ("SEMODES", "SPC = 70\nMETHOD = 6\n")):
        file, folder = OUT / f"nastran_{solution}.bdf", fresh(f"nastran_{solution}")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(nastran_plate(solution, control))
        code, text = invoke(["init", folder, "--from", file])
        report.check(code == 0 and "left out" in text and ": TEMP" in text and text.count("left out") == 1, f"{solution}: code {code}, {text.splitlines()[:2]}")
        result = run(folder / "case.toml", folder / "run")
        report.check(result.code == 0, f"{solution}: run, code {result.code}")
        if solution == 101:
            u = result.displacement()
            report.percent(u[:, 0].max() / (0.00126532 * PRESSURE * SIDE**4 / rigidity), 0.01, "deflection along x, the plate's normal")
            report.below(np.abs(u[:, 1:]).max(), 1e-9 * u.max(), "and none along the plate")
        else:
            first = np.loadtxt(folder / "run" / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[0, 1]
            report.percent(first / (35.9852 / (2 * math.pi * SIDE**2) * math.sqrt(rigidity / DENSITY / THICKNESS)), 0.01, "first frequency")
    bad = OUT / "nastran_bad.bdf"
    bad.write_text(nastran_plate(101, "").replace("CORD2R,5,,", "CORD2R,6,,"))
    shutil.rmtree(OUT / "nastran_bad", ignore_errors=True)
    code, text = invoke(["init", OUT / "nastran_bad", "--from", bad])
    report.check(code == 2 and "there is no coordinate system 5" in text and ".bdf:7: GRID" in text, f"a missing coordinate system: code {code}, {text.strip()[-160:]}")


@test
def abaqus_ties(report):
    """Two plates of a deck that *TIE joins along cells that do not match are one cantilever: w = F l^3 / (3 E I)."""
    nodes, elements = [], []
    for x, n in ((0.0, 4), (1.0, 5)):
        base = len(nodes)
        nodes += [(x + i / n, j / n) for i in range(n + 1) for j in range(n + 1)]
        corner = lambda i, j: base + i * (n + 1) + j + 1
        elements += [(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)) for i in range(n) for j in range(n)]
    end = [k + 1 for k, (x, _) in enumerate(nodes) if x > 1.999]
    deck = ["*NODE", *(f"{k + 1}, {x}, {y}, 0." for k, (x, y) in enumerate(nodes)), "*ELEMENT, TYPE=S4, ELSET=plates",
            *(f"{k + 1}, {a}, {b}, {c}, {d}" for k, (a, b, c, d) in enumerate(elements)),
            "*NSET, NSET=held", "1, 2, 3, 4, 5", "*NSET, NSET=end", ", ".join(map(str, end)),
            "*SURFACE, TYPE=NODE, NAME=slave", "two", "*SURFACE, TYPE=NODE, NAME=master", "one",
            "*TIE, NAME=line, POSITION TOLERANCE=0.001", "slave, master", "*MATERIAL, NAME=m", "*ELASTIC", "1e7, 0.",
            "*SHELL SECTION, ELSET=plates, MATERIAL=m", "0.01", "*BOUNDARY", "held, ENCASTRE", "*STEP", "*STATIC", "*CLOAD",
            *(f"{k}, 3, {1e-4 * (0.5 if k in (end[0], end[-1]) else 1)}" for k in end), "*END STEP"]
    folder = fresh("abaqus_ties")
    file = OUT / "abaqus_ties.inp"
    file.write_text("\n".join(deck) + "\n")
    code, text = invoke(["init", folder, "--from", file])
    report.check(code == 0 and "left out" not in text, f"init: code {code}, {text.splitlines()[:2]}")
    case = (folder / "case.toml").read_text()
    report.check("merge = true  # *TIE" in case and "merge_tolerance = 0.001" in case, "the case merges within the deck's tolerance")
    result = run(folder / "case.toml", folder / "run")
    report.check(result.code == 0, f"run: code {result.code}")
    deflection = result.displacement()[:, 2].max()
    report.percent(deflection / (5e-4 * 2**3 / (3 * 1e7 * 1e-6 / 12)), 0.01, "deflection of the end")


@test
def abaqus_details(report):
    """What a deck's keywords say besides: mass of a section, edges that are guided, axes of nodes; what is left out is listed."""
    nx, ny = 16, 2
    nodes = [(i, j) for j in range(ny + 1) for i in range(nx + 1)]
    elements = [(a + 1, a + 2, a + nx + 3, a + nx + 2) for j in range(ny) for a in range(j * (nx + 1), j * (nx + 1) + nx)]
    mesh = ["*Node", *(f"{k + 1}, {x / nx}, {0.1 * y}, 0." for k, (x, y) in enumerate(nodes)), "*Element, type=S4, elset=All",
            *(f"{k + 1}, {a}, {b}, {c}, {d}" for k, (a, b, c, d) in enumerate(elements)), "*Nset, nset=Root, generate", f"1, {len(nodes)}, {nx + 1}",
            "*Nset, nset=Tip, generate", f"{nx + 1}, {len(nodes)}, {nx + 1}", "*Material, name=M", "*Elastic", "1e9, 0.", "*Density", "1000.,",
            "*Boundary", "Root, ENCASTRE"]

    def begun(name, section, *rest):
        (OUT / f"{name}.inp").write_text("\n".join([*mesh, f"*Shell Section, elset=All, material=M{section}", "0.01,", *rest]) + "\n")
        code, said = invoke(["init", fresh(name), "--from", OUT / f"{name}.inp"])
        return code, " ".join(said.split()), OUT / name / "case.toml"

    def solved(name, *words):
        code, said, case = begun(name, *words)
        return run(case, fresh(f"{name}_run")), said

    modal = ["*Step", "*Frequency", "1,", "*End Step"]
    code, said, case = begun("abaqus_mass", ", density=30.", *modal)
    report.check(code == 0 and "density = 4000" in case.read_text() and "left out" not in said, f"mass of the section besides that of the material: {said[-120:]}")
    guided, said = solved("abaqus_guided", "", "*Step", "*Static", "*Boundary", "Tip, 1", "Tip, 4, 6", "*Cload", "Tip, 3, 1e-3", "*End Step")
    exact = 3e-3 / (12 * 1e9 * 0.2 * 0.01**3 / 12)
    report.percent(guided.displacement()[nx, 2] / exact, 0.01, f"an edge that is held in 1 and 4 to 6 does not turn: {said[-80:]}")
    patch = [f"{k + 1}" for k, (x, y) in enumerate(nodes) if x in (5, 6)]
    held = ["*Nset, nset=Patch", ", ".join(patch), "*Boundary", "Patch, ENCASTRE", "*Step", "*Static", "*Cload", "Tip, 3, 1e-3", "*End Step"]
    exact = 3e-3 * (10 / 16)**3 / (3 * 1e9 * 0.2 * 0.01**3 / 12)
    for name, both in (("abaqus_patch", []), ("abaqus_patch_both", ["*Elset, elset=Patch", "6, 22"])):  # as Abaqus/CAE writes a set
        patched, said = solved(name, "", *both, *held)
        report.percent(patched.displacement()[nx, 2] / exact, 0.02, f"the nodes of a strip of cells, held as a whole: {said[-80:]}")
    code, said, case = begun("abaqus_points", "", "*Nset, nset=Some", f"{nx + 1}, {nx // 2}", "*Boundary", "Some, ENCASTRE", "*Step", "*Static", "*End Step")
    report.check(code == 0 and "Some: rotations" in said and 'group = "Some"\ntype = "hinged"' in case.read_text(), f"points have no slope: {said[-160:]}")
    for what, words, listed, missing in (
            ("a load along axes of its nodes", ("*Transform, nset=Tip", "0., 0., 1., 0., 1., 0.", "*Step", "*Static", "*Cload", "Tip, 1, 1e-3", "*End Step"), "CLOAD or *DLOAD Tip", 'type = "point"'),
            ("a support along axes of its nodes", ("*Transform, nset=Tip", "0., 0., 1., 0., 1., 0.", "*Step", "*Static", "*Boundary", "Tip, 1, 1, 0.1", "*End Step"), "*BOUNDARY Tip", "value ="),
            ("supports of the modes alone", ("*Step", "*Buckle", "1,", "*Boundary, load case=2", "Tip, 1, 3", "*Cload", "Tip, 1, -1.", "*End Step"), "LOAD CASE=2", 'group = "Tip"\ntype = "hinged"'),
            ("a type of support", ("*Boundary", "Tip, YASYMM", "*Step", "*Static", "*End Step"), "*BOUNDARY Tip, YASYMM", 'group = "Tip"'),
            ("a parameter of a load", ("*Step", "*Static", "*Cload, cyclic mode=1", "Tip, 3, 1.", "*End Step"), "CYCLIC MODE", "nothing"),
            ("a node that is clamped", ("*Boundary", "8, ENCASTRE", "*Step", "*Static", "*End Step"), "HELD_1: rotations", 'group = "HELD_1"\ntype = "clamped"'),
            ("a stabilised procedure", ("*Step", "*Static, stabilize", "*End Step"), "*STATIC, STABILIZE", "nothing"),
            ("no number of modes", ("*Step", "*Frequency", ", , 100.", "*End Step"), "without a number of modes", "nothing")):
        code, said, case = begun("abaqus_details", "", *words)
        report.check(code == 0 and listed in said and missing not in case.read_text(), f"{what} is listed: code {code}, {said[-160:]}")
    code, said, _ = begun("abaqus_details", "", "*Node, input=more.txt")
    report.check(code == 2 and "*INCLUDE" in said, f"nodes of another file: code {code}, {said[-100:]}")
    for keyword in ("*Ngen", "*Nfill", "*Elgen", "*Elcopy"):
        code, said, _ = begun("abaqus_details", "", keyword, "1, 3, 1")
        report.check(code == 2 and f"{keyword.upper()}: nodes and elements that keywords make" in said, f"{keyword}: code {code}, {said[-100:]}")
    code, said, case = begun("abaqus_flat", "", "*Step", "*Static", "*Boundary", "Tip, ZSYMM", "*End Step")
    report.check('group = "Tip"\ntype = "sliding"\ncomponents = ["z"]' in case.read_text(), "an edge in the plane of its mirror is guided in it")
    plane, said = solved("abaqus_plane", "", "*Nset, nset=Plane, generate", f"1, {len(nodes)}, 1", "*Boundary", "Plane, 3, 5", "*Step", "*Static", "*Cload",
                         *(f"{(nx + 1) * (y + 1)}, 1, {1e3 * (1 + y % 2)}" for y in range(ny + 1)), "*End Step")
    report.percent(plane.displacement()[nx, 0] / (4e3 / (1e9 * 0.01 * 0.2)), 1e-6, f"a sheet that is held in its plane: {said[-80:]}")


@test
def abaqus_loads(report):
    """Surfaces under pressure, weight of one set, temperatures and rubber of a deck as Abaqus/CAE writes them."""
    nodes = [(i, j) for j in range(3) for i in range(5)]
    elements = [(a, a + 1, a + 6, a + 5) for a in (1, 2, 3, 4, 6, 7, 8, 9)]
    deck = "\n".join([
        "*Part, name=P", "*Node", *(f"{k + 1}, {x}., {y}., 0." for k, (x, y) in enumerate(nodes)), "*Element, type=S4R",
        *(f"{k + 1}, {a}, {b}, {c}, {d}" for k, (a, b, c, d) in enumerate(elements)),
        "*Elset, elset=one", "1, 2, 5, 6", "*Elset, elset=two", "3, 4, 7, 8", "*Nset, nset=held", "1, 6, 11",
        "*Shell Section, elset=one, material=Steel", "0.02, 5", "*Shell Section, elset=two, material=Steel", "0.01, 5", "*End Part",
        "*Assembly, name=A", "*Instance, name=P-1, part=P", "*End Instance", "*Nset, nset=All, instance=P-1, generate", "1, 15, 1",
        "*Surface, type=ELEMENT, name=Upper", "one, SPOS", "*Surface, type=ELEMENT, name=Lower", "two, SNEG", "*End Assembly",
        "*Material, name=Steel", "*Density", "8000.,", "*Expansion", "1e-5,", "*Elastic", "2e11, 0.3",
        "*Initial Conditions, type=TEMPERATURE", "All, 20.", "*Step, name=S, nlgeom=NO", "*Static", "1., 1.", "*Boundary", "held, ENCASTRE",
        "*Temperature", "All, 120.", "*Dload", "two, GRAV, 10., 0., 0., -1.", "*Dsload", "Upper, P, 1000.", "Lower, P, 300.", "*End Step"])

    def begin(name, text):
        file = OUT / f"{name}.inp"
        file.write_text(text + "\n")
        return (*invoke(["init", fresh(name), "--from", file]), OUT / name / "case.toml")

    code, said, case = begin("abaqus_loads", deck)
    report.check(code == 0 and "left out" not in said, f"all is understood: code {code}, {said[:200]}")
    with case.open("a") as file:
        file.write('\n[[probe]]\nname = "held"\ntype = "reaction"\ngroup = "held"\n')
    result = run(case, fresh("abaqus_loads_run"))
    # Pressures push into their side: down on 4 m^2, up on 4 m^2; 4 m^2 of 0.01 m weigh 8000 kg/m^3 * 10 m/s^2.
    report.percent(result.history["held_z"][-1] / (4000 - 1200 + 3200), 1e-6, "the supports carry pressures and weight")
    report.percent(result.displacement()[4::5, 0].mean() / (4 * 1e-5 * 100), 0.04, "the plate, clamped across, lengthens by the change of temperature")
    # Abaqus/CAE calls the set of a section and that of a support alike, and nodes and elements of a set, too.
    alike = deck.replace("elset=two", "elset=Set-1").replace("two, ", "Set-1, ").replace("*Assembly, name=A", "*Assembly, name=A\n*Nset, nset=Set-1, instance=P-1\n1, 6, 11\n"
                         "*Elset, elset=Set-1, instance=P-1\n1, 5").replace("held, ENCASTRE", "P-1.Set-1, ENCASTRE").replace("Set-1, SNEG", "two, SNEG")
    alike = alike.replace("*Dload\nSet-1, GRAV", "*Dload\ntwo, GRAV").replace("*Shell Section, elset=one", "*Elset, elset=two\n3, 4, 7, 8\n*Shell Section, elset=one")
    code, said, case = begin("abaqus_alike", alike)
    with case.open("a") as file:
        file.write('\n[[probe]]\nname = "held"\ntype = "reaction"\ngroup = "held"\n')
    again = run(case, fresh("abaqus_alike_run"))
    report.percent(again.history["held_z"][-1] / result.history["held_z"][-1], 1e-9, f"sets of one name in part and assembly: code {code}")
    report.below(np.abs(again.displacement() - result.displacement()).max(), 1e-12, "and the same displacements")
    for what, changes, words in (
            ("an amplitude of temperatures", (("*Temperature\n", "*Amplitude, name=A\n0., 0., 1., 1.\n*Temperature, amplitude=A\n"),), "*TEMPERATURE, AMPLITUDE"),
            ("expansion in two directions of an isotropic sheet", (("*Expansion\n1e-5,", "*Expansion, type=ortho\n1e-5, 3e-5, 0."),), "*EXPANSION, TYPE=ORTHO"),
            ("a ramp in a motion", (("nlgeom=NO", "amplitude=RAMP"), ("*Static\n1., 1.", "*Dynamic, explicit\n, 1.")), "AMPLITUDE=RAMP")):
        text = deck
        for old, new in changes:
            text = text.replace(old, new, 1)
        code, said, case = begin("abaqus_listed", text)
        report.check(code == 0 and words in said and invoke(["check", case])[0] == 0, f"{what} is listed: code {code}, {said[-160:]}")
    report.check("step = 0.01" in case.read_text(), "an explicit step that finds its own size begins with a hundredth")
    collapsed = deck.replace("8, 9, 10, 15, 14", "8, 9, 10, 15, 15")
    code, said, case = begin("abaqus_collapsed", collapsed)
    report.check(code == 0 and collapsed != deck and invoke(["check", case])[0] == 0 and "15 triangles" in invoke(["info", case.parent / "mesh.inp"])[1],
                 f"a quadrangle with a node twice is a triangle: code {code}")
    for what, change, words in (("coordinates along curves", ("*Node\n", "*Node, system=C\n"), "SYSTEM=C"), ("a system", ("*Node\n", "*System\n1., 0., 0.\n*Node\n"), "*SYSTEM")):
        code, said, _ = begin("abaqus_wrong", deck.replace(*change, 1))
        report.check(code == 2 and words in said, f"{what}: code {code}, {said.strip()[-120:]}")
    for law, constants, expected in (("neo hooke", "1e5, 0.", 'type = "neo_hookean"\nshear_modulus = 200000'),
                                     ("mooney-rivlin", "1e5, 2e4, 0.", 'type = "mooney_rivlin"\nc10 = 100000\nc01 = 20000'),
                                     ("ogden, n=2", "4e5, 2., 3e3, -2., 1e-9, 0.", 'type = "ogden"\nmu = [400000, -3000]\nalpha = [2, -2]')):
        text = deck.replace("*Elastic\n2e11, 0.3", f"*Hyperelastic, {law}\n{constants}").replace("*Expansion\n1e-5,\n", "")
        code, said, case = begin("abaqus_rubber", text.replace("*Temperature\nAll, 120.\n", ""))
        report.check(code == 0 and expected in case.read_text() and ("compressibility" in said) == ("1e-9" in constants)
                     and invoke(["check", case])[0] == 0, f"{law}: code {code}, {said[:120]}")


@test
def deck_orientations(report):
    """The angle of *ORIENTATION turns about its local axis, which may point against the normal of the shell."""
    def deck(name, elements, second_axis):
        text = ["*NODE", "1, 0, 0, 0", "2, 1, 0, 0", "3, 1, 1, 0", "4, 0, 1, 0", "5, 2, 0, 0", "6, 2, 1, 0", "*ELEMENT, TYPE=S4, ELSET=ALL", *elements,
                "*ORIENTATION, NAME=O", f"0, 1, 0, {second_axis}, 0, 0", "3, 30.", "*SHELL SECTION, COMPOSITE, ELSET=ALL, ORIENTATION=O",
                "0.1, 3, M, 0.", "0.1, 3, M, 90.", "*MATERIAL, NAME=M", "*ELASTIC, TYPE=LAMINA", "1e5, 1e4, 0.3, 4e3, 4e3, 4e3", "*DENSITY", "1e-9",
                "*STEP", "*FREQUENCY", "2", "*END STEP"]
        file = OUT / f"{name}.inp"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("\n".join(text) + "\n")
        folder = fresh(name)
        code, said = invoke(["init", folder, "--from", file])
        angles = next((line for line in (folder / "case.toml").read_text().splitlines() if line.startswith("angles")), "") if code == 0 else said
        return angles, said

    alike, opposite = ["1, 1, 2, 3, 4", "2, 2, 5, 6, 3"], ["1, 1, 2, 3, 4", "2, 2, 3, 6, 5"]
    # Axis 1 is y in both; the third is y x (-x) = z, along the normals, or -z.
    report.check(deck("orientation_along", alike, -1)[0] == "angles = [30, 120]", f"along the normals: {deck('orientation_along', alike, -1)[0]}")
    report.check(deck("orientation_against", alike, 1)[0] == "angles = [-30, 60]", f"against them: {deck('orientation_against', alike, 1)[0]}")
    text = (OUT / "orientation_along.inp").read_text().replace("TYPE=LAMINA\n1e5, 1e4, 0.3, 4e3, 4e3, 4e3", "TYPE=ISOTROPIC\n1e5, 0.3")
    file = OUT / "orientation_isotropic.inp"
    file.write_text(text.replace("SECTION, COMPOSITE,", "SECTION,").replace("0.1, 3, M, 0.\n0.1, 3, M, 90.", "0.2").replace("ELSET=ALL, ORIENTATION", "ELSET=ALL, MATERIAL=M, ORIENTATION"))
    code, said = invoke(["init", fresh("orientation_isotropic"), "--from", file])
    made = (OUT / "orientation_isotropic" / "case.toml").read_text() if code == 0 else said
    report.check('type = "isotropic"' in made and "direction = [0, 1, 0]" in made and "without the angle of 30 degrees" in said, f"of an isotropic section: {said[-200:]}")
    said = deck("orientation_mixed", opposite, -1)[1]
    report.check("against the normals of 2 of its 4 triangles" in said, f"normals that differ are said: {said[-300:]}")
