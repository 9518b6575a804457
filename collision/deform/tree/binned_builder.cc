#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/deform/tree/tree_draft.h"

namespace leeway::collision {
namespace {

constexpr std::size_t kBins = 16;
// Pieces of up to this many triangles are halved at the median, so that their nodes are full.
// Half-empty nodes cost every update, and the shape of such a small piece soon changes with the
// mesh.
constexpr std::int32_t kBalanced = 512;
// From this depth on, nodes are also halved. The heuristic may cut off one triangle at a time, but
// no tree may be deeper than DeformTree::kMaxDepth.
constexpr int kFreeDepth = 32;

std::size_t binOf(const DraftBox& box, int axis, float from, float scale) {
  const float f = (box.middle(axis) - from) * scale;
  return static_cast<std::size_t>(std::clamp(static_cast<int>(f), 0, static_cast<int>(kBins) - 1));
}

// A border between bins: the triangles of lower bins are on the left.
struct Cut {
  float cost = std::numeric_limits<float>::infinity();  // area times count of both sides, summed
  int axis = -1;                                        // -1: none
  std::size_t bin = 0;
  float scale = 0;  // bins per unit of middle()
};

// Replaces `best` by the cheapest cut along an axis, if that is cheaper.
void findCut(const TreeDraft& draft, DraftRange range, int axis, float from, float scale,
             Cut& best) {
  std::array<DraftBox, kBins> bins;
  std::array<std::int32_t, kBins> number{};
  for (std::int32_t i = range.begin; i < range.end; ++i) {
    const DraftBox& box = draft.boxAt(i);
    const std::size_t bin = binOf(box, axis, from, scale);
    bins[bin].add(box);
    ++number[bin];
  }
  std::array<float, kBins> right_cost{};  // of bins i and up; -1 if they are empty
  DraftBox right;
  std::int32_t right_number = 0;
  for (std::size_t i = kBins - 1; i > 0; --i) {
    right.add(bins[i]);
    right_number += number[i];
    right_cost[i] = right_number > 0 ? right.area() * static_cast<float>(right_number) : -1;
  }
  DraftBox left;
  std::int32_t left_number = 0;
  for (std::size_t i = 1; i < kBins; ++i) {
    left.add(bins[i - 1]);
    left_number += number[i - 1];
    if (left_number == 0 || right_cost[i] < 0) continue;
    const float cost = left.area() * static_cast<float>(left_number) + right_cost[i];
    if (cost < best.cost) best = {cost, axis, i, scale};
  }
}

// Cuts at the border of bins with the least sum of area times number on both sides, over three
// axes; in the middle of the order if there is no such border. Returns the first place on the
// right.
std::int32_t cutByArea(TreeDraft& draft, DraftRange range) {
  float from[3], to[3];
  draft.middles(range, from, to);
  Cut best;
  for (int axis = 0; axis < 3; ++axis) {
    const float width = to[axis] - from[axis];
    if (!(width > 0)) continue;
    const float scale = (static_cast<float>(kBins) * (1 - 1e-5F)) / width;
    if (std::isfinite(scale)) findCut(draft, range, axis, from[axis], scale, best);
  }
  const std::int32_t half = range.begin + range.count() / 2;
  if (best.axis < 0) return half;
  const auto first = draft.order.begin() + range.begin, last = draft.order.begin() + range.end;
  const auto middle = std::partition(first, last, [&](std::int32_t t) {
    return binOf(draft.box(t), best.axis, from[best.axis], best.scale) < best.bin;
  });
  const auto cut = static_cast<std::int32_t>(middle - draft.order.begin());
  return cut > range.begin && cut < range.end ? cut : half;
}

// Splits into up to eight parts by repeatedly cutting the one with the largest box. Parts stay in
// the order of their triangles.
std::size_t partByArea(TreeDraft& draft, DraftRange range, std::array<DraftRange, kWidth>& parts) {
  std::array<float, kWidth> area{};
  std::size_t count = 1;
  parts[0] = range;
  area[0] = draft.bound(range).area();
  while (count < kWidth) {
    std::size_t widest = kWidth;
    for (std::size_t i = 0; i < count; ++i) {
      if (parts[i].count() > kBalanced && (widest == kWidth || area[i] > area[widest])) widest = i;
    }
    if (widest == kWidth) break;
    const DraftRange whole = parts[widest];
    const std::int32_t middle = cutByArea(draft, whole);
    for (std::size_t i = count; i > widest + 1; --i) {
      parts[i] = parts[i - 1];
      area[i] = area[i - 1];
    }
    parts[widest] = {whole.begin, middle};
    parts[widest + 1] = {middle, whole.end};
    area[widest] = draft.bound(parts[widest]).area();
    area[widest + 1] = draft.bound(parts[widest + 1]).area();
    ++count;
  }
  return count;
}

// Moves the triangles with the lower middles along the longest axis before place `cut`.
void halve(TreeDraft& draft, DraftRange range, std::int32_t cut) {
  float from[3], to[3];
  draft.middles(range, from, to);
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (to[k] - from[k] > to[axis] - from[axis]) axis = k;
  }
  const auto first = draft.order.begin();
  std::nth_element(
      first + range.begin, first + cut, first + range.end, [&](std::int32_t l, std::int32_t r) {
        const float middle_l = draft.box(l).middle(axis), middle_r = draft.box(r).middle(axis);
        return middle_l != middle_r ? middle_l < middle_r : l < r;
      });
}

// Splits into parts of `capacity` triangles, the last one smaller, by repeatedly halving the
// longest part.
std::size_t partEvenly(TreeDraft& draft, DraftRange range, std::int32_t capacity,
                       std::array<DraftRange, kWidth>& parts) {
  std::size_t count = 1;
  parts[0] = range;
  for (;;) {
    std::size_t longest = 0;
    for (std::size_t i = 1; i < count; ++i) {
      if (parts[i].count() > parts[longest].count()) longest = i;
    }
    const DraftRange whole = parts[longest];
    if (whole.count() <= capacity) return count;
    const std::int32_t pieces = (whole.count() + capacity - 1) / capacity;
    const std::int32_t cut = whole.begin + (pieces / 2) * capacity;
    halve(draft, whole, cut);
    for (std::size_t i = count; i > longest + 1; --i) parts[i] = parts[i - 1];
    parts[longest] = {whole.begin, cut};
    parts[longest + 1] = {cut, whole.end};
    ++count;
  }
}

}  // namespace

std::int32_t buildBinned(TreeDraft& draft, DraftRange range, int depth) {
  const std::int32_t id = draft.newNode();
  std::array<DraftRange, kWidth> parts;
  const std::size_t count = depth < kFreeDepth && range.count() > kBalanced
                                ? partByArea(draft, range, parts)
                                : partEvenly(draft, range, childCapacity(range.count()), parts);
  for (std::size_t i = 0; i < count; ++i) {
    draft.setChild(id, i,
                   parts[i].count() <= DeformTree::kLeafTriangles
                       ? draft.newLeaf(parts[i])
                       : buildBinned(draft, parts[i], depth + 1));
  }
  draft.endNode(id, range.count());
  return id;
}

}  // namespace leeway::collision
