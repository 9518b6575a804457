// Reads the geometry of Collada 1.4 and 1.5. Sections are those of "COLLADA - Digital Asset Schema
// Release 1.4.1", 2008.

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "collision/base/sine_cosine.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

using tinyxml2::XMLElement;
using Matrix = Eigen::Matrix4d;

// Limit on the nodes of a scene, including instances: more result from instances of instances
// without end.
constexpr int kMostNodes = 1'000'000;
constexpr std::size_t kDeepest = 1000;
constexpr int kMostControllers = 100;  // stacked on each other
constexpr double kFlat = 1e-9;         // volume to which a matrix reduces a cube along its columns

bool isNamed(const XMLElement& element, const char* name) {
  return std::strcmp(element.Name(), name) == 0;
}

FilePlace placeOf(const XMLElement& element) { return FilePlace::line(element.GetLineNum()); }

std::string tagOf(const XMLElement& element) { return '<' + std::string(element.Name()) + '>'; }

std::string lineOf(const XMLElement& element) {
  return "line " + std::to_string(element.GetLineNum());
}

/// The names that may occur in an element.
struct KnownNames {
  std::vector<std::string> names;
  std::size_t matter;  // number of names, from the first, that place or scale geometry
};
const KnownNames kInNode = {
    {"lookat", "matrix", "rotate", "scale", "skew", "translate", "node", "instance_geometry",
     "instance_controller", "instance_node", "instance_camera", "instance_light", "asset", "extra"},
    10};
const KnownNames kInScene = {{"node", "instance_geometry", "instance_controller", "instance_node",
                              "asset", "evaluate_scene", "extra"},
                             4};
const KnownNames kInAsset = {{"unit", "up_axis", "contributor", "created", "modified", "keywords",
                              "revision", "subject", "title", "coverage", "extra"},
                             1};

template <class Visit>
void eachChild(const XMLElement& parent, const Visit& visit) {
  for (const XMLElement* child = parent.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement())
    visit(*child);
}

/// Calls visit(word, place) for each word in an element's text, without comments.
template <class Visit>
void eachWord(const XMLElement& element, const Visit& visit) {
  for (const tinyxml2::XMLNode* node = element.FirstChild(); node != nullptr;
       node = node->NextSibling()) {
    if (node->ToText() == nullptr) continue;
    Words words(node->Value(), node->GetLineNum());
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
      visit(word, words.place());
  }
}

/// Parses the whole document. Rejects text in UTF-16.
void parse(const MeshSource& source, tinyxml2::XMLDocument& document) {
  const std::string_view text = source.text();
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    source.fail("is UTF-16; a DAE file in UTF-8 would be accepted");
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    source.failAt(FilePlace::line(document.ErrorLineNum()),
                  std::string("XML syntax error (") +
                      tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()) +
                      "); a whole and well-formed DAE file would be accepted");
  const XMLElement* root = document.RootElement();
  if (root == nullptr || !isNamed(*root, "COLLADA"))
    source.fail("has no element <COLLADA> as its root; a DAE file would be accepted");
  // TinyXML2 accepts more elements after the root.
  if (const XMLElement* second = root->NextSiblingElement())
    source.failAt(placeOf(*second), "a second root element, " + tagOf(*second) +
                                        ", after that of " + lineOf(*root) +
                                        "; one <COLLADA> would be accepted");
}

class DaeReader {
 public:
  explicit DaeReader(const MeshSource& source) : source_(source) { parse(source_, document_); }

  MeshContents run() {
    source_.pause();
    const XMLElement& root = *document_.RootElement();
    index(root);
    Matrix unit = Matrix::Identity();
    unit.diagonal().head<3>().setConstant(unitOf(root));
    if (other_unit_ != nullptr)
      contents_.notes.push_back(
          {placeOf(*other_unit_), "<unit> in the <asset> of " +
                                      tagOf(*other_unit_->Parent()->Parent()->ToElement()) +
                                      " is left out; that of <COLLADA> is taken for all"});
    const XMLElement& scene = visualScene(root);
    checkChildren(scene, kInScene);
    visitChildren(scene, unit);
    if (contents_.instances.empty())
      fail(scene,
           "the visual scene has no geometry; <instance_geometry> in one of its nodes would be "
           "accepted");
    for (const XMLElement* library = root.FirstChildElement("library_animations");
         library != nullptr; library = library->NextSiblingElement("library_animations"))
      if (const XMLElement* animation = library->FirstChildElement("animation")) {
        contents_.notes.push_back({placeOf(*animation), kAnimated});
        break;
      }
    if (unknown_ > 0)
      contents_.notes.push_back(
          {first_unknown_.first,
           first_unknown_.second + " is not known and is left out" +
               (unknown_ == 1 ? "" : ", as are " + std::to_string(unknown_ - 1) + " more")});
    return std::move(contents_);
  }

