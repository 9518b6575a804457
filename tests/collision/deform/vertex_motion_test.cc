#include "leeway/collision/vertex_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "collision/base/numbers.h"
#include "tests/support/motion_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using Exact = long double;  // 11 bits more than double resolve its rounding
using ExactVector = Eigen::Matrix<Exact, 3, 1>;

constexpr Exact kExactTwoPi = 6.283185307179586476925286766559L;

std::vector<Vector3d> at(const VertexMotion& motion, double time) {
  std::vector<Vector3d> positions(static_cast<std::size_t>(motion.vertexCount()));
  motion.evaluate(time, positions);
  return positions;
}

/// Largest deviation from `exact` at random times in [t0, t1], relative to rounding(); above 1 is a
/// failure.
double worstRounding(const VertexMotion& motion, double t0, double t1, Random& random,
                     const std::function<ExactVector(Exact, std::size_t)>& exact) {
  double worst = 0;
  const double allowed = motion.rounding(t0, t1);
  for (int i = 0; i < 20; ++i) {
    const double time = random.uniform(t0, t1);
    const std::vector<Vector3d> positions = at(motion, time);
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const Exact error = (positions[v].cast<Exact>() - exact(Exact(time), v)).norm();
      worst = std::max(worst, static_cast<double>(error) / allowed);
    }
  }
  return worst;
}

TEST(VertexMotion, WavesFollowTheirFormula) {
  Random random(11);
  for (int i = 0; i < 20; ++i) {
    const double far = random.chance(0.3) ? 1e5 : 10;
    WavesMotion spec;
    spec.rest = motion_cases::cloth(5).vertices;
    for (int k = 0; k < 2; ++k) {
      spec.waves.push_back({motion_cases::randomVector(random, 3),
                            motion_cases::randomVector(random, 0.2), random.uniform(0.1, 2),
                            random.uniform(-3, 3), random.uniform(-9, 9)});
    }
    if (random.chance(0.5)) spec.pinned = PinnedEdge{{0.2, 0, 1}, {0.3, 0, -2}, 0.7};
    const auto motion = VertexMotion::waves(spec);
    EXPECT_EQ(motion->kind(), MotionKind::kWaves);
    EXPECT_LT(motion->rounding(-far, far), far * 1e-13);
    const auto exact = [&](Exact t, std::size_t v) -> ExactVector {
      const ExactVector r = spec.rest[v].cast<Exact>();
      ExactVector p = r;
      Exact share = 1;
      if (spec.pinned) {
        share = (r - spec.pinned->point.cast<Exact>())
                    .dot(spec.pinned->direction.cast<Exact>().normalized()) /
                Exact(spec.pinned->length);
        share = std::clamp<Exact>(share, 0, 1);
      }
      for (const Wave& w : spec.waves) {
        const Exact turns = w.direction.cast<Exact>().normalized().dot(r) / Exact(w.wavelength) -
                            Exact(w.frequency) * t;
        p += share * std::sin(kExactTwoPi * turns + Exact(w.phase)) * w.amplitude.cast<Exact>();
      }
      return p;
    };
    const double worst = worstRounding(*motion, -far, far, random, exact);
    EXPECT_LE(worst, 1) << "spec " << i;
    EXPECT_GT(worst, 1e-4) << "the comparison does not bite";
  }
}

TEST(VertexMotion, PinnedEdgeStays) {
  Random random(3);
  const motion_cases::RestMesh mesh = motion_cases::cloth(6);
  const auto motion = motion_cases::wavesOf(mesh, random);
  const std::vector<Vector3d> positions = at(*motion, 0.37);
  for (std::size_t v = 0; v < 6; ++v) EXPECT_EQ(positions[v], mesh.vertices[v]);
  EXPECT_GT((positions.back() - mesh.vertices.back()).norm(), 1e-3);
}

Exact bernstein(int degree, int i, Exact u) {
  Exact value = 1;
  for (int k = 0; k < i; ++k) value *= Exact(degree - k) / Exact(k + 1) * u;
  for (int k = i; k < degree; ++k) value *= 1 - u;
  return value;
}

