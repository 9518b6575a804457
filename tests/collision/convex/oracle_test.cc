// The engine against the oracle: every pair of shapes, ordinary and hard.

#include "tools/truth/oracle/oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "leeway/collision/distance.h"
#include "tests/support/from_environment.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;
using oracle::Truth;

constexpr std::array<ShapeType, 9> kTypes = {
    ShapeType::kSphere,    ShapeType::kCapsule,    ShapeType::kBox,
    ShapeType::kCylinder,  ShapeType::kCone,       ShapeType::kEllipsoid,
    ShapeType::kHalfSpace, ShapeType::kConvexHull, ShapeType::kMesh};

struct Placed {
  Shape shape;
  Pose pose;
};

struct Counts {
  int cases = 0, unsafe = 0, overlapping = 0, near = 0, unconverged = 0;
};

/// Queries in every way a caller can. Intervals that miss the truth count as unsafe and are printed
/// for a replay.
class Examiner {
 public:
  explicit Examiner(const std::string& label) : label_(label) {}

  void examine(const Placed& a, const Placed& b) {
    const Truth truth = oracle::signedSeparation(a.shape, a.pose, b.shape, b.pose);
    const double size = std::min(oracle::sizeOf(a.shape), oracle::sizeOf(b.shape));
    ++counts.cases;
    if (truth.upper < 0) ++counts.overlapping;
    if (std::abs(truth.upper) < 0.05 * size) ++counts.near;

    const DistanceResult plain = ask(a, b, truth, {}, nullptr, "plain");
    // (Overlaps of meshes are only enclosed; touching may look like overlap.)
    const bool exact = a.shape.isConvex() && b.shape.isConvex();
    if (plain.status == DistanceStatus::kLimit && (exact || truth.lower > 1e-9))
      ++counts.unconverged;
    ask(b, a, truth, {}, nullptr, "swapped");
    DistanceRequest limited;
    for (const int limit : {0, 1, 3, 6}) {
      limited.iteration_limit = limit;
      limited.node_limit = 4 * limit;
      ask(a, b, truth, limited, nullptr, "limited");
    }
    DistanceRequest shallow;
    shallow.depth = false;
    ask(a, b, truth, shallow, nullptr, "without depth");
    for (const double offset : {-1e-3, -1e-7, 0.0, 1e-7, 1e-3})
      threshold(a, b, truth, truth.upper + offset * size);
    threshold(a, b, truth, 0);
    // A valid cache, one of another pair, and nonsense.
    PairCache cache;
    ask(a, b, truth, {}, &cache, "cold cache");
    ask(a, b, truth, {}, &cache, "warm cache");
    ask(b, a, truth, {}, &cache, "foreign cache");
    for (const int count : {-7, 3, 1 << 30}) {
      PairCache nonsense{{std::nan(""), 1e300, -HUGE_VAL},
                         count,
                         {1 << 30, 1 << 30, -5},
                         {1 << 30, -1, 1 << 30},
                         -5,
                         1 << 30,
                         1 << 30,
                         -9};
      ask(a, b, truth, {}, &nonsense, "nonsense in the cache");
    }
    witnesses(a, b, plain);
  }

  Counts counts;

 private:
  DistanceResult ask(const Placed& a, const Placed& b, const Truth& truth,
                     const DistanceRequest& request, PairCache* cache, const char* how) {
    const DistanceResult r = distance(a.shape, a.pose, b.shape, b.pose, request, scratch_, cache);
    const bool ordered = r.distance.lower <= r.distance.upper;  // false for NaN
    const bool holds =
        ordered && r.distance.lower <= truth.upper && r.distance.upper >= truth.lower;
    bool honest = true;
    switch (r.status) {
      case DistanceStatus::kConverged:
        honest = r.distance.width() <= (std::isnan(request.tolerance)
                                            ? defaultTolerance(a.shape, a.pose, b.shape, b.pose)
                                            : request.tolerance);
        break;
      case DistanceStatus::kAboveThreshold:
        honest = r.distance.lower > request.threshold;
        break;
      case DistanceStatus::kNotAboveThreshold:
        honest = r.distance.upper <= request.threshold;
        break;
      case DistanceStatus::kOverlap:
        honest = !request.depth && r.distance.upper <= 0;
        break;
      case DistanceStatus::kLimit:
        break;
      case DistanceStatus::kInvalid:
        honest = a.shape.type() == ShapeType::kHalfSpace && b.shape.type() == ShapeType::kHalfSpace;
        break;
    }
    if (holds && honest) return r;
    ++counts.unsafe;
    report(a, b, truth, r, how);
    return r;
  }

