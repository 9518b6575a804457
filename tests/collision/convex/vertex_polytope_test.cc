// The polytope in vector lanes against its slow twin, growPolytope().

#include "collision/convex/epa/vertex_polytope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "collision/convex/epa/epa.h"
#include "collision/convex/gjk/vertex_gjk.h"
#include "tests/collision/convex/pair_cases.h"
#include "tests/support/every_target.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

// Round, flat-sided or thin; a third are boxes, which have many facets in one plane.
Shape anyBody(Random& random) {
  const Vector3d half(random.uniform(0.1, 1), random.uniform(0.1, 1),
                      random.chance(0.2) ? random.logUniform(1e-6, 0.1) : random.uniform(0.1, 1));
  if (random.chance(0.3)) return Shape::box(half);
  const int count = random.chance(0.1) ? 300 : 4 + random.below(60);
  const bool on_grid = random.chance(0.3);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Vector3d p = random.direction();
    if (on_grid) p = (2 * p).array().round() / 2;
    points.push_back(half.cwiseProduct(p));
  }
  return Shape::convexHull(points);
}

// An overlapping pair, as convexDistance() passes it to the polytope.
struct Overlap {
  Overlap(const testing::Pair& pair, const DistanceRequest& request)
      : a(viewOf(pair.a)),
        b(viewOf(pair.b)),
        relative(relativePose(pair.X_WA, pair.X_WB)),
        difference(a, b, relative.X_BA, relative.X_BA) {
    query.request = request;
    query.roundoff = kUnitRoundoff * (a.extent + b.extent + relative.X_BA.translation.norm());
    query.lower_offset = kSupportRounding * query.roundoff;
    query.upper_offset = -kSupportRounding * query.roundoff;
  }
  // False if GJK finds no four points that contain the origin.
  bool begin(Progress& progress) {
    const Vector3d towards = -relative.X_BA.translation.normalized();
    return runVertexGjk(difference, towards, nullptr, progress, simplex) == GjkEnd::kInside &&
           simplex.count == 4;
  }

  ConvexView a, b;
  RelativePose relative;
  Difference<false> difference;
  CoreQuery query;
  Simplex simplex;
};

// Some are parallel, some barely in contact.
testing::Pair anyPair(Random& random, Scratch& scratch) {
  testing::Pair pair{anyBody(random), anyBody(random), {}, {}};
  pair.X_WA = {random.rotation(), random.direction()};
  pair.X_WB = {random.chance(0.2) ? pair.X_WA.rotation : random.rotation(),
               pair.X_WA.translation + random.logUniform(1e-3, 0.5) * random.direction()};
  if (random.chance(0.3)) testing::moveApart(pair, -random.logUniform(1e-13, 0.1), scratch);
  return pair;
}

TEST(VertexPolytope, AgreesWithItsSlowTwin) {
  Random random(241);
  Scratch scratch;
  PolytopeBuffers buffers;
  int asked = 0, found = 0;
  for (int i = 0; i < casesToAsk(6000); ++i) {
    const testing::Pair pair = anyPair(random, scratch);
    DistanceRequest request = testing::nanometre();
    request.tolerance = random.chance(0.5) ? 1e-9 : random.logUniform(1e-12, 1e-1);
    Overlap overlap(pair, request);
    Progress progress(overlap.query);
    if (!overlap.begin(progress) || progress.enough()) continue;
    ++asked;
    Progress slow = progress;
    growPolytope(overlap.difference, overlap.simplex, buffers, slow);
    const bool enough = growVertexPolytope(overlap.difference, overlap.simplex, progress);
    EXPECT_LE(progress.lower(), slow.upper()) << pair.replay();
    EXPECT_GE(progress.upper(), slow.lower()) << pair.replay();
    EXPECT_EQ(enough, progress.enough()) << pair.replay();
    if (!enough) continue;
    ++found;
    // The plane supports the difference, and the witness is within the tolerance of it.
    const Vector3d& n = progress.normal();
    SupportPoint s;
    overlap.difference.support(n, s);
    EXPECT_NEAR(n.norm(), 1, 1e-14) << pair.replay();
    EXPECT_LE(progress.lower(), n.dot(s.w)) << pair.replay();
    const Vector3d& w = progress.witnessW();
    EXPECT_LE(-w.norm(), progress.upper()) << pair.replay();
    EXPECT_LE(w.norm() + progress.upper(), request.tolerance + 1e-13) << pair.replay();
    EXPECT_LE((w - n.dot(w) * n).norm(), std::sqrt(8 * request.tolerance * w.norm()) + 1e-12)
        << pair.replay();
  }
  EXPECT_GT(asked, casesToAsk(3000));
  EXPECT_GT(found, asked * 3 / 4);
}

