#include <cmath>
#include <optional>

#include "collision/base/numbers.h"
#include "leeway/planner/simplify.h"
#include "planner/base/tolerances.h"
#include "planner/improve/push.h"

// Near its ends a path keeps no more than the ends, and in a narrow place no more than the place
// allows. Between them it may keep more: first T1 between the places that have T1, then T2 > T1
// between the places that have T2. If that fails, each side of the limiting place is pushed on its
// own.
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

/// Its moves are pushed parts of the path; its measure is the clearance that they keep.
class Elsewhere : PathImprover {
 public:
  Elsewhere(const std::shared_ptr<const CompiledScene>& scene, EdgeCertifier& certifier,
            Waypoints& path, const PushOptions& options)
      : PathImprover(certifier, path, options.stop),
        scene_(scene),
        options_(options),
        spare_(options.longest - pathLength(space_, path)),
        shortest_(kElsewhereShort * pathLength(space_, path)) {}

  EdgeCertifier::Statistics run() {
    raise(0, path_.size() - 1, options_.target, 0);
    return work_;
  }

 private:
  /// A point of an edge, and an upper bound on its clearance.
  struct Sample {
    std::size_t edge;
    double t, clearance;
  };

  bool isEnough() { return isOver() || pushes_ >= kMostElsewhere; }

  /// Raises the clearance of the part between two waypoints, whose edges keep `floor`. Returns the
  /// waypoint where the part then ends.
  std::size_t raise(std::size_t first, std::size_t last, double floor, int divisions) {
    if (isEnough() || divisions > kMostDivisions || first == last) return last;
    const std::vector<Sample> samples = sampled(first, last);
    double target = kElsewhereGrowth * floor, most = -kInfinity;
    for (const Sample& sample : samples) most = std::max(most, sample.clearance);
    target = std::min(target, kElsewhereEnds * most);
    floor_ = floor;
    for (int k = 0; k < kElsewhereTries && isWorth(target, floor) && !isEnough(); ++k) {
      if (const auto raised = raiseBetween(first, last, samples, floor, target, divisions))
        return *raised;
      target = (floor + target) / 2;
    }
    const Sample* narrow = narrowest(samples);
    if (narrow == nullptr || isEnough()) return last;
    std::size_t at = narrow->edge;
    if (narrow->t > 0) {
      const Point point = between(at, narrow->t);
      if (!take({at, at + 1, {&point, 1}})) return last;
      ++at;
      ++last;
    }
    const std::size_t middle = raise(first, at, floor, divisions + 1);
    return raise(middle, last + middle - at, floor, divisions + 1);
  }

  /// Raises the clearance between the first and the last place that have the target, then that of
  /// each of the three parts.
  std::optional<std::size_t> raiseBetween(std::size_t first, std::size_t last,
                                          const std::vector<Sample>& samples, double floor,
                                          double target, int divisions) {
    const auto hasRoom = [&](const Sample& s) { return kElsewhereEnds * s.clearance >= target; };
    const auto from = std::find_if(samples.begin(), samples.end(), hasRoom);
    const auto end = std::find_if(samples.rbegin(), samples.rend(), hasRoom).base();
    if (end - from < 3) return std::nullopt;
    const auto to = end - 1;
    // Samples at waypoints stay there; other samples become waypoints.
    const std::size_t begins = from->t > 0 ? 1 : 0, ends = to->t > 0 && to->t < 1 ? 1 : 0;
    Waypoints part = {between(from->edge, from->t)};
    for (std::size_t i = from->edge + 1; i < to->edge + (to->t > 0 ? 1 : 0); ++i)
      part.push_back(path_[i]);
    part.push_back(between(to->edge, to->t));
    if (!pushPart(part, target)) return std::nullopt;
    const std::size_t move_last = to->t > 0 ? to->edge + 1 : to->edge;
    const std::size_t before = path_.size();
    if (!take({from->edge, move_last,
               std::span(part).subspan(1 - begins, part.size() - 2 + begins + ends)}))
      return std::nullopt;
    last += path_.size() - before;
    const std::size_t head = from->edge + begins, tail = head + part.size() - 1;
    std::size_t middle = head;
    if (lengthBetween(first, head) > shortest_) middle = raise(first, head, floor, divisions + 1);
    const std::size_t shift = middle - head;
    last += shift;
    if (lengthBetween(tail + shift, last) > shortest_)
      last = raise(tail + shift, last, floor, divisions + 1);
    return last + raise(middle, tail + shift, target, divisions) - (tail + shift);
  }

