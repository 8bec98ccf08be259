"""`voile fit`: fabric files from the sheets of a laboratory."""

import re
import tomllib

import numpy as np
from draping import frame
from harness import OUT, solve, test
from solver import ROOT, invoke, variant

UNITS = {"g/m^2": 1e-3, "mg/cm^2": 1e-2, "mm": 1e-3, "N/m": 1, "kN/m": 1e3, "uN.m": 1e-6, "mN": 1e-3, "1/m": 1, "deg": 1, "gf.cm^2/cm": 98.0665e-6, "gf.cm/cm": 9.80665e-3}


SHEARED = """name = "Sheared"
description = "A loop of shear of round figures."
areal_density = 0.2
membrane_warp = 1e4
membrane_weft = 1e4
membrane_shear = 40
shear_hysteresis = 0.8
shear_hysteresis_5 = 2
bending_warp = 1e-5
bending_weft = 1e-5
[sources]
""" + "".join(f'{key} = "x"\n' for key in ("areal_density", "membrane_warp", "membrane_weft", "membrane_shear", "shear_hysteresis", "shear_hysteresis_5", "bending_warp", "bending_weft"))


def si(value):
    """A figure of a fabric file, but for bending lengths."""
    if not isinstance(value, str):
        return value
    number, unit = value.split(" ", 1)
    return float(number) * UNITS[unit]


def figures(file):
    fabric = tomllib.loads(file.read_text())
    all_ = {k: v for k, v in fabric.items() if k not in ("name", "description", "sources")}
    for key in ("bending_warp", "bending_weft"):
        if str(all_[key]).endswith("mm FAST"):
            all_[key] = 9.81 * si(all_["areal_density"]) * (1e-3 * float(all_[key].split()[0])) ** 3
    return {k: si(v) for k, v in all_.items()}


def extension(stiffness, load):
    """Of a linear law, by bisection: stiffness (x + x^2/2)(1 + x) = load."""
    low, high = 0.0, 2.0
    for _ in range(60):
        x = 0.5 * (low + high)
        low, high = (x, high) if stiffness * (x + x * x / 2) * (1 + x) < load else (low, x)
    return x


def kes_sheet(f):
    """What KES reads off a fabric with friction and linear tension."""
    emt = {d: extension(f[f"membrane_{d}"], 490.3325) for d in ("warp", "weft")}
    wt = {d: f[f"membrane_{d}"] / 2 * (x + x * x / 2) ** 2 for d, x in emt.items()}
    both = lambda values, unit: "{ warp = %.6g, weft = %.6g }" % tuple(values[d] / unit for d in ("warp", "weft"))
    bending = {d: f[f"bending_{d}"] for d in ("warp", "weft")}
    return f"""[kes]
W = {100 * f["areal_density"]:.6g}
T = {1e3 * f["thickness"]:.6g}
B = {both(bending, 98.0665e-6)}
2HB = {f["bending_hysteresis"] / 9.80665e-3:.6g}
G = {f["membrane_shear"] / 56.18796:.6g}
EMT = {both(emt, 1e-2)}
WT = {both(wt, 0.980665)}
RC = 45
"""


def fast_sheet(f):
    """What FAST reads off a fabric, with a bending length along the bias."""
    length = lambda d: 1e3 * (d / (9.81 * f["areal_density"])) ** (1 / 3)
    twist = f.get("bending_twist", 0.5 * (f["bending_warp"] * f["bending_weft"]) ** 0.5)
    lines = [f"W = {1e3 * f['areal_density']:.6g}", f"C-1 = {length(f['bending_warp']):.6g}", f"C-2 = {length(f['bending_weft']):.6g}", f"EB5 = {123 / f['membrane_shear']:.6g}"]
    for number, d in ((1, "warp"), (2, "weft")):
        slack = 0.2  # that both readings have
        lines += [f"E5-{number} = {slack + 490.3 / f[f'membrane_{d}']:.6g}", f"E20-{number} = {slack + 1961.3 / f[f'membrane_{d}']:.6g}"]
    return "[bending_length]\nbias = \"%.6g mm\"\n[fast]\n" % length((f["bending_warp"] + f["bending_weft"]) / 4 + twist) + "\n".join(lines) + "\n"


