#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/vertex_motion.h"

// What the factories of VertexMotion refuse. Every function throws InvalidMotion with the kind, the
// place, the value and what would be accepted.

namespace leeway::collision {

/// A number as messages show it: the shortest that reads back as the same.
std::string shown(double value);

/// "morph: key 3: <what>".
[[noreturn]] void refuse(MotionKind kind, const std::string& what);

/// Finite, each larger than the one before.
void requireIncreasing(MotionKind kind, std::span<const double> times);
/// Finite, at most kLargestMotion in magnitude. `what` names it: "reference 2, vertex 17".
void requireUsable(MotionKind kind, const std::string& what, double value);
/// The same for every vertex of `positions`, which `what` names as a whole.
void requireUsable(MotionKind kind, const std::string& what,
                   std::span<const Eigen::Vector3d> positions);
/// `count` is `wanted` of `things`.
void requireCount(MotionKind kind, const std::string& what, std::size_t count, std::size_t wanted,
                  const std::string& things);
/// At least one vertex.
void requireVertices(MotionKind kind, std::size_t count);
/// At least one key; times as requireIncreasing().
void requireKeys(MotionKind kind, std::span<const double> times);
/// Usable, not zero: the unit vector.
Eigen::Vector3d requireDirection(MotionKind kind, const std::string& what,
                                 const Eigen::Vector3d& direction);

template <class Keys>
std::vector<double> timesOf(const Keys& keys) {
  std::vector<double> times;
  times.reserve(keys.size());
  for (const auto& key : keys) times.push_back(key.time);
  return times;
}

inline double squaredLength(const Eigen::Vector3d& v) {
  return v.x() * v.x() + v.y() * v.y() + v.z() * v.z();
}

/// The largest magnitude of a coordinate.
inline double largestCoordinate(std::span<const Eigen::Vector3d> points) {
  double largest = 0;
  for (const Eigen::Vector3d& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

}  // namespace leeway::collision
