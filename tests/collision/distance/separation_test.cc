#include "leeway/collision/separation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/distance/nearest_in_half_spaces.h"
#include "leeway/collision/distance.h"
#include "tests/support/allocations.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

constexpr double kPi = 3.14159265358979323846;

struct Case {
  std::vector<PlacedShape> body, obstacles;
};

// Minimum upper and lower ends over all pairs at a translation.
Interval apart(const Case& c, const Vector3d& t, Scratch& scratch) {
  Interval all{kInfinity, kInfinity};
  DistanceRequest request;
  request.depth = false;
  for (const PlacedShape& a : c.obstacles) {
    for (const PlacedShape& b : c.body) {
      Pose moved = b.X_WS;
      moved.translation += t;
      const Interval d = distance(*a.shape, a.X_WS, *b.shape, moved, request, scratch).distance;
      all.lower = std::min(all.lower, d.lower);
      all.upper = std::min(all.upper, d.upper);
    }
  }
  return all;
}

// Slow twin: directions all around, each marched outwards in small steps and then bisected.
double brute(const Case& c, double clearance, double far, int directions, int steps,
             Scratch& scratch) {
  double best = far;
  for (int i = 0; i < directions; ++i) {
    const double z = 1 - (2 * i + 1.0) / directions, r = std::sqrt(1 - z * z),
                 a = kPi * (1 + std::sqrt(5.0)) * i;
    const Vector3d d(r * std::cos(a), r * std::sin(a), z);
    const double step = far / steps;
    for (double s = step; s < best; s += step) {
      if (!(apart(c, s * d, scratch).lower > clearance)) continue;
      double fails = s - step, good = s;
      for (int k = 0; k < 20; ++k) {
        const double middle = 0.5 * (fails + good);
        (apart(c, middle * d, scratch).lower > clearance ? good : fails) = middle;
      }
      best = good;
      break;
    }
  }
  return best;
}

std::string show(const SeparationResult& r) {
  std::ostringstream out;
  out.precision(17);
  out << "status " << static_cast<int>(r.status) << " translation " << r.translation.transpose()
      << " length " << r.translation.norm() << " clearance " << r.clearance << " least " << r.least
      << " queries " << r.queries;
  return out.str();
}

// Invariants of every answer.
void expectSound(const Case& c, const SeparationRequest& request, const SeparationResult& r,
                 Scratch& scratch, const std::string& what) {
  const std::string text = what + ": " + show(r);
  if (r.status == SeparationStatus::kApart) {
    EXPECT_TRUE(r.translation.isZero(0)) << text;
  }
  if (r.status == SeparationStatus::kApart || r.status == SeparationStatus::kSeparated) {
    EXPECT_GT(r.clearance, request.clearance) << text;
    EXPECT_GE(apart(c, r.translation, scratch).upper, r.clearance - 1e-12) << text;
    EXPECT_GE(r.translation.norm(), r.least) << text;
    EXPECT_LE(r.translation.norm(), request.longest) << text;
  }
  EXPECT_LE(r.queries,
            request.query_limit + 2 * static_cast<int>(c.body.size() * c.obstacles.size()))
      << text;
}

TEST(Separation, OfTwoConvexShapesIsTheDepth) {
  Random random(61);
  Scratch scratch;
  const auto shapes = sampleConvexShapes(random);
  int overlapping = 0, separate = 0;
  for (const auto& [name_a, a] : shapes) {
    for (const auto& [name_b, b] : shapes) {
      if (a.type() == ShapeType::kHalfSpace && b.type() == ShapeType::kHalfSpace) continue;
      for (int i = 0; i < 6; ++i) {
        const Pose X_WA = random.pose(0.2), X_WB = random.pose(0.3);
        SeparationRequest request;
        request.clearance = i % 2 == 0 ? 0 : 0.02;
        const SeparationResult r = separation(a, X_WA, b, X_WB, request, scratch);
        const Case c{{{&b, X_WB}}, {{&a, X_WA}}};
        const std::string what = name_a + " and " + name_b + " " + std::to_string(i);
        expectSound(c, request, r, scratch, what);
        const Interval d = distance(a, X_WA, b, X_WB, {}, scratch).distance;
        if (d.lower > request.clearance) {
          ++separate;
          EXPECT_EQ(r.status, SeparationStatus::kApart) << what << " " << show(r);
          continue;
        }
        ++overlapping;
        EXPECT_EQ(r.status, SeparationStatus::kSeparated) << what << " " << show(r);
        EXPECT_LE(r.translation.norm(), request.clearance - d.lower + 1e-6) << what << show(r);
      }
    }
  }
  EXPECT_GT(overlapping, 200);
  EXPECT_GT(separate, 20);
}

