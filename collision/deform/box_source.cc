#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/deform/snapshot.h"

namespace leeway::collision {

void prepare(Scratch& scratch, const DeformableSnapshot& snapshot) {
  const DeformableSnapshotImpl& s = snapshot.impl();
  if (s.demand == Demand::kNothing) return;
  DeformScratch& deform = scratch.impl().deform;
  DeformScratch::Entry* entry = deform.find(s.owner);
  if (entry == nullptr) {
    deform.entries.emplace_back();
    entry = &deform.entries.back();
    entry->owner = s.owner;
  }
  if (s.demand == Demand::kNoTree) {
    const std::size_t triangles = s.mesh->triangles().size();
    if (deform.boxes_b.size() < triangles) {
      deform.boxes_a.resize(triangles);
      deform.boxes_b.resize(triangles);
      deform.lists.resize(8 * triangles + 64);
    }
  }
  // Allocates a quarter more, because a rebuilt hierarchy may be a little larger.
  const std::size_t count = s.tree->nodes().size() + s.tree->nodes().size() / 4;
  if (entry->boxes.size() >= s.tree->nodes().size()) return;
  entry->boxes.resize(count);
  entry->stamp.assign(count, 0);
}

BoxSource::BoxSource(const DeformableSnapshotImpl& snapshot, DeformScratch& scratch)
    : snapshot_(&snapshot) {
  if (snapshot.demand == Demand::kNothing) return;
  entry_ = scratch.find(snapshot.owner);
  if (entry_ != nullptr && entry_->boxes.size() < snapshot.tree->nodes().size()) entry_ = nullptr;
}

const WideBox& BoxSource::fill(std::int32_t node, WideBox& room) const {
  const DeformableSnapshotImpl& s = *snapshot_;
  if (entry_ != nullptr && entry_->stamp[at(node)] == s.id) return entry_->boxes[at(node)];
  WideBox& box = entry_ != nullptr ? entry_->boxes[at(node)] : room;
  if (s.demand == Demand::kMotion) {
    s.bounds->bound(node, s.parameters, box);
  } else {
    deformKernels().fromVertices(*s.tree, s.vertices.data(), node, box);
  }
  if (entry_ != nullptr) entry_->stamp[at(node)] = s.id;
  return box;
}

}  // namespace leeway::collision
