#include "robots/urdf/rotation.h"

#include <Eigen/Geometry>

#include "collision/base/sine_cosine.h"
#include "leeway/robots/model.h"

namespace leeway::robots {

Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle) {
  double sine, cosine;
  collision::sineCosine(angle, sine, cosine);
  const Eigen::Vector3d a = axis.normalized();
  Eigen::Matrix3d cross;
  cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return cosine * Eigen::Matrix3d::Identity() + sine * cross + (1 - cosine) * (a * a.transpose());
}

Eigen::Matrix3d rotationOfZ(const Eigen::Vector3d& direction) {
  Eigen::Vector3d u, v;
  const Eigen::Vector3d z = direction.normalized();
  planeAxes(z, u, v);
  Eigen::Matrix3d R;
  R << u, v, z;
  return R;
}

Eigen::Matrix3d rotationOf(const std::vector<double>& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

}  // namespace leeway::robots
