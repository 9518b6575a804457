#include "planner/search/limits.h"

#include <cmath>
#include <limits>

#include "planner/base/tolerances.h"

namespace leeway::planner {

Limits::Limits(double seconds, std::int64_t iterations, std::function<bool()> stop,
               Progress progress)
    : seconds_(seconds > 0 && std::isfinite(seconds) ? seconds
                                                     : std::numeric_limits<double>::infinity()),
      search_seconds_(seconds_),
      limit_(iterations > 0 ? static_cast<std::uint64_t>(iterations)
                            : std::numeric_limits<std::uint64_t>::max()),
      stop_(std::move(stop)),
      progress_(std::move(progress)) {}

double Limits::elapsed() const { return secondsSince(begin_); }

bool Limits::pastCount() const { return iterations() >= limit_; }

bool Limits::isPast(double fraction) const {
  return elapsed() > fraction * seconds_ ||
         static_cast<double>(iterations()) > fraction * static_cast<double>(limit_);
}

void Limits::reserve(double fraction) { search_seconds_ = seconds_ * (1 - fraction); }

bool Limits::iterate(std::uint64_t count) {
  if (pastCount()) return true;
  iterations_.fetch_add(count, std::memory_order_relaxed);
  const double now = elapsed();
  return isOverAt(now) || now > search_seconds_;
}

bool Limits::searchOver() {
  if (pastCount()) return true;
  const double now = elapsed();
  return isOverAt(now) || now > search_seconds_;
}

bool Limits::over() { return isOverAt(elapsed()); }

bool Limits::isOverAt(double now) {
  if (over_.load(std::memory_order_relaxed)) return true;
  bool over = now > seconds_;
  if (stop_ || progress_) {
    const std::lock_guard<std::mutex> lock(callbacks_);
    if (stop_ && stop_()) over = true;
    report(now);
  }
  if (over) over_.store(true, std::memory_order_relaxed);
  return over;
}

void Limits::enter(const char* phase) {
  if (!progress_) return;
  const std::lock_guard<std::mutex> lock(callbacks_);
  phase_ = phase;
  state_ = nullptr;
  last_report_ = elapsed();
  progress_(phase_, last_report_);
}

void Limits::describe(std::function<std::string()> state) {
  if (!progress_) return;
  const std::lock_guard<std::mutex> lock(callbacks_);
  state_ = std::move(state);
}

void Limits::report(double now) {
  if (!progress_ || now - last_report_ < kProgressPeriod) return;
  last_report_ = now;
  progress_(state_ ? phase_ + state_() : phase_, now);
}

}  // namespace leeway::planner
