"""Regression tests of remeshing within a run: the answer, restarts, stages, supports and probes, and mistakes."""

import re
import signal

import h5py
import numpy as np

from benchmarks import BENCHMARKS
from curves import Table
from harness import OUT, solve, test
from results import Results
from common import fresh, lines, sheet_on_ball, started, strip, wait_for
from solver import ROOT, invoke, load_case, run, variant, write_case
from staging import end_of, stage, staged

SIZES = {"angle": 6.0, "smallest": 0.05, "largest": 0.5}


def swinging(**changes):
    """A strip that is hit at its end and gets other meshes on the way."""
    return strip("dynamic", **{"nx": 16, "time__end": 0.6, "time__checkpoint_steps": 5,
                               "load": [{"type": "line", "group": "tip", "vector": [0, 0, 40.0]}],
                               "remesh": {"angle": 5.0, "smallest": 0.1, "largest": 1.0, "every": 5},
                               "output": {"fields": ["displacement", "velocity"], "every": 1},
                               "probe": [{"name": "tip", "type": "displacement", "group": "tip"},
                                         {"name": "middle", "type": "displacement", "point": [5, 0.5, 0]}]} | changes)


def at_steps(history, name):
    return dict(zip(history["step"], history[name]))


BALANCE = ("stored_energy", "work_of_loads", "numerical_loss")


def compare(report, again, whole, limit, what, balanced=True):
    """The steps of a run that went on against those of the unbroken one: meshes the same (where the state is not, `balanced` is false, nearly:
    a size that is rounded the other way is another mesh), values to `limit`."""
    for name, slack in (("vertices", 0.0 if balanced else 0.05), ("remeshings", 0.0)):
        a, b = at_steps(again.history, name), at_steps(whole.history, name)
        report.check(all(abs(a[s] - b[s]) <= slack * b[s] for s in a), f"{what}: the same {name}" + ", to 5 %" * (slack > 0.0))
    for name in ("tip_z", "middle_z", "kinetic_energy", *(BALANCE if balanced else ())):
        a, b = at_steps(again.history, name), at_steps(whole.history, name)
        report.below(max(abs(a[s] - b[s]) for s in a) / max(map(abs, b.values())), limit, f"{what}: {name}")


@test
def remesh_path(report):
    """A coarse cantilever gets the mesh it needs: answers beside the published ones, the same on 1, 2 and 3 ranks."""
    reference = BENCHMARKS["cantilever_shear"].reference
    case = variant(load_case(BENCHMARKS["cantilever_shear"].case),
                   {"mesh.parameters.nx": 10, "mesh.parameters.ny": 1, "remesh": SIZES,
                    "output": {"fields": ["displacement", "wanted_size"], "every": 4}})
    first = None
    for ranks in (1, 2, 3):
        result = solve(f"remesh_path_{ranks}", case, ranks)
        h, steps = result.history, list(Results(result.folder))
        counts = [len(s["displacement"]) for s in steps]
        report.check(len(set(counts)) > 1 and counts[-1] == h["vertices"][-1], f"{ranks} rank(s): results of several meshes are read")
        report.check(h["remeshings"][-1] >= 1 and "refused" not in result.text.replace("0 refused", ""), f"{ranks} rank(s): remeshed, nothing refused")
        report.percent(-h["tip_x"][-1] / reference["minus_u_tip_elastica"][-1], 0.01, f"{ranks} rank(s): -u of the tip, against the elastica")
        report.percent(h["tip_z"][-1] / reference["w_tip_elastica"][-1], 0.01, f"{ranks} rank(s): w of the tip")
        wanted = [s["wanted_size"] for s in steps]
        table = Table(result.folder / "remeshing.csv")
        report.check([len(w) for w in wanted] == counts and wanted[0].min() == table["wanted_smallest"][0]
                     and wanted[0].max() == table["wanted_largest"][0],
                     f"{ranks} rank(s): the field of wanted sizes is what the first remeshing went by")
        report.check(SIZES["smallest"] < wanted[-1].min() < 0.9 * wanted[-1].max() < SIZES["largest"],
                     f"{ranks} rank(s): in the bent strip sizes follow the curvature")
        first = first or h
        report.check(list(h["vertices"]) == list(first["vertices"]), f"{ranks} rank(s): the same meshes as on one")
        report.below(h["tip_z"][-1] / first["tip_z"][-1] - 1, 1e-8, f"{ranks} rank(s): the same tip as on one")


