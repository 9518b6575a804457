#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/lab/base/engine.h"

namespace leeway::tools::report {

enum class FamilyKind : unsigned char {
  kOrdinary,  ///< apart, by 1 to 100 % of the sizes
  kOverlap,   ///< overlapping, with a depth requested
  kHard,      ///< known to trouble engines
  kCoherent,  ///< slow motion, each query warm-started from the previous one
};
const char* toString(FamilyKind kind);

/// A pair and its truth in quadruple precision: lower <= signed distance <= upper.
struct AccuracyCase {
  PairSpec spec;
  double truth_lower = 0, truth_upper = 0;  ///< [m]
  double extent = 0;      ///< largest coordinate [m]; the input is rounded to 1e-16 of it
  bool has_value = true;  ///< false: only the sign of spec.distance is known
  int track = 0;          ///< coherent families: cases of one track are consecutive
};

struct AccuracyFamily {
  std::string name;
  FamilyKind kind = FamilyKind::kOrdinary;
  std::vector<AccuracyCase> cases;
};

/// Families, and the shapes of their cases.
struct AccuracySet {
  std::vector<std::unique_ptr<ReportShape>> shapes;
  std::vector<AccuracyFamily> families;
};

/// Makes `per_family` cases for every family: all pairs of convex types apart, overlaps with depth,
/// hard and coherent ones. Equal seeds give equal cases. `progress`, if set, receives each family's
/// name before it is made. A few milliseconds for each case, nearly all of it for the truth.
AccuracySet makeAccuracySet(int per_family, std::uint64_t seed,
                            const std::function<void(const std::string&)>& progress = {});

}  // namespace leeway::tools::report
