#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

/// The convex hull of a point set by Quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The
/// Quickhull algorithm for convex hulls", 1996) with exact predicates: a facet is visible from a
/// point only when it is so exactly. The hull therefore is convex and holds every point without any
/// tolerance, and nothing has to be merged.
class HullBuilder {
 public:
  /// A point to insert is taken from the facet from which it stands out farthest. With
  /// `vertex_limit` the insertion stops at that many vertices (at least 4) and outside() names the
  /// points that the hull does not hold. Points must be finite, their non-zero coordinates not
  /// below kSmallestExact (see tolerances.h). O(n log n) as a rule; O(n) memory. Deterministic.
  explicit HullBuilder(std::span<const Eigen::Vector3d> points, int vertex_limit = 0);

  /// Affine dimension of the set, exactly: 0 a point, 1 a segment, 2 flat, 3 solid. -1 when there
  /// are no points.
  int dimension() const { return dimension_; }
  /// Indices of the hull's vertices, ascending. For dimension 0..2 these are the extreme points
  /// (without a limit on their number). For dimension 3 the corners of facets(): when the insertion
  /// was not stopped, every extreme point is among them, and perhaps points within a flat face or
  /// straight edge.
  const std::vector<std::int32_t>& vertices() const { return vertices_; }
  /// Dimension 2: vertices() once around the outline. Empty otherwise.
  const std::vector<std::int32_t>& outline() const { return outline_; }
  /// Counter-clockwise from outside, indices of points; empty unless dimension() is 3.
  const std::vector<std::array<std::int32_t, 3>>& facets() const { return facets_; }
  /// For each facet, the facet across the edge from corner k to corner k + 1.
  const std::vector<std::array<std::int32_t, 3>>& adjacent() const { return adjacent_; }
  /// Points outside of a hull that was stopped by the limit; ascending.
  const std::vector<std::int32_t>& outside() const { return outside_; }
  /// For each of outside(), a facet that it stands out of.
  const std::vector<std::int32_t>& outsideOf() const { return outside_of_; }

 private:
  struct Facet {
    std::array<std::int32_t, 3> corner;
    std::array<std::int32_t, 3> adjacent;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, rounded: chooses among points
    double doubt = 0;  // a height above the plane by `normal` errs by less [m]; infinity: unknown
    std::int32_t first = -1;     // head of the list of points outside of this facet
    std::int32_t farthest = -1;  // the one of them that is farthest from its plane
    double height = 0;           // of that one [m]
    std::int32_t mark = 0;       // insertion in which the facet was last found visible or not
    bool visible = false;
    bool alive = true;
  };
  struct HorizonEdge {
    std::int32_t from, to, facet, side;  // facet: the one that stays; side: its edge
  };

  bool start();  // the first tetrahedron; false when the set is not solid
  void buildFlat(std::int32_t a, std::int32_t b, std::int32_t c);
  void build(int vertex_limit);
  void insert(std::int32_t facet, std::int32_t point);
  std::int32_t addFacet(std::int32_t a, std::int32_t b, std::int32_t c);
  void assign(std::int32_t point, std::int32_t first_facet);
  inline double heightOver(const Facet& facet, std::int32_t point) const;
  inline bool sees(std::int32_t point, const Facet& facet, double height) const;
  void finish();

  const Eigen::Vector3d& at(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }
  Facet& facet(std::int32_t i) { return work_[static_cast<std::size_t>(i)]; }

  std::span<const Eigen::Vector3d> points_;
  bool limited_ = false;
  double size_ = 0;  // no two points are farther apart [m]
  int dimension_ = -1;
  std::vector<std::int32_t> vertices_;
  std::vector<std::int32_t> outline_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<std::array<std::int32_t, 3>> adjacent_;
  std::vector<std::int32_t> outside_, outside_of_;

  std::vector<Facet> work_;
  std::vector<std::int32_t> next_;     // list of points outside, per point
  std::vector<std::int32_t> visible_;  // facets seen by the point being inserted
  std::vector<HorizonEdge> horizon_;
  std::vector<std::int32_t> free_;  // facets to use again
  std::vector<std::int32_t>
      horizon_facet_;  // per point: the new facet whose horizon edge starts there
};

/// An upper bound on the distance of `point` from the hull built of `points` [m], rounding
/// included: 0 when it is not outside of any facet. O(facets).
double distanceFromHull(const Eigen::Vector3d& point, std::span<const Eigen::Vector3d> points,
                        const HullBuilder& hull);

/// The largest distanceFromHull() of hull.outside(); 0 for none. O(outside + facets) as a rule:
/// what is no farther from the facet that it stands out of than the largest distance met is not
/// held against the others.
double largestDistanceFromHull(std::span<const Eigen::Vector3d> points, const HullBuilder& hull);

}  // namespace leeway::collision