  void threshold(const Placed& a, const Placed& b, const Truth& truth, double value) {
    DistanceRequest request;
    request.threshold = value;
    ask(a, b, truth, request, nullptr, "threshold");
  }

  /// The distance of the witnesses, or the depth, is within the interval's width.
  void witnesses(const Placed& a, const Placed& b, const DistanceResult& r) {
    if (r.status != DistanceStatus::kConverged || r.distance.lower <= 0) return;
    const double length = (r.point_b - r.point_a).norm();
    const double rounding =
        1e-14 * (a.pose.translation.norm() + b.pose.translation.norm() + length);
    if (std::abs(length - r.distance.upper) <= r.distance.width() + rounding) return;
    ++counts.unsafe;
    report(a, b, {r.distance.lower, r.distance.upper, false}, r, "witness points");
  }

  void report(const Placed& a, const Placed& b, const Truth& truth, const DistanceResult& r,
              const char* how) {
    if (++reported_ > 3) return;
    ADD_FAILURE() << label_ << ", " << how << "\n  A " << oracle::replay(a.shape) << "\n    "
                  << oracle::replay(a.pose) << "\n  B " << oracle::replay(b.shape) << "\n    "
                  << oracle::replay(b.pose) << "\n  truth [" << testing::PrintToString(truth.lower)
                  << ", " << testing::PrintToString(truth.upper) << "] answer ["
                  << testing::PrintToString(r.distance.lower) << ", "
                  << testing::PrintToString(r.distance.upper) << "] status "
                  << static_cast<int>(r.status) << " |point_b - point_a| "
                  << testing::PrintToString((r.point_b - r.point_a).norm());
  }

  std::string label_;
  Scratch scratch_;
  int reported_ = 0;
};

/// A pose for B next to A, from deep inside to well apart; a third of them nearly touch, found with
/// the engine's own normal.
Pose beside(Random& random, const Placed& a, const Shape& b) {
  const double reach = oracle::sizeOf(a.shape) + oracle::sizeOf(b);
  Pose X;
  X.rotation = random.rotation();
  X.translation = a.pose.translation + reach * random.uniform(0, 1.2) * random.direction();
  if (!random.chance(0.35)) return X;
  Scratch scratch;
  const DistanceResult r = distance(a.shape, a.pose, b, X, {}, scratch);
  if (!std::isfinite(r.distance.upper)) return X;
  const double wanted =
      random.chance(0.3) ? 0
                         : reach * random.logUniform(1e-17, 1e-4) * (random.chance(0.5) ? 1 : -1);
  X.translation += (wanted - r.distance.upper) * r.normal;
  return X;
}

/// LEEWAY_TEST_SEED=N shifts every seed, for other cases in long runs.
std::uint64_t seed(std::uint64_t base, ShapeType a, ShapeType b) {
  return base + 16 * static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b) +
         100'000 * fromEnvironment("LEEWAY_TEST_SEED", 0);
}

std::string title(ShapeType a, ShapeType b) {
  return std::string(toString(a)) + " with " + toString(b);
}

