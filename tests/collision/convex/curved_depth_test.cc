#include "collision/convex/round_depth/curved_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "collision/base/work.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tests/collision/convex/known_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;
using testing::hull;
using testing::known;
using testing::Known;
using testing::knownDepths;
using testing::Pair;
using testing::pose;

constexpr ShapeType kRound[] = {ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};
constexpr ShapeType kAny[] = {ShapeType::kCapsule, ShapeType::kBox, ShapeType::kCylinder,
                              ShapeType::kCone, ShapeType::kEllipsoid};

// The reach of a body along n, from its definition.
double most(const Shape& s, const Pose& X_WS, const Vector3d& n) {
  const Vector3d d = X_WS.rotation.transpose() * n;
  if (s.type() == ShapeType::kConvexHull) {
    double farthest = -std::numeric_limits<double>::infinity();
    for (const Vector3d& p : s.hull()->vertices()) farthest = std::max(farthest, d.dot(p));
    return farthest;
  }
  const Vector3d e = s.halfExtents();
  const double across = std::hypot(d.x(), d.y()), h = s.halfLength(), r = s.radius();
  switch (s.type()) {
    case ShapeType::kCapsule:
      return h * std::abs(d.z()) + r * d.norm();
    case ShapeType::kBox:
      return d.cwiseAbs().dot(e);
    case ShapeType::kCylinder:
      return h * std::abs(d.z()) + r * across;
    case ShapeType::kCone:
      return std::max(h * d.z(), r * across - h * d.z());
    default:
      return d.cwiseProduct(e).norm();
  }
}

double apartAlong(const Pair& pair, const Vector3d& n) {
  return n.dot(pair.X_WB.translation - pair.X_WA.translation) - most(pair.a, pair.X_WA, n) -
         most(pair.b, pair.X_WB, -n);
}

// Round bodies whose z axes (nearly) coincide, with nearly round sections: the depth is about the
// same all around.
Pair aroundOneAxis(Random& random) {
  const auto nearlyRound = [&](ShapeType type) {
    if (type != ShapeType::kEllipsoid || random.chance(0.3)) {
      return oracle::randomShape(random, type, Flavour::kPlain);
    }
    const double r = random.uniform(0.1, 0.5);
    return Shape::ellipsoid({r, r * (1 - random.logUniform(1e-12, 0.1)), random.uniform(0.1, 0.5)});
  };
  Pair pair{nearlyRound(kRound[random.below(3)]),
            nearlyRound(kAny[random.below(5)]),
            {random.rotation(), random.direction()},
            {}};
  const double tilt = random.chance(0.3) ? 0.0 : random.logUniform(1e-12, 0.3);
  Eigen::Matrix3d K;
  const Vector3d u = random.direction();
  K << 0, -u.z(), u.y(), u.z(), 0, -u.x(), -u.y(), u.x(), 0;
  const Eigen::Matrix3d turn =
      Eigen::Matrix3d::Identity() + std::sin(tilt) * K + (1 - std::cos(tilt)) * K * K;
  pair.X_WB.rotation = pair.X_WA.rotation * turn;
  pair.X_WB.translation =
      pair.X_WA.translation + pair.X_WA.rotation.col(2) * random.uniform(-0.1, 0.1);
  if (random.chance(0.7)) {
    pair.X_WB.translation += random.logUniform(1e-14, 0.1) * random.direction();
  }
  return pair;
}

void expectDeepAndNarrow(std::span<const Known> all,
                         int iteration_limit = testing::kThoroughLimit) {
  Scratch scratch;
  const auto step = bySanitizer<std::size_t>(1, 4, 8);
  for (std::size_t i = 0; i < all.size(); i += step) {
    const Known& one = all[i];
    const DistanceResult r = testing::expectNarrow(one, scratch, iteration_limit);
    EXPECT_LT(r.distance.upper, 0) << one.pair.replay();
    EXPECT_NEAR(apartAlong(one.pair, r.normal), r.distance.lower, 1e-9 + 1e-14 * one.size())
        << one.pair.replay();
  }
}

