#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::planner {

/// Whether space that an octree says nothing about is free or occupied.
enum class Unseen : unsigned char { kFree, kOccupied };

/// An octree of OctoMap in memory, as octomap_msgs/Octomap holds it.
struct OctreeData {
  std::string id = "OcTree";  ///< or ColorOcTree, OcTreeStamped
  double resolution = 0;      ///< edge of the smallest cells [m], from 1e-9 to 1e4
  bool binary = true;         ///< free, occupied or unknown; false: with log odds
  std::string_view data;
  std::size_t first_byte = 0;  ///< where `data` begins in its file, for messages
};

/// The boxes of the octree's occupied leaves, in the octree's frame. With log odds, a leaf is
/// occupied from a probability of 1/2 on, as OctoMap has it. Boxes that share a whole face are
/// joined; their union is that of the leaves. With `unseen` kOccupied, so is everything within the
/// octree's cube (65,536 cells wide) that no leaf covers. Throws std::invalid_argument with the
/// byte for damaged data, an unknown id, a resolution that is not accepted, and more than 2^22
/// boxes. O(n log n), in memory for 2^23 boxes before they are joined.
std::vector<robots::Geometry> octreeBoxes(const OctreeData& octree, Unseen unseen);

/// The same from a file: .bt (binary) or .ot (log odds). Throws robots::InputError with line or
/// byte for a damaged file, robots::Stopped.
std::vector<robots::Geometry> loadOctree(const std::string& path, Unseen unseen,
                                         const robots::Stop& stop = {});

}  // namespace leeway::planner
