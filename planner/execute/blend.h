#pragma once

// Private to planner/: geometry of corners that are cut. Differences are those of the edges before
// and after the corner, as ConfigurationSpace::difference() has them.

#include <span>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// Euclidean, of the numbers as they are.
double norm(std::span<const double> v);

/// Does the second edge go on exactly where the first one points?
bool inLine(std::span<const double> first, std::span<const double> second);

/// Are there floating joints' orientations?
bool hasRotation(const ConfigurationSpace& space);

/// The point at t in [0, 1] of the quadratic Bezier curve that cuts the corner over `length`.
void blendPoint(const ConfigurationSpace& space, std::span<const double> corner,
                std::span<const double> before, std::span<const double> after, double length,
                double t, std::span<double> result);

}  // namespace leeway::planner
