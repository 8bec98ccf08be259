"""Rigid groups and sliding clamps: rolling, twist, caps, a top, modes; ranks, restart, mistakes."""

import math

import numpy as np
from common import fresh, strip
from harness import OUT, solve, test
from solver import ROOT, Result, run, write_case


def strip_of(nx, ny, length=12.0, width=1.0, pattern=1):
    return {"file": str(ROOT / "meshes" / "cantilever.geo"),
            "parameters": {"length": length, "width": width, "nx": nx, "ny": ny, "pattern": pattern}}


def plain(thickness, young=1.2e6, poisson=0.0, density=100.0):
    return [{"type": "isotropic", "young": young, "poisson": poisson, "thickness": thickness, "density": density}]


def case_of(mesh, material, rigid, analysis="static", **more):
    return {"title": "Rigid groups", "analysis": analysis, "mesh": mesh, "material": material, "rigid": rigid,
            "output": {"every": 1000}} | more


@test
def rigid_roll(report):
    """A moment of a fixed direction on the rigid end of a cantilever rolls it into a circle; alike on 1, 2 and 3 ranks."""
    length, moment = 12.0, 50 * math.pi / 3  # E I 2 pi / L
    end = {"group": "tip", "name": "end", "moment": [0, -moment, 0], "turn": "about", "turn_axis": [0, 1, 0]}
    case = case_of(strip_of(24, 2), plain(0.1), [end], support=[{"type": "clamped", "group": "clamp"}],
                   steps={"stops": [0.25, 0.5, 0.75, 1.0]})
    ends = []
    for ranks in (1, 2, 3):
        h = solve("rigid_roll", case, ranks).history
        ends.append(np.array([h[f"end_{a}"][-1] for a in "xyz"]))
    for factor in (0.25, 0.5, 0.75, 1.0):
        at = int(np.argmin(abs(h["load_factor"] - factor)))
        angle = 2 * math.pi * factor
        x, z = length * math.sin(angle) / angle - length, length * (1 - math.cos(angle)) / angle
        error = math.hypot(h["end_x"][at] - x, h["end_z"][at] - z)
        report.below(error / length, 0.005, f"load factor {factor}: place of the end")
        if factor < 1:  # a rotation vector of more than 360 degrees begins anew
            report.near(-h["end_turn_y"][at], angle, 0.01 * angle, f"load factor {factor}: turn")
    for ranks, place in zip((2, 3), ends[1:]):
        report.below(np.abs(place - ends[0]).max() / length, 1e-7, f"{ranks} ranks")
    free = solve("rigid_roll_free", case | {"rigid": [{k: v for k, v in end.items() if not k.startswith("turn")}],
                                            "steps": {"final_load_factor": 0.5}}).history
    at = int(np.argmin(abs(h["load_factor"] - 0.5)))
    report.below((free["end_z"][-1] - h["end_z"][at]) / length, 1e-6, "free about all axes it goes the same way")


@test
def rigid_twist(report):
    """A strip twisted at a rigid end that is free to come nearer: shortening and torque of Buckley (1914), with ends that do not warp."""
    length, width, t, young, angle = 20.0, 1.0, 0.02, 1e6, 60.0
    end = {"group": "tip", "name": "end", "translation": ["free", 0, 0], "turn": "about", "turn_axis": [1, 0, 0],
           "turn_angle": f"{angle}*t"}
    case = case_of(strip_of(120, 12, length, width), plain(t, young), [end], support=[{"type": "clamped", "group": "clamp"}],
                   steps={"initial_step": 0.25, "max_step": 0.25})
    h = solve("rigid_twist", case).history
    decay = width / math.sqrt(24)  # length over which ends that do not warp are felt, as of a beam with GJ and E I_w
    twist = math.radians(angle) / (length - 2 * decay)
    shortening = (length - 3 * decay) * twist**2 * width**2 / 24
    torque = young / 2 * width * t**3 / 3 * twist + young * t * width**5 * twist**3 / 360
    report.near(h["end_turn_x"][-1], math.radians(angle), 1e-9, "turn")
    report.percent(-h["end_x"][-1] / shortening, 0.015, f"shortening {-h['end_x'][-1]:.5g} m")
    report.below(h["end_force_x"][-1], 1e-5, "axial force")
    report.percent(h["end_moment_x"][-1] / torque, 0.015, f"torque {h['end_moment_x'][-1]:.5g} N m")


