#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "collision/base/numbers.h"

namespace leeway::collision {

/// Disjoint sets of the numbers from 0 on. A set is identified by its lowest member. Path halving
/// (R. E. Tarjan, J. van Leeuwen 1984).
class UnionFind {
 public:
  explicit UnionFind(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::int32_t find(std::int32_t i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  void unite(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    parent_[at(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

}  // namespace leeway::collision
