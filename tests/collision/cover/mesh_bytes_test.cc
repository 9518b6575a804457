#include "collision/cover/mesh_bytes.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <cstring>

#include "collision/base/parallel.h"
#include "collision/cover/ball_cover.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/shape.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision::testing {
namespace {

using Eigen::Vector3d;

// A body with convex pieces: a fine L, closed and concave.
TriangleSoup fineAngle() {
  Random random(5);
  TriangleSoup soup = ballSoup(18, 24, 0.4, 0, random);
  append(soup, ballSoup(18, 24, 0.3, 0, random), {Eigen::Matrix3d::Identity(), {0.9, 0, 0}});
  return soup;
}

std::vector<NamedMesh> meshes() {
  std::vector<NamedMesh> all = sampleMeshes(3);
  all.push_back(named("with pieces", fineAngle()));
  return all;
}

MeshAndBytes made(const TriangleMesh& mesh) {
  return makeMeshAndBytes(mesh.vertices(), mesh.triangles());
}

template <class T>
void expectSame(std::span<const T> a, std::span<const T> b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i], b[i]) << what << ' ' << i;
}

void expectSameHull(const ConvexHull& a, const ConvexHull& b) {
  expectSame(a.vertices(), b.vertices(), "hull vertex");
  expectSame(a.facets(), b.facets(), "hull facet");
  ASSERT_EQ(a.hasNeighbours(), b.hasNeighbours());
  for (std::size_t v = 0; v < a.vertices().size(); ++v) {
    const auto i = static_cast<std::int32_t>(v);
    expectSame(a.neighbours(i), b.neighbours(i), "neighbours");
  }
}

void expectSameNode(const MeshTree& a, const MeshTree& b, int i) {
  const MeshNode &n = a.node(i), &m = b.node(i);
  EXPECT_EQ(n.center, m.center);
  EXPECT_EQ(n.radius, m.radius);
  EXPECT_EQ(n.low, m.low);
  EXPECT_EQ(n.high, m.high);
  EXPECT_EQ(n.excess, m.excess);
  EXPECT_EQ(n.extent, m.extent);
  EXPECT_EQ(n.right, m.right);
  EXPECT_EQ(n.triangle_begin, m.triangle_begin);
  EXPECT_EQ(n.triangle_end, m.triangle_end);
  EXPECT_EQ(n.component, m.component);
  const ConvexView v = a.nodeView(n), w = b.nodeView(m);
  expectSame(std::span(v.points, static_cast<std::size_t>(v.count)),
             std::span(w.points, static_cast<std::size_t>(w.count)), "core");
}

void expectSameBoxes(const BoxTree& a, const BoxTree& b) {
  ASSERT_EQ(a.nodes().size(), b.nodes().size());
  ASSERT_EQ(a.firstPiece(), b.firstPiece());
  for (std::size_t i = 0; i < a.nodes().size(); ++i) {
    const BoxNode &n = a.nodes()[i], &m = b.nodes()[i];
    ASSERT_EQ(n.count, m.count);
    for (int lane = 0; lane < n.count; ++lane) {
      ASSERT_EQ(n.child[lane], m.child[lane]);
      const OrientedBox p = n.box(lane), q = m.box(lane);
      ASSERT_EQ(std::memcmp(&p, &q, sizeof(p)), 0);
    }
  }
}

void expectSameMesh(const TriangleMesh& a, const TriangleMesh& b) {
  expectSame(a.vertices(), b.vertices(), "vertex");
  expectSame(a.triangles(), b.triangles(), "triangle");
  ASSERT_EQ(a.componentCount(), b.componentCount());
  for (int c = 0; c < a.componentCount(); ++c) EXPECT_EQ(a.isClosed(c), b.isClosed(c));
  EXPECT_EQ(a.hullExcess(), b.hullExcess());
  EXPECT_EQ(a.pieces().use, b.pieces().use);
  EXPECT_EQ(a.pieces().pieces, b.pieces().pieces);
  EXPECT_EQ(a.pieces().excess, b.pieces().excess);
  const MeshTree &s = a.tree(), &t = b.tree();
  ASSERT_EQ(s.nodes().size(), t.nodes().size());
  for (int i = 0; i < static_cast<int>(s.nodes().size()); ++i) expectSameNode(s, t, i);
  EXPECT_EQ(s.extent(), t.extent());
  expectSameHull(s.hull(), t.hull());
  ASSERT_EQ(s.pieceCount(), t.pieceCount());
  for (int i = 0; i < s.pieceCount(); ++i) {
    expectSameHull(s.pieceHull(i), t.pieceHull(i));
    EXPECT_EQ(s.pieceExcess(i), t.pieceExcess(i));
    EXPECT_EQ(s.boxes().pieceNode(i), t.boxes().pieceNode(i));
  }
  expectSameBoxes(s.boxes(), t.boxes());
}

