"""Load-deflection curves: reading them and measuring how far they are from published points.

Symbols   lambda  load factor, 1 at the published full load
          d       deflection
          P_i     published point (lambda_i, d_i)
Measure   e_i = distance from P_i to the polyline through the computed points, after dividing loads by the largest published
          load and deflections by the largest published deflection. The polyline starts at the origin.
"""

import csv
from pathlib import Path

import numpy as np


class Table:
    """A CSV file with a header line; lines before it that start with # are comments."""

    def __init__(self, path):
        self.path = Path(path)
        with open(path, newline="") as file:
            lines = file.read().splitlines()
        self.comments = [line.lstrip("# ") for line in lines if line.startswith("#")]
        rows = list(csv.reader(line for line in lines if line.strip() and not line.startswith("#")))
        if not rows:
            raise SystemExit(f"{path}: the table is empty")
        self.names = [name.strip() for name in rows[0]]
        # A run that was killed may leave half a line at the end.
        values = [[float(x) for x in row] for row in rows[1:] if len(row) == len(self.names)]
        self.values = np.array(values).reshape(len(values), len(self.names))

    def __contains__(self, name):
        return name in self.names

    def __getitem__(self, name):
        if name not in self.names:
            raise SystemExit(f"{self.path}: there is no column '{name}'; there are {', '.join(self.names)}")
        return self.values[:, self.names.index(name)]


def distances(published, computed):
    """e_i of every published point. Both are arrays of rows (load factor, deflection)."""
    published, computed = np.asarray(published, float), np.asarray(computed, float)
    units = np.abs(published).max(axis=0)
    points = published / units
    line = np.vstack([np.zeros(2), computed / units])
    start, along = line[:-1], np.diff(line, axis=0)
    length2 = np.maximum((along**2).sum(axis=1), 1e-300)
    result = []
    for p in points:
        t = np.clip(((p - start) * along).sum(axis=1) / length2, 0.0, 1.0)
        result.append(np.linalg.norm(start + t[:, None] * along - p, axis=1).min())
    return np.array(result)


def at_load(computed, load):
    """Deflection at a load factor by linear interpolation; nan beyond the last step."""
    line = np.vstack([np.zeros(2), np.asarray(computed, float)])
    if load > line[:, 0].max() * (1 + 1e-12):
        return float("nan")
    return float(np.interp(load, line[:, 0], line[:, 1]))


def fitted_order(sizes, errors):
    """Slope of log(error) over log(size) by least squares."""
    sizes, errors = np.asarray(sizes, float), np.abs(np.asarray(errors, float))
    usable = errors > 0
    if usable.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(sizes[usable]), np.log(errors[usable]), 1)[0])


def observed_order(sizes, values):
    """Order p and limit w of w_h = w + C h^p through the three finest meshes; nan where they do not fit such a law."""
    order = np.argsort(sizes)[:3]
    if len(order) < 3:
        return float("nan"), float("nan")
    (h1, h2, h3), (w1, w2, w3) = np.asarray(sizes, float)[order], np.asarray(values, float)[order]
    if not (w3 - w2) * (w2 - w1) > 0:
        return float("nan"), float("nan")
    target = (w3 - w2) / (w2 - w1)
    ratio = lambda p: (h3**p - h2**p) / (h2**p - h1**p)
    low, high = 0.05, 8.0
    if not ratio(low) < target < ratio(high):
        return float("nan"), float("nan")
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ratio(middle) < target else (low, middle)
    return low, float(w1 - (w2 - w1) * h1**low / (h2**low - h1**low))
