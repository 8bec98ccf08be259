"""Periodic edges: a strip in plane strain, a cell that is stretched, modes of an infinite plate, a motion; ranks, restart, mistakes."""

import math

import numpy as np
from common import fresh
from harness import OUT, solve, test
from panels import Panels
from shapes import write_msh
from solver import ROOT, run, write_case

YOUNG, POISSON, THICKNESS, DENSITY = 1.2e6, 0.3, 0.1, 100.0
PLATE = {"type": "isotropic", "young": YOUNG, "poisson": POISSON, "thickness": THICKNESS, "density": DENSITY}
BENDING = YOUNG * THICKNESS**3 / (12 * (1 - POISSON**2))
SIDES = {"from": "side_low", "to": "side_high", "name": "across"}


def strip(analysis, n, length, width, periodic, pattern=2, material=PLATE, **more):
    mesh = {"file": str(ROOT / "meshes" / "cantilever.geo"),
            "parameters": {"length": length, "width": width, "nx": n, "ny": max(1, round(n * width / length)), "pattern": pattern}}
    return {"title": "Periodic", "analysis": analysis, "mesh": mesh, "material": [material], "periodic": periodic,
            "output": {"every": 1000}} | more


def cell(name, analysis, n, m, length, width, along=None, across=None, material=PLATE, **more):
    """A rectangle that repeats itself along both sides, held at a corner."""
    p = Panels()
    at = p.add("plate", (0, 0, 0), (length, 0, 0), (0, width, 0), n, m)
    p.point("corner", at[0, 0])
    mesh = p.write(OUT / f"{name}.msh")
    pairs = [{"from": "plate start", "to": "plate end", "name": "along"} | (along or {}),
             {"from": "plate low", "to": "plate high", "name": "across"} | (across or {})]
    return {"title": "Cell", "analysis": analysis, "mesh": {"file": str(mesh)}, "material": [material], "periodic": pairs,
            "support": [{"type": "hinged", "group": "corner"}], "output": {"every": 1000}} | more


@test
def periodic_strip(report):
    """One period of an infinitely wide cantilever is in plane strain, also one cell wide, on 1, 2 and 3 ranks."""
    length, load = 10.0, 0.04
    exact = load * length**3 / (3 * BENDING)
    probe = [{"name": "tip", "type": "displacement", "group": "tip"}, {"name": "clamp", "type": "reaction", "group": "clamp"}]
    more = {"support": [{"type": "clamped", "group": "clamp"}], "probe": probe,
            "load": [{"type": "line", "group": "tip", "vector": [0, 0, load]}]}
    for pattern, n, width in ((0, 40, 1.0), (1, 40, 1.0), (2, 40, 1.0), (2, 40, 0.25), (0, 40, 0.25)):
        h = solve("periodic_strip", strip("linear", n, length, width, [SIDES], pattern, **more)).history
        report.percent(h["tip_z"][-1] / exact, 0.003, f"pattern {pattern}, {width} m wide: deflection")
        report.near(h["clamp_z"][-1], -load * width, 1e-9, "the clamp holds the load")
    free = solve("periodic_free", strip("linear", 40, length, 1.0, [], **more)).history
    report.check(free["tip_z"][-1] / exact > 1.05, "with free sides it is another one")
    large = more | {"load": [{"type": "line", "group": "tip", "vector": [0, 0, 10 * load]}]}
    runs = [solve(f"periodic_large_{ranks}", strip("static", 40, length, 1.0, [SIDES], **large), ranks) for ranks in (1, 2, 3)]
    shapes = [r.displacement() for r in runs]
    for ranks, shape in zip((2, 3), shapes[1:]):
        report.below(np.abs(shape - shapes[0]).max() / length, 1e-7, f"{ranks} ranks")
    beam = PLATE | {"poisson": 0.0, "young": YOUNG / (1 - POISSON**2)}
    plain = solve("periodic_beam", strip("static", 40, length, 1.0, [], material=beam, **large)).history["tip_z"][-1]
    report.percent(runs[0].history["tip_z"][-1] / plain, 0.003, "at a large deflection as a beam of E/(1 - nu^2)")
    stopped = solve("periodic_half", strip("static", 40, length, 1.0, [SIDES], **large, steps={"stops": [0.5], "final_load_factor": 0.5}))
    again = solve("periodic_again", strip("static", 40, length, 1.0, [SIDES], **large), options=["--restart", str(stopped.folder / "checkpoint.h5")])
    report.below(np.abs(again.displacement() - shapes[0]).max() / length, 1e-7, "continued from half the load")


