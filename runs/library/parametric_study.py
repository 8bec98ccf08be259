"""A parametric study: the drop of a strip under its weight over its thickness.

The weight grows with the thickness and the stiffness with its third power, so that small drops go with 1/thickness^2.
"""

import numpy as np
from strip import strip
from voile import Simulation

drops = {}
for thickness in (0.01, 0.02, 0.04):
    s = Simulation(strip("static", thickness=thickness, load=[{"type": "gravity", "vector": [0, 0, -0.5]}]))
    assert s.run(), s.reason
    drops[thickness] = -s.displacements()[s.group("tip"), 2].mean()
    print(f"thickness {1e3 * thickness:3.0f} mm: drop {1e3 * drops[thickness]:8.4f} mm")

# q L^4 / 8 D with q = density * thickness * 0.5 m/s^2, D = young * thickness^3 / 12
exact = {h: 100 * h * 0.5 / (8 * 1e7 * h**3 / 12) for h in drops}
assert all(np.isclose(drops[h], exact[h], rtol=0.02) for h in drops), (drops, exact)
