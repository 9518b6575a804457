#pragma once

#include <functional>
#include <span>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/contact/distance_gradient.h"

namespace leeway::planner {

/// A way along obstacles. If a step towards a target meets an obstacle, the distance there and its
/// gradient give the part of the step that leads into it. The next step omits that part, and keeps
/// a small clearance. Contacts on the way accumulate, so a body can also pass between two walls. In
/// this way trees reach places that are too narrow for samples (Zhang, Manocha, "An efficient
/// retraction-based RRT planner", 2008, move samples to the surface for the same reason).
///
/// A slide uses its certifier and its own workspace, in the same order for the same calls. If no
/// other code uses the certifier, its answers depend only on the calls made here.
class ContactSlide {
 public:
  using Edge = std::function<EdgeCheck(std::span<const double>, std::span<const double>)>;

  /// `check` decides each tried edge with the certifier: it counts edges, and leaves them open
  /// after the time limit. `range`: the longest step, in the space's distance. All must outlive the
  /// slide.
  ContactSlide(EdgeCertifier& certifier, const Edge& check, double range);

  /// Slides from `from`, which is free, towards `target`; each step comes nearer. Appends the
  /// reached points; a free edge joins each to the previous one. Appends no points if there is no
  /// way. At most kSlideEdges edges, each step O(contacts * variables).
  void slide(std::span<const double> from, std::span<const double> target,
             std::vector<double>& points);

 private:
  /// A limit on approaching an obstacle: gradient * step >= least.
  struct Contact {
    std::vector<double> gradient;
    double least;
  };
  void project(std::span<double> step) const;
  bool meet(std::span<const double> from, std::span<const double> to, const EdgeCheck& check);
  /// Bisects the way from `from`, which is free, to t. place_ becomes the last place for which
  /// is_free() holds; is_free() reads place_.
  template <class IsFree>
  void placeBefore(std::span<const double> from, std::span<const double> to, double t,
                   const IsFree& is_free);
  /// The nearest pair at the last free place before t, which becomes place_.
  EdgeClearance nearestBefore(std::span<const double> from, std::span<const double> to, double t);
  /// The same for one pair, at far lower cost; other pairs may be in contact at place_.
  EdgeClearance nearestOfPair(std::span<const double> from, std::span<const double> to, double t,
                              int pair);
  /// The distance of the pair's bodies at place_.
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
  std::vector<int> chain_;  ///< of the queried pair
  std::vector<robots::Pose> X_WL_;
  std::vector<Contact> contacts_;
};

}  // namespace leeway::planner
