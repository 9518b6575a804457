// Tasks of an edge: added, joined, and halved by a rule.
#include "planner/edge/edge_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <vector>

#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

class EdgeQueueTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::vector<double> a = {-1, 0, 0}, b = {1, 0, 0};
    ASSERT_TRUE(frames.begin(a, b));
  }
  EdgeFrames frames{
      std::make_shared<const CompiledScene>(test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0})),
      256};
  EdgeQueue queue{frames, 64};
};

using Task = std::tuple<int, double, double>;  // pair, from, width

std::vector<Task> tasksOf(EdgeQueue& queue) {
  std::vector<Task> tasks;
  for (const EdgeInterval& interval : queue.intervals())
    for (const int pair : queue.pairs(interval)) tasks.emplace_back(pair, interval.t0, interval.h);
  return tasks;
}

TEST_F(EdgeQueueTest, GroupsTasksByInterval) {
  EXPECT_TRUE(queue.empty());
  for (const int pair : {3, 1}) EXPECT_TRUE(queue.add(pair, 0.25, 0.25));
  EXPECT_TRUE(queue.add(3, 0.5, 0.5));
  ASSERT_EQ(queue.intervals().size(), 2U);
  EXPECT_EQ(tasksOf(queue), (std::vector<Task>{{3, 0.25, 0.25}, {1, 0.25, 0.25}, {3, 0.5, 0.5}}));
  EXPECT_EQ(queue.intervals()[0].slot1, queue.intervals()[1].slot0);  // t = 1/2, placed once
}

TEST_F(EdgeQueueTest, SumsTheWidthsOfAPair) {
  EXPECT_EQ(queue.widthOf(3), 0);
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(queue.add(3, i / 16.0, 1 / 16.0));
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(i == 9 || queue.add(1, i / 16.0, 1 / 16.0));
  EXPECT_EQ(queue.widthOf(3), 1);
  EXPECT_EQ(queue.widthOf(1), 15 / 16.0);
  EXPECT_TRUE(queue.join([](int, double) { return true; }));
  EXPECT_EQ(queue.widthOf(3), 1);
  EXPECT_EQ(queue.widthOf(1), 15 / 16.0);
}

TEST_F(EdgeQueueTest, RefusesMoreThanItHasRoomFor) {
  for (int pair = 0; pair < 64; ++pair) ASSERT_TRUE(queue.add(pair, 0, 1));
  EXPECT_FALSE(queue.add(64, 0, 1));
  EXPECT_EQ(queue.pairs().size(), 64U);
}

TEST_F(EdgeQueueTest, JoinsNeighboursOfAPairAsFarAsAllowed) {
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.add(7, i / 8.0, 1 / 8.0));
  EXPECT_TRUE(queue.add(8, 0, 0.25));
  EXPECT_TRUE(queue.add(8, 0.5, 0.25));  // no neighbour
  EXPECT_TRUE(queue.join([](int, double width) { return width <= 0.25; }));
  EXPECT_EQ(tasksOf(queue),
            (std::vector<Task>{{7, 0, 0.25}, {8, 0, 0.25}, {7, 0.25, 0.25}, {8, 0.5, 0.25}}));
}

/// Settles a task if its interval is at most the pair's number of 1/64 wide.
struct WidthRule {
  EdgeQueue& queue;
  double stop_at = 2;  ///< ends the loop in an interval that begins here
  std::vector<Task> settled = {};
  std::vector<double> begins = {};

  bool sweep(EdgeInterval& interval) {
    begins.push_back(interval.t0);
    if (interval.t0 >= stop_at) return false;
    queue.keep(interval, [&](int pair) {
      const bool is_open = interval.h * 64 > pair;
      if (!is_open) settled.emplace_back(pair, interval.t0, interval.h);
      return is_open;
    });
    return true;
  }
  bool look(EdgeInterval& interval, int slot) { return slot >= 0 && queue.hasRoom(interval); }
};

// Every task is settled once over its whole interval, in either order.
TEST_F(EdgeQueueTest, HalvesUntilNothingIsLeft) {
  for (const EdgeQueue::Order order : {EdgeQueue::Order::kByLevel, EdgeQueue::Order::kFromLeft}) {
    frames.release(0);
    queue.clear();
    for (const int pair : {8, 32, 64}) ASSERT_TRUE(queue.add(pair, 0, 1));
    WidthRule rule{queue};
    queue.subdivide(order, rule);
    for (const int pair : {8, 32, 64}) {
      double covered = 0;
      for (const auto& [p, from, width] : rule.settled) {
        if (p != pair) continue;
        EXPECT_EQ(width * 64, pair);
        covered += width;
      }
      EXPECT_EQ(covered, 1) << pair;
    }
    std::vector<Task> unique = rule.settled;
    std::sort(unique.begin(), unique.end());
    EXPECT_EQ(std::unique(unique.begin(), unique.end()), unique.end());
    EXPECT_EQ(std::is_sorted(rule.begins.begin(), rule.begins.end()),
              order == EdgeQueue::Order::kFromLeft);
    EXPECT_EQ(rule.begins.size(), 15U);  // 1 + 2 + 4 + 8
  }
}

TEST_F(EdgeQueueTest, EndsWhereTheRuleDoes) {
  ASSERT_TRUE(queue.add(8, 0, 1));
  WidthRule rule{queue, 0.5};
  queue.subdivide(EdgeQueue::Order::kFromLeft, rule);
  EXPECT_EQ(rule.begins.back(), 0.5);
  EXPECT_EQ(rule.settled.size(), 4U);  // of [0, 1/2]
}

}  // namespace
}  // namespace leeway::planner
