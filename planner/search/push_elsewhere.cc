#include "planner/search/push_elsewhere.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/simplify.h"
#include "planner/base/tolerances.h"
#include "planner/search/push.h"
#include "planner/search/search.h"

// A path near its ends keeps no more than these have, and in a narrow place no more than the place.
// Between them it may keep more: first as much as T1 between the places where it has that, then
// T2 > T1 in there; where that fails, on either side of the place that limits it.
// clang-format off
//
//   clearance |        ___________           ____
//             |       /           \         /    \.
//          T2 |......x.............x.......x......x..
//          T1 |...x.................\_____/.........x
//             |__/                                   \.
//
// clang-format on

namespace leeway::planner {
namespace {

class Elsewhere {
 public:
  Elsewhere(const std::shared_ptr<const CompiledScene>& scene, EdgeCertifier& certifier,
            const PushElsewhereOptions& options)
      : scene_(scene), space_(scene->space()), certifier_(certifier), options_(options) {}

  void run(Waypoints& path) {
    spare_ = options_.longest - length(path);
    shortest_ = kElsewhereShort * length(path);
    path = raisedPart(path, options_.kept, 0);
  }

  EdgeCertifier::Statistics work;

 private:
  /// A point of a part, and what it keeps at most.
  struct Sample {
    std::size_t edge;
    double t, clearance;
  };

  double length(const Waypoints& path) const { return pathLength(space_, path); }
  bool isOver() const { return (options_.stop && options_.stop()) || pushes_ >= kMostElsewhere; }

  /// The part, whose edges keep `floor`, or one with the same ends that keeps more elsewhere.
  Waypoints raisedPart(Waypoints part, double floor, int divisions) {
    if (isOver() || divisions > kMostDivisions || part.size() < 2) return part;
    const std::vector<Sample> samples = sampled(part);
    double target = std::min(kElsewhereGrowth * floor, kElsewhereEnds * mostOf(samples));
    for (int k = 0; k < kElsewhereTries && isWorth(target, floor) && !isOver(); ++k) {
      if (auto raised = raisedBetween(part, samples, floor, target, divisions))
        return std::move(*raised);
      target = (floor + target) / 2;
    }
    const Sample* narrow = narrowest(samples);
    if (narrow == nullptr || isOver()) return part;
    const Waypoints before = between(part, nullptr, narrow), after = between(part, narrow, nullptr);
    if (!keeps(before, floor) || !keeps(after, floor)) return part;
    return joined(
        {raisedPart(before, floor, divisions + 1), raisedPart(after, floor, divisions + 1)});
  }

  /// Raises what is between the first and the last place that have the target; then each of the
  /// three on its own.
  std::optional<Waypoints> raisedBetween(const Waypoints& part, const std::vector<Sample>& samples,
                                         double floor, double target, int divisions) {
    const auto hasRoom = [&](const Sample& s) { return kElsewhereEnds * s.clearance >= target; };
    const auto first = std::find_if(samples.begin(), samples.end(), hasRoom);
    const auto last = std::find_if(samples.rbegin(), samples.rend(), hasRoom).base();
    if (last - first < 3) return std::nullopt;
    Waypoints head = between(part, nullptr, &*first), tail = between(part, &*(last - 1), nullptr);
    Waypoints middle = between(part, &*first, &*(last - 1));
    if (!keeps(head, floor) || !keeps(tail, floor) || !pushPart(middle, target))
      return std::nullopt;
    if (length(head) > shortest_) head = raisedPart(std::move(head), floor, divisions + 1);
    if (length(tail) > shortest_) tail = raisedPart(std::move(tail), floor, divisions + 1);
    return joined({head, raisedPart(std::move(middle), target, divisions), tail});
  }

  /// The least of the samples that have more on both sides; null without one.
  static const Sample* narrowest(const std::vector<Sample>& samples) {
    const Sample* least = nullptr;
    for (std::size_t i = 1; i + 1 < samples.size(); ++i)
      if (samples[i].clearance <= samples[i - 1].clearance &&
          samples[i].clearance <= samples[i + 1].clearance &&
          (least == nullptr || samples[i].clearance < least->clearance))
        least = &samples[i];
    return least;
  }

  static bool isWorth(double target, double floor) {
    return target > floor + std::max(kElsewhereGain * floor, kClearanceTolerance);
  }

