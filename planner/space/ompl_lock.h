#pragma once

#include <mutex>

namespace leeway::planner {

/// OMPL seeds each of its generators, at its construction, from one generator of the process. Hold
/// this lock while you make an object with such a generator. After seedOmpl() under the lock, a
/// planner then gets the same seeds even if other plans start. Recursive, because making a planner
/// may make a sampler.
std::recursive_mutex& omplSeedLock();

/// Silences OMPL's console while at least one exists; the last one restores the previous output
/// handler.
class QuietOmpl {
 public:
  QuietOmpl();
  ~QuietOmpl();
  QuietOmpl(const QuietOmpl&) = delete;
  QuietOmpl& operator=(const QuietOmpl&) = delete;
};

}  // namespace leeway::planner
