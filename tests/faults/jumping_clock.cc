// Preloaded: the wall clock jumps by up to a year at every look, back and forth, and the steady one
// ($LEEWAY_STEADY_JUMP = s) at every seventh forward by so many seconds, as after a sleep.

#include <dlfcn.h>
#include <sys/time.h>

#include <atomic>
#include <cstdlib>
#include <ctime>

namespace {

long nextJump() {
  static std::atomic<unsigned> state{1};
  return static_cast<long>((state.fetch_add(1) * 2654435761U) >> 7);
}

long steadyJump() {
  static const long jump = [] {
    const char* text = std::getenv("LEEWAY_STEADY_JUMP");
    return text != nullptr ? std::strtol(text, nullptr, 10) : 0L;
  }();
  static std::atomic<long> looks{0};
  return ++looks / 7 * jump;
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* time) {
  using ClockGettime = int (*)(clockid_t, timespec*);
  static const auto real = reinterpret_cast<ClockGettime>(dlsym(RTLD_NEXT, "clock_gettime"));
  const int status = real(clock, time);
  if (status != 0) return status;
  if (clock == CLOCK_REALTIME) time->tv_sec += nextJump() % (2 * 31'536'000) - 31'536'000;
  if (clock == CLOCK_MONOTONIC) time->tv_sec += steadyJump();
  return 0;
}
