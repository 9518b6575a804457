#include "collision/lanes/lane_sweep.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/convex/gjk/support.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

constexpr float kFar = 1e30f;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void setCenter(const Eigen::Vector3d& p, float* center) {
  for (int k = 0; k < 3; ++k) center[k] = static_cast<float>(p[k]);
}

/// What a plane must part two bodies by besides radius, growth and slack, and one that a lane has
/// for itself; see simd/lane_sweep.cc.
float partAbove(double threshold, double rounding) {
  return floatAbove(std::max(threshold, 0.0) + 4 * rounding);
}
float partEachAbove(double threshold, double rounding) {
  return floatAbove(std::max(threshold, 0.0) + 5 * rounding);
}

/// Rounding of the centre and of the double that it was made from is added to the radius.
double centerRounding(const Ball& ball) { return 0x1p-23 * ball.center.lpNorm<1>(); }

}  // namespace

LaneSweep::LaneSweep() : impl_(std::make_unique<Impl>()) {}
LaneSweep::~LaneSweep() = default;
LaneSweep::LaneSweep(LaneSweep&&) noexcept = default;
LaneSweep& LaneSweep::operator=(LaneSweep&&) noexcept = default;

int LaneSweep::addPiece(const Piece& piece) {
  Impl::LanePiece lane{};
  lane.frame = piece.frame;
  lane.motion = piece.motion;
  lane.reach = piece.reach;
  const auto grown = [](const Ball& ball) {
    Impl::LaneBall result{};
    setCenter(ball.center, result.center);
    result.radius = floatAbove(ball.radius + centerRounding(ball));
    return result;
  };
  lane.outer = grown(piece.outer);
  lane.cover = static_cast<int>(impl_->balls.size());
  for (const Ball& ball : piece.cover) impl_->balls.push_back(grown(ball));
  lane.inner = static_cast<int>(impl_->balls.size());
  for (const Ball& ball : piece.inner) {
    Impl::LaneBall result{};
    setCenter(ball.center, result.center);
    result.radius = floatBelow(ball.radius - centerRounding(ball));
    impl_->balls.push_back(result);
  }
  lane.end = static_cast<int>(impl_->balls.size());
  for (const Ball& ball : piece.inner)
    lane.inner_reach = std::max(
        lane.inner_reach, floatAbove((ball.center - piece.outer.center).norm() + ball.radius));
  impl_->addPoints(piece.points, lane);
  lane.parts_begin = static_cast<int>(impl_->parts.size());  // of `parts` until finish()
  for (const CoverPart& p : piece.parts) {
    Impl::LanePiece part{};
    part.frame = lane.frame;
    part.motion = lane.motion;
    part.reach = lane.reach;
    part.outer = grown(p.ball);
    impl_->addPoints(p.points, part);
    impl_->parts.push_back(part);
  }
  lane.parts_end = static_cast<int>(impl_->parts.size());
  impl_->pieces.push_back(lane);
  return static_cast<int>(impl_->pieces.size()) - 1;
}

LaneSweep::Impl::Obstacle LaneSweep::Impl::obstacleOf(const Shape& shape, const Pose& X_WG) {
  Obstacle o;
  Eigen::Vector3d center_G = Eigen::Vector3d::Zero(), half = Eigen::Vector3d::Zero();
  double radius = 0;
  o.exact = true;
  switch (shape.type()) {
    case ShapeType::kSphere:
      radius = shape.radius();
      break;
    case ShapeType::kCapsule:
      half.z() = shape.halfLength();
      radius = shape.radius();
      break;
    case ShapeType::kBox:
      half = shape.halfExtents();
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      o.kind = Kind::kCylinder;
      o.exact = shape.type() == ShapeType::kCylinder;
      half = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kHalfSpace:
      o.kind = Kind::kHalfSpace;
      break;
    case ShapeType::kEllipsoid:
      o.exact = false;
      half = shape.halfExtents();
      break;
    case ShapeType::kConvexHull:
    case ShapeType::kMesh:
    case ShapeType::kDeformable: {
      o.exact = false;
      const AxisBox box = boxOf(shape);
      center_G = box.center;
      half = box.half;
      break;
    }
  }
  const Eigen::Matrix3d rotation_GW = X_WG.rotation.transpose();
  const Eigen::Vector3d center = X_WG * center_G;
  o.aligned = rotation_GW.isIdentity(0);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      o.rotation[3 * row + column] = static_cast<float>(rotation_GW(row, column));
  setCenter(center, o.center);
  // A stand-in may be larger than the shape; an exact one is as near as rounding, which `scale`
  // counts, has it.
  for (int k = 0; k < 3; ++k) o.half[k] = static_cast<float>(half[k]);
  o.radius = static_cast<float>(radius);
  o.scale = center.lpNorm<1>() + half.lpNorm<1>() + radius;
  const Eigen::Vector3d extent =
      rotation_GW.transpose().cwiseAbs() * half + Eigen::Vector3d::Constant(radius);
  o.low = center - extent;
  o.high = center + extent;
  if (o.kind == Kind::kHalfSpace) {
    o.low.setConstant(-static_cast<double>(kFar));
    o.high.setConstant(static_cast<double>(kFar));
  }
  o.shape = shape;
  o.X_WG = X_WG;
  if (shape.isConvex()) {
    o.view = viewOf(shape);
  } else if (shape.type() == ShapeType::kMesh) {
    o.view = shape.mesh()->tree().hullView();
  }
  o.has_view = shape.type() != ShapeType::kDeformable && shape.type() != ShapeType::kHalfSpace;
  return o;
}

