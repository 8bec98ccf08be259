"""Effective masses of modes; vibration over the frequency under loads and on a moving base; random vibration."""

import csv
import math

import numpy as np
from harness import OUT, solve, test
from solver import ROOT, invoke, variant, write_case
from voile import mac, mac_span

CLAMP = [{"type": "clamped", "group": "clamp"}]
TIP = [{"name": "tip", "type": "displacement", "group": "tip", "components": ["z"]}]


def strip_of(nx, ny, length, width):
    return {"file": str(ROOT / "meshes" / "cantilever.geo"),
            "parameters": {"length": length, "width": width, "nx": nx, "ny": ny, "pattern": 1}}


def blade(analysis="harmonic", nx=60, **more):
    """A clamped strip of aluminium, 1 m long."""
    material = [{"type": "isotropic", "young": 70e9, "poisson": 0.0, "thickness": 0.002, "density": 2700.0}]
    return {"title": "Blade", "analysis": analysis, "mesh": strip_of(nx, 2, 1.0, 0.05), "material": material,
            "support": CLAMP, "probe": TIP} | more


def table_of(result, name):
    return np.genfromtxt(result.folder / name, delimiter=",", names=True, ndmin=1)


def response_of(result, probe="tip_z"):
    """Frequencies, and complex displacements."""
    table = table_of(result, "response.csv")
    return table["frequency_hz"], table[f"{probe}_amplitude"] * np.exp(1j * np.radians(table[f"{probe}_phase"]))


@test
def effective_masses(report):
    """Modes of a cantilever take 61.31, 18.83, 6.47, 3.31 % of its mass (Clough & Penzien); all modes take all that moves."""
    area = 0.05 * 1.0
    mass = 2700 * 0.002 * area
    result = solve("harmonic_masses", blade("modal", eigen={"modes": 6}))
    table = table_of(result, "modes.csv")
    across = table[table["effective_mass_z"] > 1e-3 * mass]
    for i, exact in enumerate((0.613076, 0.188300, 0.064742, 0.033078)):
        report.percent(across["effective_mass_z"][i] / (exact * mass), 0.01, f"mode {i + 1}")
    report.percent(across["participation_z"][0] / 1.566, 0.002, "participation of the first")
    sum_z = 100 * table["effective_mass_z"].sum() / mass
    report.check(f"carry 0.0 % of the mass in x, {100 * table['effective_mass_y'].sum() / mass:.1f} % in y, {sum_z:.1f} % in z"
                 in result.text, f"the log has the sums ({sum_z:.1f} % in z)")
    # The same modes on another mesh are the same, whatever the number; all others are square to them.
    fine = solve("harmonic_masses_fine", blade("modal", nx=40, eigen={"modes": 5}))
    found = mac(result.modes, fine.modes)
    report.below(abs(found.diagonal() - 1).max(), 0.01, "MAC of the same mode on two meshes")
    report.below(found[~np.eye(6, 5, dtype=bool)].max(), 0.05, "MAC of different modes")
    # All modes of a free plate: all of its mass, and its moments of inertia about its centre.
    free = blade("modal", mesh=strip_of(3, 2, 1.0, 0.5), support=[], eigen={"modes": 6}, mass=[{"group": "tip", "mass": 0.3}])
    free["probe"] = []
    ends = []
    for ranks in (1, 2):
        table = table_of(solve("harmonic_free", free, ranks), "modes.csv")
        ends.append(table)
        whole = 2700 * 0.002 * 0.5 + 3 * 0.3
        for axis in "xyz":
            report.percent(table[f"effective_mass_{axis}"].sum() / whole, 1e-9, f"free, {ranks} rank(s): mass in {axis}")
        centre = (2.7 * 0.5 + 0.9 * 1.0) / whole
        about_y = 2.7 / 12 + 2.7 * (centre - 0.5) ** 2 + 0.9 * (1 - centre) ** 2
        about_x = 2.7 * 0.25 / 12 + 2 * 0.3 * 0.25**2
        report.percent(table["effective_inertia_y"].sum() / about_y, 1e-9, "moment of inertia about y")
        report.percent(table["effective_inertia_x"].sum() / about_x, 1e-9, "moment of inertia about x")
    lumped = table_of(solve("harmonic_lumped", free | {"eigen": {"modes": 6, "mass": "lumped"}}), "modes.csv")
    report.percent(lumped["effective_mass_z"].sum() / whole, 1e-9, "lumped: mass in z")


