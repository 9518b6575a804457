#include "planner/execute/rows_proof.h"

namespace leeway::planner {

bool RowsProof::edgeFree(EdgeCertifier& certifier, std::span<const double> a,
                         std::span<const double> b, double beyond, std::int64_t most_work) {
  if (isSpent()) {
    failed_ = {};
    return false;
  }
  EdgeRequest request = EdgeRequest::persistent();
  request.work_limit = std::min(most_work > 0 ? most_work : request.work_limit, left_);
  request.beyond = beyond;
  const std::int64_t before = certifier.statistics.work;
  const EdgeCheck check = certifier.certify(a, b, request);
  // Placing the robot is not counted: it takes about a microsecond.
  left_ -= std::max<std::int64_t>(certifier.statistics.work - before, kGuardLeastWork);
  if (check.verdict == Verdict::kFree) return true;
  failed_ = check;
  return false;
}

}  // namespace leeway::planner