 private:
  [[noreturn]] void fail(const XMLElement& at, const std::string& message) const {
    source_.failAt(placeOf(at), message);
  }

  [[noreturn]] void failTwice(const XMLElement& second, const XMLElement& first,
                              const std::string& what) const {
    fail(second, "a second " + what + ", after that of " + lineOf(first) +
                     "; one would be accepted, as which one is meant cannot be known");
  }

  /// The child of that name, null without one. Refuses two.
  const XMLElement* onlyChild(const XMLElement& parent, const char* name) const {
    const XMLElement* child = parent.FirstChildElement(name);
    if (child != nullptr)
      if (const XMLElement* second = child->NextSiblingElement(name))
        failTwice(*second, *child, tagOf(*child) + " in " + tagOf(parent));
    return child;
  }
  /// The <input> of that semantic, null without one. Refuses two.
  const XMLElement* onlyInput(const XMLElement& parent, const char* semantic) const {
    const XMLElement* found = nullptr;
    for (const XMLElement* input = parent.FirstChildElement("input"); input != nullptr;
         input = input->NextSiblingElement("input")) {
      if (input->Attribute("semantic", semantic) == nullptr) continue;
      if (found != nullptr)
        failTwice(*input, *found,
                  std::string("<input> of the semantic ") + semantic + " in " + tagOf(parent));
      found = input;
    }
    return found;
  }

  /// Rejects children with misspelt names that matter, and counts other unknown ones.
  void checkChildren(const XMLElement& parent, const KnownNames& known) {
    eachChild(parent, [&](const XMLElement& child) {
      if (std::find(known.names.begin(), known.names.end(), child.Name()) != known.names.end())
        return;
      const std::string* const near = nearestName(child.Name(), known.names);
      const std::string what = tagOf(child) + " in " + tagOf(parent);
      if (near != nullptr && static_cast<std::size_t>(near - known.names.data()) < known.matter)
        fail(child, what + " is not known; <" + *near + "> would be accepted");
      countUnknown(child, what);
    });
  }
  void countUnknown(const XMLElement& at, const std::string& what) {
    if (unknown_++ == 0) first_unknown_ = {placeOf(at), what};
  }

  // ----------------------------------------------------------------------------------------------
  // references

  /// Indexes elements by kind and id.
  void index(const XMLElement& element) {
    if (const char* id = element.Attribute("id")) {
      const std::string key = std::string(element.Name()) + '#' + id;
      if (!by_id_.try_emplace(key, &element).second) again_.try_emplace(key, &element);
    }
    const XMLElement* const unit = element.FirstChildElement("unit");
    if (unit != nullptr && std::strcmp(element.Name(), "asset") == 0 &&
        element.Parent() != document_.RootElement() && other_unit_ == nullptr)
      other_unit_ = unit;
    eachChild(element, [&](const XMLElement& child) { index(child); });
  }

  /// The id that an attribute refers to in this file.
  std::string reference(const XMLElement& element, const char* attribute) const {
    const char* text = element.Attribute(attribute);
    if (text == nullptr || text[0] != '#')
      fail(element, tagOf(element) +
                        (text == nullptr ? std::string(" has no ") + attribute
                                         : " refers to " + shown(text)) +
                        "; " + attribute + "=\"#ID\", an element of this file, would be accepted");
    return text + 1;
  }

  /// The element of that kind that `element` refers to: one below `near`, or any. Refuses an id
  /// that two have.
  const XMLElement& referred(const XMLElement& element, const char* attribute, const char* kind,
                             const XMLElement* near = nullptr) const {
    const std::string id = reference(element, attribute);
    if (near != nullptr) {
      const XMLElement* found = nullptr;
      for (const XMLElement* child = near->FirstChildElement(kind); child != nullptr;
           child = child->NextSiblingElement(kind)) {
        if (child->Attribute("id", id.c_str()) == nullptr) continue;
        if (found != nullptr) failTwice(*child, *found, tagOf(*child) + " of the id " + shown(id));
        found = child;
      }
      if (found != nullptr) return *found;
    }
    const auto found = by_id_.find(std::string(kind) + '#' + id);
    if (found == by_id_.end())
      fail(element, tagOf(element) + " refers to " + shown('#' + id) + ", and there is no <" +
                        kind + "> of that id; the id of one would be accepted");
    if (const auto again = again_.find(found->first); again != again_.end())
      failTwice(*again->second, *found->second, tagOf(*found->second) + " of the id " + shown(id));
    return *found->second;
  }

