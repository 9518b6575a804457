#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace leeway::planner {

/// When a plan must end: a deadline, a count of planner iterations, a caller who has had enough. An
/// iteration is one look of the planner at its termination condition, which every OMPL planner
/// takes once in its main loop. Thread-safe.
class Limits {
 public:
  using Progress = std::function<void(const std::string& phase, double elapsed_s)>;

  /// `seconds` from now; infinite when not positive or not finite. `iterations` 0: none.
  Limits(double seconds, std::int64_t iterations, std::function<bool()> stop, Progress progress);

  /// Counts one iteration; true when the search must end. Once true it stays so.
  bool iterate();
  /// True when the search must end; counts nothing.
  bool searchOver();
  /// True when everything must end: the deadline or the caller, not the count.
  bool over();
  /// The search ends that fraction of the time limit before the deadline, to leave time for what
  /// follows.
  void reserve(double fraction);
  /// Names what is being done; told to the caller at once and from then on now and again.
  void enter(const char* phase);

  std::uint64_t iterations() const { return iterations_.load(std::memory_order_relaxed); }
  double elapsed() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool pastCount() const;
  void report(double now);

  Clock::time_point begin_ = Clock::now();
  double seconds_;
  double search_seconds_;
  std::uint64_t limit_;
  std::function<bool()> stop_;
  Progress progress_;
  std::atomic<std::uint64_t> iterations_{0};
  std::atomic<bool> over_{false};
  std::mutex callbacks_;  ///< the caller's functions are never called by two threads at once
  const char* phase_ = "";
  double last_report_ = 0;
};

}  // namespace leeway::planner
