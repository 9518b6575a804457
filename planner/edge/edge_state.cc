// One configuration against the margins: as an edge without length by lanes. If these do not
// decide, by coarse bounds, then by distance().

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

EdgeCertifier::Impl::Near EdgeCertifier::Impl::nearPairs(int slot, double reach) {
  const std::span<const int> anywhere = frames.edges().near_anywhere;
  if (frames.edges().areAllNear()) return {anywhere, true};
  near_pairs.assign(anywhere.begin(), anywhere.end());
  bool has_room = true;
  for (std::size_t row = 0; row < frames.pairs().rows().size(); ++row)
    has_room = frames.nearInRow(row, slot, reach, near_pairs) && has_room;
  std::sort(near_pairs.begin(), near_pairs.end());
  return {near_pairs, has_room};
}

std::optional<Verdict> EdgeCertifier::Impl::decideByLanes() {
  if (!lanes.begin(frames)) return std::nullopt;
  if (lanes.sweep(frames, asked).id >= 0) return Verdict::kNotFree;
  if (lanes.isFull()) return std::nullopt;
  lanes.closeGaps(frames, asked);
  if (!lanes.open().empty() && lanes.searchPlanes().id >= 0) return Verdict::kNotFree;
  if (lanes.open().empty()) return Verdict::kFree;
  return std::nullopt;
}

Verdict EdgeCertifier::Impl::checkState(int slot, double t, int& offender) {
  if (frames.pairs().empty()) return Verdict::kFree;
  // Balls come first, for all pairs, because most collisions are deep. The last contact is likely
  // to be the next.
  const auto [near, are_all] = nearPairs(slot, beyondMargins());
  if (!are_all) return Verdict::kUndecided;
  const auto count = static_cast<int>(near.size());
  const int first = last_contact;
  asked_pairs.clear();
  for (int i = -1; i < count; ++i) {
    const int p = i < 0 ? first : near[at(i)];
    if (i < 0 ? first < 0 : p == first) continue;
    if (!asked.has(frames.pair(p))) continue;
    const PairState coarse = queries.coarseState(slot, frames.pair(p));
    if (coarse == PairState::kFree) continue;
    if (coarse == PairState::kNotFree) {
      offender = last_contact = p;
      return Verdict::kNotFree;
    }
    asked_pairs.push_back(p);
  }
  Verdict verdict = Verdict::kFree;
  for (const int p : asked_pairs) {
    const EdgePair& pair = frames.pair(p);
    if (frames.keepsGap(pair, asked.thresholdOf(pair), t, t)) continue;
    const PairState exact = queries.exactState(slot, pair);
    if (exact == PairState::kFree) continue;
    offender = p;
    if (exact == PairState::kNotFree) {
      last_contact = p;
      return Verdict::kNotFree;
    }
    verdict = Verdict::kUndecided;
  }
  return verdict;
}

}  // namespace leeway::planner
