#include "robots/mesh/triangulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "collision/base/numbers.h"
#include "robots/base/tolerances.h"
#include "robots/mesh/ear_clipping.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using Triangle = CutMesh::Triangle;

class Cutter {
 public:
  Cutter(FileMesh& mesh, Bent bent) : mesh_(mesh), bent_(bent) {
    result_.triangles.reserve(mesh.faces.size());
  }

  CutMesh run() {
    for (const FileMesh::Face& face : mesh_.faces) {
      if (face.count == 3) {
        const std::int32_t* const c = &mesh_.corners[at(face.first)];
        result_.triangles.push_back({c[0], c[1], c[2]});
      } else {
        cut(face);
      }
    }
    return std::move(result_);
  }

 private:
  void cut(const FileMesh::Face& face) {
    points_.clear();
    for (const std::int32_t corner : mesh_.cornersOf(face))
      points_.push_back(mesh_.vertices[at(corner)]);
    measure();
    const bool is_convex = face.count == 4 && isConvexQuadrangle();
    if (is_convex) {
      cut_.triangles = {{0, 1, 2}, {0, 2, 3}};
      cut_.crossing = 0;
    } else {
      cut_ = cutPolygon(points_);
    }
    const std::int32_t* const c = &mesh_.corners[at(face.first)];
    for (const auto& [i, j, k] : cut_.triangles)
      result_.triangles.push_back({c[at(i)], c[at(j)], c[at(k)]});
    // The comparisons are written so that NaN is counted.
    if (!(cut_.crossing <= tolerance_))
      count(cut_.crossing * Vector3d::UnitX(), face, result_.crossing);
    if (departure_ <= tolerance_) return;
    count(departure_ * normal_, face, result_.bent);
    if (bent_ == Bent::kCut) return;
    if (is_convex)
      coverByTetrahedron();
    else
      coverBySlab();
  }

  static void count(const Vector3d& departure, const FileMesh::Face& face, FaceCount& counted) {
    if (counted.count++ == 0) counted.first = face.place;
    if (departure.squaredNorm() > counted.largest.squaredNorm()) counted.largest = departure;
  }

  /// Computes the polygon's plane, its thickness, and the limit on the thickness of planar
  /// polygons.
  void measure() {
    const Vector3d normal = polygonNormal(points_);
    const double length = normal.norm();
    normal_ = length > 0 ? Vector3d(normal / length) : Vector3d::Zero();
    double least = 0, most = 0, largest = 0, size = 0;
    for (const Vector3d& p : points_) {
      const double height = normal_.dot(p - points_[0]);
      least = std::min(least, height);
      most = std::max(most, height);
      largest = std::max(largest, p.cwiseAbs().maxCoeff());
      size = std::max(size, (p - points_[0]).cwiseAbs().maxCoeff());
    }
    rounding_ = kPlanarRounding * largest;
    departure_ = most - least;
    tolerance_ = kPlanarShare * std::clamp(largest, size, kPlanarOffset * size) + rounding_;
  }

  /// Whether the polygon has four corners, each with the polygon's orientation by more than
  /// rounding.
  bool isConvexQuadrangle() const {
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3d before = points_[i] - points_[(i + 3) % 4],
                     after = points_[(i + 1) % 4] - points_[i];
      if (!(before.cross(after).dot(normal_) > tolerance_ * (before.norm() + after.norm())))
        return false;
    }
    return true;
  }

  std::int32_t addVertex(const Vector3d& p) {
    mesh_.vertices.push_back(p);
    return static_cast<std::int32_t>(mesh_.vertices.size() - 1);
  }

  /// Covers the polygon by the tetrahedron of its four corners, whose faces are the triangles of
  /// both diagonals. The tetrahedron is made a little larger, so that it shares no corner with the
  /// polygon and its edges do not belong to a surface that is closed without it.
  void coverByTetrahedron() {
    const Vector3d middle = 0.25 * (points_[0] + points_[1] + points_[2] + points_[3]);
    const double beyond = 1e-3 * departure_ + 4 * rounding_;
    std::int32_t v[4];
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3d out = points_[i] - middle;
      v[i] = addVertex(points_[i] + beyond * out.normalized() +
                       std::copysign(rounding_, out.dot(normal_)) * normal_);
    }
    for (const Triangle& t : {Triangle{0, 1, 2}, {0, 2, 3}, {1, 0, 3}, {2, 1, 3}})
      result_.triangles.push_back({v[t[0]], v[t[1]], v[t[2]]});
  }

  /// Covers the polygon by its triangles on both sides, at the distance of its thickness, and by
  /// walls along its edges, except bridges, which it traverses twice.
  void coverBySlab() {
    const Vector3d offset = ((1 + 1e-9) * departure_ + rounding_) * normal_;
    const auto count = static_cast<std::int32_t>(points_.size());
    const auto first = static_cast<std::int32_t>(mesh_.vertices.size());
    for (const Vector3d& p : points_) addVertex(p + offset);
    for (const Vector3d& p : points_) addVertex(p - offset);
    for (const auto& [i, j, k] : cut_.triangles) {
      result_.triangles.push_back({first + i, first + j, first + k});
      result_.triangles.push_back({first + count + k, first + count + j, first + count + i});
    }
    const std::vector<std::int32_t> place = placesOf();
    std::multiset<std::pair<std::int32_t, std::int32_t>> walls;
    for (std::int32_t i = 0; i < count; ++i) {
      const std::int32_t from = place[at(i)], to = place[at((i + 1) % count)];
      if (from == to) continue;
      if (const auto back = walls.find({to, from}); back != walls.end())
        walls.erase(back);
      else
        walls.emplace(from, to);
    }
    for (const auto& [from, to] : walls) {
      const std::int32_t a = first + from, b = first + to;
      result_.triangles.push_back({a + count, b + count, b});
      result_.triangles.push_back({a + count, b, a});
    }
  }

  /// For each corner, the first one at the same place.
  std::vector<std::int32_t> placesOf() const {
    std::vector<std::int32_t> order(points_.size()), place(points_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
    const auto isBefore = [&](std::int32_t a, std::int32_t b) {
      const Vector3d &p = points_[at(a)], &q = points_[at(b)];
      return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    };
    std::stable_sort(order.begin(), order.end(), isBefore);
    for (std::size_t i = 0; i < order.size(); ++i)
      place[at(order[i])] = i > 0 && points_[at(order[i])] == points_[at(order[i - 1])]
                                ? place[at(order[i - 1])]
                                : order[i];
    return place;
  }

  FileMesh& mesh_;
  Bent bent_;
  CutMesh result_;
  // The current polygon:
  std::vector<Vector3d> points_;
  Vector3d normal_;
  double departure_ = 0, tolerance_ = 0, rounding_ = 0;
  CutPolygon cut_;
};

}  // namespace

CutMesh triangulate(FileMesh& mesh, Bent bent) { return Cutter(mesh, bent).run(); }

}  // namespace leeway::robots
