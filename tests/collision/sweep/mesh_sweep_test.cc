#include "collision/sweep/mesh_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "collision/mesh/descent/box_gaps.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/time_of_contact.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/collision/convex/box_cases.h"
#include "tests/support/allocations.h"
#include "tests/support/every_target.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

/// Poses of A in B, both turning; counts calls.
class Seen final : public Placements {
 public:
  Seen(const RigidMotion& motion) : motion_(motion) {}
  bool at(double t, Pose& X_BA) override {
    X_BA = motion_.pose(t);
    ++asked;
    return asked <= room;
  }
  int asked = 0, room = std::numeric_limits<int>::max();

 private:
  const RigidMotion& motion_;
};

/// Bound for `bend`: |p''| <= angular_speed^2 |p - axis|, plus the origin's own.
double bendOf(const RigidMotion& motion, const Shape& a) {
  const FrameMotionBound bound = motion.bound(0, 1);
  return (bound.acceleration + bound.angular_speed * bound.angular_speed * a.extent()) / 8 *
             (1 + 1e-9) +
         1e-12;
}

std::string text(const Pose& X) {
  std::ostringstream out;
  out.precision(17);
  out << X.rotation.reshaped().transpose() << " | " << X.translation.transpose();
  return out.str();
}

struct Counts {
  int unsafe = 0, wrong = 0, free = 0, contact = 0, undecided = 0;
};

/// Against single placements: with a free verdict none is within the threshold, a contact is one at
/// its time, and motions that stay far from the threshold are free.
void check(const Shape& a, const Shape& b, const RigidMotion& motion, double threshold,
           const std::string& what, Counts& counts) {
  Scratch scratch;
  Seen seen(motion);
  MeshSweepRequest request;
  request.bend = bendOf(motion, a);
  request.threshold = threshold;
  const MeshSweepResult result = sweepMesh(a, seen, b, request, scratch);
  double nearest = std::numeric_limits<double>::infinity();
  PairCache cache;
  // Surfaces only: containment is outside a sweep's scope.
  const auto surfaces = [&](double t) {
    DistanceRequest exact;
    exact.tolerance = 1e-6;
    const DistanceResult r = distance(a, motion.pose(t), b, {}, exact, scratch, &cache);
    return r.distance;
  };
  for (int k = 0; k <= 64; ++k) nearest = std::min(nearest, surfaces(k / 64.0).upper);
  switch (result.status) {
    case MeshSweepStatus::kFree:
      ++counts.free;
      if (nearest <= threshold && nearest >= 0) {
        ++counts.unsafe;
        ADD_FAILURE() << "unsafe: " << what << ": " << nearest << " <= " << threshold;
      }
      break;
    case MeshSweepStatus::kContact:
      ++counts.contact;
      EXPECT_LE(surfaces(result.t).lower, threshold) << what << " at " << result.t;
      break;
    case MeshSweepStatus::kUndecided:
      ++counts.undecided;
      break;
  }
  const FrameMotionBound bound = motion.bound(0, 1);
  const double speed = bound.speed + bound.angular_speed * a.extent();
  if (nearest > threshold + speed / 128 + 1e-3 && result.status != MeshSweepStatus::kFree) {
    ++counts.wrong;
    ADD_FAILURE() << what << ": " << nearest << " is not called free";
  }
}

TEST(MeshSweep, HoldsAgainstPlacementsOnTheWay) {
  Random random(61);
  const auto meshes = sampleMeshes(61);
  const auto shapes = sampleConvexShapes(random);
  Counts counts;
  int pairs = 0;
  const auto one = [&](const Shape& a, const Shape& b, const std::string& what) {
    if (!sweepsMesh(a, b) || (kSanitized && ++pairs % 10 != 0)) return;
    for (int i = 0; i < 3; ++i) {
      const Pose X0 = random.pose(2),
                 X1{i == 0 ? X0.rotation : random.pose(1).rotation,
                    X0.translation + random.uniform(0, 2) * random.direction()};
      const double threshold = i == 2 ? 0.05 : 1e-9;
      const std::string name = what + " from " + text(X0) + " to " + text(X1);
      check(a, b, StraightMotion(X0, X1), threshold, name, counts);
      check(a, b, ScrewMotion(X0, X1), threshold, name + " screw", counts);
    }
  };
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Shape mesh = Shape::mesh(meshes[i].mesh);
    for (std::size_t j = i % 3; j < meshes.size(); j += 3)
      one(mesh, Shape::mesh(meshes[j].mesh), meshes[i].name + " to " + meshes[j].name);
    for (const auto& [kind, shape] : shapes) {
      one(mesh, shape, meshes[i].name + " to " + kind);
      one(shape, mesh, kind + " to " + meshes[i].name);
    }
  }
  EXPECT_EQ(counts.unsafe, 0);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_GT(counts.free, kSanitized ? 8 : 100);
  EXPECT_GT(counts.contact, kSanitized ? 8 : 100);
  EXPECT_LT(counts.undecided, (counts.free + counts.contact) / 20);
}

