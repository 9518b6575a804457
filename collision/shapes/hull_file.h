#pragma once

#include <memory>

#include "collision/base/byte_stream.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// A hull with all that was made of it, for a file. O(vertices).
void packHull(const ConvexHull& hull, ByteWriter& to);

/// A hull that packHull() wrote. Null where the bytes are none that queries could use: every index
/// is checked and every coordinate is finite. That it is a hull, and of the right points, is not
/// looked at. O(vertices).
std::shared_ptr<const ConvexHull> unpackHull(ByteReader& from);

}  // namespace leeway::collision
