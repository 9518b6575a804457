#include "planner/verify/kinematics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"
#include "planner/base/tolerances.h"

namespace leeway::planner::verification {
namespace {

using collision::Shape;
using collision::ShapeType;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using robots::Joint;
using robots::JointType;
using robots::Model;
using robots::Pose;

/// The rotation of a quaternion xyzw whose length is not zero. Turns the unit vectors: v + 2 w (u x
/// v) + 2 u x (u x v), where u and w are normalised.
Matrix3d rotationOf(const double* q) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const Vector3d u = Vector3d(q[0], q[1], q[2]) / norm;
  const double w = q[3] / norm;
  Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    const Vector3d e = Vector3d::Unit(i), twice = 2 * u.cross(e);
    R.col(i) = e + w * twice + u.cross(twice);
  }
  return R;
}

/// Directions of a planar joint's x and y: the unit vectors under the shortest rotation of the z
/// axis onto the normal. This rotation is two reflections: in z, then in the bisector of z and the
/// normal.
void planeDirections(const Vector3d& normal, Vector3d& u, Vector3d& v) {
  if (normal.x() * normal.x() + normal.y() * normal.y() <= kVerifyAcross) {
    u = Vector3d::UnitX();
    v = normal.z() < 0 ? Vector3d(-Vector3d::UnitY()) : Vector3d(Vector3d::UnitY());
    return;
  }
  // For a normal almost opposite to z, 1 + normal.z cancels: it is computed from the other two.
  const double across = normal.x() * normal.x() + normal.y() * normal.y();
  Vector3d bisector(normal.x(), normal.y(),
                    normal.z() < 0 ? across / (1 - normal.z()) : 1 + normal.z());
  bisector /= bisector.norm();
  const auto reflect = [&](const Vector3d& p) -> Vector3d {
    return p - 2 * bisector.dot(p) * bisector;
  };
  u = reflect(Vector3d::UnitX());  // the reflection in z leaves x and y alone
  v = reflect(Vector3d::UnitY());
}

/// The position of a joint with one variable. A mimic joint follows its master's variable.
double position(const Model& model, const Joint& joint, std::span<const double> q) {
  if (joint.mimic < 0) return q[at(joint.first_variable)];
  return joint.multiplier * position(model, model.joints[at(joint.mimic)], q) + joint.offset;
}

/// The change of that position under dq. Offsets do not contribute.
double change(const Model& model, const Joint& joint, std::span<const double> dq) {
  if (joint.mimic < 0) return dq[at(joint.first_variable)];
  return joint.multiplier * change(model, model.joints[at(joint.mimic)], dq);
}

Pose jointMotion(const Model& model, const Joint& joint, std::span<const double> q) {
  Pose X_JC;
  switch (joint.type) {
    case JointType::kFixed:
      break;
    case JointType::kRevolute:
    case JointType::kContinuous:
      X_JC.rotation = rotationAbout(joint.axis, position(model, joint, q));
      break;
    case JointType::kPrismatic:
      X_JC.translation = position(model, joint, q) * joint.axis;
      break;
    case JointType::kPlanar: {
      const double* p = &q[at(joint.first_variable)];
      Vector3d u, v;
      planeDirections(joint.axis, u, v);
      X_JC.rotation = rotationAbout(joint.axis, p[2]);
      X_JC.translation = p[0] * u + p[1] * v;
      break;
    }
    case JointType::kFloating: {
      const double* p = &q[at(joint.first_variable)];
      X_JC.rotation = rotationOf(p + 3);
      X_JC.translation = Vector3d(p[0], p[1], p[2]);
      break;
    }
  }
  return X_JC;
}

Sphere enclosingPoints(std::span<const Vector3d> points) {
  Vector3d low = points[0], high = points[0];
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Sphere sphere{(low + high) / 2, 0};
  for (const Vector3d& p : points)
    sphere.radius = std::max(sphere.radius, (p - sphere.center).norm());
  return sphere;
}

}  // namespace

/// Keeps the part of a vector along the axis and turns the part across it. Sine and cosine are
/// rounded from long double, because C libraries agree on that.
Matrix3d rotationAbout(const Vector3d& axis, double angle) {
  const double s = static_cast<double>(std::sin(static_cast<long double>(angle)));
  const double c = static_cast<double>(std::cos(static_cast<long double>(angle)));
  Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    const Vector3d e = Vector3d::Unit(i);
    const Vector3d along = axis * axis[i];
    R.col(i) = along + c * (e - along) + s * axis.cross(e);
  }
  return R;
}

std::vector<Pose> placeLinks(const Model& model, std::span<const double> q) {
  std::vector<Pose> X_WL(model.links.size());
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const Pose X_PC = joint.X_PJ * jointMotion(model, joint, q);
    X_WL[at(joint.child_link)] = joint.parent_link < 0 ? X_PC : X_WL[at(joint.parent_link)] * X_PC;
  }
  return X_WL;
}

Sphere enclosingSphere(const Shape& shape) {
  Sphere sphere;
  const double r = shape.radius(), l = shape.halfLength();
  switch (shape.type()) {
    case ShapeType::kSphere:
      sphere.radius = r;
      break;
    case ShapeType::kCapsule:
      sphere.radius = r + l;
      break;
    case ShapeType::kBox:
      sphere.radius = shape.halfExtents().norm();
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      sphere.radius = std::sqrt(r * r + l * l);
      break;
    case ShapeType::kEllipsoid:
      sphere.radius = shape.halfExtents().maxCoeff();
      break;
    case ShapeType::kHalfSpace:
      sphere.radius = std::numeric_limits<double>::infinity();
      break;
    case ShapeType::kConvexHull:
      sphere = enclosingPoints(shape.hull()->vertices());
      break;
    case ShapeType::kMesh:
      sphere = enclosingPoints(shape.mesh()->vertices());
      break;
    case ShapeType::kDeformable:
      sphere = enclosingPoints(shape.deformable()->vertices());
      break;
  }
  sphere.radius += kVerifyRounding * (sphere.radius + sphere.center.norm());
  return sphere;
}

