#include "tools/leeway/view/timeline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/kinematics.h"

namespace leeway::tools::view {
namespace {

using planner::CompiledScene;
using planner::EdgeCertifier;

constexpr int kMoments = 250;
/// Moments times pairs, so that a page of 10^5 objects takes seconds.
constexpr double kMomentPairs = 2e7;
/// Moments times pairs for which every body's own clearance is asked, and not the robot's alone.
constexpr double kBodyPairs = 4e6;
/// For the bound of one stretch, about 3 ms (EdgeRequest::work_limit).
constexpr std::int64_t kStretchWork = 3'000'000;
constexpr double kStretchTolerance = 1e-4;  // [m]
/// Vertices of all frames of an obstacle, so that a page stays small.
constexpr std::size_t kFrameVertices = 2'500'000;
constexpr std::size_t kFrames = 200;

int momentsFor(const CompiledScene& scene) {
  const double pairs = static_cast<double>(std::max<std::size_t>(scene.scene().pairs().size(), 1));
  return static_cast<int>(std::clamp(kMomentPairs / pairs, 20.0, static_cast<double>(kMoments)));
}

/// The clearance of each body by itself, which is more than a scene's clearance asks.
class BodyClearances {
 public:
  BodyClearances(std::shared_ptr<const CompiledScene> scene, std::size_t moments)
      : scene_(std::move(scene)),
        workspace_(scene_->scene()),
        all_(static_cast<double>(moments) * static_cast<double>(scene_->scene().pairs().size()) <=
             kBodyPairs),
        q_(scene_->model().variables.size()),
        X_WL_(scene_->model().links.size()) {}

  void rebind(std::shared_ptr<const CompiledScene> scene) {
    scene_ = std::move(scene);
    workspace_.prepare(scene_->scene());
  }

  std::vector<double> clearancesAt(const std::vector<double>& position) {
    place(position);
    const collision::Scene& scene = scene_->scene();
    std::vector<double> clearance(scene.bodies().size(), kInfinity);
    for (auto p = scene.pairs().begin(); p != scene.pairs().end(); ++p) {
      const collision::ScenePair pair = *p;
      double& a = clearance[at(pair.body_a)];
      double& b = clearance[at(pair.body_b)];
      const bool b_counts = all_ || scene.bodies()[at(pair.body_b)].moving;
      const double apart = bound(pair);
      if (apart > a && (!b_counts || apart > b)) continue;
      const double upper = pairDistance(scene, workspace_, static_cast<int>(p.number()),
                                        {.tolerance = kMomentTolerance})
                               .distance.upper;
      a = std::min(a, upper);
      if (b_counts) b = std::min(b, upper);
    }
    return clearance;
  }

 private:
  void place(const std::vector<double>& position) {
    scene_->expand(position, q_);
    robots::forwardKinematics(scene_->model(), q_, X_WL_);
    const auto bodies = scene_->scene().bodies();
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (bodies[b].moving)
        workspace_.setPose(static_cast<int>(b), X_WL_[at(scene_->bodyLink(static_cast<int>(b)))]);
    }
  }

  /// No less apart than this, but for rounding: it only decides what is asked [m].
  double bound(const collision::ScenePair& pair) const {
    const auto ball = [&](int body, int geometry) {
      const collision::Body& of = scene_->scene().bodies()[at(body)];
      const collision::Geometry& g = of.geometries[at(geometry)];
      const collision::Pose& X_WB = of.moving ? workspace_.pose(body) : of.X_WB;
      return std::pair(Eigen::Vector3d(X_WB * (g.X_BG * g.shape.boundingCenter())),
                       g.shape.boundingRadius());
    };
    const auto [a, radius_a] = ball(pair.body_a, pair.geometry_a);
    const auto [b, radius_b] = ball(pair.body_b, pair.geometry_b);
    return (a - b).norm() - radius_a - radius_b;
  }