TEST(VertexMotion, LatticesFollowBernsteinPolynomials) {
  Random random(12);
  for (int i = 0; i < 10; ++i) {
    LatticeMotion spec;
    spec.rest = motion_cases::sphere(4).vertices;
    spec.box_lower = Vector3d(-0.7, -0.5, -0.9);
    spec.box_upper = Vector3d(0.6, 0.5, 0.5);
    for (int& cells : spec.cells) cells = 1 + random.below(random.chance(0.3) ? 16 : 4);
    const int size = (spec.cells[0] + 1) * (spec.cells[1] + 1) * (spec.cells[2] + 1);
    for (const double time : {-1.0, 2.5}) {
      LatticeMotion::Key key{time, {}};
      for (int k = 0; k < size; ++k)
        key.control_points.push_back(motion_cases::randomVector(random, 2));
      spec.keys.push_back(key);
    }
    const auto motion = VertexMotion::lattice(spec);
    EXPECT_LT(motion->rounding(-1, 2), 1e-12);
    const auto exact = [&](Exact t, std::size_t v) -> ExactVector {
      const Exact s = std::clamp<Exact>((t + 1) / 3.5L, 0, 1);
      const ExactVector low = spec.box_lower.cast<Exact>();
      const ExactVector u =
          (spec.rest[v].cast<Exact>() - low).cwiseQuotient(spec.box_upper.cast<Exact>() - low);
      ExactVector p = ExactVector::Zero();
      std::size_t n = 0;
      for (int z = 0; z <= spec.cells[2]; ++z) {
        for (int y = 0; y <= spec.cells[1]; ++y) {
          for (int x = 0; x <= spec.cells[0]; ++x, ++n) {
            const Exact weight = bernstein(spec.cells[0], x, u.x()) *
                                 bernstein(spec.cells[1], y, u.y()) *
                                 bernstein(spec.cells[2], z, u.z());
            p += weight * ((1 - s) * spec.keys[0].control_points[n].cast<Exact>() +
                           s * spec.keys[1].control_points[n].cast<Exact>());
          }
        }
      }
      return p;
    };
    const double worst = worstRounding(*motion, -1.5, 3, random, exact);
    EXPECT_LE(worst, 1) << "spec " << i;
    EXPECT_GT(worst, 1e-5) << "the comparison does not bite";
  }
}

TEST(VertexMotion, ALatticeOnItsGridLeavesTheMesh) {
  LatticeMotion spec;
  spec.rest = motion_cases::cloth(5).vertices;
  spec.box_lower = Vector3d(0, -1, 0);
  spec.box_upper = Vector3d(1, 1, 2);
  spec.cells[0] = 4;
  spec.cells[2] = 3;
  LatticeMotion::Key key;
  for (int z = 0; z <= 3; ++z) {
    for (int y = 0; y <= 1; ++y) {
      for (int x = 0; x <= 4; ++x)
        key.control_points.push_back({x / 4.0, 2.0 * y - 1, 2.0 * z / 3});
    }
  }
  spec.keys.push_back(key);
  const std::vector<Vector3d> positions = at(*VertexMotion::lattice(spec), 7);
  for (std::size_t v = 0; v < positions.size(); ++v)
    EXPECT_LT((positions[v] - spec.rest[v]).norm(), 1e-15) << v;
}

using Transform = Eigen::Transform<Exact, 3, Eigen::Isometry>;
using Quaternion = Eigen::Quaternion<Exact>;

Quaternion quaternionOf(const SkinnedMotion::BonePose& pose) {
  return Quaternion(Exact(pose.quaternion[3]), Exact(pose.quaternion[0]), Exact(pose.quaternion[1]),
                    Exact(pose.quaternion[2]))
      .normalized();
}

Transform placed(const Quaternion& q, const ExactVector& translation) {
  Transform X = Transform::Identity();
  X.linear() = q.toRotationMatrix();
  X.translation() = translation;
  return X;
}

