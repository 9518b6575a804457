#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <memory_resource>
#include <mutex>
#include <thread>

#include "collision/base/numbers.h"
#include "collision/deform/snapshot.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/scene.h"
#include "leeway/collision/vertex_motion.h"
#include "tests/support/allocations.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/motion_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::Sheet;

// One wave of this height [m] along x.
std::shared_ptr<const VertexMotion> oneWave(const Sheet& sheet, double height) {
  WavesMotion motion;
  motion.rest = sheet.vertices;
  motion.waves.push_back({{1, 0, 0}, {0, 0, height}, 0.7, 1, 0});
  return VertexMotion::waves(std::move(motion));
}

TEST(DeformableMesh, ComponentsAreClosedByIndexAlone) {
  const Sheet globe = testing::globe(5), cloth = testing::cloth(4);
  EXPECT_EQ(DeformableMesh::make(globe.vertices, globe.triangles)->closedComponentCount(), 1);
  EXPECT_EQ(DeformableMesh::make(cloth.vertices, cloth.triangles)->closedComponentCount(), 0);
  // Each triangle with its own corners: nothing is welded.
  Sheet loose;
  for (const auto& t : globe.triangles) {
    const auto n = static_cast<std::int32_t>(loose.vertices.size());
    for (const std::int32_t v : t)
      loose.vertices.push_back(globe.vertices[static_cast<std::size_t>(v)]);
    loose.triangles.push_back({n, n + 1, n + 2});
  }
  const auto mesh = DeformableMesh::make(loose.vertices, loose.triangles);
  EXPECT_EQ(mesh->closedComponentCount(), 0);
  EXPECT_EQ(mesh->componentCount(), mesh->triangleCount());
}

TEST(DeformableMesh, RefusesWhatIsNoMesh) {
  const std::vector<Vector3d> v = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<DeformableMesh::Triangle> none, good = {{0, 1, 2}}, high = {{0, 1, 3}},
                                                    negative = {{0, -1, 2}};
  EXPECT_NO_THROW(DeformableMesh::make(v, good));
  EXPECT_THROW(DeformableMesh::make(v, none), InvalidShape);
  EXPECT_THROW(DeformableMesh::make(v, high), InvalidShape);
  EXPECT_THROW(DeformableMesh::make(v, negative), InvalidShape);
  for (const double bad : {kNaN, kInfinity, 2e15}) {
    std::vector<Vector3d> broken = v;
    broken[1].y() = bad;
    try {
      DeformableMesh::make(broken, good);
      ADD_FAILURE() << bad;
    } catch (const InvalidShape& e) {
      EXPECT_NE(std::string(e.what()).find("vertex 1"), std::string::npos) << e.what();
    }
  }
}

TEST(Deformable, NamesOfStrategiesGoBothWays) {
  for (int i = 0; i <= static_cast<int>(DeformStrategy::kOctree); ++i) {
    const auto strategy = static_cast<DeformStrategy>(i);
    EXPECT_EQ(deformStrategy(toString(strategy)), strategy);
  }
  EXPECT_EQ(deformStrategy("refitt"), std::nullopt);
}

TEST(Deformable, RefusesAStrategyThatTheVerticesDoNotHave) {
  const Sheet sheet = testing::cloth(3);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy s :
       {DeformStrategy::kMorph, DeformStrategy::kSkinned, DeformStrategy::kReduced}) {
    DeformOptions options;
    options.strategy = s;
    EXPECT_THROW(Deformable(mesh, nullptr, options), std::invalid_argument);
  }
}

TEST(Deformable, RefusesOptionsThatMakeNoSense) {
  const Sheet sheet = testing::cloth(3);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  const auto refused = [&](const auto& set, const std::string& told) {
    DeformOptions options;
    set(options);
    try {
      const Deformable deformable(mesh, nullptr, options);
      ADD_FAILURE() << "accepted: " << told;
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(error.what(), "deformable: " + told + " is accepted");
    }
  };
  const std::string factor = "restructure_factor is ", horizon = "speed_horizon is ";
  refused([](DeformOptions& o) { o.restructure_factor = kNaN; }, factor + "nan; a number above 1");
  refused([](DeformOptions& o) { o.restructure_factor = 0; }, factor + "0; a number above 1");
  refused([](DeformOptions& o) { o.restructure_factor = -1; }, factor + "-1; a number above 1");
  refused([](DeformOptions& o) { o.restructure_factor = 1; }, factor + "1; a number above 1");
  refused([](DeformOptions& o) { o.hybrid_split = -3; },
          "hybrid_split is -3; a count of at least 0");
  refused([](DeformOptions& o) { o.speed_horizon = kNaN; },
          horizon + "nan; a finite number of at least 0 s");
  refused([](DeformOptions& o) { o.speed_horizon = kInfinity; },
          horizon + "inf; a finite number of at least 0 s");
  refused([](DeformOptions& o) { o.speed_horizon = -0.5; },
          horizon + "-0.5; a finite number of at least 0 s");
  refused([](DeformOptions& o) { o.expected_queries = -1; },
          "expected_queries is -1; a count of at least 0");
  DeformOptions least;
  least.hybrid_split = least.expected_queries = 0;
  least.speed_horizon = 0;
  least.restructure_factor = 1.0000001;
  EXPECT_NO_THROW(Deformable(mesh, nullptr, least));
}

