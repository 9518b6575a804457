#include "tools/view/timeline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/kinematics.h"
#include "tools/view/base/pairs_too_near.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools::view {
namespace {

using planner::CompiledScene;
using planner::EdgeCertifier;

constexpr int kMoments = 250;
/// Limit on moments times pairs, so that a page of 10^5 objects takes seconds.
constexpr double kMomentPairs = 2e7;
/// Limit on moments times pairs for the clearance of every body; above it, only of moving bodies.
constexpr double kBodyPairs = 4e6;
/// Work limit for the bound of one stretch, about 3 ms (EdgeRequest::work_limit).
constexpr std::int64_t kStretchWork = 3'000'000;
constexpr double kStretchTolerance = 1e-4;  // [m]
/// How far obstacles are searched, first and last, before all are [m].
constexpr double kFirstReach = 0.1, kLastReach = 1e3;
/// Limit on the vertices of all frames of an obstacle, so that a page stays small.
constexpr std::size_t kFrameVertices = 2'500'000;
constexpr std::size_t kFrames = 200;

int momentsFor(const CompiledScene& scene) {
  const double pairs = static_cast<double>(std::max<std::size_t>(scene.scene().pairs().size(), 1));
  return static_cast<int>(std::clamp(kMomentPairs / pairs, 20.0, static_cast<double>(kMoments)));
}

/// The clearance of each body separately, which a scene's clearance does not contain.
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
    const auto look = [&](std::size_t number) {
      const collision::ScenePair pair = scene.pairs()[number];
      double& a = clearance[at(pair.body_a)];
      double& b = clearance[at(pair.body_b)];
      const bool b_counts = all_ || scene.bodies()[at(pair.body_b)].moving;
      const double apart = bound(pair);
      if (apart > a && (!b_counts || apart > b)) return;
      const double upper =
          pairDistance(scene, workspace_, static_cast<int>(number), {.tolerance = kMomentTolerance})
              .distance.upper;
      a = std::min(a, upper);
      if (b_counts) b = std::min(b, upper);
    };
    if (all_) {
      for (auto p = scene.pairs().begin(); p != scene.pairs().end(); ++p) look(p.number());
      return clearance;
    }
    for (std::size_t p = 0; p < scene.pairs().listedCount(); ++p) look(p);
    for (std::size_t row = 0; row < scene.pairs().rows().size(); ++row)
      visitNear(row, clearance[at(scene.pairs().rows()[row].body)], look);
    return clearance;
  }

  /// Adds the distance of two bodies of `shown` at a position. O(listed pairs + those that are
  /// near).
  void measure(const std::vector<double>& position, const CompiledScene& shown, PairCurve& curve) {
    const auto body = [&](int b) {
      return &shown == scene_.get() ? b : scene_->scene().find(shown.scene().bodies()[at(b)].name);
    };
    const int a = body(curve.pair.a), b = body(curve.pair.b);
    place(position);
    collision::DistanceResult nearest;
    nearest.distance = {kNaN, kNaN};
    const collision::Scene& scene = scene_->scene();
    const auto look = [&](std::size_t number) {
      const collision::ScenePair pair = scene.pairs()[number];
      if (std::minmax(pair.body_a, pair.body_b) != std::minmax(a, b)) return;
      curve.pair.margin = pair.margin;
      if (bound(pair) > nearest.distance.upper) return;
      collision::DistanceResult found = pairDistance(scene, workspace_, static_cast<int>(number),
                                                     {.tolerance = kMomentTolerance});
      if (found.distance.upper >= nearest.distance.upper) return;
      if (pair.body_a != a) std::swap(found.point_a, found.point_b);
      nearest = found;
    };
    for (std::size_t p = 0; p < scene.pairs().listedCount(); ++p) look(p);
    for (std::size_t row = 0; row < scene.pairs().rows().size(); ++row)
      if (const int moving = scene.pairs().rows()[row].body; moving == a || moving == b)
        visitNear(row, nearest.distance.upper, look);
    curve.distance.push_back(nearest.distance.upper);
    curve.point_a.push_back(nearest.point_a);
    curve.point_b.push_back(nearest.point_b);
  }

 private:
  /// Calls look(number) for the pairs of a row of the table that may be nearer than `least` [m],
  /// which look() lowers. Searches ever farther, because a cloud has millions of balls.
  template <class Look>
  void visitNear(std::size_t row, const double& least, const Look& look) {
    for (double reach = kFirstReach;; reach = reach < kLastReach ? 4 * reach : kInfinity) {
      collision::forEachNearInRow(scene_->scene(), workspace_, row, reach, [&](int number) {
        look(at(number));
        return true;
      });
      if (least <= reach || std::isinf(reach)) return;
    }
  }

  void place(const std::vector<double>& position) {
    scene_->expand(position, q_);
    robots::forwardKinematics(scene_->model(), q_, X_WL_);
    const auto bodies = scene_->scene().bodies();
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (bodies[b].moving)
        workspace_.setPose(static_cast<int>(b), X_WL_[at(scene_->bodyLink(static_cast<int>(b)))]);
    }
  }

  /// A lower bound on the distance, up to rounding. It only decides which pairs are measured [m].
  double bound(const collision::ScenePair& pair) const {
    const auto ball = [&](int body, int geometry) {
      const collision::Body& of = scene_->scene().bodies()[at(body)];
      const collision::Pose& X_WB = of.moving ? workspace_.pose(body) : of.X_WB;
      if (at(geometry) >= of.geometries.size()) {
        const collision::Ball& one = (*of.balls)[at(geometry) - of.geometries.size()];
        return std::pair(Eigen::Vector3d(X_WB * one.center), one.radius);
      }
      const collision::Geometry& g = of.geometries[at(geometry)];
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

/// Maps the clearances of the bodies of one scene to the bodies of the same names in another.
std::vector<double> inShown(std::vector<double> clearance, const CompiledScene& asked,
                            const CompiledScene& shown) {
  if (&asked == &shown) return clearance;
  std::vector<double> mapped(shown.scene().bodies().size(), kInfinity);
  for (std::size_t b = 0; b < clearance.size(); ++b)
    if (const int body = shown.scene().find(asked.scene().bodies()[b].name); body >= 0)
      mapped[at(body)] = clearance[b];
  return mapped;
}

/// Bounds on stretches of a path: for the world, for the robot itself, and for all pairs.
class Bounds {
 public:
  explicit Bounds(EdgeCertifier& certifier) : certifier_(certifier) {
    const collision::ScenePairs& pairs = certifier.scene().scene().pairs();
    const int robot = certifier.scene().bodiesOfRobot();
    world_margin_ = pairs.leastMargin(robot, true);
    self_margin_ = pairs.leastMargin(robot, false);
  }

  void add(const Moment& from, const Moment& to, Timeline& timeline) {
    planner::Interval world = bound(from, to, planner::Pairs::kWorld),
                      self = bound(from, to, planner::Pairs::kSelf);
    if ((world.lower < world_margin_ || self.lower < self_margin_) &&
        certifier_.certify(from.position, to.position).verdict == planner::Verdict::kFree) {
      world.lower = std::max(world.lower, world_margin_);
      self.lower = std::max(self.lower, self_margin_);
    }
    timeline.world_stretches.push_back(world);
    timeline.self_stretches.push_back(self);
    timeline.stretches.push_back(
        {std::min(world.lower, self.lower), std::min(world.upper, self.upper)});
  }

 private:
  planner::Interval bound(const Moment& from, const Moment& to, planner::Pairs pairs) const {
    return certifier_
        .edgeClearance(from.position, to.position,
                       {.tolerance = kStretchTolerance, .work_limit = kStretchWork, .pairs = pairs})
        .clearance;
  }

  EdgeCertifier& certifier_;
  double world_margin_, self_margin_;
};

/// The obstacles whose motion is known, at any time, and the scene with them.
class Obstacles {
 public:
  Obstacles(const planner::Problem& problem, std::shared_ptr<const CompiledScene> scene)
      : scene_(std::move(scene)) {
    for (const planner::DeformingObstacle& o : problem.world.deforming) {
      if (!o.motion) continue;
      followed_.push_back({scene_->scene().find(o.object.name),
                           collision::Deformable(o.mesh, o.motion, o.options)});
    }
    for (const planner::Object& o : problem.world.objects)
      if (o.motion && o.motion->poses)
        rigid_.emplace_back(scene_->scene().find(o.name), o.motion->poses);
  }

  /// The scene at a time; null if nothing moves.
  std::shared_ptr<const CompiledScene> sceneAt(double time) {
    if (followed_.empty() && rigid_.empty()) return nullptr;
    std::vector<CompiledScene::Replacement> shapes;
    for (Followed& f : followed_) {
      f.mesh.update(time);
      shapes.push_back({f.body, 0, collision::Shape::deformable(f.mesh.snapshot())});
    }
    for (const auto& [body, X_WB] : placedAt(time)) shapes.push_back({body, 0, X_WB});
    return scene_->withShapes(shapes);
  }

  /// As Moment::placed.
  std::vector<std::pair<int, collision::Pose>> placedAt(double time) const {
    std::vector<std::pair<int, collision::Pose>> placed;
    for (const auto& [body, poses] : rigid_) placed.emplace_back(body, poses->pose(time));
    return placed;
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
  std::vector<std::pair<int, std::shared_ptr<const collision::PoseMotion>>> rigid_;
};

/// The position of the executed motion at `time`, which lies within the step.
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

namespace {

/// Measures a moment whose position is known.
void measure(EdgeCertifier& certifier, const CompiledScene& asked, const CompiledScene& shown,
             Moment& moment) {
  moment.check = certifier.clearance(moment.position, kMomentTolerance);
  moment.closest = pairOf(moment.check, asked, shown);
  const bool is_self =
      moment.check.pair >= 0 && asked.isOfRobot(asked.scene().pairs()[at(moment.check.pair)]);
  for (const planner::Pairs pairs : {planner::Pairs::kWorld, planner::Pairs::kSelf}) {
    Nearest& near = pairs == planner::Pairs::kWorld ? moment.world : moment.self;
    planner::StateCheck found;
    if (moment.check.pair >= 0 && is_self == (pairs == planner::Pairs::kSelf)) {
      found = moment.check;
    } else {
      const planner::EdgeClearance edge = certifier.edgeClearance(
          moment.position, moment.position, {.tolerance = kMomentTolerance, .pairs = pairs});
      found.clearance = edge.clearance;
      found.pair = edge.pair;
      found.closest = edge.closest;
    }
    near = {found.clearance, pairOf(found, asked, shown), found.closest.point_a,
            found.closest.point_b};
  }
}

/// A place of a path with its least clearance.
struct LeastPlace {
  double time = 0;
  std::vector<double> position;
  const planner::PathClearance* least = nullptr;
  bool is_self = false;
};

std::vector<LeastPlace> leastPlaces(const planner::Trajectory& trajectory,
                                    const planner::ConfigurationSpace& space,
                                    const planner::PathEdges& edges, const LeastClearance& least) {
  std::vector<LeastPlace> places;
  for (const planner::PathClearance* of : {&least.world, &least.self}) {
    for (std::size_t k = 0; k < edges.places.size(); ++k) {
      const planner::PathEdges::Place& place = edges.places[k];
      if (place.segment != of->closest_segment || of->closest_t < place.t0 ||
          of->closest_t > place.t1)
        continue;
      const double t = (of->closest_t - place.t0) / (place.t1 - place.t0);
      std::vector<double> position(at(space.size()));
      space.interpolate(edges.path.positions[k], edges.path.positions[k + 1], t, position);
      if (const auto time = trajectory.passes(static_cast<int>(k), t))
        places.push_back({*time, std::move(position), of, of == &least.self});
      break;
    }
  }
  return places;
}

/// Gives the moment at such a place the pair and the interval of the path's least clearance, which
/// are also true there.
void keepPlaces(const std::vector<LeastPlace>& places, const CompiledScene& shown,
                Timeline& timeline) {
  for (std::size_t m = 0; m < timeline.moments.size(); ++m) {
    Moment& moment = timeline.moments[m];
    for (const LeastPlace& place : places) {
      if (place.time != moment.time) continue;
      Nearest& near = place.is_self ? moment.self : moment.world;
      const int a = shown.scene().find(place.least->closest_a),
                b = shown.scene().find(place.least->closest_b);
      if (near.pair.a < 0 || a < 0 || b < 0) continue;
      (place.is_self ? timeline.least_self : timeline.least_world) = static_cast<int>(m);
      const bool is_all = moment.closest.a == near.pair.a && moment.closest.b == near.pair.b;
      near = {place.least->clearance,
              {a, b, near.pair.margin},
              place.least->closest_point_a,
              place.least->closest_point_b};
      if (!is_all) continue;
      moment.check.clearance = near.clearance;
      moment.check.closest.point_a = near.point_a;
      moment.check.closest.point_b = near.point_b;
      moment.closest = near.pair;
    }
  }
}

/// Finds the least clearances among the moments.
void findLeast(Timeline& timeline) {
  double world = kInfinity, self = kInfinity;
  for (std::size_t m = 0; m < timeline.moments.size(); ++m) {
    const Moment& moment = timeline.moments[m];
    if (moment.world.clearance.upper < world) {
      world = moment.world.clearance.upper;
      timeline.least_world = static_cast<int>(m);
    }
    if (moment.self.clearance.upper < self) {
      self = moment.self.clearance.upper;
      timeline.least_self = static_cast<int>(m);
    }
  }
}

/// Raises the bounds of stretches to those of the whole path, which are narrower in places.
void raiseBounds(const LeastClearance& least, Timeline& timeline) {
  for (std::size_t m = 0; m < timeline.stretches.size(); ++m) {
    double& world = timeline.world_stretches[m].lower;
    double& self = timeline.self_stretches[m].lower;
    world = std::max(world, least.world.clearance.lower);
    self = std::max(self, least.self.clearance.lower);
    timeline.stretches[m].lower = std::min(world, self);
  }
}

/// Finds the pair that is farthest below its margin at any moment.
class Failing {
 public:
  /// `certified`: there is none, and moments need not be looked at.
  explicit Failing(bool certified) : certified_(certified) {}

  /// Looks at a moment, whose robot and obstacles are those of the certifier's scene.
  void look(EdgeCertifier& certifier, const CompiledScene& shown, const Moment& moment) {
    if (certified_) return;
    const planner::StateCheck check = certifier.tooNear(moment.position, kMomentTolerance);
    const Pair pair = pairOf(check, certifier.scene(), shown);
    const double beyond = check.clearance.upper - pair.margin;
    if (pair.a < 0 || pair.b < 0 || !(beyond <= 0 && beyond < beyond_)) return;
    beyond_ = beyond;
    pair_ = pair;
  }

  bool found() const { return pair_.a >= 0; }
  /// Adds the pair to the timeline's pairs, unless the nearest pair does not keep its margin
  /// either.
  void add(Timeline& timeline) const {
    const Nearest* nearest = nullptr;
    for (const Moment& moment : timeline.moments)
      for (const Nearest* near : {&moment.world, &moment.self})
        if (near->pair.a >= 0 &&
            (nearest == nullptr || near->clearance.upper < nearest->clearance.upper))
          nearest = near;
    if (pair_.a < 0 || nearest == nullptr || nearest->clearance.upper <= nearest->pair.margin)
      return;
    const auto is_it = [&](const PairCurve& curve) {
      return std::minmax(curve.pair.a, curve.pair.b) == std::minmax(pair_.a, pair_.b);
    };
    auto found = std::find_if(timeline.pairs.begin(), timeline.pairs.end(), is_it);
    if (found == timeline.pairs.end()) found = timeline.pairs.insert(found, {pair_, {}, {}, {}});
    timeline.failing = static_cast<int>(found - timeline.pairs.begin());
  }

 private:
  bool certified_;
  Pair pair_;
  double beyond_ = kInfinity;
};

/// Adds the pairs of bodies that come nearest, among those that are the nearest of a body at a
/// moment, without their distances.
void choosePairs(Timeline& timeline) {
  constexpr std::size_t kPairs = 12;
  std::map<std::pair<int, int>, double> least;
  for (const Moment& moment : timeline.moments)
    for (const Nearest* near : {&moment.world, &moment.self})
      if (near->pair.a >= 0) {
        double& known = least.try_emplace({near->pair.a, near->pair.b}, kInfinity).first->second;
        known = std::min(known, near->clearance.upper);
      }
  std::vector<std::pair<double, std::pair<int, int>>> order;
  for (const auto& [pair, distance] : least) order.emplace_back(distance, pair);
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), kPairs));
  for (const auto& [distance, pair] : order)
    timeline.pairs.push_back({{pair.first, pair.second}, {}, {}, {}});
}

/// Adds these pairs of a path.
void addPairs(const std::vector<Stage>& stages, const CompiledScene& shown, const Failing& failing,
              Timeline& timeline) {
  choosePairs(timeline);
  failing.add(timeline);
  std::size_t m = 0;
  for (const Stage& stage : stages) {
    if (!stage.scene) continue;
    BodyClearances bodies(stage.scene, 1);
    for (; m < timeline.moments.size() && timeline.moments[m].stage == &stage - stages.data(); ++m)
      for (PairCurve& curve : timeline.pairs)
        bodies.measure(timeline.moments[m].position, shown, curve);
  }
}

/// Adds the same pairs of an execution, with the obstacles where they were.
void addPairs(const planner::Problem& problem, const std::shared_ptr<const CompiledScene>& scene,
              const Failing& failing, Timeline& timeline) {
  choosePairs(timeline);
  failing.add(timeline);
  Obstacles obstacles(problem, scene);
  BodyClearances bodies(scene, 1);
  for (const Moment& moment : timeline.moments) {
    if (auto now = obstacles.sceneAt(moment.time)) bodies.rebind(now);
    for (PairCurve& curve : timeline.pairs) bodies.measure(moment.position, *scene, curve);
  }
}

}  // namespace