/// A part of a mesh: its hull, grown by what stands out of it.
LaneSweep::Impl::Obstacle LaneSweep::Impl::partOf(const CoverPart& part, const Pose& X_WG) {
  const bool fine = !part.points.fine.empty();
  const std::shared_ptr<const ConvexHull> hull =
      ConvexHull::compute(fine ? part.points.fine : part.points.points);
  const double radius =
      (fine ? part.points.fine_radius : part.points.radius) * (1 + kRelativeRounding) +
      hull->excess();
  Obstacle o = obstacleOf(Shape::convexHull(hull), X_WG);
  for (float& half : o.half) half = floatAbove(static_cast<double>(half) + radius);
  o.view.excess += radius;
  return o;
}

int LaneSweep::addObstacle(const Shape& shape, const Pose& X_WG) {
  Impl::Obstacle o = Impl::obstacleOf(shape, X_WG);
  o.parts_begin = o.parts_end = static_cast<int>(impl_->obstacle_parts.size());
  if (shape.type() == ShapeType::kMesh) {
    for (const CoverPart& part : coverOf(shape)->parts) {
      impl_->obstacle_parts.push_back(Impl::partOf(part, X_WG));
      ++o.parts_end;
    }
  }
  impl_->obstacles.push_back(std::move(o));
  return static_cast<int>(impl_->obstacles.size()) - 1;
}

void LaneSweep::addPair(int id, int piece, int obstacle, int balls, double threshold,
                        bool by_parts) {
  const Impl::LanePiece& a = impl_->pieces[at(piece)];
  const double rounding = kLaneSweepRounding * (a.reach + static_cast<double>(a.outer.radius) +
                                                impl_->obstacles[at(obstacle)].scale);
  const Impl::Obstacle& o = impl_->obstacles[at(obstacle)];
  const bool points = a.frame >= 0 && a.points.begin < a.points.end;
  const bool deforms = o.shape.type() == ShapeType::kDeformable;
  impl_->pairs.push_back({id, piece, obstacle, balls, a.motion, false,
                          floatAbove(threshold + rounding), floatBelow(threshold - rounding),
                          floatAbove(std::max(threshold, 0.0) + rounding),
                          points && o.has_view ? partAbove(threshold, rounding) : -1.0F,
                          points && !deforms ? partEachAbove(threshold, rounding) : -1.0F,
                          by_parts && points && !deforms});
}

void LaneSweep::addPiecePair(int id, int a, int b, int motion, double threshold, bool by_parts) {
  const Impl::LanePiece &x = impl_->pieces[at(a)], &y = impl_->pieces[at(b)];
  const double rounding =
      kLaneSweepRounding *
      (x.reach + y.reach + static_cast<double>(x.outer.radius + y.outer.radius));
  impl_->piece_pairs.push_back(static_cast<std::int32_t>(impl_->pairs.size()));
  const bool planes = x.frame >= 0 && y.frame >= 0 && x.points.begin < x.points.end &&
                      y.points.begin < y.points.end;
  impl_->pairs.push_back(
      {id, a, b, b, motion, true, floatAbove(threshold + rounding),
       floatBelow(threshold - rounding), floatAbove(std::max(threshold, 0.0) + rounding),
       planes ? partAbove(threshold, rounding) : -1.0F, -1.0F, by_parts && planes});
}

