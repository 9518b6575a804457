#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "collision/base/vector.h"

namespace leeway::collision {

/// Pairs of touching triangles, stored by a descent at rest for solids that overlap although no
/// triangle of one crosses a triangle of the other, such as two bricks with flush sides, half
/// inside each other. Near touching triangles there may be a point that both solids have in common.
/// Each candidate is a place from which to search for one, in B's frame. solids/common_point.h
/// decides whether there is one.
class TouchingTriangles {
 public:
  /// Search from `point` along `way` [m].
  struct Candidate {
    Vector point, way;
    double room;  ///< the larger, the farther the solids are likely to continue along `way` [m]
  };

  /// Removes all candidates. Points no farther apart than `near` [m], a few times the rounding,
  /// count as one.
  void start(double near) {
    near_ = near;
    flush_.count = on_a_.count = on_b_.count = 0;
  }
  double near() const { return near_; }

  /// Adds the corners of a triangle of A and of one of B that touch, in B's frame,
  /// counter-clockwise from outside. O(1).
  void add(const Vector* p, const Vector* q);

  /// Candidates from inside the area that two triangles of the same plane and side share, into both
  /// solids.
  std::span<const Candidate> flush() const { return flush_.all(); }
  /// Candidates along a triangle of one body, from where it touches one of the other body to behind
  /// that. Points on the way are on the triangle to within near().
  std::span<const Candidate> onA() const { return on_a_.all(); }
  std::span<const Candidate> onB() const { return on_b_.all(); }

 private:
  /// The candidates with the most room, in descending order. A longer list finds points in contacts
  /// of more parts, and costs time if solids only touch.
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