  std::shared_ptr<const CompiledScene> scene_;
  collision::Workspace workspace_;
  bool all_;
  std::vector<double> q_;
  std::vector<collision::Pose> X_WL_;
};

void keepLeast(Timeline& timeline) {
  if (timeline.body_clearance.empty()) return;
  timeline.least_clearance.assign(timeline.body_clearance[0].size(), kInfinity);
  timeline.least_moment.assign(timeline.body_clearance[0].size(), -1);
  for (std::size_t m = 0; m < timeline.body_clearance.size(); ++m) {
    for (std::size_t b = 0; b < timeline.least_clearance.size(); ++b) {
      if (timeline.body_clearance[m][b] < timeline.least_clearance[b]) {
        timeline.least_clearance[b] = timeline.body_clearance[m][b];
        timeline.least_moment[b] = static_cast<int>(m);
      }
    }
  }
}

/// Clearances of the bodies of one scene as those of another that names them.
std::vector<double> inShown(std::vector<double> clearance, const CompiledScene& asked,
                            const CompiledScene& shown) {
  if (&asked == &shown) return clearance;
  std::vector<double> mapped(shown.scene().bodies().size(), kInfinity);
  for (std::size_t b = 0; b < clearance.size(); ++b)
    if (const int body = shown.scene().find(asked.scene().bodies()[b].name); body >= 0)
      mapped[at(body)] = clearance[b];
  return mapped;
}

double leastMargin(const CompiledScene& scene) { return scene.scene().pairs().leastMargin(); }

planner::Interval proven(EdgeCertifier& certifier, const Moment& from, const Moment& to,
                         double margin) {
  planner::Interval bound =
      certifier
          .edgeClearance(from.position, to.position,
                         {.tolerance = kStretchTolerance, .work_limit = kStretchWork})
          .clearance;
  if (bound.lower < margin &&
      certifier.certify(from.position, to.position).verdict == planner::Verdict::kFree)
    bound.lower = margin;
  return bound;
}

/// The deforming obstacles at any time, and the scene with them.
class Obstacles {
 public:
  Obstacles(const planner::Problem& problem, std::shared_ptr<const CompiledScene> scene)
      : scene_(std::move(scene)) {
    for (const planner::DeformingObstacle& o : problem.world.deforming) {
      if (!o.motion) continue;
      followed_.push_back({scene_->scene().find(o.object.name),
                           collision::Deformable(o.mesh, o.motion, o.options)});
    }
  }

  /// Null where nothing moves.
  std::shared_ptr<const CompiledScene> sceneAt(double time) {
    if (followed_.empty()) return nullptr;
    std::vector<CompiledScene::Replacement> shapes;
    for (Followed& f : followed_) {
      f.mesh.update(time);
      shapes.push_back({f.body, 0, collision::Shape::deformable(f.mesh.snapshot())});
    }
    return scene_->withShapes(shapes);
  }

  void addFrames(double time, std::vector<Frames>& frames) const {
    frames.resize(followed_.size());
    for (std::size_t i = 0; i < followed_.size(); ++i) {
      const auto vertices = followed_[i].mesh.snapshot()->vertices();
      frames[i].body = followed_[i].body;
      frames[i].times.push_back(time);
      frames[i].positions.emplace_back(vertices.begin(), vertices.end());
    }
  }

  std::size_t vertexCount() const {
    std::size_t count = 0;
    for (const Followed& f : followed_) count += f.mesh.snapshot()->vertices().size();
    return count;
  }

 private:
  struct Followed {
    int body;
    collision::Deformable mesh;
  };
  std::shared_ptr<const CompiledScene> scene_;
  std::vector<Followed> followed_;
};

/// Where the executed motion is at `time`, which lies within the step.
std::vector<double> positionAt(const planner::ConfigurationSpace& space,
                               const std::vector<planner::TimedPoint>& motion, double time) {
  std::size_t i = 0;
  while (i + 2 < motion.size() && motion[i + 1].time <= time) ++i;
  if (i + 1 >= motion.size()) return motion.back().position;
  const double span = motion[i + 1].time - motion[i].time;
  const double t = span > 0 ? std::clamp((time - motion[i].time) / span, 0.0, 1.0) : 0;
  std::vector<double> position(motion[i].position.size());
  space.interpolate(motion[i].position, motion[i + 1].position, t, position);
  return position;
}

}  // namespace

Pair pairOf(const planner::StateCheck& check, const CompiledScene& asked,
            const CompiledScene& shown) {
  if (check.pair < 0) return {};
  const collision::ScenePair& pair = asked.scene().pairs()[at(check.pair)];
  const auto body = [&](int b) {
    return &asked == &shown ? b : shown.scene().find(asked.scene().bodies()[at(b)].name);
  };
  return {body(pair.body_a), body(pair.body_b), pair.margin};
}