@test
def rigid_caps(report):
    """A tube between rigid caps in compression, torsion and bending; a force beside the axis bends it as its moment does."""
    radius, length, t, young, load = 0.1, 1.0, 0.002, 1e9, 10.0
    mesh = {"file": str(ROOT / "meshes" / "tube.geo"), "parameters": {"n_axial": 32, "n_circ": 64}}
    held = {"group": "start", "translation": [0, 0, 0], "turn": "held"}
    area, inertia, shear = 2 * math.pi * radius * t, math.pi * radius**3 * t, young / 2

    def end(analysis="linear", **more):
        return solve("rigid_caps", case_of(mesh, plain(t, young), [held, {"group": "end"} | more], analysis)).history

    h = end(force=[-load, 0, 0])
    report.percent(-h["end_x"][-1] / (load * length / (young * area)), 0.01, "compression")
    report.near(h["start_force_x"][-1], load, 1e-6 * load, "reaction")
    h = end(moment=[load, 0, 0])
    report.percent(h["end_turn_x"][-1] / (load * length / (shear * 2 * inertia)), 0.01, "torsion")
    report.near(h["start_moment_x"][-1], -load, 1e-6 * load, "its reaction")
    h = end(moment=[0, load, 0])
    bent = h["end_turn_y"][-1]
    report.percent(bent / (load * length / (young * inertia)), 0.01, "bending")
    report.below(abs(end(moment=[0, 1e6 * load, 0])["end_turn_y"][-1] / bent / 1e6 - 1), 1e-6, "a moment a million times as large turns it a million times as far")
    h = end(force=[load / 0.3, 0, 0], point=[length, 0, 0.3])
    report.below(h["end_turn_y"][-1] / bent - 1, 1e-6, "a force beside the axis turns it as far")
    report.percent(end("static", force=[-load, 0, 0])["end_x"][-1] / (-load * length / (young * area)), 0.01, "static")


@test
def rigid_slopes(report):
    """Edges whose slope a body holds, and sliding clamps: beams of all supports against theory."""
    length, t, young, load = 10.0, 0.1, 1.2e6, 0.01
    bending = young * t**3 / 12

    def deflection(rigid, support, name="tip", loads=None):
        case = strip("linear", 40, 2, rigid=rigid, support=support, load=loads or [{"type": "line", "group": "tip", "vector": [0, 0, load]}])
        return solve("rigid_slopes", case).history[f"{name}_z"][-1]

    clamp = [{"type": "clamped", "group": "clamp"}]
    whole, guided = load * length**3 / (3 * bending), load * length**3 / (12 * bending)
    report.percent(deflection([{"group": "clamp", "translation": [0, 0, 0], "turn": "held"}], []) / whole, 0.01, "held by a body")
    end = {"group": "tip", "name": "end", "turn": "held"}
    report.percent(deflection([end], clamp) / guided, 0.01, "guided by a body")
    report.percent(deflection([end | {"force": [0, 0, load]}], clamp, "end", [{"type": "line", "group": "tip", "vector": [0, 0, 0]}]) / guided, 0.01, "with a force on it")
    report.percent(deflection([end | {"slope": "free"}], clamp) / whole, 0.01, "hinged at a body")
    slides = {"type": "sliding", "group": "tip"}
    report.percent(deflection([], clamp + [slides]) / guided, 0.01, "guided by a sliding clamp")
    report.below(deflection([], clamp + [slides | {"components": ["z"]}]), 1e-12, "that holds the deflection too")


