// All strategies, motions and queries against brute force over triangles. Every frame updates one
// deformable for each strategy; each answers every query, and its interval must intersect brute
// force's. LEEWAY_CONFORMANCE_QUERIES: number of queries for each strategy and motion (the default
// is quick); LEEWAY_CONFORMANCE_SEED: other frames and queries.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iomanip>
#include <limits>
#include <optional>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "tests/support/motion_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using motion_cases::MotionCase;
using oracle::Random;

constexpr int kQueriesAFrame = 12;

std::uint64_t fromEnvironment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

struct Choice {
  DeformStrategy strategy;
  DeformVolume volume = DeformVolume::kBox;

  std::string name() const {
    const std::string word = toString(strategy);
    return volume == DeformVolume::kBox ? word : word + ", " + toString(volume);
  }
};
constexpr Choice kChoices[] = {
    {DeformStrategy::kAuto},
    {DeformStrategy::kRebuild},
    {DeformStrategy::kRebuildLinear},
    {DeformStrategy::kRefit},
    {DeformStrategy::kHybrid},
    {DeformStrategy::kLazy},
    {DeformStrategy::kMorph},
    {DeformStrategy::kMorph, DeformVolume::kDop},
    {DeformStrategy::kMorph, DeformVolume::kBall},
    {DeformStrategy::kSkinned},
    {DeformStrategy::kReduced},
    {DeformStrategy::kReduced, DeformVolume::kDop},
    {DeformStrategy::kReduced, DeformVolume::kBall},
    {DeformStrategy::kOctree},
    {DeformStrategy::kRestructure},
};

// --- The slow twin ----------------------------------------------------------------------------

/// A body as convex pieces: its triangles, or itself. Triangle shapes are made on demand.
class Pieces {
 public:
  explicit Pieces(const Shape& shape) : shape_(shape) {
    std::span<const Vector3d> vertices;
    std::span<const motion_cases::Triangle> triangles;
    if (shape.type() == ShapeType::kDeformable) {
      vertices = shape.deformable()->vertices();
      triangles = shape.deformable()->mesh().triangles();
    } else if (shape.type() == ShapeType::kMesh) {
      vertices = shape.mesh()->vertices();
      triangles = shape.mesh()->triangles();
    } else {
      centers_.push_back(shape.boundingCenter());
      radii_.push_back(shape.boundingRadius());
      pieces_.emplace_back(shape);
      return;
    }
    pieces_.resize(triangles.size());
    for (const motion_cases::Triangle& t : triangles) {
      const auto corner = [&](std::size_t k) { return vertices[static_cast<std::size_t>(t[k])]; };
      corners_.push_back({corner(0), corner(1), corner(2)});
      const Vector3d center = (corner(0) + corner(1) + corner(2)) / 3;
      double radius = 0;
      for (std::size_t k = 0; k < 3; ++k) radius = std::max(radius, (corner(k) - center).norm());
      centers_.push_back(center);
      radii_.push_back(radius * (1 + 1e-12) + 1e-14);
    }
  }

  std::size_t count() const { return centers_.size(); }
  const Vector3d& center(std::size_t i) const { return centers_[i]; }
  double radius(std::size_t i) const { return radii_[i]; }
  const Shape& piece(std::size_t i) {
    if (!pieces_[i]) pieces_[i] = Shape::convexHull(corners_[i]);
    return *pieces_[i];
  }
  const Shape& shape() const { return shape_; }
  const std::array<Vector3d, 3>& corners(std::size_t i) const { return corners_[i]; }

 private:
  Shape shape_;
  std::vector<Vector3d> centers_;
  std::vector<double> radii_;
  std::vector<std::array<Vector3d, 3>> corners_;
  std::vector<std::optional<Shape>> pieces_;
};

