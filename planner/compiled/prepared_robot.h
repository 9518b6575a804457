#pragma once

// Private to planner/: what compiling makes of a robot alone.

#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/motion_bound.h"
#include "leeway/robots/prepared_store.h"
#include "planner/compiled/edge_model.h"
#include "planner/compiled/robot_lanes.h"

namespace leeway::planner {

/// Whether poses and shapes are the same, bit by bit; shapes that share no vertices are not.
bool isSamePose(const robots::Pose& x, const robots::Pose& y);
bool areSameShapes(std::span<const robots::Geometry> x, std::span<const robots::Geometry> y);

/// A robot with what it holds, ready for any world: its bodies and their bounds, the pairs among
/// them, motions and their bounds. Kept with the model (robots::Model::prepared), and so shared by
/// all problems that plan the same variables from the same values of the others, with the same held
/// objects and contacts. Constant; does not own the model.
class PreparedRobot final : public robots::PreparedStore::Entry {
 public:
  /// That of a problem, prepared now if it is not yet. Thread-safe; two threads may both prepare
  /// it, and get the same. Throws robots::InputError for two half-spaces that may not touch.
  /// O(pairs of links * joints), plus milliseconds a pair of links for proofs where the robot has
  /// no SRDF; these ask `stop`: throws robots::Stopped.
  static std::shared_ptr<const PreparedRobot> of(const Problem& problem,
                                                 const ConfigurationSpace& space,
                                                 const robots::Stop& stop);

  /// Links with geometry, then held objects, and their pairs. Margins mean nothing; moving bodies
  /// stand where the first problem had them.
  const collision::Scene& scene() const { return scene_; }
  /// The link that carries each body, whether it moves or not.
  std::span<const int> carriers() const { return carriers_; }
  /// True when a pair was dropped by a proof that holds within the joints' limits only.
  bool hasProven() const { return has_proven_; }
  /// Pairs of bodies that are not checked. Those of the bodies up to the i-th with later ones end
  /// at droppedEnd(i); after them all, those of which geometry decides.
  const std::shared_ptr<const std::vector<CompiledScene::Dropped>>& dropped() const {
    return dropped_;
  }
  std::size_t droppedEnd(int body) const { return dropped_ends_[static_cast<std::size_t>(body)]; }
  /// About pairs that are checked although they touch at the zero configuration.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Links that the SRDF lets touch everything.
  std::span<const int> uncheckedBodies() const { return unchecked_bodies_; }
  /// The problem's.
  const Contacts& contacts() const { return contacts_; }
  /// Whether the problem's contacts name it. O(log names).
  bool isAllowedName(const std::string& name) const;
  /// Which member of a problem is not what the robot was prepared from; null: none. Of margins that
  /// counts which proofs ask.
  const char* differenceFrom(const Problem& problem) const;

  const RobotMotions& motions() const { return motions_; }
  /// Made by the first who asks. `model`: the problem's.
  const RobotLanes& lanes(const robots::Model& model) const;

  std::span<const int> variables() const { return variables_; }
  /// Limits of what is planned, values of what is not; one a variable.
  std::span<const robots::VariableRange> ranges() const { return ranges_; }

 private:
  PreparedRobot(const Problem& problem, std::vector<robots::VariableRange> ranges,
                const ConfigurationSpace& space, const robots::Stop& stop);
  const char* differenceFrom(const Problem& problem,
                             std::span<const robots::VariableRange> ranges) const;

  // What it was prepared from.
  std::vector<int> variables_;
  std::vector<robots::VariableRange> ranges_;
  std::vector<Attachment> attachments_;
  Contacts contacts_;
  Margins margins_;
  bool has_srdf_;

  std::vector<std::string> allowed_names_;  // sorted
  collision::Scene scene_;
  std::vector<int> carriers_;
  bool has_proven_ = false;
  std::shared_ptr<const std::vector<CompiledScene::Dropped>> dropped_;
  std::vector<std::size_t> dropped_ends_;
  std::vector<std::string> warnings_;
  std::vector<int> unchecked_bodies_;
  RobotMotions motions_;

  mutable std::once_flag lanes_once_;
  mutable std::unique_ptr<const RobotLanes> lanes_;
};

}  // namespace leeway::planner
