"""What goes wrong: signals, folders, options, damage, memory."""

import json
import math
import re
import signal
import subprocess

import h5py
import numpy as np
from common import fresh, lines, started, strip, wait_for
from harness import OUT, solve, test
from results import NAME, Results
from solver import binary, command, environment, invoke, run, variant, write_case


@test
def signals(report):
    """SIGINT, SIGTERM and SIGUSR1 in every analysis: the last good state is on disk, exit code 3, and a restart goes on."""
    for analysis, name, number in (("static", "static", signal.SIGINT), ("dynamic", "dynamic", signal.SIGTERM),
                                   ("dynamic", "interrupted", signal.SIGINT)):
        case = strip(analysis, nx=160, ny=16, steps__max_step=0.002, steps__initial_step=0.002, time__end=10.0,
                     output={"fields": ["displacement", "velocity"], "every": 1000})
        if analysis == "dynamic":
            del case["steps"]
        folder = fresh(f"signals_{name}")
        process = started(write_case(case, OUT / f"signals_{name}.toml"), folder)
        running = wait_for(lambda: lines(folder / "history.csv") >= 5, process)
        process.send_signal(number)
        text = process.communicate(timeout=60)[0]
        report.check(running and process.returncode == 3 and "stopped by a signal" in text,
                     f"{name}: code {process.returncode}: {text.splitlines()[-1][:110] if text else ''}")
        done = lines(folder / "history.csv") - 2
        report.check(Results(folder)[-1].number == done, f"the last step, {done}, is in the results though every = 1000")
        report.check(json.loads((folder / "summary.json").read_text())["converged"] is False, "summary.json says so")
        restart = folder / (NAME if analysis == "static" else "checkpoint.h5")
        again = variant(case, {"time.end": 0.01 * (done + 2)} if analysis == "dynamic" else {"steps.final_load_factor": 0.002 * (done + 2)})
        result = run(write_case(again, OUT / f"signals_{name}_again.toml"), fresh(f"signals_{name}_again"), 1, ["--restart", restart])
        report.check(result.code == 0 and result.summary["steps"] in (2, done + 2), f"a restart goes on: code {result.code}")
    case = strip("drape", nx=300, ny=30, load=[{"type": "gravity", "vector": [0, 0, -0.5]}])
    folder = fresh("signals_drape")
    process = started(write_case(case, OUT / "signals_drape.toml"), folder, ["-snes_monitor"])
    for count, line in enumerate(process.stdout):
        if "SNES Function norm" in line and count > 12:
            break
    process.send_signal(signal.SIGTERM)
    text = process.communicate(timeout=120)[0]
    report.check(process.returncode == 3 and "stopped by a signal" in text, f"drape: code {process.returncode}")
    report.check(np.abs(Results(folder).step(1)["displacement"]).max() > 0, "what it had reached is in the results")


@test
def signal_twice(report):
    """A second SIGINT ends a run at once; SIGUSR1 writes what `every` would have left out."""
    case = strip("static", nx=160, ny=16, steps__max_step=0.002, steps__initial_step=0.002,
                 output={"fields": ["displacement"], "every": 1000})
    folder = fresh("signal_twice")
    process = started(write_case(case, OUT / "signal_twice.toml"), folder)
    running = wait_for(lambda: lines(folder / "history.csv") >= 3, process)
    before = set((folder / "steps").glob("*.h5"))
    process.send_signal(signal.SIGUSR1)
    came = wait_for(lambda: set((folder / "steps").glob("*.h5")) > before, process, 30)
    report.check(running and came, "SIGUSR1: one more step is written, and the run goes on")
    process.send_signal(signal.SIGSTOP)
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGCONT)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    report.check(process.returncode in (3, -signal.SIGINT), f"two SIGINT: code {process.returncode}")


