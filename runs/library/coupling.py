"""Coupling with implicit iterations: a sheet carries a mass that hangs on a spring, which another program would compute.

    partner:  the force on it is F = m a + k (z - z_s), by which it holds the sheet back
    sheet:    it is pulled by -F, spread as its mass, and moves as one
Each step is repeated from the saved state until force and motion fit. Together they are one oscillator:
    z = z_s (1 - cos(w t)),   w^2 = k/(M + m)
"""

import math

import numpy as np
from strip import strip
from voile import Simulation

STEP, END = 0.02, 0.5  # [s]
K, M_PARTNER, Z_S = 6.0, 0.1, 0.05  # [N/m], [kg], [m]

case = strip("dynamic", time={"end": END, "step": STEP, "spectral_radius": 1.0})
del case["support"]
s = Simulation(case)
mass = 100.0 * 0.01 * 0.25  # of the sheet [kg]
corners = s.triangles()
weights = np.bincount(corners.ravel(), minlength=s.vertex_count)[:, None] / corners.size  # cells are alike


def motion():
    """Of the sheet's centre: place and velocity along z."""
    return (weights * s.displacements()).sum(axis=0)[2], (weights * s.velocities()).sum(axis=0)[2]


force, worst, iterations = K * Z_S * mass / (mass + M_PARTNER), 0.0, 0
acceleration = K * Z_S / (mass + M_PARTNER)
place, velocity = motion()
for n in range(round(END / STEP)):
    saved = s.save()
    guess = force
    for k in range(50):
        s.set_forces(guess * weights * [0.0, 0.0, 1.0])
        s.advance_to((n + 1) * STEP)
        z, v = motion()
        a = 2 * (v - velocity) / STEP - acceleration  # the partner's trapezoidal rule
        wanted = K * (Z_S - z) - M_PARTNER * a
        iterations += 1
        if abs(wanted - guess) < 1e-9:
            break
        guess += 0.6 * (wanted - guess)
        s.restore(saved)
    else:
        raise RuntimeError("the iterations of the coupling do not converge")
    force, acceleration, place, velocity = guess, a, z, v
    exact = Z_S * (1 - math.cos(math.sqrt(K / (mass + M_PARTNER)) * s.time))
    worst = max(worst, abs(z - exact))
print(f"{iterations} iterations in {n + 1} steps; largest error {1e3 * worst:.4f} mm of {2e3 * Z_S:g} mm")
assert worst < 0.01 * Z_S, worst