/// Compares every piece with every piece, pruned by bounding balls.
Interval bruteSurfaces(Pieces& a, const Pose& X_WA, Pieces& b, const Pose& X_WB, Scratch& scratch) {
  const Pose X_AB = X_WA.inverse() * X_WB;
  std::vector<Vector3d> centers;
  for (std::size_t j = 0; j < b.count(); ++j) centers.push_back(X_AB * b.center(j));
  const auto coarse = [&](std::size_t i, std::size_t j) {
    return (a.center(i) - centers[j]).norm() - a.radius(i) - b.radius(j);
  };
  Interval all{kInfinity, kInfinity};
  const auto look = [&](std::size_t i, std::size_t j) {
    const Interval d = distance(a.piece(i), X_WA, b.piece(j), X_WB, {}, scratch).distance;
    all.lower = std::min(all.lower, d.lower);
    all.upper = std::min(all.upper, d.upper);
  };
  // Starts with the pair of nearest balls, which prunes most others.
  std::size_t near_i = 0, near_j = 0;
  double nearest = kInfinity;
  for (std::size_t i = 0; i < a.count(); ++i) {
    for (std::size_t j = 0; j < b.count(); ++j) {
      const double d = coarse(i, j);
      if (d < nearest) {
        nearest = d;
        near_i = i;
        near_j = j;
      }
    }
  }
  look(near_i, near_j);
  for (std::size_t i = 0; i < a.count(); ++i) {
    for (std::size_t j = 0; j < b.count(); ++j) {
      if (coarse(i, j) - 1e-9 <= all.upper && (i != near_i || j != near_j)) look(i, j);
    }
  }
  return all;
}

double solidAngles(const Vector3d& p, const std::array<Vector3d, 3>& t) {
  const Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)),
                        la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

/// Whether a point off the surface is inside a closed component, by the triangles' solid angles.
bool inside(const Pieces& outer, const Vector3d& p) {
  const auto componentOf = [&](std::size_t i) {
    return outer.shape().type() == ShapeType::kMesh
               ? outer.shape().mesh()->component(static_cast<int>(i))
               : outer.shape().deformable()->mesh().component(static_cast<int>(i));
  };
  const auto closed = [&](int component) {
    return outer.shape().type() == ShapeType::kMesh
               ? outer.shape().mesh()->isClosed(component)
               : outer.shape().deformable()->mesh().isClosed(component);
  };
  std::vector<double> turns;
  for (std::size_t i = 0; i < outer.count(); ++i) {
    const int component = componentOf(i);
    if (!closed(component)) continue;
    turns.resize(std::max(turns.size(), static_cast<std::size_t>(component) + 1), 0);
    turns[static_cast<std::size_t>(component)] += solidAngles(p, outer.corners(i));
  }
  return std::any_of(turns.begin(), turns.end(), [](double sum) { return std::abs(sum) > 6.28; });
}

/// Whether a component of `inner` is inside a closed one of `outer`; the surfaces are disjoint.
bool bruteHolds(const Pieces& outer, const Pose& X_WO, const Pieces& inner, const Pose& X_WI) {
  const ShapeType type = outer.shape().type();
  if (type != ShapeType::kMesh && type != ShapeType::kDeformable) return false;
  if (inner.shape().type() == ShapeType::kHalfSpace) return false;
  const Pose X_OI = X_WO.inverse() * X_WI;
  if (inner.shape().isConvex()) {
    // A hull's bounding centre may be outside the hull.
    const ConvexHull* hull = inner.shape().hull();
    return inside(outer,
                  X_OI * (hull != nullptr ? hull->vertices()[0] : inner.shape().boundingCenter()));
  }
  std::vector<int> seen;  // one point for each component
  for (std::size_t i = 0; i < inner.count(); ++i) {
    const int component = inner.shape().type() == ShapeType::kMesh
                              ? inner.shape().mesh()->component(static_cast<int>(i))
                              : inner.shape().deformable()->mesh().component(static_cast<int>(i));
    if (std::find(seen.begin(), seen.end(), component) != seen.end()) continue;
    seen.push_back(component);
    if (inside(outer, X_OI * inner.corners(i)[0])) return true;
  }
  return false;
}

struct Truth {
  Interval separation;   ///< when apart
  bool overlap = false;  ///< proven; the separation is at most `separation.upper` <= 0
  bool apart = false;    ///< proven
};

Truth truthOf(Pieces& a, const Pose& X_WA, Pieces& b, const Pose& X_WB, Scratch& scratch) {
  Truth truth;
  truth.separation = bruteSurfaces(a, X_WA, b, X_WB, scratch);
  if (truth.separation.lower > 0) {
    truth.overlap = bruteHolds(a, X_WA, b, X_WB) || bruteHolds(b, X_WB, a, X_WA);
    truth.apart = !truth.overlap;
    if (truth.overlap) truth.separation = {-kInfinity, -truth.separation.lower};
  } else {
    truth.overlap = truth.separation.upper <= 0;
    truth.separation.lower = -kInfinity;
  }
  return truth;
}

// --- What is compared -------------------------------------------------------------------------

