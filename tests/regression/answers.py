"""What users ask for besides solving: ranges of validity, stresses, springs, axes, histories, an installed program."""

import copy
import json
import os
import re
import shlex
import struct
import subprocess
import tomllib

import numpy as np
from common import fresh, plate, strip
from harness import OUT, solve, test
from shapes import write_msh
from solver import ROOT, environment, invoke, load_case, run, variant, write_case


@test
def out_of_range(report):
    """A strip stretched by 80 %, and one folded at an edge: one warning each with the place; the history has the figures."""
    stretched = solve("range_stretched", strip(load=[{"type": "line", "group": "tip", "vector": [1.2e5, 0, 0]}]), 2)
    said = [line for line in stretched.text.splitlines() if "membrane strain" in line]
    report.check(len(said) == 1 and " m at rest" in said[0], f"{said}")
    stretch = 1 + stretched.history["tip_x"][-1] / 10
    report.near(stretched.history["largest_strain"][-1], 0.5 * (stretch**2 - 1), 0.02, f"strain at a stretch of {stretch:.3f}")
    report.check(stretched.history["largest_turn"][-1] < 1e-6, "no edge turns")
    # Two cells pushed together by 7 of their 10 m, while a pressure lifts their middle.
    folded = strip(nx=2, ny=1, load=[{"type": "area", "vector": [0, 0, 2.0], "constant": True}],
                   support=[{"type": "hinged", "group": "clamp"}, {"type": "hinged", "group": "tip", "value": [-7, 0, 1]}],
                   steps={"initial_step": 0.02, "max_step": 0.05})
    bent = solve("range_folded", folded, 1)
    said = [line for line in bent.text.splitlines() if "across one edge" in line]
    report.check(len(said) == 1 and "(5, 0.5, 0) m at rest" in said[0], f"{said}")
    report.check(bent.history["largest_turn"][-1] > np.pi / 3, f"an edge turns by {np.degrees(bent.history['largest_turn'][-1]):.0f} degrees")
    small = solve("range_small", strip(), 1)
    report.check("warning" not in small.text, "no warning within the range")


@test
def units_declared(report):
    """A strip in metres and one in millimetres and tonnes, both with texts that carry units: one answer."""
    metres = strip(nx=10, material=[{"type": "isotropic", "young": "1.2 MPa", "poisson": 0.0, "thickness": "10 cm", "density": "1 g/cm^3"}],
                   load=[{"type": "line", "group": "tip", "vector": [0, 0, "0.4 N/m"]}, {"type": "pressure", "magnitude": "0.1 Pa"}])
    millimetres = copy.deepcopy(metres) | {"units": {"length": "mm", "mass": "t"}}
    millimetres["mesh"]["scale"] = 1000
    a, b = solve("units_si", metres, 1), solve("units_mm", millimetres, 1)
    report.below(abs(b.history["tip_z"][-1] / a.history["tip_z"][-1] / 1e3 - 1.0), 1e-9, "deflection in mm over that in m, less 1000")
    report.check("units: mm, t, s" in b.text and "units:" not in a.text, "the header names the units")
    report.check(b.results[-1].unit("displacement") == "mm" and a.results[-1].unit("displacement") == "m", "fields have them")
    inches = copy.deepcopy(metres) | {"units": {"length": "in", "mass": "slinch"}}
    inches["mesh"]["scale"] = 1 / 0.0254
    inches["material"][0]["young"] = 1.2e6 / 6894.757293168  # psi
    c = solve("units_in", inches, 1)
    report.below(abs(c.history["tip_z"][-1] / a.history["tip_z"][-1] * 0.0254 - 1.0), 1e-9, "and in inches, with a plain number in psi")
    for ending, words in (("obj", b"# lengths in mm"), ("stl", b"lengths in mm"), ("ply", b"comment lengths in mm")):
        code, said = invoke(["export", b.folder, "--output", OUT / f"units.{ending}"])
        report.check(code == 0 and words in (OUT / f"units.{ending}").read_bytes()[:200], f"an exported {ending} names the unit {said[:80]}")
    report.check("N, J, Pa, s and Hz in this text stand for mm, N, mJ, MPa, s and" in invoke(["check", OUT / "units_mm.toml"])[1], "and check")
    report.check((b.results.mesh().unit, a.results.mesh().unit) == ("mm", "m"), "positions have them, too")
    modes = [solve(f"units_modes_{k}", c | {"analysis": "modal", "load": []}, 1).folder for k, c in enumerate((metres, millimetres))]
    code, said = invoke(["compare", *modes])
    report.check(code == 2 and "lengths in m," in said and "in mm" in said, f"modes in m and mm are not compared: code {code} {said[-160:]}")
    report.check("units: mm" in invoke(["info", OUT / "units_mm.toml"])[1], "info of the case names them")
    fabric = dict(metres, material=[{"type": "fabric", "fabric": "wool_tropical", "direction": [1, 0, 0]}], load=metres["load"][:1])
    small = copy.deepcopy(fabric) | {"units": {"length": "mm", "mass": "g", "time": "ms"}}
    small["mesh"]["scale"] = 1000
    a, b = (solve(f"units_fabric_{k}", dict(c, analysis="modal"), 1).summary["eigenvalues"][0] for k, c in enumerate((fabric, small)))
    report.below(abs(1e3 * b / a - 1.0), 1e-6, "the first frequency of a fabric, in 1/ms and in Hz (to the solver's tolerance)")
    columns = [(OUT / f"units_fabric_{k}" / "modes.csv").read_text().split(",")[1] for k in range(2)]
    report.check(columns == ["frequency_hz", "frequency_per_ms"], f"its column: {columns}")
    forgotten = plate(40, 1.0) | {"analysis": "linear", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 40, "side": 200}}}
    forgotten["material"][0]["thickness"] = "2 mm"
    large = solve("units_forgotten", forgotten, 1)
    report.check("if the mesh is in millimetres" in large.text, "a mesh of 200 m with 2 mm is pointed out")


