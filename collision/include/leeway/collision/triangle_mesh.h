#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace leeway::collision {

class MeshTree;    // private to collision/
class Shape;       // shape.h
struct BallCover;  // ball_cover.h

/// What became of a mesh's decomposition into convex pieces. Where they are used, queries that do
/// not move (distance, tolerance, depth) ask hulls of pieces first, and triangles only where a
/// piece's excess leaves the question open. Answers mean the same either way.
struct PieceSummary {
  enum class Use : unsigned char {
    kUsed,
    kOpen,       ///< no component is closed: there is no inside that pieces could fill
    kSmall,      ///< so few triangles that they are as quick
    kConcave,    ///< too many pieces for the triangles: those are as quick
    kLaborious,  ///< more work than preparation may take
    kExtreme,    ///< of a size that hierarchies in single precision do not take
    kNotAsked
  };
  Use use = Use::kSmall;
  int pieces = 0;           ///< hulls, of four triangles and more
  int loose_triangles = 0;  ///< in no piece
  double excess = 0;        ///< no hull stands out of the solid by more, proven [m]
};

/// A rigid triangle mesh. Vertices are welded by exact equality; components whose welded edges are
/// each shared by exactly two triangles of opposite direction are closed and count as solids
/// (orientation is mended so that they enclose positive volume); the others are surfaces without an
/// inside.
class TriangleMesh {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// `vertices` [m]. Throws InvalidShape for no triangles, an index out of range, or a coordinate
  /// that is not finite or exceeds 1e60 in magnitude. Triangles without area are kept (they are
  /// segments or points that can be touched). O(n log n), and up to about 0.1 s for hullExcess().
  /// With `decompose`, convex pieces are looked for, which about doubles that: see pieces(). False
  /// saves the time; answers mean the same.
  static std::shared_ptr<const TriangleMesh> make(std::span<const Eigen::Vector3d> vertices,
                                                  std::span<const Triangle> triangles,
                                                  bool decompose = true);

  std::span<const Eigen::Vector3d> vertices() const { return vertices_; }
  std::span<const Triangle> triangles() const { return triangles_; }
  int componentCount() const { return static_cast<int>(component_closed_.size()); }
  int closedComponentCount() const;
  bool isClosed(int component) const {
    return component_closed_[static_cast<std::size_t>(component)] != 0;
  }
  /// Component of triangle i.
  int component(int triangle) const {
    return triangle_component_[static_cast<std::size_t>(triangle)];
  }
  /// How far the convex hull's surface stands out from the mesh: sup over the hull's facets of the
  /// distance to the mesh, a proven upper bound [m].
  double hullExcess() const { return hull_excess_; }
  /// Counts and excess are 0 where pieces are not used.
  const PieceSummary& pieces() const { return pieces_; }
  const MeshTree& tree() const { return *tree_; }  ///< for the engine's own queries
  std::size_t bytes() const;                       ///< of memory, hierarchy included

  ~TriangleMesh();

 private:
  friend std::shared_ptr<const BallCover> coverOf(const Shape&);
  TriangleMesh() = default;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> triangle_component_;
  std::vector<std::uint8_t> component_closed_;
  double hull_excess_ = 0;
  PieceSummary pieces_;
  std::unique_ptr<const MeshTree> tree_;
  // Made when first asked for.
  mutable std::once_flag cover_once_;
  mutable std::shared_ptr<const BallCover> cover_;
};

}  // namespace leeway::collision
