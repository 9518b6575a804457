#include "leeway/collision/time_of_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "leeway/collision/distance.h"
#include "tests/support/from_environment.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using oracle::Random;

Pose randomPose(Random& random, double size) {
  return {random.rotation(),
          Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size),
                          random.uniform(-size, size))};
}

Pose shifted(double x, double y, double z) { return {Eigen::Matrix3d::Identity(), {x, y, z}}; }
Pose turnedAbout(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& p) {
  return {Eigen::AngleAxisd(angle, axis).toRotationMatrix(), p};
}

/// Slow twin: the distance at many instants, at full accuracy.
struct Sampled {
  double first_touch = std::numeric_limits<double>::infinity();  // time of a proven contact
  double least = std::numeric_limits<double>::infinity();        // smallest upper end found
};
Sampled sampled(const Shape& a, const RigidMotion& ma, const Shape& b, const RigidMotion& mb,
                double margin, int count) {
  Scratch scratch;
  Sampled s;
  for (int i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) / count;
    const DistanceResult r = distance(a, ma.pose(t), b, mb.pose(t), {}, scratch);
    s.least = std::min(s.least, r.distance.upper - margin);
    if (r.distance.upper <= margin) {
      s.first_touch = t;
      break;
    }
  }
  return s;
}

/// Checks the answer against the samples; returns whether it was a contact.
bool expectTrue(const ContactResult& result, const Shape& a, const RigidMotion& ma, const Shape& b,
                const RigidMotion& mb, double margin, const std::string& where) {
  const Sampled s = sampled(a, ma, b, mb, margin, 400);
  const std::string replay = where + "\n" + oracle::replay(a) + oracle::replay(ma.pose(0)) +
                             oracle::replay(ma.pose(1)) + "\n" + oracle::replay(b) +
                             oracle::replay(mb.pose(0)) + oracle::replay(mb.pose(1));
  EXPECT_NE(result.status, ContactStatus::kInvalid) << replay;
  EXPECT_GE(s.first_touch, result.time.lower) << replay;  // certified free before
  if (result.status == ContactStatus::kContact) {
    Scratch scratch;
    const DistanceResult r =
        distance(a, ma.pose(result.time.upper), b, mb.pose(result.time.upper), {}, scratch);
    EXPECT_LE(r.distance.lower, margin + 1e-12) << replay;
    EXPECT_LE(result.time.width(), 1e-6 * (1 + 1e-9)) << replay;
  }
  return result.status == ContactStatus::kContact;
}

TEST(RigidMotion, EndsWhereItShouldAndMovesAsItSays) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Pose X0 = randomPose(random, 2);
    Pose X1 = randomPose(random, 2);
    if (i % 3 == 1) X1.rotation = X0.rotation;
    if (i % 3 == 2)
      X1.rotation = Eigen::AngleAxisd(std::pow(10.0, random.uniform(-13, 0.4)), random.direction())
                        .toRotationMatrix() *
                    X0.rotation;
    const StraightMotion straight(X0, X1);
    const ScrewMotion screw(X0, X1);
    for (const RigidMotion* m :
         {static_cast<const RigidMotion*>(&straight), static_cast<const RigidMotion*>(&screw)}) {
      EXPECT_LE((m->pose(0).translation - X0.translation).norm(), 1e-14);
      EXPECT_LE((m->pose(1).translation - X1.translation).norm(), 2e-12);
      EXPECT_LE((m->pose(1).rotation - X1.rotation).norm(), 4e-12);
      const FrameMotionBound bound = m->bound(0, 1);
      const double t = random.uniform(0.1, 0.9), h = 1e-4;
      const Pose before = m->pose(t - h), now = m->pose(t), after = m->pose(t + h);
      const FrameVelocity v = m->velocity(t);
      const Eigen::Vector3d p = random.direction();  // a point of the body
      const Eigen::Vector3d r = now.rotation * p;
      const Eigen::Vector3d speed = (after * p - before * p) / (2 * h);
      EXPECT_LE((speed - v.linear - v.angular.cross(r)).norm(), 1e-6);
      const double second = (after * p - 2 * (now * p) + before * p).norm() / (h * h);
      EXPECT_LE(second, bound.acceleration + bound.angular_acceleration +
                            bound.angular_speed * bound.angular_speed + 1e-5);
      EXPECT_LE(v.linear.norm(), bound.speed + 1e-12);
      EXPECT_LE(v.angular.norm(), bound.angular_speed + 1e-12);
    }
  }
}