@test
def units_of_motion(report):
    """A sheet held by the default attachment to a body that a file moves: the same in m, kg, s and in mm, g, ms; exports count seconds."""
    frames = np.array([[[x, y, 0.0], [x + 0.1, y, 0.0], [x, y + 0.1, 0.0]] for x, y in ((0.0, 0.0), (0.02, 0.0), (0.02, 0.03))])
    (OUT / "carrier.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in frames[0]) + "f 1 2 3\n")
    with open(OUT / "carrier.mdd", "wb") as out:
        out.write(struct.pack(">2i3f", 3, 3, 0.0, 0.1, 0.2) + frames.astype(">f4").tobytes())
    metres = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.05, "n": 4}, "translate": [0.0, 0.0, 0.01]},
              "material": [{"type": "isotropic", "young": "1 MPa", "poisson": 0.3, "thickness": "1 mm", "density": "200 kg/m^3"}],
              "load": [{"type": "gravity", "vector": ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]}],
              "obstacle": [{"name": "carrier", "type": "mesh", "file": str(OUT / "carrier.obj"), "frames": str(OUT / "carrier.mdd"), "frames_smoothing": "50 ms"}],
              "attachment": [{"groups": ["left", "right"], "obstacle": "carrier"}],
              "time": {"end": "0.2 s", "step": "10 ms", "velocity_tolerance": "1e-6 m/s"}, "damping": {"mass": "20 Hz"},
              "probe": [{"name": "edge", "type": "displacement", "group": "left"}], "output": {"every": 5}}
    millimetres = copy.deepcopy(metres) | {"units": {"length": "mm", "mass": "g", "time": "ms"}}
    millimetres["mesh"] |= {"scale": 1000, "translate": [0.0, 0.0, 10.0]}
    millimetres["obstacle"][0]["scale"] = 1000
    a, b = (solve(f"units_motion_{k}", case) for k, case in enumerate((metres, millimetres)))
    for axis in "xyz":
        report.below(abs(b.history[f"edge_{axis}"][-1] / a.history[f"edge_{axis}"][-1] / 1e3 - 1), 1e-5, f"along {axis}: {a.history[f'edge_{axis}'][-1]:.4g} m")
    report.below(np.abs(b.results[-1].obstacles / 1e3 - a.results[-1].obstacles).max(), 1e-8, "the body")
    said = (b.folder / "resolved_case.toml").read_text()
    report.check("# [mm]" in said and "# [m]" not in said and "# stiffness: 1e4 in SI units" in said, "the case with every value names its units")
    ends = []
    for k, done in enumerate((a, b)):
        made = OUT / f"units_motion_{k}"
        ends.append([])
        for ending in ("mdd", "usda", "glb"):
            code, text = invoke(["export", done.folder, "--output", made.with_suffix(f".{ending}")])
            report.check(code == 0, f"{ending}: {text[-100:] if code else 'made'}")
        count, = struct.unpack(">i", made.with_suffix(".mdd").read_bytes()[:4])
        ends[k].append(struct.unpack(f">{count}f", made.with_suffix(".mdd").read_bytes()[8:8 + 4 * count])[-1])
        ends[k].append(float(re.search(r"endTimeCode = ([\d.]+)", made.with_suffix(".usda").read_text())[1]) / 25)
        content = made.with_suffix(".glb").read_bytes()
        gltf = json.loads(content[20:20 + struct.unpack("<I", content[12:16])[0]])
        ends[k].append(gltf["accessors"][gltf["animations"][0]["samplers"][0]["input"]]["max"][0])
    report.below(np.abs(np.array(ends) - 0.2).max(), 1e-6, f"ends of films [s]: {ends}")
    code, text = invoke(["plot", b.folder, "--y", "edge_z", "--output", OUT / "units_motion.svg"])
    report.check(code == 0 and "time [ms]" in (OUT / "units_motion.svg").read_text(), f"a diagram names the unit of time {text[-100:]}")


