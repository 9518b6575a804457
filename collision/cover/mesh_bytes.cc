#include "collision/cover/mesh_bytes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "collision/cover/ball_cover.h"
#include "collision/mesh/mesh_file.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

void packPoints(const PointCover& cover, ByteWriter& to) {
  to.array(cover.points);
  to.value(cover.radius);
  to.array(cover.fine);
  to.value(cover.fine_radius);
  to.array(cover.clusters);
  to.array(cover.nearest);
  to.value(static_cast<std::uint8_t>(cover.own ? 1 : 0));
}

void packCover(const BallCover& cover, ByteWriter& to) {
  to.array(cover.outer);
  to.array(cover.inner);
  packPoints(cover.points, to);
  to.value(static_cast<std::int32_t>(cover.parts.size()));
  for (const CoverPart& part : cover.parts) {
    to.value(part.ball);
    packPoints(part.points, to);
  }
}

bool isRadius(double radius) { return radius >= 0 && std::isfinite(radius); }
bool isBall(const Ball& ball) { return ball.center.allFinite() && isRadius(ball.radius); }
bool areFinite(const std::vector<Vector3d>& points) {
  return std::all_of(points.begin(), points.end(), [](const Vector3d& p) { return p.allFinite(); });
}

bool areBalls(const std::vector<Ball>& balls) {
  return balls.size() <= static_cast<std::size_t>(kCoverBalls) &&
         std::all_of(balls.begin(), balls.end(), isBall);
}

// Whether the clusters are consecutive parts of `fine`, as clusterFine() makes them.
bool areClusters(const PointCover& cover) {
  const auto count = static_cast<int>(cover.fine.size());
  if (count == 0) return cover.clusters.empty() && cover.nearest.empty();
  int last = 0;
  for (const int end : cover.clusters) {
    if (end <= last) return false;
    last = end;
  }
  return last == count && cover.clusters.size() <= static_cast<std::size_t>(kMostClusters) &&
         cover.nearest.size() == cover.points.size() &&
         std::all_of(cover.nearest.begin(), cover.nearest.end(),
                     [&](int i) { return i >= 0 && i < count; });
}

bool unpackPoints(ByteReader& from, PointCover& cover) {
  cover.points = from.array<Vector3d>();
  cover.radius = from.value<double>();
  cover.fine = from.array<Vector3d>();
  cover.fine_radius = from.value<double>();
  cover.clusters = from.array<int>();
  cover.nearest = from.array<int>();
  cover.own = from.value<std::uint8_t>() != 0;
  return !from.failed() && !cover.points.empty() && areFinite(cover.points) &&
         areFinite(cover.fine) && isRadius(cover.radius) && isRadius(cover.fine_radius) &&
         cover.fine.size() <= static_cast<std::size_t>(kMostHullPoints) && areClusters(cover);
}

std::shared_ptr<const BallCover> unpackCover(ByteReader& from) {
  auto cover = std::make_shared<BallCover>();
  cover->outer = from.array<Ball>();
  cover->inner = from.array<Ball>();
  if (!areBalls(cover->outer) || !areBalls(cover->inner) || !unpackPoints(from, cover->points))
    return nullptr;
  const auto parts = from.value<std::int32_t>();
  if (parts < 0 || parts > kCoverParts) return nullptr;
  for (std::int32_t i = 0; i < parts; ++i) {
    CoverPart& part = cover->parts.emplace_back();
    part.ball = from.value<Ball>();
    if (!isBall(part.ball) || !unpackPoints(from, part.points)) return nullptr;
  }
  return cover;
}

}  // namespace

MeshAndBytes makeMeshAndBytes(std::span<const Vector3d> vertices,
                              std::span<const TriangleMesh::Triangle> triangles,
                              const MeshOptions& options, const std::function<void()>& checkpoint) {
  BallCover cover;
  const BuiltMesh built = MeshFile::build(
      vertices, triangles, options,
      [&](const std::shared_ptr<const TriangleMesh>& mesh) {
        cover = coverWithoutInnerBalls(Shape::mesh(mesh));
      },
      checkpoint);
  if (checkpoint) checkpoint();
  addInnerBalls(Shape::mesh(built.mesh), cover);
  MeshFile::setCover(*built.mesh, std::make_shared<const BallCover>(cover));
  if (checkpoint) checkpoint();
  ByteWriter bytes;
  MeshFile::pack(built, bytes);
  packCover(cover, bytes);
  return {built.mesh, bytes.take()};
}

std::shared_ptr<const TriangleMesh> meshFromBytes(std::span<const std::byte> bytes) {
  ByteReader from(bytes);
  std::shared_ptr<TriangleMesh> mesh = MeshFile::unpack(from);
  if (mesh == nullptr) return nullptr;
  std::shared_ptr<const BallCover> cover = unpackCover(from);
  if (cover == nullptr || !from.atEnd()) return nullptr;
  MeshFile::setCover(*mesh, std::move(cover));
  return mesh;
}

}  // namespace leeway::collision
