// Places the shapes of a problem, and bounds how far the robot reaches.

#include <fmt/format.h>

#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "planner/base/did_you_mean.h"
#include "planner/validate/checks.h"
#include "planner/validate/names.h"

namespace leeway::planner {
namespace {

using robots::Geometry;
using robots::Model;
using robots::Pose;
using Ball = PointCloud::Ball;

std::vector<Pose> placeLinks(const Problem& problem, std::span<const double> configuration) {
  const Model& model = *problem.robot.model;
  if (configuration.empty()) configuration = problem.start;
  if (configuration.size() != model.variables.size())
    throw std::invalid_argument(
        fmt::format("a configuration of {} numbers; all {} variables of the model are expected",
                    configuration.size(), model.variables.size()));
  std::vector<Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, configuration, X_WL);
  return X_WL;
}

void append(const std::vector<Geometry>& geometries, const Pose& X_WB,
            std::vector<Geometry>& shapes_W) {
  for (const Geometry& geometry : geometries) {
    shapes_W.push_back(geometry);
    shapes_W.back().X_BG = X_WB * geometry.X_BG;
  }
}

}  // namespace

std::vector<Geometry> placedShapes(const Problem& problem, const std::string& name,
                                   std::span<const double> configuration) {
  const std::vector<Pose> X_WL = placeLinks(problem, configuration);
  const Model& model = *problem.robot.model;
  std::vector<Geometry> shapes_W;
  std::vector<std::string> known = {kRobotWord};
  bool found = false;
  const auto visit = [&](const std::string& body, bool is_of_robot,
                         const std::vector<Geometry>& geometries, const Pose& X_WB) {
    known.push_back(body);
    if (body != name && !(is_of_robot && name == kRobotWord)) return;
    found = true;
    append(geometries, X_WB, shapes_W);
  };
  for (std::size_t l = 0; l < model.links.size(); ++l)
    visit(model.links[l].name, true, model.links[l].geometries, X_WL[l]);
  for (const Attachment& held : problem.robot.attachments)
    visit(held.object.name, true, held.object.geometries, X_WL[at(held.link)] * held.X_LO);
  for (const Object& object : problem.world.objects)
    visit(object.name, false, object.geometries, object.X_WO);
  for (const DeformingObstacle& obstacle : problem.world.deforming)
    visit(obstacle.object.name, false, obstacle.object.geometries, obstacle.object.X_WO);
  if (!found)
    throw std::invalid_argument("unknown link or object '" + name + "'" + didYouMean(name, known));
  return shapes_W;
}

std::vector<Geometry> carveShapes(const Problem& problem, std::span<const std::string> names,
                                  std::span<const double> configuration) {
  if (names.empty())
    throw std::invalid_argument("carve is empty; names of links or objects are expected");
  if (configuration.size() == problem.robot.model->variables.size()) {
    const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
    std::vector<double> point;
    for (const int v : problem.robot.variables) point.push_back(configuration[at(v)]);
    if (const std::string fault = space.brokenLimit(point); !fault.empty())
      throw std::invalid_argument("state: " + fault + "; a state within the limits is expected");
  }
  std::vector<Geometry> all_W;
  for (const std::string& name : names) {
    const auto refuse = [&](const char* what) {
      throw std::invalid_argument(
          fmt::format("carve names '{}', which {} are expected", name, what));
    };
    for (const Object& object : problem.world.objects) {
      if (object.name != name) continue;
      if (object.cloud) refuse("is a cloud; links and objects with shapes");
      if (object.motion && !configuration.empty()) refuse("moves; links and objects at rest");
    }
    for (const DeformingObstacle& obstacle : problem.world.deforming)
      if (obstacle.object.name == name && !configuration.empty())
        refuse("deforms; links and objects at rest");
    const std::vector<Geometry> shapes_W = placedShapes(problem, name, configuration);
    all_W.insert(all_W.end(), shapes_W.begin(), shapes_W.end());
  }
  return all_W;
}

