#pragma once

// Reads pairs of convex shapes from text files (format: tests/data/README.md).

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::collision::testing {

struct FileCase {
  int id = 0, a = 0, b = 0;  // a, b: into CaseFile::shapes
  std::string family, part;
  Pose X_WA, X_WB;
};

struct CaseFile {
  std::map<int, Shape> shapes;
  std::vector<FileCase> cases;
};

inline Shape readShape(std::istream& in) {
  std::string type;
  in >> type;
  if (type == "hull") {
    std::size_t vertices = 0, facets = 0;
    in >> vertices >> facets;
    std::vector<Eigen::Vector3d> points(vertices);
    for (Eigen::Vector3d& p : points) in >> p.x() >> p.y() >> p.z();
    return Shape::convexHull(points);
  }
  if (type == "box" || type == "ellipsoid") {
    Eigen::Vector3d size;
    in >> size.x() >> size.y() >> size.z();
    return type == "box" ? Shape::box(size) : Shape::ellipsoid(size);
  }
  double radius = 0, half_length = 0;
  in >> radius;
  if (type == "sphere") return Shape::sphere(radius);
  in >> half_length;
  if (type == "capsule") return Shape::capsule(radius, half_length);
  if (type == "cone") return Shape::cone(radius, half_length);
  EXPECT_EQ(type, "cylinder");
  return Shape::cylinder(radius, half_length);
}

/// Empty if the file is unreadable; a malformed line fails the test.
inline CaseFile readCases(const std::string& path) {
  CaseFile file;
  std::ifstream lines(path);
  std::string line, word;
  while (std::getline(lines, line)) {
    std::istringstream in(line);
    word.clear();
    in >> word;
    if (word == "shape") {
      int id = 0;
      in >> id;
      file.shapes.emplace(id, readShape(in));
    } else if (word == "case") {
      FileCase c;
      in >> c.id >> c.family >> c.part >> c.a >> c.b;
      for (Pose* X : {&c.X_WA, &c.X_WB}) {
        for (int i = 0; i < 9; ++i) in >> X->rotation(i / 3, i % 3);
        for (int i = 0; i < 3; ++i) in >> X->translation[i];
      }
      file.cases.push_back(c);
    }
    EXPECT_FALSE(in.fail() && !word.empty()) << path << ": " << line.substr(0, 80);
  }
  return file;
}

}  // namespace leeway::collision::testing
