// The passes of LaneSweep over its pairs by balls.
// Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_BALL_PASS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_BALL_PASS_INL_H
#undef LEEWAY_COLLISION_BALL_PASS_INL_H
#else
#define LEEWAY_COLLISION_BALL_PASS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/lanes/lane_balls-inl.h"
#include "collision/lanes/lane_planes-inl.h"
#include "collision/lanes/lane_points-inl.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The passes over pairs by balls. all() first culls by boxes around sweeps, then by outer balls.
/// Then it searches contacts by inner balls, and finally tries the last planes and the covers of
/// balls.
template <bool kStill>
class BallPass {
 public:
  explicit BallPass(const LaneSweepKernel& kernel)
      : s_(kernel.sweep), scratch_(kernel.scratch), kernel_(kernel) {}

  /// Tests the last contacts again, in the middle of the intervals.
  HWY_INLINE LaneSweepKernel::Contact again() {
    ++scratch_.stamp;
    for (const Scratch::PastContact& last : scratch_.contacts) {
      if (last.pair < 0) break;
      const Sweep::Pair& pair = kernel_.pair(last.pair);
      if (!isAsked(pair)) continue;
      std::int32_t point = last.point;
      if (point < 0 && isOutOfReach(pair)) continue;
      const std::uint32_t lanes = point < 0
                                      ? contact(pair, kAll)
                                      : pointsInside(kernel_, pair, point, point + 1, kAll, point);
      if (lanes != 0) return kernel_.noteContact(last.pair, point, lanes);
    }
    return {};
  }

  /// Searches a contact of one pair by balls and all points.
  HWY_INLINE LaneSweepKernel::Contact one(std::int32_t number) {
    ++scratch_.stamp;
    const Sweep::Pair& pair = kernel_.pair(number);
    const std::uint32_t by_balls = contact(pair, kAll);
    if (by_balls != 0) return kernel_.noteContact(number, -1, by_balls);
    std::int32_t point = -1;
    const std::uint32_t lanes = inside(pair, point);
    return lanes != 0 ? kernel_.noteContact(number, point, lanes) : LaneSweepKernel::Contact{};
  }

  /// near: for each pair of parts, the lanes of `lanes` in which their balls are not proven to keep
  /// the threshold.
  HWY_INLINE void nearParts(std::int32_t number, std::uint32_t lanes, std::uint32_t* near) {
    const Sweep::Pair& whole = kernel_.pair(number);
    const float fixed = requiredGap(whole, whole.cover_above);
    const Sweep::Range of_a = s_.partsOfA(whole), of_b = s_.partsOfB(whole);
    for (int a = of_a.begin; a < of_a.end; ++a) {
      const float above = fixed + s_.pieces[size(a)].outer.radius;
      placePart(size(a));
      for (int b = of_b.begin; b < of_b.end; ++b, ++near) {
        scratch_.work.add(2 * kLaneBallWork);
        if (whole.pieces) {
          placePart(size(b));
          *near = openToBall<kStill>(scratch_.outer[size(a)], scratch_.outer[size(b)],
                                     above + s_.pieces[size(b)].outer.radius, lanes);
        } else {
          *near = openToObstacle<kStill>(kernel_.obstacle(whole, b), scratch_.outer[size(a)], above,
                                         lanes);
        }
      }
    }
  }

