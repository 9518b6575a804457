#pragma once

// Private to collision/: code that is far because much else has run since it did last.

#include <cstddef>

#include "collision/base/fetch_lines.h"

namespace leeway::collision {

/// fetchLines() from a function's begin on, or of what stands behind it.
template <class Result, class... Arguments>
void fetchCode(Result (*function)(Arguments...), std::size_t bytes) {
  fetchLines(reinterpret_cast<const char*>(function), bytes);
}

}  // namespace leeway::collision