  // ----------------------------------------------------------------------------------------------
  // numbers

  std::size_t wholeNumber(const XMLElement& at, std::string_view word, FilePlace place) const {
    std::size_t value = 0;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      source_.failAt(place, shown(word) + " stands in " + tagOf(at) +
                                "; a whole number of 0 or more would be accepted");
    return value;
  }
  std::size_t attribute(const XMLElement& element, const char* name, std::size_t otherwise) const {
    const char* text = element.Attribute(name);
    if (text == nullptr) return otherwise;
    Words words(text);
    return wholeNumber(element, words.next(), placeOf(element));
  }

  /// A finite number. Some exporters write a decimal comma, in the locale of their machine.
  double number(std::string_view word, FilePlace place) const {
    const std::optional<double> value = parseNumber(word);
    if (value && std::abs(*value) <= kGreatestCoordinate) return *value;
    return coordinate(source_, value ? std::string(word) : withPoint(word), place);
  }
  static std::string withPoint(std::string_view word) {
    std::string text(word);
    if (const std::size_t comma = text.find(','); comma != std::string::npos) text[comma] = '.';
    return text;
  }

  std::vector<double> numbers(const XMLElement& element) const {
    std::vector<double> values;
    eachWord(element, [&](std::string_view word, FilePlace place) {
      values.push_back(number(word, place));
    });
    return values;
  }
  std::vector<double> numbers(const XMLElement& element, std::size_t count) const {
    std::vector<double> values = numbers(element);
    if (values.size() != count)
      fail(element, tagOf(element) + " holds " + std::to_string(values.size()) + " numbers; " +
                        std::to_string(count) + " would be accepted");
    return values;
  }

  /// The first child element or text, null without one.
  static const tinyxml2::XMLNode* firstContent(const XMLElement& element) {
    const tinyxml2::XMLNode* node = element.FirstChild();
    while (node != nullptr && node->ToElement() == nullptr && node->ToText() == nullptr)
      node = node->NextSibling();
    return node;
  }

  /// The unit in <asset>, in metres.
  double unitOf(const XMLElement& root) {
    const XMLElement* asset = onlyChild(root, "asset");
    if (asset == nullptr) return 1;
    checkChildren(*asset, kInAsset);
    const XMLElement* unit = onlyChild(*asset, "unit");
    if (unit == nullptr) return 1;
    const char* text = unit->Attribute("meter");
    for (const tinyxml2::XMLAttribute* a = unit->FirstAttribute(); a != nullptr; a = a->Next()) {
      if (std::strcmp(a->Name(), "meter") == 0 || std::strcmp(a->Name(), "name") == 0) continue;
      const std::string what = "the attribute " + shown(a->Name()) + " of <unit>";
      if (text == nullptr) fail(*unit, what + " is not known; meter and name would be accepted");
      countUnknown(*unit, what);
    }
    if (const tinyxml2::XMLNode* inside = firstContent(*unit)) {
      const std::string what =
          (inside->ToElement() != nullptr ? tagOf(*inside->ToElement())
                                          : "the text " + shown(Words(inside->Value()).next())) +
          " in <unit>";
      if (text == nullptr)
        fail(*unit, what + " is not known; the attribute meter would be accepted");
      countUnknown(*unit, what);
    }
    if (text == nullptr) {
      const char* const name = unit->Attribute("name");
      if (name != nullptr && std::strcmp(name, "meter") != 0 && std::strcmp(name, "metre") != 0)
        contents_.notes.push_back({placeOf(*unit), "<unit> is named " + shown(name) +
                                                       " and has no attribute meter: 1 is taken"});
      return 1;
    }
    Words words(text);
    const std::optional<double> metres = parseFinite(withPoint(words.next()));
    if (!metres || !(*metres > 0) || !words.atEnd())
      fail(*unit, "the unit is meter=\"" + std::string(text) +
                      "\"; a finite number above 0 would be accepted");
    return *metres;
  }

  // ----------------------------------------------------------------------------------------------
  // the scene

  const XMLElement& visualScene(const XMLElement& root) const {
    const XMLElement* scene = onlyChild(root, "scene");
    const XMLElement* instance =
        scene == nullptr ? nullptr : onlyChild(*scene, "instance_visual_scene");
    if (instance == nullptr)
      source_.fail("has no visual scene; <scene> with <instance_visual_scene> would be accepted");
    return referred(*instance, "url", "visual_scene");
  }

