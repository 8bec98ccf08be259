"""Decks that CalculiX and `voile init --from` read: problems of shells on a mesh of elements of eight nodes, or of four."""

import math

import numpy as np


class Deck:
    """A mapped rectangle of n x m cells, of elements of eight nodes or four."""

    def __init__(self, shape, n, m, eight, closed=False):
        self.points, self.number = [], {}
        fine = 2 if eight else 1
        self.last, self.closed = (fine * n, fine * m), closed
        self.cells = []
        for j in range(m):
            for i in range(n):
                a, b = fine * i, fine * j
                corners = [(a, b), (a + fine, b), (a + fine, b + fine), (a, b + fine)]
                middles = [(a + 1, b), (a + 2, b + 1), (a + 1, b + 2), (a, b + 1)] if eight else []
                self.cells.append([self.node(shape, k) for k in corners + middles])
        self.kind, self.sets = "S8R" if eight else "S4", {}

    def node(self, shape, key):
        if self.closed:
            key = (key[0] % self.last[0], key[1])
        if key not in self.number:
            self.number[key] = len(self.points) + 1
            self.points.append(shape(key[0] / self.last[0], key[1] / self.last[1]))
        return self.number[key]

    def along(self, side):
        """Nodes of a side in order: 'u0', 'u1', 'v0' or 'v1'."""
        axis, end = (0 if side[0] == "u" else 1), (self.last[0 if side[0] == "u" else 1] if side[1] == "1" else 0)
        keys = sorted((k for k in self.number if k[axis] == end), key=lambda k: k[1 - axis])
        return [self.number[k] for k in keys]

    def spread(self, side):
        """Fractions of a line load at its nodes."""
        nodes = self.along(side)
        share = np.zeros(len(nodes))
        step, rule = (2, (1, 4, 1)) if self.kind == "S8R" else (1, (1, 1))
        for k in range(0, len(nodes) - 1, step):
            share[k:k + step + 1] += np.array(rule) / sum(rule)
        return dict(zip(nodes, share / share.sum()))

    def text(self, material, supports, step):
        lines = ["*NODE"] + [", ".join([str(k + 1), *(f"{round(c, 9) + 0.0}" for c in x)]) for k, x in enumerate(self.points)]  # 1e-15 instead of 0 makes CalculiX less exact
        lines += [f"*ELEMENT, TYPE={self.kind}, ELSET=SHELL"]
        lines += [", ".join(str(k) for k in [e + 1] + cell) for e, cell in enumerate(self.cells)]
        for name, nodes in self.sets.items():
            lines += [f"*NSET, NSET={name}"] + [f"{k}," for k in nodes]
        return "\n".join(lines + material + supports + step) + "\n"


def elastic(young, poisson, thickness, density=None):
    lines = ["*MATERIAL, NAME=M", "*ELASTIC", f"{young}, {poisson}"]
    return lines + (["*DENSITY", str(density)] if density else []) + ["*SHELL SECTION, ELSET=SHELL, MATERIAL=M", str(thickness)]


def static(forces, large):
    lines = [f"*STEP{', NLGEOM, INC=1000' if large else ''}", "*STATIC"] + (["0.1, 1"] if large else [])
    return lines + ["*CLOAD"] + [f"{node}, {axis}, {value:.12g}" for node, axis, value in forces] + ["*NODE PRINT, NSET=SEEN", "U", "*END STEP"]


