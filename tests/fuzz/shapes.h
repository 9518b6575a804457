#pragma once

#include <optional>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/fuzz/byte_reader.h"

namespace leeway::fuzz {

/// Up to `most` points.
std::vector<Eigen::Vector3d> readPoints(ByteReader& bytes, int most);

/// A mesh of few triangles; nothing if TriangleMesh refuses it.
std::shared_ptr<const collision::TriangleMesh> readMesh(ByteReader& bytes);

/// Any shape; nothing if its factory refuses the sizes, which is a valid outcome.
std::optional<collision::Shape> readShape(ByteReader& bytes);

/// Ends the process with a message; the driver adds how to reproduce it.
[[noreturn]] void fail(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace leeway::fuzz