@test
def remesh_restart(report):
    """A motion that is remeshed continues from a checkpoint or a recorded step with the meshes of the unbroken run."""
    whole = solve("remesh_whole", swinging(), 1)
    h = whole.history
    report.check(h["remeshings"][-1] >= 1, "remeshed")
    change = h["kinetic_energy"] + h["stored_energy"] - h["work_of_loads"] + h["numerical_loss"] - h["remeshing_gain"]
    work = max(map(abs, h["work_of_loads"]))
    report.below(max(map(abs, change)) / work, 1e-4, "the balance is closed")
    report.below(max(map(abs, h["remeshing_gain"])) / work, 1e-4, "velocities have taken up what the new mesh changed")
    report.below(max(map(abs, h["energy_unaccounted"])) / work, 1e-4, "hardly anything is unaccounted for")
    report.check(abs(whole.summary["energy"]["work_of_loads"] / h["work_of_loads"][-1] - 1) < 1e-12 and "unaccounted" in whole.text, "and told at the end")
    motion, peak = whole.summary["motion"], max(h["kinetic_energy"])
    report.check(motion["largest"] == peak and h["time"][list(h["kinetic_energy"]).index(peak)] == motion["time_of_largest"] and not motion["at_rest"], "it is still in motion, and when it was fastest is told")
    file = OUT / "remesh_whole.toml"
    for number, steps in enumerate((30, 35, 50)):  # before, at and after the step at which the mesh is exchanged
        short = run(file, fresh("remesh_short"), 2, ["-ts_max_steps", str(steps)])
        again = run(file, fresh("remesh_again"), 1 + (number + 2) % 3, ["--restart", OUT / "remesh_short" / "checkpoint.h5"])
        report.check(short.code == 3 and again.code == 0, f"from step {steps}: codes {short.code}, {again.code}")
        compare(report, again, whole, 1e-8, f"from step {steps}")
    at = list(h["remeshings"]).index(1) - 1
    run(file, fresh("remesh_short"), 1, ["-ts_max_steps", str(at)])  # the mesh is exchanged next
    again = run(file, fresh("remesh_again"), 1, ["--restart", OUT / "remesh_short" / "checkpoint.h5"])
    report.check(np.array_equal(again.displacement(), whole.displacement()), f"from step {at} on one rank: the same to the last bit")
    recorded = run(file, fresh("remesh_recorded"), 2, ["--restart", whole.folder / "results.vtkhdf", "--restart-step", "40"])
    report.check(recorded.code == 0, "from results.vtkhdf" + recorded.text[-200:] * (recorded.code != 0))
    compare(report, recorded, whole, 1e-3, "from results.vtkhdf, which has no accelerations", balanced=False)


@test
def remesh_contact_restart(report):
    """A sheet that is remeshed on a ball, stopped before, at and after the step at which its mesh is exchanged: the run that continues is the same to the bit, the sums of energies too."""
    case = sheet_on_ball(time__end=0.14, time__checkpoint_steps=1, remesh={"largest": 0.08, "smallest": 0.02})
    whole = solve("remesh_ball", case, 1)
    h = whole.history
    report.check([h["remeshings"][k] for k in (10, 11)] == [0, 1], "remeshed after step 10")
    for steps in (9, 10, 12):
        run(OUT / "remesh_ball.toml", fresh("remesh_ball_short"), 1, ["-ts_max_steps", str(steps)])
        again = run(OUT / "remesh_ball.toml", fresh("remesh_ball_again"), 1, ["--restart", OUT / "remesh_ball_short" / "checkpoint.h5"]).history
        other = [name for name in h.names if name != "wall_seconds" and not np.array_equal(again[name][1:], h[name][steps + 1:], equal_nan=True)]
        report.check(again["step"][0] == steps and not other, f"from step {steps}: other columns are {other}")


