"""Bending stiffness of a fabric from a measured drop: the secant method on a strip that hangs over the edge of a table.

Large deflections: no formula gives the answer. The "measurement" is a simulation with a known modulus.
"""

from strip import strip
from voile import Simulation


def drop(young):
    """Of the tip under the strip's weight [m]."""
    s = Simulation(strip("drape", young=young, thickness=1e-3, load=[{"type": "gravity", "vector": [0, 0, -9.81]}]))
    assert s.run(), s.reason
    return -s.displacements()[s.group("tip"), 2].mean()


true = 3.7e9
measured = drop(true)
print(f"measured drop: {measured:.4f} m")
young, before = 2e9, 8e9  # two guesses
error, error_before = drop(young) - measured, drop(before) - measured
for k in range(20):
    if abs(error) < 1e-7:
        break
    young, before = young - error * (young - before) / (error - error_before), young
    error, error_before = drop(young) - measured, error
    print(f"{k + 1}: bending stiffness {young * 1e-9 / 12:.6f} N m, drop off by {error:+.2e} m")
assert abs(young / true - 1) < 1e-4, young
