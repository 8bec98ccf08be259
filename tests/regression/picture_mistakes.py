"""Regression tests of what render, plot, export and view say when they cannot do what is asked."""

import os
import resource
import shutil
import subprocess

import h5py
import numpy as np
from harness import OUT, solve, test
from picturing import draw
from common import fresh, started, strip, wait_for
from solver import binary, environment, write_case


def refused(report, words, part):
    code, said = draw(*words)
    report.check(code == 2 and part in said, f"voile {' '.join(str(w) for w in words)}: code {code}: {said.strip()[-120:]}")


def some_results():
    return solve("pictures_strip", strip("dynamic", time__end=0.1), 1)


@test
def pictures_of_mistakes(report):
    """What cannot be drawn ends with code 2 and a message that says why."""
    folder, png = some_results().folder, ("--output", OUT / "x.png")
    for words, part in ((("--steps", "77", *png), "there is no step 77"), (("--field", "displacment", *png), "did you mean 'displacement'"),
                        (("--field", "displacement:w", *png), "magnitude, x, y, z"), (("--size", "1e9x3", *png), "--size"),
                        (("--size", "32000x90000", *png), "pixels"), (("--view", "frnt", *png), "three-quarter"), (("--mode", "1", *png), "no modes"),
                        (("--stage", "a", *png), "not a run in stages"), (("--output", "/proc/version/x.png"), "cannot be written"),
                        (("--animation", OUT / "x.avi"), ".webp"), (("--range", "2,1", "--field", "displacement", *png), "smaller"), (("--range", "0,1", *png), "--field"),
                        (("--steps", "5:1", *png), "must not be larger"), (("--steps", "1:5:0", *png), "names no steps"), (("--size", "-64x48", *png), "--size"),
                        (("--scale", "nan", *png), "--scale"), (("--creases", "nan", *png), "--creases"), (("--eye", "1,2,3", "--target", "1,2,3", *png), "--eye"),
                        (("--output", OUT / "x.jpg"), ".png"), (("--output", OUT), "directory"), (("--output", "/dev/full"), "No space"),
                        (("--animation", OUT / "x.webp", "--steps", "100:200"), "there is no step 100:200"), (("--animation", OUT / "x.gif", "--rate", "nan"), "--rate"), (("--frames", "3"), "--frames requires"), (("--rate", "10"), "--rate requires"),
                        (("--cloth", "satin", *png), "plain, twill or knit"), (("--print", "checks:3", *png), "mm, cm or m"),
                        (("--print", "checks:3mm", "--panels", *png), "excludes")):
        refused(report, ("render", folder, *words), part)
    refused(report, ("render",), "results")


