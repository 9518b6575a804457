#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/lab/base/motion_engine.h"

namespace leeway::tools::report {

/// A motion with its truth: the first contact lies in [lower, upper], or there is none.
struct ContactCase {
  ContactSpec spec;
  bool contact = false;
  double lower = 1, upper = 1;
};

/// Cases of one kind, and their shapes.
struct ContactFamily {
  std::string name;
  std::vector<std::unique_ptr<ReportShape>> shapes;
  std::vector<ContactCase> cases;
};

}  // namespace leeway::tools::report