void expectSameCover(const BallCover& a, const BallCover& b) {
  ASSERT_EQ(a.outer.size(), b.outer.size());
  for (std::size_t i = 0; i < a.outer.size(); ++i) {
    EXPECT_EQ(a.outer[i].center, b.outer[i].center);
    EXPECT_EQ(a.outer[i].radius, b.outer[i].radius);
  }
  ASSERT_EQ(a.inner.size(), b.inner.size());
  expectSame<Vector3d>(a.points.points, b.points.points, "cover point");
  expectSame<Vector3d>(a.points.fine, b.points.fine, "fine point");
  EXPECT_EQ(a.points.clusters, b.points.clusters);
  EXPECT_EQ(a.points.nearest, b.points.nearest);
  ASSERT_EQ(a.parts.size(), b.parts.size());
  for (std::size_t i = 0; i < a.parts.size(); ++i) {
    EXPECT_EQ(a.parts[i].ball.radius, b.parts[i].ball.radius);
    expectSame<Vector3d>(a.parts[i].points.points, b.parts[i].points.points, "part");
  }
}

// Queries of all kinds, which read the whole mesh. Returns their answers' bytes.
std::vector<double> answers(const std::shared_ptr<const TriangleMesh>& mesh, int poses) {
  const Shape shape = Shape::mesh(mesh);
  const std::vector<Shape> others = {Shape::sphere(0.1), Shape::box({0.2, 0.1, 0.05}),
                                     Shape::cylinder(0.1, 0.2), shape};
  Random random(11);
  std::vector<double> numbers;
  for (int i = 0; i < poses; ++i) {
    const Pose X = random.pose(1.2), Y = random.pose(0.2);
    for (const Shape& other : others) {
      const DistanceResult r = distance(shape, X, other, Y);
      for (const double n : {r.distance.lower, r.distance.upper}) numbers.push_back(n);
      for (const Vector3d& v : {r.normal, r.point_a, r.point_b})
        for (const double n : v) numbers.push_back(n);
    }
  }
  return numbers;
}

bool sameBytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(MeshBytes, GiveTheSameMeshAgain) {
  bool pieces = false, parts = false, open = false;
  for (const NamedMesh& given : meshes()) {
    SCOPED_TRACE(given.name);
    const MeshAndBytes built = made(*given.mesh);
    const std::shared_ptr<const TriangleMesh> read = meshFromBytes(built.bytes);
    ASSERT_NE(read, nullptr);
    expectSameMesh(*built.mesh, *read);
    const auto cover = coverOf(Shape::mesh(read));
    expectSameCover(*coverOf(Shape::mesh(built.mesh)), *cover);
    EXPECT_TRUE(sameBytes(answers(built.mesh, 8), answers(read, 8)));
    pieces = pieces || read->pieces().pieces > 0;
    parts = parts || !cover->parts.empty();
    open = open || read->closedComponentCount() < read->componentCount();
  }
  EXPECT_TRUE(pieces && parts && open) << "the meshes do not show all that is kept";
}

TEST(MeshBytes, AreTheSameForTheSameMesh) {
  const TriangleSoup soup = fineAngle();
  EXPECT_EQ(makeMeshAndBytes(soup.vertices, soup.triangles).bytes,
            makeMeshAndBytes(soup.vertices, soup.triangles).bytes);
}