@test
def harmonic_methods(report):
    """Superposition against the direct solution and, at rest, the linear analysis; damping of all kinds; 1 to 3 ranks."""
    load = [{"type": "line", "group": "tip", "vector": [0, 0, 2.0]}]
    listed = [1e-3, 1.0, 1.64, 5.0, 10.3, 11.0, 20.0, 28.8, 45.0, 60.0, 90.0]
    damping = {"bending": 1e-4, "mass": 0.3, "membrane": 2e-5}
    for name, section, more in (("loads", {"excitation": "loads"}, {"load": load}),
                                ("base", {"excitation": "base", "direction": [1, 0, 2], "acceleration": 3.0}, {})):
        case = blade(harmonic=section | {"frequencies": listed}, damping=damping, **more)
        few = solve(f"harmonic_{name}", case)
        alone, count = response_of(few)[1], len(few.summary["eigenvalues"])
        many = solve(f"harmonic_{name}_many", case | {"eigen": {"modes": 60}})
        direct = response_of(solve(f"harmonic_{name}_direct", case | {"harmonic": case["harmonic"] | {"method": "direct"}}, 2 if name == "loads" else 3))[1]
        report.below(max(abs(response_of(many)[1] / direct - 1)), 1e-6, f"{name}: 60 modes against the direct solution")
        report.below(max(abs(alone / direct - 1)), 1e-4, f"{name}: {count} modes against it")
        for ranks in (2, 3) if name == "loads" else ():
            other = response_of(solve(f"harmonic_{name}", case, ranks))[1]
            report.below(max(abs(other / alone - 1)), 1e-7, f"{name}: {ranks} ranks")
        if name == "loads":
            linear = solve("harmonic_linear", blade("linear", load=load)).history["tip_z"][-1]
            report.below(abs(direct[0]) / linear - 1, 1e-6, "slowest: the linear analysis")
    # A free plate moves by its mass alone.
    free = blade(support=[], load=[{"type": "area", "vector": [0, 0, 1.0]}], harmonic={"frequencies": [1.0]}, damping={"ratio": [0.02]})
    u = response_of(solve("harmonic_free_body", free))[1][0]
    report.below(abs(u * (2 * math.pi) ** 2 * 5.4 / -1 - 1), 1e-5, "free: acceleration")


