#include "collision/shapes/hull_builder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/exact_predicates.h"
#include "collision/base/tolerances.h"
#include "collision/shapes/point_triangle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

// Largest coordinate of a normal, as the axis to project along.
int dominantAxis(const Vector3d& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return axis;
}

}  // namespace

inline double HullBuilder::heightOver(const Facet& f, std::int32_t point) const {
  return f.normal.dot(at(point) - at(f.corner[0]));
}

// `height` is heightOver(). Exact: rounding decides nothing.
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
  const auto count = static_cast<std::int32_t>(points_.size());
  // Two points far apart: the lowest and highest of the coordinate that spreads most.
  Vector3d low = at(0), high = at(0);
  for (const Vector3d& p : points_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  size_ = (high - low).norm() * (1 + kRelativeRounding);
  const int axis = dominantAxis(high - low);
  std::int32_t a = 0, b = 0;
  for (std::int32_t i = 1; i < count; ++i) {
    if (at(i)[axis] < at(a)[axis]) a = i;
    if (at(i)[axis] > at(b)[axis]) b = i;
  }
  if (at(a)[axis] == at(b)[axis]) {
    dimension_ = 0;
    vertices_ = {0};
    return false;
  }
  // The point farthest from their line; where rounding says 0, any point that is exactly off the
  // line.
  const Vector3d direction = (at(b) - at(a)).normalized();
  std::int32_t c = -1;
  double best = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const double distance = (at(i) - at(a)).cross(direction).squaredNorm();
    if (distance > best) {
      best = distance;
      c = i;
    }
  }
  if (c < 0 || collinear(at(a), at(b), at(c))) {
    c = -1;
    for (std::int32_t i = 0; i < count && c < 0; ++i) {
      if (!collinear(at(a), at(b), at(i))) c = i;
    }
  }
  if (c < 0) {
    dimension_ = 1;
    // a and b are extreme along an axis on which the line is not constant.
    vertices_ = {std::min(a, b), std::max(a, b)};
    return false;
  }
  // The point farthest from their plane, and again any that is exactly off it.
  const Vector3d normal = (at(b) - at(a)).cross(at(c) - at(a));
  std::int32_t d = -1;
  best = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const double distance = std::abs(normal.dot(at(i) - at(a)));
    if (distance > best) {
      best = distance;
      d = i;
    }
  }
  int side = d < 0 ? 0 : orientation(at(a), at(b), at(c), at(d));
  for (std::int32_t i = 0; i < count && side == 0; ++i) {
    d = i;
    side = orientation(at(a), at(b), at(c), at(d));
  }
  if (side == 0) {
    dimension_ = 2;
    buildFlat(a, b, c);
    return false;
  }
  if (side > 0) std::swap(b, c);  // now d lies behind abc
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
  for (std::int32_t i = 0; i < count; ++i) assign(i, 0);
  return true;
}

// Extreme points of a set that is exactly flat, by Andrew's monotone chain on two coordinates. The
// projection keeps them because abc, and with it the plane, does not become straight in it.
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
      // A duplicate of the last point turns by 0 about every other, so that only the first two need
      // a look.
      if (!chain.empty() && at(chain.back()) == at(p)) continue;
      chain.push_back(p);
    }
    // The last point of a chain is the first of the other; duplicates of it may carry another
    // index.
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
  // The product as computed errs by less than 6 units of |ab| |ac|; what the division and a height
  // by it add is less than 12 units of the distance between two points. Lengths whose squares leave
  // the range of normal doubles tell nothing.
  f.doubt = length > kLeastToSquare
                ? 16 * kUnitRoundoff * size_ * (ab.norm() * ac.norm() / length + 1)
                : std::numeric_limits<double>::infinity();
  return id;
}

// Puts the point on the list of the first live facet from `first_facet` on that it is outside of;
// none: it is inside.
void HullBuilder::assign(std::int32_t point, std::int32_t first_facet) {
  for (std::size_t i = index(first_facet); i < work_.size(); ++i) {
    Facet& f = work_[i];
    if (!f.alive) continue;
    const double height = heightOver(f, point);
    if (!sees(point, f, height)) continue;
    if (f.farthest < 0 || height > f.height) {
      f.farthest = point;
      f.height = height;
    }
    next_[index(point)] = f.first;
    f.first = point;
    return;
  }
}

