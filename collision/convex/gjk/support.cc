#include "collision/convex/gjk/support.h"

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"

namespace leeway::collision {

Curvature curvatureAt(const ConvexView& view, const Vector& direction) {
  Curvature k;
  switch (view.core) {
    case Core::kEllipsoid: {
      // p = S^2 d / |S d|, so that dp = (S^2 - p p^T) / |S d|, with d in its null space: its axes
      // across d are those of a symmetric 2 x 2 matrix.
      const Vector squared = view.size.cwiseProduct(view.size);
      const Vector scaled = view.size.cwiseProduct(direction);
      const double norm = scaled.norm();
      if (!(norm > kAcrossAxisSquared)) return k;
      const Vector p = squared.cwiseProduct(direction) / norm;
      const auto [u, v] = tangentsAt(direction);
      const double pu = p.dot(u), pv = p.dot(v);
      const double uu = (squared.cwiseProduct(u).dot(u) - pu * pu) / norm;
      const double vv = (squared.cwiseProduct(v).dot(v) - pv * pv) / norm;
      const double uv = (squared.cwiseProduct(u).dot(v) - pu * pv) / norm;
      // One Jacobi rotation makes it diagonal.
      const double half = 0.5 * (uu - vv), root = std::sqrt(half * half + uv * uv);
      const double mean = 0.5 * (uu + vv);
      double c = 1, s = 0;
      if (root > 0) {
        const double cosine = half / root;
        c = std::sqrt(0.5 * (1 + cosine));
        s = std::copysign(std::sqrt(0.5 * (1 - cosine)), uv);
      }
      k.axis[0] = c * u + s * v;
      k.axis[1] = c * v - s * u;
      k.strength[0] = std::max(mean + root, 0.0);
      k.strength[1] = std::max(mean - root, 0.0);
      return k;
    }
    case Core::kCylinder:
    case Core::kCone: {
      const double across_squared = direction.x() * direction.x() + direction.y() * direction.y();
      if (!(across_squared > kAcrossAxisSquared)) return k;
      const double across = std::sqrt(across_squared);
      if (view.core == Core::kCone && 2 * direction.z() * view.size.z() >= view.size.x() * across) {
        return k;  // the apex
      }
      k.axis[0] = Vector(-direction.y() / across, direction.x() / across, 0);
      k.strength[0] = view.size.x() / across;
      return k;
    }
    default:
      return k;
  }
}

Vector farthestOfRound(const ConvexView& view, const Vector& direction, int& piece) {
  piece = 0;
  if (view.core == Core::kEllipsoid) {
    const Vector scaled = view.size.cwiseProduct(direction);
    const double norm_squared = scaled.squaredNorm();
    // Relative to the largest axis, as kAcrossAxisSquared is to a radius.
    if (!(norm_squared > kAcrossAxisSquared * view.extent * view.extent) ||
        !(norm_squared > kLeastSquare)) {
      return Vector::Zero();
    }
    return view.size.cwiseProduct(scaled) / std::sqrt(norm_squared);
  }
  const double across_squared = direction.x() * direction.x() + direction.y() * direction.y();
  double z = std::copysign(view.size.z(), direction.z());
  const bool off_axis = across_squared > kAcrossAxisSquared;
  const double across = std::sqrt(across_squared);
  if (view.core == Core::kCone) {
    if (2 * direction.z() * view.size.z() >= view.size.x() * across) {
      piece = 1;
      return {0, 0, view.size.z()};
    }
    z = -view.size.z();
  }
  if (view.core == Core::kCylinder) piece = std::signbit(direction.z()) ? 0 : 1;
  if (!off_axis) return {0, 0, z};
  const double s = view.size.x() / across;
  return {s * direction.x(), s * direction.y(), z};
}

bool farthestOfPiece(const ConvexView& view, const Vector& direction, int piece, Vector& p) {
  switch (view.core) {
    case Core::kEllipsoid:
      p = farthestOfRound(view, direction, piece);
      return true;
    case Core::kCylinder:
    case Core::kCone: {
      if (view.core == Core::kCone && piece == 1) {
        p = Vector(0, 0, view.size.z());
        return true;
      }
      const double across_squared = direction.x() * direction.x() + direction.y() * direction.y();
      // Nearly along the axis the whole rim is equally far, so points stay where they were found.
      if (!(across_squared > kFollowRimSquared)) return false;
      const double s = view.size.x() / std::sqrt(across_squared);
      p = Vector(s * direction.x(), s * direction.y(), piece == 1 ? view.size.z() : -view.size.z());
      return true;
    }
    default:
      return vertex(view, piece, p);
  }
}

}  // namespace leeway::collision