TEST(VertexMotion, SkinsFollowTheirBones) {
  Random random(13);
  for (int i = 0; i < 10; ++i) {
    SkinnedMotion spec;
    spec.rest = motion_cases::tube(4).vertices;
    const auto randomPose = [&] {
      SkinnedMotion::BonePose pose;
      pose.translation = motion_cases::randomVector(random, 0.5);
      for (int k = 0; k < 4; ++k) pose.quaternion[k] = random.uniform(-1, 1);
      return pose;
    };
    for (int b = 0; b < 5; ++b) spec.bones.push_back({random.below(b + 1) - 1, randomPose()});
    for (int v = 0; v < static_cast<int>(spec.rest.size()); ++v) {
      for (int b = 0; b < 5; ++b)
        if (b == v % 5 || random.chance(0.5)) spec.weights.push_back({v, b, random.uniform(0, 3)});
    }
    for (const double time : {0.0, 1.5}) {
      SkinnedMotion::Key key{time, {}};
      for (int b = 0; b < 5; ++b) key.poses.push_back(randomPose());
      spec.keys.push_back(key);
    }
    const auto motion = VertexMotion::skinned(spec);
    EXPECT_LT(motion->rounding(0, 1), 1e-11);
    const auto exact = [&](Exact t, std::size_t v) -> ExactVector {
      const Exact s = std::clamp<Exact>(t / 1.5L, 0, 1);
      std::vector<Transform> now, rest;
      ExactVector p = ExactVector::Zero();
      for (std::size_t b = 0; b < 5; ++b) {
        const SkinnedMotion::BonePose &from = spec.keys[0].poses[b], &to = spec.keys[1].poses[b];
        const Quaternion q0 = quaternionOf(from);
        Quaternion q1 = quaternionOf(to);
        if (q0.dot(q1) < 0) q1.coeffs() = -q1.coeffs();
        Quaternion q;
        q.coeffs() = ((1 - s) * q0.coeffs() + s * q1.coeffs()).normalized();
        Transform X =
            placed(q, (1 - s) * from.translation.cast<Exact>() + s * to.translation.cast<Exact>());
        Transform R =
            placed(quaternionOf(spec.bones[b].rest), spec.bones[b].rest.translation.cast<Exact>());
        if (spec.bones[b].parent >= 0) {
          const auto parent = static_cast<std::size_t>(spec.bones[b].parent);
          X = now[parent] * X;
          R = rest[parent] * R;
        }
        now.push_back(X);
        rest.push_back(R);
      }
      Exact sum = 0;
      for (const SkinnedMotion::Weight& w : spec.weights) {
        if (static_cast<std::size_t>(w.vertex) != v) continue;
        const auto b = static_cast<std::size_t>(w.bone);
        sum += Exact(w.weight);
        p += Exact(w.weight) *
             (now[b] * (rest[b].inverse(Eigen::Isometry) * spec.rest[v].cast<Exact>()));
      }
      return p / sum;
    };
    const double worst = worstRounding(*motion, -0.5, 2, random, exact);
    EXPECT_LE(worst, 1) << "spec " << i;
    EXPECT_GT(worst, 1e-6) << "the comparison does not bite";
  }
}

TEST(VertexMotion, ReducedCoordinatesAddModes) {
  Random random(14);
  ReducedMotion spec;
  spec.rest = motion_cases::cloth(4).vertices;
  for (int k = 0; k < 6; ++k) {
    spec.modes.push_back(motion_cases::bumped(motion_cases::cloth(4), k, 0.2));
    spec.harmonics.push_back({random.uniform(-1, 1), random.uniform(-4, 4), random.uniform(-3, 3)});
  }
  const auto motion = VertexMotion::reduced(spec);
  const double worst =
      worstRounding(*motion, -20, 20, random, [&](Exact t, std::size_t v) -> ExactVector {
        ExactVector p = spec.rest[v].cast<Exact>();
        for (std::size_t k = 0; k < 6; ++k) {
          const ReducedMotion::Harmonic& h = spec.harmonics[k];
          p += Exact(h.amplitude) *
               std::sin(kExactTwoPi * Exact(h.frequency) * t + Exact(h.phase)) *
               spec.modes[k][v].cast<Exact>();
        }
        return p;
      });
  EXPECT_LE(worst, 1);
  EXPECT_GT(worst, 1e-4);
}

