#include "tools/lab/bench/pair_families.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "tools/lab/bench/bodies.h"
#include "tools/lab/bench/splitmix.h"
#include "tools/lab/fcl/fcl_shape.h"

namespace leeway::bench {
namespace {

using collision::DistanceResult;
using collision::Scratch;
using Eigen::Vector3d;

class Random : public SplitMix {
 public:
  using SplitMix::SplitMix;
  double logUniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  Vector3d direction() {
    for (;;) {
      const double x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
      const Vector3d v(x, y, z);
      const double norm = v.norm();
      if (norm > 0.01 && norm <= 1) return v / norm;
    }
  }
  Eigen::Matrix3d rotation() {
    const Vector3d axis = direction();
    return Eigen::AngleAxisd(uniform(0, 6.283185307179586), axis).toRotationMatrix();
  }
};
Body body(const Shape& shape) { return {shape, lab::toFcl(shape)}; }

Body hull(const std::vector<Vector3d>& points) {
  const auto own = collision::ConvexHull::compute(points);
  auto vertices =
      std::make_shared<std::vector<Vector3d>>(own->vertices().begin(), own->vertices().end());
  auto faces = std::make_shared<std::vector<int>>();
  for (const auto& f : own->facets()) faces->insert(faces->end(), {3, f[0], f[1], f[2]});
  return {Shape::convexHull(own),
          std::make_shared<fcl::Convexd>(vertices, static_cast<int>(own->facets().size()), faces)};
}

/// `count` vertices on an ellipsoid.
Body roundHull(Random& random, int count) {
  const Vector3d axes(random.uniform(0.5, 1), random.uniform(0.4, 1), random.uniform(0.3, 1));
  std::vector<Vector3d> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.push_back(axes.cwiseProduct(random.direction()));
  return hull(points);
}

/// Long, thin and flat: two of three sizes below a thousandth to a hundredth of the first.
Body sliver(Random& random) {
  const Vector3d scale(1, random.logUniform(1e-5, 1e-2), random.logUniform(1e-6, 1));
  std::vector<Vector3d> points;
  points.reserve(12);
  for (int i = 0; i < 12; ++i) points.push_back(scale.cwiseProduct(random.direction()));
  return hull(points);
}

Body anyBox(Random& random) {
  return body(Shape::box({random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1)}));
}
Body anySphere(Random& random) { return body(Shape::sphere(random.uniform(0.1, 0.6))); }
Body anyCapsule(Random& random) {
  return body(Shape::capsule(random.uniform(0.1, 0.6), random.uniform(0.2, 1)));
}
Body anyCylinder(Random& random) {
  return body(Shape::cylinder(random.uniform(0.1, 0.6), random.uniform(0.2, 1)));
}
Body anyCone(Random& random) {
  return body(Shape::cone(random.uniform(0.1, 0.6), random.uniform(0.2, 1)));
}
Body anyEllipsoid(Random& random) {
  return body(
      Shape::ellipsoid({random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1)}));
}
/// A robot's closed link of 768 triangles.
Body linkMesh(Random&) {
  const Soup soup = bench::link(24, 16);
  return {Shape::mesh(collision::TriangleMesh::make(soup.vertices, soup.triangles)), {}};
}
/// Moves B along the normal until the pair is `gap` apart (negative: that deep).
bool settle(double gap, Scratch& scratch, Pair& pair) {
  for (int i = 0; i < 40; ++i) {
    const DistanceResult r = distance(pair.a.ours, pair.X_WA, pair.b.ours, pair.X_WB, {}, scratch);
    if (std::abs(r.distance.upper - gap) <= 1e-12) break;
    pair.X_WB.translation += (gap - r.distance.upper) * r.normal;
  }
  const DistanceResult r = distance(pair.a.ours, pair.X_WA, pair.b.ours, pair.X_WB, {}, scratch);
  pair.gap = r.distance.upper;
  pair.F_WA = lab::isometry(pair.X_WA);
  pair.F_WB = lab::isometry(pair.X_WB);
  return std::abs(r.distance.upper - gap) <= 1e-3 * std::abs(gap) + 1e-9;
}

/// Random poses at that gap.
bool place(Random& random, double gap, Scratch& scratch, Pair& pair) {
  const double reach = pair.a.ours.boundingRadius() + pair.b.ours.boundingRadius();
  pair.X_WA = {random.rotation(), {random.uniform(), random.uniform(), random.uniform()}};
  pair.X_WB.rotation = random.rotation();
  pair.X_WB.translation = pair.X_WA.translation + 1.1 * reach * random.direction();
  return settle(gap, scratch, pair);
}

