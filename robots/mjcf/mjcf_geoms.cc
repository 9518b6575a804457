#include "robots/mjcf/mjcf_geoms.h"

#include <algorithm>
#include <filesystem>

#include "leeway/robots/text.h"
#include "robots/base/read_file.h"
#include "robots/urdf/rotation.h"

namespace leeway::robots {

namespace {

using std::filesystem::path;
using tinyxml2::XMLElement;

enum Type : std::size_t {
  kPlane,
  kHfield,
  kSphere,
  kCapsule,
  kEllipsoid,
  kCylinder,
  kBox,
  kMesh,
  kSdf
};
const std::vector<std::string> kTypes = {"plane",    "hfield", "sphere", "capsule", "ellipsoid",
                                         "cylinder", "box",    "mesh",   "sdf"};

/// The sizes that a type needs; mjcf.schema, `size` of geom.
std::size_t sizesOf(std::size_t type) {
  return type == kSphere ? 1 : type == kCapsule || type == kCylinder ? 2 : 3;
}

/// Half the length of `fromto`, and the pose in the middle of it.
double halfOf(const Attributes& a, const std::vector<double>& fromto, Pose& pose) {
  const Eigen::Vector3d from(fromto.data()), to(fromto.data() + 3);
  const double length = (from - to).norm();
  if (!(length > 1e-10)) a.fail("fromto", "two points that are apart would be accepted");
  pose.translation = (from + to) / 2;
  pose.rotation = rotationOfZ(from - to);
  return length / 2;
}

}  // namespace

GeomReader::GeomReader(const MjcfFile& file, const MjcfSettings& settings,
                       const DefaultClasses& classes)
    : file_(file), settings_(settings), classes_(classes) {
  file.eachOf("asset", [&](const XMLElement& e) {
    if (std::string_view(e.Name()) == "mesh") readMesh(e);
    if (std::string_view(e.Name()) == "model")
      file.fail(e,
                "<model> holds another model, which is not read; bodies in this file or in an "
                "<include> would be accepted");
  });
  file.eachOf("contact", [&](const XMLElement& e) {
    if (std::string_view(e.Name()) != "pair") return;
    for (const char* name : {"geom1", "geom2"}) paired_.insert(file.of(e).attribute(e, name));
  });
}

void GeomReader::readMesh(const XMLElement& e) {
  checkAttributes(file_, e);
  std::string name;
  if (const char* own = e.Attribute("name"))
    name = own;
  else
    name = path(file_.of(e).attribute(e, "file")).stem().string();
  if (!meshes_.emplace(name, &e).second)
    file_.fail(e, "a second mesh " + inQuotes(name) + ", the first is in " +
                      lineOf(meshes_.at(name)->GetLineNum()) + "; names must be unique");
}

GeomReader::Mesh GeomReader::resolved(const XMLElement& e) const {
  const Attributes a = classes_.of(e, "");
  if (e.Attribute("file") == nullptr)
    file_.fail(e, "<mesh> has no file; file=\"...\" is needed, other meshes are not read");
  path file = file_.of(e).attribute(e, "file");
  if (endingOf(file.string()) == ".msh")
    a.fail("file", "MuJoCo's own .msh is not read; .stl and .obj would be accepted");
  if (settings_.strips_paths) file = file.filename();
  Mesh mesh;
  mesh.path = file_.place(e, (path(settings_.mesh_folder) / file).string());
  const path whole = path(file_.main().path()).parent_path() / mesh.path;
  std::error_code error;
  if (!file_.options().kinematics_only && !std::filesystem::is_regular_file(whole, error))
    a.fail("file", "there is no " + inQuotes(whole.string()) +
                       "; a path from the file's folder, or from the compiler's meshdir, would be "
                       "accepted");
  mesh.scale = a.vector("scale", mesh.scale);
  if ((mesh.scale.array() == 0).any())
    a.fail("scale", "three numbers other than zero would be accepted");
  // A vertex v becomes S R' (v - p). Our readers scale first: R' S v - R' S p is the same for S = s
  // or R = 1.
  const Eigen::Vector3d p = a.vector("refpos", Eigen::Vector3d::Zero());
  if (const auto q = a.numbers("refquat", 4)) {
    if (!(Eigen::Vector4d(q->data()).norm() > 1e-12))
      a.fail("refquat", "a quaternion other than zero would be accepted");
    mesh.X_GM.rotation = rotationOf(*q).transpose();
    const bool is_uniform = mesh.scale.x() == mesh.scale.y() && mesh.scale.y() == mesh.scale.z();
    if (!is_uniform && mesh.X_GM.rotation != Eigen::Matrix3d::Identity())
      a.fail("refquat", "one scale for all axes would be accepted beside it");
  }
  mesh.X_GM.translation = -(mesh.X_GM.rotation * mesh.scale.cwiseProduct(p));
  return mesh;
}

GeomReader::Geom GeomReader::read(const XMLElement& element, const std::string& childclass,
                                  const Pose& X_LF, bool is_static) {
  checkAttributes(file_, element);
  const Attributes a = classes_.of(element, childclass);
  Geom geom;
  geom.name = a.text("name", "");
  geom.masks = {a.mask("contype", 1), a.mask("conaffinity", 1)};
  const std::size_t type = a.word("type", kTypes, "sphere");
  if (geom.masks.isNone() && paired_.count(geom.name) == 0) return geom;
  if (type == kHfield || type == kSdf)
    file_.fail(element, "a geom of type " + kTypes[type] +
                            " is not read; another type, or contype and conaffinity 0 for one that "
                            "collides with nothing, would be accepted");
  if (type == kPlane && !is_static)
    file_.fail(element,
               "a plane moves with its body; planes of bodies that stand still would be "
               "accepted, as in MuJoCo");
  geom.shape = shapeOf(a, type, X_LF);
  return geom;
}

std::optional<UrdfCollision> GeomReader::readVisual(const XMLElement& element,
                                                    const std::string& childclass,
                                                    const Pose& X_LF) const {
  constexpr unsigned kHidden = 3;  // the first group that MuJoCo's viewer does not show
  const Attributes a = classes_.of(element, childclass);
  const std::size_t type = a.word("type", kTypes, "sphere");
  if (a.mask("group", 0) >= kHidden || type == kPlane) return std::nullopt;
  if (type == kHfield || type == kSdf)
    file_.fail(element, "this geom of type " + kTypes[type] +
                            " is not drawn; another type would be accepted");
  UrdfCollision shape = shapeOf(a, type, X_LF);
  shape.is_hull = false;
  return shape;
}

UrdfCollision GeomReader::shapeOf(const Attributes& a, std::size_t type, const Pose& X_LF) const {
  UrdfCollision shape;
  shape.name = a.text("name", "");
  shape.file = file_.of(a.element()).path();
  shape.line = a.element().GetLineNum();
  readShape(a, type, X_LF, shape);
  return shape;
}

void GeomReader::readShape(const Attributes& a, std::size_t type, const Pose& X_LF,
                           UrdfCollision& shape) const {
  std::vector<double> size = a.over("size", {0, 0, 0});
  Pose X_FG;
  const bool is_fit = type != kMesh && !a.text("mesh", "").empty();
  if (const auto fromto = a.numbers("fromto", 6)) {
    if (is_fit) a.fail("fromto", "pos, without it, would be accepted beside a mesh");
    if (type != kCapsule && type != kCylinder && type != kEllipsoid && type != kBox)
      a.fail("fromto",
             "a capsule, cylinder, ellipsoid or box would be accepted with it, and this "
             "is a " +
                 kTypes[type]);
    if (a.vector("pos", Eigen::Vector3d::Zero()) != Eigen::Vector3d::Zero())
      a.fail("pos", "pos or fromto would be accepted");
    const double half = halfOf(a, *fromto, X_FG);
    size = type == kCapsule || type == kCylinder ? std::vector{size[0], half, 0.0}
                                                 : std::vector{size[0], size[0], half};
  } else {
    X_FG = poseOf(a, settings_);
  }
  shape.X_LG = X_LF * X_FG;
  if (type == kMesh) return readMeshGeom(a, shape);
  if (is_fit && type == kPlane)
    a.fail("mesh", "a type that can be fitted to a mesh would be accepted, this is a plane");
  if (type == kPlane) {
    shape.kind = UrdfCollision::Kind::kPlane;
    return;
  }
  if (is_fit) readFit(a, shape);
  for (std::size_t i = 0; i < sizesOf(type) && !is_fit; ++i)
    if (!(size[i] > 0))
      a.fail("size", std::to_string(sizesOf(type)) + " positive numbers would be accepted for a " +
                         kTypes[type] + (sizesOf(type) == 1 ? "" : ", fewer with fromto"));
  shape.radius = size[0];
  shape.length = 2 * size[1];
  shape.size = 2 * Eigen::Vector3d(size.data());
  shape.kind = type == kSphere      ? UrdfCollision::Kind::kSphere
               : type == kCapsule   ? UrdfCollision::Kind::kCapsule
               : type == kCylinder  ? UrdfCollision::Kind::kCylinder
               : type == kEllipsoid ? UrdfCollision::Kind::kEllipsoid
                                    : UrdfCollision::Kind::kBox;
}

const XMLElement& GeomReader::meshOf(const Attributes& a) const {
  const std::string name = a.text("mesh", "");
  if (name.empty()) a.fail("mesh", "the name of a <mesh> would be accepted");
  const auto found = meshes_.find(name);
  if (found == meshes_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, mesh] : meshes_) names.push_back(known);
    const std::string nearest = suggestion(name, names);
    a.fail("mesh", nearest.empty() ? "the name of a <mesh> would be accepted" : nearest);
  }
  return *found->second;
}