TEST(VertexMotion, MorphsBlendAndHold) {
  for (const bool smooth : {false, true}) {
    MorphMotion spec;
    spec.references = {motion_cases::bumped(motion_cases::cloth(4), 0, 0.1),
                       motion_cases::bumped(motion_cases::cloth(4), 1, 0.1)};
    spec.keys = {{1, {1, 0}}, {3, {-0.5, 2}}};
    spec.interpolation = smooth ? Interpolation::kSmooth : Interpolation::kLinear;
    const auto motion = VertexMotion::morph(spec);
    EXPECT_EQ(at(*motion, 0), spec.references[0]);
    EXPECT_EQ(at(*motion, 1), spec.references[0]);
    EXPECT_EQ(at(*motion, 3), at(*motion, 99));
    EXPECT_EQ(motion->speedBound(-5, 0.9), 0);
    EXPECT_EQ(motion->speedBound(3.1, 8), 0);
    Random random(15);
    const double worst =
        worstRounding(*motion, 0, 4, random, [&](Exact t, std::size_t v) -> ExactVector {
          const Exact u = std::clamp<Exact>((t - 1) / 2, 0, 1);
          const Exact s = smooth ? u * u * (3 - 2 * u) : u;
          return (1 - 1.5L * s) * spec.references[0][v].cast<Exact>() +
                 2 * s * spec.references[1][v].cast<Exact>();
        });
    EXPECT_LE(worst, 1);
    EXPECT_GT(worst, 1e-4);
  }
}

TEST(VertexMotion, CachesPassThroughTheirFrames) {
  CacheMotion spec;
  spec.vertex_count = 2;
  spec.times = {0, 0.5, 2};
  for (int i = 0; i < 6; ++i) spec.positions.emplace_back(0.1 * i, 4e6 + i * i / 3., 1. / (i + 3));
  const auto motion = VertexMotion::cache(spec);
  for (std::size_t frame = 0; frame < 3; ++frame) {
    for (std::size_t v = 0; v < 2; ++v)
      EXPECT_EQ(at(*motion, spec.times[frame])[v], spec.positions[2 * frame + v]);
  }
  EXPECT_LT((at(*motion, 0.25)[0] - 0.5 * (spec.positions[0] + spec.positions[2])).norm(), 1e-15);
  EXPECT_EQ(at(*motion, -1), at(*motion, 0));
  EXPECT_EQ(at(*motion, 3), at(*motion, 2));
  EXPECT_EQ(motion->keyTimes().size(), 3u);
}

// Finite differences of every motion against its bounds, and the bounds are not useless.
TEST(VertexMotion, SpeedAndAccelerationAreBounded) {
  int checked = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const motion_cases::MotionCase& c : motion_cases::allMotions(8, seed)) {
      Random random(seed);
      const VertexMotion& motion = *c.motion;
      double fastest = 0, sharpest = 0;  // shares of the bounds
      for (int i = 0; i < 400; ++i) {
        const double t0 = random.uniform(-0.5, 3.5), dt = random.logUniform(1e-4, 0.5);
        const double t1 = t0 + dt, middle = t0 + dt / 2;
        const std::vector<Vector3d> a = at(motion, t0), b = at(motion, middle), d = at(motion, t1);
        const double speed = motion.speedBound(t0, t1), error = motion.rounding(t0, t1);
        const double acceleration = motion.accelerationBound(t0, t1);
        ASSERT_TRUE(std::isfinite(speed)) << c.name;
        for (std::size_t v = 0; v < a.size(); ++v) {
          const double moved = (d[v] - a[v]).norm();
          ASSERT_LE(moved, speed * (t1 - t0) + 2 * error + 1e-15)
              << c.name << " seed " << seed << " t0 " << t0 << " t1 " << t1 << " vertex " << v;
          if (speed > 0) fastest = std::max(fastest, moved / (speed * dt));
          // x(t0) - 2 x(middle) + x(t1) is at most the acceleration times (dt / 2)^2.
          const double bent = (a[v] - 2 * b[v] + d[v]).norm(), half = dt / 2;
          if (std::isfinite(acceleration)) {
            ASSERT_LE(bent, acceleration * half * half + 4 * error + 1e-14)
                << c.name << " seed " << seed << " t0 " << t0 << " t1 " << t1 << " vertex " << v;
            if (dt > 0.01 && acceleration > 0)
              sharpest = std::max(sharpest, bent / (acceleration * half * half));
          }
          ++checked;
        }
      }
      EXPECT_GT(fastest, 0.2) << c.name << " seed " << seed << ": the speed bound is idle";
      if (c.name == "waves" || c.name.find("smooth") != std::string::npos) {
        EXPECT_GT(sharpest, 0.1) << c.name << " seed " << seed << ": the acceleration is idle";
      }
      EXPECT_EQ(motion.speedBound(1, 0), c.name == "explosion" ? 0.5 : kInfinity) << c.name;
    }
  }
  EXPECT_GT(checked, 1000000);
}