// Regression: long runs left these up to 2e-4 m wide.
TEST(CurvedDepth, PairsThatWereLeftOpenAreAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("pairs-that-were-left-open"));
}

// Regression: hulls close to round bodies stayed open, because cells ignored the hulls' vertices.
TEST(CurvedDepth, HullsInRoundBodiesAreAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("hulls-in-round-bodies"));
}

// Valleys all around an axis, where the bend changes within a cell. Regression: they needed more
// cells than a query has.
TEST(CurvedDepth, ValleyAroundAnAxisIsAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("valley-around-an-axis"));
}

// Parallel lines of two cones give a member in many ways. Regression: they needed more cells than a
// query has.
TEST(CurvedDepth, TwinsAreAsNarrowAsAsked) { expectDeepAndNarrow(knownDepths("twins")); }

// Regression: these stayed open, because nodes were chosen for an earlier, larger depth; descents
// backed off, or ended, before the nearest plane was found; directions were out of place by less
// than a unit in double.
TEST(CurvedDepth, EdgesAreProvenWhereTheirNearestPlaneWasFoundLate) {
  expectDeepAndNarrow(knownDepths("edges-are-proven-where-their-nearest-plane-was-found-late"));
}

// Sides parallel within 1e-13. Regression: the penalty that selects a member cost 4e-14.
TEST(CurvedDepth, EdgesThatAreAllButParallelAreAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("edges-that-are-all-but-parallel"));
}

// A needle whose width is a millionth of its length needs even narrower cells; one of width 0 is a
// segment.
TEST(CurvedDepth, NeedlesAreAsNarrowAsAsked) { expectDeepAndNarrow(knownDepths("needles")); }

// Regression: witnesses of two needles, known to 1e-10 along them, were reported 1.7e-14 too far
// apart.
TEST(CurvedDepth, PointsOfNeedlesAreAsFarApartAsTold) {
  const Known one =
      known(Shape::ellipsoid({0.56981488366792843, 5.9850671180047097e-07, 5.6920720047663588e-07}),
            pose({-0.48075693383531526, 0.44505737914080268, -0.75551088664663624,
                  0.73080015557679323, -0.27277519282806506, -0.6257194473456511,
                  -0.48456568510182541, -0.85294643644834589, -0.19410943658634139},
                 {-0.096097887404924462, 0.94042236514188748, -0.32614562878758457}),
            Shape::ellipsoid({0.56981488366792843, 5.9850671180047097e-07, 5.6920720047663588e-07}),
            pose({-0.39643826443434249, -0.87157132021931671, -0.28844433824127036,
                  -0.5240185751650408, -0.04315587874534943, 0.85061278088899994,
                  -0.7538177733207726, 0.48836564570091789, -0.43961091970609489},
                 {-0.16350576590222871, 0.75084240129158397, -0.48590820468070023}));
  Scratch scratch;
  const DistanceResult r = testing::expectNarrow(one, scratch);
  EXPECT_NEAR((r.point_b - r.point_a).norm(), r.distance.upper, r.distance.width() + 3e-15);
}

