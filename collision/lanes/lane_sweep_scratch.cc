#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "collision/base/numbers.h"
#include "collision/lanes/lane_sweep.h"
#include "collision/lanes/lane_sweep_impl.h"

namespace leeway::collision {
namespace {

/// Obstacles that are made when they are near, and kept [count].
constexpr std::size_t kMostMade = std::size_t{1} << 8U;

}  // namespace

LaneSweep::Scratch::Scratch(const LaneSweep& sweep, collision::Scratch& queries, Work& work)
    : impl_(std::make_unique<Impl>(queries, work)) {
  const LaneSweep::Impl& s = *sweep.impl_;
  // Not initialized, because moving balls are placed before they are read.
  impl_->outer = spareArray<Impl::Placed>(s.pieces.size());
  impl_->balls = spareArray<Impl::Placed>(s.stock->balls.size());
  impl_->cover_stamp.resize(s.pieces.size());
  impl_->inner_stamp.resize(s.pieces.size());
  impl_->part_stamp.resize(s.pieces.size());
  impl_->low.resize(3 * s.pieces.size());
  impl_->high.resize(3 * s.pieces.size());
  impl_->group_near.resize(s.groups.size());
  const std::size_t with_world = s.rows.size() * s.places, numbers = s.pairs.size() + with_world;
  const std::size_t most = std::min(numbers, s.pairs.size() + kMostNear);
  impl_->candidates.reserve(most);
  impl_->open.reserve(most);
  impl_->open_pairs.reserve(most);
  impl_->planes.resize(numbers);
  impl_->searches.resize(numbers);
  impl_->part_hints.resize(numbers);
  impl_->known.resize(with_world);
  impl_->made.resize(s.places, kMostMade);
  impl_->part_owners.assign(std::min(s.pairs_with_parts, Impl::kPartBlocks), -1);
  impl_->part_memory =
      spareArray<std::byte>(impl_->part_owners.size() * s.most_parts * sizeof(Impl::PartMemory));
  // Fixed balls are placed once, here.
  const auto still = [](const LaneSweep::Impl::LaneBall& ball, Impl::Placed& placed) {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < kLanes; ++i) {
        placed.center[k].at[i] = ball.center[k];
        placed.way[k].at[i] = 0;
      }
  };
  for (std::size_t p = 0; p < s.pieces.size(); ++p) {
    const LaneSweep::Impl::LanePiece& piece = s.pieces[p];
    if (piece.frame >= 0) continue;
    still(piece.outer, impl_->outer[p]);
    for (int k = 0; k < 3; ++k) {
      impl_->low[3 * p + at(k)] = piece.outer.center[k] - piece.outer.radius;
      impl_->high[3 * p + at(k)] = piece.outer.center[k] + piece.outer.radius;
    }
    for (int i = piece.cover; i < piece.end; ++i) still(s.balls[at(i)], impl_->balls[at(i)]);
  }
}
LaneSweep::Scratch::~Scratch() = default;

LaneSweep::Scratch::Impl::PartMemory* LaneSweep::Scratch::Impl::partsOf(
    const LaneSweep::Impl::Pair& pair, std::size_t most_parts) {
  const std::size_t block = at(pair.id) % part_owners.size();
  std::byte* const room = part_memory.get() + block * most_parts * sizeof(PartMemory);
  if (part_owners[block] != pair.id) {
    for (int k = 0; k < pair.parts; ++k) ::new (room + at(k) * sizeof(PartMemory)) PartMemory;
    part_owners[block] = pair.id;
  }
  return std::launder(reinterpret_cast<PartMemory*>(room));
}

void LaneSweepKernel::findObstacle(Sweep::Pair& pair) const {
  pair.made = &scratch.made.of(pair.place(),
                               [this](std::int32_t place) { return sweep.obstacleIn(place); });
}

bool LaneSweep::Scratch::isFull() const { return impl_->is_full; }

std::span<const LaneSweep::Open> LaneSweep::Scratch::open() const { return impl_->open; }

void LaneSweep::Scratch::close(std::span<const std::uint32_t> intervals) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < impl_->open.size(); ++i) {
    impl_->open[i].intervals &= ~intervals[i];
    if (impl_->open[i].intervals == 0) continue;
    impl_->open[kept] = impl_->open[i];
    impl_->open_pairs[kept++] = impl_->open_pairs[i];
  }
  impl_->open.resize(kept);
  impl_->open_pairs.resize(kept);
}

}  // namespace leeway::collision
