#include "leeway/collision/separation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/convex/gjk/support.h"
#include "collision/distance/cone_direction.h"
#include "collision/distance/nearest_in_half_spaces.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

constexpr int kPlanes = 8;  // planes of a choice; its point is on at most three of them

// Support of a shape (for a mesh its hull, for a deforming mesh its bounding ball) along a unit
// direction; infinite if the shape is unbounded.
double supportOf(const PlacedShape& s, const Vector& direction) {
  const Vector d = rotatedBack(s.X_WS.rotation, direction);
  const double origin = direction.dot(s.X_WS.translation);
  if (s.shape->type() == ShapeType::kHalfSpace) return d.z() > kAlongHalfSpace ? origin : kInfinity;
  if (s.shape->type() == ShapeType::kDeformable) {
    return origin + d.dot(s.shape->boundingCenter()) + s.shape->boundingRadius();
  }
  const ConvexView view =
      s.shape->isConvex() ? viewOf(*s.shape) : s.shape->mesh()->tree().hullView();
  int hint = 0;
  return origin + d.dot(farthest(view, d, hint)) + view.radius + view.excess;
}

struct Plane {
  PlaneHalfSpace space;
  Vector point;   // nearest to the origin among all planes of the choice and this one
  double length;  // of `point`
};

class BodyTranslationSearch {
 public:
  BodyTranslationSearch(std::span<const PlacedShape> body, std::span<const PlacedShape> obstacles,
                        const SeparationRequest& request, Scratch& scratch)
      : body_(body), obstacles_(obstacles), request_(request), scratch_(scratch) {
    query_.threshold = request.clearance;
    query_.tolerance = std::min(kDefaultTolerance, request.tolerance);
    query_.iteration_limit = request.iteration_limit;
    query_.node_limit = request.node_limit;
    // Planes are moved out by half the tolerance, so that translations stay beyond them in spite of
    // rounding.
    margin_ = 0.5 * request.tolerance;
  }

  SeparationResult run() {
    Pair pair;
    DistanceResult found;
    const State state = deepest(Vector::Zero(), pair, found);
    if (invalid_) return {};
    if (state == State::kFree) {
      result_.status = SeparationStatus::kApart;
      result_.clearance = clearanceAt(Vector::Zero());
      result_.queries = queries_;
      return result_;
    }
    length_ = request_.longest * (1 + 8 * kUnitRoundoff);
    if (result_.least <= request_.longest) {
      std::array<PlaneHalfSpace, kPlanes> none;
      branch(none, 0, Vector::Zero());
      if (concave()) march();
      if (result_.status == SeparationStatus::kSeparated) turn();
    }
    if (result_.status == SeparationStatus::kSeparated) {
      result_.clearance = clearanceAt(result_.translation);
    } else {
      result_.status = SeparationStatus::kNotFound;
    }
    result_.queries = queries_;
    return result_;
  }

 private:
  struct Pair {
    std::size_t obstacle = 0, part = 0;
  };
  enum class State : unsigned char { kFree, kBlocked, kUnknown };

  bool exhausted() const { return queries_ >= request_.query_limit; }

  bool concave() const {
    const auto isMesh = [](const PlacedShape& s) { return !s.shape->isConvex(); };
    return std::any_of(body_.begin(), body_.end(), isMesh) ||
           std::any_of(obstacles_.begin(), obstacles_.end(), isMesh);
  }

  DistanceResult ask(const Pair& pair, const Vector& t, const DistanceRequest& request) {
    ++queries_;
    const PlacedShape &a = obstacles_[pair.obstacle], &b = body_[pair.part];
    Pose moved = b.X_WS;
    moved.translation += t;
    const DistanceResult r = distance(*a.shape, a.X_WS, *b.shape, moved, request, scratch_);
    invalid_ = invalid_ || r.status == DistanceStatus::kInvalid;
    return r;
  }

