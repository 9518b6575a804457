#include "tools/lab/accuracy/accuracy_cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

#include "tools/lab/accuracy/hard_pairs.h"
#include "tools/lab/accuracy/random_pairs.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::tools::report {
namespace {

using collision::Pose;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using namespace random_pairs;

struct Pairing {
  const char* name;
  MakeShape a, b;
};
/// Every pair of convex types; the first twelve are the ones published elsewhere.
constexpr std::array<Pairing, 38> kPairings = {{
    {"box-box", box, box},
    {"box-sphere", box, sphere},
    {"sphere-capsule", sphere, capsule},
    {"capsule-capsule", capsule, capsule},
    {"box-capsule", box, capsule},
    {"box-cylinder", box, cylinder},
    {"cylinder-cylinder", cylinder, cylinder},
    {"hull 8", hull<8>, hull<8>},
    {"hull 32", hull<32>, hull<32>},
    {"hull 128", hull<128>, hull<128>},
    {"hull 512", hull<512>, hull<512>},
    {"sphere-sphere", sphere, sphere},
    {"sphere-cylinder", sphere, cylinder},
    {"sphere-cone", sphere, cone},
    {"sphere-ellipsoid", sphere, ellipsoid},
    {"sphere-hull", sphere, hull<32>},
    {"capsule-cylinder", capsule, cylinder},
    {"capsule-cone", capsule, cone},
    {"capsule-ellipsoid", capsule, ellipsoid},
    {"capsule-hull", capsule, hull<32>},
    {"box-cone", box, cone},
    {"box-ellipsoid", box, ellipsoid},
    {"box-hull", box, hull<32>},
    {"cylinder-cone", cylinder, cone},
    {"cylinder-ellipsoid", cylinder, ellipsoid},
    {"cylinder-hull", cylinder, hull<32>},
    {"cone-cone", cone, cone},
    {"cone-ellipsoid", cone, ellipsoid},
    {"cone-hull", cone, hull<32>},
    {"ellipsoid-ellipsoid", ellipsoid, ellipsoid},
    {"ellipsoid-hull", ellipsoid, hull<32>},
    {"half-space-sphere", halfSpace, sphere},
    {"half-space-capsule", halfSpace, capsule},
    {"half-space-box", halfSpace, box},
    {"half-space-cylinder", halfSpace, cylinder},
    {"half-space-cone", halfSpace, cone},
    {"half-space-ellipsoid", halfSpace, ellipsoid},
    {"half-space-hull", halfSpace, hull<32>},
}};

/// Closed-form pairs behave alike in contact; these cover every kind of core.
constexpr std::array<Pairing, 13> kOverlaps = {{
    {"overlap box-box", box, box},
    {"overlap box-sphere", box, sphere},
    {"overlap sphere-capsule", sphere, capsule},
    {"overlap capsule-capsule", capsule, capsule},
    {"overlap box-capsule", box, capsule},
    {"overlap box-cylinder", box, cylinder},
    {"overlap cylinder-cylinder", cylinder, cylinder},
    {"overlap cone-ellipsoid", cone, ellipsoid},
    {"overlap half-space-box", halfSpace, box},
    {"overlap hull 8", hull<8>, hull<8>},
    {"overlap hull 32", hull<32>, hull<32>},
    {"overlap hull 128", hull<128>, hull<128>},
    {"overlap hull 512", hull<512>, hull<512>},
}};
constexpr std::array<Pairing, 4> kCoherent = {{
    {"coherent box", box, box},
    {"coherent hull 32", hull<32>, hull<32>},
    {"coherent hull 128", hull<128>, hull<128>},
    {"coherent hull 512", hull<512>, hull<512>},
}};
/// A frame of coherent motion: a robot's link at 1 m/s and 1 rad/s, 200 frames/s.
constexpr double kStep = 0.005;  // [m] and [rad]

class SetBuilder {
 public:
  SetBuilder(int per_family, std::uint64_t seed,
             const std::function<void(const std::string&)>& progress)
      : per_family_(per_family), seed_(seed), progress_(progress) {}

