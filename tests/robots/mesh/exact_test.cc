// From the file to the interval: numbers and distances against an independent reader in quadruple
// precision.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/model.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/mesh_texts.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/quad.h"

namespace leeway::robots {
namespace {

using collision::testing::Random;
using Eigen::Vector3d;
using oracle::Quad;
using oracle::wide;
using QuadVector = oracle::Vector;

/// A decimal number of up to about thirty digits, within a few units of 2^-113.
Quad quadOf(const std::string& text) {
  Quad value = 0;
  int power = 0;
  bool negative = false, after_point = false;
  std::size_t i = 0;
  for (; i < text.size() && text[i] != 'e' && text[i] != 'E'; ++i) {
    if (text[i] == '-') negative = true;
    if (text[i] == '.') after_point = true;
    if (text[i] < '0' || text[i] > '9') continue;
    value = wide(10) * value + wide(text[i] - '0');
    power -= after_point ? 1 : 0;
  }
  if (i < text.size()) power += std::atoi(text.c_str() + i + 1);
  Quad factor = 1;
  for (int k = 0; k < std::abs(power); ++k) factor *= wide(10);
  value = power < 0 ? value / factor : value * factor;
  return negative ? -value : value;
}

/// A number as programs write it.
std::string written(Random& random, double value) {
  const char* const formats[] = {"%.17g", "%.9g", "%.6f", "%.12e", "%g", "%.3f", "%.0f", "%.16f"};
  char text[400];
  std::snprintf(text, sizeof text, formats[random.below(8)], value);
  return (value >= 0 && random.below(4) == 0 ? "+" : "") + std::string(text);
}

TEST(Exact, NumbersAreRoundedCorrectly) {
  Random random(7);
  const int count = casesToAsk(30000);
  std::vector<std::string> numbers;
  for (int i = 0; i < 3 * count; ++i)
    numbers.push_back(written(random, std::pow(10, random.uniform(-12, 9)) * random.uniform()));
  for (const char* hard : {"0.1", "9007199254740993", "0.5000000000000000277", "1.", ".5", "-0",
                           "4.9e-324", "1e-400", "0.30000000000000004", "8.5e-17"})
    numbers.emplace_back(hard);
  numbers.resize(numbers.size() / 3 * 3);
  std::string obj, ply, stl = "solid\n", dae;
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    const std::string row = numbers[i] + ' ' + numbers[i + 1] + ' ' + numbers[i + 2] + '\n';
    obj += "v " + row;
    ply += row;
    stl += (i % 9 == 0 ? "facet normal 0 0 0\nouter loop\nvertex " : "vertex ") + row +
           (i % 9 == 6 ? "endloop\nendfacet\n" : "");
    dae += row;
  }
  const std::size_t rows = numbers.size() / 3;
  while (stl.rfind("endfacet") != stl.size() - 9) stl.erase(stl.rfind('\n', stl.size() - 2) + 1);
  const std::string total = std::to_string(rows);
  const MeshContents read[] = {
      mesh_texts::readAs(readObj, obj + "f 1 2 3\n"),
      mesh_texts::readAs(readPly, "ply\nformat ascii 1.0\nelement vertex " + total +
                                      "\nproperty double x\nproperty double y\nproperty double "
                                      "z\nend_header\n" +
                                      ply),
      mesh_texts::readAs(readStl, stl + "endsolid\n"),
      mesh_texts::readAs(
          readDae,
          "<COLLADA><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array "
          "id=\"a\" count=\"" +
              std::to_string(3 * rows) + "\">" + dae +
              "</float_array><technique_common><accessor source=\"#a\" count=\"" + total +
              "\" stride=\"3\"/></technique_common></source><vertices id=\"v\"><input "
              "semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"1\"><input "
              "semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh>"
              "</geometry></library_geometries><library_visual_scenes><visual_scene "
              "id=\"s\"><node><instance_geometry url=\"#g\"/></node></visual_scene>"
              "</library_visual_scenes><scene><instance_visual_scene "
              "url=\"#s\"/></scene></COLLADA>")};
  for (const MeshContents& contents : read) {
    const auto& vertices = contents.meshes.at(0).vertices;
    ASSERT_GE(vertices.size() + 3, rows);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_EQ(vertices[i][static_cast<Eigen::Index>(k)],
                  oracle::toDouble(quadOf(numbers[3 * i + k])))
            << numbers[3 * i + k];
  }
}

// ------------------------------------------------------------------------------------------------

/// The distance of a point from a triangle.
Quad distanceTo(const QuadVector& p, const QuadVector& a, const QuadVector& b,
                const QuadVector& c) {
  const QuadVector n = oracle::cross(b - a, c - a);
  const auto inside = [&](const QuadVector& s, const QuadVector& t) {
    return oracle::dot(oracle::cross(n, t - s), p - s) >= 0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a))
    return oracle::absolute(oracle::dot(n, p - a)) / oracle::squareRoot(oracle::dot(n, n));
  Quad least = oracle::infinity();
  for (const auto& [s, t] : {std::pair(a, b), {b, c}, {c, a}}) {
    const QuadVector edge = t - s;
    Quad share = oracle::dot(p - s, edge) / oracle::dot(edge, edge);
    share = share < 0 ? Quad(0) : share > 1 ? Quad(1) : share;
    const QuadVector d = p - (s + share * edge);
    const Quad length = oracle::squareRoot(oracle::dot(d, d));
    if (length < least) least = length;
  }
  return least;
}

