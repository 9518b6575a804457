#pragma once

// Private to the library: what is remembered of pairs or places, in a table of fixed size.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace leeway::collision {

/// One value a pair, by its number. Up to kMost pairs have a place each; more share places, and a
/// pair that comes to the place of another finds a new value there. So it is for what may be
/// forgotten: hints, warm starts. What is forgotten depends on the pairs that are asked for alone.
template <class T>
class PairTable {
 public:
  static constexpr std::size_t kMost = 1U << 14U;  ///< places [count]
  /// Of so many pairs that they are in runs few are ever near, and a small table is made sooner.
  static constexpr std::size_t kMostOfRuns = 1U << 10U;

  /// Room for pairs [0, pairs), in `most` places at most: a power of two. The only one that
  /// allocates.
  void resize(std::size_t pairs, std::size_t most = kMost) {
    places_.assign(std::min(pairs, most), {});
  }

  /// The value of a pair, a new one where another has its place.
  T& of(std::int32_t pair) {
    Place& place = places_[indexOf(pair)];
    if (place.pair != pair) place = {pair, T()};
    return place.value;
  }
  /// The same; make(pair) is the new value.
  template <class Make>
  T& of(std::int32_t pair, const Make& make) {
    Place& place = places_[indexOf(pair)];
    if (place.pair != pair) place = {pair, make(pair)};
    return place.value;
  }
  /// The value of a pair; null: nothing is known of it.
  const T* find(std::int32_t pair) const {
    const Place& place = places_[indexOf(pair)];
    return place.pair == pair ? &place.value : nullptr;
  }

 private:
  struct Place {
    std::int32_t pair = -1;
    T value = T();
  };
  std::size_t indexOf(std::int32_t pair) const {
    const auto number = static_cast<std::size_t>(pair);
    return number < places_.size() ? number : number & (places_.size() - 1);
  }
  std::vector<Place> places_;
};

}  // namespace leeway::collision
