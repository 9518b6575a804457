#pragma once

// Private to planner/: the bodies of a robot, and which of their pairs are checked.

#include <map>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/motion_bound.h"

namespace leeway::planner {

/// Bodies: links with geometry, then held objects. A pair is checked unless there is a reason to
/// drop it; the first reason found stands.
class RobotPairs {
 public:
  /// `ranges`: of the model's variables, in this problem, which is valid. Throws robots::Stopped.
  RobotPairs(const Problem& problem, std::span<const robots::VariableRange> ranges,
             const robots::Stop& stop);

  collision::SceneBuilder builder() const;
  /// The link that carries each body.
  std::vector<int> carriers() const;
  /// What the model knows of the links of two bodies by joint angles; null: nothing.
  const robots::LinkGap* linkGap(int i, int j) const;

  /// True when a pair was dropped by a proof that holds within the joints' limits only.
  bool hasProven() const { return has_proven_; }
  /// Dropped pairs; those of body i with later ones end at droppedEnds()[i]. Last those proven
  /// apart.
  std::vector<CompiledScene::Dropped> takeDropped() { return std::move(dropped_); }
  std::vector<std::size_t> takeDroppedEnds() { return std::move(dropped_ends_); }

 private:
  struct Entry {
    collision::Body body;
    int link;                // that carries it
    const Attachment* held;  // null for links
    bool isLink() const { return held == nullptr; }
  };

  void add(Entry entry);
  void addLinks();
  void addAttachments();

  void findAllowed();
  std::string reason(int i, int j) const;
  void drop(int i, int j, const std::string& why);
  void dropProven(const robots::Stop& stop);

  int count() const { return static_cast<int>(entries_.size()); }
  const std::string& name(int i) const;
  std::span<const int> named(const std::string& name) const;
  bool areNamed(int i, int j, const std::string& a, const std::string& b) const;
  bool moves(int link) const;
  int parentOf(int link) const;
  int rigidRoot(int link) const;
  bool areAdjacent(int a, int b) const;
  bool areRigid(const Entry& a, const Entry& b) const;
  bool hasMargin(int i, int j) const;
  bool isPassiveWithinLimits() const;

  const Problem& problem_;
  const robots::Model& model_;
  std::span<const robots::VariableRange> ranges_;
  std::vector<robots::Pose> poses_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::vector<int>> named_;  // entries by name
  std::set<std::pair<int, int>> allowed_;                    // by the problem; the lower first
  std::map<std::pair<int, int>, std::string> reasons_;
  std::vector<CompiledScene::Dropped> dropped_;
  std::vector<std::size_t> dropped_ends_;
  bool has_proven_ = false;
};

}  // namespace leeway::planner