def fit(name, text, *words):
    folder = OUT / "fit"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.toml").write_text(text)
    return invoke(["fit", folder / f"{name}.toml", "-o", folder / f"{name}_fabric.toml", "--overwrite", *words])


@test
def fit_shipped(report):
    """`voile fit` recovers each shipped fabric from its own virtual sheet of KES or FAST."""
    for file in sorted((ROOT / "runs" / "fabrics").glob("*.toml")):
        f = figures(file)
        sheet = kes_sheet(f) if "bending_hysteresis" in f else fast_sheet(f)
        code, text = fit(file.stem, 'name = "virtual"\ndescription = "virtual sheet"\n' + sheet)
        report.check(code == 0 and "not determined" in text, f"{file.stem}: exit code {code}{': ' + text.strip()[-200:] if code else ''}")
        found = figures(OUT / "fit" / f"{file.stem}_fabric.toml")
        worst = max((abs(found[k] / v - 1), k) for k, v in f.items() if k not in ("membrane_poisson", "bending_poisson"))
        report.below(worst[0], 5e-3, f"{file.stem}: {len(f)} figures, worst {worst[1]}")
        if "membrane_poisson" in f:
            report.check(re.search(r"membrane_poisson +0\n", text) is not None, "the coupling of warp and weft is listed as not determined")


def curvature(history, places):
    """Of the circle through three points of a strip that bends down where it turns about +y."""
    p = [np.stack([np.asarray(history[f"p{i}_x"]) + x, np.asarray(history[f"p{i}_z"])], 1) for i, x in enumerate(places)]
    a, b, c = p[1] - p[0], p[2] - p[1], p[2] - p[0]
    return -2 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1) * np.linalg.norm(c, axis=1))


def record(name, x, force):
    (OUT / "fit").mkdir(parents=True, exist_ok=True)
    np.savetxt(OUT / "fit" / f"{name}.csv", np.stack([x, force], 1), delimiter=",", header="x,force", comments="")


@test
def fit_solver(report):
    """What goes into the solver comes out of `voile fit`: the bending loop of KES, a picture frame, a cantilever."""
    length, width, places = 0.01, 0.004, (0.0025, 0.005, 0.0075)
    strip = {"analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": length, "width": width, "nx": 40, "ny": 4}},
             "material": [{"type": "fabric", "fabric": "cotton_broad", "direction": [1, 0, 0], "hysteresis": "friction"}],
             "support": [{"type": "clamped", "group": "clamp"}], "steps": {"initial_step": 0.02, "max_step": 0.02}, "output": {"every": 1000}}
    turned = {"group": "tip", "name": "end", "translation": ["free", 0, "free"], "turn": "about", "turn_axis": [0, 1, 0],
              "turn_angle": "table(t, 0, 0, 0.2, 143.24, 0.6, -143.24, 1, 0)"}  # to 2.5 /cm
    probes = [{"name": f"p{i}", "type": "displacement", "point": [x, width / 2, 0]} for i, x in enumerate(places)]
    h = solve("fit_bending", strip | {"rigid": [turned], "probe": probes}).history
    record("bending", curvature(h, places), np.asarray(h["end_moment_y"]) / width)
    (OUT / "fit_sheared.toml").write_text(SHEARED)
    h = solve("fit_shear", frame("table(t, 0, 0, 0.2, 8, 0.6, -8, 1, 0)", material__0__fabric=str(OUT / "fit_sheared.toml"))).history
    t, force = np.asarray(h["load_factor"]), np.asarray(h["top_x"]) / 0.05
    angle = np.interp(t, (0, 0.2, 0.6, 1), (0, 8, -8, 0))
    force *= np.sign(force[np.argmin(np.abs(t - 0.2))]) * np.cos(np.radians(angle))  # along the turned edges
    record("shear", angle, force)
    sheet = 'name = "a"\ndescription = "b"\nareal_density = "123.8 g/m^2"\n'
    code, text = fit("solver", sheet + '[bending_loop.warp]\nfile = "bending.csv"\nunits = ["1/m", "N"]\n[shear_loop]\nfile = "shear.csv"\nunits = ["deg", "N/m"]\n')
    report.check(code == 0, f"loops: exit code {code}: {text.strip()[-160:] if code else ''}")
    found = figures(OUT / "fit" / "solver_fabric.toml")
    for key, value in (("bending_warp", 0.118 * 98.0665e-6), ("bending_hysteresis", 0.124 * 9.80665e-3), ("membrane_shear", 40), ("shear_hysteresis", 0.8), ("shear_hysteresis_5", 2)):
        report.percent(found[key] / value, 0.005, f"{key} of the loop")

    overhang = 0.0425
    long = variant(strip, {"mesh.parameters": {"length": overhang, "width": 0.01, "nx": 40, "ny": 4}, "material.0.hysteresis": "damping"})
    h = solve("fit_cantilever", long | {"load": [{"type": "gravity", "vector": [0, 0, -9.80665]}], "probe": [{"name": "tip", "type": "displacement", "group": "tip"}],
                                        "steps": {"initial_step": 0.2, "max_step": 0.2}}).history
    fall = np.degrees(np.arctan2(-h["tip_z"][-1], overhang + h["tip_x"][-1]))
    code, text = fit("cantilever", sheet + f'[overhang]\nangle = "{fall:.6f} deg"\nwarp = "{1e3 * overhang} mm"\n')
    report.check(code == 0 and 35 < fall < 48, f"a strip falls by {fall:.2f} degrees: exit code {code}")
    report.percent(figures(OUT / "fit" / "cantilever_fabric.toml")["bending_warp"] / (0.118 * 98.0665e-6), 0.005, "bending_warp of the overhang")


