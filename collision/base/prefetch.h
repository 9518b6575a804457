#pragma once

// Private to collision/: prefetches of evicted data and code.

#include <cstddef>

namespace leeway::collision {

/// Prefetches the cache lines of `bytes` bytes, all at once. Reading them in order would miss the
/// cache once for each line.
inline void prefetch(const void* from, std::size_t bytes) {
  const char* const begin = static_cast<const char*>(from);
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(begin + i);
}

/// Prefetches code from a function's first byte on; `bytes` may reach past the function's end.
template <class Result, class... Arguments>
void prefetchCode(Result (*function)(Arguments...), std::size_t bytes) {
  prefetch(reinterpret_cast<const char*>(function), bytes);
}

}  // namespace leeway::collision