@test
def signals_to_mpirun(report):
    """mpirun hands SIGUSR2 on: the ranks end with the last good state on disk, and mpirun with their exit code 3. SIGINT it keeps."""
    case = strip("static", nx=160, ny=16, steps__max_step=0.002, steps__initial_step=0.002,
                 output={"fields": ["displacement"], "every": 1000})
    file = write_case(case, OUT / "signals_to_mpirun.toml")
    for number, code in ((signal.SIGUSR2, 3), (signal.SIGINT, 1)):
        folder = fresh("signals_to_mpirun")
        process = subprocess.Popen(command(["run", file, "--output", folder], 2), env=environment(2), text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        running = wait_for(lambda: lines(folder / "history.csv") >= 5, process)
        process.send_signal(number)
        process.communicate(timeout=60)
        report.check(running and process.returncode == code, f"{number.name}: code {process.returncode}")
        report.check((folder / "checkpoint.h5").is_file(), "the last good state is a checkpoint")


@test
def full_terminal(report):
    """A log that cannot be written, or that is closed, ends nothing: the results are whole, the exit code is that of the run."""
    file = write_case(strip("static"), OUT / "full_terminal.toml")
    for redirection in ("2>/dev/full", ">/dev/full", ">/dev/full 2>&1", ">&-", "<&- >&- 2>&-"):
        for ranks in (1, 2) if "2>&1" in redirection else (1,):
            folder = fresh("full_terminal")
            done = subprocess.run(["bash", "-c", f'exec "$0" "$@" {redirection}', *command(["run", file, "--output", folder, "--verbose"], ranks)],
                                  env=environment(ranks), timeout=60, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            report.check(done.returncode == 0 and len(Results(folder)) > 1 and (folder / "checkpoint.h5").is_file(),
                         f"{redirection} on {ranks} rank(s): code {done.returncode}")
    done = subprocess.run(["bash", "-c", 'exec "$0" reference >/dev/full', str(binary())], env=environment(1), text=True, stderr=subprocess.PIPE)
    report.check(done.returncode == 2 and "standard output" in done.stderr, f"a reference that is lost: code {done.returncode}")


@test
def impossible_names(report):
    """Names that cannot be, loops of links, and temporary folders that cannot be written: exit code 2 and what to do."""
    folder = fresh("impossible_names")
    folder.mkdir(parents=True)
    (folder / "a").symlink_to("b")
    (folder / "b").symlink_to("a")
    file = write_case(strip("static"), folder / "case.toml")
    for name in ("n" * 300, folder / "a", folder / "a" / "x", "/proc/version/x"):
        for ranks, words in ((1, ["run", file, "--output", name]), (2, ["run", file, "--output", name]), (1, ["run", name]), (1, ["init", name]),
                             (1, ["info", f"{name}.obj"]), (1, ["run", file, "--output", folder / "r", "--restart", name]),
                             (1, ["render", name]), (1, ["plot", name, "--output", "x.svg"])):
            code, text = invoke(words, ranks)
            report.check(code == 2 and "error" in text, f"{words[0]} {str(name)[-30:]} on {ranks} rank(s): code {code}")
    for temporary, limit in (("/proc/version/x", ""), ("/proc", ""), (str(folder), "ulimit -f 1;")):
        done = subprocess.run(["bash", "-c", f'{limit} exec "$0" "$@"', *command(["check", file])], env=environment(1) | {"TMPDIR": temporary}, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        report.check(done.returncode == 2 and "set TMPDIR" in done.stdout, f"TMPDIR={temporary} {limit}: code {done.returncode}: {done.stdout[:150]}")


@test
def failed_motion(report):
    """A motion that does not converge: exit code 3, a summary, the reason, no step twice, a checkpoint of the last good state."""
    for name, case, options in (("first", strip("dynamic", time__min_step=0.01), ["-snes_max_it", "1", "-snes_rtol", "1e-14", "-snes_stol", "1e-14"]),
                                ("later", strip("dynamic", load=[{"type": "line", "group": "tip", "vector": [0, 0, 1.0],
                                                                  "history": "t > 0.055 ? 1e12 : 1"}], time__min_step=0.005), ["-snes_max_it", "3"])):
        folder = fresh(f"failed_motion_{name}")
        result = run(write_case(case, OUT / f"failed_motion_{name}.toml"), folder, 1, options)
        report.check(result.code == 3 and "no step of" in result.text, f"{name}: code {result.code}: {result.text.splitlines()[-1][:120]}")
        steps = list(result.history["step"])
        report.check(len(steps) == len(set(steps)), f"{name}: every step once: {len(steps)} lines")
        report.check(result.summary["converged"] is False, f"{name}: summary.json says so")
        report.check((folder / "checkpoint.h5").is_file(), f"{name}: checkpoint.h5 is there")
        with h5py.File(folder / "checkpoint.h5") as data:
            report.check(data.attrs["step"] == steps[-1], f"{name}: it is step {int(data.attrs['step'])}, the last good one")
    fixed = run(write_case(strip("dynamic", time__min_step=0.01), OUT / "fixed_step.toml"), fresh("fixed_step"), 1)
    report.check(fixed.code == 0 and fixed.summary["steps"] == 20, f"min_step = step is a fixed step: code {fixed.code}")
    short = run(write_case(strip("dynamic"), OUT / "max_steps.toml"), fresh("max_steps"), 1, ["-ts_max_steps", "7"])
    with h5py.File(OUT / "max_steps" / "checkpoint.h5") as data:
        report.check(short.code == 3 and data.attrs["step"] == 7, f"-ts_max_steps 7 leaves step {int(data.attrs['step'])} as a checkpoint")


@test
def named_failures(report):
    """What ends without convergence names the triangles where the residual is largest: in motion, and along every kind of path."""
    tip = {"type": "displacement", "name": "tip", "group": "tip", "components": ["z"]}
    late = [{"type": "line", "group": "tip", "vector": [0, 0, 1.0], "history": "t > 0.055 ? 1e12 : 1"}]
    path = {"initial_step": 0.5, "min_step": 0.4}
    for name, case, options in (
        ("motion", strip("dynamic", load=late, time__min_step=0.005), ["-snes_max_it", "3"]),
        ("load", strip(steps=path | {"fallback": False}), ["-snes_max_it", "1"]),
        ("displacement", strip(steps=path | {"control": "displacement", "control_probe": "tip", "final_displacement": 5.0}, probe=[tip]), ["-snes_max_it", "1"]),
        ("arc_length", strip(steps=path | {"control": "arc_length"}), ["-snes_max_it", "1"])):
        for ranks in (1, 2, 3):
            result = run(write_case(case, OUT / f"named_{name}.toml"), fresh(f"named_{name}"), ranks, options)
            text = " ".join(result.text.split())
            found = re.findall(r"triangle (\d+) at \(([-0-9.e, ]+)\), smallest angle ([0-9.]+) degrees", text)
            report.check(result.code == 3 and "the residual is largest at triangle" in text and 1 <= len(found) <= 5,
                         f"{name} on {ranks} rank(s): code {result.code}, {len(found)} triangles: {text[-200:]}")
            places = [[float(c) for c in place.split(",")] for _, place, _ in found]
            report.check(all(0 <= x <= 10 and 0 <= y <= 1 and z == 0 for x, y, z in places), f"{name}: they lie on the strip: {places}")
            if name == "motion":
                report.check(places[0][0] > 9, f"the first is where the load tears: x = {places[0][0]}")


@test
def user_mistakes(report):
    """Mistakes in PETSc's options are the user's: exit code 2 and PETSc's words, without its stack, on 1 and 2 ranks."""
    file = write_case(strip(), OUT / "user_mistakes.toml")
    for options, word in ((["-snes_type", "foo"], "foo"), (["-pc_factor_mat_solver_type", "foo"], "foo"),
                          (["-snes_rtol", "small"], "small"), (["-ksp_type", "foo"], "foo")):
        for ranks in (1, 2):
            result = run(file, OUT / "user_mistakes", ranks, options)
            report.check(result.code == 2 and word in result.text and "PETSC ERROR" not in result.text,
                         f"{' '.join(options)} on {ranks} rank(s): code {result.code}")
    for arguments, code in (([], 2), (["--help"], 0), (["run", "--help"], 0)):
        got, text = invoke(arguments)
        report.check(got == code, f"voile {' '.join(arguments)}: code {got}")
    report.check("voile run" in text, "the help of `run` shows how it is called")
    code, text = invoke(["--version"])
    report.check(code == 0 and text.splitlines()[0].count("(") == 1, f"--version: {text.splitlines()[0]}")


@test
def full_disk(report):
    """A disk that fills up is the user's matter too: exit code 2, what was written stays readable."""
    limit = "ulimit -f 60; exec \"$0\" \"$@\""  # no file larger than 60 kB
    file = write_case(strip("dynamic", nx=100, ny=10), OUT / "full_disk.toml")
    folder = fresh("full_disk")
    done = subprocess.run(["bash", "-c", "trap '' XFSZ; " + limit, *command(["run", file, "--output", folder])], env=environment(1) | {"PMIX_MCA_gds": "hash"},
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    report.check(done.returncode == 2 and "writing failed" in done.stdout, f"code {done.returncode}: {done.stdout.strip()[-120:]}")
    # Steps fit, the file of all of them does not.
    done = subprocess.run(["bash", "-c", "trap '' XFSZ; " + limit.replace("60", "1500"), *command(["run", file, "--output", folder, "--overwrite"])],
                          env=environment(1) | {"PMIX_MCA_gds": "hash"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    report.check(done.returncode == 2 and "could not be put into one file" in done.stdout, f"code {done.returncode}: {done.stdout.strip()[-120:]}")
    results = Results(folder)
    report.check(len(results) == 21 and not results.complete and all(np.isfinite(step["displacement"]).all() for step in results),
                 f"{len(results)} steps can be read")


@test
def lacking_memory(report):
    """A matrix that memory cannot hold: exit code 2, how much was asked for and what helps."""
    file = write_case(strip("static", nx=900, ny=90), OUT / "lacking_memory.toml")
    done = subprocess.run(["bash", "-c", "ulimit -v 1100000; exec \"$0\" \"$@\"", *command(["run", file, "--output", OUT / "lacking_memory", "--overwrite"])],
                          env=environment(1), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    report.check(done.returncode == 2 and "out of memory" in done.stdout and "voile_mixed" in done.stdout,
                 f"code {done.returncode}: {done.stdout.strip()[-250:]}")


@test
def lacking_disk(report):
    """A factor that shall be kept in files, where there is no such folder: exit code 2 and what is wrong, in either precision."""
    file = write_case(strip("static"), OUT / "lacking_disk.toml")
    for options in (["-pc_type", "voile_mixed", "-pc_mixed_on_disk"], ["-mat_mumps_icntl_22", "1"]):
        done = subprocess.run(command(["run", file, "--output", OUT / "lacking_disk", "--overwrite", *options], 2), text=True, timeout=60,
                              env=environment(2) | {"MUMPS_OOC_TMPDIR": "/proc/version/folder"}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        report.check(done.returncode == 2 and "MUMPS_OOC_TMPDIR" in done.stdout, f"{options[0]}: code {done.returncode}: {done.stdout.strip()[:250]}")


@test
def nobody_listens(report):
    """`voile run case.toml | head`: ends as other programs do, without a word of a crash; its steps are there."""
    folder = fresh("nobody_listens")
    file = write_case(strip("static", steps__max_step=0.01, steps__initial_step=0.01), OUT / "nobody_listens.toml")
    process = subprocess.Popen([binary(), "run", file, "--output", folder, "-snes_monitor"], env=environment(1), text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    for line in process.stdout:
        if lines(folder / "history.csv") > 3:
            break
    process.stdout.close()
    said = process.stderr.read()
    process.wait()
    report.check(process.returncode == -signal.SIGPIPE and not said.strip(), f"code {process.returncode}: {said.strip()[:200]}")
    report.check(len(Results(folder)) >= 2, "what it had done is readable")


@test
def folders(report):
    """Nobody's files are lost: no foreign folder, no earlier run unless asked, no input, one run at a time."""
    folder = fresh("folders")
    folder.mkdir()
    file = write_case(strip(), folder / "case.toml")
    text = file.read_text()

    def start(output, *options, cwd=folder, case="case.toml"):
        done = subprocess.run(command(["run", case, "--output", output, *options]), env=environment(1), cwd=cwd, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return done.returncode, " ".join(done.stdout.split())

    for options in ([], ["--overwrite"]):
        code, said = start(".", *options)
        report.check(code == 2 and "not empty" in said and file.read_text() == text, f"--output . {options}: code {code}, the case is as it was")
    report.check(start("out")[0] == 0 and (folder / "out" / "resolved_case.toml").is_file(), "a new folder")
    (folder / "out" / "notes.txt").write_text("mine")
    (folder / "out" / "steps").mkdir()
    for name in ("000900.h5", "epoch_000007.h5", "obstacles.h5", "000901.h5.part"):
        (folder / "out" / "steps" / name).write_text("old")
    code, said = start("out")
    report.check(code == 2 and "--overwrite" in said, f"again: code {code}: {said[-90:]}")
    code, said = start("out", "--overwrite")
    report.check(code == 0 and (folder / "out" / "notes.txt").read_text() == "mine", f"--overwrite: code {code}, other files stay")
    report.check(not (folder / "out" / "steps").exists(), "steps of earlier runs go")
    code, said = start("out", "--overwrite", case="out/resolved_case.toml")
    report.check(code == 2 and "its own input" in said, f"from its own echo: code {code}")
    code, said = start("out", "--overwrite", "--restart", f"out/{NAME}")
    report.check(code == 2 and "its own input" in said, f"over what it restarts from: code {code}")
    slow = write_case(strip("static", nx=160, ny=16, steps__max_step=0.002, steps__initial_step=0.002), OUT / "folders_slow.toml")
    process = started(slow, fresh("folders_slow"))
    wait_for(lambda: lines(OUT / "folders_slow" / "history.csv") >= 3, process)
    code, said = start(OUT / "folders_slow", "--overwrite")
    report.check(code == 2 and f"process {process.pid}" in said, f"two at once: code {code}: {said[-120:]}")
    process.kill()
    process.wait()
    report.check(start(OUT / "folders_slow", "--overwrite")[0] == 0, "a lock left by kill -9 holds nobody up")


@test
def damaged_restart(report):
    """One flipped bit anywhere in a checkpoint or a step: exit code 2 or the same run, never a wrong one or a crash."""
    case = strip("dynamic", time__end=0.1)
    whole = solve("damaged_whole", case, 1)
    longer = write_case(strip("dynamic", time__end=0.12), OUT / "damaged.toml")
    right = run(longer, fresh("damaged_right"), 1, ["--restart", whole.folder / "checkpoint.h5"])
    report.check(right.code == 0, "the undamaged one goes on")
    data = (whole.folder / "checkpoint.h5").read_bytes()
    random, codes, wrong = np.random.default_rng(7), [], 0
    for k in range(60):
        bytes_ = bytearray(data)
        at = int(random.integers(len(data)))
        bytes_[at] ^= 1 << int(random.integers(8))
        damaged = OUT / "damaged.h5"
        damaged.write_bytes(bytes_)
        result = run(longer, OUT / "damaged_run", 1, ["--restart", damaged])
        codes.append(result.code)
        if result.code == 0:
            wrong += float(np.abs(result.displacement() - right.displacement()).max()) > 1e-9
        elif result.code != 2:
            report.check(False, f"bit at byte {at}: code {result.code}: {result.text.strip()[-150:]}")
    report.check(wrong == 0 and codes.count(2) > 20, f"{codes.count(2)} refused, {codes.count(0)} had hit nothing, {wrong} wrong")
    with h5py.File(OUT / "damaged.h5", "w") as file, h5py.File(whole.folder / "checkpoint.h5") as good:
        for name in good:
            good.copy(name, file)
        for name, value in good.attrs.items():
            file.attrs[name] = value
        file["velocity"][0, 0] = np.inf
    result = run(longer, OUT / "damaged_run", 1, ["--restart", OUT / "damaged.h5"])
    report.check(result.code == 2 and "not finite" in result.text, f"an infinite velocity: code {result.code}")
    for name in ("displacement", "velocity"):
        with h5py.File(OUT / "damaged.h5", "w") as file, h5py.File(whole.folder / "checkpoint.h5") as good:
            for other in set(good) - {name}:
                good.copy(other, file)
            for key, value in good.attrs.items():
                file.attrs[key] = value
        result = run(longer, OUT / "damaged_run", 1, ["--restart", OUT / "damaged.h5"])
        report.check(result.code == 2 and f"has no '{name}'" in result.text, f"without {name}: code {result.code}: {result.text.strip()[-150:]}")
    result = run(longer, OUT / "damaged_run", 1, ["--restart", ""])
    report.check(result.code == 2 and "the name is empty" in result.text, f"an empty name: code {result.code}")
    result = run(longer, OUT / "damaged_run", 1, ["--restart", OUT / "nowhere.h5"])
    report.check(result.code == 2 and "there is no such file" in result.text, f"a checkpoint that is not there: code {result.code}")
    result = run(longer, OUT / "damaged_run", 1, ["--restart", whole.folder / "checkpoint.h5", "--set", "time.end=0.05"])
    report.check(result.code == 2 and "after the end" in result.text, f"a checkpoint later than the end of the motion: code {result.code}")


@test
def weak_options(report):
    """What options make of the solvers is judged by answers: a strut that has buckled is not called stable, modes and responses have small residuals, and an option says no more than its key may."""
    strut = strip(nx=8, ny=1, load=[{"type": "line", "group": "tip", "vector": [-4, 0, 0]}], probe=[{"name": "tip", "type": "displacement", "group": "tip", "components": ["z"]}])

    def code_of(name, case, options="", *words):
        result = run(write_case(case | {"petsc": {"options": options}}, OUT / f"weak_{name}.toml"), fresh(f"weak_{name}"))
        missing = [w for w in words if w not in result.text]
        report.check(not missing, f"{name}, {options}: {missing or 'said'}")
        return result

    for options in ("-pc_type lu", "-ksp_type cg -pc_type jacobi -ksp_max_it 1000"):
        result = code_of("drape", strut | {"analysis": "drape"}, options)
        report.check(result.code == 3 or abs(result.history["tip_z"][-1]) > 1, f"{options}: the drape of a strut beyond its buckling load, code {result.code}, {result.history['tip_z'][-1]:.3g} m")
        result = code_of("static", strut | {"analysis": "static"}, options)
        report.check(result.code in (3, 5), f"{options}: its load path ends with code {result.code}")
    first = run(write_case(strut | {"analysis": "static"}, OUT / "weak_unstable.toml"), fresh("weak_unstable"))
    again = run(OUT / "weak_unstable.toml", fresh("weak_again"), 1, ["--restart", first.folder / "checkpoint.h5"])
    report.check((first.code, again.code) == (5, 5), f"an unstable end stays one when it is restarted: codes {first.code}, {again.code}")
    staged = {k: v for k, v in strut.items() if k not in ("analysis", "time")} | {"stage": [{"name": "a", "analysis": "static"}, {"name": "b", "analysis": "modal"}]}
    report.check(code_of("stages", staged, "", "if no later stage leaves it").code == 5, "modes of an unstable equilibrium leave it so")
    buckling, modal = (strip(a, nx=8, ny=1, load=strut["load"], eigen={"modes": 2}) for a in ("buckling", "modal"))
    del buckling["time"], modal["time"], modal["load"]
    report.percent(code_of("buckling", buckling).summary["eigenvalues"][0] / (math.pi**2 / 4 / 4), 0.01, "the buckling load")
    for options in ("-pc_type none", "-ksp_type preonly -pc_type jacobi", "-pc_type ilu"):
        report.check(code_of("buckling", buckling, options).code == 2, f"buckling with {options} is refused")
    for options in ("-st_pc_type none", "-st_pc_type mat"):
        report.check(code_of("modal", modal, options).code == 3, f"modes with {options} have not converged")
    response = modal | {"analysis": "harmonic", "harmonic": {"frequencies": [0.01]}, "load": [{"type": "line", "group": "tip", "vector": [0, 0, 1]}], "damping": {"ratio": [0.01]}}
    response["eigen"] = {"modes": 1}
    report.check(code_of("harmonic", response).code == 0 and code_of("harmonic", response, "-pc_type none").code == 2, "a response without its static correction is refused")
    motion, path = strip("dynamic", nx=4, ny=1), strip("static", nx=4, ny=1)
    touching = {"contact": {"distance": 0.1}, "obstacle": [{"name": "ball", "type": "sphere", "point": [8, 0.5, 2], "radius": 1}]}
    for case, options, words in ((path, "-pc_type voile_mixed -mixed_ksp_rtol 1", "-mixed_ksp_rtol of 0.001 at most"), (path, "-pc_type voile_mixed -mixed_ksp_atol 1e10", "-mixed_ksp_"),
                                 (motion, "-inexact_ksp_norm_type none", "does not know when to end"), (motion, "-snes_ksp_ew", "judges convergence itself"), (path, "-ksp_initial_guess_nonzero", "refuses one of its options"),
                                 (path | touching, "-path_control arc_length", "contact in a static path needs load"), (path | {"steps": {"stops": [0.3]}}, "-path_control arc_length", "stops are load factors"),
                                 (path, "-path_at_critical_point stop", "load control cannot stop"), (motion | touching, "-ts_type voile_central", "contact needs the implicit method")):
        report.check(code_of("refused", case, options, words).code == 2, f"{options} is refused")
    for case, words in ((strip("linear", nx=4, ny=1, steps={"control": "arc_length"}), "[steps] control has no effect"), (strip("dynamic", nx=4, ny=1, time={"end": 0.1, "method": "central_difference", "step_error": 1e-3}), "[time] step_error has no effect")):
        code, text = invoke(["check", write_case(case, OUT / "weak_idle.toml")])
        report.check(code == 0 and words in text, f"{words}: code {code}")
