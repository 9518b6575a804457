#pragma once

// Private to planner/: the bodies of a robot, and the selection of the pairs that are checked.

#include <optional>
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
/// drop it; the first reason found is kept.
class RobotPairs {
 public:
  /// `ranges`: of the model's variables, in this valid problem. Throws robots::Stopped.
  RobotPairs(const Problem& problem, std::span<const robots::VariableRange> ranges,
             const robots::Stop& stop);

  collision::SceneBuilder builder() const;
  /// The link that carries each body.
  std::vector<int> carriers() const;
  /// The gap of the links of two bodies by joint angles, from the model; null: none.
  const robots::LinkGap* linkGap(int i, int j) const;

  /// Links that the SRDF allows to touch everything, unless the problem replaces the SRDF.
  std::vector<int> uncheckedBodies() const;
  /// Dropped pairs by their first body; those of body i end at droppedEnds()[i]. Pairs that
  /// geometry decides come last.
  std::vector<CompiledScene::Dropped> takeDropped() { return std::move(dropped_); }
  /// Warnings about pairs that are checked although they touch at the zero configuration.
  std::vector<std::string> takeWarnings() { return std::move(warnings_); }
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

  struct Reason {
    Unchecked why;
    std::string words;
  };

  void findCarriers();
  std::set<std::pair<int, int>> bodiesOf(
      const std::vector<std::pair<std::string, std::string>>& pairs) const;
  std::optional<Reason> reason(int i, int j) const;
  std::optional<Reason> contact(int i, int j) const;
  void drop(int i, int j, const Reason& reason);
  void dropTouching(const robots::Stop& stop);
  void warnOfTouch(int i, int j);

  int count() const { return static_cast<int>(entries_.size()); }
  const std::string& name(int i) const;
  std::span<const int> named(const std::string& name) const;
  bool areNamed(int i, int j, const std::string& a, const std::string& b) const;
  int parentOf(int link) const;
  bool areAdjacent(int a, int b) const;
  const robots::DisabledPair* findDisabled(int a, int b) const;
  bool isUnchecked(const Entry& entry) const;
  bool derivesPairs() const { return !model_.has_srdf && !problem_.contacts.replace_srdf; }

  const Problem& problem_;
  const robots::Model& model_;
  const std::vector<robots::LinkGap>& link_gaps_ = model_.linkGaps();
  std::span<const robots::VariableRange> ranges_;
  std::vector<robots::Pose> poses_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::vector<int>> named_;  // entries by name
  std::set<std::pair<int, int>> allowed_, checked_;          // by the problem; the lower body first
  /// The link of the nearest joint that moves each link; -1: it stands still.
  std::vector<int> carrier_;
  std::set<std::pair<int, int>> is_dropped_;
  std::vector<CompiledScene::Dropped> dropped_;
  std::vector<std::size_t> dropped_ends_;
  std::vector<std::string> warnings_;
};

}  // namespace leeway::planner
