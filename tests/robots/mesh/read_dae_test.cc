#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_texts.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using mesh_texts::Corners;
using mesh_texts::cornersOf;
using mesh_texts::expectRefused;
using mesh_texts::readAs;

const std::string kSource =
    "<source id=\"p\"><float_array id=\"pa\" count=\"12\">0 0 0 1 0 0\n1 1 0 0 1 0.1</float_array>"
    "<technique_common><accessor source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" "
    "type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
    "type=\"float\"/></accessor></technique_common></source>\n";
const std::string kVertices =
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\n";
const std::string kInput = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
const std::string kTriangle = "<triangles count=\"1\">" + kInput + "<p>0 1 2</p></triangles>\n";
const std::string kInstance = "<instance_geometry url=\"#g\"/>";

/// Lines 1 to 4: the asset, source and vertices; line 6 has the faces, or the first of them.
std::string dae(const std::string& faces, const std::string& nodes,
                const std::string& asset = "<unit meter=\"1\"/>", const std::string& more = "") {
  return "<COLLADA><asset>" + asset + "</asset>\n<library_geometries><geometry id=\"g\"><mesh>\n" +
         kSource + kVertices + faces + "</mesh></geometry></library_geometries>\n" + more +
         "<library_visual_scenes><visual_scene id=\"s\">" + nodes +
         "</visual_scene></library_visual_scenes>\n<scene><instance_visual_scene "
         "url=\"#s\"/></scene></COLLADA>\n";
}
std::string node(const std::string& content) { return "<node>" + content + "</node>"; }

/// The place of a point of the mesh's first instance.
Vector3d placed(const std::string& transforms, const Vector3d& point,
                const std::string& asset = "") {
  const MeshContents contents =
      readAs(readDae, dae(kTriangle, node(transforms + kInstance), asset));
  const MeshContents::Placement& X = contents.instances.at(0).placement;
  return X.leftCols<3>() * point + X.col(3);
}

TEST(ReadDae, PrimitivesOfAllKinds) {
  const MeshContents contents = readAs(
      readDae,
      dae(kTriangle +
              "<polylist count=\"2\"><input semantic=\"NORMAL\" source=\"#n\" offset=\"0\"/><input "
              "semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/><vcount>4 3</vcount><p>9 0 9 1 -1 2 "
              "9 "
              "3 9 3 9 <!-- a comment --> 2 9 1</p></polylist>\n<polygons count=\"2\">" +
              kInput + "<p>0 1 2 3</p><p>2 1 0</p></polygons>\n<tristrips count=\"1\">" + kInput +
              "<p>0 1 2 3</p></tristrips>\n<trifans count=\"1\">" + kInput +
              "<p>0 1 2 3</p></trifans>\n<lines count=\"3\">" + kInput +
              "<p>0 1 1 2 2 3</p></lines>\n<linestrips count=\"1\">" + kInput +
              "<p>0 1 2</p></linestrips>\n<polylist count=\"2\">" + kInput +
              "<vcount>2 1</vcount><p>0 1 2</p></polylist>\n<triangles count=\"0\"/>\n",
          node(kInstance)));
  ASSERT_EQ(contents.meshes.size(), 1U);
  const FileMesh& mesh = contents.meshes[0];
  EXPECT_EQ(mesh.vertices.at(3), Vector3d(0, 1, 0.1));
  ASSERT_EQ(mesh.faces.size(), 9U);
  EXPECT_EQ(cornersOf(mesh, 0), (Corners{0, 1, 2}));
  EXPECT_EQ(cornersOf(mesh, 1), (Corners{0, 1, 2, 3}));
  EXPECT_EQ(cornersOf(mesh, 2), (Corners{3, 2, 1}));
  EXPECT_EQ(cornersOf(mesh, 3), (Corners{0, 1, 2, 3}));
  EXPECT_EQ(cornersOf(mesh, 4), (Corners{2, 1, 0}));
  EXPECT_EQ(cornersOf(mesh, 5), (Corners{0, 1, 2}));
  EXPECT_EQ(cornersOf(mesh, 6), (Corners{2, 1, 3}));
  EXPECT_EQ(cornersOf(mesh, 7), (Corners{0, 1, 2}));
  EXPECT_EQ(cornersOf(mesh, 8), (Corners{0, 2, 3}));
  EXPECT_EQ(mesh.faces[0].place.text(), ":6");
  EXPECT_EQ(contents.not_solid.lines, 3 + 1 + 1);
  EXPECT_EQ(contents.not_solid.points, 1);
}

