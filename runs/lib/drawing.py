"""Pictures of scripts, drawn by voile render and voile plot and put beside each other by voile sheet."""

import subprocess
import tempfile
from pathlib import Path

from solver import binary, environment


def draw(*words):
    """One command of voile; ends the script if it fails."""
    if subprocess.run([str(binary()), *map(str, words)], env=environment(), check=False).returncode != 0:
        raise SystemExit(f"voile {' '.join(map(str, words))} failed")


def words_of(options):
    """Options of a command: title="x" becomes --title x, mesh=True becomes --mesh."""
    return [w for name, value in options.items() for w in (f"--{name.replace('_', '-')}", value)[: 1 if value is True else 2]]


def plot(file, curves=(), dashed=(), points=(), size=(720, 480), **options):
    """Curves are (table, X, Y) or (table, X, Y, label), as voile plot takes them."""
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    several = [w for option, some in (("--curve", curves), ("--dashed", dashed), ("--points", points)) for c in some
               for w in (option, ":".join(map(str, c)))]
    draw("plot", *several, "--output", file, "--size", f"{size[0]}x{size[1]}", "--quiet", *words_of(options))


def plots(file, diagrams, columns=None):
    """Diagrams (what plot takes) beside each other."""
    with Sheet(file, columns) as sheet:
        for diagram in diagrams:
            plot(sheet.place(), **diagram)


class Sheet:
    """Pictures beside each other: they are written to sheet.place(), one after the other, and put together at the end."""

    def __init__(self, file, columns=None, palette=True):
        self.file, self.pictures = file, []
        self.options = words_of({"columns": columns} if columns else {}) + (["--palette"] if palette else [])

    def __enter__(self):
        self.temporary = tempfile.TemporaryDirectory()
        return self

    def place(self):
        self.pictures.append(Path(self.temporary.name) / f"{len(self.pictures)}.png")
        return self.pictures[-1]

    def __exit__(self, kind, error, trace):
        if kind is None and self.pictures:
            Path(self.file).parent.mkdir(parents=True, exist_ok=True)
            draw("sheet", *self.pictures, "--output", self.file, "--quiet", *self.options)
        self.temporary.cleanup()
