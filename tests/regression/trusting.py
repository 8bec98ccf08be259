"""Exit code 0 means right: choices of solvers, turning clamps, follower loads, driven energies, starts and restarts."""

import math
import signal

import numpy as np
from common import fresh, started, strip, wait_for
from gathering import ruffle
from harness import OUT, Failure, solve, test
from solver import ROOT, invoke, run, variant, write_case

from voile import Results


def grid_mesh(name, place, cells, groups, closed=False):
    """A Gmsh file of `cells` squares, each two triangles, whose vertex (i, j) lies at place(i/nx, j/ny). `groups`: for each
    name of a curve its side: left, right, bottom or top. `closed`: the right side is the left one."""
    (nx, ny), number = cells, 0
    columns = nx if closed else nx + 1
    node = lambda i, j: j * columns + (i % nx if closed else i) + 1  # noqa: E731
    nodes = [place(i / nx, j / ny) for j in range(ny + 1) for i in range(columns)]
    sides = {"left": [(node(0, j), node(0, j + 1)) for j in range(ny)], "right": [(node(nx, j), node(nx, j + 1)) for j in range(ny)],
             "bottom": [(node(i, 0), node(i + 1, 0)) for i in range(nx)], "top": [(node(i, ny), node(i + 1, ny)) for i in range(nx)]}
    elements = []
    for j in range(ny):
        for i in range(nx):
            a, b, c, d = node(i, j), node(i + 1, j), node(i, j + 1), node(i + 1, j + 1)
            elements += [f"2 2 1 1 {a} {b} {d}", f"2 2 1 1 {a} {d} {c}"]
    names = ['2 1 "sheet"']
    for number, (group, side) in enumerate(groups.items(), 2):
        names.append(f'1 {number} "{group}"')
        elements += [f"1 2 {number} {number} {a} {b}" for a, b in sides[side]]
    file = OUT / name
    OUT.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(
        ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames", "$Nodes",
         str(len(nodes)), *(f"{k} {x:.17g} {y:.17g} {z:.17g}" for k, (x, y, z) in enumerate(nodes, 1)), "$EndNodes", "$Elements",
         str(len(elements)), *(f"{k} {e}" for k, e in enumerate(elements, 1)), "$EndElements", ""]))
    return str(file)


def long_strip(start=None):
    mesh = grid_mesh("trusting_strip.msh", lambda s, t: (12 * s, t, 0.0), (48, 4), {"left": "left", "right": "right"})
    return {
        "mesh": {"file": mesh} | ({"start": start} if start else {}),
        "material": [{"type": "isotropic", "young": 1.2e6, "poisson": 0.3, "thickness": 0.1}],
        "support": [{"type": "clamped", "group": "left"}],
        "probe": [{"name": "E", "type": "energy"}, {"name": "R", "type": "reaction", "group": "right"},
                  {"name": "tip", "type": "displacement", "group": "right"}],
    }


def turned(angle, axis, centre):
    return {"rotation_axis": axis, "rotation_centre": centre, "rotation_angle": f"{angle}*t"}


def pushed(analysis):
    """A strip pushed up at its end, quasi-statically or fast; with `contact` from above onto a floor."""
    case = {
        "mesh": {"file": grid_mesh("trusting_push.msh", lambda s, t: (s, 0.2 * t, 0.0), (10, 2), {"left": "left", "right": "right"})},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 0.01, "density": 1000}],
        "support": [{"type": "clamped", "group": "left"}],
        "load": [{"type": "line", "group": "right", "vector": [0, 0, 20.0 if analysis != "static" else 0.05]}],
        "probe": [{"name": "tip", "type": "displacement", "group": "right", "components": ["z"]}],
    }
    if analysis != "static":
        case |= {"analysis": "dynamic", "time": {"end": 0.2, "step": 0.02}}
    if analysis == "contact":
        case["load"][0]["vector"] = [0, 0, -2.0]
        case["contact"] = {"distance": 5e-3}
        case["obstacle"] = [{"name": "floor", "type": "plane", "point": [0, 0, -0.05], "normal": [0, 0, 1]}]
        case["time"] = {"end": 0.2, "step": 0.01, "velocity_tolerance": 1e-4}
    return case