@test
def linear_values(report):
    """All that a linear analysis tells is linear: reactions balance loads of any size, fields are proportional, stored energy is half the work."""
    hemisphere = {"mesh.file": str(ROOT / "meshes" / "hemisphere.geo"), "mesh.parameters": {"n": 8}}
    curved = variant(load_case(ROOT / "runs" / "linear" / "hemisphere_hole.toml"), hemisphere)
    for name, case in (("flat", strip("linear", nx=10)), ("curved", curved)):
        case["probe"].append({"name": "energy", "type": "energy"})
        known = []
        for k, size in enumerate((1.0, 1e6)):
            scaled = copy.deepcopy(case)
            for load in scaled["load"]:
                load["vector"] = [size * c for c in load["vector"]]
            result = solve(f"linear_values_{name}_{k}", scaled, 1 + k)
            step, h = result.results[-1], result.history
            stored, work = h["energy_membrane"][-1] + h["energy_bending"][-1], -h["energy_external"][-1]
            report.below(abs(stored / work - 0.5), 1e-7, f"{name} x {size:g}: stored energy over work, less a half")
            if name == "flat":
                report.below(abs(step["reaction"][:, 2].sum() / size + 0.4), 1e-7, f"{name} x {size:g}: the reactions balance the load")
            known.append([step[field] / size for field in ("reaction", "bending_moment", "membrane_force", "membrane_strain")]
                         + [np.array([result.summary["membrane_error"], result.summary["recovery_error"]])])
        # A strip that only bends has membrane forces and strains of no more than round-off.
        bent = {"strain": 2e-3, "force": 240.0} if name == "flat" else {}
        for field, (small, large) in zip(("reaction", "moment", "force", "strain", "error"), zip(*known)):
            # Fields are central differences over 1e-5 of a cell: their round-off is 1.1e-6, and depends on the order of sums.
            report.below(np.abs(small - large).max(), 2e-6 * bent.get(field, max(np.abs(small).max(), 1.0 if field == "error" else 0.0)),
                         f"{name}: {field}s are proportional")
    small = copy.deepcopy(case) | {"analysis": "static", "steps": {"initial_step": 1.0}}
    for load in small["load"]:
        load["vector"] = [1e-3 * c for c in load["vector"]]
    static = solve("linear_values_static", small).summary
    for estimate in ("membrane_error", "recovery_error"):
        report.percent(result.summary[estimate] / static[estimate], 0.02, f"{name}: {estimate} {static[estimate]:.2e} as of a small load")
    energy = {"probe": [{"name": "energy", "type": "energy"}]}
    laminate = strip("linear", nx=10, material=[{"type": "laminate", "young_1": 1.4e11, "young_2": 1e10, "poisson_12": 0.3, "shear_12": 5e9, "angles": [0, 30, 90],
                                                 "ply_thicknesses": [1e-3], "direction": [1, 0.5, 0]}], load=[{"type": "line", "group": "tip", "vector": [2e3, 100, 300]}])
    large = copy.deepcopy(laminate)
    large["load"][0]["vector"] = [2e6, 1e5, 3e5]
    one, many = (solve("linear_coupled", c).summary["membrane_error"] for c in (laminate, large))
    report.below(abs(many / one - 1), 1e-3, f"membrane_error {one:.2e} of a laminate that couples, of a thousand times the load over that of one")
    # A strip bent to many times its length, strainless: so say the strain that is linear, and the turn that is.
    turned = [solve("linear_turned", strip("linear", nx=10, load=[{"type": "line", "group": "tip", "vector": [0, 0, size]}])).history for size in (1.0, 1e3)]
    for column in ("largest_strain", "largest_turn"):
        report.below(abs(turned[1][column][-1] - 1e3 * turned[0][column][-1]), 1e-6 * (1 + 1e3 * turned[0][column][-1]), f"{column} {turned[1][column][-1]:.3g} is proportional")
    dead, follower = (solve("linear_follower", strip("linear", nx=10, load=[{"type": kind, "magnitude": 1e-3}]) | energy).history["energy_bending"][-1]
                      for kind in ("pressure", "follower_pressure"))
    report.near(follower / dead, 1.0, 0.01, "energy of bending under a follower pressure over that of a dead one")
    for kind, group in (("follower_pressure", "plate"), ("follower_moment", "tip")):
        one, many = (solve("linear_far", strip("linear", nx=10, load=[{"type": kind, "group": group, "magnitude": size}])).history["tip_z"][-1] for size in (1.0, 1e6))
        report.below(abs(many / one / 1e6 - 1), 1e-9, f"deflection under a {kind}, 1e6 times as large, over that of one")
    moment = strip("linear", nx=10, load=[{"type": "follower_moment", "group": "tip", "magnitude": 0.1}]) | energy
    # m^2 L/(2 D)
    report.percent(solve("linear_moment", moment).history["energy_bending"][-1] / (0.1**2 * 10 / (2 * 1.2e6 * 0.1**3 / 12)), 1e-4, "energy of bending under a moment at the edge")


@test
def linear_output(report):
    """The cost of output grows with the number of steps, not with its square: results.vtkhdf is not rewritten in every step."""
    case = strip("dynamic", nx=4, ny=1, time__end=2.0, time__step=0.002, load=[{"type": "line", "group": "tip", "vector": [0, 0, 0.01]}])
    result = solve("linear_output", case, 1)
    report.check(len(result.results) == 1001, f"{len(result.results)} steps in the results")
    wall = result.history["wall_seconds"]
    first, last = wall[200] - wall[0], wall[1000] - wall[800]
    report.check(last < 4 * first, f"first 200 steps {first:.2f} s, last 200 steps {last:.2f} s (they took 10 times as long)")


@test
def chains(report):
    """A motion from a static equilibrium stays there; a drape from a motion; initial velocities; --set; the schema."""
    static = solve("chain_static", strip(), 2)
    moved = strip("dynamic", time__load_history="1")
    result = run(write_case(moved, OUT / "chain_motion.toml"), fresh("chain_motion"), 2, ["--restart", static.results.file])
    tip = static.history["tip_z"][-1]
    report.check(result.code == 0 and result.history["time"][0] == 0, f"a motion begins at the equilibrium: code {result.code}")
    report.below((np.abs(result.history["tip_z"] - tip) / tip).max(), 1e-6, "it stays there: change of the tip")
    back = run(write_case(strip(), OUT / "chain_back.toml"), fresh("chain_back"), 1, ["--restart", OUT / "chain_motion" / "checkpoint.h5"])
    report.check(back.code == 0, f"a static path from a motion: code {back.code}")
    report.below(back.history["tip_z"][-1] / tip - 1, 1e-6, "it finds the same equilibrium")
    thrown = strip("dynamic", support=[], load=[], initial_velocity=[{"velocity": [1, 2, 3], "angular_velocity": [0, 0, 2], "centre": [5, 0.5, 0]}],
                   time__end=0.1)
    result = solve("chain_thrown", thrown, 2)
    u = result.displacement()
    report.below(np.abs(u.mean(axis=0) - 0.1 * np.array([1, 2, 3])).max(), 1e-3, "a thrown sheet flies on: error of the middle [m]")
    x = rest(result) + u
    turned = np.arctan2(*(x[np.argmax(data_x(result))] - x.mean(axis=0))[[1, 0]]) - np.arctan2(*(rest(result)[np.argmax(data_x(result))] - rest(result).mean(axis=0))[[1, 0]])
    report.near(turned, 0.2, 2e-3, "and turns [rad]")
    file = write_case(strip(), OUT / "chain_set.toml")
    code, text = invoke(["check", file, "--set", "mesh.parameters.nx=7", "--set", "load.0.vector=[0, 0, 1]"])
    report.check(code == 0 and "24 vertices" in text, f"--set: code {code}: {text.splitlines()[0]}")
    for wrong, word in (("load.3.vector=[0,0,1]", "load"), ("mesh.paramters.n=3", "paramters"), ("nonsense", "key=value"), ("title.x=1", "title")):
        code, text = invoke(["check", file, "--set", wrong])
        report.check(code == 2 and word in text, f"--set {wrong}: code {code}: {text.strip()[-90:]}")
    schema = json.loads(invoke(["reference", "--schema"])[1])
    template = tomllib.loads((ROOT / "runs" / "templates" / "shell" / "case.toml").read_text())
    report.check(set(template) <= set(schema["properties"]) and not schema["additionalProperties"], "the schema knows the template's sections")
    report.check(schema["properties"]["material"]["items"]["properties"]["poisson"]["maximum"] == 0.5, "and ranges")