@test
def remesh_taken_over(report):
    """Results of a remeshed run are gone on with without [remesh], on the mesh of the step; a motion recorded without velocities is only for statics."""
    case = strip("static", nx=8, load=[{"type": "line", "group": "tip", "vector": [0, 0, 4.0]}],
                 remesh={"angle": 5.0, "smallest": 0.1, "largest": 1.0}, output={"fields": ["displacement"]})
    whole = solve("remesh_taken", case, 1)
    vertices = [len(s["displacement"]) for s in Results(whole.folder)]
    report.check(len(set(vertices)) > 1, f"remeshed: {sorted(set(vertices))} vertices")
    for ranks, changes in ((1, {"remesh": None}), (2, {"remesh": {"active": False}})):
        file = write_case(variant(case, {**changes, "steps.final_load_factor": 1.5}), OUT / "remesh_taken_on.toml")
        on = run(file, fresh("remesh_taken_on"), ranks, ["--restart", whole.folder / "results.vtkhdf"])
        report.check(on.code == 0 and len(on.displacement()) == vertices[-1], f"{ranks} rank(s): code {on.code}, on the mesh of the last step" + on.text[-300:] * (on.code != 0))
    places = [[0.25 * k, 0.5, 0] for k in (9, 21)]
    for k, point in enumerate(places):
        probe = {"name": "middle", "type": "displacement", "point": point}
        on = run(write_case(swinging(probe=[probe]), OUT / f"remesh_taken_probe_{k}.toml"), fresh(f"remesh_taken_probe_{k}"), 1, ["--restart", OUT / "remesh_taken_probe_0" / "checkpoint.h5"] * k + ["-ts_max_steps", "40"] * (1 - k))
        kept = [on.results.mesh(e).positions[on.results.mesh(e).group("probe middle")] for e in on.results.epochs]
        report.check(len(kept) > 1 - k and all(np.linalg.norm(x - point) < 0.7 and (x == kept[0]).all() for x in kept), f"code {on.code}: the probe is at the point that the case says, and stays: {kept[0].round(3)} at {point}")
    moving = solve("remesh_taken_moving", swinging(time__end=0.3, output={"fields": ["displacement"]}), 1)
    again = run(OUT / "remesh_taken_moving.toml", fresh("remesh_taken_on"), 1, ["--restart", moving.folder / "results.vtkhdf"])
    report.check(again.code == 2 and "`velocity` is not among the fields" in again.text, f"a motion without its velocities does not begin anew at time 0: code {again.code}")
    still = run(OUT / "remesh_taken.toml", fresh("remesh_taken_on"), 1, ["--restart", moving.folder / "results.vtkhdf"])
    report.check(still.code == 0, "statics begin at its shape" + still.text[-300:] * (still.code != 0))


@test
def remesh_killed(report):
    """kill -9 in the middle of a remeshed motion: its checkpoint goes on on another number of ranks."""
    case = swinging(time__step=0.002)
    folder = fresh("remesh_killed")
    file = write_case(case, OUT / "remesh_killed.toml")
    process = started(file, folder)

    def remeshed():
        return lines(folder / "remeshing.csv") > 1 and lines(folder / "history.csv") > 210

    running = wait_for(remeshed, process)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    with h5py.File(folder / "checkpoint.h5") as data:
        at = int(data.attrs["step"])
    whole = solve("remesh_killed_whole", case, 1)
    again = run(file, fresh("remesh_killed_again"), 3, ["--restart", folder / "checkpoint.h5"])
    report.check(running and again.code == 0, f"killed after step {at}, code {again.code}")
    compare(report, again, whole, 1e-8, "on 3 ranks")