@test
def harmonic_peaks(report):
    """A heavy tip on a light blade: one degree of freedom on a moving base, Miles' equation, and a peak that no point of the table misses."""
    ratio, mass = 0.01, 5.0
    for kind, method in (("ratio", {}), ("bending", {}), ("mass", {})):
        case = blade(nx=40, mesh=strip_of(40, 2, 0.2, 0.02), mass=[{"group": "tip", "mass": mass}],
                     harmonic={"excitation": "base", "direction": [0, 0, 1], "acceleration": 9.81, "from": 0.1, "to": 5.0, "points": 20}
                     | method, damping={"ratio": [ratio]})
        if kind == "bending":
            case["damping"] = {"bending": 2 * ratio / (2 * math.pi * first)}
            case["harmonic"]["spacing"] = "linear"
        if kind == "mass":  # air at rest, which acts on the motion in space
            case["damping"] = {"mass": 20 * ratio * 2 * math.pi * first}
        result = solve(f"harmonic_{kind}", case)
        first = result.summary["eigenvalues"][0]
        f, u = response_of(result)
        part = table_of(result, "modes.csv")["participation_z"][0]
        exact = -part * 9.81 / (2 * math.pi) ** 2 / (first**2 - f**2 + 2j * ratio * first * f)
        accelerations = table_of(result, "response.csv")["tip_z_acceleration"]
        if kind == "mass":
            exact = 9.81 * first**2 / (first**2 - f**2 + 20j * ratio * first * f)
            report.below(max(abs(accelerations / abs(exact) - 1)), 0.01, "mass: acceleration in space")
            continue
        report.below(max(abs(u / exact - 1)), 0.002, f"{kind}: one degree of freedom, amplitude and phase, {len(f)} points")
        report.percent(result.summary["response"][0]["largest_amplitude"] / abs(exact).max(), 0.002, "its peak")
        report.percent(max(accelerations / abs(9.81 - (2 * math.pi * f) ** 2 * exact)), 0.002, "acceleration in space")
    section = {"excitation": "base", "direction": [0, 0, 1], "psd_frequencies": [0.02, 500.0], "psd_values": [2.0, 2.0]}
    random = solve("harmonic_random", case | {"harmonic": section, "damping": {"ratio": [ratio]}}, 2)
    rms = random.summary["response"][0]
    miles = math.sqrt(math.pi / 2 * first / (2 * ratio) * 2.0)
    report.percent(rms["rms_acceleration"] / miles, 0.005, "Miles' equation")
    report.percent(rms["rms_displacement"] / math.sqrt(2.0 / (8 * ratio * (2 * math.pi * first) ** 3)), 0.005, "displacement")
    # The table is integrated as it is read: by the trapezoidal rule over many points.
    listed = np.concatenate([np.linspace(0.5, 1.2, 8001)])
    shaped = section | {"psd_frequencies": [0.5, 0.8, 1.2], "psd_values": [1.0, 4.0, 0.5], "frequencies": [float(x) for x in listed]}
    result = solve("harmonic_shaped", case | {"harmonic": shaped, "damping": {"ratio": [ratio]}})
    psd = table_of(result, "response.csv")["tip_z_acceleration_psd"]
    report.percent(math.sqrt(np.trapz(psd, listed)) / result.summary["response"][0]["rms_acceleration"], 1e-4, "a table with slopes")
    # A plate of two triangles on springs has no more modes than four: they are all, up to any frequency.
    buoy = blade(mesh=strip_of(1, 1, 1.0, 1.0), support=[{"type": "displacement", "group": "plate", "components": ["x", "y"]}],
                 mass=[{"group": "plate", "mass": 1e4}], spring=[{"type": "point", "group": "plate", "stiffness": 4e6, "direction": [0, 0, 1]}],
                 harmonic=section, damping={"ratio": [ratio]})
    rms, first = solve("harmonic_buoy", buoy).summary["response"][0]["rms_acceleration"], math.sqrt(4e6 / 1e4) / (2 * math.pi)
    report.percent(rms / math.sqrt(math.pi / 2 * first / (2 * ratio) * 2.0), 0.005, "a plate of two triangles on springs")


@test
def harmonic_in_time(report):
    """A motion in time whose base follows a cosine settles into the response, with damping of both kinds."""
    f, acceleration = 1.2, 0.1
    omega = 2 * math.pi * f
    damping = {"mass": 2.0, "bending": 0.01}
    base = {"excitation": "base", "direction": [0, 0, 1], "acceleration": acceleration, "frequencies": [f]}
    u = response_of(solve("harmonic_settled", blade(nx=10, harmonic=base, damping=damping, eigen={"mass": "lumped"})))[1][0]
    mover = {"type": "clamped", "group": "clamp", "motion": [0, 0, f"-{acceleration}/{omega}^2*(cos({omega}*t)-1)"]}
    foot = {"name": "foot", "type": "displacement", "group": "clamp", "components": ["z"]}
    steps = 200
    motion = blade("dynamic", nx=10, support=[mover], probe=[*TIP, foot], damping=damping, output={"every": 100000},
                   time={"end": 10 / f, "step": 1 / f / steps, "spectral_radius": 1.0})
    h = solve("harmonic_moved", motion).history
    relative = (h["tip_z"] - h["foot_z"])[-steps:]
    found = 2 / steps * np.sum(relative * np.exp(-1j * omega * h["time"][-steps:]))
    report.below(abs(u / found - 1), 0.001, f"amplitude {abs(u):.4g} m, phase {np.degrees(np.angle(u)):.2f} degrees")


