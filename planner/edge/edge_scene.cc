// Pieces and pairs of a compiled scene, in the form that edges use.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"
#include "collision/sweep/mesh_sweep.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"
#include "planner/compiled/prepared_robot.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {
namespace {

/// Whether a planned floating or planar joint carries a link. A joint that only places an arm in
/// its world is not planned.
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

/// Whether the pair is two meshes, one of which moves freely. Links of an arm stay near each other
/// and near its base and move little there, so sweeps of their hulls decide. Against a convex
/// obstacle, sweeps of convex pieces do.
bool sweepsSurfaces(const Piece& a, const Piece& b, double margin) {
  if (!(margin >= 0) || a.is_free_mesh == b.is_free_mesh) return false;
  const Piece& still = a.is_free_mesh ? b : a;
  return still.link < 0 && still.shape().type() == collision::ShapeType::kMesh &&
         collision::sweepsMesh(a.shape(), b.shape());
}

/// Rounding error of the poses of a pair's pieces [m].
double roundingOf(const EdgeModel& model, const Piece& a, const Piece& b) {
  // All coordinates that enter a relative pose are within this of their frame's origin.
  const double scale = 2 * model.reach + a.scale + b.scale;
  return (a.link >= 0 && b.link >= 0 ? 2 : 1) * model.rounding +
         collision::kTransferRounding * scale;
}

/// A geometry of a body, without the data that only moving pieces or only pieces of the world have.
Piece pieceOf(const CompiledScene& scene, int body, int geometry) {
  Piece piece;
  piece.body = body;
  piece.link = scene.bodyLink(body);
  piece.stored = collision::SceneAccess::geometry(scene.scene(), body, geometry);
  const collision::Geometry& g = piece.geometry();
  piece.at_origin = g.X_BG.rotation == Eigen::Matrix3d::Identity() &&
                    g.X_BG.translation == Eigen::Vector3d::Zero();
  return piece;
}

/// Piece::scale of a piece of the world.
double scaleOf(const CompiledScene& scene, const Piece& piece) {
  const collision::Pose& X_WB = scene.scene().bodies()[at(piece.body)].X_WB;
  const collision::Pose X_WG = piece.at_origin ? X_WB : X_WB * piece.geometry().X_BG;
  return (X_WG.rotation.transpose() * X_WG.translation).lpNorm<1>() +
         piece.bounds().outer.center.lpNorm<1>();
}

/// The pair of a moving piece with a static piece, which is in the world.
EdgePair pairWithWorld(const CompiledScene& scene, int a, const Piece& of_a, int b,
                       const Piece& of_b, double margin) {
  EdgePair e{};
  e.a = a;
  e.b = b;
  e.motion = scene.edgeModel().robot->motions().of_world[at(a)];
  e.rounding = roundingOf(scene.edgeModel(), of_a, of_b);
  e.threshold = margin + e.rounding;
  e.by_surfaces = sweepsSurfaces(of_a, of_b, margin);
  e.gap = -1;
  return e;
}

}  // namespace

class EdgeSceneBuilder {
 public:
  EdgeSceneBuilder(const CompiledScene& scene, EdgeScene& edges)
      : compiled_(scene),
        scene_(scene.scene()),
        model_(scene.edgeModel()),
        edges_(edges),
        pairs_(edges.pairs) {}

  void build() {
    const collision::ScenePairs& all = scene_.pairs();
    const std::size_t end = all.places() > 0 ? at(all.firstStill()) : scene_.bodies().size();
    edges_.pieces.scene_ = &compiled_;
    edges_.pieces.listed_.reserve(collision::SceneAccess::geometryCount(scene_) - all.places());
    for (std::size_t b = 0; b < end; ++b)
      for (std::size_t g = 0; g < scene_.bodies()[b].size(); ++g)
        addPiece(static_cast<int>(b), static_cast<int>(g));
    addPairs();
    addRows();
    for (const EdgePair& pair : pairs_.listed_) {
      edges_.has_surface_pairs = edges_.has_surface_pairs || pair.by_surfaces;
      pairs_.most_rounding_ = collision::greatest(pairs_.most_rounding_, pair.rounding);
    }
    findNearAnywhere();
    const double of_world = all.leastMargin(compiled_.bodiesOfRobot(), true),
                 of_robot = all.leastMargin(compiled_.bodiesOfRobot(), false);
    static_assert(static_cast<int>(Pairs::kWorld) == 1 && static_cast<int>(Pairs::kSelf) == 2);
    edges_.least_margin_ = {std::min(of_world, of_robot), of_world, of_robot};
  }

 private:
  Piece piece(int i) const { return edges_.pieces[at(i)]; }
  const Piece& listed(int i) const { return edges_.pieces.listed_[at(i)]; }

  void addPiece(int body, int geometry) {
    const auto index = static_cast<int>(edges_.pieces.listed().size());
    Piece piece = pieceOf(compiled_, body, geometry);
    if (piece.link >= 0) {
      piece.is_free_mesh = piece.shape().type() == collision::ShapeType::kMesh &&
                           isCarriedFreely(compiled_, piece.link);
      piece.moving = static_cast<int>(edges_.moving.size());
      edges_.moving.push_back(index);
    } else {
      piece.scale = scaleOf(compiled_, piece);
    }
    edges_.pieces.listed_.push_back(piece);
  }