struct Tally {
  std::int64_t answers = 0, overlaps = 0, apart = 0, near = 0;
  std::int64_t unsafe = 0;     ///< reported farther than the truth
  std::int64_t cautious = 0;   ///< reported nearer than the truth
  std::int64_t undecided = 0;  ///< a limit left an answer open that was not within 1e-9
  std::int64_t wide = 0;       ///< apart, not far beyond the tolerance, wider than requested
};

/// Why the answer is wrong; empty when it is right.
std::string fault(const Truth& truth, const DistanceRequest& request, const DistanceResult& r,
                  Tally& tally) {
  ++tally.answers;
  tally.overlaps += truth.overlap ? 1 : 0;
  tally.apart += truth.apart ? 1 : 0;
  if (r.status == DistanceStatus::kInvalid) return "invalid";
  if (!(r.distance.lower <= r.distance.upper)) return "ends exchanged";
  if (!(std::abs(r.normal.norm() - 1) < 1e-6)) return "normal is not a unit vector";
  if (r.distance.lower > truth.separation.upper) {
    ++tally.unsafe;
    return "UNSAFE: farther than brute force";
  }
  if (r.distance.upper < truth.separation.lower) {
    ++tally.cautious;
    return "nearer than brute force";
  }
  // Copies the engine's NaN default.
  const double tolerance = std::isnan(request.tolerance) ? 1e-9 : request.tolerance;
  const double t = request.threshold;
  if (!std::isnan(t)) {
    if (r.status == DistanceStatus::kAboveThreshold && !(r.distance.lower > t)) return "status";
    if (r.status == DistanceStatus::kNotAboveThreshold && !(r.distance.upper <= t)) return "status";
    const bool open = r.status == DistanceStatus::kLimit;
    if (open && truth.apart && std::abs(truth.separation.lower - t) > 1e-9) {
      ++tally.undecided;
      return "undecided";
    }
  } else if (truth.apart && r.distance.width() > std::max(tolerance, 1e-12)) {
    // Below the tolerance, closed bodies are bounded as if they might overlap.
    ++tally.wide;
    if (truth.separation.lower > tolerance) return "wider than asked";
    if (r.status != DistanceStatus::kLimit) return "status";
  }
  if (truth.apart && std::isnan(t)) {
    const double gap = (r.point_a - r.point_b).norm();
    if (!(gap <= r.distance.upper + r.distance.width() + 1e-9) ||
        !(gap >= r.distance.lower - r.distance.width() - 1e-9))
      return "witness points are not that far apart";
  }
  return "";
}

// --- One motion, all strategies ---------------------------------------------------------------

struct Subject {
  Choice choice;
  Deformable deformable;
  PairCache cache;  // kept across frames
  Scratch scratch;
};

std::vector<Subject> subjectsOf(const MotionCase& c,
                                const std::shared_ptr<const DeformableMesh>& mesh) {
  std::vector<Subject> subjects;
  for (const Choice& choice : kChoices) {
    const DeformStrategy strategy = choice.strategy;
    DeformOptions options;
    options.strategy = strategy;
    options.volume = choice.volume;
    options.hybrid_split = 32;  // small meshes get query nodes too
    try {
      subjects.push_back({choice, Deformable(mesh, c.motion, options), {}, {}});
    } catch (const std::invalid_argument&) {
      // Three strategies are specific to one kind of motion; the others take any.
      EXPECT_TRUE(strategy == DeformStrategy::kMorph || strategy == DeformStrategy::kSkinned ||
                  strategy == DeformStrategy::kReduced)
          << toString(strategy) << " refuses " << c.name;
    }
  }
  return subjects;
}

struct Opponent {
  Shape shape;
  Pose X_WB;
};

Shape randomOpponent(Random& random, const std::vector<Deformable>& moving) {
  constexpr ShapeType kTypes[] = {
      ShapeType::kSphere,    ShapeType::kCapsule,    ShapeType::kBox,
      ShapeType::kCylinder,  ShapeType::kCone,       ShapeType::kEllipsoid,
      ShapeType::kHalfSpace, ShapeType::kConvexHull, ShapeType::kMesh,
  };
  const int kind = random.below(11);
  if (kind >= 9) {
    const auto i = static_cast<std::size_t>(random.below(static_cast<int>(moving.size())));
    return Shape::deformable(moving[i].snapshot());
  }
  if (kTypes[kind] == ShapeType::kMesh) {
    if (random.chance(0.5)) return Shape::mesh(oracle::ellMesh(random.uniform(0.1, 1.5)));
    return Shape::mesh(oracle::sheetMesh(random, random.uniform(0.2, 1), 4));
  }
  const oracle::Flavour flavour =
      random.chance(0.8) ? oracle::Flavour::kPlain
                         : oracle::kFlavours[static_cast<std::size_t>(random.below(6))];
  return oracle::randomShape(random, kTypes[kind], flavour);
}

