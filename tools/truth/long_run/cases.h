#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "leeway/collision/distance.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::accuracy {

/// What kind of trouble a case is made for.
enum class Family {
  kPlain,
  kNear,        ///< gaps and depths of 1e-16 to 1e-4 of the sizes
  kParallel,    ///< axes parallel, exactly or but for 1e-17 to 1e-3 rad; faces in one plane
  kCoaxial,     ///< axes z on one line, or nearly
  kSliver,      ///< one size of 1e-6
  kFlat,        ///< one size of 0; flat hulls
  kRatio,       ///< sizes 1e3 to 1e6 apart
  kFar,         ///< 1e3 to 1e9 m from the origin
  kDuplicates,  ///< hulls with vertices that are equal or nearly so
  kDegenerate,  ///< points, segments, discs
  kDeep,        ///< centres near each other or the same
  kTwin,        ///< a shape with itself: the same pose, or turned, or moved along an axis
  kLarge,       ///< hulls of 64 to 512 vertices
  kRevolved,    ///< bodies of revolution about one axis or one middle, exactly or nearly
  kMiddle,      ///< a corner, edge or face in the middle of a round body, exactly or nearly
};
constexpr std::array<const char*, 15> kFamilyNames = {
    "plain",      "near",       "parallel", "coaxial", "sliver", "flat",     "ratio", "far",
    "duplicates", "degenerate", "deep",     "twin",    "large",  "revolved", "middle"};

struct Case {
  const collision::Shape* a = nullptr;
  const collision::Shape* b = nullptr;
  collision::Pose X_WA, X_WB;
  Family family = Family::kPlain;
};

/// Shapes of one block of cases: making them costs more than asking.
class Pool {
 public:
  explicit Pool(oracle::Random& random);
  /// A case of the given family, every pair of convex types alike (half-space with half-space
  /// apart).
  Case draw(oracle::Random& random, Family family, collision::Scratch& scratch) const;

 private:
  static constexpr std::size_t kTypes = 8, kEach = 3;
  const collision::Shape& pick(oracle::Random& random, std::size_t type,
                               oracle::Flavour flavour) const;
  const collision::Shape& pick(oracle::Random& random, std::size_t type, Family family,
                               bool second) const;
  Case drawMiddle(oracle::Random& random) const;
  void place(oracle::Random& random, Case& c) const;

  std::vector<collision::Shape> shapes_;  // by type, flavour, number
  std::array<std::vector<collision::Shape>, kTypes> degenerate_;
  std::vector<collision::Shape> large_, revolved_, round_, cornered_;
};

}  // namespace leeway::accuracy
