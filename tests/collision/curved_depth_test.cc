#include "collision/curved_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "leeway/collision/convex_hull.h"
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

Known known(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, double tolerance) {
  return {{a, b, X_WA, X_WB}, tolerance};
}

Shape hull(const std::vector<Vector3d>& points) { return Shape::convexHull(points); }

void expectNarrow(std::span<const Known> all) {
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

// Long runs left these open, at widths of up to 2e-4 m.
TEST(CurvedDepth, PairsThatWereLeftOpenAreAsNarrowAsAsked) {
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
  expectNarrow(all);
}

// The same of hulls beside round bodies: no vertex of theirs was known to cells of directions.
TEST(CurvedDepth, HullsInRoundBodiesAreAsNarrowAsAsked) {
  const Known all[] = {
      known(Shape::cylinder(95.623096358221687, 158.04557535679169),
            pose({0.32357863633115813, 0.13862141577299653, -0.93599197069160711,
                  0.85454527404940439, -0.46754215978857028, 0.22617847691605647,
                  -0.40626252683443048, -0.87303403823065739, -0.26974493022256163},
                 {-0.76959725033399751, 0.065596299210605113, 0.63515131882742937}),
            hull({{-0.13688687708625319, -0.29692731391923516, 0.21235884038553032},
                  {0.2165498571162926, 0.16750819170395548, 0.27757393439332578},
                  {0.10582428101371549, -0.014340760732509065, -0.37496091541539273},
                  {-0.17498261187037883, -0.15936011275512207, -0.30981537076991733},
                  {-0.20587435247277133, 0.31802827396164801, 0.092053744706547772},
                  {0.13001716985214623, 0.35751328909604602, 0.085322374691351593},
                  {-0.28285177026252334, -0.13789503165341938, 0.23017376102472104},
                  {0.13883659220574904, -0.25039346231717358, 0.26462735809647298},
                  {0.11370754241459494, -0.30219764750236899, 0.21851155713525372},
                  {0.31036068775514569, -0.12946084775273095, 0.19727203642407953},
                  {0.16374960177895895, 0.081703481767820663, -0.3442538786184608},
                  {0.19912173796106239, 0.26761500273166877, 0.20182385325798602},
                  {0.33443110232325918, -0.16271732197048944, 0.11695740630335485},
                  {-0.14013515882687985, 0.22141560988000941, -0.28868215899434246},
                  {-0.12587919402110956, 0.35172966638122594, 0.11153830848436562},
                  {0.34160410852949302, -0.086069238030486564, 0.16702946823907447},
                  {0.27937019275592112, 0.11967483163509499, 0.24419327188159251}}),
            pose({-0.63369020840122259, -0.21766472418635707, 0.74233333996345097,
                  0.17652590568464271, 0.89359438648592293, 0.41270773807025191,
                  -0.75317682146932274, 0.39256991770348898, -0.5278385504258325},
                 {-1.1637865086086048, 0.070580127365973203, -0.46532792639322529}),
            0),  // ratio
      known(Shape::cylinder(327.08650428385323, 365.7495302351914),
            pose({0.56998695555392942, 0.40542972992760667, 0.71466188130415265, 0.6313991437988864,
                  0.34045875854554675, -0.69672301163350303, -0.52578511932955652,
                  0.84835992822648865, -0.061930933071858041},
                 {-0.6509385782970285, -0.59193188666603347, -0.47528476604308861}),
            hull({{1.8840671358589062e-05, -9.3910603265232453e-06, 1.882705067344162e-05},
                  {-2.2484525686399464e-05, -1.6153847072348004e-05, -5.5785372437523767e-06},
                  {-1.7568841623694058e-05, 1.7613082602603559e-05, -1.3369213649071316e-05},
                  {8.1363563507714649e-06, 2.6184516855179507e-05, -6.766943974437562e-06},
                  {1.4876516212007167e-05, -1.8828803003819631e-05, 1.4892487743702747e-05},
                  {-1.4534046430802315e-07, -7.0425994926379551e-06, 2.734961456574527e-05},
                  {8.0701249212067973e-06, 1.5744885993016807e-05, -2.2013459455117816e-05},
                  {5.3914335270857222e-06, 3.4988322925667428e-08, 2.7722769859798832e-05},
                  {-1.9908777293845933e-05, 1.546363371174054e-06, 1.9971732407265816e-05},
                  {1.6182277746293336e-05, -2.2828412135370552e-05, -3.8233800070855695e-06},
                  {-2.6560322851472813e-05, 7.7405885579534609e-06, -5.6791977568232911e-06}}),
            pose({-0.086356278451191981, -0.23218110556773275, 0.96883152683498364,
                  0.97074719789928032, -0.23829470810104025, 0.029419548972336007,
                  0.22403676248052656, 0.94303105267450527, 0.24596740180125232},
                 {0.84873905631686375, -5.8105549712415021, -1.4481809183051111}),
            1e-14),  // ratio
      known(Shape::cylinder(461.63373163906442, 729.47833481868156),
            pose({-0.49988983338352977, -0.75126729003668025, -0.43093806213971142,
                  -0.57575814548281501, -0.083443323222469612, 0.81335095113965428,
                  -0.64700286891943293, 0.65470197092305538, -0.39083579273077107},
                 {0.32193669393132579, -0.88716781154738511, -0.33059044035602614}),
            hull({{-8.6622955059547884e-05, 0.00020426682078682266, 9.2154879515842289e-05},
                  {-6.717611708077324e-05, -0.00019418705862540571, 0.00012449798308626243},
                  {-8.1515610340622844e-05, -2.7935554928929701e-05, 0.00022426725636568592},
                  {-0.00023249118539228915, -1.5142434737123716e-05, 5.8647656571290022e-05}}),
            pose({0.73844694545287115, 0.20798967675960198, 0.64143308545222444,
                  0.46813650571273713, -0.84277587322755632, -0.26566339515371451,
                  0.48532908502416461, 0.49645656594204346, -0.71971282978882689},
                 {-2.4437565374904109, 4.8109149506219779, -5.9814389794871952}),
            0),  // ratio
      known(Shape::cone(128.32020036324815, 216.15045744835871),
            pose({0.12865511211232383, 0.60921848974835169, -0.78249644975303445,
                  0.3971721834669879, -0.75466131512802392, -0.52224568560142925,
                  -0.90868152771332977, -0.24359624627234952, -0.3390556738864432},
                 {-0.0035391580383909802, 0.58177358695457237, -0.81334308129004818}),
            hull({{-5.523635082958106e-06, -3.9213272074042416e-06, -6.3775567624349317e-07},
                  {3.4607876643859189e-06, 1.694956777856545e-06, -5.6075087305351192e-06},
                  {2.3374661922520167e-06, 5.1947134697792289e-06, -3.7209256464982285e-06},
                  {-2.0220050164006553e-06, -6.257388557682027e-06, 1.7466161718121691e-06},
                  {1.8982342329486038e-06, 6.8970631236659222e-07, -6.4973145144235457e-06},
                  {-5.8757300906363666e-06, 1.5543439151569538e-06, 3.0584137710911631e-06},
                  {3.0993016440602141e-07, 5.7126321052584086e-06, 3.6829148270028321e-06}}),
            pose({0.12513980613303799, 0.34645130069212704, 0.92968356184764234,
                  -0.29777439228624869, 0.90696428343900226, -0.29790300412136222,
                  -0.94639866875410428, -0.23955643346549996, 0.21666166011952503},
                 {0.0086899654626371673, 0.52789246556129743, -0.71100476528690792}),
            0),  // ratio
      known(hull({{-0.20530875297510365, 0.12139373326311143, -0.12921173581716763},
                  {0.14297318950349866, -0.12694798504513374, -0.19242315705966961},
                  {0.051511825577017313, -0.079205475909466028, -0.25427705285438373},
                  {-0.25237826385298129, 0.097049959290949631, -0.021686690222647288},
                  {0.019110830385006345, 0.016816462268569945, -0.27006624734571771},
                  {0.13957940101609523, 0.23234678139159629, -0.010786991498418436},
                  {0.095325466421314148, 0.25382282730053823, 0.0084156395688718584},
                  {0.18786008482814412, -0.11810489805150315, 0.15602441085048088}}),
            pose({0.24138108466549779, -0.84918458961569832, 0.46970278339065197,
                  -0.72785852872095524, -0.47855049411903972, -0.49113275877973062,
                  0.64183886929187617, -0.22332701882584785, -0.73359928334785396},
                 {0.11043953434930701, 0.96837568334409807, -0.22372225003463456}),
            Shape::cone(732.39576503894, 483.86823512751909),
            pose({-0.83632709050560905, -0.44541612514144219, -0.31962708450693877,
                  0.2597548823616343, 0.19147765820624885, -0.94650076994006949,
                  0.48278815103077688, -0.87460893082098934, -0.044438939596369131},
                 {0.41188456094012038, 0.77715117734437134, 0.37812263424579995}),
            0),  // ratio
      known(hull({{0, 0, 0},
                  {9.9999999999999995e-07, 0, 0},
                  {0, 9.9999999999999995e-07, 9.9999999999999995e-07}}),
            pose({-0.79595637216016346, -0.58583428482956101, -0.15248489871415827,
                  0.57951560789301437, -0.81021975405153546, 0.087781606006377022,
                  -0.17497175150869487, -0.018497050113611468, 0.98439968778493325},
                 {0.7286754551652328, -0.35106961145421006, 0.58803248970880051}),
            Shape::cone(0.35328031594668829, 0.41877395372819021),
            pose({-0.056053537792281061, -0.33399093317317063, 0.94090810255788737,
                  -0.86767388443257476, -0.44994402393149002, -0.21140578422083323,
                  0.493963592964761, -0.82825143035581483, -0.26457425600177054},
                 {0.72878677627288801, -0.35100134445527781, 0.58785814777085921}),
            0),  // degenerate
  };
  expectNarrow(all);
}

// Valleys all around an axis took more cells than there are in a query where bends changed over a
// cell, ...
TEST(CurvedDepth, ValleyAroundAnAxisIsAsNarrowAsTwiceThePrecisionAllows) {
  const Known all[] = {
      known(Shape::cone(0.62811599583691802, 0.95443453478336371),
            pose({0.64839619123139236, -0.26118833753713538, 0.71509651903166949,
                  -0.48024456087979434, -0.86916266287133359, 0.11798909786834103,
                  0.59071781837184922, -0.41992489543369405, -0.68899603863375236},
                 {0.83669806186568896, -0.54684262008059248, -0.029991701078674288}),
            Shape::cylinder(0.04457468663094008, 0.1719576169786988),
            pose({-0.64202241864063914, -0.27648541088417283, 0.71509651903154559,
                  -0.27899570290423936, 0.95301624883579417, 0.11798909786891359,
                  -0.71412086632711747, -0.12375720998455404, -0.68899603863378289},
                 {1.2466240430908486, -0.479205880940759, -0.42495569500169017}),
            1e-14),  // coaxial
  };
  expectNarrow(all);
}

// ... or where parallel lines of two cones made the same member in many ways.
TEST(CurvedDepth, TwinsAreAsNarrowAsTwiceThePrecisionAllows) {
  const Known all[] = {
      known(Shape::cone(0.12473359624743964, 0.063092900932907564),
            pose({-0.6129390778900321, 0.6086377407040835, -0.50385095751218401,
                  -0.039754178398865636, 0.61311794777843032, 0.7889904862619046,
                  0.7891294520515294, 0.50363328196475909, -0.3516080562249071},
                 {-0.93378072574232818, -0.093389984375244497, 0.34544444857389511}),
            Shape::cone(0.12473359624743964, 0.063092900932907564),
            pose({-0.6086377407040835, 0.6129390778900321, 0.50385095751218401,
                  -0.61311794777843032, 0.039754178398865636, -0.7889904862619046,
                  -0.50363328196475909, -0.7891294520515294, 0.3516080562249071},
                 {-0.96899553220557466, -0.038246401018287593, 0.32087009882567824}),
            1e-14),  // twin
  };
  expectNarrow(all);
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

// Pairs with nothing round are others' work, and triangles.
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

// Steps are counted: any limit leaves the truth, and says so where it is why.
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
  for (const int limit : {1, 8, 63, 64, 70, 100, 256, 1000}) {
    DistanceRequest request;
    request.iteration_limit = limit;
    for (const double tolerance : {1e-9, 1e-12, 1.1e-14}) {
      request.tolerance = tolerance;
      const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch);
      EXPECT_LE(r.distance.lower, truth.upper) << limit;
      EXPECT_GE(r.distance.upper, truth.lower) << limit;
      EXPECT_LE(r.iterations, 2 * limit) << tolerance;
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
