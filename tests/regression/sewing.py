"""Garments: flat panels that are sewn together, as texture coordinates of an OBJ file."""

import numpy as np
from common import fresh
from harness import OUT, solve, test
from pattern_files import part
from results import Results
from solver import invoke, run, write_case

RADIUS, HEIGHT = 0.2, 0.3


def tube_file(name, place, around=48, up=8, unit=0.01, texture=lambda u, v, panel: (u, v), wrong=None):
    """An OBJ file of a tube sewn from one panel of 2 pi RADIUS x HEIGHT: place(angle, z) puts its vertices, `unit` is that of the
    texture coordinates [m]; texture(u, v, panel) changes them, of the first half or the second. `wrong`: changes the lines of the
    file."""
    lines = []
    panel = lambda i, j: (2 * np.pi * RADIUS * i / around / unit, HEIGHT * j / up / unit)  # noqa: E731
    for j in range(up + 1):
        lines += ["v {:.15g} {:.15g} {:.15g}".format(*place(2 * np.pi * i / around, HEIGHT * j / up)) for i in range(around)]
    count = 0
    for j in range(up):
        for i in range(around):
            for corners in (((i, j), (i + 1, j), (i + 1, j + 1)), ((i, j), (i + 1, j + 1), (i, j + 1))):
                lines += ["vt {:.12g} {:.12g}".format(*texture(*panel(*c), int(i >= around // 2))) for c in corners]
                lines.append("f " + " ".join(f"{c[1] * around + c[0] % around + 1}/{count + k + 1}" for k, c in enumerate(corners)))
                count += 3
    # Edges at the front and the back, to hold the tube by.
    for group, i in (("front", 0), ("back", around // 2)):
        lines += [f"g {group}", f"l {i + 1} {around + i + 1}"]
    lines += ["g lower", "l " + " ".join(str(i % around + 1) for i in range(around + 1))]
    if wrong:
        lines = wrong(lines)
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / name).write_text("\n".join(lines) + "\n")
    return str(OUT / name)


def ellipse(angle, z):
    return np.array([1.1 * RADIUS * np.cos(angle), 0.9 * RADIUS * np.sin(angle), z])


def tube(file, **changes):
    """Held against rigid motions only."""
    return {"analysis": "drape", "mesh": {"file": file, "rest": "texture", "texture_unit": 0.01},
            "material": [{"type": "orthotropic", "young_1": 1e6, "young_2": 1e6, "poisson_12": 0.0, "shear_12": 5e5, "thickness": 2e-3, "density": 300.0, "direction": [1, 0, 0]}],
            "support": [{"type": "displacement", "group": "front", "components": ["x", "y"]},
                        {"type": "displacement", "group": "back", "components": ["y"]},
                        {"type": "displacement", "group": "lower", "components": ["z"]}],
            "probe": [{"name": "energy", "type": "energy"}]} | changes


def fields(result, *names):
    last = Results(result.folder)[-1]
    return [last[name] for name in names]


@test
def sewn_tube(report):
    """A flat panel sewn into a tube that starts as an ellipse: it becomes the cylinder of its length, whose energy is known."""
    bending = np.pi * HEIGHT / RADIUS * 1e6 * 2e-3**3 / 12
    file = tube_file("tube.obj", ellipse)
    for ranks in (1, 2, 3):
        result = solve(f"sewn_tube_{ranks}", tube(file), ranks)
        h = result.history
        report.percent(h["energy_bending"][-1] / bending, 0.005, f"{ranks} rank(s): bending energy")
        report.below(h["energy_membrane"][-1] / bending, 0.01, f"{ranks} rank(s): energy of the membrane, in bending energies")
        place = Results(result.folder)[-1].positions
        centre = place[:, :2].mean(axis=0)
        radius = np.linalg.norm(place[:, :2] - centre, axis=1)
        report.below(np.abs(radius / RADIUS - 1).max(), 0.004, f"{ranks} rank(s): radius, relative")
        report.near(h["largest_turn"][-1], 2 * np.pi / 48, 1e-3, f"{ranks} rank(s): largest turn from cell to cell")
        curvature, = fields(result, "curvature")
        report.percent(-curvature[:, 0].mean() * RADIUS, 0.005, f"{ranks} rank(s): curvature along the panel's u")
        report.below(np.abs(curvature[:, 1]).max() * RADIUS, 1e-2, f"{ranks} rank(s): curvature across, in 1/radius")
    # A start of its own: the same cylinder.
    start = tube_file("tube_start.obj", lambda a, z: RADIUS * np.array([1.1 - 1.05 * (1 - np.cos(a)), 0.95 * np.sin(a), z / RADIUS]))
    result = solve("sewn_tube_start", tube(file, mesh={"file": file, "start": start, "rest": "texture", "texture_unit": 0.01}), 2)
    report.percent(result.history["energy_bending"][-1] / bending, 0.005, "with a start of its own: bending energy")
    # Pressure inside: the path begins in the equilibrium without it.
    pressure = tube(file, analysis="static", load=[{"type": "follower_pressure", "magnitude": 20.0}], steps={"initial_step": 0.5, "max_step": 0.5})
    result = solve("sewn_tube_pressure", pressure, 2)
    report.percent(fields(result, "membrane_force")[0][:, 0].mean() / (20.0 * RADIUS), 0.02, "under pressure: hoop force along the panel's u")
    report.check("of flat panels; 8 edges are seams" in result.text, "a note counts the seams")


@test
def sewn_motion(report):
    """Panels in motion: a tube is let go as an ellipse; a restart goes on to the same state."""
    file = tube_file("tube_motion.obj", ellipse, 24, 4)
    case = tube(file, analysis="dynamic", time={"end": 0.04, "step": 0.002, "checkpoint_steps": 10})
    whole = solve("sewn_motion", case, 2)
    energy = whole.history["kinetic_energy"] + whole.history["energy_membrane"] + whole.history["energy_bending"]
    report.below(energy.max() / energy[0] - 1, 0.01, "energy, relative to that of the start")
    report.check(whole.history["kinetic_energy"].max() > 0.01 * energy[0], "it moves")
    half = solve("sewn_motion_half", case | {"time": case["time"] | {"end": 0.02}}, 1)
    rest = solve("sewn_motion_rest", case, 3, ["--restart", str(half.folder / "checkpoint.h5")])
    report.below(np.abs(rest.displacement() - whole.displacement()).max(), 1e-9, "after a restart: difference [m]")
    for what, mesh in (("texture_unit", case["mesh"] | {"texture_unit": 0.011}), ("rest", {"file": file})):
        other = run(write_case(case | {"mesh": mesh}, OUT / "sewn_other.toml"), OUT / "sewn_other", 1, ["--restart", str(half.folder / "checkpoint.h5")])
        report.check(other.code == 2 and "its rest shape is another" in other.text, f"another {what}: code {other.code}")


@test
def sewn_wrongly(report):
    """Texture coordinates that are no panels: each mistake is named with file, key and remedy."""
    def refused(what, mesh, *words, **changes):
        code, text = invoke(["check", write_case(tube(mesh["file"], mesh=mesh, **changes), OUT / "sewn_wrong.toml")], 2)
        report.check(code == 2 and all(w in text for w in words), f"{what}: code {code}: {' '.join(text.split())[:300]}")

    key = {"rest": "texture", "texture_unit": 0.01}
    good = tube_file("tube.obj", ellipse)
    code, text = invoke(["check", write_case(tube(good), OUT / "sewn_good.toml")], 2)
    report.check(code == 0, f"the tube itself: code {code}")
    plain = lambda lines: [" ".join(w.split("/")[0] for w in x.split()) for x in lines if not x.startswith("vt")]  # noqa: E731
    refused("no texture", {"file": tube_file("tube_plain.obj", ellipse, wrong=plain)} | key, "tube_plain.obj", "[mesh] rest", "no texture", "remove the key")
    partly = lambda lines: [x if k % 40 != 35 else " ".join(w.split("/")[0] for w in x.split()) for k, x in enumerate(lines)]  # noqa: E731
    refused("some faces without", {"file": tube_file("tube_partly.obj", ellipse, wrong=partly)} | key, "have no texture coordinates", "the first is")
    refused("no area", {"file": tube_file("tube_line.obj", ellipse, texture=lambda u, v, panel: (u, 0.0))} | key, "[mesh] rest", "no area in their texture")
    refused("another unit", {"file": good} | key | {"texture_unit": 1.0}, "texture_unit = 1 is wrong, with 0.01", "times the area")
    refused("mirrored", {"file": tube_file("tube_mirrored.obj", ellipse, texture=lambda u, v, panel: (-u, v))} | key, "[mesh] rest", "mirrored", "normals of the mesh")
    half = lambda u, v, panel: (-u if panel else u, v)  # noqa: E731
    refused("half of it mirrored", {"file": tube_file("tube_half.obj", ellipse, texture=half)} | key, "384 of 768", "mirror those panels")
    refused("one panel in another scale", {"file": tube_file("tube_scale.obj", ellipse, texture=lambda u, v, panel: ((1 + 4 * panel) * u, (1 + 4 * panel) * v))} | key, "factor of", "scale of the two panels")
    refused("a unit without panels", {"file": good, "texture_unit": 0.01}, "texture_unit", 'rest = "texture"')
    refused("a linear solution", {"file": good} | key, "rest", "static", analysis="linear")


@test
def sewn_folded_edge(report):
    """The halves of an edge, sewn to each other with the piece lying flat: the middles between their nodes are all one point before
    it is folded."""
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "folded.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" viewBox="0 0 200 100">'
                                    '<path id="p" d="M 0 0 L 100 0 L 200 0 L 200 100 L 100 100 L 0 100 Z"/></svg>\n')
    case = {"panel": [{"file": str(OUT / "folded.svg"), "name": "p", "size": 0.02, "up_axis": "z"}],
            "seam": [{"name": "edge", "edges": ["p/0"], "to": ["p/1"], "meet": ["p@0", "p@2"]}],
            "material": [{"type": "isotropic", "young": 5e7, "poisson": 0.3, "thickness": 5e-5, "density": 900.0}],
            "contact": {"distance": 5e-4, "stiffness": 1e4}, "damping": {"mass": 20.0}, "output": {"every": 1000},
            "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 1.0, "step": 5e-3}},
                      {"name": "rest", "analysis": "dynamic", "time": {"end": 1.1, "step": 5e-3, "velocity_tolerance": 3e-3}}]}
    result = solve("sewn_folded_edge", case)
    stages = result.summary["stages"]
    report.check(result.summary["converged"] and stages[0]["vertices"] - stages[1]["vertices"] == 5, "five pairs of nodes are welded")
    report.check(all(part(result, s["name"]).history["intersections"].max() == 0 for s in stages), "nothing intersects")


@test
def sewn_from_next(report):
    """The stage after sewing with self-contact begins from its checkpoint as it does in one run: the mesh is another one by then."""
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "half.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="300mm" viewBox="0 0 200 300">'
                                  '<path id="back" d="M0,300 L200,300 L200,0 L0,0 Z"/></svg>')
    piece = {"file": str(OUT / "half.svg"), "size": 0.03}
    case = {
        "panel": [piece | {"name": "a"}, piece | {"name": "b", "translate": [0.21, 0, 0]}],
        "seam": [{"name": "s", "edges": ["a/1"], "to": ["b/3"], "meet": ["a@1", "b@0"]}],
        "material": [{"type": "fabric", "fabric": "wool_tropical", "texture_direction": [0, 1]}],
        "support": [{"group": "a/2", "type": "hinged"}], "load": [{"type": "gravity", "vector": [0, 0.5, -9.81]}], "contact": {},
        "stage": [{"name": "sew", "analysis": "dynamic", "sew": ["all"], "time": {"end": 0.8}}, {"name": "next", "analysis": "dynamic", "time": {"end": 0.82}}]}
    file, folder = write_case(case, OUT / "sewn_from_next.toml"), fresh("sewn_from_next")
    code, text = invoke(["run", file, "--output", folder])
    report.check(code == 0, "both stages" + text[-300:] * (code != 0))
    history = (folder / "next" / "history.csv").read_text().splitlines()[-1].split(",")
    for ranks in (1, 2):
        code, text = invoke(["run", file, "--output", folder, "--from", "next", "--overwrite"], ranks)
        again = (folder / "next" / "history.csv").read_text().splitlines()[-1].split(",")
        report.check(code == 0, f"from the second on {ranks}" + text[-300:] * (code != 0))
        report.percent(float(again[1]) / 0.82, 1e-12, "to the same time")
        if ranks == 1:  # on other ranks a step may be cut where the iteration stalls
            report.percent(float(again[9]) / float(history[9]), 1e-12, "kinetic energy at the end")
