#!/usr/bin/python3
"""Checks that includes point one way through the layers and that each third-party library stays in its place."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

# A layer may include itself and these.
LAYERS = {
    "base": set(),
    "mesh": {"base"},
    "energy": {"mesh", "base"},
    "geometry": {"mesh", "base"},
    "adapt": {"geometry", "mesh", "base"},
    "contact": {"energy", "geometry", "mesh", "base"},
    "untangle": {"contact", "geometry", "mesh", "base"},
    "system": {"contact", "energy", "geometry", "mesh", "base"},
    "linear": {"system", "mesh", "base"},
    "solve": {"linear", "system", "mesh", "base"},
    "formats": {"geometry", "mesh", "base"},
    "results": {"mesh", "base"},
    "manikin": {"geometry", "mesh", "base"},
    "pattern": {"results", "formats", "geometry", "mesh", "base"},
    "input": {"solve", "linear", "system", "energy", "results", "formats", "mesh", "base"},
    "fit": {"input", "energy", "mesh", "base"},
    "picture": {"adapt", "results", "formats", "geometry", "mesh", "base"},
    "gmsh": {"results", "formats", "mesh", "base"},
    "setup": {"input", "pattern", "results", "formats", "solve", "linear", "system", "untangle", "contact", "adapt", "energy", "geometry", "mesh", "base"},
    "record": {"setup", "input", "results", "formats", "solve", "linear", "system", "contact", "energy", "geometry", "mesh", "base"},
    "remesh": {"record", "setup", "input", "results", "solve", "linear", "system", "contact", "adapt", "energy", "geometry", "mesh", "base"},
    # With what is behind the interface of the library, include/voile/*.hpp.
    "simulation": {"remesh", "record", "setup", "input", "pattern", "results", "formats", "solve", "linear", "system", "untangle", "contact", "adapt", "energy", "geometry", "mesh", "base"},
    "python": set(),
    "cli": {"simulation", "remesh", "record", "setup", "fit", "input", "picture", "manikin", "pattern", "results", "formats", "solve", "linear", "system", "energy", "geometry", "mesh", "base"},
}

# Header -> files that may include it, as "<layer>/<file without suffix>" patterns. The first match counts.
THIRD_PARTY = [
    (r"pybind11/.*|petsc4py/.*", r"python/core"),
    (r"petsc.*\.h", r"base/petsc.*|system/.*|linear/.*|solve/.*|input/.*|setup/.*|record/.*|remesh/.*|simulation/.*|cli/.*"),
    (r"slepc.*\.h", r"solve/.*"),
    (r"metis\.h", r"mesh/partition|.*/mumps.*"),
    (r"[sd]mumps_c\.h", r".*/mumps.*"),
    (r"hdf5.*\.h|H5.*\.h", r"results/.*"),
    (r"CGAL/.*", r"geometry/intersections|geometry/closest_triangle|geometry/implicit_surface|geometry/triangle_division|formats/(triangle_file|polygon_split)"),
    (r"gmsh\.h(_cwrap)?", r"gmsh/.*"),
    (r"toml\+\+/.*", r"input/case.*|fit/sheet.*|picture/recording"),
    (r"embree3/.*", r"picture/tracing"),
    (r"stb/.*", r"picture/truetype"),
    (r"png\.h", r"picture/image"),
    (r"webp/.*|gif_lib\.h", r"picture/animation"),
    (r"muParser\.h", r"input/case_expression"),
    (r"mpi\.h", r"base/mpi.*|cli/main|simulation/.*"),
    (r"pugixml\.hpp", r"pattern/svg"),
    (r"nlohmann/.*", r"cli/.*|setup/.*|record/.*|remesh/.*|simulation/.*|input/.*|pattern/garmentcode|picture/export_gltf|picture/viewer"),
    (r"CLI/.*", r"cli/.*"),
    (r"boost/math/.*", r"pattern/curve"),
    (r"Eigen/.*", r".*"),
    (r"unsupported/Eigen/.*", r"fit/least_squares"),
    (r"fmt/.*", r".*"),
    (r"dlfcn\.h", r".*/mumps.*|base/(threads|shipped_files)|cli/doctor"),
    (r"xmmintrin\.h", r".*/mumps.*"),
    (r"unistd\.h|fcntl\.h|sys/.*\.h", r"formats/.*|results/.*|cli/.*|setup/.*|record/.*|simulation/.*|gmsh/.*|input/.*|base/.*"),
    (r"linux/.*\.h|poll\.h", r"base/.*"),
    (r"spawn\.h", r"cli/.*"),
    (r"doctest/.*", r"(?!)"),  # tests only
]
# It prints the versions of all libraries.
EXEMPT = {"cli/version"}

STANDARD = set(
    """algorithm any array atomic barrier bit bitset cassert cctype cerrno cfenv cfloat charconv chrono cinttypes climits clocale
    cmath compare complex concepts condition_variable coroutine csetjmp csignal cstdarg cstddef cstdint cstdio cstdlib cstring
    ctime cuchar cwchar cwctype deque exception execution filesystem format forward_list fstream functional future
    initializer_list iomanip ios iosfwd iostream istream iterator latch limits list locale map memory memory_resource mutex new
    numbers numeric optional ostream queue random ranges ratio regex scoped_allocator semaphore set shared_mutex
    source_location span sstream stack stdexcept stop_token streambuf string string_view strstream syncstream system_error
    thread tuple type_traits typeindex typeinfo unordered_map unordered_set utility valarray variant vector version""".split())

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
# Raw MPI belongs to base/mpi; the program itself starts and ends MPI.
MPI_CALL = re.compile(r"\bP?MPI_[A-Z][a-z]\w*\s*\(")
MPI_START = re.compile(r"\bMPI_(Init|Init_thread|Initialized|Finalize|Finalized|Abort|Comm_f2c)\s*\(")


def without_comments(text):
    keep_lines = lambda m: "\n" * m.group(0).count("\n")
    return re.sub(r"//[^\n]*", "", re.sub(r"/\*.*?\*/", keep_lines, text, flags=re.S))


def check_third_party(header, layer_file):
    for pattern, allowed in THIRD_PARTY:
        if re.fullmatch(pattern, header):
            if re.fullmatch(allowed, layer_file) or layer_file in EXEMPT:
                return None
            return f"<{header}> may only be included by {allowed}"
    if header in STANDARD:
        return None
    return f"<{header}> is neither a standard header nor in the table of {Path(__file__).name}"


def check_project(header, path, layer):
    """Own room: "x.hpp"; another: "room/x.hpp", unless it is private; the library's interface: "voile/x.hpp"."""
    parts = header.split("/")
    if parts[0] == "voile" and len(parts) == 2:
        if not (ROOT / "include" / header).is_file():
            return f'"{header}": there is no such file'
        # What is thrown is the same inside and outside.
        return None if header == "voile/errors.hpp" or layer in ("simulation", "python") else f"{layer} must not include the library's interface ({header})"
    if len(parts) == 1:
        return None if (path.parent / header).is_file() else f'"{header}": there is no such file beside it; those of other rooms are included as "<room>/x.hpp"'
    if len(parts) != 2 or parts[0] not in LAYERS:
        return f'"{header}": unknown room'
    if not (ROOT / "src" / header).is_file():
        return f'"{header}": there is no such file'
    if parts[0] == layer:
        return f'"{header}": in its own room it is included as "{parts[1]}"'
    if parts[0] not in LAYERS[layer]:
        return f"{layer} must not include {parts[0]} ({header})"
    if f"private to src/{parts[0]}" in (ROOT / "src" / header).read_text().replace("\n// ", " ").lower():
        return f"{header} is private to its room"
    return None


