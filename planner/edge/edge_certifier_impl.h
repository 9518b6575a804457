#pragma once

// Private to planner/: what certify() and edgeClearance() share.

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collision/base/work.h"
#include "collision/sweep/mesh_sweep.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_lanes.h"

namespace leeway::planner {

/// A dyadic part of the edge, with the pairs that it leaves open as a range of a list.
struct EdgeInterval {
  int slot0, slot1;
  double t0, h;
  int begin, end;
  int level;
};

struct EdgeCertifier::Impl {
  explicit Impl(std::shared_ptr<const CompiledScene> scene);

  /// Nothing is counted yet, and so much may be.
  void startWork(std::int64_t limit = std::numeric_limits<std::int64_t>::max()) {
    work = {0, limit};
  }

  /// What a look at one pair found.
  enum class Pair : unsigned char { kFree, kNotFree, kOpen };

  // One configuration (edge_state.cc).
  /// `slot` is the edge's configuration at t.
  Verdict checkState(int slot, double t, int& pair);
  Pair coarseState(int slot, const EdgePair& pair) const;
  /// `nodes`: see sweep(); where they do not suffice, open.
  Pair exactState(int slot, const EdgePair& pair, int nodes = 0);
  collision::DistanceResult stateDistance(int slot, const EdgePair& pair,
                                          const collision::DistanceRequest& request);

  // One interval.
  /// What is known of a motion: its bound over the present interval, and its part near the right
  /// end.
  struct MotionMemory {
    std::uint64_t stamp = 0, generation = 0;
    int slot = -1;
    double half = 0;
    robots::MotionBound bound, right;
  };
  /// A piece's ball over an interval, in some frame.
  struct SweptBall {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0, growth = 0;
    std::uint64_t stamp = 0;
  };
  SweptBall sweptBall(const EdgeInterval& interval, const EdgePair& pair, const Eigen::Vector3d& c0,
                      const Eigen::Vector3d& c1);
  /// The same in the world, for a pair whose other piece does not move: once an interval and piece.
  const SweptBall& worldBall(const EdgeInterval& interval, const EdgePair& pair);
  const robots::MotionBound& motionOf(const EdgeInterval& interval, int motion);
  /// Lower bound on the separation over the interval, from balls, and the growth of a sweep.
  double coarseSweep(const EdgeInterval& interval, const EdgePair& pair, double& growth);
  /// `nodes`: at most so many pairs of nodes for meshes; 0: no limit of its own.
  Interval sweep(const EdgeInterval& interval, const EdgePair& pair, double growth,
                 double threshold, int nodes = 0);
  /// Both surfaces of a pair over all of an interval, for by_surfaces. Told: free, or not (at t),
  /// or neither.
  collision::MeshSweepResult sweepSurfaces(const EdgeInterval& interval, const EdgePair& pair);
  /// The slot of the edge's configuration at t, placed once for most t; -1 when there is none left.
  int slotAt(double t);
  /// Where a pair's first piece is, seen from the second, along the edge.
  class PairPlacements;

  /// Sweeps the open pairs of an interval, in place: afterwards [begin, end) is what it leaves
  /// open. False when one is proven not to be free, at t.
  bool examine(EdgeInterval& interval, std::vector<int>& open, int& offender, double& t);
  void startInterval() { ++stamp; }

  /// The open pairs of an interval at its middle: not free or undecided where one is there.
  Verdict checkMiddle(const EdgeInterval& interval, int slot, int& offender);
  /// The same at the end of an interval, for pairs whose sweep has just failed there for the first
  /// time on this edge.
  Verdict checkEnd(const EdgeInterval& interval, int& offender);
  EdgeCheck told(Verdict verdict, int p, double t);
  EdgeCheck certifyByLanes();
  /// An exact look at a pair at t, which changes what is expected of the next; free where no
  /// contact is found there.
  EdgeCheck lookAt(int p, double t);
  /// Looks for contacts between the middles of lanes, of pairs that are open and have not been
  /// looked at so in vain, and exactly at those that the last exact look found in contact; free
  /// where nothing is met.
  EdgeCheck lookCloser(const EdgeLanes::Parts& parts);
  /// Where the first of some lanes begins, and how far it is from there to the end of the last.
  static std::pair<double, double> rangeOf(const EdgeLanes::Parts& parts, std::uint32_t open_lanes);
  /// Looks at open pairs whose hulls are not apart, in the middle of where they are open; free
  /// where nothing is met.
  EdgeCheck checkOpen(const EdgeLanes::Parts& parts);
  /// Lists what the pass of lanes left and planes will not part as intervals; false when that
  /// cannot be placed.
  bool listOpenLanes();
  /// Whether a pair that is open in some lanes is asked over just these as one interval.
  bool isAskedOver(const collision::LaneSweep::Open& pair, int lane, int width) const;
  /// How many lanes one sweep of a pair is tried on: as long as its growth stays small.
  int mergedLanes(const collision::LaneSweep::Open& pair) const;
  /// Lists what a pass over parts left: pairs whose hulls were apart as parts for finer passes,
  /// others, and those that it left open in most of a part, as intervals. False when there are too
  /// many.
  bool listParts(const EdgeLanes::Parts& parts);
  /// Whether a finer pass was of little use for a pair in the part that begins with lane `first`:
  /// one sweep of what is there is tried on all of it, where it would take many in pieces.
  bool isWideOpen(const collision::LaneSweep::Open& pair, int first, int share) const;
  bool listWideOpen(const EdgeLanes::Parts& parts, int first);
  bool listLane(const EdgeLanes::Parts& parts, int lane, int first);
  /// Finer passes over the parts that are listed, until none is left or they do not pay; what
  /// remains becomes intervals. Told where that decides the edge.
  std::optional<EdgeCheck> certifyParts();
  /// Lists what parts from `next` on are left as intervals; false when there are too many.
  bool listPartsLeft(std::size_t& next);
  bool isForParts(const collision::LaneSweep::Open& pair) const {
    return pair.apart && !frames.pairs()[static_cast<std::size_t>(pair.id)].by_surfaces;
  }
  /// As many parts of the list, from `next` on, as one pass divides; pass_pairs become their pairs.
  EdgeLanes::Parts takeParts(std::size_t& next);
  /// An interval without pairs, at the end of the lists.
  bool addInterval(double from, double width);
  /// Not free where one of the pairs that are open in all of the edge is so at its end: a body may
  /// be inside another there without a meeting of surfaces.
  EdgeCheck checkInside();
  /// Intervals that stand side by side become one, pair by pair, as long as a sweep's growth stays
  /// small: one is asked for less than two. False when that cannot be placed.
  bool mergeIntervals();
  /// The same for a range of stretches; the number of those that are left.
  std::size_t mergeStretches();
  EdgeCheck certifyByLevels();
  EdgeCheck certifyIntervals();
  void findLastValid(const EdgeRequest& request, EdgeCheck& check);
  bool certifyPrefix(EdgeInterval interval, EdgeCheck& check);

