"""Regression tests of stages: what flows from one to the next, what they name, and where a run may begin."""

import copy
import math
import re
import signal

import numpy as np
from harness import OUT, solve, test
from common import fresh, lines, started, strip, wait_for
from pattern_files import CLOTH, rectangle, svg
from solver import Result, invoke, run, write_case
from voile import Results


def staged(stages, **changes):
    """The strip with stages and without the sections of a single one."""
    case = strip(**changes)
    for key in ("analysis", "time"):
        case.pop(key, None)
    return case | {"stage": stages}


def stage(name, analysis, **sections):
    return {"name": name, "analysis": analysis, **sections}


EXPANDING = {"type": "isotropic", "young": 1.2e6, "poisson": 0.0, "thickness": 0.1, "density": 100.0, "expansion": 1e-4}
BEND = stage("bend", "static")
SWING = stage("swing", "dynamic", time={"end": 0.1, "step": 0.01})


def end_of(result, name):
    return Result(result.folder / name, result.code, result.text, 0.0)


def largest(a, b):
    return float(np.abs(a - b).max() / np.abs(b).max())


@test
def stages(report):
    """A static and a dynamic stage are the two runs one after the other; --from and --restart go on within them."""
    both = staged([BEND, SWING], damping={"mass": 3.0})
    for ranks in (1, 2):
        whole = solve(f"stages_{ranks}", both, ranks)
        report.check(whole.summary["converged"] and [s["name"] for s in whole.summary["stages"]] == ["bend", "swing"],
                     f"{ranks} rank(s): summary.json lists both stages")
        bend = solve(f"stages_bend_{ranks}", strip("static", time=None), ranks)
        swing = run(write_case(strip("dynamic", time__end=0.1, damping={"mass": 3.0}), OUT / "stages_swing.toml"), fresh("stages_swing"),
                    ranks, ["--restart", bend.folder / "checkpoint.h5"])
        report.below(largest(end_of(whole, "bend").displacement(), bend.displacement()), 1e-12, f"{ranks} rank(s): the first stage alone")
        report.below(largest(end_of(whole, "swing").displacement(), swing.displacement()), 1e-9, f"{ranks} rank(s): both, run by hand")
    before = end_of(whole, "swing").displacement()
    file = OUT / "stages_2.toml"
    again = run(file, whole.folder, 1, ["--from", "swing"])
    report.check(again.code == 0, "--from swing continues from the end of the stage before")
    report.below(largest(end_of(whole, "swing").displacement(), before), 1e-9, "to the same end")
    report.check((whole.folder / "bend" / "history.csv").is_file(), "which stays")
    report.check("had another" not in again.text, "nothing is said of the same material")
    again = run(file, whole.folder, 1, ["--from", "swing", "--set", "material.0.young=2.4e6"])
    report.check(again.code == 0 and "--from swing" in again.text and "had another [material]: young" in again.text, "of another one it is")


@test
def stages_turn(report):
    """A support that turns in a later stage turns its group from where that is, about its centre, whatever has moved it before; also from a stop."""
    first = {"type": "hinged", "group": "plate", "motion": ["0.5*t", "0", "0"], "rotation_axis": [0, 1, 0], "rotation_angle": "40*t", "stages": ["one"]}
    second = {"type": "hinged", "group": "plate", "motion": ["0", "0", "0.2*t"], "rotation_axis": [0, 0, 1], "rotation_angle": "90*t", "rotation_centre": [1, 0, 0], "stages": ["two"]}
    turn = lambda x, axis, angle: x @ np.array({"y": [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]],  # noqa: E731
                                                "z": [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]}[axis]).T
    for analysis in ("static", "dynamic"):
        ends = (1.0, 1.0) if analysis == "static" else (1.0, 2.0)
        stages = [stage(name, analysis, **({} if analysis == "static" else {"time": {"end": end, "step": 0.05}})) for name, end in zip(("one", "two"), ends)]
        turned = second if analysis == "static" else second | {"rotation_angle": "90*(t-1)", "motion": ["0", "0", "0.2*(t-1)"]}
        case = staged(stages, support=[first, turned], load=None, probe=None, nx=10)
        case = {k: v for k, v in case.items() if v is not None}
        for ranks in (1, 2):
            whole = solve(f"stages_turn_{analysis}", case, ranks)
            result = end_of(whole, "two")
            start = Results(result.folder).mesh().positions
            centre = np.array([1.0, 0, 0])
            expected = turn(turn(start, "y", math.radians(40)) + [0.5, 0, 0] - centre, "z", math.radians(90)) + centre + [0, 0, 0.2]
            report.below(np.abs(start + result.displacement() - expected).max(), 1e-12, f"{analysis}, {ranks} rank(s): where it is")
        if analysis == "dynamic":
            case["stage"][1]["time"]["end"] = 1.5
            half = solve("stages_turn_half", case)
            again = run(OUT / "stages_turn_dynamic.toml", fresh("stages_turn_again"), options=["--from", "two", "--restart", half.folder / "two" / "checkpoint.h5"])
            report.below(np.abs(end_of(again, "two").displacement() - result.displacement()).max(), 1e-12, "from the middle of the turn")


