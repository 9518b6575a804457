#include "robots/base/low_discrepancy.h"

namespace leeway::robots {

LowDiscrepancy::LowDiscrepancy(std::size_t dimensions, std::uint64_t seed) {
  double root = 1.5;
  for (int i = 0; i < 60; ++i) {
    double power = 1;
    for (std::size_t k = 0; k < dimensions; ++k) power *= root;
    const double count = static_cast<double>(dimensions + 1);
    root -= (power * root - root - 1) / (count * power - 1);
  }
  double step = 1;
  for (std::size_t k = 0; k < dimensions; ++k) {
    step /= root;
    steps_.push_back(static_cast<std::uint64_t>(step * 0x1p53) << 11U);
    shifts_.push_back(mixed(seed ^ mixed(k)));
  }
}

}  // namespace leeway::robots