/// Vertices far from a mesh's origin, to which its placement moves them back.
TEST(MeshSweep, FarFromItsOriginAMeshTakesAsManyNodes) {
  Random random(65);
  const TriangleSoup ball = ballSoup(9, 12, 0.3, 0.05, random),
                     torus = torusSoup(16, 8, 1, 0.2, 0, random);
  const auto moved = [](TriangleSoup soup, const Vector3d& by) {
    for (Vector3d& v : soup.vertices) v += by;
    return Shape::mesh(named("far", soup).mesh);
  };
  Counts counts;
  int nodes_here = 0;
  for (const double away : {0.0, 1e3, 1e6}) {
    const Vector3d by(away, 0.3 * away, -away);
    const Shape a = moved(ball, {0, 0, 0}), b = moved(torus, {0, 0, 0}), far_a = moved(ball, by),
                far_b = moved(torus, by);
    Random places(66);
    int nodes = 0;
    const auto one = [&](const Shape& x, const Shape& y, const Pose& X0, const Pose& X1,
                         const std::string& what) {
      const StraightMotion motion(X0, X1);
      check(x, y, motion, 1e-6, what + " from " + text(X0) + " to " + text(X1), counts);
      Scratch scratch;
      Seen seen(motion);
      MeshSweepRequest request;
      request.bend = bendOf(motion, x);
      request.threshold = 1e-6;
      nodes += sweepMesh(x, seen, y, request, scratch).nodes;
    };
    for (int i = 0; i < casesToAsk(20); ++i) {
      const Pose X0 = places.pose(1.5), X1 = places.pose(1.5);
      one(a, far_b, {X0.rotation, X0.translation + by}, {X1.rotation, X1.translation + by}, "to");
      // (A turn would move a distant body far.)
      const Vector3d back = X0.rotation * by;
      one(far_a, b, {X0.rotation, X0.translation - back}, {X0.rotation, X1.translation - back}, "");
    }
    if (away == 0) nodes_here = nodes;
    EXPECT_LT(nodes, 1.2 * nodes_here + 10) << away;
  }
  EXPECT_EQ(counts.unsafe, 0);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_GT(counts.free, casesToAsk(20));
  EXPECT_GT(counts.contact, casesToAsk(20));
}

/// A part of a motion is queried like a whole motion.
TEST(MeshSweep, PartsOfAMotion) {
  Random random(62);
  TriangleSoup soup = ballSoup(9, 12, 0.3, 0.05, random);
  const Shape ball = Shape::mesh(named("ball", soup).mesh);
  Scratch scratch;
  int mixed = 0;
  for (int i = 0; i < casesToAsk(200); ++i) {
    const StraightMotion motion(random.pose(1.2), random.pose(1.2));
    MeshSweepRequest request;
    request.bend = bendOf(motion, ball);
    request.threshold = 1e-6;
    Seen seen(motion);
    const MeshSweepStatus whole = sweepMesh(ball, seen, ball, request, scratch).status;
    int free = 0;
    request.h = 0.125;
    for (int k = 0; k < 8; ++k) {
      request.t0 = k * request.h;
      const MeshSweepResult part = sweepMesh(ball, seen, ball, request, scratch);
      free += part.status == MeshSweepStatus::kFree ? 1 : 0;
      if (part.status != MeshSweepStatus::kContact) continue;
      EXPECT_GE(part.t, request.t0);
      EXPECT_LE(part.t, request.t0 + request.h);
    }
    if (whole != MeshSweepStatus::kUndecided) {
      EXPECT_EQ(whole == MeshSweepStatus::kFree, free == 8) << i;
    }
    mixed += free > 0 && free < 8 ? 1 : 0;
  }
  EXPECT_GT(mixed, casesToAsk(30));
}

