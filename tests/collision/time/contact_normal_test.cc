// The normal of a contact, compared with the normal of bodies just apart, from plain supports and
// pairs of triangles.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/mesh/descent/triangle_pair.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/time_of_contact.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

double degrees(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / 3.14159265358979;
}

/// The largest n . p over the shape's points, in its own frame; of a mesh its vertices'.
double support(const Shape& s, const Vector3d& n) {
  const double across = std::hypot(n.x(), n.y());
  switch (s.type()) {
    case ShapeType::kSphere:
      return s.radius() * n.norm();
    case ShapeType::kCapsule:
      return s.radius() * n.norm() + s.halfLength() * std::abs(n.z());
    case ShapeType::kBox:
      return n.cwiseAbs().dot(s.halfExtents());
    case ShapeType::kCylinder:
      return s.radius() * across + s.halfLength() * std::abs(n.z());
    case ShapeType::kCone:
      return std::max(s.halfLength() * n.z(), s.radius() * across - s.halfLength() * n.z());
    case ShapeType::kEllipsoid:
      return n.cwiseProduct(s.halfExtents()).norm();
    case ShapeType::kConvexHull: {
      double most = -kInfinity;
      for (const Vector3d& v : s.hull()->vertices()) most = std::max(most, n.dot(v));
      return most;
    }
    case ShapeType::kHalfSpace:
      return n.z() > 0 && across < 1e-12 * n.z() ? 0 : kInfinity;
    case ShapeType::kMesh:
    case ShapeType::kDeformable:
      break;
  }
  return kInfinity;
}

/// The distance of B from A that a plane with this normal proves.
double apartAlong(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                  const Vector3d& n) {
  return n.dot(X_WB.translation - X_WA.translation) - support(a, X_WA.rotation.transpose() * n) -
         support(b, X_WB.rotation.transpose() * -n);
}

/// The normal of convex bodies that are just apart. Plain supports must give their distance along
/// it, so no other direction can be much better.
Vector3d normalApart(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                     Scratch& scratch) {
  const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
  EXPECT_GT(r.distance.lower, 0);
  if (a.type() != ShapeType::kHalfSpace && b.type() != ShapeType::kHalfSpace) {
    EXPECT_GT(apartAlong(a, X_WA, b, X_WB, r.normal), 0.999 * r.distance.upper);
  }
  return r.normal;
}

struct Angles {
  std::vector<double> all;
  void add(const Vector3d& normal, const Vector3d& truth) {
    EXPECT_NEAR(normal.norm(), 1, 1e-9);
    all.push_back(degrees(normal.dot(truth)));
  }
  double most() const { return all.empty() ? 0 : *std::max_element(all.begin(), all.end()); }
  double median() {
    std::sort(all.begin(), all.end());
    return all.empty() ? 0 : all[all.size() / 2];
  }
};

/// Cast from outside towards the other body, with a rotation on the way.
StraightMotion cast(oracle::Random& random, const Shape& a, const Shape& b) {
  const double size = oracle::sizeOf(a) + oracle::sizeOf(b);
  Pose from{random.rotation(), 1.5 * size * random.direction()};
  if (b.type() == ShapeType::kHalfSpace)
    from.translation.z() = std::abs(from.translation.z()) + size;
  Pose to{random.rotation(), 0.3 * oracle::sizeOf(b) * random.direction() - from.translation};
  if (random.chance(0.5)) to.rotation = from.rotation;
  return {from, to};
}