  /// Evenly along the part's length.
  std::vector<Sample> sampled(const Waypoints& part) {
    std::vector<Sample> samples;
    const double step = length(part) / kElsewhereSamples;
    for (std::size_t i = 0; i + 1 < part.size(); ++i) {
      const double edge = space_.distance(part[i], part[i + 1]);
      const int count = step > 0 ? static_cast<int>(std::ceil(edge / step)) : 1;
      for (int k = 0; k < count; ++k) {
        if (options_.stop && options_.stop()) return {};
        samples.push_back(sampleAt(part, i, static_cast<double>(k) / count));
      }
    }
    samples.push_back(sampleAt(part, part.size() - 2, 1));
    return samples;
  }

  Sample sampleAt(const Waypoints& part, std::size_t edge, double t) {
    std::vector<double> point(part[0].size());
    space_.interpolate(part[edge], part[edge + 1], t, point);
    const EdgeClearance found = certifier_.edgeClearance(
        point, point, {.tolerance = kElsewhereTolerance, .pairs = options_.pairs});
    return {edge, t, found.clearance.lower};
  }

  static double mostOf(const std::vector<Sample>& samples) {
    double most = -kInfinity;
    for (const Sample& sample : samples) most = std::max(most, sample.clearance);
    return most;
  }

  /// From a sample, or the beginning, to another, or the end.
  Waypoints between(const Waypoints& part, const Sample* from, const Sample* to) const {
    const auto pointAt = [&](const Sample& sample) {
      std::vector<double> point(part[0].size());
      space_.interpolate(part[sample.edge], part[sample.edge + 1], sample.t, point);
      return point;
    };
    Waypoints result;
    const std::size_t first = from != nullptr ? from->edge + 1 : 0;
    const std::size_t last = to != nullptr ? to->edge : part.size() - 1;
    if (from != nullptr) result.push_back(pointAt(*from));
    for (std::size_t i = first; i <= last; ++i)
      if (result.empty() || part[i] != result.back()) result.push_back(part[i]);
    if (to != nullptr)
      if (auto point = pointAt(*to); point != result.back()) result.push_back(std::move(point));
    return result;
  }

  /// Whether edges that rounding has moved off proven ones still are.
  bool keeps(const Waypoints& part, double floor) {
    for (std::size_t i = 0; i + 1 < part.size(); ++i) {
      if (certifier_.certify(part[i], part[i + 1]).verdict != Verdict::kFree) return false;
      if (!(certifier_
                .proveClearance(part[i], part[i + 1],
                                {.wanted = floor - kElsewhereRounding, .pairs = options_.pairs})
                .clearance.lower >= floor - kElsewhereRounding))
        return false;
    }
    return true;
  }

  /// Whether the part now keeps the target; if so, it is as short as it may be.
  bool pushPart(Waypoints& part, double target) {
    ++pushes_;
    PushOptions push_options;
    push_options.target = push_options.least = target;
    const double before = length(part);
    push_options.longest = before + spare_;
    push_options.pairs = options_.pairs;
    push_options.work = kClearancePushWork;
    push_options.stop = options_.stop;
    if (!(push(certifier_, part, push_options) > 0)) return false;
    EdgeCertifier wider(raised(*scene_, options_.pairs, target - kElsewhereRounding));
    SimplifyOptions options;
    options.stop = options_.stop;
    options.attempts = kElsewhereShortcuts;
    simplify(wider, part, options);
    work += wider.statistics;
    spare_ -= length(part) - before;
    return true;
  }

  static Waypoints joined(std::initializer_list<Waypoints> parts) {
    Waypoints path;
    for (const Waypoints& part : parts)
      for (const std::vector<double>& point : part)
        if (path.empty() || point != path.back()) path.push_back(point);
    return path;
  }

  const std::shared_ptr<const CompiledScene>& scene_;
  const ConfigurationSpace& space_;
  EdgeCertifier& certifier_;
  const PushElsewhereOptions& options_;
  double spare_ = 0;     ///< length that the path may still gain
  double shortest_ = 0;  ///< length of a part that is divided
  int pushes_ = 0;
};

}  // namespace

EdgeCertifier::Statistics pushElsewhere(const std::shared_ptr<const CompiledScene>& scene,
                                        EdgeCertifier& certifier, Waypoints& path,
                                        const PushElsewhereOptions& options) {
  if (path.size() < 2 || !(options.kept > 0)) return {};
  Elsewhere elsewhere(scene, certifier, options);
  elsewhere.run(path);
  return elsewhere.work;
}

}  // namespace leeway::planner
