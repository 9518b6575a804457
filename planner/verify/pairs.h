#pragma once

#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner::verification {

/// A link, an attached object or an object of the world.
struct Body {
  std::string name;
  const std::vector<robots::Geometry>* geometries = nullptr;
  int link = -1;          ///< carries it, or is it; -1: the world
  bool attached = false;  ///< an attached object
  robots::Pose X_LB;      ///< in its link, or in the world
};

/// Two bodies that must keep more than `margin` [m] apart.
struct BodyPair {
  std::size_t a = 0, b = 0;
  double margin = 0;
  /// Joints above each that the other does not share, nearest first.
  std::vector<int> joints_a, joints_b;
};

std::vector<Body> collectBodies(const Problem& problem);

/// All pairs but allowed ones (SRDF, problem, held objects and what they may touch), adjacent
/// links, and pairs that no planned joint moves against each other. Pairs that the planner drops by
/// a proof stay: the verifier trusts none. O(bodies^2).
std::vector<BodyPair> collectPairs(const Problem& problem, const std::vector<Body>& bodies);

}  // namespace leeway::planner::verification
