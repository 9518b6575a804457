#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <stdexcept>

namespace leeway::planner {

/// Returns the bytes from one of `count` items of memory to the next, where `given` = 0 says that
/// nothing stands between them. Throws std::invalid_argument for a stride smaller than an item's
/// `size` [bytes], and for a null pointer to items.
inline std::size_t strideOf(const void* first, std::size_t count, std::size_t given,
                            std::size_t size) {
  if (first == nullptr && count * size > 0)
    throw std::invalid_argument(fmt::format(
        "first is a null pointer beside {} items; the address of the first is expected", count));
  if (given != 0 && given < size && count > 1)
    throw std::invalid_argument(
        fmt::format("stride {}; at least {} bytes, or 0 for no gap, are accepted", given, size));
  return given == 0 ? size : given;
}

}  // namespace leeway::planner