@test
def periodic_cell(report):
    """A cell that is stretched has one stress; forces on free differences stretch it as far, and expressions along a path."""
    length, width, strain = 2.0, 1.0, 0.01
    stiffness = YOUNG * THICKNESS / (1 - POISSON**2)
    stretched = {"along": {"difference": [strain * length, 0, 0]}, "across": {"difference": [0, -0.5 * strain * width, 0]}}
    for ranks in (1, 2, 3):
        h = solve("periodic_cell", cell("periodic_cell", "linear", 6, 3, length, width, **stretched), ranks).history
        report.percent(h["along_force_x"][-1] / (stiffness * strain * (1 - 0.5 * POISSON) * width), 1e-9, f"{ranks} ranks: force along")
        report.percent(h["across_force_y"][-1] / (stiffness * strain * (POISSON - 0.5) * length), 1e-9, "across")
        report.near(h["along_x"][-1], strain * length, 1e-12, "difference")
    path = {"along": {"difference": [f"{20 * strain * length}*t", 0, 0]}, "across": {"difference": [0, "free", 0]}}
    run_of = solve("periodic_path", cell("periodic_path", "static", 6, 3, length, width, output={}, **path))
    h, step = run_of.history, run_of.results[-1]
    green = 20 * strain + 0.5 * (20 * strain)**2
    force = YOUNG * THICKNESS * green * (1 + 20 * strain) * width
    report.percent(h["along_force_x"][-1] / force, 1e-9, "force at 20 % of stretch")
    report.percent(h["across_y"][-1] / (width * (math.sqrt(1 - 2 * POISSON * green) - 1)), 1e-9, "it gets narrower as it likes")
    n = step["membrane_force"]
    report.below(np.ptp(n, axis=0).max() / np.abs(n).max(), 1e-9, "one stress everywhere")
    report.below(np.abs(step["bending_moment"]).max(), 1e-9, "no moment")
    pulled = {"along": {"difference": ["free", 0, 0], "force": [force, 0, 0]}, "across": {"difference": [0, "free", 0]}}
    for analysis in ("static", "drape"):
        h = solve("periodic_pulled", cell("periodic_pulled", analysis, 6, 3, length, width, **pulled)).history
        report.percent(h["along_x"][-1] / (20 * strain * length), 1e-6, f"{analysis}: the force stretches it as far")
    arc = {"along": {"difference": [20 * strain * length, 0, 0]}, "across": {"difference": [0, "free", 0]}}
    probes = [{"name": name, "type": "reaction", "group": f"plate {name}"} for name in ("start", "end", "low", "high")]
    for control in ("arc_length", "load"):
        h = solve(f"periodic_{control}", cell(f"periodic_{control}", "static", 6, 3, length, width, probe=probes, steps={"control": control}, **arc)).history
        at = h["along_x"][-1] / length
        green = at + 0.5 * at**2
        report.near(at, 20 * strain * h["load_factor"][-1], 1e-9, f"{control}: the difference grows with the load factor")
        report.percent(h["along_force_x"][-1] / (YOUNG * THICKNESS * green * (1 + at) * width), 1e-6, f"{control}: force at {100 * at:.4g} %")
        report.near(h["end_x"][-1], h["along_force_x"][-1], 1e-6, "reaction on `to`")
        report.near(h["start_x"][-1], -h["along_force_x"][-1], 1e-6, "reaction on `from`")
        report.below(max(abs(h["low_x"][-1]), abs(h["high_x"][-1]), abs(h["low_y"][-1])), 1e-6, "none on the others")
    sheared = {"along": {"difference": [0, strain * length, 0]}}
    h = solve("periodic_sheared", cell("periodic_sheared", "linear", 6, 3, length, width, **sheared)).history
    report.percent(h["along_force_y"][-1] / (stiffness * (1 - POISSON) / 2 * strain * width), 1e-9, "shear")
    # Pulled along the edges that repeat: a corner is held by a support, whose force is none across the edges.
    along = cell("periodic_along", "linear", 8, 4, 1.0, 0.5, across={"difference": [0, "free", 0]}, load=[{"type": "line", "group": "plate end", "vector": [10.0, 0, 0]}])
    along["periodic"] = along["periodic"][1:]
    along["support"] += [{"type": "displacement", "group": "plate start", "components": ["x", "z"]}, {"type": "displacement", "group": "plate end", "components": ["z"]}]
    h = solve("periodic_along", along, 2).history
    report.below(abs(h["across_force_x"][-1]) / 5.0, 1e-6, "nothing crosses the edges of a strip that is pulled along them")


