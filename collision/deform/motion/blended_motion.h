#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "collision/base/sine_cosine.h"
#include "collision/deform/motion/key_track.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// 2 pi turns [rad]. Whole turns are subtracted first, which is exact. The error is less than 16
/// units for the two operations, plus 2 pi times the error of `turns`.
inline double angleOfTurns(double turns) { return kTwoPi * (turns - std::nearbyint(turns)); }

// clang-format off
/// A vertex is base + sum over the fields of coordinate times the field's vector there: morph targets
/// (no base), reduced modes, and waves, each of which is two standing waves:
///   sin(k r - w t + p) = sin(k r) cos(p - w t) + cos(k r) sin(p - w t).
/// The parameters are the coordinates.
// clang-format on
class BlendedMotion final : public VertexMotion {
 public:
  using Field = std::vector<Eigen::Vector3d>;

  /// amplitude * sin(2 pi frequency t + phase), or with the cosine.
  struct Harmonic {
    double amplitude, frequency, phase;
    bool cosine;
  };

  /// Bounds, for all times, of a vertex's speed [m/s] and acceleration [m/s^2], and of the error of
  /// the stored fields [m].
  struct HarmonicBounds {
    double speed = 0, acceleration = 0, field_error = 0;
  };

  /// With keys: one row of coordinates for each key. `base` may be empty.
  BlendedMotion(MotionKind kind, Field base, std::vector<Field> fields, KeyTrack track,
                std::vector<std::vector<double>> coordinates);
  /// With one harmonic for each field.
  BlendedMotion(MotionKind kind, Field base, std::vector<Field> fields,
                std::vector<Harmonic> harmonics, const HarmonicBounds& bounds);

  void parameters(double time, std::span<double> out) const override;
  void vertices(std::span<const double> parameters, int first,
                std::span<Eigen::Vector3d> out) const override;
  double speedBound(double t0, double t1) const override;
  double accelerationBound(double t0, double t1) const override;
  double rounding(double t0, double t1) const override;

  const Field& base() const { return base_; }
  const std::vector<Field>& fields() const { return fields_; }

 private:
  void measureFields();
  void measureSegments();
  Field base_;
  std::vector<Field> fields_;
  double base_size_ = 0;             // largest |coordinate| [m]
  std::vector<double> field_sizes_;  // largest |coordinate| of each field [m]

  std::optional<KeyTrack> track_;
  std::vector<std::vector<double>> coordinates_;  // one row a key
  std::vector<double> speeds_, accelerations_;    // one for each segment

  std::vector<Harmonic> harmonics_;
  HarmonicBounds bounds_;
};

}  // namespace leeway::collision
