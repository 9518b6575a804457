#pragma once

#include "collision/base/targets.h"
//
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>
#include <cstring>

namespace leeway {

/// Calls run(name) once for each instruction set that this machine has and this compiler supports,
/// with run-time dispatch forced to it. Returns their number, at least 1. Not thread-safe.
template <class Run>
int onEveryTarget(const Run& run) {
  int count = 0;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();  // dispatch is otherwise chosen once
    run(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(0);
    ++count;
  }
  hwy::GetChosenTarget().DeInit();
  return count;
}

/// Expects run(), which returns a vector of numbers, to give the same bytes with each of them.
template <class Run>
void expectTheSameBytesOnEveryTarget(const Run& run) {
  const auto best = run();
  EXPECT_GE(onEveryTarget([&](const char* target) {
              const auto other = run();
              ASSERT_EQ(best.size(), other.size()) << target;
              EXPECT_EQ(std::memcmp(best.data(), other.data(), best.size() * sizeof(best[0])), 0)
                  << target;
            }),
            1);
}

}  // namespace leeway
