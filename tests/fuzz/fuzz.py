#!/usr/bin/python3
"""Damages input files and runs the program on them: whatever ends in anything but exit code 0, 2 or 3 is a finding.

    tests/fuzz/fuzz.py                          250 inputs, about a minute on 2 cores
    tests/fuzz/fuzz.py --seconds 36000 --seed 7 a night
    tests/fuzz/fuzz.py --voile build-sanitize/voile --timeout 120 --here
    tests/fuzz/fuzz.py --again 7:1234           one input again, with its output

A sanitizer's complaint in the child process that reads a foreign file looks like a damaged file; with --here the program reads
in its own process. Then crashes inside Gmsh, CGAL and HDF5 are findings too.
Input number i of seed s is the same on every machine. Findings are kept in results/fuzz with their files and output.
Files that are small stay in seeds/; a checkpoint, results and the binary forms are made from them when the program starts.
"""

import argparse
import os
import random
import re
import resource
import shutil
import struct
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SEEDS = HERE / "seeds"
sys.path.insert(0, str(ROOT / "runs" / "lib"))

from solver import environment  # noqa: E402

GOOD = {0, 2, 3}
NUMBERS = ["0", "-1", "1", "99", "1e300", "-1e300", "1e-300", "nan", "inf", "1e9", "2147483648", "-2147483649", "4294967296",
           "18446744073709551616", "0.1", "1e38", "007", ""]
WORDS = ["$Nodes", "$EndNodes", "$Elements", "$PhysicalNames", "element", "property float x", "property list uchar int v",
         "end_header", "facet normal", "endsolid", "f 1 2 3", "f -1 -2 -3", "f 1/1/1 2 3 4 5 6", "vt 0 0", "stitch 0 1 2 0.5", "l 1 2", "g x",
         "*NODE", "*ELEMENT, TYPE=S3", "*ELEMENT, TYPE=S4, ELSET=q", "*NSET, NSET=a, GENERATE", "CELLS 1 4", "POLYGONS 1 4",
         "[mesh]", "[[support]]", "[[load]]", "= [", "{ a = 1 }", '"', "'", "\\", "#", "\0", "\n\n", ";", "{", "}", "(", ")", "LINE", "POLYLINE", "SPLINE", "ENDSEC", "ENDBLK", "EOF"]


# -------------------------------------------------------------------------------------------------------------- damage

def flip_bits(data, rng):
    for _ in range(rng.choice((1, 1, 1, 2, 5, 20))):
        if data:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def set_bytes(data, rng):
    if data:
        at = rng.randrange(len(data))
        data[at:at + rng.choice((1, 2, 4, 8))] = bytes(rng.choice((0, 0xff, 0x7f, 0x80)) for _ in range(rng.choice((1, 2, 4, 8))))


def overwrite_number(data, rng):
    """Four or eight bytes as a number that a binary file may hold."""
    if len(data) > 8:
        at = rng.randrange(len(data) - 8)
        text, kinds = rng.choice((("<i", (0, -1, 99, 2**31 - 1, -2**31)), ("<q", (-1, 2**62, 2**31)),
                                  (">i", (0, -1, 2**31 - 1)), ("<f", (float("nan"), 1e38, -1e38)), ("<d", (float("inf"), 1e300))))
        value = struct.pack(text, rng.choice(kinds))
        data[at:at + len(value)] = value


def cut(data, rng):
    del data[rng.randrange(len(data) + 1):]


def remove(data, rng):
    at = rng.randrange(len(data) + 1)
    del data[at:at + rng.choice((1, 4, 16, 200))]


def repeat(data, rng):
    at = rng.randrange(len(data) + 1)
    data[at:at] = data[at:at + rng.choice((1, 4, 16, 200))] * rng.choice((1, 2, 50))


def change_token(data, rng):
    tokens = list(re.finditer(rb"[-+]?\d[\d.eE+-]*", data))
    if tokens:
        token = rng.choice(tokens)
        data[token.start():token.end()] = rng.choice(NUMBERS).encode()


def insert_word(data, rng):
    at = rng.randrange(len(data) + 1)
    data[at:at] = (" " + rng.choice(WORDS) + rng.choice((" ", "\n"))).encode()


def swap_lines(data, rng):
    lines = bytes(data).split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    data[:] = b"\n".join(lines)


