#include "planner/problem/vertex_cache.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace leeway::planner {
namespace {

using collision::CacheMotion;
using collision::InvalidMotion;

constexpr char kPc2Mark[12] = "POINTCACHE2";  // with its zero
constexpr std::size_t kPc2Header = 32, kMddHeader = 8;
constexpr std::size_t kVertexBytes = 12;

/// Reads numbers of four bytes in sequence. Does not check that the bytes exist.
class Words {
 public:
  Words(std::span<const std::byte> bytes, bool big_endian)
      : at_(bytes.data()), big_endian_(big_endian) {}

  std::int32_t integer() { return std::bit_cast<std::int32_t>(word()); }
  float number() { return std::bit_cast<float>(word()); }

 private:
  std::uint32_t word() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
      value |= std::to_integer<std::uint32_t>(at_[i]) << (big_endian_ ? 24 - 8 * i : 8 * i);
    at_ += 4;
    return value;
  }
  const std::byte* at_;
  bool big_endian_;
};

/// The shortest text that is read back as exactly the same number.
std::string shortNumber(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

[[noreturn]] void refuse(const char* format, const std::string& what) {
  throw InvalidMotion(std::string(format) + " cache: " + what);
}

void requireHeader(const char* format, std::size_t size, std::size_t header) {
  if (size >= header) return;
  refuse(format, std::to_string(size) + " bytes; its header alone has " + std::to_string(header));
}

void requireCount(const char* format, const char* things, std::int32_t count) {
  if (count >= 1) return;
  refuse(format, std::to_string(count) + " " + things + "; at least 1 is needed");
}

/// Throws unless the remaining `rest` bytes hold `frames` frames of `vertices` vertices with
/// `extra` bytes per frame.
void requireSize(const char* format, std::size_t rest, std::int32_t frames, std::int32_t vertices,
                 std::size_t extra) {
  const auto f = static_cast<std::uint64_t>(frames);
  // Divide: a frame has up to 2^31 * 12 + 4 bytes, and their product with the frames may overflow.
  const std::uint64_t frame = static_cast<std::uint64_t>(vertices) * kVertexBytes + extra;
  if (rest % f == 0 && rest / f == frame) return;
  const bool short_of = rest / f < frame;
  refuse(format, std::to_string(rest) + " bytes after the header, " +
                     (short_of ? "too few" : "too many") + " for " + std::to_string(frames) +
                     " frames of " + std::to_string(vertices) + " vertices, which take " +
                     std::to_string(frame) + " each");
}

void requireScale(const char* format, double scale) {
  if (std::abs(scale) > 0 && std::abs(scale) <= std::numeric_limits<double>::max()) return;
  refuse(format, "scale " + shortNumber(scale) + "; a finite number that is not 0 is accepted");
}

void readPositions(Words& words, double scale, CacheMotion& motion) {
  for (Eigen::Vector3d& p : motion.positions)
    for (int k = 0; k < 3; ++k) p[k] = scale * static_cast<double>(words.number());
}

void makeRoom(std::int32_t frames, std::int32_t vertices, CacheMotion& motion) {
  motion.vertex_count = vertices;
  motion.times.reserve(static_cast<std::size_t>(frames));
  motion.positions.resize(static_cast<std::size_t>(frames) * static_cast<std::size_t>(vertices));
}

}  // namespace

CacheMotion parsePc2(std::span<const std::byte> bytes, double frames_per_second, double scale) {
  constexpr const char* kFormat = "PC2";
  requireScale(kFormat, scale);
  if (!(frames_per_second > 0 && frames_per_second <= std::numeric_limits<double>::max())) {
    refuse(kFormat, shortNumber(frames_per_second) +
                        " frames per second; a finite number above 0 is accepted");
  }
  // Check the mark before the length, because a short file of another kind is not a PC2 at all.
  const std::span<const std::byte> mark = std::as_bytes(std::span(kPc2Mark));
  const std::size_t marked = std::min(bytes.size(), mark.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(marked), mark.begin()))
    refuse(kFormat, "does not begin with POINTCACHE2; only PC2 files are accepted here");
  requireHeader(kFormat, bytes.size(), kPc2Header);
  Words words(bytes.subspan(sizeof kPc2Mark), false);
  const std::int32_t version = words.integer(), vertices = words.integer();
  const float first = words.number(), step = words.number();
  const std::int32_t frames = words.integer();
  if (version != 1) refuse(kFormat, "version " + std::to_string(version) + "; 1 is accepted");
  requireCount(kFormat, "vertices", vertices);
  requireCount(kFormat, "samples", frames);
  if (!std::isfinite(first))
    refuse(kFormat, "first frame " + shortNumber(double(first)) + "; finite numbers are accepted");
  if (!(step > 0 && std::isfinite(step))) {
    refuse(kFormat, "a sample every " + shortNumber(double(step)) +
                        " frames; a finite number above 0 is accepted");
  }
  requireSize(kFormat, bytes.size() - kPc2Header, frames, vertices, 0);
  CacheMotion motion;
  makeRoom(frames, vertices, motion);
  for (std::int32_t i = 0; i < frames; ++i)
    motion.times.push_back((double(first) + i * double(step)) / frames_per_second);
  readPositions(words, scale, motion);
  return motion;
}

CacheMotion parseMdd(std::span<const std::byte> bytes, double scale) {
  constexpr const char* kFormat = "MDD";
  requireScale(kFormat, scale);
  requireHeader(kFormat, bytes.size(), kMddHeader);
  Words words(bytes, true);
  const std::int32_t frames = words.integer(), vertices = words.integer();
  requireCount(kFormat, "frames", frames);
  requireCount(kFormat, "vertices", vertices);
  requireSize(kFormat, bytes.size() - kMddHeader, frames, vertices, 4);
  CacheMotion motion;
  makeRoom(frames, vertices, motion);
  for (std::int32_t i = 0; i < frames; ++i) motion.times.push_back(double(words.number()));
  readPositions(words, scale, motion);
  return motion;
}

}  // namespace leeway::planner
