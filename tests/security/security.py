#!/usr/bin/python3
"""What a stranger's files may not do: run programs, load libraries, write or empty files, hang. docs/reference/security.md says what they may.

    tests/security/security.py            everything, half a minute
    tests/security/security.py scripts    some of it; --list names all

Each input tries to make a file MARKER, or to change a file `victim` that it must not touch. Neither may happen, whatever the
program answers; and it has to answer at once. Set VOILE to test another program than build/voile.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "python"))

from voile.running import environment, program  # noqa: E402

INPUTS = HERE / "inputs"
OUT = Path(os.environ.get("VOILE_SECURITY_FOLDER", ROOT / "results" / "security"))
PATIENCE = 20  # seconds
VICTIM = "a file of the user's\n"
SCENES = {}


def scene(function):
    SCENES[function.__name__] = function
    return function


class Folder:
    """A stranger's folder in which the user works. Counts what goes wrong."""

    def __init__(self, name):
        self.place = OUT / name
        shutil.rmtree(self.place, ignore_errors=True)
        self.here = self.place / "folder"
        shutil.copytree(INPUTS, self.here)
        self.home = self.place / "home"
        self.home.mkdir()
        self.victim = self.home / "victim"
        self.failures = 0
        self.heal()

    def heal(self):
        self.victim.write_text(VICTIM)

    def check(self, good, what):
        print(f"  {'ok  ' if good else 'FAIL'} {what}", flush=True)
        self.failures += not good

    def harmed(self):
        """What must not have happened."""
        found = [str(p.relative_to(self.place)) for p in self.place.rglob("MARKER*")]
        if not self.victim.is_file() or self.victim.read_text() != VICTIM:
            found.append("the user's file has changed")
        return found

    def execute(self, command, **more):
        """(exit code or "hangs", text, seconds)"""
        env = environment(1) | {"HOME": str(self.home)} | more
        env.pop("PETSC_OPTIONS", None)
        begin = time.time()
        try:
            done = subprocess.run([str(c) for c in command], cwd=self.here, env=env, text=True, errors="replace", timeout=PATIENCE,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        except subprocess.TimeoutExpired:
            return "hangs", "", time.time() - begin
        return done.returncode, " ".join(done.stdout.split()), time.time() - begin

    def voile(self, *words, **more):
        return self.execute([program(), *words], **more)

    def refused(self, what, *words, saying="", **more):
        """The command ends with code 2 and a message, and nothing has happened."""
        code, text, seconds = self.voile(*words, **more)
        harm = self.harmed()
        self.check(code == 2 and saying in text and not harm,
                   f"{what}: code {code}, {seconds:.1f} s{', ' + ', '.join(harm) if harm else ''}: {text[:180]}")

    def case(self, **lines):
        """Writes mine.toml: the case with other lines behind it, or another mesh."""
        text = (self.here / "case.toml").read_text()
        if "mesh" in lines:
            text = text.replace('"flat.msh"', "'" + lines["mesh"] + "'")
        (self.here / "mine.toml").write_text(text + lines.get("more", ""))
        return "mine.toml"

    def options(self, text):
        return self.case(more=f'[petsc]\noptions = "{text}"\n')

    def ran(self, output="out"):
        """A run that has ended, to be tampered with."""
        code, text, _ = self.voile("run", "case.toml", "--output", output, "--overwrite", "--quiet")
        self.check(code == 0, f"a good run: code {code} {text[:120]}")
        return self.here / output


@scene
def options(f):
    """PETSc's options in a case load no libraries and write no files; a .petscrc in the folder is not read."""
    made = subprocess.run(["cc", "-shared", "-fPIC", "-o", f.here / "library.so", f.here / "library.c"]).returncode
    f.check(made == 0, "a library that leaves a marker is made")
    case = f.options("-dll_prepend ./library.so")
    for command in (["check", case], ["info", case], ["run", case, "--output", "out"]):
        f.refused(f"{command[0]}: -dll_prepend", *command, saying="command line")
    for text in ("-ksp_view :MARKER", "-ksp_view_mat binary:MARKER", "-snes_monitor ascii:MARKER", "-ksp_type python -ksp_python_type x",
                 "-log_view :MARKER", "-ksp_monitor_solution draw", "-on_error_attach_debugger", "-options_file more"):
        f.refused(text, "run", f.options(text), "--output", "out", "--overwrite", saying="petsc.options")
    for name in (".petscrc", "petscrc"):
        (f.here / name).write_text("-ksp_view :MARKER\n-dll_prepend ./library.so\n")
        (f.home / name).write_text("-ksp_view :MARKER\n")
    code, text, _ = f.voile("run", "case.toml", "--output", "out", "--overwrite")
    f.check(code == 0 and not f.harmed(), f".petscrc in the folder: code {code} {f.harmed()} {text[:100] if code else ''}")
    code, text, _ = f.voile("run", f.options("-snes_rtol 1e-9 -ksp_view"), "--output", "out", "--overwrite")
    f.check(code == 0 and "KSP Object" in text, f"what tunes a solver or prints is done: code {code}")


def alone(f, script):
    """What the program that reads scripts does of itself, without the search for dangerous commands before it."""
    return f.execute(["bash", "-c", 'exec "$0" "$1" geo 0 0 1 confined 3>&1 >/dev/null 2>&1', program().parent / "voile-gmsh", script],
                     VOILE_READ_SECONDS="3")


@scene
def scripts(f):
    """Scripts of Gmsh run no programs and write no files, whether the search for dangerous commands finds them or not."""
    for script in sorted(f.here.glob("*.geo")):
        name = script.name
        if name == "square.geo":
            continue
        if name != "never_ends.geo":
            f.refused(f"check, {name}", "check", f.case(mesh=name))
        _, answer, seconds = alone(f, name)
        harm = f.harmed()
        f.check(not harm and answer[:1] != "d",
                f"alone, {name}: {answer[:1]!r}, {seconds:.1f} s{', ' + ', '.join(harm) if harm else ''}")
    code, text, _ = f.voile("check", f.case(mesh="square.geo"))
    f.check(code == 0, f"a script that does nothing of this is read: code {code} {text[:100]}")
    f.refused("info, a script that sleeps", "info", "never_ends.geo", saying="VOILE_READ_SECONDS", VOILE_READ_SECONDS="2")
    named = 'a"; SystemCall "touch MARKER"; "b.geo'
    (f.here / named).write_text("DefineConstant[ n = 1 ];\n" + (f.here / "square.geo").read_text())
    for more in ("", "[mesh.parameters]\nn = 2\n"):
        f.refused("a name with quotes", "check", f.case(mesh=named, more=more), saying="quotes")
    code, _, _ = f.voile("check", f.case(mesh="computed.geo"), "--allow-system-call")
    f.check(bool(f.harmed()), f"--allow-system-call: it is done, code {code}")


@scene
def links(f):
    """A results folder with links in it does not lead a run, a picture or an export out of it."""
    out = f.ran()
    for name in ("run.lock", "steps", "resolved_case.toml", "results.vtkhdf", "results.vtkhdf.part", "checkpoint.h5.part", "history.csv", "modes"):
        shutil.rmtree(f.here / "bad", ignore_errors=True)
        shutil.copytree(out, f.here / "bad", symlinks=True)
        (f.here / "bad" / name).unlink(missing_ok=True)
        target = f.victim
        if name in ("steps", "modes"):
            target = f.home / name
            target.mkdir(exist_ok=True)
            (target / "000000.h5").write_text("mine")
            (target / "summary.json").write_text("mine")
        (f.here / "bad" / name).symlink_to(target)
        f.refused(f"run, {name} is a link", "run", "case.toml", "--output", "bad", "--overwrite", saying="symbolic link")
        f.check(target.is_file() or len(list(target.iterdir())) == 2, f"{name}: what it leads to is as it was")
    shutil.rmtree(f.here / "bad")
    shutil.copytree(out, f.here / "bad")
    os.link(f.victim, f.here / "bad" / "run.lock")
    f.refused("run, run.lock is a second name of a file", "run", "case.toml", "--output", "bad", "--overwrite", saying="another name")
    for name, words in (("picture.png", ["render", "--size", "40x30"]), ("results.obj", ["export", "--to", "obj"]), ("view.html", ["view"]),
                        ("plot.svg", ["plot", "--x", "step", "--y", "residual"])):
        (out / name).symlink_to(f.victim)
        f.refused(f"{words[0]}, {name} is a link", words[0], "out", *words[1:], saying="symbolic link")
    (f.here / "case_here").mkdir()
    (f.here / "case_here" / "case.toml").symlink_to(f.home / "MARKER")
    f.refused("init, case.toml is a link to nothing", "init", "case_here")
    (f.here / "typed").symlink_to(out)
    code, _, _ = f.voile("run", "case.toml", "--output", "typed", "--overwrite", "--quiet")
    f.check(code == 0 and not f.harmed(), f"a link that the user names as --output is followed: code {code}")


@scene
def pipes(f):
    """Pipes and devices as a case, mesh, table or results are refused at once, also behind links."""
    os.mkfifo(f.here / "pipe")
    out = f.ran()
    for name in ("pipe.toml", "pipe.msh", "pipe.geo", "pipe.obj", "pipe.inp", "pipe.vtk", "pipe.csv", "pipe.h5", "pipe.dxf", "pipe.pos", "pipe.pc2", "pipe.stl"):
        (f.here / name).symlink_to("pipe")
    saying = "a pipe"
    f.refused("run", "run", "pipe.toml", "--output", "x", saying=saying)
    for ending in ("msh", "geo", "obj", "inp", "vtk"):
        f.refused(f"check, a mesh .{ending}", "check", f.case(mesh=f"pipe.{ending}"), saying=saying)
    f.refused("info", "info", "pipe.msh", saying=saying)
    f.refused("a start", "run", "case.toml", "--set", "mesh.start='pipe.msh'", "--output", "x", saying=saying)
    (f.here / "includes.geo").write_text('Include "pipe";\n' + (f.here / "square.geo").read_text())
    f.refused("a script that includes one", "check", f.case(mesh="includes.geo"), saying=saying)
    for words in (["run", "case.toml", "--output", "x", "--restart", "pipe.h5"], ["plot", "pipe.csv", "--output", "x.svg"], ["render", "pipe.h5"]):
        f.refused(" ".join(words[:2]), *words, saying=saying)
    (out / "results.vtkhdf").unlink()
    (out / "results.vtkhdf").symlink_to(f.here / "pipe")
    f.refused("render, results behind a link", "render", "out", saying=saying)
    f.refused("a device", "run", "/dev/zero", "--output", "x", saying=saying)
    f.refused("a body", "check", f.case(more='[[obstacle]]\nname = "b"\ntype = "mesh"\nfile = "pipe.stl"\n'), saying=saying)


@scene
def foreign_data(f):
    """Results whose data lie in other files (HDF5's links, external storage, virtual datasets) are not read."""
    import h5py
    import numpy as np
    from voile import Results
    out = f.ran()
    good = (out / "results.vtkhdf").read_bytes()
    with h5py.File(f.home / "secret.h5", "w") as secret:
        secret["x"] = np.ones(48)
    os.mkfifo(f.here / "pipe.h5")
    name = "VTKHDF/PointData/displacement"

    def external_link(file):
        del file[name]
        file[name] = h5py.ExternalLink(str(f.here / "pipe.h5"), "x")

    def link_to_group(file):
        del file["voile/steps"]
        file["voile/steps"] = h5py.ExternalLink(str(f.home / "secret.h5"), "/")

    def external_storage(file):
        shape, attributes = file[name].shape, dict(file[name].attrs)
        del file[name]
        data = file.create_dataset(name, shape, "f8", external=[(str(f.victim), 0, h5py.h5f.UNLIMITED)])
        data.attrs.update(attributes)

    def virtual(file):
        shape, attributes = file[name].shape, dict(file[name].attrs)
        del file[name]
        layout = h5py.VirtualLayout(shape, "f8")
        layout[:16, 0] = h5py.VirtualSource(str(f.home / "secret.h5"), "x", (48,))[:16]
        file.create_virtual_dataset(name, layout).attrs.update(attributes)

    for tamper in (external_link, link_to_group, external_storage, virtual):
        (out / "results.vtkhdf").write_bytes(good)
        with h5py.File(out / "results.vtkhdf", "r+") as file:
            tamper(file)
        for words in (["export", "out", "--to", "csv", "--output", "x.csv"], ["render", "out", "--field", "displacement", "--size", "40x30"],
                      ["view", "out"], ["run", "case.toml", "--output", "x", "--overwrite", "--restart", "out/results.vtkhdf"]):
            f.refused(f"{tamper.__name__}: {words[0]}", *words)
        try:
            Results(out)[-1]["displacement"]
            f.check(False, f"{tamper.__name__}: the Python package has read it")
        except ValueError as error:
            f.check("other file" in str(error), f"{tamper.__name__}: Python: {error}")


@scene
def numbers(f):
    """A state of absurd size is no start, and names of probes are no formulas."""
    import h5py
    out = f.ran()
    for name, value in (("displacement", 1e300), ("displacement", 1e12)):
        shutil.copy(out / "checkpoint.h5", f.here / "large.h5")
        with h5py.File(f.here / "large.h5", "r+") as file:
            file[name][0, 0] = value
        f.refused(f"{name} of {value:g}", "run", "case.toml", "--output", "x", "--overwrite", "--restart", "large.h5", saying="larger")
    for name in ("=cmd|' /C calc'!A0", "+1", "-1", "@SUM(A1)", "\\tx", "\\rx"):
        f.refused(f"a probe {name}", "check", f.case(more=f'[[probe]]\nname = "{name}"\ntype = "displacement"\ngroup = "right"\n'), saying="name")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="names; all by default")
    parser.add_argument("--list", action="store_true", help="name them and stop")
    arguments = parser.parse_args()
    if arguments.list:
        for name, function in SCENES.items():
            print(f"{name:15} {function.__doc__}")
        return 0
    failed = []
    for name in arguments.scenes or SCENES:
        print(f"{name}: {SCENES[name].__doc__}", flush=True)
        folder = Folder(name)
        SCENES[name](folder)
        if folder.failures:
            failed.append(name)
    print(f"{len(failed)} of {len(arguments.scenes or SCENES)} kinds of foreign files do harm" + (": " + ", ".join(failed) if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
