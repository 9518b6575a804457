#pragma once

// Private to planner/: the state of an EdgeCertifier, and the stages that certify() and
// edgeClearance() share, file by file.
//
// clang-format off
//   what decides an edge, cheap to dear             here                        file
//   1. balls; planes and points already known       EdgeLanes::sweep            edge_lanes.cc
//   2. gaps between links, by joint angles          EdgeLanes::closeGaps        edge_lanes.cc
//   3. contacts, where they are likely              searchLikelyContacts        edge_contacts.cc
//   4. new planes                                   EdgeLanes::searchPlanes     edge_lanes.cc
//   5. contacts in the middle of open lanes         searchContacts              edge_contacts.cc
//   6. planes again, over finer parts               certifyParts                edge_parts.cc
//   7. containment at the edge's end                checkContainment            edge_contacts.cc
//   8. exact sweeps of what is left, bisected       bisectIntervals             edge_bisection.cc
//
//   beneath these: one interval                     sweepOpenPairs              edge_sweep.cc
//                  lists of intervals               listOpenLanes and below     edge_intervals.cc
//                  one configuration                decideByLanes, checkState   edge_state.cc
//   the least clearance in place of a verdict       ClearanceSearch             edge_clearance.cc
//   a proof of more than the margins                Asking                      edge_clearance.cc
// clang-format on

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/pair_table.h"
#include "collision/base/work.h"
#include "collision/sweep/mesh_sweep.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_lanes.h"

namespace leeway::planner {

// Capacities for one edge, which stays undecided where it needs more.

inline constexpr int kEdgeSlots = 1024;      ///< configurations
inline constexpr int kEdgeIntervals = 2048;  ///< intervals of one level
inline constexpr int kEdgeOpen = 1 << 16;    ///< open pairs of all these
inline constexpr int kEdgeParts = 512;       ///< parts for finer passes of lanes

inline constexpr int kEdgeSpans = 4096;      ///< of more spans none are merged
inline constexpr int kSharedSlots = 1 << 9;  ///< multiples of 1 / kSharedSlots are placed once
inline constexpr int kContactLooks = 3;      ///< looks for a contact, in each of two stages

/// Part [t0, t0 + h] of the edge; both are dyadic, and so exact. The pairs that are still open
/// there are [begin, end) of a list.
struct EdgeInterval {
  int slot0, slot1;  ///< the configurations at its ends
  double t0, h;
  int begin, end;
  int level;  ///< bisections so far
};

/// A part of an edge's cost.
struct CostPart {
  EdgeInterval interval;
  int middle;                 ///< its configuration's slot; -1: none was left
  double lower, upper;        ///< of the integral over it, in t
  double clearance, nearest;  ///< bounds on its least clearance [m]
};

struct EdgeCertifier::Impl {
  explicit Impl(std::shared_ptr<const CompiledScene> scene);

  /// Resets the count of work; beyond `limit` the edge stays undecided.
  void startWork(std::int64_t limit = std::numeric_limits<std::int64_t>::max()) {
    work = {0, limit};
  }

  /// What an edge may cost that names no limit.
  std::int64_t defaultWork() const;

  // The order of the stages (edge_certifier.cc). Functions that return an optional check return it
  // where they decide the edge.

  /// An edge within work_limit; undecided, too, where it cannot be begun.
  EdgeCheck decideEdge(std::span<const double> a, std::span<const double> b);
  EdgeCheck certifyByLanes();
  /// Without lanes: exact sweeps alone, from the whole edge down.
  EdgeCheck certifyByBisection();
  /// A verdict on pair p (-1: none) at t. Remembers a pair that is not free.
  EdgeCheck makeCheck(Verdict verdict, int p = -1, double t = 0);
  EdgeCheck makeCheck(const EdgeLanes::Parts& parts, const collision::LaneSweep::Contact& contact) {
    return makeCheck(Verdict::kNotFree, contact.id, parts.from[contact.lane] + parts.width / 2);
  }

  /// Sets looked_at, most_rounding and least_margin.
  void takePairs();

  // What is asked: by certify() that all pairs keep their margins.

  /// While it lives, some pairs alone are looked at, and have to keep `demanded` where their margin
  /// is less [m].
  class Asking;
  bool isAsked(const EdgePair& pair) const {
    return asked == Pairs::kAll || pair.is_self == (asked == Pairs::kSelf);
  }
  double thresholdOf(const EdgePair& pair) const {
    return std::max(pair.threshold, demanded + pair.rounding);
  }
  double leastMargin() const { return least_margin[static_cast<std::size_t>(asked)]; }
  /// How far what is demanded is above the least margin [m].
  double beyondMargins() const { return std::max(0.0, demanded - leastMargin()); }

