#include "collision/mesh/patch_hull.h"

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/shapes/hull_builder.h"

namespace leeway::collision {

bool PatchHull::build(std::vector<Vector> points) {
  points_ = std::move(points);
  const HullBuilder builder(points_);
  if (builder.dimension() < 3) return false;
  facets_ = builder.facets();
  corners_.clear();
  for (const std::int32_t v : builder.vertices()) corners_.push_back(points_[at(v)]);
  low_ = high_ = corners_[0];
  for (const Vector& p : corners_) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  size_ = (high_ - low_).norm();
  makePlanes();
  makeCenter();
  return center_.allFinite();
}

// The exact plane of facet abc supports the hull: (b - a) x (c - a) . (x - a) <= 0. The computed
// product errs by less than 16 units of |b - a| |c - a|, and its dot products by that times |x -
// a|.
void PatchHull::makePlanes() {
  planes_.clear();
  first_.assign(points_.size() + 1, 0);
  for (const auto& f : facets_) {
    const Vector &a = points_[at(f[0])], &b = points_[at(f[1])], &c = points_[at(f[2])];
    const Vector normal = cross(b - a, c - a);
    const double length = normal.norm();
    const double error = 16 * kUnitRoundoff * (b - a).norm() * (c - a).norm();
    planes_.push_back({length > 0 ? Vector(normal / length) : Vector::UnitX(), a,
                       length > 0 ? size_ * (error / length + 16 * kUnitRoundoff)
                                  : std::numeric_limits<double>::infinity()});
    for (const std::int32_t v : f) ++first_[at(v) + 1];
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  around_.resize(3 * facets_.size());
  std::vector<std::int32_t> fill(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    for (const std::int32_t v : facets_[i]) {
      around_[at(fill[at(v)]++)] = static_cast<std::int32_t>(i);
    }
  }
}

// The centroid of the volume, summed over tetrahedra from the vertices' mean.
void PatchHull::makeCenter() {
  Vector mean = Vector::Zero();
  for (const Vector& p : corners_) mean += p / static_cast<double>(corners_.size());
  Vector sum = Vector::Zero();
  double volume = 0;
  for (const auto& f : facets_) {
    const Vector a = points_[at(f[0])] - mean, b = points_[at(f[1])] - mean,
                 c = points_[at(f[2])] - mean;
    const double v = a.dot(cross(b, c));
    volume += v;
    sum += v * (a + b + c);
  }
  center_ = volume > 0 ? Vector(mean + sum / (4 * volume)) : mean;
  reach_ = 0;
  for (const Vector& p : corners_) reach_ = std::max(reach_, (p - center_).norm());
  reach_ *= 1 + kRelativeRounding;
}

}  // namespace leeway::collision