using Make = std::function<Body(Random&)>;

std::vector<Pair> scattered(Random& random, int count, const Make& a, const Make& b,
                            const std::function<double(Random&)>& gap) {
  std::vector<Body> bodies_a, bodies_b;
  for (int i = 0; i < 16; ++i) {
    bodies_a.push_back(a(random));
    bodies_b.push_back(b(random));
  }
  Scratch scratch;
  std::vector<Pair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    const auto pick = [&] { return static_cast<std::size_t>(random.uniform(0, 15.999)); };
    Pair pair{bodies_a[pick()], bodies_b[pick()], {}, {}, {}, {}, 0, 0, 0};
    if (place(random, gap(random), scratch, pair)) pairs.push_back(pair);
  }
  return pairs;
}

/// Bodies of revolution that overlap side by side, with an angle from `tilt` between their axes.
std::vector<Pair> sideBySide(Random& random, int count, const Make& make,
                             const std::function<double(Random&)>& tilt) {
  Scratch scratch;
  std::vector<Pair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    Pair pair{make(random), make(random), {}, {}, {}, {}, 0, 0, 0};
    pair.X_WA = {random.rotation(), {random.uniform(), random.uniform(), random.uniform()}};
    const auto about = [&](const Vector3d& axis, double angle) {
      return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    };
    const double way = random.uniform(0, 6.283185307179586);
    const Vector3d beside(std::cos(way), std::sin(way), 0);
    pair.X_WB.rotation = pair.X_WA.rotation * about(Vector3d::UnitZ(), random.uniform(0, 6)) *
                         about(beside, tilt(random));
    const double reach = pair.a.ours.boundingRadius() + pair.b.ours.boundingRadius();
    const Vector3d along(0, 0, random.uniform(-0.2, 0.2));
    pair.X_WB.translation = pair.X_WA.translation + pair.X_WA.rotation * (reach * (beside + along));
    if (settle(-random.logUniform(1e-3, 0.1), scratch, pair)) pairs.push_back(pair);
  }
  return pairs;
}

/// Overlapping pairs of random depth, because the depth of meshes cannot be set.
std::vector<Pair> overlapping(Random& random, int count, const Make& a, const Make& b) {
  Scratch scratch;
  const Body body_a = a(random);
  std::vector<Pair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    Pair pair{body_a, b(random), {}, {}, {}, {}, 0, 0, 0};
    const double reach = pair.a.ours.boundingRadius() + pair.b.ours.boundingRadius();
    pair.X_WA = {random.rotation(), {random.uniform(), random.uniform(), random.uniform()}};
    pair.X_WB = {random.rotation(),
                 pair.X_WA.translation + random.uniform(0.3, 1) * reach * random.direction()};
    const DistanceResult r = distance(pair.a.ours, pair.X_WA, pair.b.ours, pair.X_WB, {}, scratch);
    if (r.distance.upper < -1e-3) pairs.push_back(pair);
  }
  return pairs;
}

/// Tracks of frames: B passes A at 2 to 30 cm, moving 1 to 6 mm and 0.01 rad in each frame.
std::vector<Pair> coherent(Random& random, int tracks, int frames, const Make& make) {
  Scratch scratch;
  std::vector<Pair> pairs;
  int track = 0;
  while (static_cast<int>(pairs.size()) < tracks * frames) {
    Pair pair{make(random), make(random), {}, {}, {}, {}, 0, 0, 0};
    if (!place(random, random.uniform(0.05, 0.5), scratch, pair)) continue;
    const DistanceResult r = distance(pair.a.ours, pair.X_WA, pair.b.ours, pair.X_WB, {}, scratch);
    // The motion is mostly tangential.
    Vector3d v = random.direction();
    v = (v - 0.9 * v.dot(r.normal) * r.normal).normalized() * random.uniform(0.001, 0.006);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.01, random.direction()).toRotationMatrix();
    ++track;
    for (int i = 0; i < frames; ++i) {
      pair.track = track;
      pair.F_WB = lab::isometry(pair.X_WB);
      pair.gap = std::numeric_limits<double>::quiet_NaN();
      pairs.push_back(pair);
      pair.X_WB.translation += v;
      // It stays orthogonal up to rounding for a few hundred frames.
      pair.X_WB.rotation = turn * pair.X_WB.rotation;
    }
  }
  return pairs;
}
double gapOf(Random& random) { return random.logUniform(1e-7, 10); }
double nearGap(Random& random) { return random.logUniform(1e-12, 1e-6); }
double depthOf(Random& random) { return -random.logUniform(1e-3, 0.3); }
double farGap(Random& random) { return random.uniform(0.01, 1); }