TEST(Separation, FromSeveralObstaclesIsNearTheShortest) {
  Random random(62);
  Scratch scratch;
  const auto shapes = sampleConvexShapes(random);
  int separated = 0;
  double worst = 0, sum = 0;
  const int cases = kSanitized ? 10 : 30;
  for (int i = 0; i < cases; ++i) {
    Case c;
    for (int k = 0; k < 1 + i % 3; ++k) {
      c.body.push_back(
          {&shapes[static_cast<std::size_t>(random.below(8))].second, random.pose(0.15)});
    }
    for (int k = 0; k < 2 + i % 4; ++k) {
      c.obstacles.push_back(
          {&shapes[static_cast<std::size_t>(random.below(i % 5 == 0 ? 9 : 8))].second,
           random.pose(0.3)});
    }
    SeparationRequest request;
    request.clearance = i % 2 == 0 ? 0 : 0.01;
    const SeparationResult r = separation(c.body, c.obstacles, request, scratch);
    const std::string what = "case " + std::to_string(i);
    expectSound(c, request, r, scratch, what);
    if (r.status != SeparationStatus::kSeparated) continue;
    ++separated;
    const double twin = brute(c, request.clearance, 1.2, 150, 60, scratch);
    EXPECT_GE(twin, r.least - 1e-9) << what << show(r);
    const double ratio = r.translation.norm() / twin;
    worst = std::max(worst, ratio);
    sum += ratio;
    EXPECT_LE(ratio, 1.1) << what << " twin " << twin << " " << show(r);
  }
  EXPECT_GT(separated, 2 * cases / 3);
  EXPECT_LT(sum, 1.0 * separated);  // the twin's directions are coarse
}

TEST(Separation, OfMeshesAgainstTheTwin) {
  Random random(63);
  Scratch scratch;
  const auto meshes = sampleMeshes(63);
  int separated = 0;
  const int cases = kSanitized ? 6 : 12;
  for (int i = 0; i < cases; ++i) {
    const Shape a = Shape::mesh(meshes[static_cast<std::size_t>(i % 5)].mesh),
                b = i % 3 == 0 ? Shape::box({0.1, 0.3, 0.05})
                               : Shape::mesh(meshes[static_cast<std::size_t>((i + 2) % 4)].mesh);
    const Pose X_WA = random.pose(0.1), X_WB = random.pose(0.5);
    const Case c{{{&b, X_WB}}, {{&a, X_WA}}};
    SeparationRequest request;
    request.tolerance = 1e-4;
    const SeparationResult r = separation(c.body, c.obstacles, request, scratch);
    const std::string what = meshes[static_cast<std::size_t>(i % 5)].name + " " + std::to_string(i);
    expectSound(c, request, r, scratch, what);
    if (r.status != SeparationStatus::kSeparated) continue;
    ++separated;
    const double twin = brute(c, 0, 2.5, 60, 25, scratch);
    EXPECT_LE(r.translation.norm(), 1.1 * twin) << what << " twin " << twin << " " << show(r);
    EXPECT_GE(twin, r.least - 1e-9) << what << show(r);
  }
  EXPECT_GT(separated, cases / 3);
}

