#include "collision/deform_probe.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/collision/tolerances.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The reach of the box low .. high, placed by X_BA, along a unit vector of B.
struct Reach {
  double low = kInfinity, high = -kInfinity;
};

void reachAlong(const Vector3d& n, const Vector3d& low, const Vector3d& high, const Pose& X_BA,
                Reach& reach) {
  const Vector3d n_A = X_BA.rotation.transpose() * n;
  double least = n.dot(X_BA.translation), most = least;
  for (int k = 0; k < 3; ++k) {
    // 0 times infinity is no number: what does not count along n must not be multiplied.
    if (n_A[k] == 0) continue;
    least += n_A[k] * (n_A[k] > 0 ? low[k] : high[k]);
    most += n_A[k] * (n_A[k] > 0 ? high[k] : low[k]);
  }
  reach.low = std::min(reach.low, least);
  reach.high = std::max(reach.high, most);
}

float below(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f
                                     : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float above(double x) { return -below(-x); }

double magnitude(const Vector3d& low, const Vector3d& high) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    if (std::isfinite(low[k])) sum += std::abs(low[k]);
    if (std::isfinite(high[k])) sum += std::abs(high[k]);
  }
  return sum;
}

}  // namespace

Probe makeProbe(const Vector3d& low, const Vector3d& high, double radius, const Pose& X_BA0,
                const Pose* X_BA1, double extent, double slack) {
  Probe probe{};
  for (int k = 0; k < 3; ++k) {
    for (int own = 0; own < 2; ++own) {
      // Along the axis of the infinite box exactly, so that a half-space stays bounded.
      const Vector3d n = own == 0 ? Vector3d(Vector3d::Unit(k)) : Vector3d(X_BA0.rotation.col(k));
      Reach reach;
      if (own == 1 && X_BA1 == nullptr) {
        const double at = n.dot(X_BA0.translation);
        reach = {at + low[k], at + high[k]};
      } else {
        reachAlong(n, low, high, X_BA0, reach);
        if (X_BA1 != nullptr) reachAlong(n, low, high, *X_BA1, reach);
      }
      (own == 0 ? probe.low : probe.axis_low)[k] = below(reach.low);
      (own == 0 ? probe.high : probe.axis_high)[k] = above(reach.high);
      if (own == 1) {
        for (int i = 0; i < 3; ++i) probe.axis[k][i] = static_cast<float>(n[i]);
      }
    }
  }
  double size = extent + magnitude(low, high) + radius + X_BA0.translation.lpNorm<1>();
  if (X_BA1 != nullptr) size += X_BA1->translation.lpNorm<1>();
  probe.radius = above(radius);
  probe.slack = above(slack + kSingleRounding * size);
  return probe;
}

double lowerBound(const Probe& probe, const float* low, const float* high) {
  double squared = 0, squared_axes = 0, deepest = -kInfinity;
  bool finite = true;
  for (int k = 0; k < 3; ++k) {
    const double l = static_cast<double>(low[k]), h = static_cast<double>(high[k]);
    finite = finite && std::isfinite(l) && std::isfinite(h);
    const double gap =
        std::max(l - static_cast<double>(probe.high[k]), static_cast<double>(probe.low[k]) - h);
    if (!(gap >= -kInfinity)) continue;  // both infinite: nothing is known along this axis
    deepest = std::max(deepest, gap);
    squared += std::max(gap, 0.0) * std::max(gap, 0.0);
  }
  if (finite) {
    const auto along = [&](const float* n, double& center, double& reach) {
      center = reach = 0;
      for (int k = 0; k < 3; ++k) {
        const double l = static_cast<double>(low[k]), h = static_cast<double>(high[k]);
        center += static_cast<double>(n[k]) * (0.5 * (l + h));
        reach += std::abs(static_cast<double>(n[k])) * (0.5 * (h - l));
      }
    };
    double center = 0, reach = 0;
    for (int j = 0; j < 3; ++j) {
      along(probe.axis[j], center, reach);
      const double gap = std::max(center - static_cast<double>(probe.axis_high[j]),
                                  static_cast<double>(probe.axis_low[j]) - center) -
                         reach;
      deepest = std::max(deepest, gap);
      squared_axes += std::max(gap, 0.0) * std::max(gap, 0.0);
    }
  }
  double lower = std::sqrt(std::max(squared, squared_axes)) * (1 - 1e-6);
  if (!(lower > 0)) lower = deepest;
  return lower - static_cast<double>(probe.radius) - static_cast<double>(probe.slack);
}

}  // namespace leeway::collision