// A thin cylinder that nearly touches an edge of a flat triangle. Regression: too little stiffness
// blended in the triangle's far corner.
TEST(CurvedDepth, NeedleBesideATriangleIsAsNarrowAsAsked) {
  const Known one =
      known(hull({{0.077463448117133044, -0.94199100734402441, -1.8575296913736039e-09},
                  {0.082371254462768023, 0.89147696166807855, -3.0304273193898107e-07},
                  {0.61701349057423849, -0.70713690652389671, -1.1226238020355629e-07}}),
            pose({-0.30141790332449347, -0.82149832444371218, -0.48403279898333285,
                  -0.91527716768307443, 0.39156098594925648, -0.094592286157462124,
                  0.26723576458534737, 0.41451236075492309, -0.86992215106172877},
                 {0.74707492026913269, -0.56340151067355926, -0.3527857724960296}),
            Shape::cylinder(4.066694508594082e-07, 0.34245131967307024),
            pose({-0.82032132585581552, 0.56191558678511622, 0.10641332470182846,
                  0.5419698701838942, 0.82321845967515483, -0.16905628489623925,
                  -0.18259677477713337, -0.081007659995854797, -0.97984497593394138},
                 {0.84090921424308296, -1.1361647850696506, -0.66428378786995501}));
  Scratch scratch;
  const DistanceResult r = testing::expectNarrow(one, scratch);
  EXPECT_GT(r.distance.lower, 8e-10);
}

// A hull of seven nearly collinear vertices. Regression: no number of directions found the two
// vertices of the nearest edge.
TEST(CurvedDepth, HullsLikeNeedlesAreAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("hulls-like-needles"));
}

// Regression: the rounding of a ball's radius next to a depth was omitted.
TEST(CurvedDepth, BallsInEllipsoidsAreAsNarrowAsAsked) {
  const std::vector<Known> all = knownDepths("balls-in-ellipsoids");
  Scratch scratch;
  for (const Known& one : all) testing::expectNarrow(one, scratch);
}

// A needle over a disc's cap, whose nearest points GJK does not find.
TEST(CurvedDepth, NeedleOverADiscIsAsNarrowAsAsked) {
  const Known one =
      known(Shape::box({5.5715712679717971e-07, 0.38540117644874594, 4.8038930328817018e-07}),
            pose({0.61420317727520013, 0.78796372621250221, 0.043216006274966662,
                  0.67576158497042049, -0.49688176556192332, -0.54447662147270426,
                  -0.4075545819927856, 0.36362298775706448, -0.8376619756628032},
                 {0.076283734950715526, -0.99680802112671663, -0.023549114620473533}),
            Shape::cylinder(0.59556227998198408, 3.1331194571400749e-07),
            pose({0.37775433034567651, 0.89849888724153193, 0.22360996295071109,
                  0.70456015716405396, -0.4356331444156043, 0.56019527704501115,
                  0.60074674434577924, -0.054069521102947604, -0.79760882395171917},
                 {0.2986884647952549, -0.66869198630202276, 0.079749822683795796}));
  Scratch scratch;
  const DistanceResult r = testing::expectNarrow(one, scratch);
  EXPECT_GT(r.distance.lower, 1e-9);
}

// A ball's middle in a box: both ends include the rounding of closed forms.
TEST(CurvedDepth, BallInABoxIsAsNarrowAsAsked) {
  const std::vector<Known> all = knownDepths("ball-in-a-box");
  Scratch scratch;
  for (const Known& one : all) testing::expectNarrow(one, scratch);
}

// Two flat cones that touch at their apexes: a valley of a millionth's depth, all around.
TEST(CurvedDepth, ApexesAreAsNarrowAsAsked) { expectDeepAndNarrow(knownDepths("apexes")); }

// Regression: a cylinder of radius 0 got the rounding of a rim, more than the tolerance.
TEST(CurvedDepth, CylindersWithoutRadiusAreAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("cylinders-without-radius"));
}

// The corner of a hull at and next to the middle of a cone: a face of the cone and an edge of the
// hull are chosen together, all around the axis. Regression: up to 7e-7 m wide.
TEST(CurvedDepth, CornersInTheMiddleOfAConeAreAsNarrowAsAsked) {
  constexpr double kCos = 0.76484218728448842, kSin = 0.64421768723769102;  // of 0.7
  const Shape corner = hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  for (const double half_length : {0.15, 0.3}) {
    for (const double beside : {0.0, 1e-12, 1e-6}) {
      if (isBrief() && beside > 0) continue;
      {
        const Known all[] = {known(
            Shape::cone(0.2, half_length), Pose{}, corner,
            pose({1, 0, 0, 0, kCos, -kSin, 0, kSin, kCos}, {beside, 0.3 * beside, -0.5 * beside}))};
        expectDeepAndNarrow(all);
      }
    }
  }
}