@test
def rigid_modes(report):
    """A cantilever with a heavy rigid end, and the same about its equilibrium; buckling under a force on it."""
    length, t, young, mass = 10.0, 0.1, 1.2e6, 5000.0
    bending = young * t**3 / 12
    end = {"group": "tip", "name": "end", "mass": mass, "force": [-1.0, 0, 0]}
    clamp = [{"type": "clamped", "group": "clamp"}]
    h = solve("rigid_modes", strip("modal", 40, 2, rigid=[end], support=clamp, load=None, eigen={"modes": 1}))
    exact = math.sqrt(3 * bending / ((mass + 33 / 140 * 100) * length**3)) / (2 * math.pi)
    found = h.summary["eigenvalues"][0]
    report.percent(found / exact, 0.01, f"frequency {found:.5g} Hz")
    found = solve("rigid_column", strip("buckling", 40, 2, rigid=[end], support=clamp, load=None, eigen={"modes": 1})).summary["eigenvalues"][0]
    report.percent(found / (math.pi**2 * bending / (4 * length**2)), 0.01, f"critical force {found:.5g} N")
    guided = end | {"turn": "held"}
    found = solve("rigid_column", strip("buckling", 40, 2, rigid=[guided], support=clamp, load=None, eigen={"modes": 1})).summary["eigenvalues"][0]
    report.percent(found / (math.pi**2 * bending / length**2), 0.01, f"guided {found:.5g} N")
    plates = solve("rigid_plate", strip("modal", 8, 2, rigid=[{"group": "plate"}], support=None, load=None, eigen={"modes": 6}))
    report.below(max(map(abs, plates.summary["eigenvalues"])), 1e-4, "a rigid plate has six motions without frequency")


@test
def rigid_pendulum(report):
    """A rigid plate swings from the horizontal as a compound pendulum; a free one keeps its energy and place."""
    length, g = 10.0, 9.81
    plate = {"group": "plate", "name": "plate", "point": [0, 0.5, 0], "translation": [0, 0, 0], "turn": "about", "turn_axis": [0, 1, 0]}
    fall = strip("dynamic", 40, 2, rigid=[plate], support=None,
                 load=[{"type": "gravity", "vector": [0, 0, -g], "constant": True}], time={"end": 1.2, "step": 0.01, "max_step": 0.01, "spectral_radius": 0.9})
    h = solve("rigid_fall", fall).history
    # d2(angle)/dt2 = 3 g/(2 L) cos(angle), by Runge and Kutta
    y, n = np.array([0.0, 0.0]), 4000
    dt = h["time"][-1] / n

    def rate(s):
        return np.array([s[1], 1.5 * g / length * math.cos(s[0])])

    for _ in range(n):
        a = rate(y)
        b = rate(y + dt / 2 * a)
        c = rate(y + dt / 2 * b)
        y = y + dt / 6 * (a + 2 * b + 2 * c + rate(y + dt * c))
    report.percent(h["plate_turn_y"][-1] / y[0], 0.001, f"angle after {h['time'][-1]:.3g} s: {h['plate_turn_y'][-1]:.5g}")
    top = {"group": "plate", "name": "plate"}
    spin = strip("dynamic", 8, 2, rigid=[top], support=None, load=None, initial_velocity=[{"angular_velocity": [1.0, 0.02, 2.0], "centre": [5, 0.5, 0]}],
                 time={"end": 2.0, "step": 0.01, "max_step": 0.01, "spectral_radius": 0.9})
    h = solve("rigid_top", spin).history
    kinetic = h["kinetic_energy"]
    report.below(kinetic[-1] / kinetic[0] - 1, 0.002, "kinetic energy of a free plate")
    report.below(max(abs(h["plate_x"][-1]), abs(h["plate_y"][-1]), abs(h["plate_z"][-1])), 1e-6, "its centre stays")