/// Separated parts are not subdivided: the number of nodes does not grow with the ratio of way to
/// size.
TEST(MeshSweep, SmallBodiesOnALongWay) {
  Scratch scratch;
  const auto cube = [](double half) {
    return Shape::mesh(named("cube", boxSoup(Vector3d::Constant(half))).mesh);
  };
  const auto asked = [&](const Shape& a, const Shape& b, const Vector3d& from, const Vector3d& to) {
    Pose X0, X1;
    X0.translation = from;
    X1.translation = to;
    const StraightMotion motion(X0, X1);
    Seen seen(motion);
    return sweepMesh(a, seen, b, {}, scratch);
  };
  const Shape still = cube(0.2);
  for (const double half : {0.1, 1e-3, 1e-5}) {
    const Shape moved = cube(half), box = Shape::box(Vector3d::Constant(half));
    for (const Shape& a : {moved, box}) {
      for (const double way : {2.0, 2e3, 2e6}) {
        const MeshSweepResult past =
            asked(a, still, {-way, 0.2 + 2 * half, 0.01}, {way, 0.2 + 2 * half, 0.02});
        EXPECT_EQ(past.status, MeshSweepStatus::kFree) << half << ' ' << way;
        EXPECT_LT(past.nodes, 1500) << half << ' ' << way;
        const MeshSweepResult hit = asked(a, still, {-way, 0.03, 0.01}, {way, 0.01, 0.02});
        // 2^-30 of the longest exceeds the smallest.
        if (way < 1e6) {
          EXPECT_EQ(hit.status, MeshSweepStatus::kContact) << half << ' ' << way;
        }
        EXPECT_NE(hit.status, MeshSweepStatus::kFree) << half << ' ' << way;
        EXPECT_LT(hit.nodes, 1500) << half << ' ' << way;
      }
    }
  }
}

TEST(MeshSweep, LimitsLeaveItUndecided) {
  Random random(63);
  TriangleSoup soup = ballSoup(9, 12, 0.3, 0.05, random);
  const Shape ball = Shape::mesh(named("ball", soup).mesh);
  Scratch scratch;
  Pose X0, X1;
  X0.translation = {-1, 0.62, 0};
  X1.translation = {1, 0.62, 0};
  X1.rotation = Eigen::AngleAxisd(1, Vector3d::UnitZ()).toRotationMatrix();
  const StraightMotion motion(X0, X1);
  MeshSweepRequest request;
  request.bend = bendOf(motion, ball);
  request.threshold = 1e-6;
  Seen seen(motion);
  const MeshSweepResult all = sweepMesh(ball, seen, ball, request, scratch);
  EXPECT_EQ(all.status, MeshSweepStatus::kFree);
  for (const int limit : {0, 1, 10, all.nodes / 2}) {
    request.node_limit = limit;
    EXPECT_EQ(sweepMesh(ball, seen, ball, request, scratch).status, MeshSweepStatus::kUndecided);
  }
  request.node_limit = all.nodes + 1;
  Seen short_of(motion);
  for (const int room : {0, 1, 3}) {
    short_of.asked = 0;
    short_of.room = room;
    EXPECT_EQ(sweepMesh(ball, short_of, ball, request, scratch).status,
              MeshSweepStatus::kUndecided);
  }
  const auto refuses = [&](double bend, double threshold, double t0, double h) {
    MeshSweepRequest bad;
    bad.bend = bend;
    bad.threshold = threshold;
    bad.t0 = t0;
    bad.h = h;
    return sweepMesh(ball, seen, ball, bad, scratch).status == MeshSweepStatus::kUndecided;
  };
  const double nan = std::nan("");
  EXPECT_TRUE(refuses(-1, 0, 0, 1) && refuses(nan, 0, 0, 1) && refuses(0.1, -1, 0, 1) &&
              refuses(0.1, nan, 0, 1) && refuses(0.1, 0, -1, 1) && refuses(0.1, 0, nan, 1) &&
              refuses(0.1, 0, 0, 0.3) && refuses(0.1, 0, 0.3, 0.5) && refuses(0.1, 0, 0.25, 0.5) &&
              refuses(0.1, 0, 0, 2) && refuses(0.1, 0, 0, nan) && refuses(0.1, 0, 0, 0));
  EXPECT_FALSE(sweepsMesh(Shape::box({1, 1, 1}), Shape::sphere(1)));
  EXPECT_FALSE(sweepsMesh(ball, Shape::halfSpace()));
}

TEST(MeshSweep, AllocatesNothing) {
  Random random(64);
  const auto meshes = sampleMeshes(64);
  const auto shapes = sampleConvexShapes(random);
  Scratch scratch;
  std::size_t allocated = 0;
  int asked = 0;
  for (const NamedMesh& m : meshes) {
    const Shape a = Shape::mesh(m.mesh), b = Shape::mesh(meshes[3].mesh);
    const StraightMotion motion(random.pose(1), random.pose(1));
    MeshSweepRequest request;
    request.bend = bendOf(motion, a);
    Seen seen(motion);
    const std::size_t before = allocationCount();
    sweepMesh(a, seen, b, request, scratch);
    for (const auto& [kind, shape] : shapes) sweepMesh(a, seen, shape, request, scratch);
    allocated += allocationCount() - before;
    asked += seen.asked;
  }
  EXPECT_EQ(allocated, 0U);
  EXPECT_GT(asked, 100);
}

