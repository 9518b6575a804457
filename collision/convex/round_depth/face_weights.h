#pragma once

#include "collision/convex/round_depth/curved_face.h"

namespace leeway::collision {

// The minor cycle of Wolfe (1976), "Finding the nearest point in a polytope": the weights of a few
// members that maximise a linear gain minus half the square of their mean.

/// Coordinates of a member's offset: two across the direction, and the penalties for departing from
/// the kept parameters.
inline constexpr int kOffsets = 2 + kMostCurvedParameters;
/// Number of affinely independent members, plus the one that joins them [count].
inline constexpr int kMostMembers = kOffsets + 2;

/// A member of the face in a direction, with its gain and its offset: one vertex of a hull, one end
/// of each parameter, and all or nothing of each round part's arm.
struct FaceMember {
  int vertex = 0;
  double parameter[kMostCurvedParameters] = {};
  double arm[2] = {0, 0};
  double weight = 0, gain = 0;
  double offset[kOffsets] = {};
};

double innerProduct(const double (&v)[kOffsets], const double (&w)[kOffsets]);

/// The weighted mean of the members' offsets.
void meanOf(const FaceMember* members, int count, double (&mean)[kOffsets]);

/// Moves the weights, whose sum is 1, to the best ones, and drops members without weight. The
/// newest member is the last one.
void weigh(FaceMember* members, int& count);

}  // namespace leeway::collision