  /// Tests all pairs: returns a contact, or records the lanes that stay open.
  HWY_INLINE LaneSweepKernel::Contact all() {
    ++scratch_.stamp;
    scratch_.open.clear();
    scratch_.open_pairs.clear();
    scratch_.candidates.clear();
    scratch_.is_full = false;
    placeOuter();
    cull();
    if (met_.id >= 0) return met_;
    std::sort(scratch_.candidates.begin(), scratch_.candidates.end(),
              [](const Scratch::Candidate& x, const Scratch::Candidate& y) {
                return x.key < y.key || (x.key == y.key && x.pair < y.pair);
              });
    // For obstacles, inner balls are tested before covers, because a contact with one is usually
    // deep. Pairs of pieces usually miss, so the order is reversed below.
    for (const Scratch::Candidate& c : scratch_.candidates) {
      if (c.piece < 0) continue;
      const Sweep::LanePiece& a = s_.pieces[size(c.piece)];
      if (!(c.key <= a.inner_reach - a.outer.radius)) continue;
      const Sweep::Pair& pair = kernel_.pair(c.pair);
      if (pair.pieces || !isAsked(pair)) continue;
      const std::uint32_t lanes = contact(pair, c.lanes);
      if (lanes != 0) return kernel_.noteContact(c.pair, -1, lanes);
    }
    // Among many candidates, as in a dense cloud, the first ones are the deepest: if a piece is in
    // contact, its points show it there, before the others are tested.
    int tries = scratch_.candidates.size() > kManyCandidates ? kPointTries : 0;
    for (const Scratch::Candidate& c : scratch_.candidates) {
      const Sweep::Pair& pair = kernel_.pair(c.pair);
      if (!isAsked(pair)) continue;
      std::uint32_t open = c.lanes;
      // The plane that last separated the pair, in an earlier run, often does so again.
      const Scratch::Plane* plane = scratch_.planes.find(c.pair);
      if (plane != nullptr && plane->known)
        open = notSeparated<kStill>(kernel_, pair, *plane, open);
      if (open == 0) continue;
      open = uncovered(pair, open);
      if (open == 0) continue;
      if (pair.pieces) {
        const std::uint32_t lanes = contact(pair, open);
        if (lanes != 0) return kernel_.noteContact(c.pair, -1, lanes);
      }
      scratch_.open.push_back({pair.id, open});
      scratch_.open_pairs.push_back(c.pair);
      if (pair.pieces || tries-- <= 0) continue;
      std::int32_t point = -1;
      const std::uint32_t lanes = inside(pair, point);
      if (lanes != 0) return kernel_.noteContact(c.pair, point, lanes);
    }
    return {};
  }

 private:
  static std::size_t size(std::int32_t i) { return static_cast<std::size_t>(i); }

  /// The lanes in which a point of the pair's piece is inside its obstacle, and the point.
  HWY_INLINE std::uint32_t inside(const Sweep::Pair& pair, std::int32_t& point) {
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    const auto inside = [&](const Sweep::LanePiece::Points& points) {
      return pointsInside(kernel_, pair, points.begin, points.end, kAll, point);
    };
    const std::uint32_t lanes = inside(a.points);
    return lanes != 0 || a.fine.begin == a.points.begin ? lanes : inside(a.fine);
  }

  bool isAsked(const Sweep::Pair& pair) const { return (pair.kind & kernel_.asked.kinds) != 0; }

  const LaneFrame& frame(const Sweep::LanePiece& piece) const {
    return kernel_.frames[piece.frame];
  }
  float growthOf(int motion) const { return kStill || motion < 0 ? 0 : kernel_.growth[motion]; }

