#include "planner/edge/contact_search.h"

#include <algorithm>

namespace leeway::planner {
namespace {

constexpr int kLooks = 3;  ///< checks in each of the two searches

/// contact_score of a pair that distance() has just found in contact. searchLikely() calls
/// distance() from this score on. A pair found by other means starts with a score of 1.
constexpr int kScoreOfExactContact = 2;

}  // namespace

ContactSearch::ContactSearch(EdgeFrames& frames, EdgeLanes& lanes, PairQueries& queries,
                             const collision::Work& work, EdgeMemory& memory)
    : frames_(frames), lanes_(lanes), queries_(queries), work_(work), memory_(memory) {
  likely_looks_.reserve(kLooks);
}

void ContactSearch::begin() {
  likely_looks_.clear();
  looks_ = 0;
}

void ContactSearch::remember(int pair) {
  PairMemory& known = memory_.of(pair);
  known.contact_score = std::max(known.contact_score, 1);
  known.lane_contact_score = 1;
}

std::optional<PairVerdict> ContactSearch::checkAt(int p, double t) {
  const int slot = frames_.place(t);
  if (slot < 0) return PairVerdict{Verdict::kUndecided, p, t};
  if (queries_.exactState(slot, frames_.pair(p)) == PairState::kNotFree) {
    memory_.of(p).contact_score = kScoreOfExactContact;
    return PairVerdict{Verdict::kNotFree, p, t};
  }
  --memory_.of(p).contact_score;
  return std::nullopt;
}

std::optional<PairVerdict> ContactSearch::searchLikely(const EdgeLanes::Parts& parts) {
  for (const collision::LaneSweep::Open& pair : lanes_.open()) {
    if (memory_.of(pair.id).lane_contact_score < 0) continue;
    if (likely_looks_.size() == kLooks || work_.isSpent()) break;
    const EdgeLanes::Parts::Range range = parts.rangeOf(pair.intervals);
    if (const std::optional<double> t = lanes_.findContact(pair.id, range.from, range.width))
      return PairVerdict{Verdict::kNotFree, pair.id, *t};
    --memory_.of(pair.id).lane_contact_score;
    const bool exact = memory_.of(pair.id).contact_score >= kScoreOfExactContact;
    likely_looks_.push_back({pair.id, range, exact});
    if (!exact) continue;
    if (const auto verdict = checkAt(pair.id, range.middle())) return verdict;
  }
  return std::nullopt;
}

std::optional<PairVerdict> ContactSearch::search(const EdgeLanes::Parts& parts) {
  for (const collision::LaneSweep::Open& pair : lanes_.open()) {
    // Pairs that are always near and hardly ever collide have a score below 0.
    if (pair.apart || memory_.of(pair.id).contact_score < 0) continue;
    if (looks_ >= kLooks || work_.isSpent()) break;
    const EdgeLanes::Parts::Range range = parts.rangeOf(pair.intervals);
    // Over an unchanged range, the checks of searchLikely() would fail again.
    const auto known =
        std::find_if(likely_looks_.begin(), likely_looks_.end(),
                     [&](const Look& look) { return look.pair == pair.id && look.range == range; });
    const bool is_known = known != likely_looks_.end();
    if (is_known && known->exact) continue;
    ++looks_;
    if (!is_known) {
      if (const std::optional<double> t = lanes_.findContact(pair.id, range.from, range.width))
        return PairVerdict{Verdict::kNotFree, pair.id, *t};
    }
    if (const auto verdict = checkAt(pair.id, range.middle())) return verdict;
  }
  return std::nullopt;
}

}  // namespace leeway::planner
