#pragma once

#include <mutex>

namespace leeway::planner {

/// OMPL seeds each of its generators, when it is made, from one generator of the whole process.
/// Hold this lock while you make an object that has such a generator: after seedOmpl() under the
/// lock a planner then gets the same seeds however many other plans are starting. Recursive,
/// because making a planner may make a sampler.
std::recursive_mutex& omplSeedLock();

/// Silences OMPL's console while at least one exists; the last one puts the old output handler
/// back.
class QuietOmpl {
 public:
  QuietOmpl();
  ~QuietOmpl();
  QuietOmpl(const QuietOmpl&) = delete;
  QuietOmpl& operator=(const QuietOmpl&) = delete;
};

}  // namespace leeway::planner
