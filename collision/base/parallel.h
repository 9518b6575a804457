#pragma once

// Private to the library: runs two halves of a large task at the same time.

#include <exception>
#include <system_error>
#include <thread>

namespace leeway::collision {

/// Calls both functions and returns when both are done. They run at the same time if that is
/// `worth` a thread (about 20 us) and the machine has two cores, otherwise one after the other.
/// They must not depend on each other, so that the result does not depend on the order. Rethrows
/// what one of them throws.
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
    } catch (const std::system_error&) {  // no thread is available
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

/// A task of this many triangles or more is worth a thread [count].
inline constexpr std::size_t kWorthAThread = 20000;

}  // namespace leeway::collision
