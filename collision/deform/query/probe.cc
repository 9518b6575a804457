#include "collision/deform/query/probe.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

struct Reach {
  double low = kInfinity, high = -kInfinity;
};

// Extends `reach` by the interval of the box low .. high, placed by X_BA, along a unit vector n of
// B.
void reachAlong(const Vector3d& n, const Vector3d& low, const Vector3d& high, const Pose& X_BA,
                Reach& reach) {
  const Vector3d n_A = X_BA.rotation.transpose() * n;
  double least = n.dot(X_BA.translation), most = least;
  for (int k = 0; k < 3; ++k) {
    // 0 times infinity would be NaN.
    if (n_A[k] == 0) continue;
    least += n_A[k] * (n_A[k] > 0 ? low[k] : high[k]);
    most += n_A[k] * (n_A[k] > 0 ? high[k] : low[k]);
  }
  reach.low = std::min(reach.low, least);
  reach.high = std::max(reach.high, most);
}

// The sum of the magnitudes of finite coordinates.
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
  const bool finite = low.allFinite() && high.allFinite();
  const Vector3d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  // Half the sides of the axis-aligned box around the turned box.
  const Vector3d around = finite ? Vector3d(X_BA0.rotation.cwiseAbs() * half) : half;
  probe.turned = !finite || X_BA1 != nullptr || around.sum() > kTurnedBox * half.sum();
  for (int k = 0; k < 3; ++k) {
    const Vector3d own = X_BA0.rotation.col(k);
    Reach along, along_own;
    if (X_BA1 == nullptr && finite) {
      const double at = X_BA0.translation[k] + X_BA0.rotation.row(k).dot(middle);
      along = {at - around[k], at + around[k]};
    } else {
      reachAlong(Vector3d::Unit(k), low, high, X_BA0, along);
      if (X_BA1 != nullptr) reachAlong(Vector3d::Unit(k), low, high, *X_BA1, along);
    }
    if (X_BA1 == nullptr) {
      // Exact along the body's own axis, so that a half-space stays bounded on one side.
      const double at = own.dot(X_BA0.translation);
      along_own = {at + low[k], at + high[k]};
    } else {
      reachAlong(own, low, high, X_BA0, along_own);
      reachAlong(own, low, high, *X_BA1, along_own);
    }
    probe.low[k] = roundedDown(along.low);
    probe.high[k] = roundedUpToFloat(along.high);
    probe.axis_low[k] = roundedDown(along_own.low);
    probe.axis_high[k] = roundedUpToFloat(along_own.high);
    for (int i = 0; i < 3; ++i) probe.axis[k][i] = static_cast<float>(own[i]);
  }
  double size = extent + magnitude(low, high) + radius + X_BA0.translation.lpNorm<1>();
  if (X_BA1 != nullptr) size += X_BA1->translation.lpNorm<1>();
  probe.radius = roundedUpToFloat(radius);
  probe.slack = roundedUpToFloat(slack + kSingleRounding * size);
  return probe;
}

double lowerBound(const Probe& probe, const float* low, const float* high) {
  double squared = 0, squared_axes = 0, widest_gap = -kInfinity;
  bool turned = probe.turned;
  for (int k = 0; k < 3; ++k) {
    const double l = static_cast<double>(low[k]), h = static_cast<double>(high[k]);
    turned = turned && std::isfinite(l) && std::isfinite(h);
    const double gap =
        std::max(l - static_cast<double>(probe.high[k]), static_cast<double>(probe.low[k]) - h);
    if (!(gap >= -kInfinity)) continue;  // NaN: both are infinite
    widest_gap = std::max(widest_gap, gap);
    squared += std::max(gap, 0.0) * std::max(gap, 0.0);
  }
  if (turned) {
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
      widest_gap = std::max(widest_gap, gap);
      squared_axes += std::max(gap, 0.0) * std::max(gap, 0.0);
    }
  }
  double lower = std::sqrt(std::max(squared, squared_axes)) * (1 - kRotationTolerance);
  if (!(lower > 0)) lower = widest_gap;
  return lower - static_cast<double>(probe.radius) - static_cast<double>(probe.slack);
}

}  // namespace leeway::collision
