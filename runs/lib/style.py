"""The look of all pictures."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = ("#1f5f8b", "#c8553d", "#3f7d4e", "#8a5a9c", "#b8860b", "#444444")

plt.rcParams.update({
    "font.size": 10.5,
    "font.family": "DejaVu Sans",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.edgecolor": "#666666",
    "axes.titlesize": 12,
    "axes.titlepad": 12,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
})


def new_figure(width=7.2, height=4.8):
    figure, axes = plt.subplots(figsize=(width, height), layout="constrained")
    return figure, axes


def save(figure, path, dpi=150):
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=dpi, facecolor="white")
    plt.close(figure)