@test
def remesh_stages(report):
    """Drape, motion and modes, one after the other: each goes on with the mesh that it finds."""
    case = staged([stage("hang", "drape", remesh=SIZES), stage("swing", "dynamic", time={"end": 0.05, "step": 0.01}, remesh=SIZES),
                   stage("modes_of_it", "modal", eigen={"modes": 2})], nx=10)
    case["load"] = [{"type": "gravity", "vector": [0, 0, -0.05]}]
    whole = solve("remesh_stages", case, 2)
    hang, swing = end_of(whole, "hang"), end_of(whole, "swing")
    report.check(hang.history["remeshings"][-1] >= 1, "the drape is remeshed")
    report.check(swing.history["vertices"][0] == hang.history["vertices"][-1], "the motion begins on its mesh")
    found = whole.summary["stages"][2]["eigenvalues"]
    again = run(OUT / "remesh_stages.toml", whole.folder, 1, ["--from", "modes_of_it"])
    report.check(again.code == 0 and len(found) == 2, "--from modes_of_it" + again.text[-200:] * (again.code != 0))
    for a, b in zip(again.summary["stages"][-1]["eigenvalues"], found):
        report.percent(a / b, 1e-6, "frequency")


@test
def remesh_refused(report):
    """What would change the energy is refused, said, and tried again after 1, 2, 4, ... looks, also after a restart."""
    case = swinging(remesh={"angle": 5.0, "smallest": 0.1, "largest": 1.0, "every": 1, "energy_change": 1e-9, "velocity_change": 0.0}, time__checkpoint_steps=1)
    whole = solve("remesh_refused", case, 1)
    table = Table(whole.folder / "remeshing.csv")
    report.check(whole.code == 0 and not np.any(table["accepted"]), "nothing is accepted")
    report.check(set(whole.history["vertices"]) == {whole.history["vertices"][0]}, "the mesh stays")
    waits = np.diff(table["step"])
    report.check(len(waits) >= 3 and all(w >= 2**k for k, w in enumerate(waits[:6])), f"waits between tries: {waits}")
    report.check("refused" in whole.text and "the energy would change by" in whole.text and "more than remesh.energy_change" in whole.text, "said")
    at = int(table["step"][2]) + 1
    file = OUT / "remesh_refused.toml"
    run(file, fresh("remesh_refused_short"), 1, ["-ts_max_steps", str(at)])
    again = run(file, fresh("remesh_refused_again"), 2, ["--restart", OUT / "remesh_refused_short" / "checkpoint.h5"])
    later = Table(again.folder / "remeshing.csv")
    report.check(again.code == 0 and list(later["step"]) == [s for s in table["step"] if s > at], "tried at the same steps after a restart")


@test
def remesh_effort(report):
    """What remeshing took is told, the bending stiffness is assembled once per epoch and refused mesh, and edges are as long as wanted."""
    folder = OUT / "remesh_effort.log"
    path = strip(nx=10, steps__initial_step=0.1, steps__max_step=0.1, remesh=SIZES, load=[{"type": "line", "group": "tip", "vector": [0, 0, 20.0]}])
    refused = swinging(remesh={"angle": 5.0, "smallest": 0.1, "largest": 1.0, "every": 5, "energy_change": 1e-9, "velocity_change": 0.0})
    for name, case in (("count", path), ("refused", refused)):
        result = solve(f"remesh_effort_{name}", case, 2, ["-log_view", f":{folder}"])
        told, table = result.summary["remeshing"], Table(result.folder / "remeshing.csv")
        report.check(told["count"] == np.sum(table["accepted"]) == result.history["remeshings"][-1], f"{told['count']} remeshings")
        report.check(told["attempts"] == len(table["accepted"]) and told["attempts"] == told["count"] + told["refused"], f"{told['attempts']} attempts")
        assembled = int(re.search(r"^VoileBendAssemble\s+(\d+)", folder.read_text(), re.M).group(1))
        report.check(assembled == 1 + told["attempts"], f"the bending stiffness was assembled {assembled} times")
        report.check(0 < told["fraction"] < 1 and 0 < told["cpu_seconds"] < result.summary["cpu_seconds"], f"{100 * told['fraction']:.0f} % of the time")
        report.check(f"{told['count']} remeshings, {told['refused']} refused" in result.text and "% of its time" in result.text, "said at the end")
        report.check(told[name] >= 2, "there was such a one")
        ratios = [table[f"ratio_{p}"] for p in (1, 50, 99)]
        report.check(np.all(ratios[0] > 0.5) and np.all(np.abs(ratios[1] - 1) < 0.2) and np.all(ratios[2] < 1.5), f"edges over their wanted length: {ratios}")
        low, high = table["wanted_smallest"], table["wanted_largest"]
        keys = case["remesh"]
        report.check(np.all(low <= high) and np.all(low > 0.99 * keys["smallest"]) and np.all(high < 1.01 * keys["largest"]), f"wanted sizes: {low} to {high}")


