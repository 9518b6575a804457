#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "collision/deform/motion/key_track.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// Vertices stored frame by frame. The two parameters are the number of a frame and the share of
/// the next frame.
class CachedVertices final : public VertexMotion {
 public:
  explicit CachedVertices(CacheMotion motion);

  void parameters(double time, std::span<double> out) const override;
  /// (1 - share) * frame + share * next, without fused operations; the frame itself for share 0.
  void vertices(std::span<const double> parameters, int first,
                std::span<Eigen::Vector3d> out) const override;
  double speedBound(double t0, double t1) const override;
  double accelerationBound(double t0, double t1) const override;
  double rounding(double t0, double t1) const override;
  MotionSource source() const override {
    return CacheMotion{vertexCount(), {track_.times().begin(), track_.times().end()}, positions_};
  }

  std::size_t frameCount() const { return track_.times().size(); }
  const Eigen::Vector3d* frame(std::size_t i) const {
    return positions_.data() + i * static_cast<std::size_t>(vertexCount());
  }

 private:
  void measureSegments();

  KeyTrack track_;
  std::vector<Eigen::Vector3d> positions_;
  double size_ = 0;             // largest |coordinate| [m]
  std::vector<double> speeds_;  // one for each segment
};

}  // namespace leeway::collision
