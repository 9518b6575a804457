#include <cmath>

#include "collision/convex/gjk/swept_gjk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/convex/gjk/swept_gjk_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/base/dispatch.h"
#include "collision/base/tolerances.h"
#include "collision/convex/gjk/vertex_cores-inl.h"
#include "collision/convex/gjk/vertex_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

/// A core's points as columns, padded to a multiple of eight with copies of the first.
struct PointColumns {
  int length = 0;
  alignas(64) double x[kSweptLanes], y[kSweptLanes], z[kSweptLanes];

  HWY_INLINE explicit PointColumns(const ConvexView& view) {
    if (view.core != Core::kPoints || view.count > kSweptLanes) return;
    length = (view.count + 7) / 8 * 8;
    for (int i = 0; i < length; ++i) {
      const Vector& p = view.points[i < view.count ? i : 0];
      x[i] = p.x();
      y[i] = p.y();
      z[i] = p.z();
    }
  }
};

/// The difference of the hull of a core's two placements and another core. A's indices: columns()
/// of the first placement, followed by those of the second.
class SweptCores {
 public:
  using Point = Triple;
  static constexpr double kTilt = 0;  // (most sweeps have a threshold)

  HWY_INLINE explicit SweptCores(const Difference<true>& difference)
      : b_(difference.viewB()), columns_b_(b_) {
    const PointColumns a(difference.viewA());
    length_ = a.length;
    place(a, difference.pose(), 0);
    place(a, difference.endPose(), length_);
  }

  HWY_INLINE Triple support(const Triple& n, VertexIndices& indices) const {
    indices.a = scanColumns<2 * kSweptLanes>(x_, y_, z_, 2 * length_, n.x, n.y, n.z);
    if (columns_b_.length == 0) return farthestCorner(b_, -n, indices.b) - pointOfA(indices);
    indices.b = scanColumns<kSweptLanes>(columns_b_.x, columns_b_.y, columns_b_.z,
                                         columns_b_.length, -n.x, -n.y, -n.z);
    return Triple{columns_b_.x[indices.b], columns_b_.y[indices.b], columns_b_.z[indices.b]} -
           pointOfA(indices);
  }
  HWY_INLINE Triple pointOfA(const VertexIndices& indices) const {
    return {x_[indices.a], y_[indices.a], z_[indices.a]};
  }
  HWY_INLINE Points<4> members(const VertexIndices (&indices)[3]) const {
    const auto member = [&](int i)
                            HWY_ATTR { return corner(b_, indices[i].b) - pointOfA(indices[i]); };
    return sideBySide(member(0), member(1), member(2));
  }
  HWY_INLINE int columns() const { return length_; }

 private:
  HWY_INLINE void place(const PointColumns& a, const Pose& X_BA, int to) {
    const Widest d;
    const Eigen::Matrix3d& R = X_BA.rotation;
    for (int i = 0; i < a.length; i += static_cast<int>(hn::MaxLanes(Widest()))) {
      const Same x = hn::Load(d, a.x + i), y = hn::Load(d, a.y + i), z = hn::Load(d, a.z + i);
      const auto row = [&](int r) HWY_ATTR {
        return hn::Add(
            hn::Add(hn::Add(hn::Mul(hn::Set(d, R(r, 0)), x), hn::Mul(hn::Set(d, R(r, 1)), y)),
                    hn::Mul(hn::Set(d, R(r, 2)), z)),
            hn::Set(d, X_BA.translation[r]));
      };
      hn::Store(row(0), d, x_ + to + i);
      hn::Store(row(1), d, y_ + to + i);
      hn::Store(row(2), d, z_ + to + i);
    }
  }

  const ConvexView& b_;
  const PointColumns columns_b_;
  int length_ = 0;
  alignas(64) double x_[2 * kSweptLanes], y_[2 * kSweptLanes], z_[2 * kSweptLanes];
};

}  // namespace

GjkEnd sweptSteps(Difference<true>& difference, const Vector& direction, Progress& progress,
                  Simplex& simplex) {
  const CoreQuery& query = progress.query();
  const SweptCores cores(difference);
  // Ends when the swept hull, grown, is not above the threshold, because its lower end can no
  // longer rise above it.
  Search<SweptCores> search(cores, query.request, query.lower_offset, query.lower_offset,
                            progress.iterations);
  const GjkEnd end =
      search.run(tripleOf(direction), nullptr, {difference.hintA(), difference.hintB()});
  Carriers found;
  offerPlane(search, end, progress, found);
  const int count = difference.viewA().count;
  for (int i = 0; i < found.count; ++i) {
    const Triple &here_w = found.w[i], here_a = cores.pointOfA(found.indices[i]);
    SupportPoint& s = simplex.points[simplex.slot[i]];
    s.w = Vector(here_w.x, here_w.y, here_w.z);
    s.a = Vector(here_a.x, here_a.y, here_a.z);
    s.placement = found.indices[i].a >= cores.columns() ? 1 : 0;
    const int index = found.indices[i].a - s.placement * cores.columns();
    s.index_a = index < count ? index : 0;
    s.index_b = found.indices[i].b;
  }
  simplex.count = found.count;
  if (found.count > 0) difference.setHints(simplex.point(0).index_a, simplex.point(0).index_b);
  return end;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(sweptSteps);

bool isForSweptLanes(const Difference<true>& difference) {
  const ConvexView& a = difference.viewA();
  return a.core == Core::kPoints && a.count <= kSweptLanes && difference.countsVertices();
}

GjkEnd runSweptVertexGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
                         Simplex& simplex) {
  if (progress.iterations >= progress.query().request.iteration_limit) return GjkEnd::kLimit;
  const GjkEnd end = LEEWAY_DISPATCH(sweptSteps)(difference, direction, progress, simplex);
  if (end != GjkEnd::kInside && simplex.count > 0) reduceAll(simplex, simplex.count);
  return end;
}

}  // namespace leeway::collision
#endif
