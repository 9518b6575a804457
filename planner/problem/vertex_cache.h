#pragma once

#include <cstddef>
#include <span>

#include "leeway/collision/vertex_motion.h"

// Vertex caches, as animation tools write them: the positions of all vertices, frame by frame.
// Everything here throws collision::InvalidMotion, whose message names the value and what would be
// accepted: a wrong mark or version, counts below 1 or beyond what the bytes hold, bytes missing or
// left over, times that are not finite. Whether times increase and positions are finite is checked
// by collision::VertexMotion::cache(). O(bytes).

namespace leeway::planner {

/// PC2 (Point Cache 2: 3ds Max, Blender), little endian: the 12 characters "POINTCACHE2" and a
/// zero, int32 version 1, int32 vertices, float first frame, float frames from one sample to the
/// next, int32 samples, then the samples, three floats a vertex. Times are frames by
/// `frames_per_second`
/// (> 0), positions are multiplied by `scale`.
collision::CacheMotion parsePc2(std::span<const std::byte> bytes, double frames_per_second,
                                double scale = 1);

/// MDD (Motion Designer Data: LightWave, Blender), big endian: int32 frames, int32 vertices, one
/// float a frame for its time [s], then the frames, three floats a vertex. Positions are multiplied
/// by `scale`.
collision::CacheMotion parseMdd(std::span<const std::byte> bytes, double scale = 1);

}  // namespace leeway::planner