/// The first snapshot is refitted with every option, because its vertices may not be the motion's.
TEST(Deformable, TheFirstSnapshotIsRefitted) {
  const Sheet sheet = testing::cloth(4);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy :
       {DeformStrategy::kRefit, DeformStrategy::kRebuild, DeformStrategy::kHybrid,
        DeformStrategy::kLazy, DeformStrategy::kAuto}) {
    DeformOptions options;
    options.strategy = strategy;
    Deformable deformable(mesh, nullptr, options);
    EXPECT_EQ(deformable.statistics().strategy, DeformStrategy::kRefit);
    EXPECT_STREQ(deformable.statistics().reason, "the first snapshot is at rest");
    ASSERT_EQ(deformable.update(sheet.vertices, 1), UpdateStatus::kUpdated);
    if (strategy != DeformStrategy::kAuto) {
      EXPECT_EQ(deformable.statistics().strategy, strategy);
    }
  }
}

TEST(Deformable, BrokenInputLeavesTheLastGoodState) {
  const Sheet sheet = testing::cloth(20);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    DeformOptions options;
    options.strategy = strategy;
    Deformable deformable(mesh, nullptr, options);
    EXPECT_EQ(deformable.update(1.0), UpdateStatus::kNoMotion);
    const auto good = testing::waved(sheet.vertices, 0.2, 1);
    ASSERT_EQ(deformable.update(good, 1, 3), UpdateStatus::kUpdated);
    const auto before = deformable.snapshot();
    EXPECT_EQ(before->time(), 1);
    EXPECT_EQ(before->speedBound(), 3);
    const UpdateStatistics told = deformable.statistics();
    for (const double bad : {kNaN, kInfinity, -kInfinity, 1e10}) {
      for (const std::size_t v : {std::size_t{0}, std::size_t{217}, good.size() - 1}) {
        for (int k = 0; k < 3; ++k) {
          std::vector<Vector3d> broken = good;
          broken[v][k] = bad;
          EXPECT_EQ(deformable.update(broken, 2), UpdateStatus::kNotFinite);
          EXPECT_EQ(deformable.badVertex(), static_cast<int>(v));
          EXPECT_EQ(deformable.snapshot(), before);
          std::copy(broken.begin(), broken.end(), deformable.nextVertices().begin());
          EXPECT_EQ(deformable.commit(2), UpdateStatus::kNotFinite) << toString(strategy);
          EXPECT_EQ(deformable.snapshot(), before);
        }
      }
    }
    const std::vector<Vector3d> fewer(good.begin(), good.end() - 1);
    EXPECT_EQ(deformable.update(fewer, 2), UpdateStatus::kWrongVertexCount);
    EXPECT_EQ(deformable.update(good, kNaN), UpdateStatus::kBadTime);
    EXPECT_EQ(deformable.update(good, 2, -1), UpdateStatus::kBadTime);
    EXPECT_EQ(deformable.update(good, 2, kNaN), UpdateStatus::kBadTime);
    EXPECT_EQ(deformable.snapshot(), before);
    EXPECT_EQ(deformable.statistics().strategy, told.strategy);
    EXPECT_EQ(before->vertices()[7], good[7]);
    EXPECT_EQ(deformable.update(good, 2), UpdateStatus::kUpdated);
    EXPECT_NE(deformable.snapshot(), before);
    EXPECT_GT(deformable.snapshot()->id(), before->id());
  }
}

TEST(Deformable, UpdatesAndQueriesAllocateNothingInSteadyState) {
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy :
       {DeformStrategy::kRefit, DeformStrategy::kHybrid, DeformStrategy::kLazy,
        DeformStrategy::kOctree, DeformStrategy::kAuto}) {
    DeformOptions options;
    options.strategy = strategy;
    options.hybrid_split = 64;
    Deformable deformable(mesh, nullptr, options);
    Scratch scratch;
    PairCache cache;
    std::shared_ptr<const DeformableSnapshot> held;  // like a planner's thread
    const Shape ball = Shape::sphere(0.1), box = Shape::box({0.1, 0.2, 0.3});
    for (int frame = 0; frame < 8; ++frame) {
      const auto vertices = testing::waved(sheet.vertices, 0.2, frame);
      const std::size_t before = testing::allocationCount();
      ASSERT_EQ(deformable.update(vertices, frame), UpdateStatus::kUpdated);
      if (frame >= 3) {
        EXPECT_EQ(testing::allocationCount(), before) << toString(strategy) << frame;
      }
      held = deformable.snapshot();
      if (frame < 2) prepare(scratch, *held);
      const Shape shape = Shape::deformable(held);
      const std::size_t queries = testing::allocationCount();
      for (const double height : {0.0, 0.3, 1.0}) {
        Pose X;
        X.translation = {0.1, 0.2, height};
        distance(ball, X, shape, Pose{}, {}, scratch, &cache);
        distance(box, X, shape, Pose{}, {}, scratch, nullptr);
      }
      selfDistance(*held, {}, scratch);
      EXPECT_EQ(testing::allocationCount(), queries) << toString(strategy);
    }
    EXPECT_LE(deformable.bytes(), 4000 * static_cast<std::size_t>(mesh->vertexCount()));
  }
}