# Those that this PETSc has and Voile takes; what is measured against the default is the tip at the end.
TAKEN = ["-snes_linesearch_type bt", "-snes_linesearch_type basic", "-snes_linesearch_type nleqerr", "-snes_type newtontr",
         "-snes_type qn", "-snes_type ksponly", "-ksp_type preonly -pc_type jacobi", "-ksp_type cg -pc_type jacobi -ksp_rtol 0.5",
         "-snes_lag_preconditioner 4", "-snes_linesearch_type basic -snes_linesearch_damping 1.9"]
REFUSED = ["-snes_type ngmres", "-snes_type ngs", "-snes_type aspin", "-snes_type fas", "-snes_linesearch_type shell", "-snes_convergence_test skip",
           "-snes_mf", "-snes_lag_jacobian -1"]


@test
def solver_options(report):
    """Solvers of PETSc that a user chooses end at the right place, or with code 3, or are refused: static, in motion, in contact."""
    for kind in ("static", "motion", "contact"):
        case = pushed(kind)
        right = solve(f"options_{kind}", case).history["tip_z"][-1]
        # Solvers that fail at long steps take shorter ones, and end where those do.
        fine = right if kind == "static" else solve(
            "options_fine", variant(case, {"time.step": case["time"]["step"] / 4})).history["tip_z"][-1]
        tolerance = 1e-4 + 1.5 * abs(fine - right)
        report.check(abs(right) > 0.01, f"{kind}: the end goes to {right:.4g} m")
        for options in TAKEN + (["-snes_linesearch_type l2", "-snes_linesearch_type cp"] if kind != "contact" else []):
            done = run(write_case(case, OUT / f"options_{kind}.toml"), fresh("options_other"), 1, options.split(), 120)
            end = done.history["tip_z"][-1] if done.code == 0 else math.nan
            good = done.code == 3 or (done.code == 0 and abs(end - right) <= tolerance) or (done.code == 2 and "option -snes" in done.text)
            report.check(good, f"{kind}, {options}: code {done.code}, {end:.6g} m" + ("" if good else done.text[-300:]))
    for options in REFUSED:
        done = run(OUT / "options_motion.toml", fresh("options_other"), 1, options.split(), 120)
        report.check(done.code == 2 and "option" in done.text, f"{options}: code {done.code}")
    for options in ("-snes_linesearch_type l2", "-snes_type newtontr"):
        done = run(OUT / "options_contact.toml", fresh("options_other"), 1, options.split(), 120)
        report.check(done.code == 2 and "contact" in done.text, f"in contact {options}: code {done.code}")


@test
def loose_options(report):
    """Tolerances that allow anything end at the right place or are refused; so are numbers that PETSc cannot use, and empty names."""
    case = pushed("static")
    right = solve("loose_static", case).history["tip_z"][-1]
    loose = solve("loose_static", case, 1, ["-snes_atol", "1e9"]).history["tip_z"][-1]
    report.near(loose / right, 1.0, 1e-3, "-snes_atol 1e9: the end goes as far")
    motion = write_case(pushed("motion"), OUT / "loose_motion.toml")
    for options, words in (("-snes_rtol 1", "no equilibrium"), ("-ts_adapt_safety 2", "Safety factor"), ("-ts_adapt_dt_min 5", "time step"),
                           ("-snes_lag_jacobian 0", "Lag"), ("-options_file nofile", "cannot be read")):
        done = run(motion, fresh("loose_other"), 1, options.split(), 120)
        report.check(done.code == 2 and words in done.text, f"{options}: code {done.code}, {done.text.strip()[-160:]}")
    done = run(motion, fresh("loose_other"), 1, ["-ts_max_steps", "3"], 120)
    report.check(done.code == 3 and "-ts_max_steps ends the motion at t = 0.06 s" in done.text, f"a motion that ends early: code {done.code}")
    for command in ("run", "check", "info"):
        code, said = invoke([command, ""])
        report.check(code == 2 and "empty" in said, f"{command} of an empty name: code {code}")


