"""Meshes of flat panels that meet at common lines, vertex by vertex."""

import numpy as np
from jittered import write_msh


class Panels:
    """Panels of n x m cells; corners that lie at the same place are one vertex unless `merged` is false."""

    def __init__(self, merged=True):
        self.points, self.cells, self.groups, self._number = [], [], {}, {}
        self.merged = merged

    def add(self, name, origin, along, across, n, m):
        """A panel; its sides `name start`, `end` (along 0 and 1), `low` and `high` (across 0 and 1) are curves."""
        origin, along, across = (np.asarray(v, float) for v in (origin, along, across))
        part = "" if self.merged else name
        at = np.array([[self._vertex(part, origin + along * i / n + across * j / m) for j in range(m + 1)] for i in range(n + 1)])
        cells = []
        for i in range(n):
            for j in range(m):
                a, b, c, d = at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]
                cells += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
        self.cells += cells
        for side, line in (("start", at[0]), ("end", at[-1]), ("low", at[:, 0]), ("high", at[:, -1])):
            self.groups[f"{name} {side}"] = (1, list(zip(line[:-1], line[1:])))
        self.groups[name] = (2, cells)
        return at

    def join(self, name, parts):
        """One curve of several."""
        self.groups[name] = (1, [s for p in parts for s in self.groups[p][1]])

    def point(self, name, vertex):
        self.groups[name] = (0, [(vertex,)])

    def write(self, file):
        return write_msh(file, np.array(self.points), [(name, dimension, np.array(list(dict.fromkeys(map(tuple, members)))))
                                                       for name, (dimension, members) in self.groups.items()])

    def _vertex(self, part, x):
        key = (part, *np.round(x, 9))
        if key not in self._number:
            self._number[key] = len(self.points)
            self.points.append(x)
        return self._number[key]
