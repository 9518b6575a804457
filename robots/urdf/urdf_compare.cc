// urdfdom, as a second reader, must read the same robot from the file.

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <mutex>
#include <thread>

#include "leeway/robots/input_error.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

namespace {

int urdfdomType(JointType type) {
  switch (type) {
    case JointType::kFixed:
      return urdf::Joint::FIXED;
    case JointType::kRevolute:
      return urdf::Joint::REVOLUTE;
    case JointType::kContinuous:
      return urdf::Joint::CONTINUOUS;
    case JointType::kPrismatic:
      return urdf::Joint::PRISMATIC;
    case JointType::kPlanar:
      return urdf::Joint::PLANAR;
    case JointType::kFloating:
      return urdf::Joint::FLOATING;
  }
  return urdf::Joint::UNKNOWN;
}

bool sameVector(const Eigen::Vector3d& a, const urdf::Vector3& b) {
  return a.x() == b.x && a.y() == b.y && a.z() == b.z;
}

/// Equal up to rounding: urdfdom makes a quaternion of the angles, with the C library's functions.
bool samePose(const Pose& a, const urdf::Pose& b) {
  for (int i = 0; i < 3; ++i) {
    const urdf::Vector3 turned = b.rotation * urdf::Vector3(i == 0, i == 1, i == 2);
    if ((a.rotation.col(i) - Eigen::Vector3d(turned.x, turned.y, turned.z)).norm() > 1e-9)
      return false;
  }
  return sameVector(a.translation, b.position);
}

bool sameShape(const UrdfCollision& a, const urdf::Geometry& b) {
  switch (a.kind) {
    case UrdfCollision::Kind::kBox: {
      const auto* box = dynamic_cast<const urdf::Box*>(&b);
      return box != nullptr && sameVector(a.size, box->dim);
    }
    case UrdfCollision::Kind::kSphere: {
      const auto* sphere = dynamic_cast<const urdf::Sphere*>(&b);
      return sphere != nullptr && sphere->radius == a.radius;
    }
    case UrdfCollision::Kind::kCylinder:
    case UrdfCollision::Kind::kCapsule: {  // in the essence a cylinder
      const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&b);
      return cylinder != nullptr && cylinder->radius == a.radius && cylinder->length == a.length;
    }
    case UrdfCollision::Kind::kMesh: {
      const auto* mesh = dynamic_cast<const urdf::Mesh*>(&b);
      return mesh != nullptr && mesh->filename == a.mesh_file &&
             sameVector(a.mesh_scale, mesh->scale);
    }
    case UrdfCollision::Kind::kEllipsoid: {  // in the essence the box of its half axes
      const auto* box = dynamic_cast<const urdf::Box*>(&b);
      return box != nullptr && sameVector(a.size / 2, box->dim);
    }
    case UrdfCollision::Kind::kPlane:
      break;  // of MJCF
  }
  return false;
}

bool sameCollision(const UrdfCollision& a, const urdf::Collision* b) {
  return b != nullptr && b->geometry != nullptr && samePose(a.X_LG, b->origin) &&
         sameShape(a, *b->geometry);
}

bool sameJoint(const UrdfDocument& document, const UrdfJoint& a, const urdf::Joint& b) {
  const bool moves_along_axis = a.type != JointType::kFixed && a.type != JointType::kFloating;
  if (b.type != urdfdomType(a.type) ||
      b.parent_link_name != document.links[static_cast<std::size_t>(a.parent)].name ||
      b.child_link_name != document.links[static_cast<std::size_t>(a.child)].name ||
      !samePose(a.X_PJ, b.parent_to_joint_origin_transform) ||
      (moves_along_axis && !sameVector(a.axis, b.axis)))
    return false;
  if (a.has_limit &&
      (b.limits == nullptr || b.limits->lower != a.lower || b.limits->upper != a.upper ||
       b.limits->velocity != (std::isinf(a.velocity) ? 0 : a.velocity)))
    return false;
  return !a.has_mimic || (b.mimic != nullptr && b.mimic->joint_name == a.mimic &&
                          b.mimic->multiplier == a.multiplier && b.mimic->offset == a.offset);
}

/// Keeps what urdfdom says, which else goes to stderr. What other threads say goes on to the
/// handler that was there before.
class Messages final : public console_bridge::OutputHandler {
 public:
  Messages() : lock_(mutex()), before_(console_bridge::getOutputHandler()) {
    console_bridge::useOutputHandler(this);
  }
  ~Messages() override { console_bridge::useOutputHandler(before_); }
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* file,
           int line) override {
    if (std::this_thread::get_id() == thread_)
      text_ += (text_.empty() ? "" : "; ") + text;
    else if (before_ != nullptr)
      before_->log(text, level, file, line);
  }
  const std::string& text() const { return text_; }

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }

  std::lock_guard<std::mutex> lock_;  // the handler is the process's
  console_bridge::OutputHandler* before_;
  std::thread::id thread_ = std::this_thread::get_id();
  std::string text_;
};

}  // namespace

void compareWithUrdfdom(const UrdfDocument& document) {
  const auto fail = [&](int line, const std::string& what) {
    throw InputError(document.path, line,
                     "urdfdom reads " + what +
                         " otherwise than is written here; plain URDF 1.0 would be accepted");
  };
  urdf::ModelInterfaceSharedPtr model;
  {
    Messages messages;
    model = urdf::parseURDF(document.essence);
    if (model == nullptr)
      throw InputError(
          document.path, 0,
          "urdfdom refuses this file: " + messages.text() + "; plain URDF 1.0 would be accepted");
  }
  if (model->links_.size() != document.links.size()) fail(0, "the number of links");
  if (model->joints_.size() != document.joints.size()) fail(0, "the number of joints");
  for (const UrdfLink& link : document.links) {
    const auto other = model->getLink(link.name);
    if (other == nullptr || other->collision_array.size() != link.collisions.size())
      fail(link.line, "link \"" + link.name + "\"");
    for (std::size_t i = 0; i < link.collisions.size(); ++i)
      if (!sameCollision(link.collisions[i], other->collision_array[i].get()))
        fail(link.collisions[i].line, "this geometry");
  }
  for (const UrdfJoint& joint : document.joints) {
    const auto other = model->getJoint(joint.name);
    if (other == nullptr || !sameJoint(document, joint, *other))
      fail(joint.line, "joint \"" + joint.name + "\"");
  }
}

}  // namespace leeway::robots