@test
def mode_options(report):
    """Options of SLEPc that change the problem, or leave modes wrong, are refused; without a mode nothing has converged."""
    case = write_case(strip("modal", nx=20, ny=3, load=[], eigen={"modes": 3}), OUT / "modes.toml")
    for options, word in (("-st_type shift", "sinvert"), ("-eps_hermitian", "symmetric"), ("-eps_tol 0.1", "-eps_tol"), ("-st_ksp_type gmres -st_ksp_rtol 0.1", "-st_ksp_rtol"),
                          ("-st_ksp_type gmres -st_pc_type none -st_ksp_max_it 5", "has not been solved")):
        done = run(case, fresh("modes_other"), 1, options.split(), 120)
        report.check(done.code == 2 and word in done.text, f"{options}: code {done.code}, {done.text.strip()[-160:]}")
    done = run(case, fresh("modes_other"), 1, ["-eps_max_it", "1", "-eps_ncv", "5", "-eps_type", "power"], 120)
    report.check(done.code == 3 and "0 of 3 modes found" in done.text, f"no mode: code {done.code}")
    held = write_case(strip("modal", nx=4, ny=1, load=[], support=[{"type": "hinged", "group": "plate"}]), OUT / "modes_held.toml")
    done = run(held, fresh("modes_other"), 1, [], 120)
    report.check(done.code == 2 and "no vertex is free" in done.text, f"nothing can vibrate: code {done.code}")
    lowest = run(case, fresh("modes_other"), 1, [], 120).summary["eigenvalues"]
    done = run(case, fresh("modes_other"), 1, ["-eps_target", f"{(2 * math.pi * lowest[2])**2:.6g}", "-eps_nev", "1"], 120)
    report.check(done.code == 0 and "2 mode(s) lie below" in done.text, f"a target: code {done.code}")
    report.near(done.summary["eigenvalues"][0] / lowest[2], 1.0, 1e-6, "the third mode, by a target")


@test
def damped_restart(report):
    """A damped motion in wind that goes on from a checkpoint has the reactions and works of the unbroken one from its first row."""
    case = pushed("motion")
    case["material"][0] |= {"membrane_damping": 1e-3, "bending_damping": 2e-3}
    case["support"][0]["motion"] = ["0", "0", "0.05*(1-cos(20*t))"]
    case |= {"air": {"density": 1.2, "normal_drag": 1.2, "wind": ["0", "0", "20*sin(30*t)"]}, "time": {"end": 0.4, "step": 0.02}}
    case["probe"].append({"name": "R", "type": "reaction", "group": "left"})
    explicit = {"time": {"end": 0.4, "step": 2e-4, "method": "central_difference", "mass": "lumped"}}
    for ranks, more in ((1, {}), (1, explicit), (2, {"rigid": [{"name": "end", "group": "right"}]})):
        if "rigid" in more:
            case["probe"] = case["probe"][:1]
            del case["air"]
        whole = solve("damped_whole", case | more, ranks).history
        half = solve("damped_half", variant(case | more, {"time.end": 0.2}), ranks)
        rest = solve("damped_rest", case | more, ranks, ["--restart", str(half.folder / "checkpoint.h5")]).history
        columns = [c for c in whole.names if c[:2] == "R_" or c.startswith(("work_of", "end_", "numerical"))]
        middle = int(np.argmin(np.abs(np.array(whole["time"]) - 0.2)))
        scale = {c: np.abs(np.array(whole[c])).max() + 1e-30 for c in columns}
        first = max(abs(rest[c][0] - whole[c][middle]) / scale[c] for c in columns)
        last = max(abs(rest[c][-1] - whole[c][-1]) / scale[c] for c in columns)
        if not more:  # accelerations of supports at an end are of differences to one side
            report.percent(half.history["R_z"][-1] / whole["R_z"][middle], 0.03, "reaction at the end of a run over that of a run that goes on")
        report.below(first, 1e-8, f"{ranks} rank(s): difference in the first row of {len(columns)} columns")
        second = max(abs(rest[c][1] - whole[c][middle + 1]) / scale[c] for c in columns)
        report.below(max(second, last), 1e-8, "in the second and in the last one")


