#pragma once

#include <cstdint>

#include "collision/convex/gjk/support.h"
#include "collision/convex/round_depth/curved_cell.h"

namespace leeway::collision {

/// Cells that a query may test for each step of its limit, and the cost of one cell [count, units
/// of Work].
inline constexpr int kFacetCellsPerStep = 3;
inline constexpr std::int64_t kFacetCellWork = 120;

/// Proves that the curved surface of a difference over a facet of a polytope is farther out than
/// the facet. A triangle of three members lies inside a curved surface. Where the surface is about
/// as curved as a ball around the origin, a polytope needs ever more facets for smaller tolerances.
/// But the members between the three are also known.
///
/// Each vertex w_i is split into the centre C_i of the ellipsoid that it lies on (for cylinders and
/// cones, of the rim's disc), and the rest. In all directions x = sum mu_i w_i of the triangle's
/// cone, with mu_i >= 0 and the sum 1, the support function h of the difference is at least that of
/// a convex combination of its members:
///
///   h(x) >= x . sum mu_i C_i + sum over A and B of (sum mu_i s_i) |M x|
///
/// Here M are the semi-axes in their directions, and s_i is 1 if a vertex lies on such an
/// ellipsoid, 0 if it is a separate point (a cone's apex, a box's corner). If the right side is at
/// least `depth` |x| in the cones of all facets that are closer than `depth`, the difference
/// contains a ball of that radius around the origin, because a ray from the origin meets a facet,
/// which is farther out or one of these.
///
/// Branch and bound over directions. A cell is proven by a quadratic form below the right side,
/// which is nonnegative if its matrix is copositive (K. P. Hadeler, "On copositive matrices",
/// 1983).
class CurvedFacets {
 public:
  /// roundoff: as in CoreQuery.
  CurvedFacets(const Difference<false>& difference, double roundoff, int iteration_limit);

  /// Whether some part of the difference is curved. If not, no facet is ever covered.
  bool any() const { return curved_; }

  /// True if the support of the difference is proven, rounding included, to be at least `depth` > 0
  /// in all directions of the cone of the three points, which must be members of the difference by
  /// their indices. O(1): at most a few hundred cells for one facet, and kFacetCellsPerStep for
  /// each step of the limit for all facets together.
  bool covers(const SupportPoint& w0, const SupportPoint& w1, const SupportPoint& w2, double depth);

  /// Cells that covers() has tested.
  int cells() const { return most_cells_ - cells_left_; }

  /// After covers(): the direction, of any length, with the least bound evaluated.
  const Vector& leastDirection() const { return least_direction_; }

  /// The member that determines the bound in the direction sum weights[i] w_i, where the weights
  /// sum to 1: a point of B minus one of A, and that of A.
  void member(const SupportPoint* const w[3], const double weights[3], Vector& of_difference,
              Vector& of_a) const;

 private:
  /// One core: semi-axes in its own frame, whose axes are the columns of R.
  struct Part {
    const ConvexView* view = nullptr;
    Vector semi_axes = Vector::Zero();
    bool curved = false;
  };
  struct Cell {
    CurvedCorner corner[3];
    int depth;  ///< halvings
  };
  /// The centre of the ellipsoid or rim that a point of a core lies on, in the core's frame; false
  /// for a vertex.
  bool centerOf(int part, int piece, Vector& center) const;
  Vector centerOfA(const SupportPoint& s) const;
  CurvedCorner cornerOf(const SupportPoint& s) const;
  void shareOf(const SupportPoint& s, double share[2]) const;
  bool holdsAt(const CurvedCorner& c, double depth);

  const Difference<false>& difference_;
  Part part_[2];
  bool curved_ = false;
  const int most_cells_;
  int cells_left_ = 0;
  double slack_ = 0;  // rounding of a bound [m^2]
  Vector least_direction_ = Vector::UnitX();
  double least_value_ = 0;
};

}  // namespace leeway::collision
