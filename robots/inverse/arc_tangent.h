#pragma once

namespace leeway::robots {

/// The angle of (x, y) in [-pi, pi], within 2e-16 (1 + |angle|): the same bytes with every C
/// library. 0 for x = y = 0. O(1).
double arcTangent(double y, double x);

}  // namespace leeway::robots
