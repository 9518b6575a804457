#include "collision/mesh/box_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "collision/base/round_box.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/mesh/box_ranges.h"

namespace leeway::collision {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// From this depth on nodes are parted by count, so that kMaxDepth holds for any mesh of 2^31
// triangles: each of the eight pieces has at most a quarter of them.
constexpr int kFreeDepth = BoxTree::kMaxDepth - 17;
// The same above convex pieces, so that the triangles below them have their share.
constexpr int kFreePieceDepth = kFreeDepth - 17;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

double halfArea(const Vector3d& h) { return h.x() * h.y() + h.y() * h.z() + h.z() * h.x(); }

// Vectors whose squares leave the range of normal doubles are brought to a length near 1, by a
// power of two: divided by their own lengths as rounded they would not be of length 1.
Vector3d withinRange(const Vector3d& v) {
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0 && largest <= std::numeric_limits<double>::max())) return v;
  if (largest >= kLeastToSquare && largest <= kMostToSquare) return v;
  const int exponent = std::ilogb(largest);
  return v.unaryExpr([&](double x) { return std::ldexp(x, -exponent); });
}

// A right-handed frame with its first axis along `along_first` and its second near to
// `near_second`.
Matrix3d frame(const Vector3d& along_first, const Vector3d& near_second) {
  const Vector3d first = withinRange(along_first), second = withinRange(near_second);
  Matrix3d axes = Matrix3d::Identity();
  if (!(first.norm() > 0)) return axes;
  axes.col(0) = first.normalized();
  Vector3d across = second - axes.col(0).dot(second) * axes.col(0);
  if (!(across.norm() > 1e-6 * second.norm())) across = axes.col(0).unitOrthogonal();
  axes.col(1) = across.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

constexpr std::size_t kMostFrames = 4;

// A symmetric matrix: second moments of points.
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

  // The direction of the largest spread, first, and of the largest across it. The pieces of a
  // surface are flat as a rule, so that the direction of the least spread is told apart best: that
  // of the adjugate's largest, by squaring. Across it the largest has a closed form, and across
  // that the others have, which leaves no trace of what the first was wrong by in their plane.
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

  // The direction of the largest spread among those across `n` (unit).
  Vector3d mostAcross(const Vector3d& n) const {
    const Vector3d u = n.unitOrthogonal(), v = cross(n, u);
    const Vector3d along_u = times(u);
    const double a = u.dot(along_u), b = v.dot(along_u), c = v.dot(times(v));
    // (h + r, b) and (b, r - h) are along the eigenvector of the larger eigenvalue, h half of the
    // difference.
    const double h = 0.5 * (a - c), r = std::sqrt(h * h + b * b);
    if (!(r > 0)) return u;
    return h >= 0 ? Vector3d((h + r) * u + b * v) : Vector3d(b * u + (r - h) * v);
  }

 private:
  Vector3d times(const Vector3d& v) const {
    return {xx_ * v.x() + xy_ * v.y() + xz_ * v.z(), xy_ * v.x() + yy_ * v.y() + yz_ * v.z(),
            xz_ * v.x() + yz_ * v.y() + zz_ * v.z()};
  }
  // Each column of a matrix that is nearly of rank one is along it; that of the largest entry is
  // the least rounded.
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

// Triangles order[begin, end) and a box around them, in columns of `axes`.
struct BoxTree::Piece {
  std::int32_t begin = 0, end = 0;
  Matrix3d axes = Matrix3d::Identity();
  Vector3d center = Vector3d::Zero(), half = Vector3d::Zero();
};

struct BoxTree::Input {
  std::span<const Vector3d> vertices;
  std::span<const Triangle> triangles;
  std::span<const std::int32_t> slot_of;
  double extent = 0;
  std::vector<Vector3d> centroid;  // of a triangle, or of all in its piece
  std::vector<std::int32_t> order;
  // What must not be parted stands together in `order` and has the same number here.
  std::vector<std::int32_t> unit;
  // Coordinates of all corners of the piece that is looked at, filled up to whole blocks.
  std::array<std::vector<double>, 3> in_hand;

  std::int32_t unitAt(std::int32_t at) const { return unit[index(order[index(at)])]; }
  bool isOneUnit(const Piece& piece) const { return unitAt(piece.begin) == unitAt(piece.end - 1); }
  std::int32_t unitsIn(const Piece& piece) const {
    std::int32_t count = 1;
    for (std::int32_t at = piece.begin + 1; at < piece.end; ++at) {
      count += unitAt(at) != unitAt(at - 1) ? 1 : 0;
    }
    return count;
  }
  Vector3d middleOf(std::int32_t t) const {
    const Triangle& c = triangles[index(t)];
    return (vertices[index(c[0])] + vertices[index(c[1])] + vertices[index(c[2])]) / 3;
  }

  /// Corner k of a triangle.
  const Vector3d& corner(std::int32_t at, std::size_t k) const {
    return vertices[index(triangles[index(order[index(at)])][k])];
  }

  /// Corner k of triangle i of the piece in hand.
  Vector3d cornerInHand(std::size_t i, std::size_t k) const {
    const std::size_t at = 3 * i + k;
    return {in_hand[0][at], in_hand[1][at], in_hand[2][at]};
  }

  void takeInHand(const Piece& piece) {
    const std::size_t used = 3 * static_cast<std::size_t>(piece.end - piece.begin),
                      size = (used + kRangeBlock - 1) / kRangeBlock * kRangeBlock;
    for (std::vector<double>& column : in_hand) column.resize(size);
    double *x = in_hand[0].data(), *y = in_hand[1].data(), *z = in_hand[2].data();
    std::size_t i = 0;
    const auto put = [&](const Vector3d& p) {
      x[i] = p.x();
      y[i] = p.y();
      z[i] = p.z();
      ++i;
    };
    for (std::int32_t at = piece.begin; at < piece.end; ++at) {
      for (const std::int32_t v : triangles[index(order[index(at)])]) put(vertices[index(v)]);
    }
    while (i < size) put(corner(piece.end - 1, 2));
  }

  // The smallest of the boxes of all corners along some frames.
  void fitBest(Piece& piece, std::span<const Matrix3d> frames) const {
    std::array<BoxRange, kMostFrames> ranges;
    boxRanges({in_hand[0], in_hand[1], in_hand[2]}, frames, ranges.data());
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const Vector3d half = 0.5 * (ranges[i].high - ranges[i].low);
      const double area = halfArea(half);
      if (!(area < best)) continue;
      best = area;
      piece.axes = frames[i];
      piece.half = half;
      piece.center = frames[i] * (0.5 * (ranges[i].low + ranges[i].high));
    }
  }

  // The smallest box of a few.
  void fit(Piece& piece) {
    takeInHand(piece);
    std::array<Matrix3d, kMostFrames> frames;
    std::size_t count = 0;
    frames[count++].setIdentity();
    if (piece.end - piece.begin == 1) {
      frames[count++] = frameOfTriangle();
    } else {
      addFrames(static_cast<std::size_t>(piece.end - piece.begin), frames, count);
    }
    fitBest(piece, {frames.data(), count});
  }

  // Along an edge that the other corner is above: no rectangle around a triangle is smaller than
  // those, which are of one area; of the least girth.
  Matrix3d frameOfTriangle() const {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    const Vector3d a = cornerInHand(0, 0), b = cornerInHand(0, 1), c = cornerInHand(0, 2);
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

  // Those of the spread of the surface and of the corners, and of the mean normal with the spread
  // across it.
  void addFrames(std::size_t triangle_count, std::array<Matrix3d, kMostFrames>& frames,
                 std::size_t& count) const {
    Vector3d mean = Vector3d::Zero(), corner_mean = Vector3d::Zero(), normal = Vector3d::Zero();
    Spread spread, corner_spread;
    double total = 0;
    const Vector3d origin = cornerInHand(0, 0);
    for (std::size_t i = 0; i < triangle_count; ++i) {
      const Vector3d a = cornerInHand(i, 0) - origin, b = cornerInHand(i, 1) - origin,
                     c = cornerInHand(i, 2) - origin;
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
    const double corner_count = 3 * static_cast<double>(triangle_count);
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

  // Parts a piece along its longest axis, by the mean of the triangles' middles.
  void split(const Piece& piece, bool by_count, Piece& left, Piece& right) {
    int axis = 0;
    piece.half.maxCoeff(&axis);
    const Vector3d along = piece.axes.col(axis);
    const auto first = order.begin() + piece.begin, last = order.begin() + piece.end;
    auto middle = first;
    if (!by_count) {
      double mean = 0;
      for (auto at = first; at != last; ++at) mean += along.dot(centroid[index(*at)]);
      mean /= static_cast<double>(piece.end - piece.begin);
      // Stable, so that the order of triangles depends on nothing but the mesh.
      middle = std::stable_partition(
          first, last, [&](std::int32_t t) { return along.dot(centroid[index(t)]) < mean; });
    }
    if (middle == first || middle == last) {
      std::sort(first, last, [&](std::int32_t l, std::int32_t r) {
        const double cl = along.dot(centroid[index(l)]), cr = along.dot(centroid[index(r)]);
        if (cl != cr) return cl < cr;
        return std::pair(unit[index(l)], l) < std::pair(unit[index(r)], r);
      });
      middle = first;
      for (std::int32_t left_units = unitsIn(piece) / 2; left_units > 0; --left_units) {
        const std::int32_t one = unit[index(*middle)];
        while (unit[index(*middle)] == one) ++middle;
      }
    }
    left.begin = piece.begin;
    left.end = right.begin = static_cast<std::int32_t>(middle - order.begin());
    right.end = piece.end;
    fit(left);
    fit(right);
  }
};

BoxTree::BoxTree(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                 std::span<const std::int32_t> slot_of, double extent,
                 std::span<const std::int32_t> piece_of, int pieces)
    : piece_node_(static_cast<std::size_t>(pieces), -1),
      first_piece_(static_cast<std::int32_t>(triangles.size())) {
  if (!(extent >= kSmallestBoxScale && extent <= kLargestBoxScale)) return;
  Input input{vertices, triangles, slot_of, extent, {}, {}, {}, {}};
  input.centroid.reserve(triangles.size());
  input.unit.reserve(triangles.size());
  std::vector<Vector3d> sum(index(pieces), Vector3d::Zero());
  std::vector<double> count(index(pieces), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    input.centroid.push_back(input.middleOf(static_cast<std::int32_t>(t)));
    input.unit.push_back(piece_of[t] >= 0 ? piece_of[t]
                                          : static_cast<std::int32_t>(index(pieces) + t));
    if (piece_of[t] < 0) continue;
    sum[index(piece_of[t])] += input.centroid[t];
    ++count[index(piece_of[t])];
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (piece_of[t] >= 0) input.centroid[t] = sum[index(piece_of[t])] / count[index(piece_of[t])];
  }
  input.order.resize(triangles.size());
  std::iota(input.order.begin(), input.order.end(), 0);
  std::stable_sort(input.order.begin(), input.order.end(), [&](std::int32_t l, std::int32_t r) {
    return input.unit[index(l)] < input.unit[index(r)];
  });
  nodes_.reserve(2 + triangles.size() / 6);
  nodes_.emplace_back();
  Piece whole;
  whole.end = static_cast<std::int32_t>(triangles.size());
  input.fit(whole);
  setLane(0, 0, whole, input);
  const std::int32_t child = childFor(input, whole, 0, false);
  nodes_[0].child[0] = child;
  nodes_[0].count = 1;
  nodes_.shrink_to_fit();
}

// What stands below a box.
std::int32_t BoxTree::childFor(Input& input, const Piece& piece, int depth, bool in_piece) {
  if (piece.end - piece.begin == 1) return ~input.slot_of[index(input.order[index(piece.begin)])];
  if (in_piece || !input.isOneUnit(piece)) return build(input, piece, depth, in_piece);
  const std::int32_t number = input.unitAt(piece.begin);
  // From here on its triangles go their own ways.
  for (std::int32_t at = piece.begin; at < piece.end; ++at) {
    const std::int32_t t = input.order[index(at)];
    input.unit[index(t)] = static_cast<std::int32_t>(piece_node_.size()) + t;
    input.centroid[index(t)] = input.middleOf(t);
  }
  const std::int32_t node = build(input, piece, depth, true);
  piece_node_[index(number)] = node;
  return ~(first_piece_ + number);
}

std::int32_t BoxTree::build(Input& input, const Piece& whole, int depth, bool in_piece) {
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  const bool by_count = depth >= (in_piece || piece_node_.empty() ? kFreeDepth : kFreePieceDepth);
  std::vector<Piece> pieces{whole};
  while (pieces.size() < BoxNode::kWidth) {
    std::size_t largest = pieces.size();
    double most = -1;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double size =
          by_count ? static_cast<double>(input.unitsIn(pieces[i])) : halfArea(pieces[i].half);
      if (input.isOneUnit(pieces[i]) || !(size > most)) continue;
      most = size;
      largest = i;
    }
    if (largest == pieces.size()) break;
    Piece left, right;
    input.split(pieces[largest], by_count, left, right);
    pieces[largest] = left;
    pieces.insert(pieces.begin() + static_cast<std::ptrdiff_t>(largest) + 1, right);
  }
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    setLane(id, static_cast<int>(i), pieces[i], input);
    const std::int32_t child = childFor(input, pieces[i], depth + 1, in_piece);
    nodes_[index(id)].child[i] = child;
  }
  nodes_[index(id)].count = static_cast<std::int32_t>(pieces.size());
  return id;
}

// The box in single precision: its planes are those of the rounded axes and centre, moved out to
// hold every corner.
void BoxTree::setLane(std::int32_t id, int lane, const Piece& piece, const Input& input) {
  BoxNode& node = nodes_[index(id)];
  Vector3d center, half = Vector3d::Zero();
  Matrix3d axes;
  for (int k = 0; k < 3; ++k) {
    node.center[k][lane] = static_cast<float>(piece.center[k]);
    center[k] = static_cast<double>(node.center[k][lane]);
    for (int i = 0; i < 3; ++i) {
      node.axis[k][i][lane] = static_cast<float>(piece.axes(i, k));
      axes(i, k) = static_cast<double>(node.axis[k][i][lane]);
    }
  }
  for (std::int32_t at = piece.begin; at < piece.end; ++at) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d p = axes.transpose() * (input.corner(at, k) - center);
      half = half.cwiseMax(p.cwiseAbs());
    }
  }
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    node.half[k][lane] = floatAbove(half[k] + kRelativeRounding * input.extent);
    squared += half[k] * half[k];
  }
  node.radius[lane] = static_cast<float>(std::sqrt(squared));
}

OrientedBox BoxNode::box(int lane) const {
  OrientedBox box;
  for (int k = 0; k < 3; ++k) {
    box.center[k] = center[k][lane];
    box.half[k] = half[k][lane];
    for (int i = 0; i < 3; ++i) box.axis[k][i] = axis[k][i][lane];
  }
  return box;
}

}  // namespace leeway::collision