Timeline timelineOfPath(const planner::Problem& problem,
                        const std::shared_ptr<const CompiledScene>& scene,
                        const planner::PathEdges& edges, const std::vector<Stage>& stages,
                        const LeastClearance& least, bool certified,
                        const std::vector<std::pair<int, double>>& failures) {
  const planner::Path& path = edges.path;
  // Leaves out blends, because a page shows the edges that the certificate covers.
  const planner::ConfigurationSpace& space = scene->space();
  const planner::Trajectory trajectory(std::make_shared<const planner::ConfigurationSpace>(space),
                                       path.positions, planner::motionLimits(problem), {}, {},
                                       path.steps);
  Timeline timeline;
  timeline.waypoint_times.assign(trajectory.times().begin(), trajectory.times().end());
  const std::vector<LeastPlace> places = leastPlaces(trajectory, space, edges, least);
  std::vector<double> times = timeline.waypoint_times;
  for (const LeastPlace& place : places) times.push_back(place.time);
  for (const auto& [edge, t] : failures)
    if (const auto time_of = trajectory.passes(edge, t)) times.push_back(*time_of);
  const int count = momentsFor(*scene);
  for (int i = 0; i <= count; ++i) times.push_back(trajectory.duration() * i / count);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());

  Failing failing(certified);
  std::size_t waypoint = 0;
  auto time = times.begin();
  for (const Stage& stage : stages) {
    if (!stage.scene) continue;  // nothing moves
    EdgeCertifier certifier(stage.scene);
    BodyClearances bodies(stage.scene, times.size());
    Bounds bounds(certifier);
    const double end = timeline.waypoint_times[at(stage.last)];
    for (; time != times.end() && *time <= end; ++time) {
      Moment moment{*time, std::vector<double>(at(space.size())), {}, {}};
      trajectory.configuration(*time, moment.position);
      // A waypoint is exactly where the path has it.
      while (waypoint < timeline.waypoint_times.size() &&
             timeline.waypoint_times[waypoint] <= *time) {
        if (timeline.waypoint_times[waypoint] == *time) moment.position = path.positions[waypoint];
        ++waypoint;
      }
      for (const LeastPlace& place : places)
        if (place.time == *time) moment.position = place.position;
      moment.stage = static_cast<int>(&stage - stages.data());
      measure(certifier, *stage.scene, *scene, moment);
      failing.look(certifier, *scene, moment);
      moment.placed = placedObjects(problem, *scene, stage.problem, moment.position);
      timeline.body_clearance.push_back(
          inShown(bodies.clearancesAt(moment.position), *stage.scene, *scene));
      if (!timeline.moments.empty()) bounds.add(timeline.moments.back(), moment, timeline);
      timeline.moments.push_back(std::move(moment));
    }
  }
  keepLeast(timeline);
  findLeast(timeline);
  keepPlaces(places, *scene, timeline);
  raiseBounds(least, timeline);
  addPairs(stages, *scene, failing, timeline);
  return timeline;
}

