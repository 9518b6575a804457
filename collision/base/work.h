#pragma once

#include <cstdint>
#include <limits>

namespace leeway::collision {

class Scratch;  // leeway/collision/query.h

/// The cost of queries, counted instead of timed, so that it is the same on every machine and
/// instruction set. It counts steps of searches, boxes, points and planes in lanes, each with its
/// weight. A unit is about a nanosecond on the machine on which the weights were measured.
struct Work {
  std::int64_t done = 0;
  /// Above this limit, searches through hierarchies and lanes stop: intervals are wider or
  /// undecided, but still hold.
  std::int64_t limit = std::numeric_limits<std::int64_t>::max();

  bool isSpent() const { return done > limit; }
  void add(std::int64_t units) { done += units; }
};

/// Weights, fitted once to the times of 66,700 edges of panda and ur5 (AMD EPYC, Zen 5, AVX-512).
/// Their sum is within a third of the measured time for nine in ten edges above 20 us.
inline constexpr std::int64_t kPairWork = 100;       ///< a pair of convex parts
inline constexpr std::int64_t kStepWork = 80;        ///< a step of its search
inline constexpr std::int64_t kSweptPairWork = 250;  ///< a pair with one swept part
inline constexpr std::int64_t kSweptStepWork = 75;
inline constexpr std::int64_t kSweptLanePairWork = 120;  ///< such a pair in vector lanes
inline constexpr std::int64_t kSweptLaneStepWork = 50;
inline constexpr std::int64_t kBoxWork = 13;        ///< a box of a node, or a pair of triangles
inline constexpr std::int64_t kLaneBallWork = 5;    ///< a ball in all lanes
inline constexpr std::int64_t kLanePointWork = 3;   ///< a point against a plane
inline constexpr std::int64_t kLanePlaneWork = 80;  ///< each plane, besides its points
inline constexpr std::int64_t kPlaneSearchWork = 1200;
inline constexpr std::int64_t kLanePassWork = 850;  ///< placing the frames
inline constexpr std::int64_t kPlacingWork = 40;    ///< placing one link
inline constexpr std::int64_t kCellWork = 2;        ///< a cell of a table

/// From now on, queries with `scratch` count into `work` and stop at its limit; `work` must outlive
/// them. O(1).
void countInto(Scratch& scratch, Work& work);

}  // namespace leeway::collision