Timeline timelineOfPath(const planner::Problem& problem,
                        const std::shared_ptr<const CompiledScene>& scene,
                        const planner::Path& path, const std::vector<Stage>& stages) {
  // Without blends: a page shows the edges that the certificate is about.
  const planner::ConfigurationSpace& space = scene->space();
  const planner::Trajectory trajectory(std::make_shared<const planner::ConfigurationSpace>(space),
                                       path.positions, planner::motionLimits(problem));
  Timeline timeline;
  timeline.waypoint_times.assign(trajectory.times().begin(), trajectory.times().end());
  std::vector<double> times = timeline.waypoint_times;
  const int count = momentsFor(*scene);
  for (int i = 0; i <= count; ++i) times.push_back(trajectory.duration() * i / count);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());

  std::size_t waypoint = 0;
  auto time = times.begin();
  for (const Stage& stage : stages) {
    if (!stage.scene) continue;  // nothing moves
    EdgeCertifier certifier(stage.scene);
    BodyClearances bodies(stage.scene, times.size());
    const double margin = leastMargin(*stage.scene);
    const double end = timeline.waypoint_times[at(stage.last)];
    for (; time != times.end() && *time <= end; ++time) {
      Moment moment{*time, std::vector<double>(at(space.size())), {}, {}};
      trajectory.configuration(*time, moment.position);
      // A waypoint is where the path has it, to the bit.
      while (waypoint < timeline.waypoint_times.size() &&
             timeline.waypoint_times[waypoint] <= *time) {
        if (timeline.waypoint_times[waypoint] == *time) moment.position = path.positions[waypoint];
        ++waypoint;
      }
      moment.check = certifier.clearance(moment.position, kMomentTolerance);
      moment.closest = pairOf(moment.check, *stage.scene, *scene);
      moment.placed = placedObjects(problem, *scene, stage.problem, moment.position);
      timeline.body_clearance.push_back(
          inShown(bodies.clearancesAt(moment.position), *stage.scene, *scene));
      if (!timeline.moments.empty())
        timeline.stretches.push_back(proven(certifier, timeline.moments.back(), moment, margin));
      timeline.moments.push_back(std::move(moment));
    }
  }
  keepLeast(timeline);
  return timeline;
}

Timeline timelineOfSteps(const planner::Problem& problem,
                         const std::shared_ptr<const CompiledScene>& scene,
                         const std::vector<planner::ReplanStep>& steps) {
  Timeline timeline;
  if (steps.empty()) return timeline;
  const planner::ConfigurationSpace& space = scene->space();
  Obstacles obstacles(problem, scene);
  EdgeCertifier certifier(scene);
  BodyClearances bodies(scene, steps.size() + 1);
  const std::size_t most =
      std::min(kFrames, kFrameVertices / std::max<std::size_t>(obstacles.vertexCount(), 1) + 1);
  const std::size_t every = (steps.size() + most) / most;
  const auto add = [&](double time, std::vector<double> position, bool last) {
    if (auto now = obstacles.sceneAt(time)) {
      certifier.rebind(now);
      bodies.rebind(now);
      if (timeline.moments.size() % every == 0 || last) obstacles.addFrames(time, timeline.frames);
    }
    Moment moment{time, std::move(position), {}, {}};
    moment.check = certifier.clearance(moment.position, kMomentTolerance);
    moment.closest = pairOf(moment.check, *scene, *scene);
    timeline.body_clearance.push_back(bodies.clearancesAt(moment.position));
    timeline.moments.push_back(std::move(moment));
  };
  for (const planner::ReplanStep& step : steps) {
    add(step.time, positionAt(space, step.motion, step.time), false);
    timeline.stretches.push_back(step.certified ? step.clearance
                                                : planner::Interval{-kInfinity, kInfinity});
  }
  const planner::TimedPoint& end = steps.back().motion.back();
  if (end.time > timeline.moments.back().time)
    add(end.time, end.position, true);
  else
    timeline.stretches.pop_back();
  keepLeast(timeline);
  return timeline;
}

Timeline timelineOfState(const planner::Problem& problem,
                         const std::shared_ptr<const CompiledScene>& scene, const Stage& stage,
                         const std::vector<double>& position) {
  Timeline timeline;
  EdgeCertifier certifier(stage.scene);
  BodyClearances bodies(stage.scene, 1);
  Moment moment{0, position, certifier.clearance(position, kMomentTolerance), {}};
  moment.closest = pairOf(moment.check, *stage.scene, *scene);
  moment.placed = placedObjects(problem, *scene, stage.problem, position);
  timeline.moments.push_back(std::move(moment));
  timeline.body_clearance.push_back(inShown(bodies.clearancesAt(position), *stage.scene, *scene));
  keepLeast(timeline);
  return timeline;
}

}  // namespace leeway::tools::view
