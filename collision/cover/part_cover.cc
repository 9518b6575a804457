// Concave meshes as a few convex hulls.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/cover/ball_cover.h"
#include "collision/cover/face_parts.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/hull_distance.h"
#include "collision/shapes/hull_of_part.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Slices of a part across an axis, at whose boundaries the part may be cut; and directions around
/// the axis in which their widths are measured [count].
constexpr int kSlices = 16;
constexpr int kDirections = 12;

/// A cut must save this share of the measure of the whole mesh's hull.
constexpr double kLeastSaving = 0.02;

/// Limit on the faces of a part that are measured [count]. Only the choice of cuts depends on it.
constexpr std::size_t kMeasuredFaces = 4000;

/// Supports of a part's slices across an axis, in each direction.
class Profile {
 public:
  Profile(const Polygons& faces, Index axis) : u_((axis + 1) % 3), v_((axis + 2) % 3) {
    for (const Vector3d& p : faces.corners()) {
      low_ = std::min(low_, p[axis]);
      high_ = std::max(high_, p[axis]);
    }
    for (int d = 0; d < kDirections; ++d)
      sineCosine(kTwoPi * d / kDirections, sine_[at(d)], cosine_[at(d)]);
    for (auto& slice : reach_) slice.fill(-kInfinity);
    if (!(high_ > low_)) return;
    const std::size_t step = std::max<std::size_t>(1, faces.size() / kMeasuredFaces);
    for (std::size_t f = 0; f < faces.size(); f += step) {
      const std::span<const Vector3d> face = faces[f];
      for (std::size_t i = 0; i < face.size(); ++i)
        addEdge(face[i], face[(i + 1) % face.size()], axis);
    }
  }

  double boundary(int slice) const { return low_ + (high_ - low_) * slice / kSlices; }

  /// Measure of the hull of slices [begin, end): the widths of its sections, summed along the axis
  /// [m^2]. 0 if it is empty.
  double measure(int begin, int end) const {
    double sum = 0;
    for (int d = 0; d < kDirections; ++d) sum += envelope(begin, end, d);
    return sum * (high_ - low_) / kSlices;
  }

 private:
  void addEdge(const Vector3d& p, const Vector3d& q, Index axis) {
    const double scale = kSlices / (high_ - low_);
    const double from = (p[axis] - low_) * scale, to = (q[axis] - low_) * scale;
    const auto sliceOf = [](double x) {
      return static_cast<int>(std::clamp(x, 0.0, kSlices - 1.0));
    };
    const int last = sliceOf(std::max(from, to));
    for (int k = sliceOf(std::min(from, to)); k <= last; ++k) {
      for (int end = 0; end < 2; ++end) {
        const double rise = to - from;
        const double t =
            std::abs(rise) > 1e-9 ? std::clamp((k + end - from) / rise, 0.0, 1.0) : end;
        const double x = p[u_] + t * (q[u_] - p[u_]), y = p[v_] + t * (q[v_] - p[v_]);
        for (std::size_t d = 0; d < kDirections; ++d)
          reach_[at(k)][d] = std::max(reach_[at(k)][d], cosine_[d] * x + sine_[d] * y);
      }
    }
  }

  /// The sum over slices [begin, end) of the least concave sequence above their supports.
  double envelope(int begin, int end, int direction) const {
    std::array<int, kSlices> corner{};
    int corners = 0;
    const auto value = [&](int k) { return reach_[at(k)][at(direction)]; };
    for (int k = begin; k < end; ++k) {
      if (!(value(k) > -kInfinity)) continue;
      while (corners > 1) {
        const int i = corner[at(corners - 2)], j = corner[at(corners - 1)];
        if ((value(j) - value(i)) * (k - i) > (value(k) - value(i)) * (j - i)) break;
        --corners;
      }
      corner[at(corners++)] = k;
    }
    double sum = corners > 0 ? value(corner[0]) : 0;
    for (int c = 1; c < corners; ++c) {
      const int i = corner[at(c - 1)], j = corner[at(c)];
      const double step = (value(j) - value(i)) / (j - i);
      for (int k = i + 1; k <= j; ++k) sum += value(i) + step * (k - i);
    }
    return sum;
  }

