#pragma once

// Private to robots/: pairs of links that keep a distance whatever their joints do.

#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Of all pairs of links, neither neighbours nor disabled, between which just two joints stand that
/// turn, and of which something is proven. Seen from what is between the two joints, each link
/// turns about an axis that stands still: one of them, made of triangles, is held by a stack of
/// cylinders about its axis, however it is turned; and over an arc of h radians of the other, its
/// points stay within h^2 / 8 times their distance from its axis of their chords. Some hundred
/// distance queries a pair, and kGapQueries at most and again as many by cells for pairs that stay
/// near each other: a fifth of the time that meshes take to load.
std::vector<LinkGap> provenGaps(const Model& model);

}  // namespace leeway::robots
