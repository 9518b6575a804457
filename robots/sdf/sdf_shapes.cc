#include "robots/sdf/sdf_shapes.h"

#include <algorithm>

#include "robots/urdf/rotation.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;
using Kind = UrdfCollision::Kind;

const char* const kRead = "box, sphere, cylinder, capsule, ellipsoid, plane or mesh";

/// The one element of a <geometry> that is a shape.
const XMLElement& shapeIn(XmlFile& file, const XMLElement& geometry) {
  const XMLElement* shape = geometry.FirstChildElement();
  if (shape == nullptr)
    file.fail(geometry, std::string("<geometry> is empty; ") + kRead + " would be accepted");
  if (const XMLElement* second = shape->NextSiblingElement())
    file.fail(*second, "a second shape <" + std::string(second->Name()) +
                           "> in one <geometry>; one would be accepted, more go into collisions of "
                           "their own");
  return *shape;
}

void readMesh(XmlFile& file, const XMLElement& e, UrdfCollision& shape) {
  expectOnly(file, e, {"optimization"}, {"uri", "scale", "submesh"}, {"convex_decomposition"});
  if (const XMLElement* part = e.FirstChildElement("submesh"))
    file.fail(*part,
              "<submesh> takes a part of the mesh, and is not read; a file that holds only "
              "this part would be accepted");
  const XMLElement& uri = file.requiredChild(e, "uri");
  shape.kind = Kind::kMesh;
  shape.line = uri.GetLineNum();
  shape.mesh_file = file.text(uri);
  shape.mesh_from = file.path();
  if (shape.mesh_file.empty())
    file.fail(uri, "<uri> of <mesh> is empty; the path of a mesh would be accepted");
  shape.mesh_scale = vectorIn(file, e, "scale", shape.mesh_scale);
  if ((shape.mesh_scale.array() == 0).any())
    file.fail(e, "<scale> of <mesh> is " + inQuotes(textIn(file, e, "scale")) +
                     "; three numbers other than zero would be accepted");
  const char* optimized = e.Attribute("optimization");
  const std::string method = optimized == nullptr ? "" : optimized;
  shape.is_hull = method == "convex_hull";
  if (method == "convex_decomposition")
    file.leaveOut(e,
                  "optimization \"convex_decomposition\" is left out: the mesh collides as it "
                  "is");
  else if (!method.empty() && !shape.is_hull)
    file.fail(e, "optimization of <mesh> is " + inQuotes(method) +
                     "; convex_hull or convex_decomposition would be accepted");
}

void readPlane(XmlFile& file, const XMLElement& e, bool is_visual, UrdfCollision& shape) {
  expectOnly(file, e, {}, {"normal", "size"});
  const Eigen::Vector3d normal = vectorIn(file, e, "normal", Eigen::Vector3d::UnitZ());
  if (!(normal.norm() > 1e-12))
    file.fail(e, "<normal> of <plane> is zero; a direction would be accepted");
  shape.kind = is_visual ? Kind::kBox : Kind::kPlane;
  if (is_visual) {  // (What collides has no end.)
    const std::vector<double> size = numbersIn(file, e, "size", 2).value_or(std::vector{1., 1.});
    shape.size = {size[0], size[1], 0};
    if (!(shape.size.array() >= 0).all())
      file.fail(e, "<size> of <plane> is " + inQuotes(textIn(file, e, "size")) +
                       "; two edges of zero or more would be accepted");
  }
  if (normal != Eigen::Vector3d::UnitZ()) shape.X_LG.rotation *= rotationOfZ(normal);
}

}  // namespace

std::optional<UrdfCollision> readShape(const XMLElement& element, const SdfFrames& frames,
                                       int link) {
  const SdfScope& scope = frames[link].scope;
  XmlFile& file = scope.file();
  const bool is_visual = std::string_view(element.Name()) == "visual";
  if (is_visual)
    expectOnly(file, element, {"name"}, {"pose", "geometry"},
               {"cast_shadows", "laser_retro", "transparency", "visibility_flags", "meta",
                "material", "plugin"});
  else
    expectOnly(
        file, element, {"name"}, {"pose", "geometry"},
        {"surface", "laser_retro", "max_contacts", "density", "auto_inertia_params", "plugin"});
  if (const XMLElement* surface = element.FirstChildElement("surface"))
    if (const XMLElement* contact = surface->FirstChildElement("contact"))
      for (const char* mask : {"collide_bitmask", "category_bitmask", "collide_without_contact"})
        leaveOutChildren(file, *contact, mask, "the shape collides with all others");
  UrdfCollision shape;
  if (const char* name = element.Attribute("name")) shape.name = name;
  const SdfPose pose = poseIn(*scope.source, element);
  shape.X_LG = pose.X;
  if (!pose.relative_to.empty())
    shape.X_LG =
        frames.relative(link, frames.find(scope.whole(pose.relative_to), file, *pose.element)) *
        pose.X;
  const XMLElement& geometry = file.requiredChild(element, "geometry");
  file.allowAttributes(geometry, {});
  const XMLElement& e = shapeIn(file, geometry);
  shape.file = file.path();
  shape.line = e.GetLineNum();
  const std::string kind = e.Name();
  if (kind == "empty") return std::nullopt;
  if (kind == "box") {
    shape.kind = Kind::kBox;
    expectOnly(file, e, {}, {"size"});
    static_cast<void>(file.requiredChild(e, "size"));
    shape.size = vectorIn(file, e, "size", shape.size);
    if ((shape.size.array() < 0).any())
      file.fail(e, "<size> of <box> is " + inQuotes(textIn(file, e, "size")) +
                       "; edges of zero or more would be accepted");
  } else if (kind == "sphere") {
    shape.kind = Kind::kSphere;
    expectOnly(file, e, {}, {"radius"});
    shape.radius = sizeIn(file, e, "radius");
  } else if (kind == "cylinder" || kind == "capsule") {
    shape.kind = kind == "capsule" ? Kind::kCapsule : Kind::kCylinder;
    expectOnly(file, e, {}, {"radius", "length"});
    shape.radius = sizeIn(file, e, "radius");
    shape.length = sizeIn(file, e, "length");
  } else if (kind == "ellipsoid") {
    shape.kind = Kind::kEllipsoid;
    expectOnly(file, e, {}, {"radii"});
    static_cast<void>(file.requiredChild(e, "radii"));
    shape.size = 2 * vectorIn(file, e, "radii", shape.size);
    if (!(shape.size.array() > 0).all())
      file.fail(e, "<radii> of <ellipsoid> is " + inQuotes(textIn(file, e, "radii")) +
                       "; three positive numbers would be accepted");
  } else if (kind == "plane") {
    readPlane(file, e, is_visual, shape);
  } else if (kind == "mesh") {
    readMesh(file, e, shape);
  } else {
    file.fail(e, "the geometry <" + kind + "> is not read; " + kRead + " would be accepted");
  }
  return shape;
}

}  // namespace leeway::robots