Make hullOf(int count) {
  return [count](Random& random) { return roundHull(random, count); };
}

std::vector<Pair> verifications(Random& random, int count, const Make& make) {
  std::vector<Pair> pairs = scattered(random, count, make, make, farGap);
  for (Pair& p : pairs) p.threshold = random.uniform(0.01, 1);
  return pairs;
}

}  // namespace

std::vector<PairFamily> pairFamilies(std::uint64_t seed, const std::string& only) {
  constexpr int kCount = 256, kTracks = 10, kFrames = 48;
  std::vector<PairFamily> all;
  const auto add = [&](const char* name, double target, Query query,
                       const std::function<std::vector<Pair>(Random&)>& make) {
    if (!only.empty() && std::string(name).find(only) == std::string::npos) return;
    std::uint64_t hash = seed;
    for (const char* c = name; *c != 0; ++c)
      hash = hash * 1099511628211U + static_cast<unsigned char>(*c);
    Random random(hash);
    all.push_back({name, target, query, make(random)});
  };
  const auto cold = [&](const char* name, double target, const Make& a, const Make& b) {
    add(name, target, Query::kCold,
        [&](Random& random) { return scattered(random, kCount, a, b, gapOf); });
  };
  cold("box-box", .25, anyBox, anyBox);
  cold("sphere-capsule", .35, anySphere, anyCapsule);
  cold("capsule-capsule", .5, anyCapsule, anyCapsule);
  cold("box-cylinder", .30, anyBox, anyCylinder);
  cold("box-capsule", .03, anyBox, anyCapsule);
  cold("cylinder-cylinder", .30, anyCylinder, anyCylinder);
  cold("hull 8", .15, hullOf(8), hullOf(8));
  cold("hull 32", .25, hullOf(32), hullOf(32));
  cold("hull 128", .20, hullOf(128), hullOf(128));
  cold("hull 512", .15, hullOf(512), hullOf(512));
  add("nearly touching", .30, Query::kCold, [&](Random& random) {
    std::vector<Pair> pairs;
    for (const int size : {8, 32, 128}) {
      const auto some = scattered(random, kCount / 4, hullOf(size), hullOf(size), nearGap);
      pairs.insert(pairs.end(), some.begin(), some.end());
    }
    return pairs;
  });
  cold("slivers", .22, sliver, sliver);
  for (const int size : {32, 512}) {
    add(size == 32 ? "depth, hull 32" : "depth, hull 512", size == 32 ? .25 : .15, Query::kDepth,
        [&](Random& random) {
          return scattered(random, kCount / 2, hullOf(size), hullOf(size), depthOf);
        });
  }
  const auto side = [&](const char* name, double target,
                        const std::function<double(Random&)>& tilt) {
    add(name, target, Query::kDepth,
        [&](Random& random) { return sideBySide(random, kCount / 2, anyCylinder, tilt); });
  };
  side("depth, cylinders |", .05, [](Random&) { return 0.0; });
  side("depth, cylinders /", 1.2, [](Random& random) { return random.logUniform(1e-6, 1e-2); });
  const auto depth = [&](const char* name, double target, const Make& a, const Make& b) {
    add(name, target, Query::kDepth,
        [&](Random& random) { return scattered(random, kCount / 2, a, b, depthOf); });
  };
  depth("depth, cylinders", .30, anyCylinder, anyCylinder);
  depth("depth, box-cyl.", .35, anyBox, anyCylinder);
  depth("depth, cone-ell.", .30, anyCone, anyEllipsoid);
  depth("depth, hull-cyl.", .35, hullOf(32), anyCylinder);
  add("depth, mesh-cyl.", 0, Query::kDepth,
      [&](Random& random) { return overlapping(random, kCount / 2, linkMesh, anyCylinder); });
  const auto warm = [&](const char* name, double target, const Make& make) {
    add(name, target, Query::kWarm,
        [&](Random& random) { return coherent(random, kTracks, kFrames, make); });
  };
  warm("warm, box", .15, anyBox);
  warm("warm, hull 32", .10, hullOf(32));
  warm("warm, hull 128", .08, hullOf(128));
  warm("warm, hull 512", .05, hullOf(512));
  const auto verify = [&](const char* name, const Make& make) {
    add(name, .5, Query::kVerify,
        [&](Random& random) { return verifications(random, kCount, make); });
  };
  verify("d > t, box", anyBox);
  verify("d > t, cylinder", anyCylinder);
  verify("d > t, hull 32", hullOf(32));
  verify("d > t, hull 512", hullOf(512));
  return all;
}

}  // namespace leeway::bench
