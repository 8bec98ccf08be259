// Reading what a stranger wrote, in a process that has no rights to do harm with. Linux: seccomp, and limits of resources.
#pragma once

namespace voile {

/// Gives up, in this process and all its threads and for good, the rights to start programs and processes, to write,
/// make, rename or delete files, to open sockets and to touch other processes; reading files remains. What tries to run
/// a program or to write a file ends the process with a message to the parent. Returns whether the kernel filters
/// system calls: if not, files grow by nothing (RLIMIT_FSIZE) and users other than root start nothing (RLIMIT_NPROC).
/// The process ends after limit_of_reading() seconds. For programs that answer through answer_to_parent(); without effect with VOILE_READ_HERE in the environment.
bool confine_process();

/// Seconds after which the reading of a foreign script is stopped: VOILE_READ_SECONDS of the environment, or 600.
[[nodiscard]] int limit_of_reading();

}  // namespace voile
