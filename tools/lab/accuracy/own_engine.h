#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/engine.h"

namespace leeway::tools::report {

/// Our engine behind the rivals' interface: `leeway` answers distances (with depth in overlap);
/// `leeway d > t?` answers thresholds, alternately half and 1.5 times the true distance.
std::vector<std::unique_ptr<PairEngine>> makeOwnEngines();

}  // namespace leeway::tools::report
