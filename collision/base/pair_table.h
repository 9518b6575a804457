#pragma once

// Private to the library: a table of fixed size with data about pairs or places.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "collision/base/spare_memory.h"

namespace leeway::collision {

/// One value for each pair, by its number. Up to kMost pairs have a place each. With more pairs,
/// several share a place, and a pair that replaces another starts with a new value. Use it only for
/// data that may be lost: hints, warm starts. The lost values depend only on the pairs that are
/// queried.
template <class T>
class PairTable {
 public:
  static constexpr std::size_t kMost = 1U << 11U;  ///< places [count]

  PairTable() = default;
  PairTable(const PairTable&) = delete;
  PairTable& operator=(const PairTable&) = delete;
  ~PairTable() { clear(); }

  /// Makes room for pairs [0, pairs), in at most `most` places (a power of two), and removes all
  /// values. This is the only function that allocates.
  void resize(std::size_t pairs, std::size_t most = kMost) {
    static_assert(alignof(Place) <= 64, "what takeMemory() aligns to");
    clear();
    has_begun_.assign(std::min(pairs, most), 0);
    is_shared_ = pairs > most;
    places_.reset(static_cast<Place*>(takeMemory(has_begun_.size() * sizeof(Place))));
  }

  /// Returns the value of a pair, or a new value if another pair has its place.
  T& of(std::int32_t pair) {
    return of(pair, [](std::int32_t) { return T(); });
  }
  /// As above; make(pair) is the new value.
  template <class Make>
  T& of(std::int32_t pair, const Make& make) {
    const std::size_t i = indexOf(pair);
    Place& place = places_.get()[i];
    if (has_begun_[i] == 0) {
      ::new (static_cast<void*>(&place)) Place{pair, make(pair)};
      has_begun_[i] = 1;
    } else if (place.pair != pair) {
      place = {pair, make(pair)};
    }
    return place.value;
  }
  /// Whether pairs share places. If not, a value is never lost.
  bool isShared() const { return is_shared_; }
  /// The value of a pair; null if none is stored.
  const T* find(std::int32_t pair) const {
    const std::size_t i = indexOf(pair);
    if (has_begun_[i] == 0) return nullptr;
    const Place& place = places_.get()[i];
    return place.pair == pair ? &place.value : nullptr;
  }

 private:
  struct Place {
    std::int32_t pair;
    T value;
  };
  std::size_t indexOf(std::int32_t pair) const {
    const auto number = static_cast<std::size_t>(pair);
    // A hash, because the numbers of one body's pairs differ by multiples of a row's length.
    return number < has_begun_.size()
               ? number
               : (number * 0x9e3779b97f4a7c15U >> 32U) & (has_begun_.size() - 1);
  }
  void clear() {
    if constexpr (!std::is_trivially_destructible_v<T>)
      for (std::size_t i = 0; i < has_begun_.size(); ++i)
        if (has_begun_[i] != 0) std::destroy_at(places_.get() + i);
    has_begun_.clear();
  }
  // Memory for all places. A place is initialized when a pair first uses it, because most are never
  // used.
  std::unique_ptr<Place, GiveBack> places_;
  std::vector<unsigned char> has_begun_;
  bool is_shared_ = false;
};

}  // namespace leeway::collision
