#include "planner/problem/indexed_mesh.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "leeway/robots/input_error.h"
#include "leeway/robots/text.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {
namespace {

using robots::InputError;

class ObjReader {
 public:
  explicit ObjReader(const std::string& file) : file_(file) {}

  IndexedMesh run() {
    std::ifstream stream(file_, std::ios::binary);
    if (!stream) throw InputError(file_, 0, "cannot be read; a Wavefront OBJ file is expected");
    for (std::string line; std::getline(stream, line);) {
      ++line_;
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "v") readVertex(words);
      if (word == "f") readFace(words);
    }
    if (mesh_.triangles.empty())
      throw InputError(file_, 0, "has no faces; at least one is expected");
    for (const Face& face : faces_)
      for (const std::int32_t corner : mesh_.triangles[face.triangle])
        if (corner < 0 || static_cast<std::size_t>(corner) >= mesh_.vertices.size())
          throw InputError(file_, face.line,
                           fmt::format("names vertex {} of {}; 1 to {} is expected", corner + 1,
                                       mesh_.vertices.size(), mesh_.vertices.size()));
    return std::move(mesh_);
  }

 private:
  struct Face {
    std::size_t triangle;
    int line;
  };

  void readVertex(std::istringstream& words) {
    Eigen::Vector3d vertex;
    for (int k = 0; k < 3; ++k) {
      std::string word;
      words >> word;
      const std::optional<double> value = robots::parseNumber(word);
      if (!value || !std::isfinite(*value))
        throw InputError(
            file_, line_,
            fmt::format("'{}' is no coordinate; 'v X Y Z' with three finite numbers is "
                        "expected",
                        word));
      vertex[k] = *value;
    }
    mesh_.vertices.push_back(vertex);
  }

  void readFace(std::istringstream& words) {
    std::vector<std::int32_t> corners;
    for (std::string word; words >> word;) {
      // VERTEX/TEXTURE/NORMAL; negative numbers count back from the last vertex so far.
      std::int32_t number = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (error != std::errc() || (end != word.data() + word.size() && *end != '/') || number == 0)
        throw InputError(
            file_, line_,
            fmt::format("'{}' is no corner; the number of a vertex is expected", word));
      corners.push_back(number > 0 ? number - 1
                                   : static_cast<std::int32_t>(mesh_.vertices.size()) + number);
    }
    if (corners.size() < 3)
      throw InputError(
          file_, line_,
          fmt::format("is a face of {} corners; at least three are expected", corners.size()));
    for (std::size_t k = 2; k < corners.size(); ++k) {
      faces_.push_back({mesh_.triangles.size(), line_});
      mesh_.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }

  std::string file_;
  int line_ = 0;
  IndexedMesh mesh_;
  std::vector<Face> faces_;
};

}  // namespace

IndexedMesh readObj(const std::string& file) { return ObjReader(file).run(); }

IndexedMesh gridMesh(double size_x, double size_y, int cells_x, int cells_y) {
  IndexedMesh mesh;
  for (int j = 0; j <= cells_y; ++j)
    for (int i = 0; i <= cells_x; ++i)
      mesh.vertices.emplace_back(size_x * (static_cast<double>(i) / cells_x - 0.5),
                                 size_y * (static_cast<double>(j) / cells_y - 0.5), 0);
  for (int j = 0; j < cells_y; ++j)
    for (int i = 0; i < cells_x; ++i) {
      const std::int32_t a = j * (cells_x + 1) + i, b = a + 1, c = a + cells_x + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

}  // namespace leeway::planner