/// Fewer cases for pairs on which the oracle takes long.
int casesFor(ShapeType a, ShapeType b) {
  const auto costly = [](ShapeType t) {
    return t == ShapeType::kMesh ? 4 : t == ShapeType::kConvexHull ? 2 : 1;
  };
  return casesToAsk(60 / (costly(a) * costly(b)) + 4);
}

TEST(Oracle, HoldsForEveryPairOfPlainShapes) {
  int cases = 0, overlapping = 0, near = 0;
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      if (type_b < type_a) continue;
      Random random(seed(1000, type_a, type_b));
      Examiner examiner(title(type_a, type_b));
      for (int i = 0; i < casesFor(type_a, type_b); ++i) {
        Placed a{oracle::randomShape(random, type_a, Flavour::kPlain), {}};
        Placed b{oracle::randomShape(random, type_b, Flavour::kPlain), {}};
        a.pose = {random.rotation(), random.direction()};
        b.pose = beside(random, a, b.shape);
        examiner.examine(a, b);
      }
      EXPECT_EQ(examiner.counts.unsafe, 0) << title(type_a, type_b);
      EXPECT_EQ(examiner.counts.unconverged, 0) << title(type_a, type_b);
      cases += examiner.counts.cases;
      overlapping += examiner.counts.overlapping;
      near += examiner.counts.near;
    }
  }
  // The cases are hard: many overlap, many nearly touch.
  EXPECT_GT(5 * overlapping, cases);
  EXPECT_GT(5 * near, cases);
}

TEST(Oracle, HoldsForHardShapes) {
  int cases = 0, overlapping = 0;
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      if (type_b < type_a) continue;
      Random random(seed(2000, type_a, type_b));
      Examiner examiner(title(type_a, type_b) + ", hard");
      for (const Flavour flavour_a : oracle::kFlavours) {
        for (const Flavour flavour_b : oracle::kFlavours) {
          if (random.chance(kSanitized ? 0.9 : 0.5)) continue;
          Placed a{oracle::randomShape(random, type_a, flavour_a), {}};
          Placed b{oracle::randomShape(random, type_b, flavour_b), {}};
          a.pose = {random.rotation(), random.direction() * (random.chance(0.2) ? 1e5 : 1.0)};
          b.pose = beside(random, a, b.shape);
          examiner.examine(a, b);
        }
      }
      EXPECT_EQ(examiner.counts.unsafe, 0) << title(type_a, type_b);
      cases += examiner.counts.cases;
      overlapping += examiner.counts.overlapping;
    }
  }
  EXPECT_GT(10 * overlapping, cases);
}

/// Parallel faces and axes, common centres, coaxial bodies, apexes that meet: unit rotations and
/// round numbers.
TEST(Oracle, HoldsForAlignedPlacements) {
  Eigen::Matrix3d quarter;
  quarter << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  Eigen::Matrix3d flip;
  flip << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const std::array<Eigen::Matrix3d, 3> rotations = {Eigen::Matrix3d::Identity(), quarter, flip};
  const auto make = [](ShapeType type) {
    Random random(7);
    switch (type) {
      case ShapeType::kSphere:
        return Shape::sphere(0.5);
      case ShapeType::kCapsule:
        return Shape::capsule(0.25, 0.5);
      case ShapeType::kBox:
        return Shape::box({0.5, 0.5, 0.5});
      case ShapeType::kCylinder:
        return Shape::cylinder(0.5, 0.5);
      case ShapeType::kCone:
        return Shape::cone(0.5, 0.5);
      case ShapeType::kEllipsoid:
        return Shape::ellipsoid({0.5, 0.25, 0.5});
      case ShapeType::kHalfSpace:
        return Shape::halfSpace();
      case ShapeType::kMesh:
        return Shape::mesh(oracle::boxMesh({0.5, 0.5, 0.5}));
      case ShapeType::kConvexHull:
      case ShapeType::kDeformable:
        break;
    }
    return Shape::convexHull(oracle::boxMesh({0.5, 0.5, 0.5})->vertices());
  };
  const int step = kSanitized ? 4 : 1;  // some of each pair, in turns
  int kind = 0, overlapping = 0;
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      if (type_b < type_a) continue;
      Examiner examiner(title(type_a, type_b) + ", aligned");
      const Placed a{make(type_a), {}};
      for (const Eigen::Matrix3d& R : rotations) {
        for (const Vector3d& t :
             {Vector3d(0, 0, 0), Vector3d(0, 0, 1), Vector3d(0, 0, 0.75), Vector3d(1, 0, 0),
              Vector3d(1, 1, 0), Vector3d(0, 0, 1 + 1e-12), Vector3d(0.125, 0, -1.5)})
          if (kind++ % step == 0) examiner.examine(a, {make(type_b), {R, t}});
      }
      EXPECT_EQ(examiner.counts.unsafe, 0) << title(type_a, type_b);
      overlapping += examiner.counts.overlapping;
    }
  }
  EXPECT_GT(overlapping, 100 / step);
}

