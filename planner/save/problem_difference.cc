#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/settings.h"
#include "planner/save/motion_text.h"
#include "planner/save/problem_text.h"
#include "planner/validate/names.h"

namespace leeway::planner {
namespace {

using collision::Shape;
using robots::Geometry;
using robots::Model;
using robots::Pose;

/// Motions of vertices are compared at some times, to within this [m]: modes are written as places.
constexpr double kSavedMotion = 1e-12;

// (The template below finds what is declared before it.)
bool isSame(const Waypoint& a, const Waypoint& b);
bool isSame(const CostTerm& a, const CostTerm& b);
bool isSame(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return (a - b).cwiseAbs().maxCoeff() < kSavedRotation;
}
bool isSame(const Pose& a, const Pose& b) {
  return a.translation == b.translation && isSame(a.rotation, b.rotation);
}

template <class Range>
std::vector<Eigen::Vector3d> sorted(const Range& points) {
  std::vector<Eigen::Vector3d> all(points.begin(), points.end());
  std::sort(all.begin(), all.end(), [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  });
  return all;
}

/// Whether the same triangles stand in the same order, and enclose the same.
template <class Mesh, class Vertices>
bool isSameMesh(const Mesh& a, const Vertices& at_a, const Mesh& b, const Vertices& at_b) {
  if (a.triangles().size() != b.triangles().size() || a.componentCount() != b.componentCount())
    return false;
  for (std::size_t i = 0; i < a.triangles().size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (at_a[static_cast<std::size_t>(a.triangles()[i][k])] !=
          at_b[static_cast<std::size_t>(b.triangles()[i][k])])
        return false;
  for (int c = 0; c < a.componentCount(); ++c)
    if (a.isClosed(c) != b.isClosed(c)) return false;
  return true;
}

bool isSame(const Shape& a, const Shape& b) {
  if (a.type() != b.type() || a.radius() != b.radius() || a.halfLength() != b.halfLength() ||
      a.halfExtents() != b.halfExtents())
    return false;
  if (a.hull() != nullptr) return sorted(a.hull()->vertices()) == sorted(b.hull()->vertices());
  if (a.mesh() != nullptr)
    return a.mesh() == b.mesh() ||
           isSameMesh(*a.mesh(), a.mesh()->vertices(), *b.mesh(), b.mesh()->vertices());
  if (a.deformable() != nullptr)
    return isSameMesh(a.deformable()->mesh(), a.deformable()->vertices(), b.deformable()->mesh(),
                      b.deformable()->vertices());
  return true;
}

bool isSame(const std::vector<Geometry>& a, const std::vector<Geometry>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Geometry& x, const Geometry& y) {
                      return x.name == y.name && isSame(x.X_BG, y.X_BG) && isSame(x.shape, y.shape);
                    });
}

bool isSame(const ObjectMotion& a, const ObjectMotion& b) {
  if (a.speed_bound != b.speed_bound || a.turn_bound != b.turn_bound || a.age != b.age ||
      (a.poses == nullptr) != (b.poses == nullptr))
    return false;
  if (a.poses == nullptr) return true;
  using Key = collision::PoseMotion::Key;
  return a.poses->isSteady() == b.poses->isSteady() && a.poses->velocity() == b.poses->velocity() &&
         a.poses->angularVelocity() == b.poses->angularVelocity() &&
         std::equal(
             a.poses->keyPoses().begin(), a.poses->keyPoses().end(), b.poses->keyPoses().begin(),
             b.poses->keyPoses().end(),
             [](const Key& x, const Key& y) { return x.time == y.time && isSame(x.X_WB, y.X_WB); });
}

bool isSame(const Object& a, const Object& b) {
  const auto isSameBall = [](const PointCloud::Ball& x, const PointCloud::Ball& y) {
    return x.center == y.center && x.radius == y.radius;
  };
  if (a.name != b.name || a.color != b.color || (a.cloud == nullptr) != (b.cloud == nullptr))
    return false;
  if (a.cloud && (!std::equal(a.cloud->balls.begin(), a.cloud->balls.end(), b.cloud->balls.begin(),
                              b.cloud->balls.end(), isSameBall) ||
                  a.cloud->completeWithin() != b.cloud->completeWithin()))
    return false;
  if ((a.motion == nullptr) != (b.motion == nullptr) || (a.motion && !isSame(*a.motion, *b.motion)))
    return false;
  return isSame(a.geometries, b.geometries);
}

bool isSame(const robots::PoseRegion& a, const robots::PoseRegion& b) {
  return a.link == b.link && a.base == b.base && isSame(a.X_LF, b.X_LF) && isSame(a.X_WR, b.X_WR) &&
         a.position == b.position && a.rpy == b.rpy &&
         a.position_tolerance == b.position_tolerance && a.angle_tolerance == b.angle_tolerance;
}

bool isSame(const FramePose& a, const FramePose& b) {
  return a.frame == b.frame && a.relative_to == b.relative_to && a.position == b.position &&
         a.rpy == b.rpy && isSame(a.rotation, b.rotation) &&
         a.position_tolerance == b.position_tolerance && a.angle_tolerance == b.angle_tolerance;
}

template <class Item>
bool isSame(const std::vector<Item>& a, const std::vector<Item>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Item& x, const Item& y) { return isSame(x, y); });
}

