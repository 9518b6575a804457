#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::tools {

/// One pair of convex shapes at given poses, as in a case file.
struct Case {
  std::int64_t id = 0;
  std::string family;
  std::string part;  ///< SUB: a part of the family; for seq-*, a track with its cases in time order
  std::size_t shape_a = 0, shape_b = 0;  ///< indices into CaseFile::shapes
  collision::Pose X_WA, X_WB;
};

struct CaseFile {
  std::vector<collision::Shape> shapes;
  std::vector<std::vector<Eigen::Vector3d>> points;  ///< of each shape: a hull's as given
  std::vector<Case> cases;
};

/// Reads the two kinds of lines, `shape ID TYPE SIZES...` and `case ID FAMILY SUB SHAPE_A SHAPE_B
/// RA(9, row major) TA(3) RB(9) TB(3)`. Skips empty lines and lines that begin with #. Throws
/// robots::InputError with file and line. O(size of the file).
CaseFile readCaseFile(const std::string& file);

/// The truth about a case in a reference file: `ID VERDICT D GAP HASVALUE L`.
struct Reference {
  int verdict = 0;         ///< 1 apart, 0 touching, -1 overlapping
  double distance = 0;     ///< signed [m]
  double gap = 0;          ///< width of its proof [m]
  bool has_value = false;  ///< false: only the verdict is known
  double extent = 0;       ///< the largest coordinate in the case [m]
};

/// References by case ID. Throws robots::InputError with file and line.
std::unordered_map<std::int64_t, Reference> readReferenceFile(const std::string& file);

}  // namespace leeway::tools