TEST(Separation, OfSymmetricAndNestedBodies) {
  Scratch scratch;
  const Shape small = Shape::box({0.1, 0.1, 0.1}), big = Shape::box({0.5, 0.5, 0.5});
  const SeparationRequest request;
  SeparationResult r = separation(big, {}, small, {}, request, scratch);
  EXPECT_EQ(r.status, SeparationStatus::kSeparated);
  EXPECT_NEAR(r.translation.norm(), 0.6, 2e-6) << show(r);
  EXPECT_NEAR(r.least, 0.6, 1e-9) << show(r);
  r = separation(Shape::sphere(0.3), {}, Shape::sphere(0.2), {}, request, scratch);
  EXPECT_NEAR(r.translation.norm(), 0.5, 2e-6) << show(r);
  // A box at the centre of a closed mesh, far from the mesh's surface.
  const Shape mesh = Shape::mesh(named("box", boxSoup({0.5, 0.5, 0.5})).mesh);
  r = separation(mesh, {}, small, {}, request, scratch);
  EXPECT_EQ(r.status, SeparationStatus::kSeparated);
  EXPECT_NEAR(r.translation.norm(), 0.6, 1e-4) << show(r);
}

TEST(Separation, BetweenWalls) {
  Scratch scratch;
  const Shape body = Shape::box({0.1, 0.1, 0.1}), wall = Shape::box({0.1, 2, 1});
  Case c;
  c.body = {{&body, {}}};
  Pose left, right;
  left.translation.x() = -0.19;
  right.translation.x() = 0.19;
  c.obstacles = {{&wall, left}, {&wall, right}};
  // The gap is too narrow. The exits are next to the walls, past their ends in z, or over a wall in
  // x.
  SeparationRequest request;
  SeparationResult r = separation(c.body, c.obstacles, request, scratch);
  expectSound(c, request, r, scratch, "two walls");
  EXPECT_EQ(r.status, SeparationStatus::kSeparated);
  EXPECT_NEAR(r.translation.norm(), 0.39, 1e-5) << show(r);
  EXPECT_NEAR(r.least, 0.01, 1e-9) << show(r);
  // No way is short enough.
  request.longest = 0.3;
  r = separation(c.body, c.obstacles, request, scratch);
  EXPECT_EQ(r.status, SeparationStatus::kNotFound) << show(r);
  EXPECT_TRUE(r.translation.isZero(0));
  // Thick walls: exits past their ends.
  const Shape thick = Shape::box({3, 2, 1});
  left.translation.x() = -3.09;
  right.translation.x() = 3.09;
  c.obstacles = {{&thick, left}, {&thick, right}};
  request.longest = kInfinity;
  r = separation(c.body, c.obstacles, request, scratch);
  EXPECT_NEAR(r.translation.norm(), 1.1, 1e-5) << show(r);
  // Opposed half-spaces: no exit.
  const Shape ground = Shape::halfSpace();
  Pose below, above;
  below.translation.z() = -0.05;
  above.rotation = Eigen::AngleAxisd(kPi, Vector3d::UnitX()).toRotationMatrix();
  above.translation.z() = 0.05;
  c.obstacles = {{&ground, below}, {&ground, above}};
  r = separation(c.body, c.obstacles, request, scratch);
  EXPECT_EQ(r.status, SeparationStatus::kNotFound) << show(r);
  // A corner of three half-spaces pushes along the diagonal.
  Pose x, y;
  x.rotation = Eigen::AngleAxisd(kPi / 2, Vector3d::UnitY()).toRotationMatrix();
  y.rotation = Eigen::AngleAxisd(-kPi / 2, Vector3d::UnitX()).toRotationMatrix();
  c.obstacles = {{&ground, {}}, {&ground, x}, {&ground, y}};
  r = separation(c.body, c.obstacles, request, scratch);
  EXPECT_NEAR(r.translation.norm(), 0.1 * std::sqrt(3.0), 1e-5) << show(r);
}