bool isSame(const Goal& a, const Goal& b) {
  return (a.name == b.name || (isGivenByPlace(a.name) && isGivenByPlace(b.name))) &&
         a.ranges == b.ranges && isSame(a.poses, b.poses);
}

bool isSame(const Waypoint& a, const Waypoint& b) {
  return a.position == b.position && a.via == b.via &&
         a.rotation.has_value() == b.rotation.has_value() &&
         (!a.rotation || isSame(*a.rotation, *b.rotation));
}

bool isSame(const MoveStep& a, const MoveStep& b) {
  return isSame(a.goal, b.goal) && isSame(a.poses, b.poses);
}
bool isSame(const LineStep& a, const LineStep& b) {
  return a.frame == b.frame && a.by == b.by && a.relative_to == b.relative_to &&
         a.position_tolerance == b.position_tolerance && a.angle_tolerance == b.angle_tolerance &&
         isSame(a.turn, b.turn) && isSame(a.poses, b.poses) && a.speed == b.speed;
}
bool isSame(const AttachStep& a, const AttachStep& b) {
  return a.object == b.object && a.link == b.link && a.touch == b.touch;
}
bool isSame(const DetachStep& a, const DetachStep& b) { return a.object == b.object; }

bool isSame(const Step& a, const Step& b) {
  return a.name == b.name && a.allowed == b.allowed && a.action.index() == b.action.index() &&
         std::visit(
             [&](const auto& x) {
               return isSame(x, std::get<std::decay_t<decltype(x)>>(b.action));
             },
             a.action);
}

bool isSame(const Constraint& a, const Constraint& b) {
  using Turn = Constraint::Turn;
  return a.name == b.name && a.frame == b.frame && a.relative_to == b.relative_to &&
         isSame(a.X_SR, b.X_SR) && a.position == b.position &&
         (a.position_tolerance == b.position_tolerance ||
          a.position == std::array{Constraint::kFree, Constraint::kFree, Constraint::kFree}) &&
         a.turn == b.turn && (a.turn != Turn::kFixed || isSame(a.rotation, b.rotation)) &&
         (a.turn != Turn::kAxis || (a.axis == b.axis && a.direction == b.direction)) &&
         (a.turn == Turn::kAny || a.angle == b.angle);
}

bool isSame(const Frame& a, const Frame& b) {
  return a.name == b.name && a.link == b.link && isSame(a.X_LF, b.X_LF);
}

bool isSame(const Attachment& a, const Attachment& b) {
  return isSame(a.object, b.object) && a.link == b.link && isSame(a.X_LO, b.X_LO) &&
         a.touch_links == b.touch_links;
}

bool isSame(const PairMargin& a, const PairMargin& b) {
  return a.a == b.a && a.b == b.b && a.margin == b.margin;
}
bool isSame(const Wish& a, const Wish& b) {
  return a.pairs == b.pairs && a.clearance == b.clearance && a.weight == b.weight;
}

