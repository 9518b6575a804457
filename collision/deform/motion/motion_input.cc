#include "collision/deform/motion/motion_input.h"

#include <charconv>
#include <cmath>

#include "collision/base/tolerances.h"

namespace leeway::collision {

std::string shown(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return std::string(text, end.ptr);
}

void refuse(MotionKind kind, const std::string& what) {
  throw InvalidMotion(std::string(toString(kind)) + ": " + what);
}

void requireIncreasing(MotionKind kind, std::span<const double> times) {
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::string key = "key " + std::to_string(i) + ": time " + shown(times[i]);
    if (!(std::abs(times[i]) <= kLargestMotion))
      refuse(kind, key + "; finite numbers up to " + shown(kLargestMotion) + " are accepted");
    if (i > 0 && !(times[i] > times[i - 1]))
      refuse(kind, key + "; it must be larger than the time before it, " + shown(times[i - 1]));
  }
}

void requireUsable(MotionKind kind, const std::string& what, double value) {
  if (std::abs(value) <= kLargestMotion) return;  // false for a NaN
  refuse(kind, what + ": " + shown(value) + "; finite numbers up to " + shown(kLargestMotion) +
                   " are accepted");
}

void requireUsable(MotionKind kind, const std::string& what,
                   std::span<const Eigen::Vector3d> positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if ((positions[i].array().abs() <= kLargestMotion).all()) continue;
    for (int k = 0; k < 3; ++k)
      requireUsable(kind, what + " " + std::to_string(i), positions[i][k]);
  }
}

void requireCount(MotionKind kind, const std::string& what, std::size_t count, std::size_t wanted,
                  const std::string& things) {
  if (count == wanted) return;
  refuse(kind, what + " has " + std::to_string(count) + " " + things + "; " +
                   std::to_string(wanted) + " are needed");
}

void requireVertices(MotionKind kind, std::size_t count) {
  if (count == 0) refuse(kind, "no vertices; at least 1 is needed");
}

void requireKeys(MotionKind kind, std::span<const double> times) {
  if (times.empty()) refuse(kind, "no keys; at least 1 is needed");
  requireIncreasing(kind, times);
}

Eigen::Vector3d requireDirection(MotionKind kind, const std::string& what,
                                 const Eigen::Vector3d& direction) {
  for (int k = 0; k < 3; ++k) requireUsable(kind, what, direction[k]);
  const double largest = direction.cwiseAbs().maxCoeff();
  if (!(largest > 0)) refuse(kind, what + ": 0 0 0; a vector that is not zero is needed");
  const Eigen::Vector3d scaled = direction / largest;  // squares of tiny numbers would vanish
  return scaled /
         std::sqrt(scaled.x() * scaled.x() + scaled.y() * scaled.y() + scaled.z() * scaled.z());
}

void requireRow(MotionKind kind, std::size_t key, std::span<const double> row, std::size_t wanted,
                const std::string& thing) {
  const std::string name = "key " + std::to_string(key);
  requireCount(kind, name, row.size(), wanted, thing + "s");
  const std::string prefix = name + ", " + thing + " ";
  for (std::size_t k = 0; k < row.size(); ++k)
    requireUsable(kind, prefix + std::to_string(k), row[k]);
}

void requirePhase(MotionKind kind, const std::string& what, double phase) {
  if (std::abs(phase) <= kLargestPhase) return;  // false for a NaN
  refuse(kind, what + ": " + shown(phase) + "; finite numbers up to " + shown(kLargestPhase) +
                   " are accepted");
}

const char* toString(MotionKind kind) {
  switch (kind) {
    case MotionKind::kWaves:
      return "waves";
    case MotionKind::kLattice:
      return "lattice";
    case MotionKind::kMorph:
      return "morph";
    case MotionKind::kSkinned:
      return "skinned";
    case MotionKind::kReduced:
      return "reduced";
    case MotionKind::kCache:
      return "cache";
    case MotionKind::kOwn:
      return "own";
  }
  return "unknown";
}

VertexMotion::VertexMotion(MotionKind kind, int vertex_count, int parameter_count,
                           std::vector<double> key_times)
    : kind_(kind),
      vertex_count_(vertex_count),
      parameter_count_(parameter_count),
      key_times_(std::move(key_times)) {
  if (vertex_count <= 0) {
    throw InvalidMotion(std::string(toString(kind)) + ": " + std::to_string(vertex_count) +
                        " vertices; at least 1 is needed");
  }
  if (parameter_count < 0) {
    throw InvalidMotion(std::string(toString(kind)) + ": " + std::to_string(parameter_count) +
                        " parameters; 0 or more are accepted");
  }
  requireIncreasing(kind, key_times_);
}

std::shared_ptr<const VertexMotion> VertexMotion::withSource(std::shared_ptr<VertexMotion> made,
                                                             MotionSource source) {
  made->source_ = std::make_shared<const MotionSource>(std::move(source));
  return made;
}

void VertexMotion::evaluate(double time, std::span<Eigen::Vector3d> positions) const {
  std::vector<double> numbers(static_cast<std::size_t>(parameter_count_));
  parameters(time, numbers);
  vertices(numbers, 0, positions);
}

}  // namespace leeway::collision