TEST(RigidMotion, AScrewKeepsItsAxis) {
  // A quarter turn about the line x = 1, y = 0, rising by 2.
  const ScrewMotion screw(shifted(0, 0, 0),
                          turnedAbout(Eigen::Vector3d::UnitZ(), M_PI / 2, {1, -1, 2}));
  const Pose half = screw.pose(0.5);
  const double s = std::sqrt(0.5);
  EXPECT_NEAR(half.translation.x(), 1 - s, 1e-15);
  EXPECT_NEAR(half.translation.y(), -s, 1e-15);
  EXPECT_NEAR(half.translation.z(), 1, 1e-15);
  EXPECT_NEAR(screw.bound(0, 1).acceleration, M_PI * M_PI / 4, 1e-12);
}

/// LEEWAY_TEST_CONTACTS sets the number of cases, and LEEWAY_TEST_SEED selects other ones.
TEST(TimeOfContact, RandomMotionsOfAllShapes) {
  Random random(7 + fromEnvironment("LEEWAY_TEST_SEED", 0));
  Scratch scratch;
  int contacts = 0, frees = 0, undecided = 0;
  const ShapeType types[] = {ShapeType::kSphere,    ShapeType::kCapsule,    ShapeType::kBox,
                             ShapeType::kCylinder,  ShapeType::kCone,       ShapeType::kEllipsoid,
                             ShapeType::kHalfSpace, ShapeType::kConvexHull, ShapeType::kMesh};
  // All pairs of types at least once.
  const int cases =
      static_cast<int>(fromEnvironment("LEEWAY_TEST_CONTACTS", kSanitized ? 2 * 81 : 600));
  for (int i = 0; i < cases; ++i) {
    const Shape a = oracle::randomShape(random, types[i % 9], oracle::Flavour::kPlain);
    const Shape b = oracle::randomShape(random, types[(i / 9) % 9], oracle::Flavour::kPlain);
    if (a.type() == ShapeType::kHalfSpace && b.type() == ShapeType::kHalfSpace) continue;
    const Pose A0 = randomPose(random, 1.5), A1 = randomPose(random, 1.5);
    const Pose B0 = randomPose(random, 1.5), B1 = randomPose(random, 1.5);
    std::unique_ptr<RigidMotion> ma, mb;
    if (i % 2 == 0)
      ma = std::make_unique<StraightMotion>(A0, A1);
    else
      ma = std::make_unique<ScrewMotion>(A0, A1);
    if (i % 3 == 0)
      mb = std::make_unique<Still>(B0);
    else if (i % 3 == 1)
      mb = std::make_unique<ScrewMotion>(B0, B1);
    else
      mb = std::make_unique<StraightMotion>(B0, B1);
    ContactRequest request;
    request.margin = i % 4 == 0 ? 0.05 : 0;
    PairCache cache;
    const ContactResult result =
        timeOfContact(a, *ma, b, *mb, request, scratch, i % 5 == 0 ? nullptr : &cache);
    if (expectTrue(result, a, *ma, b, *mb, request.margin, "case " + std::to_string(i))) ++contacts;
    frees += result.status == ContactStatus::kFree;
    undecided += result.status == ContactStatus::kUndecided;
  }
  std::printf("%d times of contact: %d contacts, %d free, %d undecided\n",
              contacts + frees + undecided, contacts, frees, undecided);
  EXPECT_GT(contacts, cases / 4);
  EXPECT_GT(frees, cases / 10);
  EXPECT_EQ(undecided, 0);
}

