"""What drawings of surfaces with matplotlib need: normals, and a perspective camera with a lamp. Whole pictures: voile render."""

import numpy as np


def normals_and_areas(corners):
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(length, 1e-300)[:, None], 0.5 * length


class Camera:
    """Perspective view from a direction given by angles in degrees, aimed at the middle of some points."""

    def __init__(self, points, elevation, azimuth):
        e, a = np.radians(elevation), np.radians(azimuth)
        self.back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])  # towards the viewer
        self.right = np.array([-np.sin(a), np.cos(a), 0.0])
        self.up = np.cross(self.back, self.right)
        low, high = points.min(axis=0), points.max(axis=0)
        self.target = 0.5 * (low + high)
        self.distance = 3.2 * np.linalg.norm(high - low)

    def project(self, points):
        """Plane coordinates (..., 2) and nearness to the viewer (...)."""
        x = points - self.target
        near = x @ self.back
        scale = self.distance / (self.distance - near)
        return np.stack([x @ self.right * scale, x @ self.up * scale], axis=-1), near

    def lamp(self):
        direction = 0.75 * self.back + 0.55 * self.up + 0.45 * self.right
        return direction / np.linalg.norm(direction)