@test
def fit_sheets(report):
    """`voile fit`: the block of the how-to, a drape coefficient through the virtual test, mistakes."""
    block = re.search(r"^```text\n(name.*?)^```$", (ROOT / "docs" / "howto" / "fit-a-fabric.md").read_text(), re.M | re.S)[1]
    code, text = fit("howto", block)
    report.check(code == 0 and "bending_warp" in text, f"how-to: exit code {code}: {text.strip()[-60:]}")
    head = 'name = "a"\ndescription = "b"\nareal_density = "163 g/m^2"\n'
    drape = head + '[drape]\ncoefficient = "80 %"\nfolds = 6\n'
    code, text = fit("drape", drape, "--cell", "14", "--repeats", "1")
    report.check(code == 0 and text.count("virtual drape test") > 1, f"drape: exit code {code}: {text.strip()[-60:]}")
    if code == 0:
        row = re.search(r"drape.coefficient +[\d.]+ +([\d.]+)", text)
        report.near(float(row[1]), 80, 0.6, "drape coefficient of the fabric that was found")
        found = figures(OUT / "fit" / "drape_fabric.toml")
        report.near((found["bending_warp"] / 0.163 / 9.81) ** (1 / 3), 0.0234, 0.0015, "its bending length")
    for name, sheet, expected in (("unit", head + "thickness = 0.4\n", "unit_.toml:4: thickness: the unit"), ("word", head + "[kes]\nEMTT = 4\n", "did you mean 'EMT'"),
                                  ("rank", head + '[bending_length]\nbias = "20 mm"\n', "cannot be separated"), ("none", head, "determines the bending stiffness")):
        code, text = fit(name + "_", sheet)
        report.check(code == 2 and expected in text, f"{name}: exit code {code}: {text.strip()[:160]}")
    for words, expected in ((["no_such.toml"], "no such file"), ([OUT / "fit" / "howto.toml", "-o", OUT / "fit" / "howto_fabric.toml"], "--overwrite"), (["a.toml", "--outptu", "b"], "--output")):
        code, text = invoke(["fit", *words])
        report.check(code == 2 and expected in text, f"{expected}: exit code {code}: {text.strip()[:110]}")