TEST(VertexMotion, LinearKeysHaveNoAccelerationBoundAcrossThem) {
  Random random(2);
  const motion_cases::RestMesh mesh = motion_cases::cloth(4);
  const auto linear = motion_cases::morphOf(mesh, random, Interpolation::kLinear, 0, 1);
  EXPECT_EQ(linear->accelerationBound(0, 0.7), 0);
  EXPECT_EQ(linear->accelerationBound(0.6, 0.8), kInfinity);
  EXPECT_EQ(linear->accelerationBound(-0.1, 0.1), kInfinity);
  EXPECT_EQ(linear->accelerationBound(2.9, 3.1), kInfinity);
  EXPECT_EQ(linear->accelerationBound(3, 4), 0);
  const auto smooth = motion_cases::morphOf(mesh, random, Interpolation::kSmooth, 0, 1);
  EXPECT_LT(smooth->accelerationBound(-1, 5), kInfinity);
}

// Half a turn between keys so close that rates or their squares overflow: infinity times a bone's
// fixed origin is NaN.
TEST(VertexMotion, KeysAsCloseAsCanBeHaveNoBounds) {
  SkinnedMotion skin;
  skin.rest = motion_cases::cloth(4).vertices;
  skin.bones.resize(1);
  for (int v = 0; v < static_cast<int>(skin.rest.size()); ++v) skin.weights.push_back({v, 0, 1});
  skin.keys.resize(3);
  for (SkinnedMotion::Key& key : skin.keys) key.poses.resize(1);
  skin.keys[1].poses[0].quaternion = skin.keys[2].poses[0].quaternion = {1, 0, 0, 0};
  skin.keys[2].time = 1;
  for (const double gap : {5e-324, 1e-310, 1e-308, 1e-300}) {
    skin.keys[1].time = gap;
    skin.interpolation = Interpolation::kLinear;
    const auto linear = VertexMotion::skinned(skin);
    // From z = 1 to z = -1 in `gap` seconds.
    EXPECT_GE(linear->speedBound(-1, 1), 2 / gap) << gap;
    EXPECT_EQ(linear->accelerationBound(-1, gap), kInfinity) << gap;
    skin.interpolation = Interpolation::kSmooth;
    const auto smooth = VertexMotion::skinned(skin);
    EXPECT_GE(smooth->speedBound(-1, 1), 2 / gap) << gap;
    EXPECT_EQ(smooth->accelerationBound(-1, gap), kInfinity) << gap;
  }
}

// This includes amplitude 0 with an overflowing argument.
TEST(VertexMotion, RoundingIsANumber) {
  ReducedMotion reduced;
  reduced.rest = motion_cases::cloth(4).vertices;
  reduced.modes.assign(2, reduced.rest);
  reduced.harmonics = {{0, 1, 0}, {1, 0.3, 0}};
  const auto motion = VertexMotion::reduced(reduced);
  EXPECT_EQ(motion->rounding(0, 1e308), kInfinity);
  EXPECT_LT(motion->rounding(0, 1), 1e-13);
}

