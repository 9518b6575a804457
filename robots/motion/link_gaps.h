#pragma once

// Private to robots/: pairs of links that keep a distance whatever their joints do.

#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Gaps of all pairs of links, neither adjacent nor disabled, between which exactly two joints move
/// and both turn; pairs of which nothing is proven are left out. At least one link must be made of
/// triangles. Method: one link is replaced by its solid of revolution about its joint's axis, and
/// the other's turn is swept by arcs; what one angle leaves open is swept by both. Some hundred
/// distance queries a pair, at most kGapQueries by one angle and as many by both: a fifth of the
/// time that meshes take to load.
std::vector<LinkGap> provenGaps(const Model& model, const Stop& stop = {});

}  // namespace leeway::robots