bool isSame(const CostTerm& a, const CostTerm& b) {
  return a.nearness.kind == b.nearness.kind && a.nearness.distance == b.nearness.distance &&
         a.weight == b.weight && a.worst == b.worst && a.of == b.of;
}

/// Whether costs are the same. Other objectives consist of settings.
bool isSameCost(const Objective& a, const Objective& b) {
  const auto *x = std::get_if<MinimumCost>(&a), *y = std::get_if<MinimumCost>(&b);
  if (x == nullptr || y == nullptr) return x == y;
  // Their sum does not depend on the order of terms.
  const auto ordered = [](std::vector<CostTerm> terms) {
    std::stable_partition(terms.begin(), terms.end(), [](const CostTerm& t) { return !t.worst; });
    return terms;
  };
  return x->length == y->length && isSame(ordered(x->terms), ordered(y->terms));
}

bool isSameMotion(const collision::VertexMotion* a, const collision::VertexMotion* b) {
  if ((a == nullptr) != (b == nullptr)) return false;
  if (a == nullptr) return true;
  if (a->kind() != b->kind() || a->vertexCount() != b->vertexCount() ||
      !std::equal(a->keyTimes().begin(), a->keyTimes().end(), b->keyTimes().begin(),
                  b->keyTimes().end()))
    return false;
  std::vector<double> times(a->keyTimes().begin(), a->keyTimes().end());
  for (std::size_t i = 1; i < a->keyTimes().size(); ++i)
    times.push_back(0.3 * times[i - 1] + 0.7 * times[i]);
  for (const double time : {0.0, 0.137, 1.71, 13.9}) times.push_back(time);
  std::vector<Eigen::Vector3d> at_a(static_cast<std::size_t>(a->vertexCount())), at_b = at_a;
  for (const double time : times) {
    a->evaluate(time, at_a);
    b->evaluate(time, at_b);
    for (std::size_t v = 0; v < at_a.size(); ++v)
      if (!((at_a[v] - at_b[v]).cwiseAbs().maxCoeff() < kSavedMotion)) return false;
  }
  return true;
}

bool isSame(const DeformingObstacle& a, const DeformingObstacle& b) {
  const collision::DeformOptions &x = a.options, &y = b.options;
  return isSame(a.object, b.object) && isSame(a.object.X_WO, b.object.X_WO) &&
         isSameMotion(a.motion.get(), b.motion.get()) &&
         isSameMesh(*a.mesh, a.mesh->rest(), *b.mesh, b.mesh->rest()) &&
         a.speed_bound == b.speed_bound && x.strategy == y.strategy && x.volume == y.volume &&
         x.hybrid_split == y.hybrid_split && x.restructure_factor == y.restructure_factor &&
         x.speed_horizon == y.speed_horizon && x.expected_queries == y.expected_queries;
}

/// Returns the first element that differs: "world.objects[2]"; empty: none.
template <class Item>
std::string firstOf(const std::string& list, const std::vector<Item>& a,
                    const std::vector<Item>& b) {
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (!isSame(a[i], b[i])) return fmt::format("{}[{}]", list, i);
  return a.size() == b.size() ? std::string() : list;
}

std::string modelDifference(const Model& a, const Model& b) {
  if (a.links.size() != b.links.size()) return "links";
  for (std::size_t i = 0; i < a.links.size(); ++i) {
    const std::string link = fmt::format("links[{}]", i);
    const robots::Joint &x = a.joints[i], &y = b.joints[i];
    if (a.links[i].name != b.links[i].name || !isSame(a.links[i].geometries, b.links[i].geometries))
      return link;
    if (x.name != y.name || x.type != y.type || x.parent_link != y.parent_link ||
        !isSame(x.X_PJ, y.X_PJ) || x.axis != y.axis || x.first_variable != y.first_variable ||
        x.mimic != y.mimic || x.multiplier != y.multiplier || x.offset != y.offset)
      return fmt::format("joints[{}]", i);
  }
  if (a.variables.size() != b.variables.size()) return "variables";
  for (std::size_t v = 0; v < a.variables.size(); ++v) {
    const robots::Variable &x = a.variables[v], &y = b.variables[v];
    if (x.name != y.name || x.lower != y.lower || x.upper != y.upper || x.velocity != y.velocity ||
        x.acceleration != y.acceleration || x.jerk != y.jerk || x.touchRange() != y.touchRange())
      return fmt::format("variables[{}]", v);
  }
  const auto isSamePair = [](const robots::DisabledPair& x, const robots::DisabledPair& y) {
    return x.link_a == y.link_a && x.link_b == y.link_b;
  };
  if (!std::equal(a.disabled_pairs.begin(), a.disabled_pairs.end(), b.disabled_pairs.begin(),
                  b.disabled_pairs.end(), isSamePair))
    return "disabled_pairs";
  if (a.unchecked_links != b.unchecked_links) return "unchecked_links";
  if (a.enabled_pairs != b.enabled_pairs) return "enabled_pairs";
  if (a.has_srdf != b.has_srdf) return "has_srdf";
  return {};
}