TEST(Deformable, TakesNothingFromTheDefaultResource) {
  // An embedding program's resource, which need not be thread-safe.
  std::pmr::memory_resource* const before =
      std::pmr::set_default_resource(std::pmr::null_memory_resource());
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : {DeformStrategy::kRebuild, DeformStrategy::kRebuildLinear,
                                        DeformStrategy::kRestructure, DeformStrategy::kLazy}) {
    DeformOptions options;
    options.strategy = strategy;
    EXPECT_NO_THROW({
      Deformable deformable(mesh, nullptr, options);
      const auto vertices = testing::waved(sheet.vertices, 0.4, 1);
      EXPECT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated);
      Scratch scratch;
      prepare(scratch, *deformable.snapshot());
    }) << toString(strategy);
  }
  std::pmr::set_default_resource(before);
}

// Some strategies validate vertices while reading them for boxes, which skips vertices without
// triangles.
TEST(Deformable, ChecksVerticesThatNoTriangleHas) {
  Sheet sheet = testing::cloth(20);
  sheet.vertices.push_back({0, 0, 0});
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    Deformable deformable(mesh, nullptr, testing::optionsOf(strategy));
    std::vector<Vector3d> vertices = testing::waved(sheet.vertices, 0.2, 1);
    ASSERT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated) << toString(strategy);
    for (const double bad : {kNaN, kInfinity, 1.0001e9}) {
      vertices.back().z() = bad;
      EXPECT_EQ(deformable.update(vertices, 2), UpdateStatus::kNotFinite) << toString(strategy);
      EXPECT_EQ(deformable.badVertex(), static_cast<int>(vertices.size()) - 1);
    }
  }
}

// Boxes are rounded outwards, beyond the limit.
TEST(Deformable, TakesVerticesUpToTheLimitAndNoneBeyond) {
  const Sheet sheet = testing::cloth(20);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    Deformable deformable(mesh, nullptr, testing::optionsOf(strategy));
    for (std::size_t v = 0; v < sheet.vertices.size(); v += 17) {
      std::vector<Vector3d> vertices = sheet.vertices;
      vertices[v].y() = -1e9;
      EXPECT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated) << toString(strategy);
      vertices[v].y() = std::nextafter(-1e9, -kInfinity);
      EXPECT_EQ(deformable.update(vertices, 2), UpdateStatus::kNotFinite) << toString(strategy);
      EXPECT_EQ(deformable.badVertex(), static_cast<int>(v)) << toString(strategy);
      EXPECT_EQ(deformable.snapshot()->time(), 1) << toString(strategy);
    }
  }
}

TEST(Deformable, SnapshotsOutliveTheirOwner) {
  const Sheet sheet = testing::cloth(6);
  auto deformable = std::make_unique<Deformable>(
      DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr, DeformOptions{});
  ASSERT_EQ(deformable->update(testing::waved(sheet.vertices, 0.2, 1), 1), UpdateStatus::kUpdated);
  const auto kept = deformable->snapshot();
  const Vector3d vertex = kept->vertices()[5];
  deformable.reset();
  EXPECT_EQ(kept->vertices()[5], vertex);
  Scratch scratch;
  EXPECT_GT(distance(Shape::sphere(0.1), {Eigen::Matrix3d::Identity(), {0, 0, 3}},
                     Shape::deformable(kept), Pose{}, {}, scratch)
                .distance.lower,
            2);
}

// Readers repeatedly query the newest snapshot; its answers have the same bytes at any time. Also
// run under ThreadSanitizer.
TEST(Deformable, ThreadsReadSnapshotsWhileTheNextIsMade) {
  const Sheet sheet = testing::cloth(16);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : {DeformStrategy::kRefit, DeformStrategy::kHybrid}) {
    DeformOptions options;
    options.strategy = strategy;
    Deformable deformable(mesh, nullptr, options);
    constexpr int kFrames = 60;
    std::vector<double> expected;
    const auto ask = [](const std::shared_ptr<const DeformableSnapshot>& snapshot,
                        Scratch& scratch) {
      prepare(scratch, *snapshot);
      return distance(Shape::sphere(0.2), {Eigen::Matrix3d::Identity(), {0.2, 0.1, 0.8}},
                      Shape::deformable(snapshot), Pose{}, {}, scratch)
          .distance.upper;
    };
    Scratch scratch;
    for (int frame = 0; frame < kFrames; ++frame) {
      ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 0.3, frame), frame),
                UpdateStatus::kUpdated);
      expected.push_back(ask(deformable.snapshot(), scratch));
    }
    std::mutex newest_mutex;
    std::shared_ptr<const DeformableSnapshot> newest = deformable.snapshot();
    std::atomic<bool> over{false};
    std::atomic<int> wrong{0}, asked{0};
    const auto read = [&] {
      Scratch own;
      while (!over.load()) {
        std::shared_ptr<const DeformableSnapshot> snapshot;
        {
          const std::lock_guard<std::mutex> lock(newest_mutex);
          snapshot = newest;
        }
        const auto frame = static_cast<std::size_t>(snapshot->time());
        if (ask(snapshot, own) != expected[frame]) ++wrong;
        ++asked;
      }
    };
    std::thread first(read), second(read);
    for (int round = 0; round < 4 || asked.load() < 20; ++round) {
      for (int frame = 0; frame < kFrames; ++frame) {
        ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 0.3, frame), frame),
                  UpdateStatus::kUpdated);
        const std::lock_guard<std::mutex> lock(newest_mutex);
        newest = deformable.snapshot();
      }
    }
    over = true;
    first.join();
    second.join();
    EXPECT_EQ(wrong.load(), 0);
  }
}

