#include "planner/task/line_motion.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using robots::Pose;

std::vector<double> expanded(const CompiledScene& scene, std::span<const double> point) {
  std::vector<double> q(scene.model().variables.size());
  scene.expand(point, q);
  return q;
}

LineWay wayFrom(const CompiledScene& scene, const Problem& world, const LineStep& line,
                std::span<const double> point) {
  std::vector<Pose> X_WL(scene.model().links.size());
  robots::forwardKinematics(scene.model(), expanded(scene, point), X_WL);
  return lineWay(world, line, X_WL);
}

/// The error of a frame at X_WF that should be at X_WP. Its turn is the longest chord between ends
/// of unit vectors.
LineDeparture errorAt(const Pose& X_WP, const Pose& X_WF) {
  // |A - B| (Frobenius) of two rotations is sqrt(2) times the longest chord.
  return {(X_WF.translation - X_WP.translation).norm(),
          (X_WF.rotation - X_WP.rotation).norm() / std::sqrt(2.0)};
}

/// A try that gains more than this share of a stretch lets the tries begin again.
constexpr double kLineGain = 0.01;

/// The motion of each joint along a stretch in addition to the motion that follows the line [rad or
/// m].
using Drift = std::vector<double>;

/// One call of followLine().
class LineSearch {
 public:
  LineSearch(EdgeCertifier& certifier, const robots::InverseKinematics& kinematics,
             const Problem& world, const LineStep& line, const std::vector<double>& start)
      : certifier_(certifier),
        scene_(certifier.scene()),
        kinematics_(kinematics),
        line_(line),
        way_(wayFrom(scene_, world, line, start)),
        frame_(scene_, way_.link, way_.X_LF) {
    options_.starts = 1;
    // A false find: NOLINTNEXTLINE(clang-analyzer-optin.cplusplus.UninitializedObject)
    options_.prove = false;
  }

  LineMotion run(const std::vector<double>& start, const LineTries& tries) {
    stop_ = tries.stop;
    Run best{{start}, {0}, {{}}, {}};
    extend(best, {});
    const std::vector<int> joints =
        best.end && tries.free > 0 ? freeJoints(start) : std::vector<int>();
    Random random(tries.seed, kLineStream);
    for (int failed = 0; best.end && !joints.empty() && failed < tries.free; ++failed) {
      if (isStopped()) break;
      Run run = best;
      // Prefers late places, because the run keeps its points up to there.
      const double back = random.uniform();
      const auto kept = static_cast<std::size_t>(
          std::ceil((1 - back * back) * static_cast<double>(run.points.size())));
      run.points.resize(kept);
      run.places.resize(kept);
      run.departures.resize(kept);
      extend(run, drift(joints, random, failed == 0 ? &run.points.back() : nullptr));
      const double gain = run.places.back() - best.places.back();
      if (!(gain > 0)) continue;
      best = std::move(run);
      // Near the end of the reach there is always a little more to gain.
      if (gain > kLineGain) failed = -1;
    }
    LineMotion motion;
    motion.points = std::move(best.points);
    motion.places = std::move(best.places);
    motion.end = std::move(best.end);
    for (const LineDeparture& of : best.departures) {
      motion.departure.deviation = std::max(motion.departure.deviation, of.deviation);
      motion.departure.turn = std::max(motion.departure.turn, of.turn);
    }
    return motion;
  }

 private:
  struct Run {
    std::vector<std::vector<double>> points;
    std::vector<double> places;
    std::vector<LineDeparture> departures;  ///< of the edge before each point
    std::optional<LineEnd> end;
  };

  bool isStopped() const { return stop_ && stop_(); }

