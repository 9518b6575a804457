#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/lab/motion/contact_family.h"

namespace leeway::tools::report {

/// Names of all families, in the order of the report.
const std::vector<std::string>& contactFamilies();

/// Makes `count` cases; equal arguments give equal cases. The truth follows from the construction
/// or from a slow search (motion_truth.h), which drops cases too close to touching to be decided.
/// Up to a few milliseconds for each case.
ContactFamily makeContactFamily(const std::string& name, int count, std::uint64_t seed);

}  // namespace leeway::tools::report