  HWY_INLINE void placeOuter() {
    const D d;
    for (std::size_t p = 0; p < s_.wholes; ++p) {
      const Sweep::LanePiece& piece = s_.pieces[p];
      if (piece.frame < 0) continue;
      Placed& placed = scratch_.outer[p];
      placeBall<kStill>(frame(piece), piece.outer.center, placed);
      const float radius = piece.outer.radius + growthOf(piece.motion) + kernel_.slack;
      V sum = hn::Zero(d);
      for (int k = 0; k < 3; ++k) {
        V low = hn::Set(d, 1e30f), high = hn::Set(d, -1e30f);
        for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
          const V c = hn::Load(d, placed.center[k].at + at);
          const V w = kStill ? hn::Zero(d) : hn::Abs(hn::Load(d, placed.way[k].at + at));
          const V end = hn::Add(c, w);
          low = hn::Min(low, hn::Sub(c, w));
          high = hn::Max(high, end);
          sum = hn::Add(sum, end);
        }
        scratch_.low[3 * p + static_cast<std::size_t>(k)] =
            hn::GetLane(hn::MinOfLanes(d, low)) - radius;
        scratch_.high[3 * p + static_cast<std::size_t>(k)] =
            hn::GetLane(hn::MaxOfLanes(d, high)) + radius;
      }
      // hn::Min() may have dropped NaN or infinity. NaN bounds then keep the piece near everything.
      if (hn::AllTrue(d, hn::Eq(hn::Sub(sum, sum), hn::Zero(d)))) continue;
      std::fill_n(&scratch_.low[3 * p], 3, std::numeric_limits<float>::quiet_NaN());
      std::fill_n(&scratch_.high[3 * p], 3, std::numeric_limits<float>::quiet_NaN());
    }
  }

  /// Computes the box around the sweeps of a group's pieces; NaN if one of them is NaN.
  HWY_INLINE void boundGroup(const Sweep::Group& group) {
    float* const low = &scratch_.low[3 * size(group.piece)];
    float* const high = &scratch_.high[3 * size(group.piece)];
    float sum = 0;
    std::fill_n(low, 3, kFar);
    std::fill_n(high, 3, -kFar);
    for (int i = group.begin; i < group.end; ++i) {
      const std::size_t p = 3 * size(s_.group_members[size(i)]);
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], scratch_.low[p + k]);
        high[k] = std::max(high[k], scratch_.high[p + k]);
        sum += scratch_.high[p + k];
      }
    }
    if (std::isfinite(sum)) return;
    std::fill_n(low, 3, std::numeric_limits<float>::quiet_NaN());
    std::fill_n(high, 3, std::numeric_limits<float>::quiet_NaN());
  }

  /// Whether all pairs of a bundle keep their thresholds, tested by the balls of the group.
  HWY_INLINE bool isApart(const Sweep::Bundle& bundle) {
    const std::size_t a = size(s_.groups[size(bundle.group)].piece), b = size(bundle.other);
    for (std::size_t k = 0; k < 3; ++k)
      if (scratch_.low[3 * a + k] - scratch_.high[3 * b + k] > bundle.above ||
          scratch_.low[3 * b + k] - scratch_.high[3 * a + k] > bundle.above)
        return true;
    float growth = 0;
    for (int i = bundle.motions_begin; i < bundle.motions_end; ++i) {
      const float more = growthOf(s_.bundle_motions[size(i)]);
      growth = std::isnan(growth) || growth >= more ? growth : more;  // NaN is kept
    }
    const float fixed = bundle.above + growth + 2 * kernel_.slack;
    const float above = fixed + s_.pieces[a].outer.radius + s_.pieces[b].outer.radius;
    scratch_.work.add(kLaneBallWork);
    if (openToBall<kStill>(scratch_.outer[a], scratch_.outer[b], above, kAll) == 0) return true;
    placeCover(a);
    return uncoveredPieces<true>(s_.pieces[a], b, fixed, kAll) == 0;
  }

  HWY_INLINE void cull() {
    for (const Sweep::Group& group : s_.groups) boundGroup(group);
    if (s_.world && (LaneSweep::kOfWorld & kernel_.asked.kinds) != 0) cullWorld();
    if (met_.id >= 0) return;
    for (const Sweep::Loose& loose : s_.loose_pairs) {
      const std::size_t a = size(s_.pairs[size(loose.pair)].a);
      if (!isApart(&scratch_.low[3 * a], &scratch_.high[3 * a], loose.low, loose.high))
        considerObstacle(a, loose.pair);
    }
    std::size_t next = 0;
    for (const Sweep::Bundle& bundle : s_.bundles) {
      next = size(bundle.end);
      if ((bundle.kind & kernel_.asked.kinds) == 0 || isApart(bundle)) continue;
      for (std::size_t i = size(bundle.begin); i < next; ++i) considerPieces(s_.piece_pairs[i]);
    }
    for (; next < s_.piece_pairs.size(); ++next) considerPieces(s_.piece_pairs[next]);
  }

  HWY_INLINE void cullWorld() {
    const ObstacleBoxes* const first = s_.boxes->first().get();
    for (std::size_t g = 0; g < s_.groups.size(); ++g)
      scratch_.group_near[g] = isNearObstacle(s_.groups[g]) ? 1 : 0;
    // Starts with the piece of the last contact, because it is likely to be in contact again, which
    // ends the pass.
    const std::int32_t last = rowOfLastContact();
    if (last >= 0) cullRow(s_.rows[size(last)], first);
    for (std::size_t row = 0; row < s_.rows.size() && met_.id < 0; ++row)
      if (static_cast<std::int32_t>(row) != last) cullRow(s_.rows[row], first);
  }

  /// The row of the pair that was last found in contact; -1 if it has none.
  std::int32_t rowOfLastContact() const {
    const std::int32_t in_world =
        scratch_.contacts[0].pair - static_cast<std::int32_t>(s_.pairs.size());
    return in_world < 0 ? -1 : in_world / static_cast<std::int32_t>(s_.places);
  }

  HWY_INLINE void cullRow(const LaneSweep::Row& row, const ObstacleBoxes* first) {
    const std::size_t p = size(row.piece);
    const Sweep::LanePiece& piece = s_.pieces[p];
    if (piece.group >= 0 && scratch_.group_near[size(piece.group)] == 0) return;
    float low[3], high[3];
    growBox(&scratch_.low[3 * p], &scratch_.high[3 * p], piece.row_above, low, high);
    if (first != nullptr) cullBoxes(p, low, high, *first, 0);
    cullBoxes(p, low, high, *s_.boxes, first != nullptr ? first->slots() : 0);
  }

  /// Whether two boxes are apart; false with NaN.
  static bool isApart(const float* low_a, const float* high_a, const float* low_b,
                      const float* high_b) {
    bool apart = false;
    for (int k = 0; k < 3; ++k) apart |= high_a[k] < low_b[k] || low_a[k] > high_b[k];
    return apart;
  }

  /// Grows a box, rounded outwards.
  static void growBox(const float* low, const float* high, float above, float* grown_low,
                      float* grown_high) {
    for (int k = 0; k < 3; ++k) {
      grown_low[k] = low[k] - above;
      grown_low[k] -= std::abs(grown_low[k]) * 0x1p-22f;
      grown_high[k] = high[k] + above;
      grown_high[k] += std::abs(grown_high[k]) * 0x1p-22f;
    }
  }

  /// Whether any box is near a group.
  HWY_INLINE bool isNearObstacle(const Sweep::Group& group) {
    float above = 0;
    for (int i = group.begin; i < group.end; ++i)
      above = std::max(above, s_.pieces[size(s_.group_members[size(i)])].row_above);
    float low[3], high[3];
    growBox(&scratch_.low[3 * size(group.piece)], &scratch_.high[3 * size(group.piece)], above, low,
            high);
    const ObstacleBoxes* const first = s_.boxes->first().get();
    return (first != nullptr && isNearBoxes(low, high, first->levels())) ||
           isNearBoxes(low, high, s_.boxes->levels());
  }
  bool isNearBoxes(const float* low, const float* high, std::span<const ObstacleBoxes::Level> of) {
    return !of.empty() && isNearBoxes(low, high, of.data(), of.size() - 1, 0, of.back().size());
  }
  /// Whether any of the boxes [begin, end) of a level is near.
  bool isNearBoxes(const float* low, const float* high, const ObstacleBoxes::Level* levels,
                   std::size_t level, std::size_t begin, std::size_t end) {
    const D d;
    end = std::min(end, levels[level].size());
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
      std::uint32_t near = nearBoxes(low, high, levels[level], i);
      if (level == 0 && near != 0) return true;
      for (std::size_t j = i; near != 0; near >>= 1U, ++j)
        if ((near & 1U) != 0 && isNearBoxes(low, high, levels, level - 1, ObstacleBoxes::kWidth * j,
                                            ObstacleBoxes::kWidth * (j + 1)))
          return true;
    }
    return false;
  }

  HWY_INLINE void cullBoxes(std::size_t p, const float* low, const float* high,
                            const ObstacleBoxes& boxes, std::size_t first_slot) {
    const auto levels = boxes.levels();
    if (levels.empty()) return;
    const WorldCull cull{p,
                         low,
                         high,
                         boxes,
                         first_slot,
                         s_.pieces[p].row_above + growthOf(s_.pieces[p].motion) + kernel_.slack,
                         s_.pieces[p].row_above + kernel_.slack};
    cullBoxes(cull, levels.size() - 1, 0, levels.back().size(), kAll);
  }

  /// A row's piece and the boxes of its world.
  struct WorldCull {
    std::size_t p;
    const float *low, *high;  // the box around the piece's sweep, grown
    const ObstacleBoxes& boxes;
    std::size_t first_slot;
    float above;  // lower bound on requiredGap() for every pair of the row
    // Upper bound on the gap at which a pair of the row is in contact in the middle of an interval.
    float below;
  };

  /// Tests boxes [begin, end) of a level by the box around the piece's sweep, and nodes also by its
  /// outer ball in `lanes`.
  void cullBoxes(const WorldCull& of, std::size_t level, std::size_t begin, std::size_t end,
                 std::uint32_t lanes) {
    const D d;
    const ObstacleBoxes::Level& boxes = of.boxes.levels()[level];
    end = std::min(end, boxes.size());  // NaN also meets nodes that are padding
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
      std::uint32_t near = nearBoxes(of.low, of.high, boxes, i);
      for (std::size_t j = i; near != 0; near >>= 1U, ++j) {
        if ((near & 1U) == 0) continue;
        if (level == 0) {
          considerObstacle(of.p, s_.pairOf(s_.pieces[of.p], of.first_slot + j), lanes);
          continue;
        }
        // NaN and infinity also meet nodes that are padding, which have no children.
        if (ObstacleBoxes::kWidth * j >= of.boxes.levels()[level - 1].size()) break;
        const Sweep::Core node = boxOf(boxes, j);
        scratch_.work.add(kLaneBallWork);
        const std::uint32_t open = openToObstacle<kStill>(
            node, scratch_.outer[of.p], of.above + s_.pieces[of.p].outer.radius, lanes);
        if (open == 0) continue;
        if (level == 1 && of.boxes.hasBallsAlone(j))
          cullBalls(of, j, node, open);
        else
          cullBoxes(of, level - 1, ObstacleBoxes::kWidth * j, ObstacleBoxes::kWidth * (j + 1),
                    open);
        if (met_.id >= 0) return;
      }
    }
  }

  /// A box of a level as a core. Halves of the ends are exact, and the sum and the difference each
  /// round by at most u times a coordinate. Nothing is rotated into the world's axes, so
  /// openToObstacle() stays within the rounding that lane_balls-inl.h derives.
  HWY_INLINE static Sweep::Core boxOf(const ObstacleBoxes::Level& boxes, std::size_t i) {
    Sweep::Core core{};
    core.aligned = true;
    for (int k = 0; k < 3; ++k) {
      const float low = 0.5F * boxes.low[k][i], high = 0.5F * boxes.high[k][i];
      core.center[k] = low + high;
      core.half[k] = high - low;
    }
    return core;
  }

  /// Tests the balls of a node of level 1 that contains only balls, in `lanes`: by the cover and
  /// the outer ball of the piece, first against the node's box. The pairs of the remaining balls
  /// are made when they are tested, because most never are.
  void cullBalls(const WorldCull& of, std::size_t node, const Sweep::Core& box,
                 std::uint32_t lanes) {
    const Sweep::LanePiece& piece = s_.pieces[of.p];
    placeCover(of.p);
    // The lanes in which each ball of the cover is near the node's box.
    std::uint32_t near_box[kCoverBalls];
    const int count = std::min(piece.inner - piece.cover, kCoverBalls);
    std::uint32_t open = 0;
    for (int i = 0; i < count; ++i) {
      const std::size_t ball = size(piece.cover + i);
      near_box[i] = openToObstacle<kStill>(box, scratch_.balls[ball],
                                           of.above + s_.balls[ball].radius, lanes);
      open |= near_box[i];
    }
    scratch_.work.add(count * kLaneBallWork);
    // The cover decides nothing here if it is empty or has more balls than were tested.
    const bool has_more = count == 0 || count < piece.inner - piece.cover;
    if (open == 0 && !has_more) return;
    const ObstacleBoxes::Level& balls = of.boxes.levels()[0];
    const std::size_t begin = ObstacleBoxes::kWidth * node;
    const D d;
    for (std::size_t i = begin; i < begin + ObstacleBoxes::kWidth; i += hn::Lanes(d)) {
      std::uint32_t near = nearBoxes(of.low, of.high, balls, i);
      for (std::size_t j = i; near != 0; near >>= 1U, ++j) {
        if ((near & 1U) == 0) continue;
        const std::int32_t number = s_.pairOf(piece, of.first_slot + j);
        if (number < 0) continue;
        if (has_more)
          considerObstacle(of.p, number, lanes);
        else
          considerBall(of, number, boxOf(balls, j), near_box, count);
        if (met_.id >= 0) return;
      }
    }
    near_balls_ += static_cast<int>(ObstacleBoxes::kWidth);
    if (near_balls_ >= kNearBalls && !has_searched_) meetWorld();
  }

  /// Searches a contact of any row with a ball of the world, by inner balls. In a dense cloud,
  /// thousands of balls are near the covers of a piece in contact, and of the pieces before it.
  void meetWorld() {
    has_searched_ = true;
    const ObstacleBoxes* const first = s_.boxes->first().get();
    for (const LaneSweep::Row& row : s_.rows) {
      const auto p = size(row.piece);
      const Sweep::LanePiece& piece = s_.pieces[p];
      if (piece.group >= 0 && scratch_.group_near[size(piece.group)] == 0) continue;
      placeInner(p);
      float low[3], high[3];
      growBox(&scratch_.low[3 * p], &scratch_.high[3 * p], piece.row_above, low, high);
      const auto meet = [&](const ObstacleBoxes& boxes, std::size_t first_slot) {
        const std::size_t levels = boxes.levels().size();
        if (levels < 2 || met_.id >= 0) return;
        const float below = piece.row_above + kernel_.slack;
        meetBoxes({p, low, high, boxes, first_slot, below, below}, levels - 1, 0,
                  boxes.levels().back().size());
      };
      if (first != nullptr) meet(*first, 0);
      meet(*s_.boxes, first != nullptr ? first->slots() : 0);
      if (met_.id >= 0) return;
    }
  }

  /// Searches a contact with the balls in the nodes [begin, end) of a level above 0.
  void meetBoxes(const WorldCull& of, std::size_t level, std::size_t begin, std::size_t end) {
    const D d;
    const ObstacleBoxes::Level& boxes = of.boxes.levels()[level];
    end = std::min(end, boxes.size());
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
      std::uint32_t near = nearBoxes(of.low, of.high, boxes, i);
      for (std::size_t j = i; near != 0; near >>= 1U, ++j) {
        if ((near & 1U) == 0) continue;
        if (ObstacleBoxes::kWidth * j >= of.boxes.levels()[level - 1].size()) break;
        if (!isNearInner(of, boxOf(boxes, j))) continue;
        if (level > 1)
          meetBoxes(of, level - 1, ObstacleBoxes::kWidth * j, ObstacleBoxes::kWidth * (j + 1));
        else if (of.boxes.hasBallsAlone(j))
          meetBalls(of, j);
        if (met_.id >= 0) return;
      }
    }
  }

  HWY_INLINE bool isNearInner(const WorldCull& of, const Sweep::Core& box) {
    const Sweep::LanePiece& piece = s_.pieces[of.p];
    for (int i = piece.inner; i < piece.end; ++i) {
      scratch_.work.add(kLaneBallWork);
      if (contactWithObstacle(box, scratch_.balls[size(i)], of.below + s_.balls[size(i)].radius) !=
          0)
        return true;
    }
    return false;
  }

  void meetBalls(const WorldCull& of, std::size_t node) {
    const ObstacleBoxes::Level& balls = of.boxes.levels()[0];
    const std::size_t begin = ObstacleBoxes::kWidth * node;
    for (std::size_t j = begin; j < begin + ObstacleBoxes::kWidth; ++j) {
      const std::int32_t number = s_.pairOf(s_.pieces[of.p], of.first_slot + j);
      if (number < 0) continue;
      meetBall(of, number, boxOf(balls, j), kAll);
      if (met_.id >= 0) return;
    }
  }

  /// Tests a ball of the world, given by its box, in the lanes in which the balls of the cover are
  /// near the node. The box is rounded outwards: half of its longest side is at least the radius,
  /// and its middle is within 4 u of a coordinate of the centre on each axis.
  HWY_INLINE void considerBall(const WorldCull& of, std::int32_t number, const Sweep::Core& box,
                               const std::uint32_t* near_box, int count) {
    const Sweep::Core point = middleOf(box);
    const float above = of.above + longestHalf(box);
    const Sweep::LanePiece& piece = s_.pieces[of.p];
    std::uint32_t open = 0;
    for (int i = 0; i < count; ++i) {
      const std::uint32_t lanes = near_box[i] & ~open;
      if (lanes == 0) continue;
      scratch_.work.add(kLaneBallWork);
      const std::size_t ball = size(piece.cover + i);
      open |=
          openToObstacle<kStill>(point, scratch_.balls[ball], above + s_.balls[ball].radius, lanes);
    }
    if (open == 0) return;
    float key;
    const float of_outer = above + piece.outer.radius;
    open = openToObstacle<kStill>(point, scratch_.outer[of.p], of_outer, open, &key);
    scratch_.work.add(kLaneBallWork);
    if (open == 0) return;
    meetBall(of, number, box, open);
    if (met_.id < 0) addCandidate({key - of_outer, number, -1, open});
  }

  static Sweep::Core middleOf(const Sweep::Core& box) {
    Sweep::Core point = box;
    std::fill_n(point.half, 3, 0.0F);
    return point;
  }
  static float longestHalf(const Sweep::Core& box) {
    return std::max(box.half[0], std::max(box.half[1], box.half[2]));
  }

  /// Records a contact by inner balls with a ball of the world, given by its box, if one comes near
  /// it.
  HWY_INLINE void meetBall(const WorldCull& of, std::int32_t number, const Sweep::Core& box,
                           std::uint32_t lanes) {
    const Sweep::LanePiece& piece = s_.pieces[of.p];
    const Sweep::Core point = middleOf(box);
    const float below = of.below + longestHalf(box);
    placeInner(of.p);
    for (int i = piece.inner; i < piece.end; ++i) {
      scratch_.work.add(kLaneBallWork);
      if ((lanes & contactWithObstacle(point, scratch_.balls[size(i)],
                                       below + s_.balls[size(i)].radius)) == 0)
        continue;
      const Sweep::Pair& pair = kernel_.pair(number);
      const std::uint32_t met = isAsked(pair) ? contact(pair, lanes) : 0;
      if (met != 0) met_ = kernel_.noteContact(number, -1, met);
      return;
    }
  }

  /// Tests an obstacle in the lanes of `among`.
  HWY_INLINE void considerObstacle(std::size_t p, std::int32_t number, std::uint32_t among = kAll) {
    if (number < 0) return;
    const Sweep::Pair& pair = kernel_.pair(number);
    if (!isAsked(pair)) return;
    const Sweep::Obstacle& o = kernel_.obstacle(pair);
    const Sweep::LanePiece& piece = s_.pieces[p];
    const float above = requiredGap(pair) + piece.outer.radius;
    float key;
    const std::uint32_t lanes = openToObstacle<kStill>(o, scratch_.outer[p], above, among, &key);
    scratch_.work.add(kLaneBallWork);
    if (lanes != 0 && !isProven(pair)) addCandidate({key - above, number, pair.a, lanes});
  }

  HWY_INLINE void considerPieces(std::int32_t number) {
    const Sweep::Pair& pair = kernel_.pair(number);
    if (!isAsked(pair)) return;
    const std::size_t a = size(pair.a), b = size(pair.b);
    for (std::size_t k = 0; k < 3; ++k)
      if (scratch_.low[3 * a + k] - scratch_.high[3 * b + k] > pair.free_above ||
          scratch_.low[3 * b + k] - scratch_.high[3 * a + k] > pair.free_above)
        return;
    const float above = requiredGap(pair) + s_.pieces[a].outer.radius + s_.pieces[b].outer.radius;
    float key;
    const std::uint32_t lanes =
        openToBall<kStill>(scratch_.outer[a], scratch_.outer[b], above, kAll, &key);
    scratch_.work.add(kLaneBallWork);
    if (lanes != 0 && !isProven(pair)) addCandidate({key - above, number, pair.a, lanes});
  }

  bool isProven(const Sweep::Pair& pair) const {
    const LaneSweep::Proofs* const proofs = kernel_.asked.proofs;
    return pair.has_proof && proofs != nullptr && proofs->keeps(pair.id);
  }

  /// There is room for all listed pairs.
  HWY_INLINE void addCandidate(const Scratch::Candidate& candidate) {
    if (scratch_.candidates.size() < scratch_.candidates.capacity())
      scratch_.candidates.push_back(candidate);
    else
      scratch_.is_full = true;
  }

  /// The gap that a pair's separation must exceed, in addition to the radii of pieces.
  float requiredGap(const Sweep::Pair& pair) const { return requiredGap(pair, pair.free_above); }
  float requiredGap(const Sweep::Pair& pair, float above) const {
    const float growth = growthOf(pair.motion);
    if (pair.pieces) return above + growth + 2 * kernel_.slack;
    return above + growth + kernel_.slack + kernel_.obstacle(pair).radius;
  }

  HWY_INLINE void placePart(std::size_t p) {
    if (scratch_.part_stamp[p] == scratch_.stamp) return;
    scratch_.part_stamp[p] = scratch_.stamp;
    const Sweep::LanePiece& piece = s_.pieces[p];
    if (piece.frame >= 0) placeBall<kStill>(frame(piece), piece.outer.center, scratch_.outer[p]);
  }

  HWY_INLINE void placeCover(std::size_t p) {
    if (scratch_.cover_stamp[p] == scratch_.stamp) return;
    scratch_.cover_stamp[p] = scratch_.stamp;
    const Sweep::LanePiece& piece = s_.pieces[p];
    scratch_.work.add((piece.inner - piece.cover) * kLaneBallWork);
    if (piece.frame < 0) return;
    for (int i = piece.cover; i < piece.inner; ++i)
      placeBall<kStill>(frame(piece), s_.balls[size(i)].center, scratch_.balls[size(i)]);
  }
  HWY_INLINE void placeInner(std::size_t p) {
    if (scratch_.inner_stamp[p] == scratch_.stamp) return;
    scratch_.inner_stamp[p] = scratch_.stamp;
    const Sweep::LanePiece& piece = s_.pieces[p];
    scratch_.work.add((piece.end - piece.inner) * kLaneBallWork);
    if (piece.frame < 0) return;
    for (int i = piece.inner; i < piece.end; ++i)
      placeBall<true>(frame(piece), s_.balls[size(i)].center, scratch_.balls[size(i)]);
  }

  /// Whether no inner ball of A can touch the obstacle in any lane, tested by the ball around them
  /// all.
  HWY_INLINE bool isOutOfReach(const Sweep::Pair& pair) {
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    if (pair.pieces || a.frame < 0 || !kernel_.obstacle(pair).exact) return false;
    placeBall<true>(frame(a), a.outer.center, scratch_.outer[size(pair.a)]);
    const Sweep::Obstacle& o = kernel_.obstacle(pair);
    const float below = pair.contact_below - kernel_.slack + o.radius + a.inner_reach;
    return contactWithObstacle(o, scratch_.outer[size(pair.a)], below) == 0;
  }

  /// Lanes of `lanes` in which inner balls prove that the threshold is not kept.
  HWY_INLINE std::uint32_t contact(const Sweep::Pair& pair, std::uint32_t lanes) {
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    if (a.inner == a.end) return 0;
    placeInner(size(pair.a));
    if (!pair.pieces && kernel_.obstacle(pair).exact) {
      const Sweep::Obstacle& o = kernel_.obstacle(pair);
      const float below = pair.contact_below - kernel_.slack + o.radius;
      for (int i = a.inner; i < a.end; ++i) {
        const std::uint32_t found = lanes & contactWithObstacle(o, scratch_.balls[size(i)],
                                                                below + s_.balls[size(i)].radius);
        if (found != 0) return found;
      }
      return 0;
    }
    if (pair.balls < 0) return 0;
    const Sweep::LanePiece& b = s_.pieces[size(pair.balls)];
    placeInner(size(pair.balls));
    const float below = pair.contact_below - 2 * kernel_.slack;
    for (int i = a.inner; i < a.end; ++i)
      for (int j = b.inner; j < b.end; ++j) {
        const std::uint32_t found =
            lanes & contactWithBall(scratch_.balls[size(i)], scratch_.balls[size(j)],
                                    below + s_.balls[size(i)].radius + s_.balls[size(j)].radius);
        if (found != 0) return found;
      }
    return 0;
  }

  /// Lanes of `lanes` in which some ball of the covers is not proven to keep the threshold.
  HWY_INLINE std::uint32_t uncovered(const Sweep::Pair& pair, std::uint32_t lanes) {
    placeCover(size(pair.a));
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    if (!pair.pieces) {
      const Sweep::Obstacle& o = kernel_.obstacle(pair);
      const float fixed = requiredGap(pair, pair.cover_above);
      std::uint32_t open = 0;
      for (int i = a.cover; i < a.inner && open != lanes; ++i)
        open |= openToObstacle<kStill>(o, scratch_.balls[size(i)], fixed + s_.balls[size(i)].radius,
                                       lanes & ~open);
      scratch_.work.add((a.inner - a.cover) * kLaneBallWork);
      if (open == 0 || pair.balls < 0) return open;
      lanes = open;
    }
    return uncoveredPieces(a, size(pair.balls),
                           pair.cover_above + growthOf(pair.motion) + 2 * kernel_.slack, lanes);
  }

  /// `kAny`: ends at the first open lanes and returns only these.
  template <bool kAny = false>
  HWY_INLINE std::uint32_t uncoveredPieces(const Sweep::LanePiece& a, std::size_t number,
                                           float fixed, std::uint32_t lanes) {
    placeCover(number);
    const Sweep::LanePiece& b = s_.pieces[number];
    std::uint32_t open = 0;
    for (int i = a.cover; i < a.inner && open != lanes; ++i) {
      if (kAny && open != 0) break;
      const Placed& ball = scratch_.balls[size(i)];
      const float above = fixed + s_.balls[size(i)].radius;
      scratch_.work.add(kLaneBallWork);
      const std::uint32_t near =
          openToBall<kStill>(ball, scratch_.outer[number], above + b.outer.radius, lanes & ~open);
      if (near == 0) continue;
      scratch_.work.add((b.inner - b.cover) * kLaneBallWork);
      for (int j = b.cover; j < b.inner && open != lanes; ++j)
        open |= openToBall<kStill>(ball, scratch_.balls[size(j)], above + s_.balls[size(j)].radius,
                                   near & ~open);
    }
    return open;
  }

  const Sweep& s_;
  Scratch& scratch_;
  const LaneSweepKernel& kernel_;
  LaneSweepKernel::Contact met_;  // found while boxes were culled; it ends the pass
  // Balls of the world that were compared with covers in this pass [count], and whether meetWorld()
  // was called, which it is once: after the first kNearBalls.
  static constexpr int kNearBalls = 512;
  int near_balls_ = 0;
  // With more candidates than this, the points of this many open pairs are tested early [count].
  static constexpr std::size_t kManyCandidates = 64;
  static constexpr int kPointTries = 4;
  bool has_searched_ = false;
};

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