// Regression: where convex hulls met, the normal was (1, 0, 0), or of the depth of another corner.
TEST(ContactNormal, OfConvexShapesIsThatJustBefore) {
  oracle::Random random(11);
  Scratch scratch;
  const ShapeType types[] = {ShapeType::kSphere,    ShapeType::kCapsule,   ShapeType::kBox,
                             ShapeType::kCylinder,  ShapeType::kCone,      ShapeType::kEllipsoid,
                             ShapeType::kHalfSpace, ShapeType::kConvexHull};
  for (const ShapeType type_a : types) {
    for (const ShapeType type_b : types) {
      if (type_a == ShapeType::kHalfSpace)
        continue;  // used as B; the exchanged order is tested
                   // below
      Angles angles;
      int contacts = 0;
      const int casts = kSanitized ? 10 : 200;
      for (int i = 0; i < casts; ++i) {
        const Shape a = oracle::randomShape(random, type_a, oracle::Flavour::kPlain),
                    b = oracle::randomShape(random, type_b, oracle::Flavour::kPlain);
        const StraightMotion motion = cast(random, a, b);
        Pose X_WB;
        if (type_b != ShapeType::kHalfSpace) X_WB.rotation = random.rotation();
        const Still still(X_WB);
        const ContactResult result = timeOfContact(a, motion, b, still, {}, scratch);
        if (result.status != ContactStatus::kContact) continue;
        ++contacts;
        const double t = std::max(0.0, result.time.lower - 1e-6);
        const Vector3d truth = normalApart(a, motion.pose(t), b, still.pose(0), scratch);
        angles.add(result.distance.normal, truth);
        // In the other order it is the opposite.
        const ContactResult other = timeOfContact(b, still, a, motion, {}, scratch);
        EXPECT_LT(degrees(-other.distance.normal.dot(truth)), 13);
      }
      EXPECT_GT(contacts, casts / 4) << toString(type_a) << " " << toString(type_b);
      EXPECT_LT(angles.most(), 13) << toString(type_a) << " " << toString(type_b);
      EXPECT_LT(angles.median(), 0.05) << toString(type_a) << " " << toString(type_b);
    }
  }
}

TEST(ContactNormal, OfBodiesThatFallOnAHull) {
  Scratch scratch;
  const Shape floor = Shape::convexHull(testing::boxSoup({1, 1, 0.1}, {0, 0, -0.1}).vertices),
              box = Shape::convexHull(testing::boxSoup({0.2, 0.2, 0.2}).vertices);
  Pose above, below;
  above.translation = {0.3, 0.1, 1};
  below.translation = {0.3, 0.1, -1};
  for (const Shape& falling : {Shape::sphere(0.2), box, Shape::box({0.2, 0.2, 0.2})}) {
    const ContactResult result =
        timeOfContact(falling, StraightMotion(above, below), floor, Still({}), {}, scratch);
    ASSERT_EQ(result.status, ContactStatus::kContact);
    EXPECT_NEAR(result.time.lower, 0.4, 1e-6);
    EXPECT_LT((result.distance.normal + Vector3d::UnitZ()).norm(), 1e-6);
  }
}

/// The unit vector between the nearest points of two meshes, from A to B.
Vector3d nearestWay(const TriangleMesh& a, const Pose& X_WA, const TriangleMesh& b,
                    const Pose& X_WB) {
  const auto cornersOf = [](const TriangleMesh& m, const Pose& X, std::size_t t, Vector3d* p) {
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = X * m.vertices()[static_cast<std::size_t>(m.triangles()[t][k])];
  };
  double least = kInfinity;
  Vector3d way = Vector3d::Zero();
  for (std::size_t i = 0; i < a.triangles().size(); ++i) {
    for (std::size_t j = 0; j < b.triangles().size(); ++j) {
      Vector3d p[3], q[3];
      cornersOf(a, X_WA, i, p);
      cornersOf(b, X_WB, j, q);
      const TrianglePair pair = trianglePair(p, q);
      if (!(pair.above < least)) continue;
      least = pair.above;
      way = pair.q - pair.p;
    }
  }
  return way.normalized();
}

TEST(ContactNormal, OfMeshesIsThatJustBefore) {
  testing::Random random(12);
  Scratch scratch;
  std::vector<testing::NamedMesh> meshes;
  meshes.push_back(testing::named("box", testing::boxSoup({0.5, 0.3, 0.2})));
  meshes.push_back(testing::named("torus", testing::torusSoup(10, 5, 0.5, 0.2, 0.2, random)));
  meshes.push_back(testing::named("bumpy ball", testing::ballSoup(5, 6, 0.5, 0.3, random)));
  for (const auto& m : meshes) {
    for (const auto& n : meshes) {
      Angles angles;
      const Shape a = Shape::mesh(m.mesh), b = Shape::mesh(n.mesh);
      for (int i = 0; i < casesToAsk(60); ++i) {
        Pose from = random.pose(0), to = from;
        from.translation = 3 * random.direction();
        to.translation = 0.3 * random.vector() - from.translation;
        if (i % 2 == 0) to.rotation = random.pose(0).rotation;
        const StraightMotion motion(from, to);
        const ContactResult result = timeOfContact(a, motion, b, Still({}), {}, scratch);
        if (result.status != ContactStatus::kContact) continue;
        const double t = std::max(0.0, result.time.lower - 1e-6);
        angles.add(result.distance.normal, nearestWay(*m.mesh, motion.pose(t), *n.mesh, {}));
      }
      EXPECT_GT(angles.all.size(), casesToAsk(20)) << m.name << " " << n.name;
      EXPECT_LT(angles.most(), 13) << m.name << " " << n.name;
      EXPECT_LT(angles.median(), 0.05) << m.name << " " << n.name;
    }
  }
}

