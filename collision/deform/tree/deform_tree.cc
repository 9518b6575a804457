#include "collision/deform/tree/deform_tree.h"

#include <atomic>

#include "collision/base/numbers.h"

namespace leeway::collision {

DeformTree::DeformTree(const DeformTree& other, std::pmr::memory_resource* memory)
    : nodes_(other.nodes_, memory),
      up_(other.up_, memory),
      leaf_begin_(other.leaf_begin_, memory),
      leaf_end_(other.leaf_end_, memory),
      leaves_(other.leaves_, memory),
      leaf_vertices_(other.leaf_vertices_, memory),
      refit_offsets_(other.refit_offsets_, memory),
      refit_vertices_(other.refit_vertices_, memory),
      refit_corners_(other.refit_corners_, memory),
      branches_(other.branches_, memory),
      rows_(other.rows_, memory),
      runs_(other.runs_, memory),
      fours_(other.fours_, memory),
      singles_(other.singles_, memory),
      slot_of_(other.slot_of_, memory),
      slots_(other.slots_, memory),
      upper_count_(other.upper_count_) {}

std::span<const std::int32_t> DeformTree::vertices(std::int32_t node, int lane) const {
  const std::int32_t child = nodes_[at(node)].child[lane];
  if (child == kNone) return {};
  std::int32_t first = 0, last = 0;
  if (isLeaf(child)) {
    first = leafOf(child);
    last = first + 1;
  } else {
    first = leaf_begin_[at(child)];
    last = leaf_end_[at(child)];
  }
  const auto begin = at(leaves_[at(first)].vertex_begin);
  const auto end = at(leaves_[at(last - 1)].vertex_end);
  return std::span<const std::int32_t>(leaf_vertices_).subspan(begin, end - begin);
}

std::uint64_t DeformTree::nextId() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

std::size_t DeformTree::bytes() const {
  const auto bytesOf = [](const auto& vector) {
    return vector.capacity() * sizeof(*vector.data());
  };
  return sizeof(*this) + bytesOf(nodes_) + bytesOf(up_) + bytesOf(leaf_begin_) +
         bytesOf(leaf_end_) + bytesOf(leaves_) + bytesOf(leaf_vertices_) + bytesOf(refit_offsets_) +
         bytesOf(refit_vertices_) + bytesOf(refit_corners_) + bytesOf(branches_) + bytesOf(rows_) +
         bytesOf(runs_) + bytesOf(fours_) + bytesOf(singles_) + bytesOf(slot_of_) + bytesOf(slots_);
}

}  // namespace leeway::collision