  /// The least of the samples that have greater ones on both sides; null if there is none.
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

  /// Samples at equal steps along the part's length.
  std::vector<Sample> sampled(std::size_t first, std::size_t last) {
    std::vector<Sample> samples;
    const double step = lengthBetween(first, last) / kElsewhereSamples;
    for (std::size_t i = first; i < last; ++i) {
      const double edge = space_.distance(path_[i], path_[i + 1]);
      const int count = step > 0 ? static_cast<int>(std::ceil(edge / step)) : 1;
      for (int k = 0; k < count; ++k) {
        if (isOver()) return {};
        samples.push_back(sampleAt(i, static_cast<double>(k) / count));
      }
    }
    samples.push_back(sampleAt(last - 1, 1));
    return samples;
  }

  Sample sampleAt(std::size_t edge, double t) {
    const Point point = between(edge, t);
    const EdgeClearance found = certifier_.edgeClearance(
        point, point, {.tolerance = kElsewhereTolerance, .pairs = options_.pairs});
    return {edge, t, found.clearance.lower};
  }

  bool mayGain(const Move& move) override {
    growth_ = lengthOf(move) - lengthBetween(move.first, move.last);
    return growth_ <= std::max(spare_, kElsewhereRounding);
  }

  /// An edge keeps its clearance, except for rounding at places that have become waypoints.
  bool proves(const Move& move, std::size_t edge) override {
    const double least = floor_ - kElsewhereRounding;
    return PathImprover::proves(move, edge) &&
           certifier_
                   .proveClearance(pointOf(move, edge), pointOf(move, edge + 1),
                                   {.wanted = least, .pairs = options_.pairs})
                   .clearance.lower >= least;
  }

  void keep(const Move&) override { spare_ -= growth_; }

  /// Whether the part now keeps the target. If so, it is also shortened.
  bool pushPart(Waypoints& part, double target) {
    ++pushes_;
    PushOptions push_options = options_;
    push_options.target = push_options.least = target;
    push_options.longest = pathLength(space_, part) + spare_;
    push_options.work = kClearancePushWork;
    if (!(push(certifier_, part, push_options) > 0)) return false;
    EdgeCertifier wider(raised(*scene_, options_.pairs, target - kElsewhereRounding));
    SimplifyOptions options;
    options.stop = options_.stop;
    options.attempts = kElsewhereShortcuts;
    simplify(wider, part, options);
    work_ += wider.statistics;
    return true;
  }

  const std::shared_ptr<const CompiledScene>& scene_;
  const PushOptions& options_;
  double spare_;       ///< by which the path's length may still grow
  double shortest_;    ///< least length of a part that is divided
  double floor_ = 0;   ///< clearance that the current part keeps
  double growth_ = 0;  ///< of the path's length, by the current move
  int pushes_ = 0;
  EdgeCertifier::Statistics work_;
};

}  // namespace

EdgeCertifier::Statistics pushElsewhere(const std::shared_ptr<const CompiledScene>& scene,
                                        EdgeCertifier& certifier, Waypoints& path,
                                        const PushOptions& options) {
  if (path.size() < 2 || !(options.target > 0)) return {};
  return Elsewhere(scene, certifier, path, options).run();
}

}  // namespace leeway::planner