@test
def held_inertia(report):
    """Reactions of accelerated supports and rigid groups hold their inertia: m a and I alpha."""
    time, mass, g = {"end": 0.2, "step": 0.01}, 100.0, 3.0
    moved = [{"type": "displacement", "group": "plate", "components": ["x", "y", "z"], "motion": [f"{g}/2*t^2", "0", "0"]}]
    probe = [{"name": "all", "type": "reaction", "group": "plate"}]
    h = solve("held_inertia", strip("dynamic", 8, 2, support=moved, load=None, probe=probe, time=time)).history
    report.below(np.abs(h["all_x"][1:] / (mass * g) - 1).max(), 1e-6, "a plate that is held everywhere: m a")
    moved[0]["motion"][0] = f"{g}/2*(sqrt(t)*sqrt(0.2-t+1e-12))^4/(0.2-t+1e-12)^2"  # not defined before or after the run
    h = solve("held_inertia_within", strip("dynamic", 8, 2, support=moved, load=None, probe=probe, time=time)).history
    report.below(np.abs(h["all_x"] / (mass * g) - 1).max(), 1e-6, "a motion that is defined within the run only")
    end = {"group": "plate", "name": "plate", "translation": [f"{g}/2*t^2", 0, 0], "turn": "about", "turn_axis": [0, 0, 1], "turn_angle": "90*t^2"}
    for ranks in (1, 2):
        h = solve("held_inertia_rigid", strip("dynamic", 8, 2, support=None, rigid=[end], load=None, probe=None, time=time), ranks).history
        report.below(np.abs(h["plate_force_x"][2:] / (mass * g) - 1).max(), 1e-3, f"a rigid plate on {ranks} ranks: m a")
        moment = np.abs(h["plate_moment_z"][2:] / (mass * (10**2 + 1) / 12 * math.pi) - 1)
        report.below(moment.max(), 0.05, f"I alpha ({moment[-1]:.3g})")
    fixed = [{"type": "clamped", "group": "clamp"}]
    h = solve("held_still", strip("dynamic", 8, 2, support=fixed, load=None, probe=[{"name": "all", "type": "reaction", "group": "clamp"}], time=time)).history
    report.below(np.abs(h["all_x"]).max(), 1e-9, "nothing where nothing moves")


@test
def rigid_motion(report):
    """A strip swings with a heavy body beside its end: the energy is kept, ranks agree, a restart ends at the same bits."""
    end = {"group": "tip", "name": "end", "mass": 50.0, "point": [10.2, 0.3, 0.1]}

    def case(end_time):
        return strip("dynamic", 20, 2, rigid=[end], load=[{"type": "gravity", "vector": [0, 0, -9.81], "constant": True}],
                     time={"end": end_time, "step": 1 / 128, "max_step": 1 / 128, "velocity_tolerance": 1e-6},
                     initial_velocity=[{"angular_velocity": [0.3, 0, 0.5], "centre": [0, 0.5, 0]}])

    whole = solve("rigid_swing", case(64 / 128))
    h = whole.history
    gain = h["kinetic_energy"][-1] + h["stored_energy"][-1] - h["kinetic_energy"][0]
    report.below(gain / h["work_of_loads"][-1] - 1, 0.002, "work of the weight that is not energy")
    report.below(h["energy_unaccounted"][-1] / h["work_of_loads"][-1], 1e-6, "not accounted for")
    for ranks in (2, 3):
        other = solve("rigid_swing_ranks", case(64 / 128), ranks)
        report.below(np.abs(other.displacement() - whole.displacement()).max(), 1e-7, f"{ranks} ranks")
    first = solve("rigid_swing_half", case(32 / 128))
    again = solve("rigid_swing_again", case(64 / 128), options=["--restart", str(first.folder / "checkpoint.h5")])
    report.check(np.array_equal(again.displacement(), whole.displacement()), "a restart ends at the same bits")
    again = solve("rigid_swing_again", case(64 / 128), options=["--restart", str(whole.results.file), "--restart-step", "32"])
    report.below(np.abs(again.displacement() - whole.displacement()).max(), 3e-4, "one from results, without accelerations [m]")


def end_of(result, name):
    return Result(result.folder / name, result.code, result.text, 0.0)


