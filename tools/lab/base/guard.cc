#include "tools/lab/base/guard.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <system_error>

namespace leeway::tools::report {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Limits processor time, because load on the machine must not count as an endless loop.
void setTimer(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(std::floor(seconds));
  timer.it_value.tv_usec =
      static_cast<suseconds_t>(std::lround(1e6 * (seconds - std::floor(seconds))));
  setitimer(ITIMER_PROF, &timer, nullptr);
}

struct Progress {
  std::size_t current;
};

/// A child's work: items from `first` on, until the end or until one kills the child.
[[noreturn]] void liveAsChild(std::size_t first, std::size_t count, double seconds,
                              const std::function<void(std::size_t)>& work, Progress& progress,
                              std::span<Fate> fates) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // the answers of an interrupted report are not read
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (null >= 0) dup2(null, STDERR_FILENO);
  for (const int signal_number : {SIGPROF, SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL})
    signal(signal_number, SIG_DFL);
  for (std::size_t i = first; i < count; ++i) {
    progress.current = i;
    setTimer(seconds);
    try {
      work(i);
      fates[i] = Fate::kDone;
    } catch (...) {
      fates[i] = Fate::kThrew;
    }
  }
  progress.current = count;
  _exit(0);
}

}  // namespace

SharedMemory::SharedMemory(std::size_t bytes)
    : data_(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)),
      bytes_(bytes) {
  if (data_ == MAP_FAILED) throw std::bad_alloc();
}

SharedMemory::~SharedMemory() { munmap(data_, bytes_); }

std::vector<Fate> runGuarded(std::size_t count, double seconds,
                             const std::function<void(std::size_t)>& work) {
  const SharedArray<Fate> fates(count);
  const SharedArray<Progress> progress(1);
  for (std::size_t next = 0; next < count;) {
    progress[0].current = next;
    const pid_t child = fork();
    if (child < 0) fail("fork");
    if (child == 0) liveAsChild(next, count, seconds, work, progress[0], fates.span());
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
      if (errno != EINTR) fail("waitpid");
    const std::size_t reached = progress[0].current;
    if (reached >= count) break;
    // A call of exit() counts as dying.
    fates[reached] =
        WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF ? Fate::kTimedOut : Fate::kDied;
    next = reached + 1;
  }
  const std::span<const Fate> found = fates.span();
  return {found.begin(), found.end()};
}

}  // namespace leeway::tools::report
