// The difference of two cores that index their vertices, and its support in vector code. Included
// once a target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_VERTEX_CORES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_VERTEX_CORES_INL_H
#undef LEEWAY_COLLISION_VERTEX_CORES_INL_H
#else
#define LEEWAY_COLLISION_VERTEX_CORES_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstdint>

#include "collision/convex/gjk/support.h"
#include "collision/convex/gjk/vertex_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

/// A point of a kPoints core, from the copy of its vertices that support functions have just read.
HWY_INLINE Triple point(const ConvexView& view, int index) {
  return view.support != nullptr ? tripleOf(view.support->corners()[index])
                                 : tripleOf(view.points[index]);
}
/// The vertex of a core by its index, which must be valid.
HWY_INLINE Triple corner(const ConvexView& view, int index) {
  const double x = view.size.x(), y = view.size.y(), z = view.size.z();
  switch (view.core) {
    case Core::kBox:
      return {(index & 1) != 0 ? x : -x, (index & 2) != 0 ? y : -y, (index & 4) != 0 ? z : -z};
    case Core::kSegment:
      return {0, 0, index == 1 ? z : -z};
    case Core::kPoints:
      return point(view, index);
    default:
      return {0, 0, 0};
  }
}

/// farthest() for a direction of any length, of cores with vertices.
HWY_INLINE Triple farthestCorner(const ConvexView& view, const Triple& d, std::int32_t& index) {
  switch (view.core) {
    case Core::kBox: {
      index =
          (std::signbit(d.x) ? 0 : 1) | (std::signbit(d.y) ? 0 : 2) | (std::signbit(d.z) ? 0 : 4);
      return {std::copysign(view.size.x(), d.x), std::copysign(view.size.y(), d.y),
              std::copysign(view.size.z(), d.z)};
    }
    case Core::kSegment:
      index = d.z >= 0 ? 1 : 0;
      return {0, 0, d.z >= 0 ? view.size.z() : -view.size.z()};
    case Core::kPoints: {
      int found = -1;
      if (view.support != nullptr) found = scannedSupport(*view.support, d, index);
      // Climbing needs a unit vector: its tolerance for equal values scales with the length.
      index = found >= 0
                  ? found
                  : farthestPoint(view, Vector(d.x, d.y, d.z) / std::sqrt(squared(d)), index);
      return point(view, index);
    }
    default:
      index = 0;
      return {0, 0, 0};
  }
}

/// The vertices of a small hull, placed at a pose once, so that neither directions nor vertices are
/// rotated for each support.
class PlacedColumns {
 public:
  /// Places them if their number is within the limit.
  HWY_INLINE void place(const HullSupport& support, const Eigen::Matrix3d& R, const Triple& t) {
    if (support.length() == 0 || support.length() > kPlacedUpTo) return;
    length_ = support.length();
    for (int i = 0; i < length_; i += static_cast<int>(hn::MaxLanes(Widest()))) {
      placeColumns(support, i, R, t, 1, x_ + i, y_ + i, z_ + i);
    }
  }
  HWY_INLINE bool empty() const { return length_ == 0; }
  HWY_INLINE Triple farthest(const Triple& n, std::int32_t& index) const {
    index = scanColumns<kPlacedUpTo>(x_, y_, z_, length_, n.x, n.y, n.z);
    return {x_[index], y_[index], z_[index]};
  }

 private:
  static constexpr int kPlacedUpTo = 32;
  int length_ = 0;
  alignas(64) double x_[kPlacedUpTo], y_[kPlacedUpTo], z_[kPlacedUpTo];
};

/// The difference of two cores with vertices. A's vertices are placed in B's frame if they are few
/// and the search will be long.
class PlacedCores {
 public:
  using Point = Triple;
  static constexpr double kTilt = 0.4, kSmallTilt = 0.2;  // the best of a few values each
  static constexpr double reach = std::numeric_limits<double>::infinity();
  HWY_INLINE PlacedCores(const Difference<false>& difference, bool place)
      : a_(difference.viewA()),
        b_(difference.viewB()),
        R_(difference.pose().rotation),
        t_(tripleOf(difference.pose().translation)) {
    if (place && a_.core == Core::kPoints && a_.support != nullptr) {
      vertices_a_.place(*a_.support, R_, t_);
    }
  }

  HWY_INLINE Triple support(const Triple& n, VertexIndices& indices) const {
    const Triple b = farthestCorner(b_, -n, indices.b);
    if (!vertices_a_.empty()) return b - vertices_a_.farthest(n, indices.a);
    return b - placed(farthestCorner(a_, rotatedBack(R_, n), indices.a));
  }
  template <int n>
  HWY_INLINE Points<n> fan(const Ring<n>& ring, const VertexIndices& hints,
                           Lanes<n>& indices) const {
    const Points<n> directions = directionsOf(ring);
    alignas(64) double x[std::size_t{n}], y[std::size_t{n}], z[std::size_t{n}],
        both[std::size_t{n}];
    store(directions.x, x);
    store(directions.y, y);
    store(directions.z, z);
    for (int i = 0; i < n; ++i) {
      VertexIndices found = hints;
      const Triple w = support({x[i], y[i], z[i]}, found);
      x[i] = w.x;
      y[i] = w.y;
      z[i] = w.z;
      both[i] = inLane(found);
    }
    indices = load<n>(both);
    return {load<n>(x), load<n>(y), load<n>(z)};
  }
  HWY_INLINE bool supportIsExpensive() const { return haveTables(a_, b_); }
  /// A's part of a member.
  HWY_INLINE Triple pointOfA(const VertexIndices& indices) const {
    return placed(corner(a_, indices.a));
  }
  HWY_INLINE Points<4> members(const VertexIndices (&indices)[3]) const {
    const auto member = [&](int i)
                            HWY_ATTR { return corner(b_, indices[i].b) - pointOfA(indices[i]); };
    return sideBySide(member(0), member(1), member(2));
  }

 private:
  HWY_INLINE Triple placed(const Triple& a) const { return rotated(R_, a) + t_; }

  const ConvexView &a_, &b_;
  const Eigen::Matrix3d& R_;
  const Triple t_;
  PlacedColumns vertices_a_;
};

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