@test
def remesh_softer(report):
    """In equilibrium a finer mesh that stores more because it is softer is accepted: the potential counts, loads included."""
    # The default element is softer on the coarse mesh, so that the finer one would not be softer.
    case = variant(load_case(BENCHMARKS["pinched_cylinder"].case),
                   {"element": {"type": "six_node"}, "mesh.parameters.n_axial": 12, "mesh.parameters.n_circ": 12,
                    "steps": {"final_load_factor": 0.12, "initial_step": 0.01, "max_step": 0.02},
                    "remesh": {"angle": 10.0, "smallest": 1.0, "largest": 15.0, "energy_change": 0.02}})
    result = solve("remesh_softer", case, 2)
    table = Table(result.folder / "remeshing.csv")
    before, after = (table["membrane" + end] + table["bending" + end] for end in ("_before", ""))
    grown = after / before - 1
    report.check(len(grown) >= 2 and np.all(table["accepted"]), f"{len(grown)} remeshings, all accepted")
    report.check(grown.max() > 0.02, f"stored energy grows by up to {100 * grown.max():.1f} %, more than the bound of 2 %")


@test
def remesh_heated(report):
    """A sheet that is held flat while one side is heated keeps its mesh; free to bend, it gets a finer one."""
    for name, held in (("flat", True), ("bent", False)):
        case = strip("static", nx=10, ny=1, load=None, remesh={"angle": 6.0, "smallest": 0.2, "largest": 2.0, "every": 1, "energy_change": 2.0})
        case["material"] = [{"type": "isotropic", "young": 1.2e6, "poisson": 0.0, "thickness": 0.1, "expansion": 1e-3}]
        case |= {"temperature": [{"difference": "50"}], "steps": {"initial_step": 0.25, "max_step": 0.25}}
        if held:
            case["support"] = [{"type": "clamped", "group": "clamp"}, {"type": "displacement", "group": "plate", "components": ["z"]}]
        h = solve(f"remesh_heated_{name}", {k: v for k, v in case.items() if v is not None}).history
        report.check((h["vertices"][-1] > h["vertices"][0]) != held, f"{name}: {h['vertices'][0]:.0f} vertices, {h['vertices'][-1]:.0f} at the end")


@test
def remesh_keeps(report):
    """Probes at points keep their vertex, supports hold new vertices, and a support releases of them."""
    case = swinging()
    case["support"].append({"type": "displacement", "group": "tip", "components": ["y"], "release": 0.45})
    result = solve("remesh_keeps", case, 2)
    steps = list(Results(result.folder))
    report.check(result.history["remeshings"][-1] >= 1 and len({len(s["displacement"]) for s in steps}) > 1, "remeshed")
    report.check("support(s) hold" in result.text, "a support releases")
    started_at = steps[0].mesh.positions
    probe = started_at[np.linalg.norm(started_at - [5, 0.5, 0], axis=1).argmin()]
    for step in (steps[0], steps[-1]):
        at = step.mesh.positions
        report.below(np.abs(step["displacement"][at[:, 0] < 1e-9]).max(), 1e-14, "the clamped edge stays")
        place = np.linalg.norm(at - probe, axis=1)
        report.check(place.min() == 0.0, "the vertex of the probe is there, bit by bit")
        report.near(step["displacement"][place.argmin(), 2], at_steps(result.history, "middle_z")[step.number], 1e-9, "and has its value")


