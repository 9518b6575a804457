#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/constraint_result.h"
#include "leeway/planner/problem.h"
#include "planner/constraint/frame_motion.h"

namespace leeway::planner {

/// Proves a problem's constraints at points and along whole edges of a scene, and looks at its
/// condition at states of these. Has buffers: one thread at a time. The scene must outlive it.
class ConstraintProof {
 public:
  /// The constraints' names are known. O(constraints * joints^2).
  ConstraintProof(const CompiledScene& scene, const Problem& problem);

  /// Whether all constraints, and the condition, hold at a point. O(constraints * joints).
  bool holds(std::span<const double> point);
  /// Whether constraints are proven to hold everywhere on the edge from a to b, and the condition
  /// holds at states at most Condition::resolution apart. Errors at both ends bound
  /// those between, up to how far the frame leaves its chord; where that is too much the edge is
  /// halved, kConstraintHalvings times at most. O(constraints * joints) for each part.
  bool holds(std::span<const double> a, std::span<const double> b);

  /// Returns in words what is wrong at a point: "constraint 'upright': frame 'tool' is tilted by
  /// 0.3 rad, at most 0.17 is allowed"; empty where all hold.
  std::string fault(std::span<const double> point);

  struct Broken {
    std::size_t edge = 0;
    std::string what;  ///< "constraint 'upright' is not proven to hold"
  };
  /// Proven bounds over all edges between points, one for each constraint; nothing where they are
  /// not proven. `broken`: receives the first edge on which one is not; may be null.
  std::optional<std::vector<ConstraintResult>> prove(const std::vector<std::vector<double>>& points,
                                                     Broken* broken = nullptr);

 private:
  /// How far a frame is from what it must keep. A bound for the ends of a chord is one for all of
  /// it: distances to convex sets, and projections.
  struct Error {
    double position = 0;  ///< of the origin from its box [m]
    double chord = 0;     ///< the longest chord between a unit vector and where it should be
    double sine = 0;      ///< of the axis and its direction
    double cosine = 1;
  };
  struct Part {
    Constraint constraint;
    robots::Pose X_BR;  ///< of the reference frame in the motion's base
    FrameMotion motion;
    ConstraintResult worst;
  };
  struct Span {
    double t0, t1;
    Error e0, e1;
  };

  static Error errorOf(const Part& part, const robots::Pose& X_BF);
  static Error over(const Error& a, const Error& b, const ChordDeparture& departure);
  static double angleOf(const Constraint& constraint, const Error& error);
  static bool isWithin(const Constraint& constraint, const Error& error);
  bool holds(Part& part, std::span<const double> a, std::span<const double> b);
  /// Whether the condition accepts all states that are looked at on an edge.
  bool isAccepted(std::span<const double> a, std::span<const double> b);

  const CompiledScene* scene_;
  Condition condition_;
  std::vector<double> states_;
  std::vector<Part> parts_;
  std::vector<Span> open_;  ///< of an edge: parts that are not proven yet
};

}  // namespace leeway::planner
