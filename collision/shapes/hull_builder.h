#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

/// The convex hull of a point set by Quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The
/// Quickhull algorithm for convex hulls", 1996) with exact predicates for visibility. The hull is
/// therefore exactly convex and contains every point without any tolerance, and no facets have to
/// be merged.
class HullBuilder {
 public:
  /// Inserts the points that are farthest from their facets. With `vertex_limit`, insertion stops
  /// at that many vertices (at least 4), and outside() lists the points that the hull does not
  /// contain. Points must be finite, and their non-zero coordinates at least kSmallestExact
  /// (tolerances.h). Usually O(n log n); O(n) memory. Deterministic.
  explicit HullBuilder(std::span<const Eigen::Vector3d> points, int vertex_limit = 0);

  /// Exact affine dimension of the set: 0 a point, 1 a segment, 2 flat, 3 solid; -1 if there are no
  /// points.
  int dimension() const { return dimension_; }
  /// Indices of the hull's vertices, ascending. For dimensions 0 to 2 these are the extreme points,
  /// with or without a limit. For dimension 3 they are the corners of facets(): unless the limit
  /// stopped insertion, all extreme points, and perhaps points within a flat face or straight edge.
  const std::vector<std::int32_t>& vertices() const { return vertices_; }
  /// Dimension 2: vertices() once around the outline. Empty otherwise.
  const std::vector<std::int32_t>& outline() const { return outline_; }
  /// Counter-clockwise from outside, as indices of points; empty unless dimension() is 3.
  const std::vector<std::array<std::int32_t, 3>>& facets() const { return facets_; }
  /// For each facet, the facet across the edge from corner k to corner k + 1.
  const std::vector<std::array<std::int32_t, 3>>& adjacent() const { return adjacent_; }
  /// Points outside a hull that was stopped by the limit; ascending.
  const std::vector<std::int32_t>& outside() const { return outside_; }
  /// For each point of outside(), a facet that it is outside of.
  const std::vector<std::int32_t>& outsideOf() const { return outside_of_; }

 private:
  struct Facet {
    std::array<std::int32_t, 3> corner;
    std::array<std::int32_t, 3> adjacent;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, rounded: selects points
    double doubt = 0;  // error bound of a height computed with `normal` [m]; infinity: unknown
    std::int32_t first = -1;     // head of the list of points outside of this facet
    std::int32_t farthest = -1;  // the farthest of them from the plane
    double height = 0;           // of that point [m]
    std::int32_t mark = 0;       // the last insertion that tested the facet's visibility
    bool visible = false;
    bool alive = true;
  };
  struct HorizonEdge {
    std::int32_t from, to, facet, side;  // facet: the one beyond, which remains; side: its edge
  };

  bool start();  // builds the first tetrahedron; false if the set is not solid
  void farthestAlongAnAxis(std::int32_t& a, std::int32_t& b);
  std::int32_t farthestFromLine(std::int32_t a, std::int32_t b) const;
  std::int32_t farthestFromPlane(std::int32_t a, std::int32_t b, std::int32_t c, int& side) const;
  void makeTetrahedron(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d);
  void buildFlat(std::int32_t a, std::int32_t b, std::int32_t c);
  void build(int vertex_limit);
  void insert(std::int32_t facet, std::int32_t point);
  void findHorizon(std::int32_t facet, std::int32_t point);
  std::int32_t removeVisible(std::int32_t point);
  void addCone(std::int32_t point);
  void reassign(std::int32_t orphans);
  void putOutside(Facet& facet, std::int32_t point, double height);
  std::int32_t addFacet(std::int32_t a, std::int32_t b, std::int32_t c);
  void assign(std::int32_t point);
  inline double heightOver(const Facet& facet, std::int32_t point) const;
  inline bool sees(std::int32_t point, const Facet& facet, double height) const;
  void finish();

  std::int32_t pointCount() const { return static_cast<std::int32_t>(points_.size()); }
  const Eigen::Vector3d& at(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }
  Facet& facet(std::int32_t i) { return work_[static_cast<std::size_t>(i)]; }

  std::span<const Eigen::Vector3d> points_;
  bool limited_ = false;
  double size_ = 0;  // upper bound on the distance of two points [m]
  int dimension_ = -1;
  std::vector<std::int32_t> vertices_;
  std::vector<std::int32_t> outline_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<std::array<std::int32_t, 3>> adjacent_;
  std::vector<std::int32_t> outside_, outside_of_;

  std::vector<Facet> work_;
  std::vector<std::int32_t> next_;     // per point: its successor in a facet's list
  std::vector<std::int32_t> visible_;  // facets that the point being inserted sees
  std::vector<HorizonEdge> horizon_;
  std::vector<std::int32_t> added_;  // facets from the horizon to that point
  std::vector<std::int32_t> free_;   // facets to reuse
  // Per point: the new facet whose horizon edge starts there.
  std::vector<std::int32_t> horizon_facet_;
};

}  // namespace leeway::collision
