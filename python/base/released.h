#pragma once

// Long calls: without the interpreter's lock, stoppable, and finished before the interpreter exits.

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <utility>

#include "leeway/robots/stopped.h"

namespace leeway::python {

namespace py = pybind11;

/// The interpreter's lock is released while this object exists. Throws std::runtime_error if the
/// interpreter is about to exit, and in a child of fork() whose parent was in such a call, because
/// the locks that it held stay locked there.
class Released {
 public:
  Released();
  ~Released();
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

 private:
  PyThreadState* state_;
};

/// Calls `function` without the interpreter's lock.
template <typename Function>
auto released(Function&& function) {
  const Released unlocked;
  return function();
}

/// Reasons to end a long call early: a signal (in the main thread, which alone gets signals), the
/// exit of the interpreter, or a function of the caller. Constructed with the lock held; called
/// without it.
class Interrupt {
 public:
  explicit Interrupt(py::object stop = py::none());
  /// Checks for signals and calls the caller's function every 20 ms; cheap in between.
  bool operator()();
  /// For PlanOptions::stop; `this` must outlive it.
  std::function<bool()> callback() {
    return [this] { return (*this)(); };
  }
  /// Rethrows the exception that ended the call, if there is one. Call it with the lock held.
  void rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }
  /// Calls `function`, which may throw robots::Stopped, without the interpreter's lock.
  template <typename Function>
  auto released(Function&& function) {
    try {
      return python::released(std::forward<Function>(function));
    } catch (const robots::Stopped&) {
      rethrow();
      throw;
    }
  }
  /// Ends the call with the exception that is being handled, for callbacks that fail.
  void fail() {
    raised_ = std::current_exception();
    ended_ = true;
  }

 private:
  py::object stop_;
  bool sees_signals_;
  std::atomic<bool> ended_ = false;
  /// The time of the next check. Planners with their own threads call this from all of them.
  std::atomic<std::chrono::steady_clock::time_point> next_ = std::chrono::steady_clock::now();
  std::exception_ptr raised_;
};

/// Registers with the interpreter's exit and with fork().
void defineLifetime(py::module_& module);

}  // namespace leeway::python
