#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/stopped.h"

namespace leeway::planner {

/// A picture with one channel, row by row from the top.
struct GrayImage {
  std::size_t width = 0, height = 0;
  int bits =
      0;  ///< of a value: 1, 2, 4, 8 or 16 in PNG; 8 or 16 in PGM, where values may end below
  std::vector<std::uint16_t> values;
};

/// Reads a PNG (grey, 1 to 16 bits, without alpha) or a PGM (P2, P5). Values stay as they are
/// stored: neither gamma nor the number of significant bits is applied. `kind` says in messages
/// what is expected ("a depth image"). Throws robots::InputError with the line or byte for another
/// ending, a damaged file and more than 2^26 pixels, robots::Stopped. O(size).
GrayImage readGrayImage(const std::string& path, std::string_view kind, const robots::Stop& stop);

}  // namespace leeway::planner