@test
def exports_of_mistakes(report):
    """What cannot be exported or viewed ends with code 2 and a message that says why."""
    folder = some_results().folder
    for words, part in ((("--to", "fbx"), "obj, stl"), ((), "--to"), (("--to", "ply", "--field", "velocty"), "did you mean 'velocity'"),
                        (("--to", "glb", "--field", "velocity"), "glb files have no fields"), (("--to", "ply", "--cloth", "twill"), "export as glb"), (("--to", "obj", "--steps", "77"), "there is no step 77"), (("--to", "obj", "--output", "x.stl"), "two formats"),
                        (("--output", "/proc/version/x.glb"), "cannot be written")):
        refused(report, ("export", folder, *words), part)
    for words, part in ((("--steps", "77"), "there is no step 77"), (("--field", "velocty"), "did you mean 'velocity'"),
                        (("--output", "/proc/version/x.html"), "cannot be written")):
        refused(report, ("view", folder, *words), part)
    for words, part in ((("--y", "kinetic_enrgy"), "did you mean 'kinetic_energy'"), (("--x", "time", "--y", "step", "--output", OUT / "x.jpg"), ".svg or .png"),
                        (("--y", "2*kinetic_enrgy"), "did you mean 'kinetic_energy'"), (("--y", "2*(step"), "an expression such as"), (("--points", "x.csv:a"), "FILE:X:Y"),
                        (("--y", "step", "--log", "y", "--y-range", "-1,1"), "begins above 0"), (("--y", "step", "--x-range", "3,1"), "smaller"),
                        (("--y", "step", "--log", "y", "--equal"), "linear"), (("--y", "step", "--size", "16x16", "--output", OUT / "x.svg"), "too small"),
                        (("--y", "0*step", "--log", "y", "--output", OUT / "x.svg"), "positive numbers"),
                        (("--y", "sqrt(-1-time)", "--output", OUT / "x.svg"), "finite in no row")):
        refused(report, ("plot", folder, *words), part)
    refused(report, ("plot", folder, "--y", "step,time"), "step/time")
    refused(report, ("plot", "--output", OUT / "x.svg"), "--curve")
    draw("render", folder, "--size", "64x64", "--output", OUT / "x.png")
    for words, part in (((OUT / "nowhere.png", "--output", OUT / "x.png"), "no PNG"), ((OUT, "--output", OUT / "x.png"), "no PNG"),
                        ((folder / "history.csv", "--output", OUT / "x.png"), "no PNG"), ((OUT / "x.png", "--output", OUT / "y.jpg"), ".png"),
                        ((OUT / "x.png", "--columns", "0", "--output", OUT / "y.png"), "--columns"), ((), "pictures")):
        refused(report, ("sheet", *words), part)


def indexed_steps(file):
    """How many steps the index of a running run names; it lags behind the history."""
    if not file.is_file():
        return 0
    with h5py.File(file, "r") as index:
        return int(index["VTKHDF/Steps"].attrs["NSteps"]) if "VTKHDF/Steps" in index else 0