  /// Appends the halves of an interval, met in `slot`, with its open pairs, to the next level.
  void split(const EdgeInterval& interval, int slot);

  // Clearance of an edge (edge_clearance.cc).
  struct ClearanceSearch;
  Interval refineState(int slot, double t, const EdgePair& pair, ClearanceSearch& search);
  void searchState(int slot, double t, ClearanceSearch& search);
  void settlePairs(EdgeInterval& interval, ClearanceSearch& search);
  void settleFromMiddle(EdgeInterval& interval, int slot, bool last, ClearanceSearch& search);
  /// Lists all pairs over the whole edge.
  void listWholeEdge(int start, int end);
  /// Lists what lanes do not prove to be so far apart that it need not be looked at, and settles
  /// the rest; false, with nothing settled, where they say nothing.
  bool listNearLanes(ClearanceSearch& search);
  /// Looks at the first few pairs that lanes left open, in the middle of where they are open.
  void searchOpenLanes(const EdgeLanes::Parts& parts, int count, ClearanceSearch& search);
  void searchIntervals(ClearanceSearch& search);

  std::shared_ptr<const CompiledScene> scene;
  EdgeFrames frames;
  EdgeLanes lanes;
  bool lanes_fit = true;  // what `scene` is now
  collision::Workspace workspace;
  std::vector<MotionMemory> motion;    // one a motion
  std::vector<SweptBall> world_balls;  // one a piece
  /// Slots of multiples of 1 / kSharedSlots.
  struct SharedSlot {
    std::uint64_t generation = 0;
    int slot = -1;
  };
  std::vector<SharedSlot> shared_slots;
  std::uint64_t stamp = 0;
  std::vector<double> hopeful;              // growth [m] at which a pair's sweep is worth trying
  std::vector<std::uint64_t> failed_stamp;  // the interval at which a pair's sweep last failed
  std::vector<std::uint64_t> end_looked;    // the edge at whose end a pair was last looked at
  // Of looks at a pair before it is swept, and before planes are looked for: up by what is met,
  // down by what is not; below 0 none are taken.
  std::vector<int> luck, closer_luck;
  /// What lookCloser() has asked in vain of this edge, with exact queries or without.
  struct CloserLook {
    int pair;
    double from, width;
    bool exact;
  };
  std::vector<CloserLook> closer_looks;
  std::vector<EdgeInterval> intervals, next_intervals;
  /// What mergeIntervals() asks of a pair.
  struct Stretch {
    int pair;
    double from, width;
  };
  std::vector<Stretch> stretches;
  /// A part of the edge that is looked at in lanes again, and its pairs as a range of part_pairs.
  struct EdgePart {
    double from, width;
    int begin, end;
  };
  std::vector<EdgePart> edge_parts;
  std::vector<int> part_pairs, open_everywhere;
  std::vector<collision::LaneSweep::Open> pass_pairs;
  int looks = 0;  // at single configurations of this edge
  std::vector<int> open, next_open;
  std::vector<std::pair<double, int>> order;  // pairs by coarse distance
  int killer = 0;                             // index into pairs of what last was not free
  collision::Work work;                       // of the present edge or state
  std::int64_t work_limit = 0;
  int queries = 0;  // of the present edgeClearance()
  double smallest = 0;
  Statistics* statistics = nullptr;
  std::uint64_t edge = 0;  // number of the present one
};

/// Places for configurations and intervals of one edge; beyond them it is undecided.
inline constexpr int kEdgeSlots = 1024;
inline constexpr int kEdgeIntervals = 2048;
inline constexpr int kEdgeOpen = 1 << 16;
inline constexpr int kEdgeParts = 512;
inline constexpr int kEdgeStretches = 4096;

/// Places of an edge whose slots are found again.
inline constexpr int kSharedSlots = 1 << 9;

}  // namespace leeway::planner