TEST(Deformable, AMotionIsFollowedByItsOwnBounds) {
  const Sheet sheet = testing::cloth(10);
  MorphMotion motion;
  motion.references = {sheet.vertices, testing::waved(sheet.vertices, 0.4, 1)};
  motion.keys = {{0, {1, 0}}, {1, {0, 1}}};
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  Deformable deformable(mesh, VertexMotion::morph(std::move(motion)));
  ASSERT_EQ(deformable.update(0.5), UpdateStatus::kUpdated);
  EXPECT_EQ(deformable.statistics().strategy, DeformStrategy::kMorph);
  EXPECT_GT(deformable.snapshot()->speedBound(), 0);
  EXPECT_LT(deformable.snapshot()->speedBound(), 1);
  // The caller's vertices differ from the motion's.
  ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 3, 2), 1), UpdateStatus::kUpdated);
  EXPECT_NE(deformable.statistics().strategy, DeformStrategy::kMorph);
  EXPECT_GT(deformable.snapshot()->high().z(), 1);
}

// Motion bounds are memory, too: at least 64 bytes for each node and each axis of a morph target.
TEST(Deformable, BytesCountBoundsFromTheMotion) {
  const Sheet sheet = testing::cloth(10);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  const auto bytesOf = [&](DeformStrategy strategy, std::size_t targets) {
    MorphMotion motion;
    motion.references.assign(targets, testing::waved(sheet.vertices, 0.4, 1));
    motion.keys = {{0, std::vector<double>(targets, 1.0 / static_cast<double>(targets))}};
    DeformOptions options;
    options.strategy = strategy;
    return Deformable(mesh, VertexMotion::morph(std::move(motion)), options).bytes();
  };
  const std::size_t refit = bytesOf(DeformStrategy::kRefit, 2),
                    two = bytesOf(DeformStrategy::kMorph, 2),
                    four = bytesOf(DeformStrategy::kMorph, 4);
  EXPECT_GT(two, refit + 1000);
  EXPECT_GT(four, two + 1000);
}

// Boxes from modes (waves included) and bones are looser than boxes of vertices but need no vertex,
// so they are worthwhile while queries are few. Boxes from morph targets are tight.
TEST(Deformable, LooserBoxesOfAMotionAreTakenWhereQueriesAreFew) {
  int kinds = 0;
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(10, 9)) {
    const MotionKind kind = c.motion->kind();
    const bool loose =
        kind == MotionKind::kWaves || kind == MotionKind::kReduced || kind == MotionKind::kSkinned;
    const DeformStrategy own = kind == MotionKind::kSkinned ? DeformStrategy::kSkinned
                               : kind == MotionKind::kMorph ? DeformStrategy::kMorph
                                                            : DeformStrategy::kReduced;
    if (!loose && kind != MotionKind::kMorph) continue;
    ++kinds;
    const auto mesh = DeformableMesh::make(c.mesh.vertices, c.mesh.triangles);
    for (const int queries : {0, 12}) {
      DeformOptions options;
      options.expected_queries = queries;
      Deformable deformable(mesh, c.motion, options);
      ASSERT_EQ(deformable.update(0.5), UpdateStatus::kUpdated);
      EXPECT_EQ(deformable.statistics().strategy,
                loose && queries > 0 ? DeformStrategy::kHybrid : own)
          << c.name << ", " << queries << " queries";
    }
  }
  EXPECT_GE(kinds, 4);
}

// A rebuild must save more than its cost and that of later updates; without many queries it does
// not.
TEST(Deformable, ADecayedHierarchyIsBuiltAnewForMany) {
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const int queries : {0, 10000}) {
    DeformOptions options;
    options.expected_queries = queries;
    options.hybrid_split = 40;
    Deformable deformable(mesh, nullptr, options);
    int rebuilt = 0;
    for (int frame = 0; frame < 20; ++frame) {
      // The halves turn against one another: neighbours along the middle separate.
      std::vector<Vector3d> vertices(sheet.vertices);
      for (Vector3d& v : vertices) v.z() = 0.1 * frame * (v.x() > 0 ? v.y() : -v.y());
      ASSERT_EQ(deformable.update(vertices, frame), UpdateStatus::kUpdated);
      rebuilt += deformable.statistics().strategy == DeformStrategy::kRebuild ? 1 : 0;
    }
    EXPECT_EQ(rebuilt > 0, queries > 0) << rebuilt;
  }
}

// A folded sheet.
Sheet foldedSheet(std::vector<Vector3d>& flat) {
  constexpr int kFolds = 10, kCells = 60;
  Sheet sheet;
  for (int i = 0; i <= kCells; ++i) {
    const int folded =
        i % (2 * kFolds) <= kFolds ? i % (2 * kFolds) : 2 * kFolds - i % (2 * kFolds);
    for (int j = 0; j <= kCells; ++j) {
      sheet.vertices.emplace_back(0.02 * folded, 0.02 * j, 1e-3 * i);
      flat.emplace_back(0.02 * i, 0.02 * j, 0);
    }
  }
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const int a = i * (kCells + 1) + j, b = a + kCells + 1;
      sheet.triangles.push_back({a, b, b + 1});
      sheet.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return sheet;
}