  /// Visits instances of a node, then its child nodes, then the nodes that it refers to.
  void visitChildren(const XMLElement& node, const Matrix& X) {
    if (++nodes_ > kMostNodes)
      fail(node, "more than 1000000 nodes, instances counted; fewer would be accepted");
    if (nodes_ % 1024 == 0) source_.pause();
    eachChild(node, [&](const XMLElement& child) {
      if (isNamed(child, "instance_geometry"))
        place(referred(child, "url", "geometry"), X);
      else if (isNamed(child, "instance_controller"))
        place(controlled(child), X);
    });
    eachChild(node, [&](const XMLElement& child) {
      if (isNamed(child, "node")) visit(child, X);
    });
    eachChild(node, [&](const XMLElement& child) {
      if (isNamed(child, "instance_node")) visit(instanced(child), X);
    });
  }

  void visit(const XMLElement& node, const Matrix& parent) {
    if (path_.size() == kDeepest)
      fail(node, "nodes stand in nodes more than 1000 deep; fewer would be accepted");
    for (const XMLElement* above : path_)
      if (above == &node) fail(node, "the node is an instance of itself; a tree would be accepted");
    path_.push_back(&node);
    if (checked_.insert(&node).second) checkChildren(node, kInNode);
    Matrix X = parent;
    const XMLElement* const flattened_above = flattened_;
    eachChild(node, [&](const XMLElement& child) { transform(child, X); });
    visitChildren(node, X);
    flattened_ = flattened_above;
    path_.pop_back();
  }

  /// The instanced node, by its id; some exporters write its name.
  const XMLElement& instanced(const XMLElement& instance) const {
    const std::string id = reference(instance, "url");
    const XMLElement* named = nullptr;
    if (by_id_.count("node#" + id) == 0) findNamed(*document_.RootElement(), id, named);
    return named != nullptr ? *named : referred(instance, "url", "node");
  }
  void findNamed(const XMLElement& element, const std::string& name,
                 const XMLElement*& found) const {
    if (isNamed(element, "node") && element.Attribute("name", name.c_str()) != nullptr) {
      if (found != nullptr) failTwice(element, *found, "<node> of the name " + shown(name));
      found = &element;
    }
    eachChild(element, [&](const XMLElement& child) { findNamed(child, name, found); });
  }

  /// The geometry below skins and morphs, in its undeformed state.
  const XMLElement& controlled(const XMLElement& instance) {
    const XMLElement* controller = &referred(instance, "url", "controller");
    for (int i = 0; i < kMostControllers; ++i) {
      const XMLElement* deformer = onlyChild(*controller, "skin");
      if (deformer == nullptr) deformer = onlyChild(*controller, "morph");
      if (deformer == nullptr)
        fail(*controller, "the controller has neither <skin> nor <morph>; one would be accepted");
      if (i == 0 && !has_controllers_) {
        has_controllers_ = true;
        contents_.notes.push_back({placeOf(*deformer), "a mesh of " + tagOf(*deformer) +
                                                           " is taken as it is without it"});
      }
      const auto next = by_id_.find("controller#" + reference(*deformer, "source"));
      if (next == by_id_.end()) return referred(*deformer, "source", "geometry");
      controller = next->second;
    }
    fail(*controller,
         "the controller's source is a controller without end; a geometry would be "
         "accepted");
  }

  void place(const XMLElement& geometry, const Matrix& X) {
    if (flattened_ != nullptr)
      fail(*flattened_, tagOf(*flattened_) +
                            " flattens the geometry of its node; one that keeps its volume would "
                            "be accepted");
    const auto [entry, is_new] = meshes_.try_emplace(&geometry, contents_.meshes.size());
    if (is_new) {
      contents_.meshes.emplace_back();
      readGeometry(geometry, contents_.meshes.back());
    }
    contents_.instances.push_back({entry->second, X.topRows<3>()});
  }

  // ----------------------------------------------------------------------------------------------
  // transformations: chapter 5, in their order