/// The oracle gives the known answers; all other tests depend on it.
TEST(Oracle, AgreesWithClosedForms) {
  const Pose origin;
  const auto at = [](double x, double y, double z) {
    return Pose{Eigen::Matrix3d::Identity(), {x, y, z}};
  };
  const auto expect = [](const Truth& t, double value) {
    EXPECT_TRUE(t.has_value);
    EXPECT_LE(t.lower, value + 1e-15);
    EXPECT_GE(t.upper, value - 1e-15);
    EXPECT_LT(t.upper - t.lower, 1e-6);
  };
  const Shape ball = Shape::sphere(0.5), box = Shape::box({0.5, 0.5, 0.5}),
              cone = Shape::cone(1, 1);
  expect(oracle::signedSeparation(ball, origin, ball, at(3, 4, 0)), 4);
  expect(oracle::signedSeparation(ball, origin, ball, origin), -1);
  expect(oracle::signedSeparation(box, origin, box, at(0.25, 0.125, 0)), -0.75);
  expect(oracle::signedSeparation(box, origin, box, at(2, 2, 2)), std::sqrt(3.0));
  expect(oracle::signedSeparation(box, origin, Shape::halfSpace(), at(0, 0, -1)), 0.5);
  expect(oracle::signedSeparation(cone, origin, ball, at(0, 0, 2)), 0.5);
  // Next to the cone's slope, whose distance from the axis point (0, 0, 1) - the apex - is |x| 2 /
  // sqrt 5.
  expect(oracle::signedSeparation(cone, origin, Shape::sphere(0), at(1, 0, 1)), 2 / std::sqrt(5.0));
  expect(
      oracle::signedSeparation(Shape::ellipsoid({1, 2, 3}), origin, Shape::sphere(0), at(0, 5, 0)),
      3);
  expect(oracle::signedSeparation(Shape::ellipsoid({1, 2, 3}), origin, Shape::sphere(0), origin),
         -1);
  expect(
      oracle::signedSeparation(Shape::cylinder(1, 2), origin, Shape::cylinder(1, 2), at(0, 0, 3.5)),
      -0.5);
  const Shape solid = Shape::mesh(oracle::ellMesh(3));
  expect(oracle::signedSeparation(solid, origin, ball, at(2, 2, 0)), 0.5);  // in the L's notch
  EXPECT_LE(oracle::signedSeparation(solid, origin, Shape::sphere(0.01), at(0.5, 0.5, 0)).upper,
            -0.5);  // inside
}

