#include "python/base/released.h"

#include <stdexcept>
#include <thread>
#include <utility>

namespace leeway::python {
namespace {

// The first three change only with the interpreter's lock held: the number of calls that run
// without it; whether the interpreter is about to exit; whether this process is a child of fork()
// with locks that no thread can release.
int running = 0;
std::atomic<bool> ending = false;
bool orphaned = false;
unsigned long main_thread = 0;  ///< its identifier

void check() {
  if (orphaned)
    throw std::runtime_error(
        "leeway: the process was forked while a thread was planning; plan there before or after, "
        "or start processes with 'spawn'");
  if (ending) throw std::runtime_error("leeway: the interpreter is about to end");
}

/// If a thread requests the lock of an exiting interpreter, CPython unwinds it through C++ code
/// that must not throw, which aborts the process. So the exit waits for such calls.
void finish() {
  ending = true;
  while (running > 0) {
    const py::gil_scoped_release unlocked;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

Released::Released() {
  check();
  ++running;
  state_ = PyEval_SaveThread();
}

Released::~Released() {
  PyEval_RestoreThread(state_);
  --running;
}

Interrupt::Interrupt(py::object stop) : stop_(std::move(stop)) {
  if (!stop_.is_none() && PyCallable_Check(stop_.ptr()) == 0)
    throw py::type_error(
        "stop is no function; one without arguments that returns a bool is "
        "expected");
  // No Python code runs here: during its exit the interpreter ends threads that wait for its lock,
  // and C++ frames do not survive that.
  sees_signals_ = PyThread_get_thread_ident() == main_thread;
}

bool Interrupt::operator()() {
  if (ended_) return true;
  if (ending) return ended_ = true;
  if (!sees_signals_ && stop_.is_none()) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_.load()) return false;
  next_ = now + std::chrono::milliseconds(20);
  const py::gil_scoped_acquire locked;
  try {
    if (sees_signals_ && PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!stop_.is_none() && py::bool_(stop_())) ended_ = true;
  } catch (...) {
    fail();
  }
  return ended_;
}

void defineLifetime(py::module_&) {
  main_thread =
      py::module_::import("threading").attr("main_thread")().attr("ident").cast<unsigned long>();
  py::module_::import("atexit").attr("register")(py::cpp_function(finish));
  py::module_::import("os").attr("register_at_fork")(
      py::arg("after_in_child") = py::cpp_function([] {
        orphaned = orphaned || running > 0;
        main_thread = PyThread_get_thread_ident();  // after fork() only the calling thread exists
      }));
}

}  // namespace leeway::python
