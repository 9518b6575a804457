#pragma once

#include <cstddef>
#include <span>

#include "leeway/collision/vertex_motion.h"

// Vertex caches of animation tools: the positions of all vertices, frame by frame. Both functions
// throw collision::InvalidMotion, naming the value and what would be accepted, for a wrong mark or
// version, counts below 1 or beyond the bytes, missing or surplus bytes, and times that are not
// finite. collision::VertexMotion::cache() checks that times increase and positions are finite.
// O(bytes).

namespace leeway::planner {

/// PC2 (Point Cache 2: 3ds Max, Blender), little endian: the 12 characters "POINTCACHE2" and a
/// zero, int32 version 1, int32 vertices, float first frame, float frames from one sample to the
/// next, int32 samples, then the samples, three floats a vertex. A sample's time is its frame over
/// `frames_per_second` (> 0); positions are multiplied by `scale`.
collision::CacheMotion parsePc2(std::span<const std::byte> bytes, double frames_per_second,
                                double scale = 1);

/// MDD (Motion Designer Data: LightWave, Blender), big endian: int32 frames, int32 vertices, one
/// float a frame for its time [s], then the frames, three floats a vertex. Positions are multiplied
/// by `scale`.
collision::CacheMotion parseMdd(std::span<const std::byte> bytes, double scale = 1);

}  // namespace leeway::planner