UpdateStatus commitMoved(Deformable& deformable, const std::vector<Vector3d>& vertices,
                         double moved) {
  const std::span<Vector3d> next = deformable.nextVertices();
  std::copy(vertices.begin(), vertices.end(), next.begin());
  return deformable.commit(0, 1, Deformable::Vertices::kFinite, moved);
}

// A sheet folded when its hierarchy was built, now flat. Returns the frame in which `auto` rebuilds
// if bounds on vertex motion are missing in every `period`-th frame; -1: not within 2000.
int frameBuiltAnew(int split, int queries, int period) {
  std::vector<Vector3d> flat;
  const Sheet sheet = foldedSheet(flat);
  DeformOptions options;
  options.expected_queries = queries;
  options.hybrid_split = split;
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr, options);
  for (int frame = 0; frame < 2000; ++frame) {
    const double moved = frame % period == 0 ? kInfinity : 1e-6;
    EXPECT_EQ(commitMoved(deformable, flat, moved), UpdateStatus::kUpdated);
    if (deformable.statistics().strategy == DeformStrategy::kRebuild) return frame;
  }
  return -1;
}

// Frames count towards a rebuild even if the rotation through the branches is repeatedly
// interrupted.
TEST(Deformable, FramesOfTurnsCutShortCountForARebuild) {
  const int known_never = frameBuiltAnew(40, 20, 1);
  EXPECT_GT(known_never, 8);
  for (const int period : {2, 3, 5}) {
    const int frame = frameBuiltAnew(40, 20, period);
    EXPECT_GE(frame, known_never - period) << period;
    EXPECT_LE(frame, known_never + period) << period;
  }
}

// A mesh nearly at rest reads few branches, but must not wait for all of them before a rebuild.
TEST(Deformable, ADecayedHierarchyAtRestIsBuiltAnewSoon) {
  for (const int split : {0, 20, 40}) {
    const int frame = frameBuiltAnew(split, 200, 1 << 30);
    EXPECT_GE(frame, 1) << split;
    EXPECT_LE(frame, 16) << split;
  }
}

// Decay is also detected when all nodes count as upper ones.
TEST(Deformable, ADecayedHierarchyWithoutBranchesIsBuiltAnew) {
  for (const int split : {1, 8}) {
    if (isBrief() && split == 1) continue;
    const int frame = frameBuiltAnew(split, 200, 1);
    EXPECT_GE(frame, 1) << split;
    EXPECT_LT(frame, 100) << split;
    EXPECT_EQ(frameBuiltAnew(split, 0, 1), -1) << split;
  }
}

// When `auto` decides to rebuild, most branches were not read in that frame. A non-finite vertex
// there, which violates the caller's guarantee, must not reach the builder; the hierarchy is kept.
TEST(Deformable, ARebuildOfWhatWasNotReadLooksAtItFirst) {
  const int frame = frameBuiltAnew(40, 20, 1 << 30);
  ASSERT_GT(frame, 1);
  std::vector<Vector3d> flat;
  const Sheet sheet = foldedSheet(flat);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  DeformOptions options;
  options.expected_queries = 20;
  options.hybrid_split = 40;
  for (std::size_t i = 0; i < flat.size(); i += 97) {
    Deformable deformable(mesh, nullptr, options);
    for (int f = 0; f < frame; ++f) {
      ASSERT_EQ(commitMoved(deformable, flat, f == 0 ? kInfinity : 1e-6), UpdateStatus::kUpdated);
    }
    const auto before = deformable.snapshot();
    std::vector<Vector3d> spoilt(flat);
    spoilt[i].y() = kNaN;
    ASSERT_EQ(commitMoved(deformable, spoilt, 1e-6), UpdateStatus::kNotFinite);
    EXPECT_EQ(deformable.badVertex(), static_cast<int>(i));
    EXPECT_EQ(deformable.snapshot(), before);
    ASSERT_EQ(commitMoved(deformable, flat, 1e-6), UpdateStatus::kUpdated);
    if (deformable.statistics().strategy == DeformStrategy::kHybrid) {
      EXPECT_EQ(deformable.snapshot()->impl().tree, before->impl().tree) << i;
    }
  }
}

// Upper nodes' boxes hold all vertices below them.
void expectHeld(const DeformableSnapshot& snapshot) {
  const DeformableSnapshotImpl& s = snapshot.impl();
  for (std::int32_t node = 0; node < s.tree->upperCount(); ++node) {
    const WideBox& box = s.boxes[static_cast<std::size_t>(node)];
    for (int column = 0; column < kWidth; ++column) {
      for (const std::int32_t v : s.tree->vertices(node, column)) {
        const Vector3d& p = s.vertices[static_cast<std::size_t>(v)];
        for (int k = 0; k < 3; ++k) {
          ASSERT_LE(static_cast<double>(box.low[k][column]), p[k]) << node << " " << column;
          ASSERT_GE(static_cast<double>(box.high[k][column]), p[k]) << node << " " << column;
        }
      }
    }
  }
}

