#include "tools/report/motion/motion_cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <stdexcept>

#include "leeway/robots/link_motion.h"
#include "leeway/robots/model.h"
#include "tools/report/motion/motion_truth.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::tools::report {
namespace {

using collision::MovingTriangle;
using collision::Pose;
using collision::Shape;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using oracle::Random;

constexpr double kPi = 3.14159265358979323846;
/// Clearance or depth of grazing motions [m].
constexpr double kGrazing = 1e-4;

/// A shape in the engine's and the truth's form.
struct Body {
  const ReportShape* shape = nullptr;
  const SlowPolytope* slow = nullptr;
};

/// From `start`, the origin moves straight while the body turns about a fixed world axis.
struct Move {
  Pose start;
  Vector3d travel = Vector3d::Zero(), axis = Vector3d::UnitZ();  // [m], unit
  double angle = 0;                                              // [rad], up to half a turn

  Pose at(double t) const {
    return {slowTurn(axis, t * angle) * start.rotation, start.translation + t * travel};
  }
};

/// Three uniform numbers, drawn in order.
Vector3d sizes(Random& random, double least, double most) {
  const double x = random.uniform(least, most), y = random.uniform(least, most);
  return {x, y, random.uniform(least, most)};
}

/// Random direction and length.
Vector3d vector(Random& random, double least, double most) {
  const double length = random.uniform(least, most);
  return length * random.direction();
}

Pose placed(const Vector3d& p, const Matrix3d& R = Matrix3d::Identity()) { return {R, p}; }

/// Builds one family.
class Maker {
 public:
  Maker(const std::string& name, std::uint64_t seed) : random(seed) { family.name = name; }

  Random random;
  ContactFamily family;

  Body box(const Vector3d& half) { return add({Shape::box(half), {}}, slowBox(half)); }
  Body boxMesh(const Vector3d& half) {
    return add({Shape::mesh(oracle::boxMesh(half)), {}}, slowBox(half));
  }
  /// Eight points on an ellipsoid.
  Body hull() {
    std::vector<Vector3d> points(8);
    const Vector3d size = sizes(random, 0.1, 0.5);
    for (Vector3d& p : points) p = size.cwiseProduct(random.direction());
    return add({Shape::convexHull(points), points}, slowHull(points));
  }
  Body box(double least, double most) { return box(sizes(random, least, most)); }

  /// What the construction already guarantees.
  enum class Known { kNothing, kApartAtStart, kFree };

  /// Adds the pair if its truth is clear and, where required, it starts apart. A random change of
  /// frame breaks alignment with the axes.
  void keep(const Body& a, Move move_a, const Body& b, Move move_b, Known known = Known::kNothing) {
    Pose X_WF = placed(sizes(random, -1, 1));
    X_WF.rotation = random.rotation();
    ContactCase c;
    std::array<SlowBody, 2> slow;
    const std::array<std::pair<Body, Move*>, 2> both = {{{a, &move_a}, {b, &move_b}}};
    for (std::size_t i = 0; i < 2; ++i) {
      Move& m = *both[i].second;
      m.start = X_WF * m.start;
      m.travel = X_WF.rotation * m.travel;
      m.axis = (X_WF.rotation * m.axis).normalized();
      const bool still = m.angle == 0 && m.travel.isZero(0);
      std::shared_ptr<const collision::RigidMotion> motion;
      if (still)
        motion = std::make_shared<collision::Still>(m.start);
      else
        motion = std::make_shared<collision::StraightMotion>(m.start, m.at(1));
      c.spec.bodies.push_back({both[i].first.shape, motion, true});
      slow[i] = {both[i].first.slow, [m](double t) { return m.at(t); },
                 m.travel.norm() + std::abs(m.angle) * both[i].first.slow->reach};
    }
    c.spec.pairs = {{0, 1}};
    TimeTruth truth{false, 1, 1, true};
    if (known != Known::kFree) truth = slowFirstContact(slow, c.spec.pairs, 0);
    if (known == Known::kApartAtStart && truth.contact && truth.upper == 0) return;
    keep(std::move(c), truth);
  }

