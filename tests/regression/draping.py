"""Drape and motion of fabric without contact."""

import json
import shutil

import numpy as np
from common import drape_script
from harness import OUT, solve, test
from results import Results
from solver import ROOT, invoke, run, variant


@test
def heavy_strip(report):
    """Draping of a clamped strip: drop over reach within 1 % of the heavy elastica, clamp curvature within 2 %."""
    script = drape_script("heavy_strip")
    (OUT / "heavy_strip").mkdir(parents=True, exist_ok=True)
    for gamma, pattern, material, angle in ((1.0, "one_way", "isotropic", 0), (100.0, "unstructured", "isotropic", 0),
                                            (100.0, "unstructured", "fabric", 30)):
        row = script.measure(gamma, pattern, 80, material, angle, OUT / "heavy_strip")
        what = f"Gamma {gamma:g}, {material}, {pattern}"
        report.check(row is not None, f"{what}: a stable equilibrium was found")
        if row:
            report.below(row["error"], 0.01, f"{what}: H/W")
            report.below(row["curvature"], 0.02, f"{what}: clamp curvature")


@test
def loops(report):
    """Heart, pear and ring of a heavy strip: drop and width within 1 % of the heavy elastica."""
    script = drape_script("loops")
    (OUT / "loops").mkdir(parents=True, exist_ok=True)
    for shape, gamma, pattern, angle in (("heart", 300, "unstructured", 30), ("pear", 100, "one_way", None),
                                         ("ring", 10, "one_way", 45)):
        row = script.measure(shape, gamma, pattern, 160, angle, OUT / "loops")
        report.check(row is not None, f"{shape}: a stable equilibrium was found")
        if row:
            report.below(row["errors"][0], 0.01, f"{shape}: drop")
            report.below(row["errors"][1], 0.01, f"{shape}: width")


@test
def wrinkling(report):
    """A plate that overhangs a disc is stable at 0.95 of its critical load and unstable at 1.05, with four waves."""
    script = drape_script("wrinkling")
    (OUT / "wrinkling").mkdir(parents=True, exist_ok=True)
    found = []
    for factor in (0.95, 1.05):
        result = script.solve(script.plate_case(0.5, factor, 24, "unstructured"), OUT / "wrinkling" / f"{factor:g}")
        report.check(result is not None, f"{factor:g} P_c: solved")
        if result:
            found.append(script.spectrum(result))
    if len(found) == 2:
        report.check(min(found[0].values()) > 0, f"stable at 0.95: lowest eigenvalue {min(found[0].values()):+.3g}")
        ratio, waves = script.onset(*found)
        report.check(waves == 4, f"{waves} waves")
        report.percent(ratio, 0.04, "critical load")


@test
def killed_motion(report):
    """A motion killed on 2 ranks continues from its checkpoint to the state of the unbroken run."""
    script = drape_script("kill")
    whole = solve("killed_motion", script.strip_case(steps=100))
    file = OUT / "killed_motion.toml"
    running = script.run_and_kill(file, OUT / "killed_motion_half", 42)
    report.check(running, "the run was still going when it was killed")
    shutil.rmtree(OUT / "killed_motion_again", ignore_errors=True)
    again = run(file, OUT / "killed_motion_again", 2, ["--restart", str(OUT / "killed_motion_half" / "checkpoint.h5")], 300)
    report.check(again.code == 0, f"the restart completes: code {again.code}")
    if again.code == 0:
        report.below(script.difference(whole, again), script.LIMIT, "relative difference of the final states")
    steps = solve("killed_motion_steps", variant(script.strip_case(steps=100),
                                                 {"output": {"fields": ["displacement", "velocity"], "every": 50}}))
    middle = run(file, OUT / "killed_motion_step", 2, ["--restart", str(steps.results.file), "--restart-step", "50"], 300)
    report.check(middle.code == 0 and middle.history["step"][0] == 50, f"from step 50 of the results: code {middle.code}")
    # The strip folds, which amplifies the step that begins with another acceleration: 3 % was measured.
    report.below(script.difference(whole, middle), 0.2, "its accelerations are found anew: relative difference")