@test
def periodic_modes(report):
    """Modes of an infinite plate by one cell: omega = k^2 sqrt(D/(rho h)), each as often as waves have its length."""
    length, width, n, m = 1.0, 0.8, 30, 24
    thin = PLATE | {"thickness": 0.001}
    waves = sorted((2 * math.pi)**2 * ((i / length)**2 + (j / width)**2) for i in range(-3, 4) for j in range(-3, 4) if i or j)
    speed = math.sqrt(YOUNG * 0.001**3 / (12 * (1 - POISSON**2)) / (DENSITY * 0.001))
    exact = [k * speed / (2 * math.pi) for k in waves[:12]]
    case = cell("periodic_modes", "modal", n, m, length, width, material=thin, eigen={"modes": 15})
    del case["support"]
    for ranks in (1, 2):
        found = solve("periodic_modes", case, ranks).summary["eigenvalues"]
        report.below(max(map(abs, found[:3])) / exact[0], 1e-4, f"{ranks} ranks: three translations")
        for k, (f, e) in enumerate(zip(found[3:], exact)):
            report.percent(f / e, 0.005, f"mode {k + 4}: {f:.5g} Hz")
    # A tension that a difference gives, as a string: omega^2 = D k^4 + N k^2
    strain = 1e-4
    tight = cell("periodic_tight", "modal", n, m, length, width, {"difference": [strain * length, 0, 0]}, {"difference": [0, "free", 0]},
                 material=thin, eigen={"modes": 7, "load_factor": 1.0})
    del tight["support"]
    found = solve("periodic_tight", tight).summary["eigenvalues"]
    one = [math.sqrt((speed * k2)**2 + YOUNG * strain * (kx / length * 2 * math.pi)**2 / DENSITY) / (2 * math.pi)
           for kx, k2 in [(i, (2 * math.pi)**2 * ((i / length)**2 + (j / width)**2)) for i in range(-3, 4) for j in range(-3, 4)]]
    for f, e in zip(sorted(map(abs, found))[3:], sorted(one)[1:]):
        report.percent(f / e, 0.005, f"under tension: {f:.5g} Hz")


@test
def periodic_buckling(report):
    """An endless plate on two simple supports, compressed along them: N = 4 pi^2 D/b^2, by a force or by a shortening, on one, two and three ranks."""
    length, width = 1.0, 2.0  # two half waves
    thin = PLATE | {"thickness": 0.01}
    critical = 4 * math.pi**2 * YOUNG * 0.01**3 / (12 * (1 - POISSON**2)) / length**2
    held = [{"type": "displacement", "group": "plate start", "components": ["x", "z"]}, {"type": "displacement", "group": "plate end", "components": ["z"]},
            {"type": "hinged", "group": "corner"}]
    short = critical / (YOUNG * 0.01) * width
    for name, pair, unit in (("force", {"difference": [0, "free", 0], "force": [0, -1, 0]}, critical * length), ("shortening", {"difference": [0, -short, 0]}, 1.0)):
        for n, ranks, off in ((16, 1, 0.02), (32, 2, 0.005), (32, 3, 0.005)):
            case = cell("periodic_buckling", "buckling", n, 2 * n, length, width, across=pair, material=thin) | {"support": held, "eigen": {"modes": 2}}
            case["periodic"] = case["periodic"][1:]
            found = solve("periodic_buckling", case, ranks).summary["eigenvalues"]
            report.percent(found[0] / unit, off, f"by a {name}, {n} cells, {ranks} ranks")
            report.below(found[1] / found[0] - 1, 1e-3, "the wave may stand anywhere: twice the same")


