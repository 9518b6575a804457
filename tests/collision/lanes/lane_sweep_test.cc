#include "collision/lanes/lane_sweep.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "collision/base/rounding.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "leeway/collision/convex_hull.h"
#include "tests/support/every_target.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

// Three adjacent operations, which a compiler vectorises.
void round(Vector3d& v) {
  for (int k = 0; k < 3; ++k) v[k] = roundedToSingle(v[k]);
}

TEST(LaneSweep, NumbersAreRoundedToSingles) {
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const Vector3d given = i == 0 ? Vector3d(0.1, 0.2, 0.3)
                                  : Vector3d(random.logUniform(1e-30, 1e30) * random.direction());
    Vector3d rounded = given;
    round(rounded);
    for (int k = 0; k < 3; ++k) {
      volatile float nearest = static_cast<float>(given[k]);  // not vectorised
      ASSERT_EQ(rounded[k], static_cast<double>(nearest));
    }
  }
}

// A plane's normal is in single precision; its offset belongs to the normal as rounded. Regression:
// g++ 12 used two of three components unrounded, and vertices lay up to 3e-8 of their size beyond.
TEST(LaneSweep, NothingIsBeyondAPlane) {
  Random random(4);
  int planes = 0;
  for (int run = 0; run < 1000; ++run) {
    LaneSweepKernel::Sweep sweep;
    std::vector<Vector3d> points[2];
    std::vector<LaneFrame> frames(2);
    for (std::size_t i = 0; i < 2; ++i) {
      for (int k = 0; k < 6; ++k)
        points[i].push_back(random.direction() + (i == 0 ? 3.0 : 0.0) * Vector3d(1, 1, 1));
      LaneSweepKernel::Sweep::LanePiece piece{};
      piece.frame = static_cast<int>(i);
      piece.view = piece.fine_view = viewOfPoints(points[i].data(), 6, 0);
      sweep.pieces.push_back(piece);
      for (LaneValues& v : frames[i].origin) std::fill_n(v.at, kLanes, 0.0F);
      for (std::size_t k = 0; k < 9; ++k)
        std::fill_n(frames[i].rotation[k].at, kLanes, k % 4 == 0 ? 1.0F : 0.0F);
    }
    collision::Scratch queries;
    Work work;
    LaneSweepKernel::Scratch scratch(queries, work);
    const LaneSweepKernel kernel{sweep, scratch, frames.data(), nullptr, 0};
    LaneSweepKernel::Sweep::Pair pair{};
    pair.a = 0;
    pair.b = 1;
    pair.pieces = true;
    LaneSweepKernel::Scratch::Plane plane;
    if (!kernel.findPlane(pair, 0, true, plane)) continue;
    ++planes;
    const Vector3d n(static_cast<double>(plane.normal[0]), static_cast<double>(plane.normal[1]),
                     static_cast<double>(plane.normal[2]));
    for (const Vector3d& p : points[1])
      ASSERT_LE(n.dot(p), static_cast<double>(plane.offset) + 1e-15) << "run " << run;
  }
  EXPECT_GT(planes, 900);
}

/// A hull turns past a box, points clustered or not.
struct Passing {
  LaneSweep sweep;
  Scratch queries;
  Work work;
  std::unique_ptr<LaneSweep::Scratch> scratch;

  Passing(const PointCover& points, const Shape& box, const Pose& X_WB)
      : Passing(LaneSweep(), pieceOf(points), box, X_WB) {}
  /// From a sweep that may already have pieces and obstacles.
  Passing(LaneSweep begun, const LaneSweep::Piece& piece, const Shape& box, const Pose& X_WB)
      : sweep(std::move(begun)) {
    const int added = sweep.addPiece(piece);
    finish(added, box, X_WB);
  }
  /// Copies a sweep that has the piece.
  Passing(const LaneSweep& begun, int piece, const Shape& box, const Pose& X_WB) : sweep(begun) {
    finish(piece, box, X_WB);
  }

  static LaneSweep::Piece pieceOf(const PointCover& points) {
    LaneSweep::Piece piece;
    piece.frame = piece.motion = 0;
    piece.outer = piece.cover.emplace_back(Ball{Vector3d::Zero(), 1.1});
    piece.points = points;
    piece.reach = 3;
    return piece;
  }
  void finish(int piece, const Shape& box, const Pose& X_WB) {
    sweep.addPair(piece, sweep.addObstacle(box, X_WB), -1, 0.0);
    sweep.finish();
    scratch = std::make_unique<LaneSweep::Scratch>(sweep, queries, work);
  }

  /// Intervals still open after a run and a plane search, and whether the hulls are apart.
  std::pair<std::uint32_t, bool> open(const std::vector<LaneFrame>& frames, float growth) {
    const float values[kLanes] = {growth};
    if (sweep.run(frames, values, 1e-6F, *scratch, {}).id >= 0 ||
        sweep.separate(frames, values, 1e-6F, *scratch).id >= 0)
      return {0, false};
    if (scratch->open().empty()) return {0, true};
    return {scratch->open().front().intervals, scratch->open().front().apart};
  }
};

