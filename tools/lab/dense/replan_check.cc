// Checks an executed trajectory at many instants, with separate kinematics, exact vertices of
// everything that deforms, FCL for contact, and every triangle against every link for the distance.
// Then the limits on velocity, acceleration and jerk, by differences of rows.

#include <fcl/fcl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/trajectory.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/dense/joint_motion.h"
#include "tools/lab/dense/trajectory_file.h"
#include "tools/lab/fcl/fcl_shape.h"

namespace {

using Eigen::Isometry3d;
using leeway::at;
using leeway::collision::Shape;
using leeway::lab::FclGeometry;
using leeway::lab::isometry;
using leeway::planner::DeformingObstacle;
using leeway::planner::Object;
using leeway::planner::Problem;
namespace robots = leeway::robots;

/// A placed shape.
struct Part {
  std::string owner;
  int link = -1;  // -1: the world
  Shape shape;
  Isometry3d X_LG;
  FclGeometry geometry;
  Isometry3d X_WG;
  std::shared_ptr<const leeway::collision::PoseMotion> motion = nullptr;  // of an object that moves
};

class World {
 public:
  explicit World(const Problem& problem)
      : problem_(problem), model_(*problem.robot.model), X_WL_(model_.links.size()) {
    for (std::size_t l = 0; l < model_.links.size(); ++l)
      if (moves(static_cast<int>(l)))
        for (const robots::Geometry& g : model_.links[l].geometries)
          add(robot_, model_.links[l].name, static_cast<int>(l), g, Isometry3d::Identity());
    for (const auto& held : problem.robot.attachments)
      if (moves(held.link))
        for (const robots::Geometry& g : held.object.geometries)
          add(robot_, held.object.name, held.link, g, isometry(held.X_LO));
    for (const Object& object : problem.world.objects) {
      for (const robots::Geometry& g : object.geometries)
        add(still_, object.name, -1, g, isometry(object.X_WO));
      if (object.cloud)
        for (const robots::Geometry& g : geometriesOf(*object.cloud))
          add(still_, object.name, -1, g, isometry(object.X_WO));
    }
    for (Part& part : still_) part.X_WG = part.X_LG;
    for (const Object& object : problem.world.objects) {
      if (!object.motion || !object.motion->poses) continue;
      for (Part& part : still_) {
        if (part.owner != object.name) continue;
        part.X_LG = isometry(object.X_WO).inverse() * part.X_WG;  // in the object's frame
        part.motion = object.motion->poses;
      }
    }
  }

  std::size_t triangles() const {
    std::size_t count = 0;
    for (const DeformingObstacle& o : problem_.world.deforming) count += o.mesh->triangles().size();
    return count;
  }

  /// First contact of the robot, as text; empty if it is free.
  std::string contact(const std::vector<double>& positions, double time) {
    place(positions);
    for (Part& part : still_)
      if (part.motion) part.X_WG = isometry(part.motion->pose(time)) * part.X_LG;
    for (const Part& part : robot_)
      for (const Part& other : still_)
        if (!allowed(part.owner, other.owner) && meets(part, other.geometry, other.X_WG))
          return part.owner + " and " + other.owner;
    for (const DeformingObstacle& o : problem_.world.deforming) {
      const std::vector<Eigen::Vector3d> vertices = verticesOf(o, time);
      const FclGeometry mesh = leeway::lab::fclMesh(vertices, o.mesh->triangles());
      for (const Part& part : robot_)
        if (!allowed(part.owner, o.object.name) && meets(part, mesh, Isometry3d::Identity()))
          return part.owner + " and " + o.object.name;
    }
    return {};
  }

