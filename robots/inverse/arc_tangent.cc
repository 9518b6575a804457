#include "robots/inverse/arc_tangent.h"

#include <cmath>
#include <numbers>

#include "collision/base/sine_cosine.h"

namespace leeway::robots {

double arcTangent(double y, double x) {
  const double ax = std::fabs(x), ay = std::fabs(y);
  const double larger = ax > ay ? ax : ay;
  if (!(larger > 0)) return 0;
  const double u = ax / larger, v = ay / larger;
  const double t = ax > ay ? v : u;  // in [0, 1]
  // Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.47: within 1e-5.
  const double t2 = t * t;
  double angle =
      t * (0.9998660 + t2 * (-0.3302995 + t2 * (0.1801410 + t2 * (-0.0851330 + t2 * 0.0208351))));
  if (!(ax > ay)) angle = std::numbers::pi / 2 - angle;
  // The direction turned back by the estimate is at asin(d) = d + d^3 / 6; the next term is 1e-26.
  double sine, cosine;
  collision::sineCosine(angle, sine, cosine);
  const double d = (v * cosine - u * sine) / std::sqrt(u * u + v * v);
  angle += d + d * d * d / 6;
  if (x < 0) angle = std::numbers::pi - angle;
  return std::signbit(y) ? -angle : angle;
}

}  // namespace leeway::robots
