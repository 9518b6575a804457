#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

struct SimplifyOptions {
  std::uint64_t seed = 1;
  int attempts = 100;  ///< random shortcuts tried at most
  int failures = 30;   ///< in a row: ends earlier
  /// A shortcut must keep this clearance [m] besides the margins: with it a path found for its
  /// clearance loses none.
  double clearance_floor = -std::numeric_limits<double>::infinity();
  double clearance_tolerance = 1e-3;  ///< of clearances compared with the floor [m]
  std::function<bool()> stop;         ///< asked before every edge; true ends with the path so far
};

struct SimplifyResult {
  int attempts = 0, shortcuts = 0;
};

/// Shortens a path in place: leaves vertices out, then cuts between random points of it (Geraerts
/// and Overmars 2007, "Creating high-quality paths for motion planning"), then pulls vertices
/// towards the chord of their neighbours. Every edge of the result that was not an edge before is
/// certified as it stands; the path never gets longer, and its ends never change. Deterministic
/// unless stopped. O(attempts + vertices log vertices) edges. `path`: waypoints of the scene's
/// space.
SimplifyResult simplify(EdgeCertifier& certifier, std::vector<std::vector<double>>& path,
                        const SimplifyOptions& options = {});

/// Sum of the space's distances between waypoints.
double pathLength(const ConfigurationSpace& space, const std::vector<std::vector<double>>& path);

}  // namespace leeway::planner
