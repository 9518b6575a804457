#include "collision/shapes/hull_builder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/exact_predicates.h"
#include "collision/base/tolerances.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

// The axis of a vector's largest coordinate.
int dominantAxis(const Vector3d& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return axis;
}

}  // namespace

inline double HullBuilder::heightOver(const Facet& f, std::int32_t point) const {
  return f.normal.dot(at(point) - at(f.corner[0]));
}

// Exact: if the rounding of `height`, which is heightOver(), could matter, a predicate decides.
inline bool HullBuilder::sees(std::int32_t point, const Facet& f, double height) const {
  if (height > f.doubt) return true;
  if (height < -f.doubt) return false;
  if (point == f.corner[0] || point == f.corner[1] || point == f.corner[2]) return false;
  return orientation(at(f.corner[0]), at(f.corner[1]), at(f.corner[2]), at(point)) > 0;
}

HullBuilder::HullBuilder(std::span<const Vector3d> points, int vertex_limit)
    : points_(points), limited_(vertex_limit > 0) {
  if (points.empty()) return;
  if (!start()) return;
  dimension_ = 3;
  build(std::max(vertex_limit, 4));
  finish();
}

bool HullBuilder::start() {
  std::int32_t a = 0, b = 0;
  farthestAlongAnAxis(a, b);
  if (a == b) {
    dimension_ = 0;
    vertices_ = {0};
    return false;
  }
  std::int32_t c = farthestFromLine(a, b);
  if (c < 0) {
    dimension_ = 1;
    // These are also extreme: a and b are the ends along a coordinate that is not constant on the
    // line.
    vertices_ = {std::min(a, b), std::max(a, b)};
    return false;
  }
  int side = 0;
  const std::int32_t d = farthestFromPlane(a, b, c, side);
  if (side == 0) {
    dimension_ = 2;
    buildFlat(a, b, c);
    return false;
  }
  if (side > 0) std::swap(b, c);  // now d lies behind abc
  makeTetrahedron(a, b, c, d);
  return true;
}