  /// Extends the run from its last point as far as the line can be followed.
  void extend(Run& run, const Drift& drift) {
    run.end.reset();
    double piece = kFirstLinePiece;
    LineEnd why;
    while (run.places.back() < way_.size()) {
      if (isStopped()) {
        why = {};
        why.why = LineEnd::Why::kStopped;
        break;
      }
      const double place = run.places.back(), corner = std::floor(place) + 1;
      const double next = place + piece >= corner ? corner : place + piece;
      if (const std::optional<std::vector<double>> to =
              jointsAt(run.points.back(), next, drift, next - place)) {
        const std::vector<double>& from = run.points.back();
        const LineDeparture departure = lineDeparture(frame_, way_, place, next, from, *to);
        why = {};
        why.why = LineEnd::Why::kSingularity;
        if (departure.deviation <= kConstraintShare * line_.position_tolerance &&
            departure.turn <= kConstraintShare * line_.angle_tolerance) {
          const EdgeCheck check = certifier_.certify(from, *to, EdgeRequest::persistent());
          if (check.verdict == Verdict::kFree) {
            run.points.push_back(*to);
            run.places.push_back(next);
            run.departures.push_back(departure);
            piece = std::min(2 * piece, 1.0);
            continue;
          }
          why = collisionAt(check);
        }
      } else {
        why = {};
        why.why = LineEnd::Why::kSingularity;
      }
      piece /= 2;
      if (piece < kShortestLinePiece) break;
    }
    if (run.places.back() < way_.size()) run.end = named(std::move(why), run);
  }

  /// Joint values near `from` for a place of the way.
  std::optional<std::vector<double>> jointsAt(const std::vector<double>& from, double place,
                                              const Drift& drift, double step) {
    const robots::PoseRegion region =
        robots::PoseRegion::exact(way_.link, way_.X_LF, way_.at(place), Pose());
    const ConfigurationSpace& space = scene_.space();
    std::vector<double> seed = from;
    for (std::size_t i = 0; i < drift.size(); ++i)
      seed[i] = std::clamp(seed[i] + step * drift[i], space.lower(static_cast<int>(i)),
                           space.upper(static_cast<int>(i)));
    robots::IkResult solved = kinematics_.solve({&region, 1}, expanded(scene_, seed), options_);
    if (solved.solutions.empty() || !space.withinLimits(solved.solutions[0].values))
      return std::nullopt;
    return std::move(solved.solutions[0].values);
  }

  LineEnd collisionAt(const EdgeCheck& check) const {
    LineEnd end;
    end.why = LineEnd::Why::kCollision;
    end.text = check.verdict == Verdict::kNotFree ? "it is in collision"
                                                  : "its margins are not proven to be kept";
    if (check.pair < 0) return end;
    const collision::ScenePair& pair = scene_.scene().pairs()[at(check.pair)];
    end.text =
        fmt::format("{} and {} {}", scene_.scene().bodies()[at(pair.body_a)].name,
                    scene_.scene().bodies()[at(pair.body_b)].name,
                    check.verdict == Verdict::kNotFree ? "do not keep their margin"
                                                       : "are not proven to keep their margin");
    return end;
  }

  /// Fills in where a run ends, and the reason in words.
  LineEnd named(LineEnd end, const Run& run) {
    const double place = run.places.back(), stretch = std::floor(place);
    end.waypoint = static_cast<int>(stretch);
    end.share = place - stretch;
    if (end.why == LineEnd::Why::kStopped) {
      end.text = "the time limit was reached, or the search was stopped";
    } else if (end.why != LineEnd::Why::kCollision) {
      end.text = "the joints would have to jump, as near a singularity, or at the end of its reach";
      const ConfigurationSpace& space = scene_.space();
      const std::vector<double>& q = run.points.back();
      double nearest = kNearLimit;
      for (int i = 0; i < space.size(); ++i) {
        const int variable = space.variables()[at(i)];
        if (!robots::movesLink(scene_.model(), {&variable, 1}, way_.link)) continue;
        for (const double limit : {space.lower(i), space.upper(i)}) {
          if (!(std::abs(q[at(i)] - limit) < nearest)) continue;
          nearest = std::abs(q[at(i)] - limit);
          end.why = LineEnd::Why::kLimit;
          end.text = fmt::format("joint '{}' is at its limit of {:.6g}",
                                 scene_.model().variables[at(variable)].name, limit);
        }
      }
    }
    const WayStretch& part = way_.stretches[at(end.waypoint)];
    const std::string where =
        way_.stretches.size() == 1 && line_.poses.empty()
            ? std::string("the line")
            : fmt::format("the way to pose {} of {}", end.waypoint + 1, way_.stretches.size());
    end.text = fmt::format("it ends after {:.4f} of {} ({:.4f} of {:.4f} m): {}", end.share, where,
                           end.share * part.length(), part.length(), end.text);
    return end;
  }