@test
def stocking(report):
    """A tube that is tight on a leg with friction is an equilibrium without any load: the forces of contact are its measure."""
    tube = lambda name, r: grid_mesh(name, lambda s, t: (r * math.cos(2 * math.pi * s), r * math.sin(2 * math.pi * s), 0.05 * t),  # noqa: E731
                                     (72, 6), {"low": "bottom"}, closed=True)
    young, thickness, rest, leg, height = 2e5, 2e-4, 0.09, 0.0992, 0.05
    case = {"analysis": "drape", "mesh": {"file": tube("stocking_rest.msh", rest), "start": tube("stocking_start.msh", 0.1)},
            "material": [{"type": "isotropic", "young": young, "poisson": 0.0, "thickness": thickness, "density": 500}],
            "contact": {"distance": 1e-3, "self": False},
            "obstacle": [{"name": "leg", "type": "capsule", "radius": leg, "point": [0, 0, -0.1], "end": [0, 0, 0.15], "friction": 0.1}]}
    done = solve("stocking", case)
    end = done.results[-1]
    places, forces = end.positions, end["contact_force"]
    outwards = np.einsum("ij,ij->i", forces[:, :2], places[:, :2]) / np.linalg.norm(places[:, :2], axis=1)
    radius = np.linalg.norm(places[:, :2], axis=1).mean()
    stretch = radius / rest
    hoop = young * thickness * 0.5 * (stretch**2 - 1) * stretch  # first Piola-Kirchhoff, per height at rest
    report.percent(outwards.sum() / (2 * math.pi * hoop * height), 0.01, "sum of the pressure on the leg")
    report.below(done.summary["residual"], 1e-4, "residual of the forces")


@test
def linear_options(report):
    """A linear solver that leaves the forces unbalanced does not end a linear analysis as done."""
    case = variant(strip("linear"), {})
    right = solve("linear_right", case).history
    probe = "tip_z"
    for options in ("-ksp_type preonly -pc_type jacobi", "-ksp_type richardson -pc_type jacobi -ksp_max_it 3 -ksp_convergence_test skip"):
        done = run(write_case(case, OUT / "linear_other.toml"), fresh("linear_other"), 1, options.split(), 120)
        report.check(done.code in (2, 3), f"{options}: code {done.code}")
    done = run(OUT / "linear_other.toml", fresh("linear_other"), 1, "-ksp_type cg -pc_type icc".split(), 120)
    good = done.code == 3 or abs(done.history[probe][-1] / right[probe][-1] - 1) < 1e-4
    report.check(good, f"conjugate gradients: code {done.code}")


@test
def clamps_turn_far(report):
    """Clamps that turn by 90 and 180 degrees in default steps carry a free strip along, bend and twist one; a fold at a clamp unfolds."""
    strip_case = long_strip()
    free = variant(strip_case, {"support.0": strip_case["support"][0] | turned(90, [0, 1, 0], [0, 0, 0])})
    h = solve("turned_free", free).history
    report.near(h["tip_x"][-1], -12.0, 1e-6, "a free strip is carried along: x [m]")
    report.near(h["tip_z"][-1], -12.0, 1e-6, "and z [m]")
    report.below(h["E_membrane"][-1] + h["E_bending"][-1], 1e-6, "without energy [J]")
    fine = solve("turned_fine", variant(free | {"steps": {"initial_step": 0.05, "max_step": 0.05}}, {
        "support": [strip_case["support"][0], {"type": "clamped", "group": "right"} | turned(90, [0, 1, 0], [12, 0, 0])]})).history
    coarse = solve("turned_coarse", variant(free, {
        "support": [strip_case["support"][0], {"type": "clamped", "group": "right"} | turned(90, [0, 1, 0], [12, 0, 0])]})).history
    report.near(coarse["R_x"][-1] / fine["R_x"][-1], 1.0, 1e-6, "bent by 90 degrees, reaction in default steps over that in 20 steps")
    twisted = variant(strip_case, {
        "support": [strip_case["support"][0], {"type": "clamped", "group": "right"} | turned(180, [1, 0, 0], [12, 0.5, 0])]})
    fine = solve("twisted_fine", twisted | {"steps": {"initial_step": 0.05, "max_step": 0.05}}).history
    coarse = solve("twisted_coarse", twisted).history
    report.near(coarse["R_x"][-1] / fine["R_x"][-1], 1.0, 1e-6, f"twisted by 180 degrees ({fine['R_x'][-1]:.4g} N), the same")
    mirrored = grid_mesh("trusting_mirrored.msh", lambda s, t: (-12 * s, t, 0.0), (48, 4), {"left": "left", "right": "right"})
    folded = long_strip(mirrored) | {"analysis": "drape", "load": [{"type": "line", "group": "right", "vector": [0, 0, 1e-6]}]}
    h = solve("turned_folded", folded | {"element": {"type": "corrected"}}).history
    report.near(h["tip_x"][-1], 0.0, 1e-6, "folded back on its clamp it turns over, x [m]")


