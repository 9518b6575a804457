// Planes between pairs of a LaneSweep, by distance queries in double precision.

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/convex/gjk/support.h"
#include "collision/lanes/lane_sweep_impl.h"

namespace leeway::collision {
namespace {

/// The frame in the middle of a lane's interval.
Pose poseOf(const LaneFrame& frame, int lane) {
  Pose X_WF;
  for (int i = 0; i < 9; ++i)
    X_WF.rotation.data()[i] = static_cast<double>(frame.rotation[i].at[lane]);
  for (int i = 0; i < 3; ++i) X_WF.translation[i] = static_cast<double>(frame.origin[i].at[lane]);
  return X_WF;
}

}  // namespace

LaneSweep::Contact LaneSweepKernel::noteContact(std::int32_t pair, std::int32_t point,
                                                std::uint32_t lanes) const {
  // Moves the contact to the front; the others move back.
  Scratch::PastContact previous{pair, point};
  for (Scratch::PastContact& contact : scratch.contacts) {
    std::swap(contact, previous);
    if (previous.pair == pair || previous.pair < 0) break;
  }
  return {pair, std::countr_zero(lanes)};
}

bool LaneSweepKernel::findPlane(const Sweep::Pair& pair, int lane, bool closely,
                                Scratch::Plane& plane, PairCache* cache) const {
  const Sweep::LanePiece& a = sweep.pieces[at(pair.a)];
  const Pose X_WA = poseOf(frames[a.frame], lane);
  const Sweep::Obstacle* o = pair.pieces ? nullptr : &obstacle(pair);
  const Sweep::Exact* exact = o != nullptr ? &o->exact_shape : nullptr;
  const Pose X_WB =
      o != nullptr ? exact->X_WG : poseOf(frames[sweep.pieces[at(pair.b)].frame], lane);
  const auto viewOfPiece = [closely](const Sweep::LanePiece& piece) -> const ConvexView& {
    return closely ? piece.fine_view : piece.view;
  };
  const ConvexView& b = o != nullptr ? exact->view : viewOfPiece(sweep.pieces[at(pair.b)]);
  const Pose X_BA = X_WB.inverse() * X_WA;
  DistanceRequest request;
  request.depth = false;
  request.tolerance = closely ? kLanePlaneTolerance / 8 : kLanePlaneTolerance;
  scratch.work.add(kPlaneSearchWork);
  const DistanceResult r =
      convexDistance(viewOfPiece(a), X_BA, b, request, scratch.distance, cache);
  if (!(r.distance.upper > 0) || !r.normal.allFinite()) return false;
  // The offset is computed with the rounded normal.
  Eigen::Vector3d n = -r.normal;
  if (o != nullptr) n = X_WB.rotation * n;
  for (int k = 0; k < 3; ++k) {
    n[k] = roundedToSingle(n[k]);
    plane.normal[k] = static_cast<float>(n[k]);
  }
  if (o != nullptr) {
    placePlane(*o, plane);
  } else {
    const Sweep::LanePiece& piece_b = sweep.pieces[at(pair.b)];
    int hint = 0;
    plane.offset = floatAbove(n.dot(farthest(piece_b.fine_view, n, hint)) +
                              static_cast<double>(piece_b.fine.radius) * kLanePlaneOutwards);
  }
  return plane.known = std::isfinite(plane.offset);
}

void LaneSweepKernel::placePlane(const Sweep::Obstacle& o, Scratch::Plane& plane) const {
  const Eigen::Vector3d n(static_cast<double>(plane.normal[0]),
                          static_cast<double>(plane.normal[1]),
                          static_cast<double>(plane.normal[2]));
  const Pose& X_WG = o.exact_shape.X_WG;
  const ConvexView& view = o.exact_shape.view;
  const Eigen::Vector3d n_B = X_WG.rotation.transpose() * n;
  int hint = 0;
  plane.offset = floatAbove(n.dot(X_WG.translation) + n_B.dot(farthest(view, n_B, hint)) +
                            (view.radius + view.excess) * kLanePlaneOutwards);
}

void LaneSweepKernel::remember(const Sweep::Pair& pair, const OwnPlanes& planes, int lane,
                               Scratch::Plane& plane) const {
  const Sweep::Obstacle& o = obstacle(pair);
  if (!o.has_view) return;
  for (int k = 0; k < 3; ++k) plane.normal[k] = planes.normal[k].at[lane];
  placePlane(o, plane);
  plane.known = std::isfinite(plane.offset);
}

}  // namespace leeway::collision