TEST(TimeOfContact, GrazingHitsAndFrees) {
  Scratch scratch;
  const Shape box = Shape::box({0.2, 0.3, 0.1});
  for (const double clearance : {1e-4, 1e-6, -1e-6, -1e-4})
    for (const double spin : {0.0, 3.0}) {
      // The lower box is fixed; the upper one passes over it, turning about the vertical.
      const StraightMotion moving(
          shifted(-2, 0.05, 0.2 + clearance),
          turnedAbout(Eigen::Vector3d::UnitZ(), spin, {2, 0.05, 0.2 + clearance}));
      const Still still(shifted(0, 0, 0));
      const ContactResult result = timeOfContact(box, moving, box, still, {}, scratch);
      EXPECT_EQ(result.status, clearance > 0 ? ContactStatus::kFree : ContactStatus::kContact)
          << clearance << " " << spin << " queries " << result.queries;
      if (spin == 0 && clearance < 0) {
        EXPECT_NEAR(result.time.lower, 0.4, 2e-6);
      }
      // A corner on a circle that just reaches, or just misses, a wall.
      const double reach = std::hypot(0.2, 0.3);
      const StraightMotion turning(shifted(0, 0, 0),
                                   turnedAbout(Eigen::Vector3d::UnitZ(), 3, {0, 0, 0}));
      const Still wall(shifted(reach + 0.5 + clearance, 0, 0));
      const ContactResult touch =
          timeOfContact(box, turning, Shape::box({0.5, 1, 1}), wall, {}, scratch);
      EXPECT_EQ(touch.status, clearance > 0 ? ContactStatus::kFree : ContactStatus::kContact)
          << clearance << " queries " << touch.queries;
    }
}

TEST(TimeOfContact, StartsThinPlatesAndFastTurns) {
  Scratch scratch;
  const Shape box = Shape::box({0.2, 0.3, 0.1});
  const Still still(shifted(0, 0, 0));
  const StraightMotion away(shifted(0.3, 0, 0), shifted(3, 0, 0));
  const ContactResult inside = timeOfContact(box, away, box, still, {}, scratch);
  EXPECT_EQ(inside.status, ContactStatus::kContact);
  EXPECT_EQ(inside.time.lower, 0);
  EXPECT_EQ(inside.time.upper, 0);
  // Through an infinitely thin sheet in one step.
  const Shape sheet = Shape::box({1, 1, 0});
  const StraightMotion through(shifted(0, 0, -5), shifted(0.1, 0, 5));
  const ContactResult hit = timeOfContact(Shape::sphere(1e-3), through, sheet, still, {}, scratch);
  EXPECT_EQ(hit.status, ContactStatus::kContact);
  EXPECT_NEAR(hit.time.lower, 0.4999, 2e-6);
  // A rod that turns by almost half a turn hits a body that neither end pose approaches.
  const Shape rod = Shape::capsule(0.01, 1);
  const StraightMotion turning(shifted(0, 0, 0),
                               turnedAbout(Eigen::Vector3d::UnitY(), 3, {0, 0, 0}));
  const ContactResult swept =
      timeOfContact(rod, turning, Shape::sphere(0.01), Still(shifted(0.99, 0, 0)), {}, scratch);
  EXPECT_EQ(swept.status, ContactStatus::kContact);
  EXPECT_NEAR(swept.time.upper, (M_PI / 2 - 0.02) / 3, 1e-3);
}

TEST(TimeOfContact, FewLooksSufficeAndNoneIsTakenTwice) {
  // Regression: if a contact was expected exactly one tolerance after a certified time, it was
  // searched repeatedly, because t + tolerance - t is not the tolerance.
  Random random(5);
  Scratch scratch;
  const Shape box = Shape::box({0.2, 0.3, 0.1});
  int contacts = 0, queries = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose A0 = randomPose(random, 1), A1 = randomPose(random, 1);
    const StraightMotion moving(A0, A1);
    const ContactResult result =
        timeOfContact(box, moving, box, Still(randomPose(random, 0.3)), {}, scratch);
    EXPECT_LE(result.queries, 60) << i;
    EXPECT_NE(result.status, ContactStatus::kUndecided) << i;
    contacts += result.status == ContactStatus::kContact;
    queries += result.queries;
  }
  EXPECT_GT(contacts, 200);
  EXPECT_LE(queries, 500 * 8);
}

