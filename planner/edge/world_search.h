#pragma once

// Private to planner/: the pairs of one moving piece with a world of many obstacles, nearest first.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "collision/base/numbers.h"
#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "collision/lanes/obstacle_boxes.h"
#include "leeway/collision/scene.h"
#include "leeway/collision/shape.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {

/// Branch and bound over the boxes of static bodies, best first. A node is bounded by the plane
/// that separates the piece, swept over an interval, from the node's centre: its children lie
/// beyond that plane at the distance of their boxes. So most boxes cost a few products, and one in
/// sixteen a distance. A piece that is not convex has no such plane; its distance changes no faster
/// than the point does. The bounds are on distances, not on depths: they prove nothing below 0.
/// Allocates only in the constructor.
class WorldSearch {
 public:
  /// Refers to both.
  WorldSearch(const EdgeFrames& frames, collision::Workspace& workspace);

  /// A part of the edge: the slots at its ends, and how far points may leave the chords between
  /// them [m].
  struct Part {
    int slot0, slot1;
    double growth;
  };
  struct Result {
    double lower;   ///< of the separation of all pairs that were not visited, over the part [m]
    bool complete;  ///< these pairs are at least as far as required
  };
  /// Calls visit(pair) for the pairs of a row, in the order of a lower bound on their separation
  /// over the part, while it is below enough(). Stops early after `steps` nodes and pairs, when
  /// `work` is spent, when visit() returns false, or without room. In a part without length, a
  /// piece with an inside contains what is inside; in other parts only its surface is bounded.
  template <class Enough, class Visit>
  Result run(std::size_t row, const Part& part, int steps, const collision::Work& work,
             const Enough& enough, const Visit& visit) {
    if (!begin(row, part)) return {-kInfinity, false};
    while (!tasks_.empty()) {
      const double lower = tasks_.front().lower;
      if (lower >= enough()) return {std::min(beyond_, lower), true};
      if (steps-- <= 0 || work.isSpent()) return {std::min(beyond_, lower), false};
      const Task task = pop();
      const bool goes_on = task.pair >= 0 ? visit(task.pair) : expand(task, enough());
      if (!goes_on) return {std::min(beyond_, lower), false};
    }
    return {beyond_, true};
  }

 private:
  /// A node of the hierarchy, or one of the pairs at its leaves.
  struct Task {
    double lower;
    std::int32_t pair;  ///< -1: a node
    std::int32_t index, level;
    bool is_of_first;  ///< of ObstacleBoxes::first()
    bool operator<(const Task& other) const { return lower > other.lower; }  // for a heap
  };

  bool begin(std::size_t row, const Part& part);
  /// Adds a node or, in level 0, its pair. False without room.
  bool push(double lower, const collision::ObstacleBoxes& of, std::size_t level, std::size_t index);
  Task pop();
  /// Bounds a node, and adds the children that may be nearer than `enough`. False without room.
  bool expand(const Task& task, double enough);

  const EdgeFrames& frames_;
  collision::Workspace& workspace_;
  const collision::Shape point_ = collision::Shape::sphere(0);
  collision::SpareVector<Task> tasks_;  // a heap, with the least bound first

  // The current search.
  const collision::ObstacleBoxes* boxes_ = nullptr;
  const collision::Shape* shape_ = nullptr;
  collision::Pose X_WA0_, X_WA1_;
  double growth_ = 0;
  bool is_swept_ = false;
  std::size_t row_ = 0;
  double beyond_ = 0;  // the least bound of what was left out
};

}  // namespace leeway::planner
