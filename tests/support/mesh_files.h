#pragma once

// Meshes of robots as plain triangles, read without a library: binary STL and OBJ, as far as the
// test data needs.

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "tests/support/build_paths.h"

namespace leeway::collision::testing {

struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
};

/// All collision meshes of the test data's robots, in a fixed order; empty if the data is absent.
inline std::vector<std::filesystem::path> meshFiles() {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const char* folder : {"robots/panda/meshes/collision", "robots/ur5/meshes"}) {
    std::filesystem::recursive_directory_iterator it(leeway::dataFolder() + "/" + folder, error),
        end;
    for (; !error && it != end; it.increment(error)) {
      const std::string extension = it->path().extension().string();
      if (extension == ".obj" || extension == ".stl" || extension == ".STL")
        files.push_back(it->path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

inline TriangleSoup readBinaryStl(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  TriangleSoup soup;
  std::uint32_t count = 0;
  if (bytes.size() < 84) return soup;
  std::memcpy(&count, bytes.data() + 80, 4);
  for (std::size_t i = 0; i < count && 84 + 50 * (i + 1) <= bytes.size(); ++i) {
    float v[9];
    std::memcpy(v, bytes.data() + 84 + 50 * i + 12, sizeof v);
    const auto first = static_cast<std::int32_t>(soup.vertices.size());
    for (int k = 0; k < 3; ++k) {
      soup.vertices.emplace_back(static_cast<double>(v[3 * k]), static_cast<double>(v[3 * k + 1]),
                                 static_cast<double>(v[3 * k + 2]));
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

inline TriangleSoup readObj(const std::filesystem::path& path) {
  std::ifstream in(path);
  TriangleSoup soup;
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string kind, corner;
    words >> kind;
    if (kind == "v") {
      double x = 0, y = 0, z = 0;
      words >> x >> y >> z;
      soup.vertices.emplace_back(x, y, z);
    } else if (kind == "f") {
      std::vector<std::int32_t> corners;
      while (words >> corner)
        corners.push_back(std::stoi(corner) - 1);  // "7/1/2": stops at the slash
      for (std::size_t i = 2; i < corners.size(); ++i) {
        soup.triangles.push_back({corners[0], corners[i - 1], corners[i]});
      }
    }
  }
  return soup;
}

inline TriangleSoup readMesh(const std::filesystem::path& path) {
  return path.extension() == ".obj" ? readObj(path) : readBinaryStl(path);
}

}  // namespace leeway::collision::testing