/// A tetrahedron in one of the formats, and its corners at their places in the file.
struct WrittenMesh {
  std::string name, content;
  std::vector<QuadVector> corners;
};

constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

WrittenMesh writtenMesh(Random& random, int format, double offset) {
  WrittenMesh mesh;
  std::vector<std::string> words[4];
  const Vector3d place = offset * random.direction();
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d corner = place + random.vector();
    mesh.corners.emplace_back();
    for (int k = 0; k < 3; ++k) {
      char text[60];
      std::snprintf(text, sizeof text, random.below(2) == 0 ? "%.17g" : "%.5f", corner[k]);
      words[i].emplace_back(text);
    }
    mesh.corners[i] = {quadOf(words[i][0]), quadOf(words[i][1]), quadOf(words[i][2])};
  }
  const auto row = [&](int i) {
    const auto& w = words[static_cast<std::size_t>(i)];
    return w[0] + ' ' + w[1] + ' ' + w[2] + '\n';
  };
  if (format == 0) {
    mesh.name = "m.obj";
    for (int i = 0; i < 4; ++i) mesh.content += "v " + row(i);
    for (const auto& f : kFaces)
      mesh.content += "f " + std::to_string(f[0] + 1) + ' ' + std::to_string(f[1] + 1) + ' ' +
                      std::to_string(f[2] + 1) + '\n';
  } else if (format == 1) {
    mesh.name = "m.ply";
    mesh.content =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty "
        "double z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 4; ++i) mesh.content += row(i);
    for (const auto& f : kFaces)
      mesh.content += "3 " + std::to_string(f[0]) + ' ' + std::to_string(f[1]) + ' ' +
                      std::to_string(f[2]) + '\n';
  } else if (format == 2) {
    mesh.name = "m.stl";
    mesh.content = "solid\n";
    for (const auto& f : kFaces) {
      mesh.content += "facet normal 0 0 0\nouter loop\n";
      for (const int i : f) mesh.content += "vertex " + row(i);
      mesh.content += "endloop\nendfacet\n";
    }
    mesh.content += "endsolid\n";
  } else if (format == 3) {  // binary: the truth is in single precision
    mesh.name = "m.stl";
    std::vector<std::vector<float>> triangles;
    for (const auto& f : kFaces) {
      triangles.emplace_back();
      for (const int i : f) {
        const QuadVector& c = mesh.corners[static_cast<std::size_t>(i)];
        for (const Quad x : {c.x, c.y, c.z})
          triangles.back().push_back(static_cast<float>(oracle::toDouble(x)));
      }
    }
    for (QuadVector& c : mesh.corners)
      for (Quad* x : {&c.x, &c.y, &c.z})
        *x = wide(static_cast<double>(static_cast<float>(oracle::toDouble(*x))));
    mesh.content = mesh_texts::binaryStl(triangles, 4);
  } else {  // below two nodes, in another unit
    mesh.name = "m.dae";
    const std::string unit = random.below(2) == 0 ? "0.001" : "1";
    std::string matrix, numbers, shift, faces;
    Quad m[12];
    for (int i = 0; i < 12; ++i) {
      char text[60];
      const double value = i % 4 == 3 ? random.uniform(-1, 1) * offset
                                      : (i % 5 == 0 ? 1 : 0) + random.uniform(-0.3, 0.3);
      std::snprintf(text, sizeof text, "%.9g ", value);
      matrix += text;
      m[i] = quadOf(text);
    }
    Quad t[3];
    for (Quad& x : t) {
      char text[60];
      std::snprintf(text, sizeof text, "%.12g ", random.uniform(-1, 1) * offset);
      shift += text;
      x = quadOf(text);
    }
    for (int i = 0; i < 4; ++i) numbers += row(i);
    for (const auto& f : kFaces)
      faces += std::to_string(f[0]) + ' ' + std::to_string(f[1]) + ' ' + std::to_string(f[2]) + ' ';
    mesh.content =
        "<COLLADA><asset><unit meter=\"" + unit +
        "\"/></asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array "
        "id=\"a\" count=\"12\">" +
        numbers +
        "</float_array><technique_common><accessor source=\"#a\" count=\"4\" stride=\"3\"/>"
        "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
        "source=\"#p\"/></vertices><triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" "
        "offset=\"0\"/><p>" +
        faces +
        "</p></triangles></mesh></geometry></"
        "library_geometries><library_visual_scenes><visual_scene "
        "id=\"s\"><node><translate>" +
        shift + "</translate><node><matrix>" + matrix +
        "0 0 0 1</matrix><instance_geometry url=\"#g\"/></node></node></visual_scene>"
        "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
    for (QuadVector& c : mesh.corners) {
      const auto moved = [&](int r) {
        return quadOf(unit) *
               (t[r] + m[4 * r] * c.x + m[4 * r + 1] * c.y + m[4 * r + 2] * c.z + m[4 * r + 3]);
      };
      c = {moved(0), moved(1), moved(2)};
    }
  }
  return mesh;
}

