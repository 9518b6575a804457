// Any bytes as a mesh file of each format: contents whose numbers and indices can be used, or an
// InputError; and all polygons are cut into triangles with the same edges.

#include <cmath>
#include <cstdlib>
#include <map>

#include "collision/base/tolerances.h"
#include "leeway/robots/input_error.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/triangulate.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace {

using namespace leeway;
using Eigen::Vector3d;
using robots::FileMesh;

/// Edges of triangles, each with how much more often it is run along than back. Corners at one
/// place are one, and coordinates that meshes take for 0 are.
class Edges {
 public:
  explicit Edges(const FileMesh& mesh) : mesh_(mesh) {}
  void add(std::int32_t from, std::int32_t to, int count) {
    const Place a = place(from), b = place(to);
    if (a == b) return;
    edges_[{a, b}] += count;
    edges_[{b, a}] -= count;
  }
  bool cancel() const {
    return std::all_of(edges_.begin(), edges_.end(), [](const auto& e) { return e.second == 0; });
  }

 private:
  using Place = std::array<double, 3>;
  Place place(std::int32_t corner) const {
    const Vector3d& v = mesh_.vertices[static_cast<std::size_t>(corner)];
    const auto flushed = [](double x) { return std::abs(x) < collision::kSmallestExact ? 0 : x; };
    return {flushed(v.x()), flushed(v.y()), flushed(v.z())};
  }
  const FileMesh& mesh_;
  std::map<std::pair<Place, Place>, int> edges_;
};

void check(FileMesh& mesh) {
  for (const Vector3d& v : mesh.vertices)
    if (!v.allFinite()) fuzz::fail("a vertex is not finite");
  const auto count = static_cast<std::int32_t>(mesh.vertices.size());
  for (const FileMesh::Face& face : mesh.faces) {
    if (face.count < 3) fuzz::fail("a face of %d corners", face.count);
    for (const std::int32_t corner : mesh.cornersOf(face))
      if (corner < 0 || corner >= count) fuzz::fail("corner %d of %d", corner, count);
  }
  const robots::CutMesh cut = robots::triangulate(mesh, robots::Bent::kCut);
  Edges edges(mesh);
  for (const FileMesh::Face& face : mesh.faces) {
    const auto corners = mesh.cornersOf(face);
    for (std::size_t i = 0; i < corners.size(); ++i)
      edges.add(corners[i], corners[(i + 1) % corners.size()], 1);
  }
  for (const auto& t : cut.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.add(t[k], t[(k + 1) % 3], -1);
  if (!edges.cancel()) fuzz::fail("the triangles' edges are not the polygons'");
  const robots::CutMesh covered = robots::triangulate(mesh, robots::Bent::kCovered);
  const auto after = static_cast<std::int32_t>(mesh.vertices.size());
  for (const auto& t : covered.triangles)
    for (const std::int32_t v : t)
      if (v < 0 || v >= after) fuzz::fail("a triangle names vertex %d of %d", v, after);
}

}  // namespace

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  std::vector<std::string> seeds = sourceTextsUnder("problems/mesh", ".obj");
  seeds.push_back(
      "v 0 2 0\nv 0 0 0\nv 3 0 0.1\nv 3 1 0 1\nv 1 1 0 .5 .5 .5\nv 1 2 0\nf 1 2 3 4 5 6\nf 1//1 -1 "
      "\\\n2 3\nl 1 2\np 1\n");
  seeds.push_back(
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 "
      "1 "
      "0.5\nendloop\nendfacet\nendsolid s\n");
  std::string binary = "binary" + std::string(74, '\0') + std::string("\2\0\0\0", 4);
  for (int i = 0; i < 100; ++i) binary += static_cast<char>(i % 4 == 3 ? 0x3f : i % 7);
  seeds.push_back(binary);
  seeds.push_back(
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty double y\nproperty "
      "float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nelement tristrips 1\nproperty "
      "list "
      "int int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0.2 0.2 0.3\n0 1 0\n5 0 1 2 3 4\n5 "
      "0 1 2 "
      "-1 3\n");
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
  for (int i = 0; i < 9; ++i) ply += std::string(i % 4 == 0 ? "\0\0\x80\x3f" : "\0\0\0\0", 4);
  seeds.push_back(ply + std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13));
  seeds.push_back(
      R"(<COLLADA><asset><unit meter="0.01"/></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0.3 0.3 0.1 0 1 0</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
<tristrips count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 3</p></tristrips>
</mesh></geometry></library_geometries><library_nodes><node id="n"><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="o"><rotate>0 0 1 30</rotate><matrix>1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1</matrix>
<instance_node url="#n"/><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
  seeds.push_back(
      R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "children": [1],
"rotation": [0, 0, 0.6, 0.8], "scale": [1, 2, -1]}, {"mesh": 0, "translation": [1, 2, 3]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}]}],
"accessors": [{"bufferView": 0, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC3"},
{"bufferView": 0, "byteOffset": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 12, "byteStride": 3}],
"buffers": [{"byteLength": 12, "uri": "data:;base64,AAECAwABAgMAAQID"}]})");
  return seeds;
}

std::vector<std::string> dictionary() {
  return {"v 1 2 3\n",
          "f 1 2 3 4\n",
          "facet",
          "outer loop",
          "vertex 1 2 3\n",
          "endloop",
          "endsolid",
          "solid",
          "element ",
          "property float ",
          "end_header\n",
          "list uchar int ",
          "binary_big_endian",
          "<node>",
          "</node>",
          "<instance_node url=\"#o\"/>",
          "<translate>1 2 3</translate>",
          "<skew>45 0 1 0 1 0 0</skew>",
          "<scale>0 0 0</scale>",
          "count=\"2\"",
          "1e400",
          "-nan",
          "1e-400",
          "\"mode\": 5",
          "\"byteStride\": 1",
          "5126",
          "+.5",
          "\\\n",
          "2147483648"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string path = fuzz::writeInput("input.mesh", {data, size});
  static const robots::Stop never;
  const auto readGltf = [](const robots::MeshSource& source) {
    bool reads_others = false;
    return robots::readGltf(source, reads_others);
  };
  using Reader = robots::MeshContents (*)(const robots::MeshSource&);
  for (const Reader read : {Reader(robots::readStl), Reader(robots::readObj),
                            Reader(robots::readPly), Reader(robots::readDae), Reader(readGltf)}) {
    try {
      robots::MeshContents contents = read(robots::MeshSource(path, "", 0, never));
      for (FileMesh& mesh : contents.meshes) check(mesh);
      for (const auto& instance : contents.instances)
        if (instance.mesh >= contents.meshes.size()) fuzz::fail("an instance of no mesh");
    } catch (const robots::InputError& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
  return 0;
}