DistanceRequest randomRequest(Random& random, const Truth& truth) {
  DistanceRequest request;
  const double about = truth.apart ? truth.separation.upper : 0.01;
  switch (random.below(4)) {
    case 0:  // collide
      request.threshold = 0;
      request.depth = false;
      break;
    case 1:  // tolerance
      request.threshold = about * random.uniform(0, 2);
      request.depth = random.chance(0.5);
      break;
    case 2:  // distance
      request.tolerance = random.chance(0.5) ? 1e-9 : random.logUniform(1e-8, 1e-1);
      break;
    default:  // distance, no depth
      request.depth = false;
      break;
  }
  return request;
}

/// Moves B to about `gap` from A, if they are apart.
void graze(const Truth& truth, const DistanceResult& r, double gap, Pose& X_WB) {
  if (truth.apart) X_WB.translation -= (truth.separation.upper - gap) * r.normal;
}

// Checks a depth's ends: the translation by lower along the normal separates; no random one shorter
// than upper claims does.
std::string depthFault(Pieces& a, const Pose& X_WA, Pieces& b, const Pose& X_WB,
                       const DistanceResult& r, Random& random, Scratch& scratch) {
  const auto separated = [&](const Vector3d& translation) {
    Pose moved = X_WB;
    moved.translation += translation;
    return truthOf(a, X_WA, b, moved, scratch);
  };
  if (std::isfinite(r.distance.lower)) {
    if (separated((1e-7 - r.distance.lower) * r.normal).overlap)
      return "its separating translation does not separate";
  }
  if (r.distance.upper < -1e-7) {
    for (int i = 0; i < 3; ++i) {
      const double length = -0.999 * r.distance.upper;
      if (separated(length * random.direction()).apart) return "UNSAFE: a shorter one separates";
    }
  }
  return "";
}

class Conformance : public ::testing::TestWithParam<int> {
 protected:
  static constexpr std::uint64_t kDefaultQueries = 48;

  void SetUp() override {
    seed_ = fromEnvironment("LEEWAY_CONFORMANCE_SEED", 1);
    queries_ = fromEnvironment("LEEWAY_CONFORMANCE_QUERIES", kDefaultQueries);
  }

  // Frames are reproducible alone: randomness depends on seed, motion and frame only.
  Random randomOf(std::uint64_t frame) const {
    return Random(Random(seed_ * 1000003 + static_cast<std::uint64_t>(GetParam())).bits() ^
                  frame * 0xd1342543de82ef95u);
  }

  std::uint64_t seed_ = 1, queries_ = kDefaultQueries;
  int faults_ = 0;
};

/// A time within and around the keys; sometimes exactly a key.
double randomTime(Random& random) {
  if (random.chance(0.1))
    return motion_cases::keyTimes()[static_cast<std::size_t>(random.below(4))];
  return random.uniform(-0.3, 3.6);
}

