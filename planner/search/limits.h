#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "planner/base/clock.h"

namespace leeway::planner {

/// The end of a plan: a deadline, a count of iterations, or the caller's stop. An iteration is one
/// call of the planner's termination condition, which every OMPL planner makes once in its main
/// loop. Thread-safe.
class Limits {
 public:
  using Progress = std::function<void(const std::string& phase, double elapsed_s)>;

  /// `seconds` from now; infinite if not positive or not finite. `iterations` 0: no limit.
  Limits(double seconds, std::int64_t iterations, std::function<bool()> stop, Progress progress);

  /// Counts iterations; true if the search must end. Once true, it stays true.
  bool iterate(std::uint64_t count = 1);
  /// The remaining iterations.
  std::uint64_t left() const { return pastCount() ? 0 : limit_ - iterations(); }
  /// True if the search must end; counts nothing.
  bool searchOver();
  /// True if everything must end: by the deadline or the caller, not by the count.
  bool over();
  /// True if more than this fraction of the time or of the iterations is used.
  bool isPast(double fraction) const;
  /// Makes the search end before the deadline, by this fraction of the time limit.
  void reserve(double fraction);
  /// Sets the phase, which is reported to the caller immediately, and then every kProgressPeriod.
  void enter(const char* phase);
  /// A text that reports append to the phase. It may be called until the next describe() or
  /// enter(), by any thread that checks the limits.
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
  std::mutex callbacks_;  ///< held during calls of the caller's functions
  std::string phase_;
  std::function<std::string()> state_;
  double last_report_ = 0;
};

}  // namespace leeway::planner
