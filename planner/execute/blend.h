#pragma once

// Private to planner/: the geometry of cut corners. `before` and `after` are the differences of the
// two edges at the corner; see ConfigurationSpace::difference().

#include <span>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// Euclidean norm.
double norm(std::span<const double> v);

/// Whether the second edge continues the first in its direction, within kInLine.
bool inLine(std::span<const double> first, std::span<const double> second);

/// Whether the space has orientations of floating joints.
bool hasRotation(const ConfigurationSpace& space);

/// The point at t in [0, 1] of the quadratic Bezier curve that cuts the corner over `length`.
void blendPoint(const ConfigurationSpace& space, std::span<const double> corner,
                std::span<const double> before, std::span<const double> after, double length,
                double t, std::span<double> result);

}  // namespace leeway::planner
