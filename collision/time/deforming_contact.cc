// The first contact of a deforming mesh and a moving body.
//
// Vertices move on straight lines, so at any t a set of them is inside the blend of its boxes at 0
// and 1. Time is divided into slabs, with a box of the body for each. The first slab in which a
// node's box may intersect the body's box is the earliest time at which the node matters.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/convex/gjk/support.h"
#include "collision/deform/snapshot.h"
#include "collision/time/contact_sample.h"
#include "collision/time/relative_motion.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {
namespace {

constexpr int kSlabs = 16;

/// A moving box: at t, its contents are inside the blend of its two states.
struct MovingBox {
  Vector low0 = Vector::Constant(kInfinity), high0 = Vector::Constant(-kInfinity);
  Vector low1 = low0, high1 = high0;

  void add(const Vector& from, const Vector& to) {
    low0 = low0.cwiseMin(from), high0 = high0.cwiseMax(from);
    low1 = low1.cwiseMin(to), high1 = high1.cwiseMax(to);
  }
};

/// Boxes around the body (for a half-space, its plane's highest offset) for each slab of [0, end].
class Slabs {
 public:
  /// `size`: largest distance of a vertex from the origin [m].
  Slabs(const Shape& b, const RigidMotion& motion, double end, double margin, double size)
      : end_(end) {
    const ConvexView view = viewOf(b);
    const FrameMotionBound bound = motion.bound(0, end);
    plane_ = b.type() == ShapeType::kHalfSpace;
    bounded_ = !plane_ || bound.angular_speed == 0;
    if (!bounded_) return;
    const double step = end / kSlabs;
    const double departure = relativePose(Pose{}, motion.pose(0)).slack;
    std::array<Vector, kSlabs + 1> low, high;
    double slack = 0;
    for (int k = 0; k <= kSlabs; ++k) {
      const Pose X = motion.pose(timeOf(k));
      const double reach = std::min(b.extent(), X.translation.norm() + size);
      slack = std::max(
          slack, motion.rounding(reach) + (departure + kMotionRounding) *
                                              (X.translation.norm() + reach + view.radius + size));
      if (plane_) {
        up_ = X.rotation.col(2);
        high[at(k)].x() = up_.dot(X.translation);
        continue;
      }
      int hint = 0;
      for (int i = 0; i < 3; ++i) {
        const Vector along = X.rotation.row(i).transpose();
        const double out = view.radius + view.excess;
        high[at(k)][i] = X.translation[i] + along.dot(farthest(view, along, hint)) + out;
        low[at(k)][i] = X.translation[i] + along.dot(farthest(view, -along, hint)) - out;
      }
    }
    // An upper bound on how far points leave their chords over a slab.
    slack += pointAcceleration(b, bound) * step * step / 8 * kGrowthOutwards;
    for (int k = 0; k < kSlabs; ++k) {
      low_[at(k)] = (low[at(k)].cwiseMin(low[at(k + 1)])).array() - slack - margin;
      high_[at(k)] = (high[at(k)].cwiseMax(high[at(k + 1)])).array() + slack + margin;
    }
  }

  double timeOf(int slab) const { return end_ * slab / kSlabs; }

  /// The first slab in which the contents of the box may be within the margin of the body; kSlabs
  /// if there is none.
  int first(const MovingBox& box) const {
    if (!bounded_) return 0;
    for (int k = 0; k < kSlabs; ++k)
      if (!isApart(box, k)) return k;
    return kSlabs;
  }

 private:
  bool isApart(const MovingBox& box, int k) const {
    const double t0 = static_cast<double>(k) / kSlabs * end_;
    const double t1 = static_cast<double>(k + 1) / kSlabs * end_;
    const Vector low = blend(box.low0, box.low1, t0).cwiseMin(blend(box.low0, box.low1, t1));
    const Vector high = blend(box.high0, box.high1, t0).cwiseMax(blend(box.high0, box.high1, t1));
    if (plane_) {
      // The box's lowest corner relative to the plane.
      const Vector lowest = (up_.array() > 0).select(low, high);
      return up_.dot(lowest) > high_[at(k)].x();
    }
    return (low.array() > high_[at(k)].array()).any() || (high.array() < low_[at(k)].array()).any();
  }

