#include "tools/lab/motion/motion_truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"

namespace leeway::tools::report {
namespace {

using collision::Pose;
using Eigen::Vector3d;

/// Shortest interval of time that is still halved.
constexpr double kSmallest = 1e-11;
/// A time of contact is clear if it is known to within this.
constexpr double kClear = 1e-8;
/// Limit on the evaluations of one pair before it is declared unclear.
constexpr int kMostLooks = 2'000'000;

/// Gap of two point sets along a unit direction, of either sign.
double gapAlong(const Vector3d& n, std::span<const Vector3d> a, std::span<const Vector3d> b) {
  double low_a = kInfinity, high_a = -kInfinity, low_b = kInfinity, high_b = -kInfinity;
  for (const Vector3d& p : a) {
    const double x = n.dot(p);
    low_a = std::min(low_a, x), high_a = std::max(high_a, x);
  }
  for (const Vector3d& p : b) {
    const double x = n.dot(p);
    low_b = std::min(low_b, x), high_b = std::max(high_b, x);
  }
  return std::max(low_b - high_a, low_a - high_b);
}

/// Directions to project on; the best one of the last call is tried first (temporal coherence).
class Axes {
 public:
  /// The largest gap; stops at the first above `enough`. `offer(f)` calls f(direction), of any
  /// length, for each direction until it returns false.
  template <typename Offer>
  double largestGap(std::span<const Vector3d> a, std::span<const Vector3d> b, double enough,
                    const Offer& offer) {
    double best = -kInfinity;
    Vector3d best_axis = last_;
    const auto look = [&](const Vector3d& direction) {
      const double norm = direction.norm();
      if (!(norm > 1e-12)) return true;
      const Vector3d n = direction / norm;
      const double gap = gapAlong(n, a, b);
      if (gap > best) best = gap, best_axis = n;
      return best <= enough;
    };
    if (look(last_)) offer(look);
    last_ = best_axis;
    return best;
  }

 private:
  Vector3d last_ = Vector3d::Zero();
};

/// The first t in [0, end] with gap(t) <= 0, for a function that changes by at most `speed` per
/// unit of t. Bisects intervals that the gap in their middle does not clear, the earlier half
/// first. `gap(t, enough)` may return any lower bound above `enough`.
template <typename Gap>
TimeTruth firstTouch(const Gap& gap, double speed, double end) {
  TimeTruth truth{false, end, end, true};
  if (gap(0, 0) <= 0) return {true, 0, 0, true};
  if (gap(end, 0) <= 0) truth.contact = true;
  struct Span {
    double begin, end;
  };
  std::vector<Span> open = {{0, end}};
  for (int looks = 0; !open.empty(); ++looks) {
    const Span s = open.back();
    open.pop_back();
    if (truth.contact && s.begin >= truth.upper) continue;
    const double middle = s.begin + (s.end - s.begin) / 2, half = (s.end - s.begin) / 2;
    const double there = gap(middle, speed * half);
    if (there > speed * half) continue;
    if (there <= 0) {
      truth.contact = true;
      truth.upper = std::min(truth.upper, middle);
    }
    if (half <= kSmallest) {
      // Everything before it is clear. Is there contact directly after it?
      truth.lower = s.begin;
      double before = s.end;
      while (truth.contact && truth.upper - before > kSmallest) {
        const double between = before + (truth.upper - before) / 2;
        (gap(between, 0) <= 0 ? truth.upper : before) = between;
      }
      truth.clear = truth.contact && truth.upper - truth.lower <= kClear;
      return truth;
    }
    if (looks > kMostLooks) return {false, 0, 1, false};
    if (there > 0) open.push_back({middle, s.end});
    open.push_back({s.begin, middle});
  }
  // Every interval before a touch at its end was cleared.
  truth.lower = truth.contact ? std::max(0.0, truth.upper - kSmallest) : end;
  return truth;
}

Vector3d cornerAt(const collision::MovingTriangle& m, std::size_t i, double t) {
  return (1 - t) * m.from[i] + t * m.to[i];
}

}  // namespace

SlowPolytope slowBox(const Vector3d& h) {
  SlowPolytope p;
  for (int i = 0; i < 8; ++i)
    p.vertices.emplace_back((i & 1) != 0 ? h.x() : -h.x(), (i & 2) != 0 ? h.y() : -h.y(),
                            (i & 4) != 0 ? h.z() : -h.z());
  for (int i = 0; i < 3; ++i) p.normals.push_back(Vector3d::Unit(i));
  p.edges = p.normals;
  p.reach = h.norm();
  return p;
}

SlowPolytope slowHull(std::span<const Vector3d> points) {
  SlowPolytope p;
  p.vertices.assign(points.begin(), points.end());
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    p.reach = std::max(p.reach, points[i].norm());
    for (std::size_t j = i + 1; j < n; ++j) {
      bool edge = false;
      for (std::size_t k = 0; k < n; ++k) {
        if (k == i || k == j) continue;
        const Vector3d normal = (points[j] - points[i]).cross(points[k] - points[i]).normalized();
        int above = 0, below = 0;
        for (std::size_t l = 0; l < n; ++l) {
          const double side = normal.dot(points[l] - points[i]);
          above += side > 1e-12, below += side < -1e-12;
        }
        if (above > 0 && below > 0) continue;
        edge = true;
        if (k > j) p.normals.push_back(normal);
      }
      if (edge) p.edges.push_back((points[j] - points[i]).normalized());
    }
  }
  return p;
}

