"""Case files as nested dictionaries.

    case = Case.read("runs/slit_annulus/case.toml")
    coarse = case.changed({"mesh.parameters.n_circ": 40, "load.0.vector": None})
    coarse.write("results/coarse.toml")
"""

from __future__ import annotations

import copy
import json
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any


# Keys of sections that name files.
FILES = {"mesh": ("file", "start"), "panel": ("file",), "material": ("fabric", "interlining"), "imperfection": ("results",),
         "obstacle": ("file", "landmarks", "frames"), "remesh": ("background",)}


class Case(dict[str, Any]):
    """A case as its sections and keys, which docs/reference/case.md lists. File names are relative to the folder it is
    written to, or absolute."""

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Case:
        """A case file, with the names of files made absolute, so that it can be written elsewhere."""
        with open(path, "rb") as file:
            case = cls(tomllib.load(file))
        folder = Path(path).parent.resolve()
        _make_absolute(case, folder)
        for stage in case.get("stage", []):
            _make_absolute(stage, folder)
        return case

    @classmethod
    def from_toml(cls, text: str) -> Case:
        return cls(tomllib.loads(text))

    def changed(self, changes: Mapping[str, Any]) -> Case:
        """A copy with values replaced. Keys are paths such as "mesh.parameters.n" or "load.0.vector"; the value None removes
        the key."""
        result = copy.deepcopy(self)
        for path, value in changes.items():
            *parents, last = path.split(".")
            node: Any = result
            for name in parents:
                if value is None and not isinstance(node, list) and name not in node:
                    break  # what is not there need not be removed
                node = node[int(name)] if isinstance(node, list) else node.setdefault(name, {})
            else:
                if value is None and not isinstance(node, list):
                    node.pop(last, None)
                elif value is None:
                    node.pop(int(last))
                elif isinstance(node, list):
                    node[int(last)] = value
                else:
                    node[last] = value
        return result

    def to_toml(self) -> str:
        """Plain keys, then one section per table."""
        lines = [f"{_key(k)} = {_value(v)}" for k, v in self.items() if not (_is_section(v) or (isinstance(v, list) and not v))]
        for name, value in self.items():
            if isinstance(value, Mapping):
                lines += ["", f"[{_key(name)}]"] + [f"{_key(k)} = {_value(v)}" for k, v in value.items()]
            elif _is_section(value):
                for entry in value:
                    lines += ["", f"[[{_key(name)}]]"] + [f"{_key(k)} = {_value(v)}" for k, v in entry.items()]
        return "\n".join(lines) + "\n"

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Writes the case file, and folders that are missing."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self.to_toml())
        return path


def _make_absolute(sections: Mapping[str, Any], folder: Path) -> None:
    for name, keys in FILES.items():
        entries = sections.get(name, [])
        for entry in entries if isinstance(entries, list) else [entries]:
            for key in keys:
                text = entry.get(key)
                # A fabric may be one that is shipped; frames may be a pattern of names.
                if isinstance(text, str) and (key != "fabric" and key != "interlining" or (folder / text).exists()):
                    entry[key] = str(folder / text)


def _is_section(value: Any) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value))


def _key(name: str) -> str:
    return name if re.fullmatch(r"[\w-]+", name, re.ASCII) else json.dumps(name)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if hasattr(value, "tolist"):  # of NumPy
        return _value(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{value!r} cannot be written in a case file")
