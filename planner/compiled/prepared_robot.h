#pragma once

// Private to planner/: the part of compiling that concerns only the robot.

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

/// A robot with its held objects, ready for any world: its bodies and their bounds, the pairs among
/// them, motions and their bounds. It is kept with the model (robots::Model::prepared). So all
/// problems share it that plan the same variables with the same values of the others, and the same
/// held objects and contacts. Constant; does not own the model.
class PreparedRobot final : public robots::PreparedStore::Entry {
 public:
  /// The prepared robot of a problem; prepares it if necessary. Thread-safe: if two threads prepare
  /// it, both get the same one. Throws robots::InputError for two half-spaces that may not touch.
  /// O(pairs of links * joints), plus milliseconds per pair of links for proofs if the robot has no
  /// SRDF. These proofs poll `stop` and throw robots::Stopped.
  static std::shared_ptr<const PreparedRobot> of(const Problem& problem,
                                                 const ConfigurationSpace& space,
                                                 const robots::Stop& stop);

  /// Links with geometry, then held objects, and their pairs. Margins have no meaning here; moving
  /// bodies have the poses of the first problem.
  const collision::Scene& scene() const { return scene_; }
  /// The link that carries each body, whether it moves or not.
  std::span<const int> carriers() const { return carriers_; }
  /// Pairs of bodies that are not checked, by their first body: pairs of bodies up to the i-th end
  /// at droppedEnd(i). Pairs that geometry decides come last.
  const std::shared_ptr<const std::vector<CompiledScene::Dropped>>& dropped() const {
    return dropped_;
  }
  std::size_t droppedEnd(int body) const { return dropped_ends_[static_cast<std::size_t>(body)]; }
  /// Warnings about pairs that are checked although they touch at the zero configuration.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Links that the SRDF allows to touch everything.
  std::span<const int> uncheckedBodies() const { return unchecked_bodies_; }
  /// The contacts of the problem.
  const Contacts& contacts() const { return contacts_; }
  /// Whether the problem's contacts mention the name. O(log names).
  bool isAllowedName(const std::string& name) const;
  /// The name of a member in which a problem differs from the one that the robot was prepared for;
  /// null: none.
  const char* differenceFrom(const Problem& problem) const;

  const RobotMotions& motions() const { return motions_; }
  /// Created at the first use. `model`: the problem's.
  const RobotLanes& lanes(const robots::Model& model) const;

  std::span<const int> variables() const { return variables_; }
  std::span<const Attachment> attachments() const { return attachments_; }
  /// Limits of planned variables and values of the others, one per variable.
  std::span<const robots::VariableRange> ranges() const { return ranges_; }

 private:
  PreparedRobot(const Problem& problem, std::vector<robots::VariableRange> ranges,
                const ConfigurationSpace& space, const robots::Stop& stop);
  const char* differenceFrom(const Problem& problem,
                             std::span<const robots::VariableRange> ranges) const;

  // The data that it was prepared from.
  robots::RobotDescription robot_;
  std::vector<int> variables_;
  std::vector<robots::VariableRange> ranges_;
  std::vector<Attachment> attachments_;
  Contacts contacts_;

  std::vector<std::string> allowed_names_;  // sorted
  collision::Scene scene_;
  std::vector<int> carriers_;
  std::shared_ptr<const std::vector<CompiledScene::Dropped>> dropped_;
  std::vector<std::size_t> dropped_ends_;
  std::vector<std::string> warnings_;
  std::vector<int> unchecked_bodies_;
  RobotMotions motions_;

  mutable std::once_flag lanes_once_;
  mutable std::unique_ptr<const RobotLanes> lanes_;
};

}  // namespace leeway::planner
