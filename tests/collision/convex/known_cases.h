#pragma once

// Pairs, with exact numbers, whose intervals were too wide in long runs.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "leeway/collision/distance.h"
#include "tests/collision/convex/pair_cases.h"
#include "tests/support/build_paths.h"
#include "tests/support/case_file.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision::testing {

struct Known {
  Pair pair;

  double size() const {
    return oracle::sizeOf(pair.a) + oracle::sizeOf(pair.b) +
           (pair.X_WB.translation - pair.X_WA.translation).norm();
  }
};

inline Known known(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return {{a, b, X_WA, X_WB}};
}

/// The pairs of a family of tests/data/depths.txt; a family without a pair fails the test.
inline std::vector<Known> knownDepths(const std::string& family) {
  static const CaseFile file = readCases(leeway::sourceFolder() + "/tests/data/depths.txt");
  std::vector<Known> pairs;
  for (const FileCase& c : file.cases)
    if (c.family == family)
      pairs.push_back(known(file.shapes.at(c.a), c.X_WA, file.shapes.at(c.b), c.X_WB));
  EXPECT_FALSE(pairs.empty()) << family;
  return pairs;
}

inline Pose pose(const double (&R)[9], const Eigen::Vector3d& t) {
  Pose X;
  X.rotation << R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8];
  X.translation = t;
  return X;
}

inline Shape hull(const std::vector<Eigen::Vector3d>& points) { return Shape::convexHull(points); }

/// Number of steps that leaves no pair of these families wider than requested. The default ends
/// within a millisecond, and some pairs need more.
inline constexpr int kThoroughLimit = 36 * DistanceRequest{}.iteration_limit;

/// Expects an interval as narrow as requested that contains the truth, in either order, within
/// `iteration_limit` steps. Returns the answer for the first order.
inline DistanceResult expectNarrow(const Known& known, Scratch& scratch,
                                   int iteration_limit = DistanceRequest{}.iteration_limit) {
  const Pair& pair = known.pair;
  DistanceRequest request;
  request.iteration_limit = iteration_limit;
  const oracle::Truth truth = oracle::signedSeparation(pair.a, pair.X_WA, pair.b, pair.X_WB);
  const DistanceResult there = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch),
                       back = distance(pair.b, pair.X_WB, pair.a, pair.X_WA, request, scratch);
  for (const DistanceResult& r : {there, back}) {
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << pair.replay();
    EXPECT_LE(r.distance.lower, truth.upper) << pair.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << pair.replay();
  }
  return there;
}

}  // namespace leeway::collision::testing