bool LaneSweep::canMeet(int pair) const {
  const Impl::Pair& p = impl_->pairs[static_cast<std::size_t>(pair)];
  const auto piece = [&](int i) -> const Impl::LanePiece& {
    return impl_->pieces[static_cast<std::size_t>(i)];
  };
  const Impl::LanePiece& a = piece(p.a);
  const bool exact = !p.pieces && impl_->obstacles[static_cast<std::size_t>(p.b)].exact;
  const bool by_balls = exact || (p.balls >= 0 && piece(p.balls).inner < piece(p.balls).end);
  return (a.inner < a.end && by_balls) || (exact && a.frame >= 0 && a.own >= 0);
}

void LaneSweep::finish() { impl_->finish(); }

void LaneSweep::Impl::addPoints(const PointCover& cover, LanePiece& of) {
  double rounding = cover.fine_radius;
  const auto add = [&](const std::vector<Eigen::Vector3d>& added, double radius) {
    LanePiece::Points told;
    told.begin = static_cast<int>(points.size());
    for (const Eigen::Vector3d& p : added) {
      points.push_back(p);
      for (int k = 0; k < 3; ++k) point[k].push_back(static_cast<float>(p[k]));
      rounding = std::max(rounding, cover.fine_radius + centerRounding({p, 0}));
    }
    told.end = static_cast<int>(points.size());
    told.radius = floatAbove(radius);
    return told;
  };
  of.points = of.fine = add(cover.points, cover.radius);
  if (!cover.fine.empty()) of.fine = add(cover.fine, cover.fine_radius);
  if (cover.own) of.own = floatAbove(rounding);
  of.fine.clusters_begin = static_cast<int>(clusters.size());
  // (Clusters that are not clusterFine()'s are no help.)
  const std::vector<int>& ends = cover.clusters;
  const bool whole = ends.size() <= kMostClusters && !ends.empty() && ends.front() > 0 &&
                     std::is_sorted(ends.begin(), ends.end()) &&
                     ends.back() == static_cast<int>(cover.fine.size());
  int begin = 0;
  for (const int end : whole ? ends : std::vector<int>()) {
    addCluster(of.fine.begin + begin, of.fine.begin + end);
    begin = end;
  }
  of.fine.clusters_end = static_cast<int>(clusters.size());
  if (cover.nearest.size() == cover.points.size()) {
    for (const int i : cover.nearest) begin_with.push_back(of.fine.begin + i);
  }
  for (auto i = static_cast<int>(begin_with.size()); i < static_cast<int>(points.size()); ++i)
    begin_with.push_back(i);
}

void LaneSweep::Impl::addCluster(int begin, int end) {
  Cluster cluster{{}, 0, begin, end};
  Eigen::AlignedBox3d box;
  for (int i = begin; i < end; ++i) box.extend(points[at(i)]);
  setCenter(box.center(), cluster.center);
  const auto place = [](const float* p) {
    return Eigen::Vector3d(static_cast<double>(p[0]), static_cast<double>(p[1]),
                           static_cast<double>(p[2]));
  };
  const Eigen::Vector3d center = place(cluster.center);
  double radius = 0;
  for (int i = begin; i < end; ++i) {
    const float p[3] = {point[0][at(i)], point[1][at(i)], point[2][at(i)]};
    radius = std::max(radius, (place(p) - center).norm());
  }
  // See simd/lane_sweep.cc.
  cluster.radius = floatAbove((radius + 0x1p-20 * (center.norm() + radius)) * (1 + 0x1p-20));
  clusters.push_back(cluster);
}

