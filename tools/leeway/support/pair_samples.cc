#include "tools/leeway/support/pair_samples.h"

#include <cmath>
#include <numbers>

#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"

namespace leeway::tools {
namespace {

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers with every library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform() {  // [0, 1)
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// A uniform rotation (Shoemake 1992).
void sampleRotation(Random& random, double* quaternion) {
  const double u = random.uniform();
  const double a = 2 * std::numbers::pi * random.uniform();
  const double b = 2 * std::numbers::pi * random.uniform();
  quaternion[0] = std::sqrt(1 - u) * std::sin(a);
  quaternion[1] = std::sqrt(1 - u) * std::cos(a);
  quaternion[2] = std::sqrt(u) * std::sin(b);
  quaternion[3] = std::sqrt(u) * std::cos(b);
}

void samplePoint(const planner::ConfigurationSpace& space, Random& random,
                 std::vector<double>& point) {
  for (const auto& part : space.parts()) {
    const auto first = static_cast<std::size_t>(part.first);
    if (part.kind == planner::ConfigurationSpace::Kind::kRotation) {
      sampleRotation(random, &point[first]);
      continue;
    }
    const double lower =
        std::isfinite(space.lower(part.first)) ? space.lower(part.first) : -std::numbers::pi;
    const double upper =
        std::isfinite(space.upper(part.first)) ? space.upper(part.first) : std::numbers::pi;
    point[first] = lower + random.uniform() * (upper - lower);
  }
}

}  // namespace

std::vector<PairSamples> samplePairs(const planner::CompiledScene& scene, int samples,
                                     std::uint64_t seed) {
  const auto& pairs = scene.scene().pairs();
  const auto bodies = scene.scene().bodies();
  std::vector<PairSamples> result;
  for (std::size_t p = 0; p < pairs.listedCount(); ++p) {
    if (scene.bodyLink(pairs[p].body_a) >= 0 && scene.bodyLink(pairs[p].body_b) >= 0) {
      result.push_back({static_cast<int>(p), 0});
    }
  }
  Random random(seed);
  collision::Scratch scratch;
  collision::DistanceRequest request;
  request.depth = false;
  std::vector<double> point(static_cast<std::size_t>(scene.space().size()));
  std::vector<double> q(scene.model().variables.size());
  std::vector<robots::Pose> X_WL(scene.model().links.size());
  for (int sample = 0; sample < samples && !result.empty(); ++sample) {
    samplePoint(scene.space(), random, point);
    scene.expand(point, q);
    robots::forwardKinematics(scene.model(), q, X_WL);
    for (PairSamples& entry : result) {
      const auto& pair = pairs[static_cast<std::size_t>(entry.pair)];
      const auto place = [&](int body, int geometry) {
        const auto& shape =
            bodies[static_cast<std::size_t>(body)].geometries[static_cast<std::size_t>(geometry)];
        return X_WL[static_cast<std::size_t>(scene.bodyLink(body))] * shape.X_BG;
      };
      const auto& a = bodies[static_cast<std::size_t>(pair.body_a)]
                          .geometries[static_cast<std::size_t>(pair.geometry_a)]
                          .shape;
      const auto& b = bodies[static_cast<std::size_t>(pair.body_b)]
                          .geometries[static_cast<std::size_t>(pair.geometry_b)]
                          .shape;
      request.threshold = pair.margin;
      const auto answer =
          collision::distance(a, place(pair.body_a, pair.geometry_a), b,
                              place(pair.body_b, pair.geometry_b), request, scratch);
      entry.hits += answer.distance.lower > pair.margin ? 0 : 1;
    }
  }
  return result;
}

}  // namespace leeway::tools
