#include "collision/distance/plane_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/convex/gjk/support.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

/// The reach of a body along a direction of its own frame.
double reachAlong(const ConvexView& view, const Eigen::Vector3d& direction) {
  int hint = 0;
  return direction.dot(farthest(view, direction, hint)) + view.radius + view.excess;
}

ConvexView hullOf(const Shape& shape) {
  return shape.isConvex() ? viewOf(shape) : shape.mesh()->tree().hullView();
}

/// Accuracy of the distance along a direction, as a share. It need not be high, because planes
/// tolerate a small turn.
constexpr double kDirectionShare = 1e-3;

bool hasHull(const Shape& shape) { return shape.type() != ShapeType::kDeformable; }

ThreeGaps gapsOf(const ConvexView& a, const ThreePoses& X_BA, const ConvexView& b,
                 const Eigen::Vector3d& direction_B) {
  const bool is_space = b.core == Core::kHalfSpace;
  const Eigen::Vector3d up = is_space ? Eigen::Vector3d::UnitZ() : direction_B;
  const double reach_b = is_space ? 0 : reachAlong(b, up);
  const double sizes = a.extent + a.radius + (is_space ? 0 : b.extent + b.radius);
  ThreeGaps gaps;
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    const Pose& X = X_BA[k];
    const double gap = up.dot(X.translation) - reachAlong(a, -(X.rotation.transpose() * up)) -
                       reach_b - kPlaneGapRounding * (sizes + X.translation.lpNorm<1>());
    gaps[k] = std::isnan(gap) ? -kInfinity : gap;
  }
  return gaps;
}

bool areEnough(const ThreeGaps& gaps, const ThreeGaps& wanted) {
  return gaps[0] >= wanted[0] && gaps[1] >= wanted[1] && gaps[2] >= wanted[2];
}

void takeLeast(ThreeGaps& least, const ThreeGaps& gaps) {
  for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], gaps[k]);
}

/// One descent through a mesh's hierarchy.
class SurfaceGaps {
 public:
  /// `other`: the hull of the other body; the mesh is A, or B.
  SurfaceGaps(const MeshTree& tree, bool is_a, const ThreePoses& X_BA, const ConvexView& other,
              const ThreeGaps& wanted, int& nodes, Scratch& scratch)
      : tree_(tree),
        is_a_(is_a),
        X_BA_(X_BA),
        other_(other),
        wanted_(wanted),
        left_(nodes),
        scratch_(scratch) {
    request_.depth = false;
    request_.tolerance = kDirectionShare * std::abs(wanted[1]);
  }

  ThreeGaps run() {
    descend(0, Eigen::Vector3d::Zero());
    return least_;
  }

 private:
  /// Gaps of a part along the direction of the enclosing part if these are enough, otherwise along
  /// its own direction.
  ThreeGaps gapsOfPart(const ConvexView& part, Eigen::Vector3d& direction) {
    --left_;
    const ConvexView &a = is_a_ ? part : other_, &b = is_a_ ? other_ : part;
    if (direction.squaredNorm() > 0.5) {
      const ThreeGaps gaps = gapsOf(a, X_BA_, b, direction);
      if (areEnough(gaps, wanted_)) return gaps;
    }
    const DistanceResult found = convexDistance(a, X_BA_[1], b, request_, scratch_, nullptr);
    if (!(found.distance.lower > 0)) return {-kInfinity, -kInfinity, -kInfinity};
    direction = -found.normal;
    return gapsOf(a, X_BA_, b, direction);
  }

  void descend(int number, Eigen::Vector3d direction) {
    const MeshNode& node = tree_.node(number);
    const ThreeGaps gaps = gapsOfPart(tree_.nodeView(node), direction);
    if (areEnough(gaps, wanted_) || left_ <= 0) return takeLeast(least_, gaps);
    if (node.right >= 0) {
      descend(number + 1, direction);
      descend(node.right, direction);
      return;
    }
    for (std::int32_t slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
      Eigen::Vector3d own = direction;
      takeLeast(least_, gapsOfPart(tree_.triangleView(slot), own));
    }
  }

  const MeshTree& tree_;
  bool is_a_;
  const ThreePoses& X_BA_;
  const ConvexView& other_;
  const ThreeGaps& wanted_;
  int& left_;
  Scratch& scratch_;
  DistanceRequest request_;
  ThreeGaps least_{kInfinity, kInfinity, kInfinity};
};

}  // namespace

ThreeGaps planeGaps(const Shape& a, const ThreePoses& X_BA, const Shape& b,
                    const Eigen::Vector3d& direction_B) {
  if (a.type() == ShapeType::kHalfSpace || !hasHull(a) || !hasHull(b))
    return {-kInfinity, -kInfinity, -kInfinity};
  return gapsOf(hullOf(a), X_BA, hullOf(b), direction_B);
}

ThreeGaps surfaceGaps(const Shape& a, const ThreePoses& X_BA, const Shape& b,
                      const ThreeGaps& wanted, int& nodes, Scratch& scratch) {
  const bool is_mesh_a = a.type() == ShapeType::kMesh, is_mesh_b = b.type() == ShapeType::kMesh;
  if ((!is_mesh_a && !is_mesh_b) || !hasHull(a) || !hasHull(b) || a.type() == ShapeType::kHalfSpace)
    return {-kInfinity, -kInfinity, -kInfinity};
  const bool is_a = is_mesh_a && !(is_mesh_b && b.mesh()->hullExcess() > a.mesh()->hullExcess());
  const ConvexView other = hullOf(is_a ? b : a);
  return SurfaceGaps((is_a ? a : b).mesh()->tree(), is_a, X_BA, other, wanted, nodes, scratch)
      .run();
}

}  // namespace leeway::collision