void LaneSweep::Impl::addParts() {
  wholes = pieces.size();
  const auto shift = static_cast<int>(wholes);
  for (LanePiece& piece : pieces) {
    piece.parts_begin += shift;
    piece.parts_end += shift;
  }
  pieces.insert(pieces.end(), parts.begin(), parts.end());
  parts.clear();
  whole_obstacles = obstacles.size();
  const auto shift_obstacles = static_cast<int>(whole_obstacles);
  for (Obstacle& obstacle : obstacles) {
    obstacle.parts_begin += shift_obstacles;
    obstacle.parts_end += shift_obstacles;
  }
  std::move(obstacle_parts.begin(), obstacle_parts.end(), std::back_inserter(obstacles));
  obstacle_parts.clear();
  struct Range {
    int begin, end;
  };
  const auto partsOf = [](const auto& things, int i) {
    const auto& thing = things[at(i)];
    return thing.parts_begin < thing.parts_end ? Range{thing.parts_begin, thing.parts_end}
                                               : Range{i, i + 1};
  };
  const std::size_t whole_pairs = pairs.size();
  for (std::size_t p = 0; p < whole_pairs; ++p) {
    Pair pair = pairs[p];
    const Range a = partsOf(pieces, pair.a),
                b = pair.pieces ? partsOf(pieces, pair.b) : partsOf(obstacles, pair.b);
    const int count = (a.end - a.begin) * (b.end - b.begin);
    if (!pair.by_parts || count == 1 || count > kMostPartPairs) continue;
    pairs[p].parts_begin = static_cast<int>(pairs.size());
    pairs[p].parts_end = pairs[p].parts_begin + count;
    for (pair.a = a.begin; pair.a < a.end; ++pair.a)
      for (pair.b = b.begin; pair.b < b.end; ++pair.b) pairs.push_back(pair);
  }
}

void LaneSweep::Impl::finish() {
  addParts();
  for (LanePiece& piece : pieces) {
    if (piece.points.begin == piece.points.end) continue;
    const auto view = [&](const LanePiece::Points& p) {
      return viewOfPoints(&points[at(p.begin)], p.end - p.begin, 0);
    };
    piece.view = view(piece.points);
    piece.fine_view = view(piece.fine);
  }
  const std::size_t padded = paddedObstacles();
  pair_of.assign(wholes * padded, -1);
  std::vector<double> grown(whole_obstacles, 0.0);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    if (pair.pieces || at(pair.a) >= wholes || at(pair.b) >= whole_obstacles) continue;
    pieces[at(pair.a)].has_obstacles = true;
    pair_of[at(pair.a) * padded + at(pair.b)] = static_cast<std::int32_t>(p);
    double& g = grown[at(pair.b)];
    g = std::max(g, static_cast<double>(pair.free_above));
  }
  for (int k = 0; k < 3; ++k) {
    low[k].assign(padded, kFar);
    high[k].assign(padded, -kFar);
    for (std::size_t i = 0; i < whole_obstacles; ++i) {
      // A pair's rounding is larger than that of this comparison.
      low[k][i] = floatBelow(obstacles[i].low[k] - grown[i]);
      high[k][i] = floatAbove(obstacles[i].high[k] + grown[i]);
    }
  }
}

std::size_t LaneSweep::bytes() const {
  return impl_->pieces.size() * sizeof(Impl::LanePiece) +
         impl_->balls.size() * sizeof(Impl::LaneBall) +
         impl_->points.size() *
             (sizeof(Eigen::Vector3d) + 3 * sizeof(float) + sizeof(std::int32_t)) +
         impl_->clusters.size() * sizeof(Impl::Cluster) +
         impl_->obstacles.size() * (sizeof(Impl::Obstacle) + 6 * sizeof(float)) +
         impl_->pairs.size() * sizeof(Impl::Pair) + impl_->pair_of.size() * sizeof(std::int32_t);
}

LaneSweep::Scratch::Scratch(const LaneSweep& sweep) : impl_(std::make_unique<Impl>()) {
  const LaneSweep::Impl& s = *sweep.impl_;
  countInto(impl_->own);
  impl_->outer.resize(s.pieces.size());
  impl_->balls.resize(s.balls.size());
  impl_->cover_stamp.resize(s.pieces.size());
  impl_->inner_stamp.resize(s.pieces.size());
  impl_->part_stamp.resize(s.pieces.size());
  impl_->low.resize(3 * s.pieces.size());
  impl_->high.resize(3 * s.pieces.size());
  impl_->candidates.reserve(s.pairs.size());
  impl_->open.reserve(s.pairs.size());
  impl_->open_pairs.reserve(s.pairs.size());
  impl_->planes.resize(s.pairs.size());
  impl_->searches.resize(s.pairs.size());
  impl_->manners.resize(s.pairs.size());
  // What stands in the world is placed once.
  const auto still = [](const LaneSweep::Impl::LaneBall& ball, Impl::Placed& placed) {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < kLanes; ++i) {
        placed.center[k].at[i] = ball.center[k];
        placed.way[k].at[i] = 0;
      }
  };
  for (std::size_t p = 0; p < s.pieces.size(); ++p) {
    const LaneSweep::Impl::LanePiece& piece = s.pieces[p];
    if (piece.frame >= 0) continue;
    still(piece.outer, impl_->outer[p]);
    for (int k = 0; k < 3; ++k) {
      impl_->low[3 * p + at(k)] = piece.outer.center[k] - piece.outer.radius;
      impl_->high[3 * p + at(k)] = piece.outer.center[k] + piece.outer.radius;
    }
    for (int i = piece.cover; i < piece.end; ++i) still(s.balls[at(i)], impl_->balls[at(i)]);
  }
}
LaneSweep::Scratch::~Scratch() = default;
std::span<const LaneSweep::Open> LaneSweep::Scratch::open() const { return impl_->open; }