@test
def harmonic_about_states(report):
    """About a taut state: a string's response on its side; stages keep earlier loads as those of the equilibrium."""
    tension, pressure, thickness = 500.0, 1e-3, 5e-4
    areal = 1000 * thickness
    speed = math.sqrt(tension / areal)
    first = speed / 2  # of a string of 1 m [Hz]
    listed = [1e-3 * first, 0.5 * first, 1.6 * first, 2.5 * first]
    material = [{"type": "isotropic", "young": 2e9, "poisson": 0.0, "thickness": thickness, "density": 1000.0}]
    case = blade(nx=80, material=material, eigen={"mass": "lumped"},
                 support=[{"type": "hinged", "group": "clamp"}, {"type": "displacement", "group": "tip", "components": ["z"]}],
                 load=[{"type": "line", "group": "tip", "vector": [tension, 0, 0], "constant": True},
                       {"type": "area", "vector": [0, 0, pressure]}],
                 probe=[{"name": "middle", "type": "displacement", "point": [0.5, 0.025, 0.0], "components": ["z"]}],
                 harmonic={"frequencies": listed})
    exact = []
    for f in listed:
        omega = 2 * math.pi * f
        exact.append(pressure / (areal * omega**2) * (1 / math.cos(omega / speed / 2) - 1))
    found = response_of(solve("harmonic_string", case), "middle_z")[1]
    for f, u, w in zip(listed, found, exact):
        report.percent(u.real / w, 0.005, f"string at {f / first:g} times its first frequency")
    pull, shake = dict(case["load"][0]), case["load"][1] | {"stages": ["shake"]}
    del pull["constant"], case["analysis"]
    staged = case | {"load": [pull, shake], "stage": [{"name": "pull", "analysis": "static"}, {"name": "shake", "analysis": "harmonic"}]}
    result = solve("harmonic_stages", staged, 2)
    result.folder = result.folder / "shake"
    report.below(max(abs(response_of(result, "middle_z")[1] / found - 1)), 1e-6, "as a stage behind its tension")