  Index u_, v_;
  double low_ = kInfinity, high_ = -kInfinity;
  std::array<double, kDirections> sine_{}, cosine_{};
  std::array<std::array<double, kDirections>, kSlices> reach_{};
};

/// A cut of a part and what it saves [m^2]; 0 if there is none.
struct Cut {
  double saved = 0;
  Index axis = 0;
  double place = 0;
};

struct MeshPart {
  Polygons faces;
  std::array<Cut, 3> cuts;  ///< across each axis
};

Cut bestCut(const Polygons& faces, Index axis) {
  const Profile profile(faces, axis);
  const double whole = profile.measure(0, kSlices);
  Cut best{0, axis, 0};
  for (int k = 1; k < kSlices; ++k) {
    const double saved = whole - profile.measure(0, k) - profile.measure(k, kSlices);
    if (saved > best.saved) best = {saved, axis, profile.boundary(k)};
  }
  return best;
}

MeshPart partOf(Polygons faces) {
  MeshPart part;
  part.faces = std::move(faces);
  for (Index axis = 0; axis < 3; ++axis)
    part.cuts[static_cast<std::size_t>(axis)] = bestCut(part.faces, axis);
  return part;
}

std::pair<MeshPart, MeshPart> divide(const MeshPart& part, const Cut& cut) {
  return {partOf(clipped(part.faces, cut.axis, cut.place, -1)),
          partOf(clipped(part.faces, cut.axis, cut.place, 1))};
}

CoverPart coverOfPart(const MeshPart& part, double extent) {
  CoverPart cover;
  cover.ball = ballAround(part.faces.corners());
  const std::shared_ptr<const ConvexHull> hull = hullOfPart(part.faces.corners());
  const std::span<const Vector3d> vertices = hull->vertices();
  PointCover& points = cover.points;
  points.own = false;
  const HullBuilder few(vertices, kCoverPoints);
  for (const std::int32_t i : few.vertices()) points.points.push_back(vertices[at(i)]);
  for (const std::int32_t i : few.outside())
    points.radius = std::max(points.radius, distanceFromHull(vertices[at(i)], vertices, few));
  if (vertices.size() <= kMostHullPoints && vertices.size() > points.points.size())
    points.fine.assign(vertices.begin(), vertices.end());
  // Corners from clipping are rounded.
  const double rounding = kTransferRounding * extent;
  points.radius += rounding;
  points.fine_radius = rounding;
  clusterFine(points);
  return cover;
}

}  // namespace

std::vector<CoverPart> coverWithParts(const Shape& shape, int count) {
  std::vector<CoverPart> cover;
  if (shape.type() != ShapeType::kMesh || !(shape.mesh()->hullExcess() > kLeastConcavity))
    return cover;
  Polygons faces = polygonsOf(*shape.mesh());
  const double least = kLeastSaving * Profile(faces, 0).measure(0, kSlices);
  std::vector<MeshPart> parts;
  parts.push_back(partOf(std::move(faces)));
  std::array<bool, 3> axes = {true, true, true}, used = {};
  while (static_cast<int>(parts.size()) < count) {
    Cut best;
    std::size_t divided = 0;
    for (std::size_t i = 0; i < parts.size(); ++i)
      for (const Cut& cut : parts[i].cuts)
        if (axes[static_cast<std::size_t>(cut.axis)] && cut.saved > best.saved) {
          best = cut;
          divided = i;
        }
    if (!(best.saved > least)) break;
    used[static_cast<std::size_t>(best.axis)] = true;
    if (std::count(used.begin(), used.end(), true) == 2) axes = used;
    std::pair<MeshPart, MeshPart> sides = divide(parts[divided], best);
    parts[divided] = std::move(sides.first);
    parts.push_back(std::move(sides.second));
  }
  if (parts.size() == 1) return cover;
  for (const MeshPart& part : parts) cover.push_back(coverOfPart(part, shape.extent()));
  return cover;
}

}  // namespace leeway::collision