void LaneSweep::Scratch::countInto(Work& work) {
  impl_->work = &work;
  collision::countInto(impl_->distance, work);
}

void LaneSweep::Scratch::close(std::span<const std::uint32_t> lanes) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < impl_->open.size(); ++i) {
    impl_->open[i].lanes &= ~lanes[i];
    if (impl_->open[i].lanes == 0) continue;
    impl_->open[kept] = impl_->open[i];
    impl_->open_pairs[kept++] = impl_->open_pairs[i];
  }
  impl_->open.resize(kept);
  impl_->open_pairs.resize(kept);
}

namespace {

Pose poseOf(const LaneFrame& frame, int lane) {
  Pose X_WF;
  for (int i = 0; i < 9; ++i)
    X_WF.rotation.data()[i] = static_cast<double>(frame.rotation[i].at[lane]);
  for (int i = 0; i < 3; ++i) X_WF.translation[i] = static_cast<double>(frame.origin[i].at[lane]);
  return X_WF;
}

}  // namespace

LaneSweep::Contact LaneSweepKernel::told(std::int32_t pair, std::int32_t point,
                                         std::uint32_t lanes) const {
  // To the front of the killers.
  Scratch::Killer previous{pair, point};
  for (Scratch::Killer& killer : scratch.killers) {
    std::swap(killer, previous);
    if (previous.pair == pair || previous.pair < 0) break;
  }
  return {sweep.pairs[at(pair)].id, std::countr_zero(lanes)};
}

bool LaneSweepKernel::findPlane(const Sweep::Pair& pair, int lane, bool closely,
                                Scratch::Plane& plane, PairCache* cache) const {
  const Sweep::LanePiece& a = sweep.pieces[at(pair.a)];
  const Pose X_WA = poseOf(frames[a.frame], lane);
  const Sweep::Obstacle* o = pair.pieces ? nullptr : &sweep.obstacles[at(pair.b)];
  const Pose X_WB = o != nullptr ? o->X_WG : poseOf(frames[sweep.pieces[at(pair.b)].frame], lane);
  const auto viewOfPiece = [closely](const Sweep::LanePiece& piece) -> const ConvexView& {
    return closely ? piece.fine_view : piece.view;
  };
  const ConvexView& b = o != nullptr ? o->view : viewOfPiece(sweep.pieces[at(pair.b)]);
  const Pose X_BA = X_WB.inverse() * X_WA;
  DistanceRequest request;
  request.depth = false;
  request.tolerance = closely ? kLanePlaneTolerance / 8 : kLanePlaneTolerance;
  scratch.work->add(kPlaneSearchWork);
  const DistanceResult r =
      convexDistance(viewOfPiece(a), X_BA, b, request, scratch.distance, cache);
  if (!(r.distance.upper > 0) || !r.normal.allFinite()) return false;
  // Of the normal as it is rounded.
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
  const Eigen::Vector3d n_B = o.X_WG.rotation.transpose() * n;
  int hint = 0;
  plane.offset = floatAbove(n.dot(o.X_WG.translation) + n_B.dot(farthest(o.view, n_B, hint)) +
                            (o.view.radius + o.view.excess) * kLanePlaneOutwards);
}

void LaneSweepKernel::remember(std::int32_t number, const Each& each, int lane) const {
  const Sweep::Obstacle& o = sweep.obstacles[at(sweep.pairs[at(number)].b)];
  if (!o.has_view) return;
  Scratch::Plane plane;
  for (int k = 0; k < 3; ++k) plane.normal[k] = each.normal[k].at[lane];
  placePlane(o, plane);
  plane.known = std::isfinite(plane.offset);
  scratch.planes[at(number)] = plane;
}

}  // namespace leeway::collision
