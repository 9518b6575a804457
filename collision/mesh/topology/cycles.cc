#include "collision/mesh/topology/cycles.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "collision/base/numbers.h"
#include "collision/mesh/topology/union_find.h"

namespace leeway::collision {
namespace {

// Limit on the steps of the elimination, of about 50 ns each: enough for meshes of thousands of
// patches.
constexpr std::int64_t kCycleWork = 20'000'000;

using Number = std::uint64_t;  // modulo kCyclePrime
__extension__ using Product = unsigned __int128;

Number sum(Number a, Number b) {
  const Number s = a + b;
  return s >= kCyclePrime ? s - kCyclePrime : s;
}
Number negative(Number a) { return a == 0 ? 0 : kCyclePrime - a; }
Number product(Number a, Number b) {
  return static_cast<Number>(static_cast<Product>(a) * b % kCyclePrime);
}
// By Fermat's little theorem.
Number inverse(Number a) {
  Number result = 1;
  for (Number exponent = kCyclePrime - 2; exponent > 0; exponent >>= 1) {
    if ((exponent & 1) != 0) result = product(result, a);
    a = product(a, a);
  }
  return result;
}
Number toNumber(std::int32_t times) {
  const Number size = static_cast<Number>(times < 0 ? -std::int64_t{times} : std::int64_t{times});
  return times < 0 ? negative(size) : size;
}

// A pseudo-random number, always the same for a patch (S. Vigna's splitmix64).
Number drawn(std::size_t patch) {
  std::uint64_t z = (patch + 1) * 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return 1 + (z ^ (z >> 31)) % (kCyclePrime - 1);
}

// The unknowns are the patches' weights. A solved unknown is a sum over others, each of which is
// free or solved later.
class Elimination {
 public:
  Elimination(std::size_t patches, std::span<const BorderEquation> equations)
      : equations_(equations), solution_(patches), is_solved_(patches, 0), uses_(patches, 0) {
    for (const BorderEquation& e : equations)
      for (const BorderTerm& term : e) ++uses_[at(term.patch)];
  }

  // False if it would take too long.
  bool run() {
    for (const BorderEquation& e : equations_) {
      Row row;
      for (const BorderTerm& term : e) row.emplace(term.patch, toNumber(term.times));
      if (!substitute(row)) return false;
      if (!row.empty()) solve(row);
    }
    return true;
  }

  std::vector<Number> values() const {
    std::vector<Number> value(solution_.size(), 0);
    for (std::size_t p = 0; p < value.size(); ++p)
      if (is_solved_[p] == 0) value[p] = drawn(p);
    for (auto p = order_.rbegin(); p != order_.rend(); ++p)
      for (const Term& term : solution_[at(*p)])
        value[at(*p)] = sum(value[at(*p)], product(term.factor, value[at(term.patch)]));
    return value;
  }

  bool isFree(std::size_t patch) const { return is_solved_[patch] == 0; }

 private:
  using Row = std::map<std::int32_t, Number>;
  struct Term {
    std::int32_t patch;
    Number factor;
  };

  // Substitutes solved unknowns; only free unknowns remain.
  bool substitute(Row& row) {
    for (auto i = row.begin(); i != row.end();) {
      if (is_solved_[at(i->first)] == 0) {
        ++i;
        continue;
      }
      const auto [patch, factor] = *i;
      row.erase(i);
      for (const Term& term : solution_[at(patch)]) {
        if (++work_ > kCycleWork) return false;
        Number& n = row[term.patch];
        n = sum(n, product(factor, term.factor));
        if (n == 0) row.erase(term.patch);
      }
      i = row.begin();
    }
    return true;
  }

  // Solves for the unknown that the fewest equations use, so that the other equations stay short.
  void solve(const Row& row) {
    const auto rarest = std::min_element(row.begin(), row.end(), [&](const auto& a, const auto& b) {
      return uses_[at(a.first)] < uses_[at(b.first)];
    });
    const Number scale = negative(inverse(rarest->second));
    std::vector<Term>& terms = solution_[at(rarest->first)];
    for (const auto& [patch, factor] : row)
      if (patch != rarest->first) terms.push_back({patch, product(scale, factor)});
    is_solved_[at(rarest->first)] = 1;
    order_.push_back(rarest->first);
  }

  std::span<const BorderEquation> equations_;
  std::vector<std::vector<Term>> solution_;
  std::vector<std::uint8_t> is_solved_;
  std::vector<std::int32_t> uses_, order_;
  std::int64_t work_ = 0;
};

}  // namespace

PatchCycle largestCycle(std::size_t patches, std::span<const BorderEquation> equations) {
  PatchCycle cycle;
  UnionFind clusters(patches);
  Elimination elimination(patches, equations);
  if (!elimination.run()) {
    cycle.weight.assign(patches, 1);
    for (const BorderEquation& e : equations)
      for (const BorderTerm& term : e) cycle.weight[at(term.patch)] = 0;
    cycle.cluster.resize(patches);
    std::iota(cycle.cluster.begin(), cycle.cluster.end(), 0);
    return cycle;
  }
  cycle.weight = elimination.values();
  for (const BorderEquation& e : equations) {
    std::int32_t before = -1;
    for (const BorderTerm& term : e) {
      if (cycle.weight[at(term.patch)] == 0) continue;
      if (before >= 0) clusters.unite(before, term.patch);
      before = term.patch;
    }
  }
  std::vector<Number> scale(patches, 0);  // of a cluster; 0: it has no free patch yet
  std::vector<std::uint8_t> has_several(patches, 0);
  for (std::size_t p = 0; p < patches; ++p) {
    cycle.cluster.push_back(clusters.find(static_cast<std::int32_t>(p)));
    const std::size_t r = at(cycle.cluster[p]);
    if (!elimination.isFree(p)) continue;
    if (scale[r] != 0) has_several[r] = 1;
    scale[r] = inverse(cycle.weight[p]);
  }
  for (std::size_t p = 0; p < patches; ++p) {
    const std::size_t r = at(cycle.cluster[p]);
    if (scale[r] != 0 && has_several[r] == 0) cycle.weight[p] = product(cycle.weight[p], scale[r]);
  }
  return cycle;
}

}  // namespace leeway::collision
