#!/usr/bin/python3
"""Reference deflections of thin shells and plates without shear, as series: what runs/lib/linear.py compares with.

Symbols   R, L, h  radius, length, thickness; C = E h / (1 - nu^2), D = C h^2 / 12
          x, phi   along the axis, around it; u, v, w displacements along x, along phi, outwards
Koiter's energy of a cylinder with the strains and changes of curvature
          e_x = u,x                   k_x = w,xx
          e_p = (v,p + w) / R         k_p = (w,pp - v,p) / R^2
          g   = u,p / R + v,x         2 k_xp = 2 w,xp / R - 3 v,x / (2 R) + u,p / (2 R^2)
is minimised over products of trigonometric functions (exact where the ends are diaphragms or the direction is closed)
and Legendre polynomials (free edges). Run the file to print each of them with two truncations.
"""

import math

import numpy as np
from numpy.polynomial import legendre


def stiffness(strains, young, poisson, thickness):
    """Second derivative of the energy density at each point; `strains` are the six rows e_x, e_p, g, k_x, k_p, 2 k_xp
    as arrays (unknowns, points). Returns (points, unknowns, unknowns)."""
    c = young * thickness / (1 - poisson**2)
    law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    b = np.array(strains)
    factors = np.zeros((6, 6))
    factors[:3, :3], factors[3:, 3:] = c * law, c * thickness**2 / 12 * law
    return np.einsum("rip,rs,sjp->pij", b, factors, b, optimize=True)


def polynomials(count, x, scale):
    """Legendre polynomials of x / scale and their first two derivatives: three arrays (count, points)."""
    identity = np.eye(count)
    return [np.array([legendre.legval(x / scale, legendre.legder(identity[k], d)) for k in range(count)]) / scale**d
            for d in range(3)]


def solve(matrix, force):
    """Least squares after scaling the diagonal to one: high polynomials are nearly dependent."""
    scale = 1 / np.sqrt(np.diag(matrix))
    return np.linalg.lstsq(matrix * scale[:, None] * scale, force * scale, rcond=1e-15)[0] * scale


def roof(waves=40, count=16, radius=25.0, length=50.0, half_angle=40.0, young=4.32e8, poisson=0.0, thickness=0.25,
         weight=90.0, gradients=False):
    """Downward deflection in the middle of the free edge of a roof on end diaphragms under its own weight: cosines
    along the axis, polynomials across. `gradients` adds the energy that the element gives to gradients of strain:
    D times the same quadratic form in u_c,ab = E_ac,b + E_bc,a - E_ab,c for both directions c of the surface."""
    edge = math.radians(half_angle)
    nodes, weights = legendre.leggauss(4 * count)
    phi, weights = edge * (nodes + 1) / 2, weights * edge / 2
    f = polynomials(2 * count, phi, edge)
    even, odd = [g[0::2] for g in f], [g[1::2] for g in f]  # u and w are even in phi, v is odd
    at_edge = polynomials(2 * count, np.array([edge]), edge)[0][:, 0]
    zero = np.zeros_like(even[0])
    total = 0.0
    for m in range(1, 2 * waves, 2):
        k = m * math.pi / length
        rows = [(k * even[0], zero, zero), (zero, odd[1] / radius, even[0] / radius),
                (even[1] / radius, -k * odd[0], zero), (zero, zero, -k * k * even[0]),
                (zero, -odd[1] / radius**2, even[2] / radius**2),
                (even[1] / (2 * radius**2), 1.5 * k * odd[0] / radius, -2 * k * even[1] / radius)]
        density = stiffness([np.concatenate(r) for r in rows], young, poisson, thickness)
        if gradients:
            along = [(-k * k * even[0], zero, zero), (even[2] / radius**2, zero, k * even[0] / radius),
                     (2 * k * even[1] / radius, zero, zero)]
            across = [(zero, -k * k * odd[0], zero), (zero, odd[2] / radius**2, even[1] / radius**2),
                      (zero, -2 * k * odd[1] / radius, -2 * k * even[0] / radius)]
            none = 3 * [np.concatenate((zero, zero, zero))]
            density += sum(stiffness(none + [np.concatenate(r) for r in c], young, poisson, thickness)
                           for c in (along, across))
        matrix = np.tensordot(weights, density, 1) * radius * length / 2
        force = weight * np.concatenate([zero, np.sin(phi) * odd[0], -np.cos(phi) * even[0]]) @ weights
        x = solve(matrix, force * radius * 2 / k * math.sin(k * length / 2))
        total -= x[2 * count:] @ at_edge[0::2] * math.cos(edge) - x[count:2 * count] @ at_edge[1::2] * math.sin(edge)
    return total