  // One configuration (edge_state.cc).

  enum class PairState : unsigned char { kFree, kNotFree, kOpen };
  /// The pairs, in their order, that may not keep their thresholds, or not be farther apart than
  /// `reach` >= 0 [m]; until the next call.
  std::span<const int> nearPairs(int slot, double reach);
  /// Of an edge without length that frames have begun: stages 1, 2 and 4, which mostly tell.
  std::optional<Verdict> decideByLanes();
  /// All pairs at t, placed in `slot`. `offender`: the pair that is not free or undecided.
  Verdict checkState(int slot, double t, int& offender);
  /// By balls and coarse shapes.
  PairState coarseState(int slot, const EdgePair& pair) const;
  /// By distance(). Looks at no more than `nodes` pairs of nodes; 0: as many as it takes.
  PairState exactState(int slot, const EdgePair& pair, int nodes = 0);
  /// Witnesses in the scene's order of the two bodies.
  collision::DistanceResult stateDistance(int slot, const EdgePair& pair,
                                          const collision::DistanceRequest& request);

  // One interval (edge_sweep.cc).

  /// Bounds on a motion, of the present interval, and of its right half, which the next interval
  /// needs as its left one.
  struct MotionMemory {
    std::uint64_t interval_stamp = 0, generation = 0;
    int slot = -1;  ///< at the right end
    double half = 0;
    robots::MotionBound bound, right;
  };
  /// Holds a piece over an interval, in some frame. `growth`: how far points may leave the chord
  /// between their two places [m].
  struct SweptBall {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0, growth = 0;
    std::uint64_t interval_stamp = 0;
  };
  struct PairContact {
    int pair;
    double t;
  };
  class PairPlacements;

  /// Sweeps the open pairs of an interval, in place: afterwards [begin, end) are those still open.
  /// Stops at a pair that is proven not to be free, and returns it.
  std::optional<PairContact> sweepOpenPairs(EdgeInterval& interval);
  /// One of these pairs; `t`: where it is not free.
  PairState sweepPair(const EdgeInterval& interval, int p, double& t);
  PairState sweepExactly(const EdgeInterval& interval, int p, double growth, double& t);
  /// Invalidates bounds and balls of the interval before.
  void startInterval() { ++interval_stamp; }
  const robots::MotionBound& motionOf(const EdgeInterval& interval, int motion);
  SweptBall sweptBall(const EdgeInterval& interval, const EdgePair& pair, const Eigen::Vector3d& c0,
                      const Eigen::Vector3d& c1);
  /// sweptBall() in the world, for pairs whose other piece stands still: made once an interval and
  /// piece.
  const SweptBall& worldBall(const EdgeInterval& interval, const EdgePair& pair);
  /// Lower bound on the separation over the interval, from balls, and the growth of a sweep [m].
  double coarseSweep(const EdgeInterval& interval, const EdgePair& pair, double& growth);
  /// Separation over the interval, from the hull of a's two placements grown by `growth`, as far as
  /// `threshold` needs it. `nodes`: see exactState().
  Interval sweep(const EdgeInterval& interval, const EdgePair& pair, double growth,
                 double threshold, int nodes = 0);
  /// Both surfaces of a pair that is by_surfaces.
  collision::MeshSweepResult sweepSurfaces(const EdgeInterval& interval, const EdgePair& pair);
  /// The slot of the configuration at t, placed once for multiples of 1 / kSharedSlots; -1 when
  /// none is left.
  int slotAt(double t);

  // Contacts (edge_contacts.cc).

  /// Before planes are searched, which costs more: between the middles of lanes, for pairs whose
  /// lane_contact_score allows it; exactly, for those that the last exact look found in contact.
  std::optional<EdgeCheck> searchLikelyContacts(const EdgeLanes::Parts& parts);
  /// After planes: open pairs whose hulls are not apart, in the middle of where they are open.
  std::optional<EdgeCheck> searchContacts(const EdgeLanes::Parts& parts);
  /// distance() of a pair at t; updates its contact_score.
  std::optional<EdgeCheck> checkContactAt(int p, double t);
  /// Where the first of some lanes begins, and how far it is from there to the end of the last.
  static std::pair<double, double> rangeOf(const EdgeLanes::Parts& parts, std::uint32_t open_lanes);
  /// At the edge's end, pairs of meshes that are open in all of it: a body may be inside another
  /// though their surfaces never meet.
  std::optional<EdgeCheck> checkContainment();
  /// At the edge's end, pairs whose sweep of its last interval has failed; once an edge and pair.
  std::optional<EdgeCheck> checkEnd(const EdgeInterval& interval);
  /// At an interval's middle, placed in `slot`, its open pairs. Undecided pairs stay open.
  std::optional<EdgeCheck> checkMiddle(const EdgeInterval& interval, int slot);