def rest(result):
    return result.results.mesh().positions


def data_x(result):
    return rest(result)[:, 0]


@test
def stops_are_recorded(report):
    """Fields are there at every stop of a path and at its end, however seldom they are written."""
    case = strip(steps={"initial_step": 0.02, "max_step": 0.02, "stops": [0.05, 0.11], "final_load_factor": 0.15}, output={"fields": ["displacement"], "every": 100})
    case.pop("time")
    found = [round(step.load_factor, 9) for step in solve("stops_recorded", case).results]
    report.check(found == [0.0, 0.05, 0.11, 0.15], f"load factors {found}")


@test
def springs_and_masses(report):
    """A plate strip on springs sinks by force / stiffness; a point mass at the tip lowers the frequency as beam theory says."""
    length, width, pressure, k = 10.0, 1.0, 3.0, 50.0
    case = strip(support=[{"type": "displacement", "group": "plate", "components": ["x", "y"]}], load=[{"type": "pressure", "magnitude": pressure}],
                 spring=[{"type": "area", "stiffness": k}])
    sunk = solve("springs_area", case, 2)
    report.near(sunk.history["tip_z"][-1], pressure / k, 1e-9, "elastic foundation: deflection [m]")
    case = strip(support=[{"type": "clamped", "group": "clamp"}], spring=[{"type": "line", "group": "tip", "stiffness": 1e7, "direction": [0, 0, 1]}])
    held = solve("springs_line", case, 1)
    report.below(held.history["tip_z"][-1], 1e-6, "a stiff spring line holds the tip [m]")
    mass, density, h = 200.0, 100.0, 0.1
    case = strip("modal", nx=40, ny=4, load=[], mass=[{"group": "tip", "mass": mass / 5}])
    first = float((solve("masses", case, 2).folder / "modes.csv").read_text().splitlines()[1].split(",")[1])
    ei = 1.2e6 * width * h**3 / 12
    # Rayleigh's quotient with the static deflection under the tip mass: 33/140 of the beam's mass counts.
    expected = np.sqrt(3 * ei / length**3 / (mass + 33 / 140 * density * h * width * length)) / (2 * np.pi)
    report.below(first / expected - 1, 0.01, f"frequency with a mass at the tip, {first:.5f} Hz: difference from beam theory")
    weight = strip("static", load=[{"type": "gravity", "vector": [0, 0, -1e-3]}], mass=[{"group": "tip", "mass": mass / 3}])
    tip = solve("masses_weight", weight, 1).history["tip_z"][-1]
    expected = -1e-3 * length**3 / ei * (mass / 3 + density * h * width * length / 8)
    report.below(tip / expected - 1, 0.02, "weight of the mass: difference from beam theory")


@test
def stresses(report):
    """A bent strip: top and bottom stress are -+6 M/h^2; of a laminate, each ply carries what its stiffness gives it."""
    load, length, h = 1e-4, 10.0, 0.1
    case = strip("linear", nx=80, ny=8, load=[{"type": "line", "group": "tip", "vector": [0, 0, load]}],
                 output={"fields": ["displacement"], "every": 1, "stresses": "surface"})
    result = solve("stresses", case, 2)
    step = result.results.step(1)
    centre = step.mesh.positions[step.mesh.triangles].mean(axis=1)
    middle = (np.abs(centre[:, 0] - 4) < 1) & (np.abs(centre[:, 1] - 0.5) < 0.3)
    expected = 6 * load * (length - centre[middle, 0]) / h**2
    for side, sign in (("top", -1), ("bottom", 1)):
        principal = step[f"principal_stress_{side}"][middle, 0 if sign > 0 else 1]
        report.below(np.abs(principal / (sign * expected) - 1).max(), 0.02, f"{side}: principal stress against 6 M / h^2")
        report.below(np.abs(step[f"von_mises_{side}"][middle] / expected - 1).max(), 0.02, f"{side}: von Mises")
    ply = {"type": "laminate", "young_1": 1e7, "young_2": 1e6, "poisson_12": 0.0, "shear_12": 5e5, "angles": [0, 90, 0],
           "ply_thicknesses": [h / 3], "direction": [1, 0, 0]}
    pulled = strip("linear", nx=20, ny=4, material=[ply], load=[{"type": "line", "group": "tip", "vector": [0.003, 0, 0]}],
                   output={"fields": ["displacement"], "every": 1, "stresses": "plies"})
    step = solve("stresses_plies", pulled, 1).results.step(1)
    strain = 0.003 / ((2 * 1e7 + 1e6) * h / 3)
    for number, modulus in ((1, 1e7), (2, 1e6), (3, 1e7)):
        report.below(np.abs(step[f"stress_ply_{number}_top"][:, 0] / (modulus * strain) - 1).max(), 1e-6, f"ply {number}: stress along the strip")


