#include "planner/task/line_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

std::vector<double> expanded(const CompiledScene& scene, std::span<const double> point) {
  std::vector<double> q(scene.model().variables.size());
  scene.expand(point, q);
  return q;
}

/// How far the frame is from the line, and turned from its rotation, as a chord on the unit sphere.
LineDeparture departureAt(const LinePlace& place, const robots::Pose& X_WF) {
  const double length = place.along_W.norm();
  const Eigen::Vector3d from = X_WF.translation - place.X_WF.translation;
  const double way =
      length > 0 ? std::clamp(from.dot(place.along_W) / length, 0.0, length) / length : 0;
  // |A - B| (Frobenius) of two rotations is sqrt(2) times the longest chord.
  return {(from - way * place.along_W).norm(),
          (X_WF.rotation - place.X_WF.rotation).norm() / std::sqrt(2.0)};
}

}  // namespace

LineDeparture lineDeparture(FrameMotion& frame, const LinePlace& place, std::span<const double> a,
                            std::span<const double> b) {
  frame.begin(a, b);
  const LineDeparture first = departureAt(place, frame.poseAt(0));
  const LineDeparture last = departureAt(place, frame.poseAt(1));
  const ChordDeparture chord = frame.departure(0, 1), rounding = frame.rounding();
  const double turn = std::max(first.turn, last.turn) + chord.tips + rounding.tips;
  return {std::max(first.deviation, last.deviation) + chord.origin + rounding.origin,
          turn < 2 ? 2 * std::asin(turn / 2) * (1 + kLineRounding) : 4};
}

LineMotion followLine(EdgeCertifier& certifier, const robots::InverseKinematics& kinematics,
                      const Problem& world, const LineStep& line,
                      const std::vector<double>& start) {
  const CompiledScene& scene = certifier.scene();
  const LinePlace place = linePlace(world, line, expanded(scene, start));
  FrameMotion frame(scene, place.link, place.X_LF);
  robots::IkOptions options;
  options.starts = 1;
  options.prove = false;
  LineMotion motion;
  motion.points = {start};
  const auto fail = [&](double way, const std::string& why) {
    motion.points.clear();
    motion.fault = fmt::format("{} after {:.4f} of {:.4f} m", why, way * place.along_W.norm(),
                               place.along_W.norm());
    return motion;
  };
  double way = 0, piece = kFirstLinePiece;
  while (way < 1) {
    const double next = way + piece >= 1 ? 1 : way + piece;
    robots::Pose X_WF = place.X_WF;
    X_WF.translation += next * place.along_W;
    const robots::PoseRegion region =
        robots::PoseRegion::exact(place.link, place.X_LF, X_WF, robots::Pose());
    const std::vector<double> from = motion.points.back();
    const robots::IkResult solved = kinematics.solve({&region, 1}, expanded(scene, from), options);
    std::string why = "no joint values were found for it";
    if (!solved.solutions.empty() && scene.space().withinLimits(solved.solutions[0].values)) {
      const std::vector<double>& to = solved.solutions[0].values;
      const LineDeparture departure = lineDeparture(frame, place, from, to);
      why = "the joints would have to jump";
      if (departure.deviation <= line.position_tolerance &&
          departure.turn <= line.angle_tolerance) {
        const EdgeCheck check = certifier.certify(from, to, EdgeRequest::persistent());
        if (check.verdict == Verdict::kFree) {
          motion.points.push_back(to);
          motion.departure.deviation = std::max(motion.departure.deviation, departure.deviation);
          motion.departure.turn = std::max(motion.departure.turn, departure.turn);
          way = next;
          piece *= 2;
          continue;
        }
        why = "it is in collision";
        if (check.pair >= 0) {
          const collision::ScenePair& pair = scene.scene().pairs()[at(check.pair)];
          why = fmt::format("{} and {} do not keep their margin",
                            scene.scene().bodies()[at(pair.body_a)].name,
                            scene.scene().bodies()[at(pair.body_b)].name);
        }
        // A shorter piece meets the same; only one that is undecided may do better.
        if (check.verdict == Verdict::kNotFree) return fail(way, why);
      }
    }
    piece /= 2;
    if (piece < kShortestLinePiece) return fail(way, why);
  }
  return motion;
}

}  // namespace leeway::planner
