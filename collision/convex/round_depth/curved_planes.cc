#include "collision/convex/round_depth/curved_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/tolerances.h"
#include "collision/convex/gjk/tangents.h"

namespace leeway::collision {

namespace {

// Newton steps, and steps back onto an edge [count].
constexpr int kDescentSteps = 12;
constexpr int kEdgeSteps = 3;

}  // namespace

CurvedPlanes::CurvedPlanes(Difference<false>& difference, Progress& progress, double evenly)
    : difference_(difference), progress_(progress), faces_(difference, evenly) {}

double CurvedPlanes::stiffness() const { return std::max(std::abs(reach_), stiff_); }

double CurvedPlanes::ask(const Vector& e) {
  SupportPoint s;
  ++work_;
  if (!(e.squaredNorm() > 0.5)) return std::numeric_limits<double>::infinity();
  difference_.support(-e, s);
  const double value = e.dot(s.w);
  progress_.offerLower(-value, -e);
  reach_ = std::min(reach_, value);
  return value;
}

// The step onto one or two edges of the difference.
Vector CurvedPlanes::stepOnto(const CurvedFace& face, const CurvedEdge* edge, int edges) const {
  const auto besideOf = [&](const CurvedEdge& of, double& gain) {
    const Vector way = faces_.wayOf(face, of);
    gain = face.e.dot(way);
    return Vector(way - gain * face.e);
  };
  double gain_a = 0, gain_b = 0;
  const Vector a = besideOf(edge[0], gain_a);
  const double aa = a.squaredNorm();
  if (edges == 2) {
    const Vector b = besideOf(edge[1], gain_b);
    const TangentForm form = {aa, a.dot(b), b.squaredNorm()};
    if (form.determinant() > kSameDirectionSquared * aa * form.vv) {
      return newtonStep({a, b}, form, gain_a, gain_b);
    }
  }
  return aa > 0 ? Vector((-gain_a / aa) * a) : Vector::Zero();
}

Vector CurvedPlanes::wayFrom(const CurvedFace& face, CurvedStep& step) const {
  CurvedChoice choice;
  const Vector y = faces_.blend(face, stiffness(), 1, choice);
  const Vector& e = face.e;
  const double reach = e.dot(y);
  // The Hessian, along v and w, of the support minus the distance.
  const auto bend = [&](const Vector& v, const Vector& w) {
    return faces_.bend(face, choice, v, w) - reach * v.dot(w);
  };
  step.edges = faces_.edges(choice, step.edge);
  if (step.edges > 0) {
    const Vector across = stepOnto(face, step.edge, step.edges),
                 way = faces_.wayOf(face, step.edge[0]);
    const Vector beside = way - e.dot(way) * e;
    const double squared = beside.squaredNorm();
    if (step.edges == 2 || !(squared > 0)) return across;
    const Vector along = cross(e, beside) / std::sqrt(squared);
    const double second = bend(along, along), first = y.dot(along) + bend(along, across);
    return across - (first / (second > 0 ? second : reach)) * along;
  }
  const Tangents at = tangentsAt(e);
  const auto& [u, v] = at;
  const TangentForm hessian = {bend(u, u), bend(u, v), bend(v, v)};
  const double gu = y.dot(u), gv = y.dot(v);
  if (hessian.uu > 0 && hessian.determinant() > 0) return newtonStep(at, hessian, gu, gv);
  return -(gu * u + gv * v) / reach;
}

bool CurvedPlanes::stepFrom(const Vector& e, CurvedStep& step) const {
  step.way = wayFrom(faces_.along(e), step);
  const double length = step.way.norm();
  if (!(length > 0)) return false;
  if (length > 1) step.way /= length;
  return true;
}

Vector CurvedPlanes::after(const Vector& e, const CurvedStep& step) const {
  Vector next = (e + step.way).normalized();
  for (int i = 0; i < kEdgeSteps && step.edges > 0; ++i) {
    next = (next + stepOnto(faces_.along(next), step.edge, step.edges)).normalized();
  }
  return next;
}

void CurvedPlanes::descend(Vector e, double value) {
  for (int i = 0; i < kDescentSteps && !progress_.decided(); ++i) {
    CurvedStep step;
    if (!stepFrom(e, step)) return;
    bool nearer = false;
    const auto tryNext = [&] {
      const Vector next = after(e, step);
      const double next_value = ask(next);
      if (next_value < value) e = next, value = next_value, nearer = true;
    };
    for (int k = 0; k < kHalves && !nearer; ++k, step.way *= 0.5) tryNext();
    // (If two edges are nearly parallel, the step follows the first.)
    if (step.edges == 2) {
      std::swap(step.edge[0], step.edge[1]);
      step.way.setZero();
      tryNext();
    }
    if (!nearer) return;
  }
}

bool CurvedPlanes::meetsCap(const CurvedFace& face, int part, double wide) const {
  const Core core = faces_.view(part).core;
  return (core == Core::kCylinder || core == Core::kCone) && !(face.length[part] > wide);
}

Vector CurvedPlanes::memberOf(const CurvedFace& face, const CurvedChoice& choice, double wide,
                              Vector& point_a) const {
  point_a = placed(difference_.pose(), faces_.center(0, choice));
  Vector y = faces_.center(1, choice) - point_a;
  for (const bool caps : {false, true}) {
    for (int k = 0; k < 2; ++k) {
      if (meetsCap(face, k, wide) != caps) continue;
      const double share = faces_.share(k, choice);
      Vector arm = share * face.arm[k];
      if (caps) {
        const double radius = share * faces_.semiAxes(k).x();
        const Vector up = faces_.axis(k);
        arm = y.dot(face.e) * face.e - y;
        arm -= up.dot(arm) * up;
        const double length = arm.norm();
        if (length > radius) arm *= radius / length;
      }
      y += arm;
      if (k == 0) point_a -= arm;
    }
  }
  return y;
}

}  // namespace leeway::collision
