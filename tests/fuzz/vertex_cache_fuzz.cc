// Any bytes as a vertex cache of each format: a motion or an InvalidMotion; a motion has the
// positions that it states, and meets its samples at its key times.

#include <cmath>
#include <cstring>

#include "leeway/collision/vertex_motion.h"
#include "planner/problem/vertex_cache.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/support/cache_bytes.h"

namespace {

using namespace leeway;

void check(const char* format, collision::CacheMotion cache) {
  const auto vertices = static_cast<std::size_t>(cache.vertex_count);
  if (cache.positions.size() != cache.times.size() * vertices)
    fuzz::fail("%s: %zu positions", format, cache.positions.size());
  const std::vector<Eigen::Vector3d> given = cache.positions;
  const auto motion = collision::VertexMotion::cache(std::move(cache));
  std::vector<Eigen::Vector3d> positions(vertices);
  for (std::size_t f = 0; f < motion->keyTimes().size(); ++f) {
    motion->evaluate(motion->keyTimes()[f], positions);
    for (std::size_t v = 0; v < vertices; ++v) {
      if (positions[v] != given[f * vertices + v])
        fuzz::fail("%s: frame %zu is not met", format, f);
    }
  }
  const double first = motion->keyTimes().front(), last = motion->keyTimes().back();
  if (!(motion->speedBound(first, last) >= 0)) fuzz::fail("%s: no speed bound", format);
}

}  // namespace

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  return {cache_bytes::pc2(3, 4), cache_bytes::pc2(1, 1), cache_bytes::mdd(3, 4),
          cache_bytes::mdd(1, 1)};
}

std::vector<std::string> dictionary() {
  const auto word = [](const char* bytes) { return std::string(bytes, 4); };
  return {std::string("POINTCACHE2\0", 12),
          word("\0\0\0\1"),
          word("\1\0\0\0"),
          word("\0\0\0\0"),
          word("\x7f\xff\xff\xff"),
          word("\xff\xff\xff\x7f"),
          word("\0\0\xc0\x7f"),
          word("\x7f\x80\0\0"),
          word("\0\0\0\x80")};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  for (const bool pc2 : {true, false}) {
    try {
      check(pc2 ? "PC2" : "MDD",
            pc2 ? planner::parsePc2(bytes, 24) : planner::parseMdd(bytes, 0.01));
    } catch (const collision::InvalidMotion& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
  return 0;
}
