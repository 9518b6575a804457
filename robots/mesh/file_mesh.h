#pragma once

// Private to robots/: the contents of a mesh file, before its polygons are triangulated.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <string>
#include <vector>

#include "collision/base/large_pages.h"

namespace leeway::robots {

/// A place in a file: a line of a text file, or a byte of a binary file.
class FilePlace {
 public:
  constexpr FilePlace() = default;  ///< the whole file
  /// Lines count from 1.
  static constexpr FilePlace line(std::int64_t number) { return FilePlace(number); }
  static constexpr FilePlace byte(std::size_t offset) {
    return FilePlace(-1 - static_cast<std::int64_t>(offset));
  }
  /// ":12", ", byte 84", or an empty string.
  std::string text() const;

  std::int64_t code() const { return code_; }  ///< for files
  static FilePlace fromCode(std::int64_t code) { return FilePlace(code); }

 private:
  explicit constexpr FilePlace(std::int64_t code) : code_(code) {}
  std::int64_t code_ = 0;
};

/// Vertices exactly as in the file, and polygons over them, in the file's order.
class FileMesh {
 public:
  struct Face {
    std::int32_t first = 0, count = 0;  ///< of the corners
    FilePlace place;
  };

  std::pmr::vector<Eigen::Vector3d> vertices{collision::largeArrays()};
  std::pmr::vector<std::int32_t> corners{collision::largeArrays()};  ///< vertices, from 0
  std::pmr::vector<Face> faces{collision::largeArrays()};
  std::vector<std::int32_t> others;  ///< vertices of lines, points and curves, if they are read

  void addFace(std::span<const std::int32_t> of, FilePlace place) {
    faces.push_back(
        {static_cast<std::int32_t>(corners.size()), static_cast<std::int32_t>(of.size()), place});
    corners.insert(corners.end(), of.begin(), of.end());
  }
  std::span<const std::int32_t> cornersOf(const Face& face) const {
    return std::span(corners).subspan(static_cast<std::size_t>(face.first),
                                      static_cast<std::size_t>(face.count));
  }
};

/// A message about a file that is usable.
struct MeshNote {
  FilePlace place;
  std::string text;
};

/// Counts the parts of a file that have no area and are omitted.
struct NotSolid {
  std::int64_t lines = 0, points = 0, curves = 0;
  FilePlace first;

  void count(std::int64_t& kind, FilePlace place) {
    if (lines + points + curves == 0) first = place;
    ++kind;
  }
};

/// A whole file: meshes, and one or several placements of each.
struct MeshContents {
  using Placement = Eigen::Matrix<double, 3, 4>;  ///< from a mesh's coordinates to the file's
  struct Instance {
    std::size_t mesh;
    Placement placement;
  };
  std::vector<FileMesh> meshes;
  std::vector<Instance> instances;
  NotSolid not_solid;
  std::vector<MeshNote> notes;
};

}  // namespace leeway::robots
