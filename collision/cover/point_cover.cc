#include "collision/cover/point_cover.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr int kCircle = 12;  // corners of the polygon in a circle

void addCircle(double radius, double z, std::vector<Vector3d>& points) {
  for (int i = 0; i < kCircle; ++i) {
    double sine = 0, cosine = 0;
    sineCosine(kTwoPi * i / kCircle, sine, cosine);
    points.emplace_back(radius * cosine, radius * sine, z);
  }
}

/// Largest distance of the circle from its polygon, rounded up: radius (1 - cos(pi / 12)).
double outsideOfCircle(double radius) { return 0.0340742 * radius; }

void addBox(const Vector3d& half, std::vector<Vector3d>& points) {
  for (int i = 0; i < 8; ++i)
    points.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                        (i & 4) != 0 ? half.z() : -half.z());
}

/// Greedy choice of a hull's vertices by their distances from the hull of those already chosen.
class VertexChoice {
 public:
  VertexChoice(std::span<const Vector3d> vertices, std::size_t most)
      : vertices_(vertices), most_(most) {
    for (int axis = 0; axis < 3; ++axis) {
      choose(farthest(Vector3d::Unit(axis)));
      choose(farthest(-Vector3d::Unit(axis)));
    }
    for (std::size_t v = 0; v < vertices.size(); ++v) farthest_.push_back({distanceOf(v), v});
    std::make_heap(farthest_.begin(), farthest_.end());
  }

  PointCover run() {
    // Distances from the hull only shrink as it grows, so only the farthest is computed again.
    double farthest = 0;
    while (true) {
      farthest = farthest_.front().distance;
      if (farthest <= kPointCoverRadius) break;
      std::pop_heap(farthest_.begin(), farthest_.end());
      Far& last = farthest_.back();
      last.distance = distanceOf(last.vertex);
      const bool is_farthest = last.distance >= farthest;
      if (is_farthest && chosen_.size() >= most_) break;
      if (is_farthest) {
        choose(last.vertex);
        last.distance = 0;
      }
      std::push_heap(farthest_.begin(), farthest_.end());
    }
    PointCover cover;
    cover.points = chosen_;
    cover.radius = farthest;
    return cover;
  }

 private:
  /// A vertex, and an upper bound on its distance from the hull of those chosen [m].
  struct Far {
    double distance;
    std::size_t vertex;
    /// Among equally far vertices, the first one counts as the farthest.
    bool operator<(const Far& other) const {
      return distance != other.distance ? distance < other.distance : vertex > other.vertex;
    }
  };

  std::size_t farthest(const Vector3d& direction) const {
    std::size_t best = 0;
    for (std::size_t v = 1; v < vertices_.size(); ++v)
      if (direction.dot(vertices_[v]) > direction.dot(vertices_[best])) best = v;
    return best;
  }

  void choose(std::size_t v) {
    if (std::find(chosen_.begin(), chosen_.end(), vertices_[v]) == chosen_.end() &&
        chosen_.size() < most_)
      chosen_.push_back(vertices_[v]);
  }

  double distanceOf(std::size_t v) {
    if (std::find(chosen_.begin(), chosen_.end(), vertices_[v]) != chosen_.end()) return 0;
    const ConvexView hull = viewOfPoints(chosen_.data(), static_cast<int>(chosen_.size()), 0);
    Pose X_HP;
    X_HP.translation = vertices_[v];
    DistanceRequest request;
    request.depth = false;
    request.tolerance = 1e-2 * kPointCoverRadius;
    const DistanceResult r = convexDistance(ConvexView{}, X_HP, hull, request, scratch_, nullptr);
    return std::max(r.distance.upper, 0.0);
  }

  std::span<const Vector3d> vertices_;
  std::size_t most_;
  std::vector<Far> farthest_;  // a heap of all vertices
  std::vector<Vector3d> chosen_;
  Scratch scratch_;
};