@test
def clamp_anew(report):
    """A clamp given anew for the group of the one before is the same clamp; another group, whose slope was free, is refused."""
    def supports(second):
        return [{"type": "clamped", "group": "clamp", "stages": ["bend"]}, {"type": "clamped", "group": second, "stages": ["more"]}]

    bend = [BEND, stage("more", "static")]
    one = solve("clamp_anew_one", staged(bend), 1)
    two = solve("clamp_anew_two", staged(bend, support=supports("clamp")), 1)
    report.below(largest(end_of(two, "more").displacement(), end_of(one, "more").displacement()), 1e-9, "two supports and one")
    free = run(write_case(staged(bend, support=supports("tip")), OUT / "clamp_anew_free.toml"), fresh("clamp_anew_free"))
    report.check(free.code == 2 and "slope" in free.text, f"a slope that was free: code {free.code}")


@test
def other_material(report):
    """A restart with another material changes the energy at the start, not that of remeshing, and the balance still closes."""
    first = solve("other_material_first", strip("dynamic"), 1)
    for young in (1.2e6, 2.4e6):
        case = strip("dynamic", time__end=0.3, material__0__young=young)
        result = run(write_case(case, OUT / "other_material.toml"), fresh("other_material"), 1, ["--restart", first.folder / "checkpoint.h5"])
        h = result.history
        report.check(result.code == 0 and max(map(abs, h["remeshing_gain"])) < 1e-12, f"E = {young:g}: code {result.code}, "
                     f"remeshing_gain {max(map(abs, h['remeshing_gain'])):.3g} J of {max(h['stored_energy']):.3g} J")
        report.below(max(map(abs, h["energy_unaccounted"])) / max(h["stored_energy"]), 1e-3, "unaccounted, of what is stored")


@test
def stages_echo(report):
    """What a run with stages writes of its case can be run: the whole, and each first stage by itself."""
    whole = solve("stages_echo", staged([BEND, SWING]), 1)
    again = run(whole.folder / "resolved_case.toml", fresh("stages_echo_again"))
    report.check(again.code == 0, "the whole runs from its echo" + again.text[-200:] * (again.code != 0))
    report.below(largest(end_of(again, "swing").displacement(), end_of(whole, "swing").displacement()), 1e-12, "to the same end")
    alone = run(whole.folder / "bend" / "resolved_case.toml", fresh("stages_echo_bend"))
    report.below(largest(alone.displacement(), end_of(whole, "bend").displacement()), 1e-12, "the first stage from its own")