@test
def rigid_stages(report):
    """A rigid end is turned about one axis and then another: the strip is where one turn about their common axis brings it."""
    turns = ([0, 1, 0], 40.0), ([1, 0, 0], 60.0)
    q = np.array([1.0, 0, 0, 0])
    for axis, angle in turns:
        half, a = math.radians(angle) / 2, np.array(axis, float)
        p, q0 = math.sin(half) * a, math.cos(half)
        q = np.concatenate([[q0 * q[0] - p @ q[1:]], q0 * q[1:] + q[0] * p + np.cross(p, q[1:])])
    axis, angle = list(q[1:] / np.linalg.norm(q[1:])), 2 * math.degrees(math.acos(q[0]))
    end = {"group": "tip", "name": "end", "translation": ["-1*t", "0.5*t", "1*t"], "turn": "about"}
    first = end | {"turn_axis": turns[0][0], "turn_angle": f"{turns[0][1]}*t", "stages": ["one"]}
    second = end | {"translation": [0, "0.25*t", 0], "turn_axis": turns[1][0], "turn_angle": f"{turns[1][1]}*t", "stages": ["two", "three"]}
    names = ["one", "two", "three"]
    steps = {"initial_step": 0.1, "max_step": 0.1}
    stages = [{"name": n, "analysis": a} for n, a in zip(names, ("static", "static", "modal"))]
    base = {k: v for k, v in strip("static", 20, 2, load=None, probe=None, time=None, steps=steps, eigen={"modes": 3}).items() if v is not None}
    staged = {k: v for k, v in base.items() if k != "analysis"} | {"stage": stages, "rigid": [first, second]}
    whole = solve("rigid_stages", staged)
    at_once = solve("rigid_at_once", base | {"rigid": [end | {"translation": ["-1*t", "0.75*t", "1*t"], "turn_axis": axis, "turn_angle": f"{angle}*t"}]})
    last = end_of(whole, "two").displacement()
    report.below(np.abs(last - at_once.displacement()).max(), 1e-7, "the same place")
    h, once = whole.stage("two").history, at_once.history
    for part in ("x", "turn_x", "turn_y", "turn_z", "force_x", "force_z", "moment_x", "moment_y"):
        report.below(abs(h[f"end_{part}"][-1] - once[f"end_{part}"][-1]), 1e-5 * max(1.0, abs(once[f"end_{part}"][-1])), f"end_{part}")
    ranks = solve("rigid_stages_ranks", staged, 3)
    report.below(np.abs(end_of(ranks, "two").displacement() - last).max(), 1e-7, "on three ranks")
    found = whole.stage("three").summary["eigenvalues"]
    direct = solve("rigid_direct", base | {"analysis": "modal", "rigid": [{"group": "tip", "translation": [0, 0, 0], "turn": "held"}]}).summary["eigenvalues"]
    report.check(found[0] != direct[0] and found[0] > 0, f"modes about the turned strip: {found[0]:.4g}, {direct[0]:.4g} Hz flat")


