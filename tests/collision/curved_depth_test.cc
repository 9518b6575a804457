#include "collision/curved_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "leeway/collision/distance.h"
#include "tests/collision/pair_cases.h"
#include "tests/sanitized.h"
#include "tools/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;
using testing::Pair;

constexpr ShapeType kRound[] = {ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};
constexpr ShapeType kAny[] = {ShapeType::kCapsule, ShapeType::kBox, ShapeType::kCylinder,
                              ShapeType::kCone, ShapeType::kEllipsoid};

// How far a body reaches along n, from its definition.
double most(const Shape& s, const Pose& X_WS, const Vector3d& n) {
  const Vector3d d = X_WS.rotation.transpose() * n, e = s.halfExtents();
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

Pose pose(const double (&R)[9], const Vector3d& t) {
  Pose X;
  X.rotation << R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8];
  X.translation = t;
  return X;
}

// Round bodies whose axes z (nearly) fall together, of nearly round sections: depths that are about
// the same all around.
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

struct Known {
  Pair pair;
  double tolerance;  // of the sizes involved; 0: the default
};

// Long runs left these open, at widths of up to 2e-4 m.
TEST(CurvedDepth, PairsThatWereLeftOpenAreAsNarrowAsAsked) {
  const auto known = [](const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        double tolerance) {
    return Known{{a, b, X_WA, X_WB}, tolerance};
  };
  const Known all[] = {
      known(Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
            pose({0.69259647507259003, -0.71613621923555182, 0.086365723617838619,
                  -0.46768007289394159, -0.53697884640565174, -0.70208907407164034,
                  0.54916798170955006, 0.44587288997186786, -0.70683229542317472},
                 {0.070610520459519183, 0.72293194939278815, -0.68730164480203249}),
            Shape::cylinder(0.54587614483008084, 0.53073149722360435),
            pose({0.31515693471138767, 0.94510161796882419, 0.086365723617838619,
                  0.69230224665449702, -0.16669892425076732, -0.70208907407164034,
                  -0.64914844664410809, 0.28105942497334552, -0.70683229542317472},
                 {0.070610510984088395, 0.72293193835084912, -0.68730164338059763}),
            0),  // coaxial
      known(Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
            pose({0.43237246227931092, 0.83305297100711129, -0.34507506626638651,
                  -0.63727157318028138, 0.011572197032118647, -0.77055241630415983,
                  -0.63791770306118267, 0.55307217589757218, 0.53588447670096739},
                 {0.10473201149673106, -0.5286302014804739, -0.84236649734575875}),
            Shape::cone(0.93986130395674727, 0.86376011149231213),
            pose({0.46194226303132468, 0.81702664844345663, -0.34507506626638651,
                  -0.63644778513496203, 0.034397536606887463, -0.77055241630415983,
                  -0.6176921259189726, 0.57557298860234096, 0.53588447670096739},
                 {-0.028656387037519382, -0.82651514561682271, -0.63521450675313751}),
            0),  // coaxial
      known(Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
            pose({0.34706855570086936, 0.93370805710117177, -0.08793566823574861,
                  0.14242390533947885, 0.040201592050429169, 0.98898901064898714,
                  0.92696216148857125, -0.35577112881874778, -0.11902963944946809},
                 {0.40402434528698211, -0.9007348895602123, -0.15950231078068264}),
            Shape::cone(0.93986130395674727, 0.86376011149231213),
            pose({-0.70025018897320912, 0.70846100181655547, -0.087935668235748693,
                  0.023611492812394198, 0.14609323811425415, 0.98898901064898714,
                  0.71350695178824675, 0.69046344920087888, -0.11902963944946779},
                 {0.40402434528698211, -0.9007348895602123, -0.15950231078068264}),
            0),  // coaxial
      known(Shape::cone(0.050180210970703479, 0.22769379357593578),
            pose({0.27907299162350419, 0.74287690488219527, -0.60848349980829974,
                  0.90762285805051635, -0.41098870875142746, -0.085492858316038006,
                  -0.31359051785811298, -0.52841478543988885, -0.78894790806364168},
                 {-0.12616035183457494, -0.59647128928074855, 0.79265728198808449}),
            Shape::ellipsoid({0.59659078551845701, 0.59781945170521755, 0.56434287125055804}),
            pose({0.78062869694536441, 0.14271183541117069, -0.60848349980829974,
                  0.1143046788655091, -0.98976027984881587, -0.085492858316038006,
                  -0.61445364177847872, -0.0028143324551653803, -0.78894790806364168},
                 {-0.12616035183457494, -0.59647128928074855, 0.79265728198808449}),
            0),  // coaxial
      known(Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
            pose({-0.14079622829977256, -0.95145001175085653, 0.27371389668018908,
                  0.68007370120991617, 0.1079737381400645, 0.72514924863417352,
                  -0.71949717373955258, 0.28824390194999044, 0.63185383592207489},
                 {0.036263089460074463, 0.11267356348434415, 0.99297011860103335}),
            Shape::capsule(0.28272361711377697, 0.14887132205603434),
            pose({0.17301895761862235, 0.94612110380686043, 0.27371389668018908,
                  -0.68334756347105774, -0.084821428327176984, 0.72514924863417352,
                  0.70929581121189067, -0.31250629150118792, 0.63185383592207489},
                 {0.04002652817795508, 0.12264402823477005, 1.0016578148378394}),
            0),  // coaxial
      known(Shape::cone(0.22596538321805767, 0.39322721683466044),
            pose({-0.56612208901030137, 0.49876007008358553, 0.65631103359979293,
                  0.57740473890454846, 0.80816136627271284, -0.11609898171298645,
                  -0.58831075786966702, 0.3132309029365381, -0.74550442897435443},
                 {0.20677049173249709, -0.14562384299078404, 0.96749142637095076}),
            Shape::cylinder(0.43737792222323035, 0.26187804570230322),
            pose({0.61818168923493078, -0.43255894153062058, 0.65631102474098035,
                  -0.4837385434229784, -0.86747798021727107, -0.11609898985425883,
                  0.61955501830076554, -0.24571266947406942, -0.74550443550542611},
                 {0.25556772296207469, -0.15425589176968924, 0.91206259744542828}),
            0),  // coaxial
      known(
          Shape::cylinder(115.2031535107147, 164.08838763293161),
          pose({0.15996095129254273, 0.35405812197937742, -0.92144198966729385,
                -0.44146889940617179, -0.80924772633066056, -0.3875865429626778,
                -0.88290299858970256, 0.46878669316555122, 0.026857613300871996},
               {-0.93396565255556907, -0.27094032840397636, -0.23302252743199645}),
          Shape::ellipsoid({0.00024936648722052873, 0.0002150611796769207, 0.00012816511292912562}),
          pose({0.70439491008104782, 0.66819391875740153, -0.23946752929685425, 0.31631129679893005,
                -0.59751473950647505, -0.73683329158629096, -0.63543290296402799,
                0.44327533543852415, -0.63224362616207674},
               {1.7668521401591744, 0.64926533479127913, -0.20114536339800726}),
          0),  // ratio
      known(Shape::cylinder(0.18164841456287673, 0.23501608476186989),
            pose({0.90775476176749459, 0.11670750550549758, -0.40294000874463104,
                  -0.41909017006193416, 0.20978311432815999, -0.88337674539249511,
                  -0.01856668645445847, 0.97075764385425389, 0.23934258929960506},
                 {0.015739734995687545, 0.081883553226797481, 0.99651760870203376}),
            Shape::ellipsoid({0.06142399395368027, 0.060938735178177071, 0.32684320026309294}),
            pose({0.078884827231271465, -0.91182045019047953, -0.40294000874463159,
                  0.22701725309560883, 0.41001060046868032, -0.88337674539249467,
                  0.97069065660982679, -0.021789312007117013, 0.23934258929960575},
                 {-0.044390858166987957, -0.049942442042460525, 1.0322346175652486}),
            1e-14),  // coaxial
      known(Shape::capsule(0.096937645972291708, 0.47829145516058175),
            pose({0.63424200220498583, 0.77242667025343015, -0.033077510792220766,
                  0.587806623759344, -0.45397488145863552, 0.66961942927998952, 0.50221554705489935,
                  -0.44414394748303909, -0.74196745091043681},
                 {-0.3072200697094401, 0.20420426879526168, 0.9294710567702037}),
            Shape::ellipsoid({0.14846644634558762, 0.16184384657657416, 0.13352485205311984}),
            pose({-0.16080168019844154, 0.66771405283068475, -0.72684301145280339,
                  0.71579888849192563, 0.58592433491401863, 0.3799008094085729, 0.67954011719624197,
                  -0.45918473124439413, -0.57216659436997164},
                 {-0.30722004308923784, 0.20420428691345324, 0.92947103725617153}),
            1e-14),  // deep
      known(Shape::ellipsoid({0.75098265807231801, 0.42921903381135984, 0.69055674760289432}),
            pose({0.99833109116888297, -0.057503806311771363, 0.005323970811882228,
                  -0.057624737079668142, -0.99799032884664363, 0.026357033313087645,
                  0.0037976416427315798, -0.026619838245683928, -0.99963841569325784},
                 {0.97195463865693132, 0.16828410671439803, 0.16427002106474276}),
            Shape::ellipsoid({0.75098265807231801, 0.42921903381135984, 0.69055674760289432}),
            pose({0.99833109116888297, -0.057503806311771363, 0.005323970811882228,
                  -0.057624737079668142, -0.99799032884664363, 0.026357033313087645,
                  0.0037976416427315798, -0.026619838245683928, -0.99963841569325784},
                 {0.97595284840873808, 0.18807778165076122, -0.58644109346378082}),
            1e-14),  // twin
      known(Shape::cylinder(58.316075163392881, 78.453571270285138),
            pose({-0.52910102690830563, -0.45564771587514735, 0.71584723394194816,
                  -0.84387939899766229, 0.19407000938811114, -0.50020434964466609,
                  0.088992489974838107, -0.86874736861406376, -0.48719436188673138},
                 {-0.24022345055542599, 0.45261925319325963, 0.85873657511603696}),
            Shape::cone(1.3052182988250697e-06, 3.7796903339157489e-06),
            pose({-0.3003927226026526, -0.82110318085762302, 0.48533882864743061,
                  0.2241826658280206, -0.55536471027707468, -0.80081968689655958,
                  0.92709565016216555, -0.1317558536246311, 0.35090461736209255},
                 {-0.57928158216543624, 0.7513857248296516, 0.90604489975108438}),
            0),  // ratio
  };
  Scratch scratch;
  for (const auto& [pair, tolerance] : all) {
    DistanceRequest request;
    const double size = oracle::sizeOf(pair.a) + oracle::sizeOf(pair.b) +
                        (pair.X_WB.translation - pair.X_WA.translation).norm();
    if (tolerance > 0) request.tolerance = tolerance * size;
    const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch);
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << pair.replay();
    EXPECT_LT(r.distance.upper, 0) << pair.replay();
    const oracle::Truth truth = oracle::signedSeparation(pair.a, pair.X_WA, pair.b, pair.X_WB);
    EXPECT_LE(r.distance.lower, truth.upper) << pair.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << pair.replay();
    EXPECT_NEAR(apartAlong(pair, r.normal), r.distance.lower, 1e-9 + 1e-14 * size) << pair.replay();
  }
}