// With known bounds on vertex motion, hybrid updates read the branches in rotation.
TEST(Deformable, BranchesThatAreReadInTurnsHoldTheirVertices) {
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  Deformable deformable(mesh, nullptr, testing::optionsOf(DeformStrategy::kHybrid));
  std::vector<Vector3d> before(sheet.vertices);
  int few = 0;
  for (int frame = 0; frame < 200; ++frame) {
    // Fast, slow, at rest, and by a distance of the mesh's size.
    const double phase = frame < 60 ? 0.02 * frame : frame < 120 ? 1.2 + 1e-3 * frame : 1.32;
    const auto vertices = testing::waved(sheet.vertices, 0.3,
                                         frame == 150   ? 7
                                         : frame == 180 ? 2.5
                                                        : phase);
    double moved = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i)
      moved = std::max(moved, (vertices[i] - before[i]).norm() * (1 + 1e-12));
    before = vertices;
    const std::span<Vector3d> next = deformable.nextVertices();
    std::copy(vertices.begin(), vertices.end(), next.begin());
    ASSERT_EQ(deformable.commit(frame, 1, Deformable::Vertices::kFinite, moved),
              UpdateStatus::kUpdated);
    expectHeld(*deformable.snapshot());
    if (HasFatalFailure()) return;
    few += 2 * deformable.statistics().vertices_touched < mesh->vertexCount() ? 1 : 0;
    // Boxes stay tight.
    ASSERT_LT(deformable.snapshot()->high().z(), 0.3 + 0.1) << frame;
  }
  EXPECT_GT(few, 120);
  EXPECT_EQ(deformable.commit(200, 1, Deformable::Vertices::kFinite, -1), UpdateStatus::kBadTime);
  EXPECT_EQ(deformable.commit(200, 1, Deformable::Vertices::kFinite, kNaN), UpdateStatus::kBadTime);
}

// A motion's bounds hold in both directions of time.
TEST(Deformable, AMotionsBranchesAreReadInTurns) {
  const Sheet sheet = testing::cloth(24);
  const auto waves = oneWave(sheet, 0.1);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  Deformable deformable(mesh, waves, testing::optionsOf(DeformStrategy::kHybrid));
  int few = 0;
  double time = 1e3;
  for (int frame = 0; frame < 200; ++frame) {
    time += frame < 50 ? 0.01 : frame < 100 ? -0.004 : frame == 120 ? 0.4 : 1e-9;
    ASSERT_EQ(deformable.update(time), UpdateStatus::kUpdated);
    expectHeld(*deformable.snapshot());
    if (HasFatalFailure()) return;
    few += 2 * deformable.statistics().vertices_touched < mesh->vertexCount() ? 1 : 0;
    if (frame != 150) continue;
    // Interleaved vertices that are not the motion's.
    ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 3, 2), time),
              UpdateStatus::kUpdated);
    expectHeld(*deformable.snapshot());
    EXPECT_GT(deformable.snapshot()->high().z(), 1);
  }
  EXPECT_GT(few, 120);
}

// Branches under every kind of motion: displaced by its bounds and read in rotation.
TEST(Deformable, BranchesFollowEveryMotion) {
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(24, 31)) {
    const auto mesh = DeformableMesh::make(c.mesh.vertices, c.mesh.triangles);
    DeformOptions options;
    options.strategy = DeformStrategy::kHybrid;
    options.hybrid_split = 16;
    Deformable deformable(mesh, c.motion, options);
    Random random(32);
    int few = 0;
    double time = 0;
    for (int frame = 0; frame < 150; ++frame) {
      // Back and forth, across keys, occasionally far.
      time += random.chance(0.05) ? random.uniform(-0.5, 0.6) : random.uniform(-4e-4, 8e-4);
      ASSERT_EQ(deformable.update(time), UpdateStatus::kUpdated) << c.name;
      expectHeld(*deformable.snapshot());
      if (HasFatalFailure()) FAIL() << c.name << ", frame " << frame;
      few += 2 * deformable.statistics().vertices_touched < mesh->vertexCount() ? 1 : 0;
      // Between stored frames boxes are interpolated.
      if (c.motion->kind() == MotionKind::kCache) {
        EXPECT_EQ(deformable.statistics().vertices_touched, 0);
      }
    }
    EXPECT_GT(few, 75) << c.name;
  }
}

