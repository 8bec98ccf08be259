"""A controller moves an obstacle by what it measures: a ball lifts the tip of a strip to a height and holds it there."""

from strip import strip
from voile import Simulation

TARGET, GAIN = 0.06, 12.0  # [m], [1/s]

s = Simulation(strip("dynamic", young=1e9, time={"end": 0.8, "step": 0.02}, damping={"mass": 20.0},
                     load=[{"type": "gravity", "vector": [0, 0, -9.81]}], contact={"distance": 4e-3},
                     obstacle=[{"name": "ball", "type": "sphere", "point": [0.85, 0.125, -0.115], "radius": 0.1}]))
tip = s.group("tip")
while not s.finished:
    height = s.positions()[tip, 2].mean()
    ball = s.obstacle("ball")
    end = s.time + 0.02
    ball[:, 2] += 0.02 * min(0.4, GAIN * (TARGET - height))
    s.set_obstacle("ball", ball, end)
    s.advance_to(end)
assert s.converged, s.reason
height = s.positions()[tip, 2].mean()
print(f"t = {s.time:g} s: the tip is at {1e3 * height:.1f} mm, the target is {1e3 * TARGET:g} mm")
assert abs(height - TARGET) < 0.05 * TARGET, height