  /// Minimum distance from obstacles that move, if below `enough`: all pairs of a triangle or shape
  /// and a robot shape, at the poses of the last contact().
  double distance(double time, double enough) {
    const auto poseOf = [](const Part& part) {
      return leeway::collision::Pose{part.X_WG.linear(), part.X_WG.translation()};
    };
    for (const Part& other : still_)
      for (const Part& part : robot_)
        if (other.motion && !allowed(part.owner, other.owner))
          enough =
              std::min(enough, leeway::collision::distance(part.shape, poseOf(part), other.shape,
                                                           poseOf(other), {}, scratch_)
                                   .distance.upper);
    for (const DeformingObstacle& o : problem_.world.deforming) {
      const std::vector<Eigen::Vector3d> vertices = verticesOf(o, time);
      for (const Part& part : robot_) {
        if (allowed(part.owner, o.object.name)) continue;
        const leeway::collision::Pose X_WG{part.X_WG.linear(), part.X_WG.translation()};
        const Eigen::Vector3d center = X_WG * part.shape.boundingCenter();
        for (const auto& t : o.mesh->triangles()) {
          const std::array<Eigen::Vector3d, 3> corners = {vertices[at(t[0])], vertices[at(t[1])],
                                                          vertices[at(t[2])]};
          const double reach =
              std::max((corners[1] - corners[0]).norm(), (corners[2] - corners[0]).norm());
          if ((corners[0] - center).norm() - part.shape.boundingRadius() - reach >= enough)
            continue;
          leeway::collision::DistanceRequest request;
          request.depth = false;
          enough = std::min(
              enough, leeway::collision::distance(part.shape, X_WG, Shape::convexHull(corners), {},
                                                  request, scratch_)
                          .distance.upper);
        }
      }
    }
    return enough;
  }

 private:
  static void add(std::vector<Part>& parts, const std::string& owner, int link,
                  const robots::Geometry& g, const Isometry3d& X) {
    parts.push_back({owner, link, g.shape, X * isometry(g.X_BG), leeway::lab::toFcl(g.shape),
                     Isometry3d::Identity()});
  }

  bool allowed(const std::string& a, const std::string& b) const {
    return std::any_of(
        problem_.contacts.allowed.begin(), problem_.contacts.allowed.end(), [&](const auto& pair) {
          return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
        });
  }

  bool moves(int link) const {
    for (; link >= 0; link = model_.joints[at(link)].parent_link) {
      const robots::Joint* joint = &model_.joints[at(link)];
      while (joint->mimic >= 0) joint = &model_.joints[at(joint->mimic)];
      for (const int v : problem_.robot.variables)
        if (model_.variables[at(v)].joint >= 0 &&
            &model_.joints[at(model_.variables[at(v)].joint)] == joint)
          return true;
    }
    return false;
  }

  static bool meets(const Part& part, const FclGeometry& other, const Isometry3d& X) {
    const fcl::CollisionRequestd request(1, false);
    fcl::CollisionResultd result;
    return fcl::collide(part.geometry.get(), part.X_WG, other.get(), X, request, result) > 0;
  }

  std::vector<Eigen::Vector3d> verticesOf(const DeformingObstacle& o, double time) const {
    std::vector<Eigen::Vector3d> vertices(at(o.mesh->vertexCount()));
    if (o.motion)
      o.motion->evaluate(time, vertices);
    else
      vertices.assign(o.mesh->rest().begin(), o.mesh->rest().end());
    const Isometry3d X = isometry(o.object.X_WO);
    for (Eigen::Vector3d& v : vertices) v = X * v;
    return vertices;
  }

  void place(const std::vector<double>& positions) {
    std::vector<double> q = problem_.start;
    for (std::size_t i = 0; i < positions.size(); ++i)
      q[at(problem_.robot.variables[i])] = positions[i];
    for (std::size_t l = 0; l < model_.links.size(); ++l) {
      const robots::Joint& joint = model_.joints[l];
      double value = 0, factor = 1, offset = 0;
      const robots::Joint* master = &joint;
      for (; master->mimic >= 0; master = &model_.joints[at(master->mimic)]) {
        offset += factor * master->offset;
        factor *= master->multiplier;
      }
      if (master->variable_count == 1) value = factor * q[at(master->first_variable)] + offset;
      Isometry3d X = joint.parent_link < 0 ? Isometry3d::Identity() : X_WL_[at(joint.parent_link)];
      X = X * isometry(joint.X_PJ);
      X_WL_[l] = X * leeway::dense::jointMotion(joint, value);
    }
    for (Part& part : robot_) part.X_WG = X_WL_[at(part.link)] * part.X_LG;
  }

