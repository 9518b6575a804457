#include "robots/mjcf/mjcf_settings.h"

#include <numbers>

#include "robots/urdf/rotation.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

Eigen::Matrix3d rotationOfEuler(const std::vector<double>& angles, const MjcfSettings& settings) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const char axis = settings.euler[i];
    const bool is_moving = axis >= 'a';
    const Eigen::Matrix3d turn = rotationAbout(
        Eigen::Vector3d::Unit(axis - (is_moving ? 'x' : 'X')), settings.angle(angles[i]));
    R = is_moving ? Eigen::Matrix3d(R * turn) : Eigen::Matrix3d(turn * R);
  }
  return R;
}

Eigen::Matrix3d rotationOfAxes(const Attributes& attributes, const std::vector<double>& xy) {
  Eigen::Vector3d x(xy[0], xy[1], xy[2]), y(xy[3], xy[4], xy[5]);
  if (!(x.norm() > 0)) attributes.fail("xyaxes", "an x axis other than 0 0 0 would be accepted");
  x.normalize();
  const double length = y.norm();
  y -= x.dot(y) * x;
  if (!(y.norm() > 1e-9 * length))
    attributes.fail("xyaxes", "a y axis that is not along x would be accepted");
  y.normalize();
  Eigen::Matrix3d R;
  R << x, y, x.cross(y);
  return R;
}

}  // namespace

double MjcfSettings::angle(double written) const {
  return degrees ? written * (std::numbers::pi / 180) : written;
}

MjcfSettings readSettings(const MjcfFile& file) {
  MjcfSettings settings;
  file.eachSection("compiler", [&](const XMLElement& e) {
    checkAttributes(file, e);
    const Attributes a(file, {&e});
    if (a.word("coordinate", {"local", "global"}, "local") == 1)
      file.fail(e,
                "coordinate is \"global\"; \"local\" would be accepted, as MuJoCo from 3.0 on "
                "has it");
    settings.degrees =
        a.word("angle", {"radian", "degree"}, settings.degrees ? "degree" : "radian") == 1;
    const std::string euler = a.text("eulerseq", settings.euler);
    if (euler.size() != 3 || euler.find_first_not_of("xyzXYZ") != std::string::npos)
      a.fail("eulerseq", "three letters of xyzXYZ would be accepted");
    settings.euler = euler;
    settings.mesh_folder = a.text("assetdir", settings.mesh_folder);
    settings.mesh_folder = a.text("meshdir", settings.mesh_folder);
    settings.strips_paths = a.flag("strippath", settings.strips_paths);
    settings.auto_limits = a.flag("autolimits", settings.auto_limits);
    settings.fits_bounds = a.flag("fitaabb", settings.fits_bounds);
    settings.exact_inertia = a.flag("exactmeshinertia", settings.exact_inertia);
  });
  file.eachOf("option", [&](const XMLElement& e) {
    if (std::string_view(e.Name()) != "flag") return;
    checkAttributes(file, e);
    settings.filters_parents = Attributes(file, {&e})
                                   .word("filterparent", {"disable", "enable"},
                                         settings.filters_parents ? "enable" : "disable") == 1;
  });
  return settings;
}

Pose poseOf(const Attributes& attributes, const MjcfSettings& settings) {
  Pose pose;
  pose.translation = attributes.vector("pos", Eigen::Vector3d::Zero());
  const char* given = nullptr;
  for (const char* name : {"axisangle", "euler", "xyaxes", "zaxis"}) {
    const XMLElement* at = attributes.find(name);
    if (at == nullptr) continue;
    const char* other = given == nullptr && at->Attribute("quat") != nullptr ? "quat" : given;
    if (other != nullptr)
      attributes.fail(name, "there is " + std::string(other) +
                                " already, by the element or its class; one orientation would be "
                                "accepted");
    given = name;
  }
  // In MuJoCo the others win over a quat, also where a class gives them and the element the quat.
  if (given == nullptr && attributes.find("quat") != nullptr) given = "quat";
  if (given == nullptr) return pose;
  const std::string kind = given;
  const auto numbers = [&](std::size_t count) { return *attributes.numbers(given, count); };
  const auto requireLength = [&](double length, const char* what) {
    if (!(length > 1e-12))
      attributes.fail(given, std::string(what) + " other than zero would be accepted");
  };
  if (kind == "quat") {
    const std::vector<double> q = numbers(4);
    requireLength(Eigen::Vector4d(q.data()).norm(), "a quaternion");
    pose.rotation = rotationOf(q);
  } else if (kind == "axisangle") {
    const std::vector<double> a = numbers(4);
    const Eigen::Vector3d axis(a.data());
    requireLength(axis.norm(), "an axis");
    pose.rotation = rotationAbout(axis, settings.angle(a[3]));
  } else if (kind == "euler") {
    pose.rotation = rotationOfEuler(numbers(3), settings);
  } else if (kind == "xyaxes") {
    pose.rotation = rotationOfAxes(attributes, numbers(6));
  } else {
    const Eigen::Vector3d z(numbers(3).data());
    requireLength(z.norm(), "an axis");
    pose.rotation = rotationOfZ(z);
  }
  return pose;
}

}  // namespace leeway::robots