@test
def periodic_film(report):
    """A film on an elastic foundation by two of its waves, k^4 = K/D: modes and buckling N = 2 sqrt(K D), then the height of its waves,
    A^2 k^2/4 = shortening beyond the critical one (3 % more than found at a shortening of 2 %, on any mesh), from an imperfection by a
    mode or by an expression."""
    h, foundation, width = 0.01, 2.0e4, 0.05
    bending = YOUNG * h**3 / (12 * (1 - POISSON**2))
    k = (foundation / bending)**0.25
    length = 2 * 2 * math.pi / k
    critical = 2 * math.sqrt(foundation * bending) * (1 - POISSON**2) / (YOUNG * h)  # strain
    ground = [{"type": "area", "stiffness": foundation, "direction": [0, 0, 1]}]
    hold = [{"type": "displacement", "group": "corner", "components": ["x", "y"]}]

    def film(name, analysis, strain, n=48, **more):
        shorter = {"difference": [-strain * length, 0, 0]}
        return cell(name, analysis, n, 4, length, width, along=shorter, material=PLATE | {"thickness": h}) | {"spring": ground, "support": hold} | more

    for ranks in (1, 3):
        found = solve("periodic_film", film("periodic_film", "modal", 0.0, eigen={"modes": 5}), ranks).summary["eigenvalues"]
        waves = sorted((2 * math.pi * i / length)**4 for i in range(-2, 3))  # the cell is too narrow for others
        for f, k4 in zip(found, waves):
            report.percent(f / (math.sqrt((foundation + bending * k4) / (DENSITY * h)) / (2 * math.pi)), 0.003, f"{ranks} ranks: {f:.5g} Hz")
    buckled = solve("periodic_film_buckling", film("periodic_film", "buckling", critical, eigen={"modes": 2}))
    report.percent(buckled.summary["eigenvalues"][0], 0.01, "it buckles")
    for ranks, imperfection in ((1, {"type": "modes", "results": str(buckled.folder), "modes": [1], "amplitudes": [0.03 * h]}),
                                (2, {"type": "expression", "height": f"{0.03 * h}*cos({k}*x)"})):
        end = solve("periodic_film_waves", film("periodic_film", "static", 3 * critical, imperfection=[imperfection], steps={"initial_step": 0.05, "max_step": 0.05}), ranks)
        z = end.displacement()[:, 2]
        report.percent((z.max() - z.min()) / 2 * k / 2 / math.sqrt(2 * critical), 0.04, f"{imperfection['type']}: height of the waves, {ranks} ranks")
        report.below(abs(z.max() + z.min()) / z.max(), 0.05, "as high as deep")
    # A corrugated cell, cut on its slope: heights go along the mean normal of both sides.
    n, m = 10, 4
    points = np.array([(x, y, 0.1 * math.sin(2 * math.pi * x + 1)) for y in np.linspace(0, 0.4, m + 1) for x in np.linspace(0, 1, n + 1)])
    at = lambda i, j: j * (n + 1) + i  # noqa: E731
    cells = np.array([t for j in range(m) for i in range(n) for t in ((at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1)))])
    ends = [(name, 1, [(at(i, j), at(i, j + 1)) for j in range(m)]) for name, i in (("from", 0), ("to", n))]
    waved = {"analysis": "modal", "mesh": {"file": str(write_msh(OUT / "corrugated.msh", points, [*ends, ("sheet", 2, cells)]))}, "material": [PLATE | {"thickness": 0.01}],
             "periodic": [{"from": "from", "to": "to"}], "imperfection": [{"type": "expression", "height": "0.02"}], "eigen": {"modes": 8}}
    moved = solve("periodic_corrugated", waved).results[-1].mesh.positions - points
    report.below(np.abs(np.linalg.norm(moved, axis=1) / 0.02 - 1).max(), 0.05, "a corrugated cell moves by the height everywhere")
    report.below(np.abs(moved[[at(0, j) for j in range(m + 1)]] - moved[[at(n, j) for j in range(m + 1)]]).max(), 1e-12, "alike on both curves")


