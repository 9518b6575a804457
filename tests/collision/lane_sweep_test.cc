#include "leeway/collision/lane_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "collision/lane_sweep_impl.h"
#include "collision/round_box.h"
#include "tools/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

// Three side by side, of which a compiler makes vectors.
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
      volatile float nearest = static_cast<float>(given[k]);  // of which no vector is made
      ASSERT_EQ(rounded[k], static_cast<double>(nearest));
    }
  }
}

// A plane's normal is one of singles, and its offset that of the normal as it is rounded. In code
// of g++ 12, which took two of three numbers as they were, vertices were up to 3e-8 of their size
// beyond.
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
    LaneSweepKernel::Scratch scratch;
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

}  // namespace
}  // namespace leeway::collision