// The middles of round bodies: caps as near as rims, whose arms must not shift other pieces; cells
// that became flat instead of small; nearly parallel pieces. Regression: up to 5e-6 of their sizes
// wide.
TEST(CurvedDepth, PlacesInTheMiddleOfRoundBodiesAreAsNarrowAsAsked) {
  expectDeepAndNarrow(knownDepths("places-in-the-middle-of-round-bodies"));
}

// The middle of a ball at a cone's apex, up to rounding. Regression: the normal was a direction
// across the axis, along which the cone reaches beyond its apex.
TEST(CurvedDepth, NormalOfABallAtAnApexProvesTheLowerEnd) {
  const std::vector<Known> all = knownDepths("normal-of-a-ball-at-an-apex-proves-the-lower-end");
  expectDeepAndNarrow(all);
  Scratch scratch;
  for (const Known& one : all) {
    Pair pair = one.pair;
    const double radius = pair.b.halfExtents().x();
    pair.b = Shape::sphere(radius);
    const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch);
    const Known given{{pair.a, one.pair.b, pair.X_WA, pair.X_WB}};
    EXPECT_NEAR(apartAlong(given.pair, r.normal), r.distance.lower, 1e-13) << pair.replay();
  }
}

// Regression: a step along a tiny way without a direction gave a plane through the origin, and the
// lower end was above the upper one.
TEST(CurvedDepth, DirectionThatIsLostIsNoPlane) {
  expectDeepAndNarrow(knownDepths("direction-that-is-lost-is-no-plane"));
}

// offerCurvedDepth() alone against many planes, most of them close to the nearest one.
TEST(CurvedDepth, NoPlaneSeparatesByLess) {
  Random random(91);
  Scratch scratch;
  int answered = 0, asked = 0;
  for (int i = 0; i < casesToAsk(300); ++i) {
    const Pair pair = aroundOneAxis(random);
    const RelativePose relative = relativePose(pair.X_WA, pair.X_WB);
    ASSERT_TRUE(relative.valid);
    const ConvexView a = viewOf(pair.a), b = viewOf(pair.b);
    ASSERT_TRUE(haveCurvedDepth(a, b));
    CoreQuery query;
    query.request.iteration_limit = testing::kThoroughLimit;
    const double size = a.extent + b.extent + relative.X_BA.translation.norm();
    query.roundoff = kUnitRoundoff * size;
    query.upper_offset = -kSupportRounding * query.roundoff;
    query.lower_offset = -query.upper_offset;
    Progress progress(query);
    Difference<false> difference(a, b, relative.X_BA, relative.X_BA);
    // Any plane to start from.
    const Vector3d start = random.direction();
    SupportPoint s;
    difference.support(start, s);
    progress.offerLower(start.dot(s.w), start);
    if (!(progress.lower() < 0)) continue;
    ++asked;
    if (!offerCurvedDepth(difference, progress)) continue;
    ++answered;
    EXPECT_LE(progress.upper() - progress.lower(), 1e-9) << pair.replay();
    const Pair bodies{pair.a, pair.b, relative.X_BA, {}};
    const double radii = a.radius + b.radius, rounding = 1e-15 * size;
    const auto apart = [&](const Vector3d& n) { return apartAlong(bodies, n) + radii; };
    EXPECT_NEAR(apart(progress.normal()), progress.lower(), 1e-13 * size) << pair.replay();
    // The witness is a point of the difference that lies along the plane's normal.
    EXPECT_NEAR(progress.witnessW().norm(), -progress.upper(), 1e-6) << pair.replay();
    const Vector3d axes[2] = {bodies.X_WA.rotation.col(2), Vector3d::UnitZ()};
    for (int k = 0; k < 400; ++k) {
      const Vector3d axis = axes[k % 2], n = progress.normal();
      const double angle = random.uniform(0, 6.3), along = n.dot(axis);
      Vector3d here =
          along * axis + std::cos(angle) * (n - along * axis) + std::sin(angle) * cross(axis, n);
      if (k >= 200) here += random.logUniform(1e-10, k < 350 ? 1e-2 : 1) * random.direction();
      here.normalize();
      EXPECT_LE(apart(here), progress.upper() + rounding) << pair.replay();
    }
  }
  EXPECT_GT(10 * asked, 8 * casesToAsk(300));
  EXPECT_GT(100 * answered, 85 * asked);
}