// By itself, against many planes, most of them where the nearest one is.
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
    if (!offerCurvedDepth(difference, progress, nullptr)) continue;
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

// Few iterations are few, and pairs with vertices of their own or nothing round are others' work.
TEST(CurvedDepth, SpeaksOfRoundBodiesOnly) {
  const Shape cone = Shape::cone(0.2, 0.3), box = Shape::box({0.1, 0.2, 0.3});
  const Shape capsule = Shape::capsule(0.1, 0.2);
  const Vector3d corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Shape hull = Shape::convexHull(corners);
  EXPECT_TRUE(haveCurvedDepth(viewOf(cone), viewOf(box)));
  EXPECT_TRUE(haveCurvedDepth(viewOf(capsule), viewOf(cone)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(capsule), viewOf(box)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(cone), viewOf(hull)));
  EXPECT_FALSE(haveCurvedDepth(viewOf(cone), viewOf(Shape::halfSpace())));
}

// Swapped bodies have the same depth.
TEST(CurvedDepth, SwappedIsTheSame) {
  Random random(92);
  Scratch scratch;
  for (int i = 0; i < casesToAsk(300); ++i) {
    const Pair pair = aroundOneAxis(random);
    const Interval d = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch).distance;
    const Interval e = distance(pair.b, pair.X_WB, pair.a, pair.X_WA, {}, scratch).distance;
    EXPECT_LE(d.width(), 1e-9) << pair.replay();
    EXPECT_LE(e.width(), 1e-9) << pair.replay();
    EXPECT_LE(d.lower, e.upper) << pair.replay();
    EXPECT_LE(e.lower, d.upper) << pair.replay();
  }
}

// One that is no number was none to the depth that is to be proven either: it stayed infinite, and
// the upper end became that.
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
  for (const double tolerance : {std::nan(""), -infinity, -1.0, 0.0}) {
    DistanceRequest request;
    request.tolerance = tolerance;
    const DistanceResult d =
        distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch, nullptr);
    EXPECT_EQ(d.status, DistanceStatus::kLimit);
    EXPECT_NEAR(d.distance.lower, -0.60681486666, 1e-9) << tolerance;
    EXPECT_NEAR(d.distance.upper, -0.60681486666, 1e-9) << tolerance;
  }
}

}  // namespace
}  // namespace leeway::collision
