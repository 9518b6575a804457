#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/report/base/engine.h"

namespace leeway::tools::report {

enum class FamilyKind : unsigned char {
  kOrdinary,  ///< apart, by 1 to 100 % of the sizes
  kOverlap,   ///< overlapping, depth asked
  kHard,      ///< what engines are known to get wrong
  kCoherent,  ///< slow motion, each query warmed by the one before
};
const char* toString(FamilyKind kind);

/// A pair with its truth, from quadruple precision: lower <= signed distance <= upper.
struct AccuracyCase {
  PairSpec spec;
  double truth_lower = 0, truth_upper = 0;  ///< [m]
  double extent = 0;      ///< largest coordinate at play [m]: 1e-16 of it is the input's rounding
  bool has_value = true;  ///< false: only the sign of spec.distance is known
  int track = 0;          ///< coherent families: cases of one track follow one another
};

struct AccuracyFamily {
  std::string name;
  FamilyKind kind = FamilyKind::kOrdinary;
  std::vector<AccuracyCase> cases;
};

/// Families and the shapes they point to.
struct AccuracySet {
  std::vector<std::unique_ptr<ReportShape>> shapes;
  std::vector<AccuracyFamily> families;
};

/// Every family with `per_family` cases: pairs of all convex types apart, with depth, and hard
/// ones; same seed, same cases. `progress`, if set, is told each family's name before it is made.
/// A few milliseconds a case, nearly all of it for the truth.
AccuracySet makeAccuracySet(int per_family, std::uint64_t seed,
                            const std::function<void(const std::string&)>& progress = {});

/// Sum of the bounding radii of both that are finite [m]; 1 where both are points.
double sizeOfPair(const collision::Shape& a, const collision::Shape& b);

}  // namespace leeway::tools::report