@test
def results_that_are_not_there(report):
    """Folders that are missing, empty or half written: code 2 and a message from each command; a step that was cut off is named."""
    done = some_results()
    empty, half, cut = fresh("pictures_empty"), fresh("pictures_half"), fresh("pictures_cut")
    empty.mkdir()
    half.mkdir()
    whole = done.results.file.read_bytes()
    (half / "results.vtkhdf").write_bytes(whole[:len(whole) // 2])
    (half / "history.csv").write_bytes(whole)
    for command in (("render", "--output", OUT / "x.png"), ("export", "--output", OUT / "x.glb"), ("view", "--output", OUT / "x.html"), ("plot", "--output", OUT / "x.svg")):
        history = command[0] == "plot"
        refused(report, (command[0], empty, *command[1:]), "there is no such table" if history else "there are no results")
        refused(report, (command[0], OUT / "nowhere", *command[1:]), "there is no such")
        refused(report, (command[0], half, *command[1:]), "this is no CSV file" if history else "damaged or not whole")
    process = started(write_case(strip("dynamic", time__end=100.0), OUT / "pictures_cut.toml"), cut)
    wait_for(lambda: indexed_steps(cut / "results.vtkhdf") > 4, process)
    process.kill()
    process.wait()
    os.truncate(cut / "steps" / "000003.h5", 3000)
    refused(report, ("render", cut, "--steps", "3", "--output", OUT / "x.png"), "steps/000003.h5 beside it, which is missing or cannot be read")
    code, said = draw("render", cut, "--steps", "2", "--size", "64x64", "--output", OUT / "x.png")
    report.check(code == 0, "other steps are drawn" if code == 0 else said)


@test
def results_with_flipped_bytes(report):
    """Results with bytes that are wrong, or an end that is missing: drawn, or refused with one line that says so."""
    whole, folder, wrong = some_results().results.file.read_bytes(), fresh("pictures_flipped"), []
    folder.mkdir()
    random = np.random.default_rng(1)
    for k in range(24):
        data = bytearray(whole[:int(len(whole) * random.random())] if k % 2 else whole)
        for at in [] if k % 2 else random.integers(0, random.choice([2000, 20000, len(data)]), 5):
            data[at] = random.integers(0, 256)
        (folder / "results.vtkhdf").write_bytes(data)
        code, said = draw("render", folder, "--size", "32x32", "--quality", "draft", "--quiet", "--output", OUT / "x.png")
        if code not in (0, 2) or code == 2 and (not said.startswith("voile: error: ") or said.count("\n") != 1):
            wrong.append(f"{k}: code {code}: {said[-300:]}")
    report.check(not wrong, f"24 of them, {len(wrong)} not so {wrong[:2]}")


@test
def pictures_on_a_full_disk(report):
    """A disk that fills up while pictures are written: code 2, and half a picture does not stay."""
    results, out = some_results().folder, fresh("pictures_full")
    out.mkdir()
    films = ("webp", "gif", "mp4") if shutil.which("ffmpeg") else ("webp", "gif")
    commands = [("render", results, "--output", out / "x.png"), *(("render", results, "--animation", out / f"x.{e}") for e in films),
                ("view", results, "--output", out / "x.html"), *(("export", results, "--output", out / f"x.{e}") for e in ("glb", "obj", "usda", "csv"))]
    for words in commands:
        size = ("--size", "640x480", "--quality", "draft") if words[0] == "render" else ()
        done = subprocess.run(["bash", "-c", "trap '' XFSZ; ulimit -f 2; exec \"$0\" \"$@\"", binary(), *words, *size, "--quiet"], env=environment(), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        left = [f.name for f in out.iterdir()]
        report.check(done.returncode == 2 and not left, f"{words[0]}, {words[-1].suffix}: code {done.returncode}, left {left}: {done.stdout.strip()[-120:]}")


@test
def pictures_without_memory(report):
    """Too little memory for a picture is told with code 2; for threads, fewer do."""
    folder = some_results().folder

    def limited(gigabytes, *words):
        limit = int(gigabytes * 2**30)
        done = subprocess.run([binary().parent / "voile-picture", "render", folder, "--output", OUT / "x.png", *words], env=environment(), text=True,
                              capture_output=True, timeout=120, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        return done.returncode, done.stderr

    for words, gigabytes in ((("--size", "14000x14000"), 2), (("--size", "64x64", "--threads", "1"), 0.1)):
        code, said = limited(gigabytes, *words)
        report.check(code == 2 and "out of memory" in said, f"{' '.join(words)} in {gigabytes} GB: code {code}: {said.strip()[-120:]}")
    code, said = limited(3, "--size", "64x64", "--threads", "1000")
    report.check(code == 0, f"1000 threads in 3 GB: code {code}: {said.strip()[-120:]}")


@test
def film_without_ffmpeg(report):
    """MP4 without ffmpeg, or one that fails, is told with code 2."""
    folder, place, film = some_results().folder, fresh("pictures_path"), OUT / "x.mp4"
    place.mkdir()

    def drawn(path, file):
        done = subprocess.run([binary(), "render", folder, "--animation", file, "--size", "320x240", "--quality", "draft"], env={**environment(), "PATH": path},
                              text=True, capture_output=True)
        return done.returncode, done.stderr

    code, said = drawn(str(place), film)
    report.check(code == 2 and "needs the program ffmpeg" in said, f"without ffmpeg: code {code}: {said.strip()[-120:]}")
    for name, text, file, part in (("fails at once", "exit 1", film, "ffmpeg"), ("fails in the end", "cat >/dev/null; exit 1", film, "ffmpeg reports an error"),
                                   ("works", "cat >/dev/null", "/proc/version/x.mp4", "is the folder there?")):
        (place / "ffmpeg").write_text(f"#!/bin/sh\n{text}\n")
        (place / "ffmpeg").chmod(0o755)
        code, said = drawn(f"{place}:{os.environ['PATH']}", file)
        report.check(code == 2 and part in said, f"an ffmpeg that {name}: code {code}: {said.strip()[-120:]}")