@test
def harmonic_mistakes(report):
    """What cannot be answered is refused with its key and a remedy, or warned of."""
    base = {"excitation": "base", "direction": [0, 0, 1], "from": 1.0, "to": 50.0}
    load = [{"type": "line", "group": "tip", "vector": [0, 0, 2.0]}]
    psd = {"excitation": "base", "direction": [0, 0, 1], "psd_frequencies": [1.0, 50.0], "psd_values": [1.0, 1.0]}
    wrong = [
        ("harmonic.from", ">= 0", {"harmonic": base | {"from": -1.0}}),
        ("harmonic.from", "above 0 with logarithmic", {"harmonic": {k: v for k, v in base.items() if k != "from"}}),
        ("harmonic.to", "must be above from", {"harmonic": base | {"to": 0.5}}),
        ("harmonic.direction", "the key is missing", {"harmonic": {"excitation": "base", "from": 1.0, "to": 50.0}}),
        ("harmonic.frequencies", "ascending", {"harmonic": {"excitation": "base", "direction": [0, 0, 1], "frequencies": [2.0, 1.0]}}),
        ("harmonic.psd_frequencies", "ascending", {"harmonic": psd | {"psd_frequencies": [50.0, 1.0]}}),
        ("harmonic.psd_values", "2 frequencies and 1 values", {"harmonic": psd | {"psd_values": [1.0]}}),
        ("damping.ratio", "without damping", {"harmonic": psd, "damping": {"bending": 0.0}}),
        ("harmonic.method", "superposition", {"harmonic": psd | {"method": "direct"}, "damping": {"bending": 1e-4}}),
        ("harmonic.direction", "symmetry", {"harmonic": base | {"direction": [0, 1, 0]}, "support": [
            {"type": "clamped", "group": "clamp"}, {"type": "symmetry", "group": "side_low"}]}),
        ("damping.mass", "0 Hz", {"harmonic": base | {"from": 0.0, "spacing": "linear"}, "damping": {"mass": 1.0}}),
        ("time.mass", "lumped", {"analysis": "dynamic", "damping": {}, "time": {"mass": "consistent"}, "support": [
            {"type": "clamped", "group": "clamp", "motion": ["0", "0", "0.1*t"]}]}),
        ("damping.ratio", "has no modes", {"harmonic": base | {"method": "direct"}}),
        ("harmonic.excitation", "no load varies", {"harmonic": {"from": 1.0, "to": 50.0}}),
        ("load.type", "follower_pressure", {"harmonic": {"from": 1.0, "to": 50.0}, "load": [{"type": "follower_pressure", "magnitude": 1.0}]}),
        ("[[probe]]", "displacement", {"harmonic": base, "probe": []}),
        ("probe.type", "must be a displacement", {"harmonic": base, "probe": TIP + [{"name": "f", "type": "energy"}]}),
        ("[air]", "does not drag", {"harmonic": base, "air": {"normal_drag": 1.0}}),
        ("[contact]", "there is no contact", {"harmonic": base, "contact": {"distance": 1e-3}}),
        ("[remesh]", "nothing is remeshed", {"harmonic": base, "remesh": {"largest": 0.1}}),
        ("harmonic.direction", "leaves it behind", {"harmonic": base, "support": []}),
        ("[[support]]", "do not move by `value`", {"harmonic": {"from": 1.0, "to": 50.0}, "load": load, "support": CLAMP + [
            {"type": "displacement", "group": "tip", "components": ["x"], "value": [0.01, 0, 0]}]}),
        ("damping.ratio", "use `bending`", {"analysis": "dynamic"}),
        ("eigen.modes", "give a number", {"analysis": "modal", "eigen": {"modes": 0}}),
    ]
    for key, part, changes in wrong:
        code, text = invoke(["check", write_case(blade(nx=8, damping={"ratio": [0.02]}) | changes, OUT / "harmonic_wrong.toml")])
        report.check(code == 2 and key in text and part in text and "harmonic_wrong.toml" in text,
                     f"{key}: {part}" + ("" if code == 2 and key in text and part in text else f": code {code}: {text[-300:]}"))
    late = [("eigen.modes", "but the response is wanted up to 50", {"harmonic": base, "eigen": {"modes": 2}}),
            ("harmonic", "the equilibrium is unstable", {"harmonic": base, "load": [
                {"type": "line", "group": "tip", "vector": [-150.0, 0, 0], "constant": True}]})]
    for key, part, changes in late:
        code, text = invoke(["run", write_case(blade(nx=8, damping={"ratio": [0.02]}) | changes, OUT / "harmonic_wrong.toml"),
                             "--output", str(OUT / "harmonic_wrong"), "--overwrite"])
        report.check(code == 2 and key in text and part in text, f"{key}: {part}" + ("" if code == 2 and part in text else f": code {code}: {text[-300:]}"))
    loose = solve("harmonic_undamped", blade(nx=8, harmonic=base))
    report.check("nothing damps the resonance(s) at 1.6" in loose.text, "an undamped resonance is warned of")


