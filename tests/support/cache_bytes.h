#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

// Bytes of vertex caches according to the formats' specifications.

namespace leeway::cache_bytes {

inline void put(std::string& bytes, std::uint32_t word, bool big_endian) {
  for (int i = 0; i < 4; ++i)
    bytes.push_back(static_cast<char>(word >> (big_endian ? 24 - 8 * i : 8 * i) & 0xff));
}
inline void put(std::string& bytes, std::int32_t n, bool big_endian) {
  put(bytes, std::bit_cast<std::uint32_t>(n), big_endian);
}
inline void put(std::string& bytes, float x, bool big_endian) {
  put(bytes, std::bit_cast<std::uint32_t>(x), big_endian);
}

/// Coordinate k of vertex v in frame f.
inline float coordinate(int f, int v, int k) { return 0.25f * float(100 * f + 10 * v + k) - 3; }

inline std::string pc2(std::int32_t frames, std::int32_t vertices, float first = 2,
                       float step = 0.5f) {
  std::string bytes("POINTCACHE2\0", 12);
  put(bytes, std::int32_t{1}, false);
  put(bytes, vertices, false);
  put(bytes, first, false);
  put(bytes, step, false);
  put(bytes, frames, false);
  for (int f = 0; f < frames; ++f)
    for (int v = 0; v < vertices; ++v)
      for (int k = 0; k < 3; ++k) put(bytes, coordinate(f, v, k), false);
  return bytes;
}

inline std::string mdd(std::int32_t frames, std::int32_t vertices) {
  std::string bytes;
  put(bytes, frames, true);
  put(bytes, vertices, true);
  for (int f = 0; f < frames; ++f) put(bytes, 0.125f * float(f * f), true);
  for (int f = 0; f < frames; ++f)
    for (int v = 0; v < vertices; ++v)
      for (int k = 0; k < 3; ++k) put(bytes, coordinate(f, v, k), true);
  return bytes;
}

}  // namespace leeway::cache_bytes