TEST(ContactNormal, OfADeformingMeshIsThatJustBefore) {
  testing::Random random(13);
  Scratch scratch;
  const testing::TriangleSoup soup = testing::ballSoup(6, 8, 0.5, 0.2, random);
  DeformOptions options;
  options.strategy = DeformStrategy::kRefit;
  Deformable deformable(DeformableMesh::make(soup.vertices, soup.triangles), nullptr, options);
  std::vector<Vector3d> vertices = soup.vertices;
  ASSERT_EQ(deformable.update(vertices, 0), UpdateStatus::kUpdated);
  const auto from = deformable.snapshot();
  for (Vector3d& v : vertices) v += 0.2 * random.vector();
  ASSERT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated);
  const auto to = deformable.snapshot();
  prepare(scratch, *from);
  prepare(scratch, *to);
  Angles angles;
  for (int i = 0; i < casesToAsk(200); ++i) {
    const Shape sphere = Shape::sphere(0.1 + 0.1 * random.uniform(0, 1));
    Pose begin, end;
    begin.translation = 1.5 * random.direction();
    end.translation = 0.3 * random.vector() - begin.translation;
    const StraightMotion motion(begin, end);
    const ContactResult result = timeOfContact(from, to, sphere, motion, {}, scratch);
    if (result.status != ContactStatus::kContact) continue;
    const double t = std::max(0.0, result.time.lower - 1e-6);
    // The nearest point of all triangles to the sphere's centre.
    Vector3d way = Vector3d::Zero();
    double least = kInfinity;
    for (const auto& triangle : from->mesh().triangles()) {
      Vector3d p[3];
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(triangle[k]);
        p[k] = (1 - t) * from->vertices()[v] + t * to->vertices()[v];
      }
      const Vector3d center = motion.pose(t).translation;
      const Vector3d q[3] = {center, center, center};
      const TrianglePair pair = trianglePair(p, q);
      if (pair.above < least) {
        least = pair.above;
        way = pair.q - pair.p;
      }
    }
    angles.add(result.distance.normal, way.normalized());
  }
  EXPECT_GT(angles.all.size(), casesToAsk(100));
  EXPECT_LT(angles.most(), 1);
}

// For bodies in contact at the start, the direction of approach is unknown.
TEST(ContactNormal, OfBodiesInContactAtTheStart) {
  Scratch scratch;
  Pose inside, away;
  inside.translation = {0, 0, 0.4};
  away.translation = {0, 0, 3};
  const auto soup = testing::boxSoup({0.5, 0.5, 0.5});
  const Shape hull = Shape::convexHull(soup.vertices), small = Shape::box({0.2, 0.2, 0.2}),
              mesh = Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles));
  const StraightMotion motion(inside, away);
  // Convex bodies have a depth.
  const ContactResult convex = timeOfContact(small, motion, hull, Still({}), {}, scratch);
  EXPECT_EQ(convex.status, ContactStatus::kContact);
  EXPECT_EQ(convex.time.upper, 0);
  EXPECT_LT((convex.distance.normal + Vector3d::UnitZ()).norm(), 1e-9);
  const ContactResult solid = timeOfContact(small, motion, mesh, Still({}), {}, scratch);
  EXPECT_EQ(solid.status, ContactStatus::kContact);
  EXPECT_EQ(solid.distance.normal.norm(), 0);
  // Within a margin the bodies are apart, so they have a normal.
  ContactRequest request;
  request.margin = 0.5;
  inside.translation = {0, 0, 1};
  const ContactResult near =
      timeOfContact(small, StraightMotion(inside, away), mesh, Still({}), request, scratch);
  EXPECT_EQ(near.status, ContactStatus::kContact);
  EXPECT_LT((near.distance.normal + Vector3d::UnitZ()).norm(), 1e-6);
}

}  // namespace
}  // namespace leeway::collision
