// The search for contacts along an edge. Most edges that a planner asks are not free, and one
// configuration in contact proves that for far less than bounds that fail everywhere near it. Which
// pairs are looked at is learned from edges before: see contact_score.

#include <algorithm>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {
namespace {

/// contact_score of a pair that distance() has just found in contact: searchLikelyContacts() asks
/// distance() from this on, and a pair found otherwise, with a score of 1, has to earn it.
constexpr int kScoreOfExactContact = 2;

}  // namespace

std::pair<double, double> EdgeCertifier::Impl::rangeOf(const EdgeLanes::Parts& parts,
                                                       std::uint32_t open_lanes) {
  double from = 1, to = 0;  // parts need not stand in the order of time
  for (int lane = 0; lane < collision::kLanes; ++lane) {
    if ((open_lanes >> lane & 1U) == 0) continue;
    from = std::min(from, parts.from[lane]);
    to = std::max(to, parts.from[lane] + parts.width);
  }
  return {from, to - from};
}

std::optional<EdgeCheck> EdgeCertifier::Impl::checkContactAt(int p, double t) {
  const int slot = frames.place(t);
  if (slot < 0) return makeCheck(Verdict::kUndecided, p, t);
  if (exactState(slot, frames.pair(p)) == PairState::kNotFree) {
    pair_memory.of(p).contact_score = kScoreOfExactContact;
    return makeCheck(Verdict::kNotFree, p, t);
  }
  --pair_memory.of(p).contact_score;
  return std::nullopt;
}

std::optional<EdgeCheck> EdgeCertifier::Impl::searchLikelyContacts(const EdgeLanes::Parts& parts) {
  likely_looks.clear();
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if (pair_memory.of(pair.id).lane_contact_score < 0) continue;
    if (likely_looks.size() == kContactLooks || work.isSpent()) break;
    const auto [from, width] = rangeOf(parts, pair.lanes);
    if (const std::optional<double> t = lanes.findContact(pair.id, from, width))
      return makeCheck(Verdict::kNotFree, pair.id, *t);
    --pair_memory.of(pair.id).lane_contact_score;
    const bool exact = pair_memory.of(pair.id).contact_score >= kScoreOfExactContact;
    likely_looks.push_back({pair.id, from, width, exact});
    if (!exact) continue;
    if (const auto check = checkContactAt(pair.id, from + width / 2)) return check;
  }
  return std::nullopt;
}

std::optional<EdgeCheck> EdgeCertifier::Impl::searchContacts(const EdgeLanes::Parts& parts) {
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    // Pairs that are always near and hardly ever collide have a score below 0.
    if (pair.apart || pair_memory.of(pair.id).contact_score < 0) continue;
    if (contact_looks >= kContactLooks || work.isSpent()) break;
    const auto [from, width] = rangeOf(parts, pair.lanes);
    // Over an unchanged range the looks of searchLikelyContacts() would find nothing again.
    const auto known =
        std::find_if(likely_looks.begin(), likely_looks.end(),
                     [&, from = from, width = width](const ContactLook& look) {
                       return look.pair == pair.id && look.from == from && look.width == width;
                     });
    const bool is_known = known != likely_looks.end();
    if (is_known && known->exact) continue;
    ++contact_looks;
    if (!is_known) {
      if (const std::optional<double> t = lanes.findContact(pair.id, from, width))
        return makeCheck(Verdict::kNotFree, pair.id, *t);
    }
    if (const auto check = checkContactAt(pair.id, from + width / 2)) return check;
  }
  return std::nullopt;
}

std::optional<EdgeCheck> EdgeCertifier::Impl::checkContainment() {
  // A pair that balls or planes parted anywhere is apart there, and cannot come to be one inside
  // the other without a meeting of surfaces.
  int end = -1;
  for (const int p : never_parted) {
    if (std::find(open_pairs.begin(), open_pairs.end(), p) == open_pairs.end()) continue;
    if (end < 0) end = frames.place(1);
    if (end < 0) return makeCheck(Verdict::kUndecided, p, 1);
    const PairState state = exactState(end, frames.pair(p));
    if (state == PairState::kNotFree) return makeCheck(Verdict::kNotFree, p, 1);
    if (state == PairState::kOpen) return makeCheck(Verdict::kUndecided, p, 1);
  }
  return std::nullopt;
}

std::optional<EdgeCheck> EdgeCertifier::Impl::checkEnd(const EdgeInterval& interval) {
  if (interval.t0 + interval.h < 1) return std::nullopt;
  for (int i = interval.begin; i < interval.end; ++i) {
    const int p = open_pairs[at(i)];
    if (pair_memory.of(p).sweep_failed != interval_stamp || pair_memory.of(p).end_checked == edge)
      continue;
    pair_memory.of(p).end_checked = edge;
    const PairState state = exactState(interval.slot1, frames.pair(p));
    if (state == PairState::kNotFree) return makeCheck(Verdict::kNotFree, p, 1);
    if (state == PairState::kOpen) return makeCheck(Verdict::kUndecided, p, 1);
  }
  return std::nullopt;
}

std::optional<EdgeCheck> EdgeCertifier::Impl::checkMiddle(const EdgeInterval& interval, int slot) {
  for (int i = interval.begin; i < interval.end; ++i) {
    const int p = open_pairs[at(i)];
    const EdgePair& pair = frames.pair(p);
    PairState state = coarseState(slot, pair);
    // Where a sweep has just failed the pair is near enough to be asked exactly. A contact is found
    // within few nodes; that there is none, the halves have to prove anyway.
    if (state == PairState::kOpen && pair_memory.of(p).sweep_failed == interval_stamp &&
        !work.isSpent())
      state = exactState(slot, pair, kContactNodes);
    if (state == PairState::kNotFree)
      return makeCheck(Verdict::kNotFree, p, interval.t0 + interval.h / 2);
  }
  return std::nullopt;
}

}  // namespace leeway::planner