  // Finer passes of lanes (edge_parts.cc).

  /// Planes over the listed parts, each divided again, until none is left or they no longer pay;
  /// what remains becomes intervals.
  std::optional<EdgeCheck> certifyParts();
  /// Lists what a pass over `parts` left open: pairs whose hulls were apart become parts of finer
  /// passes; the others, and those open in most of a part, become intervals. False when full.
  bool listParts(const EdgeLanes::Parts& parts);
  bool listWideOpen(const EdgeLanes::Parts& parts, int first);
  bool listLane(const EdgeLanes::Parts& parts, int lane, int first);
  /// Lists the parts from `next` on as intervals. False when full.
  bool listPartsLeft(std::size_t& next);
  /// True for a pair that a finer pass left open in more than half of the `share` lanes from
  /// `first` on, which are one part of the pass before: one exact sweep is tried over all of it.
  bool isWideOpen(const collision::LaneSweep::Open& pair, int first, int share) const;
  /// Finer passes may part what is apart in the middle of its lanes.
  bool isForParts(const collision::LaneSweep::Open& pair) const {
    return pair.apart && !frames.pair(pair.id).by_surfaces;
  }
  /// As many parts of the list, from `next` on, as one pass divides; pass_pairs are their pairs.
  EdgeLanes::Parts takeParts(std::size_t& next);

  // Lists of intervals (edge_intervals.cc).

  /// One interval, with all pairs; of those with the world with what may come as near as their
  /// thresholds plus `reach` >= 0 [m]. False where there is no room for all.
  bool listWholeEdge(int start, int end, double reach);
  /// Appends the pairs that the pass over the whole edge left and finer passes will not part, each
  /// over as many lanes at once as a sweep is tried on. False when full.
  bool listOpenLanes();
  /// Whether listOpenLanes() has a pair over the `width` lanes from `lane` on as one interval.
  bool isSweptOver(const collision::LaneSweep::Open& pair, int lane, int width) const;
  /// The most lanes over which a sweep of the pair keeps its growth below kMergedGrowth.
  int lanesPerSweep(const collision::LaneSweep::Open& pair) const;
  /// Appends an interval without pairs. False when full.
  bool addInterval(double from, double width);
  /// Makes one interval of neighbours, pair by pair, as long as a sweep's growth stays small: one
  /// long sweep costs less than two short ones. False when full.
  bool mergeIntervals();
  /// mergeIntervals() over `spans`; returns how many remain.
  std::size_t mergeSpans();
  /// Whether the next level has room for the halves of an interval with `count` pairs.
  bool hasRoomToSplit(std::size_t count) const {
    return next_open_pairs.size() + 2 * count <= next_open_pairs.capacity() &&
           next_intervals.size() + 2 <= next_intervals.capacity();
  }
  /// Appends the halves of an interval, which meet in `slot`, to the next level.
  void split(const EdgeInterval& interval, int slot);

  // Bisection (edge_bisection.cc).

  /// Sweeps the listed intervals and the halves of those that stay open, level by level.
  EdgeCheck bisectIntervals();
  std::optional<EdgeCheck> bisect(EdgeInterval& interval);
  /// Sets check.last_valid: how far from its start the edge is certified.
  void findLastValid(EdgeCheck& check);
  /// Depth first from the left; false where an interval stays open.
  bool certifyPrefix(EdgeInterval interval, EdgeCheck& check);

  // The least clearance of an edge (edge_clearance.cc).

  struct ClearanceSearch;
  Interval refineState(int slot, double t, const EdgePair& pair, ClearanceSearch& search);
  void searchState(int slot, double t, ClearanceSearch& search);
  void listWholeEdge(int start, int end, ClearanceSearch& search);
  void searchNearLanes(int slot, ClearanceSearch& search);
  void searchPairs(int slot, double t, std::span<const int> near, ClearanceSearch& search);
  void settlePairs(EdgeInterval& interval, ClearanceSearch& search);
  void settleFromMiddle(EdgeInterval& interval, int slot, bool last, ClearanceSearch& search);
  bool listNearLanes(ClearanceSearch& search);
  /// EdgeLanes::sweepBeyond() for the pairs that are asked, and planes where that leaves some open.
  collision::LaneSweep::Contact sweepAskedBeyond(double beyond);
  /// The distance of pair p near t, downhill.
  void descend(int p, double t, ClearanceSearch& search);
  void searchOpenLanes(const EdgeLanes::Parts& parts, int count, ClearanceSearch& search);
  void searchIntervals(ClearanceSearch& search);