void GeomReader::readFit(const Attributes& a, UrdfCollision& shape) const {
  const XMLElement& element = meshOf(a);
  const Mesh mesh = resolved(element);
  const std::size_t inertia = classes_.of(element, "")
                                  .word("inertia", {"legacy", "exact", "shell", "convex"},
                                        settings_.exact_inertia ? "exact" : "legacy");
  if (inertia == 3)
    classes_.of(element, "")
        .fail("inertia",
              "legacy, exact or shell would be accepted, as a primitive is fitted to the mesh");
  shape.fit = MeshFit{static_cast<MeshFit::Inertia>(inertia), settings_.fits_bounds,
                      a.number("fitscale", 1), mesh.X_GM};
  if (!(shape.fit->scale > 0)) a.fail("fitscale", "a number above 0 would be accepted");
  shape.mesh_file = mesh.path;
  shape.mesh_scale = mesh.scale;
}

void GeomReader::readMeshGeom(const Attributes& a, UrdfCollision& shape) const {
  const XMLElement& element = meshOf(a);
  const Mesh mesh = resolved(element);
  shape.kind = UrdfCollision::Kind::kMesh;
  shape.is_hull = true;
  shape.file = file_.of(element).path();
  shape.line = element.GetLineNum();
  shape.mesh_file = mesh.path;
  shape.mesh_scale = mesh.scale;
  shape.X_LG = shape.X_LG * mesh.X_GM;
}

}  // namespace leeway::robots
