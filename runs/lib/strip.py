"""Critical weight of a thin strip of length 1 on edge, clamped at x = 0, by Ritz's method: as a plate and as a beam.

Symbols   W, D    width, bending matrix (material axes along and across); load 1 per area down the width
          w       deflection to the side, v(x) + y phi(x) of a beam
Membrane forces under the load, with M = W (1 - x)^2 / 2, V = -W (1 - x), I = W^3 / 12 (the clamp's disturbance left out):
          N_xx = M y / I,   N_xy = V (W^2/4 - y^2) / (2 I),   N_yy = y - W (W^2 y/4 - y^3/3) / (2 I)
Plate     w = sum of x^2 P_i(x) P_j(y); Legendre polynomials. An upper bound that falls with their numbers.
Beam      D11 - D12^2/D22 for v and, if the clamp keeps the section from warping, W^2/12 times that for phi''; 4 D66 phi'^2.
"""

import numpy as np
from numpy.polynomial import legendre


def legendre_values(count, t, scale):
    """Values of P_0 ... and of their first two derivatives with respect to t / scale."""
    return [scale**d * np.array([legendre.legval(t, legendre.legder(unit, d)) for unit in np.eye(count)]) for d in range(3)]


def along(count, x, power):
    """x^power P_i(2 x - 1) with two derivatives; power 1 or 2."""
    p, f = legendre_values(count, 2 * x - 1, 2.0), [x**power, power * x ** (power - 1), power * (power - 1) * np.ones_like(x)]
    return [f[0] * p[0], f[1] * p[0] + f[0] * p[1], f[2] * p[0] + 2 * f[1] * p[1] + f[0] * p[2]]


def gauss(count, low, high):
    nodes, weights = legendre.leggauss(count)
    return 0.5 * (high - low) * nodes + 0.5 * (high + low), 0.5 * (high - low) * weights


def critical_factor(stiffness, geometric):
    """Smallest positive root of stiffness + factor * geometric."""
    scale = 1 / np.sqrt(np.diag(stiffness))
    lower = np.linalg.cholesky(stiffness * np.outer(scale, scale))
    half = np.linalg.solve(lower, geometric * np.outer(scale, scale))
    return -1 / np.linalg.eigvalsh(np.linalg.solve(lower, half.T))[0]


def plate(bending, width, length_count=30, width_count=8):
    (x, wx), (y, wy) = gauss(length_count + 20, 0, 1), gauss(width_count + 8, -width / 2, width / 2)
    f, g = along(length_count, x, 2), legendre_values(width_count, 2 * y / width, 2 / width)
    term = lambda a, b, of_x=1.0, of_y=1.0: np.kron((f[a[0]] * wx * of_x) @ f[b[0]].T, (g[a[1]] * wy * of_y) @ g[b[1]].T)
    xx, yy, xy = (2, 0), (0, 2), (1, 1)
    cross = term(xx, yy)
    stiffness = (bending[0][0] * term(xx, xx) + bending[1][1] * term(yy, yy) + bending[0][1] * (cross + cross.T)
                 + 4 * bending[2][2] * term(xy, xy))
    inertia = width**3 / 12
    moment, force = width * (1 - x) ** 2 / 2, -width * (1 - x)
    shear = term((1, 0), (0, 1), force, (width**2 / 4 - y**2) / (2 * inertia))
    across = y - width * (width**2 * y / 4 - y**3 / 3) / (2 * inertia)
    geometric = term((1, 0), (1, 0), moment, y / inertia) + shear + shear.T + term((0, 1), (0, 1), 1.0, across)
    return critical_factor(stiffness, geometric)


def beam(bending, width, warping_held, count=40):
    x, weight = gauss(2 * count + 8, 0, 1)
    v, phi = along(count, x, 2), along(count, x, 2 if warping_held else 1)
    flexure = bending[0][0] - bending[0][1] ** 2 / bending[1][1]
    warp = flexure * width**2 / 12 if warping_held else 0.0
    none = np.zeros((count, count))
    twist = 4 * bending[2][2] * (phi[1] * weight) @ phi[1].T + warp * (phi[2] * weight) @ phi[2].T
    coupling = (v[1] * weight * (1 - x) ** 2 / 2) @ phi[1].T - (v[1] * weight * (1 - x)) @ phi[0].T
    return critical_factor(np.block([[flexure * (v[2] * weight) @ v[2].T, none], [none, twist]]),
                           np.block([[none, coupling], [coupling.T, none]]))