  void transform(const XMLElement& element, Matrix& X) {
    if (isNamed(element, "matrix")) {
      const std::vector<double> m = numbers(element, 16);
      // (The last row may be inexact, because exporters multiply in single precision.)
      if ((Eigen::RowVector4d(m[12], m[13], m[14], m[15]) - Eigen::RowVector4d::Unit(3))
              .cwiseAbs()
              .maxCoeff() > 1e-5)
        fail(element, "the last row of <matrix> is not 0 0 0 1, as it would be accepted");
      Matrix local = Matrix::Identity();
      for (int i = 0; i < 12; ++i) local(i / 4, i % 4) = m[static_cast<std::size_t>(i)];
      if (isFlat(local.topLeftCorner<3, 3>())) flattened_ = &element;
      X *= local;
    } else if (isNamed(element, "translate")) {
      const std::vector<double> t = numbers(element, 3);
      X.col(3).head<3>() += X.topLeftCorner<3, 3>() * Eigen::Vector3d(t[0], t[1], t[2]);
    } else if (isNamed(element, "scale")) {
      const std::vector<double> s = numbers(element, 3);
      if (std::count(s.begin(), s.end(), 0.0) > 0) flattened_ = &element;
      for (int i = 0; i < 3; ++i) X.col(i) *= s[static_cast<std::size_t>(i)];
    } else if (isNamed(element, "rotate")) {
      const std::vector<double> r = numbers(element, 4);
      turn(X, rotation(element, {r[0], r[1], r[2]}, r[3]));
    } else if (isNamed(element, "skew")) {
      turn(X, skew(element, numbers(element, 7)));
    } else if (isNamed(element, "lookat")) {
      const std::vector<double> l = numbers(element, 9);
      const Eigen::Vector3d eye(l[0], l[1], l[2]);
      const Eigen::Vector3d back = direction(element, eye - Eigen::Vector3d(l[3], l[4], l[5]));
      const Eigen::Vector3d right =
          direction(element, Eigen::Vector3d(l[6], l[7], l[8]).cross(back));
      Eigen::Matrix3d axes;
      axes << right, back.cross(right), back;
      X.col(3).head<3>() += X.topLeftCorner<3, 3>() * eye;
      turn(X, axes);
    }
  }

  /// Whether a map sends all points to one plane, within the rounding of exporters.
  static bool isFlat(const Eigen::Matrix3d& map) {
    Eigen::Matrix3d unit = map;
    for (int i = 0; i < 3; ++i) {
      const double length = unit.col(i).stableNorm();
      if (!(length > 0)) return true;
      unit.col(i) /= length;
    }
    return !(std::abs(unit.determinant()) > kFlat);
  }

  static void turn(Matrix& X, const Eigen::Matrix3d& by) {
    const Eigen::Matrix3d linear = X.topLeftCorner<3, 3>() * by;
    X.topLeftCorner<3, 3>() = linear;
  }

  Eigen::Vector3d direction(const XMLElement& element, const Eigen::Vector3d& v) const {
    const double length = v.stableNorm();
    if (!(length > 0))
      fail(element, tagOf(element) +
                        " has a direction of no length; one with a length would be "
                        "accepted");
    return v / length;
  }

  /// Argument in degrees; exact for right angles.
  static void sineCosine(double degrees, double& sine, double& cosine) {
    const double right_angles = std::round(degrees / 90);
    double s, c;
    collision::sineCosine((degrees - 90 * right_angles) * (std::numbers::pi / 180), s, c);
    const double quadrant = right_angles - 4 * std::floor(right_angles / 4);
    sine = quadrant == 0 ? s : quadrant == 1 ? c : quadrant == 2 ? -s : -c;
    cosine = quadrant == 0 ? c : quadrant == 1 ? -s : quadrant == 2 ? -c : s;
  }

  Eigen::Matrix3d rotation(const XMLElement& element, const Eigen::Vector3d& axis,
                           double degrees) const {
    if (degrees == 0) return Eigen::Matrix3d::Identity();
    if (std::abs(degrees) > 1e6)
      fail(element, "an angle of " + std::to_string(degrees) +
                        " degrees; up to a million would be accepted");
    const Eigen::Vector3d u = direction(element, axis);
    double sine, cosine;
    sineCosine(degrees, sine, cosine);
    Eigen::Matrix3d cross;
    cross << 0, -u.z(), u.y(), u.z(), 0, -u.x(), -u.y(), u.x(), 0;
    return cosine * Eigen::Matrix3d::Identity() + sine * cross + (1 - cosine) * u * u.transpose();
  }

  /// RenderMan's RiSkew: an angle, an axis to turn by the angle, and the axis to turn it towards.
  Eigen::Matrix3d skew(const XMLElement& element, const std::vector<double>& v) const {
    const Eigen::Vector3d turned(v[1], v[2], v[3]);
    const Eigen::Vector3d along = direction(element, {v[4], v[5], v[6]});
    const double parallel = turned.dot(along);
    const Eigen::Vector3d across = direction(element, turned - parallel * along);
    const double distance = turned.dot(across);
    double sine, cosine;
    sineCosine(v[0], sine, cosine);
    const double x = distance * cosine - parallel * sine;
    if (!(x > 0))
      fail(element, "<skew> by " + std::to_string(v[0]) +
                        " degrees turns its axis over; a smaller angle would be accepted");
    const double shear = (distance * sine + parallel * cosine) / x - parallel / distance;
    return Eigen::Matrix3d::Identity() + shear * along * across.transpose();
  }