// A rod touches a ring from inside: it returns to the middle instead of leaving the ring.
TEST(Separation, BackIntoTheHollow) {
  Random random(64);
  Scratch scratch;
  const Shape ring = Shape::mesh(named("torus", torusSoup(24, 10, 0.6, 0.2, 0, random)).mesh);
  const Shape rod = Shape::cylinder(0.1, 0.8);
  Pose X_WB;
  X_WB.translation = {0.31, 0.02, 0.1};
  SeparationRequest request;
  request.clearance = 0.01;
  const SeparationResult r = separation(ring, {}, rod, X_WB, request, scratch);
  EXPECT_EQ(r.status, SeparationStatus::kSeparated) << show(r);
  EXPECT_LT(r.translation.norm(), 0.05) << show(r);
  EXPECT_GT(r.translation.norm(), 0.01) << show(r);
}

TEST(Separation, LimitsAndBadInput) {
  Scratch scratch;
  const Shape box = Shape::box({0.1, 0.1, 0.1}), ground = Shape::halfSpace();
  SeparationRequest request;
  request.query_limit = 1;
  EXPECT_EQ(separation(box, {}, box, {}, request, scratch).status, SeparationStatus::kNotFound);
  request = {};
  EXPECT_EQ(separation(ground, {}, ground, {}, request, scratch).status,
            SeparationStatus::kInvalid);
  Pose bad;
  bad.translation.x() = std::nan("");
  EXPECT_EQ(separation(box, {}, box, bad, request, scratch).status, SeparationStatus::kInvalid);
  request.clearance = -1;
  EXPECT_EQ(separation(box, {}, box, {}, request, scratch).status, SeparationStatus::kInvalid);
  request.clearance = std::nan("");
  EXPECT_EQ(separation(box, {}, box, {}, request, scratch).status, SeparationStatus::kInvalid);
  request = {};
  request.tolerance = 0;
  EXPECT_EQ(separation(box, {}, box, {}, request, scratch).status, SeparationStatus::kInvalid);
  request = {};
  const PlacedShape none{nullptr, {}}, one{&box, {}};
  EXPECT_EQ(separation({&none, 1}, {&one, 1}, request, scratch).status, SeparationStatus::kInvalid);
  EXPECT_EQ(separation({}, {&one, 1}, request, scratch).status, SeparationStatus::kApart);
}

TEST(Separation, AllocatesNothing) {
  Random random(65);
  Scratch scratch;
  const auto meshes = sampleMeshes(65);
  const Shape mesh = Shape::mesh(meshes[3].mesh), box = Shape::box({0.2, 0.2, 0.2});
  const PlacedShape body[] = {{&mesh, random.pose(0.2)}, {&box, random.pose(0.2)}},
                    obstacles[] = {{&box, random.pose(0.2)}, {&mesh, random.pose(0.2)}};
  SeparationRequest request;
  request.tolerance = 1e-3;
  request.query_limit = 1000;
  const std::size_t before = allocationCount();
  separation(body, obstacles, request, scratch);
  EXPECT_EQ(allocationCount(), before);
}

TEST(NearestInHalfSpaces, AgainstSampling) {
  Random random(66);
  int found = 0, none = 0;
  for (int i = 0; i < 500; ++i) {
    PlaneHalfSpace spaces[8];
    const int count = 1 + random.below(8);
    for (int k = 0; k < count; ++k) spaces[k] = {random.direction(), random.uniform(-0.5, 1)};
    Vector3d point;
    const bool any = nearestInHalfSpaces(spaces, count, point);
    (any ? found : none) += 1;
    const auto holds = [&](const Vector3d& t, double doubt) {
      return std::all_of(spaces, spaces + count, [&](const PlaneHalfSpace& s) {
        return s.normal.dot(t) >= s.offset - doubt;
      });
    };
    if (any) {
      EXPECT_TRUE(holds(point, 1e-9 * (1 + point.norm())));
    }
    for (int k = 0; k < 300; ++k) {
      const Vector3d t = (any ? point.norm() : 3) * random.uniform(0, 1) * random.direction();
      if (any && t.norm() > point.norm() - 1e-6) continue;
      EXPECT_FALSE(holds(t, 0)) << i;
    }
  }
  EXPECT_GT(found, 100);
  EXPECT_GT(none, 10);
}

}  // namespace
}  // namespace leeway::collision