TEST(TimeOfContact, AllowedDepths) {
  Random random(13);
  Scratch scratch;
  int contacts = 0, frees = 0;
  const ShapeType types[] = {ShapeType::kSphere, ShapeType::kBox, ShapeType::kConvexHull,
                             ShapeType::kCylinder};
  for (int i = 0; i < 300; ++i) {
    const Shape a = oracle::randomShape(random, types[i % 4], oracle::Flavour::kPlain);
    const Shape b = oracle::randomShape(random, types[(i / 4) % 4], oracle::Flavour::kPlain);
    const Pose A0 = randomPose(random, 1), A1 = randomPose(random, 1);
    const StraightMotion ma(A0, A1);
    const Still mb(randomPose(random, 0.3));
    ContactRequest request;
    request.margin = -0.03;
    const ContactResult result = timeOfContact(a, ma, b, mb, request, scratch);
    if (expectTrue(result, a, ma, b, mb, request.margin, "case " + std::to_string(i))) ++contacts;
    frees += result.status == ContactStatus::kFree;
  }
  EXPECT_GT(contacts, 80);
  EXPECT_GT(frees, 40);
  EXPECT_EQ(contacts + frees, 300);
}

TEST(RigidMotion, AMountedFrameMovesAsItsBodyDoes) {
  Random random(17);
  for (int i = 0; i < 100; ++i) {
    const Pose X0 = randomPose(random, 2), X1 = randomPose(random, 2), X_BG = randomPose(random, 1);
    const ScrewMotion body(X0, X1);
    const MountedMotion mounted(body, X_BG);
    const double t = random.uniform(0.1, 0.9), h = 1e-4;
    const Eigen::Vector3d before = mounted.pose(t - h).translation,
                          now = mounted.pose(t).translation,
                          after = mounted.pose(t + h).translation;
    EXPECT_LE((mounted.pose(t).rotation - body.pose(t).rotation * X_BG.rotation).norm(), 1e-15);
    const FrameVelocity v = mounted.velocity(t);
    const FrameMotionBound bound = mounted.bound(0, 1);
    EXPECT_LE(((after - before) / (2 * h) - v.linear).norm(), 1e-6);
    EXPECT_LE(v.linear.norm(), bound.speed + 1e-12);
    EXPECT_LE((after - 2 * now + before).norm() / (h * h), bound.acceleration + 1e-5);
  }
}

TEST(TimeOfContact, SenselessRequestsAndPosesAreInvalid) {
  Scratch scratch;
  const Shape ball = Shape::sphere(1);
  const Still here(shifted(0, 0, 0)), there(shifted(5, 0, 0));
  const double nan = std::nan("");
  ContactRequest request;
  request.time_tolerance = 0;
  EXPECT_EQ(timeOfContact(ball, here, ball, there, request, scratch).status,
            ContactStatus::kInvalid);
  request = {};
  request.end = nan;
  EXPECT_EQ(timeOfContact(ball, here, ball, there, request, scratch).status,
            ContactStatus::kInvalid);
  request = {};
  EXPECT_EQ(timeOfContact(ball, Still(shifted(nan, 0, 0)), ball, there, request, scratch).status,
            ContactStatus::kInvalid);
  request.query_limit = 0;
  const ContactResult nothing = timeOfContact(ball, here, ball, there, request, scratch);
  EXPECT_EQ(nothing.status, ContactStatus::kUndecided);
  EXPECT_EQ(nothing.time.lower, 0);
}

/// Moves down to the origin at t = 0.5 and up again, without a guaranteed bound.
class Unpromised final : public RigidMotion {
 public:
  Pose pose(double t) const override { return shifted(0, 0, 4 * (t - 0.5) * (t - 0.5)); }
  FrameVelocity velocity(double t) const override { return {{0, 0, 8 * (t - 0.5)}, {0, 0, 0}}; }
  FrameMotionBound bound(double, double) const override {
    constexpr double kAny = std::numeric_limits<double>::infinity();
    return {kAny, kAny, 0, 0};
  }
  double rounding(double reach) const override { return 1e-14 * (1 + reach); }
};

// Regression: an unbounded acceleration counted as 0, and the motion as free.
TEST(TimeOfContact, NothingIsCertifiedWithoutABound) {
  Scratch scratch;
  ContactRequest request;
  request.query_limit = 200;
  for (const Shape& b : {Shape::sphere(0.1), Shape::box({0.1, 0.2, 0.3}), Shape::halfSpace()}) {
    const ContactResult result = timeOfContact(Shape::sphere(0.05), Unpromised(), b,
                                               Still(shifted(0, 0, 0)), request, scratch);
    EXPECT_NE(result.status, ContactStatus::kFree);
    EXPECT_LT(result.time.lower, 0.5);
  }
}