@test
def rigid_stage_loads(report):
    """A force on a body stays for the modes; a spin and a driven turn continue from motion to motion and from a stop; mistakes are refused."""
    pull = {"group": "tip", "name": "end", "force": [0, 0, 0.4], "moment": [0, -0.5, 0], "turn": "about", "turn_axis": [0, 1, 0]}
    base = {k: v for k, v in strip("static", 20, 2, load=None, probe=None, time=None, eigen={"modes": 3}).items() if v is not None}
    plain = {k: v for k, v in base.items() if k != "analysis"}
    stages = [{"name": "one", "analysis": "static"}, {"name": "two", "analysis": "modal"}]
    both = solve("rigid_loaded", plain | {"rigid": [pull], "stage": stages})
    once = solve("rigid_loaded_once", base | {"analysis": "modal", "rigid": [pull], "eigen": {"modes": 3, "load_factor": 1.0}})
    a, b = (np.array(r.summary["eigenvalues"]) for r in (both.stage("two"), once))
    report.below(np.abs(a / b - 1).max(), 1e-6, f"frequencies about the loaded strip {a[0]:.5g} Hz")
    # A free spinning plate, and a strip whose end is driven, in two stages and at once
    time = {"step": 1 / 128, "max_step": 1 / 128, "velocity_tolerance": 1e-7, "spectral_radius": 0.9}
    clamp = [{"type": "clamped", "group": "clamp"}]
    scenes = {
        "spun": {"rigid": [{"group": "plate", "name": "end"}], "initial_velocity": [{"angular_velocity": [1.0, 0.02, 2.0], "centre": [5, 0.5, 0]}]},
        "driven": {"support": clamp, "rigid": [{"group": "tip", "name": "end", "translation": ["-2*t^2", "0", "t^2"], "turn": "about", "turn_axis": [1, 1, 0],
                                                "turn_angle": "200*t^2"}]},
    }
    for name, scene in scenes.items():
        case = {k: v for k, v in plain.items() if k not in ("eigen", "support")} | scene
        unbroken = solve(f"rigid_{name}", case | {"analysis": "dynamic", "time": time | {"end": 0.5}})
        parts = [{"name": n, "analysis": "dynamic", "time": {"end": end}} for n, end in (("one", 0.25), ("two", 0.5))]
        split = solve(f"rigid_{name}_split", case | {"stage": parts, "time": time})
        h, whole = split.stage("two").history, unbroken.history
        for part in ("x", "z", "turn_x", "turn_y", "turn_z"):
            report.below(abs(h[f"end_{part}"][-1] - whole[f"end_{part}"][-1]), 1e-3, f"{name}: end_{part} {whole[f'end_{part}'][-1]:.4g}")
        report.below(h["kinetic_energy"][-1] / whole["kinetic_energy"][-1] - 1, 0.01, f"{name}: kinetic energy")
        parts[1]["time"] = {"end": 0.375}
        half = solve(f"rigid_{name}_half", case | {"stage": parts, "time": time})
        again = run(OUT / f"rigid_{name}_split.toml", fresh("rigid_again"), options=["--from", "two", "--restart", half.folder / "two" / "checkpoint.h5"])
        report.check(again.code == 0 and np.array_equal(end_of(again, "two").displacement(), end_of(split, "two").displacement()),
                     f"{name}: a stage that continues from its middle ends at the same bits")
    mistakes = {
        "late": ([pull | {"stages": ["two"]}], ("stage 'two'", "has not been rigid", "every stage")),
        "early": ([pull | {"stages": ["one"]}], ("stage 'two'", "to the end", "every stage")),
        "point": ([pull | {"stages": ["one"]}, pull | {"stages": ["two"], "point": [10, 0, 0]}], ("point, slope and mass",)),
        "moved": ([pull | {"stages": ["one"]}, {"group": "tip", "turn": "about", "turn_axis": [0, 1, 0], "turn_angle": "t", "stages": ["two"]}],
                  ("stage 'two'", "nothing is moved", "modal")),
    }
    for name, (rigid, expected) in mistakes.items():
        result = run(write_case(plain | {"rigid": rigid, "stage": stages}, OUT / "rigid_stage_mistake.toml"), fresh("rigid_stage_mistake"))
        report.check(result.code == 2 and all(e in result.text for e in expected), f"{name}: code {result.code}: {result.text.strip()[-250:]}")