@test
def release(report):
    """A support that lets go does so beyond the case's own end, and a restart from that very moment is the unbroken run."""
    script = drape_script("kill")
    case = variant(script.strip_case(steps=20), {"support.0.release": 0.02, "time.end": 0.04, "time.checkpoint_steps": 10})
    whole = solve("release_whole", case, 1)
    held = solve("release_held", variant(case, {"support.0.release": None, "time.checkpoint_steps": None}), 1)
    report.check((held.folder / "checkpoint.h5").is_file(), "a run that is complete leaves a checkpoint")
    moved = script.difference(whole, held)
    report.check(moved > 0.01, f"it lets go: {moved:.3g} away from the run that holds on")
    longer = solve("release_longer", variant(case, {"time.end": 0.01}), 1, ["-ts_max_time", "0.04"])
    report.below(script.difference(whole, longer), 1e-10, "-ts_max_time beyond the end and the release: difference")
    solve("release_until", variant(case, {"time.end": 0.02}), 1)
    again = solve("release_again", case, 1, ["--restart", OUT / "release_until" / "checkpoint.h5"])
    report.below(script.difference(whole, again), 1e-10, "restart at the moment of release: difference")
    lost = [r.summary["energy"] for r in (whole, again)]
    for key in ("initial_energy", "remeshing_gain"):
        report.near(lost[1][key], lost[0][key], 1e-9 * abs(lost[0]["remeshing_gain"]), f"{key} of the unbroken run")
    grown = variant(case, {"support.0.release": 0.0207, "time.end": 0.04, "time.step": 2e-4, "time.max_step": 1e-3,
                           "time.target_iterations": 1000, "time.checkpoint_steps": None})
    times = solve("release_grown", grown, 1).history["time"]
    sizes, at = np.diff(times), int(np.argmin(np.abs(times - 0.0207)))
    report.check(abs(times[at] - 0.0207) < 1e-12 and sizes[at] > 0.9e-3,
                 f"the step after the release is as long as before: {sizes[at - 2]:.2g}, {sizes[at - 1]:.2g}, then {sizes[at]:.2g} s")


def flap(**changes):
    """A flap of cotton, two bending lengths long, that is clamped at one side and has friction inside."""
    case = {
        "analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.06, "n": 12, "pattern": 1}},
        "material": [{"type": "fabric", "fabric": "cotton_broad", "direction": [1, 0, 0], "hysteresis": "friction"}],
        "support": [{"type": "clamped", "group": "left"}], "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
        "steps": {"initial_step": 0.1, "max_step": 0.1}, "output": {"every": 1000}}
    return variant(case, {k.replace("__", "."): v for k, v in changes.items()})


@test
def yarn_friction(report):
    """Friction inside a fabric: what stays when a load has gone, the balance of a motion, restarts, ranks, and what is refused."""
    sag = {}
    for kind in ("friction", "damping"):
        case = flap(material__0__hysteresis=kind, analysis=None)
        case["load"] = [{"type": "gravity", "vector": [0, 0, -9.81 * factor], "stages": [stage]} for stage, factor in (("load", 1), ("unload", 1e-6))]
        folder = solve(f"yarn_friction_{kind}", case | {"stage": [{"name": name, "analysis": "static"} for name in ("load", "unload")]}).folder
        sag[kind] = [-1e3 * Results(folder / stage)[-1]["displacement"][:, 2].min() for stage in ("load", "unload")]
    (loaded, left), (elastic, nothing) = sag["friction"], sag["damping"]
    report.check(loaded < 0.9 * elastic, f"friction carries: sags by {loaded:.2f} mm, without by {elastic:.2f}")
    report.check(left > 0.5 * loaded and nothing < 0.01 * elastic, f"and holds {left:.2f} mm without the weight, without {nothing:.3f}")

    two = solve("yarn_friction_ranks", flap(), 2)
    one = solve("yarn_friction_whole", flap())
    difference = np.abs(two.displacement() - one.displacement()).max() / np.abs(one.displacement()).max()
    report.below(difference, 1e-6, "2 ranks: difference")
    loss = np.asarray(one.history["fabric_loss"])
    report.check(loss[-1] > 0 and np.all(np.diff(loss) >= 0), f"a path writes what is lost: {loss[-1]:.3g} J")
    half = solve("yarn_friction_half", flap(steps__final_load_factor=0.5))
    again = solve("yarn_friction_again", flap(), 1, ["--restart", half.folder / "checkpoint.h5"])
    report.below(np.abs(again.displacement() - one.displacement()).max() / np.abs(one.displacement()).max(), 1e-9, "restart at half the load: difference")
    code, text = invoke(["run", OUT / "yarn_friction_whole.toml", "--output", OUT / "yarn_friction_refused", "--overwrite",
                         "--restart", half.results.file])
    report.check(code == 2 and "checkpoint.h5" in text, f"results do not hold slips: exit code {code}")

    motion = flap(analysis="dynamic", time={"end": 0.3, "step": 2e-3, "velocity_tolerance": 1e-4})
    turned = flap(analysis="dynamic", support=[{"type": "clamped", "group": "left", "rotation_axis": [0, 1, 0], "rotation_angle": "40*sin(2*pi*t/0.2)"}],
                  time={"end": 0.2, "step": 2e-3})
    h = solve("yarn_friction_turned", turned).history
    report.check(h["fabric_loss"][-1] > 0 and min(h["numerical_loss"]) > -0.02 * h["work_of_supports"][-1],
                 f"a clamp that turns gives what is rubbed away, {h['fabric_loss'][-1]:.3g} J: numerical loss at least {min(h['numerical_loss']):.3g} J")
    solved = solve("yarn_friction_motion", motion)
    h = solved.history
    report.check(h["fabric_loss"][-1] > 0.1 * h["work_of_loads"][-1], f"a motion loses {h['fabric_loss'][-1]:.3g} J of {h['work_of_loads'][-1]:.3g}")
    report.below(h["energy_unaccounted"][-1] / h["work_of_loads"][-1], 1e-3, "not accounted for")
    report.percent(solved.summary["energy"]["fabric_loss"] / h["fabric_loss"][-1], 1e-9, "the summary has it")
    finer = solve("yarn_friction_remeshed", motion | {"remesh": {"largest": 0.006, "smallest": 0.003}})
    report.check(finer.history["remeshings"][-1] > 0, f"{finer.history['remeshings'][-1]:.0f} remeshings")
    report.percent(finer.history["fabric_loss"][-1] / h["fabric_loss"][-1], 0.02, "loss with remeshing over that without")


