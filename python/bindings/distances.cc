#include <cmath>
#include <limits>

#include "leeway/collision/separation.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/shapes.h"

namespace leeway::python {
namespace {

using collision::DistanceRequest;
using collision::DistanceResult;
using collision::DistanceStatus;
using collision::Shape;

const char* statusName(DistanceStatus status) {
  switch (status) {
    case DistanceStatus::kConverged:
      return "converged";
    case DistanceStatus::kAboveThreshold:
      return "above_threshold";
    case DistanceStatus::kNotAboveThreshold:
      return "not_above_threshold";
    case DistanceStatus::kOverlap:
      return "overlap";
    case DistanceStatus::kLimit:
      return "limit";
    case DistanceStatus::kInvalid:
      break;
  }
  return "invalid";
}

const char* statusName(collision::SeparationStatus status) {
  switch (status) {
    case collision::SeparationStatus::kApart:
      return "apart";
    case collision::SeparationStatus::kSeparated:
      return "separated";
    case collision::SeparationStatus::kNotFound:
      return "not_found";
    case collision::SeparationStatus::kInvalid:
      break;
  }
  return "invalid";
}

/// NaN where None is given: the request's own way to say "none".
double optional(const py::object& value, const char* name) {
  return value.is_none() ? std::numeric_limits<double>::quiet_NaN() : number(value, name);
}

double positiveLength(const py::object& value, const char* name) {
  const double given = optional(value, name);
  if (given <= 0)
    throw py::value_error(std::string(name) + " is " + text(given) +
                          "; a positive length is expected");
  return given;
}

DistanceResult distanceOf(const Shape& a, const py::object& X_WA, const Shape& b,
                          const py::object& X_WB, const py::object& tolerance,
                          const py::object& threshold, bool depth) {
  DistanceRequest request;
  request.tolerance = positiveLength(tolerance, "tolerance");
  request.threshold = optional(threshold, "threshold");
  request.depth = depth;
  const collision::Pose pose_a = pose(X_WA, "X_WA"), pose_b = pose(X_WB, "X_WB");
  const Shape shape_a = a, shape_b = b;
  return released([&] {
    return collision::distance(shape_a, pose_a, shape_b, pose_b, request, threadScratch());
  });
}

/// One row a pose: (n, 4, 4), (n, 7) or (n, 3).
std::vector<collision::Pose> posesOf(const py::object& value, const char* name) {
  std::vector<collision::Pose> poses;
  const py::array given = py::array::ensure(value);
  if (!given || given.ndim() < 2)
    throw py::value_error(std::string(name) +
                          " is no list of poses; (n, 4, 4), (n, 7) or (n, 3) "
                          "is expected");
  for (const py::handle row : given) poses.push_back(pose(row, name));
  return poses;
}

py::array_t<double> distancesOf(const Shape& a, const py::object& X_WA, const Shape& b,
                                const py::object& X_WB, const py::object& tolerance) {
  DistanceRequest request;
  request.tolerance = positiveLength(tolerance, "tolerance");
  const std::vector<collision::Pose> poses_a = posesOf(X_WA, "X_WA"),
                                     poses_b = posesOf(X_WB, "X_WB");
  if (poses_a.size() != poses_b.size())
    throw py::value_error("X_WA holds " + std::to_string(poses_a.size()) + " poses, X_WB " +
                          std::to_string(poses_b.size()) + "; equal numbers are expected");
  std::vector<double> intervals(2 * poses_a.size());
  const Shape shape_a = a, shape_b = b;
  Interrupt interrupt;
  released([&] {
    collision::PairCache cache;
    for (std::size_t i = 0; i < poses_a.size() && !interrupt(); ++i) {
      const collision::Interval found =
          collision::distance(shape_a, poses_a[i], shape_b, poses_b[i], request, threadScratch(),
                              &cache)
              .distance;
      intervals[2 * i] = found.lower;
      intervals[2 * i + 1] = found.upper;
    }
  });
  interrupt.rethrow();
  return array(std::move(intervals), {static_cast<py::ssize_t>(poses_a.size()), 2});
}

collision::SeparationResult separationOf(const Shape& a, const py::object& X_WA, const Shape& b,
                                         const py::object& X_WB, const py::object& clearance,
                                         const py::object& longest) {
  collision::SeparationRequest request;
  request.clearance = number(clearance, "clearance");
  if (!longest.is_none()) request.longest = number(longest, "longest");
  const collision::Pose pose_a = pose(X_WA, "X_WA"), pose_b = pose(X_WB, "X_WB");
  const Shape shape_a = a, shape_b = b;
  return released([&] {
    return collision::separation(shape_a, pose_a, shape_b, pose_b, request, threadScratch());
  });
}

void defineResults(py::module_& module) {
  py::class_<DistanceResult> result(
      module, "Distance",
      "The signed distance of two bodies: lower <= distance <= upper, rounding included. Below 0 "
      "they overlap by that depth.");
  defineConstant(
      result, "lower", [](const DistanceResult& self) { return self.distance.lower; },
      "The distance is at least this [m].");
  defineConstant(
      result, "upper", [](const DistanceResult& self) { return self.distance.upper; },
      "The distance is at most this [m].");
  defineConstant(
      result, "status", [](const DistanceResult& self) { return statusName(self.status); },
      "'converged', 'above_threshold', 'not_above_threshold', 'overlap', 'limit' or 'invalid'.");
  defineConstant(
      result, "point_a", [](const DistanceResult& self) { return array(self.point_a); },
      "Nearest point on A, or the deepest one: (3,), world [m].");
  defineConstant(
      result, "point_b", [](const DistanceResult& self) { return array(self.point_b); },
      "Nearest point on B, or the deepest one: (3,), world [m].");
  defineConstant(
      result, "normal", [](const DistanceResult& self) { return array(self.normal); },
      "Unit vector from A to B: (3,).");
  result.def("__repr__", [](const DistanceResult& self) {
    return "<leeway.Distance " + text(self.distance.lower) + " to " + text(self.distance.upper) +
           " m, " + statusName(self.status) + ">";
  });
  using collision::SeparationResult;
  py::class_<SeparationResult> separation(
      module, "Separation", "A translation of B after which it is proven to be away from A.");
  defineConstant(
      separation, "translation",
      [](const SeparationResult& self) { return array(self.translation); },
      "What moves B away: (3,), world [m]; 0 unless status is 'separated'.");
  separation.def_readonly("clearance", &SeparationResult::clearance,
                          "Proven distance after the translation [m].");
  separation.def_readonly("least", &SeparationResult::least,
                          "Proven: no shorter translation separates [m].");
  defineConstant(
      separation, "status", [](const SeparationResult& self) { return statusName(self.status); },
      "'apart' (nothing to do), 'separated', 'not_found' or 'invalid'.");
  separation.def("__repr__", [](const SeparationResult& self) {
    return std::string("<leeway.Separation, ") + statusName(self.status) + ": " +
           text(self.translation.x()) + ", " + text(self.translation.y()) + ", " +
           text(self.translation.z()) + " m>";
  });
}

}  // namespace

collision::Scratch& threadScratch() {
  static thread_local collision::Scratch scratch;
  return scratch;
}

void defineDistances(py::module_& module) {
  defineResults(module);
  define(module, "distance", "(a, X_WA, b, X_WB, *, tolerance=None, threshold=None, depth=True)",
         "The signed distance of two shapes, as a proven interval.\n\n"
         "Poses: None, a position (3,), a position and quaternion x y z qx qy qz qw (7,), or a "
         "matrix (4, 4). `tolerance` [m] is the width that is good enough, by default at most 1e-9 "
         "m. With `threshold` [m] the query ends as soon as the distance is proven above it or not "
         "above it. depth=False ends it as soon as overlap is proven.",
         distanceOf);
  define(module, "distances", "(a, X_WA, b, X_WB, *, tolerance=None)",
         "distance() of n pairs of poses in one call: (n, 2), lower and upper ends [m]. Poses are "
         "(n, 4, 4), (n, 7) or (n, 3).",
         distancesOf);
  define(module, "separation", "(a, X_WA, b, X_WB, *, clearance=0.0, longest=None)",
         "A short translation of B after which it is proven farther than `clearance` [m] from A; "
         "none longer than `longest` [m].",
         separationOf);
}

}  // namespace leeway::python
