#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/sensed/cloud_source.h"
#include "robots/mesh/ply_file.h"

namespace leeway::planner {
namespace {

CloudPlace cloudPlace(robots::FilePlace place) {
  return place.code() > 0 ? CloudPlace{static_cast<std::size_t>(place.code()), 0}
                          : CloudPlace{0, static_cast<std::size_t>(-1 - place.code())};
}

void readPlyPoints(const CloudSource& source, const robots::PlyElement& vertices,
                   robots::PlyFile& file, PointSink& sink) {
  const std::array<std::size_t, 3> axes = file.axesOf(vertices);
  file.forEach(vertices, [&](std::size_t row) {
    source.pause(row);
    double p[3] = {0, 0, 0};
    CloudPlace place;
    for (std::size_t k = 0; k < vertices.properties.size(); ++k) {
      const robots::PlyProperty& property = vertices.properties[k];
      if (property.count) {
        file.skip(vertices, k, k + 1);
        if (k == 0) place = cloudPlace(file.place());
        continue;
      }
      const double value = file.number(property.type);
      if (k == 0) place = cloudPlace(file.place());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (axes[axis] != k) continue;
        p[axis] =
            file.isText() && std::isinf(value) ? readCoordinate(source, file.word(), place) : value;
      }
    }
    sink.add(p, place);
  });
}

}  // namespace

void readPly(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink) {
  robots::PlyFile file(source.text(), [&](robots::FilePlace place, const std::string& message) {
    source.fail(cloudPlace(place), message);
  });
  const auto isVertex = [](const robots::PlyElement& element) { return element.name == "vertex"; };
  if (std::none_of(file.elements().begin(), file.elements().end(), isVertex))
    source.fail({1, 0}, "has no element vertex; one would be accepted");
  for (const robots::PlyElement& element : file.elements()) {
    if (isVertex(element)) {
      readPlyPoints(source, element, file, sink);
      continue;
    }
    if ((element.name == "face" || element.name == "tristrips") && element.count > 0)
      warnings.push_back(
          fmt::format("{}{}: the element '{}' ({}) is left out: a cloud has balls at vertices, and "
                      "its surface is free between them; 'mesh' takes the surface",
                      source.path(), element.place.text(), element.name, element.count));
    file.forEach(element, [&](std::size_t row) {
      source.pause(row);
      file.skip(element, 0, element.properties.size());
    });
  }
  // Rows that the header does not count would be lost.
  file.finish();
}

}  // namespace leeway::planner
