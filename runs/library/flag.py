"""A flag in a wind, with a force law of one's own: the pressure of the air on a surface grows with the square of the relative
velocity along its normal."""

import numpy as np
from strip import strip
from voile import Simulation

WIND = np.array([3.0, 0.0, 1.0])  # [m/s]
DENSITY = 1.2  # of the air [kg/m^3]


def wind_forces(x, v, triangles):
    """On the vertices [N]."""
    a, b, c = (x[triangles[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)  # times the normal
    relative = WIND - v[triangles].mean(axis=1)
    along = np.einsum("ij,ij->i", relative, area) / np.linalg.norm(area, axis=1)
    force = np.zeros_like(x)
    for k in range(3):
        np.add.at(force, triangles[:, k], (DENSITY * np.abs(along) * along)[:, None] * area / 3)
    return force


s = Simulation(strip("dynamic", young=1e6, thickness=2e-3, time={"end": 0.3, "step": 0.01}))
triangles = s.triangles()
while not s.finished:
    s.set_forces(wind_forces(s.positions(), s.velocities(), triangles))
    s.advance()
assert s.converged, s.reason
energy = s.energy()
print(f"t = {s.time:g} s: the tip is at z = {s.positions()[s.group('tip'), 2].mean():.3f} m, the wind has done {energy.loads:.3g} J")
assert energy.loads > 0 and abs(energy.unaccounted) < 1e-3 * energy.loads