@test
def compared_modes(report):
    """`voile compare` and the Python package: a run with itself, a pair whose basis another mesh chooses, other analyses and shapes."""
    def plate(pattern, n, **more):
        return {"title": "Plate", "analysis": "modal", "eigen": {"modes": 4},
                "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": n, "pattern": pattern}},
                "material": [{"type": "isotropic", "young": 70e9, "poisson": 0.3, "thickness": 0.01, "density": 2700.0}],
                "support": [{"type": "hinged", "group": g} for g in ("left", "right", "bottom", "top")],
                "mass": [{"group": "centre", "mass": 3.0}]} | more

    one, two = solve("compare_one", plate(1, 8)), solve("compare_two", plate(0, 12))
    table = OUT / "compare.csv"
    table.unlink(missing_ok=True)
    code, text = invoke(["compare", str(one.folder), str(one.folder), "--output", str(table)])
    own = np.genfromtxt(table, delimiter=",", names=True)
    matrix = np.array([[row[str(j)] for j in range(1, 5)] for row in own])
    report.check(code == 0 and "weighted by the mass" in text, "a run with itself is weighted by the mass")
    report.below(abs(matrix - np.eye(4)).max(), 1e-12, "MAC of a run with itself, all of its modes")
    report.below(abs(mac(one.modes, one.modes) - matrix).max(), 1e-12, "Python agrees")
    report.below(abs(mac_span(one.modes, one.modes, [2, 3])[1:3] - 1).max(), 1e-12, "span of its pair")
    code, text = invoke(["compare", str(one.folder), str(two.folder), "--output", str(table), "--overwrite"])
    other = np.genfromtxt(table, delimiter=",", names=True)
    matrix = np.array([[row[str(j)] for j in range(1, 5)] for row in other])
    report.check(code == 0 and "meshes differ" in text and " of 2, 3" in text, "another mesh; the pair is one of a plane")
    report.check(matrix[1:3, 1:3].max() < 0.98, f"no mode of the pair is one of the other's: {matrix[1:3, 1:3].round(3).tolist()}")
    report.below(abs(other["span"] - 1).max(), 0.005, "but each lies in the span of the other's")
    report.below(abs(mac(one.modes, two.modes) - matrix).max(), 1e-6, "Python agrees")
    report.below(abs(mac_span(one.modes, two.modes, [2, 3])[1:3] - other["span"][1:3]).max(), 1e-6, "in the span too")
    curved = solve("compare_curved", plate(0, 12, imperfection=[{"type": "expression", "height": "0.4*sin(pi*x)*sin(pi*y)"}]))
    buckling = plate(1, 8, analysis="buckling", mass=[], load=[{"type": "line", "group": "right", "vector": [-1e4, 0, 0]}])
    buckling["support"] = [{"type": "hinged", "group": "left"}] + [
        {"type": "displacement", "group": g, "components": ["z"]} for g in ("right", "bottom", "top")]
    buckled = solve("compare_buckling", buckling)
    part = solve("compare_part", plate(0, 6) | {"mesh": plate(0, 6)["mesh"] | {"scale": 0.6}})
    for pair in ((one, part), (part, one)):
        code, text = invoke(["compare", *(str(r.folder) for r in pair)])
        report.check(code == 2 and "the two shapes differ" in text, f"a part of a shape: code {code}")
    for folder, wanted in ((curved.folder, "the two shapes differ"), (buckled.folder, "compare runs of one analysis"),
                           (OUT / "nothing", "there are no modes"), (two.folder, "the file is there already")):
        code, text = invoke(["compare", str(one.folder), str(folder), "--output", str(table)]
                            if "already" in wanted else ["compare", str(one.folder), str(folder)])
        report.check(code == 2 and wanted in text, f"{wanted}" if wanted in text else f"code {code}: {text}")
    try:
        mac(one.modes, curved.modes)
        report.check(False, "Python refuses other shapes")
    except ValueError as error:
        report.check("other shapes" in str(error), "Python refuses other shapes")


@test
def harmonic_coupled_damping(report):
    """A laminate that couples stretching and bending, damped in its membrane: superposition is what the direct solution is."""
    case = {
        "analysis": "harmonic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.5, "width": 0.3, "nx": 10, "ny": 6}},
        "material": [{"type": "laminate", "young_1": 140e9, "young_2": 10e9, "poisson_12": 0.3, "shear_12": 5e9, "angles": [0, 30, 90],
                      "ply_thicknesses": [2e-4, 1e-4, 3e-4], "density": 1600.0, "direction": [1, 0.4, 0]}],
        "support": [{"type": "clamped", "group": "clamp"}], "load": [{"type": "line", "group": "tip", "vector": [0, 0, 1]}],
        "probe": [{"name": "u", "type": "displacement", "group": "tip"}], "damping": {"membrane": 1e-3},
        "harmonic": {"from": 1, "to": 50, "points": 2}}
    ends = []
    for method in ("direct", "superposition"):
        solve(f"harmonic_coupled_{method}", variant(case, {"harmonic.method": method}), 1)
        with open(OUT / f"harmonic_coupled_{method}" / "response.csv", encoding="utf-8") as file:
            ends.append(list(csv.DictReader(file))[-1])
    for c in "xyz":
        report.percent(float(ends[1][f"u_{c}_amplitude"]) / float(ends[0][f"u_{c}_amplitude"]), 0.01, f"u_{c} at 50 Hz")
