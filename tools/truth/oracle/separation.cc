// Signed separation of two convex bodies, computed slowly. The Minkowski difference C = A - B is
// given only by its support.
// Apart: Gilbert, Johnson, Keerthi 1988; every step yields the distance to a point of C (upper
// bound) and a supporting plane (lower bound).
// Overlapping: a polytope inside C is refined where it is nearest to the origin (van den Bergen
// 2001); its nearest facet bounds the depth from below, C's support along that facet's normal from
// above. Facets are found by exhaustive search, subsimplices by enumeration, without optimisations.

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "tools/truth/oracle/convex.h"

namespace leeway::oracle {
namespace {

// Limits on the steps, after which a query accepts the width reached; smooth bodies with a curve of
// closest points need them.
constexpr int kGjkSteps = 600;
constexpr int kPolytopeSteps = 500;
// Limit on the facets. A convex polytope grows by two facets in each step; more indicates rounding
// at size ratios of 1e30 and more.
constexpr std::size_t kMostFacets = 1100;
// Widths below which the search stops [relative to the extent]; far below double rounding.
const Quad kGjkWidth = wide(1e-24);
const Quad kPolytopeWidth = wide(1e-20);

struct Difference {
  const ConvexBody& a;
  const ConvexBody& b;
  Vector support(const Vector& d) const { return a.support(d) - b.support(-d); }
};

struct LeastPoint {
  /// A convex combination of the vertices: a point of C in spite of the weights' rounding.
  Vector point;
  /// Its direction by the plane's normal, which keeps the digits that the combination cancels.
  Vector direction;
};

struct Nearest {
  LeastPoint least;
  Quad squared = 0;
  std::vector<Vector> simplex;
};

/// The least point of the affine hull of `p`, if it lies within their convex hull.
std::optional<LeastPoint> innerLeastPoint(const std::vector<Vector>& p) {
  const std::size_t m = p.size() - 1;
  if (m == 0) return LeastPoint{p[0], p[0]};
  Vector e[3];
  Quad g[3][3], rhs[3], lambda[3] = {0, 0, 0};
  for (std::size_t i = 0; i < m; ++i) e[i] = p[i + 1] - p[0];
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j < m; ++j) g[i][j] = dot(e[i], e[j]);
    rhs[i] = -dot(e[i], p[0]);
  }
  if (m == 1) {
    if (!(g[0][0] > 0)) return std::nullopt;
    lambda[0] = rhs[0] / g[0][0];
  } else if (m == 2) {
    // Determinant by the cross product: avoids the Gram matrix's cancellation.
    const Vector n = cross(e[0], e[1]);
    const Quad det = squaredNorm(n);
    if (!(det > 0)) return std::nullopt;
    lambda[0] = dot(cross(-p[0], e[1]), n) / det;
    lambda[1] = dot(cross(e[0], -p[0]), n) / det;
  } else {
    const Quad det = dot(e[0], cross(e[1], e[2]));
    if (det == 0) return std::nullopt;
    const Vector o = -p[0];
    lambda[0] = dot(o, cross(e[1], e[2])) / det;
    lambda[1] = dot(e[0], cross(o, e[2])) / det;
    lambda[2] = dot(e[0], cross(e[1], o)) / det;
  }
  Quad first = 1;
  for (std::size_t i = 0; i < m; ++i) {
    if (!(lambda[i] >= 0)) return std::nullopt;
    first -= lambda[i];
  }
  if (!(first >= 0)) return std::nullopt;
  Vector point = p[0];
  for (std::size_t i = 0; i < m; ++i) point = point + lambda[i] * e[i];
  if (m != 2) return LeastPoint{point, point};
  const Vector n = cross(e[0], e[1]);
  return LeastPoint{point, (dot(p[0], n) / squaredNorm(n)) * n};
}

Nearest nearestOfSimplex(const std::vector<Vector>& points) {
  Nearest best;
  best.squared = infinity();
  const unsigned count = 1u << points.size();
  for (unsigned mask = 1; mask < count; ++mask) {
    std::vector<Vector> subset;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (mask & (1u << i)) subset.push_back(points[i]);
    const std::optional<LeastPoint> p = innerLeastPoint(subset);
    if (!p) continue;
    const Quad squared = squaredNorm(p->point);
    if (squared < best.squared) best = {*p, squared, subset};
  }
  return best;
}