TEST(ReadDae, AccessorsOfAllKinds) {
  const auto vertexOf = [](const std::string& source) {
    std::string text = dae(kTriangle, node(kInstance));
    text.replace(text.find(kSource), kSource.size(), source);
    return Vector3d(readAs(readDae, text).meshes.at(0).vertices.at(2));
  };
  const auto source = [](const std::string& numbers, const std::string& count,
                         const std::string& accessor) {
    return "<source id=\"p\"><float_array id=\"pa\" count=\"" + count + "\">" + numbers +
           "</float_array><technique_common><accessor source=\"#pa\" " + accessor +
           "</accessor></technique_common></source>\n";
  };
  // Z . X Y, from the third number on.
  EXPECT_EQ(
      vertexOf(source("0 0 1 2 3 4 5 6 7 8 9 10 11 12", "14",
                      "count=\"3\" offset=\"2\" stride=\"4\"><param name=\"Z\"/><param/><param "
                      "name=\"X\"/><param name=\"Y\"/>")),
      Vector3d(11, 12, 9));
  // Accessors without names give the first three numbers.
  EXPECT_EQ(vertexOf(source("1 2 3 4 5 6 7 8 9", "9", "count=\"3\" stride=\"3\"><param/>")),
            Vector3d(7, 8, 9));
}

TEST(ReadDae, Transformations) {
  const Vector3d p(0.5, 0.25, 2);
  EXPECT_EQ(placed("", p), p);
  EXPECT_EQ(placed("<translate>1 2 3</translate>", p), Vector3d(1.5, 2.25, 5));
  EXPECT_EQ(placed("<scale>2 4 0.5</scale>", p), Vector3d(1, 1, 1));
  EXPECT_EQ(placed("<rotate>0 0 1 90</rotate>", p), Vector3d(-0.25, 0.5, 2));
  EXPECT_EQ(placed("<rotate>0 2 0 -90</rotate>", p), Vector3d(-2, 0.25, 0.5));
  EXPECT_EQ(placed("<rotate>1 0 0 540</rotate>", p), Vector3d(0.5, -0.25, -2));
  EXPECT_EQ(placed("<rotate>0 0 0 0</rotate>", p), p);
  const Vector3d turned = placed("<rotate>1 1 1 120</rotate>", p);
  EXPECT_LT((turned - Vector3d(2, 0.5, 0.25)).norm(), 1e-15);
  EXPECT_EQ(placed("<matrix>0 -1 0 10 1 0 0 20 0 0 1 30 0 0 0 1</matrix>", p),
            Vector3d(9.75, 20.5, 32));
  // In their order: each in the frame of the previous ones.
  EXPECT_EQ(placed("<translate>1 0 0</translate><rotate>0 0 1 90</rotate><scale>2 2 2</scale>", p),
            Vector3d(0.5, 1, 4));
  // RenderMan's: y turns towards x.
  EXPECT_LT((placed("<skew>45 0 1 0 1 0 0</skew>", p) - Vector3d(0.75, 0.25, 2)).norm(), 1e-15);
  // Eye, target, up: z points back to the eye.
  EXPECT_LT((placed("<lookat>1 2 3 1 2 8 0 1 0</lookat>", p) - Vector3d(0.5, 2.25, 1)).norm(),
            1e-15);
  EXPECT_LT((placed("<lookat>0 0 0 0 0 -5 0 1 1</lookat>", p) - p).norm(), 1e-15);
}

