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
  PairTable<Hint> table;
  const auto most = static_cast<std::int32_t>(PairTable<Hint>::kMost);
  table.resize(static_cast<std::size_t>(3 * most));
  table.of(5).looks = 50;
  table.of(most + 6).looks = 60;
  EXPECT_EQ(table.find(5)->looks, 50);
  EXPECT_EQ(table.find(2 * most + 5), nullptr);  // asking changes nothing
  EXPECT_EQ(table.find(5)->looks, 50);
  EXPECT_EQ(table.of(2 * most + 5).looks, 3);
  EXPECT_EQ(table.find(5), nullptr);
  EXPECT_EQ(table.of(5).looks, 3);
  EXPECT_EQ(table.of(most + 6).looks, 60);
}

}  // namespace
}  // namespace leeway::collision