Timeline timelineOfSteps(const planner::Problem& problem,
                         const std::shared_ptr<const CompiledScene>& scene,
                         const std::vector<planner::ReplanStep>& steps,
                         const ExecutedClearance& executed) {
  Timeline timeline;
  if (steps.empty()) return timeline;
  const planner::ConfigurationSpace& space = scene->space();
  Obstacles obstacles(problem, scene);
  EdgeCertifier certifier(scene);
  BodyClearances bodies(scene, steps.size() + 1);
  Failing failing(std::all_of(steps.begin(), steps.end(),
                              [](const planner::ReplanStep& step) { return step.certified; }));
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
    moment.placed = obstacles.placedAt(time);
    measure(certifier, *scene, *scene, moment);
    failing.look(certifier, *scene, moment);
    timeline.body_clearance.push_back(bodies.clearancesAt(moment.position));
    timeline.moments.push_back(std::move(moment));
  };
  std::vector<LeastPlace> places;
  if (executed.is_known)
    for (const bool is_self : {false, true}) {
      const ExecutedPlace& place = is_self ? executed.self : executed.world;
      if (!place.position.empty())
        places.push_back({place.time, place.position,
                          is_self ? &executed.least.self : &executed.least.world, is_self});
    }
  std::sort(places.begin(), places.end(),
            [](const LeastPlace& a, const LeastPlace& b) { return a.time < b.time; });
  for (const planner::ReplanStep& step : steps) {
    const planner::Interval bounds{
        step.certified ? std::max(step.clearance.lower, executed.least.all.clearance.lower)
                       : -kInfinity,
        step.certified ? step.clearance.upper : kInfinity};
    const double end = step.motion.back().time;
    add(step.time, positionAt(space, step.motion, step.time), false);
    timeline.stretches.push_back(bounds);
    for (const LeastPlace& place : places) {
      if (!(place.time > timeline.moments.back().time && place.time < end)) continue;
      add(place.time, place.position, false);
      timeline.stretches.push_back(bounds);
    }
  }
  const planner::TimedPoint& end = steps.back().motion.back();
  if (end.time > timeline.moments.back().time)
    add(end.time, end.position, true);
  else
    timeline.stretches.pop_back();
  keepLeast(timeline);
  findLeast(timeline);
  // Steps that are not certified may have come nearer.
  std::erase_if(places, [&](const LeastPlace& place) {
    const int least = place.is_self ? timeline.least_self : timeline.least_world;
    const Moment& moment = timeline.moments[at(std::max(least, 0))];
    return (place.is_self ? moment.self : moment.world).clearance.upper <
           place.least->clearance.upper - kMomentTolerance;
  });
  keepPlaces(places, *scene, timeline);
  addPairs(problem, scene, failing, timeline);
  return timeline;
}

