"""What a terminal shows: a line of progress that rewrites itself, and colour; and plain lines elsewhere."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios

from common import base, fresh, strip, without_stops
from harness import OUT, test
from solver import command, environment, invoke, write_case

ERASE, COLOUR = "\r\x1b[K", re.compile(r"\x1b\[[0-9;]+m")


def on_terminal(words, columns=60, **variables):
    """Exit code and all that a terminal gets."""
    child, terminal = pty.fork()
    if child == 0:
        env = {k: v for k, v in environment(1).items() if k != "NO_COLOR"} | {"TERM": "xterm"} | variables
        os.execvpe(words[0], words, env)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    pieces = []
    try:
        while piece := os.read(terminal, 65536):
            pieces.append(piece)
    except OSError:  # the other end is closed
        pass
    os.close(terminal)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), b"".join(pieces).decode().replace("\r\n", "\n")


def shown(text):
    """The lines that stay, as a terminal shows them."""
    return [line.split(ERASE)[-1] for line in text.split("\n")]


@test
def progress_line(report):
    """Steps rewrite one line of a terminal, in its width; what else is printed begins on a fresh line; files, ranks, --plain, NO_COLOR, dumb terminals and monitors get lines."""
    case = write_case(without_stops(base("slit_annulus", mesh__parameters={"n_radial": 3, "n_circ": 30})), OUT / "progress_line.toml")
    run = lambda *more: command(["run", case, "--output", fresh("progress_line"), *more])  # noqa: E731
    code, text = on_terminal(run())
    lines = re.findall(r"\r\x1b\[K(step[^\r\n]*)", text)
    report.check(code == 0 and lines and " left" in lines[0], f"code {code}, {len(lines)} states of the line, the first: {lines[:1]}")
    report.check(all(len(line) < 60 for line in lines), f"longest: {max(map(len, lines))} of 60 columns")
    report.check(not any(line.startswith("step") for line in shown(text)) and shown(text)[-1] == "", "nothing of it stays")
    for what, more, variables in (("--plain", ["--plain"], {}), ("NO_COLOR", [], {"NO_COLOR": "1"}), ("dumb", [], {"TERM": "dumb"}),
                                  ("a monitor", ["-snes_monitor"], {}), ("a launcher", [], {"PMIX_RANK": "0"})):
        code, text = on_terminal(run(*more), **variables)
        report.check(code == 0 and ERASE not in text and re.search(r"^ +2 ", text, re.M), f"{what}: code {code}, plain lines")
    code, text = on_terminal(run("-log_view"))
    report.check(code == 0 and any(line.startswith("*****") for line in shown(text)), "-log_view is whole")
    done = subprocess.run(run(), env=environment(1) | {"TERM": "xterm"}, text=True, capture_output=True)
    report.check(done.returncode == 0 and "\x1b" not in done.stdout + done.stderr and re.search(r"^ +2 ", done.stdout, re.M), "a file gets lines")


@test
def coloured_words(report):
    """Errors and warnings have colour on a terminal only, not with NO_COLOR; they begin on a fresh line; the nearest command, option and key are named."""
    code, text = on_terminal(command(["rum", "x.toml"]), 200)
    report.check(code == 2 and "voile: \x1b[1;31merror:\x1b[0m" in text and "did you mean run?" in text, f"a terminal: {text!r:.120}")
    for variables in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        code, text = on_terminal(command(["rum", "x.toml"]), 200, **variables)
        report.check(code == 2 and not COLOUR.search(text), f"{variables}: {text!r:.80}")
    code, text = invoke(["rum", "x.toml"])
    report.check(code == 2 and not COLOUR.search(text), "a file has none")
    case = strip("dynamic", load=[{"type": "line", "group": "tip", "vector": [0, 0, 1.0], "history": "t > 0.055 ? 1e12 : 1"}], time__min_step=0.005)
    file = write_case(case, OUT / "coloured_words.toml")
    code, text = on_terminal(command(["run", file, "--output", fresh("coloured_words"), "-snes_max_it", "3"]), 200)
    said = [line for line in shown(text) if "not converged" in line]
    report.check(code == 3 and len(said) == 1 and COLOUR.sub("", said[0]).startswith("voile: not converged"), f"a run that fails: code {code}, {said}")
    for words, word in ((["run", file, "--outptu", "x"], "--output"), (["render", "x", "--steps", "1", "--siz", "1x1"], "--size"),
                        (["run", file, "--set", "time.stepp=1"], "step"), (["drape-test", "cotton", "--repeat", "1"], "--repeats")):
        code, text = invoke(words)
        report.check(code == 2 and re.search(f"did you mean '?{word}", text), f"{' '.join(map(str, words[2:]))}: {text.strip()[-120:]}")