KES = """name = "KES"
description = "Round figures of a worsted."
areal_density = "200 g/m^2"
tension_warp = { EMT = "4 %", WT = "6 gf.cm/cm^2" }
tension_weft = { units = ["%", "gf/cm"], points = [[1, 10], [2, 35], [4, 140], [7, 500]] }
shear_curve = { units = ["deg", "gf/cm"], points = [[2, 1.2], [5, 3], [8, 6]] }
shear_hysteresis = "0.8 gf/cm"
shear_hysteresis_5 = "1.7 gf/cm"
bending_warp = "0.1 gf.cm^2/cm"
bending_weft = "0.1 gf.cm^2/cm"
[sources]
areal_density = "x"
tension_warp = "x"
tension_weft = "x"
shear_curve = "x"
shear_hysteresis = "x"
shear_hysteresis_5 = "x"
bending_warp = "x"
bending_weft = "x"
"""


def frame(angle, **changes):
    """A square cell of 50 mm in a picture frame, which turns to this angle in degrees over the load factor t."""
    turned = {"type": "displacement", "components": ["x", "y", "z"], "rotation_axis": [0, 0, -1], "rotation_angle": angle}
    case = {
        "analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.05, "n": 1}},
        "material": [{"type": "fabric", "fabric": str(OUT / "kes.toml"), "direction": [1, 0, 0], "hysteresis": "friction"}],
        "support": [turned | {"group": "left", "rotation_centre": [0, 0, 0]}, turned | {"group": "right", "rotation_centre": [0.05, 0, 0]}],
        "steps": {"initial_step": 0.0125, "max_step": 0.0125}, "output": {"every": 1000},
        "probe": [{"name": "top", "type": "reaction", "group": "top", "components": ["x"]}]}
    return variant(case, {k.replace("__", "."): v for k, v in changes.items()})


