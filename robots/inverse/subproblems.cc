#include "robots/inverse/subproblems.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "collision/base/sine_cosine.h"
#include "robots/base/tolerances.h"
#include "robots/inverse/arc_tangent.h"

namespace leeway::robots {

Eigen::Matrix3d turnAbout(const Eigen::Vector3d& axis, double angle) {
  double s, c;
  collision::sineCosine(angle, s, c);
  const double x = axis(0), y = axis(1), z = axis(2), t = 1 - c;
  Eigen::Matrix3d R;
  R << t * x * x + c, t * x * y - s * z, t * x * z + s * y,  //
      t * x * y + s * z, t * y * y + c, t * y * z - s * x,   //
      t * x * z - s * y, t * y * z + s * x, t * z * z + c;
  return R;
}

Angles angleBetween(const Eigen::Vector3d& k, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                    double otherwise) {
  const Eigen::Vector3d across = k.cross(p);
  const double sine = across.dot(q), cosine = p.dot(q) - k.dot(p) * k.dot(q);
  // Both are |p across k| |q across k|, at most, which is compared with |p| |q|.
  const double size = p.squaredNorm() * q.squaredNorm();
  if (!(sine * sine + cosine * cosine > kSingular * kSingular * size))
    return {1, {otherwise}, true};
  return {1, {arcTangent(sine, cosine)}, false};
}

Angles anglesToPlane(const Eigen::Vector3d& h, const Eigen::Vector3d& k, const Eigen::Vector3d& p,
                     double d, double otherwise) {
  // h . p at angle t is C + A sin t + B cos t.
  const Eigen::Vector3d across = k.cross(p);
  const double along = k.dot(p) * h.dot(k);
  const double a = h.dot(across), b = h.dot(p) - along;
  const double r = std::sqrt(a * a + b * b), size = std::sqrt(h.squaredNorm() * p.squaredNorm());
  const double lack = d - along;
  if (!(r > kSingular * size)) {
    if (!(std::fabs(lack) <= kSingular * (size + std::fabs(d)))) return {};
    return {1, {otherwise}, true};
  }
  const double cosine = lack / r;
  if (!(std::fabs(cosine) <= 1 + kSingular)) return {};
  const bool singular = std::fabs(cosine) > 1 - kSingular;
  const double c = std::clamp(cosine, -1.0, 1.0), s = std::sqrt(1 - c * c);
  if (!(s > 0)) return {1, {arcTangent(c * a, c * b)}, true};
  return {2,
          {arcTangent(c * a + s * b, c * b - s * a), arcTangent(c * a - s * b, c * b + s * a)},
          singular};
}

Angles anglesToDistance(const Eigen::Vector3d& k, const Eigen::Vector3d& p,
                        const Eigen::Vector3d& q, double d, double otherwise) {
  return anglesToPlane(q, k, p, (p.squaredNorm() + q.squaredNorm() - d * d) / 2, otherwise);
}

MeetingPoints meetingPoints(const Eigen::Vector3d& k1, const Eigen::Vector3d& p1,
                            const Eigen::Vector3d& k2, const Eigen::Vector3d& p2) {
  // z = u k1 + v k2 + w k1 x k2 with k1 . z = k1 . p1, k2 . z = k2 . p2, |z| = |p|.
  const double a = k1.dot(p1), b = k2.dot(p2), c = k1.dot(k2);
  const Eigen::Vector3d normal = k1.cross(k2);
  const double across = normal.squaredNorm();
  const double u = (a - c * b) / across, v = (b - c * a) / across;
  const Eigen::Vector3d base = u * k1 + v * k2;
  const double squared_length = (p1.squaredNorm() + p2.squaredNorm()) / 2;
  const double left = squared_length - base.squaredNorm();
  MeetingPoints points;
  if (!(left >= -kSingular * squared_length)) return points;
  points.singular = !(left > kSingular * squared_length);
  const double w = left > 0 ? std::sqrt(left / across) : 0;
  points.count = w > 0 ? 2 : 1;
  points.point = {base + w * normal, base - w * normal};
  return points;
}

}  // namespace leeway::robots