def mistakes(base):
    """Name -> (changes of the keys of the group or of the case, texts of the message)."""
    end = base["rigid"][0]
    return {
        "unknown": ({"rigid": [end | {"group": "nowhere"}]}, (": [[rigid]] group", "nowhere", "the mesh has")),
        "both held": ({"support": base["support"] + [{"type": "hinged", "group": "sides"}]}, ("[[rigid]] group 'tip'", "[[support]] too", "instead")),
        "two": ({"support": None, "rigid": [end, {"group": "plate"}]}, ("both have vertex", "join the groups")),
        "force": ({"rigid": [end | {"translation": ["free", "free", 0], "force": [0, 0, 1]}]}, ("rigid.force", "z component", "free")),
        "moment": ({"rigid": [end | {"turn": "held", "moment": [0, 1, 0]}]}, ("rigid.moment", "remove it")),
        "axis": ({"rigid": [end | {"turn": "about"}]}, ("rigid.turn_axis", "missing")),
        "column": ({"probe": [{"name": "tip_turn", "type": "displacement", "group": "sides"}]}, ("probe.name", "tip_turn", "rename")),
        "arc": ({"rigid": [end | {"translation": ["t", 0, 0]}], "steps": {"control": "arc_length"}}, ("rigid.translation", "steps.control")),
        "linear": ({"rigid": [end | {"translation": ["t", 0, 0]}], "analysis": "linear"}, ("rigid.translation", "static")),
        "drape": ({"analysis": "drape"}, ("rigid.group", "[[support]]")),
        "contact": ({"contact": {"distance": 0.01}}, ("[[rigid]] and [contact]", "remove")),
        "reaction": ({"probe": [{"name": "end", "type": "reaction", "group": "tip"}]}, ("rigid_mistake.toml", "[[probe]] 'end'", "tip_force_x")),
        "spring": ({"spring": [{"type": "line", "group": "tip", "stiffness": 1.0}]}, ("[[spring]]", "[[rigid]]", "translation")),
        "line": ({"rigid": [end | {"slope": "free"}]}, ("[[rigid]] group 'tip'", "lie on a line", "slope")),
        "radius": ({"analysis": "dynamic", "time": {"end": 0.1, "spectral_radius": 1.0}}, ("[[rigid]] and time.spectral_radius", "0.9")),
        "sliding": ({"support": [{"type": "sliding", "group": "plate"}]}, ("(sliding)", "curve group")),
    }


@test
def rigid_mistakes(report):
    """What cannot be is refused with the key and a remedy; a run that was stopped goes on to the same bits."""
    base = strip("static", 20, 2, rigid=[{"group": "tip", "force": [0, 0, 0.4]}], load=None, probe=None, time=None)
    for name, (change, expected) in mistakes(base).items():
        case = {k: v for k, v in (base | change).items() if v is not None}
        result = run(write_case(case, OUT / "rigid_mistake.toml"), fresh("rigid_mistake"))
        report.check(result.code == 2 and all(e in result.text for e in expected), f"{name}: code {result.code}: {result.text.strip()[-250:]}")
    whole = base | {"steps": {"initial_step": 0.25, "max_step": 0.25}}
    first = solve("rigid_half", whole | {"steps": {"initial_step": 0.25, "max_step": 0.25, "final_load_factor": 0.5}})
    again = solve("rigid_again", whole, options=["--restart", str(first.folder / "checkpoint.h5")])
    at_once = solve("rigid_whole", whole)
    report.check(np.array_equal(again.displacement(), at_once.displacement()), "a restart ends at the same bits")
    for control in ("load", "arc_length"):
        path = whole | {"steps": whole["steps"] | {"control": control}}
        done = solve("rigid_path", path)
        again = solve("rigid_path_again", path, options=["--restart", str(done.results.file), "--restart-step", "2"])
        report.check(np.array_equal(again.displacement(), done.displacement()) and again.history["tip_z"][-1] == done.history["tip_z"][-1],
                     f"control = {control}: from step 2 of the results it ends at the same bits")
    ranks = solve("rigid_again", whole, 3, options=["--restart", str(first.folder / "checkpoint.h5")])
    report.below(np.abs(ranks.displacement() - at_once.displacement()).max(), 1e-7, "and on three ranks at the same place")


@test
def rigid_line(report):
    """A moment about a straight edge's own axis, along which it has no inertia, sets the sheet in motion at once, as one that grows fast does."""
    end = {"group": "tip", "moment": [0, -2e-3, 0]}
    case = strip("dynamic", 10, 2, rigid=[end], load=None, probe=None, time={"end": 0.1, "step": 1e-3})
    case = {k: v for k, v in case.items() if v is not None}
    sudden, fast = (solve(f"rigid_line_{k}", case | {"time": case["time"] | t}) for k, t in enumerate(({}, {"load_history": "min(1, t/0.001)"})))
    turns = [r.history["tip_turn_y"] for r in (sudden, fast)]
    report.below(np.abs(turns[0] - turns[1]).max() / np.abs(turns[1]).max(), 0.1, f"turn of up to {np.degrees(np.abs(turns[1]).max()):.2g} degrees: difference")