/// A search that ends early has proven the answer that was passed to it; for a wrong answer, the
/// search runs to its end.
TEST(Oracle, EndsEarlyOnlyWhereThatProvesTheAnswer) {
  Random random(17);
  int early = 0, overlapping = 0;
  for (int i = 0; i < (kSanitized ? 30 : 600); ++i) {
    const auto type = [&] { return kTypes[static_cast<std::size_t>(random.below(8))]; };
    // These include slivers, whose facets prove less than their planes suggest.
    const Flavour flavour = i % 3 == 0   ? Flavour::kThin
                            : i % 3 == 1 ? Flavour::kZero
                                         : Flavour::kPlain;
    const Shape a = oracle::randomShape(random, type(), flavour),
                b = oracle::randomShape(random, type(), flavour);
    const double apart = random.chance(0.5) ? random.logUniform(1e-7, 1e-2) : 1.5;
    const Pose X_WA{random.rotation(), Vector3d::Zero()},
        X_WB{random.rotation(), random.uniform(0, apart) * random.direction()};
    const Truth full = oracle::signedSeparation(a, X_WA, b, X_WB);
    if (!full.has_value) continue;
    if (full.upper < 0) ++overlapping;
    const double width = random.logUniform(1e-6, 1) * std::abs(full.upper);
    const oracle::Enough right{full.lower - width, full.upper + width};
    const Truth soon = oracle::convexSeparation(a, X_WA, b, X_WB, right);
    EXPECT_GE(soon.lower, right.lower) << i;
    EXPECT_LE(soon.upper, right.upper) << i;
    EXPECT_LE(soon.lower, full.upper) << i;
    EXPECT_GE(soon.upper, full.lower) << i;
    if (soon.upper - soon.lower > full.upper - full.lower) ++early;
    for (const oracle::Enough& wrong : {oracle::Enough{full.upper + 1e-9, full.upper + 1},
                                        oracle::Enough{full.lower - 1, full.lower - 1e-9}}) {
      const Truth late = oracle::convexSeparation(a, X_WA, b, X_WB, wrong);
      EXPECT_EQ(late.lower, full.lower) << i;
      EXPECT_EQ(late.upper, full.upper) << i;
    }
  }
  EXPECT_GT(early, kSanitized ? 2 : 20);
  EXPECT_GT(overlapping, kSanitized ? 2 : 20);
}

/// Two needles whose tips touch: all facets near the origin are slivers. Regression: the surface
/// left the origin outside, and a depth of 1.17e-13 was claimed although a plane leaves 1.05e-14.
TEST(Oracle, NeedlesWhoseTipsTouch) {
  const Shape needle =
      Shape::ellipsoid({0.45889676626796294, 3.5908188255363874e-07, 7.5520416494432564e-07});
  const Shape spike = Shape::cone(8.9623425986547928e-07, 0.54894594129677066);
  Pose X_WA, X_WB;
  X_WA.rotation << 0.75685621372367518, 0.61586757104923195, 0.21880540824618955,
      0.63484453165509314, -0.61315143252695448, -0.47012524014114443, -0.1553740402238673,
      0.49472462615081381, -0.85504763136590789;
  X_WA.translation = {-0.084779052745395642, 0.6920863752154307, 0.7168186391666721};
  X_WB.rotation << 0.0057822950626031933, 0.94536956517068638, 0.32594930635421882,
      -0.10027584043042848, 0.32485994947908869, -0.94043116125020831, -0.9949428731790485,
      -0.027246990171969188, 0.09667616374674981;
  X_WB.translation = {0.083611267470457162, 1.4996603469121483, 0.59244800683683851};
  const Truth truth = oracle::signedSeparation(needle, X_WA, spike, X_WB);
  EXPECT_LE(truth.lower, truth.upper);
  EXPECT_GE(truth.upper, -1.0480379079e-14);  // that plane, evaluated separately
}

