"""Mesh refinement: runs a problem on a series of meshes, fits the order, writes tables and a plot."""

import json
import math
import time
from dataclasses import asdict, dataclass

from benchmarks import BENCHMARKS, diagram
from curves import fitted_order, observed_order
from drawing import plot, plots
from problems import PROBLEMS
from solver import ROOT
from tables import markdown, write_csv

RESULTS = ROOT / "results" / "convergence"


@dataclass
class Answer:
    """One quantity on one mesh."""
    quantity: str
    pattern: str
    operator: str
    level: int
    factor: int        # refinement of the level
    mesh: str          # cells in each direction
    vertices: int
    computed: float
    reference: float
    error: float
    curve_error: float
    iterations: int
    factorisations: int
    cpu_seconds: float
    ranks: int


def answers_on_mesh(problem, operator, pattern, level, ranks):
    parameters = problem.mesh(level)
    folder = RESULTS / problem.name / "_".join([operator.replace("/", "-"), pattern, str(problem.factors[level])])
    mesh = " x ".join(str(v) for v in parameters.values())
    for q in problem.solve(pattern, operator, parameters, folder, ranks):
        s = q.summary
        yield Answer(q.name, pattern, operator, level, problem.factors[level], mesh, s["vertices"], q.computed,
                     q.reference, q.error, q.curve_error, s["newton_iterations"], s["factorisations"], s["cpu_seconds"],
                     s["ranks"])


def refine(name, operators, patterns, levels=None, ranks=2):
    """Solves a problem for all operators, patterns and (some, coarsest first) levels. `levels` is a number, or one for
    each operator."""
    problem, answers = PROBLEMS[name], []
    for operator in operators:
        count = levels.get(operator) if isinstance(levels, dict) else levels
        for pattern in patterns:
            for level in range(len(problem.factors))[:count]:
                begin = time.time()
                found = list(answers_on_mesh(problem, operator, pattern, level, ranks))
                answers += found
                worst = 100 * max((abs(a.curve_error if a.curve_error == a.curve_error else a.error) for a in found),
                                  default=math.nan)
                parameters = ", ".join(f"{k} = {v}" for k, v in problem.mesh(level).items())
                print(f"{name}: {operator}, {pattern}, {parameters}: {worst:.2f} %, {time.time() - begin:.1f} s",
                      flush=True)
    return answers


def answers_file(name, membrane=None):
    """Of a problem; `membrane`: of another membrane beside the default one."""
    return RESULTS / name / (f"answers_{membrane}.json" if membrane else "answers.json")


def store(name, answers, seconds, membrane=None):
    folder = RESULTS / name
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"seconds": seconds, "answers": [asdict(a) for a in answers]}, indent=1)
    answers_file(name, membrane).write_text(text + "\n")


def stored(name, membrane=None):
    """(answers, seconds) of the last refinement of a problem; none if there was none."""
    file = answers_file(name, membrane)
    if not file.is_file():
        return [], 0.0
    data = json.loads(file.read_text())
    return [Answer(**a) for a in data["answers"]], data["seconds"]


def order_of(name, series):
    """Against an exact reference the slope of log(error) over log(size) by least squares. A published curve is not
    exact: there the order comes from the three finest meshes alone."""
    sizes = [1.0 / a.factor for a in series]
    if PROBLEMS[name].family == "nonlinear":
        return observed_order(sizes, [a.computed for a in series])[0]
    return fitted_order(sizes, [a.error for a in series])


def groups(answers):
    """Answers of the same quantity, pattern and operator, in the order of the meshes."""
    keys = dict.fromkeys((a.quantity, a.pattern, a.operator) for a in answers)
    return {key: [a for a in answers if (a.quantity, a.pattern, a.operator) == key] for key in keys}


def number(value, form):
    return "-" if value is None or value != value else format(value, form)


def report(name, answers):
    """Tables and plots in the problem's folder of results. Returns the table as text."""
    folder = RESULTS / name
    header = ["quantity", "pattern", "bending/membrane", "mesh", "vertices", "computed", "reference", "error %",
              "order", "curve error %", "Newton iterations", "factorisations", "CPU s"]
    rows = []
    for (quantity, pattern, operator), series in groups(answers).items():
        order = order_of(name, series)
        for a in series:
            rows.append([quantity, pattern, operator, a.mesh, a.vertices, f"{a.computed:.6g}", f"{a.reference:.6g}",
                         f"{100 * a.error:+.3f}", number(order, ".2f") if a is series[-1] else "",
                         number(100 * a.curve_error, ".2f"), a.iterations, a.factorisations, f"{a.cpu_seconds:.1f}"])
    write_csv(folder / "table.csv", header, rows)
    text = markdown(header, rows)
    (folder / "table.md").write_text(text)
    draw(name, answers, folder / "plot.png")
    if PROBLEMS[name].family == "nonlinear":
        draw_path(name, folder / "curves.png")
    return text


def draw(name, answers, file):
    """Errors against the reference over the mesh, a diagram for each quantity; tables beside the file."""
    several = len({a.operator for a in answers}) > 1
    diagrams = {}
    for k, ((quantity, pattern, operator), series) in enumerate(groups(answers).items()):
        table, first = file.with_name(f"{file.stem}_{k}.csv"), series[0]
        write_csv(table, ["refinement", "error", "second_order"], [[a.factor, max(100 * abs(a.error), 1e-4), 100 * abs(first.error) *
                                                                    (first.factor / a.factor) ** 2] for a in series])
        shown = diagrams.setdefault(quantity, {
            "curves": [], "points": [], "dashed": [(table, "refinement", "second_order", "second order")] if len(series) > 1 else [], "log": "xy",
            "title": quantity, "x_label": "refinement", "y_label": "difference from the reference [%]", "size": (560, 400)})
        shown["points"].append((table, "refinement", "error", ""))
        shown["curves"].append((table, "refinement", "error", pattern.replace("_", " ") + (f", {operator}" if several else "")))
    plots(file, diagrams.values(), min(3, len(diagrams)))


def finest_run(name, pattern="one_way"):
    """history.csv of the finest mesh with the default element, or None."""
    for factor in reversed(PROBLEMS[name].factors):
        file = RESULTS / name / f"corrected_{pattern}_{factor}" / "history.csv"
        if file.is_file():
            return file
    return None


def finest_diagram(name, labels=None):
    """The load-deflection curves of the finest mesh with the published points."""
    return diagram(BENCHMARKS[name], finest_run(name), labels)


def draw_path(name, file):
    plot(file, **finest_diagram(name), title=PROBLEMS[name].title)
