#pragma once

// Long calls: without the interpreter's lock, stoppable, and over before the interpreter is.

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <utility>

#include "leeway/robots/stopped.h"

namespace leeway::python {

namespace py = pybind11;

/// The interpreter's lock is released as long as this lives. Throws std::runtime_error where the
/// interpreter is about to end, and in a child of fork() whose parent was in such a call: locks
/// that it held stay held there.
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

/// What ends a long call early: a signal (in the main thread, which alone sees signals), the end of
/// the interpreter, or a function of the caller's. Made with the lock held; asked without it.
class Interrupt {
 public:
  explicit Interrupt(py::object stop = py::none());
  /// Every 20 ms looks for signals and asks the caller's function; cheap in between.
  bool operator()();
  /// For PlanOptions::stop; `this` must outlive it.
  std::function<bool()> callback() {
    return [this] { return (*this)(); };
  }
  /// What ended the call, if that was an exception. With the lock held.
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
  /// When to look again. Planners with threads of their own ask from all of them.
  std::atomic<std::chrono::steady_clock::time_point> next_ = std::chrono::steady_clock::now();
  std::exception_ptr raised_;
};

/// Registers with the interpreter's end and with fork().
void defineLifetime(py::module_& module);

}  // namespace leeway::python
