// Preloaded: the n-th allocation from the beginning of main() on and all later ones fail
// ($LEEWAY_FAIL_AT = n), or with $LEEWAY_FAIL_ONCE that one alone. What shared libraries allocate
// before main() is theirs to lose.

#include <dlfcn.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>

namespace {

using Main = int (*)(int, char**, char**);

std::atomic<long> count{0};
std::atomic<bool> begun{false};
Main real_main = nullptr;

int countedMain(int argc, char** argv, char** environment) {
  begun = true;
  const int status = real_main(argc, argv, environment);
  begun = false;
  return status;
}

bool fails() {
  static const long at = [] {
    const char* text = std::getenv("LEEWAY_FAIL_AT");
    return text != nullptr ? std::strtol(text, nullptr, 10) : 0L;
  }();
  static const bool once = std::getenv("LEEWAY_FAIL_ONCE") != nullptr;
  if (!begun) return false;
  const long now = ++count;
  if (at == 0 || (once ? now != at : now < at)) return false;
  errno = ENOMEM;
  return true;
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
  using Malloc = void* (*)(std::size_t);
  static const auto real = reinterpret_cast<Malloc>(dlsym(RTLD_NEXT, "malloc"));
  return fails() ? nullptr : real(size);
}

extern "C" int __libc_start_main(Main main, int argc, char** argv, void (*init)(), void (*fini)(),
                                 void (*rtld_fini)(), void* stack_end) {
  using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
  const auto real = reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"));
  real_main = main;
  return real(countedMain, argc, argv, init, fini, rtld_fini, stack_end);
}
