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

/// The outcome of a mesh's decomposition into convex pieces. Where they are used, queries of bodies
/// at rest (distance, tolerance, depth) look at the pieces' hulls first, and at triangles only
/// where a piece's excess leaves the question open. The guarantees are the same either way.
struct PieceSummary {
  enum class Use : unsigned char {
    kUsed,
    kOpen,       ///< no component is closed: there is no inside that pieces could fill
    kSmall,      ///< so few triangles that pieces would not be faster, and not all convex solids
    kConcave,    ///< too many pieces for the number of triangles: they would not be faster
    kLaborious,  ///< finding them takes more work than allowed
    kNotAsked    ///< TriangleMesh::make() was told not to decompose
  };
  Use use = Use::kSmall;
  int pieces = 0;           ///< hulls, each of four triangles or more
  int loose_triangles = 0;  ///< in no piece
  double excess = 0;        ///< no hull stands out of the solid by more, proven [m]
};

/// How a mesh is made of its triangles.
struct MeshOptions {
  /// Also finds convex pieces, see TriangleMesh::pieces(). This about doubles the time and makes
  /// many queries faster; the guarantees do not depend on it.
  bool decompose = true;
  /// False: a surface without an inside, even where it is closed.
  bool solid = true;
  /// Where the surface is not closed, triangles are added between vertices that are this near to
  /// each other, and between edges and vertices this near to them [m]. They are part of the mesh:
  /// the mesh is larger than the one given, by points that are at most twice as far from it. 0:
  /// only triangles without area, at vertices that lie exactly on edges.
  double weld = 0;
};

/// A rigid triangle mesh. Vertices are joined where they are exactly equal. What the triangles
/// enclose is solid, whichever way they are turned: each part of the mesh whose facets close
/// without a gap, also where parts share edges or facets, or facets are given twice. Cavities count
/// as solid. All other triangles are surfaces without an inside.
class TriangleMesh {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// `vertices` [m]. Throws InvalidShape for no triangles, an index out of range, a coordinate that
  /// is not finite or exceeds 1e9 in magnitude, or vertices that differ, but by less than 1e-9 in
  /// all coordinates. Triangles without area are kept: they are segments or points that can be
  /// touched. O(n log n), and up to about 0.1 s for hullExcess().
  static std::shared_ptr<const TriangleMesh> make(std::span<const Eigen::Vector3d> vertices,
                                                  std::span<const Triangle> triangles,
                                                  const MeshOptions& options = {});

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
  /// How many edges end the surface of parts that are neither solid nor flat: of what was likely
  /// meant as a solid, whose inside no query sees. 0 with MeshOptions::solid false.
  std::size_t openEdgeCount() const { return open_edges_; }
  /// How often a crossing of triangle i counts in its component's winding number, modulo 2^61 - 1:
  /// for the engine's own use.
  std::uint64_t windingWeight(int triangle) const {
    return winding_weight_.empty() ? 1 : winding_weight_[static_cast<std::size_t>(triangle)];
  }
  /// A proven upper bound on how far the convex hull stands out from the mesh: the largest distance
  /// of a point of the hull's facets from the mesh [m].
  double hullExcess() const { return hull_excess_; }
  /// The outcome of `decompose`; counts and excess are 0 where pieces are not used.
  const PieceSummary& pieces() const { return pieces_; }
  const MeshTree& tree() const { return *tree_; }  ///< for the engine's own use
  std::size_t bytes() const;                       ///< of memory, hierarchies included

  ~TriangleMesh();

 private:
  friend std::shared_ptr<const BallCover> coverOf(const Shape&);
  friend struct MeshFile;  // private to the library
  TriangleMesh() = default;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> triangle_component_;
  std::vector<std::uint8_t> component_closed_;
  std::vector<std::uint64_t> winding_weight_;  // empty: 1 each
  std::size_t open_edges_ = 0;
  double hull_excess_ = 0;
  PieceSummary pieces_;
  std::unique_ptr<const MeshTree> tree_;
  // Made when first asked for.
  mutable std::once_flag cover_once_;
  mutable std::shared_ptr<const BallCover> cover_;
};

}  // namespace leeway::collision
