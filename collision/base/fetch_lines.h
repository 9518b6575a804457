#pragma once

// Private to collision/: memory that is far because much else has been read since.

#include <cstddef>

namespace leeway::collision {

/// Starts to bring near this many bytes: lines that are far come one after the other otherwise,
/// each when it is reached.
inline void fetchLines(const void* from, std::size_t bytes) {
  const char* const begin = static_cast<const char*>(from);
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(begin + i);
}

}  // namespace leeway::collision