TEST(VertexMotion, OneVertexHasTheBytesItHasAmongAll) {
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(8, 5)) {
    std::vector<double> parameters(static_cast<std::size_t>(c.motion->parameterCount()));
    c.motion->parameters(1.234, parameters);
    const std::vector<Vector3d> all = at(*c.motion, 1.234);
    for (int v = 0; v < c.motion->vertexCount(); ++v) {
      Vector3d one[1];
      c.motion->vertices(parameters, v, one);
      ASSERT_EQ(std::memcmp(one, &all[static_cast<std::size_t>(v)], sizeof one), 0)
          << c.name << " vertex " << v;
    }
  }
}

// Equal bytes on every machine: hashes of every motion's positions.
TEST(VertexMotion, BytesArePinned) {
  std::uint64_t hash = 14695981039346656037u;
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(6, 7)) {
    for (const double time : {-0.3, 0.0, 0.55, 1.9, 2.7, 1e4}) {
      for (const Vector3d& p : at(*c.motion, time)) {
        for (int k = 0; k < 3; ++k) {
          std::uint64_t bits;
          std::memcpy(&bits, &p[k], sizeof bits);
          hash = (hash ^ bits) * 1099511628211u;
        }
      }
    }
  }
  EXPECT_EQ(hash, 2546481508606702354u);
}

/// The message of the exception.
template <class Make>
std::string refusal(Make make) {
  try {
    make();
  } catch (const InvalidMotion& error) {
    return error.what();
  }
  return "accepted";
}

MorphMotion goodMorph() {
  MorphMotion m;
  m.references = {{Vector3d(0, 0, 0), Vector3d(1, 0, 0)}, {Vector3d(0, 1, 0), Vector3d(1, 2, 0)}};
  m.keys = {{0, {1, 0}}, {1, {0, 1}}};
  return m;
}

TEST(VertexMotion, BrokenMorphsAreRefused) {
  const auto with = [](const std::function<void(MorphMotion&)>& change) {
    MorphMotion m = goodMorph();
    change(m);
    return refusal([&] { VertexMotion::morph(m); });
  };
  EXPECT_EQ(with([](MorphMotion&) {}), "accepted");
  EXPECT_EQ(with([](MorphMotion& m) { m.references.clear(); }),
            "morph: no references; at least 1 is needed");
  EXPECT_EQ(with([](MorphMotion& m) { m.references[1].pop_back(); }),
            "morph: reference 1 has 1 vertices; 2 are needed");
  EXPECT_EQ(with([](MorphMotion& m) { m.references[1][1].y() = kNaN; }),
            "morph: reference 1, vertex 1: nan; finite numbers up to 1e+15 are accepted");
  EXPECT_EQ(with([](MorphMotion& m) { m.keys.clear(); }), "morph: no keys; at least 1 is needed");
  EXPECT_EQ(with([](MorphMotion& m) { m.keys[1].time = 0; }),
            "morph: key 1: time 0; it must be larger than the time before it, 0");
  EXPECT_EQ(with([](MorphMotion& m) { m.keys[1].time = -2; }),
            "morph: key 1: time -2; it must be larger than the time before it, 0");
  EXPECT_EQ(with([](MorphMotion& m) { m.keys[0].time = kNaN; }),
            "morph: key 0: time nan; finite numbers up to 1e+15 are accepted");
  EXPECT_EQ(with([](MorphMotion& m) { m.keys[1].weights.push_back(1); }),
            "morph: key 1 has 3 weights; 2 are needed");
  EXPECT_EQ(with([](MorphMotion& m) { m.keys[0].weights[1] = kInfinity; }),
            "morph: key 0, weight 1: inf; finite numbers up to 1e+15 are accepted");
}

