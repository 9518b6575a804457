#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "tests/support/mesh_texts.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using mesh_texts::Corners;
using mesh_texts::cornersOf;

std::string base64(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <class T>
std::string bytesOf(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
  return bytes;
}

/// A file with a tetrahedron, whose parts a test replaces.
struct Tetrahedron {
  std::string vertices = bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.1F});
  std::string indices = bytesOf<std::uint16_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  std::string position = R"("bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3")";
  std::string index = R"("bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR")";
  std::string primitive = R"("attributes": {"POSITION": 0}, "indices": 1)";
  std::string mesh = "";
  std::string view = "";  // of the vertices
  std::string nodes = R"([{"mesh": 0}])";
  std::string more = R"("scene": 0, "scenes": [{"nodes": [0]}])";
  std::string buffer = R"("uri": "data:application/octet-stream;base64,)";

  std::string json(bool binary = false) const {
    const std::string bytes = vertices + indices;
    return R"({"asset": {"version": "2.0"}, "buffers": [{)" +
           (binary ? "" : buffer + (buffer.ends_with(',') ? base64(bytes) : "") + "\", ") +
           R"("byteLength": )" + std::to_string(bytes.size()) +
           R"(}], "bufferViews": [{"buffer": 0, "byteLength": )" + std::to_string(vertices.size()) +
           view + R"(}, {"buffer": 0, "byteOffset": )" + std::to_string(vertices.size()) +
           R"(, "byteLength": )" + std::to_string(indices.size()) + R"(}], "accessors": [{)" +
           position + "}, {" + index + R"(}], "meshes": [{"primitives": [{)" + primitive + "}]" +
           mesh + R"(}], "nodes": )" + nodes + ", " + more + "}";
  }
  std::string glb() const {
    std::string text = json(true), bytes = vertices + indices;
    while (text.size() % 4 != 0) text += ' ';
    while (bytes.size() % 4 != 0) bytes += '\0';
    const auto size = static_cast<std::uint32_t>(28 + text.size() + bytes.size());
    return "glTF" + bytesOf<std::uint32_t>({2, size, static_cast<std::uint32_t>(text.size())}) +
           "JSON" + text + bytesOf<std::uint32_t>({static_cast<std::uint32_t>(bytes.size())}) +
           std::string("BIN\0", 4) + bytes;
  }
};

MeshContents read(const std::string& contents) {
  return mesh_texts::readAs(
      [](const MeshSource& source) {
        bool reads_others = false;
        return readGltf(source, reads_others);
      },
      contents);
}

void expectTetrahedron(const MeshContents& contents,
                       const Vector3d& last = {0, 0, static_cast<double>(1.1F)}) {
  ASSERT_EQ(contents.meshes.size(), 1U);
  const FileMesh& mesh = contents.meshes[0];
  ASSERT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.vertices[1], Vector3d(1, 0, 0));
  EXPECT_EQ(mesh.vertices[3], last);
  ASSERT_EQ(mesh.faces.size(), 4U);
  EXPECT_EQ(cornersOf(mesh, 1), (Corners{0, 1, 3}));
  ASSERT_EQ(contents.instances.size(), 1U);
}

TEST(ReadGltf, TextAndBinary) {
  const Tetrahedron file;
  expectTetrahedron(read(file.json()));
  expectTetrahedron(read(file.glb()));
  Tetrahedron spread;  // with room between the vertices
  spread.vertices = bytesOf<float>({9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9, 0, 0, 1.1F});
  spread.view = R"(, "byteStride": 16)";
  spread.position = R"("bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": 4,
"type": "VEC3")";
  expectTetrahedron(read(spread.json()));
  Tetrahedron plain;  // without indices
  plain.vertices = bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
  plain.position = R"("bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3")";
  plain.primitive = R"("attributes": {"POSITION": 0})";
  EXPECT_EQ(cornersOf(read(plain.json()).meshes.at(0), 0), (Corners{0, 1, 2}));
}

TEST(ReadGltf, LaterVersionsAndEscapedData) {
  Tetrahedron file;
  std::string text = file.json();
  const std::string version = R"("version": "2.0")";
  text.replace(text.find(version), version.size(), R"("version": "2.7", "minVersion": "2.0")");
  const std::size_t data = text.find("base64,") + 7;
  for (std::size_t at = data; text[at] != '"'; ++at)
    if (at % 5 == 0) {
      char escaped[4];
      std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned>(text[at]));
      text.replace(at, 1, escaped);
      at += 2;
    }
  expectTetrahedron(read(text));
}

