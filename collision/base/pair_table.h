#pragma once

// Private to the library: what is remembered of pairs or places, in a table of fixed size.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "collision/base/spare_memory.h"

namespace leeway::collision {

/// One value a pair, by its number. Up to kMost pairs have a place each; more share places, and a
/// pair that comes to the place of another finds a new value there. So it is for what may be
/// forgotten: hints, warm starts. What is forgotten depends on the pairs that are asked for alone.
template <class T>
class PairTable {
 public:
  static constexpr std::size_t kMost = 1U << 11U;  ///< places [count]

  PairTable() = default;
  PairTable(const PairTable&) = delete;
  PairTable& operator=(const PairTable&) = delete;
  ~PairTable() { clear(); }

  /// Room for pairs [0, pairs), in `most` places at most: a power of two. Nothing is known of any.
  /// The only one that allocates.
  void resize(std::size_t pairs, std::size_t most = kMost) {
    static_assert(alignof(Place) <= 64, "what takeMemory() aligns to");
    clear();
    has_begun_.assign(std::min(pairs, most), 0);
    is_shared_ = pairs > most;
    places_.reset(static_cast<Place*>(takeMemory(has_begun_.size() * sizeof(Place))));
  }

  /// The value of a pair, a new one where another has its place.
  T& of(std::int32_t pair) {
    return of(pair, [](std::int32_t) { return T(); });
  }
  /// The same; make(pair) is the new value.
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
  /// Whether pairs share places. Otherwise a value stays where it is.
  bool isShared() const { return is_shared_; }
  /// The value of a pair; null: nothing is known of it.
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
    // A hash, because pairs of one thing have numbers that differ by multiples of a row's length.
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
  // Room for all places, each begun where a pair first comes to it: most never are.
  std::unique_ptr<Place, GiveBack> places_;
  std::vector<unsigned char> has_begun_;
  bool is_shared_ = false;
};

}  // namespace leeway::collision
