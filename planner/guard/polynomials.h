#pragma once

// Private to planner/: the motion of variables as polynomials of time.

#include <span>
#include <vector>

namespace leeway::planner {

/// One polynomial a variable, with as many coefficients for each. Allocates in the constructor
/// only.
class Polynomials {
 public:
  /// `most`: coefficients of one polynomial that there is room for [count].
  Polynomials(std::size_t variables, std::size_t most)
      : size_(variables), coefficients_(variables * most) {}

  /// Takes the coefficients of 1, t, t^2, ... of the first variable, then of the next ones.
  void set(std::span<const double> coefficients);

  /// The derivative of this order of a variable at t; 0 is its value. O(terms).
  double at(std::size_t variable, int order, double t) const;
  /// How far that may be from the exact value, by rounding, for times in [0, t].
  double rounding(std::size_t variable, int order, double t) const;
  /// The most that the derivative's size is in [from, to]; not below it. O(terms).
  double most(std::size_t variable, int order, double from, double to) const;

  /// A range that a derivative must keep.
  struct Range {
    std::size_t variable;
    int order;
    double low, high;
  };
  /// The last time in [from, to] up to which the derivative is proven to be in the range, by up to
  /// `steps` bounds; `from` where it is not in it there. Subtracts the bounds from `steps`.
  double keepsUntil(const Range& range, double from, double to, int& steps) const;

 private:
  struct Enclosure {
    double middle, spread;
  };
  Enclosure enclose(std::size_t variable, int order, double from, double to) const;
  std::span<const double> of(std::size_t variable) const {
    return std::span<const double>(coefficients_).subspan(variable * terms_, terms_);
  }

  std::size_t size_, terms_ = 0;
  std::vector<double> coefficients_;
};

}  // namespace leeway::planner