@test
def follower_pressure_is_judged(report):
    """A ring beyond its buckling pressure: instability is counted, reported in the exit code, found on the path, and left."""
    mesh = grid_mesh("trusting_ring.msh", lambda s, t: (math.cos(math.pi / 2 * s), math.sin(math.pi / 2 * s), 0.2 * t), (12, 2),
                     {"a": "left", "b": "right"})
    case = {
        "mesh": {"file": mesh},
        "material": [{"type": "isotropic", "young": 1.2e6, "poisson": 0.0, "thickness": 0.1}],
        "support": [{"type": "symmetry", "group": "a", "normal": [0, 1, 0]}, {"type": "symmetry", "group": "b", "normal": [1, 0, 0]},
                    {"type": "displacement", "group": "sheet", "components": ["z"]}],
        "load": [{"type": "follower_pressure", "magnitude": -300.0}],  # 3 E I/R^3
        "probe": [{"name": "a", "type": "displacement", "group": "a", "components": ["x"]}],
        "steps": {"initial_step": 0.25, "max_step": 0.25, "final_load_factor": 1.3},
    }
    done = run(write_case(case, OUT / "ring.toml"), fresh("ring"), 1, [], 120)
    report.check(done.code == 5 and "unstable" in done.text, f"load control ends unstable: code {done.code}")
    report.check(done.summary["unstable"] is True and done.summary["negative_pivots"] == 1, "summary.json says so")
    pivots = done.history["negative_pivots"]
    report.check(pivots[done.history["load_factor"] < 1.0].max() == 0 and pivots[-1] == 1, "one negative eigenvalue beyond 3 E I/R^3")
    done = run(write_case(variant(case, {"steps.final_load_factor": 0.9}), OUT / "ring.toml"), fresh("ring"), 2, [], 120)
    report.check(done.code == 0, f"below it is stable, on 2 ranks: code {done.code}")
    path = {"steps.control": "arc_length", "steps.at_critical_point": "stop"}
    stop = solve("ring_stop", variant(case, path))
    report.near(stop.summary["critical_points"][0]["load_factor"], 1.0, 0.01, "bifurcation on the path, over 3 E I/R^3")
    # Open edges leave the pressure without a potential: the sign of the determinant tells then.
    angle = math.pi / 3
    arch = grid_mesh("trusting_arch.msh", lambda s, t: (math.sin(angle * (2 * s - 1)), 0.05 * t, math.cos(angle * (2 * s - 1))), (64, 2), {"a": "left", "b": "right", "c": "bottom", "d": "top"})
    critical = ((math.pi / angle) ** 2 - 1) * 1e9 * 4e-3**3 / 12
    open_edges = {"mesh": {"file": arch}, "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.0, "thickness": 4e-3, "density": 1000}],
                  "support": [{"type": "hinged", "group": ["a", "b"]}], "load": [{"type": "follower_pressure", "magnitude": -critical}],
                  "probe": [{"name": "arch", "type": "displacement", "group": "sheet", "components": ["x"]}], "steps": {"initial_step": 0.25, "final_load_factor": 1.5}}
    done = run(write_case(open_edges, OUT / "arch_open.toml"), fresh("arch_open"), 1, [], 120)
    report.check(done.code == 5 and done.summary["negative_pivots"] == 1, f"between open edges: code {done.code}, {done.summary['negative_pivots']} negative")
    stop = solve("arch_open_stop", variant(open_edges, path))
    report.near(stop.summary["critical_points"][0]["load_factor"], 1.0, 0.01, "the bifurcation between them")
    shaken = open_edges | {"analysis": "modal", "eigen": {"modes": 1, "load_factor": 1.5}}
    report.check("at least 1 mode(s) grow" in solve("arch_open_modes", shaken).text, "modes that grow there are said")
    flat = open_edges | {"steps": {"control": "arc_length", "at_critical_point": "switch_branch", "initial_step": 0.2, "max_steps": 40}}
    for name, support in (("open", []), ("mirrored", [{"type": "symmetry", "group": side, "normal": [0, 1, 0]} for side in "cd"])):
        branch = run(write_case(flat | {"support": flat["support"] + support}, OUT / "arch_branch.toml"), fresh("arch_branch"), 1, [], 120)
        h = branch.history
        report.check(abs(h["arch_x"]).max() > 0.02 and abs(h["load_factor"][-1] - 1) < 0.6,
                     f"{name} edges: the path leaves along a flat branch by {abs(h['arch_x']).max():.3g} m, to {h['load_factor'][-1]:.4g}")
    left = solve("ring_left", variant(case, {"load.0.magnitude": -390.0, "steps": None}) | {"analysis": "drape"})
    report.check(left.summary["negative_pivots"] == 0 and abs(left.history["a_x"][-1]) > 0.3,
                 f"drape leaves it: {left.history['a_x'][-1]:.3g} m, {left.summary['negative_pivots']} negative")


