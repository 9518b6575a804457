#include "planner/guard/polynomials.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

/// k (k - 1) ... (k - order + 1): what t^k is multiplied by in its derivative.
double falling(std::size_t k, int order) {
  double product = 1;
  for (int i = 0; i < order; ++i) product *= static_cast<double>(k) - i;
  return product;
}

}  // namespace

void Polynomials::set(std::span<const double> coefficients) {
  terms_ = coefficients.size() / size_;
  std::copy(coefficients.begin(), coefficients.end(), coefficients_.begin());
}

double Polynomials::at(std::size_t variable, int order, double t) const {
  const std::span<const double> c = of(variable);
  double sum = 0;
  for (std::size_t k = terms_; k-- > static_cast<std::size_t>(order);)
    sum = sum * t + c[k] * falling(k, order);
  return sum;
}

double Polynomials::rounding(std::size_t variable, int order, double t) const {
  const std::span<const double> c = of(variable);
  double sum = 0;
  for (std::size_t k = terms_; k-- > static_cast<std::size_t>(order);)
    sum = sum * t + std::abs(c[k]) * falling(k, order);
  return 4 * static_cast<double>(terms_) * std::numeric_limits<double>::epsilon() * sum;
}

/// By the derivatives in the middle (Taylor's series, which ends).
Polynomials::Enclosure Polynomials::enclose(std::size_t variable, int order, double from,
                                            double to) const {
  const double middle = from + (to - from) / 2, radius = std::max(to - middle, middle - from);
  double spread = 0, power = 1;
  for (int n = order + 1; n < static_cast<int>(terms_); ++n) {
    power *= radius / (n - order);
    spread += std::abs(at(variable, n, middle)) * power;
  }
  return {at(variable, order, middle), spread};
}

double Polynomials::most(std::size_t variable, int order, double from, double to) const {
  const Enclosure all = enclose(variable, order, from, to);
  return (std::abs(all.middle) + all.spread) * (1 + kGuardChordShare) +
         rounding(variable, order, to);
}

double Polynomials::keepsUntil(const Range& range, double from, double to, int& steps) const {
  const Enclosure all = enclose(range.variable, range.order, from, to);
  if (all.middle + all.spread <= range.high && all.middle - all.spread >= range.low) return to;
  const double middle = from + (to - from) / 2;
  if (--steps <= 0 || !(middle > from && middle < to)) return from;
  const double reached = keepsUntil(range, from, middle, steps);
  return reached < middle ? reached : keepsUntil(range, middle, to, steps);
}

}  // namespace leeway::planner