@test
def echoes(report):
    """What a run writes of its case is a case, whose files are found from everywhere: of panels, of a gas that does not leak, of all that names files in stages."""
    def checked(name, case):
        folder = solve(f"echo_{name}", case, 1).folder
        for file in (folder / "resolved_case.toml", *sorted(folder.glob("*/resolved_case.toml"))):
            code, text = invoke(["check", file])
            report.check(code == 0, f"{name}, {file.relative_to(folder)}: code {code}{text[-200:] if code else ''}")

    motion = {"analysis": "dynamic", "time": {"end": 0.002, "step": 0.002}}
    panels = {"panel": [{"file": svg("echo.svg", rectangle("p", 0.2, 0.1)), "size": 0.05}], "material": [CLOTH], "contact": {"distance": 1e-3}}
    checked("panels", panels | motion)
    checked("panels_staged", panels | {"stage": [{"name": "a"} | motion]})
    box = strip(nx=4, ny=1, load=[{"type": "gas", "magnitude": 1.0, "ambient": 1e5, "apex": [5, 0.5, 1]}], support=[{"type": "clamped", "group": ["clamp", "tip"]}])
    checked("gas", {k: v for k, v in box.items() if k != "time"})
    (OUT / "echo.csv").write_text("top,0,0,0.3\n")
    (OUT / "echo.pos").write_text('View "size" {\nST(0,0,0, 10,0,0, 0,1,0){2,2,2};\nST(10,0,0, 10,1,0, 0,1,0){2,2,2};\n};\n')
    (OUT / "echo.obj").write_text("v 0 0 5\nv 1 0 5\nv 0 1 5\nf 1 2 3\n")
    files = staged([{"name": "a"} | motion], nx=4, ny=1, contact={"distance": 0.01}, remesh={"background": "echo.pos", "smallest": 1, "largest": 3},
                   obstacle=[{"name": "b", "type": "mesh", "file": "echo.obj", "landmarks": "echo.csv"}])
    checked("files", files)


@test
def stages_hold(report):
    """A support of a later stage takes hold where things are and moves them by what it says; earlier loads stay in full."""
    up = stage("up", "static")
    case = staged([BEND, up, SWING])
    case["support"].append({"type": "displacement", "group": "tip", "components": ["z"], "value": [0, 0, 0.25], "stages": ["up", "swing"]})
    case["support"].append({"type": "displacement", "group": "tip", "components": ["y"], "motion": ["0", "0.5*t", "0"], "stages": ["swing"]})
    case["load"].append({"type": "line", "group": "tip", "vector": [0, 0.3, 0], "stages": ["up"]})
    whole = solve("stages_hold", case, 1)
    bend, lifted, swing = (end_of(whole, name).history for name in ("bend", "up", "swing"))
    report.near(lifted["tip_z"][-1] - bend["tip_z"][-1], 0.25, 1e-9, "the tip is lifted by the value")
    report.near(lifted["tip_z"][0] - bend["tip_z"][-1], 0.0, 1e-6, "from where the first stage left it")
    report.check(abs(lifted["tip_y"][-1]) > 1e-3 > abs(lifted["tip_y"][0]), "a load of this stage grows with the load factor")
    report.near(float(np.abs(swing["tip_z"] - lifted["tip_z"][-1]).max()), 0.0, 1e-9, "the next stage holds the tip there")
    report.near(swing["tip_y"][-1] - swing["tip_y"][0], 0.05, 1e-9, "and a support that moves begins there")
    same = solve("stages_same", staged([BEND, stage("still", "static")]), 1)
    still, first = end_of(same, "still"), end_of(same, "bend")
    report.below(largest(still.displacement(), first.displacement()), 1e-6, "a stage in which nothing is new changes nothing")


@test
def stages_factor(report):
    """What a stage has brought to another load factor than 1 stays at that: loads and a temperature, through stages of every kind."""
    part = stage("part", "static", steps={"final_load_factor": 0.6})
    case = staged([part, stage("still", "static", steps={"final_load_factor": 2.0}), stage("modes_of_it", "modal", eigen={"modes": 2}), stage("yet", "static")],
                  temperature=[{"difference": 3.0}])
    case["material"][0]["expansion"] = 1e-3
    for lasting, temperature in (("expression", "3.0*t"), ("number", 3.0)):
        case["temperature"][0]["difference"] = temperature
        whole = solve(f"stages_factor_{lasting}", case, 1)
        first = end_of(whole, "part").displacement()
        for name in ("still", "yet"):
            report.below(largest(end_of(whole, name).displacement(), first), 1e-7, f"{lasting}: stage '{name}' changes nothing")
    report.check(np.abs(first).max() > 1e-2, "though the first has moved it")
    alone = solve("stages_factor_alone", strip("modal", time=None, eigen={"modes": 2, "load_factor": 0.6}, temperature=[{"difference": 3.0}], material=case["material"]), 1)
    for a, b in zip(whole.summary["stages"][2]["eigenvalues"], alone.summary["eigenvalues"]):
        report.percent(a / b, 1e-5, "frequency of a run that ends there")