// Pairs without a round body, and triangles, are rejected.
TEST(CurvedDepth, SpeaksOfRoundBodiesOnly) {
  const Shape cone = Shape::cone(0.2, 0.3), box = Shape::box({0.1, 0.2, 0.3});
  const Shape capsule = Shape::capsule(0.1, 0.2);
  const Vector3d corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Shape hull = Shape::convexHull(corners);
  EXPECT_TRUE(haveCurvedDepth(viewOf(cone), viewOf(box)));
  EXPECT_TRUE(haveCurvedDepth(viewOf(capsule), viewOf(cone)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(capsule), viewOf(box)));
  EXPECT_TRUE(haveCurvedDepth(viewOf(cone), viewOf(hull)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(box), viewOf(hull)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(cone), viewOfPoints(corners, 3, 0)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(cone), viewOf(Shape::halfSpace())));
}

// A default query ends within a millisecond, counted as Work, and contains the exact depth even if
// it stays wide: pairs that earlier versions left open, and bodies about one axis.
TEST(CurvedDepth, DefaultQueryEndsWithinAMillisecond) {
  constexpr std::int64_t kMillisecond = 1'000'000;
  Scratch scratch;
  int wide = 0;
  const auto ask = [&](const Pair& pair) {
    Work work;
    countInto(scratch, work);
    const DistanceResult d = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch);
    EXPECT_LE(work.done, kMillisecond) << pair.replay();
    if (d.status == DistanceStatus::kConverged) return;
    ++wide;
    // (The other tests compare the thorough answer with the truth.)
    DistanceRequest thorough;
    thorough.iteration_limit = testing::kThoroughLimit;
    const Interval truth =
        distance(pair.a, pair.X_WA, pair.b, pair.X_WB, thorough, scratch).distance;
    EXPECT_EQ(d.status, DistanceStatus::kLimit) << pair.replay();
    EXPECT_LE(d.distance.lower, truth.upper) << pair.replay();
    EXPECT_GE(d.distance.upper, truth.lower) << pair.replay();
    EXPECT_LE(d.distance.width(), 1e-3) << pair.replay();
  };
  for (const char* family : {"pairs-that-were-left-open", "places-in-the-middle-of-round-bodies",
                             "direction-that-is-lost-is-no-plane"}) {
    const std::vector<Known> all = knownDepths(family);
    for (std::size_t i = 0; i < all.size(); i += bySanitizer<std::size_t>(1, 4, 8))
      ask(all[i].pair);
  }
  EXPECT_GT(wide, 0);
  Random random(93);
  for (int i = 0; i < bySanitizer(300, 30, 10); ++i) ask(aroundOneAxis(random));
}

