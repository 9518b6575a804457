#include "collision/box_tree.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "leeway/collision/tolerances.h"

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

// The least float that is not below x.
float roundedUp(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

// A right-handed frame with its first axis along `first` and its second near to `second`.
Matrix3d frame(const Vector3d& first, const Vector3d& second) {
  Matrix3d axes = Matrix3d::Identity();
  if (!(first.norm() > 0)) return axes;
  axes.col(0) = first.normalized();
  Vector3d across = second - axes.col(0).dot(second) * axes.col(0);
  if (!(across.norm() > 1e-6 * second.norm())) across = axes.col(0).unitOrthogonal();
  axes.col(1) = across.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

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

  const Vector3d& corner(std::int32_t at, std::size_t k) const {
    return vertices[index(triangles[index(order[index(at)])][k])];
  }

  Vector3d range(const Piece& piece, const Matrix3d& axes, Vector3d& middle) const {
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::int32_t at = piece.begin; at < piece.end; ++at) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d p = axes.transpose() * corner(at, k);
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
    middle = 0.5 * (low + high);
    return 0.5 * (high - low);
  }

  void consider(Piece& piece, const Matrix3d& axes, double& best) const {
    Vector3d middle;
    const Vector3d half = range(piece, axes, middle);
    const double area = halfArea(half);
    if (!(area < best)) return;
    best = area;
    piece.axes = axes;
    piece.half = half;
    piece.center = axes * middle;
  }

  // The smallest box of a few.
  void fit(Piece& piece) const {
    double best = std::numeric_limits<double>::infinity();
    consider(piece, Matrix3d::Identity(), best);
    if (piece.end - piece.begin == 1) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d edge = corner(piece.begin, (k + 1) % 3) - corner(piece.begin, k);
        consider(piece, frame(edge, corner(piece.begin, (k + 2) % 3) - corner(piece.begin, k)),
                 best);
      }
      return;
    }
    // Spread of the surface and of the corners, and the mean normal with the spread across it.
    Vector3d mean = Vector3d::Zero(), corner_mean = Vector3d::Zero(), normal = Vector3d::Zero();
    Matrix3d spread = Matrix3d::Zero(), corner_spread = Matrix3d::Zero();
    double total = 0, count = 0;
    const Vector3d origin = corner(piece.begin, 0);
    for (std::int32_t at = piece.begin; at < piece.end; ++at) {
      const Vector3d a = corner(at, 0) - origin, b = corner(at, 1) - origin,
                     c = corner(at, 2) - origin;
      const Vector3d twice_area = (b - a).cross(c - a), middle = (a + b + c) / 3;
      const double area = 0.5 * twice_area.norm();
      normal += twice_area;
      mean += area * middle;
      total += area;
      const Matrix3d corners = a * a.transpose() + b * b.transpose() + c * c.transpose();
      spread += area / 12 * (9 * middle * middle.transpose() + corners);
      corner_spread += corners;
      corner_mean += a + b + c;
      count += 3;
    }
    corner_mean /= count;
    corner_spread = (corner_spread / count - corner_mean * corner_mean.transpose()).eval();
    const auto principal = [](const Matrix3d& m) {
      const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(m);
      return frame(solver.eigenvectors().col(2), solver.eigenvectors().col(1));
    };
    consider(piece, principal(corner_spread), best);
    if (!(total > 0)) return;
    mean /= total;
    spread = (spread / total - mean * mean.transpose()).eval();
    consider(piece, principal(spread), best);
    if (!(normal.norm() > 0)) return;
    normal.normalize();
    const Matrix3d across = Matrix3d::Identity() - normal * normal.transpose();
    const Matrix3d flat = across * spread * across;
    consider(piece, frame(normal, principal(flat).col(0)), best);
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
  Input input{vertices, triangles, slot_of, extent, {}, {}, {}};
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
    node.half[k][lane] = roundedUp(half[k] + kRelativeRounding * input.extent);
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