@test
def stages_stopped_path(report):
    """A stage after a path that ended at another load factor than planned is refused, with that factor; with it as the plan it is found."""
    bent = staged([stage("part", "static", steps={"control": "displacement", "control_probe": "tip", "final_displacement": 0.3}), stage("still", "static")],
                  probe=[{"name": "tip", "type": "displacement", "group": "tip", "components": ["z"]}])
    code, text = invoke(["run", write_case(bent, OUT / "stages_stopped_path.toml"), "--output", str(fresh("stages_stopped_path"))])
    told = re.search(r"give it final_load_factor = ([0-9.]+)", text)
    report.check(code == 2 and "its path has ended at" in " ".join(text.split()) and told is not None, f"code {code}: {' '.join(text.split())[-300:]}")
    good = staged([stage("part", "static", steps={"final_load_factor": float(told[1])}), stage("still", "static")])
    whole = solve("stages_stopped_path_good", good)
    report.below(largest(end_of(whole, "still").displacement(), end_of(whole, "part").displacement()), 1e-7, "the plan is kept: nothing moves")
    for factor in (1.0, 0.5):
        sudden = staged([stage("part", "static", steps={"final_load_factor": factor}), stage("move", "dynamic", time={"step": 1e-3, "end": 1e-3})])
        told = "loads act in full from its start" in " ".join(solve("stages_sudden", sudden).text.split())
        report.check(told == (factor != 1.0), f"a motion after a path to {factor:g}: {'told' if told else 'silent'} that its loads are sudden")
    held = staged([stage("part", "static"), stage("buckle", "buckling", eigen={"modes": 1})])
    code, text = invoke(["run", write_case(held, OUT / "stages_held.toml"), "--output", str(fresh("stages_held"))])
    report.check(code == 2 and "of its own with `stages`" in " ".join(text.split()) and "Newton" not in text, f"buckling under held loads is refused before the path: {' '.join(text.split())[-200:]}")


@test
def stages_modal(report):
    """Modes of what a stage has left are those of a run that ends there."""
    eigen = {"modes": 3}
    case = staged([BEND, stage("modes_of_it", "modal", eigen=eigen)])
    whole = solve("stages_modal", case, 2)
    alone = solve("stages_modal_alone", strip("modal", time=None, eigen=eigen | {"load_factor": 1.0}), 2)
    found, wanted = whole.summary["stages"][1]["eigenvalues"], alone.summary["eigenvalues"]
    report.check(len(found) == 3, "three modes")
    for a, b in zip(found, wanted):
        report.percent(a / b, 1e-5, "frequency")
    case["load"][0]["stages"] = ["bend"]  # what bends it is gone: the strip is flat again before its modes are found
    flat = solve("stages_modal_flat", case, 1).summary["stages"][1]["eigenvalues"]
    unloaded = solve("stages_modal_unloaded", strip("modal", time=None, eigen=eigen), 1).summary["eigenvalues"]
    for a, b in zip(flat, unloaded):
        report.percent(a / b, 1e-5, "frequency without the load")


@test
def moved_after_modes(report):
    """What a support or the edges of a cell are to move by, and a stage of modes has not, the next stage moves, and later ones hold."""
    eigen, stages = {"modes": 2}, [("ring", "modal"), ("pull", "static"), ("hold", "static"), ("again", "modal")]
    case = staged([stage(name, analysis) for name, analysis in stages], eigen=eigen, load=[])
    tip = {"name": "tip", "type": "displacement", "group": "tip", "components": ["x"]}
    case |= {"probe": [tip], "support": [*case["support"], {"type": "displacement", "group": "tip", "components": ["x"], "value": [1e-3, 0, 0]}]}
    for how, change in (("value", {}), ("motion", {"value": [0, 0, 0], "motion": ["1e-3*t", "0", "0"]})):
        case["support"][-1] |= change
        whole = solve(f"moved_after_modes_{how}", case)
        for name in ("pull", "hold"):
            report.near(whole.stage(name).history["tip_x"][-1], 1e-3, 1e-12, f"{how}: the tip after '{name}'")
        report.check(whole.stage("again").summary["eigenvalues"][0] > 1.01 * whole.stage("ring").summary["eigenvalues"][0], "the strip is taut then")