// Any limit of steps leaves a valid interval, and kLimit if it is the reason for the width.
TEST(CurvedDepth, LimitOfIterationsIsKept) {
  const Pair pair{
      Shape::cylinder(0.18164841456287673, 0.23501608476186989),
      Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
      pose({0.90775476176749459, 0.11670750550549758, -0.40294000874463104, -0.41909017006193416,
            0.20978311432815999, -0.88337674539249511, -0.01856668645445847, 0.97075764385425389,
            0.23934258929960506},
           {0.015739734995687545, 0.081883553226797481, 0.99651760870203376}),
      pose({0.078884827231271465, -0.91182045019047953, -0.40294000874463159, 0.22701725309560883,
            0.41001060046868032, -0.88337674539249467, 0.97069065660982679, -0.021789312007117013,
            0.23934258929960575},
           {-0.044390858166987957, -0.049942442042460525, 1.0322346175652486})};
  const oracle::Truth truth = oracle::signedSeparation(pair.a, pair.X_WA, pair.b, pair.X_WB);
  Scratch scratch;
  int stopped = 0, converged = 0;
  for (const int limit : {1, 8, 63, 64, 70, 100, 256, 1000, 10000}) {
    DistanceRequest request;
    request.iteration_limit = limit;
    for (const double tolerance : {1e-9, 1e-12, 1.1e-14}) {
      request.tolerance = tolerance;
      const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch);
      EXPECT_LE(r.distance.lower, truth.upper) << limit;
      EXPECT_GE(r.distance.upper, truth.lower) << limit;
      EXPECT_LE(r.iterations, 2 * limit + 8) << tolerance;  // plus the last descent
      const bool narrow = r.distance.width() <= tolerance;
      EXPECT_EQ(r.status, narrow ? DistanceStatus::kConverged : DistanceStatus::kLimit);
      narrow ? ++converged : ++stopped;
    }
  }
  EXPECT_GT(stopped, 3);
  EXPECT_GT(converged, 3);
}

// Swapped bodies have the same depth.
TEST(CurvedDepth, SwappedIsTheSame) {
  Random random(92);
  Scratch scratch;
  DistanceRequest request;
  request.iteration_limit = testing::kThoroughLimit;
  for (int i = 0; i < bySanitizer(300, 30, 10); ++i) {
    const Pair pair = aroundOneAxis(random);
    const Interval d = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch).distance;
    const Interval e = distance(pair.b, pair.X_WB, pair.a, pair.X_WA, request, scratch).distance;
    EXPECT_LE(d.width(), 1e-9) << pair.replay();
    EXPECT_LE(e.width(), 1e-9) << pair.replay();
    EXPECT_LE(d.lower, e.upper) << pair.replay();
    EXPECT_LE(e.lower, d.upper) << pair.replay();
  }
}

// Enough for needles whose width is a thousandth of their length: the default limit leaves some a
// millionth of their sizes wide.
constexpr int kNeedleLimit = 4 * testing::kThoroughLimit;

// Needles about the axis or the middle of another body: their support turns within a strip of
// directions as narrow as they are thin, which cells must follow all around. Also ellipsoids that
// are balls, exactly or nearly: equally far out in all directions.
Pair revolvedPair(Random& random) {
  const auto body = [&]() -> Shape {
    const double r = random.chance(0.3) ? 1e-3 : random.uniform(0.05, 1);
    const double h = random.chance(0.1) ? r : random.uniform(0.05, 1);
    switch (random.below(6)) {
      case 0:
        return Shape::cylinder(r, h);
      case 1:
        return Shape::cone(r, h);
      case 2:
        return Shape::capsule(r, h);
      default:
        return Shape::ellipsoid({r, r, h});
    }
  };
  Pair pair{body(), body(), {random.rotation(), random.direction()}, {}};
  pair.X_WB = pair.X_WA;
  if (random.chance(0.5)) {
    pair.X_WB.translation += random.uniform(-0.1, 0.1) * pair.X_WA.rotation.col(2);
  }
  if (random.chance(0.3)) {
    pair.X_WB.translation += random.logUniform(1e-17, 1e-3) * random.direction();
  }
  return pair;
}

