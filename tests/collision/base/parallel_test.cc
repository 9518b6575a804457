#include "collision/base/parallel.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace leeway::collision {
namespace {

TEST(Parallel, DoesBoth) {
  for (const bool worth : {false, true}) {
    int first = 0, second = 0;
    inParallel(
        worth, [&] { first = 1; }, [&] { second = 2; });
    EXPECT_EQ(first, 1);
    EXPECT_EQ(second, 2);
  }
}

TEST(Parallel, HandsOnWhatIsThrown) {
  for (const bool worth : {false, true}) {
    bool done = false;
    EXPECT_THROW(inParallel(
                     worth, [] { throw std::runtime_error("first"); }, [&] { done = true; }),
                 std::runtime_error);
    EXPECT_THROW(inParallel(
                     worth, [&] { done = true; }, [] { throw std::runtime_error("second"); }),
                 std::runtime_error);
    EXPECT_TRUE(done);
  }
}

}  // namespace
}  // namespace leeway::collision