TEST_P(Conformance, AnswersAreBruteForces) {
  const std::uint64_t frames = std::max<std::uint64_t>(queries_ / kQueriesAFrame, 1);
  // Neighbouring frames share mesh and motions; new ones every kFramesAMesh frames.
  constexpr std::uint64_t kFramesAMesh = 16;
  Tally tally;
  std::optional<MotionCase> c;
  std::shared_ptr<const DeformableMesh> mesh;
  std::vector<Subject> subjects;
  std::vector<Deformable> moving;
  double time = 0;
  for (std::uint64_t frame = 0; frame < frames && faults_ < 5; ++frame) {
    if (frame % kFramesAMesh == 0) {
      Random random = randomOf(~frame);
      const int size = 6 + random.below(random.chance(0.2) ? 24 : 8);
      std::vector<MotionCase> cases = motion_cases::allMotions(size, random.bits());
      c = std::move(cases[static_cast<std::size_t>(GetParam())]);
      mesh = DeformableMesh::make(c->mesh.vertices, c->mesh.triangles);
      subjects = subjectsOf(*c, mesh);
      ASSERT_GE(subjects.size(), 8u);
      moving.clear();
      for (MotionCase& other : motion_cases::allMotions(6, random.bits())) {
        moving.emplace_back(DeformableMesh::make(other.mesh.vertices, other.mesh.triangles),
                            other.motion);
      }
    }
    Random random = randomOf(frame);
    // Sometimes a small step: hybrid updates then do less.
    const double drawn = randomTime(random);
    time = frame % 4 == 2 ? time + 0.004 : drawn;
    for (Subject& s : subjects) {
      ASSERT_EQ(s.deformable.update(time), UpdateStatus::kUpdated) << c->name;
      prepare(s.scratch, *s.deformable.snapshot());
    }
    for (Deformable& other : moving)
      ASSERT_EQ(other.update(randomTime(random)), UpdateStatus::kUpdated);

    // All strategies hold the motion's vertices bit for bit.
    std::vector<Vector3d> positions(mesh->rest().size());
    c->motion->evaluate(time, positions);
    for (const Subject& s : subjects) {
      const std::span<const Vector3d> has = s.deformable.snapshot()->vertices();
      ASSERT_TRUE(std::equal(has.begin(), has.end(), positions.begin(), positions.end()))
          << c->name << " " << s.choice.name() << " frame " << frame;
    }

    Pieces pieces(Shape::deformable(subjects[0].deformable.snapshot()));
    for (int query = 0; query < kQueriesAFrame; ++query) {
      Pieces other(randomOpponent(random, moving));
      const Pose X_WA{random.rotation(), motion_cases::randomVector(random, 1)};
      Pose X_WB{random.rotation(),
                X_WA * Vector3d(0, 0, 0.5) +
                    motion_cases::randomVector(random, random.chance(0.5) ? 0.4 : 1.5)};
      Scratch& scratch = subjects[0].scratch;
      Truth truth = truthOf(pieces, X_WA, other, X_WB, scratch);
      if (truth.apart && random.chance(0.3)) {
        const DistanceResult r =
            distance(pieces.shape(), X_WA, other.shape(), X_WB, {}, scratch, nullptr);
        constexpr double kGaps[] = {1e-2, 1e-4, 1e-6, 1e-9, 0, -1e-9, -1e-6, -1e-3};
        graze(truth, r, kGaps[random.below(8)], X_WB);
        truth = truthOf(pieces, X_WA, other, X_WB, scratch);
        ++tally.near;
      }
      const DistanceRequest request = randomRequest(random, truth);
      const bool swapped = random.chance(0.3), warm = random.chance(0.5);
      const bool look_at_depth = request.depth && random.chance(0.1);
      for (Subject& s : subjects) {
        const Shape shape = Shape::deformable(s.deformable.snapshot());
        PairCache* cache = warm && !swapped ? &s.cache : nullptr;
        const DistanceResult r =
            swapped ? distance(other.shape(), X_WB, shape, X_WA, request, s.scratch, cache)
                    : distance(shape, X_WA, other.shape(), X_WB, request, s.scratch, cache);
        std::string what = fault(truth, request, r, tally);
        if (what.empty() && look_at_depth && truth.overlap && std::isnan(request.threshold)) {
          Random directions = random;
          what = swapped ? depthFault(other, X_WB, pieces, X_WA, r, directions, scratch)
                         : depthFault(pieces, X_WA, other, X_WB, r, directions, scratch);
        }
        if (what.empty()) continue;
        if (++faults_ > 5) break;
        ADD_FAILURE() << what << ": " << c->name << ", " << s.choice.name() << ", against "
                      << toString(other.shape().type()) << (swapped ? ", swapped" : "")
                      << (cache != nullptr ? ", warm" : "") << std::setprecision(17)
                      << "\n brute force [" << truth.separation.lower << ", "
                      << truth.separation.upper << "]"
                      << (truth.overlap ? " overlap"
                          : truth.apart ? " apart"
                                        : " touching")
                      << ", answer [" << r.distance.lower << ", " << r.distance.upper << "] status "
                      << int(r.status) << ", threshold " << request.threshold << ", tolerance "
                      << request.tolerance << ", depth " << request.depth << "\n seed " << seed_
                      << " motion " << GetParam() << " frame " << frame << " (time " << time
                      << ") query " << query << "\n X_WA " << oracle::replay(X_WA) << "\n X_WB "
                      << oracle::replay(X_WB);
      }
    }
  }
  if (faults_ > 0 || !c) return;
  EXPECT_EQ(tally.unsafe, 0);
  // Guards the comparison: overlaps and separations both occur.
  EXPECT_GT(tally.overlaps * 20, tally.answers) << c->name;
  EXPECT_GT(tally.apart * 5, tally.answers) << c->name;
  EXPECT_GT(tally.near * 10, tally.answers / static_cast<std::int64_t>(subjects.size()));
  std::printf("%-26s %zu strategies, %lld answers (%lld overlaps, %lld apart), 0 differences\n",
              c->name.c_str(), subjects.size(), static_cast<long long>(tally.answers),
              static_cast<long long>(tally.overlaps), static_cast<long long>(tally.apart));
}

