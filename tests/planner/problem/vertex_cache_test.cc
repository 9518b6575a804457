#include "planner/problem/vertex_cache.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/cache_bytes.h"

namespace leeway::planner {
namespace {

using cache_bytes::coordinate;
using cache_bytes::mdd;
using cache_bytes::pc2;
using collision::CacheMotion;

std::span<const std::byte> bytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

void expectPositions(const CacheMotion& motion, int frames, int vertices, double scale) {
  ASSERT_EQ(motion.vertex_count, vertices);
  ASSERT_EQ(motion.positions.size(), static_cast<std::size_t>(frames * vertices));
  std::size_t i = 0;
  for (int f = 0; f < frames; ++f) {
    for (int v = 0; v < vertices; ++v, ++i)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(motion.positions[i][k], scale * double(coordinate(f, v, k)));
  }
}

TEST(VertexCache, ReadsPc2) {
  const CacheMotion motion = parsePc2(bytesOf(pc2(3, 4)), 10, 0.001);
  EXPECT_EQ(motion.times, (std::vector<double>{0.2, 0.25, 0.3}));
  expectPositions(motion, 3, 4, 0.001);
  EXPECT_EQ(collision::VertexMotion::cache(motion)->vertexCount(), 4);
}

TEST(VertexCache, ReadsMdd) {
  const CacheMotion motion = parseMdd(bytesOf(mdd(3, 2)));
  EXPECT_EQ(motion.times, (std::vector<double>{0, 0.125, 0.5}));
  expectPositions(motion, 3, 2, 1);
}

template <class Parse>
std::string refusal(Parse parse) {
  try {
    parse();
  } catch (const collision::InvalidMotion& error) {
    return error.what();
  }
  return "accepted";
}
std::string pc2Refusal(const std::string& bytes, double frames_per_second = 24) {
  return refusal([&] { parsePc2(bytesOf(bytes), frames_per_second); });
}
std::string mddRefusal(const std::string& bytes) {
  return refusal([&] { parseMdd(bytesOf(bytes)); });
}

std::string withWord(std::string bytes, std::size_t at, std::int32_t n, bool big_endian) {
  std::string word;
  cache_bytes::put(word, n, big_endian);
  return bytes.replace(at, 4, word);
}

TEST(VertexCache, RefusesBrokenPc2) {
  const std::string good = pc2(2, 3);
  EXPECT_EQ(pc2Refusal(good), "accepted");
  EXPECT_EQ(pc2Refusal(mdd(2, 3)),
            "PC2 cache: does not begin with POINTCACHE2; only PC2 files are accepted here");
  EXPECT_EQ(pc2Refusal(""), "PC2 cache: 0 bytes; its header alone has 32");
  EXPECT_EQ(pc2Refusal(good.substr(0, 31)), "PC2 cache: 31 bytes; its header alone has 32");
  EXPECT_EQ(pc2Refusal(withWord(good, 12, 2, false)), "PC2 cache: version 2; 1 is accepted");
  EXPECT_EQ(pc2Refusal(withWord(good, 16, 0, false)),
            "PC2 cache: 0 vertices; at least 1 is needed");
  EXPECT_EQ(pc2Refusal(withWord(good, 28, -7, false)),
            "PC2 cache: -7 samples; at least 1 is needed");
  EXPECT_EQ(pc2Refusal(good.substr(0, good.size() - 1)),
            "PC2 cache: 71 bytes after the header, too few for 2 frames of 3 vertices, which take "
            "36 each");
  EXPECT_EQ(pc2Refusal(good + "x"),
            "PC2 cache: 73 bytes after the header, too many for 2 frames of 3 vertices, which take "
            "36 each");
  EXPECT_EQ(pc2Refusal(pc2(2, 3, std::numeric_limits<float>::infinity())),
            "PC2 cache: first frame inf; finite numbers are accepted");
  EXPECT_EQ(pc2Refusal(pc2(2, 3, 0, 0)),
            "PC2 cache: a sample every 0 frames; a finite number above 0 is accepted");
  EXPECT_EQ(pc2Refusal(good, 0),
            "PC2 cache: 0 frames per second; a finite number above 0 is accepted");
}

// Counts whose product overflows 64 bits, and huge allocations.
TEST(VertexCache, RefusesAbsurdCounts) {
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(pc2Refusal(withWord(withWord(pc2(2, 3), 16, kMost, false), 28, kMost, false)),
            "PC2 cache: 72 bytes after the header, too few for 2147483647 frames of 2147483647 "
            "vertices, which take 25769803764 each");
  EXPECT_EQ(mddRefusal(withWord(withWord(mdd(2, 3), 0, kMost, true), 4, kMost, true)),
            "MDD cache: 80 bytes after the header, too few for 2147483647 frames of 2147483647 "
            "vertices, which take 25769803768 each");
}

TEST(VertexCache, RefusesBrokenMdd) {
  const std::string good = mdd(2, 3);
  EXPECT_EQ(mddRefusal(good), "accepted");
  EXPECT_EQ(mddRefusal(good.substr(0, 5)), "MDD cache: 5 bytes; its header alone has 8");
  EXPECT_EQ(mddRefusal(withWord(good, 0, -1, true)), "MDD cache: -1 frames; at least 1 is needed");
  EXPECT_EQ(mddRefusal(withWord(good, 4, 4, true)),
            "MDD cache: 80 bytes after the header, too few for 2 frames of 4 vertices, which take "
            "52 each");
  // Read as little-endian, the counts are absurd.
  EXPECT_NE(mddRefusal(withWord(good, 0, 2, false)), "accepted");
  EXPECT_EQ(refusal([&] { parseMdd(bytesOf(good), 0); }),
            "MDD cache: scale 0; a finite number that is not 0 is accepted");
}

}  // namespace
}  // namespace leeway::planner