@test
def local_axes(report):
    """A support in turned axes is the turned support; a tube under pressure free to grow radially only."""
    angle = np.radians(30)
    direction = [float(np.cos(angle)), float(np.sin(angle)), 0.0]
    case = strip("linear", load=[{"type": "area", "vector": [2.0, 0.5, 0.0]}],
                 support=[{"type": "hinged", "group": "clamp"},
                          {"type": "displacement", "group": "tip", "components": ["x"], "x_axis": direction, "value": [0.01, 0, 0]},
                          {"type": "displacement", "group": "plate", "components": ["z"]}])
    result = solve("local_axes", case, 2)
    u = np.array([result.history[f"tip_{k}"][-1] for k in "xy"])
    report.near(float(u @ direction[:2]), 0.01, 1e-12, "displacement along the local x [m]")
    report.check(abs(float(u @ [-direction[1], direction[0]])) > 1e-6, "free across it")
    wrong = strip(support=[{"type": "displacement", "group": "clamp", "components": ["x"], "y_axis": [0, 1, 0]}])
    code, text = invoke(["check", write_case(wrong, OUT / "local_axes_wrong.toml")])
    report.check(code == 2 and "x_axis" in text, f"y_axis alone: code {code}")
    poisson, inner, outer = 0.3, 6.0, 10.0
    ring = {"title": "Ring", "analysis": "linear",
            "mesh": {"file": str(ROOT / "meshes" / "annulus.geo"), "parameters": {"n_radial": 16, "n_circ": 160}},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": poisson, "thickness": 0.03}],
            "support": [{"type": "displacement", "group": "plate", "components": ["y", "z"], "cylinder_axis": [0, 0, 1]},
                        {"type": "displacement", "group": "inner", "components": ["x"], "cylinder_axis": [0, 0, 1], "value": [0.1, 0, 0]}]}
    result = solve("local_axes_ring", ring, 2)
    x, u = rest(result), result.displacement()
    radius = np.hypot(x[:, 0], x[:, 1])
    radial = (u[:, :2] * x[:, :2]).sum(axis=1) / radius
    # Lame's ring in plane stress: u = A r + B / r, no stress at the outer edge.
    b = 0.1 / ((1 - poisson) / (1 + poisson) * inner / outer**2 + 1 / inner)
    exact = b * ((1 - poisson) / (1 + poisson) * radius / outer**2 + 1 / radius)
    report.below(np.abs(radial - exact).max() / 0.1, 2e-3, "ring in cylindrical axes: error of the radial displacement")
    report.below(np.abs(u[:, 0] * x[:, 1] - u[:, 1] * x[:, 0]).max(), 1e-12, "nothing turns")


@test
def own_histories(report):
    """A load with a history of its own moves the strip as the same history of the load factor does."""
    load = {"type": "line", "group": "tip", "vector": [0, 0, 0.4]}
    one = solve("history_factor", strip("dynamic", time__load_history="sin(20*t)"), 1)
    two = solve("history_own", strip("dynamic", load=[load | {"history": "sin(20*t)"}]), 2)
    report.below(np.abs(one.history["tip_z"] - two.history["tip_z"]).max() / np.abs(one.history["tip_z"]).max(), 1e-8, "difference")
    pressure = {"type": "follower_pressure", "magnitude": 0.04}
    one = solve("history_follower_factor", strip("dynamic", time__load_history="t/0.2", load=[pressure]), 1)
    two = solve("history_follower_own", strip("dynamic", load=[pressure | {"history": "t/0.2"}]), 1)
    report.below(np.abs(one.history["tip_z"] - two.history["tip_z"]).max() / np.abs(one.history["tip_z"]).max(), 1e-8, "follower: difference")


@test
def edge_moments(report):
    """A moment on edges bends every triangle alike, those at the edge too, on any mesh; where a support holds the slope it is refused."""
    young, thickness, poisson, m = 1.2e6, 0.1, 0.3, 0.05
    rigidity = young * thickness**3 / 12 / (1 - poisson**2)
    plate = {"title": "Quarter of a plate", "analysis": "linear", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 7, "pattern": 2}},
             "material": [{"type": "isotropic", "young": young, "poisson": poisson, "thickness": thickness}],
             "support": [{"type": "symmetry", "group": "left"}, {"type": "symmetry", "group": "bottom"}, {"type": "displacement", "group": "centre", "components": ["z"]}],
             "load": [{"type": "follower_moment", "group": side, "magnitude": m} for side in ("top", "right")], "probe": [{"name": "energy", "type": "energy"}]}
    curvature = m / rigidity / (1 + poisson)  # of a sphere
    for ranks in (1, 3):
        result = solve(f"edge_moments_{ranks}", plate, ranks)
        report.below(np.abs(result.results[-1]["bending_moment"] / m - [1, 1, 0]).max(), 1e-6, "moments: error")
        x, z = result.results[-1].mesh.positions, result.displacement()[:, 2]
        report.below(np.ptp(z - 0.5 * curvature * (x[:, 0] ** 2 + x[:, 1] ** 2)) / np.ptp(z), 1e-6, "a sphere: error")
        report.percent(result.history["energy_bending"][-1] / (m * curvature), 1e-6, "energy of bending")
    tip = [{"type": "follower_moment", "group": "tip", "magnitude": m}]
    end = {"group": "tip", "slope": "free", "turn": "held", "translation": ["free", "free", "free"]}
    step = solve("edge_moment_body", strip("linear", load=tip, rigid=[end], probe=[]), 3).results[-1]
    report.below(np.abs(step["bending_moment"] / m - [1, 0, 0]).max(), 1e-6, "an edge of a rigid group that leaves the slope free: moments, error")
    for name, case, words in (("clamped", strip(load=[tip[0] | {"group": "clamp"}]), "slope held by a [[support]]"),
                              ("hinged", strip(load=tip, hinge=[{"group": "tip", "stiffness": 10.0}]), "turns a [[hinge]]"),
                              ("rigid", strip(load=tip, rigid=[{"group": "tip"}], probe=[]), "turns with a [[rigid]] group")):
        code, text = invoke(["check", write_case(case, OUT / "edge_moment_held.toml")])
        report.check(code == 2 and words in text, f"a moment on a {name} edge: code {code} {text.strip()[-120:] if code != 2 else ''}")
    laminate = {"type": "laminate", "young_1": 1.4e11, "young_2": 1e10, "poisson_12": 0.3, "shear_12": 5e9, "angles": [0, 90], "ply_thicknesses": [1e-3], "direction": [1, 0, 0]}
    text = invoke(["check", write_case(strip(load=tip, material=[laminate]), OUT / "edge_moment_coupled.toml")])[1]
    report.check("note: [[load]] type 'follower_moment' on an unsymmetric laminate" in text, "what it does to an unsymmetric laminate is noted")


