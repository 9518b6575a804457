#include "robots/motion/gap_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "collision/base/byte_stream.h"

namespace leeway::robots {
namespace {

bool isGap(float gap) { return gap >= 0 && std::isfinite(gap); }

bool isOf(const LinkGap& gap, const Model& model) {
  const auto isBelow = [](int i, std::size_t count) {
    return i >= 0 && static_cast<std::size_t>(i) < count;
  };
  constexpr auto kArcs = static_cast<std::size_t>(LinkGap::kArcs);
  return isBelow(gap.link_a, model.links.size()) && isBelow(gap.link_b, model.links.size()) &&
         isBelow(gap.joint, model.joints.size()) && isBelow(gap.other, model.joints.size()) &&
         gap.gaps.size() == kArcs && gap.cells.size() == kArcs * kArcs && isGap(gap.cell_gap) &&
         std::all_of(gap.gaps.begin(), gap.gaps.end(), isGap) &&
         std::all_of(gap.cells.begin(), gap.cells.end(), [](char c) { return c == 0 || c == 1; });
}

}  // namespace

std::vector<std::byte> bytesOf(std::span<const LinkGap> gaps) {
  collision::ByteWriter to;
  to.value(static_cast<std::uint64_t>(gaps.size()));
  for (const LinkGap& gap : gaps) {
    for (const int number : {gap.link_a, gap.link_b, gap.joint, gap.other}) to.value(number);
    to.array(gap.gaps);
    to.array(gap.cells);
    to.value(gap.cell_gap);
  }
  return to.take();
}

std::optional<std::vector<LinkGap>> gapsFromBytes(std::span<const std::byte> bytes,
                                                  const Model& model) {
  collision::ByteReader from(bytes);
  std::vector<LinkGap> gaps;
  for (auto left = from.value<std::uint64_t>(); left > 0; --left) {
    LinkGap& gap = gaps.emplace_back();
    for (int* const number : {&gap.link_a, &gap.link_b, &gap.joint, &gap.other})
      *number = from.value<int>();
    gap.gaps = from.array<float>();
    gap.cells = from.array<char>();
    gap.cell_gap = from.value<float>();
    if (from.failed() || !isOf(gap, model)) return std::nullopt;
  }
  if (!from.atEnd()) return std::nullopt;
  return gaps;
}

}  // namespace leeway::robots