  // ----------------------------------------------------------------------------------------------
  // geometries

  void readGeometry(const XMLElement& geometry, FileMesh& mesh) {
    const XMLElement* body = onlyChild(geometry, "mesh");
    const XMLElement* convex = onlyChild(geometry, "convex_mesh");
    if (body != nullptr && convex != nullptr)
      failTwice(*convex, *body, "mesh, " + tagOf(*convex) + ", in <geometry>");
    if (convex != nullptr && convex->Attribute("convex_hull_of") != nullptr)
      fail(*convex, "<convex_mesh> has convex_hull_of; a <mesh> with its faces would be accepted");
    if (body == nullptr) body = convex;
    if (body == nullptr) {
      NotSolid& left_out = contents_.not_solid;
      if (geometry.FirstChildElement("spline") == nullptr)
        fail(geometry, "the geometry has no <mesh>, which would be accepted");
      return left_out.count(left_out.curves, placeOf(geometry));
    }
    const XMLElement* vertices = onlyChild(*body, "vertices");
    eachChild(*body, [&](const XMLElement& child) {
      NotSolid& left_out = contents_.not_solid;
      if (isNamed(child, "lines") || isNamed(child, "linestrips")) {
        const std::size_t count = attribute(child, "count", 1);
        if (count == 0) return;
        left_out.count(left_out.lines, placeOf(child));
        left_out.lines += static_cast<std::int64_t>(std::min(count, std::size_t{1} << 32)) - 1;
        return;
      }
      for (const char* kind : {"triangles", "polylist", "polygons", "tristrips", "trifans"}) {
        if (!isNamed(child, kind)) continue;
        if (vertices == nullptr) fail(*body, "<mesh> has no <vertices>, which would be accepted");
        if (mesh.vertices.empty()) readVertices(*body, *vertices, mesh);
        return readFaces(child, *vertices, mesh);
      }
      for (const char* known : {"source", "vertices", "extra"})
        if (isNamed(child, known)) return;
      fail(child, "<" + std::string(child.Name()) +
                      "> stands in a <mesh>; triangles, polylist, polygons, tristrips or trifans "
                      "would be accepted");
    });
  }

