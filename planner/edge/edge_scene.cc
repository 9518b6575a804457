// Pieces and pairs of a compiled scene, as edges ask for them.

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"
#include "collision/sweep/mesh_sweep.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_model.h"

namespace leeway::planner {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Whether a planned floating or planar joint carries a link. One that only places an arm in its
/// world is not planned.
bool isCarriedFreely(const CompiledScene& scene, int link) {
  const std::span<const int> planned = scene.space().variables();
  for (int l = link; l >= 0; l = scene.model().joints[at(l)].parent_link) {
    const robots::Joint& joint = scene.model().joints[at(l)];
    const auto moves = [&joint](int v) {
      return v >= joint.first_variable && v < joint.first_variable + joint.variable_count;
    };
    if ((joint.type == robots::JointType::kFloating || joint.type == robots::JointType::kPlanar) &&
        std::any_of(planned.begin(), planned.end(), moves))
      return true;
  }
  return false;
}

/// Two meshes, one of which flies freely. Links of an arm stay near each other and near its base
/// and move little there, so that sweeps of their hulls answer; against a convex obstacle sweeps of
/// convex pieces do.
bool sweepsSurfaces(const Piece& a, const Piece& b, double margin) {
  if (!(margin >= 0) || a.is_free_mesh == b.is_free_mesh) return false;
  const Piece& still = a.is_free_mesh ? b : a;
  return still.link < 0 && still.geometry->shape.type() == collision::ShapeType::kMesh &&
         collision::sweepsMesh(a.geometry->shape, b.geometry->shape);
}

class Builder {
 public:
  Builder(const CompiledScene& scene, EdgeScene& edges)
      : compiled_(scene), scene_(scene.scene()), model_(scene.edgeModel()), edges_(edges) {}

  void build() {
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b)
      for (const collision::Geometry& g : scene_.bodies()[b].geometries)
        addPiece(static_cast<int>(b), g);
    std::vector<EdgePair> pairs;
    pairs.reserve(scene_.pairs().size());
    for (std::size_t p = 0; p < scene_.pairs().size(); ++p)
      pairs.push_back(pairOf(static_cast<int>(p)));
    sortPairs(pairs);
  }

 private:
  const Piece& piece(int i) const { return edges_.pieces[at(i)]; }

  void addPiece(int body, const collision::Geometry& g) {
    const auto index = static_cast<int>(edges_.pieces.size());
    Piece piece;
    piece.body = body;
    piece.link = compiled_.bodyLink(body);
    piece.geometry = &g;
    piece.bounds = &collision::SceneAccess::bounds(scene_, index);
    piece.at_origin = g.X_BG.rotation.isIdentity(0) && g.X_BG.translation.isZero(0);
    if (piece.link < 0) {
      piece.X_GW = (scene_.bodies()[at(body)].X_WB * g.X_BG).inverse();
      piece.scale = piece.X_GW.translation.lpNorm<1>() + piece.bounds->outer.center.lpNorm<1>();
    } else {
      piece.is_free_mesh =
          g.shape.type() == collision::ShapeType::kMesh && isCarriedFreely(compiled_, piece.link);
      piece.moving = static_cast<int>(edges_.moving.size());
      edges_.moving.push_back(index);
    }
    edges_.pieces.push_back(piece);
  }

  EdgePair pairOf(int p) {
    const collision::ScenePair& pair = scene_.pairs()[at(p)];
    const EdgeModel::Pair& known = model_.pairs[at(p)];
    EdgePair e;
    e.scene_pair = p;
    e.is_self = compiled_.isOfRobot(pair);
    e.a = collision::SceneAccess::geometryIndex(scene_, pair.body_a, pair.geometry_a);
    e.b = collision::SceneAccess::geometryIndex(scene_, pair.body_b, pair.geometry_b);
    e.motion = known.motion;
    e.rounding = (piece(e.b).link >= 0 ? 2 : 1) * model_.rounding;
    if (known.is_reversed) std::swap(e.a, e.b);
    // All coordinates that a relative pose is made from are within this of their frame's origin.
    const double scale = 2 * model_.reach + piece(e.a).scale + piece(e.b).scale;
    e.rounding += collision::kTransferRounding * scale;
    e.threshold = pair.margin + e.rounding;
    e.by_surfaces = sweepsSurfaces(piece(e.a), piece(e.b), pair.margin);
    edges_.has_surface_pairs = edges_.has_surface_pairs || e.by_surfaces;
    if (known.gap != nullptr && static_cast<double>(known.most_gap) > e.threshold) {
      e.gap = static_cast<int>(edges_.gaps.size());
      edges_.gaps.push_back(known.gap);
    }
    return e;
  }

  /// Stable, by counting.
  void sortPairs(std::span<const EdgePair> pairs) {
    std::vector<std::size_t> places(edges_.pieces.size() + 1, 0);
    for (const EdgePair& e : pairs) ++places[at(e.a) + 1];
    std::partial_sum(places.begin(), places.end(), places.begin());
    edges_.pairs.resize(pairs.size());
    for (const EdgePair& e : pairs) edges_.pairs[places[at(e.a)]++] = e;
  }

  const CompiledScene& compiled_;
  const collision::Scene& scene_;
  const EdgeModel& model_;
  EdgeScene& edges_;
};

}  // namespace

EdgeScene::EdgeScene(const CompiledScene& scene) { Builder(scene, *this).build(); }

}  // namespace leeway::planner
