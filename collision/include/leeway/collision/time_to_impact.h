#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "leeway/collision/scene.h"

namespace leeway::collision {

/// Bounds on the motion of a body: on the magnitudes of the vectors, over all of its points.
struct PointMotion {
  double speed = 0;         ///< now [m/s]
  double acceleration = 0;  ///< from now on, centripetal terms included [m/s^2]; may be infinite
  /// No point is ever faster [m/s]. If `speed` is greater, this bound takes precedence.
  double speed_cap = std::numeric_limits<double>::infinity();
};

/// How fast two such bodies can approach each other: the sums of their bounds; NaN if a number is
/// negative or NaN.
PointMotion closing(const PointMotion& a, const PointMotion& b);

/// The earliest time [s] at which a gap of `gap` [m] can be used up, rounded down. With closing
/// speed v and acceleration a it is 2 gap / (v + sqrt(v^2 + 2 a gap)), linear past the cap on
/// speed. Infinity if nothing moves. 0 for a gap that is not positive, and if any number is
/// negative or NaN, because unknown never counts as free. O(1).
double timeToImpact(double gap, const PointMotion& closing);

/// The answer of ImpactSchedule::advance().
struct ImpactReport {
  /// No pair can come down to its margin before this time [s].
  double safe_until = std::numeric_limits<double>::infinity();
  /// The pair that is due next [index of Scene::pairs()]; -1 if there is none. For a row (see
  /// ScenePairs), the first due pair of those that are near.
  int next_pair = -1;
  int imminent = 0;  ///< pairs not proven to keep their margin until time + horizon
  int violated = 0;  ///< number of imminent pairs that are proven to be at or below their margin
                     ///< now
};

/// Monitors a scene. It keeps a queue of the scene's pairs, ordered by the earliest time at which
/// each can come down to its margin, so that only due pairs are checked again. A row of pairs (see
/// ScenePairs) is one entry: when it is due, its near pairs are checked, and one distance
/// represents all others. The schedule has no clock: the caller passes the time and the poses.
/// Compare the collision-time queues of B. Mirtich, "Impulse-based dynamic simulation of rigid body
/// systems" (1996), section 2.3. The scene must outlive the schedule. Margins that are raised or
/// grown meanwhile take effect at a pair's next check.
class ImpactSchedule {
 public:
  /// Every pair is due at once. Until setMotion() the motion of a moving body is unknown (infinite
  /// speed). O(bodies + listed pairs + rows); the only call that allocates.
  explicit ImpactSchedule(const Scene& scene);

  /// Bounds the motion of a body from `time` [s] on. If the new bounds exceed the last ones at this
  /// time, the body's pairs become due at `time`, or all rows if the body has a place: O(n log n)
  /// in them, otherwise O(1). Times must not decrease (an earlier one counts as the latest).
  void setMotion(int body, const PointMotion& motion, double time);

  /// Checks the pairs that could come down to their margins before time + horizon [s], coarse
  /// bounds first. `workspace` has the poses of all bodies at `time`, within its pose_error. If an
  /// argument is NaN, no pair is checked and safe_until is -infinity. Never throws or allocates;
  /// O(n (log n + a distance query)) in the number of due pairs and, for due rows, of near ones.
  ImpactReport advance(double time, double horizon, Workspace& workspace);

  /// No pair can come down to its margin before this time [s].
  double safeUntil() const;
  /// The pair cannot come down to its margin before this time [s]. O(1).
  double due(int pair) const { return due_[itemOf(pair)]; }
  /// imminent() lists at most this many pairs of rows; the report counts all [count].
  static constexpr std::size_t kMostNamed = std::size_t{1} << 16U;
  /// The imminent pairs of the last advance(), lowest index first.
  std::span<const std::int32_t> imminent() const { return {imminent_.data(), imminent_count_}; }

  struct Statistics {
    std::uint64_t advances = 0, looks = 0, exact = 0;
  };
  Statistics statistics;

 private:
  struct TimedMotion {
    PointMotion motion;
    double time = -std::numeric_limits<double>::infinity();  // the bounds hold from this time on
                                                             // [s]
  };
  std::size_t itemOf(int pair) const;
  bool isEmptyRow(std::int32_t item) const;  // no pair of the row is ever due
  PointMotion motionAt(int body, double time) const;
  PointMotion fastestStill(double time) const;
  double look(int pair, double time, double horizon, Workspace& workspace, bool& violated);
  double lookAtRow(std::size_t row, double time, double horizon, Workspace& workspace,
                   ImpactReport& report);
  void addImminent(std::int32_t pair, ImpactReport& report);
  void setDue(std::int32_t item, double due);
  bool before(std::int32_t a, std::int32_t b) const;
  void place(std::size_t slot, std::int32_t item);
  void siftDown(std::size_t slot);
  void siftUp(std::size_t slot);

  const Scene* scene_;
  std::vector<TimedMotion> motions_;  // one for each body
  // Bodies that have places and a motion: their shapes deform, or the caller set their motion.
  std::vector<std::int32_t> moved_still_;
  std::vector<char> is_moved_still_;
  // Items are the listed pairs, followed by the rows.
  std::vector<double> due_;                // one an item [s]
  std::vector<std::int32_t> heap_, slot_;  // binary heap of items by due time; each item's slot
  // Items of body b: items_of_body_[first_item_[b]] to [first_item_[b + 1]].
  std::vector<std::int32_t> items_of_body_, first_item_;
  std::vector<std::int32_t> next_of_row_;  // for each row, the pair that is due first
  std::vector<std::int32_t> looking_, imminent_;
  std::size_t imminent_count_ = 0;  // of imminent_
};

}  // namespace leeway::collision
