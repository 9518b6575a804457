#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/deform/query/nearest_triangle.h"
#include "leeway/collision/distance.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/every_target.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::Sheet;

// Distance from the core to every triangle, one by one.
Interval bruteForce(const DeformableSnapshot& snapshot, const Vector3d& middle,
                    const Vector3d& half) {
  Scratch scratch;
  const Vector3d ends[] = {middle - half, middle + half};
  const Shape core = Shape::convexHull(half.isZero() ? std::vector<Vector3d>{middle}
                                                     : std::vector<Vector3d>{ends[0], ends[1]});
  DistanceRequest request;
  request.depth = false;
  Interval least{kInfinity, kInfinity};
  for (const auto& t : snapshot.mesh().triangles()) {
    std::vector<Vector3d> corners;
    for (const std::int32_t v : t)
      corners.push_back(snapshot.vertices()[static_cast<std::size_t>(v)]);
    const Interval one =
        distance(Shape::convexHull(corners), {}, core, {}, request, scratch).distance;
    least = {std::min(least.lower, one.lower), std::min(least.upper, one.upper)};
  }
  return least;
}

struct Case {
  NearestSearch search;
  Interval truth;
};

// A mesh in some state under some strategy, with random searches.
struct Cases {
  Cases(const Sheet& sheet, std::vector<Vector3d> vertices, DeformStrategy strategy, bool prepared,
        Random& random, int count, bool with_truth)
      : deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                   testing::optionsOf(strategy)) {
    EXPECT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated);
    snapshot = deformable.snapshot();
    if (prepared) prepare(scratch, *snapshot);
    for (int i = 0; i < count; ++i) {
      Case c;
      c.search.middle =
          vertices[static_cast<std::size_t>(random.below(static_cast<int>(vertices.size())))] +
          random.logUniform(1e-3, 3) * random.direction();
      c.search.half = random.chance(0.5)
                          ? Vector3d::Zero()
                          : Vector3d(random.logUniform(1e-3, 1) * random.direction());
      c.search.tolerance = 1e-9;
      c.search.limit = std::numeric_limits<int>::max();
      c.search.size = 12;
      if (with_truth) c.truth = bruteForce(*snapshot, c.search.middle, c.search.half);
      cases.push_back(c);
    }
  }

  NearestFound find(const NearestSearch& search) {
    const BoxSource source(snapshot->impl(), scratch.impl().deform);
    return findNearest(search, snapshot->impl(), source);
  }

  Deformable deformable;
  std::shared_ptr<const DeformableSnapshot> snapshot;
  Scratch scratch;
  std::vector<Case> cases;
};

std::vector<Cases> allCases(bool with_truth) {
  Random random(21), numbers(22);
  std::vector<Cases> all;
  // The last kind has needles and zero-area triangles.
  for (const int kind : {0, 1, 2, 3}) {
    const Sheet sheet = kind == 1   ? testing::cloth(9, &numbers)
                        : kind == 2 ? testing::globe(6)
                                    : testing::cloth(12);
    std::vector<Vector3d> vertices = kind == 2 ? testing::exploded(sheet.vertices, 0.3, 5)
                                               : testing::waved(sheet.vertices, 0.3, kind);
    if (kind == 3) {
      for (std::size_t i = 0; i < vertices.size(); ++i)
        if (i % 3 != 0) vertices[i] = vertices[i - 1] + (i % 3 == 1 ? 0 : 1e-7) * Vector3d::UnitX();
    }
    for (const DeformStrategy strategy :
         {DeformStrategy::kRefit, DeformStrategy::kHybrid, DeformStrategy::kLazy})
      for (const bool prepared : {false, true})
        all.emplace_back(sheet, vertices, strategy, prepared, random, kSanitized ? 8 : 40,
                         with_truth);
  }
  return all;
}