TEST(VertexPolytope, ThresholdsLimitsAndYesOrNo) {
  Random random(242);
  Scratch scratch;
  PolytopeBuffers buffers;
  int above = 0, below = 0, yes = 0, open = 0, told = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    const testing::Pair pair = anyPair(random, scratch);
    DistanceRequest exact = testing::nanometre();
    Overlap overlap(pair, exact);
    Progress slow(overlap.query);
    if (!overlap.begin(slow)) continue;
    const Simplex start = overlap.simplex;
    const Progress begun = slow;
    growPolytope(overlap.difference, start, buffers, slow);
    const int kind = random.below(3);
    DistanceRequest& request = overlap.query.request;
    if (kind == 0) request.threshold = random.uniform(0.5, 1.5) * slow.upper();
    if (kind == 1) request.depth = false;
    if (kind == 2) request.iteration_limit = begun.iterations + random.below(4);
    Progress progress = begun;
    if (progress.enough()) continue;
    const bool enough = growVertexPolytope(overlap.difference, start, progress);
    EXPECT_LE(progress.lower(), slow.upper()) << pair.replay();
    EXPECT_GE(progress.upper(), slow.lower()) << pair.replay();
    if (kind == 2) {
      EXPECT_LE(progress.iterations, request.iteration_limit) << pair.replay();
      open += !enough;
      // The result of the surface at the limit is kept.
      told += !enough && progress.upper() < begun.upper();
      continue;
    }
    if (!enough) continue;
    EXPECT_TRUE(progress.decided()) << pair.replay();
    if (kind == 1) ++yes;
    if (kind == 0) ++(progress.aboveThreshold() ? above : below);
  }
  EXPECT_GT(above, casesToAsk(200));
  EXPECT_GT(below, casesToAsk(200));
  EXPECT_GT(yes, casesToAsk(500));
  EXPECT_GT(open, casesToAsk(200));
  EXPECT_GT(told, open / 2);
}

TEST(VertexPolytope, LeavesToItsTwinWhatIsInDoubt) {
  const Shape box = Shape::box({1, 1, 1});
  const Pose identity;
  // Four points that do not hold the origin, or hold it on their surface.
  for (const double height : {0.0, 1e-17, 0.5}) {
    DistanceRequest request = testing::nanometre();
    Overlap overlap({box, box, identity, identity}, request);
    const Vector3d corners[4] = {
        {2, 2, height}, {-2, 2, height}, {-2, -2, height}, {2, 2, 1 + height}};
    for (int i = 0; i < 4; ++i) {
      overlap.simplex.points[overlap.simplex.slot[i]].w = corners[i];
    }
    overlap.simplex.count = 4;
    Progress progress(overlap.query);
    EXPECT_FALSE(growVertexPolytope(overlap.difference, overlap.simplex, progress));
    EXPECT_EQ(progress.upper(), std::numeric_limits<double>::infinity());
  }
  // A tolerance below rounding.
  DistanceRequest request = testing::nanometre();
  request.tolerance = 1e-16;
  Overlap overlap({box, box, identity, Pose{Eigen::Matrix3d::Identity(), {0.5, 0.2, 0.1}}},
                  request);
  Progress progress(overlap.query);
  ASSERT_TRUE(overlap.begin(progress));
  EXPECT_FALSE(growVertexPolytope(overlap.difference, overlap.simplex, progress));
}

TEST(VertexPolytope, TheSameBytesOnEveryInstructionSet) {
  expectTheSameBytesOnEveryTarget([] {
    Random random(243);
    Scratch scratch;
    std::vector<double> answers;
    for (int i = 0; i < casesToAsk(500); ++i) {
      const testing::Pair pair = anyPair(random, scratch);
      DistanceRequest request = testing::nanometre();
      Overlap overlap(pair, request);
      Progress progress(overlap.query);
      if (!overlap.begin(progress)) continue;
      const bool enough = growVertexPolytope(overlap.difference, overlap.simplex, progress);
      answers.insert(answers.end(), {progress.lower(), progress.upper(), enough ? 1.0 : 0.0,
                                     static_cast<double>(progress.iterations)});
      for (const Vector3d* v : {&progress.normal(), &progress.witnessW(), &progress.witnessA()}) {
        answers.insert(answers.end(), v->begin(), v->end());
      }
    }
    return answers;
  });
}

}  // namespace
}  // namespace leeway::collision