TEST(TimeOfContact, TrianglesOfDeformingMeshes) {
  Random random(11);
  Scratch scratch;
  int contacts = 0, frees = 0;
  const auto triangle = [&](double size, const Eigen::Vector3d& at) {
    std::array<Eigen::Vector3d, 3> p;
    for (Eigen::Vector3d& x : p) x = at + size * random.direction();
    return p;
  };
  const auto at = [](const MovingTriangle& m, double t) {
    std::vector<Eigen::Vector3d> p;
    for (std::size_t i = 0; i < 3; ++i) p.push_back((1 - t) * m.from[i] + t * m.to[i]);
    return Shape::convexHull(p);
  };
  const int cases = kSanitized ? 100 : 400;
  for (int i = 0; i < cases; ++i) {
    const Eigen::Vector3d there(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0);
    const MovingTriangle a{triangle(0.3, {-1, 0, 0}), triangle(0.3, {1, 0, 0})};
    const MovingTriangle b{triangle(0.3, there + Eigen::Vector3d(0, 0.3, 0)),
                           triangle(0.3, there - Eigen::Vector3d(0, 0.3, 0))};
    const bool shape = i % 3 == 0;
    const Shape cone = Shape::cone(0.3, 0.2);
    const Pose X_WB = randomPose(random, 0.4);
    const ContactResult result =
        shape ? timeOfContact(a, cone, X_WB, {}, scratch) : timeOfContact(a, b, {}, scratch);
    double first = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 300 && first > 1; ++k) {
      const double t = k / 300.0;
      const DistanceResult r = shape ? distance(at(a, t), Pose{}, cone, X_WB, {}, scratch)
                                     : distance(at(a, t), Pose{}, at(b, t), Pose{}, {}, scratch);
      if (r.distance.upper <= 0) first = t;
    }
    EXPECT_GE(first, result.time.lower) << i;
    if (result.status == ContactStatus::kContact) {
      ++contacts;
      EXPECT_LE(result.time.width(), 1.001e-6);
      const double t = result.time.upper;
      const DistanceResult r = shape ? distance(at(a, t), Pose{}, cone, X_WB, {}, scratch)
                                     : distance(at(a, t), Pose{}, at(b, t), Pose{}, {}, scratch);
      EXPECT_LE(r.distance.lower, 1e-12) << i;
    } else {
      EXPECT_EQ(result.status, ContactStatus::kFree) << i;
      ++frees;
    }
  }
  EXPECT_GT(contacts, cases / 5);
  EXPECT_GT(frees, cases / 10);
}

/// A corner and a face, or two edges, that meet at a known time, as triangles without area.
struct Crossing {
  MovingTriangle a, b;
  double t;
};

Crossing crossing(Random& random, bool corner, double t) {
  const auto point = [&] { return Eigen::Vector3d(random.direction()); };
  const Eigen::Vector3d a = point(), b = point(), c = point(), d = point();
  const double u = random.uniform(0.1, 0.5), v = random.uniform(0.1, 0.4);
  const Eigen::Vector3d face = a + u * (b - a) + v * (c - a), edge = a + u * (b - a);
  const auto moving = [&](const std::array<Eigen::Vector3d, 3>& at) {
    const Eigen::Vector3d travel = random.uniform(0.5, 2) * random.direction();
    MovingTriangle m;
    for (std::size_t i = 0; i < 3; ++i) {
      m.from[i] = at[i] - t * travel;
      m.to[i] = at[i] + (1 - t) * travel;
    }
    return m;
  };
  if (corner) return {moving({a, b, c}), moving({face, face, face}), t};
  return {moving({a, b, b}), moving({edge + v * d, edge - u * d, edge - u * d}), t};
}

