// A monitor of an arm with many bodies and fifty moving obstacles. It compares the number of exact
// distance queries of an impact schedule with a check of every pair at every step, and verifies
// that the schedule misses nothing (that check is the reference, also between the steps).
//
//   bench_monitor [ROBOT.urdf ROBOT.srdf] [--obstacles N] [--still N] [--seconds S] [--step S]
//                 [--seed N]
//
// --still N: adds N fixed boxes, equally dense, most of them out of reach.

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/time_to_impact.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/link_motion.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/splitmix.h"

namespace {

using namespace leeway;

using Random = bench::SplitMix;

double cpuSeconds() { return 1e-9 * bench::cpuNanoseconds(); }

constexpr double kMargin = 0.01;  // [m]

/// A box or ball that drifts around a place and turns.
struct Obstacle {
  Eigen::Vector3d center, amplitude, axis;
  double frequency, spin, radius;

  collision::Pose pose(double t) const {
    return {Eigen::AngleAxisd(spin * t, axis).toRotationMatrix(),
            center + amplitude * std::sin(frequency * t)};
  }
  collision::PointMotion motion(double t) const {
    const double speed = amplitude.norm() * frequency, turn = spin * radius;
    const auto up = [](double x) { return x * (1 + 1e-12) + 1e-12; };
    return {up(speed * std::abs(std::cos(frequency * t)) + turn),
            up(speed * frequency + spin * turn), up(speed + turn)};
  }
};

struct World {
  std::shared_ptr<const robots::Model> model;
  collision::Scene scene;
  std::vector<int> links;                        // the arm's body b is this link
  std::vector<robots::RelativeMotion> relative;  // of those links
  std::vector<Obstacle> obstacles;               // bodies numbered after the links
  std::vector<double> velocity_limits, acceleration_limits, frequency, phase;

  std::vector<double> rates(double t) const {
    std::vector<double> v(frequency.size());
    for (std::size_t i = 0; i < v.size(); ++i)
      v[i] = 0.9 * velocity_limits[i] * std::cos(frequency[i] * t + phase[i]);
    return v;
  }
  std::vector<double> configuration(double t) const {
    std::vector<double> q(frequency.size());
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] = 0.9 * velocity_limits[i] / frequency[i] * std::sin(frequency[i] * t + phase[i]);
    return q;
  }
  void place(double t, std::vector<collision::Pose>& X_WL, collision::Workspace& workspace) const {
    robots::forwardKinematics(*model, configuration(t), X_WL);
    int body = 0;
    for (const int link : links) workspace.setPose(body++, X_WL[static_cast<std::size_t>(link)]);
    for (const Obstacle& o : obstacles) workspace.setPose(body++, o.pose(t));
  }
  void tell(double t, collision::ImpactSchedule& schedule) const {
    const std::vector<double> v = rates(t);
    int body = 0;
    for (const robots::RelativeMotion& m : relative)
      schedule.setMotion(
          body++, robots::pointMotion(*model, m, v, {velocity_limits, acceleration_limits}), t);
    for (const Obstacle& o : obstacles) schedule.setMotion(body++, o.motion(t), t);
  }
};

World makeWorld(std::shared_ptr<const robots::Model> model, int obstacles, int still,
                std::uint64_t seed) {
  World world;
  world.model = std::move(model);
  Random random(seed);
  collision::SceneBuilder builder;
  builder.setDefaultMargin(kMargin);
  double reach = 0;
  for (std::size_t l = 0; l < world.model->links.size(); ++l) {
    const robots::Link& link = world.model->links[l];
    if (link.geometries.empty()) continue;
    collision::Body body;
    body.name = link.name;
    body.geometries = link.geometries;
    body.moving = true;
    builder.add(body);
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0;
    for (const robots::Geometry& g : link.geometries)
      radius =
          std::max(radius, (g.X_BG * g.shape.boundingCenter()).norm() + g.shape.boundingRadius());
    world.links.push_back(static_cast<int>(l));
    world.relative.push_back(
        robots::relativeMotion(*world.model, static_cast<int>(l), -1, center, radius));
    reach = std::max(reach, world.relative.back().base_reach);
  }
  // Only pairs with obstacles: self-collision is the planner's task.
  for (std::size_t i = 0; i < world.links.size(); ++i)
    for (std::size_t j = i + 1; j < world.links.size(); ++j)
      builder.allow(static_cast<int>(i), static_cast<int>(j));
  const int first = static_cast<int>(world.links.size());
  for (int i = 0; i < obstacles; ++i) {
    const auto vector = [&](double size) {
      return Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size),
                             random.uniform(-size, size));
    };
    Obstacle o;
    do o.center = vector(0.7 * reach);
    while (o.center.norm() < 0.3 * reach);
    o.amplitude = vector(0.2 * reach);
    o.axis = (vector(1) + Eigen::Vector3d(0, 0, 1e-3)).normalized();
    o.frequency = random.uniform(0.2, 1.5);
    o.spin = random.uniform(0, 1);
    const Eigen::Vector3d half(random.uniform(0.02, 0.1), random.uniform(0.02, 0.1),
                               random.uniform(0.02, 0.1));
    const collision::Shape shape =
        i % 3 == 0 ? collision::Shape::sphere(half.x()) : collision::Shape::box(half);
    o.radius = shape.extent();
    collision::Body body;
    body.name = "obstacle " + std::to_string(i);
    body.moving = true;
    body.geometries.push_back({shape, {}, ""});
    builder.add(body);
    world.obstacles.push_back(o);
  }
  for (int i = 0; i < obstacles; ++i)
    for (int j = i + 1; j < obstacles; ++j) builder.allow(first + i, first + j);
  const double side = reach * std::cbrt(still / 64.0);
  for (int i = 0; i < still; ++i) {
    collision::Body body;
    body.name = "still " + std::to_string(i);
    do
      for (double& x : body.X_WB.translation) x = random.uniform(-side, side);
    while (body.X_WB.translation.norm() < 0.6 * reach);
    body.geometries.push_back({collision::Shape::box({0.05, 0.05, 0.05}), {}, ""});
    for (int j = 0; j < obstacles; ++j) builder.allow(first + j, first + obstacles + i);
    builder.add(body);
  }
  world.scene = builder.build();
  for (const robots::Variable& v : world.model->variables) {
    world.velocity_limits.push_back(std::isfinite(v.velocity) ? v.velocity : 1);
    world.acceleration_limits.push_back(4);
    // A swing within the limits of position, velocity and acceleration.
    const double span = std::isfinite(v.lower) ? std::min(-v.lower, v.upper) : 3;
    const double slowest = 0.9 * world.velocity_limits.back() / std::max(span, 1e-3);
    world.frequency.push_back(std::max(slowest, random.uniform(0.2, 1)));
    if (0.9 * world.velocity_limits.back() * world.frequency.back() > 4)
      world.velocity_limits.back() = 4 / (0.9 * world.frequency.back());
    world.phase.push_back(random.uniform(-3, 3));
  }
  return world;
}

