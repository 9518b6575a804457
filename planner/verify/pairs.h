#pragma once

#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"

namespace leeway::planner::verification {

/// A link, an attached object or an object of the world.
struct Body {
  std::string name;
  const std::vector<robots::Geometry>* geometries = nullptr;
  const PointCloud* cloud = nullptr;  ///< balls besides the geometries; null without a cloud
  int link = -1;                      ///< the link, or the link that carries it; -1 for the world
  bool attached = false;              ///< an attached object
  robots::Pose X_LB;                  ///< pose in its link, or in the world

  bool hasShape() const { return !geometries->empty() || (cloud != nullptr && cloud->size() > 0); }
};

/// Two bodies that must keep more than `margin` [m] apart.
struct BodyPair {
  std::size_t a = 0, b = 0;
  double margin = 0;
  /// The joints above each body that are not above the other one, nearest first.
  std::vector<int> joints_a, joints_b;
};

std::vector<Body> collectBodies(const Problem& problem);

/// All pairs, sorted by whether they are checked. The verifier derives the reasons of Unchecked on
/// its own. It also checks the pairs that the planner has proven never to touch.
struct Pairs {
  std::vector<BodyPair> checked;
  std::vector<CompiledScene::Dropped> unchecked;  ///< of bodies with shapes
  /// Says why checking `checked` proves nothing; else empty. See CompiledScene::nothingChecked().
  std::string nothing_checked;
};

/// O(bodies^2). Computes distances if links meet at a joint of a robot without an SRDF.
Pairs collectPairs(const Problem& problem, const std::vector<Body>& bodies);

}  // namespace leeway::planner::verification
