#include "collision/lanes/obstacle_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "tests/support/every_target.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Box = ObstacleBoxes::Box;
using oracle::Random;

Box randomBox(Random& random, double world, double size) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    const double middle = random.uniform(-world, world), half = size * random.uniform(0, 1);
    box.low[k] = static_cast<float>(middle - half);
    box.high[k] = static_cast<float>(middle + half);
  }
  return box;
}

bool meet(const Box& a, const Box& b) {
  for (int k = 0; k < 3; ++k)
    if (a.high[k] < b.low[k] || a.low[k] > b.high[k]) return false;
  return true;
}

std::vector<std::int32_t> near(const ObstacleBoxes& boxes, const Box& box) {
  std::vector<std::int32_t> found;
  boxes.forEachNear(box, [&](std::size_t slot) {
    if (boxes.obstacle(slot) >= 0) found.push_back(boxes.obstacle(slot));
    return true;
  });
  std::sort(found.begin(), found.end());
  return found;
}

// The tree against a list, for counts around the widths of its nodes; some boxes are large,
// unbounded or all in one place.
TEST(ObstacleBoxes, FindsWhatAListFinds) {
  Random random(7);
  for (const int count : {0, 1, 15, 16, 17, 64, 65, 256, 257, 1000, 1025, 5000, 70000}) {
    for (const double size : {0.0, 0.1, 1.0}) {
      std::vector<Box> all;
      for (int i = 0; i < count; ++i) {
        all.push_back(randomBox(random, 10, random.chance(0.02) ? 20 : size));
        all.back().is_ball = random.chance(size);
        if (random.chance(0.01)) all.back().high[random.below(3)] = 1e30F;
        if (i > 0 && random.chance(0.3)) all.back() = all[static_cast<std::size_t>(i - 1)];
      }
      const ObstacleBoxes boxes(all);
      ASSERT_EQ(boxes.slots() % ObstacleBoxes::kWidth, 0U);
      // The same holds if some boxes are added later.
      const std::size_t first = all.size() / 3;
      const ObstacleBoxes both(
          std::span<const Box>(all).subspan(first),
          std::make_shared<const ObstacleBoxes>(std::span<const Box>(all).first(first)),
          static_cast<std::int32_t>(first));
      for (int k = 0; k < 20; ++k) {
        const Box box = randomBox(random, 12, random.chance(0.2) ? 10 : 1);
        std::vector<std::int32_t> expected;
        for (int i = 0; i < count; ++i)
          if (meet(box, all[static_cast<std::size_t>(i)])) expected.push_back(i);
        EXPECT_EQ(near(boxes, box), expected) << count << " " << size;
        EXPECT_EQ(near(both, box), expected) << count << " " << size;
      }
    }
  }
}

/// Slow twin of forEachNear(): one box after the other.
void visitSlowly(const ObstacleBoxes& boxes, std::size_t level, std::size_t begin, const Box& box,
                 std::size_t first_slot, std::vector<std::size_t>& visited) {
  const ObstacleBoxes::Level& of = boxes.levels()[level];
  const bool is_top = level + 1 == boxes.levels().size();
  const std::size_t end = is_top ? of.size() : std::min(begin + ObstacleBoxes::kWidth, of.size());
  for (std::size_t i = begin; i < end; ++i) {
    bool apart = false;
    for (int k = 0; k < 3; ++k) apart |= box.high[k] < of.low[k][i] || box.low[k] > of.high[k][i];
    if (apart) continue;
    if (level == 0)
      visited.push_back(first_slot + i);
    else
      visitSlowly(boxes, level - 1, ObstacleBoxes::kWidth * i, box, first_slot, visited);
  }
}