def drop_line(data, rng):
    lines = bytes(data).split(b"\n")
    del lines[rng.randrange(len(lines))]
    data[:] = b"\n".join(lines)


BINARY = [flip_bits, flip_bits, set_bytes, overwrite_number, overwrite_number, cut, remove, repeat]
TEXT = [change_token, change_token, change_token, insert_word, swap_lines, drop_line, flip_bits, cut, remove, repeat]


def damaged(data, rng):
    binary = b"\0" in data[:4000]
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        rng.choice(BINARY if binary else TEXT)(data, rng)
    return bytes(data)


# --------------------------------------------------------------------------------------------------------------- inputs

class Target:
    """A file to damage, the command to run on it and the other files that the command needs.

    `slow`: a damaged file may ask for a large computation, which is no finding."""

    def __init__(self, file, command, needs=(), slow=False):
        self.file, self.command, self.needs, self.slow = Path(file), command, [Path(n) for n in needs], slow


def double(xs):
    return b"".join(struct.pack("<d", x) for x in xs)


def make_binary_seeds(folder):
    """Forms of the same square and tetrahedron that are not text."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    lines, triangles = [(1, 2), (2, 3), (3, 4), (4, 1)], [(1, 2, 3), (1, 3, 4)]
    names = b'$PhysicalNames\n2\n1 1 "edge"\n2 2 "sheet"\n$EndPhysicalNames\n'
    one = struct.pack("<i", 1)
    nodes = b"".join(struct.pack("<i", k) + double(p) for k, p in enumerate(points, 1))
    elements = struct.pack("<3i", 1, 4, 2) + b"".join(struct.pack("<5i", k, 1, 1, *c) for k, c in enumerate(lines, 1))
    elements += struct.pack("<3i", 2, 2, 2) + b"".join(struct.pack("<6i", k, 2, 1, *c) for k, c in enumerate(triangles, 5))
    (folder / "binary22.msh").write_bytes(
        b"$MeshFormat\n2.2 1 8\n" + one + b"\n$EndMeshFormat\n" + names + b"$Nodes\n4\n" + nodes + b"\n$EndNodes\n$Elements\n6\n"
        + elements + b"\n$EndElements\n")
    box = double((0, 0, 0, 1, 1, 0))
    entities = struct.pack("<4Q", 0, 1, 1, 0) + struct.pack("<i", 1) + box + struct.pack("<QiQ", 1, 1, 0)
    entities += struct.pack("<i", 1) + box + struct.pack("<QiQi", 1, 2, 1, 1)
    nodes = struct.pack("<4Q", 1, 4, 1, 4) + struct.pack("<3iQ", 2, 1, 0, 4) + struct.pack("<4Q", 1, 2, 3, 4)
    nodes += b"".join(double(p) for p in points)
    elements = struct.pack("<4Q", 2, 6, 1, 6) + struct.pack("<3iQ", 1, 1, 1, 4)
    elements += b"".join(struct.pack("<3Q", k, *c) for k, c in enumerate(lines, 1)) + struct.pack("<3iQ", 2, 1, 2, 2)
    elements += b"".join(struct.pack("<4Q", k, *c) for k, c in enumerate(triangles, 5))
    (folder / "binary41.msh").write_bytes(
        b"$MeshFormat\n4.1 1 8\n" + one + b"\n$EndMeshFormat\n" + names + b"$Entities\n" + entities + b"\n$EndEntities\n$Nodes\n"
        + nodes + b"\n$EndNodes\n$Elements\n" + elements + b"\n$EndElements\n")
    corners = [(0.3, 0.3, -0.3), (0.7, 0.3, -0.3), (0.5, 0.7, -0.3), (0.5, 0.45, -0.1)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    stl = bytes(80) + struct.pack("<I", len(faces))
    for face in faces:
        stl += struct.pack("<12f", 0, 0, 0, *(x for v in face for x in corners[v])) + bytes(2)
    (folder / "binary.stl").write_bytes(stl)
    header = (b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
              b"element face 4\nproperty list uchar int vertex_indices\nend_header\n")
    (folder / "binary.ply").write_bytes(header + b"".join(struct.pack("<3f", *c) for c in corners)
                                        + b"".join(struct.pack("<B3i", 3, *f) for f in faces))
    frames = [[(x, y, z + 0.01 * k) for x, y, z in corners] for k in range(3)]
    flat = [x for frame in frames for c in frame for x in c]
    (folder / "body.pc2").write_bytes(b"POINTCACHE2\0" + struct.pack("<iiffi", 1, 4, 0.0, 1.0, 3) + struct.pack("<36f", *flat))
    (folder / "body.mdd").write_bytes(struct.pack(">ii3f", 3, 4, 0, 0.04, 0.08) + struct.pack(">36f", *flat))


def make_restart_seeds(voile, folder):
    """A checkpoint and the results of two steps of the motion in seeds/."""
    for case in ("motion.toml", "path.toml"):
        done = subprocess.run([voile, "run", folder / case, "--output", folder / f"{case}.out", "--quiet"], env=environment(1),
                              capture_output=True, text=True, timeout=300)
        if done.returncode != 0:
            raise SystemExit(f"{case}: the undamaged seed ends with code {done.returncode}:\n{done.stdout}{done.stderr}")
    make_killed_seed(voile, folder)


def make_killed_seed(voile, folder):
    """Results of a run that was killed after some steps: an index over files in steps/."""
    killed = folder / "path.toml.killed"
    for _ in range(50):
        shutil.rmtree(killed, ignore_errors=True)
        process = subprocess.Popen([voile, "run", folder / "path.toml", "--output", killed, "--quiet"], env=environment(1))
        while process.poll() is None and not (killed / "steps" / "000001.h5").is_file():
            time.sleep(0.001)
        process.kill()
        process.wait()
        if (killed / "steps" / "000001.h5").is_file():
            return
    raise SystemExit("path.toml: the run ends before it can be killed")


def targets(folder):
    run = ["run", "{}", "--output", "out"]
    small = ["square.msh", "body.obj", "fabric.toml"]
    found = [Target(name, ["info", "{}"]) for name in
             ("square.msh", "square41.msh", "binary22.msh", "binary41.msh", "square.obj", "body.obj", "binary.stl", "binary.ply",
              "text.stl", "text.ply", "text.off", "square.inp", "square.bdf", "square.vtk") if (folder / name).is_file()]
    found.append(Target("square.geo", ["info", "{}"], slow=True))
    found += [Target(name, ["check", "{}"], small) for name in ("motion.toml", "path.toml", "cloth.toml")]
    found += [Target(name, [*run, "-snes_max_it", "8"], small, slow=True) for name in ("motion.toml", "path.toml", "cloth.toml")]
    pieces = ["garment.toml", "pieces.json", "pieces.svg", "block.dxf", "drawing.dxf", "panels.obj"]
    found += [Target(name, ["check", "garment.toml"], [other for other in pieces if other != name]) for name in pieces]
    found.append(Target("fabric.toml", ["check", "cloth.toml"], ["cloth.toml", "square.msh", "body.obj"]))
    for name in ("body.obj", "binary.stl", "binary.ply", "text.stl", "text.ply", "text.off", "square41.msh"):
        if (folder / name).is_file():
            found.append(Target(name, ["check", f"obstacle:{name}"], ["cloth.toml", "fabric.toml", "square.msh"]))
    for name in ("body.pc2", "body.mdd"):
        found.append(Target(name, ["check", f"frames:{name}"], ["cloth.toml", "fabric.toml", "square.msh", "body.obj"]))
    checkpoint = Target("motion.toml.out/checkpoint.h5", ["run", "motion.toml", "--output", "out", "--restart", "{}"],
                        [*small, "motion.toml"])
    found += [checkpoint] * 3
    for results, names in (("path.toml.out", ["results.vtkhdf"]),
                           ("path.toml.killed", ["results.vtkhdf", "steps/000001.h5", "steps/epoch_000000.h5"])):
        found += [Target(f"{results}/{name}", ["run", "path.toml", "--output", "out", "--restart", f"{results}/results.vtkhdf"],
                         ["path.toml", *small, results]) for name in names]
    return found


def write_input(target, folder, seeds, rng):
    """The damaged file and what goes with it; returns the command."""
    for need in target.needs:
        if (seeds / need).is_dir():
            shutil.copytree(seeds / need, folder / need)
        else:
            shutil.copy(seeds / need, folder / need)
    (folder / target.file).parent.mkdir(parents=True, exist_ok=True)
    (folder / target.file).write_bytes(damaged((seeds / target.file).read_bytes(), rng))
    words = []
    for word in target.command:
        if word.startswith(("obstacle:", "frames:")):
            kind, name = word.split(":")
            text = (folder / "cloth.toml").read_text()
            text = text.replace('"body.obj"', f'"{name}"') if kind == "obstacle" else text.replace(
                '"body.obj"', f'"body.obj"\nframes = "{name}"')
            (folder / "cloth.toml").write_text(text)
            word = "cloth.toml"
        words.append(word.format(target.file))
    return words


# ----------------------------------------------------------------------------------------------------------------- runs

class Fuzzer:
    def __init__(self, voile, folder, timeout, memory, here):
        self.voile, self.folder, self.timeout, self.memory = Path(voile).resolve(), folder, timeout, memory
        self.environ = environment(1) | {"ASAN_OPTIONS": "detect_leaks=0:exitcode=99", "UBSAN_OPTIONS": "print_stacktrace=1"}
        if here:
            self.environ["VOILE_READ_HERE"] = "1"
        self.seeds = folder / "seeds"
        shutil.rmtree(self.seeds, ignore_errors=True)
        shutil.copytree(SEEDS, self.seeds)
        make_binary_seeds(self.seeds)
        make_restart_seeds(self.voile, self.seeds)
        self.targets = targets(self.seeds)

    def limit(self):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if self.memory > 0:
            resource.setrlimit(resource.RLIMIT_AS, (self.memory << 30, self.memory << 30))

    def run(self, seed, number):
        """One input; returns (what happened, command, output)."""
        rng = random.Random(f"{seed}:{number}")
        target = self.targets[rng.randrange(len(self.targets))]
        folder = self.folder / f"input_{seed}_{number}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        command = [str(self.voile), *write_input(target, folder, self.seeds, rng)]
        try:
            done = subprocess.run(command, cwd=folder, env=self.environ, stdin=subprocess.DEVNULL, capture_output=True,
                                  timeout=self.timeout, preexec_fn=self.limit)
            text = (done.stdout + done.stderr).decode(errors="replace")
            what = "ok" if done.returncode in GOOD else f"code {done.returncode}"
        except subprocess.TimeoutExpired as late:
            text, what = (late.stdout or b"").decode(errors="replace"), "slow" if target.slow else "timeout"
        if what in ("ok", "slow"):
            shutil.rmtree(folder)
        else:
            (folder / "output.txt").write_text(" ".join(command) + f"\n{what}\n{text}")
        return what, f"{target.file}: {' '.join(command[1:])}", text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--voile", default=ROOT / "build" / "voile")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=250, help="inputs, unless --seconds is given")
    parser.add_argument("--seconds", type=float, default=0.0, help="time to go on for")
    parser.add_argument("--timeout", type=float, default=60.0, help="seconds for each input")
    parser.add_argument("--memory", type=int, default=0, help="GB of address space for each input; 0: no limit")
    parser.add_argument("--here", action="store_true", help="foreign files are read without a process of their own")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--again", metavar="SEED:NUMBER", help="run one input and show what it says")
    options = parser.parse_args()
    folder = ROOT / "results" / "fuzz"
    folder.mkdir(parents=True, exist_ok=True)
    fuzzer = Fuzzer(options.voile, folder, options.timeout, options.memory, options.here)
    if options.again:
        seed, number = options.again.split(":")
        what, command, text = fuzzer.run(int(seed), int(number))
        print(command, what, text, sep="\n")
        return 0 if what in ("ok", "slow") else 1
    end = time.time() + options.seconds
    counts, number = {}, 0
    with ThreadPoolExecutor(options.jobs) as pool:
        while number < options.count if options.seconds <= 0 else time.time() < end:
            batch = range(number, number + 8 * options.jobs)
            if options.seconds <= 0:
                batch = range(number, min(batch.stop, options.count))
            for i, (what, command, text) in zip(batch, pool.map(lambda k: fuzzer.run(options.seed, k), batch)):
                counts[what] = counts.get(what, 0) + 1
                if what not in ("ok", "slow"):
                    last = " ".join(text.split())[-160:]
                    print(f"FINDING {options.seed}:{i} {what}: {command}\n   {last}", flush=True)
            number = batch.stop
    findings = sum(n for what, n in counts.items() if what not in ("ok", "slow"))
    print(f"{number} inputs, {findings} findings ({', '.join(f'{n} {what}' for what, n in sorted(counts.items()))})")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
