"""Time and memory of a program and everything it starts."""

import os
import re
import subprocess
import time
from dataclasses import dataclass

from solver import environment


@dataclass
class Use:
    code: int
    cpu_seconds: float   # user + system, all processes
    wall_seconds: float
    peak_memory: float   # resident memory of the largest process [bytes]


def measure(command, log, cwd=None, ranks=1, **variables):
    """Runs a command, of so many ranks, with its output in the file `log`."""
    begin = time.time()
    with open(log, "w") as out:
        process = subprocess.Popen([str(c) for c in command], cwd=cwd, env=environment(ranks) | variables, stdout=out,
                                   stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        _, status, use = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return Use(process.returncode, use.ru_utime + use.ru_stime, time.time() - begin, use.ru_maxrss * 1024.0)


EVENTS = ("VoileBendAssemble", "VoileBendCopy", "VoileResidual", "VoileTangent", "MatCholFctrSym", "MatCholFctrNum",
          "MatLUFactorSym", "MatLUFactorNum", "MatSolve", "VoileFactorSingle", "VoileRefine", "VoileFactorIncomplete", "VoileIterate", "VoileEnergy", "VoileOutput", "VoileContactFind", "VoileContactClear",
          "VoileContactTerm", "SNESSolve")


def read_log_view(text):
    """Event -> (count, seconds of the slowest rank) from the ASCII output of -log_view."""
    events = {}
    for line in text.splitlines():
        match = re.match(r"^(\w+)\s+(\d+)\S?\s+[\d.]+\s+(\d\.\d+e[+-]\d+)\s", line)
        if match and match.group(1) in EVENTS:
            count, seconds = events.get(match.group(1), (0, 0.0))
            events[match.group(1)] = (count + int(match.group(2)), seconds + float(match.group(3)))
    return events
