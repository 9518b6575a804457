#include "tools/truth/oracle/oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "tools/truth/oracle/convex.h"

namespace leeway::oracle {
namespace {

using collision::Pose;
using collision::Shape;
using collision::ShapeType;
using collision::TriangleMesh;

/// A placed triangle and its bounding sphere.
struct Triangle {
  std::array<Vector, 3> p;
  Vector center;
  Quad radius;
  int component;
  std::uint64_t weight;  // TriangleMesh::windingWeight()
};

struct PlacedMesh {
  std::vector<Triangle> triangles;
  std::vector<Vector> vertices;
  std::vector<bool> closed;             // a component
  std::vector<Vector> component_point;  // one vertex of each
};

PlacedMesh place(const TriangleMesh& mesh, const Pose& X_WM, const Vector& origin) {
  PlacedMesh result;
  Vector column[3];
  for (int c = 0; c < 3; ++c) column[c] = toVector(X_WM.rotation.col(c));
  const Vector translation = toVector(X_WM.translation) - origin;
  for (const Eigen::Vector3d& v : mesh.vertices()) {
    const Vector p = toVector(v);
    result.vertices.push_back(p.x * column[0] +
                              (p.y * column[1] + (p.z * column[2] + translation)));
  }
  for (int i = 0; i < mesh.componentCount(); ++i) result.closed.push_back(mesh.isClosed(i));
  result.component_point.resize(result.closed.size());
  for (std::size_t i = 0; i < mesh.triangles().size(); ++i) {
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k)
      t.p[k] = result.vertices[static_cast<std::size_t>(mesh.triangles()[i][k])];
    t.center = (wide(1) / 3) * (t.p[0] + t.p[1] + t.p[2]);
    t.radius = 0;
    for (const Vector& p : t.p) t.radius = std::max(t.radius, norm(p - t.center));
    t.component = mesh.component(static_cast<int>(i));
    t.weight = mesh.windingWeight(static_cast<int>(i));
    result.component_point[static_cast<std::size_t>(t.component)] = t.p[0];
    result.triangles.push_back(t);
  }
  return result;
}

ConvexBody body(const Triangle& t) {
  return ConvexBody(std::vector<Vector>(t.p.begin(), t.p.end()));
}

enum class Crossing { kNone, kOut, kIn, kUnclear };

/// How the ray from p along d crosses the triangle; unclear if rounding decides.
Crossing crossing(const Triangle& t, const Vector& p, const Vector& d) {
  const Vector a = t.p[0] - p, b = t.p[1] - p, c = t.p[2] - p;
  const Quad size = norm(a) + norm(b) + norm(c);
  const Quad tiny = wide(1e-28) * size * size;
  const Quad u = dot(d, cross(a, b)), v = dot(d, cross(b, c)), w = dot(d, cross(c, a));
  if (absolute(u) <= tiny || absolute(v) <= tiny || absolute(w) <= tiny) return Crossing::kUnclear;
  if ((u > 0) != (v > 0) || (u > 0) != (w > 0)) return Crossing::kNone;
  const Vector n = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
  const Quad height = dot(n, a), slope = dot(n, d);
  if ((height > 0) != (slope > 0)) return Crossing::kNone;
  return slope > 0 ? Crossing::kOut : Crossing::kIn;
}

enum class Inside { kNo, kYes, kUnknown };

bool same(const Vector& a, const Vector& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// Whether p is inside a closed component: its winding number, modulo the prime of the weights, by
/// a ray that stays clear of edges.
Inside inside(const PlacedMesh& mesh, const Vector& p) {
  constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61) - 1;
  Inside result = Inside::kNo;
  for (std::size_t component = 0; component < mesh.closed.size(); ++component) {
    if (!mesh.closed[component]) continue;
    bool decided = false;
    for (int attempt = 0; attempt < 64; ++attempt) {
      const Quad k = wide(attempt);
      const Vector d{wide(0.6180339887) + k / 7, wide(0.3028) - k / 11,
                     wide(0.2360679) + k * k / 13};
      std::uint64_t winding = 0;
      bool clear = true;
      for (const Triangle& t : mesh.triangles) {
        if (t.component != static_cast<int>(component)) continue;
        // A triangle that degenerates to a segment or point bounds nothing.
        if (same(t.p[0], t.p[1]) || same(t.p[1], t.p[2]) || same(t.p[2], t.p[0])) continue;
        const Crossing hit = crossing(t, p, d);
        if (hit == Crossing::kUnclear) clear = false;
        if (hit == Crossing::kOut) winding += t.weight;
        if (hit == Crossing::kIn) winding += kPrime - t.weight;
        winding %= kPrime;
      }
      if (!clear) continue;
      if (winding != 0) return Inside::kYes;
      decided = true;
      break;
    }
    if (!decided) result = Inside::kUnknown;
  }
  return result;
}

/// Distance from a point to the surface, bounded from below.
Quad surfaceDistance(const PlacedMesh& mesh, const Vector& p) {
  Quad best = infinity();
  const ConvexBody point({p});
  for (const Triangle& t : mesh.triangles) {
    if (norm(t.center - p) - t.radius > best) continue;
    best = std::min(best, separation(point, body(t)).lower);
  }
  return best;
}

Bounds meet(const Bounds& a, const Bounds& b) {
  return {std::min(a.lower, b.lower), std::min(a.upper, b.upper)};
}

struct Whole {
  Bounds hull;                  // separation of the convex hulls: a lower bound
  Bounds pieces;                // minimum over the pieces' separations
  Quad contained = infinity();  // <= 0: minus a depth proven by containment
  bool contained_unknown = false;
};

Truth judge(const Whole& w) {
  const Quad upper = std::min(w.pieces.upper, w.contained);
  if (upper > 0 && w.contained > 0 && !w.contained_unknown && w.pieces.lower > 0) {
    return {roundDown(std::max(w.pieces.lower, w.hull.lower)), roundUp(upper), true};
  }
  return {roundDown(std::min(w.hull.lower, upper)), roundUp(upper), false};
}

Truth meshAgainstConvex(const PlacedMesh& mesh, const ConvexBody& convex) {
  Whole w;
  w.hull = separation(ConvexBody(mesh.vertices), convex);
  w.pieces = {infinity(), infinity()};
  const Vector any = convex.support({1, 0, 0});
  const Vector other = convex.support({-1, 0, 0});
  const Vector middle = wide(0.5) * (any + other);
  for (const Triangle& t : mesh.triangles) {
    // Prunes, because the triangle's separation from the convex body is at least its bounding
    // sphere's.
    const Bounds coarse = w.pieces.upper < infinity() ? separation(ConvexBody({t.center}), convex)
                                                      : Bounds{-infinity(), infinity()};
    if (coarse.lower - t.radius > w.pieces.upper) continue;
    w.pieces = meet(w.pieces, separation(body(t), convex));
  }
  const Inside middle_inside = inside(mesh, middle);
  if (middle_inside == Inside::kYes) w.contained = -surfaceDistance(mesh, middle) - convex.radius();
  if (middle_inside == Inside::kUnknown) w.contained_unknown = true;
  return judge(w);
}

Truth meshAgainstMesh(const PlacedMesh& a, const PlacedMesh& b) {
  Whole w;
  w.hull = separation(ConvexBody(a.vertices), ConvexBody(b.vertices));
  w.pieces = {infinity(), infinity()};
  for (const Triangle& s : a.triangles) {
    for (const Triangle& t : b.triangles) {
      if (norm(s.center - t.center) - s.radius - t.radius > w.pieces.upper) continue;
      w.pieces = meet(w.pieces, separation(body(s), body(t)));
    }
  }
  for (const auto& [mesh, other] : {std::pair{&a, &b}, {&b, &a}}) {
    for (const Vector& p : other->component_point) {
      const Inside p_inside = inside(*mesh, p);
      if (p_inside == Inside::kYes) w.contained = std::min(w.contained, -surfaceDistance(*mesh, p));
      if (p_inside == Inside::kUnknown) w.contained_unknown = true;
    }
  }
  return judge(w);
}

/// The half-space of pose X as unit normal and offset, from its plane's two directions.
struct Plane {
  Vector normal, point;
};

Plane plane(const Pose& X, const Vector& origin) {
  const Vector n = cross(toVector(X.rotation.col(0)), toVector(X.rotation.col(1)));
  return {(1 / norm(n)) * n, toVector(X.translation) - origin};
}

Truth halfSpaceAgainst(const Pose& X_WH, const Shape& b, const Pose& X_WB) {
  const Vector origin = toVector(X_WB.translation);
  const Plane h = plane(X_WH, origin);
  Quad lowest = infinity(), radius = 0;
  Quad scale = norm(h.point);
  if (b.type() == ShapeType::kMesh) {
    for (const Vector& v : place(*b.mesh(), X_WB, origin).vertices) {
      lowest = std::min(lowest, dot(h.normal, v - h.point));
      scale = std::max(scale, norm(v));
    }
  } else {
    const ConvexBody convex(b, X_WB, origin);
    lowest = dot(h.normal, convex.support(-h.normal) - h.point);
    radius = convex.radius();
    scale += convex.extent();
  }
  const Quad slack = 64 * quadRoundoff() * scale;
  return {roundDown(lowest - radius - slack), roundUp(lowest - radius + slack), true};
}

}  // namespace

