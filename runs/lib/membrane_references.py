"""References of the test set of runs/membranes for each thickness: closed forms, series, and meshes far finer than those compared.

Computed once by `runs/membranes --references` and kept in runs/reference/membranes.csv with what they are uncertain by.
"""

import csv
import functools
import math

import numpy as np
import series
from solver import ROOT

FILE = ROOT / "runs" / "reference" / "membranes.csv"
PLATE_LOAD = 10.92           # pressure on the clamped disc, R = 1, E = 10.92e9: bends it by 6.4 h at h = 1e-3
STRETCH, STRAIN, DENSITY = 1000.0, 0.01, 0.2  # of the drum: membrane stiffness, strain, mass per area; R = 1


@functools.cache
def table():
    """(problem, thickness) -> quantity -> (value, uncertainty)."""
    found = {}
    with open(FILE) as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            numbers = float(row["value"]), float(row["uncertainty"] or 0)
            found.setdefault((row["problem"], float(row["thickness"])), {})[row["quantity"]] = numbers
    return found


def reference(problem, thickness):
    """Quantity -> value."""
    return {quantity: value for quantity, (value, _) in table()[problem, thickness].items()}


def uncertainty(problem, thickness):
    """Of the least certain quantity, in %; 0 where no uncertainty is known."""
    return max((100 * abs(unsure / value) for value, unsure in table().get((problem, thickness), {}).values()), default=0.0)


# ------------------------------------------------------------------------------------------------- closed forms, series

def plate_centre(load, h=1e-3, n=400):
    """Centre deflection / h of a clamped circular plate, R = 1, E = 10.92e9, nu = 0.3, whose edge is held, by von Karman's equations on n
    intervals; slope p = dw/dr, radial force N:  D ((p' r)' - p/r) = r N p + q r^2/2,  (r^3 N')' = -(E h / 2) r p^2. Here `force` is N / D."""
    nu, bending = 0.3, (1e3 * h) ** 3
    stretching, load = 10.92e9 * h / bending, load / bending
    r = np.linspace(0.0, 1.0, n + 1)
    step = r[1]
    slope, force = np.zeros(n + 1), np.zeros(n + 1)
    for factor in np.geomspace(min(1.0, 10 / load), 1.0, 30):
        for _ in range(30):
            residual, matrix = np.zeros(2 * n + 2), np.zeros((2 * n + 2, 2 * n + 2))
            for i in range(1, n):
                x, low, high = r[i], r[i] - step / 2, r[i] + step / 2
                residual[i] = ((slope[i + 1] - slope[i]) * high - (slope[i] - slope[i - 1]) * low) / step**2 - slope[i] / x \
                    - x * force[i] * slope[i] - factor * load * x**2 / 2
                matrix[i, i - 1 : i + 2] = low / step**2, -2 * x / step**2 - 1 / x - x * force[i], high / step**2
                matrix[i, n + 1 + i] = -x * slope[i]
                k = n + 1 + i
                residual[k] = ((force[i + 1] - force[i]) * high**3 - (force[i] - force[i - 1]) * low**3) / step**2 \
                    + stretching / 2 * x * slope[i] ** 2
                matrix[k, k - 1 : k + 2] = low**3 / step**2, -(low**3 + high**3) / step**2, high**3 / step**2
                matrix[k, i] = stretching * x * slope[i]
            residual[0], matrix[0, 0] = slope[0], 1
            residual[n], matrix[n, n] = slope[n], 1
            residual[n + 1] = -3 * force[0] + 4 * force[1] - force[2]
            matrix[n + 1, n + 1 : n + 4] = -3, 4, -1
            residual[-1] = (3 * force[n] - 4 * force[n - 1] + force[n - 2]) / (2 * step) + (1 - nu) * force[n]
            matrix[-1, -3:] = 0.5 / step, -2 / step, 1.5 / step + 1 - nu
            change = np.linalg.solve(matrix, -residual)
            slope, force = slope + change[: n + 1], force + change[n + 1 :]
            if np.abs(change[: n + 1]).max() < 1e-9 * np.abs(slope).max():
                break
    return abs(np.sum((slope[1:] + slope[:-1]) / 2) * step) / h


