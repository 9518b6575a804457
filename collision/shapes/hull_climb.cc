#include "collision/shapes/hull_climb.h"

#include <algorithm>
#include <limits>

namespace leeway::collision {

namespace {

// Limit on the vertices within rounding of the climb's end that are followed. Larger plateaus (a
// large flat face perpendicular to the direction) are left to a scan.
constexpr int kPlateau = 32;

// True if no vertex next to the plateau around `best` is better. Otherwise `best` and its value
// become a better vertex, or `overflow` is set because the plateau has more than kPlateau vertices.
bool plateauHasNoWayUp(const ConvexHull& hull, const Vector* points, const Vector& direction,
                       double doubt, int& best, double& best_value, bool& overflow) {
  int members[kPlateau];
  int count = 0;
  members[count++] = best;
  for (int next = 0; next < count; ++next) {
    for (const std::int32_t j : hull.neighbours(members[next])) {
      const double value = direction.dot(points[j]);
      if (value > best_value) {
        best = j;
        best_value = value;
        return false;
      }
      if (value < best_value - doubt || std::find(members, members + count, j) != members + count) {
        continue;
      }
      if (count == kPlateau) {
        overflow = true;
        return false;
      }
      members[count++] = j;
    }
  }
  return true;
}

}  // namespace

int climbFarthest(const ConvexHull& hull, const Vector* points, int count, const Vector& direction,
                  int start, double doubt) {
  const double dx = direction.x(), dy = direction.y(), dz = direction.z();
  const auto valueOf = [=](std::int32_t i) {
    return points[i].x() * dx + points[i].y() * dy + points[i].z() * dz;
  };
  int best = start;
  double best_value = valueOf(start);
  for (;;) {
    // Terminates, because the value grows in every round and so no vertex occurs twice.
    int next = best;
    double runner_up = -std::numeric_limits<double>::infinity();
    const double here = best_value;
    for (const std::int32_t j : hull.neighbours(best)) {
      const double value = valueOf(j);
      if (value > best_value) {
        best_value = value;
        next = j;
      } else if (value > runner_up) {
        runner_up = value;
      }
    }
    if (best_value > here) {
      best = next;
      continue;
    }
    if (runner_up < best_value - doubt) return best;
    bool overflow = false;
    if (plateauHasNoWayUp(hull, points, direction, doubt, best, best_value, overflow)) return best;
    if (overflow) return scanFarthest(points, count, direction);
  }
}

}  // namespace leeway::collision
