"""Reactions, stresses and fields of vibrations: static limit, a shaken beam, Miles, a load that changes the temperature."""

import math

import numpy as np
from harmonic import TIP, blade, response_of, strip_of, table_of
from harness import OUT, solve, test
from solver import ROOT, invoke, load_case, write_case
from voile import Results

AREA, HEIGHT, YOUNG, DENSITY = 0.05, 0.002, 70e9, 2700.0  # width 0.05 m of 1 m
SKIN = {"name": "skin", "type": "stress", "point": [0.254, 0.0126, 0.0]}
FOOT = {"name": "foot", "type": "reaction", "group": "clamp"}
LOAD = [{"type": "line", "group": "tip", "vector": [3000.0, 0, 2.0]}]
BASE = {"excitation": "base", "direction": [0, 0, 1], "acceleration": 3.0}


def fields_of(result, folder="response"):
    return Results(result.folder / folder)


def triangle_at(mesh, point):
    return int(np.linalg.norm(mesh.positions[mesh.triangles].mean(axis=1) - point, axis=1).argmin())


def shaken_beam(omega, x):
    """Root shear per acceleration of the base, and moment at x, of a clamped beam of 1 m; both relative to EI."""
    inertia = AREA * HEIGHT**3 / 12
    b = (DENSITY * AREA * HEIGHT * omega**2 / (YOUNG * inertia)) ** 0.25

    def row(d, at):  # of cos, sin, cosh, sinh, differentiated d times
        c, s, ch, sh = math.cos(b * at), math.sin(b * at), math.cosh(b * at), math.sinh(b * at)
        circular = [(c, s), (-s, c), (-c, -s), (s, -c)][d]
        hyperbolic = (ch, sh) if d % 2 == 0 else (sh, ch)
        return [b**d * v for v in (*circular, *hyperbolic)]

    w = np.linalg.solve([row(0, 0), row(1, 0), row(2, 1), row(3, 1)], [-1 / omega**2, 0, 0, 0])
    return YOUNG * inertia * np.dot(row(3, 0), w), YOUNG * inertia * np.dot(row(2, x), w)


def mean_across(mesh, group, values):
    """Over the length of a straight group along y, as a probe takes it."""
    members = mesh.group(group)
    members = members[np.argsort(mesh.positions[members, 1])]
    y = mesh.positions[members, 1]
    return np.trapz(values[members], y) / (y[-1] - y[0])