Eigen::Matrix3d slowTurn(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

TimeTruth slowFirstContact(std::span<const SlowBody> bodies,
                           std::span<const std::array<std::size_t, 2>> pairs, double margin) {
  TimeTruth first{false, 1, 1, true};
  for (const auto& pair : pairs) {
    const SlowBody &a = bodies[pair[0]], &b = bodies[pair[1]];
    Axes axes;
    std::vector<Vector3d> points(a.shape->vertices.size());
    const auto gap = [&](double t, double enough) {
      const Pose X_BA = b.pose(t).inverse() * a.pose(t);
      for (std::size_t i = 0; i < points.size(); ++i) points[i] = X_BA * a.shape->vertices[i];
      return axes.largestGap(points, b.shape->vertices, enough + margin, [&](const auto& look) {
        for (const Vector3d& n : b.shape->normals)
          if (!look(n)) return;
        for (const Vector3d& n : a.shape->normals)
          if (!look(X_BA.rotation * n)) return;
        for (const Vector3d& e : a.shape->edges) {
          const Vector3d along = X_BA.rotation * e;
          for (const Vector3d& f : b.shape->edges)
            if (!look(along.cross(f))) return;
        }
      }) - margin;
    };
    const TimeTruth truth = firstTouch(gap, a.speed + b.speed, first.upper);
    if (!truth.clear) return truth;
    if (truth.contact) first = truth;
  }
  return first;
}

TimeTruth slowFirstContact(const collision::MovingTriangle& a, const collision::MovingTriangle& b,
                           double margin) {
  double speed = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      speed = std::max(speed, (a.to[i] - a.from[i] - b.to[j] + b.from[j]).norm());
  Axes axes;
  const auto gap = [&](double t, double enough) {
    std::array<Vector3d, 3> p, q, e, f;
    for (std::size_t i = 0; i < 3; ++i) p[i] = cornerAt(a, i, t), q[i] = cornerAt(b, i, t);
    for (std::size_t i = 0; i < 3; ++i) e[i] = p[(i + 1) % 3] - p[i], f[i] = q[(i + 1) % 3] - q[i];
    const Vector3d m = e[0].cross(e[1]).normalized(), n = f[0].cross(f[1]).normalized();
    return axes.largestGap(p, q, enough + margin, [&](const auto& look) {
      if (!look(m) || !look(n)) return;
      for (std::size_t i = 0; i < 3; ++i) {
        // Edge normals within the planes decide coplanar pairs.
        if (!look(m.cross(e[i])) || !look(n.cross(f[i]))) return;
        for (std::size_t j = 0; j < 3; ++j)
          if (!look(e[i].cross(f[j]))) return;
      }
    }) - margin;
  };
  return firstTouch(gap, speed, 1);
}

}  // namespace leeway::tools::report
