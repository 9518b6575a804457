// First contact of a whole deforming mesh, against every triangle alone and against distances at
// many instants.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/time_of_contact.h"
#include "tests/support/allocations.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using Snapshot = std::shared_ptr<const DeformableSnapshot>;

std::shared_ptr<const DeformableMesh> sheet(int cells) {
  const testing::Sheet cloth = testing::cloth(cells);
  return DeformableMesh::make(cloth.vertices, cloth.triangles);
}

std::vector<Vector3d> waves(const DeformableMesh& mesh, Random& random, double height) {
  std::vector<Vector3d> v(mesh.rest().begin(), mesh.rest().end());
  const Vector3d k = 4 * random.direction();
  const double phase = random.uniform(0, 6), size = random.uniform(0.02, 0.2);
  const Vector3d drift(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), height);
  for (Vector3d& p : v) p += drift + size * Vector3d(0, 0.3, 1) * std::sin(k.dot(p) + phase);
  return v;
}

Pose randomPose(Random& random, double low, double high) {
  Pose X{random.rotation(), Vector3d::Zero()};
  X.translation.x() = random.uniform(-0.7, 0.7);
  X.translation.y() = random.uniform(-0.7, 0.7);
  X.translation.z() = random.uniform(low, high);
  return X;
}

/// Every triangle alone, up to the end.
ContactResult bruteForce(const Snapshot& from, const Snapshot& to, const Shape& b,
                         const RigidMotion& motion, const ContactRequest& request,
                         Scratch& scratch) {
  ContactResult first;
  first.status = ContactStatus::kFree;
  first.time = {HUGE_VAL, HUGE_VAL};
  for (const auto& corners : from->mesh().triangles()) {
    MovingTriangle t;
    for (std::size_t i = 0; i < 3; ++i) {
      t.from[i] = from->vertices()[static_cast<std::size_t>(corners[i])];
      t.to[i] = to->vertices()[static_cast<std::size_t>(corners[i])];
    }
    const ContactResult one = timeOfContact(t, b, motion, request, scratch);
    EXPECT_TRUE(one.status == ContactStatus::kFree || one.status == ContactStatus::kContact);
    if (one.status != ContactStatus::kContact) continue;
    first.status = one.status;
    first.time.lower = std::min(first.time.lower, one.time.lower);
    first.time.upper = std::min(first.time.upper, one.time.upper);
  }
  return first;
}

std::vector<Shape> bodies(Random& random) {
  return {Shape::sphere(0.2),
          Shape::capsule(0.05, 0.3),
          Shape::box({0.1, 0.2, 0.3}),
          Shape::cylinder(0.1, 0.2),
          oracle::randomShape(random, ShapeType::kConvexHull, oracle::Flavour::kPlain),
          Shape::halfSpace()};
}

TEST(TimeOfContactDeforming, AsEveryTriangleByItself) {
  Random random(23);
  Scratch scratch;
  const auto mesh = sheet(12);
  const DeformStrategy strategies[] = {DeformStrategy::kRebuild, DeformStrategy::kRefit,
                                       DeformStrategy::kHybrid,  DeformStrategy::kLazy,
                                       DeformStrategy::kOctree,  DeformStrategy::kRestructure};
  int contacts = 0, frees = 0, plane_contacts = 0;
  // Every strategy with every shape, once if slow.
  const int cases = kSanitized ? 36 : 120;
  for (int i = 0; i < cases; ++i) {
    DeformOptions options;
    options.strategy = strategies[i % 6];
    Deformable deformable(mesh, nullptr, options);
    ASSERT_EQ(deformable.update(waves(*mesh, random, -0.3), 0), UpdateStatus::kUpdated);
    const Snapshot from = deformable.snapshot();
    prepare(scratch, *from);
    ASSERT_EQ(deformable.update(waves(*mesh, random, 0.3), 1), UpdateStatus::kUpdated);
    const Snapshot to = deformable.snapshot();
    prepare(scratch, *to);
    const std::vector<Shape> shapes = bodies(random);
    const Shape& b = shapes[static_cast<std::size_t>(i / 6) % shapes.size()];
    Pose X0 = randomPose(random, 0.5, 1), X1 = randomPose(random, -0.6, 0.9);
    if (b.type() == ShapeType::kHalfSpace) {
      // An approaching wall, half of the cases without turning.
      X0.rotation = Eigen::AngleAxisd(M_PI - 0.2, Vector3d::UnitX()).toRotationMatrix();
      X1.rotation =
          i % 12 < 6 ? X0.rotation : Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();
      X0.translation.z() += 0.6;
    }
    const StraightMotion motion(X0, X1);
    ContactRequest request;
    request.margin = i % 5 == 0 ? 0.02 : 0;
    const ContactResult result = timeOfContact(from, to, b, motion, request, scratch);
    const ContactResult truth = bruteForce(from, to, b, motion, request, scratch);
    ASSERT_EQ(result.status, truth.status)
        << i << " " << toString(b.type()) << " " << toString(options.strategy);
    if (truth.status == ContactStatus::kFree) {
      ++frees;
      continue;
    }
    ++contacts;
    plane_contacts += b.type() == ShapeType::kHalfSpace;
    EXPECT_LE(result.time.width(), 2e-6) << i;
    EXPECT_LE(result.time.lower, truth.time.upper) << i;
    EXPECT_LE(truth.time.lower, result.time.upper) << i;
    EXPECT_GE(result.distance.triangle_a, 0);
    // Somewhere on the sheet at that time.
    std::vector<Vector3d> then(from->vertices().begin(), from->vertices().end());
    for (std::size_t v = 0; v < then.size(); ++v)
      then[v] += result.time.upper * (to->vertices()[v] - then[v]);
    Deformable check(mesh);
    ASSERT_EQ(check.update(then, 0), UpdateStatus::kUpdated);
    const DistanceResult there = distance(Shape::deformable(check.snapshot()), Pose{}, b,
                                          motion.pose(result.time.upper), {}, scratch);
    EXPECT_LE(there.distance.lower, request.margin + 1e-9) << i;
  }
  EXPECT_GT(contacts, cases / 3);
  EXPECT_GT(frees, cases / 8);
  EXPECT_GT(plane_contacts, cases / 40);
}

