#!/usr/bin/python3
"""Builds the Debian packages and the Python wheel, installs them where nothing else is, and runs an example there.

    tests/packages/packages.py                   builds in build-deb, which takes minutes, and needs the network for a system
    tests/packages/packages.py --build FOLDER    a build that is there, configured with -DVOILE_NATIVE=OFF -DVOILE_V3=ON

As root with debootstrap and a mirror of Debian the packages are installed by apt into a bare system of their own (chroot). Elsewhere
they are unpacked into an empty folder, the libraries of each program are looked up, and the programs run from there: the names of
the packages that they depend on are then not tested.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "results" / "packages"
MIRROR = os.environ.get("VOILE_MIRROR", "http://deb.debian.org/debian")
PROGRAMS = ("voile", "voile-gmsh", "voile-manikin", "voile-picture")
# What each package has, among other things.
CONTENTS = {"voile": ["usr/bin/voile", "usr/bin/voile-x86-64-v3", "usr/share/voile/fabrics/wool_tropical.toml", "usr/share/voile/templates/drape/case.toml",
                      "usr/share/man/man1/voile.1"],
            "libvoile-dev": ["usr/include/voile/simulation.hpp"],
            "python3-voile": ["usr/lib/python3.11/dist-packages/voile/__init__.py"],
            "voile-examples": ["usr/share/voile/examples/slit_annulus/case.toml", "usr/share/voile/meshes/annulus.geo"]}
# From a folder of the user's: a picture of an example.
FIRST_PICTURE = """set -e
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -p "$HOME/elsewhere" && cd "$HOME/elsewhere" && rm -rf ring
voile init ring --example slit_annulus
voile check ring/case.toml
voile run ring/case.toml --output ring/run --quiet --set mesh.parameters.n_radial=4 --set mesh.parameters.n_circ=40
voile render ring/run --no-ground --output ring/picture.png
"""
SIMULATE = """import os, voile
os.chdir(os.path.join(os.environ["HOME"], "elsewhere"))
s = voile.Simulation("ring/case.toml")
s.advance()
print("python moves", s.positions().max() > 6, abs(voile.Results("ring/run")[-1]["displacement"]).max() > 10)
"""


class Report:
    failures = 0

    def check(self, good, what):
        print(f"  {'ok  ' if good else 'FAIL'} {what}", flush=True)
        self.failures += not good
        return good


def run(words, **more):
    return subprocess.run([str(w) for w in words], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **more)


def built(folder):
    """A build for packages. Compilers that are found before are used again."""
    if not (folder / "CMakeCache.txt").is_file():
        cached = ["-DCMAKE_C_COMPILER_LAUNCHER=ccache", "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        subprocess.run(["cmake", "-S", ROOT, "-B", folder, *generator, "-DCMAKE_BUILD_TYPE=Release", "-DVOILE_NATIVE=OFF", "-DVOILE_V3=ON", "-DVOILE_TESTS=OFF", *cached], check=True)
    subprocess.run(["cmake", "--build", folder, "-j", str(os.cpu_count())], check=True)
    return folder


def packed(report, build, version):
    """The packages, by name."""
    folder = OUT / "debs"
    shutil.rmtree(folder, ignore_errors=True)
    done = run(["cpack", "-G", "DEB", "-B", folder, "--config", build / "CPackConfig.cmake"], cwd=build)
    report.check(done.returncode == 0, f"cpack: code {done.returncode} {done.stdout[-300:] if done.returncode else ''}")
    debs = {file.name.split("_")[0]: file for file in sorted(folder.glob("*.deb"))}
    report.check(set(debs) == set(CONTENTS), f"packages: {', '.join(debs)}")
    for name, wanted in CONTENTS.items():
        files = run(["dpkg-deb", "-c", debs[name]]).stdout
        missing = [file for file in wanted if f"./{file}\n" not in files + "\n"]
        has = run(["dpkg-deb", "-f", debs[name], "Version"]).stdout.strip()
        depends = run(["dpkg-deb", "-f", debs[name], "Depends"]).stdout.strip()
        report.check(not missing and has == version and depends, f"{name} {has}: {debs[name].stat().st_size / 1e6:.1f} MB, {len(depends.split(','))} dependencies {missing or ''}")
    return debs


def bare_system(root):
    """Whether a bare Debian is there or can be had."""
    if os.geteuid() != 0 or not shutil.which("debootstrap"):
        return False
    if (root / "etc" / "debian_version").is_file():
        return True
    return run(["debootstrap", "--variant=minbase", "bookworm", root, MIRROR]).returncode == 0


def inside(root, script):
    """Runs a script in the system below a root, which has processes of its own."""
    return run(["unshare", "--mount", "--pid", "--fork", f"--mount-proc={root / 'proc'}", "chroot", root, "/bin/sh", "-c", script],
               env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C.UTF-8"})


def check_doctor(report, done):
    """It ran, as the program for this processor."""
    said = "AVX2 or newer" if "avx2" in Path("/proc/cpuinfo").read_text() else "any processor"
    report.check(done.returncode == 0 and said in done.stdout, f"doctor: code {done.returncode} {done.stdout[-300:]}")


def test_in_system(report, root, debs):
    print("a bare Debian 12: packages are installed by apt")
    (root / "packages").mkdir(exist_ok=True)
    for file in debs.values():
        shutil.copy(file, root / "packages")
    names = " ".join(f"/packages/{debs[name].name}" for name in ("voile", "voile-examples", "python3-voile"))
    done = inside(root, f"apt-get update -q && apt-get install -q -y --no-install-recommends --reinstall {names}")
    report.check(done.returncode == 0, f"apt-get install: code {done.returncode} {done.stdout[-400:] if done.returncode else ''}")
    done = inside(root, FIRST_PICTURE)
    report.check(done.returncode == 0 and (root / "root/elsewhere/ring/picture.png").is_file(), f"an example from another folder: code {done.returncode} {done.stdout[-300:] if done.returncode else ''}")
    done = inside(root, f"python3 -c '{SIMULATE}'")
    report.check("python moves True True" in done.stdout, f"Python: {done.stdout.strip()[-300:]}")
    check_doctor(report, inside(root, "cd && voile doctor"))


def test_unpacked(report, debs):
    print("packages are unpacked into an empty folder: their dependencies are those of this system")
    root = OUT / "unpacked"
    shutil.rmtree(root, ignore_errors=True)
    for file in debs.values():
        subprocess.run(["dpkg-deb", "-x", file, root], check=True)
    env = {"PATH": f"{root}/usr/bin:/usr/bin:/bin", "HOME": str(root / "home")}
    (root / "home").mkdir()
    for file in [*(root / "usr/bin" / name for name in PROGRAMS), *root.rglob("libvoile.so.0"), *root.rglob("_core.*.so")]:
        found = run(["ldd", file], env=env).stdout
        report.check("not found" not in found and str(ROOT) not in found.replace(str(root), ""), f"libraries of {file.name}")
    done = run(["/bin/sh", "-c", FIRST_PICTURE], env=env)
    report.check(done.returncode == 0 and (root / "home/elsewhere/ring/picture.png").is_file(), f"an example from another folder: code {done.returncode} {done.stdout[-300:] if done.returncode else ''}")
    check_doctor(report, run(["voile", "doctor"], env=env))
    done = run(["/usr/bin/python3", "-c", SIMULATE], env=env | {"PYTHONPATH": str(root / "usr/lib/python3.11/dist-packages")})
    report.check("python moves True True" in done.stdout, f"Python: {done.stdout.strip()[-300:]}")


def test_wheel(report, build, home):
    """pip install . in an environment whose NumPy and h5py are the system's, of which pip does not find Debian's h5py."""
    folder = OUT / "environment"
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run(["/usr/bin/python3", "-m", "venv", "--system-site-packages", folder], check=True)
    done = run([folder / "bin/pip", "install", "--no-deps", "--config-settings", f"build={build}", ROOT], cwd=OUT)
    report.check(done.returncode == 0, f"pip install .: code {done.returncode} {done.stdout[-400:] if done.returncode else ''}")
    env = {"PATH": f"{folder}/bin:/usr/bin:/bin", "HOME": str(home)}
    done = run(["/bin/sh", "-c", FIRST_PICTURE], env=env)
    report.check(done.returncode == 0, f"the programs of the environment: code {done.returncode} {done.stdout[-300:] if done.returncode else ''}")
    done = run([folder / "bin/python", "-c", SIMULATE + "print(voile.__file__)"], env=env)
    report.check("python moves True True" in done.stdout and str(folder) in done.stdout, f"Python: {done.stdout.strip()[-300:]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=ROOT / "build-deb", help="folder of the build")
    parser.add_argument("--root", type=Path, default=OUT / "system", help="folder of the bare system, which is kept")
    parser.add_argument("--unpack", action="store_true", help="unpack only, without a system")
    arguments = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    report = Report()
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    build = built(arguments.build.resolve())
    debs = packed(report, build, version)
    if not arguments.unpack and bare_system(arguments.root):
        test_in_system(report, arguments.root.resolve(), debs)
    else:
        test_unpacked(report, debs)
    home = OUT / "home"
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    test_wheel(report, build, home)
    print(f"{report.failures} failed")
    return 1 if report.failures else 0


if __name__ == "__main__":
    sys.exit(main())
