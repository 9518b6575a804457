#pragma once

// Every tolerance of robots/: unit, reason, and what goes wrong when it is changed.

namespace leeway::robots {

/// Added to every reach, relative to it and as metres: a walk over a hundred joints rounds by 1e-14
/// of the coordinates. Smaller would risk reaches rounded inwards; larger only loosens bounds.
inline constexpr double kReachRounding = 1e-12;

/// Relative rounding of sums of some hundred positive terms, and of halving a box (an ulp each).
inline constexpr double kBoundRounding = 1e-12;

/// provenApart(): a distance must beat the motion by this much [m]: kinematics' rounding for robots
/// of up to 1e5 m.
inline constexpr double kApartSlack = 1e-9;

/// provenApart(): boxes looked at for one pair before it is left to be checked (a few ms).
inline constexpr int kApartBoxes = 2000;

/// provenApart(): no box is split below this half width [rad or m]: pairs that come that near stay
/// checked.
inline constexpr double kApartSmallest = 1e-3;

}  // namespace leeway::robots