@test
def few_unknowns(report):
    """Follower loads on a mesh of eight triangles, on one rank: MUMPS orders the unknowns itself."""
    case = strip(nx=4, ny=1, load=[{"type": "follower_moment", "group": "tip", "magnitude": -60.0}])
    one, two = (solve(f"few_unknowns_{n}", case, n) for n in (1, 2))
    report.below(np.abs(one.displacement() - two.displacement()).max(), 1e-9, "1 and 2 ranks: difference [m]")
    report.check(one.history["tip_z"][-1] != 0, f"the tip moves by {one.history['tip_z'][-1]:.4g} m")


@test
def installed(report):
    """cmake --install brings the program, its manual page, completion, fabrics, templates and examples, and works from there."""
    prefix = fresh("installed")
    done = subprocess.run(["cmake", "--install", ROOT / "build", "--prefix", prefix], text=True, capture_output=True)
    report.check(done.returncode == 0, f"code {done.returncode} {done.stderr[-200:]}")
    for file in ("bin/voile", "share/man/man1/voile.1", "share/bash-completion/completions/voile"):
        report.check((prefix / file).is_file(), file)
    for helper in ("voile-picture", "voile-gmsh", "voile-manikin"):  # loading those takes longer than much of their work
        needed = subprocess.run(["readelf", "-d", prefix / "bin" / helper], text=True, capture_output=True).stdout
        report.check("libm.so" in needed and not re.search("petsc|slepc|libmpi", needed), f"{helper} needs no library of the solver")
    script = f"source {prefix}/share/bash-completion/completions/voile; COMP_WORDS=(voile run --ov); COMP_CWORD=2; _voile; echo ${{COMPREPLY[@]}}"
    text = subprocess.run(["bash", "-c", script], text=True, capture_output=True, env=os.environ).stdout
    report.check(text.strip() == "--overwrite", f"completion of --ov: {text.strip()}")
    for case in ("examples/hemisphere/case.toml", "templates/drape/case.toml"):
        done = subprocess.run([prefix / "bin" / "voile", "check", prefix / "share" / "voile" / case], text=True, capture_output=True, env=environment(1))
        report.check(done.returncode == 0, f"check {case}: code {done.returncode} {done.stderr[-200:]}")
    env = environment(1) | {"PATH": f"{prefix / 'bin'}:{os.environ['PATH']}"}
    user = fresh("installed_user")
    user.mkdir()
    done = subprocess.run("voile init blade --modal && voile run blade/case.toml --output blade/run", shell=True, cwd=user, text=True, capture_output=True, env=env)
    report.check(done.returncode == 0 and "voile render blade/run" in done.stdout, f"a template runs elsewhere: code {done.returncode} {done.stderr[-200:]}")


@test
def templates(report):
    """Each template of init passes check without a warning; shells also run without one, and the printed command draws them. Drape and skirt, which take a minute, run in the tutorials."""
    code, text = invoke(["init", "--list"])
    names = re.findall(r"^  --(\w+)", text, re.M)
    report.check(code == 0 and len(names) >= 4, f"--list: {names}")
    for name in names:
        folder = fresh(f"template_{name}") / "case"
        code, text = invoke(["init", folder, f"--{name}"])
        report.check(code == 0, f"init --{name}: code {code}")
        commands = re.findall(r"^  voile (.*)$", text, re.M)
        short = name in ("shell", "modal")
        for command in commands if short else commands[:1]:
            code, text = invoke(shlex.split(command))
            warnings = [line for line in text.splitlines() if "warning" in line]
            report.check(code == 0 and not warnings, f"{command.split()[0]} of {name}: code {code} {' '.join(warnings)} {text[-300:] if code else ''}")
        report.check(len(commands) == 3 and (not short or any(folder.glob("picture.*"))), f"commands and picture of {name}")
    code, text = invoke(["init", folder, f"--{name}"])
    report.check(code == 2 and "exists already" in text, f"init over a case: code {code}")
    for words, word in ((["--analysis", "static"], "--drape"), ([], "--drape"), (["--drap"], "--drape"), (["--drape", "--shell"], "keep one")):
        code, text = invoke(["init", folder, *words])
        report.check(code == 2 and word in text, f"init {' '.join(words)}: code {code}: {text.strip().splitlines()[0]}")


@test
def examples(report):
    """init --list names the examples with their titles; each begins a case whose meshes are with it and that passes check, one is solved and drawn; a wrong name gets the nearest."""
    code, text = invoke(["init", "--list"])
    listed = dict(re.findall(r"^  ([\w.]+) +(\S.*)\.$", text[text.index("Examples"):], re.M))
    report.check(code == 0 and len(listed) > 10 and all(len(title) > 20 for title in listed.values()), f"{len(listed)} examples")
    for name in listed:
        folder = fresh(f"example_{name}") / "case"
        code, text = invoke(["init", folder, "--example", name])
        case = (folder / "case.toml").read_text()
        report.check(code == 0 and "../" not in case and all((folder / mesh).is_file() for mesh in re.findall(r'"([\w.]+\.geo)"', case)), f"{name}: code {code}")
        commands = re.findall(r"^  voile (.*)$", text, re.M)
        for command in commands if name == "buckling_supported" else commands[:1] if name == "stages" else []:
            code, text = invoke(shlex.split(command))
            report.check(code == 0, f"{command.split()[0]} of {name}: code {code} {text[-300:] if code else ''}")
    report.check((OUT / "example_buckling_supported" / "case" / "picture.png").is_file(), "a picture")
    for words, said in ((["--example", "slit_anulus"], "slit_annulus"), (["--example", "hemisphere", "--shell"], "keep one")):
        code, text = invoke(["init", folder, *words])
        report.check(code == 2 and said in text, f"{' '.join(words)}: code {code}: {text.strip()}")


