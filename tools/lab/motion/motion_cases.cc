#include "tools/lab/motion/motion_cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "tools/lab/motion/arm_among_boxes.h"
#include "tools/lab/motion/family_maker.h"

namespace leeway::tools::report {
namespace {

using namespace motion_families;
using collision::MovingTriangle;

constexpr double kPi = 3.14159265358979323846;
/// Clearance or depth of grazing motions [m].
constexpr double kGrazing = 1e-4;

/// Two bodies that pass each other, or collide.
void passing(FamilyMaker& make, const Body& a, const Body& b, double most_turn) {
  Random& r = make.random;
  const auto move = [&](const Vector3d& meeting) {
    Move m;
    m.travel = vector(r, 0.2, 2);
    m.start = placed(meeting - r.uniform(0.2, 0.8) * m.travel);
    m.start.rotation = r.rotation();
    m.axis = r.direction();
    m.angle = r.uniform(0, most_turn);
    return m;
  };
  const Move move_a = move(Vector3d::Zero());
  const Vector3d aside = vector(r, 0, 1);
  make.keep(a, move_a, b, move(aside), FamilyMaker::Known::kApartAtStart);
}

/// A box passes over another one and penetrates it by `depth`, turning about the vertical. With
/// depth < 0 it is free by construction.
void grazing(FamilyMaker& make, double depth) {
  Random& r = make.random;
  const Vector3d low = sizes(r, 0.1, 0.4), high = sizes(r, 0.1, 0.4);
  const double away = r.uniform(0.8, 2), heading = r.uniform(0, 2 * kPi);
  const double side = r.uniform(-0.1, 0.1), yaw = r.uniform(0, 2 * kPi);
  const Vector3d along(std::cos(heading), std::sin(heading), 0);
  const Vector3d across(-along.y(), along.x(), 0);
  Move over;
  over.start = placed(-away * along + side * across + Vector3d(0, 0, low.z() + high.z() - depth),
                      slowTurn(Vector3d::UnitZ(), yaw));
  over.travel = 2 * away * along;
  over.angle = r.chance(0.5) ? 0 : r.uniform(-3, 3);
  const Body a = make.box(high), b = make.box(low);
  make.keep(a, over, b, {}, depth < 0 ? FamilyMaker::Known::kFree : FamilyMaker::Known::kNothing);
}

/// Nearly parallel plates slide along each other and approach slightly.
void nearParallel(FamilyMaker& make) {
  Random& r = make.random;
  Vector3d low = sizes(r, 0.5, 1), high = sizes(r, 0.1, 0.4);
  low.z() *= 0.1, high.z() *= 0.1;
  const double gap = r.logUniform(1e-3, 1e-1);
  Move slide;
  const double tilt = std::min(r.logUniform(1e-7, 1e-2), gap / 2);
  const double towards = r.uniform(0, 2 * kPi), yaw = r.uniform(0, 2 * kPi);
  const Vector3d start = sizes(r, -0.5, 0), travel = sizes(r, 0.2, 0.6);
  slide.start = placed(
      {start.x(), start.y(), low.z() + high.z() + gap},
      slowTurn({std::cos(towards), std::sin(towards), 0}, tilt) * slowTurn(Vector3d::UnitZ(), yaw));
  slide.travel = {travel.x(), travel.y(), -gap * r.uniform(0.5, 1.5)};
  slide.angle = r.chance(0.5) ? 0 : r.uniform(-0.5, 0.5);
  const Body a = make.box(high), b = make.box(low);
  make.keep(a, slide, b, {});
}

/// Rods that turn by up to half a turn next to a body.
void fastTurn(FamilyMaker& make) {
  Random& r = make.random;
  Move turn;
  turn.start = placed({0, 0, 0}, r.rotation());
  turn.travel = vector(r, 0, 0.2);
  turn.axis = r.direction();
  turn.angle = r.uniform(2, 3.1);
  Move other;
  other.start = placed(vector(r, 0.2, 1.1));
  other.start.rotation = r.rotation();
  other.travel = vector(r, 0, 0.1);
  const Body a = make.box({0.01, 0.01, r.uniform(0.5, 1)}), b = make.box(0.02, 0.1);
  make.keep(a, turn, b, other);
}

/// Small bodies shot through, or past, large plates of almost no thickness.
void thinPlate(FamilyMaker& make) {
  Random& r = make.random;
  Move shot;
  Vector3d hole = sizes(r, -1.2, 1.2);
  hole.z() = 0;
  shot.travel = vector(r, 1, 10);
  shot.start = placed(hole - r.uniform(0.1, 0.9) * shot.travel);
  shot.start.rotation = r.rotation();
  shot.axis = r.direction();
  shot.angle = r.uniform(0, 3);
  const Body a = make.box(0.01, 0.1), b = make.box({1, 1, r.logUniform(1e-7, 1e-3)});
  make.keep(a, shot, b, {});
}

/// In contact at 0, then separating.
void starting(FamilyMaker& make) {
  Random& r = make.random;
  const Vector3d low = sizes(r, 0.1, 0.4), high = sizes(r, 0.1, 0.4);
  Move away;
  Vector3d start = sizes(r, -0.1, 0.1);
  start.z() = low.z() + high.z() - r.logUniform(1e-4, 0.19);
  away.start = placed(start, slowTurn(Vector3d::UnitZ(), r.uniform(0, 2 * kPi)));
  away.travel = sizes(r, -0.5, 0.5) + Vector3d(0, 0, 1);
  away.axis = r.direction();
  away.angle = r.uniform(0, 1.5);
  const Body a = make.box(high), b = make.box(low);
  make.keep(a, away, b, {});
}

/// A corner on a circle that just reaches a wall, or just misses it.
void tangentialTurn(FamilyMaker& make) {
  Random& r = make.random;
  const Vector3d half = sizes(r, 0.1, 0.4);
  const double reach = std::hypot(half.x(), half.y());
  const double corner = std::atan2(half.y(), half.x());
  Move turn;
  turn.angle = r.uniform(1, 3);
  // The corner points at the wall at some time on the way.
  turn.start =
      placed({0, 0, 0}, slowTurn(Vector3d::UnitZ(), -corner - turn.angle * r.uniform(0.2, 0.8)));
  Move wall;
  const double gap = r.chance(0.5) ? kGrazing : -kGrazing;
  wall.start = placed({reach + 0.5 + gap, 0, 0});
  const Body a = make.box(half), b = make.box({0.5, 1, 1});
  make.keep(a, turn, b, wall, gap > 0 ? FamilyMaker::Known::kFree : FamilyMaker::Known::kNothing);
}
void keepTriangles(FamilyMaker& make, const MovingTriangle& a, const MovingTriangle& b,
                   double margin) {
  ContactCase c;
  c.spec.triangles = {a, b};
  c.spec.margin = margin;
  make.keep(std::move(c), slowFirstContact(a, b, margin));
}

/// Each corner moves on its own straight line.
void triangles(FamilyMaker& make) {
  Random& r = make.random;
  const auto around = [&](const Vector3d& p) {
    std::array<Vector3d, 3> corners;
    for (Vector3d& corner : corners) corner = p + 0.3 * r.direction();
    return corners;
  };
  const Vector3d aside = sizes(r, -0.4, 0.4), up(0, 0.4, 0);
  const MovingTriangle a{around({-1, 0, 0}), around({1, 0, 0})};
  const MovingTriangle b{around(aside + up), around(aside - up)};
  keepTriangles(make, a, b, 0);
}

/// Coplanar at all times: only edges and corners that slide along the plane meet. Point contacts
/// cannot be proven under rounding, so contact is 1e-9 m.
void coplanar(FamilyMaker& make) {
  Random& r = make.random;
  const double height = r.below(9) / 4.0 - 1;
  const auto around = [&](double x, double y) {
    std::array<Vector3d, 3> p;
    const double turn = r.uniform(0, 2 * kPi);
    for (std::size_t i = 0; i < 3; ++i) {
      const double angle = turn + 2 * kPi / 3 * static_cast<double>(i) + r.uniform(-0.5, 0.5);
      p[i] = {x + 0.3 * std::cos(angle), y + 0.3 * std::sin(angle), height};
    }
    return p;
  };
  const double aside = r.uniform(-0.7, 0.7);
  const MovingTriangle a{around(-1, 0), around(1, 0)}, b{around(0, aside), around(0, aside)};
  keepTriangles(make, a, b, 1e-9);
}

/// Equal L-shaped solids side by side, one of which moves along a side of the other. All faces
/// along its way are flush, and no triangle crosses another one when they meet.
void flush(FamilyMaker& make) {
  Random& r = make.random;
  const double size = r.uniform(0.2, 1);
  const ReportShape* ell = make.known(Shape::mesh(oracle::ellMesh(size)));
  const int axis = r.below(3);
  // (The L's height is two thirds of its size.)
  const double width = axis == 2 ? size / 3 + size / 3 : size, before = r.uniform(0.1, 1) * size,
               beyond = r.uniform(0.1, 1) * size;
  const Vector3d along = r.below(2) == 0 ? Vector3d::Unit(axis) : Vector3d(-Vector3d::Unit(axis));
  const Pose X_WF{r.rotation(), sizes(r, -1, 1)};
  const auto at = [&](double way) { return Pose{X_WF.rotation, X_WF * (way * along)}; };
  ContactCase c;
  c.spec.bodies = {
      {ell, std::make_shared<collision::StraightMotion>(at(-width - before), at(beyond - width))},
      {ell, std::make_shared<collision::Still>(X_WF)}};
  c.spec.pairs = {{0, 1}};
  const double t = before / (before + beyond);
  make.keep(std::move(c), {true, t - 1e-12, t + 1e-12, true});
}

using Recipe = std::function<void(FamilyMaker&)>;

std::vector<std::pair<std::string, Recipe>> recipes() {
  const auto chain = std::make_shared<ArmAmongBoxes>();
  const auto boxes = [](double turn) {
    return [turn](FamilyMaker& m) {
      const Body a = m.box(0.05, 0.5), b = m.box(0.05, 0.5);
      passing(m, a, b, turn);
    };
  };
  const auto pooled = [](const std::function<Body(FamilyMaker&)>& make) {
    return [make](FamilyMaker& m) {
      const Body a = m.pooled(make), b = m.pooled(make);
      passing(m, a, b, 1.5);
    };
  };
  return {{"ordinary", boxes(1.5)},
          {"translation", boxes(0)},
          {"hulls", pooled([](FamilyMaker& m) { return m.hull(); })},
          {"grazing hits", [](FamilyMaker& m) { grazing(m, kGrazing); }},
          {"grazing frees", [](FamilyMaker& m) { grazing(m, -kGrazing); }},
          {"near-parallel", nearParallel},
          {"fast rotation", fastTurn},
          {"thin plates", thinPlate},
          {"start in contact", starting},
          {"tangential rotation", tangentialTurn},
          {"articulated", [chain](FamilyMaker& m) { chain->add(m); }},
          {"meshes", pooled([](FamilyMaker& m) { return m.boxMesh(sizes(m.random, 0.05, 0.5)); })},
          {"flush meshes", flush},
          {"triangles", triangles},
          {"coplanar sliding", coplanar}};
}

}  // namespace

const std::vector<std::string>& contactFamilies() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const auto& [name, recipe] : recipes()) result.push_back(name);
    return result;
  }();
  return names;
}

ContactFamily makeContactFamily(const std::string& name, int count, std::uint64_t seed) {
  for (const auto& [known, recipe] : recipes()) {
    if (known != name) continue;
    std::uint64_t mixed = seed;
    for (const char letter : name)
      mixed = mixed * 1099511628211u + static_cast<unsigned char>(letter);
    FamilyMaker make(name, mixed);
    while (static_cast<int>(make.family.cases.size()) < count) recipe(make);
    return std::move(make.family);
  }
  throw std::invalid_argument("no family '" + name + "'");
}

}  // namespace leeway::tools::report