  /// Adds pairs ordered by their first piece, then as in the scene, by counting sort.
  void addPairs() {
    const collision::ScenePairs& all = scene_.pairs();
    std::vector<EdgePair> in_scene_order;
    in_scene_order.reserve(all.listedCount());
    // The position of the next pair of each piece.
    std::vector<std::size_t> places(edges_.pieces.listed().size() + 1, 0);
    for (std::size_t p = 0; p < all.listedCount(); ++p) {
      in_scene_order.push_back(pairOf(static_cast<int>(p)));
      ++places[at(in_scene_order.back().a) + 1];
    }
    std::partial_sum(places.begin(), places.end(), places.begin());
    pairs_.listed_.resize(in_scene_order.size());
    for (const EdgePair& pair : in_scene_order) pairs_.listed_[places[at(pair.a)]++] = pair;
  }

  EdgePair pairOf(int p) {
    const collision::ScenePair pair = scene_.pairs()[at(p)];
    const int a = collision::SceneAccess::geometryIndex(scene_, pair.body_a, pair.geometry_a);
    const int b = collision::SceneAccess::geometryIndex(scene_, pair.body_b, pair.geometry_b);
    EdgePair e{};
    if (!compiled_.isOfRobot(pair)) {
      e = pairWithWorld(compiled_, a, listed(a), b, listed(b), pair.margin);
      e.scene_pair = p;
      return e;
    }
    const EdgeModel::Pair& known = model_.pairs[next_of_robot_++];
    e.scene_pair = p;
    e.is_self = true;
    e.is_reversed = known.is_reversed;
    e.a = known.is_reversed ? b : a;
    e.b = known.is_reversed ? a : b;
    e.motion = known.motion;
    e.rounding = roundingOf(model_, listed(e.a), listed(e.b));
    e.threshold = pair.margin + e.rounding;
    e.by_surfaces = sweepsSurfaces(listed(e.a), listed(e.b), pair.margin);
    e.gap = -1;
    if (known.gap >= 0 && model_.gaps[at(known.gap)].most > e.threshold) e.gap = known.gap;
    return e;
  }

  void addRows() {
    const collision::ScenePairs& all = scene_.pairs();
    pairs_.compiled_ = &compiled_;
    pairs_.edges_ = &edges_;
    pairs_.size_ = all.size();
    pairs_.numbers_ = all.numbers();
    if (all.places() == 0) return;
    pairs_.first_still_ = collision::SceneAccess::geometryIndex(scene_, all.firstStill(), 0);
    const std::span<const std::int32_t> added = collision::SceneAccess::added(scene_);
    const bool has_mesh = std::any_of(added.begin(), added.end(), [&](std::int32_t place) {
      const Piece still = piece(pairs_.pieceIn(at(place)));
      return still.shape().type() == collision::ShapeType::kMesh;
    });
    Piece farthest;
    farthest.scale = collision::SceneAccess::scaleOfStill(scene_);
    for (std::size_t r = 0; r < all.rows().size(); ++r) {
      const collision::ScenePairs::Row& of = all.rows()[r];
      EdgePairs::Row row{};
      row.piece = collision::SceneAccess::geometryIndex(scene_, of.body, of.geometry);
      row.motion = model_.robot->motions().of_world[at(row.piece)];
      const double rounding = roundingOf(model_, piece(row.piece), farthest);
      row.most_threshold = collision::greatest(0, of.most + rounding);
      pairs_.most_rounding_ = collision::greatest(pairs_.most_rounding_, rounding);
      pairs_.rows_.push_back(row);
      if (has_mesh && piece(row.piece).is_free_mesh) findSurfacePairs(r);
    }
  }

  void findNearAnywhere() {
    const collision::ScenePairs& all = scene_.pairs();
    std::vector<int>& near = edges_.near_anywhere;
    near.resize(all.listedCount());
    std::iota(near.begin(), near.end(), 0);
    if (all.numbers() > kManyPairs) return;
    near.reserve(all.size());
    for (std::size_t row = 0; row < all.rows().size(); ++row)
      for (std::size_t place = 0; place < all.places(); ++place)
        if (const std::int32_t number = all.numberOf(row, place); number >= 0)
          near.push_back(number);
  }

  void findSurfacePairs(std::size_t row) {
    const collision::ScenePairs& all = scene_.pairs();
    for (std::size_t place = 0; place < all.places() && !edges_.has_surface_pairs; ++place)
      if (const std::int32_t number = all.numberOf(row, place); number >= 0)
        edges_.has_surface_pairs = pairs_[at(number)].by_surfaces;
  }

  const CompiledScene& compiled_;
  const collision::Scene& scene_;
  const EdgeModel& model_;
  EdgeScene& edges_;
  EdgePairs& pairs_;
  std::size_t next_of_robot_ = 0;
};

Piece Pieces::inPlace(std::size_t i) const {
  const collision::Scene& scene = scene_->scene();
  const auto [body, geometry] = scene.pairs().geometryIn(i - listed_.size());
  Piece piece = pieceOf(*scene_, body, geometry);
  piece.scale = scaleOf(*scene_, piece);
  return piece;
}

EdgeScene::EdgeScene(const CompiledScene& scene) { EdgeSceneBuilder(scene, *this).build(); }

int EdgePairs::stillOf(std::size_t number) const {
  return pieceIn(compiled_->scene().pairs().placeOf(number).place);
}

Piece EdgePairs::pieceOf(std::size_t number) const { return edges_->pieces[at(stillOf(number))]; }

EdgePair EdgePairs::inTable(std::size_t number, const Piece& still) const {
  const collision::ScenePairs& all = compiled_->scene().pairs();
  const collision::ScenePairs::Place of = all.placeOf(number);
  const int piece = rows_[of.row].piece;
  EdgePair pair = pairWithWorld(*compiled_, piece, edges_->pieces.listed()[at(piece)],
                                pieceIn(of.place), still, all.marginOf(of));
  pair.scene_pair = static_cast<int>(number);
  return pair;
}

}  // namespace leeway::planner
