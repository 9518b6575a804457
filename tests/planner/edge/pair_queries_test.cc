// Exact queries of one pair, compared with distances at many configurations.
#include "planner/edge/pair_queries.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"
#include "planner/base/random.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// The slow twin: the result of distance() for the configuration at t.
Interval distanceAt(EdgeFrames& frames, const EdgePair& pair, double t) {
  const int slot = frames.place(t);
  EXPECT_GE(slot, 0);
  return collision::distance(frames.piece(pair.a).shape(), frames.piecePose(slot, pair.a),
                             frames.piece(pair.b).shape(), frames.piecePose(slot, pair.b),
                             collision::DistanceRequest())
      .distance;
}

TEST(PairQueries, AnswersHoldAtEveryConfiguration) {
  Problem problem = test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0});
  Random random(47);
  for (int i = 0; i < 6; ++i)
    problem.world.objects.push_back(test::box("post " + std::to_string(i), {0.1, 0.2, 0.5},
                                              random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2),
                                              0));
  problem.margins.common = 0.01;
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeFrames frames(scene, 1024);
  collision::Workspace workspace(scene->scene());
  const collision::Work work;
  Asked asked;
  EdgeMemory memory;
  memory.resize(frames.pairs().numbers());
  PairQueries queries(frames, workspace, work, asked, memory);
  EdgeCertifier::Statistics statistics;
  queries.statistics = &statistics;

  int free = 0, contacts = 0, open = 0, more = 0;
  for (int k = 0; k < 2000; ++k) {
    std::vector<double> a(3), b(3);
    for (std::vector<double>* q : {&a, &b})
      *q = {random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-3, 3)};
    ASSERT_TRUE(frames.begin(a, b));
    asked.separation = k % 4 == 0 ? 0.1 : -kInfinity;
    asked.beyond = k % 3 == 0 ? 0.05 : 0;
    const double h = 1.0 / (1 << k % 5), t0 = h * (k % (1 << k % 5));
    const EdgeInterval interval{frames.place(t0), frames.place(t0 + h), t0, h, 0, 0, 0};
    queries.startInterval();
    for (std::size_t p = 0; p < frames.pairs().numbers(); ++p) {
      const EdgePair pair = frames.pair(static_cast<int>(p));
      // Its margin: relative poses are exact to within the rounding that the threshold includes.
      const double least = asked.thresholdOf(pair) - pair.rounding;
      double t = -1;
      const PairState state = queries.sweep(interval, static_cast<int>(p), t);
      if (state == PairState::kFree) {
        ++free;
        more += asked.separation > 0 || asked.beyond > 0;
        for (int i = 0; i <= 16; ++i)
          EXPECT_GT(distanceAt(frames, pair, t0 + h * i / 16).upper, least) << k << " " << p;
      } else if (state == PairState::kNotFree) {
        ++contacts;
        EXPECT_GE(t, t0);
        EXPECT_LE(t, t0 + h);
        EXPECT_LE(distanceAt(frames, pair, t).lower, asked.thresholdOf(pair)) << k << " " << p;
      } else {
        ++open;
      }
      frames.release(2);
    }
  }
  EXPECT_GT(free, 1000);
  EXPECT_GT(more, 200);
  EXPECT_GT(contacts, 20);
  EXPECT_GT(open, 20);
}

}  // namespace
}  // namespace leeway::planner