TEST(DeformNearest, IsBruteForces) {
  int crossing = 0, apart = 0;
  for (Cases& cases : allCases(true)) {
    for (const Case& c : cases.cases) {
      const NearestFound found = cases.find(c.search);
      const double lower = std::min(found.lower, found.own_lower);
      ASSERT_GE(found.slot, 0);
      ASSERT_LE(lower, std::max(c.truth.upper, 0.0));
      ASSERT_GE(found.upper, c.truth.lower);
      // Skips contact: a segment that pierces a triangle is at positive distance from its edges.
      if (!(c.truth.lower > 1e-9)) {
        ++crossing;
        continue;
      }
      ++apart;
      ASSERT_LE(found.upper - lower, 1.001e-9) << toString(cases.snapshot->strategy());
      ASSERT_NEAR(found.way.norm(), found.upper, 1e-12);
      // Found again from any start; not found if it is out of reach.
      NearestSearch again = c.search;
      again.first = found.slot;
      ASSERT_NEAR(cases.find(again).upper, found.upper, 1e-9);
      again.first = 0;
      ASSERT_NEAR(cases.find(again).upper, found.upper, 1e-9);
      again.first = -1;
      again.reach = 0.99 * c.truth.lower;
      const NearestFound none = cases.find(again);
      ASSERT_GT(std::min(none.lower, none.slot >= 0 ? none.own_lower : kInfinity), again.reach);
      // A limit leaves a bound, an early exit none.
      again = c.search;
      again.limit = 3;
      const NearestFound limited = cases.find(again);
      ASSERT_LE(limited.visited, 3);
      ASSERT_LE(std::min(limited.lower, limited.slot >= 0 ? limited.own_lower : kInfinity),
                c.truth.upper);
      again = c.search;
      again.enough = 2 * c.truth.upper;
      const NearestFound near = cases.find(again);
      ASSERT_LE(near.upper, again.enough);
      ASSERT_LE(std::min(near.lower, near.own_lower), c.truth.upper);
    }
  }
  EXPECT_GT(apart, 3 * crossing);
  EXPECT_GT(crossing, 0);
}

// Triangles that share the nearest vertex or edge are equally near up to rounding. The chosen one
// must depend neither on nodes that the thread has already filled, and so closes earlier, nor on
// the start: threads with different histories must agree.
TEST(DeformNearest, UpperEndsDoNotDependOnThePast) {
  int searches = 0;
  for (Cases& cases : allCases(false)) {
    for (const Case& c : cases.cases) {
      const NearestFound found = cases.find(c.search);
      NearestSearch again = c.search;
      for (const std::int32_t first : {-1, found.slot, 0}) {
        again.first = first;
        ASSERT_EQ(cases.find(again).upper, found.upper) << toString(cases.snapshot->strategy());
        ++searches;
      }
    }
  }
  EXPECT_GT(searches, 100);
}

// With an early exit, other results must not depend on the history either: filled nodes are handled
// like unfilled ones.
TEST(DeformNearest, NodesThatAreFilledDoNotShow) {
  const auto numbersOf = [](const NearestFound& f) {
    return std::vector<double>{static_cast<double>(f.slot), f.upper, f.own_lower, f.lower,
                               static_cast<double>(f.visited)};
  };
  int filled = 0;
  for (Cases& cases : allCases(false)) {
    std::vector<NearestSearch> searches;
    std::vector<std::vector<double>> fresh;
    for (const Case& c : cases.cases) {
      for (const double share : {0.0, 1.1, 2.0}) {
        NearestSearch search = c.search;
        search.enough = share * cases.find(c.search).upper;
        searches.push_back(search);
      }
    }
    for (const NearestSearch& search : searches) {
      cases.scratch = Scratch();
      prepare(cases.scratch, *cases.snapshot);
      fresh.push_back(numbersOf(cases.find(search)));
    }
    // Twice, so that each runs after all others.
    for (int round = 0; round < 2; ++round)
      for (const NearestSearch& search : searches) cases.find(search);
    for (std::size_t i = 0; i < searches.size(); ++i) {
      ASSERT_EQ(numbersOf(cases.find(searches[i])), fresh[i])
          << toString(cases.snapshot->strategy());
      filled += cases.snapshot->strategy() != DeformStrategy::kRefit ? 1 : 0;
    }
  }
  EXPECT_GT(filled, 100);
}

// The depth search starts from the triangle found. Regression: a near-enough triangle ended the
// search, and which one came first depended on filled nodes in 1 or 2 of 5,000 overlaps.
TEST(DeformNearest, DepthsDoNotDependOnThePast) {
  Random random(24);
  const Sheet sheet = testing::globe(12);
  for (const DeformStrategy strategy : {DeformStrategy::kHybrid, DeformStrategy::kLazy}) {
    Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                          testing::optionsOf(strategy));
    ASSERT_EQ(deformable.update(testing::exploded(sheet.vertices, 0.05, 6), 1),
              UpdateStatus::kUpdated);
    const Shape mesh = Shape::deformable(deformable.snapshot());
    Scratch used;
    prepare(used, *deformable.snapshot());
    int overlaps = 0;
    for (int i = 0; i < (kSanitized ? 40 : 400); ++i) {
      const double radius = random.uniform(0.05, 0.5);
      const Shape body = random.chance(0.5) ? Shape::sphere(radius) : Shape::capsule(radius, 0.3);
      const Pose X_WS{random.rotation(), random.uniform(0.8, 1.1) * random.direction()};
      Scratch fresh;
      prepare(fresh, *deformable.snapshot());
      DistanceRequest request;
      request.depth = random.chance(0.5);
      request.node_limit = 1000;
      const DistanceResult one = distance(body, X_WS, mesh, {}, request, fresh),
                           other = distance(body, X_WS, mesh, {}, request, used);
      ASSERT_EQ(one.distance.lower, other.distance.lower) << oracle::replay(X_WS);
      ASSERT_EQ(one.distance.upper, other.distance.upper) << oracle::replay(X_WS);
      ASSERT_EQ(one.triangle_b, other.triangle_b) << oracle::replay(X_WS);
      ASSERT_EQ(one.normal, other.normal) << oracle::replay(X_WS);
      overlaps += one.distance.upper <= 0 ? 1 : 0;
    }
    EXPECT_GT(overlaps, kSanitized ? 10 : 100);
  }
}