@test
def driven_work(report):
    """A sheet held softly to a box that moves: what drives it gives no more work for longer steps."""
    sheet = grid_mesh("trusting_sheet.msh", lambda s, t: (0.1 * s, 0.1 * t, 0.0), (4, 4), {"w": "left"})
    box = OUT / "trusting_box.obj"
    box.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in ((-.03, 0, -.05), (-.01, 0, -.05), (-.01, .1, -.05), (-.03, .1, -.05), (-.02, .05, .05)))
                   + "f 1 4 3\nf 1 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
    case = {
        "analysis": "dynamic",
        "mesh": {"file": sheet},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 5e-4, "density": 400}],
        "attachment": [{"groups": ["w"], "obstacle": "box"}],
        "contact": {"distance": 1e-3},
        "obstacle": [{"name": "box", "type": "mesh", "file": str(box), "motion": ["0.25*(t-sin(10*t)/10)", "0", "0"]}],
        "time": {"end": 0.2, "step": 0.01, "velocity_tolerance": 1e-5},
    }
    works = []
    for step in (0.01, 0.005):
        h = solve("driven", variant(case, {"time.step": step})).history
        works.append(h["work_of_supports"][-1])
        kinetic = h["kinetic_energy"][-1]
        report.below(h["numerical_loss"][-1], 0.1 * kinetic, f"steps of {step} s: numerical loss [J], kinetic {kinetic:.3g}")
        report.near(works[-1] / kinetic, 1.0, 0.2, "work over the kinetic energy that it has become")


@test
def start_elsewhere(report):
    """mesh.start that supports would pull across the room is refused; one a little off is told; supports of a later stage take hold."""
    lifted = grid_mesh("trusting_lifted.msh", lambda s, t: (12 * s, t, 3.0), (48, 4), {"left": "left", "right": "right"})
    done = run(write_case(long_strip(lifted), OUT / "elsewhere.toml"), fresh("elsewhere"), 1, [], 120)
    report.check(done.code == 2 and "[mesh] start" in done.text and "3 m" in done.text, f"3 m away: code {done.code}")
    near = grid_mesh("trusting_near.msh", lambda s, t: (12 * s, t, 1e-3), (48, 4), {"left": "left", "right": "right"})
    done = run(write_case(long_strip(near), OUT / "elsewhere.toml"), fresh("elsewhere"), 1, [], 120)
    report.check(done.code == 0 and "note: [mesh] start" in done.text, f"1 mm away: code {done.code}")


@test
def unloaded_stages(report):
    """Stages without load after one that has moved the sheet by micrometres: at rest, and the same frequencies as never loaded."""
    mesh = grid_mesh("trusting_plate.msh", lambda s, t: (100 * s, 30 * t, 0.0), (10, 3), {"left": "left", "right": "right"})
    case = {
        "mesh": {"file": mesh},
        "material": [{"type": "isotropic", "young": 210000.0, "poisson": 0.3, "thickness": 1.0, "density": 7.85e-9}],
        "support": [{"type": "clamped", "group": "left"}],
        "probe": [{"name": "tip", "type": "displacement", "group": "right"}],
    }
    first = lambda folder: float((folder / "modes.csv").read_text().splitlines()[1].split(",")[1])  # noqa: E731
    never = first(solve("unloaded_never", case | {"analysis": "modal"}).folder)
    after = case | {"load": [{"type": "line", "group": "right", "vector": [0, 0, 5e-4], "stages": ["s1"]}]}
    for load in (5e-4, 0.5):
        staged = variant(after, {"load.0.vector": [0, 0, load]})
        for last in ("modal", "static", "drape"):
            result = solve(f"unloaded_{last}", staged | {"stage": [{"name": "s1", "analysis": "static"}, {"name": "m", "analysis": last}]})
            if last == "modal":
                report.near(first(result.folder / "m") / never, 1.0, 1e-6, f"after a load of {load} N/mm, frequency over that of a sheet never loaded")


