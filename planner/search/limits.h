#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "planner/base/clock.h"

namespace leeway::planner {

/// When a plan must end: at a deadline, after a count of iterations, or when the caller says so. An
/// iteration is one call of the planner's termination condition, which every OMPL planner makes
/// once in its main loop. Thread-safe.
class Limits {
 public:
  using Progress = std::function<void(const std::string& phase, double elapsed_s)>;

  /// `seconds` from now; infinite when not positive or not finite. `iterations` 0: none.
  Limits(double seconds, std::int64_t iterations, std::function<bool()> stop, Progress progress);

  /// Counts iterations; true when the search must end. Once true it stays so.
  bool iterate(std::uint64_t count = 1);
  /// Iterations that are left.
  std::uint64_t left() const { return pastCount() ? 0 : limit_ - iterations(); }
  /// True when the search must end; counts nothing.
  bool searchOver();
  /// True when everything must end: by the deadline or the caller, not by the count.
  bool over();
  /// True when more than that fraction of the time or of the iterations is used.
  bool isPast(double fraction) const;
  /// Lets the search end that fraction of the time limit before the deadline.
  void reserve(double fraction);
  /// Names what is done from now on; reported to the caller at once, and then every
  /// kProgressPeriod.
  void enter(const char* phase);
  /// What reports say behind the phase, as long as it may be asked for: until the next describe()
  /// or enter(). Called by whichever thread asks for the limits.
  void describe(std::function<std::string()> state);

  std::uint64_t iterations() const { return iterations_.load(std::memory_order_relaxed); }
  double elapsed() const;

 private:
  bool pastCount() const;
  bool isOverAt(double now);
  void report(double now);

  Clock::time_point begin_ = Clock::now();
  double seconds_;
  double search_seconds_;
  std::uint64_t limit_;
  std::function<bool()> stop_;
  Progress progress_;
  std::atomic<std::uint64_t> iterations_{0};
  std::atomic<bool> over_{false};
  std::mutex callbacks_;  ///< held while one of the caller's functions is called
  std::string phase_;
  std::function<std::string()> state_;
  double last_report_ = 0;
};

}  // namespace leeway::planner
