#include "leeway/collision/vertex_motion.h"

#include <cmath>
#include <string>

#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {

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

void VertexMotion::evaluate(double time, std::span<Eigen::Vector3d> positions) const {
  std::vector<double> numbers(static_cast<std::size_t>(parameter_count_));
  parameters(time, numbers);
  vertices(numbers, 0, positions);
}

}  // namespace leeway::collision
