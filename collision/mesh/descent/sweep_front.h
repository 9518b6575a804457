#pragma once

// Private to collision/: the fronts at which descents of sweeps ended, for SweepFronts.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

/// Pairs of nodes that together cover all pairs of triangles of two bodies, and the direction that
/// separated each.
struct SweepFront {
  struct Entry {
    std::int32_t a, b;  ///< nodes; -1: a convex shape as a whole
    Eigen::Vector3d direction_B;
    int vertex_a, vertex_b;
  };
  /// Limit on the size of stored fronts: testing a larger one would cost more than a descent.
  static constexpr std::size_t kMost = 96;

  const MeshTree* a = nullptr;  ///< null: a convex shape
  const MeshTree* b = nullptr;
  std::size_t count = 0;
  std::array<Entry, kMost> entries;
};

/// The last fronts of a few pairs of meshes, and room for the next one.
struct SweepFrontScratch {
  static constexpr std::size_t kFronts = 4;

  bool active = false;
  std::size_t next = 0;  ///< index in `kept` of the front that is replaced next
  std::array<SweepFront, kFronts> kept;
  SweepFront found;  ///< the front that is being recorded

  SweepFront* of(const MeshTree* a, const MeshTree* b) {
    for (SweepFront& front : kept)
      if (front.count > 0 && front.a == a && front.b == b) return &front;
    return nullptr;
  }
  void clear() {
    for (SweepFront& front : kept) front.count = 0;
  }
};

/// Records a front during a descent: the pairs of nodes that it did not have to expand, each with
/// the direction in `cache` that separated it.
class FrontRecorder {
 public:
  FrontRecorder(SweepFront& front, const PairCache& cache) : front_(front), cache_(cache) {}

  void start(bool records) { records_ = records; }
  void record(std::int32_t a, std::int32_t b) {
    if (!records_) return;
    if (count_ == SweepFront::kMost) {
      records_ = false;
      return;
    }
    front_.entries[count_++] = {a, b, cache_.direction_B, cache_.vertex_a, cache_.vertex_b};
  }
  /// Stores the recorded pairs as the front of two bodies, if it is not too large.
  void keep(SweepFrontScratch& fronts, const MeshTree* a, const MeshTree* b) const {
    if (!records_) return;
    SweepFront* front = fronts.of(a, b);
    if (front == nullptr) {
      front = &fronts.kept[fronts.next];
      fronts.next = (fronts.next + 1) % SweepFrontScratch::kFronts;
    }
    front->a = a;
    front->b = b;
    front->count = count_;
    std::copy_n(front_.entries.begin(), count_, front->entries.begin());
  }

 private:
  SweepFront& front_;
  const PairCache& cache_;
  bool records_ = false;
  std::size_t count_ = 0;
};

}  // namespace leeway::collision
