#include "tests/fuzz/shapes.h"

#include <cstdarg>
#include <cstdio>
#include <cstdlib>

namespace leeway::fuzz {

using collision::InvalidShape;
using collision::Shape;
using collision::TriangleMesh;
using Eigen::Vector3d;

std::vector<Vector3d> readPoints(ByteReader& bytes, int most) {
  std::vector<Vector3d> points;
  const int count = bytes.below(most + 1);
  for (int i = 0; i < count; ++i) {
    const int kind = bytes.below(6);
    if (kind == 0 && !points.empty()) {
      points.push_back(
          points[static_cast<std::size_t>(bytes.below(static_cast<int>(points.size())))]);
    } else if (kind == 1 && points.size() >= 2) {
      points.push_back(0.5 *
                       (points[points.size() - 1] + points[points.size() - 2]));  // on an edge
    } else {
      points.push_back(bytes.vector());
    }
  }
  return points;
}

std::shared_ptr<const TriangleMesh> readMesh(ByteReader& bytes) {
  std::vector<Vector3d> vertices = readPoints(bytes, 10);
  std::vector<TriangleMesh::Triangle> triangles;
  if (bytes.below(2) == 0 && vertices.size() >= 4) {
    triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};  // closed, whatever its form
  }
  const int more = bytes.below(8);
  const int range =
      static_cast<int>(vertices.size()) + (bytes.below(16) == 0 ? 1 : 0);  // sometimes out of range
  for (int i = 0; i < more && range > 0; ++i)
    triangles.push_back({bytes.below(range), bytes.below(range), bytes.below(range)});
  try {
    return TriangleMesh::make(vertices, triangles);
  } catch (const InvalidShape&) {
    return nullptr;
  }
}

std::optional<Shape> readShape(ByteReader& bytes) {
  try {
    const int type = bytes.below(9);
    switch (type) {
      case 0:
        return Shape::sphere(bytes.size());
      case 6:
        return Shape::halfSpace();
      case 7: {
        const std::vector<Vector3d> points = readPoints(bytes, 20);
        return Shape::convexHull(std::span<const Vector3d>(points));
      }
      case 8: {
        const auto mesh = readMesh(bytes);
        if (!mesh) return std::nullopt;
        return Shape::mesh(mesh);
      }
      default:
        break;
    }
    const double x = bytes.size(), y = bytes.size();
    if (type == 1) return Shape::capsule(x, y);
    if (type == 2) return Shape::cylinder(x, y);
    if (type == 3) return Shape::cone(x, y);
    const Vector3d sizes(x, y, bytes.size());
    return type == 4 ? Shape::box(sizes) : Shape::ellipsoid(sizes);
  } catch (const InvalidShape&) {
    return std::nullopt;
  }
}

void fail(const char* format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  std::vfprintf(stderr, format, arguments);
  va_end(arguments);
  std::fputc('\n', stderr);
  std::abort();
}

}  // namespace leeway::fuzz