@test
def modes_on_a_path(report):
    """[eigen] load_factor leads a later stage, and a restart, to the state that it leads an unbroken run to."""
    load = [{"type": "line", "group": "tip", "vector": [2000.0, 0, 0]}, {"type": "line", "group": "tip", "vector": [3000.0, 0, 0]}]
    first = lambda f: solve("path_modes_alone", strip("modal", time=None, eigen={"modes": 1, "load_factor": 1.0},  # noqa: E731
                                                      load=[load[0] | {"vector": [f, 0, 0]}]), 1).summary["eigenvalues"][0]
    exact = first(2000.0 + 0.75 * 3000.0)
    later = staged([stage("pull", "static", steps={"initial_step": 1.0}), stage("ring", "modal", eigen={"modes": 1, "load_factor": 0.75}), stage("after", "modal", eigen={"modes": 1})],
                   load=[load[0], load[1] | {"stages": ["ring", "after"]}])
    stages = solve("path_modes_stage", later, 1).summary["stages"]
    report.near(stages[1]["eigenvalues"][0] / exact, 1.0, 1e-6, "a stage goes to its load factor")
    report.near(stages[2]["eigenvalues"][0] / exact, 1.0, 1e-6, "where the next one finds it")
    whole = strip("modal", time=None, load=load[:1], eigen={"modes": 1, "load_factor": 1.0})
    half = solve("path_modes_half", strip("static", time=None, load=load[:1], steps={"final_load_factor": 0.5, "initial_step": 0.5}), 1)
    for factor, force in ((0.25, 500.0), (0.0, 1000.0), (1.0, 2000.0)):
        again = run(write_case(whole | {"eigen": {"modes": 1, "load_factor": factor}}, OUT / "path_modes_again.toml"), fresh("path_modes_again"), 1,
                    ["--restart", half.folder / "checkpoint.h5"])
        report.near(again.summary["eigenvalues"][0] / first(force), 1.0, 1e-6, f"a restart from 0.5 with load_factor {factor}")


@test
def stages_interrupted(report):
    """A stage that is stopped ends the run with code 3, and continues from its checkpoint to the end of the unbroken run."""
    long_swing = stage("swing", "dynamic", time={"end": 0.4, "step": 0.002})
    case = staged([stage("bend", "static", steps={"initial_step": 1.0}), long_swing], nx=80, ny=8)
    whole = solve("stages_whole", case, 1)
    folder = fresh("stages_stopped")
    file = write_case(case, OUT / "stages_stopped.toml")
    process = started(file, folder)
    running = wait_for(lambda: lines(folder / "swing" / "history.csv") >= 5, process)
    process.send_signal(signal.SIGTERM)
    text = process.communicate(timeout=60)[0]
    report.check(running and process.returncode == 3 and "stage 'swing': not converged: stopped by a signal" in text, "stopped with code 3")
    early = staged([*case["stage"], stage("modes_of_it", "modal")], nx=80, ny=8)
    result = run(write_case(early, OUT / "stages_early.toml"), folder, 1, ["--from", "modes_of_it"])
    report.check(result.code == 2 and "stage 'swing' before it has not come to its end" in result.text, "what comes after cannot begin yet")
    rest = run(file, fresh("stages_rest"), 2, ["--from", "swing", "--restart", folder / "swing" / "checkpoint.h5"])
    report.check(rest.code == 0, "it goes on on 2 ranks")
    report.below(largest(end_of(rest, "swing").displacement(), end_of(whole, "swing").displacement()), 1e-8, "to the same end")


