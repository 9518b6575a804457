#pragma once

#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner::verification {

/// A thing that the verifier looks at: a link, an attached object or an object of the world.
struct Body {
  std::string name;
  const std::vector<robots::Geometry>* geometries = nullptr;
  int link = -1;          ///< that carries it; -1: the world
  bool attached = false;  ///< carried, and no link itself
  robots::Pose X_LB;      ///< in its link, or in the world
};

/// Two bodies that must keep more than `margin` [m] apart.
struct BodyPair {
  std::size_t a = 0, b = 0;
  double margin = 0;
  std::vector<int> joints_a,
      joints_b;  ///< joints above each that the other does not share, nearest first
};

std::vector<Body> collectBodies(const Problem& problem);

/// All pairs but those that need not be kept: allowed ones (SRDF, problem, held objects and what
/// they may touch), adjacent links, and pairs that no planned joint moves against each other. What
/// others prove never to meet is not believed here: it stays.
std::vector<BodyPair> collectPairs(const Problem& problem, const std::vector<Body>& bodies);

}  // namespace leeway::planner::verification
