#include "planner/sensed/cloud_source.h"

namespace leeway::planner {

// A control byte c below 32 precedes c + 1 literal bytes. Any other is a reference to earlier
// bytes: its upper three bits are the length minus 2 (7: the next byte adds to it), its other bits
// and one more byte the distance minus 1. Source and copy may overlap.
std::optional<std::string> decompressLzf(std::string_view data, std::size_t size) {
  std::string out;
  // A reference of three bytes makes at most 264.
  if (size / 88 > data.size()) return std::nullopt;
  out.reserve(size);
  std::size_t at = 0;
  while (at < data.size()) {
    const auto control = static_cast<unsigned char>(data[at++]);
    if (control < 32) {
      const std::size_t count = control + std::size_t{1};
      if (count > data.size() - at || count > size - out.size()) return std::nullopt;
      out.append(data.substr(at, count));
      at += count;
      continue;
    }
    std::size_t length = control >> 5U;
    if (length == 7) {
      if (at == data.size()) return std::nullopt;
      length += static_cast<unsigned char>(data[at++]);
    }
    length += 2;
    if (at == data.size()) return std::nullopt;
    const std::size_t back =
        ((control & 31U) << 8U) + static_cast<unsigned char>(data[at++]) + std::size_t{1};
    if (back > out.size() || length > size - out.size()) return std::nullopt;
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

}  // namespace leeway::planner
