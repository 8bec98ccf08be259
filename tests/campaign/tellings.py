#!/usr/bin/python3
"""Random problems, each told in several ways that must have one answer.

    tests/campaign/tellings.py              forty problems, about 15 CPU minutes
    tests/campaign/tellings.py 200 260      those with these numbers

A problem is a jittered sheet with random materials, supports, loads, temperatures and analysis. It is told turned and moved, in a
mirror, in other units, with other numbers of vertices and triangles, on more ranks, with its surface in two groups, its loads in
two halves, and as a stage. Exit codes must agree, displacements, reactions, energies and frequencies to 1e-6; where a doubly
curved sheet gets other corners to 2e-3, since fits of curvature depend on them. Exit code 1 if anything differs.
"""

import math
import random
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "regression"), str(ROOT / "runs" / "lib")]

from harness import OUT  # noqa: E402
from solver import run, write_case  # noqa: E402

FOLDER = OUT / "campaign" / "tellings"


@dataclass
class Quantity:
    """A number or list with powers of mass, length and time; `kind` is how it turns: scalar, vector, point, shear (the third
    number changes its sign in a mirror) or sense (an angle about the normal)."""

    value: object
    mass: int = 0
    length: int = 0
    time: int = 0
    kind: str = "scalar"


@dataclass
class Linear:
    """The expression a + b.x of the place x [m]."""

    a: float
    b: list


def pressure(value, kind="scalar"):
    return Quantity(value, 1, -1, -2, kind)


def force(value, per_length=0, kind="vector"):
    return Quantity(value, 1, 1 - per_length, -2, kind)


@dataclass
class Telling:
    turn: np.ndarray = None
    shift: np.ndarray = None
    units: tuple = (("m", 1.0), ("kg", 1.0), ("s", 1.0))
    ranks: int = 1
    numbers: int = 0
    split: bool = False
    halves: bool = False
    stage: bool = False

    def __post_init__(self):
        self.turn = np.eye(3) if self.turn is None else self.turn
        self.shift = np.zeros(3) if self.shift is None else self.shift
        self.mirrored = np.linalg.det(self.turn) < 0

    def unit(self, mass, length, time):
        return self.units[1][1] ** mass * self.units[0][1] ** length * self.units[2][1] ** time

    def tell(self, x):
        """Everything of a case as this telling writes it."""
        if isinstance(x, dict):
            return {key: self.tell(value) for key, value in x.items()}
        if isinstance(x, list):
            return [self.tell(value) for value in x]
        if isinstance(x, Linear):
            b = self.turn @ np.array(x.b, float)
            a, b = x.a - b @ self.shift, b * self.unit(0, 1, 0)
            return f"({a!r}) + ({b[0]!r})*x + ({b[1]!r})*y + ({b[2]!r})*z"
        if not isinstance(x, Quantity):
            return x
        value, sign, unit = np.array(x.value, float), -1 if self.mirrored else 1, self.unit(x.mass, x.length, x.time)
        if x.kind == "vector":
            value = self.turn @ value
        if x.kind == "sense":
            value = sign * value
        if x.kind == "shear" and value.shape == (3,):
            value = value * [1, 1, sign]
        if x.kind == "shear" and value.shape == (3, 3):
            value = value * np.outer([1, 1, sign], [1, 1, sign])
        return (value / unit).tolist()