TEST(ReadGltf, QuantisedCoordinates) {
  Tetrahedron file;
  file.more += R"(, "extensionsRequired": ["KHR_mesh_quantization"])";
  file.vertices = bytesOf<std::int16_t>({0, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 0, -32768});
  file.position = R"("bufferView": 0, "componentType": 5122, "normalized": true, "count": 4,
"type": "VEC3")";
  expectTetrahedron(read(file.json()), {0, 0, -1});
  file.vertices = bytesOf<std::uint8_t>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 255});
  file.position = R"("bufferView": 0, "componentType": 5121, "count": 4, "type": "VEC3")";
  expectTetrahedron(read(file.json()), {0, 0, 255});
}

TEST(ReadGltf, StripsFansLinesAndPoints) {
  Tetrahedron file;
  const auto as = [&](int mode) {
    file.primitive =
        R"("attributes": {"POSITION": 0}, "indices": 1, "mode": )" + std::to_string(mode);
    return read(file.json());
  };
  file.indices = bytesOf<std::uint8_t>({0, 1, 2, 3});
  file.index = R"("bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR")";
  EXPECT_EQ(cornersOf(as(5).meshes.at(0), 1), (Corners{2, 1, 3}));
  EXPECT_EQ(cornersOf(as(6).meshes.at(0), 1), (Corners{0, 2, 3}));
  EXPECT_TRUE(as(1).meshes.empty());
  EXPECT_EQ(as(1).not_solid.lines, 2);
  EXPECT_EQ(as(0).not_solid.points, 4);
}

/// Parts of a mesh may share their vertices, each with a few of them.
TEST(ReadGltf, PartsTakeTheVerticesThatTheyName) {
  Tetrahedron file;
  file.indices = bytesOf<std::uint16_t>({3, 1, 3});
  file.index = R"("bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR")";
  const MeshContents contents = read(file.json());
  ASSERT_EQ(contents.meshes.at(0).vertices.size(), 2U);
  EXPECT_EQ(contents.meshes[0].vertices[1], Vector3d(0, 0, static_cast<double>(1.1F)));
  EXPECT_EQ(cornersOf(contents.meshes[0], 0), (Corners{1, 0, 1}));
}

TEST(ReadGltf, NodesPlaceMeshes) {
  Tetrahedron file;
  // 90 degrees about z, with z mirrored, 5 along x; the other node is in no scene.
  file.nodes = R"([{"children": [1], "translation": [5, 0, 0]},
{"mesh": 0, "rotation": [0, 0, 0.70710678, 0.70710678], "scale": [1, 1, -2]}, {"mesh": 0}])";
  const MeshContents contents = read(file.json());
  ASSERT_EQ(contents.instances.size(), 1U);
  const auto& X = contents.instances[0].placement;
  const Vector3d moved = X.leftCols<3>() * Vector3d(1, 2, 3) + X.col(3);
  EXPECT_LT((moved - Vector3d(3, 1, -6)).norm(), 1e-12);
  file.nodes = R"([{"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, -2, 0, 5, 0, 0, 1]},
{"mesh": 0}])";
  EXPECT_LT((read(file.json()).instances[0].placement - X).norm(), 1e-12);
  file.more = R"("asset2": 0)";  // without a scene all nodes count
  EXPECT_EQ(read(file.json()).instances.size(), 2U);
}

