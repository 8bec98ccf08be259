"""Membranes of rubber without a program: laws in plane stress, an inflated disc by shooting, spheres and tubes in closed form.

Symbols: a, b principal stretches; forces are per width at rest, laws per area at rest (moduli times thickness).
Disc: Adkins & Rivlin, Phil. Trans. R. Soc. A 244 (1952) 505; Hart-Smith & Crisp, Int. J. Eng. Sci. 5 (1967) 1; the equations of equilibrium
below are those of the energy W = 2 pi int w R dR - p pi int r^2 (-z') dR.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

# Ogden (1972), fitted to Treloar's rubber [Pa]
TRELOAR = {"mu": [0.63e6, 0.0012e6, -0.01e6], "alpha": [1.3, 5.0, -2.0]}


class Law:
    """Ogden's sum of mu/alpha (a^alpha + b^alpha + (a b)^-alpha - 3)."""

    def __init__(self, mu, alpha, thickness=1.0):
        self.terms = [(m * thickness, p) for m, p in zip(mu, alpha)]

    def energy(self, a, b):
        return sum(m / p * (a**p + b**p + (a * b)**-p - 3) for m, p in self.terms)

    def forces(self, a, b):
        """dw/da, dw/db."""
        first = sum(m * (a**p - (a * b)**-p) / a for m, p in self.terms)
        return first, sum(m * (b**p - (a * b)**-p) / b for m, p in self.terms)

    def stretch(self, force, b, guess):
        """a of a force along a, where it grows with a."""
        low, high = 1e-3, 2 * guess
        while self.forces(high, b)[0] < force:
            high *= 2
        return brentq(lambda a: self.forces(a, b)[0] - force, low, high, xtol=1e-14, rtol=1e-14)


def neo_hookean(shear, thickness=1.0):
    return Law([shear], [2.0], thickness)


def mooney_rivlin(c10, c01, thickness=1.0):
    return Law([2 * c10, -2 * c01], [2.0, -2.0], thickness)


def disc(law, pole, radius=1.0):
    """Pressure, height of the pole, and energy of a disc held at its edge, of a stretch at the pole.

    The centre has no length, so p is 1 and the disc ends where r = R; then lengths and p are scaled.
    P = R f1 r'/a, and R f1 z'/a = -p r^2/2.
    """
    force = law.forces(pole, pole)[0]
    length = 2 * force  # of the order of radius p = 2 f
    guess = [pole]

    def slopes(R, y):
        r, z, P, W = y
        Q, b = -0.5 * r * r, r / R
        f1 = np.hypot(P, Q) / R
        a = guess[0] = law.stretch(f1, b, guess[0])
        slope = a / (R * f1)
        return [slope * P, slope * Q, law.forces(a, b)[1] + r * slope * Q, 2 * np.pi * R * law.energy(a, b)]

    def edge(R, y):
        return y[0] - R
    edge.terminal, edge.direction = True, -1
    start = 1e-5 * length
    y = [pole * start, 0.0, start * force, 0.0]
    found = solve_ivp(slopes, (start, 100 * length), y, events=edge, rtol=1e-10, atol=1e-13, method="DOP853")
    R, (_, z, _, W) = found.t_events[0][0], found.y_events[0][0]
    scale = radius / R
    return {"pressure": 1 / scale, "height": -z * scale, "energy": W * scale**2}


def sphere_pressure(law, stretch, radius=1.0):
    return 2 * law.forces(stretch, stretch)[0] / (radius * stretch**2)


def tube_pressure(law, stretch, along=1.0, radius=1.0):
    """Of a tube of that stretch along its axis, without what its ends do."""
    return law.forces(stretch, along)[0] / (radius * stretch * along)


def largest(pressure, low, high):
    """Stretch and pressure of the first limit point between two stretches."""
    grid = np.linspace(low, high, 2001)
    values = pressure(grid)
    at = int(np.argmax((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))) + 1
    while grid[2] - grid[0] > 1e-9 and grid[1] - grid[0] > 1e-10:
        grid = np.linspace(grid[at - 1], grid[at + 1], 101)
        values = pressure(grid)
        at = min(max(int(np.argmax(values)), 1), 99)
    return float(grid[at]), float(values[at])