// 0 m/s times an infinite duration, or amplitude 0 times an infinite argument, is NaN: no bound on
// the vertices' motion.
TEST(Deformable, BranchesAreReadAfterTimesThatNoDoubleHolds) {
  const motion_cases::RestMesh cloth = motion_cases::cloth(40);
  const auto mesh = DeformableMesh::make(cloth.vertices, cloth.triangles);
  ReducedMotion one_key;
  one_key.rest = cloth.vertices;
  one_key.modes.push_back(cloth.vertices);
  one_key.keys.push_back({0, {0.5}});
  WavesMotion still;
  still.rest = cloth.vertices;
  still.waves.push_back({{1, 0, 0}, {0, 0.1, 0}, 1, 0, 0});
  ReducedMotion off;
  off.rest = cloth.vertices;
  off.modes.assign(2, std::vector<Vector3d>(cloth.vertices.size(), Vector3d(0, 0.1, 0)));
  off.harmonics = {{0, 1, 0}, {1, 0.3, 0}};
  struct Case {
    std::shared_ptr<const VertexMotion> motion;
    double times[2];
  };
  const Case cases[] = {{VertexMotion::reduced(one_key), {-1e308, 1e308}},
                        {VertexMotion::waves(still), {-1e308, 1e308}},
                        {VertexMotion::reduced(off), {1e308, 1}}};
  for (const Case& c : cases) {
    for (const DeformStrategy strategy : {DeformStrategy::kAuto, DeformStrategy::kHybrid}) {
      DeformOptions options;
      options.strategy = strategy;
      options.hybrid_split = 100;
      Deformable deformable(mesh, c.motion, options);
      for (const double time : c.times) {
        ASSERT_EQ(deformable.update(time), UpdateStatus::kUpdated) << time;
        ASSERT_EQ(deformable.statistics().strategy, DeformStrategy::kHybrid);
        expectHeld(*deformable.snapshot());
        if (HasFatalFailure()) FAIL() << toString(c.motion->kind()) << " at " << time;
      }
    }
  }
  // An overflowing argument makes vertices NaN even at amplitude 0.
  off.harmonics = {{0, 1e15, 0}, {1, 0, 0}};
  for (const DeformStrategy strategy : {DeformStrategy::kHybrid, DeformStrategy::kReduced}) {
    DeformOptions options;
    options.strategy = strategy;
    options.hybrid_split = 100;
    Deformable deformable(mesh, VertexMotion::reduced(off), options);
    ASSERT_EQ(deformable.update(0), UpdateStatus::kUpdated);
    EXPECT_EQ(deformable.update(1e300), UpdateStatus::kNotFinite);
    EXPECT_EQ(deformable.badVertex(), 0);
  }
}

// Displaced and grown boxes may exceed the limit for vertices.
TEST(Deformable, GrownBoxesBeyondTheLimitAreReadAgain) {
  motion_cases::RestMesh cloth = motion_cases::cloth(40);
  for (Vector3d& v : cloth.vertices) v = 2 * 9.9e8 * (v - Vector3d(0.5, 0, 0.5));
  const auto mesh = DeformableMesh::make(cloth.vertices, cloth.triangles);
  DeformOptions options;
  options.strategy = DeformStrategy::kHybrid;
  options.hybrid_split = 100;
  Deformable deformable(mesh, nullptr, options);
  for (int frame = 0; frame < 12; ++frame) {
    ASSERT_EQ(commitMoved(deformable, cloth.vertices, 2e7), UpdateStatus::kUpdated) << frame;
    expectHeld(*deformable.snapshot());
    EXPECT_LT(deformable.snapshot()->high().x(), 1.01e9);
  }
  // Vertices beyond the limit are still refused.
  std::vector<Vector3d> beyond(cloth.vertices);
  for (Vector3d& v : beyond) v *= 1.03;
  EXPECT_EQ(commitMoved(deformable, beyond, kInfinity), UpdateStatus::kNotFinite);
}

// Reused memory holds an older state, arbitrarily far from the current one.
TEST(Deformable, ACommitOfNothingNewReadsAll) {
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : {DeformStrategy::kHybrid, DeformStrategy::kAuto}) {
    Deformable deformable(mesh, oneWave(sheet, 0.5), testing::optionsOf(strategy));
    for (const double time : {0.1, 0.2, 0.3, 0.7})
      ASSERT_EQ(deformable.update(time), UpdateStatus::kUpdated);
    // Twice in a row; after a refused evaluation; after a refused commit; and with a motion bound
    // for data that was not prepared.
    ASSERT_EQ(deformable.commit(0.8), UpdateStatus::kUpdated);
    expectHeld(*deformable.snapshot());
    ASSERT_EQ(deformable.evaluate(0.71), UpdateStatus::kUpdated);
    ASSERT_EQ(deformable.commit(0.71), UpdateStatus::kUpdated);
    ASSERT_EQ(deformable.evaluate(kNaN), UpdateStatus::kBadTime);
    ASSERT_EQ(deformable.commit(0.71), UpdateStatus::kUpdated);
    expectHeld(*deformable.snapshot());
    ASSERT_EQ(deformable.update(0.1), UpdateStatus::kUpdated);
    ASSERT_EQ(deformable.update(0.7), UpdateStatus::kUpdated);
    ASSERT_EQ(deformable.evaluate(0.1), UpdateStatus::kUpdated);
    ASSERT_EQ(deformable.commit(kNaN), UpdateStatus::kBadTime);
    ASSERT_EQ(deformable.commit(0.7, kInfinity, Deformable::Vertices::kFinite, 0),
              UpdateStatus::kUpdated);
    expectHeld(*deformable.snapshot());
  }
}