// They are in contact for an instant, which cannot be proven under rounding. Regression: a fifth
// used all 10,000 queries next to it, because predictions used the fastest corner instead of the
// nearest point.
TEST(TimeOfContact, CornersAndEdgesThatCrossTakeFewLooks) {
  Random random(23);
  Scratch scratch;
  int queries = 0, proven = 0;
  const int cases = kSanitized ? 200 : 2000;
  for (int i = 0; i < cases; ++i) {
    // Some are at the very end.
    const Crossing c = crossing(random, i % 2 == 0, i % 5 == 0 ? 1 : random.uniform(0.1, 0.9));
    const ContactResult result = timeOfContact(c.a, c.b, {}, scratch);
    EXPECT_EQ(result.status, ContactStatus::kUndecided) << i;
    EXPECT_LE(result.time.lower, c.t + 1e-12) << i;
    EXPECT_GT(result.time.lower, c.t - 1e-6) << i;
    EXPECT_LE(result.queries, 60) << i;
    EXPECT_NEAR(result.distance.normal.norm(), 1, 1e-9) << i;
    queries += result.queries;
    // Within a margin above rounding, the contact lasts long enough.
    ContactRequest request;
    request.margin = 1e-12;
    const ContactResult near = timeOfContact(c.a, c.b, request, scratch);
    EXPECT_NE(near.status, ContactStatus::kFree) << i;
    EXPECT_LE(near.queries, 60) << i;
    proven += near.status == ContactStatus::kContact;
  }
  EXPECT_LE(queries, 12 * cases);
  EXPECT_GT(proven, cases * 3 / 4);
}

TEST(TimeOfContact, ACornerFallsOnAFace) {
  // Vertex (0.2, 0.1, 1) falls to z = -1 through a triangle at rest in z = 0.
  const Eigen::Vector3d a(-1, -1, 0), b(2, -1, 0), c(-1, 2, 0), from(0.2, 0.1, 1), to(0.2, 0.1, -1);
  const MovingTriangle face{{a, b, c}, {a, b, c}}, corner{{from, from, from}, {to, to, to}};
  Scratch scratch;
  const ContactResult result = timeOfContact(face, corner, {}, scratch);
  EXPECT_EQ(result.status, ContactStatus::kUndecided);
  EXPECT_NEAR(result.time.lower, 0.5, 2.6e-7);
  EXPECT_LE(result.time.lower, 0.5);
  EXPECT_LE(result.queries, 12);
  EXPECT_LT((result.distance.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
}

TEST(TimeOfContact, TheFirstOfAScene) {
  SceneBuilder builder;
  std::vector<std::unique_ptr<RigidMotion>> motions;
  const auto add = [&](const char* name, const Shape& shape, const Pose& X0, const Pose& X1,
                       bool moving) {
    Body body;
    body.name = name;
    body.moving = moving;
    body.X_WB = X0;
    body.geometries.push_back({shape, shifted(0.1, 0, 0), ""});
    builder.add(body);
    motions.push_back(moving ? std::make_unique<StraightMotion>(X0, X1) : nullptr);
  };
  add("runner", Shape::sphere(0.1), shifted(0, 0, 0), shifted(4, 0, 0), true);
  add("far", Shape::sphere(0.1), shifted(3, 0, 0), {}, false);
  add("near", Shape::sphere(0.1), shifted(2, 0, 0), {}, false);
  add("aside", Shape::sphere(0.1), shifted(1, 1, 0), {}, false);
  builder.setMargin(0, 3, 0.05);
  const Scene scene = builder.build();
  Workspace workspace(scene);
  std::vector<const RigidMotion*> told;
  for (const auto& m : motions) told.push_back(m.get());
  ContactResult result = timeOfContact(scene, told, {}, workspace);
  ASSERT_EQ(result.status, ContactStatus::kContact);
  EXPECT_NEAR(result.time.upper, 0.45, 2e-6);
  EXPECT_EQ(scene.pairs()[static_cast<std::size_t>(result.pair)].body_b, 2);
  ContactRequest request;
  request.end = 0.4;
  EXPECT_EQ(timeOfContact(scene, told, request, workspace).status, ContactStatus::kFree);
  told.pop_back();
  EXPECT_EQ(timeOfContact(scene, told, {}, workspace).status, ContactStatus::kInvalid);
}

}  // namespace
}  // namespace leeway::collision