bool shareVertex(const motion_cases::Triangle& a, const motion_cases::Triangle& b) {
  return std::any_of(a.begin(), a.end(),
                     [&](std::int32_t v) { return std::find(b.begin(), b.end(), v) != b.end(); });
}

Interval bruteSelf(Pieces& pieces, std::span<const motion_cases::Triangle> triangles,
                   Scratch& scratch) {
  Interval all{kInfinity, kInfinity};
  for (const bool exact : {false, true}) {  // first the pairs that balls decide well
    for (std::size_t i = 0; i < pieces.count(); ++i) {
      for (std::size_t j = i + 1; j < pieces.count(); ++j) {
        const double centers = (pieces.center(i) - pieces.center(j)).norm();
        const double reach = pieces.radius(i) + pieces.radius(j);
        if (centers - reach - 1e-9 > all.upper) continue;
        if (shareVertex(triangles[i], triangles[j])) continue;
        if (!exact) {
          all.upper = std::min(all.upper, centers);  // centres are points of the triangles
          continue;
        }
        const Interval d = distance(pieces.piece(i), {}, pieces.piece(j), {}, {}, scratch).distance;
        all.lower = std::min(all.lower, d.lower);
        all.upper = std::min(all.upper, d.upper);
      }
    }
  }
  return all;
}

TEST_P(Conformance, SelfDistanceIsBruteForces) {
  // Brute force over all pairs is slower: fewer frames.
  const std::uint64_t frames = std::max<std::uint64_t>(queries_ / 24, 2);
  Tally tally;
  for (std::uint64_t frame = 0; frame < frames && faults_ < 5; ++frame) {
    Random random = randomOf(frame + (std::uint64_t{1} << 40));
    const int size = 4 + random.below(5);
    std::vector<MotionCase> cases = motion_cases::allMotions(size, random.bits());
    const MotionCase& c = cases[static_cast<std::size_t>(GetParam())];
    const auto mesh = DeformableMesh::make(c.mesh.vertices, c.mesh.triangles);
    std::vector<Subject> subjects = subjectsOf(c, mesh);
    for (int step = 0; step < 3; ++step) {
      const double time = randomTime(random);
      for (Subject& s : subjects) {
        ASSERT_EQ(s.deformable.update(time), UpdateStatus::kUpdated);
        prepare(s.scratch, *s.deformable.snapshot());
      }
      Pieces pieces(Shape::deformable(subjects[0].deformable.snapshot()));
      const Interval brute = bruteSelf(pieces, mesh->triangles(), subjects[0].scratch);
      DistanceRequest request;
      const int kind = random.below(3);
      if (kind == 0) request.threshold = 0;
      if (kind == 1) request.threshold = brute.upper * random.uniform(0, 2);
      for (Subject& s : subjects) {
        const DistanceResult r =
            selfDistance(*s.deformable.snapshot(), request, s.scratch, &s.cache);
        Truth truth{brute, brute.upper <= 0, brute.lower > 0};
        // Intersecting triangles have no depth: any lower end <= 0 is right.
        if (truth.overlap) truth.separation = {-kInfinity, 0};
        const std::string what = fault(truth, request, r, tally);
        if (what.empty()) continue;
        if (++faults_ > 5) break;
        ADD_FAILURE() << what << ": self, " << c.name << ", " << s.choice.name()
                      << std::setprecision(17) << "\n brute force [" << brute.lower << ", "
                      << brute.upper << "], answer [" << r.distance.lower << ", "
                      << r.distance.upper << "] status " << int(r.status) << ", threshold "
                      << request.threshold << "\n seed " << seed_ << " motion " << GetParam()
                      << " frame " << frame << " step " << step << " time " << time << " size "
                      << size;
      }
    }
  }
  EXPECT_EQ(tally.unsafe, 0);
  EXPECT_GT(tally.answers, 0);
}

INSTANTIATE_TEST_SUITE_P(Motions, Conformance, ::testing::Range(0, 11));

}  // namespace
}  // namespace leeway::collision