TEST(VertexMotion, BrokenWavesAreRefused) {
  const auto with = [](const std::function<void(WavesMotion&)>& change) {
    WavesMotion m;
    m.rest = {Vector3d(0, 0, 0)};
    m.waves.resize(1);
    m.pinned = PinnedEdge{};
    change(m);
    return refusal([&] { VertexMotion::waves(m); });
  };
  EXPECT_EQ(with([](WavesMotion&) {}), "accepted");
  EXPECT_EQ(with([](WavesMotion& m) { m.rest.clear(); }),
            "waves: no vertices; at least 1 is needed");
  EXPECT_EQ(with([](WavesMotion& m) { m.rest[0].x() = 1e16; }),
            "waves: rest vertex 0: 1e+16; finite numbers up to 1e+15 are accepted");
  EXPECT_EQ(with([](WavesMotion& m) { m.waves.clear(); }), "waves: no waves; at least 1 is needed");
  EXPECT_EQ(with([](WavesMotion& m) { m.waves[0].direction.setZero(); }),
            "waves: wave 0, direction: 0 0 0; a vector that is not zero is needed");
  EXPECT_EQ(with([](WavesMotion& m) { m.waves[0].wavelength = 0; }),
            "waves: wave 0, wavelength: 0; more than 0 is accepted");
  EXPECT_EQ(with([](WavesMotion& m) { m.waves[0].phase = 1e6; }),
            "waves: wave 0, phase: 1e+06; finite numbers up to 1e+05 are accepted");
  EXPECT_EQ(with([](WavesMotion& m) { m.pinned->length = -1; }),
            "waves: pinned length: -1; more than 0 is accepted");
}

TEST(VertexMotion, BrokenLatticesAreRefused) {
  const auto with = [](const std::function<void(LatticeMotion&)>& change) {
    LatticeMotion m;
    m.rest = {Vector3d(0.5, 0.5, 1)};
    m.keys = {{0, std::vector<Vector3d>(8, Vector3d::Zero())}};
    change(m);
    return refusal([&] { VertexMotion::lattice(m); });
  };
  EXPECT_EQ(with([](LatticeMotion&) {}), "accepted");
  EXPECT_EQ(with([](LatticeMotion& m) { m.rest[0].z() = 1.5; }),
            "lattice: rest vertex 0 at 0.5 0.5 1.5 is outside the box; vertices must be within it");
  EXPECT_EQ(with([](LatticeMotion& m) { m.box_upper.y() = 0; }),
            "lattice: box from 0 to 0 along axis 1; the upper end must be larger");
  EXPECT_EQ(with([](LatticeMotion& m) { m.cells[2] = 17; }),
            "lattice: 17 cells along axis 2; 1 to 16 are accepted");
  EXPECT_EQ(with([](LatticeMotion& m) { m.cells[0] = 2; }),
            "lattice: key 0 has 8 control points; 12 are needed");
  EXPECT_EQ(with([](LatticeMotion& m) { m.keys[0].control_points[3].x() = kNaN; }),
            "lattice: key 0, control point 3: nan; finite numbers up to 1e+15 are accepted");
}

TEST(VertexMotion, BrokenSkinsAreRefused) {
  const auto with = [](const std::function<void(SkinnedMotion&)>& change) {
    SkinnedMotion m;
    m.rest = {Vector3d(0, 0, 0), Vector3d(1, 0, 0)};
    m.bones.resize(2);
    m.bones[1].parent = 0;
    m.weights = {{1, 0, 1}, {0, 0, 2}, {1, 1, 3}};
    m.keys = {{0, std::vector<SkinnedMotion::BonePose>(2)}};
    change(m);
    return refusal([&] { VertexMotion::skinned(m); });
  };
  EXPECT_EQ(with([](SkinnedMotion&) {}), "accepted");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.bones.clear(); }),
            "skinned: no bones; at least 1 is needed");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.bones[1].parent = 1; }),
            "skinned: bone 1: parent 1; an earlier bone, or -1 for none, is accepted");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.bones[0].rest.quaternion.setZero(); }),
            "skinned: bone 0, rest, quaternion: 0 0 0 0; x y z w of a length near 1 are needed");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.weights[1].vertex = 2; }),
            "skinned: weight 1: vertex 2; 0 to 1 are there");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.weights[1].bone = -1; }),
            "skinned: weight 1: bone -1; 0 to 1 are there");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.weights[1].weight = -0.5; }),
            "skinned: weight 1: -0.5; 0 or more is accepted");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.weights[1].weight = 0; }),
            "skinned: the weights of vertex 0 add up to 0; more than 0 is needed");
  EXPECT_EQ(with([](SkinnedMotion& m) {
              m.weights.push_back({1, 0, 1});
            }),
            "skinned: two weights for vertex 1 and bone 0; one is accepted");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.keys[0].poses.pop_back(); }),
            "skinned: key 0 has 1 poses; 2 are needed");
  EXPECT_EQ(with([](SkinnedMotion& m) { m.keys[0].poses[1].translation.x() = kNaN; }),
            "skinned: key 0, bone 1, translation: nan; finite numbers up to 1e+15 are accepted");
}