def pinched_diaphragm(waves=400, radius=300.0, length=600.0, young=3e6, poisson=0.3, thickness=3.0, force=1.0):
    """Deflection under one of two opposite forces in the middle of a cylinder on end diaphragms: a double Fourier
    series. The remainder falls as 1 / waves^2 and is extrapolated."""

    def partial(waves):
        n = np.arange(0, waves, 2.0)
        zero, one = np.zeros_like(n), np.ones_like(n)
        area = radius * math.pi * np.where(n == 0, 2, 1) * length / 2
        total = 0.0
        for m in range(1, waves, 2):
            k = m * math.pi / length
            rows = [(-k * one, zero, zero), (zero, n / radius, one / radius), (-n / radius, k * one, zero),
                    (zero, zero, -k * k * one), (zero, -n / radius**2, -n * n / radius**2),
                    (-n / (2 * radius**2), -1.5 * k / radius * one, -2 * k * n / radius)]
            density = stiffness([np.array(r) for r in rows], young, poisson, thickness)
            density[0, 1, 1] = density[0, 1, 1] or 1.0  # v without waves around the axis has no energy and no force
            total += (2 * force * np.linalg.inv(density)[:, 2, 2] / area).sum()
        return total

    coarse, fine = partial(waves // 2), partial(waves)
    return fine + (fine - coarse) / 3


def pinched_free(thickness, force=100.0, waves=240, count=30, radius=4.953, length=10.35, young=10.5e6, poisson=0.3125):
    """The same with free ends: a Fourier series around the axis, polynomials along it."""
    half = length / 2
    nodes, weights = legendre.leggauss(2 * count + 20)
    x, weights = half * (nodes + 1) / 2, weights * half / 2
    f = polynomials(2 * count, x, half)
    even, odd = [g[0::2] for g in f], [g[1::2] for g in f]  # v and w are even in x, u is odd
    middle = polynomials(2 * count, np.zeros(1), half)[0][0::2, 0]
    zero = np.zeros_like(even[0])
    total = 0.0
    for n in range(0, waves, 2):
        rows = [(odd[1], zero, zero), (zero, n * even[0] / radius, even[0] / radius),
                (-n * odd[0] / radius, even[1], zero), (zero, zero, even[2]),
                (zero, -n * even[0] / radius**2, -n * n * even[0] / radius**2),
                (-n * odd[0] / (2 * radius**2), -1.5 * even[1] / radius, -2 * n * even[1] / radius)]
        density = stiffness([np.concatenate(r) for r in rows], young, poisson, thickness)
        matrix = np.tensordot(weights, density, 1) * 2 * radius * math.pi * (2 if n == 0 else 1)
        used = np.r_[0:count, 2 * count:3 * count] if n == 0 else np.arange(3 * count)
        right = np.concatenate([0 * middle, 0 * middle, 2 * force * middle])
        total += solve(matrix[np.ix_(used, used)], right[used])[-count:] @ middle
    return total


def rhombic_plate(count=26, poisson=0.31, skew=30.0):
    """Centre deflection / (q a^4 / D) of a rhombic plate of side a, two opposite sides supported and two free: products
    of polynomials in skew coordinates that vanish on the supported sides."""
    s, c = math.sin(math.radians(skew)), math.cos(math.radians(skew))
    nodes, weights = legendre.leggauss(2 * count + 6)
    free = np.array(polynomials(count, nodes, 1.0))
    bubble = 1 - nodes**2
    held = [bubble * free[0], bubble * free[1] - 2 * nodes * free[0],
            bubble * free[2] - 4 * nodes * free[1] - 2 * free[0]]
    pairs = [(i, j) for i in range(count) for j in range(count) if (i + j) % 2 == 0]  # symmetric about the centre
    product = lambda a, b: np.array([np.outer(free[a][i], held[b][j]).ravel() for i, j in pairs])
    area = np.outer(weights, weights).ravel() * c / 4
    # x = (xi + s eta) / 2, y = c eta / 2
    k = [4 * product(2, 0), 4 / c**2 * (product(0, 2) - 2 * s * product(1, 1) + s * s * product(2, 0)),
         8 / c * (product(1, 1) - s * product(2, 0))]
    law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    matrix = sum(law[a, b] * (k[a] * area) @ k[b].T for a in range(3) for b in range(3) if law[a, b])
    x = solve(matrix, product(0, 0) @ area)
    centre = polynomials(count, np.zeros(1), 1.0)[0][:, 0]
    return sum(value * centre[i] * centre[j] for value, (i, j) in zip(x, pairs))


def main():
    print("roof", roof(20, 12), roof())
    print("roof with the energy of strain gradients", roof(20, 12, gradients=True), roof(gradients=True))
    print("pinched cylinder, diaphragms", pinched_diaphragm(200), pinched_diaphragm())
    for ratio in (100, 4.953 / 0.094, 10000):
        h = 4.953 / ratio
        unit = 100 * 4.953 / (10.5e6 * h**3)
        print(f"pinched cylinder, free ends, R/h = {ratio:.2f}, in P R / (E h^3)",
              pinched_free(h, waves=120, count=24) / unit, pinched_free(h) / unit)
    print("rhombic plate", rhombic_plate(20), rhombic_plate())


if __name__ == "__main__":
    main()
