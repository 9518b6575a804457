#include "collision/mesh/box_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "tests/support/every_target.h"
#include "tests/support/mesh_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// Against sums in the same order, point by point.
TEST(BoxRanges, AreThoseOfThePointsOnEveryInstructionSet) {
  Random random(53);
  for (const std::size_t count : {1U, 2U, 7U, 40U}) {
    std::array<std::vector<double>, 3> points;
    for (auto& column : points) {
      for (std::size_t i = 0; i < count * kRangeBlock; ++i) column.push_back(random.uniform());
    }
    const std::array<Eigen::Matrix3d, 3> frames = {
        Eigen::Matrix3d::Identity(), random.pose(1).rotation, random.pose(1).rotation};
    expectTheSameBytesOnEveryTarget([&] {
      std::array<BoxRange, 3> ranges;
      boxRanges({points[0], points[1], points[2]}, frames, ranges.data());
      std::vector<double> all;
      for (std::size_t f = 0; f < frames.size(); ++f) {
        for (int k = 0; k < 3; ++k) {
          const Vector3d axis = frames[f].col(k);
          double low = std::numeric_limits<double>::infinity(), high = -low;
          for (std::size_t i = 0; i < points[0].size(); ++i) {
            const double along =
                axis.x() * points[0][i] + axis.y() * points[1][i] + axis.z() * points[2][i];
            low = std::min(low, along);
            high = std::max(high, along);
          }
          EXPECT_EQ(ranges[f].low[k], low);
          EXPECT_EQ(ranges[f].high[k], high);
          all.insert(all.end(), {ranges[f].low[k], ranges[f].high[k]});
        }
      }
      return all;
    });
  }
}

}  // namespace
}  // namespace leeway::collision