TEST(ReadDae, UnitsCountTheUpAxisDoesNot) {
  const Vector3d p(0.5, 0.25, 2);
  EXPECT_EQ(placed("<translate>1 0 0</translate>", p, "<unit meter=\"0.5\" name=\"x\"/>"),
            Vector3d(0.75, 0.125, 1));
  EXPECT_EQ(placed("", p, "<unit name=\"x\"/>"), p);
  EXPECT_EQ(placed("<translate>1,5 0 0</translate>", p, "<unit meter=\"0,5\"/>"),
            Vector3d(1, 0.125, 1));
  // A unit without a length is a metre, whatever its name.
  for (const auto& [unit, note] :
       {std::pair("<unit name=\"millimeter\"/>", "<unit> is named 'millimeter' and has no"),
        {"<unit meter=\"1\" unit=\"x\"/>", "the attribute 'unit' of <unit> is not known"},
        {"<author/><units_of_time/>", "<author> in <asset> is not known and is left out, as are 1"},
        {"<unit name=\"meter\"/><keyword/>", "<keyword> in <asset> is not known"}}) {
    const MeshContents contents = readAs(readDae, dae(kTriangle, node(kInstance), unit));
    ASSERT_EQ(contents.notes.size(), 1U) << unit;
    EXPECT_EQ(contents.notes[0].text.find(note), 0U) << contents.notes[0].text;
    EXPECT_EQ(contents.notes[0].place.text(), ":1");
  }
  // Regression: nodes that an animation moves were placed in silence.
  const MeshContents moved = readAs(
      readDae, dae(kTriangle, node(kInstance), "",
                   "<library_animations/>\n<library_animations><animation/></library_animations>"));
  ASSERT_EQ(moved.notes.size(), 1U);
  EXPECT_EQ(moved.notes[0].text,
            "has animations; they are ignored, and nodes stay where the file has them");
  // Regression: the unit of a part was ignored in silence.
  std::string parts = dae(kTriangle, node("<asset><unit meter=\"0.5\"/></asset>" + kInstance));
  const MeshContents contents = readAs(readDae, parts);
  ASSERT_EQ(contents.notes.size(), 1U);
  EXPECT_EQ(contents.notes[0].text,
            "<unit> in the <asset> of <node> is left out; that of <COLLADA> is taken for all");
  for (const char* up : {"X_UP", "Y_UP", "Z_UP"})
    EXPECT_EQ(placed("", p, std::string("<up_axis>") + up + "</up_axis>"), p) << up;
}

TEST(ReadDae, NodesInNodesAndInstances) {
  const MeshContents contents = readAs(
      readDae,
      dae(kTriangle,
          "<node id=\"a\"><translate>1 0 0</translate><node><translate>0 1 0</translate>" +
              kInstance + "</node><instance_node url=\"#lib\"/>" + kInstance +
              "</node><node><instance_node url=\"#named\"/></node>" +
              node("<instance_controller url=\"#outer\"/>"),
          "",
          "<library_nodes><node id=\"lib\"><scale>2 2 2</scale>" + kInstance +
              "</node><node name=\"named\"><translate>0 0 5</translate>" + kInstance +
              "</node></library_nodes>\n<library_controllers><controller id=\"outer\"><morph "
              "source=\"#inner\"/></controller><controller id=\"inner\"><skin "
              "source=\"#g\"><bind_shape_matrix>2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 "
              "1</bind_shape_matrix></skin></controller></library_controllers>\n"));
  EXPECT_EQ(contents.meshes.size(), 1U);
  ASSERT_EQ(contents.instances.size(), 5U);
  const auto at = [&](std::size_t i) {
    const MeshContents::Placement& X = contents.instances[i].placement;
    return Vector3d(X.leftCols<3>() * Vector3d(1, 1, 1) + X.col(3));
  };
  EXPECT_EQ(at(0), Vector3d(2, 1, 1));
  EXPECT_EQ(at(1), Vector3d(2, 2, 1));
  EXPECT_EQ(at(2), Vector3d(3, 2, 2));
  EXPECT_EQ(at(3), Vector3d(1, 1, 6));
  EXPECT_EQ(at(4), Vector3d(1, 1, 1));
  ASSERT_EQ(contents.notes.size(), 1U);
  EXPECT_EQ(contents.notes[0].text, "a mesh of <morph> is taken as it is without it");
}