def strip(n, eight):
    """Cantilever under an end shear of 4: elastica, w = 6.6996 (runs/reference/cantilever_shear.csv)."""
    deck = Deck(lambda u, v: (10 * u, v, 0), n, max(2, n // 4), eight)
    deck.sets = {"ROOT": deck.along("u0"), "SEEN": [deck.along("u1")[0]]}
    forces = [(k, 3, 4 * f) for k, f in deck.spread("u1").items()]
    return deck.text(elastic(1.2e6, 0, 0.1), ["*BOUNDARY", "ROOT, 1, 6"], static(forces, True)), (2, elastica())


def elastica():
    """Tip deflection of an inextensible cantilever, E I = 100, L = 10, dead load 4, by shooting."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def end(k):
        return solve_ivp(lambda s, y: [y[1], -4 / 100 * math.cos(y[0]), math.sin(y[0])], (0, 10), [0, k, 0], rtol=1e-11, atol=1e-12).y[:, -1]
    return end(brentq(lambda k: end(k)[1], 0.1, 1.0))[2]


def annulus(n, eight):
    """Slit annulus lifted at its free end by 3.2: W_B = 17.490, between what finest meshes of both go to, 17.484 and 17.495. The published
    17.528 (Sze, Liu & Lo 2004) is that of 10 x 80 elements."""
    def shape(u, v):
        radius, angle = 6 + 4 * u, 2 * math.pi * v
        return radius * math.cos(angle), radius * math.sin(angle), 0
    deck = Deck(shape, max(2, n // 4), 2 * n, eight)
    deck.sets = {"ROOT": deck.along("v1"), "INNER": [deck.along("v0")[0]], "SEEN": [deck.along("v0")[-1]]}
    forces = [(k, 3, 3.2 * f) for k, f in deck.spread("v0").items()]
    return deck.text(elastic(21e6, 0, 0.03), ["*BOUNDARY", "ROOT, 1, 6"], static(forces, True)), (2, 17.490)


def hemisphere(n, eight):
    """Hemisphere with a hole of 18 degrees, pulled and pushed by 400: 8.178 inwards (Sze, Liu & Lo 2004). All of it, as CalculiX is far
    too stiff where it holds rotations on curved sheets."""
    def shape(u, v):
        a, b = 2 * math.pi * u, math.radians(72) * v
        return 10 * math.cos(a) * math.cos(b), 10 * math.sin(a) * math.cos(b), 10 * math.sin(b)
    deck = Deck(shape, 4 * n, n, eight, closed=True)
    rim, top = deck.along("v0"), deck.along("v1")
    quarter = len(rim) // 4
    a, b, c, d = (rim[k * quarter] for k in range(4))
    deck.sets = {"AC": [a, c], "B": [b], "TOP": [top[0]], "SEEN": [b]}
    supports = ["*BOUNDARY", "AC, 2, 3", "B, 1, 1", "TOP, 2, 2"]
    forces = [(a, 1, 400), (c, 1, -400), (b, 2, -400), (d, 2, 400)]
    return deck.text(elastic(6.825e7, 0.3, 0.04), supports, static(forces, True)), (1, -8.178)


def roof(n, eight):
    """Scordelis-Lo roof under its weight, all of it: 0.300601 (series of shell theory without shear, runs/reference/membranes.csv)."""
    def shape(u, v):
        angle = math.radians(80) * (u - 0.5)
        return 25 * math.sin(angle), 50 * v, 25 * math.cos(angle)
    deck = Deck(shape, 2 * n, 2 * n, eight)
    side = deck.along("u1")
    middle = side[len(side) // 2]
    deck.sets = {"ENDS": deck.along("v0") + deck.along("v1"), "SEEN": [middle], "MIDDLE": [middle, deck.along("u0")[len(side) // 2]]}
    supports = ["*BOUNDARY", "ENDS, 1, 1", "ENDS, 3, 3", "MIDDLE, 2, 2"]
    step = ["*STEP", "*STATIC", "*DLOAD", "SHELL, GRAV, 360., 0, 0, -1", "*NODE PRINT, NSET=SEEN", "U", "*END STEP"]
    return deck.text(elastic(4.32e8, 0, 0.25, 1), supports, step), (2, -0.300601)


def plate_modes(n, eight):
    """Fifth frequency of a square plate, hinged all round: 10 pi/2 sqrt(D/(rho h)), thin."""
    deck = Deck(lambda u, v: (u, v, 0), n, n, eight)
    deck.sets = {"RIM": sorted({k for s in ("u0", "u1", "v0", "v1") for k in deck.along(s)}), "SEEN": [1]}
    step = ["*STEP", "*FREQUENCY", "6", "*END STEP"]
    exact = 10 * math.pi / 2 * math.sqrt(2.1e11 * 0.005**3 / (12 * (1 - 0.09)) / (7800 * 0.005))
    return deck.text(elastic(2.1e11, 0.3, 0.005, 7800), ["*BOUNDARY", "RIM, 1, 3"], step), ("mode", 5, exact)


def plate_buckling(n, eight):
    """Lowest buckling load of a square plate, hinged all round, pressed along x: 4 pi^2 D / b^2, thin."""
    deck = Deck(lambda u, v: (u, v, 0), n, n, eight)
    deck.sets = {"RIM": sorted({k for s in ("u0", "u1", "v0", "v1") for k in deck.along(s)}), "LEFT": deck.along("u0"), "CORNER": [1]}
    step = ["*STEP", "*BUCKLE", "1, 1e-6", "*CLOAD"] + [f"{k}, 1, {-1000 * f:.12g}" for k, f in deck.spread("u1").items()] + ["*END STEP"]
    exact = 4 * math.pi**2 * 2.1e11 * 0.005**3 / (12 * (1 - 0.09)) / 1000
    return deck.text(elastic(2.1e11, 0.3, 0.005), ["*BOUNDARY", "RIM, 3, 3", "LEFT, 1, 1", "CORNER, 2, 2"], step), ("factor", 1, exact)


PROBLEMS = {f.__name__: f for f in (strip, annulus, hemisphere, roof, plate_modes, plate_buckling)}