void HullBuilder::build(int vertex_limit) {
  if (!limited_) {
    // Facets made by an insertion stand behind or in the place of old ones: sweep until a sweep
    // finds nothing.
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
  // The visible facets are connected, and their border, the horizon, is one cycle without a
  // repeated corner: they are those that a point moved a little inwards would see, which lies in no
  // facet's plane.
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
  // Points outside of the visible facets, to be spread over the new ones.
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
  std::vector<std::int32_t>& added = visible_;  // its old content goes to the free list first
  free_.insert(free_.end(), visible_.begin(), visible_.end());
  added.clear();
  for (const HorizonEdge& e : horizon_) {
    const std::int32_t id = addFacet(e.from, e.to, point);
    facet(id).adjacent[0] = e.facet;
    facet(e.facet).adjacent[index(e.side)] = id;
    horizon_facet_[index(e.from)] = id;
    added.push_back(id);
  }
  for (const std::int32_t id : added) {
    const std::int32_t following = horizon_facet_[index(facet(id).corner[1])];
    facet(id).adjacent[1] = following;
    facet(following).adjacent[2] = id;
  }
  // An orphan that is still outside sees a new facet: where it sees both facets at a horizon edge,
  // it sees the new one between their planes, and where it sees no facet that stayed, only new ones
  // are left.
  for (std::int32_t p = orphans; p >= 0;) {
    const std::int32_t following = next_[index(p)];
    std::int32_t best = -1;
    double best_height = 0;
    for (const std::int32_t id : added) {
      const Facet& f = facet(id);
      const double height = heightOver(f, p);
      if ((best >= 0 && height <= best_height) || !sees(p, f, height)) continue;
      best = id;
      best_height = height;
      if (!limited_)
        break;  // the height over the best facet is nearer to the true distance, but costs
    }
    if (best >= 0) {
      Facet& f = facet(best);
      if (f.farthest < 0 || best_height > f.height) {
        f.farthest = p;
        f.height = best_height;
      }
      next_[index(p)] = f.first;
      f.first = p;
    }
    p = following;
  }
}

void HullBuilder::finish() {
  constexpr std::int32_t kInside = -1, kVertex = -2;
  std::vector<std::int32_t> number(work_.size(), -1);
  std::vector<std::int32_t>& place = horizon_facet_;  // per point: the facet that it is outside of
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
  free_ = {};
  horizon_facet_ = {};
}

namespace {

double squaredDistance(const Vector3d& point, std::span<const Vector3d> points,
                       const std::array<std::int32_t, 3>& f) {
  return (point - closestPointOnTriangle(point, points[index(f[0])], points[index(f[1])],
                                         points[index(f[2])]))
      .squaredNorm();
}

// An upper bound on a point's distance from what its distance as computed is.
double roundedOut(double squared, const Vector3d& point) {
  const double size = point.cwiseAbs().maxCoeff();
  return std::sqrt(squared) * (1 + kRelativeRounding) + size * kRelativeRounding;
}

}  // namespace

double distanceFromHull(const Vector3d& point, std::span<const Vector3d> points,
                        const HullBuilder& hull) {
  double best = std::numeric_limits<double>::infinity();
  bool outside = false;
  for (const auto& f : hull.facets()) {
    const Vector3d &a = points[index(f[0])], &b = points[index(f[1])], &c = points[index(f[2])];
    if (!outside) outside = orientation(a, b, c, point) > 0;
    best = std::min(best, squaredDistance(point, points, f));
  }
  return outside ? roundedOut(best, point) : 0;
}

double largestDistanceFromHull(std::span<const Vector3d> points, const HullBuilder& hull) {
  struct Outside {
    std::int32_t point;
    double squared;  // of its distance from the facet that it is outside of
  };
  std::vector<Outside> outside;
  outside.reserve(hull.outside().size());
  for (std::size_t i = 0; i < hull.outside().size(); ++i) {
    const std::int32_t p = hull.outside()[i];
    const auto& f = hull.facets()[index(hull.outsideOf()[i])];
    outside.push_back({p, squaredDistance(points[index(p)], points, f)});
  }
  double largest = 0;
  const auto hold = [&](Outside& o) {
    // Rounding out keeps the order, so that what is no farther from one facet is so from the hull.
    const Vector3d& point = points[index(o.point)];
    if (roundedOut(o.squared, point) <= largest) return;
    for (const auto& f : hull.facets()) {
      const double squared = squaredDistance(point, points, f);
      if (squared >= o.squared) continue;
      o.squared = squared;
      if (roundedOut(squared, point) <= largest) return;
    }
    largest = roundedOut(o.squared, point);
  };
  // The farthest first: they leave little to do for the others.
  const auto far =
      std::max_element(outside.begin(), outside.end(),
                       [](const Outside& l, const Outside& r) { return l.squared < r.squared; });
  if (far != outside.end()) hold(*far);
  for (Outside& o : outside) hold(o);
  return largest;
}

}  // namespace leeway::collision