// The lowest and highest point along the coordinate with the largest extent; equal indices if all
// points are the same. Also sets size_.
void HullBuilder::farthestAlongAnAxis(std::int32_t& a, std::int32_t& b) {
  Vector3d low = at(0), high = at(0);
  for (const Vector3d& p : points_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  size_ = (high - low).norm() * (1 + kRelativeRounding);
  const int axis = dominantAxis(high - low);
  a = b = 0;
  for (std::int32_t i = 1; i < pointCount(); ++i) {
    if (at(i)[axis] < at(a)[axis]) a = i;
    if (at(i)[axis] > at(b)[axis]) b = i;
  }
}

// The point farthest from the line ab; if rounding finds none, the first point that is exactly off
// it; -1 if there is none.
std::int32_t HullBuilder::farthestFromLine(std::int32_t a, std::int32_t b) const {
  const Vector3d direction = (at(b) - at(a)).normalized();
  std::int32_t farthest = -1;
  double best = 0;
  for (std::int32_t i = 0; i < pointCount(); ++i) {
    const double squared = (at(i) - at(a)).cross(direction).squaredNorm();
    if (squared > best) {
      best = squared;
      farthest = i;
    }
  }
  if (farthest >= 0 && !collinear(at(a), at(b), at(farthest))) return farthest;
  for (std::int32_t i = 0; i < pointCount(); ++i) {
    if (!collinear(at(a), at(b), at(i))) return i;
  }
  return -1;
}

// The point farthest from the plane abc; if rounding finds none, the first point that is exactly
// off it. `side` is the exact side on which it lies, 0 if all points lie in the plane.
std::int32_t HullBuilder::farthestFromPlane(std::int32_t a, std::int32_t b, std::int32_t c,
                                            int& side) const {
  const Vector3d normal = (at(b) - at(a)).cross(at(c) - at(a));
  std::int32_t farthest = -1;
  double best = 0;
  for (std::int32_t i = 0; i < pointCount(); ++i) {
    const double distance = std::abs(normal.dot(at(i) - at(a)));
    if (distance > best) {
      best = distance;
      farthest = i;
    }
  }
  side = farthest < 0 ? 0 : orientation(at(a), at(b), at(c), at(farthest));
  for (std::int32_t i = 0; i < pointCount() && side == 0; ++i) {
    farthest = i;
    side = orientation(at(a), at(b), at(c), at(farthest));
  }
  return farthest;
}

// d lies behind abc.
void HullBuilder::makeTetrahedron(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  work_.reserve(64);
  next_.assign(points_.size(), -1);
  horizon_facet_.assign(points_.size(), -1);
  addFacet(a, b, c);  // 0
  addFacet(a, d, b);  // 1
  addFacet(b, d, c);  // 2
  addFacet(c, d, a);  // 3
  facet(0).adjacent = {1, 2, 3};
  facet(1).adjacent = {3, 2, 0};
  facet(2).adjacent = {1, 3, 0};
  facet(3).adjacent = {2, 1, 0};
  for (std::int32_t i = 0; i < pointCount(); ++i) assign(i);
}

// Extreme points of an exactly flat set, by Andrew's monotone chain on two coordinates. The
// projection preserves extreme points, because abc, and so the plane, does not become straight in
// it.
void HullBuilder::buildFlat(std::int32_t a, std::int32_t b, std::int32_t c) {
  int i = 0, j = 1;
  const int dominant = dominantAxis((at(b) - at(a)).cross(at(c) - at(a)));
  for (int k = 0; k < 3; ++k) {
    i = (dominant + 1 + k) % 3;
    j = (dominant + 2 + k) % 3;
    if (turn(at(a), at(b), at(c), i, j) != 0) break;
  }
  std::vector<std::int32_t> order(points_.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<std::int32_t>(k);
  std::sort(order.begin(), order.end(), [&](std::int32_t l, std::int32_t r) {
    if (at(l)[i] != at(r)[i]) return at(l)[i] < at(r)[i];
    if (at(l)[j] != at(r)[j]) return at(l)[j] < at(r)[j];
    return l < r;
  });
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::int32_t> chain;
    for (const std::int32_t p : order) {
      while (chain.size() >= 2 &&
             turn(at(chain[chain.size() - 2]), at(chain.back()), at(p), i, j) <= 0) {
        chain.pop_back();
      }
      // Duplicates are consecutive. The loop above replaces all of them except those of a chain's
      // first point.
      if (!chain.empty() && at(chain.back()) == at(p)) continue;
      chain.push_back(p);
    }
    // The last point of a chain is the first of the other one, perhaps with a duplicate's index.
    outline_.insert(outline_.end(), chain.begin(), chain.end() - 1);
    std::reverse(order.begin(), order.end());
  }
  vertices_ = outline_;
  std::sort(vertices_.begin(), vertices_.end());
}

std::int32_t HullBuilder::addFacet(std::int32_t a, std::int32_t b, std::int32_t c) {
  std::int32_t id = 0;
  if (free_.empty()) {
    id = static_cast<std::int32_t>(work_.size());
    work_.emplace_back();
  } else {
    id = free_.back();
    free_.pop_back();
    facet(id) = Facet();
  }
  Facet& f = facet(id);
  f.corner = {a, b, c};
  f.adjacent = {-1, -1, -1};
  const Vector3d ab = at(b) - at(a), ac = at(c) - at(a);
  f.normal = ab.cross(ac);
  const double length = f.normal.norm();
  if (length > 0) f.normal /= length;
  // The computed product errs by less than 6 units of |ab| |ac|. The division and a height computed
  // with it add less than 12 units of the distance between two points. If the squared length leaves
  // the range of normal doubles, the normal is unknown.
  f.doubt = length > kLeastToSquare
                ? 16 * kUnitRoundoff * size_ * (ab.norm() * ac.norm() / length + 1)
                : std::numeric_limits<double>::infinity();
  return id;
}

void HullBuilder::putOutside(Facet& f, std::int32_t point, double height) {
  if (f.farthest < 0 || height > f.height) {
    f.farthest = point;
    f.height = height;
  }
  next_[index(point)] = f.first;
  f.first = point;
}

// Puts a point on the list of the first facet that it is outside of; if there is none, the point is
// inside.
void HullBuilder::assign(std::int32_t point) {
  for (Facet& f : work_) {
    const double height = heightOver(f, point);
    if (!sees(point, f, height)) continue;
    putOutside(f, point, height);
    return;
  }
}

void HullBuilder::build(int vertex_limit) {
  if (!limited_) {
    // New facets are appended or replace old ones, so this sweeps until a sweep finds nothing.
    for (bool found = true; found;) {
      found = false;
      for (std::size_t i = 0; i < work_.size(); ++i) {
        while (work_[i].alive && work_[i].farthest >= 0) {
          found = true;
          insert(static_cast<std::int32_t>(i), work_[i].farthest);
        }
      }
    }
    return;
  }
  for (int vertices = 4; vertices < vertex_limit; ++vertices) {
    std::int32_t best = -1;
    for (std::size_t i = 0; i < work_.size(); ++i) {
      const Facet& f = work_[i];
      if (!f.alive || f.farthest < 0) continue;
      if (best < 0 || f.height > facet(best).height) best = static_cast<std::int32_t>(i);
    }
    if (best < 0) return;
    insert(best, facet(best).farthest);
  }
}

void HullBuilder::insert(std::int32_t start, std::int32_t point) {
  findHorizon(start, point);
  const std::int32_t orphans = removeVisible(point);
  addCone(point);
  reassign(orphans);
}

// Collects the facets that the point sees, starting from one of them, and their border. The visible
// facets are connected and their border, the horizon, is one cycle without a repeated corner. They
// are the facets that the point would see if it were moved slightly inwards, where it lies in no
// facet's plane.
void HullBuilder::findHorizon(std::int32_t start, std::int32_t point) {
  visible_.assign(1, start);
  horizon_.clear();
  facet(start).visible = true;
  for (std::size_t i = 0; i < visible_.size(); ++i) {
    const std::int32_t id = visible_[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t other = facet(id).adjacent[k];
      Facet& o = facet(other);
      if (o.visible) continue;
      if (o.mark != point + 1) {
        o.mark = point + 1;
        if (sees(point, o, heightOver(o, point))) {
          o.visible = true;
          visible_.push_back(other);
          continue;
        }
      }
      const std::int32_t side = o.adjacent[0] == id ? 0 : (o.adjacent[1] == id ? 1 : 2);
      horizon_.push_back({facet(id).corner[k], facet(id).corner[(k + 1) % 3], other, side});
    }
  }
}

// Frees the visible facets. Returns the list of the other points that were outside them; -1 if
// there are none.
std::int32_t HullBuilder::removeVisible(std::int32_t point) {
  std::int32_t orphans = -1;
  for (const std::int32_t id : visible_) {
    Facet& f = facet(id);
    for (std::int32_t p = f.first; p >= 0;) {
      const std::int32_t following = next_[index(p)];
      if (p != point) {
        next_[index(p)] = orphans;
        orphans = p;
      }
      p = following;
    }
    f.alive = false;
    f.first = f.farthest = -1;
  }
  free_.insert(free_.end(), visible_.begin(), visible_.end());
  return orphans;
}

// Adds the facets from the horizon to the point.
void HullBuilder::addCone(std::int32_t point) {
  added_.clear();
  for (const HorizonEdge& e : horizon_) {
    const std::int32_t id = addFacet(e.from, e.to, point);
    facet(id).adjacent[0] = e.facet;
    facet(e.facet).adjacent[index(e.side)] = id;
    horizon_facet_[index(e.from)] = id;
    added_.push_back(id);
  }
  for (const std::int32_t id : added_) {
    const std::int32_t following = horizon_facet_[index(facet(id).corner[1])];
    facet(id).adjacent[1] = following;
    facet(following).adjacent[2] = id;
  }
}

// Puts orphans on the lists of new facets. An orphan that is still outside sees a new facet: if it
// sees both facets at a horizon edge, it sees the new one between their planes; if it sees no
// remaining old facet, only new ones are left.
void HullBuilder::reassign(std::int32_t orphans) {
  for (std::int32_t p = orphans; p >= 0;) {
    const std::int32_t following = next_[index(p)];
    std::int32_t best = -1;
    double best_height = 0;
    for (const std::int32_t id : added_) {
      const Facet& f = facet(id);
      const double height = heightOver(f, p);
      if ((best >= 0 && height <= best_height) || !sees(p, f, height)) continue;
      best = id;
      best_height = height;
      // Only a limited hull needs the largest height, which is closer to the true distance.
      if (!limited_) break;
    }
    if (best >= 0) putOutside(facet(best), p, best_height);
    p = following;
  }
}

void HullBuilder::finish() {
  constexpr std::int32_t kInside = -1, kVertex = -2;
  std::vector<std::int32_t> number(work_.size(), -1);
  // For each point: the facet that it is outside of, or one of the above. Reuses the memory.
  std::vector<std::int32_t>& place = horizon_facet_;
  place.assign(points_.size(), kInside);
  for (std::size_t i = 0; i < work_.size(); ++i) {
    if (!work_[i].alive) continue;
    number[i] = static_cast<std::int32_t>(facets_.size());
    facets_.push_back(work_[i].corner);
    for (std::int32_t p = work_[i].first; p >= 0; p = next_[index(p)]) place[index(p)] = number[i];
    for (const std::int32_t p : work_[i].corner) place[index(p)] = kVertex;
  }
  for (const Facet& f : work_) {
    if (!f.alive) continue;
    adjacent_.push_back(
        {number[index(f.adjacent[0])], number[index(f.adjacent[1])], number[index(f.adjacent[2])]});
  }
  for (std::size_t p = 0; p < place.size(); ++p) {
    if (place[p] == kInside) continue;
    if (place[p] == kVertex) {
      vertices_.push_back(static_cast<std::int32_t>(p));
      continue;
    }
    outside_.push_back(static_cast<std::int32_t>(p));
    outside_of_.push_back(place[p]);
  }
  work_ = {};
  next_ = {};
  visible_ = {};
  horizon_ = {};
  added_ = {};
  free_ = {};
  horizon_facet_ = {};
}

}  // namespace leeway::collision