TEST(TimeOfContactDeforming, StartsAndSenselessQuestions) {
  Scratch scratch;
  const auto mesh = sheet(4);
  Deformable deformable(mesh);
  const Snapshot from = deformable.snapshot();
  const Still here(Pose{Eigen::Matrix3d::Identity(), Vector3d(0, 0, 0.1)});
  const ContactResult touching = timeOfContact(from, from, Shape::sphere(0.2), here, {}, scratch);
  EXPECT_EQ(touching.status, ContactStatus::kContact);
  EXPECT_EQ(touching.time.upper, 0);
  const ContactResult apart = timeOfContact(from, from, Shape::sphere(0.05), here, {}, scratch);
  EXPECT_EQ(apart.status, ContactStatus::kFree);
  // A ball inside a closed box, far from its walls.
  const Vector3d h(1, 1, 1);
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
  const std::vector<DeformableMesh::Triangle> faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                                       {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                                       {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto box = DeformableMesh::make(corners, faces);
  ASSERT_EQ(box->closedComponentCount(), 1);
  Deformable solid(box);
  const ContactResult inside =
      timeOfContact(solid.snapshot(), solid.snapshot(), Shape::sphere(0.05), here, {}, scratch);
  EXPECT_EQ(inside.status, ContactStatus::kContact);
  EXPECT_EQ(inside.time.upper, 0);

  const auto invalid = [&](const Snapshot& a, const Snapshot& b, const Shape& shape,
                           const ContactRequest& request) {
    return timeOfContact(a, b, shape, here, request, scratch).status == ContactStatus::kInvalid;
  };
  const Shape ball = Shape::sphere(0.05);
  ContactRequest request;
  EXPECT_TRUE(invalid(from, solid.snapshot(), ball, request));
  EXPECT_TRUE(invalid(from, nullptr, ball, request));
  EXPECT_TRUE(invalid(from, from, Shape::mesh(oracle::boxMesh(h)), request));
  request.margin = -0.01;
  EXPECT_TRUE(invalid(from, from, ball, request));
  request.margin = 0;
  request.query_limit = 1;
  const Still above(Pose{Eigen::Matrix3d::Identity(), Vector3d(0, 0, 0.3)});
  std::vector<Vector3d> raised(mesh->rest().begin(), mesh->rest().end());
  for (Vector3d& p : raised) p.z() += 1;
  ASSERT_EQ(deformable.update(raised, 1), UpdateStatus::kUpdated);
  const ContactResult limited =
      timeOfContact(from, deformable.snapshot(), ball, above, request, scratch);
  EXPECT_EQ(limited.status, ContactStatus::kUndecided);
  EXPECT_EQ(limited.time.lower, 0);
  const ContactResult met = timeOfContact(from, deformable.snapshot(), ball, above, {}, scratch);
  EXPECT_EQ(met.status, ContactStatus::kContact);
  EXPECT_NEAR(met.time.upper, 0.25, 1e-6);
}

TEST(TimeOfContactDeforming, LooksAtFewTrianglesAndAllocatesNothing) {
  Random random(29);
  Scratch scratch;
  const auto mesh = sheet(100);  // 20,000 triangles
  DeformOptions options;
  options.strategy = DeformStrategy::kRefit;
  Deformable deformable(mesh, nullptr, options);
  ASSERT_EQ(deformable.update(waves(*mesh, random, -0.2), 0), UpdateStatus::kUpdated);
  const Snapshot from = deformable.snapshot();
  ASSERT_EQ(deformable.update(waves(*mesh, random, 0.2), 1), UpdateStatus::kUpdated);
  const Snapshot to = deformable.snapshot();
  const Shape ball = Shape::sphere(0.05);
  const StraightMotion motion(randomPose(random, 0.5, 1), randomPose(random, -0.6, -0.4));
  ContactResult result;
  const std::size_t before = testing::allocationCount();
  result = timeOfContact(from, to, ball, motion, {}, scratch);
  EXPECT_EQ(testing::allocationCount(), before);
  EXPECT_EQ(result.status, ContactStatus::kContact);
  EXPECT_LT(result.queries, 5000);
}

}  // namespace
}  // namespace leeway::collision