@test
def stages_stopped_search(report):
    """A signal in the search that a stage begins with ends the run with code 3."""
    case = staged([stage("swing", "dynamic", time={"end": 0.01, "step": 0.01}), stage("still", "static")], nx=300, ny=30)
    case["load"] = [{"type": "gravity", "vector": [0, 0, -0.5]}]
    folder = fresh("stages_search")
    process = started(write_case(case, OUT / "stages_search.toml"), folder, ["-snes_monitor"])
    later = 0
    for line in process.stdout:
        later += "stage 'still'" in line or (later > 0 and "SNES Function norm" in line)
        if later > 3:
            break
    process.send_signal(signal.SIGTERM)
    text = process.communicate(timeout=120)[0]
    report.check(later > 3 and process.returncode == 3 and "stage 'still': not converged: stopped by a signal" in text,
                 f"code {process.returncode}: {text.splitlines()[-1][:120] if text else ''}")
    report.check((folder / "still" / "checkpoint.h5").is_file(), "what it had reached is there")


@test
def stages_mistakes(report):
    """Stages that make no sense end with code 2 and a remedy, before anything is solved or overwritten."""
    good = staged([BEND, SWING])

    def changed(change):
        case = copy.deepcopy(good)
        change(case)
        return case

    def hold(case, names):
        case["load"][0]["stages"] = names

    mistakes = {
        "did you mean 'swing'": changed(lambda c: hold(c, ["swin"])),
        "a list of names of stages": changed(lambda c: hold(c, "swing")),
        "obstacle.motion: 'ball' moves in stages": changed(lambda c: c.update(contact={}, stage=[stage("bend", "drape"), SWING], obstacle=[
            {"name": "ball", "type": "sphere", "point": [5, 0.5, 1], "radius": 0.5, "motion": ["0", "0", "-t"], "stages": ["bend"]}])),
        "another stage has it": changed(lambda c: c["stage"].append(BEND)),
        "name of a folder": changed(lambda c: c["stage"][1].update(name="../swing")),
        "the key analysis is missing": changed(lambda c: c["stage"][1].pop("analysis")),
        "give each stage a name": changed(lambda c: c["stage"][1].pop("name")),
        "each [[stage]] has its own": changed(lambda c: c.update(analysis="static")),
        "unknown key or table 'tme'": changed(lambda c: c["stage"][1].update(tme={"end": 1.0})),
        "[time] unknown key 'nd'": changed(lambda c: c["stage"][1].update(time={"nd": 1.0})),
        "a slope is held from the first stage on": changed(lambda c: c["support"].append(
            {"type": "clamped", "group": "tip", "stages": ["swing"]})),
        "make it the first stage": changed(lambda c: c["stage"][1].update(analysis="linear")),
        "give a later end": changed(lambda c: c["stage"].append(stage("again", "dynamic", time={"end": 0.1}))),
        "stage 'more': [steps] control needs a load": changed(lambda c: c["stage"].append(stage("more", "static", steps={"control": "arc_length"}))),
        "stage 'tremble': analysis = \"harmonic\" needs a load": changed(lambda c: c["stage"].append(stage("tremble", "harmonic", harmonic={"from": 1, "to": 2}))),
        "stage 'folds': analysis = \"buckling\" needs a load": changed(lambda c: c.update(
            hinge=[{"group": "tip", "stiffness": 1.0}], stage=[BEND, stage("folds", "buckling")])),
        "need the mass of every material": changed(lambda c: c["material"][0].pop("density")),
    }
    folder = OUT / "stages_mistakes"
    solve("stages_mistakes", good, 1)
    for number, (words, case) in enumerate(mistakes.items()):
        result = run(write_case(case, OUT / f"stages_mistake_{number}.toml"), folder, 1 + number % 2)
        text = " ".join(result.text.split())
        report.check(result.code == 2 and words in text, f"code {result.code}: {words}" + (": " + text[-160:] if words not in text else ""))
    report.check((folder / "swing" / "checkpoint.h5").is_file(), "the earlier run is still there")
    file = OUT / "stages_mistakes.toml"
    for options, words in ((["--restart", folder / "swing" / "checkpoint.h5"], "with --from: bend, swing"), (["--from", "swng"], "did you mean 'swing'"),
                           (["--from", "swing", "--restart", folder / "swing" / "checkpoint.h5"], "overwrite its own input")):
        result = run(file, folder, 1, options)
        report.check(result.code == 2 and words in result.text, f"code {result.code}: {words}")


