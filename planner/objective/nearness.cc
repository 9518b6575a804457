#include "planner/objective/nearness.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"

namespace leeway::planner {

double nearnessAt(const Nearness& nearness, double d) {
  if (!(d > 0)) return 1;
  if (nearness.kind == Nearness::Kind::kHinge) return std::max(0.0, 1 - d / nearness.distance);
  return std::min(1.0, nearness.distance / d);
}

double reachOf(const Nearness& nearness) {
  return nearness.kind == Nearness::Kind::kHinge ? nearness.distance : kInfinity;
}

// Both kinds are 1 up to some distance, and convex beyond it. Over a line that begins and ends
// beyond it, the mean is between the value in the middle and the mean of the values at the ends. A
// hinge is linear until it becomes 0. A line that crosses such a distance is cut there.
Interval meanNearness(const Nearness& nearness, double begin, double end) {
  double low = std::min(begin, end), high = std::max(begin, end);
  if (std::isnan(begin) || std::isnan(end)) return {0, 1};
  const bool is_hinge = nearness.kind == Nearness::Kind::kHinge;
  const double top = is_hinge ? 0 : nearness.distance;  // 1 up to there
  if (high <= top) return {1, 1};
  if (!std::isfinite(low) || !std::isfinite(high))
    return {nearnessAt(nearness, high), nearnessAt(nearness, low)};
  const double reach = reachOf(nearness);
  if (low >= reach) return {0, 0};
  // Shares of the stretch that are cut off below and above.
  const double below = low < top ? (top - low) / (high - low) : 0;
  const double above = high > reach ? (high - reach) / (high - low) : 0;
  low = std::max(low, top);
  high = std::min(high, reach);
  const double ends = (nearnessAt(nearness, low) + nearnessAt(nearness, high)) / 2;
  const double middle = is_hinge ? ends : nearnessAt(nearness, (low + high) / 2);
  const double between = std::max(0.0, 1 - below - above);
  return {below + between * std::min(middle, ends), below + between * std::max(middle, ends)};
}

}  // namespace leeway::planner
