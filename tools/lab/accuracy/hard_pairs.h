#pragma once

#include <span>

#include "tools/lab/accuracy/random_pairs.h"

namespace leeway::tools::report {

/// Placed pairs of a kind that troubles engines.
struct HardFamily {
  const char* name;
  random_pairs::Placed (*make)(oracle::Random&);
};

std::span<const HardFamily> hardFamilies();

}  // namespace leeway::tools::report
