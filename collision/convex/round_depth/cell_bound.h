#pragma once

#include "collision/convex/round_depth/curved_cell.h"

namespace leeway::collision {

/// An ellipsoid that is nearly a ball, with semi-axes M and r the least of them. r |x| of |M x| is
/// subtracted from the depth, and the rest is small. If ball and depth are about equal, separate
/// bounds of |M x| and depth |x| would err by more than their difference.
struct NearlyBall {
  double radius = 0;               ///< r; 0: no such core
  double sum = 0;                  ///< r and the longest semi-axis
  Vector spread = Vector::Zero();  ///< sqrt(M^2 - r^2) / M
};

/// provesCell() with a bound that errs by the fourth power of the cell's size. It interpolates the
/// exact margins of the corners and bounds only the second-order part in between. margins[i] is at
/// most x . center + sum share |M x| - depth |x| of corner i.
class CellBound {
 public:
  /// sizes: at least the largest M of each core [m]; roundoff: as in CoreQuery; balls, of A and B:
  /// cores that are treated as NearlyBall.
  CellBound(const CurvedCorner (&corners)[3], const double (&sizes)[2], double roundoff,
            const NearlyBall* balls = nullptr)
      : corners_(corners), sizes_(sizes), roundoff_(roundoff), balls_(balls) {}

  /// True if the bound is at least 0 in the whole cell. Must be called only once. O(1).
  bool proves(const double (&margins)[3], double depth);
  /// After proves(): the direction, of any length, in which the bound is approximately least, and
  /// whether it seems to be below 0 there.
  bool seemsBelow() const { return below_; }
  const Vector& leastDirection() const { return least_; }

 private:
  /// A term share |v|: v is M x of A or B, or x where balls exceed the depth.
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
  double between_[3] = {0, 0, 0};  // products of differences, of corners i and i + 1
  Form form_;                      // without the bends of round_
  Round round_[3];
  int rounds_ = 0;
  bool below_ = false;
  Vector least_ = Vector::UnitX();
  double slack_ = 0, angle_ = 0, difference_ = 0;
};

}  // namespace leeway::collision