  void keep(ContactCase c, const TimeTruth& truth) {
    if (!truth.clear) return;
    c.contact = truth.contact, c.lower = truth.lower, c.upper = truth.upper;
    family.cases.push_back(std::move(c));
  }

  /// Reuses one of up to 64 bodies: for shapes that are expensive to make.
  Body pooled(const std::function<Body(Maker&)>& make) {
    if (pool_.size() < 64) {
      pool_.push_back(make(*this));
      return pool_.back();
    }
    return pool_[static_cast<std::size_t>(random.below(64))];
  }

 private:
  Body add(ReportShape shape, SlowPolytope polytope) {
    family.shapes.push_back(std::make_unique<ReportShape>(std::move(shape)));
    slow_.push_back(std::move(polytope));
    return {family.shapes.back().get(), &slow_.back()};
  }

  std::deque<SlowPolytope> slow_;
  std::vector<Body> pool_;
};

/// Two bodies that pass each other, or collide.
void passing(Maker& make, const Body& a, const Body& b, double most_turn) {
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
  make.keep(a, move_a, b, move(aside), Maker::Known::kApartAtStart);
}

/// A box passes over another and penetrates it by `depth`, turning about the vertical. depth < 0:
/// free by construction.
void grazing(Maker& make, double depth) {
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
  make.keep(a, over, b, {}, depth < 0 ? Maker::Known::kFree : Maker::Known::kNothing);
}

/// Nearly parallel plates slide along each other and approach slightly.
void nearParallel(Maker& make) {
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

/// Rods that turn by up to half a turn beside a body.
void fastTurn(Maker& make) {
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
void thinPlate(Maker& make) {
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
void starting(Maker& make) {
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
void tangentialTurn(Maker& make) {
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
  make.keep(a, turn, b, wall, gap > 0 ? Maker::Known::kFree : Maker::Known::kNothing);
}

/// Seven links among five boxes.
class Chain {
 public:
  static constexpr std::size_t kLinks = 7, kBoxes = 5;

  Chain() {
    robots::RobotDescription robot;
    robot.name = "chain";
    for (std::size_t i = 0; i <= kLinks; ++i) {
      robots::Joint joint;
      joint.name = "joint" + std::to_string(i);
      joint.parent_link = static_cast<int>(i) - 1;
      joint.child_link = static_cast<int>(i);
      if (i > 0) {
        joint.type = robots::JointType::kContinuous;
        joint.X_PJ.translation = Vector3d(0, 0, i == 1 ? 0 : kLength);
        joint.axis = axis(i - 1);
        joint.first_variable = static_cast<int>(i) - 1;
        joint.variable_count = 1;
        robot.variables.push_back({joint.name, static_cast<int>(i), -HUGE_VAL, HUGE_VAL, HUGE_VAL});
      }
      robots::Link link;
      link.name = "link" + std::to_string(i);
      link.joint = static_cast<int>(i);
      robot.joints.push_back(joint);
      robot.links.push_back(link);
    }
    model_ = std::make_shared<const robots::Model>(std::move(robot));
  }

  void add(Maker& make) {
    if (link_.shape == nullptr) link_ = make.box({0.05, 0.05, kLength / 2 - 0.02});
    Random& r = make.random;
    std::vector<double> q(kLinks), dq(kLinks);
    for (std::size_t i = 0; i < kLinks; ++i) {
      q[i] = r.uniform(-1.5, 1.5);
      dq[i] = r.uniform(-0.8, 0.8);
    }
    ContactCase c;
    std::vector<SlowBody> slow;
    for (std::size_t i = 0; i < kLinks; ++i) {
      c.spec.bodies.push_back({link_.shape,
                               std::make_shared<Mounted>(std::make_shared<robots::LinkMotion>(
                                   model_, static_cast<int>(i) + 1, q, dq)),
                               false});
      double speed = 0;
      for (std::size_t k = 0; k <= i; ++k)
        speed += std::abs(dq[k]) * kLength * static_cast<double>(i - k + 2);
      slow.push_back({link_.slow, [=](double t) { return pose(q, dq, i, t); }, speed});
    }
    for (std::size_t i = 0; i < kBoxes; ++i) {
      const Body box = make.box(0.05, 0.2);
      Pose X = placed(vector(r, 0.5, 1.4));
      X.rotation = r.rotation();
      c.spec.bodies.push_back({box.shape, std::make_shared<collision::Still>(X), true});
      slow.push_back({box.slow, [X](double) { return X; }, 0});
      for (std::size_t k = 0; k < kLinks; ++k) c.spec.pairs.push_back({k, kLinks + i});
    }
    const TimeTruth truth = slowFirstContact(slow, c.spec.pairs, 0);
    // Contact at the start has a family of its own.
    if (truth.contact && truth.upper == 0) return;
    make.keep(std::move(c), truth);
  }

 private:
  static constexpr double kLength = 0.2;  // [m]

  static Vector3d axis(std::size_t joint) {
    return joint % 2 == 0 ? Vector3d::UnitZ() : Vector3d::UnitY();
  }

  /// Middle of a link's box, computed here: independent of robots::.
  static Pose pose(const std::vector<double>& q, const std::vector<double>& dq, std::size_t link,
                   double t) {
    Pose X;
    for (std::size_t i = 0; i <= link; ++i)
      X = X * placed({0, 0, i == 0 ? 0 : kLength}, slowTurn(axis(i), q[i] + t * dq[i]));
    return X * placed({0, 0, kLength / 2});
  }

  /// The box's frame on a link.
  class Mounted final : public collision::RigidMotion {
   public:
    explicit Mounted(std::shared_ptr<const RigidMotion> link)
        : link_(std::move(link)), mounted_(*link_, X_LB_) {}
    Pose pose(double t) const override { return mounted_.pose(t); }
    collision::FrameVelocity velocity(double t) const override { return mounted_.velocity(t); }
    collision::FrameMotionBound bound(double t0, double t1) const override {
      return mounted_.bound(t0, t1);
    }
    double rounding(double reach) const override { return mounted_.rounding(reach); }

   private:
    std::shared_ptr<const RigidMotion> link_;
    Pose X_LB_ = placed({0, 0, kLength / 2});
    collision::MountedMotion mounted_;
  };

  std::shared_ptr<const robots::Model> model_;
  Body link_;
};

void keepTriangles(Maker& make, const MovingTriangle& a, const MovingTriangle& b, double margin) {
  ContactCase c;
  c.spec.triangles = {a, b};
  c.spec.margin = margin;
  make.keep(std::move(c), slowFirstContact(a, b, margin));
}

/// Each corner moves on its own straight line.
void triangles(Maker& make) {
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

/// Coplanar throughout: only edges and corners sliding along it meet. Point contacts cannot be
/// proven under rounding, so contact is 1e-9 m.
void coplanar(Maker& make) {
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

using Recipe = std::function<void(Maker&)>;

std::vector<std::pair<std::string, Recipe>> recipes() {
  const auto chain = std::make_shared<Chain>();
  const auto boxes = [](double turn) {
    return [turn](Maker& m) {
      const Body a = m.box(0.05, 0.5), b = m.box(0.05, 0.5);
      passing(m, a, b, turn);
    };
  };
  const auto pooled = [](const std::function<Body(Maker&)>& make) {
    return [make](Maker& m) {
      const Body a = m.pooled(make), b = m.pooled(make);
      passing(m, a, b, 1.5);
    };
  };
  return {{"ordinary", boxes(1.5)},
          {"translation", boxes(0)},
          {"hulls", pooled([](Maker& m) { return m.hull(); })},
          {"grazing hits", [](Maker& m) { grazing(m, kGrazing); }},
          {"grazing frees", [](Maker& m) { grazing(m, -kGrazing); }},
          {"near-parallel", nearParallel},
          {"fast rotation", fastTurn},
          {"thin plates", thinPlate},
          {"start in contact", starting},
          {"tangential rotation", tangentialTurn},
          {"articulated", [chain](Maker& m) { chain->add(m); }},
          {"meshes", pooled([](Maker& m) { return m.boxMesh(sizes(m.random, 0.05, 0.5)); })},
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
    Maker make(name, mixed);
    while (static_cast<int>(make.family.cases.size()) < count) recipe(make);
    return std::move(make.family);
  }
  throw std::invalid_argument("no family '" + name + "'");
}

}  // namespace leeway::tools::report