TEST(Exact, FromTheFileToTheInterval) {
  Random random(8);
  const Folder folder;
  const int count = casesToAsk(100);
  for (int i = 0; i < count; ++i) {
    for (int format = 0; format < 5; ++format) {
      const double offset = i % 4 == 0 ? 0 : std::pow(10, random.uniform(0, 6));
      const WrittenMesh mesh = writtenMesh(random, format, offset);
      const collision::Shape shape =
          loadMesh(folder.write(mesh.name, mesh.content), Vector3d::Ones(), "exact", 1);
      Vector3d middle = Vector3d::Zero();
      double size = 0, farthest = 0;
      for (const QuadVector& c : mesh.corners) {
        const Vector3d v(oracle::toDouble(c.x), oracle::toDouble(c.y), oracle::toDouble(c.z));
        middle += 0.25 * v;
        farthest = std::max(farthest, v.cwiseAbs().maxCoeff());
      }
      for (const QuadVector& c : mesh.corners)
        size = std::max(
            size,
            (Vector3d(oracle::toDouble(c.x), oracle::toDouble(c.y), oracle::toDouble(c.z)) - middle)
                .norm());
      if (!(size > 1e-4)) continue;  // equal ones of single precision
      const Vector3d p = middle + size * random.uniform(1.1, 3) * random.direction();
      Quad truth = oracle::infinity();
      for (const auto& f : kFaces) {
        const auto corner = [&](int k) { return mesh.corners[static_cast<std::size_t>(f[k])]; };
        const Quad distance = distanceTo(oracle::toVector(p), corner(0), corner(1), corner(2));
        if (distance < truth) truth = distance;
      }
      collision::Pose X;
      X.translation = p;
      collision::DistanceRequest request;
      request.tolerance = 1e-10 * size;
      const collision::DistanceResult r =
          collision::distance(shape, {}, collision::Shape::sphere(0), X, request);
      const double allowed = 1e-9 * size + 1e-15 * farthest;
      EXPECT_LE(r.distance.lower, oracle::toDouble(truth) + allowed) << mesh.content;
      EXPECT_GE(r.distance.upper, oracle::toDouble(truth) - allowed) << mesh.content;
      // (Queries round by about 1e-14 of the coordinates.)
      EXPECT_LE(r.distance.upper - r.distance.lower, allowed + 1e-13 * farthest) << mesh.content;
    }
  }
}

}  // namespace
}  // namespace leeway::robots