@test
def periodic_vibration(report):
    """The frequency response of a wide strip by one cell: both methods agree, also where the difference is free, and the slowest is the static one."""
    start, end = "plate start", "plate end"
    bent = {"load": [{"type": "line", "group": end, "vector": [0, 0, 1.0]}], "support": [{"type": "clamped", "group": start}]}
    pulled = {"support": [{"type": "displacement", "group": start, "components": ["x", "z"]}, {"type": "displacement", "group": end, "components": ["z"]},
                          {"type": "hinged", "group": "corner"}]}
    for name, pair, more, tip in (("bent", {}, bent, "z"), ("pulled", {"difference": [0, "free", 0], "force": [0, 1, 0]}, pulled, "x")):
        still = cell("periodic_still", "linear", 20, 4, 10.0, 2.0, across=pair) | more
        still |= {"periodic": still["periodic"][1:], "probe": [{"name": "tip", "type": "displacement", "group": end, "components": [tip]}]}
        first = solve("periodic_still", still).history[f"tip_{tip}"][-1]
        found = {}
        for method in ("superposition", "direct"):
            shaken = still | {"analysis": "harmonic", "damping": {"mass": 0.1}, "eigen": {"mass": "consistent"},
                              "harmonic": {"method": method, "frequencies": [1e-5, 0.01, 0.05, 0.2]}}
            rows = [line.split(",") for line in (solve("periodic_shaken", shaken, 2).folder / "response.csv").read_text().splitlines()]
            found[method] = np.array([float(row[rows[0].index(f"tip_{tip}_amplitude")]) for row in rows[1:]])
        report.below(np.abs(found["superposition"] / found["direct"] - 1).max(), 1e-6, f"{name}: superposition against direct")
        report.percent(found["direct"][0] / abs(first), 1e-4, f"{name}: slowly as at rest")


@test
def periodic_motion(report):
    """A period of a wide cantilever swings as a beam of E/(1 - nu^2); energy, ranks, and a restart that ends at the same bits."""
    def case(end, periodic, material=PLATE, mass="consistent", **time):
        return strip("dynamic", 20, 10.0, 1.0, periodic, pattern=1, material=material, support=[{"type": "clamped", "group": "clamp"}],
                     load=[{"type": "gravity", "vector": [0, 0, -0.5], "constant": True}],
                     probe=[{"name": "tip", "type": "displacement", "group": "tip"}],
                     time={"end": end, "step": 1 / 64, "max_step": 1 / 64, "velocity_tolerance": 1e-6, "mass": mass} | time)

    wide = [SIDES]
    whole = solve("periodic_swing", case(1.0, wide))
    h = whole.history
    as_beam = PLATE | {"poisson": 0.0, "young": YOUNG / (1 - POISSON**2)}
    beam = solve("periodic_swing_beam", case(1.0, [], as_beam)).history
    report.percent(h["tip_z"][-1] / beam["tip_z"][-1], 0.003, f"tip at the end: {h['tip_z'][-1]:.4g} m")
    for name, time in (("lumped", {}), ("explicit", {"method": "central_difference", "step": 1e-3, "max_step": 1e-3})):
        ends = [solve(f"periodic_swing_{name}", case(0.25, edges, material, "lumped", **time)).history["tip_z"][-1]
                for edges, material in ((wide, PLATE), ([], as_beam))]
        report.percent(ends[0] / ends[1], 0.003, f"{name}: tip after 0.25 s: {ends[0]:.4g} m")
    report.below(h["energy_unaccounted"][-1] / h["work_of_loads"][-1], 1e-6, "not accounted for")
    for ranks in (2, 3):
        other = solve(f"periodic_swing_{ranks}", case(1.0, wide), ranks)
        report.below(np.abs(other.displacement() - whole.displacement()).max(), 1e-7, f"{ranks} ranks")
    first = solve("periodic_swing_half", case(0.5, wide))
    again = solve("periodic_swing_again", case(1.0, wide), options=["--restart", str(first.folder / "checkpoint.h5")])
    report.below(np.abs(again.displacement() - whole.displacement()).max(), 1e-9, "a restart ends at the same place")
    pulled = cell("periodic_pull", "dynamic", 6, 3, 2.0, 1.0, {"difference": ["free", 0, 0], "force": [100, 0, 0]}, {"difference": [0, "free", 0]},
                  time={"end": 0.2, "step": 1e-3, "max_step": 1e-3, "velocity_tolerance": 1e-6, "mass": "consistent"})
    for ranks in (1, 2):
        h = solve("periodic_pull", pulled, ranks).history
        report.below(h["energy_unaccounted"][-1] / h["work_of_loads"].max(), 1e-6, f"{ranks} ranks: a difference that swings: not accounted for")
        report.check(h["along_x"].max() > 1.5 * 100 * 2.0 / (YOUNG * THICKNESS), "it swings beyond the equilibrium")
        report.near(h["work_of_loads"][-1], 100 * h["along_x"][-1], 1e-9, "work of the force")