TEST(ReadGltf, RefusesWhatItWouldReadWrongly) {
  const auto expectRefused = [](const std::string& contents, const std::string& part) {
    try {
      read(contents);
      ADD_FAILURE() << "was read: " << part;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("would be accepted"), std::string::npos)
          << error.what();
    }
  };
  const auto changed = [&](std::string Tetrahedron::*part, const std::string& text,
                           const std::string& message) {
    Tetrahedron file;
    file.*part = text;
    expectRefused(file.json(), message);
    if (part != &Tetrahedron::buffer) expectRefused(file.glb(), message);
  };
  const std::string vec3 = R"("bufferView": 0, "componentType": 5126, "count": 4, "type": )";
  changed(&Tetrahedron::position, vec3 + R"("VEC2")", "accessors[0].type is");
  changed(&Tetrahedron::position, vec3 + R"("SCALAR")", "accessors[0].type is");
  changed(&Tetrahedron::position, R"("componentType": 5126, "count": 4, "type": "VEC3")",
          "accessors[0].bufferView is missing");
  changed(&Tetrahedron::position, vec3 + R"("VEC3", "sparse": {})", "is sparse");
  changed(&Tetrahedron::position,
          R"("bufferView": 0, "componentType": 5130, "count": 4, "type": "VEC3")", "5130");
  changed(&Tetrahedron::position,
          R"("bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3")",
          "accessors[0].count is '5'");
  changed(&Tetrahedron::position,
          R"("bufferView": 7, "componentType": 5126, "count": 4, "type": "VEC3")", "0 to 1");
  changed(&Tetrahedron::index,
          R"("bufferView": 1, "componentType": 5123, "count": 11, "type": "SCALAR")",
          "11 corners; three for each triangle");
  changed(&Tetrahedron::index,
          R"("bufferView": 1, "componentType": 5122, "count": 12, "type": "SCALAR")",
          "without a sign");
  changed(&Tetrahedron::indices, bytesOf<std::uint16_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 99}),
          "vertex 99 of 4");
  changed(&Tetrahedron::vertices, bytesOf<float>({0, 0, 0, 1, NAN, 0, 0, 1, 0, 0, 0, 1}),
          "not finite");
  changed(&Tetrahedron::view, R"(, "byteStride": 8)", "bufferViews[0].byteStride is '8'");
  changed(&Tetrahedron::primitive, R"("indices": 1)", "POSITION is missing");
  changed(&Tetrahedron::primitive, R"("attributes": {"POSITION": 0}, "mode": 7)", "mode is '7'");
  changed(&Tetrahedron::mesh, R"(, "weights": [0, 1])", "meshes[0].weights is a list");
  changed(&Tetrahedron::nodes, R"([{"mesh": 0, "skin": 0}])", "nodes[0].skin is '0'");
  changed(&Tetrahedron::nodes, R"([{"mesh": 0, "weights": [1]}])", "nodes[0].weights");
  changed(&Tetrahedron::nodes, R"([{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}])",
          "EXT_mesh_gpu_instancing is an object");
  changed(&Tetrahedron::nodes, R"([{"mesh": 3}])", "nodes[0].mesh is '3'; 0 to 0");
  for (const char* key : {"Translation", "translate", "rot"})
    changed(&Tetrahedron::nodes, R"([{"mesh": 0, ")" + std::string(key) + R"(": [1, 0, 0]}])",
            "nodes[0] has the unknown key '" + std::string(key) + "'");
  changed(&Tetrahedron::nodes, R"([{"mesh": 0, "children": [0]}])", "below itself");
  changed(&Tetrahedron::nodes, R"([{"children": [1, 1]}, {"mesh": 0}])", "two parents");
  changed(&Tetrahedron::nodes, R"([{"mesh": 0, "rotation": [0, 0, 1, 1]}])", "unit quaternion");
  changed(&Tetrahedron::nodes, R"([{"mesh": 0, "scale": [1, 1]}])", "3 finite numbers");
  const std::string identity = R"("matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])";
  for (const char* beside :
       {R"("translation": [1, 0, 0])", R"("scale": [1, 1, 1])", R"("rotation": [0, 0, 0, 1])"})
    changed(&Tetrahedron::nodes, R"([{"mesh": 0, )" + identity + ", " + beside + "}]",
            "stands beside a matrix");
  changed(&Tetrahedron::more, R"("extensionsRequired": ["KHR_draco_mesh_compression"])",
          "KHR_draco_mesh_compression");
  changed(&Tetrahedron::more, R"("scenes": [{"nodes": [5]}])", "scenes[0].nodes[0] is '5'");
  changed(&Tetrahedron::more, R"("scenes": 3)", "scenes is '3'; a list");
  changed(&Tetrahedron::buffer, R"("uri": "data:text/plain,)", "base64");
  changed(&Tetrahedron::buffer, R"("uri": "data:;base64,*)", "'*'");
  changed(&Tetrahedron::buffer, R"("uri": "gone.bin)", "gone.bin");
  changed(&Tetrahedron::buffer, R"("uri": "data:;base64,AAAA)", "bytes that are there");
  expectRefused("{}", "asset.version is missing");
  expectRefused(R"({"asset": {}})", "asset.version is missing");
  for (const char* version : {"1.0", "20.0", "2.", "2.x"})
    expectRefused(R"({"asset": {"version": ")" + std::string(version) + "\"}}",
                  "asset.version is '\"" + std::string(version) + "\"'");
  expectRefused(R"({"asset": {"version": "2.1", "minVersion": "2.1"}})",
                "asset.minVersion is '\"2.1\"'");
  changed(&Tetrahedron::buffer, R"("uri": "https://a.b/c.bin)", "name of a file");
  expectRefused("{\n\"asset\": nope}", ":2: is not JSON here");
  expectRefused("[]", "the file is a list");
  const std::string whole = Tetrahedron().glb();
  for (std::size_t size = 4; size < whole.size(); size += 7)
    EXPECT_THROW(read(whole.substr(0, size)), InputError) << size;
}

TEST(ReadGltf, DeeplyNestedTextsEnd) {
  const std::string deep(100'000, '[');
  EXPECT_THROW(read(R"({"asset": {"version": "2.0"}, "scenes": )" + deep), InputError);
  EXPECT_THROW(read(R"({"asset": {"version": )" + deep + std::string(100'000, ']') + "}}"),
               InputError);
}

}  // namespace
}  // namespace leeway::robots