/// 0 and infinity both stand for an unlimited time.
double limitOf(double time) { return std::isinf(time) ? 0 : time; }

/// The first setting with a value of its own that differs; empty: none. The cost of an objective is
/// compared in isSameCost().
std::string settingDifference(const Problem& a, const Problem& b) {
  const auto isSameValue = [](const Setting& setting, const auto* x, const auto* y) {
    if (x == nullptr || y == nullptr) return x == y;
    if constexpr (std::is_same_v<decltype(x), const double*>)
      if (setting.key == "limits.time") return limitOf(*x) == limitOf(*y);
    return *x == *y;
  };
  for (const Setting& setting : settings()) {
    const bool is_same = std::visit(
        [&](const auto& place) {
          using Place = std::decay_t<decltype(place)>;
          if constexpr (std::is_same_v<Place, WordSetting>)
            return place.get(a) == place.get(b);
          else if constexpr (std::is_pointer_v<Place>)
            return isSameValue(setting, settingValue(a, place), settingValue(b, place));
          else  // compared by problemDifference(), or one of the planner's parameters
            return true;
        },
        setting.value);
    if (!is_same) return std::string(setting.member.empty() ? setting.key : setting.member);
  }
  return {};
}

}  // namespace

std::string problemDifference(const Problem& a, const Problem& b) {
  if (const std::string in = modelDifference(*a.robot.model, *b.robot.model); !in.empty())
    return "robot.model." + in;
  if (a.robot.variables != b.robot.variables) return "robot.variables";
  if (a.start != b.start) return "start";
  if (static_cast<bool>(a.condition.accept) != static_cast<bool>(b.condition.accept))
    return "condition";
  // (More frames may have been added for poses.)
  std::vector<Frame> frames = b.robot.frames;
  if (frames.size() > a.robot.frames.size()) frames.resize(a.robot.frames.size());
  for (const std::string& in :
       {firstOf("robot.attachments", a.robot.attachments, b.robot.attachments),
        firstOf("robot.frames", a.robot.frames, frames),
        firstOf("start_poses", a.start_poses, b.start_poses), firstOf("goals", a.goals, b.goals),
        firstOf("steps", a.steps, b.steps), firstOf("constraints", a.constraints, b.constraints),
        firstOf("world.objects", a.world.objects, b.world.objects),
        firstOf("world.deforming", a.world.deforming, b.world.deforming),
        firstOf("margins.pairs", a.margins.pairs, b.margins.pairs),
        firstOf("margins.wishes", a.margins.wishes, b.margins.wishes), settingDifference(a, b)})
    if (!in.empty()) return in;
  for (std::size_t i = 0; i < a.world.objects.size(); ++i)
    if (!isSame(a.world.objects[i].X_WO, b.world.objects[i].X_WO))
      return fmt::format("world.objects[{}].X_WO", i);
  if (a.contacts.allowed != b.contacts.allowed) return "contacts.allowed";
  if (a.contacts.checked != b.contacts.checked) return "contacts.checked";
  if (a.contacts.replace_srdf != b.contacts.replace_srdf) return "contacts.replace_srdf";
  return isSameCost(a.objective, b.objective) ? "" : "objective";
}

}  // namespace leeway::planner