// Large meshes are built by several threads if there are enough cores.
TEST(MeshBytes, AreTheSameForAnyNumberOfThreads) {
  cpu_set_t all, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof(all), &all), 0);
  if (CPU_COUNT(&all) < 2) GTEST_SKIP() << "one core";
  CPU_ZERO(&one);
  for (std::size_t cpu = 0; CPU_COUNT(&one) == 0; ++cpu) {
    if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &one);
  }
  Random random(7);
  // In brief, each part is built by one thread; --full and ThreadSanitizer build parts by several.
  TriangleSoup soup = isBrief() ? torusSoup(30, 20, 0.6, 0.2, 0.02, random)
                                : torusSoup(180, 130, 0.6, 0.2, 0.02, random);
  append(soup, isBrief() ? ballSoup(10, 12, 0.2, 0, random) : ballSoup(60, 80, 0.2, 0, random),
         {Eigen::Matrix3d::Identity(), {1.2, 0, 0}});
  ASSERT_TRUE(isBrief() || soup.triangles.size() > 2 * kWorthAThread);
  const MeshAndBytes many = makeMeshAndBytes(soup.vertices, soup.triangles);
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  const MeshAndBytes alone = makeMeshAndBytes(soup.vertices, soup.triangles);
  const auto read = meshFromBytes(many.bytes);
  ASSERT_EQ(sched_setaffinity(0, sizeof(all), &all), 0);
  EXPECT_EQ(many.bytes, alone.bytes);
  ASSERT_NE(read, nullptr);
  if (kSanitized) return;  // a million comparisons, which access nothing new
  expectSameMesh(*many.mesh, *alone.mesh);
  expectSameMesh(*many.mesh, *meshFromBytes(many.bytes));
}

TEST(MeshBytes, AreRefusedWhenTruncatedOrExtended) {
  std::vector<std::byte> bytes = made(*meshes().back().mesh).bytes;
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 97)
    EXPECT_EQ(meshFromBytes(std::span(bytes).first(size)), nullptr) << size;
  EXPECT_EQ(meshFromBytes(std::span(bytes).first(bytes.size() - 1)), nullptr);
  bytes.push_back(std::byte{0});
  EXPECT_EQ(meshFromBytes(bytes), nullptr);
}

// Damage that a checksum would detect must not lead a query out of its arrays; run this test with
// sanitizers.
TEST(MeshBytes, OfAnyKindNeverLeadQueriesAstray) {
  Random random(17);
  int refused = 0, taken = 0;
  for (const NamedMesh& given : meshes()) {
    const std::vector<std::byte> bytes = made(*given.mesh).bytes;
    for (int i = 0; i < (kSanitized ? 60 : 300); ++i) {
      std::vector<std::byte> damaged = bytes;
      const auto place = static_cast<std::size_t>(random.uniform(0, 1) * 0.999999 *
                                                  static_cast<double>(bytes.size()));
      damaged[place] ^= std::byte{static_cast<unsigned char>(1 << (i % 8))};
      if (const auto mesh = meshFromBytes(damaged)) {
        ++taken;
        answers(mesh, 1);
      } else {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(taken, 100);
}

// Replaces every number of the file in turn by an extreme one.
TEST(MeshBytes, WithExtremeNumbersNeverLeadQueriesAstray) {
  Random random(23);
  const std::vector<std::byte> bytes = made(*meshes()[3].mesh).bytes;
  const std::int32_t extremes[] = {-1, 0x7fffffff, -0x7fffffff - 1, 0};
  int taken = 0;
  const std::size_t step = kSanitized ? 1021 : 101;
  for (std::size_t place = 0; place + 4 <= bytes.size(); place += 4 * (1 + place % step)) {
    for (const std::int32_t extreme : extremes) {
      std::vector<std::byte> damaged = bytes;
      std::memcpy(damaged.data() + place, &extreme, sizeof(extreme));
      if (const auto mesh = meshFromBytes(damaged)) {
        ++taken;
        answers(mesh, 1);
      }
    }
  }
  EXPECT_GT(taken, 10);
}

}  // namespace
}  // namespace leeway::collision::testing
