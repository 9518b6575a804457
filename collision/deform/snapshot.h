#pragma once

// Private to collision/: a deforming mesh at one time, and the source of its nodes' boxes for
// queries.

#include <cstdint>
#include <memory>
#include <memory_resource>
#include <vector>

#include "collision/base/large_pages.h"
#include "collision/deform/bounds/node_bounds.h"
#include "collision/deform/tree/deform_tree.h"
#include "collision/deform/tree/refit.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {

/// The boxes of nodes that a snapshot leaves to the queries.
enum class Demand : unsigned char {
  kNothing,   ///< none
  kBranches,  ///< those of branches, computed from the vertices below the node
  kVertices,  ///< all, computed from the vertices below the node
  kMotion,    ///< all, computed from the parameters of the motion
  kNoTree,    ///< queries do not use nodes
};

struct DeformableSnapshotImpl {
  DeformableSnapshotImpl() { face.impl_ = this; }
  DeformableSnapshotImpl(const DeformableSnapshotImpl&) = delete;
  DeformableSnapshotImpl& operator=(const DeformableSnapshotImpl&) = delete;

  DeformableSnapshot face;
  std::shared_ptr<const DeformableMesh> mesh;
  std::shared_ptr<const DeformTree> tree;
  std::shared_ptr<const NodeBounds> bounds;  // for Demand::kMotion
  // One more than the mesh has, because kernels load four doubles for each vertex.
  std::pmr::vector<Eigen::Vector3d> vertices{largePages()};
  std::vector<double> parameters;                 // of the motion
  std::pmr::vector<WideBox> boxes{largePages()};  // of the nodes that are not left to queries
  Demand demand = Demand::kNothing;
  DeformStrategy strategy = DeformStrategy::kRebuild;
  double time = 0, speed_bound = 0;
  std::uint64_t id = 0, owner = 0;
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
};

/// Boxes of nodes that a thread has found on demand, for each owner of a deforming mesh.
struct DeformScratch {
  struct Entry {
    std::uint64_t owner = 0;
    std::pmr::vector<WideBox> boxes{largePages()};  // one for each node
    // The snapshot that each box belongs to.
    std::pmr::vector<std::uint64_t> stamp{largePages()};
  };
  std::vector<Entry> entries;
  std::uint64_t asked = 0;  ///< id of the snapshot that the last query read
  /// For Demand::kNoTree: boxes of two bodies' triangles, and room for OctreePairs.
  std::vector<FloatBox> boxes_a, boxes_b;
  std::vector<std::int32_t> lists;

  Entry* find(std::uint64_t owner) {
    for (Entry& entry : entries) {
      if (entry.owner == owner) return &entry;
    }
    return nullptr;
  }
};

/// The boxes of a snapshot's nodes, for one query.
class BoxSource {
 public:
  BoxSource() = default;
  BoxSource(const DeformableSnapshotImpl& snapshot, DeformScratch& scratch);

  /// Boxes of the node's children. `room` stores them if the thread's scratch has no room.
  const WideBox& boxes(std::int32_t node, WideBox& room) const {
    return isThere(node) ? snapshot_->boxes[static_cast<std::size_t>(node)] : fill(node, room);
  }

  /// Whether the snapshot itself has the boxes of a node's children. Queries must not depend on
  /// which other boxes were found on demand, because answers would then depend on earlier queries
  /// of the thread.
  bool isThere(std::int32_t node) const {
    return snapshot_->demand == Demand::kNothing ||
           (snapshot_->demand == Demand::kBranches && node < snapshot_->tree->upperCount());
  }

  /// Prefetches the data for opening this child of a node, which an update has evicted from the
  /// cache.
  void fetch(std::int32_t child) const {
    if (child < 0) return;
    const auto i = static_cast<std::size_t>(child);
    const bool there = isThere(child);
    if (!there && entry_ == nullptr) return;
    const WideBox& box = there ? snapshot_->boxes[i] : entry_->boxes[i];
    __builtin_prefetch(box.low[0]);  // 64 bytes each
    __builtin_prefetch(box.low[2]);
    __builtin_prefetch(box.high[1]);
    __builtin_prefetch(&snapshot_->tree->node(child));
    if (!there) snapshot_->tree->fetchLeaves(child);
    if (there || snapshot_->demand == Demand::kMotion || entry_->stamp[i] == snapshot_->id) return;
    // Prefetched because nearly every child that stays open is opened later.
    if (child >= snapshot_->tree->upperCount())
      snapshot_->tree->fetchVertices(child, snapshot_->vertices.data());
  }

 private:
  const WideBox& fill(std::int32_t node, WideBox& room) const;

  const DeformableSnapshotImpl* snapshot_ = nullptr;
  DeformScratch::Entry* entry_ = nullptr;  // null: no room
};

}  // namespace leeway::collision
