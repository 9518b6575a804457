#include "robots/mesh/mesh_treatment.h"

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::robots {

using collision::Shape;

const MeshTreatment* treatmentOf(const LoadOptions& options,
                                 std::initializer_list<std::string_view> names) {
  const MeshTreatment* first = nullptr;
  for (const std::string_view name : names) {
    const auto found = options.meshes.find(name);
    if (found == options.meshes.end()) continue;
    if (options.meshes_found != nullptr) options.meshes_found->insert(found->first);
    if (first == nullptr) first = &found->second;
  }
  return first;
}

Shape withTreatment(const Shape& shape, const MeshTreatment& treatment) {
  if (shape.mesh() == nullptr) return shape;
  const collision::TriangleMesh& mesh = *shape.mesh();
  if (treatment.solid == MeshTreatment::Solid::kHull) return Shape::convexHull(mesh.vertices());
  collision::MeshOptions made;
  made.solid = treatment.solid != MeshTreatment::Solid::kSurface;
  made.weld = treatment.weld;
  return Shape::mesh(collision::TriangleMesh::make(mesh.vertices(), mesh.triangles(), made));
}

Shape treatedMesh(const Shape& shape, std::initializer_list<std::string_view> names,
                  const LoadOptions& options) {
  if (shape.mesh() == nullptr) return shape;
  const MeshTreatment* treatment = treatmentOf(options, names);
  return treatment == nullptr ? shape : withTreatment(shape, *treatment);
}

void OpenMeshes::add(std::string_view owner, std::span<const collision::Geometry> geometries) {
  std::size_t edges = 0;
  bool deforms = false;
  for (const collision::Geometry& g : geometries) {
    if (g.shape.mesh() != nullptr) edges += g.shape.mesh()->openEdgeCount();
    if (g.shape.deformable() == nullptr) continue;
    deforms = true;
    edges += g.shape.deformable()->mesh().openEdgeCount();
  }
  if (edges == 0) return;
  open_.emplace_back(owner, edges);
  if (!deforms && rigid_.empty()) rigid_ = owner;
}

std::string OpenMeshes::text(bool of_program) const {
  if (open_.empty()) return {};
  std::string named;
  for (const auto& [owner, edges] : open_)
    named += (named.empty() ? "" : ", ") + owner + " (" + std::to_string(edges) +
             (edges == 1 ? " open edge)" : " open edges)");
  const bool is_one = open_.size() == 1;
  std::string text = (is_one ? "a mesh is not closed: " : "meshes are not closed: ") + named +
                     "; where " + (is_one ? "it is" : "they are") +
                     " open, what is inside is not seen";
  if (of_program)
    return text + (rigid_.empty()
                       ? "; facets that share their vertices close it"
                       : ". In Python, solid='hull' takes the convex hull, weld=1e-6 closes cracks "
                         "of up to a micron, solid='surface' says that it is a surface; in C++, "
                         "Shape::convexHull() and MeshOptions do");
  text += ". The key `meshes: {" + (rigid_.empty() ? open_.front().first : rigid_);
  // The vertices of what deforms are the file's.
  return text + (rigid_.empty()
                     ? ": {solid: surface}}` says that it is a surface; a file whose facets share "
                       "their vertices closes it"
                     : ": {solid: hull}}` of a problem file, in Python the argument meshes, takes "
                       "the convex hull, "
                       "`weld: 1e-6` closes cracks of up to a micron, `solid: surface` says that "
                       "it is a surface");
}

}  // namespace leeway::robots
