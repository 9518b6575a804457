#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/vertex_motion.h"

// Private to collision/: the input checks of VertexMotion's factories. Every function throws
// InvalidMotion with the kind of motion, the place, the value and the accepted values.

namespace leeway::collision {

/// A number as text in messages: the shortest text that reads back as the same number.
std::string shown(double value);

/// Throws with the message "<kind>: <what>".
[[noreturn]] void refuse(MotionKind kind, const std::string& what);

/// Times must be finite, each larger than the one before.
void requireIncreasing(MotionKind kind, std::span<const double> times);
/// A number must be finite and at most kLargestMotion in magnitude. `what` names it, for example
/// "reference 2, vertex 17".
void requireUsable(MotionKind kind, const std::string& what, double value);
/// Every coordinate of `positions` must be usable. `what` names all of them, for example "reference
/// 2, vertex".
void requireUsable(MotionKind kind, const std::string& what,
                   std::span<const Eigen::Vector3d> positions);
/// The count of `things` must be `wanted`.
void requireCount(MotionKind kind, const std::string& what, std::size_t count, std::size_t wanted,
                  const std::string& things);
/// There must be at least one vertex.
void requireVertices(MotionKind kind, std::size_t count);
/// There must be at least one key; times as in requireIncreasing().
void requireKeys(MotionKind kind, std::span<const double> times);
/// A direction must be usable and not zero. Returns its unit vector.
Eigen::Vector3d requireDirection(MotionKind kind, const std::string& what,
                                 const Eigen::Vector3d& direction);
/// A key must have `wanted` numbers, each usable. `thing` names one, for example "weight".
void requireRow(MotionKind kind, std::size_t key, std::span<const double> row, std::size_t wanted,
                const std::string& thing);
/// A phase must be finite and at most kLargestPhase in magnitude [rad].
void requirePhase(MotionKind kind, const std::string& what, double phase);

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

/// The largest magnitude of a coordinate; 0 if there are no points.
inline double largestCoordinate(std::span<const Eigen::Vector3d> points) {
  double largest = 0;
  for (const Eigen::Vector3d& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

}  // namespace leeway::collision
