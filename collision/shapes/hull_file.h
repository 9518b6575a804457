#pragma once

#include <memory>

#include "collision/base/byte_stream.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// Writes a hull with all data computed from it. O(vertices).
void packHull(const ConvexHull& hull, ByteWriter& to);

/// Reads a hull that packHull() wrote. Null if the bytes are not usable for queries: every index
/// must be valid and every coordinate finite. It does not check that the data is a hull of the
/// right points. O(vertices).
std::shared_ptr<const ConvexHull> unpackHull(ByteReader& from);

}  // namespace leeway::collision
