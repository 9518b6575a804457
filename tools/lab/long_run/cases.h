#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "leeway/collision/distance.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::accuracy {

/// The difficulty for which a case is made.
enum class Family {
  kPlain,
  kNear,        ///< gaps and depths of 1e-16 to 1e-4 of the sizes
  kParallel,    ///< axes parallel, exactly or to within 1e-17 to 1e-3 rad; coplanar faces
  kCoaxial,     ///< z axes on one line, or nearly
  kSliver,      ///< one size of 1e-6
  kFlat,        ///< one size of 0; flat hulls
  kRatio,       ///< sizes 1e3 to 1e6 apart
  kFar,         ///< 1e3 to 1e9 m from the origin
  kDuplicates,  ///< hulls with equal or nearly equal vertices
  kDegenerate,  ///< points, segments, discs
  kDeep,        ///< centres close to each other or equal
  kTwin,        ///< a shape with itself: same pose, or turned, or moved along an axis
  kLarge,       ///< hulls of 64 to 512 vertices
  kRevolved,    ///< bodies of revolution with common axis or centre, exactly or nearly
  kMiddle,      ///< a corner, edge or face at the centre of a round body, exactly or nearly
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

/// Shapes shared by a block of cases, because making one costs more than a query.
class Pool {
 public:
  explicit Pool(oracle::Random& random);
  /// A case of the given family; all pairs of convex types are equally likely, except half-space
  /// with half-space.
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
