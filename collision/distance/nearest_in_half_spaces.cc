#include "collision/distance/nearest_in_half_spaces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"

namespace leeway::collision {
namespace {

struct NearestPoint {
  const PlaneHalfSpace* spaces;
  int count;
  double size = 0;  // of the largest offset [m]
  double best_squared = std::numeric_limits<double>::infinity();
  Vector point = Vector::Zero();

  /// Accepts t if it is closer and in all half-spaces.
  void offer(const Vector& t) {
    const double squared = t.squaredNorm();
    if (!(squared < best_squared)) return;
    const double doubt = kHalfSpaceDoubt * (size + std::sqrt(squared));
    for (int i = 0; i < count; ++i) {
      if (!(spaces[i].normal.dot(t) >= spaces[i].offset - doubt)) return;
    }
    best_squared = squared;
    point = t;
  }

  /// The nearest point of both planes.
  void two(const PlaneHalfSpace& a, const PlaneHalfSpace& b) {
    // t = x a + y b with a . t = a.offset, b . t = b.offset.
    const double ab = a.normal.dot(b.normal), squared_sine = 1 - ab * ab;
    if (squared_sine < kParallelPlanes * kParallelPlanes) return;
    const double x = (a.offset - ab * b.offset) / squared_sine,
                 y = (b.offset - ab * a.offset) / squared_sine;
    offer(x * a.normal + y * b.normal);
  }

  /// The common point of three planes.
  void three(const PlaneHalfSpace& a, const PlaneHalfSpace& b, const PlaneHalfSpace& c) {
    const Vector bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal),
                 ab = cross(a.normal, b.normal);
    const double volume = a.normal.dot(bc);
    if (std::abs(volume) < kParallelPlanes) return;
    offer((a.offset * bc + b.offset * ca + c.offset * ab) / volume);
  }
};

}  // namespace

bool nearestInHalfSpaces(const PlaneHalfSpace* spaces, int count, Vector& point) {
  NearestPoint search{spaces, count};
  for (int i = 0; i < count; ++i) search.size = std::max(search.size, std::abs(spaces[i].offset));
  search.offer(Vector::Zero());
  for (int i = 0; i < count; ++i) {
    search.offer(spaces[i].offset * spaces[i].normal);
    for (int j = i + 1; j < count; ++j) {
      search.two(spaces[i], spaces[j]);
      for (int k = j + 1; k < count; ++k) search.three(spaces[i], spaces[j], spaces[k]);
    }
  }
  point = search.point;
  return search.best_squared < std::numeric_limits<double>::infinity();
}

}  // namespace leeway::collision