int run(const World& world, double seconds, double step) {
  const collision::ScenePairs& pairs = world.scene.pairs();
  collision::Workspace workspace(world.scene), truth(world.scene);
  const double begin_making = cpuSeconds();
  collision::ImpactSchedule schedule(world.scene);
  const double making_s = cpuSeconds() - begin_making;
  std::vector<collision::Pose> X_WL(world.model->links.size());
  std::vector<char> imminent(pairs.numbers());
  std::uint64_t below = 0, missed = 0, early = 0, steps = 0;
  double schedule_s = 0, every_s = 0;
  for (double t = 0; t < seconds; t = step * static_cast<double>(++steps)) {
    world.place(t, X_WL, workspace);
    double begin = cpuSeconds();
    world.tell(t, schedule);
    schedule.advance(t, step, workspace);
    schedule_s += cpuSeconds() - begin;
    std::fill(imminent.begin(), imminent.end(), 0);
    for (const std::int32_t p : schedule.imminent()) imminent[static_cast<std::size_t>(p)] = 1;
    for (int s = 0; s < 2; ++s) {
      const double now = t + step * s / 2;
      world.place(now, X_WL, truth);
      begin = cpuSeconds();
      for (auto pair = pairs.begin(); pair != pairs.end(); ++pair) {
        const int p = static_cast<int>(pair.number());
        collision::DistanceRequest request;
        request.threshold = kMargin;
        if (collision::pairDistance(world.scene, truth, p, request).distance.upper > kMargin)
          continue;
        ++below;
        missed += !imminent[pair.number()];
        early += now < schedule.due(p);
      }
      if (s == 0) every_s += cpuSeconds() - begin;
    }
  }
  const double all = static_cast<double>(steps) * static_cast<double>(pairs.size());
  const auto exact = static_cast<double>(schedule.statistics.exact);
  std::printf("%zu bodies of the robot, %zu moving obstacles, %zu pairs, %llu steps of %g s\n",
              world.links.size(), world.obstacles.size(), pairs.size(),
              static_cast<unsigned long long>(steps), step);
  std::printf("exact queries: %.0f of %.0f, %.1f times fewer; looks with coarse bounds: %llu\n",
              exact, all, all / std::max(1.0, exact),
              static_cast<unsigned long long>(schedule.statistics.looks));
  std::printf(
      "CPU time: %.2f ms to make it; a step %.1f us, against %.1f us for every pair's threshold\n",
      making_s * 1e3, schedule_s / static_cast<double>(steps) * 1e6,
      every_s / static_cast<double>(steps) * 1e6);
  std::printf(
      "pairs met at or below the margin: %llu; not announced: %llu; before they were due: %llu\n",
      static_cast<unsigned long long>(below), static_cast<unsigned long long>(missed),
      static_cast<unsigned long long>(early));
  return missed + early == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A monitor of an arm among moving obstacles.");
  std::string urdf = "robots/dual_arm/dual_arm.urdf", srdf = "robots/dual_arm/dual_arm.srdf";
  int obstacles = 50, still = 0;
  double seconds = 20, step = 0.01;
  std::uint64_t seed = 1;
  auto* robot = app.add_option("robot", urdf, "URDF");
  robot->needs(app.add_option("srdf", srdf, "its SRDF"));
  app.add_option("--obstacles", obstacles, "that move")->check(CLI::PositiveNumber);
  app.add_option("--still", still, "boxes at rest")->check(CLI::NonNegativeNumber);
  app.add_option("--seconds", seconds, "to monitor")->check(CLI::PositiveNumber);
  app.add_option("--step", step, "between looks [s]")->check(CLI::PositiveNumber);
  app.add_option("--seed", seed, "of the obstacles");
  return bench::runProgram("bench_monitor", app, argc, argv, [&] {
    return run(makeWorld(robots::loadModel(urdf, srdf), obstacles, still, seed), seconds, step);
  });
}
