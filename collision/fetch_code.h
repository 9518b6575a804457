#pragma once

// Private to collision/: code that is far because much else has run since it did last.

#include <cstddef>

namespace leeway::collision {

/// Starts to bring near this many bytes of code from a function's begin on, or what stands behind
/// it: lines of code that are far come one after the other otherwise, each when it is reached.
template <class Result, class... Arguments>
void fetchCode(Result (*function)(Arguments...), std::size_t bytes) {
  const char* from = reinterpret_cast<const char*>(function);
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(from + i);
}

}  // namespace leeway::collision
