#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "collision/deform/tree/tree_draft.h"

namespace leeway::collision {
namespace {

// A triangle and its place on the curve.
using Key = std::pair<std::uint64_t, std::int32_t>;

// The lowest 21 bits of x, two zeros after each.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffffULL;
  x = (x | x << 16) & 0x1f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  x = (x | x << 2) & 0x1249249249249249ULL;
  return x;
}

// Stable sort, 11 bits for each pass.
void radixSort(std::vector<Key>& keys) {
  std::vector<Key> other(keys.size());
  for (int shift = 0; shift < 66; shift += 11) {
    std::array<std::size_t, 2049> begin{};
    for (const Key& key : keys) ++begin[((key.first >> shift) & 2047) + 1];
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    for (const Key& key : keys) other[begin[(key.first >> shift) & 2047]++] = key;
    keys.swap(other);
  }
}

void sortByCurve(TreeDraft& draft) {
  float from[3], to[3];
  draft.middles(draft.all(), from, to);
  float width = 0;
  for (int k = 0; k < 3; ++k) width = std::max(width, to[k] - from[k]);
  const float scale = width > 0 ? 0x1p20F / width : 0.0F;
  std::vector<Key> keys(draft.order.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto triangle = static_cast<std::int32_t>(i);
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const float f = (draft.box(triangle).middle(k) - from[k]) * scale;
      // A NaN becomes 0.
      const std::uint64_t cell = f > 0 && f < 0x1p21F ? static_cast<std::uint64_t>(f) : 0;
      code |= spread(cell) << k;
    }
    keys[i] = {code, triangle};
  }
  radixSort(keys);
  for (std::size_t i = 0; i < keys.size(); ++i) draft.order[i] = keys[i].second;
}

// Cuts the curve into equal runs.
std::int32_t makeNode(TreeDraft& draft, DraftRange range) {
  const std::int32_t id = draft.newNode();
  const std::int32_t capacity = childCapacity(range.count());
  std::size_t lane = 0;
  for (std::int32_t begin = range.begin; begin < range.end; begin += capacity) {
    const DraftRange part{begin, std::min(begin + capacity, range.end)};
    draft.setChild(
        id, lane++,
        part.count() <= DeformTree::kLeafTriangles ? draft.newLeaf(part) : makeNode(draft, part));
  }
  draft.endNode(id, range.count());
  return id;
}

}  // namespace

std::int32_t buildMorton(TreeDraft& draft) {
  sortByCurve(draft);
  return makeNode(draft, draft.all());
}

}  // namespace leeway::collision