/// A core of 1e-9 deep in a cylinder. Regression: rounding tore the polytope's surface where its
/// facets are slivers, and no depth was proven.
TEST(Oracle, KnowsHowDeepASpeckLies) {
  const std::array<Vector3d, 3> points = {
      Vector3d(0, 0, 0),
      Vector3d(-5.296006262073093e-10, -4.943402816475169e-10, 6.893118761935555e-10),
      Vector3d(5.1637984630306047e-10, 1.9984380293118475e-11, -8.5612643860374268e-10)};
  Pose X_WP, X_WC;
  X_WP.rotation << 0.88449382500865914, 0.41737726699287503, 0.20848714713168703,
      0.13643956537195423, -0.65873274542037641, 0.73990230105875854, 0.44615571107256224,
      -0.62599312065588386, -0.63959181855996605;
  X_WP.translation = {0.086698081913696295, -0.037395334005215441, -0.032939817654692442};
  X_WC.rotation << 0.41342980356564052, -0.84784333688182256, 0.33202029098953045,
      0.49737657040554373, 0.5157188659770231, 0.69760346794363959, -0.76268758003214865,
      -0.12327095108122521, 0.63491096059544838;
  const Truth cylinder = oracle::signedSeparation(Shape::convexHull(points), X_WP,
                                                  Shape::cylinder(0.431, 0.480), X_WC);
  EXPECT_NEAR(cylinder.lower, -0.3326730072917743, 1e-12);
  EXPECT_NEAR(cylinder.upper, -0.3326730072917743, 1e-12);
  // Specks of 1e-12 to 1e-6 all over a cylinder and a cone: the depth of their first point, up to
  // their size.
  Random random(51);
  for (int i = 0; i < 60; ++i) {
    const double size = random.logUniform(2e-9, 1e-6);
    const std::array<Vector3d, 3> speck = {Vector3d(0, 0, 0), size * random.direction(),
                                           size * random.direction()};
    const Shape round = i % 2 == 0 ? Shape::cone(0.431, 0.480) : Shape::cylinder(0.431, 0.480);
    const Pose X_WR{random.rotation(), Vector3d::Zero()};
    const Vector3d p = 0.1 * random.direction() - Vector3d(0, 0, i % 2 == 0 ? 0.25 : 0);
    const Pose X_WS{random.rotation(), X_WR.rotation * p};
    const Truth truth = oracle::signedSeparation(Shape::convexHull(speck), X_WS, round, X_WR);
    const double across = std::hypot(p.x(), p.y()), slant = std::hypot(0.96, 0.431);
    const double beside =
        i % 2 == 0 ? -(across * 0.96 + (p.z() - 0.480) * 0.431) / slant : 0.431 - across;
    const double depth = std::min({beside, p.z() + 0.480, i % 2 == 0 ? HUGE_VAL : 0.480 - p.z()});
    EXPECT_NEAR(truth.lower, -depth, 2 * size) << i;
    EXPECT_NEAR(truth.upper, -depth, 2 * size) << i;
  }
}

/// Sizes with a ratio of 1e9: the oracle's answer may be wide, but must agree.
TEST(Oracle, SaysNothingContradictoryOfSizesFarApart) {
  const Shape cone = Shape::cone(1.014892578125, 1.0000000000000002);
  Pose X_WA, X_WB;
  X_WA.rotation << -0.14884602850117057, 0.52107960773857143, -0.84042899890380118,
      0.92486593784256221, -0.22741682220839632, -0.30480253607086794, -0.34995407815601576,
      -0.82265280123248319, -0.44807868930169192;
  X_WA.translation << -0.89984130859375, 1.34625244140625, -0.927490234375;
  X_WB.rotation << -0.46110832317728856, 0.60642339952684776, 0.6477883719263029,
      0.47429923291992249, 0.78543264750161301, -0.39766291490429417, -0.74994623270485339,
      0.12387984801777907, -0.6497956842784427;
  X_WB.translation << 0.3643798828125, 1.56103515625, 0.653076171875;
  const oracle::Truth deep = oracle::signedSeparation(
      cone, X_WA, Shape::ellipsoid({1.44781494140625, 0.3011474609375, 1e9}), X_WB);
  EXPECT_LE(deep.lower, deep.upper);
  EXPECT_LE(deep.lower, -0.1);
}

}  // namespace
}  // namespace leeway::collision