// Balls that a first search leaves open are searched again under the same limit: every visited node
// of a lazy hierarchy is filled.
TEST(DeformNearest, LimitsHoldForBothSearches) {
  Random random(26);
  const Sheet sheet = testing::cloth(40);  // open: an inside would be queried as well
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                        testing::optionsOf(DeformStrategy::kLazy));
  ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 0.3, 1), 1), UpdateStatus::kUpdated);
  const auto snapshot = deformable.snapshot();
  const Shape mesh = Shape::deformable(snapshot);
  int cut = 0, overlaps = 0;
  for (int i = 0; i < (kSanitized ? 40 : 400); ++i) {
    const Pose X_WS{Eigen::Matrix3d::Identity(), 0.7 * random.unit() * random.direction()};
    const Shape ball = Shape::sphere(random.uniform(0.05, 0.5));
    Scratch scratch, free;
    prepare(scratch, *snapshot);
    const DistanceResult whole = distance(ball, X_WS, mesh, {}, {}, free);
    DistanceRequest request;
    request.node_limit = 2 + random.below(8);
    request.depth = random.chance(0.5);
    const DistanceResult limited = distance(ball, X_WS, mesh, {}, request, scratch);
    ASSERT_LE(limited.distance.lower, whole.distance.upper) << oracle::replay(X_WS);
    ASSERT_GE(limited.distance.upper, whole.distance.lower) << oracle::replay(X_WS);
    if (request.depth) continue;  // separating translations have limits of their own
    int filled = 0;
    for (const std::uint64_t id : scratch.impl().deform.find(snapshot->impl().owner)->stamp)
      filled += id == snapshot->id() ? 1 : 0;
    ASSERT_LE(filled, request.node_limit) << oracle::replay(X_WS);
    cut += limited.status == DistanceStatus::kLimit ? 1 : 0;
    overlaps += limited.distance.upper <= 0 ? 1 : 0;
  }
  EXPECT_GT(cut, kSanitized ? 1 : 10);
  EXPECT_GT(overlaps, kSanitized ? 1 : 40);
}

// A rebuilt hierarchy may reuse the memory of another. Cached places in the old one are void; a
// depth search would begin at an arbitrary triangle.
TEST(DeformNearest, PlacesAreOfOneHierarchy) {
  Random random(25);
  const Sheet sheet = testing::globe(12);
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                        testing::optionsOf(DeformStrategy::kRebuild));
  std::vector<std::uint64_t> ids;
  std::vector<PairCache> caches;
  Scratch scratch;
  for (int frame = 0; frame < 6; ++frame) {
    ASSERT_EQ(deformable.update(testing::exploded(sheet.vertices, 0.02 * frame, 6), frame),
              UpdateStatus::kUpdated);
    const Shape mesh = Shape::deformable(deformable.snapshot());
    for (int i = 0; i < (kSanitized ? 10 : 40); ++i) {
      const Pose X_WS{Eigen::Matrix3d::Identity(), random.uniform(0.8, 1.1) * random.direction()};
      const Shape body = Shape::sphere(random.uniform(0.05, 0.5));
      for (const PairCache& old : caches) {
        PairCache cache = old, without = old;
        without.place = -1;
        const DistanceResult one = distance(body, X_WS, mesh, {}, {}, scratch, &cache),
                             other = distance(body, X_WS, mesh, {}, {}, scratch, &without);
        ASSERT_EQ(one.distance.lower, other.distance.lower) << oracle::replay(X_WS);
        ASSERT_EQ(one.distance.upper, other.distance.upper) << oracle::replay(X_WS);
        ASSERT_EQ(one.triangle_b, other.triangle_b) << oracle::replay(X_WS);
      }
    }
    PairCache cache;
    distance(Shape::sphere(0.1), {Eigen::Matrix3d::Identity(), random.direction()}, mesh, {}, {},
             scratch, &cache);
    ASSERT_GE(cache.place, 0);
    caches.push_back(cache);
    ids.push_back(deformable.snapshot()->impl().tree->id());
  }
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::unique(ids.begin(), ids.end()), ids.end());
}