/// Adds all vertices of a hull as fine points, if there are more of them than chosen ones.
void addFine(std::span<const Vector3d> vertices, double excess, PointCover& cover) {
  if (vertices.size() > kMostHullPoints || vertices.size() <= cover.points.size()) return;
  cover.fine.assign(vertices.begin(), vertices.end());
  cover.fine_radius = excess;
}

/// Splits fine[begin, end) into at most `most` clusters; appends their ends.
void halve(std::vector<Vector3d>& fine, std::size_t begin, std::size_t end, int most,
           std::vector<int>& ends) {
  if (end - begin <= kClusterPoints || most < 2) {
    ends.push_back(static_cast<int>(end));
    return;
  }
  const auto place = [&](std::size_t i) { return fine.begin() + static_cast<std::ptrdiff_t>(i); };
  Eigen::AlignedBox3d box;
  std::for_each(place(begin), place(end), [&](const Vector3d& p) { box.extend(p); });
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t middle = (begin + end) / 2;
  std::sort(place(begin), place(end), [axis](const Vector3d& x, const Vector3d& y) {
    return x[axis] != y[axis]
               ? x[axis] < y[axis]
               : std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end());
  });
  halve(fine, begin, middle, most / 2, ends);
  halve(fine, middle, end, most / 2, ends);
}

}  // namespace

void clusterFine(PointCover& cover) {
  cover.clusters.clear();
  cover.nearest.clear();
  if (cover.fine.empty()) return;
  halve(cover.fine, 0, cover.fine.size(), kMostClusters, cover.clusters);
  for (const Vector3d& p : cover.points) {
    const auto next = std::min_element(cover.fine.begin(), cover.fine.end(),
                                       [&p](const Vector3d& x, const Vector3d& y) {
                                         return (x - p).squaredNorm() < (y - p).squaredNorm();
                                       });
    cover.nearest.push_back(static_cast<int>(next - cover.fine.begin()));
  }
}

PointCover coverWithPoints(const Shape& shape, int count) {
  PointCover cover;
  switch (shape.type()) {
    case ShapeType::kSphere:
      cover.points.push_back(Vector3d::Zero());
      cover.radius = shape.radius();
      break;
    case ShapeType::kCapsule:
      cover.points.emplace_back(0, 0, shape.halfLength());
      cover.points.emplace_back(0, 0, -shape.halfLength());
      cover.radius = shape.radius();
      break;
    case ShapeType::kBox:
    case ShapeType::kEllipsoid:
      addBox(shape.halfExtents(), cover.points);
      cover.own = shape.type() == ShapeType::kBox;
      break;
    case ShapeType::kCylinder:
      addCircle(shape.radius(), shape.halfLength(), cover.points);
      addCircle(shape.radius(), -shape.halfLength(), cover.points);
      cover.radius = outsideOfCircle(shape.radius());
      break;
    case ShapeType::kCone:
      addCircle(shape.radius(), -shape.halfLength(), cover.points);
      cover.points.emplace_back(0, 0, shape.halfLength());
      cover.radius = outsideOfCircle(shape.radius());
      break;
    case ShapeType::kConvexHull:
      cover = VertexChoice(shape.hull()->vertices(), static_cast<std::size_t>(count)).run();
      addFine(shape.hull()->vertices(), 0, cover);
      break;
    case ShapeType::kMesh: {
      const MeshTree& tree = shape.mesh()->tree();
      const ConvexView core = tree.nodeView(tree.node(0));
      cover.points.assign(core.points, core.points + core.count);
      cover.radius = core.excess;
      const ConvexView hull = tree.hullView();
      addFine({hull.points, static_cast<std::size_t>(hull.count)}, hull.excess, cover);
      break;
    }
    case ShapeType::kHalfSpace:
    case ShapeType::kDeformable:
      break;
  }
  if (!cover.points.empty()) {
    cover.radius += 16 * kUnitRoundoff * (shape.extent() + cover.radius);
    cover.fine_radius += 16 * kUnitRoundoff * (shape.extent() + cover.fine_radius);
    clusterFine(cover);
  }
  return cover;
}

}  // namespace leeway::collision
