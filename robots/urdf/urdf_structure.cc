// Checks on a URDF as a whole: a tree of links, mimics that end at a joint with a position.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "robots/urdf/rotation.h"
#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

class StructureCheck {
 public:
  explicit StructureCheck(UrdfDocument& document) : document_(document) {}

  void run() {
    checkParents();
    checkTree();
    checkMimics();
  }

 private:
  /// `at`: a link or joint.
  template <typename Element>
  [[noreturn]] static void failAt(const Element& at, int line, const std::string& message) {
    throw InputError(at.file, line, message);
  }

  void checkParents() {
    parent_joint_.assign(document_.links.size(), -1);
    for (std::size_t i = 0; i < document_.joints.size(); ++i) {
      const UrdfJoint& joint = document_.joints[i];
      const std::string& child = document_.links[static_cast<std::size_t>(joint.child)].name;
      if (joint.parent == joint.child)
        failAt(joint, joint.line,
               "joint " + inQuotes(joint.name) + " joins link " + inQuotes(child) +
                   " to itself; two different links would be accepted");
      int& parent = parent_joint_[static_cast<std::size_t>(joint.child)];
      if (parent >= 0) {
        const UrdfJoint& first = document_.joints[static_cast<std::size_t>(parent)];
        failAt(joint, joint.line,
               "link " + inQuotes(child) + " has two parents, through joint " +
                   inQuotes(first.name) + " (" + lineOf(first.line) + ") and joint " +
                   inQuotes(joint.name) + "; one would be accepted");
      }
      parent = static_cast<int>(i);
    }
  }

  void checkTree() {
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < document_.links.size(); ++i)
      if (parent_joint_[i] < 0) roots.push_back(i);
    if (roots.size() > 1) {
      const UrdfLink& a = document_.links[roots[0]];
      const UrdfLink& b = document_.links[roots[1]];
      failAt(b, b.line,
             "the robot has " + std::to_string(roots.size()) + " roots, among them link " +
                 inQuotes(a.name) + " (" + lineOf(a.line) + ") and link " + inQuotes(b.name) +
                 "; one link without a parent would be accepted, a fixed joint can join them");
    }
    // A link that does not lead up to the root leads into a cycle.
    for (std::size_t start = 0; start < document_.links.size(); ++start) {
      std::size_t link = start;
      for (std::size_t steps = 0; parent_joint_[link] >= 0; ++steps) {
        if (steps > document_.links.size()) failCycle(link);
        link = static_cast<std::size_t>(
            document_.joints[static_cast<std::size_t>(parent_joint_[link])].parent);
      }
    }
  }

  [[noreturn]] void failCycle(std::size_t on_cycle) const {
    std::string way = inQuotes(document_.links[on_cycle].name);
    std::size_t link = on_cycle;
    const UrdfJoint* last = nullptr;
    do {
      const UrdfJoint& joint = document_.joints[static_cast<std::size_t>(parent_joint_[link])];
      if (last == nullptr || joint.line > last->line) last = &joint;
      link = static_cast<std::size_t>(joint.parent);
      way += " < " + inQuotes(document_.links[link].name);
    } while (link != on_cycle);
    failAt(*last, last->line,
           "the links form a cycle: " + way + " (each below the next); a tree would be accepted");
  }

  /// A joint whose master is not defined is an independent joint. Refuses a name that is close to
  /// that of another joint, because that one is meant.
  void loseMaster(UrdfJoint& joint) {
    std::vector<std::string> names;
    for (const UrdfJoint& known : document_.joints)
      if (&known != &joint) names.push_back(known.name);
    const std::string what = "joint " + inQuotes(joint.name) + " mimics " + inQuotes(joint.mimic) +
                             ", which is not defined";
    const std::string nearest = suggestion(joint.mimic, names);
    if (!nearest.empty()) failAt(joint, joint.mimic_line, what + "; " + nearest);
    document_.warnings.push_back(joint.file + ":" + std::to_string(joint.mimic_line) + ": " + what +
                                 ": it is an independent joint" +
                                 (joint.type == JointType::kPrismatic && std::isinf(joint.upper)
                                      ? ", which needs bounds to be planned"
                                      : ""));
    joint.has_mimic = false;
  }

  void checkMimics() {
    const JointsByName joints = jointsByName(document_);
    for (UrdfJoint& joint : document_.joints)
      if (joint.has_mimic && joints.find(joint.mimic) == joints.end()) loseMaster(joint);
    for (const UrdfJoint& joint : document_.joints) {
      if (!joint.has_mimic) continue;
      const UrdfJoint* master = &joint;
      for (std::size_t steps = 0; master->has_mimic; ++steps) {
        const UrdfJoint* next = joints.at(master->mimic);
        if (steps > document_.joints.size() || next == &joint)
          failAt(joint, joint.mimic_line,
                 "joint " + inQuotes(joint.name) + " mimics itself" +
                     (steps == 0 ? "" : " by way of others") +
                     "; a joint that has its own position would be accepted as master");
        master = next;
      }
      if (master->type != JointType::kRevolute && master->type != JointType::kContinuous &&
          master->type != JointType::kPrismatic)
        failAt(joint, joint.mimic_line,
               "joint " + inQuotes(joint.name) + " mimics " + inQuotes(master->name) + " (" +
                   lineOf(master->line) +
                   "), which has no single position; a revolute, continuous or "
                   "prismatic joint would be accepted");
    }
  }

  UrdfDocument& document_;
  std::vector<int> parent_joint_;  // of each link; -1: the root
};

}  // namespace

JointsByName jointsByName(const UrdfDocument& document) {
  JointsByName joints;
  for (const UrdfJoint& joint : document.joints) joints.emplace(joint.name, &joint);
  return joints;
}

void lockAt(UrdfJoint& joint, double position) {
  Pose moved;
  const Eigen::Vector3d axis = joint.axis.normalized();
  if (joint.type == JointType::kPrismatic)
    moved.translation = position * axis;
  else
    moved.rotation = rotationAbout(axis, position);
  joint.X_PJ = joint.X_PJ * moved;
  joint.xyz = joint.X_PJ.translation;
  joint.type = JointType::kFixed;
  joint.has_limit = joint.has_mimic = false;
}

void checkStructure(UrdfDocument& document) { StructureCheck(document).run(); }

}  // namespace leeway::robots
