#include "tools/view/ends.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "collision/base/numbers.h"
#include "leeway/collision/separation.h"
#include "leeway/planner/placed_at.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"

namespace leeway::tools::view {
namespace {

using planner::CompiledScene;

constexpr double kEndTolerance = 1e-6;  // [m]
constexpr double kOutTolerance = 1e-4;  // [m]
constexpr int kOutQueries = 5000;       // a few milliseconds

/// A valid number of a range: its middle, or the number nearest to 0 if a side is open.
double middle(double lower, double upper) {
  if (std::isfinite(lower) && std::isfinite(upper)) return 0.5 * (lower + upper);
  return std::clamp(0.0, lower, upper);
}

/// The frame in the middle of its region; X_WF.
collision::Pose middleOf(const robots::PoseRegion& region) {
  Eigen::Vector3d position, rpy;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    position[i] = middle(region.position[k].first, region.position[k].second);
    rpy[i] = middle(region.rpy[k].first, region.rpy[k].second);
  }
  return region.X_WR * collision::Pose{robots::rotationOf(rpy), position};
}

class WayOut {
 public:
  WayOut(const CompiledScene& scene, const std::vector<double>& position) : scene_(scene) {
    std::vector<double> q(scene.model().variables.size());
    X_WL_.resize(scene.model().links.size());
    scene.expand(position, q);
    robots::forwardKinematics(scene.model(), q, X_WL_);
  }

  /// The motion that frees this body from all bodies that it is checked against.
  Eigen::Vector3d of(int body) const {
    const collision::Scene& scene = scene_.scene();
    std::vector<collision::PlacedShape> shapes;
    for (const collision::Geometry& g : scene.bodies()[at(body)].geometries)
      shapes.push_back({&g.shape, poseOf(body) * g.X_BG});
    double extent = 0;
    for (const collision::PlacedShape& s : shapes)
      extent = std::max(extent, s.shape->boundingRadius());
    collision::SeparationRequest request;
    request.tolerance = kOutTolerance;
    request.query_limit = kOutQueries;
    // The longest motion to try is twice the body's size.
    request.longest = 4 * extent;
    std::vector<char> met(scene.bodies().size(), 0);
    double margin = 0;
    for (const collision::ScenePair& pair : scene.pairs()) {
      if (pair.body_a != body && pair.body_b != body) continue;
      met[at(pair.body_a == body ? pair.body_b : pair.body_a)] = 1;
      margin = std::max(margin, pair.margin);
    }
    request.clearance = margin;
    std::vector<collision::PlacedShape> obstacles;
    std::deque<collision::Shape> near;  // those of `obstacles`
    for (std::size_t b = 0; b < met.size(); ++b) {
      if (met[b] == 0) continue;
      const collision::Body& other = scene.bodies()[b];
      const collision::Pose X_WB = poseOf(static_cast<int>(b));
      for (std::size_t number = 0; number < other.size(); ++number) {
        const collision::Geometry g = other.geometry(number);
        collision::PlacedShape placed{&g.shape, X_WB * g.X_BG};
        if (!isNear(shapes, placed, request.longest + margin)) continue;
        placed.shape = &near.emplace_back(g.shape);
        obstacles.push_back(placed);
      }
    }
    collision::Scratch scratch;
    const collision::SeparationResult result = separation(shapes, obstacles, request, scratch);
    return result.status == collision::SeparationStatus::kSeparated ? result.translation
                                                                    : Eigen::Vector3d::Zero();
  }

 private:
  const collision::Pose& poseOf(int body) const {
    const collision::Body& b = scene_.scene().bodies()[at(body)];
    return b.moving ? X_WL_[at(scene_.bodyLink(body))] : b.X_WB;
  }

  static bool isNear(const std::vector<collision::PlacedShape>& shapes,
                     const collision::PlacedShape& obstacle, double reach) {
    const Eigen::Vector3d center = obstacle.X_WS * obstacle.shape->boundingCenter();
    return std::any_of(shapes.begin(), shapes.end(), [&](const collision::PlacedShape& s) {
      const double apart = (s.X_WS * s.shape->boundingCenter() - center).norm();
      return !(apart > s.shape->boundingRadius() + obstacle.shape->boundingRadius() + reach);
    });
  }

  const CompiledScene& scene_;
  std::vector<collision::Pose> X_WL_;
};

}  // namespace

std::vector<End> endsOf(const planner::Problem& problem, const planner::Problem& first,
                        const std::shared_ptr<const CompiledScene>& scene,
                        const CompiledScene& shown) {
  std::vector<End> ends(1);
  ends[0].name = "start";
  ends[0].position = startPoint(problem);
  for (const planner::Goal& goal : problem.goals) {
    End end{goal.name, {}, {}};
    if (goal.poses.empty()) {
      for (const auto& [lower, upper] : goal.ranges) end.position.push_back(middle(lower, upper));
    } else {
      for (const robots::PoseRegion& region : goal.poses) end.frames.push_back(middleOf(region));
      planner::Problem at_goal;
      try {
        at_goal = planner::placedAt(problem, goal.poses, "goal '" + goal.name + "'");
      } catch (const robots::InputError& error) {
        // The page names the problem; the file before the goal's name says nothing more.
        const std::string text = error.what();
        const std::size_t begin = text.find("goal '" + goal.name + "'");
        end.fault = begin == std::string::npos ? text : text.substr(begin);
        for (std::size_t i = 0; i < goal.poses.size(); ++i) {
          const robots::PoseRegion& region = goal.poses[i];
          const std::string& link = shown.model().links[at(region.link)].name;
          if (const int body = shown.scene().find(link); body >= 0)
            end.placed.emplace_back(body, end.frames[i] * region.X_LF.inverse());
        }
        ends.push_back(std::move(end));
        continue;
      }
      end.position = startPoint(at_goal);
    }
    ends.push_back(std::move(end));
  }
  planner::EdgeCertifier certifier(scene);
  for (End& end : ends) {
    if (end.unreachable()) continue;
    end.check = certifier.tooNear(end.position, kEndTolerance);
    end.closest = pairOf(end.check, *scene, shown);
    end.placed = placedObjects(problem, shown, first, end.position);
    if (end.check.verdict == planner::Verdict::kFree || end.check.pair < 0) continue;
    const collision::ScenePair& pair = scene->scene().pairs()[at(end.check.pair)];
    end.way_out = WayOut(*scene, end.position).of(pair.body_a);
  }
  return ends;
}

}  // namespace leeway::tools::view
