#pragma once

// Private to the library: two halves of a large task at the same time.

#include <exception>
#include <system_error>
#include <thread>

namespace leeway::collision {

/// Calls both, and returns when both are done: at the same time where that is `worth` a thread
/// (some 20 us) and the machine has two cores, else one after the other. They must not depend on
/// each other, so that nothing depends on which it is. Throws what one of them throws.
template <class First, class Second>
void inParallel(bool worth, const First& first, const Second& second) {
  std::exception_ptr error;
  std::thread other;
  if (worth && std::thread::hardware_concurrency() > 1) {
    try {
      other = std::thread([&] {
        try {
          second();
        } catch (...) {
          error = std::current_exception();
        }
      });
    } catch (const std::system_error&) {  // no thread is to be had
    }
  }
  if (!other.joinable()) {
    first();
    second();
    return;
  }
  try {
    first();
  } catch (...) {
    other.join();
    throw;
  }
  other.join();
  if (error) std::rethrow_exception(error);
}

/// Tasks of so many triangles or more are worth a thread [count].
inline constexpr std::size_t kWorthAThread = 20000;

}  // namespace leeway::collision