// A span of the next vertices is writable until the commit, so evaluated vertices may no longer be
// the motion's.
TEST(Deformable, AnEvaluationsVerticesCanBeChanged) {
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const DeformStrategy strategy : {DeformStrategy::kHybrid, DeformStrategy::kAuto}) {
    DeformOptions options;
    options.strategy = strategy;
    options.hybrid_split = 40;
    for (const bool twice : {false, true}) {
      Deformable deformable(mesh, oneWave(sheet, 0.5), options);
      ASSERT_EQ(deformable.update(0.1), UpdateStatus::kUpdated);
      ASSERT_EQ(deformable.update(0.10001), UpdateStatus::kUpdated);
      std::span<Vector3d> next = deformable.nextVertices();
      ASSERT_EQ(deformable.evaluate(0.10002), UpdateStatus::kUpdated);
      if (twice) {
        ASSERT_EQ(deformable.evaluate(0.10002), UpdateStatus::kUpdated);
      }
      for (Vector3d& v : next) v.z() += 1;
      ASSERT_EQ(deformable.commit(0.10002, kInfinity, Deformable::Vertices::kUnchecked, 0),
                UpdateStatus::kUpdated);
      expectHeld(*deformable.snapshot());
      EXPECT_GT(deformable.snapshot()->high().z(), 1);
      // The commit ended the span: vertices evaluated now are the motion's, and few are read.
      ASSERT_EQ(deformable.update(0.10002), UpdateStatus::kUpdated);
      ASSERT_EQ(deformable.evaluate(0.10003), UpdateStatus::kUpdated);
      ASSERT_EQ(deformable.commit(0.10003), UpdateStatus::kUpdated);
      expectHeld(*deformable.snapshot());
      EXPECT_LT(2 * deformable.statistics().vertices_touched, mesh->vertexCount());
      // A non-finite vertex is found at any place.
      const auto before = deformable.snapshot();
      for (std::size_t i = 0; i < sheet.vertices.size(); ++i) {
        next = deformable.nextVertices();
        ASSERT_EQ(deformable.evaluate(0.10004), UpdateStatus::kUpdated);
        next[i].x() = kNaN;
        ASSERT_EQ(deformable.commit(0.10004), UpdateStatus::kNotFinite);
        ASSERT_EQ(deformable.badVertex(), static_cast<int>(i));
      }
      EXPECT_EQ(deformable.snapshot(), before);
    }
  }
}

// An embedding program's motion: finite bounds, but one vertex turns NaN after a while.
class Spoilt : public VertexMotion {
 public:
  explicit Spoilt(const Sheet& sheet)
      : VertexMotion(MotionKind::kOwn, static_cast<int>(sheet.vertices.size()), 1, {}),
        rest_(sheet.vertices) {}
  void parameters(double time, std::span<double> out) const override { out[0] = time; }
  void vertices(std::span<const double> parameters, int first,
                std::span<Vector3d> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t v = static_cast<std::size_t>(first) + i;
      out[i] = rest_[v] + Vector3d(0, 0, 1e-3 * std::sin(parameters[0]));
      if (v == spoilt && parameters[0] > 1.5e-4) out[i].x() = kNaN;
    }
  }
  double speedBound(double, double) const override { return 1e-3; }
  double accelerationBound(double, double) const override { return 1e-3; }
  double rounding(double, double) const override { return 1e-12; }

  std::size_t spoilt = 0;

 private:
  std::vector<Vector3d> rest_;
};

TEST(Deformable, AnOwnMotionsVerticesAreChecked) {
  const Sheet sheet = testing::cloth(24);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  DeformOptions options;
  options.hybrid_split = 40;
  for (const DeformStrategy strategy : {DeformStrategy::kHybrid, DeformStrategy::kAuto}) {
    options.strategy = strategy;
    const auto motion = std::make_shared<Spoilt>(sheet);
    for (std::size_t i = 0; i < sheet.vertices.size(); ++i) {
      motion->spoilt = i;
      Deformable deformable(mesh, motion, options);
      ASSERT_EQ(deformable.update(0), UpdateStatus::kUpdated);
      ASSERT_EQ(deformable.update(1e-4), UpdateStatus::kUpdated);
      ASSERT_EQ(deformable.update(2e-4), UpdateStatus::kNotFinite);
      ASSERT_EQ(deformable.badVertex(), static_cast<int>(i));
    }
  }
}

TEST(Deformable, AScenesShapeFollows) {
  const Sheet sheet = testing::cloth(10);
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles));
  SceneBuilder builder;
  Body arm{"arm", {{Shape::capsule(0.1, 0.3), Pose{}, "link"}}, true, Pose{}};
  Body curtain{
      "curtain", {{Shape::deformable(deformable.snapshot()), Pose{}, "sheet"}}, false, Pose{}};
  builder.add(arm);
  builder.add(curtain);
  Scene scene = builder.build();
  Workspace workspace(scene);
  Pose X;
  X.translation = {0, 0, 1};
  workspace.setPose(0, X);
  SceneResult r = clearance(scene, workspace, 1e-9);
  EXPECT_NEAR(r.clearance.lower, 0.6, 1e-6);
  EXPECT_EQ(r.verdict, Verdict::kFree);
  std::vector<Vector3d> risen = sheet.vertices;
  for (Vector3d& v : risen) v.z() += 0.7;
  ASSERT_EQ(deformable.update(risen, 1), UpdateStatus::kUpdated);
  scene.setShape(1, 0, Shape::deformable(deformable.snapshot()));
  EXPECT_EQ(decide(scene, workspace).verdict, Verdict::kNotFree);
}

}  // namespace
}  // namespace leeway::collision