TEST(CurvedDepth, BodiesOfRevolutionAboutOneAxis) {
  Random random(93);
  Scratch scratch;
  int round = 0;
  const int cases = bySanitizer(100, 10, 2);
  for (int i = 0; i < cases; ++i) {
    const Pair pair = revolvedPair(random);
    const double size = Known{pair}.size();
    DistanceRequest request;
    request.tolerance = 1e-9 * size;
    const DistanceResult plain =
        distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch, nullptr);
    EXPECT_LE(plain.distance.width(), 2e-6 * size) << pair.replay();
    request.iteration_limit = kNeedleLimit;
    const DistanceResult r =
        distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch, nullptr);
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << pair.replay();
    if (!(r.distance.upper < 0)) continue;
    ++round;
    EXPECT_NEAR(apartAlong(pair, r.normal), r.distance.lower, 1e-9 * size) << pair.replay();
    // No plane is closer than the upper end.
    const Vector3d axis = pair.X_WA.rotation.col(2), beside = pair.X_WA.rotation.col(0);
    for (int k = 0; k < 400; ++k) {
      const double slope = k < 200 ? random.uniform(-3, 3) : random.logUniform(1e-6, 1);
      const Vector3d n = ((k % 2 == 0 ? 1 : -1) * beside + slope * axis).normalized();
      EXPECT_LE(apartAlong(pair, n), r.distance.upper + 1e-15 * size) << pair.replay();
    }
  }
  EXPECT_GT(2 * round, cases - 1);
}

// Regression: the first six stayed about a millionth of their sizes wide at the default tolerance.
// The nearest plane of the sixth is where the cone's rim starts to be chosen alone, all around. The
// sides of the last one are as near as its ends.
TEST(CurvedDepth, NeedlesBallsAndSquareCylindersAboutOneAxis) {
  const Pose X = pose({-0.31507064602784673, -0.60686138720999172, 0.72969154080690823,
                       -0.015086613236279689, 0.77195585439248471, 0.635497091236638,
                       -0.94894830318234624, 0.18921790502680613, -0.25237611278528793},
                      {0, 0, 0});
  const auto moved = [&](double along) {
    Pose Y = X;
    Y.translation += along * X.rotation.col(2);
    return Y;
  };
  const Known all[] = {
      known(Shape::ellipsoid({0.001, 0.001, 0.64}), X,
            Shape::ellipsoid({0.30275767245658786, 0.30275767245658786, 0.96148927962106157}),
            moved(0)),
      known(Shape::cone(0.17006972413669696, 0.32011800272022006), X,
            Shape::ellipsoid({0.001, 0.001, 0.79835642965015308}), moved(0.03)),
      known(Shape::ellipsoid({0.001, 0.001, 0.76274573350781349}), X,
            Shape::capsule(0.25381891528711292, 0.76637862464275408), moved(0)),
      known(Shape::cylinder(0.001, 0.93273194305222629), X,
            Shape::ellipsoid({0.001, 0.001, 0.81623647376668784}), moved(-0.05)),
      known(Shape::ellipsoid({0.79993789038592122, 0.79993789038592122, 0.79993789038592122}), X,
            Shape::ellipsoid(
                {0.24128370174496533, 0.24128370174496533, 0.24128370174496533 * (1 + 1e-11)}),
            moved(0)),
      known(Shape::ellipsoid({0.49779826283277989, 0.88971247475496917, 0.49779826283277989}),
            pose({0.95566440180047907, -0.20110563642340723, 0.21508620162639169,
                  -0.0042114705185772872, 0.7210378928302914, 0.69288283325460187,
                  -0.29442794474608491, -0.66306928755718253, 0.68822329606822152},
                 {-0.49892349747263542, -0.74648049433278907, 0.44027515856603583}),
            Shape::cone(0.19242855557463401, 0.19242855557464045),
            pose({0.95566440395349217, 0.21508617075236536, 0.20110565921251677,
                  -0.0042114204516097839, 0.69288280887425646, -0.72103791655106486,
                  -0.29442793847390963, 0.68822333026249927, 0.66306925485080259},
                 {-0.52276726858754308, -0.66099177910996598, 0.36165939917119116})),
      known(Shape::cylinder(0.095673037761012963, 0.095673037761012963), X,
            Shape::cylinder(0.22722076389104978, 0.22722076389104978),
            pose({-0.31507064602783869, -0.60686138720999117, 0.72969154080691223,
                  -0.015086613236284071, 0.77195585439248759, 0.63549709123663445,
                  -0.9489483031823488, 0.18921790502679667, -0.25237611278528527},
                 {0, 0, 0}))};
  expectDeepAndNarrow(all, kNeedleLimit);
}

