// The kernels of LaneSweep for each instruction set, and their dispatch.
//
// Each operation is rounded once (no fused multiply-add), every lane does the same operations, and
// decisions use masks of all kLanes intervals, so all instruction sets give the same answers.

#include <bit>
#include <cstddef>
#include <cstdint>

#include "collision/lanes/lane_sweep_impl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/lanes/lane_passes_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "collision/lanes/ball_pass-inl.h"
#include "collision/lanes/gilbert_planes-inl.h"
#include "collision/lanes/lane_planes-inl.h"
#include "collision/lanes/lane_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

LaneSweepKernel::Contact MeetAgain(const LaneSweepKernel& kernel) {
  return BallPass<true>(kernel).again();
}
LaneSweepKernel::Contact MeetPair(const LaneSweepKernel& kernel, std::int32_t pair) {
  return BallPass<true>(kernel).one(pair);
}
LaneSweepKernel::Contact SweepAll(const LaneSweepKernel& kernel) {
  return BallPass<false>(kernel).all();
}
LaneSweepKernel::Contact StillAll(const LaneSweepKernel& kernel) {
  return BallPass<true>(kernel).all();
}

std::uint32_t SweepPlane(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                         const Scratch::Plane& plane, std::uint32_t lanes) {
  return notSeparated<false>(kernel, pair, plane, lanes);
}
void SweepNearParts(const LaneSweepKernel& kernel, std::int32_t pair, std::uint32_t lanes,
                    std::uint32_t* near) {
  BallPass<false>(kernel).nearParts(pair, lanes, near);
}
void StillNearParts(const LaneSweepKernel& kernel, std::int32_t pair, std::uint32_t lanes,
                    std::uint32_t* near) {
  BallPass<true>(kernel).nearParts(pair, lanes, near);
}
void SweepOwnPlanes(const LaneSweepKernel& kernel, const Sweep::Pair& pair, std::uint32_t lanes,
                    LaneSweepKernel::OwnPlanes& planes) {
  GilbertPlanes<false>(kernel, pair).run(lanes, planes);
}
void StillOwnPlanes(const LaneSweepKernel& kernel, const Sweep::Pair& pair, std::uint32_t lanes,
                    LaneSweepKernel::OwnPlanes& planes) {
  GilbertPlanes<true>(kernel, pair).run(lanes, planes);
}
std::uint32_t PointsInside(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                           const Sweep::LanePiece::Points& points, std::uint32_t lanes,
                           std::int32_t& point) {
  return pointsInside(kernel, pair, points.begin, points.end, lanes, point);
}
std::uint32_t StillPlane(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                         const Scratch::Plane& plane, std::uint32_t lanes) {
  return notSeparated<true>(kernel, pair, plane, lanes);
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {
namespace {

/// Limit on the planes that are searched for a pair, one after the other as long as each separates
/// a lane [count].
constexpr int kPlaneTries = 3;

/// The median of the lanes.
int middleOf(std::uint32_t lanes) {
  int half = (std::popcount(lanes) - 1) / 2, lane = 0;
  while ((lanes >> lane & 1U) == 0 || half-- > 0) ++lane;
  return lane;
}

}  // namespace

HWY_EXPORT(MeetAgain);
HWY_EXPORT(MeetPair);
HWY_EXPORT(SweepAll);
HWY_EXPORT(StillAll);
HWY_EXPORT(SweepPlane);
HWY_EXPORT(StillPlane);
HWY_EXPORT(PointsInside);
HWY_EXPORT(SweepOwnPlanes);
HWY_EXPORT(SweepNearParts);
HWY_EXPORT(StillNearParts);
HWY_EXPORT(StillOwnPlanes);

LaneSweepKernel::Separation LaneSweepKernel::separateByOwnPlanes(const Sweep::Pair& pair,
                                                                 Scratch::Memory memory,
                                                                 std::uint32_t lanes) const {
  OwnPlanes planes;
  if (growth == nullptr)
    HWY_DYNAMIC_DISPATCH(StillOwnPlanes)(*this, pair, lanes, planes);
  else
    HWY_DYNAMIC_DISPATCH(SweepOwnPlanes)(*this, pair, lanes, planes);
  if (planes.open != lanes) remember(pair, planes, middleOf(lanes & ~planes.open), *memory.plane);
  Separation found{planes.open, false, false};
  if (planes.open == 0) return found;
  if (growth != nullptr) HWY_DYNAMIC_DISPATCH(StillOwnPlanes)(*this, pair, found.open, planes);
  found.apart = planes.open == 0;
  found.touching = planes.touching != 0;
  return found;
}

bool LaneSweepKernel::separateByQueries(const Sweep::Pair& pair, Scratch::Memory memory,
                                        bool closely, std::uint32_t& lanes) const {
  bool apart = false;
  for (int look = 0; look < kPlaneTries && lanes != 0; ++look) {
    Scratch::Plane plane{};
    apart = findPlane(pair, middleOf(lanes), closely, plane, memory.search);
    if (!apart) break;
    const std::uint32_t left = growth == nullptr
                                   ? HWY_DYNAMIC_DISPATCH(StillPlane)(*this, pair, plane, lanes)
                                   : HWY_DYNAMIC_DISPATCH(SweepPlane)(*this, pair, plane, lanes);
    if (left == lanes && closely) break;
    closely = closely || left == lanes;
    if (left != lanes) *memory.plane = plane;
    lanes = left;
  }
  return apart;
}

LaneSweepKernel::Separation LaneSweepKernel::separatePair(const Sweep::Pair& pair,
                                                          Scratch::Memory memory,
                                                          std::uint32_t lanes, bool closely) const {
  Separation found{lanes, false, false};
  if (pair.own_plane_above >= 0) found = separateByOwnPlanes(pair, memory, lanes);
  // A piece that touches the box around a hull may still be apart from the hull itself.
  const bool touching = found.touching && (!pair.by_parts || obstacle(pair).exact);
  if (pair.plane_above >= 0 && !found.apart && !touching)
    found.apart = separateByQueries(pair, memory, closely, found.open);
  return found;
}

LaneSweepKernel::Separation LaneSweepKernel::separateParts(const Sweep::Pair& pair,
                                                           Scratch::PartMemory& memory,
                                                           std::uint32_t lanes,
                                                           bool closely) const {
  if (memory.plane.known) {
    lanes = growth == nullptr ? HWY_DYNAMIC_DISPATCH(StillPlane)(*this, pair, memory.plane, lanes)
                              : HWY_DYNAMIC_DISPATCH(SweepPlane)(*this, pair, memory.plane, lanes);
    if (lanes == 0) return {0, true, false};
  }
  return separatePair(pair, {&memory.plane, &memory.search}, lanes, closely);
}

LaneSweepKernel::Separation LaneSweepKernel::separateByParts(std::int32_t number,
                                                             std::uint32_t lanes,
                                                             bool closely) const {
  const Sweep::Pair& pair = this->pair(number);
  const Sweep::Range a = sweep.partsOfA(pair), b = sweep.partsOfB(pair);
  Scratch::PartMemory* const memory = scratch.partsOf(pair, sweep.most_parts);
  Sweep::Pair of_parts = pair;
  std::uint32_t near[Sweep::kMostPartPairs];
  if (growth == nullptr)
    HWY_DYNAMIC_DISPATCH(StillNearParts)(*this, number, lanes, near);
  else
    HWY_DYNAMIC_DISPATCH(SweepNearParts)(*this, number, lanes, near);
  Separation all{0, true, false};
  const std::int32_t count = pair.parts;
  std::int32_t& blocking = scratch.part_hints.of(number).blocking;
  // Starts with the pair of parts that was last open, because if it is open again, the others do
  // not matter.
  const std::int32_t first = blocking;
  for (std::int32_t k = 0; k < count && all.open != lanes; ++k) {
    if (scratch.work.isSpent()) return {lanes, false, false};
    const std::int32_t part = k == 0 ? first : k <= first ? k - 1 : k;
    const std::uint32_t left = near[part] & ~all.open;
    if (left == 0) continue;
    of_parts.a = a.begin + part / b.size();
    of_parts.b = b.begin + part % b.size();
    const Separation one = separateParts(of_parts, memory[part], left, closely);
    if (one.open == 0) continue;
    all.open |= one.open;
    all.apart = all.apart && one.apart;
    blocking = part;
  }
  return all;
}

LaneSweep::Contact LaneSweepKernel::contactOfOpen() const {
  for (std::size_t i = 0; i < scratch.open.size(); ++i) {
    const std::int32_t number = scratch.open_pairs[i];
    const Sweep::Pair& pair = this->pair(number);
    std::int32_t point = -1;
    const std::uint32_t met = HWY_DYNAMIC_DISPATCH(PointsInside)(
        *this, pair, sweep.pieces[static_cast<std::size_t>(pair.a)].points,
        scratch.open[i].intervals, point);
    if (met != 0) return noteContact(number, point, met);
  }
  return {};
}

LaneSweep::Contact LaneSweepKernel::separateOpen(bool closely) const {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < scratch.open.size(); ++i) {
    const std::int32_t number = scratch.open_pairs[i];
    const Sweep::Pair& pair = this->pair(number);
    const Sweep::LanePiece& a = sweep.pieces[static_cast<std::size_t>(pair.a)];
    std::uint32_t lanes = scratch.open[i].intervals;
    if (scratch.work.isSpent()) {
      scratch.open_pairs[kept] = number;
      scratch.open[kept++] = {pair.id, lanes, false};
      continue;
    }
    Separation found{lanes, false, false};
    Scratch::PartHint& hint = scratch.part_hints.of(number);
    if (!hint.by_parts) found = separatePair(pair, scratch.memoryOf(number), lanes, closely);
    if (found.open != 0 && !found.apart && pair.parts > 0) {
      const std::uint32_t before = found.open;
      found = separateByParts(number, before, closely);
      hint.by_parts = before == lanes && found.open != lanes;
    }
    lanes = found.open;
    if (lanes == 0) continue;
    if (!found.apart && a.fine.begin != a.points.begin) {
      std::int32_t point = -1;
      const std::uint32_t met =
          HWY_DYNAMIC_DISPATCH(PointsInside)(*this, pair, a.fine, lanes, point);
      if (met != 0) return noteContact(number, point, met);
    }
    scratch.open_pairs[kept] = number;
    scratch.open[kept++] = {pair.id, lanes, found.apart};
  }
  scratch.open.resize(kept);
  scratch.open_pairs.resize(kept);
  return {};
}

LaneSweep::Contact LaneSweep::meetAgain(std::span<const LaneFrame> frames, float slack,
                                        Scratch& scratch, std::uint8_t kinds) const {
  return HWY_DYNAMIC_DISPATCH(MeetAgain)(
      {*impl_, *scratch.impl_, frames.data(), nullptr, slack, {kinds, nullptr}});
}

LaneSweep::Contact LaneSweep::meet(int pair, std::span<const LaneFrame> frames, float slack,
                                   Scratch& scratch) const {
  return HWY_DYNAMIC_DISPATCH(MeetPair)({*impl_, *scratch.impl_, frames.data(), nullptr, slack},
                                        pair);
}

LaneSweep::Contact LaneSweep::run(std::span<const LaneFrame> frames, std::span<const float> growth,
                                  float slack, Scratch& scratch, const Asked& asked) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), growth.data(), slack, asked};
  const Contact contact = HWY_DYNAMIC_DISPATCH(SweepAll)(kernel);
  return contact.id < 0 ? kernel.contactOfOpen() : contact;
}

