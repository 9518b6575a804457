#include "collision/mesh/obb_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/mesh/box_ranges.h"

namespace leeway::collision {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// A right-handed frame with its first axis along `first` and its second close to `second`. A vector
// whose square has lost digits defines no axis, because after division by its length it would not
// be of length 1.
Matrix3d frame(const Vector3d& first, const Vector3d& second) {
  Matrix3d axes = Matrix3d::Identity();
  if (!(first.norm() > kLeastToSquare)) return axes;
  axes.col(0) = first.normalized();
  Vector3d across = second - axes.col(0).dot(second) * axes.col(0);
  if (!(across.norm() > std::max(1e-6 * second.norm(), kLeastToSquare)))
    across = axes.col(0).unitOrthogonal();
  axes.col(1) = across.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

// Second moments of points: a symmetric matrix.
class Spread {
 public:
  void add(const Vector3d& v, double weight) {
    const double x = weight * v.x(), y = weight * v.y();
    xx_ += x * v.x();
    xy_ += x * v.y();
    xz_ += x * v.z();
    yy_ += y * v.y();
    yz_ += y * v.z();
    zz_ += weight * v.z() * v.z();
  }
  void add(const Spread& s, double weight) {
    xx_ += weight * s.xx_;
    xy_ += weight * s.xy_;
    xz_ += weight * s.xz_;
    yy_ += weight * s.yy_;
    yz_ += weight * s.yz_;
    zz_ += weight * s.zz_;
  }
  void scale(double by) {
    Spread scaled;
    scaled.add(*this, by);
    *this = scaled;
  }

  // The direction of the largest spread and, second, of the largest spread across it. Parts of a
  // surface are usually flat, so the direction of the least spread is the best conditioned one. It
  // is the adjugate's largest, found by repeated squaring. The direction of the largest spread
  // across it has a closed form, and so has the second one across that. Errors of the first
  // direction within their plane cancel.
  Matrix3d principal() const {
    const double size = xx_ + yy_ + zz_;
    if (!(size > 0)) return Matrix3d::Identity();
    Spread unit = *this;
    unit.scale(1 / size);
    Spread power = unit.adjugate();
    Vector3d first;
    if (power.xx_ + power.yy_ + power.zz_ > 1e-12) {
      for (int i = 0; i < 4; ++i) {
        power.scale(1 / (power.xx_ + power.yy_ + power.zz_));
        power = power.squared();
      }
      first = unit.mostAcross(power.longestColumn().normalized());
    } else {  // along a line
      first = unit.longestColumn();
    }
    return first.norm() > 0 ? frame(first, unit.mostAcross(first.normalized()))
                            : Matrix3d::Identity();
  }

  // The direction of the largest spread across the unit vector n.
  Vector3d mostAcross(const Vector3d& n) const {
    const Vector3d u = n.unitOrthogonal(), v = cross(n, u);
    const Vector3d along_u = times(u);
    const double a = u.dot(along_u), b = v.dot(along_u), c = v.dot(times(v));
    // For the 2x2 matrix (a, b; b, c) with h = (a - c) / 2, r = sqrt(h^2 + b^2), both (h + r, b)
    // and (b, r - h) are along the eigenvector of its larger eigenvalue.
    const double h = 0.5 * (a - c), r = std::sqrt(h * h + b * b);
    if (!(r > 0)) return u;
    return h >= 0 ? Vector3d((h + r) * u + b * v) : Vector3d(b * u + (r - h) * v);
  }

 private:
  Vector3d times(const Vector3d& v) const {
    return {xx_ * v.x() + xy_ * v.y() + xz_ * v.z(), xy_ * v.x() + yy_ * v.y() + yz_ * v.z(),
            xz_ * v.x() + yz_ * v.y() + zz_ * v.z()};
  }
  // Every column of a matrix of nearly rank one is along its range; the column of the largest
  // diagonal entry is the best conditioned.
  Vector3d longestColumn() const {
    if (yy_ > xx_ && yy_ >= zz_) return {xy_, yy_, yz_};
    if (zz_ > xx_ && zz_ > yy_) return {xz_, yz_, zz_};
    return {xx_, xy_, xz_};
  }
  Spread adjugate() const {
    Spread s;
    s.xx_ = yy_ * zz_ - yz_ * yz_;
    s.yy_ = xx_ * zz_ - xz_ * xz_;
    s.zz_ = xx_ * yy_ - xy_ * xy_;
    s.xy_ = xz_ * yz_ - xy_ * zz_;
    s.xz_ = xy_ * yz_ - xz_ * yy_;
    s.yz_ = xy_ * xz_ - yz_ * xx_;
    return s;
  }
  Spread squared() const {
    Spread s;
    s.xx_ = xx_ * xx_ + xy_ * xy_ + xz_ * xz_;
    s.xy_ = xx_ * xy_ + xy_ * yy_ + xz_ * yz_;
    s.xz_ = xx_ * xz_ + xy_ * yz_ + xz_ * zz_;
    s.yy_ = xy_ * xy_ + yy_ * yy_ + yz_ * yz_;
    s.yz_ = xy_ * xz_ + yy_ * yz_ + yz_ * zz_;
    s.zz_ = xz_ * xz_ + yz_ * yz_ + zz_ * zz_;
    return s;
  }

  double xx_ = 0, xy_ = 0, xz_ = 0, yy_ = 0, yz_ = 0, zz_ = 0;
};

}  // namespace

void ObbFit::start(std::size_t triangles) {
  triangles_ = triangles;
  corners_ = 0;
  const std::size_t size = (3 * triangles + kRangeBlock - 1) / kRangeBlock * kRangeBlock;
  for (std::vector<double>& column : column_) column.resize(size);
}

FittedBox ObbFit::fit() {
  const Vector3d last = corner(triangles_ - 1, 2);
  while (corners_ < column_[0].size()) add(last);
  std::array<Matrix3d, kMostFrames> frames;
  std::size_t count = 0;
  frames[count++].setIdentity();
  if (triangles_ == 1) {
    frames[count++] = frameOfTriangle();
  } else {
    addFrames(frames, count);
  }
  return smallestAlong(frames.data(), count);
}

FittedBox ObbFit::smallestAlong(const Matrix3d* frames, std::size_t count) const {
  std::array<BoxRange, kMostFrames> ranges;
  boxRanges({column_[0], column_[1], column_[2]}, {frames, count}, ranges.data());
  FittedBox smallest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    FittedBox box;
    box.axes = frames[i];
    box.half = 0.5 * (ranges[i].high - ranges[i].low);
    box.center = frames[i] * (0.5 * (ranges[i].low + ranges[i].high));
    if (!(box.halfArea() < least)) continue;
    least = box.halfArea();
    smallest = box;
  }
  return smallest;
}