// The same visits in the same order on every instruction set, padding that NaN meets included.
TEST(ObstacleBoxes, VisitsInTheOrderOfALoop) {
  Random random(10);
  std::size_t visits = 0;
  for (const int count : {1, 16, 50, 64, 65, 300, 1025, 9000}) {
    std::vector<Box> all;
    for (int i = 0; i < count; ++i) all.push_back(randomBox(random, 10, 1));
    const std::size_t first = all.size() / 3;
    const auto before =
        std::make_shared<const ObstacleBoxes>(std::span<const Box>(all).first(first));
    const ObstacleBoxes boxes(std::span<const Box>(all).subspan(first), before,
                              static_cast<std::int32_t>(first));
    for (int q = 0; q < 50; ++q) {
      Box box = randomBox(random, 12, random.chance(0.2) ? 10 : 1);
      if (random.chance(0.2)) {
        // A face on a face: touching boxes intersect.
        const Box& other = all[static_cast<std::size_t>(random.below(count))];
        std::copy_n(other.high, 3, box.low);
        for (int k = 0; k < 3; ++k) box.high[k] = std::max(box.high[k], box.low[k]);
      }
      if (random.chance(0.1)) box.low[random.below(3)] = std::numeric_limits<float>::quiet_NaN();
      if (random.chance(0.1)) box.high[random.below(3)] = std::numeric_limits<float>::quiet_NaN();
      if (random.chance(0.1)) box.high[random.below(3)] = kFar;
      std::vector<std::size_t> expected;
      if (first > 0) visitSlowly(*before, before->levels().size() - 1, 0, box, 0, expected);
      visitSlowly(boxes, boxes.levels().size() - 1, 0, box, before->slots(), expected);
      visits += expected.size();
      onEveryTarget([&](const char* target) {
        std::vector<std::size_t> visited;
        const auto take = [&](std::size_t most) {
          visited.clear();
          boxes.forEachNear(box, [&](std::size_t slot) {
            visited.push_back(slot);
            return visited.size() < most;
          });
        };
        take(boxes.slots() + 1);
        EXPECT_EQ(visited, expected) << target << " " << count << " " << q;
        if (expected.empty()) return;
        take(expected.size() / 2 + 1);
        EXPECT_TRUE(visited.size() == expected.size() / 2 + 1 &&
                    std::equal(visited.begin(), visited.end(), expected.begin()))
            << target << " " << count << " " << q;
      });
    }
  }
  EXPECT_GT(visits, 10000U);
}

TEST(ObstacleBoxes, NodesOfBallsAloneHaveNoOthers) {
  Random random(6);
  const auto nodesOfBalls = [&](int count) {
    std::vector<Box> all;
    for (int i = 0; i < count; ++i) {
      all.push_back(randomBox(random, 10, 0.1));
      all.back().is_ball = i % 50 != 0;
    }
    const ObstacleBoxes boxes(all);
    int alone = 0;
    for (std::size_t node = 0; node < boxes.slots() / ObstacleBoxes::kWidth; ++node) {
      bool has_others = false;
      for (std::size_t i = 0; i < ObstacleBoxes::kWidth; ++i) {
        const std::int32_t box = boxes.obstacle(ObstacleBoxes::kWidth * node + i);
        has_others = has_others || (box >= 0 && !all[static_cast<std::size_t>(box)].is_ball);
      }
      EXPECT_EQ(boxes.hasBallsAlone(node), !has_others);
      alone += has_others ? 0 : 1;
    }
    return alone;
  };
  // A few balls are among the other boxes, many come after them: 20 of 1000 fill two nodes.
  EXPECT_GT(nodesOfBalls(250), 5);
  EXPECT_EQ(nodesOfBalls(1000), 61);
}

TEST(ObstacleBoxes, NanMeetsEverything) {
  Random random(8);
  std::vector<Box> all;
  for (int i = 0; i < 300; ++i) all.push_back(randomBox(random, 10, 0.1));
  Box nan;
  std::fill_n(nan.low, 3, std::numeric_limits<float>::quiet_NaN());
  std::fill_n(nan.high, 3, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(near(ObstacleBoxes(all), nan).size(), all.size());
}

// A few boxes are one list, and a level has a sixteenth of the one below.
TEST(ObstacleBoxes, LevelsAreAsFewAsCanBe) {
  Random random(9);
  const auto levels = [&](int count) {
    std::vector<Box> all;
    for (int i = 0; i < count; ++i) all.push_back(randomBox(random, 10, 0.1));
    return ObstacleBoxes(all).levels().size();
  };
  EXPECT_EQ(levels(64), 1U);
  EXPECT_EQ(levels(65), 2U);
  EXPECT_EQ(levels(1024), 2U);
  EXPECT_EQ(levels(1025), 3U);
}

}  // namespace
}  // namespace leeway::collision
