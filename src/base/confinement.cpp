#include "confinement.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "child_process.hpp"

namespace voile {

namespace {

constexpr int usual_seconds = 600;

#if defined(__x86_64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t architecture = 0;
#endif

/// What ends the process, with a message: programs, processes, new files. Some of them only older architectures have.
constexpr std::uint32_t ending[] = {SYS_execve, SYS_execveat, SYS_mkdirat, SYS_mknodat,
#ifdef SYS_open
                                    SYS_fork,   SYS_vfork,    SYS_creat,   SYS_mkdir,
                                    SYS_mknod
#endif
};

/// What just fails, as some of it is tried without need, as to delete a file that is not there.
constexpr std::uint32_t failing[] = {SYS_unlinkat,
                                     SYS_renameat2,
                                     SYS_linkat,
                                     SYS_symlinkat,
                                     SYS_fchmod,
                                     SYS_fchmodat,
                                     SYS_fchown,
                                     SYS_fchownat,
                                     SYS_utimensat,
                                     SYS_truncate,
                                     SYS_ftruncate,
                                     SYS_fallocate,
                                     SYS_setxattr,
                                     SYS_lsetxattr,
                                     SYS_fsetxattr,
                                     SYS_removexattr,
                                     SYS_lremovexattr,
                                     SYS_fremovexattr,
                                     SYS_socket,
                                     SYS_socketpair,
                                     SYS_connect,
                                     SYS_bind,
                                     SYS_ptrace,
                                     SYS_process_vm_writev,
                                     SYS_process_vm_readv,
                                     SYS_tkill,
                                     SYS_rt_sigqueueinfo,
                                     SYS_rt_tgsigqueueinfo,
                                     SYS_pidfd_send_signal,
                                     SYS_pidfd_getfd,
                                     SYS_kcmp,
                                     SYS_mount,
                                     SYS_umount2,
                                     SYS_pivot_root,
                                     SYS_chroot,
                                     SYS_setns,
                                     SYS_unshare,
                                     SYS_swapon,
                                     SYS_swapoff,
                                     SYS_reboot,
                                     SYS_sethostname,
                                     SYS_setdomainname,
                                     SYS_init_module,
                                     SYS_finit_module,
                                     SYS_delete_module,
                                     SYS_kexec_load,
                                     SYS_bpf,
                                     SYS_perf_event_open,
                                     SYS_userfaultfd,
                                     SYS_keyctl,
                                     SYS_add_key,
                                     SYS_request_key,
                                     SYS_open_by_handle_at,
                                     SYS_quotactl,
                                     SYS_acct,
                                     SYS_settimeofday,
                                     SYS_clock_settime,
                                     SYS_shmget,
                                     SYS_shmat,
                                     SYS_msgget,
                                     SYS_semget,
                                     SYS_mq_open,
                                     SYS_mq_unlink,
                                     SYS_setpriority,
                                     SYS_ioprio_set,
                                     SYS_setuid,
                                     SYS_setgid,
#ifdef SYS_renameat
                                     SYS_renameat,
#endif
#ifdef SYS_open
                                     SYS_unlink,
                                     SYS_rmdir,
                                     SYS_rename,

                                     SYS_link,
                                     SYS_symlink,
                                     SYS_chmod,
                                     SYS_chown,
                                     SYS_lchown,
                                     SYS_utime,
                                     SYS_utimes,
                                     SYS_futimesat
#endif
};

/// Calls that the filter cannot look into, and for which there is an older way that it can.
constexpr std::uint32_t missing[] = {SYS_clone3, SYS_openat2, SYS_io_uring_setup, SYS_io_uring_enter};

/// The last call of Linux 6.1: what came later is not known here.
constexpr std::uint32_t last_known = 450;

constexpr std::uint32_t opening_flags = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND | (O_TMPFILE & ~O_DIRECTORY);

class Filter {
 public:
  Filter() {
    load(offsetof(seccomp_data, arch));
    unless_equal(architecture, SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
    put(BPF_JMP | BPF_JGT | BPF_K, last_known, 0, 1);
    answer(SECCOMP_RET_ERRNO | ENOSYS);
    for (const std::uint32_t call : ending) if_equal(call, SECCOMP_RET_TRAP);
    for (const std::uint32_t call : failing) if_equal(call, SECCOMP_RET_ERRNO | EPERM);
    for (const std::uint32_t call : missing) if_equal(call, SECCOMP_RET_ERRNO | ENOSYS);
#ifdef SYS_open
    for_call(SYS_open, argument(1), [&] { if_any(opening_flags, SECCOMP_RET_TRAP); });
#endif
    for_call(SYS_openat, argument(2), [&] { if_any(opening_flags, SECCOMP_RET_TRAP); });
    for_call(SYS_clone, argument(0), [&] { unless_any(CLONE_THREAD, SECCOMP_RET_TRAP); });
    const auto self = static_cast<std::uint32_t>(getpid());
    for (const std::uint32_t call : {SYS_kill, SYS_tgkill})
      for_call(call, argument(0), [&] { unless_equal(self, SECCOMP_RET_ERRNO | EPERM); });
    for_call(SYS_prlimit64, argument(0), [&] { unless_equal(0, SECCOMP_RET_ERRNO | EPERM); });
    answer(SECCOMP_RET_ALLOW);
  }

  /// For all threads: libraries may have started some.
  [[nodiscard]] bool install() {
    sock_fprog program{static_cast<unsigned short>(code_.size()), code_.data()};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program) == 0;
  }