def column(result, name, part=None):
    return (end_of(result, part) if part else result).history[name][-1]


@test
def changed_restart(report):
    """What acts in a static or modal restart is in equilibrium, also where the load factor does not grow; an unchanged one takes no step."""
    line = lambda f: [{"type": "line", "group": "tip", "vector": [0, 0, f]}]  # noqa: E731
    half, whole = strip("static", time=None, load=line(0.5)), strip("static", time=None, load=line(1.0))
    first, right = solve("changed_first", half), solve("changed_right", whole)
    again = lambda case, file: run(write_case(case, OUT / "changed_again.toml"), fresh("changed_again"), 1, ["--restart", first.folder / file])  # noqa: E731
    for file in ("checkpoint.h5", "results.vtkhdf"):
        report.near(again(whole, file).history["tip_z"][-1] / right.history["tip_z"][-1], 1.0, 1e-6, f"twice the load, from {file}")
    spring = half | {"spring": [{"type": "point", "group": "tip", "stiffness": 0.5}]}
    report.near(again(spring, "checkpoint.h5").history["tip_z"][-1] / solve("changed_spring", spring).history["tip_z"][-1], 1.0, 1e-6, "a spring more")
    same = again(half, "checkpoint.h5")
    report.check(np.array_equal(same.displacement(), first.displacement()), "an unchanged case leaves every bit")
    modal = whole | {"analysis": "modal", "eigen": {"modes": 1}}
    alone = solve("changed_alone", modal | {"eigen": {"modes": 1, "load_factor": 1.0}})
    report.near(again(modal, "checkpoint.h5").summary["eigenvalues"][0] / alone.summary["eigenvalues"][0], 1.0, 1e-6, "modes under the load of the case")


@test
def clocks(report):
    """Histories, motions, temperatures and releases go on through stages of every kind."""
    held = {"type": "displacement", "group": "tip", "components": ["z"]}
    move = lambda name, end, **more: stage(name, "dynamic", time={"end": end, "step": 0.01} | more)  # noqa: E731
    damping = {"damping": {"mass": 5.0}}
    # A load under a history stays at what that has come to.
    half = staged([move("s1", 0.1, load_history="0.5"), stage("s2", "static")])
    report.near(column(solve("clocks_load", half), "tip_z", "s2") / column(solve("clocks_half", strip("static", time=None, steps={"final_load_factor": 0.5})), "tip_z"),
                1.0, 1e-6, "a load after a motion with load_history 0.5")
    value = staged([move("s1", 0.1, load_history="table(t, 0, 0, 0.2, 1)"), move("s2", 0.2, load_history="table(t, 0, 0, 0.2, 1)")], load=[]) | damping
    value["support"] = [*value["support"], held | {"value": [0, 0, 0.1]}]
    report.near(column(solve("clocks_value", value), "tip_z", "s2"), 0.1, 1e-9, "a value under load_history over two motions")
    for between in ("static", "drape", "modal"):
        moved = staged([move("s1", 0.1), stage("between", between), move("s2", 0.3)], load=[]) | damping
        moved["support"] = [*moved["support"], held | {"motion": ["0", "0", "0.2*t"]}]
        report.near(column(solve("clocks_motion", moved), "tip_z", "s2"), 0.06, 1e-9, f"a motion goes on after {between}")
    # Held all over, its ends are pulled by E h a 60 K at the end of 0.3 s, and by a third of it where the first motion ends.
    warm = {"material": [EXPANDING], "support": [{"type": "hinged", "group": "plate"}], "probe": [{"name": "pull", "type": "reaction", "group": "tip", "components": ["x"]}]}
    right = column(solve("clocks_warm", strip("static", time=None, load=[], temperature=[{"change": "60"}]) | warm), "pull_x")
    for between in ("static", "drape"):
        grown = staged([move("s1", 0.1), stage("between", between), move("s2", 0.3)], load=[], temperature=[{"change": "200*t"}]) | warm
        run_of = solve("clocks_grown", grown)
        report.near(column(run_of, "pull_x", "s2") / right, 1.0, 1e-9, f"a temperature goes on after {between}")
        report.near(column(run_of, "pull_x", "between") / right, 1 / 3, 0.01, "where it stands still")
    free = column(solve("clocks_free", strip("static", time=None)), "tip_z")
    for last in ("static", "drape"):
        released = staged([move("s1", 0.1), stage("s2", last)]) | damping
        released["support"] = [*released["support"], held | {"release": 0.05}]
        report.near(column(solve("clocks_release", released), "tip_z", "s2") / free, 1.0, 1e-5, f"a support that has let go holds nothing in {last}")
    pulled = [{"type": "line", "group": "tip", "vector": [2000.0, 0, 0]}]
    first = staged([stage("ring", "modal", eigen={"modes": 1})], load=[pulled[0] | {"history": "1"}])
    constant = strip("modal", time=None, eigen={"modes": 1}, load=[pulled[0] | {"constant": True}])
    report.near(solve("clocks_first", first).summary["stages"][0]["eigenvalues"][0] / solve("clocks_constant", constant).summary["eigenvalues"][0], 1.0, 1e-6,
                "modes of a first stage under a load with a history")
    late = staged([move("s1", 0.05), move("s2", 0.1)], initial_velocity=[{"velocity": [0, 0, 1.0], "stages": ["s2"]}])
    code, text = invoke(["check", write_case(late, OUT / "clocks_late.toml")])
    report.check(code == 2 and "initial_velocity.stages: stage 's2' continues a motion" in text, f"initial velocities of a later motion: code {code}: {text.strip()[-200:]}")
    ends = strip("modal", time=None, eigen={"modes": 1, "load_factor": 1.0}, steps={"control": "displacement", "control_probe": "tip_z", "final_displacement": 0.1})
    code, text = invoke(["check", write_case(ends, OUT / "clocks_ends.toml")])
    report.check(code == 2 and "steps.final_displacement" in text, f"modes where a displacement ends: code {code}: {text.strip()[-200:]}")
    text = invoke(["check", write_case(strip("drape", time=None, steps={"final_load_factor": 2.0}), OUT / "clocks_drape.toml")])[1]
    report.check("[steps] has no effect" in text, "a drape has no path")