@test
def kes(report):
    """Virtual instruments of KES: the tensile curves and the loop of shear that a fabric file gives come out; a restart keeps the loop."""
    (OUT / "kes.toml").write_text(KES)
    gf = 0.980665  # N/m
    points = {0: [(0, 0), (4, 500)], 90: [(0, 0), (1, 10), (2, 35), (4, 140), (7, 500)]}
    for warp, curve in points.items():
        most = curve[-1][0]
        pulled = frame("0", material__0__warp_angle=warp, steps__initial_step=1 / most / 8, steps__max_step=1 / most / 8)
        pulled["support"] = [{"type": "displacement", "components": ["x", "z"], "group": "left"}, {"type": "displacement", "components": ["x", "z"], "group": "right", "value": [most * 5e-4, 0, 0]},
                             {"type": "displacement", "components": ["y"], "group": "bottom"}]
        pulled["probe"] = [{"name": "pull", "type": "reaction", "group": "right", "components": ["x"]}]
        h = solve(f"kes_tension_{warp}", pulled).history
        x, force = most * np.asarray(h["load_factor"]), np.abs(h["pull_x"]) / 0.05 / gf
        off = max(abs(np.interp(at, x, force) - value) for at, value in curve) / 500
        report.below(off, 5e-3, f"tension of yarns at {warp} degrees: largest difference over 500 gf/cm")
        if warp == 0:
            report.near(np.trapezoid(force, x / 100) if hasattr(np, "trapezoid") else np.trapz(force, x / 100), 6, 0.03, "WT [gf cm/cm^2]")

    way = "table(t, 0, 0, 0.2, 8, 0.6, -8, 1, 8)"
    whole = solve("kes_shear", frame(way))
    t, force = np.asarray(whole.history["load_factor"]), np.asarray(whole.history["top_x"]) / 0.05 / gf
    force *= np.sign(force[np.argmin(np.abs(t - 0.2))])
    at = lambda branch, angle: np.interp(0.4 - angle / 40 if branch < 0 else 0.8 + angle / 40, t, force) * np.cos(np.radians(angle))
    for angle, width, mean in ((0.5, 0.8, None), (5, 1.7, 3), (-0.5, 0.8, None), (-5, 1.7, -3), (2, None, 1.2)):
        up, down = at(1, angle), at(-1, angle)
        if width:
            report.percent((up - down) / width, 0.005, f"width of the loop at {angle:g} degrees")
        if mean:
            report.percent(0.5 * (up + down) / mean, 0.005, f"its middle at {angle:g} degrees")
    report.check(whole.history["fabric_loss"][-1] > 0, f"lost: {whole.history['fabric_loss'][-1]:.3g} J")
    solve("kes_half", frame(way, steps__final_load_factor=0.45))
    again = solve("kes_again", frame(way), 2, ["--restart", OUT / "kes_half" / "checkpoint.h5"])
    report.below(abs(again.history["top_x"][-1] / whole.history["top_x"][-1] - 1), 1e-9, "restart on 2 ranks: force")
    report.below(abs(again.history["fabric_loss"][-1] / whole.history["fabric_loss"][-1] - 1), 1e-9, "and what is lost")
    three = solve("kes_ranks", frame(way), 3)
    report.below(abs(np.asarray(three.history["top_x"]) - whole.history["top_x"]).max() / (500 * gf * 0.05), 1e-9, "3 ranks: force")

    steep = KES.replace('WT = "6 gf.cm/cm^2"', "LT = 0.3").replace('{ units = ["%", "gf/cm"], points = [[1, 10], [2, 35], [4, 140], [7, 500]] }', '{ EMT = "4 %", LT = 0.3 }')
    (OUT / "kes_steep.toml").write_text(steep)
    bias = {"title": "Pulled at 20 degrees", "analysis": "static", "mesh": {"file": str(ROOT / "meshes/plate.geo"), "parameters": {"side": 0.1, "n": 24}},
            "material": [{"type": "fabric", "fabric": str(OUT / "kes_steep.toml"), "direction": [1, 0, 0], "warp_angle": 20}],
            "support": [{"type": "hinged", "group": "left"}, {"type": "displacement", "components": ["z"], "group": "plate"}],
            "load": [{"type": "line", "group": "right", "vector": [250, 0, 0]}]}
    report.below(solve("kes_bias", bias).summary["recovery_error"], 0.2, "estimated error of a pull that stiffens the yarns tenfold")

    motion = flap(analysis="dynamic", material__0__fabric=str(OUT / "kes.toml"), material__0__warp_angle=45, time={"end": 0.06, "step": 1e-3, "velocity_tolerance": 1e-4})
    h = solve("kes_motion", variant(motion, {"load.0.vector": [40, -100, -100]})).history
    report.check(h["fabric_loss"][-1] > 0.03 * h["work_of_loads"][-1], f"a motion loses {h['fabric_loss'][-1]:.3g} J of {h['work_of_loads'][-1]:.3g} in shear")
    report.below(h["energy_unaccounted"][-1] / h["work_of_loads"][-1], 1e-3, "not accounted for")