TEST(ReadDae, DamagedFiles) {
  const auto refused = [](const mesh_texts::Damaged& damaged) { expectRefused(readDae, damaged); };
  const auto asset = [&](const std::string& text) { return dae(kTriangle, node(kInstance), text); };
  for (const char* meter : {"0", "-1", "-0.01", "inf", "nan", "x", "", "1 2", "1e400"})
    refused({asset("<unit meter=\"" + std::string(meter) + "\"/>"),
             ":1",
             {"the unit is meter=\"" + std::string(meter) + "\"", "above 0"}});
  // Regression: a hull without faces of its own was left out in silence.
  refused({dae(kTriangle, node(kInstance + "<instance_geometry url=\"#h\"/>"), "",
               "<library_geometries>\n<geometry id=\"h\"><convex_mesh "
               "convex_hull_of=\"#g\"/></geometry></library_geometries>"),
           ":9",
           {"<convex_mesh> has convex_hull_of; a <mesh> with its faces would be accepted"}});
  const auto faces = [&](const std::string& text) { return dae(text, node(kInstance)); };
  refused({faces("<triangles count=\"2\">" + kInput + "<p>0 1 2</p></triangles>"),
           ":6",
           {"<triangles> holds 3 corners; 6, as its count says"}});
  refused({faces("<triangles count=\"1\">" + kInput + "</triangles>"), ":6", {"holds 0 faces; 1"}});
  refused({faces("<triangles count=\"1\">" + kInput + "<p>0 1 4</p></triangles>"),
           ":6",
           {"vertex 4; 0 to 4 - 1"}});
  refused({faces("<triangles count=\"1\">" + kInput + "<p>0\n1\n-2</p></triangles>"),
           ":8",
           {"'-2' stands in <p>"}});
  refused(
      {faces("<triangles count=\"1\">" + kInput + "<p>0 1 2.5</p></triangles>"), ":6", {"'2.5'"}});
  refused(
      {faces("<triangles count=\"1\"><p>0 1 2</p></triangles>"), ":6", {"no <input>", "VERTEX"}});
  refused(
      {faces("<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/><p>0 1 "
             "2</p></triangles>"),
       ":6",
       {"ends within a corner, after 3 numbers"}});
  refused({faces("<polylist count=\"1\">" + kInput + "<vcount>4</vcount><p>0 1 2</p></polylist>"),
           ":6",
           {"more than the 3 corners"}});
  refused({faces("<polylist count=\"1\">" + kInput + "<vcount>3</vcount><p>0 1 2 3</p></polylist>"),
           ":6",
           {"3 corners of the 4"}});
  refused({faces("<polylist count=\"2\">" + kInput + "<vcount>3</vcount><p>0 1 2</p></polylist>"),
           ":6",
           {"holds 1 polygons; 2"}});
  refused({faces("<polygons count=\"2\">" + kInput + "<p>0 1 2</p></polygons>"),
           ":6",
           {"holds 1 <p>; 2"}});
  refused(
      {faces("<polygons count=\"1\">" + kInput + "<ph><p>0 1 2</p><h>1 2 3</h></ph></polygons>"),
       ":6",
       {"a polygon with holes (<ph>)"}});
  const auto nodes = [&](const std::string& text) { return dae(kTriangle, text); };
  refused({nodes(node("<instance_geometry url=\"#h\"/>")), ":8", {"'#h'", "<geometry>"}});
  refused({nodes(node("<instance_geometry url=\"other.dae#g\"/>")),
           ":8",
           {"refers to 'other.dae#g'; url=\"#ID\""}});
  refused(
      {nodes(node("<translate>1 2 3</translate>")), ":8", {"the visual scene has no geometry"}});
  refused({nodes(node("<instance_geometry/>")), ":8", {"has no url"}});
  refused({nodes("<node id=\"a\"><node><instance_node url=\"#a\"/></node></node>"),
           ":8",
           {"an instance of itself"}});
  refused({nodes(node("<translate>1 2</translate>" + kInstance)),
           ":8",
           {"<translate> holds 2 numbers; 3"}});
  refused({nodes(node("<translate>1,5,2 0 0</translate>" + kInstance)), ":8", {"'1.5,2' stands"}});
  refused({nodes(node("<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1</matrix>" + kInstance)),
           ":8",
           {"last row"}});
  // Misspelt names that matter.
  refused({asset("<unit metre=\"0.001\"/>"), ":1", {"'metre' of <unit>", "meter and name would"}});
  refused({asset("<unit name=\"mm\" Meter=\"0.001\"/>"), ":1", {"'Meter' of <unit>"}});
  refused({asset("<unit><meter>0.001</meter></unit>"), ":1", {"<meter> in <unit>", "attribute"}});
  refused({asset("<unit name=\"meter\">0.001</unit>"), ":1", {"'0.001' in <unit>", "attribute"}});
  refused({asset("<units meter=\"0.001\"/>"), ":1", {"<units> in <asset>", "<unit> would"}});
  for (const auto& [wrong, right] : {std::pair("Translate", "translate"),
                                     {"translation", "translate"},
                                     {"scal", "scale"},
                                     {"rotation", "rotate"},
                                     {"Matrix", "matrix"},
                                     {"lookAt", "lookat"},
                                     {"skews", "skew"},
                                     {"nodes", "node"},
                                     {"instance_geometri", "instance_geometry"}})
    refused({nodes(node("<" + std::string(wrong) + ">1 2 3</" + wrong + ">" + kInstance)),
             ":8",
             {"<" + std::string(wrong) + "> in <node> is not known; <" + right + "> would"}});
  refused({nodes("<Node>" + kInstance + "</Node>" + node(kInstance)),
           ":8",
           {"<Node> in <visual_scene>", "<node> would"}});
  // Transformations that flatten a geometry.
  for (const char* flat : {"<scale>1 0 1</scale>", "<scale>0 0 0</scale>",
                           "<matrix>1 0 0 0 0 1 0 0 0 0 0 5 0 0 0 1</matrix>",
                           "<matrix>1 2 3 0 2 4 6 0 0 0 1 0 0 0 0 1</matrix>"}) {
    refused({nodes(node(flat + kInstance)), ":8", {"flattens the geometry of its node"}});
    refused({nodes(node(flat + node(kInstance))), ":8", {"flattens the geometry of its node"}});
    // A flattening without a geometry loses nothing.
    EXPECT_EQ(readAs(readDae, dae(kTriangle, node(flat) + node(kInstance))).instances.size(), 1U);
  }
  refused({nodes(node("<rotate>0 0 0 30</rotate>" + kInstance)), ":8", {"no length"}});
  refused({nodes(node("<scale>1 1 nan</scale>" + kInstance)), ":8", {"'nan' is not finite"}});
  const auto replaced = [&](const std::string& a, const std::string& b) {
    std::string text = dae(kTriangle, node(kInstance));
    return text.replace(text.find(a), a.size(), b);
  };
  refused({replaced("count=\"12\"", "count=\"13\""), ":3", {"holds 12 numbers; 13"}});
  refused({replaced("0 1 0.1", "0 1"), ":3", {"holds 11 numbers; 12"}});
  refused({replaced("0 1 0.1", "0 1 0.1x"), ":4", {"'0.1x'"}});
  refused({replaced("count=\"4\" stride", "count=\"5\" stride"),
           ":4",
           {"names 5 times 3 numbers of 12"}});
  refused({replaced("source=\"#pa\"", "source=\"#pb\""), ":4", {"'#pb'", "<float_array>"}});
  refused({replaced("<scene><instance_visual_scene url=\"#s\"/></scene>", ""),
           "",
           {"has no visual scene"}});
  refused({replaced("<COLLADA>", "<collada>").substr(0, 20), ":1", {"XML syntax error"}});
  refused({"<robot/>", "", {"<COLLADA>"}});
  const std::string whole = dae(kTriangle, node(kInstance));
  for (std::size_t size = 1; size + 11 < whole.size(); size += 7) {
    static const Stop never;
    const Folder folder;
    const std::string file = folder.write("cut.dae", whole.substr(0, size));
    EXPECT_THROW(readDae(MeshSource(file, "r", 1, never)), InputError) << size;
  }
}

