"""A table of named columns: history.csv, modes.csv."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt


class History:
    """A CSV file with a header line; lines before it that start with # are comments. history["time"] is a column."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        if self.path.exists() and not self.path.is_file():
            raise ValueError(f"{path}: this is a folder, a pipe or a device, and no table")
        lines = self.path.read_text().splitlines()
        self.comments = [line.lstrip("# ") for line in lines if line.startswith("#")]
        rows = list(csv.reader(line for line in lines if line.strip() and not line.startswith("#")))
        if not rows:
            raise ValueError(f"{path}: the table is empty")
        self.names = [name.strip() for name in rows[0]]
        # A run that was killed may leave half a line at the end. A value that does not exist is empty.
        values = [[float(x or "nan") for x in row] for row in rows[1:] if len(row) == len(self.names)]
        self.values = np.array(values).reshape(len(values), len(self.names))

    def __len__(self) -> int:
        return len(self.values)

    def __contains__(self, name: str) -> bool:
        return name in self.names

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if name not in self.names:
            raise KeyError(f"{self.path}: there is no column '{name}'; there are {', '.join(self.names)}")
        return self.values[:, self.names.index(name)]
