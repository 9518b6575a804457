#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/motion_bound.h"

namespace leeway::planner {

/// A problem reduced to what its queries can need: moving bodies only for links that the planned
/// variables move, the rest folded into the world; pairs that are allowed, rigidly attached or
/// proven apart left out. Constant while it is queried.
class CompiledScene {
 public:
  /// Throws robots::InputError for an object whose pose is not finite or no rotation, for margins
  /// that are not finite and for two half-spaces that may not touch; std::invalid_argument for
  /// variables that do not exist or hold part of an orientation. O(pairs of geometries), besides
  /// the proofs (milliseconds a pair of links) where the robot has no SRDF.
  explicit CompiledScene(const Problem& problem);

  const collision::Scene& scene() const { return scene_; }
  const ConfigurationSpace& space() const { return *space_; }
  const robots::Model& model() const { return *model_; }
  /// Link that carries scene body b, -1 for a static body.
  int bodyLink(int body) const { return body_link_[static_cast<std::size_t>(body)]; }
  /// How body a of a scene pair moves seen from body b (static: from the world), as an index into
  /// motions(), which pairs share; the other way round when isReversed(pair): whichever of the two
  /// is near the joints between them moves less.
  int pairMotionIndex(int pair) const { return pair_motion_[static_cast<std::size_t>(pair)]; }
  /// What is proven of the two links of a scene pair by the angles of two joints; null: nothing is.
  const robots::LinkGap* linkGap(int pair) const {
    return link_gaps_[static_cast<std::size_t>(pair)];
  }
  bool isReversed(int pair) const { return reversed_[static_cast<std::size_t>(pair)] != 0; }
  std::span<const robots::RelativeMotion> motions() const { return motions_; }
  /// Configuration of the whole model for a point of the space.
  void expand(std::span<const double> point, std::span<double> q) const;
  /// A difference of points as a difference of configurations: 0 for variables that are not
  /// planned.
  void expandDifference(std::span<const double> difference, std::span<double> dq) const;
  /// True when the edge is one smooth motion of every joint: false only where a circle wraps under
  /// a mimic joint that is not periodic in it, so that the mimic would jump.
  bool isSmooth(std::span<const double> a, std::span<const double> b,
                std::span<const double> difference) const;
  /// Rounding of kinematics, added to every bound [m]: how far any point of a moving body may be
  /// from where the exact kinematics of the exact point of the edge have it.
  double rounding() const { return rounding_; }

  /// The rounding bound holds for bodies within this distance of the world's origin [m]: beyond all
  /// limits, or what an unlimited joint is trusted with.
  double reach() const { return reach_; }

  /// The same scene with every pair's margin at least `margin` [m]: what a search for clearance
  /// asks of its next path. Bounds and meshes are those compiled before.
  std::shared_ptr<const CompiledScene> withMarginAtLeast(double margin) const {
    auto raised = std::make_shared<CompiledScene>(*this);
    raised->scene_.raiseMargins(margin);
    return raised;
  }

  /// The same scene with every pair's margin greater by at least `growth` >= 0 [m], and none below
  /// it (collision::Scene::growMargins()): what a motion keeps that departs so far from one that
  /// is certified.
  std::shared_ptr<const CompiledScene> withMarginsGrown(double growth) const;

  /// Another shape for a geometry of a body of the world, see collision::Scene::setShape() and
  /// growMargins().
  struct Replacement {
    int body, geometry;
    collision::Shape shape;
    double growth = 0;  ///< [m]
  };
  /// The same scene at another instant: deforming obstacles with the shapes that they have then.
  /// Only geometries of Problem::deforming may be named. Pairs, bodies and motions keep their
  /// numbers.
  std::shared_ptr<const CompiledScene> withShapes(std::span<const Replacement> shapes) const;

  /// The same scene, looking at nothing but the pairs of which keep(pair) is true: for edges of
  /// which the others are known.
  std::shared_ptr<const CompiledScene> withPairs(
      const std::function<bool(const collision::ScenePair&)>& keep) const;

  /// True when pairs were dropped by a proof that holds within the joints' limits only: points
  /// outside them cannot be answered.
  bool needsLimits() const { return needs_limits_; }

  /// What was dropped and why: for `leeway info`.
  struct Dropped {
    std::string a, b, reason;
  };
  const std::vector<Dropped>& dropped() const { return dropped_; }

 private:
  void deriveMotions(const Problem& problem, std::span<const robots::VariableRange> ranges);
  void keepAskedMotions();

  std::shared_ptr<const robots::Model> model_;
  std::shared_ptr<const ConfigurationSpace> space_;
  std::vector<double> base_configuration_;
  collision::Scene scene_;
  std::vector<int> body_link_;
  std::vector<int> pair_motion_;
  std::vector<char> reversed_;                     // one a pair
  std::vector<const robots::LinkGap*> link_gaps_;  // one a pair, of the model
  std::vector<robots::RelativeMotion> motions_;
  std::vector<int>
      jumping_circles_;  // places in a point of circles that a mimic joint is not periodic in
  std::vector<Dropped> dropped_;
  double rounding_ = 0;
  double reach_ = 0;
  bool needs_limits_ = false;
};

}  // namespace leeway::planner
