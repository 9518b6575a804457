// The pairs of a scene: a list, and a table of moving geometries with fixed ones.

#include "leeway/collision/scene_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"

namespace leeway::collision {
namespace {

double grown(double margin, double growth) { return std::max(margin, 0.0) + growth; }

/// A pair with a margin of NaN is never free. A value of 0 shows that there is one, and is
/// cautious.
double knownOr0(double margin) { return std::isnan(margin) ? 0.0 : margin; }

}  // namespace

std::size_t ScenePairs::Exceptions::slotOf(std::uint64_t key) const {
  const std::size_t mask = entries_.size() - 1;
  std::size_t slot = static_cast<std::size_t>((key * 0x9e3779b97f4a7c15U) >> 32U) & mask;
  while (entries_[slot].key != key && entries_[slot].key != kFree) slot = (slot + 1) & mask;
  return slot;
}

const ScenePairs::Exceptions::Entry* ScenePairs::Exceptions::find(std::uint64_t key) const {
  if (entries_.empty()) return nullptr;
  const Entry& entry = entries_[slotOf(key)];
  return entry.key == key ? &entry : nullptr;
}

ScenePairs::Exceptions::Entry& ScenePairs::Exceptions::of(std::uint64_t key) {
  if (2 * (count_ + 1) > entries_.size()) enlarge();
  Entry& entry = entries_[slotOf(key)];
  if (entry.key == kFree) {
    entry.key = key;
    ++count_;
  }
  return entry;
}

void ScenePairs::Exceptions::enlarge() {
  std::vector<Entry> before(std::max<std::size_t>(8, 2 * entries_.size()));
  before.swap(entries_);
  for (const Entry& entry : before)
    if (entry.key != kFree) entries_[slotOf(entry.key)] = entry;
}

ScenePairs::Found ScenePairs::findException(const Place& of) const {
  const Row& row = rows_[of.row];
  if (isCleared(of.place)) return {false, row.margin};
  const Exceptions::Entry* const entry = exceptions_.find(keyOf(of));
  if (entry == nullptr) return {!row.is_sparse, row.margin};
  return {entry->has_pair, entry->has_margin ? entry->margin : row.margin};
}

ScenePair ScenePairs::inTable(const Place& of) const {
  const Row& row = rows_[of.row];
  const Geometry still = geometryIn(of.place);
  return {row.body, row.geometry, still.body, still.geometry, find(of).margin};
}

double ScenePairs::leastMargin(int first_body, bool with) const {
  double least = kInfinity;
  for (const ScenePair& pair : listed_)
    if ((std::max(pair.body_a, pair.body_b) >= first_body) == with)
      least = std::min(least, knownOr0(pair.margin));
  // All pairs of the table have a body from first_still_ on.
  if (with == (first_still_ >= first_body))
    for (const Row& row : rows_) least = std::min(least, row.least);
  return least;
}

double ScenePairs::mostMargin() const {
  double margin = -kInfinity;
  for (const ScenePair& pair : listed_) margin = greatest(margin, pair.margin);
  for (const Row& row : rows_) margin = greatest(margin, row.most);
  return margin;
}

void ScenePairs::count() {
  // First counts the pairs that have their row's margin.
  for (Row& row : rows_) {
    row.count = row.is_sparse ? 0 : places_ - cleared_places_;
    row.least = kInfinity;
    row.most = -kInfinity;
  }
  std::vector<std::size_t> named(exceptions_.empty() ? 0 : rows_.size(), 0);
  exceptions_.forEach([&](const Exceptions::Entry& entry) {
    const Place of{static_cast<std::size_t>(entry.key >> 32U),
                   static_cast<std::size_t>(entry.key & 0xffffffffU)};
    if (of.row == kAllRows) return;
    if (isCleared(of.place)) return;
    Row& row = rows_[of.row];
    if (!row.is_sparse) --row.count;
    if (!entry.has_pair) return;
    ++named[of.row];
    const double margin = entry.has_margin ? entry.margin : row.margin;
    row.least = std::min(row.least, knownOr0(margin));
    row.most = greatest(row.most, margin);
  });
  in_table_ = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (row.count > 0) {
      row.least = std::min(row.least, knownOr0(row.margin));
      row.most = greatest(row.most, row.margin);
    }
    if (!named.empty()) row.count += named[i];
    in_table_ += row.count;
  }
}

