"""Linear problems with one known deflection each: the case files of runs/linear, their references and mesh series."""

import math
from dataclasses import dataclass

from plates import supported
from solver import ROOT


def supported_centre_force():
    """Centre deflection / (P a^2 / D) of a simply supported square plate: Navier's double series (Timoshenko &
    Woinowsky-Krieger, Theory of Plates and Shells)."""
    odd = range(1, 600, 2)
    return sum(4.0 / math.pi**4 / (m * m + n * n) ** 2 for m in odd for n in odd)


def twisted_slit_cylinder(torque, radius, young, poisson, thickness):
    """Axial displacement C pi of a lip of the slit: u = -C psi, v = C x / R, C = T R / (4 pi D (1 - nu))."""
    stiffness = young * thickness**3 / (12 * (1 - poisson**2))
    return torque * radius / (4 * stiffness * (1 - poisson))


@dataclass(frozen=True)
class LinearProblem:
    name: str
    title: str
    column: str        # of history.csv
    sign: int          # reference = sign * computed
    reference: float
    source: str        # in full in runs/linear/README.md
    parameters: tuple  # of the .geo at level 0; each level multiplies them by its factor
    factors: tuple
    expected: str      # error on the finest mesh (the worst pattern), and its reason if that is not mesh size

    @property
    def case(self):
        return ROOT / "runs" / "linear" / f"{self.name}.toml"


SERIES = "runs/lib/series.py"
KRYSL = "quoted by FinEtoolsFlexStructures"
BATHE = "Bathe, Iosilevich & Chapelle (2000)"
ZUPAN_SAJE = "Zupan & Saje (2004)"
KIRCHHOFF = "closed form"
IN_PLANE = "strain gradients count as bending, which stiffens a strip that bends in its plane"
STIFF_MEMBRANE = "the constant-strain share stiffens inextensional bending of very thin shells"

N8, N12 = (("n", 8),), (("n", 12),)
STRIP = (("nx", 24), ("ny", 2))
PINCHED, PINCHED_FREE = (("n_axial", 8), ("n_circ", 8)), (("n_axial", 8), ("n_circ", 12))
PANEL = (("n_axial", 8), ("n_circ", 8))
SLIT = (("n_axial", 24), ("n_circ", 24))
DOUBLED = (1, 2, 4, 8)
FINER = (1, 2, 4, 8, 16)

LINEAR = {
    p.name: p
    for p in (
        LinearProblem("scordelis_lo", "Scordelis-Lo roof", "A_z", -1, 0.300601, SERIES, PANEL, DOUBLED,
                      "0.2 %; the energy of the element itself has the limit 0.30017"),
        LinearProblem("pinched_cylinder_diaphragm", "Pinched cylinder on diaphragms", "A_z", -1, 1.82768e-5, SERIES,
                      PINCHED, FINER, "0.9 %; too soft under the force on coarser meshes"),
        LinearProblem("pinched_cylinder_free_100", "Pinched cylinder, free ends, R/h = 100", "A_z", -1, 0.76437,
                      SERIES, PINCHED_FREE, (1, 2, 4, 6), "0.2 %"),
        LinearProblem("pinched_cylinder_free_10000", "Pinched cylinder, free ends, R/h = 10000", "A_z", -1, 0.74228,
                      SERIES, PINCHED_FREE, FINER, f"0.4 %; needs fine meshes, {STIFF_MEMBRANE}"),
        LinearProblem("hemisphere_hole", "Hemisphere with an 18° hole", "pulled_x", 1, 0.093, KRYSL, N8, DOUBLED,
                      "0.6 %; published figures lie between 0.093 and 0.094"),
        LinearProblem("hemisphere_closed", "Closed hemisphere", "pulled_x", 1, 0.0924, KRYSL, N8, DOUBLED,
                      "0.1 %"),
        LinearProblem("twisted_beam_thick_y", "Twisted beam, thick, force along y", "tip_y", 1, 1.753248e-3,
                      ZUPAN_SAJE, STRIP, DOUBLED, f"5 %: {IN_PLANE}"),
        LinearProblem("twisted_beam_thick_z", "Twisted beam, thick, force along z", "tip_z", 1, 5.424535e-3,
                      ZUPAN_SAJE, STRIP, DOUBLED, f"1 %: {IN_PLANE}"),
        LinearProblem("twisted_beam_thin_y", "Twisted beam, thin, force along y", "tip_y", 1, 1.294e-3, KRYSL, STRIP,
                      DOUBLED, "0.2 %"),
        LinearProblem("twisted_beam_thin_z", "Twisted beam, thin, force along z", "tip_z", 1, 5.256e-3, KRYSL, STRIP,
                      DOUBLED, "0.2 %"),
        LinearProblem("raasch_hook", "Raasch's hook", "tip_z", 1, 5.022, KRYSL, (("n", 3),), DOUBLED,
                      "6 %: in torsion a strip of width / thickness = 10 without shear is too stiff by that much"),
        LinearProblem("hypar_100", "Clamped saddle, L/h = 100", "A_z", -1, 9.3355e-5, BATHE, N12,
                      (1, 2, 4, 7), "0.5 %"),
        LinearProblem("hypar_1000", "Clamped saddle, L/h = 1000", "A_z", -1, 6.3941e-3, BATHE, N12,
                      (1, 2, 4, 7), "0.6 %"),
        LinearProblem("hypar_10000", "Clamped saddle, L/h = 10000", "A_z", -1, 5.2988e-1, BATHE, N12,
                      FINER, f"0.4 %; needs fine meshes, {STIFF_MEMBRANE}"),
        LinearProblem("skew_plate", "Rhombic plate, two sides supported", "centre_z", -1, 0.79309, SERIES, N8,
                      DOUBLED, "0.2 %"),
        LinearProblem("circular_plate_clamped", "Circular plate, clamped", "centre_z", 1, 1 / 64, KIRCHHOFF, N8,
                      (1, 2, 3, 4), "0.6 %"),
        LinearProblem("circular_plate_supported", "Circular plate, simply supported", "centre_z", 1, 5.3 / 1.3 / 64,
                      KIRCHHOFF, N8, (1, 2, 3, 4), "0.1 %"),
        LinearProblem("triangular_plate", "Triangular plate, simply supported", "centre_z", 1, 1 / 972, KIRCHHOFF, N8,
                      DOUBLED, "0.2 %"),
        LinearProblem("square_plate_uniform", "Square plate, simply supported, uniform load", "centre_z", 1,
                      supported(), KIRCHHOFF, N8, DOUBLED, "0.1 %"),
        LinearProblem("square_plate_centre", "Square plate, simply supported, centre force", "centre_z", 1,
                      supported_centre_force(), KIRCHHOFF, N8, DOUBLED, "0.3 %"),
        LinearProblem("cook_membrane", "Cook's panel", "A_y", 1, 23.97, KRYSL, N8, DOUBLED,
                      f"0.7 %: {IN_PLANE}"),
        LinearProblem("slit_cylinder_torque", "Slit cylinder under torques", "lip_x", 1,
                      twisted_slit_cylinder(1000, 300, 3e6, 0.3, 3.0), "Morris (NAFEMS P12), exact", SLIT, (1, 2, 3),
                      "0.2 %"),
    )
}


def answer(problem, result):
    """The deflection that `reference` is compared with, from a run of the problem's case."""
    history = result.history
    return float(problem.sign * history[problem.column][-1])