  template <typename Function>
  void forEachPair(const Function& function) {
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
      for (std::size_t k = 0; k < body_.size(); ++k) {
        if (!function(Pair{i, k})) return;
      }
    }
  }

  // The deepest pair, unless all pairs are farther apart than the clearance.
  State deepest(const Vector& t, Pair& worst, DistanceResult& found) {
    State state = State::kFree;
    DistanceRequest exact = query_;
    exact.threshold = std::numeric_limits<double>::quiet_NaN();
    DistanceRequest quick = query_;
    quick.depth = false;
    forEachPair([&](const Pair& pair) {
      if (exhausted()) {
        state = State::kUnknown;
        return false;
      }
      if (ask(pair, t, quick).distance.lower > request_.clearance) return true;
      const DistanceResult r = ask(pair, t, exact);
      // No shorter translation separates this pair.
      if (t.isZero(0)) {
        const double least = request_.clearance - r.distance.upper;
        result_.least = std::max(result_.least, least * (1 - 4 * kUnitRoundoff));
      }
      if (state == State::kBlocked && !(r.distance.lower < found.distance.lower)) return true;
      state = State::kBlocked;
      worst = pair;
      found = r;
      return true;
    });
    return state;
  }

  // Whether every pair is farther apart than the clearance. The pair that failed last time is tried
  // first.
  bool isFree(const Vector& t) {
    DistanceRequest quick = query_;
    quick.depth = false;
    quick.tolerance = 0;
    const auto blocked = [&](const Pair& pair) {
      return exhausted() || !(ask(pair, t, quick).distance.lower > request_.clearance);
    };
    if (blocked(blocking_)) return false;
    bool all = true;
    forEachPair([&](const Pair& pair) {
      if (!blocked(pair)) return true;
      blocking_ = pair;
      all = false;
      return false;
    });
    return all;
  }

  bool take(const Vector& t) {
    const double length = t.norm();
    if (!(length < length_) || length > request_.longest) return false;
    length_ = length;
    result_.translation = t;
    result_.status = SeparationStatus::kSeparated;
    return true;
  }

  bool isDone() const {
    return result_.status == SeparationStatus::kSeparated &&
           length_ - result_.least <= request_.tolerance;
  }

  // A length that separates in some direction, if the shapes are bounded.
  double farEnough() {
    double far = 0;
    forEachPair([&](const Pair& pair) {
      const PlacedShape &a = obstacles_[pair.obstacle], &b = body_[pair.part];
      const double way =
          (a.X_WS * a.shape->boundingCenter() - b.X_WS * b.shape->boundingCenter()).norm() +
          a.shape->boundingRadius() + b.shape->boundingRadius() + request_.clearance;
      if (way < kInfinity) far = std::max(far, way);
      return true;
    });
    return far;
  }

  // Translations that separate a pair along `normal`; at the translation t the pair is `lower`
  // apart.
  PlaneHalfSpace across(const Vector& normal, double lower, const Vector& t) const {
    return {normal, normal.dot(t) + request_.clearance - lower + margin_};
  }

  // Separation of the pair along n at t = 0; -infinity if a shape is unbounded.
  double separationAlong(const Pair& pair, const Vector& n) const {
    const PlacedShape &a = obstacles_[pair.obstacle], &b = body_[pair.part];
    return -supportOf(b, -n) - supportOf(a, n);
  }

  void offer(const Vector& normal, double offset, std::array<PlaneHalfSpace, kPlanes>& chosen,
             int count, std::array<Plane, 13>& planes, int& size) const {
    if (!std::isfinite(offset) || !normal.allFinite()) return;
    Plane plane{{normal, offset}, Vector::Zero(), 0};
    chosen[static_cast<std::size_t>(count)] = plane.space;
    if (!nearestInHalfSpaces(chosen.data(), count + 1, plane.point)) return;
    plane.length = plane.point.norm();
    if (plane.length >= length_) return;
    // Sorted by length; equal lengths keep their order.
    int at = size++;
    for (; at > 0 && planes[static_cast<std::size_t>(at - 1)].length > plane.length; --at) {
      planes[static_cast<std::size_t>(at)] = planes[static_cast<std::size_t>(at - 1)];
    }
    planes[static_cast<std::size_t>(at)] = plane;
  }

  void branch(std::array<PlaneHalfSpace, kPlanes>& chosen, int count, const Vector& t) {
    if (nodes_++ >= kSeparationChoices || isDone()) return;
    Pair pair;
    DistanceResult found;
    const State state = deepest(t, pair, found);
    if (state == State::kFree) take(t);
    if (state != State::kBlocked || count == kPlanes) return;
    std::array<Plane, 13> planes;
    int size = 0;
    const PlaneHalfSpace own = across(found.normal, found.distance.lower, t);
    offer(own.normal, own.offset, chosen, count, planes, size);
    for (const Pose* X : {&obstacles_[pair.obstacle].X_WS, &body_[pair.part].X_WS}) {
      for (int k = 0; k < 6; ++k) {
        const Vector axis = (k % 2 == 0 ? 1.0 : -1.0) * X->rotation.col(k / 2);
        const PlaneHalfSpace space = across(axis, separationAlong(pair, axis), Vector::Zero());
        offer(space.normal, space.offset, chosen, count, planes, size);
      }
    }
    for (int i = 0; i < size; ++i) {
      const Plane& plane = planes[static_cast<std::size_t>(i)];
      if (plane.length >= length_) return;
      chosen[static_cast<std::size_t>(count)] = plane.space;
      branch(chosen, count + 1, plane.point);
    }
  }

  // Planes do not lead out of concavities, so this marches along 26 directions.
  void march() {
    const double far = std::min(length_, farEnough());
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (x == 0 && y == 0 && z == 0) continue;
          if (exhausted() || isDone()) return;
          const Vector direction = Vector(x, y, z).normalized();
          const double step = std::min(far, length_) / kSeparationRaySteps;
          for (double s = result_.least + margin_; s < std::min(2 * far, length_) && !exhausted();
               s += step) {
            if (isFree(s * direction)) {
              take(s * direction);
              shorten(std::max(result_.least, s - step));
              break;
            }
          }
        }
      }
    }
  }

  // Bisects between a length that is too short and the best one.
  void shorten(double too_short) {
    while (length_ - too_short > request_.tolerance && !exhausted()) {
      const double middle = 0.5 * (too_short + length_);
      const Vector t = (middle / length_) * result_.translation;
      if (middle >= length_ || middle <= too_short) return;
      if (!isFree(t) || !take(t)) too_short = middle;
    }
  }

  // Turns the translation by smaller and smaller angles as long as that shortens it.
  void turn() {
    tryShorter();
    for (double angle = 0.6; angle > kSeparationLeastTurn; angle *= 0.5) {
      for (int round = 0; round < 8; ++round) {
        if (isDone() || exhausted()) return;
        const Vector axis = result_.translation / length_;
        bool better = false;
        for (int k = 0; k < 8 && !better; ++k) {
          const Vector other = coneDirection(axis, angle, k, 8);
          const double trial = length_ - std::max(request_.tolerance, 0.02 * angle * length_);
          if (!(trial > result_.least) || !isFree(trial * other)) continue;
          better = take(trial * other);
          tryShorter();
        }
        if (!better) break;
      }
    }
  }

  void tryShorter() {
    const double trial = length_ - request_.tolerance;
    if (!(trial > result_.least) || isDone()) return;
    const Vector t = (trial / length_) * result_.translation;
    if (isFree(t) && take(t)) shorten(result_.least);
  }

  // The proven least distance at a translation that was found free.
  double clearanceAt(const Vector& t) {
    DistanceRequest exact = query_, quick = query_;
    exact.threshold = std::numeric_limits<double>::quiet_NaN();
    quick.tolerance = 0;
    exact.depth = quick.depth = false;
    double least = kInfinity;
    forEachPair([&](const Pair& pair) {
      double lower = ask(pair, t, exact).distance.lower;
      // The query with a threshold has already proven it.
      if (!(lower > request_.clearance))
        lower = std::max(lower, ask(pair, t, quick).distance.lower);
      least = std::min(least, lower);
      return true;
    });
    return least;
  }

  std::span<const PlacedShape> body_, obstacles_;
  const SeparationRequest& request_;
  Scratch& scratch_;
  DistanceRequest query_;
  SeparationResult result_;
  double margin_ = 0;
  double length_ = kInfinity;  // of the best translation, or the limit on lengths if there is none
  Pair blocking_;
  int queries_ = 0;
  int nodes_ = 0;
  bool invalid_ = false;
};

bool usable(std::span<const PlacedShape> shapes) {
  return std::all_of(shapes.begin(), shapes.end(), [](const PlacedShape& s) {
    return s.shape != nullptr && relativePose(s.X_WS, Pose{}).valid;
  });
}

}  // namespace

SeparationResult separation(std::span<const PlacedShape> body,
                            std::span<const PlacedShape> obstacles,
                            const SeparationRequest& request, Scratch& scratch) {
  // A NaN fails these comparisons.
  if (!(request.clearance >= 0 && request.clearance < kInfinity && request.tolerance > 0 &&
        request.longest >= 0) ||
      !usable(body) || !usable(obstacles)) {
    return {};
  }
  if (body.empty() || obstacles.empty()) {
    SeparationResult apart;
    apart.status = SeparationStatus::kApart;
    apart.clearance = kInfinity;
    return apart;
  }
  return BodyTranslationSearch(body, obstacles, request, scratch).run();
}

SeparationResult separation(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const SeparationRequest& request, Scratch& scratch) {
  const PlacedShape obstacle{&a, X_WA}, body{&b, X_WB};
  return separation({&body, 1}, {&obstacle, 1}, request, scratch);
}

}  // namespace leeway::collision