@test
def restart_in_contact(report):
    """A ruffle that is gathered in contact with itself, stopped by a signal at three times: the run that continues is the same to the bit."""
    case = ruffle(2.0)
    case["stage"] = case["stage"][:1]
    case["stage"][0]["time"] |= {"end": 0.4, "checkpoint_steps": 7}
    whole = run(write_case(case, OUT / "ruffle_whole.toml"), fresh("ruffle_whole"), 1)
    if whole.code not in (0, 3):
        raise Failure(f"the whole run ends with code {whole.code}: {whole.text[-300:]}")
    end = whole.folder / "sew"
    rows = [line.split(",") for line in (end / "history.csv").read_text().splitlines()]
    clock = rows[0].index("wall_seconds")
    known = {row[0]: row for row in rows}

    def is_same(row):
        return all(a == b for k, (a, b) in enumerate(zip(row, known[row[0]])) if k != clock)
    for steps in (10, 30, 60):
        folder = fresh("ruffle_part")
        process = started(OUT / "ruffle_whole.toml", folder)
        history = folder / "sew" / "history.csv"
        wait_for(lambda: history.exists() and len(history.read_text().splitlines()) > steps, process)  # noqa: B023
        process.send_signal(signal.SIGKILL if steps == 30 else signal.SIGTERM)
        process.communicate(timeout=60)
        rest = run(OUT / "ruffle_whole.toml", fresh("ruffle_rest"), 1, ["--from", "sew", "--restart", folder / "sew" / "checkpoint.h5"])
        later = [line.split(",") for line in (rest.folder / "sew" / "history.csv").read_text().splitlines()[2:]]
        same = [is_same(row) for row in later]
        report.check(len(same) > 10 and all(same), f"killed after {steps} steps: {sum(same)} of {len(same)} later lines are the same")
    places = [Results(result.folder / "sew")[-1]["displacement"] for result in (whole, rest)]
    report.check(np.abs(places[0]).max() > 0.01 and np.array_equal(*places), "and the same places")


@test
def pinched(report):
    """A sheet between two plates that close on it: the run ends with code 3, and what is stored last is of one time, the plates too."""
    file = OUT / "pinched_sheet.obj"
    line = np.linspace(-0.05, 0.05, 6)
    points = [(x, y, 0.0) for y in line for x in line]
    corners = [(6 * j + i, 6 * j + i + 1, 6 * (j + 1) + i + 1, 6 * (j + 1) + i) for j in range(5) for i in range(5)]
    file.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in points) + "".join(f"f {k + 1} {m + 1} {p + 1}\n" for a, b, c, d in corners for k, m, p in ((a, b, c), (a, c, d))))
    plate = OUT / "pinched_plate.obj"
    plate.write_text("v -0.2 -0.2 0\nv 0.2 -0.2 0\nv 0.2 0.2 0\nv -0.2 0.2 0\nf 1 2 3\nf 1 3 4\n")
    case = {"analysis": "dynamic", "mesh": {"file": str(file)}, "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 300.0}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "contact": {"distance": 1e-3}, "time": {"end": 1.0, "step": 0.01},
            "obstacle": [{"name": "below", "type": "mesh", "file": str(plate), "translate": [0, 0, -0.01]},
                         {"name": "above", "type": "mesh", "file": str(plate), "translate": [0, 0, 0.02], "motion": ["0", "0", "-0.05*t"]}]}
    result = run(write_case(case, OUT / "pinched.toml"), OUT / "pinched", 1, ["--overwrite"])
    last = list(Results(result.folder))[-1]
    report.check(result.code == 3 and 0.3 < last.time < 0.6, f"code {result.code} at t = {last.time:.4g} s")
    heights = last.obstacles[4:, 2]
    report.check(len(heights) == 4 and np.abs(heights - (0.02 - 0.05 * last.time)).max() < 1e-9, f"the plate is where it is at that time: {heights}")
    report.check(result.history["intersections"][-1] == 0, "nothing intersects")


@test
def resting_energy(report):
    """A sheet at rest without loads beside an obstacle: energies of 1e-31 J are none that could be missing."""
    case = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.1, "n": 6}},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 300.0}], "contact": {"distance": 1e-3},
            "obstacle": [{"name": "floor", "type": "plane", "point": [0, 0, -0.05], "normal": [0, 0, 1]}], "time": {"end": 0.05, "step": 0.01}}
    result = solve("resting_energy", case, 1)
    report.check("warning" not in result.text, f"no warning: {[line for line in result.text.splitlines() if 'warning' in line]}")
