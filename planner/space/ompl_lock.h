#pragma once

#include <mutex>

namespace leeway::planner {

/// OMPL seeds each of its generators from one generator of the whole process, at birth. Whoever
/// makes an object that holds such a generator does it under this lock: a planner seeded under it
/// then gets the same seeds however many other plans are starting. Recursive, because making a
/// planner may make a sampler.
std::recursive_mutex& omplSeedLock();

/// Silences OMPL's console as long as one of them lives, then puts back the output handler that was
/// there.
class QuietOmpl {
 public:
  QuietOmpl();
  ~QuietOmpl();
  QuietOmpl(const QuietOmpl&) = delete;
  QuietOmpl& operator=(const QuietOmpl&) = delete;
};

}  // namespace leeway::planner
