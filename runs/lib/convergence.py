"""Mesh refinement: runs a problem on a series of meshes, fits the order, writes tables and a plot."""

import json
import math
import time
from dataclasses import asdict, dataclass

from benchmarks import BENCHMARKS, computed_points
from curves import Table, fitted_order, observed_order
from problems import PROBLEMS
from solver import ROOT
from style import COLOURS, new_figure, save
from tables import markdown, write_csv

from matplotlib.lines import Line2D

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
    """Errors against the reference over the mesh. Colours stand for mesh and operator, line styles for the quantity."""
    quantities = list(dict.fromkeys(a.quantity for a in answers))
    kinds = list(dict.fromkeys((a.pattern, a.operator) for a in answers))
    styles = ("o-", "s--", "^:", "d-.", "v-", "x--")
    style = {q: styles[i % len(styles)] for i, q in enumerate(quantities)}
    figure, axes = new_figure(8.6, 4.8)
    for (quantity, pattern, operator), series in groups(answers).items():
        axes.plot([a.factor for a in series], [max(100 * abs(a.error), 1e-4) for a in series], style[quantity], ms=5,
                  mfc="white", color=COLOURS[kinds.index((pattern, operator)) % len(COLOURS)])
    meshes = {a.factor: a.mesh for a in sorted(answers, key=lambda a: a.factor)}
    factors, top = list(meshes), max(100 * abs(a.error) for a in answers)
    if len(factors) > 1:
        axes.plot(factors, [top * (factors[0] / f) ** 2 for f in factors], color="#999999", lw=1.0, zorder=0)
        axes.annotate("second order", (factors[-1], top * (factors[0] / factors[-1]) ** 2), fontsize=8.5,
                      color="#777777", ha="right", va="top", xytext=(0, -4), textcoords="offset points")
    axes.axhline(1.0, color="#bbbbbb", lw=1.0, ls=":", zorder=0)
    axes.set(xscale="log", yscale="log", xlabel="mesh", ylabel="difference from the reference [%]")
    axes.set_xticks(factors, list(meshes.values()))
    axes.minorticks_off()
    axes.set_title(PROBLEMS[name].title)
    several = len({operator for _, operator in kinds}) > 1
    entries = [Line2D([], [], color=COLOURS[i % len(COLOURS)], lw=4,
                      label=pattern.replace("_", " ") + (f", {operator}" if several else ""))
               for i, (pattern, operator) in enumerate(kinds)]
    entries += [Line2D([], [], color="#444444", ls=style[q][1:], marker=style[q][0], ms=5, mfc="white", label=q)
                for q in quantities]
    axes.legend(handles=entries, loc="center left", bbox_to_anchor=(1.01, 0.5))
    save(figure, file)


def finest_run(name, pattern="one_way"):
    """history.csv of the finest mesh with the default element, or None."""
    for factor in reversed(PROBLEMS[name].factors):
        file = RESULTS / name / f"edge_slope-six_node_{pattern}_{factor}" / "history.csv"
        if file.is_file():
            return Table(file)
    return None


def draw_curves(axes, name, colours, labels=None):
    history, benchmark = finest_run(name), BENCHMARKS[name]
    for k, (curve, colour) in enumerate(zip(benchmark.curves, colours)):
        label = labels[k] if labels else curve.label
        points = benchmark.points(curve)
        if history is not None:
            computed = computed_points(history, curve)
            axes.plot([0, *computed[:, 1]], [0, *computed[:, 0]], color=colour, lw=1.4,
                      label=label)
        axes.plot(points[:, 1], points[:, 0], "o", mfc="white", mec=colour, mew=1.1, ms=4, zorder=3)
    axes.set(xlabel=benchmark.deflection_label, ylabel=benchmark.load_label)


def draw_path(name, file):
    """The load-deflection curves of the finest mesh with the published points."""
    figure, axes = new_figure()
    draw_curves(axes, name, COLOURS)
    axes.set_title(PROBLEMS[name].title)
    axes.legend()
    save(figure, file)
