#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "leeway/collision/scene.h"

namespace leeway::collision {

/// How fast any point of a thing can be now, and how that can change. All three bound the magnitude
/// of vectors, over all of the thing's points.
struct PointMotion {
  double speed = 0;         ///< now [m/s]
  double acceleration = 0;  ///< from now on, centripetal terms included [m/s^2]; may be infinite
  double speed_cap =
      std::numeric_limits<double>::infinity();  ///< no point is ever faster [m/s]; what is known of
                                                ///< `speed` beyond it is ignored
};

/// How fast two things that move so can close on each other: the sums.
PointMotion closing(const PointMotion& a, const PointMotion& b);

/// The earliest time [s] after which a gap of `gap` [m] can be used up, rounded down: with closing
/// speed v and acceleration a it is 2 gap / (v + sqrt(v^2 + 2 a gap)), linear past the cap on
/// speed. 0 for a gap that is not positive; infinity when nothing moves; 0 for whatever is no
/// number or negative, since unknown is never free. O(1).
double timeToImpact(double gap, const PointMotion& closing);

/// What an advance of a schedule found.
struct ImpactReport {
  /// No pair can come down to its margin before this time [s].
  double safe_until = std::numeric_limits<double>::infinity();
  /// The pair that is next [index of Scene::pairs()]; -1 when there is none.
  int next_pair = -1;
  /// Pairs that were looked at and are not proven to keep their margin until time + horizon; those
  /// of them proven to be at or below their margin now.
  int imminent = 0;
  int violated = 0;
};

/// Pairs of a scene in the order in which they can come down to their margins. Knows no clock: the
/// caller says what time it is and where bodies are, and only pairs that are due are looked at
/// again. Compare the collision-time queues of B. Mirtich, "Impulse-based dynamic simulation of
/// rigid body systems" (1996), section 2.3. The scene must outlive the schedule.
class ImpactSchedule {
 public:
  /// Every pair is due at once; bodies that move have unknown motion (infinite speed) until
  /// setMotion(). O(pairs); the only call that allocates.
  explicit ImpactSchedule(const Scene& scene);

  /// From `time` [s] on a body moves as bounded by `motion`. Where that is more than was said
  /// before for this time, its pairs become due at `time`; else nothing has to be looked at again.
  /// Times must not run backwards (an earlier one counts as the latest). O(1), or O(pairs of the
  /// body * log pairs).
  void setMotion(int body, const PointMotion& motion, double time);

  /// Looks at the pairs that could come down to their margins before time + horizon [s], with
  /// `workspace` holding the poses of all bodies at `time` (a pose that is off by
  /// workspace.pose_error is allowed for). Coarse bounds first. A time that is no number is safe
  /// until never: nothing is looked at and safe_until is -infinity. Never throws or allocates;
  /// O(due * (log pairs + a distance query)).
  ImpactReport advance(double time, double horizon, Workspace& workspace);

  /// No pair can come down to its margin before this time [s].
  double safeUntil() const;
  /// The same for one pair.
  double due(int pair) const { return due_[static_cast<std::size_t>(pair)]; }
  /// Pairs that the last advance() left imminent, the lowest index first.
  std::span<const std::int32_t> imminent() const { return {imminent_.data(), imminent_count_}; }

  struct Statistics {
    std::uint64_t advances = 0, looks = 0, exact = 0;
  };
  Statistics statistics;

 private:
  struct Said {
    PointMotion motion;
    double time = -std::numeric_limits<double>::infinity();
  };
  PointMotion motionAt(int body, double time) const;
  double look(int pair, double time, double horizon, Workspace& workspace, bool& violated);
  void setDue(std::int32_t pair, double due);
  bool before(std::int32_t a, std::int32_t b) const;
  void place(std::size_t slot, std::int32_t pair);
  void sink(std::size_t slot);
  void rise(std::size_t slot);

  const Scene* scene_;
  std::vector<Said> said_;                                // one a body
  std::vector<double> due_;                               // one a pair
  std::vector<std::int32_t> heap_, slot_;                 // pairs by due time; where each stands
  std::vector<std::int32_t> pairs_of_body_, first_pair_;  // pairs of body b: first_pair_[b] ..
  std::vector<std::int32_t> looking_, imminent_;
  std::size_t imminent_count_ = 0;
};

}  // namespace leeway::collision
