#include "collision/mesh/hull_proof.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/mesh/point_in_solid.h"

namespace leeway::collision {
namespace {

// A hull is flat if the largest ball in it is smaller than this share of its reach.
constexpr double kThin = 0.02;

// Triangles that use a vertex twice are not part of the surface around a solid, see components.h.
bool isProper(const TriangleMesh::Triangle& t) {
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

}  // namespace

HullProof::HullProof(const Surface& surface, double largest_excess, double& work_left)
    : surface_(surface),
      largest_excess_(largest_excess),
      work_left_(work_left),
      in_trial_(surface.mesh().vertices().size()),
      trial_number_(surface.mesh().vertices().size(), -1) {}

bool HullProof::accept(const SurfacePatch& patch, int component) {
  if (prove(patch, component, nullptr)) return true;
  if (!thin_) return false;
  Vector middle = Vector::Zero(), normal = Vector::Zero();
  double area = 0;
  for (const std::int32_t t : patch.triangles()) {
    const auto& corners = surface_.corners(t);
    const Vector &p = surface_.vertex(corners[0]), &q = surface_.vertex(corners[1]),
                 &r = surface_.vertex(corners[2]);
    const double a = cross(q - p, r - p).norm();
    middle += a / 3 * (p + q + r);
    normal += a * surface_.normal(t);
    area += a;
  }
  if (!(area > 0 && normal.norm() > 0)) return false;
  for (double depth = 0.25; depth > 0.01; depth *= 0.25) {
    Vector apex = middle / area - depth * std::sqrt(area) * normal.normalized();
    for (int k = 0; k < 3; ++k) {
      if (std::abs(apex[k]) < kSmallestExact) apex[k] = 0;
    }
    if (prove(patch, component, &apex)) return true;
  }
  return false;
}

bool HullProof::prove(const SurfacePatch& patch, int component, const Vector* apex) {
  culprit_ = -1;
  collectPoints(patch, apex);
  thin_ = trial_points_.size() < 4 || !trial_.build(trial_points_);
  if (thin_) return false;
  const ConvexView view = trial_.view();
  const double radius = inradius(view);
  thin_ = !(radius > kThin * trial_.reach());
  if (!(radius > 0)) return false;
  // A triangle this deep in the hull requires the largest excess.
  allowed_ = largest_excess_ * radius / trial_.reach();
  deepest_ = 0;
  best_facet_ = 0;
  for (const std::int32_t t : patch.triangles()) {
    if (!isShallow(t, view)) return false;
  }
  if (!areOthersShallow(patch, component, view)) return false;
  if (sideOf(surface_.mesh(), component, trial_.center()) != Side::kInside) return false;
  // A triangle no deeper than h along n, n . x >= max(n . hull) - h, does not intersect the
  // interior of the hull shrunk around its centre by the share h / radius. No point of the hull is
  // farther than that share of its reach from the shrunk hull.
  const double excess = deepest_ / radius * trial_.reach() * (1 + 16 * kUnitRoundoff);
  if (!(excess <= largest_excess_)) return false;
  excess_ = excess;
  std::swap(hull_, trial_);
  hull_allowed_ = allowed_;
  return true;
}

void HullProof::collectPoints(const SurfacePatch& patch, const Vector* apex) {
  trial_points_.clear();
  in_trial_.clear();
  for (const std::int32_t t : patch.triangles()) {
    for (const std::int32_t v : surface_.corners(t)) {
      if (in_trial_.has(v)) continue;
      in_trial_.add(v);
      trial_number_[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(trial_points_.size());
      trial_points_.push_back(surface_.vertex(v));
    }
  }
  if (apex != nullptr) trial_points_.push_back(*apex);
  work_left_ -= 1 + 2 * static_cast<double>(trial_points_.size());
}

// A lower bound on the distance of the trial hull's surface from its centre [m].
double HullProof::inradius(const ConvexView& view) {
  ConvexView point;
  point.core = Core::kPoint;
  Pose X;
  X.translation = trial_.center();
  DistanceRequest request;
  request.tolerance = 0.01 * trial_.reach();
  return -convexDistance(point, X, view, request, scratch_, nullptr).distance.upper;
}

DistanceResult HullProof::depthIn(std::int32_t t, const ConvexView& hull, double allowed) {
  const auto& c = surface_.corners(t);
  const Vector triangle[3] = {surface_.vertex(c[0]), surface_.vertex(c[1]), surface_.vertex(c[2])};
  DistanceRequest request;
  request.threshold = -allowed;
  request.tolerance = 0.1 * allowed;
  request.iteration_limit = 64;
  work_left_ -= 8 + 0.05 * hull.count;
  return convexDistance(viewOfPoints(triangle, 3, 0), Pose{}, hull, request, scratch_, nullptr);
}

// Whether triangle t is no deeper in the trial hull than allowed: in some direction, no point of
// the hull is farther than that above it. Facets near the triangle and its own normal are tried
// before the query.
bool HullProof::isShallow(std::int32_t t, const ConvexView& view) {
  double depth = kInfinity;
  if (depthBelowFacets(t, depth)) return true;
  if (depth > allowed_) depth = std::min(depth, depthAlongNormal(t));
  if (depth > allowed_) depth = std::min(depth, -depthIn(t, view, allowed_).distance.lower);
  if (depth > allowed_) return false;
  deepest_ = std::max(deepest_, depth);
  return true;
}

// The triangle's depth below the facets at its corners, and below the best facet for the previous
// triangle. True if the triangle is a facet itself; its depth is then exactly 0.
bool HullProof::depthBelowFacets(std::int32_t t, double& depth) {
  const auto& c = surface_.corners(t);
  const double rounding = 16 * kUnitRoundoff * trial_.size();
  const auto offer = [&](std::int32_t facet) {
    const PatchHull::Plane& plane = trial_.plane(facet);
    // Corners of triangles outside the patch may be far away.
    double deep = -kInfinity, far_squared = 0;
    for (const std::int32_t v : c) {
      const Vector down = plane.point - surface_.vertex(v);
      deep = std::max(deep, plane.normal.dot(down));
      far_squared = std::max(far_squared, down.squaredNorm());
    }
    deep += plane.doubt + 8 * kUnitRoundoff * (std::sqrt(far_squared) + trial_.size());
    if (deep < depth) {
      depth = deep;
      best_facet_ = facet;
    }
  };
  const auto numberOf = [&](std::int32_t v) {
    return in_trial_.has(v) ? trial_number_[static_cast<std::size_t>(v)] : -1;
  };
  const std::int32_t number[3] = {numberOf(c[0]), numberOf(c[1]), numberOf(c[2])};
  work_left_ -= 1;
  offer(best_facet_);
  for (std::size_t k = 0; k < 3 && depth > rounding; ++k) {
    if (number[k] < 0) continue;
    for (const std::int32_t facet : trial_.facetsAt(number[k])) {
      const auto& f = trial_.facets()[static_cast<std::size_t>(facet)];
      if (std::all_of(number, number + 3, [&](std::int32_t n) {
            return std::find(f.begin(), f.end(), n) != f.end();
          })) {
        best_facet_ = facet;
        return true;
      }
      offer(facet);
    }
  }
  return false;
}

// The triangle's depth along its own normal, to either side.
double HullProof::depthAlongNormal(std::int32_t t) {
  const auto& c = surface_.corners(t);
  const Vector& n = surface_.normal(t);
  const Vector& origin = surface_.vertex(c[0]);
  double high = -kInfinity, low = kInfinity, own_high = 0, own_low = 0, far_squared = 0;
  for (const Vector& p : trial_.corners()) {
    const Vector way = p - origin;
    const double h = n.dot(way);
    high = std::max(high, h);
    low = std::min(low, h);
    far_squared = std::max(far_squared, way.squaredNorm());
  }
  for (const std::int32_t v : c) {
    const Vector way = surface_.vertex(v) - origin;
    own_high = std::max(own_high, n.dot(way));
    own_low = std::min(own_low, n.dot(way));
    far_squared = std::max(far_squared, way.squaredNorm());
  }
  const double error = 16 * kUnitRoundoff * std::sqrt(far_squared);
  work_left_ -= 0.02 * static_cast<double>(trial_.corners().size());
  return std::min(high - own_low + error, own_high - low + error);
}

// isShallow() for all triangles of the component outside the patch: a descent to those whose nodes
// intersect the trial hull.
bool HullProof::areOthersShallow(const SurfacePatch& patch, int component, const ConvexView& view) {
  const MeshTree& tree = surface_.tree();
  std::array<int, 2 * MeshTree::kMaxDepth> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  DistanceRequest request;
  request.tolerance = kDefaultTolerance;
  request.threshold = 0;
  request.depth = false;
  while (size > 0) {
    const int id = stack[--size];
    const MeshNode& node = tree.node(id);
    if (node.component >= 0 && node.component != component) continue;
    if ((node.low.array() > trial_.high().array()).any() ||
        (node.high.array() < trial_.low().array()).any())
      continue;
    if (patch.holds(node)) continue;
    work_left_ -= 0.1;
    if (!node.isLeaf()) {
      if (node.triangle_end - node.triangle_begin > 4) {
        work_left_ -= 2 + 0.02 * static_cast<double>(trial_.corners().size());
        const DistanceResult r =
            convexDistance(tree.nodeView(node), Pose{}, view, request, scratch_, nullptr);
        if (r.distance.lower > 0) continue;
      }
      stack[size++] = node.right;
      stack[size++] = id + 1;
      continue;
    }
    for (int slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
      const std::int32_t t = tree.triangleOf(slot);
      if (surface_.mesh().component(t) != component || patch.has(t) ||
          !isProper(surface_.corners(t)))
        continue;
      if (isShallow(t, view)) continue;
      culprit_ = t;
      return false;
    }
  }
  return true;
}

}  // namespace leeway::collision