  // The cost of an edge (objective/edge_cost.cc).

  class CostSearch;

  // The scene, and what is placed of it.

  std::shared_ptr<const CompiledScene> scene;
  EdgeFrames frames;
  EdgeLanes lanes;
  double most_rounding = 0;              ///< of all pairs [m]
  std::array<double, 3> least_margin{};  ///< of each kind of Pairs [m]
  Pairs asked = Pairs::kAll;
  double demanded = -kInfinity;  ///< [m]
  bool lanes_fit = true;  ///< false after rebind(): lanes hold the shapes of the scene before
  collision::Workspace workspace;
  struct SharedSlot {
    std::uint64_t generation = 0;
    int slot = -1;
  };
  std::vector<SharedSlot> shared_slots;

  // The present edge.

  std::uint64_t edge = 0;  ///< its number
  collision::Work work;    ///< spent on it, or on a state
  std::int64_t work_limit = 0;
  double smallest = 0;     ///< EdgeRequest::smallest_interval
  bool has_begun = false;  ///< the edge: it can be certified at all
  int queries = 0;         ///< exact ones; for edgeClearance()
  int contact_looks = 0;   ///< of searchContacts()

  // The present interval.

  std::uint64_t interval_stamp = 0;
  std::vector<MotionMemory> motion;    ///< one a motion
  std::vector<SweptBall> world_balls;  ///< one a moving piece

  // Lists.

  collision::SpareVector<EdgeInterval> intervals, next_intervals;  ///< of this level and the next
  collision::SpareVector<int> open_pairs, next_open_pairs;         ///< theirs
  /// Where a pair is to be swept, for mergeIntervals().
  struct Span {
    int pair;
    double from, width;
  };
  std::vector<Span> spans;
  /// A part of the edge for finer passes; its pairs are [begin, end) of part_pairs.
  struct EdgePart {
    double from, width;
    int begin, end;
  };
  std::vector<EdgePart> edge_parts;
  collision::SpareVector<int> part_pairs;
  std::vector<collision::LaneSweep::Open> pass_pairs;
  std::vector<CostPart> cost_parts;  ///< a heap by their width
  std::vector<int> looked_at;        ///< pairs that may be near anywhere: listed ones, or all
  bool looks_at_all = false;         ///< they are few
  collision::SpareVector<int> near_pairs, asked_pairs;  ///< of nearPairs(), and of the call before
  bool near_pairs_full = false;                         ///< more were near than there was room for
  std::vector<int> never_parted;                        ///< pairs for checkContainment()
  std::vector<std::pair<double, int>> order;            ///< pairs by coarse distance
  /// What searchLikelyContacts() has asked of this edge in vain.
  struct ContactLook {
    int pair;
    double from, width;
    bool exact;  ///< by distance(), too
  };
  std::vector<ContactLook> likely_looks;

  // Memory of edges before. It steers which queries are tried, never what they prove.

  int last_contact = -1;  ///< the pair that was last not free; -1: none
  int last_named = -1;    ///< the pair that the last verdict named
  struct PairMemory {
    /// Growth up to which a sweep is tried [m]: falls where it fails, rises where it succeeds.
    double growth_limit = kSweepGrowth;
    std::uint64_t sweep_failed = 0;  ///< interval_stamp of the last failure
    std::uint64_t end_checked = 0;   ///< the edge at whose end it was last asked
    /// Looks for a contact, by distance() and by lanes: up by a contact, down by a look in vain;
    /// below 0 no look is taken.
    int contact_score = 0, lane_contact_score = 0;
  };
  collision::PairTable<PairMemory> pair_memory;

  Statistics* statistics = nullptr;
};

class EdgeCertifier::Impl::Asking {
 public:
  Asking(Impl& impl, Pairs pairs, double demanded) : impl_(impl) {
    impl.asked = pairs;
    impl.demanded = demanded;
    impl.lanes.demandBeyond(impl.beyondMargins());
  }
  Asking(const Asking&) = delete;
  Asking& operator=(const Asking&) = delete;
  ~Asking() {
    impl_.asked = Pairs::kAll;
    impl_.demanded = -kInfinity;
    impl_.lanes.demandBeyond(0);
  }

 private:
  Impl& impl_;
};

}  // namespace leeway::planner