TEST(DeformNearest, SameBytesOnEveryTarget) {
  expectTheSameBytesOnEveryTarget([] {
    std::vector<double> all;
    for (Cases& cases : allCases(false)) {
      for (const Case& c : cases.cases) {
        const NearestFound f = cases.find(c.search);
        all.insert(all.end(), {static_cast<double>(f.slot), f.upper, f.own_lower, f.lower,
                               static_cast<double>(f.visited), f.from.x(), f.from.y(), f.from.z(),
                               f.way.x(), f.way.y(), f.way.z()});
      }
    }
    return all;
  });
}

// A zero-length capsule takes the general path, without this search. Arguments in either order.
TEST(DeformNearest, BallsAreCapsulesWithoutLength) {
  Random random(23);
  const Sheet sheet = testing::cloth(12);
  int contacts = 0;
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                          testing::optionsOf(strategy));
    Scratch scratch;
    PairCache cache, twins_cache;
    for (int frame = 0; frame < 4; ++frame) {
      const auto vertices = testing::waved(sheet.vertices, 0.3, frame);
      ASSERT_EQ(deformable.update(vertices, frame), UpdateStatus::kUpdated);
      prepare(scratch, *deformable.snapshot());
      const Shape mesh = Shape::deformable(deformable.snapshot());
      for (int i = 0; i < 60; ++i) {
        const double radius = random.chance(0.2) ? 0 : random.logUniform(1e-3, 0.5);
        const Pose X_WS{random.rotation(), 1.5 * random.unit() * random.direction()};
        DistanceRequest request;
        request.depth = random.chance(0.3);
        if (random.chance(0.5)) request.threshold = random.uniform(-0.1, 0.5);
        // The cached start may be arbitrary.
        if (random.chance(0.3)) {
          cache.hierarchy = deformable.snapshot()->impl().tree->id();
          cache.place = random.below(2 * static_cast<int>(sheet.triangles.size())) - 10;
        }
        PairCache turned_cache = cache;
        std::swap(turned_cache.triangle_a, turned_cache.triangle_b);
        const DistanceResult ball =
            distance(Shape::sphere(radius), X_WS, mesh, {}, request, scratch, &cache);
        const DistanceResult turned =
            distance(mesh, {}, Shape::sphere(radius), X_WS, request, scratch, &turned_cache);
        const DistanceResult twin =
            distance(Shape::capsule(radius, 0), X_WS, mesh, {}, request, scratch, &twins_cache);
        const auto told = [&] {
          return std::string(toString(strategy)) + " " + oracle::replay(X_WS) + " radius " +
                 std::to_string(radius);
        };
        ASSERT_EQ(turned.status, ball.status) << told();
        ASSERT_EQ(turned.triangle_a, ball.triangle_b) << told();
        ASSERT_EQ(turned_cache.triangle_a, cache.triangle_b) << told();
        ASSERT_EQ(turned.distance.upper, ball.distance.upper) << told();
        ASSERT_EQ(turned.point_b, ball.point_a) << told();
        ASSERT_EQ(turned.normal, -ball.normal) << told();
        // The width of a depth depends on the start.
        if (!request.depth || ball.distance.upper > 0) {
          ASSERT_EQ(ball.status == DistanceStatus::kLimit, twin.status == DistanceStatus::kLimit)
              << told();
        }
        ASSERT_EQ(ball.distance.lower > request.threshold, twin.distance.lower > request.threshold)
            << told();
        ASSERT_LE(ball.distance.lower, twin.distance.upper) << told();
        ASSERT_GE(ball.distance.upper, twin.distance.lower) << told();
        contacts += ball.distance.upper <= 0 ? 1 : 0;
        if (request.threshold == request.threshold || !(ball.distance.lower > 1e-6)) continue;
        ASSERT_LE((ball.point_a - twin.point_a).norm(), 1e-4) << told();
        ASSERT_NEAR((ball.point_b - ball.point_a).norm(), ball.distance.upper, 1e-9) << told();
        ASSERT_NEAR(ball.normal.dot(ball.point_b - ball.point_a), ball.distance.upper, 1e-9)
            << told();
      }
    }
  }
  EXPECT_GT(contacts, 50);
}

}  // namespace
}  // namespace leeway::collision
