#include "planner/improve/improve_path.h"

namespace leeway::planner {

bool PathImprover::isOver() {
  if (!is_over_ && stop_ && asked_++ % turn_ == 0) is_over_ = stop_();
  return is_over_;
}

bool PathImprover::take(const Move& move) {
  if (!mayGain(move)) return false;
  for (std::size_t k = 0; k <= move.points.size(); ++k)
    if (!proves(move, k)) return false;
  if (!gains(move)) return false;
  keep(move);
  replace(path_, move.first + 1, move.last, move.points);
  return true;
}

bool PathImprover::proves(const Move& move, std::size_t edge) {
  return !isOver() &&
         certifier_.certify(pointOf(move, edge), pointOf(move, edge + 1)).verdict == Verdict::kFree;
}

const PathImprover::Point& PathImprover::pointOf(const Move& move, std::size_t k) const {
  if (k == 0) return path_[move.first];
  return k <= move.points.size() ? move.points[k - 1] : path_[move.last];
}

double PathImprover::lengthOf(const Move& move) const {
  double length = 0;
  for (std::size_t k = 0; k <= move.points.size(); ++k)
    length += space_.distance(pointOf(move, k), pointOf(move, k + 1));
  return length;
}

double PathImprover::lengthBetween(std::size_t first, std::size_t last) const {
  double length = 0;
  for (std::size_t i = first; i < last; ++i) length += space_.distance(path_[i], path_[i + 1]);
  return length;
}

PathImprover::Point PathImprover::between(std::size_t edge, double t) const {
  Point point(path_[0].size());
  space_.interpolate(path_[edge], path_[edge + 1], t, point);
  return point;
}

PathImprover::Point PathImprover::advanced(const Point& from, std::span<const double> direction,
                                           double scale) const {
  Point point(from.size());
  space_.advance(from, direction, scale, point);
  for (const ConfigurationSpace::Part& part : space_.parts()) {
    if (part.kind != ConfigurationSpace::Kind::kLine) continue;
    double& x = point[static_cast<std::size_t>(part.first)];
    x = std::clamp(x, space_.lower(part.first), space_.upper(part.first));
  }
  return space_.withinLimits(point) ? point : Point{};
}

std::shared_ptr<const CompiledScene> raised(const CompiledScene& scene, Pairs of, double margin) {
  return of == Pairs::kAll ? scene.withMarginAtLeast(margin) : scene.withWorldMarginAtLeast(margin);
}

}  // namespace leeway::planner