Truth signedSeparation(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  const bool half_a = a.type() == ShapeType::kHalfSpace, half_b = b.type() == ShapeType::kHalfSpace;
  if (half_a && half_b) return {-HUGE_VAL, HUGE_VAL, false};
  if (half_a) return halfSpaceAgainst(X_WA, b, X_WB);
  if (half_b) return halfSpaceAgainst(X_WB, a, X_WA);
  const Vector origin = toVector(X_WA.translation);
  const bool mesh_a = a.type() == ShapeType::kMesh, mesh_b = b.type() == ShapeType::kMesh;
  if (mesh_a && mesh_b)
    return meshAgainstMesh(place(*a.mesh(), X_WA, origin), place(*b.mesh(), X_WB, origin));
  if (mesh_a) return meshAgainstConvex(place(*a.mesh(), X_WA, origin), ConvexBody(b, X_WB, origin));
  if (mesh_b) return meshAgainstConvex(place(*b.mesh(), X_WB, origin), ConvexBody(a, X_WA, origin));
  const Bounds s = separation(ConvexBody(a, X_WA, origin), ConvexBody(b, X_WB, origin));
  return {roundDown(s.lower), roundUp(s.upper), true};
}

Truth convexSeparation(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                       const Enough& enough) {
  const auto is_searched = [](const Shape& s) {
    return s.isConvex() && s.type() != ShapeType::kHalfSpace;
  };
  if (!is_searched(a) || !is_searched(b)) return signedSeparation(a, X_WA, b, X_WB);
  const Vector origin = toVector(X_WA.translation);
  const Bounds s = separation(ConvexBody(a, X_WA, origin), ConvexBody(b, X_WB, origin),
                              {wide(enough.lower), wide(enough.upper)});
  return {roundDown(s.lower), roundUp(s.upper), true};
}

}  // namespace leeway::oracle
