"""Makes a wheel of what `cmake --install` brings (PEP 517), with nothing but the standard library.

pip install .                                          builds in build-wheel
pip install . --config-settings build=FOLDER          takes a build that is there, of the same Python
pip install . --config-settings cmake=-DNAME=VALUE    one more option of CMake

Modules go to site-packages; programs, library, fabrics and examples to bin, lib and share of the environment.
"""

import base64
import csv
import hashlib
import io
import os
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def metadata():
    p = project()
    lines = ["Metadata-Version: 2.1", f"Name: {p['name']}", f"Version: {p['version']}", f"Summary: {p['description']}",
             f"License: {p['license']['text']}", f"Requires-Python: {p['requires-python']}", "Description-Content-Type: text/markdown"]
    lines += [f"Requires-Dist: {name}" for name in p["dependencies"]]
    for extra, names in p["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}"] + [f'Requires-Dist: {name}; extra == "{extra}"' for name in names]
    return "\n".join(lines) + "\n\n" + (ROOT / p["readme"]).read_text()


def install(prefix, settings):
    """Builds what is not built, and installs it below the prefix; returns the folder of the modules there."""
    build = Path(settings.get("build", ROOT / "build-wheel")).resolve()
    options = settings.get("cmake", [])
    options = [options] if isinstance(options, str) else options
    if not (build / "CMakeCache.txt").is_file():
        # The Python that the environment comes from has the headers.
        python = getattr(sys, "_base_executable", sys.executable)
        call(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DVOILE_TESTS=OFF", f"-DPython3_EXECUTABLE={python}", *options])
    call(["cmake", "--build", build, "-j", str(os.cpu_count() or 1)])
    for component in ("voile", "python3", "examples"):
        call(["cmake", "--install", build, "--prefix", prefix, "--strip", "--component", component])
    return next(Path(prefix).glob("lib/python3*/*-packages/voile/__init__.py")).parents[1]


def call(command):
    """What is printed goes to the errors: pip reads the output."""
    subprocess.run(command, check=True, stdout=sys.stderr)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    p = project()
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    stem = f"{p['name']}-{p['version']}"
    name = f"{stem}-{tag}-{tag}-{platform}.whl"
    records = []
    with tempfile.TemporaryDirectory() as prefix, zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        packages = install(prefix, config_settings or {})

        def add(place, data, mode=0o644):
            info = zipfile.ZipInfo(place)
            info.external_attr = (0o100000 | mode) << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(info, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            records.append((place, f"sha256={digest}", len(data)))

        files = sorted(f for f in Path(prefix).rglob("*") if f.is_file())
        linked = {f.resolve() for f in files if f.is_symlink()}  # a wheel has no links: the library is kept by its shortest name
        for file in files:
            if file in linked:
                continue
            inside = file.is_relative_to(packages)
            place = file.relative_to(packages) if inside else Path(f"{stem}.data/data") / file.relative_to(prefix)
            add(str(place), file.read_bytes(), file.stat().st_mode & 0o777)
        add(f"{stem}.dist-info/METADATA", metadata().encode())
        add(f"{stem}.dist-info/WHEEL", f"Wheel-Version: 1.0\nGenerator: voile\nRoot-Is-Purelib: false\nTag: {tag}-{tag}-{platform}\n".encode())
        table = io.StringIO()
        csv.writer(table, lineterminator="\n").writerows([*records, (f"{stem}.dist-info/RECORD", "", "")])
        wheel.writestr(f"{stem}.dist-info/RECORD", table.getvalue())
    return name

