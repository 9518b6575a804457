#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "collision/base/vector.h"

namespace leeway::collision {

/// Pairs of triangles that touch, kept by a descent at rest for solids that overlap though no
/// triangle of one crosses a triangle of the other: two bricks with flush sides, half inside each
/// other. Where triangles touch, a point that both solids have in common is near: each candidate is
/// a place from which to look for one, in B's frame. Whether there is one, solids/common_point.h
/// decides.
class TouchingTriangles {
 public:
  /// Looks from `point` along `way` [m].
  struct Candidate {
    Vector point, way;
    double room;  ///< the more, the farther the solids are likely to go on along `way` [m]
  };

  /// Forgets all. Points no farther apart than `near` [m], a few times the rounding, count as one.
  void start(double near) {
    near_ = near;
    flush_.count = on_a_.count = on_b_.count = 0;
  }
  double near() const { return near_; }

  /// Pairs whose distance is above this [m] need no closer look, where the least distance known is
  /// `upper` > 0. All pairs that touch need one, whatever the tolerance: they show whether the
  /// bodies overlap.
  double bar(double upper, double tolerance) const {
    return upper <= near_ ? near_ : upper - tolerance;
  }

  /// Corners of a triangle of A and of one of B that touch, in B's frame; outer sides see them
  /// counter-clockwise. O(1).
  void add(const Vector* p, const Vector* q);

  /// From inside the area that two triangles of the same plane and side share, into both solids.
  std::span<const Candidate> flush() const { return flush_.all(); }
  /// Along a triangle of one body, from where it touches one of the other to behind that. Points on
  /// the way are on the triangle to within near().
  std::span<const Candidate> onA() const { return on_a_.all(); }
  std::span<const Candidate> onB() const { return on_b_.all(); }

 private:
  /// Those with the most room, in falling order. More of them find points in contacts of more
  /// parts, and cost time where solids only touch.
  struct List {
    static constexpr std::size_t kMost = 8;
    std::array<Candidate, kMost> kept;
    std::size_t count = 0;

    std::span<const Candidate> all() const { return {kept.data(), count}; }
    void offer(const Candidate& candidate);
  };

  double near_ = 0;
  List flush_, on_a_, on_b_;
};

}  // namespace leeway::collision
