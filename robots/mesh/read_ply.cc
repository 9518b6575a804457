#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "robots/base/read_file.h"
#include "robots/mesh/ply_file.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

class PlyReader {
 public:
  explicit PlyReader(const MeshSource& source)
      : source_(source),
        file_({reinterpret_cast<const char*>(source.bytes().data()), source.bytes().size()},
              [&source](FilePlace place, const std::string& message) {
                source.failAt(place, message);
              }) {}

  MeshContents run() {
    for (const PlyElement& element : file_.elements()) {
      if (element.name == "vertex") {
        readVertices(element);
      } else if (element.name == "face" || element.name == "tristrips") {
        readFaces(element);
      } else {
        for (const auto& property : element.properties)
          if (property.name == "vertex_indices" || property.name == "vertex_index")
            source_.failAt(element.place, "element " + shown(element.name) + " has " +
                                              property.name + "; element face would be accepted");
        if (element.name == "edge" && element.count > 0) {
          contents_.not_solid.count(contents_.not_solid.lines, element.place);
          contents_.not_solid.lines += static_cast<std::int64_t>(element.count) - 1;
        }
        file_.forEach(element, [&](std::size_t row) {
          pause(row);
          file_.skip(element, 0, element.properties.size());
        });
      }
    }
    file_.finish();
    if (file_.isText() && !lastLineEnds(source_.text()))
      contents_.notes.push_back({file_.place(), std::string(kLastLineOpen)});
    const auto count = static_cast<std::int32_t>(mesh_.vertices.size());
    for (const FileMesh::Face& face : mesh_.faces)
      for (const std::int32_t corner : mesh_.cornersOf(face))
        if (corner >= count)
          source_.failAt(face.place, "the face names vertex " + std::to_string(corner) + "; 0 to " +
                                         std::to_string(count - 1) + " would be accepted");
    contents_.meshes.push_back(std::move(mesh_));
    contents_.instances.push_back({0, MeshContents::Placement::Identity()});
    return std::move(contents_);
  }

 private:
  void pause(std::size_t row) const {
    if (row % MeshSource::kLinesBetweenStops == 0) source_.pause();
  }

  void readVertices(const PlyElement& element) {
    const std::array<std::size_t, 3> axes = file_.axesOf(element);
    mesh_.vertices.reserve(std::min(element.count, file_.left()));
    file_.forEach(element, [&](std::size_t row) {
      pause(row);
      Eigen::Vector3d& v = mesh_.vertices.emplace_back();
      requireCountable(source_, mesh_.vertices.size(), element.place);
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const PlyProperty& property = element.properties[k];
        if (property.count) {
          file_.skip(element, k, k + 1);
          continue;
        }
        const double value = file_.number(property.type);
        for (int axis = 0; axis < 3; ++axis) {
          if (axes[static_cast<std::size_t>(axis)] != k) continue;
          if (!(std::abs(value) <= kGreatestCoordinate))
            file_.fail("a finite coordinate of up to 1e60");
          v[axis] = value;
        }
      }
    });
  }

  void readFaces(const PlyElement& element) {
    const int list = element.find({"vertex_indices", "vertex_index"});
    if (list < 0 || !element.properties[static_cast<std::size_t>(list)].count)
      source_.failAt(element.place, "the element " + element.name +
                                        " has no list of its vertices; a property list with the "
                                        "name vertex_indices would be accepted");
    const auto place_of_list = static_cast<std::size_t>(list);
    const PlyProperty& indices = element.properties[place_of_list];
    std::vector<std::int32_t> corners;
    file_.forEach(element, [&](std::size_t row) {
      pause(row);
      file_.skip(element, 0, place_of_list);
      corners.clear();
      const std::size_t count = file_.count(indices);
      const FilePlace place = file_.place();
      for (std::size_t i = 0; i < count; ++i) corners.push_back(readCorner(element, indices));
      if (element.name == "face")
        addFace(corners, place);
      else
        addStrips(corners, place);
      file_.skip(element, place_of_list + 1, element.properties.size());
    });
  }

  /// Returns a corner; -1 ends a strip.
  std::int32_t readCorner(const PlyElement& element, const PlyProperty& indices) {
    const double index = file_.number(indices.type);
    const double least = element.name == "face" ? 0 : -1;
    if (!(index >= least && index == std::floor(index) && index <= 0x7FFFFFFE))
      file_.fail("the number of a vertex, from 0,");
    return static_cast<std::int32_t>(index);
  }

  void addFace(const std::vector<std::int32_t>& corners, FilePlace place) {
    NotSolid& left_out = contents_.not_solid;
    if (corners.size() < 2) return left_out.count(left_out.points, place);
    if (corners.size() == 2) return left_out.count(left_out.lines, place);
    requireCountable(source_, mesh_.corners.size() + corners.size(), place);
    mesh_.addFace(corners, place);
  }

  /// Adds strips of triangles; every second triangle of a strip is reversed.
  void addStrips(const std::vector<std::int32_t>& corners, FilePlace place) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i] < 0) begin = i + 1;
      if (i < begin + 2) continue;
      const bool odd = (i - begin) % 2 == 1;
      const std::int32_t triangle[3] = {corners[i - (odd ? 1 : 2)], corners[i - (odd ? 2 : 1)],
                                        corners[i]};
      requireCountable(source_, mesh_.corners.size() + 3, place);
      mesh_.addFace(triangle, place);
    }
  }

  const MeshSource& source_;
  PlyFile file_;
  FileMesh mesh_;
  MeshContents contents_;
};

}  // namespace

MeshContents readPly(const MeshSource& source) { return PlyReader(source).run(); }

}  // namespace leeway::robots