void ScenePairs::clearPlace(std::size_t place) {
  Exceptions::Entry& entry = exceptions_.of(keyOf({kAllRows, place}));
  cleared_places_ += entry.has_pair ? 1 : 0;
  entry.has_pair = false;
}

void ScenePairs::restorePlace(std::size_t place) {
  Exceptions::Entry& entry = exceptions_.of(keyOf({kAllRows, place}));
  cleared_places_ -= entry.has_pair ? 0 : 1;
  entry.has_pair = true;
}

bool ScenePairs::isCleared(std::size_t place) const {
  if (cleared_places_ == 0) return false;
  const Exceptions::Entry* const entry = exceptions_.find(keyOf({kAllRows, place}));
  return entry != nullptr && !entry->has_pair;
}

void ScenePairs::set(const Place& of, std::optional<double> margin) {
  const Row& row = rows_[of.row];
  if (isUsual(row, margin) && exceptions_.find(keyOf(of)) == nullptr) return;
  Exceptions::Entry& entry = exceptions_.of(keyOf(of));
  entry.has_pair = entry.has_margin = margin.has_value();
  entry.margin = margin.value_or(0);
}

void ScenePairs::raise(double margin, int first_body) {
  const auto raised = [&](double& m) { m = std::max(m, margin); };  // NaN is kept
  for (ScenePair& pair : listed_)
    if (std::max(pair.body_a, pair.body_b) >= first_body) raised(pair.margin);
  // All pairs of the table have a body from first_still_ on; callers select all of these or more.
  for (Row& row : rows_) raised(row.margin);
  exceptions_.forEach([&](Exceptions::Entry& entry) { raised(entry.margin); });
  count();
}

void ScenePairs::grow(int body, int geometry, double growth, std::size_t first_place) {
  for (ScenePair& pair : listed_)
    if ((pair.body_a == body && pair.geometry_a == geometry) ||
        (pair.body_b == body && pair.geometry_b == geometry))
      pair.margin = grown(pair.margin, growth);
  if (rows_.empty()) return;
  if (body < first_still_) {
    const auto isOf = [&](std::size_t row) {
      return row < rows_.size() && rows_[row].body == body && rows_[row].geometry == geometry;
    };
    for (std::size_t row = 0; row < rows_.size(); ++row)
      if (isOf(row)) rows_[row].margin = grown(rows_[row].margin, growth);
    exceptions_.forEach([&](Exceptions::Entry& entry) {
      if (isOf(static_cast<std::size_t>(entry.key >> 32U)))
        entry.margin = grown(entry.margin, growth);
    });
  } else {
    const std::size_t place = first_place + static_cast<std::size_t>(geometry);
    for (std::size_t row = 0; row < rows_.size(); ++row)
      if (const Found found = find({row, place}); found.has_pair)
        setMargin({row, place}, grown(found.margin, growth));
  }
  count();
}

void ScenePairs::keep(const std::function<bool(const ScenePair&)>& keeps) {
  std::erase_if(listed_, [&](const ScenePair& pair) { return !keeps(pair); });
  const ScenePairs before = *this;
  rows_.clear();
  exceptions_ = {};
  cleared_places_ = 0;
  std::vector<char> is_kept(places_);
  for (std::size_t r = 0; r < before.rows_.size(); ++r) {
    std::size_t kept = 0;
    for (std::size_t place = 0; place < places_; ++place) {
      is_kept[place] = before.find({r, place}).has_pair && keeps(before.inTable({r, place}));
      kept += static_cast<std::size_t>(is_kept[place]);
    }
    if (kept == 0) continue;
    Row row = before.rows_[r];
    row.is_sparse = kept < places_ / 2;
    rows_.push_back(row);
    for (std::size_t place = 0; place < places_; ++place) {
      const Place of{rows_.size() - 1, place};
      if (is_kept[place] == 0) {
        if (!row.is_sparse) leaveOut(of);
      } else if (const double margin = before.find({r, place}).margin;
                 row.is_sparse || margin != row.margin) {
        setMargin(of, margin);
      }
    }
  }
  if (rows_.empty()) {
    places_ = 0;
    first_still_ = 0;
    geometries_.clear();
  }
  count();
}

}  // namespace leeway::collision