@test
def remesh_forces(report):
    """Pressure that follows the sheet and springs along an edge act on new meshes as on a uniform fine one."""
    forces = {"load": [{"type": "follower_pressure", "group": "plate", "magnitude": 0.02}],
              "spring": [{"type": "line", "group": "tip", "stiffness": 0.05, "direction": [0, 0, 1]}]}
    fine = solve("remesh_forces_fine", strip(nx=80, ny=8, **forces), 1)
    result = solve("remesh_forces", strip(nx=10, remesh=SIZES, **forces), 2)
    report.check(result.history["remeshings"][-1] >= 1, f"{result.history['vertices'][-1]:.0f} vertices instead of {fine.summary['vertices']}")
    for name in ("tip_x", "tip_z"):
        report.percent(result.history[name][-1] / fine.history[name][-1], 0.01, f"{name}: {fine.history[name][-1]:.4g}")


FIELD = """View "size" {
ST(0, 0, 0, 10, 0, 0, 10, 1, 0){%s, %s, %s};
ST(0, 0, 0, 10, 1, 0, 0, 1, 0){%s, %s, %s};
};
"""


@test
def remesh_background(report):
    """A size field of Gmsh gives the mesh that the same expression gives, in the unit and place of the mesh file."""
    keys = {"angle": 20.0, "smallest": 0.05, "largest": 0.5, "every": 1}
    still = {"load": [], "time__end": 0.02}
    meshes = {}
    (OUT / "remesh_background.pos").write_text(FIELD % ((0.1, 0.4, 0.4) + (0.1, 0.4, 0.1)))
    (OUT / "remesh_background_mm.pos").write_text(FIELD.replace("10", "10000").replace("1,", "1000,") % ((100, 400, 400) + (100, 400, 100)))
    (OUT / "remesh_background_half.pos").write_text(FIELD.replace("10", "5") % ((0.1, 0.25, 0.25) + (0.1, 0.25, 0.1)))
    for name, change in {"expression": {"size": "0.1 + 0.03*x"}, "field": {"background": "remesh_background.pos"},
                         "half": {"background": "remesh_background_half.pos"}, "half_said": {"size": "0.1 + 0.03*min(x, 5)"}}.items():
        done = solve(f"remesh_background_{name}", swinging(remesh=keys | change, **still), 2 if name == "field" else 1)
        report.check(done.code == 0 and done.history["remeshings"][-1] >= 1, f"{name}: code {done.code}")
        meshes[name] = list(Results(done.folder))[-1]["displacement"]
    report.check(meshes["field"].shape == meshes["expression"].shape and len(meshes["field"]) > 60,
                 f"the same meshes: {len(meshes['field'])} and {len(meshes['expression'])} vertices")
    report.check(meshes["half"].shape == meshes["half_said"].shape and len(meshes["half"]) > len(meshes["field"]),
                 f"beyond the field its nearest node counts: {len(meshes['half'])} and {len(meshes['half_said'])} vertices")
    moved = swinging(remesh=keys | {"background": "remesh_background_mm.pos"}, **still)
    moved["mesh"] |= {"scale": 1e-3, "translate": [5.0, 0.0, 2.0], "rotate": [0.0, 0.0, 90.0],
                      "parameters": moved["mesh"]["parameters"] | {"length": 1e4, "width": 1e3}}
    moved.pop("probe")
    done = solve("remesh_background_moved", moved, 1)
    count = int(done.history["vertices"][-1])
    report.check(abs(count - len(meshes["field"])) <= 0.02 * count, f"in millimetres and elsewhere: {count} vertices")
    (OUT / "remesh_background_flat.pos").write_text('View "size" {\nST(0, 0, 0, 10, 0, 0, 5, 0, 0){0.2, 0.2, 0.2};\nSL(0, 1, 0, 0, 1, 0){0.2, 0.2};\n};\n')
    done = solve("remesh_background_flat", swinging(remesh=keys | {"background": "remesh_background_flat.pos"}, **still), 1)
    report.check(done.code == 0 and done.history["remeshings"][-1] >= 1, f"of elements without area or length the nodes count: code {done.code}")
    for number, (words, text) in enumerate((("there is no such file", None), ("0 views", "// nothing\n"), ("positive length", FIELD % ((0.1,) * 5 + (0,))),
                                            ("of the kind VT", FIELD.replace("ST", "VT") % ((0.1,) * 6)), ("System", 'System "true";\n'),
                                            ("no elements", 'View "size" {\n};\n'), ("2 time steps", 'View "size" {\nSP(0, 0, 0){1, 0.1};\n};\n'), ("Gmsh", 'View "size" {\nST(0, 0'))):
        if text is not None:
            (OUT / f"remesh_background_{number}.pos").write_text(text)
        file = write_case(swinging(remesh=keys | {"background": f"remesh_background_{number}.pos"}), OUT / f"remesh_background_{number}.toml")
        for code, said in (invoke(["check", file]), invoke(["run", file, "--output", fresh("remesh_background_wrong")], 2)):
            report.check(code == 2 and words in said, f"code {code}: {said.strip().splitlines()[-1][:140]}")