Timeline timelineOfState(const planner::Problem& problem,
                         const std::shared_ptr<const CompiledScene>& scene, const Stage& stage,
                         const std::vector<double>& position) {
  Timeline timeline;
  EdgeCertifier certifier(stage.scene);
  BodyClearances bodies(stage.scene, 1);
  Moment moment{0, position, {}, {}};
  measure(certifier, *stage.scene, *scene, moment);
  moment.placed = placedObjects(problem, *scene, stage.problem, position);
  Failing failing(false);
  failing.look(certifier, *scene, moment);
  if (moment.check.pair >= 0 && failing.found()) {
    const auto body = [&](const std::string& name) { return scene->scene().find(name); };
    for (const PairNames& names :
         pairsTooNear(*stage.scene, position, pairNames(*stage.scene, moment.check.pair)))
      if (const Pair pair{body(names.a), body(names.b)}; pair.a >= 0 && pair.b >= 0)
        timeline.pairs.push_back({pair, {}, {}, {}});
  }
  timeline.moments.push_back(std::move(moment));
  failing.add(timeline);
  for (PairCurve& curve : timeline.pairs) bodies.measure(position, *scene, curve);
  timeline.body_clearance.push_back(inShown(bodies.clearancesAt(position), *stage.scene, *scene));
  keepLeast(timeline);
  findLeast(timeline);
  return timeline;
}

}  // namespace leeway::tools::view
