"""Time and memory of a program and everything it starts."""

import os
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


def measure(command, log, cwd=None, **variables):
    """Runs a command with its output in the file `log`."""
    begin = time.time()
    with open(log, "w") as out:
        process = subprocess.Popen([str(c) for c in command], cwd=cwd, env=environment() | variables, stdout=out,
                                   stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        _, status, use = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return Use(process.returncode, use.ru_utime + use.ru_stime, time.time() - begin, use.ru_maxrss * 1024.0)
