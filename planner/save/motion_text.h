#pragma once

// Private to planner/: deforming obstacles and files that a problem file names.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/save/yaml_text.h"

namespace leeway::planner {

/// Rotations that are as near to each other, in each entry, are written as one.
inline constexpr double kSavedRotation = 1e-14;

/// The files that a problem file names.
class SavedFiles {
 public:
  /// `folder`: as the problem file names it. `files` receives names within it, and contents.
  SavedFiles(std::string folder, std::vector<std::pair<std::string, std::string>>& files)
      : folder_(std::move(folder)), files_(files) {}

  /// Adds a file and returns how the problem file names it. `owner`: what it is of.
  std::string add(const std::string& owner, const std::string& ending, std::string content);
  /// Adds an OBJ with these vertices, in their order.
  std::string addMesh(const std::string& owner, std::span<const Eigen::Vector3d> vertices,
                      std::span<const std::array<std::int32_t, 3>> triangles);

  MapText treatments;  ///< what stands under `meshes`

 private:
  std::string folder_;
  std::vector<std::pair<std::string, std::string>>& files_;
};

/// An entry of `deforming`. Throws robots::InputError for what files cannot say.
std::string deformingText(const DeformingObstacle& obstacle, SavedFiles& files);

}  // namespace leeway::planner
