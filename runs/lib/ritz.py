#!/usr/bin/python3
"""Reference frequencies and buckling loads of plates and shells without shear: what runs/lib/modes.py compares with.

Symbols   a, h, rho  side, thickness, density; D = E h^3 / (12 (1 - nu^2))
          xi, eta    skew coordinates from -1 to 1: x = (xi + s eta) a / 2, y = c eta a / 2, with s and c the sine and
                     cosine of the angle by which two sides lean
Plates: Ritz's method with w = sum w_ij f_i(xi) g_j(eta), where f and g are Legendre polynomials times a power of
(1 + xi) and of (1 - xi): 0 for a free edge, 1 for a supported one, 2 for a clamped one. The frequencies are upper
bounds that fall with the number of polynomials. Run the file to print all of them with two truncations.
"""

import math

import numpy as np
from numpy.polynomial import legendre

FREE, SUPPORTED, CLAMPED = 0, 1, 2


def edge_polynomials(count, low, high):
    """Integrals over -1..1 of products of derivatives: a table [d][e] of matrices, for orthonormal functions."""
    factor = legendre.poly2leg(np.polynomial.polynomial.polymul(
        np.polynomial.polynomial.polypow([1, 1], low), np.polynomial.polynomial.polypow([1, -1], high)))
    functions = [legendre.legmul(factor, unit) for unit in np.eye(count)]
    nodes, weights = legendre.leggauss(count + 8)
    values = [np.array([legendre.legval(nodes, legendre.legder(f, d)) for f in functions]) for d in range(3)]
    triangle = np.linalg.qr((values[0] * np.sqrt(weights)).T, mode="r")
    values = [np.linalg.solve(triangle.T, v) for v in values]
    return [[(values[d] * weights) @ values[e].T for e in range(3)] for d in range(3)]


def plate_frequencies(modes, left=FREE, right=FREE, bottom=FREE, top=FREE, skew=0.0, side=10.0, thickness=0.05,
                      young=200e9, poisson=0.3, density=8000.0, count=20):
    """Lowest frequencies in Hz, without rigid motions; `skew` in degrees."""
    s, c = math.sin(math.radians(skew)), math.cos(math.radians(skew))
    xi, eta = edge_polynomials(count, left, right), edge_polynomials(count, bottom, top)
    # Rows w,xx  w,yy  2 w,xy in units of 4 / a^2, by the orders of the derivatives in (xi, eta)
    orders = [(2, 0), (1, 1), (0, 2)]
    rows = np.array([[1, 0, 0], [s * s / c**2, -2 * s / c**2, 1 / c**2], [-2 * s / c, 2 / c, 0]])
    law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    weight = rows.T @ law @ rows
    matrix = sum(weight[p, q] * np.kron(xi[orders[p][0]][orders[q][0]], eta[orders[p][1]][orders[q][1]])
                 for p in range(3) for q in range(3))
    values = np.linalg.eigvalsh(matrix) * (4 / side**2) ** 2
    bending = young * thickness**3 / (12 * (1 - poisson**2))
    values = values[values > 1e-6 * values[-1] / count**8]
    return np.sqrt(values[:modes] * bending / (density * thickness)) / (2 * math.pi)


def supported_frequencies(modes, side=10.0, thickness=0.05, young=200e9, poisson=0.3, density=8000.0):
    """Exact: pi / (2 a^2) sqrt(D / (rho h)) (m^2 + n^2)."""
    bending = young * thickness**3 / (12 * (1 - poisson**2))
    waves = sorted(m * m + n * n for m in range(1, 20) for n in range(1, 20))[:modes]
    return np.array(waves) * math.pi / (2 * side**2) * math.sqrt(bending / (density * thickness))


PANEL = {"radius": 1.0, "length": 0.2, "half_angle": 0.1, "thickness": 1e-3, "young": 1e9}


def panel_waves(half_length_waves, sector_waves, length, half_angle, radius):
    """Wave numbers alpha = m pi / L and beta = n / R that the planes of symmetry admit: m odd, n a multiple of
    pi / half_angle."""
    return [(m * math.pi / length, k * math.pi / half_angle / radius)
            for m in range(1, 2 * half_length_waves, 2) for k in range(sector_waves)]


def panel_donnell(modes, radius, length, half_angle, thickness, young):
    """Critical axial forces per length of a cylindrical sector, nu = 0, by Donnell's equations:
    N = D (alpha^2 + beta^2)^2 / alpha^2 + E h / R^2 alpha^2 / (alpha^2 + beta^2)^2."""
    bending = young * thickness**3 / 12
    loads = []
    for alpha, beta in panel_waves(20, 20, length, half_angle, radius):
        q = (alpha**2 + beta**2) ** 2 / alpha**2
        loads.append(bending * q + young * thickness / radius**2 / q)
    return np.array(sorted(loads)[:modes])


def panel_koiter(modes, radius, length, half_angle, thickness, young):
    """The same with Koiter's strains and changes of curvature (series.py) and the geometric term
    N (u,x^2 + v,x^2 + w,x^2) / 2. From the middle, u = U sin(alpha x) cos(beta s), v = V cos(alpha x) sin(beta s),
    w = W cos(alpha x) cos(beta s), m odd: v = w = N_x = M_x = 0 at the ends, mirror planes at the straight edges."""
    c, d = young * thickness, young * thickness**3 / 12
    loads = []
    for a, b in panel_waves(20, 20, length, half_angle, radius):
        r = radius
        # Amplitudes of e_x, e_p, g, k_x, k_p, 2 k_xp in (U, V, W); all products of sines and cosines have the same mean
        strains = np.array([[a, 0, 0], [0, b, 1 / r], [-b, -a, 0],
                            [0, 0, -a * a], [0, -b / r, -b * b], [-b / (2 * r), 1.5 * a / r, 2 * a * b]])
        law = np.diag([c, c, c / 2, d, d, d / 2])
        used = [0, 1, 2] if b > 0 else [0, 2]
        loads.append(np.linalg.eigvalsh((strains.T @ law @ strains)[np.ix_(used, used)])[0] / a**2)
    return np.array(sorted(loads)[:modes])


def main():
    form = lambda values: " ".join(f"{v:.5g}" for v in values)
    print("supported plate", form(supported_frequencies(6)), "| Ritz", form(plate_frequencies(6, 1, 1, 1, 1, count=12)))
    for name, edges, skew in (("FV12 free", {}, 0), ("FV16 cantilever", {"left": CLAMPED}, 0),
                              ("FV15 rhombic", dict.fromkeys(("left", "right", "bottom", "top"), CLAMPED), 45)):
        for count in (16, 24):
            print(f"{name}, {count} x {count} polynomials", form(plate_frequencies(6, skew=skew, count=count, **edges)))
    print("cylinder panel, Donnell", form(panel_donnell(4, **PANEL)))
    print("cylinder panel, Koiter ", form(panel_koiter(4, **PANEL)))


if __name__ == "__main__":
    main()