def check_file(path, layer):
    layer_file = f"{layer}/{path.stem}"
    for number, line in enumerate(without_comments(path.read_text()).splitlines(), 1):
        match = INCLUDE.match(line)
        problem = None
        if match:
            bracket, header = match.groups()
            is_own = bracket == '"' or header.startswith("voile/")
            problem = check_project(header, path, layer) if is_own else check_third_party(header, layer_file)
        elif MPI_CALL.search(line) and not layer_file.startswith("base/mpi") and layer_file not in EXEMPT:
            if not (layer_file in ("cli/main", "simulation/session", "python/core") and not MPI_CALL.search(MPI_START.sub("", line))):
                problem = "raw MPI call outside base/mpi: " + line.strip()
        if problem:
            yield f"{path.relative_to(ROOT)}:{number}: {problem}"


def check_imports():
    """What a script needs from the start must be a package that the two commands install."""
    scripts = [path for folder in ("tests", "runs", "python") for path in (ROOT / folder).rglob("*.py")
               if path.parent.name != "readers"]  # those run where the readers are
    own = {path.stem for path in scripts} | {"voile"}
    packages = (ROOT / "runs/lib/setup.sh").read_text().split('say()')[0]
    for path in scripts:
        for name in re.findall(r"^(?:import|from) (\w+)", path.read_text(), re.MULTILINE):
            package = {"PIL": "python3-pil"}.get(name, f"python3-{name}")
            if name not in own | sys.stdlib_module_names and not re.search(rf"\b{package}\b", packages):
                yield f"{path.relative_to(ROOT)}: {name}: {package} is not installed by runs/lib/setup.sh"


def main():
    problems, count = list(check_imports()), 0
    for base in (ROOT / "include" / "voile", ROOT / "src"):
        for path in sorted(base.rglob("*")):
            if path.suffix not in (".hpp", ".cpp", ".h"):
                continue
            parts = path.relative_to(base).parts
            layer = parts[0] if len(parts) > 1 else "simulation"
            count += 1
            if layer not in LAYERS:
                problems.append(f"{path.relative_to(ROOT)}: '{layer}' is no layer")
                continue
            problems += check_file(path, layer)
    print("\n".join(problems) if problems else f"{count} files: includes follow the layers")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