std::vector<int> jointsAbove(const Model& model, int link) {
  std::vector<int> joints;
  while (link >= 0) {
    joints.push_back(model.links[at(link)].joint);
    link = model.joints[at(joints.back())].parent_link;
  }
  return joints;
}

Motion boundMotion(const Model& model, std::span<const int> joints, std::span<const Pose> X_WL,
                   std::span<const double> dq, const Vector3d& center_W, double radius,
                   double half) {
  Motion motion;
  for (const int j : joints) {
    const Joint& joint = model.joints[at(j)];
    const Pose& X_WC = X_WL[at(joint.child_link)];
    const Vector3d arm = center_W - X_WC.translation;
    // Seen from this joint's child link, in which the joint's axis is at rest, the joints between
    // it and the body move the body by at most half * motion.speed.
    const double drift = half * motion.speed;
    motion.slack += kVerifyRounding * (1 + arm.norm() + radius);
    const auto turn = [&](double angle, double distance) {
      if (angle != 0) motion.speed += angle * (distance + radius + drift);
    };
    const auto distanceFromAxis = [&] { return arm.cross(X_WC.rotation * joint.axis).norm(); };
    switch (joint.type) {
      case JointType::kFixed:
        break;
      case JointType::kRevolute:
      case JointType::kContinuous:
        turn(std::abs(change(model, joint, dq)), distanceFromAxis());
        break;
      case JointType::kPrismatic:
        motion.speed += std::abs(change(model, joint, dq));
        break;
      case JointType::kPlanar: {
        const double* d = &dq[at(joint.first_variable)];
        turn(std::abs(d[2]), distanceFromAxis());
        motion.speed += std::sqrt(d[0] * d[0] + d[1] * d[1]);
        break;
      }
      case JointType::kFloating: {
        const double* d = &dq[at(joint.first_variable)];
        turn(Vector3d(d[3], d[4], d[5]).norm(), arm.norm());
        motion.speed += Vector3d(d[0], d[1], d[2]).norm();
        break;
      }
    }
  }
  motion.speed *= 1 + kVerifyRounding;
  return motion;
}

/// The velocity is the sum of J_j q'_j. The derivative of J_j along an inner joint that turns is
/// |J_j| at most, and so is that of an inner J_k along j: the velocity changes by at most
/// |J_j| |q''_j| + |J_j| |q'_j|^2 + 2 |J_j| |q'_j| |q'_k|, summed over joints j and inner joints k
/// that turn.
double boundSpeed(const Model& model, std::span<const int> joints, std::span<const Pose> X_WL,
                  const VariableRates& rates, const Vector3d& point_W, double half,
                  double& at_instant) {
  Vector3d velocity = Vector3d::Zero();
  double reached = 0;                  // bound on the speed against the joint's child link
  double acceleration = 0, outer = 0;  // outer: the speeds of joints before in the list
  for (const int j : joints) {
    const Joint& joint = model.joints[at(j)];
    const Pose& X_WC = X_WL[at(joint.child_link)];
    const Vector3d arm = point_W - X_WC.translation;
    const auto turn = [&](double now, double most, double second) {
      const Vector3d J = (X_WC.rotation * joint.axis).cross(arm);
      const double length = J.norm() + half * reached, speed = length * most;
      velocity += now * J;
      acceleration += length * second + speed * most + 2 * outer * most;
      outer += speed;
      reached += speed;
    };
    const auto slide = [&](const Vector3d& now, double most, double second) {
      velocity += now;
      acceleration += second;
      outer += most;
      reached += most;
    };
    switch (joint.type) {
      case JointType::kFixed:
        break;
      case JointType::kRevolute:
      case JointType::kContinuous:
        turn(change(model, joint, rates.now), std::abs(change(model, joint, rates.most)),
             std::abs(change(model, joint, rates.second)));
        break;
      case JointType::kPrismatic:
        slide(change(model, joint, rates.now) * (X_WC.rotation * joint.axis),
              std::abs(change(model, joint, rates.most)),
              std::abs(change(model, joint, rates.second)));
        break;
      case JointType::kPlanar: {
        const auto first = at(joint.first_variable);
        turn(rates.now[first + 2], rates.most[first + 2], rates.second[first + 2]);
        Vector3d u, v;
        planeDirections(joint.axis, u, v);
        const Matrix3d R_WJ = (joint.parent_link < 0 ? Matrix3d(Matrix3d::Identity())
                                                     : X_WL[at(joint.parent_link)].rotation) *
                              joint.X_PJ.rotation;
        slide(R_WJ * (rates.now[first] * u + rates.now[first + 1] * v),
              std::hypot(rates.most[first], rates.most[first + 1]),
              std::hypot(rates.second[first], rates.second[first + 1]));
        break;
      }
      case JointType::kFloating:
        acceleration = std::numeric_limits<double>::infinity();
        break;
    }
  }
  at_instant = velocity.norm();
  return (at_instant + half * acceleration) * (1 + kVerifyRounding);
}

}  // namespace leeway::planner::verification