Shape hullOf(const OrientedBox& box, const Eigen::Matrix3d& map, const Vector3d& shift) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    Vector3d p;
    for (int r = 0; r < 3; ++r) {
      p[r] = static_cast<double>(box.center[r]);
      for (int k = 0; k < 3; ++k)
        p[r] += ((i >> k & 1) != 0 ? 1 : -1) * static_cast<double>(box.half[k]) *
                static_cast<double>(box.axis[k][r]);
    }
    corners.push_back(map * p + shift);
  }
  return Shape::convexHull(corners);
}

struct GapCase {
  BoxNode node{};
  OrientedBox query;
  BoxSweep sweep;
  BoxDirection direction{};
  Eigen::Matrix3d turn;
  Vector3d way;
};

GapCase randomGapCase(Random& random) {
  GapCase c;
  c.query = randomBox(random, 2, 1);
  for (int column = 0; column < BoxNode::kWidth; ++column) {
    const OrientedBox box = randomBox(random, 2, 1);
    setColumn(c.node, column, box);
    c.node.radius[column] = std::sqrt(box.half[0] * box.half[0] + box.half[1] * box.half[1] +
                                      box.half[2] * box.half[2]);
  }
  c.sweep.of_node = (random.below(2) == 0);
  c.turn = Eigen::Matrix3d::Zero();
  const Vector3d w = random.uniform(0, 0.4) * random.direction();
  c.turn << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  c.way = random.uniform(0, 1) * random.direction();
  for (int i = 0; i < 3; ++i) {
    c.sweep.way[i] = static_cast<float>(c.way[i]);
    for (int k = 0; k < 3; ++k) {
      c.sweep.map[3 * i + k] = i == k ? 1 : 0;
      c.sweep.turn[3 * i + k] = static_cast<float>(c.turn(i, k));
    }
  }
  c.sweep.loose = c.sweep.of_node ? static_cast<float>(w.norm() * (1 + 1e-6)) : 0;
  c.sweep.fixed = c.sweep.of_node ? 1e-4F : 0;
  if (!c.sweep.of_node) c.turn.setZero();
  if (random.below(2) == 0) c.direction = boxDirection((1 + 1e-6) * random.direction());
  return c;
}

TEST(SweptBoxGaps, AreBelowTheDistanceAtAllPlacesOnTheWay) {
  Random random(64);
  Scratch scratch;
  int unsafe = 0, apart = 0, separated = 0;
  for (int i = 0; i < casesToAsk(400); ++i) {
    const GapCase c = randomGapCase(random);
    float gap[BoxNode::kWidth];
    sweptBoxGaps(c.node, c.query, c.sweep, c.direction, gap);
    for (int column = 0; column < BoxNode::kWidth; ++column) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const double s : {-1.0, -0.4, 0.0, 0.7, 1.0}) {
        const Eigen::Matrix3d map = Eigen::Matrix3d::Identity() + s * c.turn;
        const OrientedBox& moved = c.sweep.of_node ? c.node.box(column) : c.query;
        const OrientedBox& other = c.sweep.of_node ? c.query : c.node.box(column);
        nearest =
            std::min(nearest, distance(hullOf(moved, map, s * c.way), {},
                                       hullOf(other, Eigen::Matrix3d::Identity(), Vector3d::Zero()),
                                       {}, {}, scratch)
                                  .distance.upper);
      }
      if (static_cast<double>(gap[column]) > std::max(nearest, 0.0)) {
        ++unsafe;
        ADD_FAILURE() << "case " << i << " column " << column << ": " << gap[column] << " > "
                      << nearest;
      }
      if (!(nearest > 0.2)) continue;
      ++apart;
      separated += gap[column] > 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(apart, casesToAsk(800));
  EXPECT_GT(separated, 0.7 * apart);
}

TEST(SweptBoxGaps, AreTheSameOnEveryInstructionSet) {
  const auto run = [] {
    Random random(65);
    std::vector<float> all;
    for (int i = 0; i < 200; ++i) {
      const GapCase c = randomGapCase(random);
      float gap[BoxNode::kWidth];
      sweptBoxGaps(c.node, c.query, c.sweep, c.direction, gap);
      all.insert(all.end(), gap, gap + BoxNode::kWidth);
    }
    return all;
  };
  expectTheSameBytesOnEveryTarget(run);
}

}  // namespace
}  // namespace leeway::collision