 private:
  /// The lower half of an argument: flags and process numbers have no more.
  static std::uint32_t argument(unsigned number) {
    return static_cast<std::uint32_t>(offsetof(seccomp_data, args) + 8 * number);
  }
  void put(int code, std::uint32_t value, std::uint8_t if_true = 0, std::uint8_t if_false = 0) {
    code_.push_back({static_cast<std::uint16_t>(code), if_true, if_false, value});
  }
  void load(std::size_t offset) {
    put(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
  }
  void answer(std::uint32_t what) {
    put(BPF_RET | BPF_K, what);
  }
  void if_equal(std::uint32_t value, std::uint32_t what) {
    put(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    answer(what);
  }
  void unless_equal(std::uint32_t value, std::uint32_t what) {
    put(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0);
    answer(what);
  }
  void if_any(std::uint32_t bits, std::uint32_t what) {
    put(BPF_JMP | BPF_JSET | BPF_K, bits, 0, 1);
    answer(what);
  }
  void unless_any(std::uint32_t bits, std::uint32_t what) {
    put(BPF_JMP | BPF_JSET | BPF_K, bits, 1, 0);
    answer(what);
  }
  /// Looks at an argument of a call with `judge`, which makes two instructions, and allows what passes.
  template <class Judge>
  void for_call(std::uint32_t call, std::uint32_t offset, const Judge& judge) {
    put(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4);
    load(offset);
    judge();
    answer(SECCOMP_RET_ALLOW);
  }

  std::vector<sock_filter> code_;
};

/// The parent says the same where the signal could not be caught: C libraries block it to start a program.
extern "C" void end_with_message(int, siginfo_t* info, void*) {
  bool starts = info->si_syscall == SYS_execve || info->si_syscall == SYS_execveat || info->si_syscall == SYS_clone;
#ifdef SYS_open
  starts = starts || info->si_syscall == SYS_fork || info->si_syscall == SYS_vfork;
#endif
  end_child(starts ? Refused::program : Refused::file);
}

void limit(__rlimit_resource what, rlim_t most) {
  rlimit both{};
  if (getrlimit(what, &both) != 0) return;
  both.rlim_cur = both.rlim_max = std::min(both.rlim_max, most);
  (void)setrlimit(what, &both);
}

}  // namespace

int limit_of_reading() {
  const char* given = std::getenv("VOILE_READ_SECONDS");
  const int seconds = given ? std::atoi(given) : 0;
  return seconds > 0 ? seconds : usual_seconds;
}

bool confine_process() {
  if (std::getenv("VOILE_READ_HERE")) return true;
  (void)alarm(static_cast<unsigned>(limit_of_reading()));
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  struct sigaction action {};
  action.sa_sigaction = end_with_message;
  action.sa_flags = SA_SIGINFO;
  (void)sigaction(SIGSYS, &action, nullptr);
  if (architecture != 0 && Filter().install()) return true;
  limit(RLIMIT_NPROC, 0);
  return false;
}

}  // namespace voile