@test
def harmonic_forces(report):
    """Reaction and stress of a shaken cantilever against the exact beam; at rest, all of the linear analysis; both methods, 1 to 3
    ranks, damping of all kinds."""
    probes = TIP + [FOOT, SKIN]
    listed = [0.5, 3.0, 8.0, 20.0]
    shaken = solve("harmonic_shaken", blade(probe=probes, harmonic=BASE | {"frequencies": listed, "field_frequencies": [3.0, 20.0]}))
    fields = fields_of(shaken)
    mesh = fields.mesh()
    t = triangle_at(mesh, SKIN["point"])
    places = mesh.positions[mesh.triangles].mean(axis=1)[:, 0]
    around = abs(places - 0.25) < 0.03
    force, stress = response_of(shaken, "foot_z")[1], response_of(shaken, "skin_11")[1]
    for i, f in enumerate(listed):
        shear = shaken_beam(2 * math.pi * f, 0.0)[0]
        report.percent(force[i].real / (BASE["acceleration"] * shear), 0.005, f"{f:g} Hz: reaction at the root")
    for step in fields:
        i = listed.index(step.time)
        sum_z = step["reaction_amplitude"][:, 2].sum()  # all in phase
        report.percent(sum_z / abs(force[i]), 1e-9, f"{step.time:g} Hz: field of the reaction")
        report.percent(step["stress_top_amplitude"][t, 0] / abs(stress[i]), 1e-9, "field of stress")
        moment = shaken_beam(2 * math.pi * step.time, places[around].mean())[1]
        exact = BASE["acceleration"] * moment * 6 / (AREA * HEIGHT**2)
        report.percent(step["stress_top_amplitude"][around, 0].mean() / abs(exact), 0.002 * step.time, "stress about a quarter of the length")
        report.percent(step["von_mises_bottom_amplitude"][t] / abs(stress[i]), 0.01, "von Mises on the other face")
        tip = mean_across(mesh, "tip", step["displacement_amplitude"][:, 2])
        report.percent(tip / abs(response_of(shaken)[1][i]), 1e-9, "field of displacement")
    damping = {"bending": 1e-4, "mass": 0.3, "membrane": 2e-5}
    for name, section, more in (("loads", {"excitation": "loads"}, {"load": LOAD}), ("base", BASE | {"direction": [1, 0, 1e-3]}, {})):
        case = blade(nx=30, probe=probes, damping=damping, eigen={"modes": 60},
                     harmonic=section | {"frequencies": [1e-6, 1.6, 10.3, 60.0], "field_frequencies": [10.3]}, **more)
        modal = solve(f"harmonic_forces_{name}", case)
        direct = solve(f"harmonic_forces_{name}_direct", case | {"harmonic": case["harmonic"] | {"method": "direct"}}, 2)
        for column in ("foot_x", "foot_z", "skin_11"):
            one, two = response_of(modal, column)[1], response_of(direct, column)[1]
            report.below(max(abs(one / two - 1)), 3e-5, f"{name}: {column} against the direct solution")
        one, two = fields_of(modal)[0], fields_of(direct)[0]
        for field in ("displacement_amplitude", "stress_top_amplitude", "bending_moment_amplitude", "reaction_amplitude"):
            report.below(np.abs(one[field] - two[field]).max() / np.abs(two[field]).max(), 1e-5, f"{name}: {field}")
        if name == "base":
            continue
        linear = solve("harmonic_forces_linear", case | {"analysis": "linear", "harmonic": {}, "eigen": {}, "damping": {}}).history
        for column, limit in (("tip_z", 1e-6), ("foot_x", 1e-6), ("foot_z", 1e-6), ("skin_11", 1e-5)):
            report.below(abs(response_of(modal, column)[1][0] / linear[column][-1] - 1), limit, f"at rest: {column}")
        report.below(table_of(modal, "response.csv")["skin_von_mises_amplitude"][0] / linear["skin_von_mises"][-1] - 1, 1e-5, "von Mises")
        other = solve("harmonic_forces_ranks", case, 3)
        for column in ("foot_z", "skin_11"):
            report.below(max(abs(response_of(other, column)[1] / response_of(modal, column)[1] - 1)), 1e-6, f"3 ranks: {column}")


@test
def harmonic_heavy_end(report):
    """The force that shakes the foot of a blade with a heavy rigid end is that of point masses there, and all inertia far below the resonances."""
    listed, heavy = [0.01, 1.0, 4.0, 9.0], 0.2
    shaken = BASE | {"frequencies": listed}
    rigid = blade(nx=40, probe=TIP + [FOOT], damping={"ratio": [0.02]}, harmonic=shaken, rigid=[{"name": "lump", "group": "tip", "mass": heavy, "turn": "about", "turn_axis": [0, 1, 0]}])
    force = [response_of(solve("heavy_rigid", rigid, ranks), "foot_z")[1] for ranks in (1, 3)]
    direct = rigid | {"harmonic": shaken | {"method": "direct"}, "damping": {"bending": 1e-4}}
    points = {k: v for k, v in rigid.items() if k != "rigid"} | {"mass": [{"group": "tip", "mass": heavy / 3}]}  # on three vertices
    whole = (DENSITY * AREA * HEIGHT + heavy) * BASE["acceleration"]
    report.percent(abs(force[0][0]) / whole, 1e-3, "a mass times the acceleration far below")
    report.below(max(abs(force[1] / force[0] - 1)), 1e-6, "3 ranks")
    other = response_of(solve("heavy_points", points), "foot_z")[1]
    report.below(max(abs(force[0] / other - 1)), 2e-3, "against point masses")
    one, two = (response_of(solve(f"heavy_{k}", direct | {"harmonic": direct["harmonic"] | {"method": k} if k == "direct" else shaken, "eigen": {"modes": 40}}), "foot_z")[1] for k in ("direct", "modal"))
    report.below(max(abs(two / one - 1)), 1e-4, "by modes and directly")