def bessel(n, x):
    """J_n(x) and I_n(x) exp(-x) with two derivatives each, by Bessel's integrals; the trapezoidal rule is exact to round-off."""
    angle = 2 * np.pi * np.arange(4096) / 4096
    def both(x):
        return np.mean(np.cos(n * angle - x * np.sin(angle))), np.mean(np.exp(x * (np.cos(angle) - 1)) * np.cos(n * angle))
    def slopes(x):
        return (np.mean(np.sin(angle) * np.sin(n * angle - x * np.sin(angle))),
                np.mean(np.cos(angle) * np.exp(x * (np.cos(angle) - 1)) * np.cos(n * angle)))
    (j, i), (dj, di) = both(x), slopes(x)
    return (j, dj, -dj / x - (1 - n * n / x**2) * j), (i, di, -di / x + (1 + n * n / x**2) * i)


def drum_bending(thickness):
    return STRETCH * thickness**2 / 12


def drum_frequencies(thickness):
    """Of a stretched disc with bending stiffness D, nu = 0, hinged at its edge: w = J_n(a r) / J_n(a) - I_n(b r) / I_n(b), w,rr = 0 there,
    b^2 - a^2 = N / D, density (2 pi f)^2 = N a^2 + D a^4."""
    tension, bending = STRETCH * (STRAIN + STRAIN**2 / 2), drum_bending(thickness)
    found = []
    for n, start in ((0, 2.404826), (1, 3.831706), (1, 3.831706), (2, 5.135622), (2, 5.135622), (0, 5.520078)):
        def excess(a):
            b = math.sqrt(a * a + tension / bending)
            j, i = bessel(n, a)[0], bessel(n, b)[1]
            return a * a * j[2] / (b * b) - i[2] / i[0] * j[0]
        low, high = start - 0.1, start + 0.1
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if excess(low) * excess(middle) > 0 else (low, middle)
        found.append(math.sqrt((tension * low**2 + bending * low**4) / DENSITY) / (2 * math.pi))
    return found


def drum_case(thickness):
    d = drum_bending(thickness)
    return {"analysis": "modal", "eigen": {"modes": 6, "load_factor": 1.0},
            "mesh": {"file": str(ROOT / "meshes" / "disc.geo"), "parameters": {"radius": 1, "inner_radius": 0.4}},
            "material": [{"type": "matrices", "membrane": np.diag([STRETCH, STRETCH, STRETCH / 2]).tolist(),
                          "bending": np.diag([d, d, d / 2]).tolist(), "areal_density": DENSITY}],
            "support": [{"type": "displacement", "group": "edge", "components": ["x", "y", "z"], "cylinder_axis": [0, 0, 1],
                         "value": [STRAIN, 0, 0]}]}


def converged(of):
    """Value of a series and its uncertainty from a coarse and a fine truncation: of(fine)."""
    coarse, fine = of(False), of(True)
    return fine, abs(fine - coarse)


def series_values(thickness):
    """(problem, quantity) -> value, uncertainty, source."""
    plate = lambda fine: thickness * plate_centre(PLATE_LOAD, thickness, 800 if fine else 400)
    drums = drum_frequencies(thickness)
    return {
        ("pinched_free", "A_z"): (*converged(lambda f: series.pinched_free(4.953 * thickness, waves=480 if f else 240, count=40 if f else 30)), "series"),
        ("pinched_diaphragm", "A_z"): (*converged(lambda f: series.pinched_diaphragm(1200 if f else 600, thickness=300 * thickness)), "series"),
        ("scordelis_lo", "A_z"): (*converged(lambda f: series.roof(60 if f else 40, 24 if f else 18, thickness=25 * thickness)), "series"),
        ("clamped_disc", "centre_z"): (*converged(plate), "von Karman's equations"),
        **{("drum", f"mode_{k}"): (f, 1e-6 * f, "characteristic equation") for k, f in enumerate(drums, 1)},
    }