/// A reader that takes the first of two, or the last, reads another mesh than the next reader.
TEST(ReadDae, WhatStandsTwiceIsRefused) {
  const std::string whole = dae(kTriangle, node(kInstance));
  const auto refused = [&](const std::string& a, const std::string& b, const std::string& line,
                           const std::string& what) {
    std::string text = whole;
    ASSERT_NE(text.find(a), std::string::npos) << a;
    text.replace(text.find(a), a.size(), b);
    expectRefused(readDae, {text, line, {what}});
  };
  ASSERT_EQ(readAs(readDae, whole).meshes.size(), 1U);
  const std::string unit = "<unit meter=\"1\"/>", mesh = "<mesh>" + kSource + kVertices + kTriangle;
  refused(unit, unit + "\n<unit meter=\"0.001\"/>", ":2",
          "a second <unit> in <asset>, after that of line 1; one would be accepted");
  refused("</asset>", "</asset>\n<asset/>", ":2", "a second <asset> in <COLLADA>");
  refused("</geometry>", "\n" + mesh + "</mesh></geometry>", ":8", "a second <mesh> in <geometry>");
  refused("</geometry>", "<convex_mesh/></geometry>", ":7", "a second mesh, <convex_mesh>");
  refused("</geometry>", "</geometry>\n<geometry id=\"g\">" + mesh + "</mesh></geometry>", ":8",
          "a second <geometry> of the id 'g', after that of line 2");
  refused(kSource, kSource + kSource, ":5",
          "a second <source> of the id 'p', after that of line 3");
  refused(kVertices, kVertices + kVertices, ":6", "a second <vertices> in <mesh>");
  refused("source=\"#p\"/>", "source=\"#p\"/><input semantic=\"POSITION\" source=\"#p\"/>", ":5",
          "a second <input> of the semantic POSITION in <vertices>");
  refused(kInput, kInput + kInput, ":6", "a second <input> of the semantic VERTEX in <triangles>");
  refused("</technique_common>", "</technique_common>\n<technique_common/>", ":5",
          "a second <technique_common>");
  refused("</accessor>", "</accessor><accessor source=\"#pa\"/>", ":4",
          "a second <accessor> in <technique_common>");
  refused("name=\"Y\"", "name=\"X\"", ":4", "a second <param> of the name X in <accessor>");
  refused("<param name=\"X\" type=\"float\"/>", "", ":4", "names some of X, Y and Z");
  refused("</float_array>", "</float_array>\n<float_array id=\"pa\" count=\"0\"/>", ":5",
          "a second <float_array> of the id 'pa'");
  refused("</p>", "</p><p>0 1 3</p>", ":6", "a second <p> in <triangles>");
  refused(kTriangle,
          "<polylist count=\"1\">" + kInput +
              "<vcount>3</vcount><vcount>4</vcount><p>0 1 2</p></polylist>\n",
          ":6", "a second <vcount> in <polylist>");
  refused("</visual_scene>", "</visual_scene>\n<visual_scene id=\"s\"/>", ":9",
          "a second <visual_scene> of the id 's'");
  refused("<scene>", "<scene/><scene>", ":9", "a second <scene> in <COLLADA>");
  refused("</scene>", "<instance_visual_scene url=\"#t\"/></scene>", ":9",
          "a second <instance_visual_scene> in <scene>");
  refused("</COLLADA>\n", "</COLLADA>\n" + whole, ":10",
          "a second root element, <COLLADA>, after that of line 1");
  refused(kInstance, "<instance_node url=\"#n\"/></node><node name=\"n\"/><node name=\"n\">", ":8",
          "a second <node> of the name 'n'");
  // Elements without references, and elements of different geometries, may share an id.
  const auto accepted = [&](const std::string& a, const std::string& b) {
    std::string text = whole;
    text.replace(text.find(a), a.size(), b);
    EXPECT_EQ(readAs(readDae, text).instances.size(), 1U) << b;
  };
  accepted("</geometry>", "</geometry><geometry id=\"h\">" + mesh + "</mesh></geometry>");
  accepted("</visual_scene>", "</visual_scene><visual_scene id=\"t\"/><visual_scene id=\"t\"/>");
}

}  // namespace
}  // namespace leeway::robots
