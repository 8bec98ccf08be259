"""The strip that the examples of this folder share: 1 m x 0.25 m, clamped at x = 0."""

from pathlib import Path

MESHES = Path(__file__).resolve().parents[2] / "meshes"


def strip(analysis, nx=8, thickness=0.01, young=1e7, **sections):
    return {
        "analysis": analysis,
        "mesh": {"file": str(MESHES / "cantilever.geo"), "parameters": {"nx": nx, "ny": 2, "length": 1.0, "width": 0.25}},
        "material": [{"type": "isotropic", "young": young, "poisson": 0.0, "thickness": thickness, "density": 100.0}],
        "support": [{"type": "clamped", "group": "clamp"}],
        **sections,
    }