def mesh_of(chance):
    """A jittered rectangle over one of several surfaces: places, triangles, their halves, curves and points by name."""
    nx, ny, shape, jitter = chance.choice([6, 8, 10]), chance.choice([4, 6]), chance.choice(["flat", "flat", "cylinder", "dome", "saddle"]), chance.choice([0.0, 0.2])
    places = []
    for y in np.linspace(0, 0.6, ny + 1):
        for i, x in enumerate(np.linspace(0, 1, nx + 1)):
            inside = 0 < i < nx and 0 < y < 0.6
            x += chance.uniform(-jitter, jitter) / nx if inside and i != nx // 2 else 0
            places.append([x, y + (chance.uniform(-jitter, jitter) * 0.6 / ny if inside else 0), 0])
    places = np.array(places)
    along, across = places[:, 0] * (1 - places[:, 0]), places[:, 1] * (0.6 - places[:, 1])
    places[:, 2] = {"flat": 0 * along, "cylinder": 0.3 * along, "dome": 0.3 * along + 0.2 * across, "saddle": 0.2 * along - 0.3 * across}[shape]
    at = lambda i, j: j * (nx + 1) + i  # noqa: E731
    triangles, half = [], []
    for j in range(ny):
        for i in range(nx):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [(a, b, c), (a, c, d)] if chance.random() < 0.5 else [(a, b, d), (b, c, d)]
            half += ["A" if i < nx // 2 else "B"] * 2
    curves = {"left": [(at(0, j), at(0, j + 1)) for j in range(ny)], "right": [(at(nx, j), at(nx, j + 1)) for j in range(ny)],
              "bottom": [(at(i, 0), at(i + 1, 0)) for i in range(nx)], "mid": [(at(nx // 2, j), at(nx // 2, j + 1)) for j in range(ny)]}
    return shape, places, triangles, half, curves, {"p": at(nx // 2 + 1, ny // 2), "q": at(nx, ny)}


def write_mesh(file, mesh, telling):
    _, places, triangles, half, curves, points = mesh
    x = (places @ telling.turn.T + telling.shift) / telling.unit(0, 1, 0)
    chance, order, rows = random.Random(telling.numbers), list(range(len(x))), list(range(len(triangles)))
    if telling.numbers:
        chance.shuffle(order)
        chance.shuffle(rows)
    number = {v: k + 1 for k, v in enumerate(order)}
    names, elements = {}, []
    tag = lambda dimension, name: names.setdefault((dimension, name), len(names) + 1)  # noqa: E731
    elements += [(15, tag(0, name), [v]) for name, v in points.items()]
    elements += [(1, tag(1, name), [a, b]) for name, sides in curves.items() for a, b in sides]
    for k in rows:
        a, b, c = triangles[k][::-1] if telling.mirrored else triangles[k]
        first = chance.randrange(3) if telling.numbers else 0
        elements.append((2, tag(2, half[k]), [a, b, c][first:] + [a, b, c][:first]))
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", len(names), *(f'{d} {k} "{name}"' for (d, name), k in names.items()),
             "$EndPhysicalNames", "$Nodes", len(x), *("{} {:.17g} {:.17g} {:.17g}".format(number[v], *x[v]) for v in order), "$EndNodes", "$Elements", len(elements),
             *(f"{k + 1} {kind} 2 {t} {t} " + " ".join(str(number[v]) for v in vertices) for k, (kind, t, vertices) in enumerate(elements)), "$EndElements"]
    file.write_text("\n".join(map(str, lines)) + "\n")


def material(chance, heated):
    kind = chance.choice(["isotropic", "orthotropic", "laminate", "matrices"])
    m = {"type": kind, "direction": Quantity(chance.choice([[1, 0.2, 0], [0.3, 1, 0]]), kind="vector")}
    if kind == "isotropic":
        m |= {"young": pressure(2e6), "poisson": chance.choice([0.0, 0.3]), "thickness": Quantity(0.02, length=1), "density": Quantity(1000.0, 1, -3)}
        m |= {"expansion": 1e-4} if heated else {}
    if kind == "orthotropic":
        m |= {"young_1": pressure(5e6), "young_2": pressure(1e6), "poisson_12": 0.25, "shear_12": pressure(6e5), "thickness": Quantity(0.02, length=1), "density": Quantity(800.0, 1, -3)}
    if kind == "laminate":
        m |= {"young_1": pressure(1e7), "young_2": pressure(1e6), "poisson_12": 0.3, "shear_12": pressure(5e5), "density": Quantity(900.0, 1, -3),
              "angles": Quantity(chance.choice([[30.0, -45.0], [0.0, 90.0], [20.0, 60.0, 20.0]]), kind="sense"), "ply_thicknesses": Quantity([0.01], length=1)}
    if kind in ("orthotropic", "laminate") and heated:
        m |= {"expansion_1": 2e-5, "expansion_2": 2e-4}
    if kind == "matrices":
        m |= {"membrane": force([[5e4, 1e4, 2e3], [1e4, 3e4, -1e3], [2e3, -1e3, 1.2e4]], 1, "shear"), "areal_density": Quantity(15.0, 1, -2),
              "bending": Quantity([[2.0, 0.4, 0.1], [0.4, 1.5, -0.2], [0.1, -0.2, 0.6]], 1, 2, -2, "shear")}
        m |= {"expansion_strain": Quantity([1e-4, 3e-5, 4e-5], kind="shear")} if heated else {}
    if chance.random() < 0.3:
        m |= {"prestress": force([40.0, 60.0, 10.0], 1, "shear")}
    return m


def load(chance, analysis):
    kind = chance.choice(["point", "line", "pressure", "area", "gravity"] + (["follower_pressure"] if analysis in ("static", "dynamic") else []))
    way = [chance.uniform(-1, 1) for _ in range(3)]
    given = {"point": {"group": "p", "vector": force([8 * w for w in way])}, "line": {"group": chance.choice(["right", "mid"]), "vector": force([10 * w for w in way], 1)},
             "area": {"vector": pressure([20 * w for w in way], "vector")}, "gravity": {"vector": Quantity(way, 0, 1, -2, "vector")}}
    one = {"type": kind} | given.get(kind, {"magnitude": pressure(20 * way[0])})
    if kind in ("line", "area", "pressure", "follower_pressure") and chance.random() < 0.4:
        one["distribution"] = Linear(1.0, [0.5, -0.3, 0.2])
    return one | ({"constant": True} if chance.random() < 0.2 and analysis != "linear" else {})


def problem(number):
    chance = random.Random(number)
    analysis, heated = chance.choice(["static", "static", "linear", "modal", "buckling", "dynamic", "harmonic"]), chance.random() < 0.3
    mesh, materials = mesh_of(chance), [material(chance, heated) for _ in range(chance.choice([1, 2]))]
    if len(materials) > 1:
        materials[0]["groups"] = ["A"]
    case = {"analysis": analysis, "material": materials, "load": [load(chance, analysis) for _ in range(chance.choice([1, 2]))],
            "support": [{"type": chance.choice(["clamped", "hinged"]), "group": "left"}],
            "probe": [{"name": name, "type": "displacement", "group": group} for name, group in (("up", "p"), ("ur", "right"))] + [{"name": "ra", "type": "reaction", "group": "left"}]}
    case["support"] += chance.choice([[], [{"type": "hinged", "group": "right"}], [{"type": "sliding", "group": "bottom"}], [{"type": "hinged", "group": "q"}]])
    if heated:
        case["temperature"] = [{"change": Linear(20.0, [10.0, -5.0, 0.0])} | ({"difference": Linear(10.0, [0.0, 20.0, 0.0])} if chance.random() < 0.5 and all(m["type"] != "matrices" for m in materials) else {})]
    if chance.random() < 0.3:
        case["mass"] = [{"group": chance.choice(["p", "q"]), "mass": Quantity(0.2, 1)}]
    if chance.random() < 0.3:
        case["spring"] = [{"type": "line", "group": "right", "stiffness": Quantity(100.0, 1, -1, -2)} | ({"direction": Quantity([0.2, 0.3, 1], kind="vector")} if chance.random() < 0.5 else {})]
    case |= {"static": {"steps": {"initial_step": 0.5, "control": chance.choice(["load", "arc_length"])}}, "modal": {"eigen": {"modes": 4, "load_factor": chance.choice([0.0, 1.0])}},
             "buckling": {"eigen": {"modes": 3}}, "dynamic": {"time": {"end": Quantity(0.1, time=1), "step": Quantity(0.01, time=1)}},
             "harmonic": {"harmonic": {"method": "direct", "frequencies": Quantity([0.2, 1.0, 3.0], time=-1)}, "damping": {"bending": Quantity(0.002, time=1)}}}.get(analysis, {})
    return case, mesh


def in_two(case):
    """Loads, temperatures and materials of the surface by its halves."""
    for key in ("load", "temperature"):
        for one in list(case.get(key, [])):
            if key == "temperature" or one["type"] in ("area", "pressure", "follower_pressure"):
                one["group"] = "A"
                case[key].append(one | {"group": "B"})
    materials = case["material"]
    case["material"] = [materials[0] | {"groups": ["A"]}, materials[-1] | {"groups": ["B"]}]


def told(case, mesh, telling, name):
    """Exit code and answers, in SI units and the first frame."""
    case = {key: [dict(one) for one in value] if isinstance(value, list) else value for key, value in case.items()}
    if telling.split:
        in_two(case)
    if telling.halves:
        halves = [one | {key: Quantity((0.5 * np.array(one[key].value)).tolist(), one[key].mass, one[key].length, one[key].time, one[key].kind)}
                  for one in case["load"] for key in ("vector", "magnitude") if key in one]
        case["load"] = [dict(one) for one in halves for _ in range(2)]
    case = telling.tell(case) | {"units": dict(zip(("length", "mass", "time"), (unit for unit, _ in telling.units)))}
    analysis = case["analysis"]
    if telling.stage:
        case["stage"] = [{"name": "only", "analysis": case.pop("analysis")}]
    write_mesh(FOLDER / f"{name}.msh", mesh, telling)
    shutil.rmtree(FOLDER / name, ignore_errors=True)
    done = run(write_case(case | {"mesh": {"file": str(FOLDER / f"{name}.msh")}}, FOLDER / f"{name}.toml"), FOLDER / name, telling.ranks, (), 200)
    folder, answers = FOLDER / name / ("only" if telling.stage else ""), {}
    if done.code not in (0, 5):
        return done.code, answers
    table = np.genfromtxt(folder / {"modal": "modes.csv", "buckling": "modes.csv", "harmonic": "response.csv"}.get(analysis, "history.csv"), delimiter=",", names=True, ndmin=1)
    if analysis in ("modal", "buckling"):
        return done.code, {"eigenvalues": table[table.dtype.names[1]] / (telling.unit(0, 0, 1) if analysis == "modal" else 1)}
    end = "_amplitude" if analysis == "harmonic" else ""
    for probe, unit in (("up", telling.unit(0, 1, 0)), ("ur", telling.unit(0, 1, 0)), ("ra", telling.unit(1, 1, -2))):
        values = np.stack([table[f"{probe}_{axis}{end}"] * (np.exp(1j * np.radians(table[f"{probe}_{axis}_phase"])) if end else 1) for axis in "xyz"])
        answers[probe] = telling.turn.T @ values * unit
    return done.code, answers


def difference(one, other):
    """The largest, relative to the largest value of each answer."""
    worst = 0.0
    for name in one:
        if one[name].shape != other[name].shape:
            return math.inf
        size = max(np.abs(one[name]).max(), 1e-7)
        worst = max(worst, np.abs(one[name] - other[name]).max() / size)
    return worst


def tellings(number):
    chance = random.Random(number + 1)

    def turn():
        q, _ = np.linalg.qr(np.array([[chance.gauss(0, 1) for _ in range(3)] for _ in range(3)]))
        return q * np.sign(np.linalg.det(q))

    return {"turned": Telling(turn=turn(), shift=np.array([0.3, -0.2, 0.5])), "mirrored": Telling(turn=np.diag([1, -1, 1]) @ turn()),
            "units": Telling(units=(("cm", 1e-2), ("g", 1e-3), ("ms", 1e-3))), "numbers": Telling(numbers=number + 7), "ranks": Telling(ranks=chance.choice([2, 3])),
            "split": Telling(split=True), "halves": Telling(halves=True), "stage": Telling(stage=True)}


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    first, last = (int(word) for word in sys.argv[1:3]) if len(sys.argv) > 2 else (0, 40)
    wrong = 0
    for number in range(first, last):
        case, mesh = problem(number)
        code, answers = told(case, mesh, Telling(), "first")
        differing = []
        for name, telling in tellings(number).items():
            other_code, others = told(case, mesh, telling, name)
            limit = 2e-3 if name in ("numbers", "mirrored") and mesh[0] in ("dome", "saddle") else 1e-6
            if other_code != code:
                differing.append(f"{name}: code {other_code}")
            elif (far := difference(answers, others)) > limit:
                differing.append(f"{name}: {far:.1e}")
        wrong += bool(differing)
        print(f"{'FAIL' if differing else 'ok  '} {number}: {case['analysis']}, {mesh[0]}, {', '.join(m['type'] for m in case['material'])}, code {code}{': ' * bool(differing)}{', '.join(differing)}", flush=True)
    print(f"{wrong} problems differ" if wrong else "none differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