/// Distance of the origin from the difference: [lower, upper], with lower <= 0 if it is not proven
/// apart. Ends early when within `enough`.
Bounds distanceBounds(const Difference& c, Quad scale, const Bounds& enough) {
  Nearest nearest;
  const Vector start = c.support({1, 0, 0});
  nearest.least = {start, start};
  nearest.simplex = {start};
  Quad lower = 0, upper = norm(start);
  int idle = 0;
  for (int step = 0; step < kGjkSteps; ++step) {
    const Quad length = norm(nearest.least.point);
    if (length <= kGjkWidth * scale) break;
    const Vector& direction = nearest.least.direction;
    const Quad direction_length = norm(direction);
    if (!(direction_length > 0)) break;
    const Vector w = c.support(-direction);
    lower = std::max(lower, dot(direction, w) / direction_length);
    if (upper - lower <= kGjkWidth * scale) break;
    if (lower > 0 && Bounds{lower, upper}.within(enough)) break;
    std::vector<Vector> points = nearest.simplex;
    const bool known = std::any_of(points.begin(), points.end(), [&](const Vector& p) {
      return p.x == w.x && p.y == w.y && p.z == w.z;
    });
    if (known) break;
    points.push_back(w);
    if (points.size() > 4) break;  // already contains the origin
    Nearest next = nearestOfSimplex(points);
    const Quad next_length = norm(next.least.point);
    // Once the length stops falling, quadruple rounding decides instead of geometry.
    idle = next_length < length ? 0 : idle + 1;
    upper = std::min(upper, next_length);
    nearest = std::move(next);
    if (idle > 3) break;
  }
  return {lower, upper};
}

struct Facet {
  std::array<int, 3> v;
  Vector plane_normal;  // outward; 0 for a triangle without area
  Quad plane_offset;    // signed distance of its plane from the origin along it
  Vector normal;        // plane_normal; for a sliver, the direction of its nearest point
  Quad offset;          // the triangle is at least this far out along `normal` ...
  Quad rounding;        // ... up to this rounding
  bool alive = true;
  double roughly = 0;  // offset
};

/// A polytope with vertices on C, refined towards the origin.
class Polytope {
 public:
  Polytope(const Difference& c, Quad scale) : c_(c), scale_(scale) {}

  /// Ends early within `enough`.
  Bounds depth(const Bounds& enough) {
    if (!start()) return {0, best_support_};
    for (int step = 0; step < kPolytopeSteps; ++step) {
      const std::size_t nearest = nearestFacet();
      if (nearest == facets_.size()) break;  // not a number
      const Quad least = facets_[nearest].offset;
      const Bounds at_most{least - facets_[nearest].rounding, best_support_};
      if (at_most.within(enough) && proven().within(enough)) break;
      const Vector w = query(facets_[nearest].normal);
      if (dot(facets_[nearest].normal, w) - least <= kPolytopeWidth * scale_) break;
      if (!add(w, nearest) || alive_ > kMostFacets) break;
    }
    return proven();
  }

 private:
  /// The bounds that the current polytope proves. O(facets).
  Bounds proven() const {
    Quad inner = infinity();
    for (const Facet& f : facets_) {
      if (f.alive) inner = std::min(inner, f.offset - f.rounding);
    }
    // Support values always hold. Facets that claim more are torn by rounding (size ratios of 1e13
    // and more), and the inner bound is then 0.
    if (!(inner <= best_support_)) inner = 0;
    if (inner > 0 && !windsAroundOrigin()) inner = 0;
    return {inner, best_support_};
  }

  /// C's support point along a unit direction; every query bounds the depth from above.
  Vector query(const Vector& unit) {
    const Vector w = c_.support(unit);
    best_support_ = std::min(best_support_, dot(unit, w));
    return w;
  }

