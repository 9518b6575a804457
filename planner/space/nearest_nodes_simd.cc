// The nearest of many points, with one point per lane.
//
// Every lane does the same operations in the same order, each rounded once (no fused multiply and
// add), so all instruction sets find the same node.

#include <cmath>
#include <limits>
#include <numbers>

#include "planner/space/nearest_nodes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "planner/space/nearest_nodes_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace leeway::planner {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, NearestNodes::kBlock>;
using V = hn::Vec<D>;

HWY_INLINE V squaredDistances(const NearestNodes::Layout& layout, const float* block,
                              const float* query, const float* turn) {
  constexpr std::size_t kStride = NearestNodes::kBlock;
  const D d;
  V sum = hn::Zero(d);
  std::size_t row = 0;
  for (; row < layout.lines; ++row) {
    const V x = hn::Sub(hn::LoadU(d, block + row * kStride), hn::Set(d, query[row]));
    sum = hn::Add(sum, hn::Mul(x, x));
  }
  for (std::size_t i = 0; i < layout.circles; ++i, ++row) {
    const V x = hn::Abs(hn::Sub(hn::LoadU(d, block + row * kStride), hn::Set(d, query[row])));
    const V other = hn::Abs(hn::Sub(hn::Set(d, turn[row]), x));
    const V shorter = hn::IfThenElse(hn::Lt(other, x), other, x);
    sum = hn::Add(sum, hn::Mul(shorter, shorter));
  }
  // |p - q|^2 = 2 - 2 p.q, for the nearer one of p and -p.
  for (std::size_t i = 0; i < layout.rotations; ++i, row += 4) {
    V dot = hn::Zero(d);
    for (std::size_t k = row; k < row + 4; ++k)
      dot = hn::Add(dot, hn::Mul(hn::LoadU(d, block + k * kStride), hn::Set(d, query[k])));
    // Min() would turn the NaN of padding into a number.
    const V one = hn::Set(d, 1.0F), cosine = hn::Abs(dot);
    const V chord = hn::IfThenZeroElse(hn::Ge(cosine, one), hn::Sub(one, cosine));
    sum = hn::Add(sum, hn::Mul(hn::Set(d, turn[row]), chord));
  }
  return sum;
}

NearestNodes::Nearest FindNearest(const NearestNodes::Layout& layout, const float* rows,
                                  std::size_t size, const float* query, const float* turn) {
  constexpr std::size_t kStride = NearestNodes::kBlock;
  const D d;
  const hn::RebindToUnsigned<D> du;
  const std::size_t lanes = hn::Lanes(d), block_size = layout.rows() * kStride;
  V least = hn::Set(d, std::numeric_limits<float>::infinity());
  auto node = hn::Zero(du);
  // Padding is NaN, which is not less than any number.
  for (std::size_t first = 0; first < size; first += kStride, rows += block_size)
    for (std::size_t i = 0; i < kStride; i += lanes) {
      const V squared = squaredDistances(layout, rows + i, query, turn);
      const auto nearer = hn::Lt(squared, least);
      least = hn::IfThenElse(nearer, squared, least);
      node = hn::IfThenElse(hn::RebindMask(du, nearer),
                            hn::Iota(du, static_cast<std::uint32_t>(first + i)), node);
    }
  const V of_all = hn::MinOfLanes(d, least);
  const auto none = hn::Set(du, std::numeric_limits<std::uint32_t>::max());
  const auto first =
      hn::MinOfLanes(du, hn::IfThenElse(hn::RebindMask(du, hn::Eq(least, of_all)), node, none));
  return {hn::GetLane(first), std::sqrt(hn::GetLane(of_all))};
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::planner
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::planner {
HWY_EXPORT(FindNearest);

namespace {
constexpr float kTurn = 6.28318531F;
}

NearestNodes::NearestNodes(const ConfigurationSpace& space) {
  using Kind = ConfigurationSpace::Kind;
  const auto list = [&](Kind kind, std::size_t numbers) {
    std::size_t count = 0;
    for (const ConfigurationSpace::Part& part : space.parts()) {
      if (part.kind != kind) continue;
      ++count;
      const auto weight = static_cast<float>(part.weight);
      for (std::size_t k = 0; k < numbers; ++k) {
        order_.push_back(static_cast<std::size_t>(part.first) + k);
        // A rotation's chord is weighted as a whole.
        weight_.push_back(kind == Kind::kRotation ? 1 : weight);
        turn_.push_back(kind == Kind::kRotation ? 8 * weight * weight : kTurn * weight);
      }
    }
    return count;
  };
  layout_.lines = list(Kind::kLine, 1);
  layout_.circles = list(Kind::kCircle, 1);
  layout_.rotations = list(Kind::kRotation, 4);
  query_.resize(order_.size());
}

void NearestNodes::write(std::span<const double> point, float* first, std::size_t stride) const {
  for (std::size_t row = 0; row < order_.size(); ++row) {
    double x = point[order_[row]];
    // Paths may wind around a circle more than once, and lanes remove at most one turn.
    if (row >= layout_.lines && row < layout_.lines + layout_.circles)
      x = std::remainder(x, 2 * std::numbers::pi);
    first[row * stride] = weight_[row] * static_cast<float>(x);
  }
}

void NearestNodes::add(std::span<const double> point) {
  const std::size_t block_size = order_.size() * kBlock, lane = size_ % kBlock;
  if (lane == 0) {
    // Padding: NaN is not less than any distance.
    rows_.resize(rows_.size() + block_size, std::numeric_limits<float>::quiet_NaN());
  }
  write(point, rows_.data() + rows_.size() - block_size + lane, kBlock);
  ++size_;
}

NearestNodes::Nearest NearestNodes::nearest(std::span<const double> point) const {
  write(point, query_.data(), 1);
  return HWY_DYNAMIC_DISPATCH(FindNearest)(layout_, rows_.data(), size_, query_.data(),
                                           turn_.data());
}

}  // namespace leeway::planner
#endif  // HWY_ONCE