@test
def stress_at_vertices(report):
    """NAFEMS LE1 (The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990): an elliptic membrane under outward pressure, 92.7 MPa at the inner end of its long axis; recovered at the vertex, on three meshes."""
    for across, along, limit in ((12, 8, 0.04), (24, 16, 0.02), (48, 32, 0.02)):
        angle = np.linspace(0, np.pi / 2, along + 1)
        points = np.array([((2 + 1.25 * s) * np.cos(a), (1 + 1.75 * s) * np.sin(a), 0) for a in angle for s in np.linspace(0, 1, across + 1)])
        at = lambda i, j: j * (across + 1) + i  # noqa: E731
        cells = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for j in range(along) for i in range(across)]
        rim = [(at(across, j), at(across, j + 1)) for j in range(along)]
        mesh = write_msh(OUT / "le1.msh", points, [("x axis", 1, [(at(i, 0), at(i + 1, 0)) for i in range(across)]),
                                                   ("y axis", 1, [(at(i, along), at(i + 1, along)) for i in range(across)]),
                                                   *((f"rim {j}", 1, [side]) for j, side in enumerate(rim)),
                                                   ("sheet", 2, np.array([t for a, b, c, d in cells for t in ((a, b, c), (a, c, d))]))])
        outward = [np.array([(p := points[b] - points[a])[1], -p[0], 0]) / np.linalg.norm(p) for a, b in rim]
        case = {"analysis": "linear", "mesh": {"file": str(mesh)}, "material": [{"type": "isotropic", "young": 210e9, "poisson": 0.3, "thickness": 0.1}],
                "support": [{"type": "displacement", "group": group, "components": [k]} for group, k in (("x axis", "y"), ("y axis", "x"), ("sheet", "z"))],
                "load": [{"type": "line", "group": f"rim {j}", "vector": (1e6 * n).tolist()} for j, n in enumerate(outward)],
                "output": {"stresses": "surface"}}
        result = solve("le1", case, 1)
        step = result.results[-1]
        report.percent(step["stress_top_at_vertices"][0, 1] / 92.7e6, limit, f"{across} x {along}: stress at the vertex (in the triangles beside {step['stress_top'][:, 1].max() / 1e6:.1f} MPa)")
    invoke(["export", result.folder, "--to", "csv", "--output", OUT / "le1.csv"])
    titles = [line.replace('"', "").strip().split(",") for file in sorted(OUT.glob("le1*.csv")) for line in file.read_text().splitlines()[:1]]
    wanted = [f"{kind}_top{place}_{entry}" for kind, entries in (("stress", ("11", "22", "12")), ("principal_stress", ("larger", "smaller", "angle")))
              for place in ("", "_at_vertices") for entry in entries]
    missing = [name for name in wanted if not any(name in title for title in titles)]
    code, said = invoke(["render", result.folder, "--field", "stress_top_at_vertices:magnitude", "--output", OUT / "le1.png"])
    report.check(code == 2 and "larger" in said and "magnitude" not in said.split("components")[-1], f"a stress has no magnitude, at vertices neither: {said.strip()}")
    report.check(not missing, f"columns are named by what they hold{': missing ' + ', '.join(missing) if missing else ''}")


@test
def stress_at_notches(report):
    """A round hole in a wide sheet that is pulled (Kirsch): three times the stress along its edge, none across, whatever the thickness."""
    around, out = 40, 44
    r, a = np.geomspace(1.0, 5.0, out + 1), np.linspace(0, np.pi / 2, around + 1)
    points = np.array([(x * np.cos(t), x * np.sin(t), 0) for t in a for x in r])
    at = lambda i, j: j * (out + 1) + i  # noqa: E731
    cells = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for j in range(around) for i in range(out)]
    mesh = write_msh(OUT / "kirsch.msh", points, [("x axis", 1, [(at(i, 0), at(i + 1, 0)) for i in range(out)]), ("y axis", 1, [(at(i, around), at(i + 1, around)) for i in range(out)]),
                                                  ("outside", 1, [(at(out, j), at(out, j + 1)) for j in range(around)]),
                                                  ("sheet", 2, np.array([t for p, q, s, u in cells for t in ((p, q, s), (p, s, u))]))])
    # Stresses of a unit pull along x on the circle of radius 5: radial, and shear, as tractions.
    c2, s2, k = "(x*x - y*y)/25", "2*x*y/25", 1 / 25
    radial = f"({0.5 * (1 - k)} + {0.5 * (1 - 4 * k + 3 * k * k)}*{c2})"
    shear = f"(-{0.5 * (1 + 2 * k - 3 * k * k)}*{s2})"
    pulls = [([1.0, 0, 0], f"{radial}*x/5 - {shear}*y/5"), ([0, 1.0, 0], f"{radial}*y/5 + {shear}*x/5")]
    fibres = {"type": "orthotropic", "young_1": 140e9, "young_2": 10e9, "poisson_12": 0.3, "shear_12": 5e9, "direction": [1, 0, 0]}
    for name, material, thicknesses in (("isotropic", {"type": "isotropic", "young": 210e9, "poisson": 0.3}, (0.001, 0.2, 0.1, 0.04)), ("fibres", fibres, (0.001, 0.2, 0.05, 0.0125))):
        for h in thicknesses:
            case = {"analysis": "linear", "mesh": {"file": str(mesh)}, "material": [material | {"thickness": h}], "output": {"stresses": "surface"},
                    "support": [{"type": "symmetry", "group": "x axis"}, {"type": "symmetry", "group": "y axis"}, {"type": "displacement", "group": "sheet", "components": ["z"]}],
                    "load": [{"type": "line", "group": "outside", "vector": [h * 1e6 * c for c in v], "distribution": d} for v, d in pulls]}
            along, across = solve("kirsch", case).results[-1]["stress_top_at_vertices"][at(0, around)][:2] / 1e6
            thin = along if h == 0.001 else thin
            if name == "isotropic":
                report.percent(along / 3.0, 0.03, "by the closed form")
            report.percent(along / thin, 0.01, f"{name}, R = {1 / h:.3g} h: stress along the edge {along:.4g} MPa")
            report.below(abs(across) / along, 0.03, "across it")