TEST(VertexMotion, BrokenReducedMotionsAreRefused) {
  const auto with = [](const std::function<void(ReducedMotion&)>& change) {
    ReducedMotion m;
    m.rest = {Vector3d(0, 0, 0)};
    m.modes = {{Vector3d(1, 0, 0)}};
    m.harmonics.resize(1);
    change(m);
    return refusal([&] { VertexMotion::reduced(m); });
  };
  EXPECT_EQ(with([](ReducedMotion&) {}), "accepted");
  EXPECT_EQ(with([](ReducedMotion& m) { m.modes.clear(); }),
            "reduced: no modes; at least 1 is needed");
  EXPECT_EQ(with([](ReducedMotion& m) { m.modes[0].clear(); }),
            "reduced: mode 0 has 0 vertices; 1 are needed");
  EXPECT_EQ(with([](ReducedMotion& m) {
              m.keys = {{0, {1}}};
            }),
            "reduced: 1 harmonics and 1 keys; one or the other is accepted");
  EXPECT_EQ(with([](ReducedMotion& m) { m.harmonics.resize(2); }),
            "reduced: the motion has 2 harmonics; 1 are needed");
  EXPECT_EQ(with([](ReducedMotion& m) { m.harmonics.clear(); }),
            "reduced: no keys; at least 1 is needed");
  EXPECT_EQ(with([](ReducedMotion& m) { m.harmonics[0].frequency = kNaN; }),
            "reduced: harmonic 0, frequency: nan; finite numbers up to 1e+15 are accepted");
}

TEST(VertexMotion, BrokenCachesAreRefused) {
  const auto with = [](const std::function<void(CacheMotion&)>& change) {
    CacheMotion m;
    m.vertex_count = 2;
    m.times = {0, 1};
    m.positions.assign(4, Vector3d::Zero());
    change(m);
    return refusal([&] { VertexMotion::cache(m); });
  };
  EXPECT_EQ(with([](CacheMotion&) {}), "accepted");
  EXPECT_EQ(with([](CacheMotion& m) { m.vertex_count = 0; }),
            "cache: 0 vertices; at least 1 is needed");
  EXPECT_EQ(with([](CacheMotion& m) { m.times.clear(); }),
            "cache: no frames; at least 1 is needed");
  EXPECT_EQ(with([](CacheMotion& m) { m.times[1] = 0; }),
            "cache: key 1: time 0; it must be larger than the time before it, 0");
  EXPECT_EQ(with([](CacheMotion& m) { m.positions.pop_back(); }),
            "cache: the motion has 3 positions (2 frames of 2 vertices); 4 are needed");
  EXPECT_EQ(with([](CacheMotion& m) { m.positions[3].y() = std::nan(""); }),
            "cache: frame 1, vertex 1: nan; finite numbers up to 1e+15 are accepted");
  EXPECT_EQ(with([](CacheMotion& m) { m.positions[2].x() = 1e16; }),
            "cache: frame 1, vertex 0: 1e+16; finite numbers up to 1e+15 are accepted");
}

TEST(VertexMotion, OwnMotionsAreChecked) {
  EXPECT_EQ(refusal([] { motion_cases::Explosion({}, 1, 1); }),
            "own: 0 vertices; at least 1 is needed");
}

}  // namespace
}  // namespace leeway::collision
