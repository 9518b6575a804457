#include "leeway/collision/deformable_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "collision/deform/snapshot.h"
#include "collision/mesh/topology/components.h"
#include "collision/mesh/topology/cracks.h"
#include "collision/shapes/size_limits.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

struct Word {
  DeformStrategy strategy;
  const char* word;
};
constexpr Word kWords[] = {
    {DeformStrategy::kAuto, "auto"},
    {DeformStrategy::kRebuild, "rebuild"},
    {DeformStrategy::kRebuildLinear, "rebuild-linear"},
    {DeformStrategy::kRefit, "refit"},
    {DeformStrategy::kHybrid, "hybrid"},
    {DeformStrategy::kLazy, "lazy"},
    {DeformStrategy::kMorph, "morph"},
    {DeformStrategy::kSkinned, "skinned"},
    {DeformStrategy::kReduced, "reduced"},
    {DeformStrategy::kRestructure, "restructure"},
    {DeformStrategy::kOctree, "octree"},
};
constexpr const char* kVolumeWords[] = {"box", "dop", "ball"};

}  // namespace

const char* toString(DeformStrategy strategy) {
  for (const Word& w : kWords) {
    if (w.strategy == strategy) return w.word;
  }
  return "unknown";
}

std::optional<DeformStrategy> deformStrategy(std::string_view word) {
  for (const Word& w : kWords) {
    if (word == w.word) return w.strategy;
  }
  return std::nullopt;
}

const char* toString(DeformVolume volume) { return kVolumeWords[static_cast<std::size_t>(volume)]; }

std::optional<DeformVolume> deformVolume(std::string_view word) {
  for (const DeformVolume volume : {DeformVolume::kBox, DeformVolume::kDop, DeformVolume::kBall}) {
    if (word == toString(volume)) return volume;
  }
  return std::nullopt;
}

const char* toString(UpdateStatus status) {
  switch (status) {
    case UpdateStatus::kUpdated:
      return "updated";
    case UpdateStatus::kWrongVertexCount:
      return "another number of vertices than the mesh has";
    case UpdateStatus::kNotFinite:
      return "a vertex is not finite, or beyond 1e9 m";
    case UpdateStatus::kBadTime:
      return "the time, the speed bound or the distance moved is not a usable number";
    case UpdateStatus::kNoMotion:
      return "there is no motion to follow";
  }
  return "unknown";
}

std::shared_ptr<const DeformableMesh> DeformableMesh::make(std::span<const Vector3d> rest,
                                                           std::span<const Triangle> triangles,
                                                           bool solid) {
  if (triangles.empty()) throw InvalidShape("deformable mesh: no triangles; at least 1 is needed");
  requireSizes(rest, "deformable mesh", "vertex");
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::int32_t v : triangles[i]) {
      if (v >= 0 && static_cast<std::size_t>(v) < rest.size()) continue;
      throw InvalidShape("deformable mesh: triangle " + std::to_string(i) + " names vertex " +
                         std::to_string(v) + "; 0 to " + std::to_string(rest.size()) +
                         " - 1 are there");
    }
  }
  std::shared_ptr<DeformableMesh> mesh(new DeformableMesh);
  mesh->rest_.assign(rest.begin(), rest.end());
  mesh->triangles_.assign(triangles.begin(), triangles.end());
  MeshComponents components = findComponents(rest, mesh->triangles_);
  if (!solid) components.leaveOpen();
  // Solids that share a cut edge need triangles without area, which the mesh cannot have: its
  // vertices leave the edge as they move.
  std::vector<Triangle> tied = mesh->triangles_;
  addOverlapFillers(rest, tied);
  if (solid && tied.size() > triangles.size()) {
    const MeshComponents of_tied = findComponents(rest, tied);
    std::size_t needed = 0;
    for (std::size_t i = triangles.size(); i < tied.size(); ++i)
      needed += of_tied.closes(i) ? 1U : 0U;
    if (needed > 0) {
      components.leaveOpen();
      components.open_edges = needed;
    }
  }
  mesh->triangle_component_ = std::move(components.component);
  mesh->component_closed_ = std::move(components.closed);
  mesh->winding_weight_ = std::move(components.weight);
  mesh->open_edges_ = components.open_edges;
  mesh->component_vertex_.assign(mesh->component_closed_.size(), -1);
  for (std::size_t i = 0; i < mesh->triangles_.size(); ++i) {
    std::int32_t& v =
        mesh->component_vertex_[static_cast<std::size_t>(mesh->triangle_component_[i])];
    if (v < 0) v = mesh->triangles_[i][0];
  }
  return mesh;
}

int DeformableMesh::closedComponentCount() const {
  return static_cast<int>(std::count(component_closed_.begin(), component_closed_.end(), 1));
}

const DeformableMesh& DeformableSnapshot::mesh() const { return *impl_->mesh; }
std::span<const Vector3d> DeformableSnapshot::vertices() const {
  return {impl_->vertices.data(), impl_->mesh->rest().size()};
}
double DeformableSnapshot::time() const { return impl_->time; }
double DeformableSnapshot::speedBound() const { return impl_->speed_bound; }
std::uint64_t DeformableSnapshot::id() const { return impl_->id; }
DeformStrategy DeformableSnapshot::strategy() const { return impl_->strategy; }
const Vector3d& DeformableSnapshot::low() const { return impl_->low; }
const Vector3d& DeformableSnapshot::high() const { return impl_->high; }

}  // namespace leeway::collision
