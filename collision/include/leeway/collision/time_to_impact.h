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
  /// No point is ever faster [m/s]; where `speed` is greater, this holds.
  double speed_cap = std::numeric_limits<double>::infinity();
};

/// How fast two such bodies can close on each other: the sums; NaN where a number is negative or
/// NaN.
PointMotion closing(const PointMotion& a, const PointMotion& b);

/// The earliest time [s] at which a gap of `gap` [m] can be used up, rounded down: with closing
/// speed v and acceleration a it is 2 gap / (v + sqrt(v^2 + 2 a gap)), linear past the cap on
/// speed. Infinity when nothing moves; 0 for a gap that is not positive, and where any number is
/// negative or NaN, since unknown is never free. O(1).
double timeToImpact(double gap, const PointMotion& closing);

/// The answer of ImpactSchedule::advance().
struct ImpactReport {
  /// No pair can come down to its margin before this time [s].
  double safe_until = std::numeric_limits<double>::infinity();
  /// The pair that is due next [index of Scene::pairs()]; -1 when there is none. For a
  /// row (see ScenePairs), the pair that is due first of those that are near.
  int next_pair = -1;
  int imminent = 0;  ///< pairs not proven to keep their margin until time + horizon
  int violated = 0;  ///< those of them that are proven to be at or below it now
};

/// Monitors a scene: a queue of its pairs by the earliest time at which each can come down to its
/// margin, so that only pairs that are due are looked at again. A row of pairs (see ScenePairs) is
/// one entry of it: when it is due, its pairs that are near are looked at, and one distance stands
/// for all others. Has no clock: the caller passes the time and where bodies are. Compare the
/// collision-time queues of B. Mirtich, "Impulse-based dynamic simulation of rigid body systems"
/// (1996), section 2.3. The scene must outlive the schedule; margins that are raised or
/// grown meanwhile count from a pair's next look on.
class ImpactSchedule {
 public:
  /// Every pair is due at once. Until setMotion() the motion of a moving body is unknown (infinite
  /// speed). O(bodies + listed pairs + rows); the only call that allocates.
  explicit ImpactSchedule(const Scene& scene);

  /// Bounds the motion of a body from `time` [s] on. Where the new bounds exceed the last ones at
  /// this time, the body's pairs become due at `time`, or all rows if the body has a place:
  /// O(n log n) in them, else O(1). Times must not run backwards (an earlier one counts as the
  /// latest).
  void setMotion(int body, const PointMotion& motion, double time);

  /// Looks at the pairs that could come down to their margins before time + horizon [s], coarse
  /// bounds first. `workspace` has the poses of all bodies at `time`, within its pose_error. With a
  /// NaN nothing is looked at and safe_until is -infinity. Never throws or allocates;
  /// O(n (log n + a distance query)) in what is due and, of rows that are due, near.
  ImpactReport advance(double time, double horizon, Workspace& workspace);

  /// No pair can come down to its margin before this time [s].
  double safeUntil() const;
  /// The pair cannot come down to its margin before this time [s]. O(1).
  double due(int pair) const { return due_[itemOf(pair)]; }
  /// imminent() names at most this many pairs of rows; the report counts all [count].
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
    double time = -std::numeric_limits<double>::infinity();  // from when on it holds [s]
  };
  std::size_t itemOf(int pair) const;
  bool isEmptyRow(std::int32_t item) const;  // nothing is due in it, ever
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
  std::vector<TimedMotion> motions_;  // one a body
  // Bodies that have places and a motion: their shapes deform, or the caller knows.
  std::vector<std::int32_t> moved_still_;
  std::vector<char> is_moved_still_;
  // Items are the listed pairs, and after them the rows.
  std::vector<double> due_;                // one an item [s]
  std::vector<std::int32_t> heap_, slot_;  // binary heap of items by due time; each item's slot
  // Items of body b: items_of_body_[first_item_[b]] to [first_item_[b + 1]].
  std::vector<std::int32_t> items_of_body_, first_item_;
  std::vector<std::int32_t> next_of_row_;  // of each row the pair that is due first
  std::vector<std::int32_t> looking_, imminent_;
  std::size_t imminent_count_ = 0;  // of imminent_
};

}  // namespace leeway::collision
