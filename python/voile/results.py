"""Results of a run: steps, their fields, meshes and obstacles, whether the run has ended, goes on or was killed.

    results = Results("results/slit_annulus")
    last = results[-1]
    print(last.load_factor, abs(last["displacement"]).max(), last.mesh.group("tip"))

The layout of the files is in docs/reference/results.md.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from .history import History

Array = npt.NDArray[Any]

NAME = "results.vtkhdf"
PARTS = {"vertex": "VTKHDF/PointData", "triangle": "VTKHDF/CellData"}


def text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


@contextmanager
def opened(file: Path, index: bool | None = None) -> Iterator[h5py.File]:
    """A file to read; ValueError that names it if it is damaged, and, unless `index` is None, if its data are not all in itself,
    which a stranger's file is not to have read. `index`: of a run that has not ended, which names the files of its steps; these
    are opened by name instead."""
    if file.exists() and not file.is_file():
        raise ValueError(f"{file}: this is a pipe, a socket or a device")
    try:
        with h5py.File(file, "r") as data:
            if index is not None:
                _refuse_foreign(data, ("/voile/epochs", "/voile/obstacles", "/voile/steps/obstacle_positions", "/VTKHDF") if index else ())
            yield data
    except FileNotFoundError:
        raise
    except (OSError, KeyError, RuntimeError) as error:  # as h5py names neither the file nor what is wrong with it
        raise ValueError(f"{file}: damaged, or not results of Voile: {error}") from None


def _refuse_foreign(group: h5py.Group, but: tuple[str, ...]) -> None:
    for name in group:
        path = f"{group.name.rstrip('/')}/{name}"
        if path in but:
            continue
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{group.file.filename}: '{path}' is a link, perhaps to another file; it is not read")
        item = group[name]
        if isinstance(item, h5py.Group):
            _refuse_foreign(item, but)
        elif isinstance(item, h5py.Dataset) and (item.is_virtual or item.external):
            raise ValueError(f"{group.file.filename}: '{path}' has its values in other files; it is not read")


class Mesh:
    """The mesh of an epoch: positions at the start, triangles, the rest positions of their corners (those of a garment lie in
    its panels), groups and the rank that each vertex and triangle was on."""

    def __init__(self, record: h5py.Group) -> None:
        self.positions, self.triangles = record["positions"][...], record["triangles"][...]
        self.unit = text(record["positions"].attrs["unit"])
        self.rest = record["rest"][...].reshape(-1, 3, 3) if "rest" in record else self.positions[self.triangles]
        self.source = text(record.attrs["source"])
        self.partition = {name: data[...] for name, data in record["partition"].items()}
        groups = [record["groups"][name] for name in sorted(record["groups"])]
        self.groups = {(text(g.attrs["name"]), int(g.attrs["dimension"])): {k: g[k][...] for k in g} for g in groups}

    def group(self, name: str, dimension: int | None = None) -> Array:
        """Numbers of the members of a group: triangles of a surface, otherwise vertices."""
        for (other, d), members in self.groups.items():
            if other == name and dimension in (None, d):
                return members["triangles" if d == 2 else "vertices"]
        raise KeyError(f"no group {name!r} of dimension {dimension}; there are {sorted(self.groups)}")


class Step:
    """One recorded state. step["displacement"] is a field as the program writes it: a row per vertex or triangle."""

    def __init__(self, results: Results, place: int, number: int, time: float, load_factor: float, epoch: int) -> None:
        self.results, self.place, self.number, self.epoch = results, place, int(number), int(epoch)
        self.time, self.load_factor = float(time), float(load_factor)

    @property
    def mesh(self) -> Mesh:
        return self.results.mesh(self.epoch)

    @property
    def positions(self) -> Array:
        """Where the vertices are."""
        return self.mesh.positions + self["displacement"]

    @property
    def obstacles(self) -> Array:
        """Where the vertices of obstacles are (rows of x, y, z); at rest if none moves, and no rows if there are none."""
        moving = self.results._obstacles_of(self.place)
        return self.results.obstacles.get("positions", np.empty((0, 3))) if moving is None else moving

    def names(self) -> list[str]:
        return self.results._fields_of(self.place)

    def unit(self, name: str) -> str:
        """Unit of a field."""
        return self.results._unit(self.place, self._known(name))

    def on_vertices(self, name: str) -> bool:
        """Whether a field has a row for each vertex; otherwise for each triangle."""
        return self.results._on_vertices(self.place, self._known(name))

    def to_pyvista(self) -> Any:
        """The sheet at this step as pyvista.PolyData with all fields; needs the package pyvista."""
        try:
            import pyvista
        except ImportError:
            raise ImportError("to_pyvista() needs the package pyvista: pip install pyvista") from None
        triangles = self.mesh.triangles
        sheet = pyvista.PolyData(self.positions, np.column_stack([np.full(len(triangles), 3), triangles]).ravel())
        for name in self.names():
            values = self[name]
            (sheet.point_data if self.on_vertices(name) else sheet.cell_data)[name] = values
        return sheet

    def __contains__(self, name: str) -> bool:
        return name in self.names()

    def __getitem__(self, name: str) -> Array:
        return self.results._field(self.place, self.epoch, self._known(name))

    def _known(self, name: str) -> str:
        if name not in self:
            raise KeyError(f"step {self.number} has no {name!r}; it has {self.names()}")
        return name


class Results:
    """A list of steps. `place`: the folder of the results (of a run in stages that of a stage, of modes `modes` in it) or the file
    in it; it is opened for each look."""

    def __init__(self, place: str | os.PathLike[str]) -> None:
        place = Path(place)
        self.file = place / NAME if place.is_dir() else place
        if not self.file.is_file():
            inside = sorted(f.parent.name for f in place.glob(f"*/{NAME}")) if place.is_dir() else []
            raise FileNotFoundError(f"{self.file} is not there" + (f"; the folder has results of: {', '.join(inside)}" if inside else ""))
        self._meshes: dict[int, Mesh] = {}
        with opened(self.file) as data:
            if not isinstance(data.get("voile", getlink=True), h5py.HardLink):
                raise ValueError(f"{self.file}: 'voile' is missing, or a link perhaps to another file; it is not read")
            self.complete = bool(data["voile"].attrs["complete"])
        with opened(self.file, index=not self.complete) as data:
            own = data["voile"]
            table = own["steps"]
            columns = [table[name][...] for name in ("number", "time", "load_factor", "epoch")]
            self.named = len(columns[0])
            self.steps = [Step(self, i, *row) for i, row in enumerate(zip(*columns))]
            self._paths = self._fields(data) if self.complete else {}
            self._has = {name: flags[...] for name, flags in table.get("has", {}).items()}
        while not self.complete and self._file(len(self.steps)).is_file():  # the index does not name them yet
            with opened(self._file(len(self.steps)), index=False) as data:
                values = [data.attrs[name] for name in ("step", "time", "load_factor", "epoch")]
            self.steps.append(Step(self, len(self.steps), *values))

    def __len__(self) -> int:
        return len(self.steps)

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    def __getitem__(self, i: int) -> Step:
        try:
            return self.steps[i]
        except IndexError:
            remedy = "step() takes the number that the program prints"
            raise IndexError(f"{self.file}: there is no place {i} in a list of {len(self)} steps; {remedy}") from None

    def step(self, number: int) -> Step:
        """The step of that number, which the program prints; not its place in the list."""
        for s in reversed(self.steps):
            if s.number == number:
                return s
        raise KeyError(f"no step {number}; there are {[s.number for s in self.steps]}")

    @property
    def epochs(self) -> list[int]:
        """Numbers of the meshes that steps are on, in order."""
        return sorted({s.epoch for s in self.steps})

    @cached_property
    def history(self) -> History:
        """Columns of history.csv as arrays; of the run as it is now."""
        return History(self.file.parent / "history.csv")

    @property
    def times(self) -> list[float]:
        return [s.time for s in self.steps]

    def mesh(self, epoch: int = 0) -> Mesh:
        if epoch not in self._meshes:
            if self.complete:
                with opened(self.file) as data:
                    self._meshes[epoch] = Mesh(data[f"voile/epochs/{epoch:06d}"])
            else:
                with opened(self.file.parent / "steps" / f"epoch_{epoch:06d}.h5", index=False) as data:
                    self._meshes[epoch] = Mesh(data["mesh"])
        return self._meshes[epoch]

    @cached_property
    def obstacles(self) -> dict[str, Any]:
        """{"names", "positions" at rest, "triangles", "obstacle" of each triangle}; empty if there are none."""
        where, at = (self.file, "voile/obstacles") if self.complete else (self.file.parent / "steps" / "obstacles.h5", "obstacles")
        if not where.is_file():
            return {}
        with opened(where, index=False) as data:
            if at not in data:
                return {}
            found = {name: values[...] for name, values in data[at].items()}
        return {**found, "names": [text(n) for n in found["names"]], "positions": found["positions"].astype(float)}

    def replace(self, place: int, name: str, values: Array) -> None:
        """Writes another field into a step of a finished run."""
        path, begin, rows = self._where(place, self.steps[place].epoch, name)
        with h5py.File(self.file, "r+") as data:
            data[path][begin:begin + rows] = values

    def _file(self, place: int) -> Path:
        return self.file.parent / "steps" / f"{place:06d}.h5"

    @staticmethod
    def _fields(data: h5py.File) -> dict[str, str]:
        """Path of each field by its name."""
        found = {}
        for part in PARTS.values():
            for name in data.get(part, {}):
                path = f"{part}/{name}"
                if "unit" in data[path].attrs:
                    found[text(data[path].attrs["name"])] = path
        return found

    def _fields_of(self, place: int) -> list[str]:
        if self.complete:
            return [name for name, flags in self._has.items() if flags[place]]
        with opened(self._file(place), index=False) as data:
            return list(data["fields"])

    def _unit(self, place: int, name: str) -> str:
        if not self.complete:
            with opened(self._file(place), index=False) as data:
                return text(data["fields"][name].attrs["unit"])
        with opened(self.file) as data:
            return text(data[self._paths[name]].attrs["unit"])

    def _on_vertices(self, place: int, name: str) -> bool:
        if not self.complete:
            with opened(self._file(place), index=False) as data:
                return text(data["fields"][name].attrs["centre"]) == "vertex"
        return "/PointData/" in self._paths[name]

    def _where(self, place: int, epoch: int, name: str) -> tuple[str, int, int]:
        """(path, first row, number of rows) of a field in the one file."""
        path, mesh = self._paths[name], self.mesh(epoch)
        kind, array = path.split("/")[1:]
        with opened(self.file) as data:
            begin = int(data[f"VTKHDF/Steps/{kind}Offsets/{array}"][place])
        return path, begin, len(mesh.positions if kind == "PointData" else mesh.triangles)

    def _field(self, place: int, epoch: int, name: str) -> Array:
        if not self.complete:
            with opened(self._file(place), index=False) as data:
                return data["fields"][name][...]
        path, begin, rows = self._where(place, epoch, name)
        with opened(self.file) as data:
            return data[path][begin:begin + rows]

    def _obstacles_of(self, place: int) -> Array | None:
        if not self.complete:
            with opened(self._file(place), index=False) as data:
                return data["obstacles"][...].astype(float) if "obstacles" in data else None
        with opened(self.file) as data:
            if "obstacle_positions" not in data["voile/steps"]:
                return None
            rows = len(data["voile/obstacles/positions"])
            return data["voile/steps/obstacle_positions"][place * rows:(place + 1) * rows].astype(float)