@test
def stage_from_elsewhere(report):
    """A stage that begins from the checkpoint of the stage before, in another folder, has the clock of the unbroken run; modes after contact say what they leave out."""
    case = strip(nx=6, ny=1, load=[{"type": "line", "group": "tip", "vector": [0, 0, 0.4], "history": "cos(20*t)"}])
    del case["analysis"], case["time"]
    time = {"step": 0.01}
    case["stage"] = [{"name": "a", "analysis": "dynamic", "time": time | {"end": 0.05}}, {"name": "b", "analysis": "static"},
                     {"name": "c", "analysis": "dynamic", "time": time | {"end": 0.1}}]
    whole = solve("elsewhere_whole", case)
    for before, stage in (("a", "b"), ("b", "c")):
        rest = run(OUT / "elsewhere_whole.toml", fresh("elsewhere_rest"), 1, ["--from", stage, "--restart", whole.folder / before / "checkpoint.h5"])
        report.check(rest.code == 0, f"from {stage}: code {rest.code}: {rest.text.strip()[-200:] if rest.code else ''}")
        one, two = (r.stage("c").history for r in (whole, rest))
        report.check(len(one["time"]) == len(two["time"]) and np.array_equal(one["time"], two["time"]), f"from {stage}: the times of c are {two['time'][0]:g} to {two['time'][-1]:g} s")
        report.below(np.abs(one["tip_z"][-1] - two["tip_z"][-1]), 1e-9, f"from {stage}: the tip at the end, difference [m]")
    case["contact"] = {"distance": 0.01}
    case["obstacle"] = [{"name": "floor", "type": "plane", "point": [0, 0, -5], "normal": [0, 0, 1]}]
    case["stage"][1] = {"name": "b", "analysis": "modal"}
    text = invoke(["check", write_case(case, OUT / "elsewhere_modes.toml")])[1]
    report.check("note: stage 'b' knows no contact" in text, "modes after a stage with contact")
