#pragma once

#include <cstddef>
#include <span>

#include "leeway/collision/vertex_motion.h"

// Vertex caches of animation tools: the positions of all vertices, frame by frame. Both functions
// throw collision::InvalidMotion with the value and what would be accepted, for a wrong mark or
// version, counts below 1 or beyond the bytes, missing or surplus bytes, and times that are not
// finite. collision::VertexMotion::cache() checks that times increase and positions are finite.
// O(bytes).

namespace leeway::planner {

/// Parses PC2 (Point Cache 2: 3ds Max, Blender), little endian: the 12 characters "POINTCACHE2" and
/// a zero, int32 version 1, int32 vertices, float first frame, float frames from one sample to the
/// next, int32 samples, then the samples with three floats per vertex. The time of a sample is its
/// frame divided by `frames_per_second` (> 0). Multiplies positions by `scale`.
collision::CacheMotion parsePc2(std::span<const std::byte> bytes, double frames_per_second,
                                double scale = 1);

/// Parses MDD (Motion Designer Data: LightWave, Blender), big endian: int32 frames, int32 vertices,
/// one float per frame for its time [s], then the frames with three floats per vertex. Multiplies
/// positions by `scale`.
collision::CacheMotion parseMdd(std::span<const std::byte> bytes, double scale = 1);

}  // namespace leeway::planner
