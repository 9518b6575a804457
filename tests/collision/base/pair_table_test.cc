#include "collision/base/pair_table.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace leeway::collision {
namespace {

struct Hint {
  int looks = 3;
};

TEST(PairTable, FewPairsKeepTheirValues) {
  for (const std::size_t pairs :
       {std::size_t{1}, std::size_t{7}, std::size_t{1000}, PairTable<Hint>::kMost}) {
    PairTable<Hint> table;
    table.resize(pairs);
    EXPECT_FALSE(table.isShared());
    const auto count = static_cast<std::int32_t>(pairs);
    for (std::int32_t p = 0; p < count; ++p) EXPECT_EQ(table.find(p), nullptr);
    for (std::int32_t p = 0; p < count; ++p) {
      EXPECT_EQ(table.of(p).looks, 3);
      table.of(p).looks = p;
    }
    for (std::int32_t p = 0; p < count; ++p) {
      ASSERT_NE(table.find(p), nullptr);
      ASSERT_EQ(table.find(p)->looks, p);
      ASSERT_EQ(table.of(p).looks, p);
    }
  }
}

TEST(PairTable, OfManyPairsTheLastThatCameKeepsThePlace) {
  const auto most = static_cast<std::int32_t>(PairTable<Hint>::kMost);
  const std::int32_t count = 20 * most;
  int evicted = 0;
  for (std::int32_t other = most; other < count; ++other) {
    PairTable<Hint> table;
    table.resize(static_cast<std::size_t>(count));
    ASSERT_TRUE(table.isShared());
    table.of(5).looks = 50;
    EXPECT_EQ(table.find(other), nullptr);  // find() changes nothing
    ASSERT_EQ(table.find(5)->looks, 50);
    EXPECT_EQ(table.of(other).looks, 3);
    table.of(other).looks = 60;
    if (table.find(5) != nullptr) continue;
    ++evicted;
    EXPECT_EQ(table.find(other)->looks, 60);
    EXPECT_EQ(table.of(5).looks, 3);
    EXPECT_EQ(table.find(other), nullptr);
  }
  EXPECT_GT(evicted, 5);
  EXPECT_LT(evicted, 60);
}

// The pairs of one thing, one in each row, rarely share places, for any length of a row.
TEST(PairTable, PairsOfOneThingKeepTheirPlaces) {
  for (const std::int32_t places : {1000, 4096, 8192, 100'000}) {
    PairTable<Hint> table;
    table.resize(static_cast<std::size_t>(30 * places));
    int kept = 0;
    for (std::int32_t row = 0; row < 30; ++row) table.of(row * places + 7).looks = row;
    for (std::int32_t row = 0; row < 30; ++row) {
      const Hint* const hint = table.find(row * places + 7);
      kept += hint != nullptr && hint->looks == row;
    }
    EXPECT_GE(kept, 28) << places;
  }
}

}  // namespace
}  // namespace leeway::collision