// A frame along an edge onto which the third corner projects. The rectangles along such edges have
// the least area of all around the triangle, the same for each; the one with the least girth is
// selected.
Matrix3d ObbFit::frameOfTriangle() const {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  const Vector3d a = corner(0, 0), b = corner(0, 1), c = corner(0, 2);
  const std::array<Vector3d, 3> edge = {b - a, c - b, a - c};
  const double twice_area = cross(edge[0], edge[2]).norm();
  for (std::size_t k = 0; k < 3; ++k) {
    const double squared = edge[k].squaredNorm(), along = -edge[k].dot(edge[(k + 2) % 3]);
    if (!(along > -1e-9 * squared && along < (1 + 1e-9) * squared)) continue;
    const double length = std::sqrt(squared), girth = length + twice_area / length;
    if (!(girth < least)) continue;
    least = girth;
    best = k;
  }
  return frame(edge[best], -edge[(best + 2) % 3]);
}

// The principal axes of the corners and of the surface, and the mean normal with the largest spread
// across it.
void ObbFit::addFrames(std::array<Matrix3d, kMostFrames>& frames, std::size_t& count) const {
  Vector3d mean = Vector3d::Zero(), corner_mean = Vector3d::Zero(), normal = Vector3d::Zero();
  Spread spread, corner_spread;
  double total = 0;
  const Vector3d origin = corner(0, 0);
  for (std::size_t i = 0; i < triangles_; ++i) {
    const Vector3d a = corner(i, 0) - origin, b = corner(i, 1) - origin, c = corner(i, 2) - origin;
    const Vector3d twice_area = cross(b - a, c - a), middle = (a + b + c) / 3;
    const double area = 0.5 * twice_area.norm();
    normal += twice_area;
    mean += area * middle;
    total += area;
    Spread corners;
    corners.add(a, 1);
    corners.add(b, 1);
    corners.add(c, 1);
    corner_spread.add(corners, 1);
    corners.add(middle, 9);
    spread.add(corners, area / 12);
    corner_mean += a + b + c;
  }
  const double corner_count = 3 * static_cast<double>(triangles_);
  corner_mean /= corner_count;
  corner_spread.scale(1 / corner_count);
  corner_spread.add(corner_mean, -1);
  frames[count++] = corner_spread.principal();
  if (!(total > 0)) return;
  mean /= total;
  spread.scale(1 / total);
  spread.add(mean, -1);
  frames[count++] = spread.principal();
  if (!(normal.norm() > 0)) return;
  frames[count++] = frame(normal, spread.mostAcross(normal.normalized()));
}

}  // namespace leeway::collision