namespace {

/// The ball that contains a ball of a link wherever the planned joints move it.
class Reaches {
 public:
  explicit Reaches(const Problem& problem)
      : model_(*problem.robot.model),
        X_WL_(placeLinks(problem, {})),
        ranges_(model_.variables.size()) {
    for (std::size_t v = 0; v < ranges_.size(); ++v)
      ranges_[v] = {problem.start[v], problem.start[v]};
    const std::vector<robots::VariableRange> limits = robots::limitRanges(model_);
    for (const int v : problem.robot.variables) ranges_[at(v)] = limits[at(v)];
  }

  Ball of(int link, const Eigen::Vector3d& center_L, double radius) const {
    const auto motion = robots::relativeMotion(model_, link, -1, center_L, radius, ranges_);
    // The parent of the first joint that moves is nearer than the world's origin.
    const int base =
        motion.terms.empty() ? -1 : model_.joints[at(motion.terms.front().joint)].parent_link;
    Ball ball{Eigen::Vector3d::Zero(), motion.base_reach};
    if (motion.terms.empty())
      ball = {X_WL_[at(link)] * center_L, radius};
    else if (base >= 0)
      ball = {X_WL_[at(base)].translation,
              robots::relativeMotion(model_, link, base, center_L, radius, ranges_).base_reach};
    ball.radius += robots::kinematicsRounding(model_, ball.center.norm() + ball.radius);
    return ball;
  }

 private:
  const Model& model_;
  std::vector<Pose> X_WL_;
  std::vector<robots::VariableRange> ranges_;
};

}  // namespace

Ball pointReach(const Problem& problem, int link, const Eigen::Vector3d& p_L) {
  return Reaches(problem).of(link, p_L, 0);
}

std::vector<Ball> robotReach(const Problem& problem) {
  const Model& model = *problem.robot.model;
  const Reaches reaches(problem);
  std::vector<Ball> reach;
  const auto add = [&](int link, const Geometry& geometry, const Pose& X_LB) {
    reach.push_back(reaches.of(link, X_LB * (geometry.X_BG * geometry.shape.boundingCenter()),
                               geometry.shape.boundingRadius()));
  };
  for (std::size_t l = 0; l < model.links.size(); ++l)
    for (const Geometry& geometry : model.links[l].geometries)
      add(static_cast<int>(l), geometry, Pose());
  for (const Attachment& held : problem.robot.attachments)
    for (const Geometry& geometry : held.object.geometries) add(held.link, geometry, held.X_LO);
  return reach;
}

std::vector<Geometry> shapesOf(const Problem& problem, const std::string& name,
                               std::span<const double> configuration) {
  checkRobot(problem);
  return placedShapes(problem, name, configuration);
}

std::vector<Geometry> shapesToCarve(const Problem& problem, std::span<const std::string> names,
                                    std::span<const double> configuration) {
  checkRobot(problem);
  return carveShapes(problem, names, configuration);
}

PointCloud filteredScan(const Problem& problem, PointCloud scan, const std::optional<Pose>& X_WC,
                        const ScanFilters& filters) {
  if (!filters.carve && filters.carve_margin != 0)
    throw std::invalid_argument("carve_margin stands without carve; both are expected");
  if (filters.carve) {
    checkRobot(problem);
    if (!X_WC)
      throw std::invalid_argument(
          "carve stands without a pose; the pose of the cloud's frame is expected");
    const std::span<const int> variables = problem.robot.variables;
    if (filters.state.size() != variables.size())
      throw std::invalid_argument(
          fmt::format("carve stands without a state of {} numbers; where the robot was is expected",
                      variables.size()));
    std::vector<double> configuration = problem.start;
    for (std::size_t i = 0; i < variables.size(); ++i)
      configuration[at(variables[i])] = filters.state[i];
    scan = carved(scan, *X_WC, shapesToCarve(problem, *filters.carve, configuration),
                  filters.carve_margin, fmt::format("{}", fmt::join(*filters.carve, ", ")));
  }
  if (filters.thin) scan = thinned(scan, *filters.thin);
  if (filters.most_balls) scan = thinnedTo(scan, *filters.most_balls);
  return scan;
}

std::vector<Ball> reachOf(const Problem& problem) {
  checkRobot(problem);
  return robotReach(problem);
}

}  // namespace leeway::planner