@test
def harmonic_heated(report):
    """A temperature that follows a cosine: a held bar bears E alpha T far below its resonances, though nothing moves."""
    case = blade(nx=10, support=[{"type": "displacement", "group": group, "components": held} for group, held in
                                  (("clamp", ["x", "z"]), ("tip", ["x", "z"]), ("side_low", ["y"]))], probe=[FOOT | {"components": ["x"]}, SKIN],
                 temperature=[{"change": 30.0}], harmonic={"frequencies": [1e-3], "field_frequencies": [1e-3]})
    case["material"][0]["expansion"] = 2e-5
    result = solve("harmonic_heated", case)
    exact = -YOUNG * 2e-5 * 30.0
    report.percent(response_of(result, "skin_11")[1][0].real / exact, 1e-6, "stress")
    report.percent(response_of(result, "foot_x")[1][0].real / (-exact * AREA * HEIGHT), 1e-6, "reaction")
    report.percent(fields_of(result)[0]["stress_top_amplitude"][len(fields_of(result).mesh().triangles) // 2, 0] / -exact, 1e-6, "field")


@test
def random_forces(report):
    """A heavy tip under white noise by Miles: reaction, root stress, fields of root mean squares; von Mises of one stress is its size."""
    ratio, mass, length = 0.01, 5.0, 0.2
    probes = TIP + [FOOT, SKIN | {"point": [0.002, 0.005, 0.0]}]
    case = blade(nx=40, mesh=strip_of(40, 2, length, 0.02), mass=[{"group": "tip", "mass": mass}], probe=probes, damping={"ratio": [ratio]},
                 harmonic={"excitation": "base", "direction": [0, 0, 1], "psd_frequencies": [0.02, 500.0], "psd_values": [2.0, 2.0]})
    result = solve("random_forces", case, 2)
    rms = {r["probe"]: r for r in result.summary["response"]}
    first = result.summary["eigenvalues"][0]
    miles = math.sqrt(math.pi / 2 * first / (2 * ratio) * 2.0)
    whole = 3 * mass  # of the group's vertices; the blade weighs a thousandth of them
    report.percent(rms["foot_z"]["rms_reaction"] / (whole * miles), 0.01, "reaction")
    field = fields_of(result, "random")[0]
    mesh = fields_of(result, "random").mesh()
    t = triangle_at(mesh, probes[2]["point"])
    arm = length - float(mesh.positions[mesh.triangles[t]].mean(axis=0)[0])
    report.percent(rms["skin_11"]["rms_stress"] / (whole * miles * arm * 6 / (0.02 * HEIGHT**2)), 0.01, "stress at the root")
    report.percent(field["stress_top_rms"][t, 0] / rms["skin_11"]["rms_stress"], 1e-6, "field of stress")
    report.percent(field["von_mises_top_rms"][t] / rms["skin_von_mises"]["rms_stress"], 1e-6, "field of von Mises")
    report.percent(mean_across(mesh, "tip", field["displacement_rms"][:, 2]) / rms["tip_z"]["rms_displacement"], 1e-4, "field of displacement")
    report.percent(mean_across(mesh, "tip", field["acceleration_rms"][:, 2]) / rms["tip_z"]["rms_acceleration"], 1e-4, "field of acceleration")
    base = math.sqrt(2.0 * (500.0 - 0.02))
    report.percent(field["acceleration_rms"][mesh.group("clamp"), 2].max() / base, 1e-6, "the base itself")
    psd = table_of(result, "response.csv")
    i = psd["frequency_hz"].searchsorted(first)
    report.percent(psd["foot_z_psd"][i] / (2.0 * psd["foot_z_amplitude"][i] ** 2), 1e-9, "density of the reaction")


@test
def harmonic_fields_mistakes(report):
    """Probes and fields that cannot be are refused with their key."""
    base = BASE | {"from": 1.0, "to": 50.0}
    stiff = [{"type": "matrices", "membrane": [[1e6, 0, 0], [0, 1e6, 0], [0, 0, 5e5]],
              "bending": [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]], "areal_density": 5.0}]
    for key, part, changes in (
            ("harmonic.field_frequencies", "ascending", {"harmonic": base | {"field_frequencies": [2.0, 1.0]}}),
            ("harmonic.field_frequencies", "> 0", {"harmonic": base | {"field_frequencies": [0.0]}}),
            ("probe.point", "missing", {"harmonic": base, "probe": [{"name": "s", "type": "stress"}]}),
            ("'face'", "does not belong", {"harmonic": base, "probe": [TIP[0] | {"face": "top"}]}),
            ("[[probe]] 'skin'", "without its layers", {"harmonic": base, "probe": [SKIN], "material": stiff}),
            ("[[probe]] 'skin'", "new mesh", {"analysis": "static", "damping": {}, "probe": [SKIN], "load": LOAD, "remesh": {"largest": 0.1}})):
        code, text = invoke(["check", write_case(blade(nx=8, damping={"ratio": [0.02]}) | changes, OUT / "fields_wrong.toml")])
        report.check(code == 2 and key in text and part in text and "fields_wrong.toml" in text,
                     f"{key}: {part}" + ("" if code == 2 and key in text and part in text else f": code {code}: {text[-300:]}"))
    fields = fields_of(solve("fields_rigid", blade(nx=8, damping={"ratio": [0.02]}, harmonic=BASE | {"frequencies": [1.0], "field_frequencies": [1.0]},
                                                   rigid=[{"name": "lump", "group": "tip", "mass": 0.1}])))[0]
    report.check("reaction_amplitude" in fields and "stress_top_amplitude" in fields, "fields beside a rigid group")
    folder = OUT / "fields_rigid"
    there = (folder / "response" / "results.vtkhdf").is_file()
    code, text = invoke(["run", write_case(blade(nx=8, damping={}) | {"analysis": "static", "load": LOAD}, OUT / "fields_over.toml"), "--output", str(folder), "--overwrite"])
    report.check(there and code == 0 and not (folder / "response").exists(), f"--overwrite by another analysis takes its folder away: code {code}")


def board_series(case):
    """First frequency, root mean squares of acceleration and stress 11 and von Mises's in the middle of a supported orthotropic plate."""
    m, (a, b) = case["material"][0], (case["mesh"]["parameters"][k] for k in ("length", "width"))
    e_1, e_2, shear, h = 24e9, 21e9, 4.5e9, 1.6e-3
    contraction = 1 - m["poisson_12"] ** 2 * e_2 / e_1
    d_11, d_22, d_66 = (x * h**3 / 12 for x in (e_1 / contraction, e_2 / contraction, shear))
    d_12 = m["poisson_12"] * d_22
    section, ratio = case["harmonic"], case["damping"]["ratio"][0]
    f = np.geomspace(section["psd_frequencies"][0], section["psd_frequencies"][-1], 40001)
    density = np.exp(np.interp(np.log(f), np.log(section["psd_frequencies"]), np.log(section["psd_values"])))
    w = 2 * math.pi * f
    acceleration, stress, all_frequencies = np.ones(len(f), dtype=complex), np.zeros((2, len(f)), dtype=complex), []
    for i in range(1, 20, 2):
        for j in range(1, 20, 2):
            x, y = (i * math.pi / a) ** 2, (j * math.pi / b) ** 2
            natural = math.sqrt((d_11 * x**2 + 2 * (d_12 + 2 * d_66) * x * y + d_22 * y**2) / (m["density"] * h))
            all_frequencies.append(natural / (2 * math.pi))
            force = 16 / (math.pi**2 * i * j) * math.sin(i * math.pi / 2) * math.sin(j * math.pi / 2)
            q = -force / (natural**2 - w**2 + 2j * ratio * natural * w)
            acceleration -= w**2 * q
            stress += 6 / h**2 * np.outer((d_11 * x + d_12 * y, d_12 * x + d_22 * y), q)
    one, two = stress
    von_mises = abs(one) ** 2 + abs(two) ** 2 - (one * two.conj()).real
    return min(all_frequencies), *(math.sqrt(np.trapz(s * density, f)) for s in (abs(acceleration) ** 2, abs(one) ** 2, von_mises))


@test
def board(report):
    """The example of runs/board against the series of a supported plate."""
    case = load_case(ROOT / "runs" / "board" / "case.toml")
    result = solve("board", case)
    first, acceleration, stress, von_mises = board_series(case)
    rms = {r["probe"]: r for r in result.summary["response"]}
    report.percent(result.summary["eigenvalues"][0] / first, 0.001, "first frequency")
    report.percent(rms["middle_z"]["rms_acceleration"] / acceleration, 0.01, "acceleration of the middle")
    report.percent(rms["middle_stress_11"]["rms_stress"] / stress, 0.01, "its stress along x")
    report.percent(rms["middle_stress_von_mises"]["rms_stress"] / von_mises, 0.02, f"von Mises's stress: {von_mises:.5g} Pa")
    field = fields_of(result, "random")[0]["von_mises_top_rms"]
    report.percent(field.max() / rms["middle_stress_von_mises"]["rms_stress"], 0.03, "largest of the field")