  /// The planned variables that move the frame, if there are more of them than the frame needs at
  /// `point`; else empty.
  std::vector<int> freeJoints(const std::vector<double>& point) {
    const ConfigurationSpace& space = scene_.space();
    for (const ConfigurationSpace::Part& part : space.parts())
      if (part.kind == ConfigurationSpace::Kind::kRotation) return {};
    std::vector<int> joints;
    Eigen::MatrixXd J(6, space.size());
    std::vector<double> q = point;
    for (int i = 0; i < space.size(); ++i) {
      q[at(i)] = point[at(i)] + kDifferenceStep;
      const Pose next = frame_.poseAt(std::span<const double>(q));
      q[at(i)] = point[at(i)] - kDifferenceStep;
      const Pose last = frame_.poseAt(std::span<const double>(q));
      q[at(i)] = point[at(i)];
      const Eigen::Matrix3d turn = next.rotation * last.rotation.transpose();
      J.col(i) << (next.translation - last.translation),
          0.5 * Eigen::Vector3d(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0),
                                turn(1, 0) - turn(0, 1));
      J.col(i) /= 2 * kDifferenceStep;
      if (J.col(i).norm() > kLeastEffect) joints.push_back(i);
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
    qr.setThreshold(kLeastEffect);
    if (static_cast<Eigen::Index>(joints.size()) <= qr.rank()) joints.clear();
    return joints;
  }

  /// A drift of these joints: from `from` towards the middle of their limits, or random if it is
  /// null.
  Drift drift(const std::vector<int>& joints, Random& random,
              const std::vector<double>* from) const {
    const ConfigurationSpace& space = scene_.space();
    Drift drift(at(space.size()), 0.0);
    const double most = kMostDrift * random.uniform();
    for (const int i : joints) {
      if (from == nullptr)
        drift[at(i)] = most * (2 * random.uniform() - 1);
      else if (std::isfinite(space.lower(i)) && std::isfinite(space.upper(i)))
        drift[at(i)] = space.lower(i) / 2 + space.upper(i) / 2 - (*from)[at(i)];
    }
    return drift;
  }

  EdgeCertifier& certifier_;
  const CompiledScene& scene_;
  const robots::InverseKinematics& kinematics_;
  const LineStep& line_;
  LineWay way_;
  FrameMotion frame_;
  robots::IkOptions options_;
  std::function<bool()> stop_;
};

}  // namespace

const char* toString(LineEnd::Why why) {
  switch (why) {
    case LineEnd::Why::kLimit:
      return "limit";
    case LineEnd::Why::kSingularity:
      return "singularity";
    case LineEnd::Why::kCollision:
      return "collision";
    case LineEnd::Why::kStopped:
      return "stopped";
  }
  return "limit";
}

LineDeparture lineDeparture(FrameMotion& frame, const LineWay& way, double place, double next,
                            std::span<const double> a, std::span<const double> b) {
  frame.begin(a, b);
  const double begin = std::min(std::floor(place), way.size() - 1);
  const WayStretch& stretch = way.stretches[static_cast<std::size_t>(begin)];
  const LineDeparture first = errorAt(stretch.at(place - begin), frame.poseAt(0));
  const LineDeparture last = errorAt(stretch.at(next - begin), frame.poseAt(1));
  const ChordDeparture chord = frame.departure(0, 1), rounding = frame.rounding();
  const ChordDeparture of_way = stretch.departure(next - place);
  const double turn = std::max(first.turn, last.turn) + chord.tips + of_way.tips + rounding.tips;
  return {
      std::max(first.deviation, last.deviation) + chord.origin + of_way.origin + rounding.origin,
      turn < 2 ? 2 * std::asin(turn / 2) * (1 + kLineRounding) : 4};
}

LineMotion followLine(EdgeCertifier& certifier, const robots::InverseKinematics& kinematics,
                      const Problem& world, const LineStep& line, const std::vector<double>& start,
                      const LineTries& tries) {
  return LineSearch(certifier, kinematics, world, line, start).run(start, tries);
}

}  // namespace leeway::planner
