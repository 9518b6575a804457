#pragma once

#include "collision/convex/round_depth/curved_cell.h"

namespace leeway::collision {

/// An ellipsoid that is nearly a ball, M its semi-axes and r the least of them: r |x| of |M x|
/// belongs to the depth, and what is left is small. Where that ball and the depth are about as
/// large, bounds of |M x| and of depth |x| by themselves would err by more than their difference.
struct NearlyBall {
  double radius = 0;               ///< r; 0: the core is none
  double sum = 0;                  ///< r and the longest semi-axis
  Vector spread = Vector::Zero();  ///< sqrt(M^2 - r^2) / M
};

/// What provesCell() says, from what is known of the corners themselves: margins[i] is x . center +
/// sum share |M x| - depth |x| of corner i, or less. In between the bound departs from that by what
/// is of second order in the cell's size, and it errs by the fourth power.
class CellBound {
 public:
  /// sizes: the largest M of the cores, or more; roundoff [m]: as CoreQuery. `balls`, of A and
  /// B: those are taken apart.
  CellBound(const CurvedCorner (&corners)[3], const double (&sizes)[2], double roundoff,
            const NearlyBall* balls = nullptr)
      : corners_(corners), sizes_(sizes), roundoff_(roundoff), balls_(balls) {}

  /// True when the bound is at least 0 in all of the cell. Once. O(1).
  bool proves(const double (&margins)[3], double depth);
  /// After proves(): about where the bound is least, and whether it seems to be below 0 there. A
  /// direction of any length.
  bool seemsBelow() const { return below_; }
  const Vector& leastDirection() const { return least_; }

 private:
  /// One v: M x of A or B, times `share`; or x, as often as balls are larger than the depth.
  struct Round {
    double share[3], along[3];
    Vector across[3];
    double r_squared;  ///< the largest of across
    double g[3];       ///< no less than |v| + along, and linear
  };
  bool split(const Vector (&v)[3], double doubt, Round& round, double (&beyond)[3]);
  bool addDepth(double depth);
  void addRound(const Vector (&v)[3], const double (&share)[3], double size, double doubt);
  void addRound(int k);
  void addBall(int k);
  bool isBall(int k) const { return balls_ != nullptr && balls_[k].radius > 0; }
  Form leastForm() const;
  Form middleForm() const;
  bool bendAt(const double (&mu)[3], double most, Form& form) const;

  const CurvedCorner (&corners_)[3];
  const double (&sizes_)[2];
  const double roundoff_;
  const NearlyBall* const balls_;
  double shorter_[3];
  double at_[3];                   // linear parts at the corners
  double between_[3] = {0, 0, 0};  // of corners i and i + 1: what products of differences take off
  Form form_;                      // all but the bends of rounds
  Round round_[3];
  int rounds_ = 0;
  bool below_ = false;
  Vector least_ = Vector::UnitX();
  double slack_ = 0, angle_ = 0, difference_ = 0;
};

}  // namespace leeway::collision