@test
def stress_at_clamps(report):
    """Stresses at the vertices of clamped edges, where they are largest, and of an edge with a moment: a strip clamped at both ends under q has q l^2/12 there."""
    length, thickness, q = 0.6, 2e-3, 1e3
    base = {"analysis": "linear", "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.0, "thickness": thickness}], "output": {"stresses": "surface"}}
    for pattern in (0, 1, 2):
        mesh = {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": length, "width": 0.2, "nx": 32, "ny": 10, "pattern": pattern}}
        step = solve("clamp_stress", base | {"mesh": mesh, "support": [{"type": "clamped", "group": ["clamp", "tip"]}], "load": [{"type": "area", "vector": [0, 0, q]}]}).results[-1]
        x = step.mesh.positions
        at = (x[:, 0] < 1e-9) & (np.abs(x[:, 1] - 0.1) < 0.07)
        ratio = np.abs(step["stress_top_at_vertices"][at, 0]) * thickness**2 / 6 / (q * length**2 / 12)
        report.below(np.abs(ratio - 1).max(), 0.02, f"pattern {pattern}, {at.sum()} vertices of a clamped edge: stress, error")
        step = solve("moment_stress", base | {"mesh": mesh, "support": [{"type": "clamped", "group": "clamp"}], "load": [{"type": "follower_moment", "group": "tip", "magnitude": 1.0}]}).results[-1]
        at = x[:, 0] > length - 1e-9
        report.below(np.abs(-step["stress_top_at_vertices"][at, 0] * thickness**2 / 6 - 1).max(), 1e-3, f"pattern {pattern}, an edge with a moment: stress, error")


@test
def probed_means(report):
    """The mean of a group is that over its length or area, also where cells are of very different sizes."""
    folder = fresh("probed_mesh")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "graded.geo").write_text("""Point(1) = {0, 0, 0, 0.01}; Point(2) = {1, 0, 0, 0.1}; Point(3) = {1, 0.2, 0, 0.1}; Point(4) = {0, 0.2, 0, 0.01};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Physical Curve("left") = {4}; Physical Curve("right") = {2}; Physical Curve("bottom") = {1}; Physical Surface("sheet") = {1};
""")
    case = {"analysis": "static", "mesh": {"file": str(folder / "graded.geo")}, "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 1e-3}],
            "support": [{"type": "displacement", "group": "left", "components": ["x"]}, {"type": "displacement", "group": "sheet", "components": ["y", "z"]},
                        {"type": "displacement", "group": "right", "components": ["x"], "value": [0.01, 0, 0]}],
            "probe": [{"name": name, "type": "displacement", "group": name, "components": ["x"]} for name in ("sheet", "bottom")] +
                     [{"name": "far", "type": "height", "group": "bottom", "components": ["x"]}]}
    history = solve("probed_means", case).history
    for column, exact in (("sheet_x", 0.005), ("bottom_x", 0.005), ("far_mean", 0.505)):
        report.percent(history[column][-1] / exact, 1e-9, f"{column}: {history[column][-1]:.6g} m")
    # A step that such a mean controls ends where it says.
    loaded = case | {"support": case["support"][:2], "load": [{"type": "line", "group": "right", "vector": [1.0, 0, 0]}],
                     "steps": {"control": "displacement", "control_probe": "sheet", "final_displacement": 0.005}}
    history = solve("probed_means_controlled", loaded).history
    report.percent(history["sheet_x"][-1] / 0.005, 1e-9, "a step controlled by the mean")
    report.percent(history["load_factor"][-1] / (10 * 1.01 * 1.005), 1e-6, "its load factor, E h (e + e^2 / 2) (1 + e)")


@test
def shipped_fabrics(report):
    """A fabric by its name: beside the case first, then among those shipped; a misspelt name gets the nearest."""
    case = strip("linear", material=[{"type": "fabric", "fabric": "wool_tropical", "direction": [1, 0, 0]}], load=[{"type": "gravity", "vector": [0, 0, -1e-6]}])
    file = write_case(case, fresh("shipped_fabrics") / "case.toml")

    def used():
        result = run(file, file.parent / "run", 1, ["--overwrite"])
        resolved = tomllib.loads((file.parent / "run" / "resolved_case.toml").read_text()) if result.code == 0 else {}
        return resolved["material"][0]["areal_density"] if resolved else result.text

    report.check((density := used()) == 0.1629, f"a shipped fabric: {density} kg/m^2")
    shipped = (ROOT / "runs" / "fabrics" / "wool_tropical.toml").read_text()
    (file.parent / "wool_tropical.toml").write_text(shipped.replace("16.29", "20.00"))
    report.check((density := used()) == 0.2, f"the user's own comes first: {density} kg/m^2")
    for wrong, words in (("wool_tropicl", ["shipped_fabrics/wool_tropicl.toml", "runs/fabrics/wool_tropicl.toml", '"wool_tropical"']),
                         ("../wool_tropical.toml", ['"wool_tropical"', "shipped"])):
        code, text = invoke(["check", file, "--set", f'material.0.fabric="{wrong}"'])
        report.check(code == 2 and all(word in text for word in words), f"{wrong}: code {code}: {text.strip()}")