@test
def periodic_stages(report):
    """A cell that one stage stretches is sheared, swings and vibrates in later ones as it does alone; forces stay, what is new counts from there."""
    length, width, strain, shear = 1.0, 0.8, 0.05, 0.03
    along, across = {"from": "plate start", "to": "plate end", "name": "along"}, {"from": "plate low", "to": "plate high", "name": "across"}
    free = across | {"difference": [0, "free", 0]}
    second = ["shear", "swing", "ring"]
    pairs = [free, along | {"difference": [strain, 0, 0], "stages": ["stretch"]}, along | {"difference": [0, f"{shear}*t", 0], "stages": second}]
    stages = [{"name": "stretch", "analysis": "static"}, {"name": "shear", "analysis": "static", "steps": {"initial_step": 0.5}},
              {"name": "swing", "analysis": "dynamic", "time": {"step": 0.01, "end": 0.03, "mass": "consistent"}}, {"name": "ring", "analysis": "modal", "eigen": {"modes": 6}}]
    case = cell("periodic_stages", None, 8, 6, length, width, probe=[{"name": "low", "type": "reaction", "group": "plate low"}])
    del case["analysis"]
    case |= {"periodic": pairs, "stage": stages, "output": {"every": 1}}
    alone = {"periodic": [free, along | {"difference": [strain, shear, 0]}]}
    still = solve("periodic_stages_still", case | alone | {"stage": [stages[0], stages[3]]})
    want, column = still.stage("stretch").history, ("along_x", "along_y", "along_force_x", "along_force_y", "across_y")
    for ranks in (1, 3):
        run_of = solve("periodic_stages", case, ranks)
        for stage in ("shear", "swing"):
            h = run_of.stage(stage).history
            for name in column:
                report.near(h[name][-1], want[name][-1], 1e-7 * abs(want["along_force_x" if "force" in name else "along_x"][-1]), f"{ranks} ranks: {name} after {stage}")
        report.near(run_of.stage("shear").history["along_x"][0], strain, 1e-12, "it begins where the stage before has stretched it to")
        report.below(run_of.stage("swing").history["kinetic_energy"].max(), 1e-10, "and is at rest there [J]")
        for f, e in zip(run_of.stage("ring").summary["eigenvalues"][3:], still.stage("ring").summary["eigenvalues"][3:]):
            report.percent(f / e, 1e-6, f"frequency {f:.5g} Hz")
    again = run(OUT / "periodic_stages.toml", run_of.folder, 1, ["--from", "shear"])
    report.near(again.stage("shear").history["along_force_y"][-1], want["along_force_y"][-1], 1e-7 * abs(want["along_force_x"][-1]), "--from goes on from there")
    after = [{"name": "before", "analysis": "modal", "eigen": {"modes": 4}}, {"name": "pull", "analysis": "static"}]
    h = solve("periodic_stages_modes", case | {"periodic": [free, along | {"difference": [strain, 0, 0]}], "stage": after}).stage("pull").history
    report.near(h["along_x"][-1], strain, 1e-12, "what a stage of modes has not moved, the next one moves")
    # A force stays while a later one grows, and what is held then is held where it has come to.
    force, more = 3000.0, 1000.0
    pulled = [free | {"stages": ["pull", "hold"]}, along | {"difference": ["free", 0, 0], "force": [force, 0, 0], "stages": ["pull"]},
              along | {"stages": ["hold", "push"]}, across | {"difference": [0, "free", 0], "force": [0, more, 0], "stages": ["push"]}]
    run_of = solve("periodic_stages_forces", case | {"periodic": pulled, "stage": [{"name": n, "analysis": "static"} for n in ("pull", "hold", "push")]}, 2)
    pull, hold, push = (run_of.stage(name).history for name in ("pull", "hold", "push"))
    report.percent(hold["along_force_x"][-1] / force, 1e-6, "what the force has stretched is held with it")
    report.near(push["along_x"][-1], pull["along_x"][-1], 1e-9, "where it is")
    report.check(push["across_y"][-1] > hold["across_y"][-1] and push["along_force_x"][-1] > 1.05 * force, "while the other direction is pulled")
    kept = [free | {"stages": ["pull"]}, along | {"difference": ["free", 0, 0], "force": [force, 0, 0]}, across | {"difference": [0, "free", 0], "force": [0, more, 0], "stages": ["push"]}]
    both = [across | {"difference": [0, "free", 0], "force": [0, more, 0]}, along | {"difference": ["free", 0, 0], "force": [force, 0, 0]}]
    end = solve("periodic_stages_kept", case | {"periodic": kept, "stage": [{"name": n, "analysis": "static"} for n in ("pull", "push")]}).stage("push").history
    once = solve("periodic_stages_once", case | {"periodic": both, "stage": [{"name": "all", "analysis": "static"}]}).stage("all").history
    report.percent(end["along_x"][-1] / once["along_x"][-1], 1e-6, "a force that has grown stays")
    report.near(end["along_x"][0], pull["along_x"][-1], 1e-9, "from the start of the stage")


