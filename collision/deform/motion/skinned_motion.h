#pragma once

#include <cstdint>
#include <vector>

#include "collision/deform/motion/bone_chain.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// Linear blend skinning. The parameters are the skinning matrices (bone_chain.h).
class SkinnedVertices final : public VertexMotion {
 public:
  struct Influence {
    std::int32_t bone;
    double weight;  // >= 0; the weights of a vertex sum to 1 within rounding
  };

  /// `first_influence` has vertices + 1 entries.
  SkinnedVertices(std::vector<Eigen::Vector3d> rest, BoneChain bones,
                  std::vector<std::int32_t> first_influence, std::vector<Influence> influences);

  void parameters(double time, std::span<double> out) const override;
  void vertices(std::span<const double> parameters, int first,
                std::span<Eigen::Vector3d> out) const override;
  double speedBound(double t0, double t1) const override;
  double accelerationBound(double t0, double t1) const override;
  double rounding(double t0, double t1) const override;

  std::span<const Eigen::Vector3d> rest() const { return rest_; }
  std::span<const Influence> influences(int vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return {influences_.data() + first_influence_[v], influences_.data() + first_influence_[v + 1]};
  }
  int boneCount() const { return bones_.count(); }

 private:
  std::vector<Eigen::Vector3d> rest_;
  BoneChain bones_;
  std::vector<std::int32_t> first_influence_;
  std::vector<Influence> influences_;
  std::vector<double> speeds_, accelerations_;  // one for each segment
  double rounding_ = 0;
};

}  // namespace leeway::collision
