#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tools/report/base/motion_engine.h"

namespace leeway::tools::report {

/// A motion with its truth: the first contact lies in [lower, upper], or there is none.
struct ContactCase {
  ContactSpec spec;
  bool contact = false;
  double lower = 1, upper = 1;
};

/// Cases of one kind, and the shapes that they point to.
struct ContactFamily {
  std::string name;
  std::vector<std::unique_ptr<ReportShape>> shapes;
  std::vector<ContactCase> cases;
};

/// Names of all families, in the order of the report.
const std::vector<std::string>& contactFamilies();

/// `count` cases; equal arguments give equal cases. Truth follows from the construction or from a
/// slow search (motion_truth.h), which drops cases too close to touching to be decided. Up to some
/// milliseconds a case.
ContactFamily makeContactFamily(const std::string& name, int count, std::uint64_t seed);

}  // namespace leeway::tools::report