@test
def periodic_mistakes(report):
    """What periodic edges cannot be is refused with the file, the key and a remedy."""
    pull = {"from": "clamp", "to": "tip"}
    base = strip("static", 8, 4.0, 2.0, [SIDES], pattern=0, support=[{"type": "hinged", "group": "clamp"}])
    no = {"support": []}
    free = no | {"periodic": [SIDES | {"difference": ["free", 0, 0]}]}
    spring = [{"type": "area", "stiffness": 1.0}]
    obstacle = [{"type": "plane", "name": "floor", "point": [0, 0, -1], "normal": [0, 0, 1]}]
    staged = {"analysis": None, "stage": [{"name": name, "analysis": "static"} for name in "ab"]}

    def later(analysis, difference):
        return no | {"analysis": None, "stage": [{"name": "a", "analysis": "static"}, {"name": "b", "analysis": analysis, "time": {"end": 1.0, "step": 0.1}}],
                     "periodic": [SIDES | {"stages": ["a"]}, SIDES | {"stages": ["b"], "difference": difference}]}
    cases = {
        "unknown": ({"periodic": [SIDES | {"to": "nowhere"}]}, ("periodic", "'nowhere'", "clamp")),
        "surface": ({"periodic": [SIDES | {"to": "plate"}]}, ("periodic", "'plate'")),
        "itself": ({"periodic": [SIDES | {"to": "side_low"}]}, ("periodic.to", "is `from` too")),
        "twice": ({"periodic": [SIDES, SIDES | {"name": "b"}]}, ("periodic.from", "belongs to another pair")),
        "unequal": ({"periodic": [{"from": "side_low", "to": "tip"}]}, ("has 9 vertices and 'tip' has 5", "Periodic Curve")),
        "shared": ({"periodic": [{"from": "sides", "to": "sides2"}]}, ("periodic", "sides2", "sides")),
        "number": ({"periodic": [SIDES | {"difference": [0, 0]}]}, ("periodic.difference", "2 entries")),
        "text": ({"periodic": [SIDES | {"difference": ["0.1*q", 0, 0]}]}, ("periodic.difference", "q")),
        "force": ({"periodic": [SIDES | {"force": [1, 0, 0]}]}, ("periodic.force", "x component", "free")),
        "linear": ({"analysis": "linear", "periodic": [SIDES | {"difference": ["0.1*t", 0, 0]}]}, ("periodic.difference", "number")),
        "moved": ({"analysis": "dynamic", "periodic": [SIDES | {"difference": [0.1, 0, 0]}]}, ("periodic.difference", "in time")),
        "held": ({"periodic": [SIDES | {"difference": [0.1, 0, 0]}]}, ("[[periodic]] from = 'side_low'", "`difference`", "correct one")),
        "free": ({"periodic": [SIDES | {"difference": ["free", 0, 0]}]}, ("prescribe that component",)),
        "clamped": ({"periodic": [SIDES, pull], "support": [{"type": "clamped", "group": "clamp"}]}, ("holds the slope", "displacement")),
        "turned": ({"support": [{"type": "hinged", "group": "clamp", "rotation_axis": [0, 0, 1], "rotation_angle": "90*t"}]}, ("moves it otherwise", "leave one")),
        "rigid": ({"rigid": [{"group": "tip"}]}, ("[[periodic]] and [[rigid]]", "remove")),
        "spring": ({"spring": spring, "periodic": [SIDES | {"difference": ["free", 0, 0]}]}, ("[[periodic]] and [[spring]] direction", "'across'", "[0, 0, 1]")),
        "pair": ({"spring": [{"type": "pair", "group": "tip", "to": "clamp", "stiffness": 1.0}]}, ("[[periodic]] and [[spring]] type", "remove")),
        "random": ({"imperfection": [{"type": "random", "amplitude": 0.01, "length": 1.0}]}, ("[[periodic]] and [[imperfection]]", "expression")),
        "uneven": ({"imperfection": [{"type": "expression", "height": "0.01*x*y"}]}, ("[[imperfection]]", "repeat", "alike")),
        "hinge": ({"hinge": [{"group": "tip", "stiffness": 1.0}]}, ("[[periodic]] and [[hinge]]", "remove")),
        "mass": ({"mass": [{"group": "tip", "mass": 1.0}]}, ("[[periodic]] and [[mass]]", "remove")),
        "contact": ({"contact": {"distance": 0.01}, "obstacle": obstacle}, ("[[periodic]] and [contact]", "remove")),
        "remesh": ({"remesh": {}}, ("[[periodic]] and [remesh]", "remove")),
        "form": ({"form": {}, "material": [PLATE | {"prestress": [10.0, 10.0]}]}, ("[form]", "remove")),
        "gas": ({"load": [{"type": "gas", "group": "plate", "magnitude": 10.0}]}, ("[[periodic]] and [[load]]", "follower_pressure")),
        "lost pair": (staged | {"periodic": [SIDES | {"stages": ["a"]}]}, ("stage 'b'", "[[periodic]] from 'side_low' to 'side_high'", "every stage")),
        "late pair": (staged | {"periodic": [SIDES | {"stages": ["b"]}]}, ("stage 'b'", "[[periodic]] from 'side_low'", "every stage")),
        "moved later": (later("dynamic", [0.1, 0, 0]), ("stage 'b'", "in time", "static stage before")),
        "expression later": (later("modal", ["0.1*t", 0, 0]), ("stage 'b'", "control = \"load\"", "give a number")),
        "lumped": ({"analysis": "modal", "eigen": {"mass": "lumped"}} | free, ("eigen.mass", "consistent")),
        "motion": ({"analysis": "dynamic", "time": {"end": 1.0, "step": 0.1}} | free, ("time.mass", "consistent")),
        "name": ({"periodic": [SIDES | {"name": "a,b"}]}, ("periodic.name", "commas")),
        "names": ({"probe": [{"name": "across", "type": "displacement", "group": "tip"}]}, ("probe.name", "rename")),
        "four": ({"periodic": [{"from": f"a{k}", "to": f"b{k}"} for k in range(4)]} | no, ("at most 3",)),
    }
    for name, (changes, texts) in cases.items():
        case = {k: v for k, v in (base | changes).items() if v is not None}
        file = write_case(case, OUT / f"periodic_mistake_{name}.toml")
        done = run(file, fresh(f"periodic_mistake_{name}"))
        report.check(done.code == 2, f"{name}: exit code {done.code}")
        for text in texts:
            report.check(text in done.text, f"{name}: '{text}' is in: {done.text.strip()[-300:] if text not in done.text else '...'}")