  /// Reads the source of the vertices' positions.
  void readVertices(const XMLElement& body, const XMLElement& vertices, FileMesh& mesh) {
    const XMLElement* input = onlyInput(vertices, "POSITION");
    if (input == nullptr)
      fail(vertices, "<vertices> has no <input> of the semantic POSITION, which would be accepted");
    const XMLElement& source = referred(*input, "source", "source", &body);
    const XMLElement* common = onlyChild(source, "technique_common");
    const XMLElement* accessor = common == nullptr ? nullptr : onlyChild(*common, "accessor");
    if (accessor == nullptr)
      fail(source,
           "<source> has no <technique_common> with an <accessor>, which would be accepted");
    const char* kind =
        source.FirstChildElement("int_array") != nullptr ? "int_array" : "float_array";
    const XMLElement& array = referred(*accessor, "source", kind, &source);
    const std::vector<double> values = numbers(array);
    if (const std::size_t said = attribute(array, "count", values.size()); said != values.size())
      failCount(array, values.size(), " numbers", said);
    const std::array<std::size_t, 3> axes = axesOf(*accessor);
    const std::size_t count = attribute(*accessor, "count", 0);
    const std::size_t stride = attribute(*accessor, "stride", 1);
    const std::size_t offset = attribute(*accessor, "offset", 0);
    if (stride <= std::max({axes[0], axes[1], axes[2]}))
      fail(*accessor, "<accessor> has a stride of " + std::to_string(stride) +
                          "; 3, for X, Y and Z, would be accepted");
    if (offset > values.size() || count > (values.size() - offset) / stride)
      fail(*accessor, "<accessor> names " + std::to_string(count) + " times " +
                          std::to_string(stride) + " numbers of " + std::to_string(values.size()) +
                          "; no more would be accepted");
    requireCountable(source_, count, placeOf(*accessor));
    mesh.vertices.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double* const v = &values[offset + i * stride];
      mesh.vertices.emplace_back(v[axes[0]], v[axes[1]], v[axes[2]]);
    }
  }

  /// The places of X, Y and Z by the names of the accessor's params; where none has one of these
  /// names, the first three.
  std::array<std::size_t, 3> axesOf(const XMLElement& accessor) const {
    std::array<std::size_t, 3> axes = {0, 1, 2};
    const XMLElement* named[3] = {};
    std::size_t place = 0;
    for (const XMLElement* param = accessor.FirstChildElement("param"); param != nullptr;
         param = param->NextSiblingElement("param"), ++place)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::string axis(1, "XYZ"[k]);
        if (param->Attribute("name", axis.c_str()) == nullptr) continue;
        if (named[k] != nullptr)
          failTwice(*param, *named[k], "<param> of the name " + axis + " in <accessor>");
        named[k] = param;
        axes[k] = place;
      }
    if (axes[0] == axes[1] || axes[1] == axes[2] || axes[2] == axes[0])
      fail(accessor,
           "<accessor> names some of X, Y and Z and not the others; all three, or none, would be "
           "accepted");
    return axes;
  }

  /// The position of the vertices' numbers in <p>, which also has numbers of normals and others.
  struct Inputs {
    std::size_t stride = 1, offset = 0;
  };
  Inputs inputsOf(const XMLElement& faces, const XMLElement& vertices) const {
    Inputs inputs;
    const XMLElement* of_vertices = onlyInput(faces, "VERTEX");
    for (const XMLElement* input = faces.FirstChildElement("input"); input != nullptr;
         input = input->NextSiblingElement("input")) {
      const std::size_t offset = attribute(*input, "offset", 0);
      if (offset > 1000) fail(*input, "an offset above 1000; a smaller one would be accepted");
      inputs.stride = std::max(inputs.stride, offset + 1);
      if (input != of_vertices) continue;
      inputs.offset = offset;
      const char* id = vertices.Attribute("id");
      if (id == nullptr || reference(*input, "source") != id)
        fail(*input,
             "<input> of the semantic VERTEX does not name the mesh's <vertices>, which "
             "would be accepted");
    }
    if (of_vertices == nullptr)
      fail(faces, tagOf(faces) + " has no <input> of the semantic VERTEX, which would be accepted");
    return inputs;
  }

  /// Appends the corners in <p>, and returns their number.
  std::size_t readCorners(const XMLElement& p, const Inputs& inputs, FileMesh& mesh) {
    std::size_t place = 0, total = 0;
    const std::size_t before = mesh.corners.size();
    eachWord(p, [&](std::string_view word, FilePlace at) {
      if (++total % MeshSource::kLinesBetweenStops == 0) source_.pause();
      if (place == inputs.offset) {
        const std::size_t vertex = wholeNumber(p, word, at);
        if (vertex >= mesh.vertices.size())
          source_.failAt(at, "a face names vertex " + std::to_string(vertex) + "; 0 to " +
                                 std::to_string(mesh.vertices.size()) + " - 1 would be accepted");
        mesh.corners.push_back(static_cast<std::int32_t>(vertex));
      }
      if (++place == inputs.stride) place = 0;
    });
    if (place != 0)
      fail(p, "<p> ends within a corner, after " + std::to_string(total) +
                  " numbers; a multiple of " + std::to_string(inputs.stride) +
                  " would be accepted");
    requireCountable(source_, mesh.corners.size(), placeOf(p));
    return mesh.corners.size() - before;
  }

  [[noreturn]] void failCount(const XMLElement& element, std::size_t found, const std::string& of,
                              std::size_t expected) const {
    fail(element, tagOf(element) + " holds " + std::to_string(found) + of + "; " +
                      std::to_string(expected) + ", as its count says, would be accepted");
  }

  void readFaces(const XMLElement& faces, const XMLElement& vertices, FileMesh& mesh) {
    if (faces.FirstChildElement("ph") != nullptr)
      fail(*faces.FirstChildElement("ph"),
           "a polygon with holes (<ph>); triangles would be accepted");
    const XMLElement* first = faces.FirstChildElement("p");
    const bool one_list = isNamed(faces, "triangles") || isNamed(faces, "polylist");
    std::size_t count = 0;
    for (const XMLElement* p = first; p != nullptr; p = p->NextSiblingElement("p")) ++count;
    const std::size_t said = attribute(faces, "count", one_list ? 0 : count);
    if (first == nullptr) {
      if (said != 0) failCount(faces, 0, " faces", said);
      return;
    }
    const Inputs inputs = inputsOf(faces, vertices);
    if (one_list) {
      readList(faces, *first, inputs, mesh);
      return;
    }
    if (count != said) failCount(faces, count, " <p>", said);
    for (const XMLElement* p = first; p != nullptr; p = p->NextSiblingElement("p")) {
      const std::size_t begin = mesh.corners.size();
      readCorners(*p, inputs, mesh);
      if (isNamed(faces, "polygons"))
        addFace(begin, mesh.corners.size(), placeOf(*p), mesh);
      else
        addTriangles(begin, isNamed(faces, "tristrips"), placeOf(*p), mesh);
    }
  }

  /// Reads all faces in one <p>.
  void readList(const XMLElement& faces, const XMLElement& p, const Inputs& inputs,
                FileMesh& mesh) {
    const std::size_t begin = mesh.corners.size();
    const std::size_t corners = readCorners(p, inputs, mesh);
    onlyChild(faces, "p");
    const FilePlace place = placeOf(p);
    if (isNamed(faces, "triangles")) {
      const std::size_t said = attribute(faces, "count", corners / 3);
      if (corners != 3 * said) failCount(faces, corners, " corners", 3 * said);
      for (std::size_t i = 0; i < corners; i += 3) addFace(begin + i, begin + i + 3, place, mesh);
      return;
    }
    const XMLElement* sizes = onlyChild(faces, "vcount");
    if (sizes == nullptr) fail(faces, "<polylist> has no <vcount>, which would be accepted");
    std::size_t at = 0, count = 0;
    eachWord(*sizes, [&](std::string_view word, FilePlace where) {
      const std::size_t size = wholeNumber(*sizes, word, where);
      if (size > corners - at)
        source_.failAt(where, "<vcount> asks for more than the " + std::to_string(corners) +
                                  " corners in <p>; no more would be accepted");
      addFace(begin + at, begin + at + size, place, mesh);
      at += size;
      ++count;
    });
    if (at != corners)
      fail(*sizes, "<vcount> asks for " + std::to_string(at) + " corners of the " +
                       std::to_string(corners) + " in <p>; all would be accepted");
    const std::size_t said = attribute(faces, "count", count);
    if (count != said) failCount(faces, count, " polygons", said);
  }

  /// Adds a polygon over corners that were already added.
  void addFace(std::size_t begin, std::size_t end, FilePlace place, FileMesh& mesh) {
    NotSolid& left_out = contents_.not_solid;
    if (end - begin == 1) left_out.count(left_out.points, place);
    if (end - begin == 2) left_out.count(left_out.lines, place);
    if (end - begin < 3) return;
    mesh.faces.push_back(
        {static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end - begin), place});
  }

  /// Replaces the corners from `begin` on by triangles of a strip or fan.
  void addTriangles(std::size_t begin, bool is_strip, FilePlace place, FileMesh& mesh) {
    const std::vector<std::int32_t> given(mesh.corners.begin() + static_cast<std::ptrdiff_t>(begin),
                                          mesh.corners.end());
    mesh.corners.resize(begin);
    for (std::size_t i = 2; i < given.size(); ++i) {
      // Every second triangle of a strip is reversed.
      const std::size_t a = !is_strip ? 0 : i % 2 == 0 ? i - 2 : i - 1;
      const std::size_t b = !is_strip || i % 2 == 0 ? i - 1 : i - 2;
      requireCountable(source_, mesh.corners.size() + 3, place);
      mesh.addFace(std::initializer_list<std::int32_t>{given[a], given[b], given[i]}, place);
    }
  }

  const MeshSource& source_;
  tinyxml2::XMLDocument document_;
  std::unordered_map<std::string, const XMLElement*> by_id_, again_;  // again_: a second one
  const XMLElement* other_unit_ = nullptr;  // the first that is not the document's
  std::map<const XMLElement*, std::size_t> meshes_;
  std::vector<const XMLElement*> path_;
  int nodes_ = 0;
  std::unordered_set<const XMLElement*> checked_;  // nodes
  const XMLElement* flattened_ = nullptr;          // the last one that sends all points to a plane
  std::int64_t unknown_ = 0;
  std::pair<FilePlace, std::string> first_unknown_;
  bool has_controllers_ = false;
  MeshContents contents_;
};

}  // namespace

MeshContents readDae(const MeshSource& source) { return DaeReader(source).run(); }

Eigen::Matrix3d upAxisToY(const MeshSource& source) {
  tinyxml2::XMLDocument document;
  parse(source, document);
  const XMLElement* asset = document.RootElement()->FirstChildElement("asset");
  const XMLElement* up = asset == nullptr ? nullptr : asset->FirstChildElement("up_axis");
  const std::string_view axis =
      up == nullptr || up->GetText() == nullptr ? "Y_UP" : Words(up->GetText()).next();
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  if (axis == "X_UP") turned << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  if (axis == "Z_UP") turned << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return turned;
}

}  // namespace leeway::robots