// An ellipsoid that is exactly, or nearly, a ball has a ball's distances.
TEST(CurvedDepth, EllipsoidsThatAreBalls) {
  Random random(94);
  Scratch scratch;
  for (int i = 0; i < casesToAsk(150); ++i) {
    const double r = random.uniform(0.1, 1), s = random.uniform(0.1, 1);
    const double more = random.chance(0.5) ? 0 : random.logUniform(1e-17, 1e-7);
    const Shape a = Shape::ellipsoid({r, r * (1 + more), r}), b = Shape::ellipsoid({s, s, s});
    const Pose X{random.rotation(), random.direction()};
    Pose Y{random.rotation(), X.translation};
    Y.translation += (random.chance(0.3) ? 0 : random.uniform(0, 3)) * random.direction();
    const double apart = (Y.translation - X.translation).norm(), size = r + s + apart;
    DistanceRequest request;
    request.tolerance = (i % 2 == 0 ? 1e-9 : 1e-12) * size;
    const DistanceResult d = distance(a, X, b, Y, request, scratch, nullptr);
    // (A longer axis shortens the distance by no more than its excess.)
    EXPECT_LE(d.distance.lower, apart - r - s + 1e-15 * size) << i;
    EXPECT_GE(d.distance.upper, apart - r * (1 + more) - s - 1e-15 * size) << i;
    if (more < 1e-17 + 0.1 * request.tolerance || apart > r + s + 1e-3) {
      EXPECT_EQ(d.status, DistanceStatus::kConverged) << i << " " << more << " " << apart;
    }
  }
}

// Regression: with a NaN tolerance the depth to be proven stayed infinite, and so did the upper
// end.
TEST(CurvedDepth, ToleranceThatNothingMeetsLeavesTheTruth) {
  const Pair pair{
      Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
      Shape::cylinder(0.54587614483008084, 0.53073149722360435),
      pose({0.69259647507259003, -0.71613621923555182, 0.086365723617838619, -0.46768007289394159,
            -0.53697884640565174, -0.70208907407164034, 0.54916798170955006, 0.44587288997186786,
            -0.70683229542317472},
           {0.070610520459519183, 0.72293194939278815, -0.68730164480203249}),
      pose({0.31515693471138767, 0.94510161796882419, 0.086365723617838619, 0.69230224665449702,
            -0.16669892425076732, -0.70208907407164034, -0.64914844664410809, 0.28105942497334552,
            -0.70683229542317472},
           {0.070610510984088395, 0.72293193835084912, -0.68730164338059763})};
  Scratch scratch;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double tolerance : {-infinity, -1.0, 0.0}) {
    DistanceRequest request;
    request.tolerance = tolerance;
    request.iteration_limit = testing::kThoroughLimit;
    const DistanceResult d =
        distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch, nullptr);
    EXPECT_EQ(d.status, DistanceStatus::kLimit);
    EXPECT_NEAR(d.distance.lower, -0.60681486666, 1e-9) << tolerance;
    EXPECT_NEAR(d.distance.upper, -0.60681486666, 1e-9) << tolerance;
  }
}

}  // namespace
}  // namespace leeway::collision