TWO_PLATES = """h = 0.05;
For k In {0 : 2}
  Point(1 + k) = {0.5 * k, 0, 0, h};
  Point(4 + k) = {0.5 * k, 0.2, 0, h};
EndFor
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 6}; Line(4) = {6, 5}; Line(5) = {5, 4}; Line(6) = {4, 1}; Line(7) = {2, 5};
Curve Loop(1) = {1, 7, 5, 6}; Curve Loop(2) = {2, 3, 4, -7};
Plane Surface(1) = {1}; Plane Surface(2) = {2};
Physical Surface("a") = {1}; Physical Surface("b") = {2};
Physical Curve("clamp") = {6}; Physical Curve("tip") = {3};
Mesh.Algorithm = 6;
"""


@test
def remesh_outlook(report):
    """What `check` says comes true: frozen triangles neither ask for a mesh nor are counted otherwise than they are, `max_vertices` holds, a drape is looked at when it rests."""
    (OUT / "remesh_outlook.geo").write_text(TWO_PLATES)

    def told(name, analysis="static", load=0.05, **keys):
        case = strip(analysis, mesh={"file": str(OUT / "remesh_outlook.geo")}, load=[{"type": "line", "group": "tip", "vector": [0, 0, load]}],
                     material=[{"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 0.01, "density": 100.0}],
                     steps__initial_step=0.1, steps__max_step=0.1, remesh={"angle": 10.0, "smallest": 0.01, "largest": 0.1} | keys)
        file = write_case(case, OUT / f"remesh_outlook_{name}.toml")
        said = next(line for line in invoke(["check", file])[1].splitlines() if line.startswith("remeshing:"))
        return said, run(file, fresh(f"remesh_outlook_{name}"), 2)

    said, done = told("all", frozen=["a", "b"])
    report.check("suits the start" in said and done.code == 0 and "remeshed:" not in done.text and done.history["remeshings"][-1] == 0,
                 "where all is frozen nothing is remeshed: " + said)
    for name, keys in {"boundary": {}, "half": {"frozen": ["b"]}, "bound": {"size": "0.02", "max_vertices": 300},
                       "half_bound": {"size": "0.02", "max_vertices": 250, "frozen": ["b"]}}.items():
        said, done = told(name, **keys)
        count, first = int(re.search(r"about (\d+)", said)[1]), Table(done.folder / "remeshing.csv")["vertices"][0]
        report.check(done.code == 0 and 0.75 < first / count < 1.25, f"{name}: about {count} vertices, {first:.0f}")
        if most := keys.get("max_vertices"):
            report.check(max(done.history["vertices"][1:]) < 1.25 * most, f"{name}: up to {max(done.history['vertices'][1:]):.0f} vertices, {most} wanted at most")
    said, done = told("later", load=0.4, angle=4.0, size="x > 0.5 ? 0.01 : 1", growth=10.0, frozen=["b"])
    vertices = done.history["vertices"]
    report.check(done.code == 0 and vertices[-1] > 1.2 * vertices[1], f"frozen cells that are too long do not keep others from getting shorter: {vertices[1]:.0f} to {vertices[-1]:.0f} vertices")
    said, done = told("drape", "drape", frozen=["b"])
    report.check("at once" not in said and "come to rest" in said, "a drape: " + said)


@test
def remesh_mistakes(report):
    """What cannot be remeshed ends with code 2 and names the key."""
    tip_force = {"type": "point", "group": "tip", "vector": [0, 0, 1.0]}
    for number, (words, case) in enumerate((
            ("[remesh]: nothing is remeshed with analysis", strip("modal", time=None, remesh=SIZES)),
            ("the published elements", strip(remesh=SIZES, element={"type": "sze_zhou_2016"})),
            ("frozen: 'nowhere'", strip(remesh=SIZES | {"frozen": ["nowhere"]})),
            ("smallest", strip(remesh=SIZES | {"smallest": 0.6})),
            ("size", strip(remesh=SIZES | {"size": "0.1 + "})),
            ("size", strip(remesh=SIZES | {"size": "0.1*w"})),
            ("a positive length is needed everywhere", strip(remesh=SIZES | {"size": "0.5 - 0.1*x"})),
            ("the sizes ask for a mesh of about", strip(remesh=SIZES | {"size": "1e-4"})),
            ("velocity_change", strip(remesh=SIZES | {"velocity_change": 0.6})),
            ("background", strip(remesh=SIZES | {"background": "field.msh"})),
            ("[[load]] of type point", strip(remesh=SIZES, load=[tip_force])))):
        file = write_case(case, OUT / f"remesh_mistake_{number}.toml")
        for ranks in (1, 2):
            result = run(file, fresh("remesh_mistake"), ranks)
            report.check(result.code == 2 and words in result.text, f"{ranks} rank(s), code {result.code}: {result.text.splitlines()[-1][:110]}")
        report.check(invoke(["check", file])[0] == 2, "and `check` says so too")
    plain = write_case(strip(), OUT / "remesh_mistake_plain.toml")
    report.check("remeshing: edges of" in invoke(["check", plain, "--set", "remesh.smallest=0.1"])[1], "--set switches the section on")
    later = staged([stage("first", "static"), stage("second", "static", remesh=SIZES)], load=[tip_force])
    result = run(write_case(later, OUT / "remesh_mistake_later.toml"), fresh("remesh_mistake_later"), 1)
    report.check(result.code == 2 and "stage 'second': " in result.text and not (result.folder / "first").exists(), "of a later stage before the first")


@test
def remesh_ranks(report):
    """A sheet that falls on a sphere gets the same meshes bit by bit on 1, 2 and 3 ranks, since sizes do not see the last digits, and keeps its energy."""
    free, radius, side = 2e-3, 0.06, 0.2
    case = {"title": "A sheet falls on a sphere", "analysis": "dynamic",
            "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": side, "n": 10, "pattern": 2}},
            "material": [{"type": "isotropic", "young": 2e6, "poisson": 0.3, "thickness": 0.4e-3, "density": 400}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "contact": {"distance": 1e-3, "stiffness": 1e4, "friction": 0.1},
            "obstacle": [{"name": "sphere", "type": "sphere", "point": [0.12, 0.1, -free - radius], "radius": radius}],
            "damping": {"mass": 1.0}, "time": {"end": 0.1, "step": 4e-3, "velocity_tolerance": 1e-5},
            "remesh": {"smallest": 0.008, "largest": 0.02, "every": 3, "velocity_change": 0.5}, "output": {"every": 1, "fields": ["displacement"]}}
    first = None
    for ranks in (1, 2, 3):
        result = solve(f"remesh_ranks_{ranks}", case, ranks)
        steps = {s.number: (s.mesh.positions, s.mesh.triangles) for s in Results(result.folder)}
        report.check(result.history["remeshings"][-1] >= 2, f"{ranks} rank(s): {result.history['remeshings'][-1]:.0f} remeshings")
        first = first or steps
        report.check(steps.keys() == first.keys() and all(np.array_equal(a, b) for n in steps for a, b in zip(steps[n], first[n])),
                     f"{ranks} rank(s): the same meshes as on one, bit by bit")
        table = Table(result.folder / "remeshing.csv")
        before, after = (sum(np.array(table[p + end]) for p in ("membrane", "bending", "contact", "kinetic")) for end in ("_before", ""))
        report.below(np.abs(after / before - 1).max(), 1e-9, f"{ranks} rank(s): energy")
        report.check(1e-3 < np.abs(table["velocity_factor"] - 1).max() < 0.4, f"{ranks} rank(s): by velocities times {table['velocity_factor']}")