  static Vector blend(const Vector& a, const Vector& b, double t) { return (1 - t) * a + t * b; }

  double end_;
  bool plane_ = false;    // the body is a half-space
  bool bounded_ = false;  // boxes are available: not for a half-space that turns
  Vector up_ = Vector::UnitZ();
  std::array<Vector, kSlabs> low_, high_;  // grown by the margin and all rounding
};

/// Follows the triangles of the mesh that may touch the body, earliest first.
class DeformFollower {
 public:
  DeformFollower(const DeformableSnapshotImpl& from, const DeformableSnapshotImpl& to,
                 const Shape& b, const RigidMotion& motion, const ContactRequest& request,
                 Scratch& scratch, int queries)
      : from_(from),
        to_(to),
        b_(b),
        motion_(motion),
        request_(request),
        scratch_(scratch),
        slabs_(b, motion, request.end, request.margin, sizeOf(from, to)) {
    first_.status = ContactStatus::kFree;
    first_.time = {kInfinity, kInfinity};
    first_.queries = queries;
  }

  ContactResult run() {
    if (from_.demand == Demand::kNoTree)
      for (int i = 0; i < from_.mesh->triangleCount(); ++i) follow(i);
    else
      descend();
    // An undecided triangle leaves the time of contact open from there on.
    if (open_.time.lower < first_.time.lower) {
      const int queries = first_.queries;
      if (first_.status != ContactStatus::kContact) first_ = open_;
      first_.time.lower = open_.time.lower;
      first_.queries = queries;
    }
    return first_;
  }

 private:
  struct Item {
    std::int32_t child;
    int slab;
  };

  static double sizeOf(const DeformableSnapshotImpl& from, const DeformableSnapshotImpl& to) {
    return std::max({from.low.norm(), from.high.norm(), to.low.norm(), to.high.norm()});
  }

  /// Later times are irrelevant.
  double limit() const { return first_.time.lower; }

  /// Depth first, the child with the earliest slab first.
  void descend() {
    std::array<Item, DeformTree::kMaxDepth * kWidth> stack;
    std::size_t count = 0;
    stack[count++] = {0, 0};
    const BoxSource source0(from_, scratch_.impl().deform);
    const BoxSource source1(to_, scratch_.impl().deform);
    const bool same_tree = to_.tree == from_.tree && to_.demand != Demand::kNoTree;
    while (count > 0) {
      const Item item = stack[--count];
      if (slabs_.timeOf(item.slab) >= limit()) continue;
      if (DeformTree::isLeaf(item.child)) {
        const DeformTree::Leaf& leaf = from_.tree->leaf(DeformTree::leafOf(item.child));
        for (std::int32_t slot = leaf.slot_begin; slot < leaf.slot_end; ++slot)
          follow(from_.tree->triangleOf(slot));
        continue;
      }
      // Copied, because both snapshots may fill the same memory.
      WideBox room0, room1;
      const WideBox boxes0 = source0.boxes(item.child, room0);
      const WideBox boxes1 = same_tree ? source1.boxes(item.child, room1) : WideBox{};
      const DeformTree::Node& node = from_.tree->node(item.child);
      const std::size_t begin = count;
      for (int column = 0; column < kWidth && node.child[column] != DeformTree::kNone; ++column) {
        MovingBox box;
        for (int i = 0; i < 3; ++i) {
          box.low0[i] = static_cast<double>(boxes0.low[i][column]);
          box.high0[i] = static_cast<double>(boxes0.high[i][column]);
          box.low1[i] = static_cast<double>(boxes1.low[i][column]);
          box.high1[i] = static_cast<double>(boxes1.high[i][column]);
        }
        if (!same_tree) laterBox(item.child, column, box);
        const int slab = slabs_.first(box);
        if (slab == kSlabs || slabs_.timeOf(slab) >= limit()) continue;
        // Keeps the earliest on top of the stack.
        std::size_t place = count++;
        for (; place > begin && stack[place - 1].slab < slab; --place)
          stack[place] = stack[place - 1];
        stack[place] = {node.child[column], slab};
      }
    }
  }

