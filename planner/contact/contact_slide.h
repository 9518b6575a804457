#pragma once

#include <functional>
#include <span>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/contact/distance_gradient.h"

namespace leeway::planner {

/// A way along what is in the way. Where a step towards a target meets something, the distance
/// there and its gradient say which part of the step leads into it; that part is left out of the
/// next step, and a little room is kept. What is met on the way adds up, so that a body also finds
/// its way between two walls. So trees get into places that are too narrow for samples (Zhang,
/// Manocha, "An efficient retraction-based RRT planner", 2008, move samples to the surface for the
/// same reason).
///
/// It asks its certifier and a workspace of its own, in the same order for the same calls: with a
/// certifier that nobody else asks, its answers depend on the calls made here alone.
class ContactSlide {
 public:
  using Edge = std::function<EdgeCheck(std::span<const double>, std::span<const double>)>;

  /// `check` decides each edge that is tried, by the certifier: it counts them, and leaves them
  /// open when time is over. `range`: the longest step, in the space's distance. All must outlive
  /// the slide.
  ContactSlide(EdgeCertifier& certifier, const Edge& check, double range);

  /// From `from`, which is free, towards `target`, nearer with each step. Appends the points that
  /// it reaches, each joined to the one before by a free edge; none where there is no way. At most
  /// kSlideEdges edges, each step O(contacts * variables).
  void slide(std::span<const double> from, std::span<const double> target,
             std::vector<double>& points);

 private:
  /// What must not be neared: gradient * step >= least.
  struct Contact {
    std::vector<double> gradient;
    double least;
  };
  void project(std::span<double> step) const;
  bool meet(std::span<const double> from, std::span<const double> to, const EdgeCheck& check);
  /// Halves the way from `from`, which is free, to t: place_ is the last place that is_free(),
  /// which is asked about place_.
  template <class IsFree>
  void placeBefore(std::span<const double> from, std::span<const double> to, double t,
                   const IsFree& is_free);
  /// The nearest pair at the last free place before t, which is place_ then.
  EdgeClearance nearestBefore(std::span<const double> from, std::span<const double> to, double t);
  /// The same of one pair, which is far cheaper; other pairs may meet at place_.
  EdgeClearance nearestOfPair(std::span<const double> from, std::span<const double> to, double t,
                              int pair);
  /// Between the pair's bodies at place_.
  collision::DistanceResult distanceOf(int pair, const collision::DistanceRequest& request);

  EdgeCertifier& certifier_;
  const CompiledScene& scene_;
  const ConfigurationSpace& space_;
  const Edge& check_;
  double range_;
  DistanceGradient gradients_;
  collision::Workspace workspace_;
  std::vector<double> inverse_;  ///< of the squared weight of each direction
  std::vector<double> at_, next_, place_, step_, moved_;
  std::vector<double> q_;   ///< place_ as a configuration of the whole model
  std::vector<int> chain_;  ///< of the pair that is asked for
  std::vector<robots::Pose> X_WL_;
  std::vector<Contact> contacts_;
};

}  // namespace leeway::planner