  template <typename Make>
  void family(const char* name, FamilyKind kind, const Make& make) {
    Random random = begin(name, kind);
    for (int i = 0; i < per_family_; ++i) add(make(random), 0);
  }

  /// Tracks of at most 16 cases, each with its own pair and motion.
  void coherent(const Pairing& pairing) {
    constexpr int kTrack = 16;
    Random random = begin(pairing.name, FamilyKind::kCoherent);
    for (int i = 0; i < per_family_;) {
      ReportShape a = pairing.a(random);
      Placed p = placeApart(random, std::move(a), pairing.b(random));
      const Vector3d velocity = kStep * random.direction();
      const Matrix3d turn = Eigen::AngleAxisd(kStep, random.direction()).toRotationMatrix();
      const ReportShape* first_a = keep(p.a);
      const ReportShape* first_b = keep(p.b);
      for (int k = 0; k < kTrack && i < per_family_; ++k, ++i) {
        addCase(first_a, first_b, p.X_WA, p.X_WB, i / kTrack);
        p.X_WB.translation += velocity;
        p.X_WB.rotation = turn * p.X_WB.rotation;
      }
    }
  }

  AccuracySet take() { return std::move(set_); }

 private:
  /// Seeds by family, so that a family's cases do not depend on the others.
  Random begin(const char* name, FamilyKind kind) {
    if (progress_) progress_(name);
    set_.families.push_back({name, kind, {}});
    return Random(seed_ * 1000003 + set_.families.size());
  }
  const ReportShape* keep(ReportShape shape) {
    set_.shapes.push_back(std::make_unique<ReportShape>(std::move(shape)));
    return set_.shapes.back().get();
  }
  void add(Placed p, int track) {
    const ReportShape* a = keep(std::move(p.a));
    const ReportShape* b = keep(std::move(p.b));
    addCase(a, b, p.X_WA, p.X_WB, track);
  }
  void addCase(const ReportShape* a, const ReportShape* b, const Pose& X_WA, const Pose& X_WB,
               int track) {
    const oracle::Truth truth = oracle::signedSeparation(a->shape, X_WA, b->shape, X_WB);
    AccuracyCase c;
    c.spec = {a, b, X_WA, X_WB, sizeOfPair(a->shape, b->shape), 0, false};
    c.spec.distance = truth.lower + 0.5 * (truth.upper - truth.lower);
    c.spec.overlap = c.spec.distance < 0;
    c.truth_lower = truth.lower, c.truth_upper = truth.upper;
    c.extent = c.spec.size + std::max(X_WA.translation.norm(), X_WB.translation.norm());
    c.track = track;
    set_.families.back().cases.push_back(c);
  }

  int per_family_;
  std::uint64_t seed_;
  const std::function<void(const std::string&)>& progress_;
  AccuracySet set_;
};

}  // namespace

const char* toString(FamilyKind kind) {
  switch (kind) {
    case FamilyKind::kOrdinary:
      return "ordinary";
    case FamilyKind::kOverlap:
      return "overlap";
    case FamilyKind::kHard:
      return "hard";
    case FamilyKind::kCoherent:
      return "coherent";
  }
  return "";
}

AccuracySet makeAccuracySet(int per_family, std::uint64_t seed,
                            const std::function<void(const std::string&)>& progress) {
  SetBuilder builder(per_family, seed, progress);
  for (const Pairing& pairing : kPairings)
    builder.family(pairing.name, FamilyKind::kOrdinary, [&](Random& r) {
      ReportShape a = pairing.a(r);
      return placeApart(r, std::move(a), pairing.b(r));
    });
  for (const Pairing& pairing : kOverlaps)
    builder.family(pairing.name, FamilyKind::kOverlap, [&](Random& r) {
      ReportShape a = pairing.a(r);
      return placeOverlapping(r, std::move(a), pairing.b(r), 1e-3, 0.5);
    });
  for (const HardFamily& family : hardFamilies())
    builder.family(family.name, FamilyKind::kHard, family.make);
  for (const Pairing& pairing : kCoherent) builder.coherent(pairing);
  return builder.take();
}

}  // namespace leeway::tools::report