  const Problem& problem_;
  const robots::Model& model_;
  std::vector<Isometry3d> X_WL_;
  std::vector<Part> robot_, still_;
  leeway::collision::Scratch scratch_;
};

/// How much rows exceed the limits of the problem, as a share, by differences of what a controller
/// executes: straight lines at constant speed from row to row. The greatest of all joints.
struct Excess {
  double velocity = -1, acceleration = -1, jerk = -1;
};

Excess excessOf(const Problem& problem, const leeway::dense::Trajectory& rows) {
  const leeway::planner::MotionLimits limits = leeway::planner::motionLimits(problem);
  Excess most;
  const std::size_t joints = limits.velocity.size();
  std::vector<double> velocity(joints), acceleration(joints);
  double period = rows[1].time - rows[0].time;
  const auto take = [&](double& excess, double value, double limit) {
    excess = std::max(excess, std::abs(value) / limit - 1);
  };
  // The robot rests after the last row, as before the first one.
  for (std::size_t k = 1; k < rows.size() + 2; ++k) {
    const auto &a = rows[std::min(k - 1, rows.size() - 1)], &b = rows[std::min(k, rows.size() - 1)];
    const double takes = k < rows.size() ? b.time - a.time : period;
    period = std::min(period, takes);
    for (std::size_t i = 0; i < joints; ++i) {
      const double v = (b.positions[i] - a.positions[i]) / takes;
      const double dv = (v - velocity[i]) / period;
      take(most.velocity, v, limits.velocity[i]);
      take(most.acceleration, dv, limits.acceleration[i]);
      take(most.jerk, (dv - acceleration[i]) / period, limits.jerk[i]);
      velocity[i] = v;
      acceleration[i] = dv;
    }
    period = takes;
  }
  return most;
}

struct Options {
  std::string problem, trajectory;
  double step = 0.001, distance_step = 0.01;
};

int run(const Options& options) {
  const Problem problem = leeway::planner::loadProblem(options.problem);
  const leeway::dense::Trajectory rows =
      leeway::dense::readTrajectory(options.trajectory, problem.robot.variables.size());
  World world(problem);
  const double begin = rows.front().time, end = rows.back().time;
  const auto samples = static_cast<long>(std::ceil((end - begin) / options.step));
  const long every = std::max(1L, std::lround(options.distance_step / options.step));
  long contacts = 0;
  double least = std::numeric_limits<double>::infinity(), where = begin;
  std::size_t row = 1;
  std::vector<double> positions(problem.robot.variables.size());
  for (long k = 0; k <= samples; ++k) {
    const double time = std::min(end, begin + static_cast<double>(k) * options.step);
    while (row + 1 < rows.size() && rows[row].time < time) ++row;
    const auto &a = rows[row - 1], &b = rows[row];
    const double t = b.time > a.time ? (time - a.time) / (b.time - a.time) : 1;
    for (std::size_t i = 0; i < positions.size(); ++i)
      positions[i] = a.positions[i] + t * (b.positions[i] - a.positions[i]);
    if (const std::string contact = world.contact(positions, time); !contact.empty()) {
      if (contacts++ == 0) fmt::print("contact at {:.4f} s: {}\n", time, contact);
    }
    if (k % every == 0)
      if (const double d = world.distance(time, least); d < least) {
        least = d;
        where = time;
      }
  }
  fmt::print(
      "{}: {:.3f} s, {} samples, {} triangles that move: {} in contact; least distance {:.3f} mm "
      "at {:.2f} s\n",
      problem.name, end - begin, samples + 1, world.triangles(), contacts, least * 1e3, where);
  constexpr double kRounding = 1e-5;  // of numbers in files, and of setpoints
  const Excess excess = excessOf(problem, rows);
  const bool keeps =
      excess.velocity <= kRounding && excess.acceleration <= kRounding && excess.jerk <= kRounding;
  fmt::print("limits {}: velocity {:+.2e}, acceleration {:+.2e}, jerk {:+.2e} of the limit\n",
             keeps ? "kept" : "EXCEEDED", excess.velocity, excess.acceleration, excess.jerk);
  return contacts == 0 && keeps ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "An executed trajectory against dense sampling, with exact vertices at every instant.");
  Options options;
  app.add_option("problem", options.problem, "problem file")->required();
  app.add_option("trajectory", options.trajectory, "what `leeway replan --output` wrote")
      ->required();
  app.add_option("--step", options.step, "between samples for contact [s]")
      ->check(CLI::PositiveNumber);
  app.add_option("--distance-step", options.distance_step, "between samples for distance [s]")
      ->check(CLI::PositiveNumber);
  return leeway::bench::runProgram("replan_check", app, argc, argv, [&] { return run(options); });
}