TEST(LaneSweep, ClustersLeaveOutNothingThatCounts) {
  Random random(5);
  const int runs = casesToAsk(300);
  int clustered = 0, parted = 0, some = 0;
  for (int run = 0; run < runs; ++run) {
    std::vector<Vector3d> vertices;
    for (int k = 0; k < 150; ++k)
      vertices.push_back(random.direction().cwiseProduct(Vector3d(0.9, 0.6, 0.2)));
    PointCover points = coverWithPoints(Shape::convexHull(ConvexHull::compute(vertices)), 24);
    clustered += points.clusters.size() > 4;
    ASSERT_EQ(points.nearest.size(), points.points.size());
    ASSERT_EQ(points.clusters.back(), static_cast<int>(points.fine.size()));
    Pose X_WB;
    X_WB.rotation = Eigen::AngleAxisd(random.uniform(0.0, 3.0), random.direction()).matrix();
    X_WB.translation = random.uniform(0.3, 1.3) * random.direction();
    const Shape box = Shape::box({0.2, 0.1, 0.3});
    Passing clusters(points, box, X_WB);
    // A copy of a sweep that has the piece, and one to which it is added after another.
    LaneSweep begun;
    const int piece = begun.addPiece(Passing::pieceOf(points));
    begun.finishPieces();
    Passing copied(begun, piece, box, X_WB);
    Passing second(LaneSweep(begun), Passing::pieceOf(points), box, X_WB);
    points.clusters.clear();
    points.nearest.clear();
    Passing all(points, box, X_WB);
    // Several edges in a row: planes and directions are cached.
    for (int edge = 0; edge < 4; ++edge) {
      FrameStep step;
      const Eigen::Matrix3d R =
          Eigen::AngleAxisd(random.uniform(0.0, 3.0), random.direction()).matrix();
      for (int i = 0; i < 9; ++i) step.rotation[i] = static_cast<float>(R.data()[i]);
      step.angle = static_cast<float>(random.uniform(-3.0, 3.0));
      step.turn = static_cast<float>(random.uniform(-1.5, 1.5));
      for (float& slide : step.slide) slide = static_cast<float>(random.uniform(-0.1, 0.1));
      LaneValues middles;
      for (int i = 0; i < kLanes; ++i)
        middles.at[i] = (static_cast<float>(i) + 0.5F) / kLanes - 0.5F;
      std::vector<LaneFrame> frames(1);
      placeFrames({&step, 1}, middles, frames);
      moveFrames({&step, 1}, middles, 1.0F / kLanes, frames);
      const auto found = clusters.open(frames, 0.02F);
      ASSERT_EQ(found, all.open(frames, 0.02F)) << "run " << run << ", edge " << edge;
      ASSERT_EQ(found, copied.open(frames, 0.02F)) << "run " << run << ", edge " << edge;
      ASSERT_EQ(found, second.open(frames, 0.02F)) << "run " << run << ", edge " << edge;
      parted += found.first == 0 && found.second;
      some += found.first != 0;
    }
  }
  EXPECT_EQ(clustered, runs);
  EXPECT_GT(parted, runs * 2 / 3);
  EXPECT_GT(some, runs / 5);
}

// A NaN frame is apart from nothing, whatever an instruction set returns for min(NaN, x), and
// regardless of cached runs.
TEST(LaneSweep, LanesThatAreNoNumbersStayOpen) {
  Random random(6);
  std::vector<Vector3d> vertices;
  for (int k = 0; k < 150; ++k)
    vertices.push_back(random.direction().cwiseProduct(Vector3d(0.9, 0.6, 0.2)));
  PointCover points = coverWithPoints(Shape::convexHull(ConvexHull::compute(vertices)), 24);
  ASSERT_GT(points.clusters.size(), 4U);
  FrameStep step;
  step.turn = 0.3F;
  step.slide[0] = 0.05F;
  LaneValues middles;
  for (int i = 0; i < kLanes; ++i) middles.at[i] = (static_cast<float>(i) + 0.5F) / kLanes - 0.5F;
  std::vector<LaneFrame> frames(1);
  placeFrames({&step, 1}, middles, frames);
  moveFrames({&step, 1}, middles, 1.0F / kLanes, frames);
  const auto looked = [&] {
    // Near and far; clustered points or not.
    for (const double distance : {0.65, 0.8, 5.0}) {
      for (const bool clusters : {true, false}) {
        PointCover given = points;
        if (!clusters) {
          given.clusters.clear();
          given.nearest.clear();
        }
        Pose X_WB;
        X_WB.rotation = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).matrix();
        X_WB.translation = distance * Vector3d::UnitZ();
        Passing passing(given, Shape::box({0.2, 0.1, 0.3}), X_WB);
        ASSERT_EQ(passing.open(frames, 0.001F), std::pair(std::uint32_t{0}, true)) << distance;
        // One number at a time, then all of rotation, origin, turn or slide. Far away only one axis
        // separates.
        for (std::size_t which = distance < 1 ? 0 : 18; which < 22; ++which) {
          std::vector<LaneFrame> others = frames;
          const auto lane = static_cast<std::size_t>(random.below(kLanes));
          for (std::size_t i = 0; i < 18; ++i) {
            const std::size_t group = i < 9 ? 18 : i < 12 ? 19 : i < 15 ? 20 : 21;
            LaneValues* const values[] = {others[0].rotation, others[0].origin, others[0].turn,
                                          others[0].slide};
            const std::size_t firsts[] = {0, 9, 12, 15};
            if (which == i || which == group)
              values[group - 18][i - firsts[group - 18]].at[lane] =
                  std::numeric_limits<float>::quiet_NaN();
          }
          ASSERT_EQ(passing.open(others, 0.001F).first, 1U << lane)
              << distance << " m, " << which << ", lane " << lane;
        }
      }
    }
  };
  onEveryTarget([&](const char* target) {
    SCOPED_TRACE(target);
    looked();
  });
}

}  // namespace
}  // namespace leeway::collision
