#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

struct SimplifyOptions {
  std::uint64_t seed = 1;
  int attempts = 60;  ///< maximum number of random shortcuts
  int failures = 30;  ///< ends after this number of failures in a row
  /// Least clearance of a new edge [m], in addition to the margins, so that a path that was found
  /// for its clearance keeps it.
  double clearance_floor = -std::numeric_limits<double>::infinity();
  std::function<bool()> stop;  ///< polled every eight edges; true ends with the path so far
};

struct SimplifyResult {
  int attempts = 0, shortcuts = 0;
};

/// Shortens a path (waypoints of the scene's space) in place. It removes vertices, then cuts
/// between random points of the path (Geraerts and Overmars, "Creating high-quality paths for
/// motion planning", 2007), then pulls vertices towards the chord of their neighbours. Every new
/// edge is certified; the path never gets longer, and its ends never change. Deterministic unless
/// stopped. Certifies O(attempts + vertices log vertices) edges. Throws std::invalid_argument for a
/// waypoint of another size.
SimplifyResult simplify(EdgeCertifier& certifier, std::vector<std::vector<double>>& path,
                        const SimplifyOptions& options = {});

/// Sum of the space's distances between waypoints. Throws std::invalid_argument for a waypoint of
/// another size.
double pathLength(const ConfigurationSpace& space, const std::vector<std::vector<double>>& path);

}  // namespace leeway::planner