  /// Computes the box in the later snapshot from its vertices, because its hierarchy is a different
  /// one.
  void laterBox(std::int32_t node, int column, MovingBox& box) const {
    MovingBox later;
    for (const std::int32_t v : from_.tree->vertices(node, column)) {
      const Vector& p = to_.vertices[static_cast<std::size_t>(v)];
      later.add(p, p);
    }
    box.low1 = later.low1, box.high1 = later.high1;
  }

  void follow(int triangle) {
    MovingTriangle moving;
    MovingBox box;
    const auto& corners = from_.mesh->triangles()[static_cast<std::size_t>(triangle)];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(corners[i]);
      moving.from[i] = from_.vertices[v];
      moving.to[i] = to_.vertices[v];
      box.add(moving.from[i], moving.to[i]);
    }
    const int slab = slabs_.first(box);
    if (slab == kSlabs || slabs_.timeOf(slab) >= limit()) return;
    ContactRequest one = request_;
    one.end = std::min(one.end, first_.time.upper);
    one.query_limit = std::max(0, request_.query_limit - first_.queries);
    ContactResult result = timeOfContact(moving, b_, motion_, one, scratch_);
    result.distance.triangle_a = triangle;
    const int queries = first_.queries + result.queries;
    if (result.status == ContactStatus::kContact) {
      // Followed only to first_.time.upper; the previous contact may still be the earlier one.
      result.time.lower = std::min(first_.time.lower, result.time.lower);
      first_ = result;
    } else if (result.status != ContactStatus::kFree && !(open_.time.lower <= result.time.lower)) {
      open_ = result;
    }
    first_.queries = queries;
  }

  const DeformableSnapshotImpl &from_, &to_;
  const Shape& b_;
  const RigidMotion& motion_;
  const ContactRequest& request_;
  Scratch& scratch_;
  Slabs slabs_;
  ContactResult first_;
  ContactResult open_ = noneOpen();

  static ContactResult noneOpen() {
    ContactResult result;
    result.time = {kInfinity, kInfinity};
    return result;
  }
};

}  // namespace

ContactResult timeOfContact(const std::shared_ptr<const DeformableSnapshot>& from,
                            const std::shared_ptr<const DeformableSnapshot>& to, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch) {
  ContactResult result;
  if (from == nullptr || to == nullptr || &from->mesh() != &to->mesh() || !b.isConvex() ||
      !(request.time_tolerance > 0) || !(request.tolerance > 0) ||
      !(request.end >= 0 && request.end <= 1) || !(request.margin >= 0) ||
      !std::isfinite(request.margin))
    return result;
  // Closed components may contain the body, or the reverse, without a triangle nearby. Without
  // contact, that does not change later, so it is decided at t = 0.
  const Pose X_WB = motion_b.pose(0);
  const double size = std::max(from->low().norm(), from->high().norm());
  const double rounding = motion_b.rounding(std::min(b.extent(), X_WB.translation.norm() + size));
  DistanceRequest start;
  start.tolerance = kDefaultTolerance;
  start.threshold = request.margin + 2 * rounding;
  start.depth = false;
  result.queries = 1;
  result.distance = distance(Shape::deformable(from), Pose{}, b, X_WB, start, scratch);
  if (result.distance.status == DistanceStatus::kInvalid) return result;
  if (!(result.distance.distance.lower - rounding > request.margin)) {
    const bool touches = result.distance.distance.upper + rounding <= request.margin;
    result.status = touches ? ContactStatus::kContact : ContactStatus::kUndecided;
    if (!touches) result.time = {0, kInfinity};
    if (!hasNormal(result.distance)) result.distance.normal.setZero();
    return result;
  }
  const DistanceResult at_start = result.distance;
  result =
      DeformFollower(from->impl(), to->impl(), b, motion_b, request, scratch, result.queries).run();
  if (result.status == ContactStatus::kFree) result.distance = at_start;
  return result;
}

}  // namespace leeway::collision
