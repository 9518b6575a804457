#pragma once

#include <memory>
#include <vector>

#include "tools/report/base/engine.h"

namespace leeway::tools::report {

/// Our engine behind the rivals' interface: `leeway`, distances (with depth where shapes overlap),
/// and `leeway d > t?`, thresholds of half and of one and a half times the true distance in turn.
std::vector<std::unique_ptr<PairEngine>> makeOwnEngines();

}  // namespace leeway::tools::report