  /// Compares all facets: as doubles, and in full precision where these cannot decide.
  std::size_t nearestFacet() const {
    double least = HUGE_VAL;
    for (const Facet& f : facets_) {
      if (f.alive) least = std::min(least, f.roughly);
    }
    const double most = least + 1e-15 * std::abs(least);
    std::size_t nearest = facets_.size();
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      if (!facets_[i].alive || !(facets_[i].roughly <= most)) continue;
      if (nearest == facets_.size() || facets_[i].offset < facets_[nearest].offset) nearest = i;
    }
    return nearest;
  }

  Vector unit(const Vector& v) const { return (1 / norm(v)) * v; }

  /// The one of C's support points along +-d that is farther from `from`; sets its distance along
  /// d.
  Vector extreme(const Vector& d, const Vector& from, Quad& distance) {
    const Vector p = query(d), q = query(-d);
    const Quad dp = absolute(dot(p - from, d)), dq = absolute(dot(q - from, d));
    distance = std::max(dp, dq);
    return dp >= dq ? p : q;
  }

  /// Finds four points with volume; false if C is flat to within quadruple rounding.
  bool start() {
    const Quad tiny = wide(1e-27) * scale_;
    const Vector axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vertices_ = {query(axes[0])};
    Quad farthest = 0;
    Vector p1;
    for (const Vector& d : axes) {
      Quad distance;
      const Vector p = extreme(d, vertices_[0], distance);
      if (distance > farthest) farthest = distance, p1 = p;
    }
    if (farthest <= tiny) return false;
    const Vector u = unit(p1 - vertices_[0]);
    Vector side = cross(u, axes[0]);
    for (const Vector& d : axes)
      if (squaredNorm(cross(u, d)) > squaredNorm(side)) side = cross(u, d);
    side = unit(side);
    Quad d1, d2;
    const Vector q1 = extreme(side, vertices_[0], d1),
                 q2 = extreme(unit(cross(u, side)), vertices_[0], d2);
    if (std::max(d1, d2) <= tiny) return false;
    const Vector p2 = d1 >= d2 ? q1 : q2;
    Quad height;
    const Vector p3 = extreme(unit(cross(u, p2 - vertices_[0])), vertices_[0], height);
    if (height <= tiny) return false;
    vertices_.insert(vertices_.end(), {p1, p2, p3});
    // One sign for all, because facets of a flat tetrahedron, tested one by one, may disagree.
    const bool positive = dot(cross(p1 - vertices_[0], p2 - vertices_[0]), p3 - vertices_[0]) > 0;
    for (const std::array<int, 3>& v : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
      addFacet(positive ? v : std::array{v[0], v[2], v[1]});
    alive_ = facets_.size();
    return true;
  }

  Facet makeFacet(const std::array<int, 3>& v) const {
    const Vector& a = vertices_[static_cast<std::size_t>(v[0])];
    const Vector e1 = vertices_[static_cast<std::size_t>(v[1])] - a;
    const Vector e2 = vertices_[static_cast<std::size_t>(v[2])] - a;
    const Vector n = cross(e1, e2);
    const Quad area = norm(n);
    const Quad longest =
        squareRoot(std::max({squaredNorm(e1), squaredNorm(e2), squaredNorm(e1 - e2)}));
    Facet facet{v, {0, 0, 0}, 0, {0, 0, 0}, 0, infinity()};
    if (area > 0) {
      facet.plane_normal = facet.normal = (1 / area) * n;
      facet.plane_offset = facet.offset = dot(facet.normal, a);
      // Vertices have an error of a few roundoffs of scale; divided by the triangle's height, that
      // tilts its plane.
      facet.rounding = 64 * quadRoundoff() * scale_ * (1 + scale_ * longest / area);
    }
    if (facet.rounding > kPolytopeWidth * scale_) takeNearest(facet);
    return facet;
  }

  /// A sliver's own plane is unreliable. Any plane between the origin and the triangle is suitable,
  /// because it keeps the surface out of a ball. The winding around that ball is counted over the
  /// other facets, because slivers subtend almost no solid angle.
  void takeNearest(Facet& facet) const {
    std::vector<Vector> corners;
    for (const int i : facet.v) corners.push_back(vertices_[static_cast<std::size_t>(i)]);
    const Vector nearest = nearestOfSimplex(corners).least.point;
    const Quad length = norm(nearest);
    if (!(length > 0)) return;
    facet.normal = (1 / length) * nearest;
    facet.offset = infinity();
    for (const Vector& p : corners) facet.offset = std::min(facet.offset, dot(facet.normal, p));
    facet.rounding = 64 * quadRoundoff() * scale_;
  }

  void addFacet(const std::array<int, 3>& v) {
    for (std::size_t i = 0; i < 3; ++i) at_edge_[{v[i], v[(i + 1) % 3]}] = facets_.size();
    facets_.push_back(makeFacet(v));
    facets_.back().roughly = toDouble(facets_.back().offset);
  }

  /// A closed surface that stays out of a ball around the origin encloses the ball if it winds
  /// around it once; slivers cannot determine individually on which side the origin is. The winding
  /// is computed by solid angles (A. van Oosterom and J. Strackee, "The solid angle of a plane
  /// triangle", 1983): their sum is a whole number of turns, so double precision suffices.
  bool windsAroundOrigin() const {
    std::vector<Vector> units;
    units.reserve(vertices_.size());
    for (const Vector& p : vertices_) units.push_back(norm(p) > 0 ? unit(p) : Vector{});
    double sum = 0;
    for (const Facet& f : facets_) {
      if (!f.alive) continue;
      Vector u[3];
      for (std::size_t i = 0; i < 3; ++i) {
        u[i] = units[static_cast<std::size_t>(f.v[i])];
        if (!(squaredNorm(u[i]) > 0)) return false;
      }
      const Quad volume = dot(u[0], cross(u[1], u[2]));
      const Quad angles = 1 + dot(u[0], u[1]) + dot(u[1], u[2]) + dot(u[2], u[0]);
      const Quad largest = std::max(absolute(volume), absolute(angles));
      if (!(largest > 0)) return false;
      sum += 2 * std::atan2(toDouble(volume / largest), toDouble(angles / largest));
    }
    return std::abs(sum / (4 * std::numbers::pi) - 1) < 0.01;
  }

  /// Replaces the facets that see w and connect to `first` by the cone from their rim; false if
  /// rounding leaves nothing to do. Only one patch is replaced, because elsewhere only rounding
  /// makes facets visible, and replacing them would tear the surface.
  bool add(const Vector& w, std::size_t first) {
    const Quad tiny = wide(1e-29) * scale_;
    const auto sees = [&](const Facet& f) {
      return dot(f.plane_normal, w) - f.plane_offset > tiny;
    };
    if (!sees(facets_[first])) return false;
    std::vector<std::size_t> patch = {first};
    std::set<std::size_t> in_patch = {first};
    std::vector<std::pair<int, int>> rim;
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const std::array<int, 3> v = facets_[patch[next]].v;
      for (std::size_t i = 0; i < 3; ++i) {
        const int a = v[i], b = v[(i + 1) % 3];
        const std::size_t other = at_edge_.at({b, a});
        if (in_patch.count(other) != 0) continue;
        if (sees(facets_[other])) {
          in_patch.insert(other);
          patch.push_back(other);
        }
      }
    }
    for (const std::size_t f : patch) {
      for (std::size_t i = 0; i < 3; ++i) {
        const int a = facets_[f].v[i], b = facets_[f].v[(i + 1) % 3];
        if (in_patch.count(at_edge_.at({b, a})) == 0) rim.emplace_back(a, b);
      }
    }
    // Each rim vertex must be left exactly once; otherwise cone edges would have more than two
    // facets.
    std::set<int> left;
    for (const auto& [a, b] : rim) {
      if (!left.insert(a).second) return false;
    }
    const int index = static_cast<int>(vertices_.size());
    vertices_.push_back(w);
    for (const std::size_t f : patch) facets_[f].alive = false;
    for (const auto& [a, b] : rim) addFacet({a, b, index});
    alive_ += rim.size() - patch.size();
    return true;
  }

  const Difference& c_;
  Quad scale_;
  Quad best_support_ = infinity();
  std::vector<Vector> vertices_;
  std::vector<Facet> facets_;
  std::size_t alive_ = 0;
  std::map<std::pair<int, int>, std::size_t> at_edge_;  // facet on the left of an edge
};

}  // namespace

Bounds separation(const ConvexBody& a, const ConvexBody& b, const Bounds& enough) {
  const Difference c{a, b};
  const Quad scale = a.extent() + b.extent() + wide(1e-300);
  const Quad slack = 256 * quadRoundoff() * scale;
  const Quad radii = a.radius() + b.radius();
  const Bounds of_cores{enough.lower + radii + slack, enough.upper + radii - slack};
  Bounds core = distanceBounds(c, scale, of_cores);
  if (!(core.lower > 0)) {
    const Bounds depth = Polytope(c, scale).depth({-of_cores.upper, -of_cores.lower});
    core.lower = -depth.upper;
    if (depth.lower >= 0) core.upper = std::min(core.upper, -depth.lower);
  }
  return {core.lower - radii - slack, core.upper - radii + slack};
}

}  // namespace leeway::oracle
