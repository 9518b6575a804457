#pragma once

// Private to robots/: the mesh files that most robots have, read without Assimp.

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace leeway::robots {

/// Three corners a triangle, in the file's order; of a line twice the second.
using PlainTriangles = std::vector<std::array<std::array<float, 3>, 3>>;

/// Binary STL, and OBJ of vertices, triangles and lines in one object: the same numbers that Assimp
/// reads, which takes a millisecond a file and more for buffers of 16 MB. Nothing for whatever else
/// there is, malformed files among it: Assimp knows better, and has the message. O(size).
std::optional<PlainTriangles> readPlainMesh(const std::string& path);

}  // namespace leeway::robots
