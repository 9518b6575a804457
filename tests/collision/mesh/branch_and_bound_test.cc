#include "collision/mesh/descent/branch_and_bound.h"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <vector>

#include "collision/base/work.h"
#include "collision/mesh/descent/descent_bounds.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {
namespace {

struct OpenNumber {
  double lower;
  int number;
  bool is_leaf = false;

  bool isLeaf() const { return is_leaf; }
};
using OpenNumbers = BranchAndBound<OpenNumber, 16>;

/// Takes parts until the search is over; the numbers in their order.
std::vector<int> numbersOf(OpenNumbers& open, DescentBounds& bounds) {
  std::vector<int> numbers;
  for (OpenNumber next{}; open.next(bounds, next);) {
    bounds.visit();
    numbers.push_back(next.number);
  }
  return numbers;
}

TEST(BranchAndBound, TakesTheNearestSiblingFirstAndOfEqualOnesTheLast) {
  Scratch scratch;
  const DistanceRequest request;
  DescentBounds bounds(request, scratch, {});
  OpenNumbers open;
  open.push({0, 1});
  for (const OpenNumber& part : {OpenNumber{3, 2}, {1, 3}, {2, 4}, {1, 5}})
    open.pushSibling(1, part);
  EXPECT_EQ(numbersOf(open, bounds), (std::vector{5, 3, 4, 2, 1}));
  EXPECT_TRUE(open.isEmpty());
  EXPECT_EQ(bounds.result.lower, kInfinity);
}

TEST(BranchAndBound, SettlesWhatItPrunesAndWhatALimitLeaves) {
  Scratch scratch;
  DistanceRequest request;
  request.threshold = 1.5;
  request.node_limit = 1;
  DescentBounds bounds(request, scratch, {});
  OpenNumbers open;
  open.push({0.5, 1});
  open.push({1, 2});
  open.push({1.75, 3});
  open.pushSibling(bounds, open.size(), {1.625, 4});
  EXPECT_EQ(open.size(), 3U);
  EXPECT_EQ(bounds.result.lower, 1.625);
  EXPECT_EQ(numbersOf(open, bounds), std::vector{2});
  EXPECT_FALSE(open.isEmpty());
  EXPECT_EQ(bounds.result.lower, 1.625);
  open.settleRest(bounds);
  EXPECT_EQ(bounds.result.lower, 0.5);
}

TEST(BranchAndBound, TakesSeveralNodesOnceThereIsAnUpperEndAndLeavesAlone) {
  Scratch scratch;
  const DistanceRequest request;
  DescentBounds bounds(request, scratch, {});
  OpenNumbers open;
  for (int i = 0; i < 5; ++i) open.push({1, i, i == 2});
  std::array<OpenNumber, 4> room;
  std::span<const OpenNumber> taken;
  ASSERT_TRUE(open.next(bounds, room, taken));
  EXPECT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0].number, 4);
  ASSERT_TRUE(bounds.offer({}, 2, -1, -1));
  ASSERT_TRUE(open.next(bounds, room, taken));  // the next one is a leaf
  EXPECT_EQ(taken.size(), 1U);
  ASSERT_TRUE(open.next(bounds, room, taken));
  EXPECT_EQ(taken.size(), 1U);
  EXPECT_TRUE(taken[0].isLeaf());
  ASSERT_TRUE(open.next(bounds, room, taken));
  EXPECT_EQ(taken.size(), 2U);
  EXPECT_FALSE(open.next(bounds, room, taken));
  EXPECT_EQ(bounds.result.visited, 5);
}

TEST(BranchAndBound, SelfQueriesStopAtTheLimitOfWork) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<DeformableMesh::Triangle> triangles;
  for (int i = 0; i < 40; ++i) {
    for (const double y : {0.0, 0.1}) vertices.push_back({0.1 * i, y, 0.01 * (i % 3)});
    vertices.push_back({0.1 * i + 0.05, 0, 0});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  Deformable deformable(DeformableMesh::make(vertices, triangles));
  const auto snapshot = deformable.snapshot();
  Scratch scratch;
  prepare(scratch, *snapshot);
  DistanceRequest request;
  const DistanceResult whole = selfDistance(*snapshot, request, scratch);
  EXPECT_GT(whole.distance.lower, 0);
  Work work{1, 0};
  countInto(scratch, work);
  const DistanceResult stopped = selfDistance(*snapshot, request, scratch);
  EXPECT_EQ(stopped.distance.lower, 0);
  EXPECT_EQ(stopped.distance.upper, kInfinity);
  EXPECT_EQ(stopped.status, DistanceStatus::kLimit);
}

}  // namespace
}  // namespace leeway::collision