@test
def drape_test(report):
    """`voile drape-test`: coefficient, folds and files of two repeats each way; mistakes."""
    for way, few in (("plate", 2), ("weight", 1)):
        folder = OUT / f"drape test: {way}"
        shutil.rmtree(folder, ignore_errors=True)
        code, text = invoke(["drape-test", "cotton_broad", "--method", way, "--repeats", str(few), "--cell", "12", "--output", folder])
        report.check(code == 0 and "drape coefficient" in text, f"{way}: exit code {code}: {text.strip()[-120:]}")
        summary = json.loads((folder / "summary.json").read_text())
        report.check(summary["friction_inside_the_fabric"] and len(summary["repeats"]) == few, f"{way}: {few} repeats with friction")
        # The laboratory has 82.9 %; the cells are far too coarse for more than this.
        report.near(summary["drape_coefficient"]["mean"], 86, 12, f"{way}: drape coefficient")
        edge = np.loadtxt(folder / "contour_1.csv", delimiter=",", skiprows=1)
        report.check(np.all(edge[0] == edge[-1]) and edge[:, 3].max() < 150.1 and edge[:, 3].min() > 90, f"{way}: contour of {len(edge)} points")
        report.check((folder / "contours.png").stat().st_size > 5000, f"{way}: a picture")
        gaps = [np.linalg.norm(np.diff(np.loadtxt(file, delimiter=",", skiprows=1)[:, :2], axis=0), axis=1).max() for file in folder.glob("contour_*.csv")]
        report.check(len(gaps) == few and max(gaps) < 13, f"{way}: whole contours, points at most {max(gaps):.1f} mm apart")
    for words, expected in ((["no_such_fabric"], "no fabric file"), (["cotton_braod"], '"cotton_broad"'), (["cotton_broad", "--specimen", "200"], "240"), (["cotton_broad", "--cell", "nan"], "millimetres"),
                            (["cotton_broad", "--output", OUT / "drape test: plate"], "--overwrite"), ([], "fabric")):
        code, text = invoke(["drape-test", *words])
        report.check(code == 2 and expected.strip('"') in text, f"{' '.join(map(str, words))}: exit code {code}: {text.strip()[:110]}")


@test
def drape_equilibria(report):
    """`voile drape-test --equilibria`: stable states from 4 and 5 folds, and the one of the test itself; mistakes."""
    folder = OUT / "drape equilibria"
    words = ["drape-test", "cotton_broad", "--elastic", "--repeats", "1", "--cell", "14", "--no-mesh-check"]
    code, text = invoke([*words, "--equilibria", "--folds", "4..5", "--output", folder, "--overwrite"])
    report.check(code == 0 and "next to the test: number" in text, f"exit code {code}: {text.strip()[-120:]}")
    summary = json.loads((folder / "summary.json").read_text())
    tested, found = summary["repeats"][0], {e["start"]: e for e in summary["equilibria"]}
    report.check(set(found) == {"test", 4, 5} and all(e["found"] and e["stable"] and e["eigenvalue_nearest_to_zero"] > 0 for e in found.values()), "stable equilibria from the test, 4 and 5 folds")
    # Without friction the specimen at rest is an equilibrium itself.
    report.near(found["test"]["drape_coefficient"], tested["drape_coefficient"], 0.5, "coefficient next to the test [%]")
    report.check(found["test"]["fold_count"] == tested["fold_count"], f"folds next to the test: {found['test']['fold_count']}, of the test: {tested['fold_count']}")
    report.check(found[4]["fold_count"] == 4 and found[5]["fold_count"] == 5, "as many folds as the search began with")
    ranks = [e["equilibrium"] for e in sorted(found.values(), key=lambda e: e["energy_mJ"])]
    report.check(ranks[0] == 1 and ranks == sorted(ranks) and all(e["energy_mJ"] < 0 for e in found.values()), f"by energy: {ranks}")
    rows = (folder / "equilibria.csv").read_text().splitlines()
    report.check(len(rows) == 4 and rows[1].startswith("test,"), f"equilibria.csv: {len(rows)} rows")
    for more, expected in ((["--folds", "4"], "--equilibria"), (["--equilibria", "--folds", "5..4"], "4..5"), (["--equilibria", "--folds", "many"], "2..12"), (["--equilibria", "--folds", "0"], "1 to 24")):
        code, text = invoke([*words, *more, "--output", OUT / "no"])
        report.check(code == 2 and expected in text, f"{' '.join(more)}: exit code {code}: {text.strip()[:110]}")