LaneSweep::Contact LaneSweep::separate(std::span<const LaneFrame> frames,
                                       std::span<const float> growth, float slack,
                                       Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), growth.data(), slack};
  ++scratch.impl_->stamp;  // other passes may have placed balls in other intervals since run()
  return kernel.separateOpen(false);
}

LaneSweep::Contact LaneSweep::runPairs(std::span<const Open> pairs,
                                       std::span<const LaneFrame> frames,
                                       std::span<const float> growth, float slack,
                                       Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), growth.data(), slack};
  ++scratch.impl_->stamp;
  scratch.impl_->open.clear();
  scratch.impl_->open_pairs.clear();
  for (const auto& [number, lanes, apart] : pairs) {
    const Impl::Pair& pair = kernel.pair(number);
    const Scratch::Impl::Plane* plane = scratch.impl_->planes.find(number);
    const std::uint32_t open = plane != nullptr && plane->known
                                   ? HWY_DYNAMIC_DISPATCH(SweepPlane)(kernel, pair, *plane, lanes)
                                   : lanes;
    if (open == 0) continue;
    scratch.impl_->open.push_back({pair.id, open});
    scratch.impl_->open_pairs.push_back(number);
  }
  const Contact contact = kernel.contactOfOpen();
  return contact.id < 0 ? kernel.separateOpen(true) : contact;
}

LaneSweep::Contact LaneSweep::runStill(std::span<const LaneFrame> frames, float slack,
                                       Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), nullptr, slack};
  Contact contact = HWY_DYNAMIC_DISPATCH(StillAll)(kernel);
  // A deep contact in any pair ends the run, so it is searched before planes.
  if (contact.id < 0) contact = kernel.contactOfOpen();
  return contact.id < 0 ? kernel.separateOpen(false) : contact;
}

}  // namespace leeway::collision
#endif  // HWY_ONCE
